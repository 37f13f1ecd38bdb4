//! Light of suns and sky domes (contract section 5.3).

use super::tiles::{Tile, Tiles};
use super::{Directions, FEW_RAYS, FaceDirt, MANY_RAYS, StyleLight, Wanted, add};
use crate::scene::exact::{brightness, dot};
use crate::scene::{Arrival, DirtKeys, LightRays, Sample, Scene, Sun, Surface};
use glam::Vec3;

/// Faces turned away from a sun by this much, as a cosine, are still lit by it.
const BEHIND: f32 = -0.01;

/// Colour that arrives on a surface with unit normal `normal`, in light units, shadows aside.
pub(crate) fn unshadowed(sun: &Sun, normal: Vec3, two_sided: bool) -> Vec3 {
    let cosine = dot(sun.to_sun, normal);
    let cosine = if two_sided { cosine.abs() } else { cosine.max(0.0) };
    let angle = (1.0 - sun.angle_scale) + sun.angle_scale * cosine;
    sun.colour * (angle * sun.brightness / 255.0)
}

/// What arrives at a point of a sun's light of `colour`: none unless the ray towards it meets sky
/// first, and of the right texture.
pub(crate) fn seen(
    scene: &Scene,
    sun: &Sun,
    position: Vec3,
    colour: Vec3,
    rays: &mut LightRays<'_>,
) -> Option<Arrival> {
    let (sky, arrival) = rays.from_sky(position, sun.to_sun, colour)?;
    let texture = scene.surfaces[sky as usize].texture;
    sun.sky_texture.is_none_or(|t| texture == Some(t)).then_some(arrival)
}

/// Adds what one sun sends to the samples of a surface.
pub(super) fn light_surface(
    scene: &Scene,
    sun: &Sun,
    surface: &Surface,
    (samples, dirt): (&[Sample], &FaceDirt),
    (tiles, wanted): (&Tiles, &mut Wanted),
    rays: &mut LightRays<'_>,
    (styles, excess, directions): (&mut Vec<StyleLight>, &mut Vec<StyleLight>, &mut Directions),
) {
    let behind = dot(sun.to_sun, surface.normal) < BEHIND;
    if behind && !surface.curved && !surface.two_sided || surface.channel_mask & 1 == 0 {
        return;
    }
    let keys = DirtKeys::plain(sun.dirt.unwrap_or(scene.world.dirt.lights));
    for (i, sample) in samples.iter().enumerate().filter(|(_, s)| !s.occluded) {
        let colour = unshadowed(sun, sample.normal, surface.two_sided) * dirt.factor(i, &keys, 0.0);
        if brightness(colour).abs() > scene.world.gate {
            wanted.sent[i] = Some(colour);
        }
    }
    if let Some(whole) = tiles.whole() {
        trace(scene, sun, (tiles, whole), samples, wanted, rays);
    }
    for (i, arrival) in wanted.take() {
        let style = arrival.style_of(sun.style);
        directions.add(style, (i, samples.len()), sun.to_sun, arrival.colour);
        add(styles, style, samples.len(), i, arrival.colour);
        if sun.bounce_scale != 1.0 {
            let unsent = arrival.colour * (1.0 - sun.bounce_scale);
            add(excess, style, samples.len(), i, unsent);
        }
    }
}

/// Finds what arrives at the samples of a tile.
fn trace(
    scene: &Scene,
    sun: &Sun,
    (tiles, tile): (&Tiles, &Tile),
    samples: &[Sample],
    wanted: &mut Wanted,
    rays: &mut LightRays<'_>,
) {
    let members = tiles.members(tile);
    let count = wanted.rays(members);
    if count == 0 {
        return;
    }
    let one = wanted.one(members);
    let mut look = |members: &[u32], rays: &mut LightRays<'_>| {
        wanted.look(members, |i, colour| seen(scene, sun, samples[i].position, colour, rays))
    };
    if count >= FEW_RAYS && (count >= MANY_RAYS || look(one, rays)) {
        let floor = tiles.floor_along(tile, sun.to_sun);
        let narrow = rays.skywards(&tile.bounds, floor, sun.to_sun, count);
        let parts = tiles.parts(tile);
        if !narrow && count >= MANY_RAYS && !parts.is_empty() {
            for part in parts {
                trace(scene, sun, (tiles, part), samples, wanted, rays);
            }
            return;
        }
    }
    if !rays.sees_no_sky() {
        look(members, rays);
    }
    rays.anywhere();
}
