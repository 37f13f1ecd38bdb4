//! Where the luxels of a face take their light (contract sections 2.3 to 2.6).

use super::Scene;
use super::models::ShadowClass;
use super::wander::Wanderer;
use glam::Vec3;

/// A point that receives light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// World position, one unit above the surface unless solid was in the way.
    pub position: Vec3,
    /// Normal of the surface there: of unit length on flat surfaces, a blend of unit vectors on
    /// curved ones.
    pub normal: Vec3,
    /// In solid or beyond the surface: receives no light, and is filled from its neighbours.
    pub occluded: bool,
}

/// The samples of a surface, row by row: `width * extra` columns and `height * extra` rows, or none
/// if the surface has no lightmap. `extra` is the supersampling factor, 1 for one sample a luxel.
pub fn place(scene: &Scene, surface: usize, extra: u32) -> Vec<Sample> {
    let face = &scene.surfaces[surface];
    let (Some(grid), Some(map)) = (&face.luxels, &scene.luxel_maps[surface]) else {
        return Vec::new();
    };
    let offset = face.offset;
    let wanderer = Wanderer {
        shapes: &scene.shapes,
        neighbours: &scene.neighbours,
        smoothing: (face.curved && scene.world.phong).then_some(&scene.smoothing),
        luxels: map,
        in_solid: |model, p: Vec3| in_solid(scene, model as usize, p),
    };
    let extra = extra.max(1);
    let first = -0.5 + 0.5 / extra as f32;
    let at = |i: u32| first + i as f32 / extra as f32;
    let mut samples = Vec::with_capacity(grid.len() * (extra * extra) as usize);
    for t in 0..grid.height * extra {
        for s in 0..grid.width * extra {
            let start = map.world_of(at(s), at(t)) + face.normal;
            let placed = wanderer.place(surface, start);
            samples.push(Sample {
                position: placed.position + offset,
                normal: placed.normal,
                occluded: placed.occluded,
            });
        }
    }
    samples
}

/// Whether a point in the space of a brush model lies in anything solid.
pub(crate) fn in_solid(scene: &Scene, model: usize, p: Vec3) -> bool {
    let own = &scene.models[model];
    let p = p + own.offset;
    // The own model is tested without its offset: the contract's Q9.
    scene.solid.contains(model, p)
        || own.channel_mask == 1 && scene.solid.contains(0, p)
        || scene.models.iter().enumerate().any(|(i, other)| {
            matches!(other.shadow, ShadowClass::World | ShadowClass::Shadow)
                && other.channel_mask == own.channel_mask
                && other.alpha.unwrap_or(1.0) == 1.0
                && scene.solid.contains(i, p - other.offset)
        })
}
