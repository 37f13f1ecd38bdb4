//! How far the lights of a scene shine, and which of them shine on nothing.

use super::{BoundingSphere, attenuation};
use crate::scene::{Light, Scene, Surface, WorldSettings};
use rayon::prelude::*;

/// Lights that shine as far as this, in world units, count as endless: maps are smaller.
const FAR: f32 = 131_072.0;
/// Halvings of the way to where a light ends.
const STEPS: u32 = 32;
/// At most so many pairs of a light and a face are looked at.
const MOST: usize = 1 << 30;

/// How far lights shine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reaches {
    /// The shortest and the longest reach in world units, of those that end; `None` if none does.
    pub ends: Option<[f32; 2]>,
    /// Lights whose reach does not end.
    pub endless: usize,
    /// The lights, by their index in the scene, in whose reach no face has a point that they could
    /// shine on, whatever stands between.
    pub idle: Vec<usize>,
    /// Lights of which that is not known: there are too many.
    pub unknown: usize,
}

/// Looks at those lights of a scene that are no copies of surface lights.
pub fn reaches(scene: &Scene) -> Reaches {
    let own: Vec<usize> =
        (0..scene.lights.len()).filter(|&l| scene.lights[l].piece_radius == 0.0).collect();
    let faces: Vec<(&Surface, BoundingSphere)> = scene
        .surfaces
        .iter()
        .filter(|s| s.luxels.is_some() && !s.light_ignore)
        .map(|s| (s, BoundingSphere::of(s)))
        .collect();
    let known = (MOST / faces.len().max(1)).min(own.len());
    let is_idle = |&l: &usize| {
        let light = &scene.lights[l];
        !faces.iter().any(|(surface, sphere)| may_shine_on(&scene.world, light, surface, sphere))
    };
    let idle = own[..known].par_iter().copied().filter(is_idle).collect();
    let mut found = Reaches { idle, unknown: own.len() - known, ..Reaches::default() };
    for l in own {
        match reach(&scene.lights[l], &scene.world) {
            None => found.endless += 1,
            Some(end) => {
                let [least, most] = found.ends.unwrap_or([end; 2]);
                found.ends = Some([least.min(end), most.max(end)]);
            }
        }
    }
    found
}

/// Distance in world units from which on a light is too weak to count; `None` if there is none.
fn reach(light: &Light, world: &WorldSettings) -> Option<f32> {
    let counts = |d: f32| attenuation::value(light, world.dist, d).abs() > world.gate;
    if counts(FAR) {
        return None;
    }
    let (mut near, mut far) = (0.0, FAR);
    for _ in 0..STEPS {
        let middle = 0.5 * (near + far);
        if counts(middle) { near = middle } else { far = middle }
    }
    Some(near)
}

/// Whether a light can shine on any point of a surface, given the sphere around that; what stands between
/// is not looked at.
pub(super) fn may_shine_on(
    world: &WorldSettings,
    light: &Light,
    surface: &Surface,
    sphere: &BoundingSphere,
) -> bool {
    let behind = crate::scene::exact::distance(light.origin, surface.normal, surface.dist) < 0.0;
    let hidden = behind && !light.bleed && !surface.two_sided && !surface.curved;
    !hidden
        && !sphere.is_out_of_reach(light, world.dist, world.gate)
        && light.channel_mask & surface.channel_mask != 0
}
