//! Light at the probe of a brush model, a free point that belongs to no surface (contract section
//! 6.7): each light counts as on a cube's face that it lights best.

use super::{point, radiosity, sun};
use crate::photometry::Irradiance;
use crate::scene::exact::{brightness, length, normalize};
use crate::scene::{LightRays, Scene};
use glam::Vec3;

/// How far a probe may be moved out of solid, in world units.
const NUDGE: f32 = 2.0;

/// Where the probe of a brush model is; `None` if it is inside the world.
pub(crate) fn place(scene: &Scene, model: usize) -> Option<Vec3> {
    scene.solid.freed(scene.models[model].centre, NUDGE)
}

/// Direct light at a probe: style and irradiance, negative lights included.
pub(crate) fn probe(scene: &Scene, position: Vec3) -> Vec<(u16, Irradiance)> {
    let mut rays = LightRays::new(scene, None);
    let mut styles: Vec<(u16, Irradiance)> = Vec::new();
    let mut add = |style: u16, colour: Vec3| match styles.iter_mut().find(|s| s.0 == style) {
        Some(sum) => sum.1 += Irradiance(colour),
        None => styles.push((style, Irradiance(colour))),
    };
    for light in scene.lights.iter().filter(|l| l.channel_mask == 1) {
        let towards = normalize(light.origin - position);
        let colour = point::unshadowed(light, scene.world.dist, position, towards, false);
        let colour = colour.map(|c| c * best_side(towards, light.angle_scale));
        let Some(colour) = colour.filter(|c| brightness(*c).abs() > scene.world.gate) else {
            continue;
        };
        if let Some(arrival) = rays.between(position, light.origin, light.shadow_mask, colour) {
            add(arrival.style_of(light.style), arrival.colour);
        }
    }
    for sun in &scene.suns {
        let colour = sun::unshadowed(sun, sun.to_sun, false);
        let colour = colour * best_side(sun.to_sun, sun.angle_scale);
        if brightness(colour).abs() <= scene.world.gate {
            continue;
        }
        // Whatever the texture of the sky.
        if let Some((_, arrival)) = rays.from_sky(position, sun.to_sun, colour) {
            add(arrival.style_of(sun.style), arrival.colour);
        }
    }
    for light in &scene.radiosity_lights {
        for from in &light.points {
            let settings = &scene.world.surflight;
            let colour =
                radiosity::unshadowed(light, settings, scene.world.dist, *from, position, None);
            let Some(colour) = colour else { continue };
            let way = *from - position;
            if length(way) == 0.0 {
                continue;
            }
            if let Some(arrival) = rays.between(*from, position, 1, colour) {
                add(light.style, arrival.colour * best_side(normalize(way), 1.0));
            }
        }
    }
    styles
}

/// Share of light from a unit direction that the cube's face turned most to it gets.
fn best_side(towards: Vec3, angle_scale: f32) -> f32 {
    let cosine = towards.abs().max_element();
    1.0 * (1.0 - angle_scale) + cosine * angle_scale
}
