//! Light at a free point that belongs to no surface, as on the sides of a small cube around it
//! (contract sections 6.7 and 6.8): probes of brush models and points of the light grid.

use super::{point, radiosity, sun};
use crate::photometry::Irradiance;
use crate::scene::effects::COMPILED;
use crate::scene::exact::{brightness, length, normalize};
use crate::scene::{LightRays, Scene};
use glam::Vec3;

/// How far a probe may be moved out of solid, in world units.
const NUDGE: f32 = 2.0;

/// Where the probe for a point is; `None` if it is inside the world.
pub(crate) fn place(scene: &Scene, point: Vec3) -> Option<Vec3> {
    scene.solid.freed(point, NUDGE)
}

/// Direct light at a probe, negative lights included: style and irradiance, where each light counts as
/// on the side of the cube that it lights best.
pub(crate) fn probe(scene: &Scene, position: Vec3) -> Vec<(u16, Irradiance)> {
    let mut styles: Vec<(u16, Irradiance)> = Vec::new();
    each_light(scene, position, |light| {
        let colour = Irradiance(light.colour);
        match styles.iter_mut().find(|s| s.0 == light.style) {
            Some(sum) => sum.1 += colour,
            None => styles.push((light.style, colour)),
        }
    });
    styles
}

/// Directions of the sides of the cube, in the order of the sides.
pub(crate) const SIDES: [Vec3; 6] =
    [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

/// Direct light at a probe, negative lights included: style and irradiance on each of [`SIDES`].
pub(crate) fn probe_sides(scene: &Scene, position: Vec3) -> Vec<(u16, [Irradiance; 6])> {
    let mut styles: Vec<(u16, [Irradiance; 6])> = Vec::new();
    each_light(scene, position, |light| {
        let best = best_side(light.towards, light.angle_scale);
        let on_sides = SIDES.map(|side| {
            let cosine = side.dot(light.towards);
            let share = if cosine > 0.0 { angle(cosine, light.angle_scale) / best } else { 0.0 };
            Irradiance(light.colour * share)
        });
        match styles.iter_mut().find(|s| s.0 == light.style) {
            Some(sums) => sums.1.iter_mut().zip(on_sides).for_each(|(sum, e)| *sum += e),
            None => styles.push((light.style, on_sides)),
        }
    });
    styles
}

/// Light of one style that a probe gets from one direction.
struct Beam {
    style: u16,
    /// On the side of the cube that is lit best, in light units.
    colour: Vec3,
    /// Unit direction to where it comes from.
    towards: Vec3,
    /// Share of the cosine law, 0 to 1.
    angle_scale: f32,
}

/// Calls `add` for all light that arrives, in the order of the lights, the suns, the light surfaces.
fn each_light(scene: &Scene, position: Vec3, mut add: impl FnMut(Beam)) {
    let mut rays = LightRays::new(scene, None);
    for light in scene.lights.iter().filter(|l| l.channel_mask == 1) {
        let (towards, angle_scale) = (normalize(light.origin - position), light.angle_scale);
        let colour =
            point::unshadowed::<COMPILED>(light, scene.world.dist, position, towards, false);
        let colour = colour.map(|c| c * best_side(towards, angle_scale));
        let Some(colour) = colour.filter(|c| brightness(*c).abs() > scene.world.gate) else {
            continue;
        };
        if let Some(arrival) = rays.between(position, light.origin, light.shadow_mask, colour) {
            let style = arrival.style_of(light.style);
            add(Beam { style, colour: arrival.colour, towards, angle_scale });
        }
    }
    for sun in &scene.suns {
        let (towards, angle_scale) = (sun.to_sun, sun.angle_scale);
        let colour = sun::unshadowed(sun, towards, false);
        let colour = colour * best_side(towards, angle_scale);
        if brightness(colour).abs() <= scene.world.gate {
            continue;
        }
        // Whatever the texture of the sky.
        if let Some((_, arrival)) = rays.from_sky(position, towards, colour) {
            let style = arrival.style_of(sun.style);
            add(Beam { style, colour: arrival.colour, towards, angle_scale });
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
                let towards = normalize(way);
                let colour = arrival.colour * best_side(towards, 1.0);
                add(Beam { style: light.style, colour, towards, angle_scale: 1.0 });
            }
        }
    }
}

/// Share of light from a unit direction that the side turned most to it gets.
fn best_side(towards: Vec3, angle_scale: f32) -> f32 {
    angle(towards.abs().max_element(), angle_scale)
}

/// Share of light that a surface gets at an angle.
fn angle(cosine: f32, angle_scale: f32) -> f32 {
    1.0 * (1.0 - angle_scale) + cosine * angle_scale
}
