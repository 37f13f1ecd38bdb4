//! Where the luxels of a face take their light (contract sections 2.3 to 2.6).

use super::Scene;
use super::models::{Model, ShadowClass};
use super::umbra::Bounds;
use super::wander::Wanderer;
use glam::Vec3;

/// How far around a surface solid is looked for once for all its samples, in world units.
const AROUND: f32 = 24.0;

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
    let shape = &scene.shapes[surface];
    let extra = extra.max(1);
    let first = -0.5 + 0.5 / extra as f32;
    let at = |i: u32| first + i as f32 / extra as f32;
    let wanted_at = |s: u32, t: u32| map.world_of(at(s), at(t)) + face.normal;
    let place = |s: u32, t: u32, in_solid: &dyn Fn(u32, Vec3) -> bool| {
        let wanderer = Wanderer {
            shapes: &scene.shapes,
            neighbours: &scene.neighbours,
            smoothing: (face.curved && scene.world.phong).then_some(&scene.smoothing),
            luxels: map,
            in_solid,
        };
        let placed = wanderer.place(surface, wanted_at(s, t));
        Sample {
            position: placed.position + offset,
            normal: placed.normal,
            occluded: placed.occluded,
        }
    };
    let around = Around::new(scene, surface);
    let mut free: Vec<Option<Bounds>> = vec![None; grid.width as usize];
    let mut samples = Vec::with_capacity(grid.len() * (extra * extra) as usize);
    for t in 0..grid.height * extra {
        // Samples that stay where they want to be are often all free.
        if extra > 1 && t % extra == 0 {
            for (s, free) in (0..).step_by(extra as usize).zip(&mut free) {
                let ends = [(0, 0), (0, 1), (1, 0), (1, 1)]
                    .map(|(x, y)| shape.lift(wanted_at(s + x * (extra - 1), t + y * (extra - 1))));
                *free = Bounds::around(ends.into_iter()).filter(|b| around.is_free(b));
            }
        }
        for s in 0..grid.width * extra {
            let free = &free[(s / extra) as usize];
            samples.push(place(s, t, &|model, p| {
                let spared = shape.model == Some(model) && free.is_some_and(|b| b.contains(p));
                !spared && around.in_solid(model, p)
            }));
        }
    }
    samples
}

/// What solid there is around a surface, so that not all brush models need to be asked.
struct Around<'a> {
    scene: &'a Scene,
    model: Option<u32>,
    bounds: Option<Bounds>,
    /// The brush models that reach into `bounds`, as [`solids`] has them.
    solids: Vec<(usize, Vec3)>,
}

impl<'a> Around<'a> {
    fn new(scene: &'a Scene, surface: usize) -> Self {
        let shape = &scene.shapes[surface];
        let ends = shape.vertices.iter().flat_map(|v| [*v - AROUND, *v + AROUND]);
        let mut made =
            Self { scene, model: shape.model, bounds: Bounds::around(ends), solids: Vec::new() };
        if let (Some(model), Some(bounds)) = (made.model, &made.bounds) {
            let reaches = |s: &(usize, Vec3)| !made.spares(*s, bounds);
            made.solids = solids(scene, model as usize).filter(reaches).collect();
            made.solids.dedup();
        }
        made
    }

    fn spares(&self, (solid, theirs): (usize, Vec3), bounds: &Bounds) -> bool {
        let own = self.model.map_or(Vec3::ZERO, |m| self.scene.models[m as usize].offset);
        self.scene.solid.spares(solid, &bounds.moved((own - theirs).as_dvec3()))
    }

    /// Whether surely no point of a part of the bounds is in solid.
    fn is_free(&self, part: &Bounds) -> bool {
        self.model.is_some()
            && self.bounds.is_some_and(|b| b.contains_box(part))
            && self.solids.iter().all(|s| self.spares(*s, part))
    }

    /// As [`in_solid`].
    fn in_solid(&self, model: u32, p: Vec3) -> bool {
        if self.model != Some(model) || !self.bounds.is_some_and(|b| b.contains(p)) {
            return in_solid(self.scene, model as usize, p);
        }
        let p = p + self.scene.models[model as usize].offset;
        self.solids.iter().any(|&(solid, theirs)| self.scene.solid.contains(solid, p - theirs))
    }
}

/// Whether a point in the space of a brush model lies in anything solid.
pub(crate) fn in_solid(scene: &Scene, model: usize, p: Vec3) -> bool {
    let p = p + scene.models[model].offset;
    solids(scene, model).any(|(solid, theirs)| scene.solid.contains(solid, p - theirs))
}

/// The brush models whose solid counts for points of brush model `model`, and where in the world each
/// is taken to stand.
fn solids(scene: &Scene, model: usize) -> impl Iterator<Item = (usize, Vec3)> + '_ {
    let own = &scene.models[model];
    let casts = move |other: &Model| {
        matches!(other.shadow, ShadowClass::World | ShadowClass::Shadow)
            && other.channel_mask == own.channel_mask
            && other.alpha.unwrap_or(1.0) == 1.0
    };
    let others = scene.models.iter().enumerate().filter(move |(_, other)| casts(other));
    // The own model is tested without its offset: the contract's Q9.
    std::iter::once((model, Vec3::ZERO))
        .chain((own.channel_mask == 1).then_some((0, Vec3::ZERO)))
        .chain(others.map(|(i, other)| (i, other.offset)))
}
