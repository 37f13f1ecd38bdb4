//! Light of suns and sky domes (contract section 5.3).

use super::{FaceDirt, StyleLight, add};
use crate::scene::exact::{brightness, dot};
use crate::scene::{DirtKeys, Role, Sample, Scene, ShadowRays, Sun, Surface};
use glam::Vec3;

/// Length of the rays towards suns, in world units.
const SKY_DISTANCE: f32 = 1_000_000.0;
/// Faces turned away from a sun by this much, as a cosine, are still lit by it.
const BEHIND: f32 = -0.01;

/// Colour that arrives on a surface with unit normal `normal`, in light units, shadows aside.
pub(crate) fn unshadowed(sun: &Sun, normal: Vec3, two_sided: bool) -> Vec3 {
    let cosine = dot(sun.to_sun, normal);
    let cosine = if two_sided { cosine.abs() } else { cosine.max(0.0) };
    let angle = (1.0 - sun.angle_scale) + sun.angle_scale * cosine;
    sun.colour * (angle * sun.brightness / 255.0)
}

/// Whether the ray from a point towards a sun meets sky first, and of the right texture.
pub(crate) fn is_seen(scene: &Scene, sun: &Sun, position: Vec3, rays: &mut ShadowRays<'_>) -> bool {
    rays.first_hit(position, sun.to_sun, SKY_DISTANCE).is_some_and(|hit| {
        let surface = &scene.surfaces[scene.tracer_surface[hit.polygon as usize] as usize];
        surface.role == Role::Sky
            && sun.sky_texture.is_none_or(|texture| surface.texture == Some(texture))
    })
}

/// Adds what one sun sends to the samples of a surface.
pub(crate) fn light_surface(
    scene: &Scene,
    sun: &Sun,
    surface: &Surface,
    (samples, dirt): (&[Sample], &FaceDirt),
    rays: &mut ShadowRays<'_>,
    styles: &mut Vec<StyleLight>,
) {
    let behind = dot(sun.to_sun, surface.normal) < BEHIND;
    if behind && !surface.curved && !surface.two_sided || surface.channel_mask & 1 == 0 {
        return;
    }
    let keys = DirtKeys::plain(sun.dirt.unwrap_or(scene.world.dirt.lights));
    for (i, sample) in samples.iter().enumerate().filter(|(_, s)| !s.occluded) {
        let colour = unshadowed(sun, sample.normal, surface.two_sided) * dirt.factor(i, &keys, 0.0);
        if brightness(colour).abs() > scene.world.gate && is_seen(scene, sun, sample.position, rays)
        {
            add(styles, sun.style, samples.len(), i, colour);
        }
    }
}
