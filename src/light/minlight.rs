//! Minimum light: of the whole map and of brush models, of local lights, of surfaces that give off
//! light, and automatic (contract sections 6.1, 6.2 and 6.7).

use super::StyleLight;
use super::dirt::FaceDirt;
use crate::photometry::Irradiance;
use crate::scene::effects::COMPILED;
use crate::scene::exact::brightness;
use crate::scene::{
    AutoMinlight, DirtKeys, LightRays, Minlight, Sample, Scene, Surface, WorldSettings,
};
use glam::Vec3;

/// Most that mottling adds, in light units.
const MOTTLE: f32 = 48.0;
/// Size of the cells of mottling, in world units.
const MOTTLE_CELL: f32 = 16.0;

/// Light of each style at the probe of a brush model, in levels.
pub type Probe = Vec<(u16, Vec3)>;

/// How minimum light joins other light.
#[derive(Clone, Copy)]
enum Join {
    Add,
    AtLeast,
}

impl Join {
    fn of(world: &WorldSettings) -> Self {
        if world.add_min { Self::Add } else { Self::AtLeast }
    }

    fn apply(self, light: Vec3, minimum: Vec3) -> Vec3 {
        match self {
            Self::Add => light + minimum,
            Self::AtLeast => light.max(minimum),
        }
    }
}

/// Minimum light of local lights at the samples of a surface, as far as it matters where `styles` is
/// the other direct light. It is to be joined with the sum of direct and bounced light by
/// [`join_local`].
pub(super) fn local(
    scene: &Scene,
    surface: &Surface,
    (samples, dirt): (&[Sample], &FaceDirt),
    styles: &[StyleLight],
    rays: &mut LightRays<'_>,
) -> Vec<StyleLight> {
    let mut minimum: Vec<StyleLight> = Vec::new();
    if !COMPILED || surface.minlight.exempt || scene.local_minlights.is_empty() {
        return minimum;
    }
    let join = Join::of(&scene.world);
    for light in &scene.local_minlights {
        if light.brightness.abs() <= scene.world.gate
            || light.channel_mask & surface.channel_mask == 0
        {
            continue;
        }
        let other = styles.iter().find(|s| s.style == light.style);
        for (i, sample) in samples.iter().enumerate().filter(|(_, s)| !s.occluded) {
            let had = minimum.iter().find(|s| s.style == light.style).map(|s| s.irradiance[i].0);
            if matches!(join, Join::AtLeast) {
                let lit = other.map_or(Vec3::ZERO, |o| o.irradiance[i].0);
                if brightness(join.apply(lit, had.unwrap_or(lit))) >= light.brightness {
                    continue;
                }
            }
            let mask = light.shadow_mask;
            if rays.between(sample.position, light.origin, mask, light.colour).is_none() {
                continue;
            }
            let level = light.brightness * dirt.factor(i, &light.dirt, 0.0);
            let value = join.apply(had.unwrap_or(Vec3::ZERO), light.colour * (level / 255.0));
            map_of(&mut minimum, light.style, samples.len()).irradiance[i] = Irradiance(value);
        }
    }
    minimum
}

/// Joins what [`local`] found with all other light.
pub(crate) fn join_local(world: &WorldSettings, maps: &mut Vec<StyleLight>, local: &[StyleLight]) {
    let join = Join::of(world);
    for minimum in local {
        let values: Vec<Vec3> = minimum.irradiance.iter().map(|e| e.0).collect();
        apply(maps, minimum.style, &values, join);
    }
}

/// Applies the minimum light of the map, of the surface and of its glow to all samples.
pub(crate) fn global(
    scene: &Scene,
    surface: &Surface,
    (samples, dirt): (&[Sample], &FaceDirt),
    maps: &mut Vec<StyleLight>,
) {
    let minlight: &Minlight = &surface.minlight;
    if minlight.exempt {
        return;
    }
    let join = Join::of(&scene.world);
    let keys = DirtKeys::plain(scene.world.dirt.minlight);
    let value = |i: usize, level: f32, colour: Vec3, mottled: bool| {
        let mut m = level * dirt.factor(i, &keys, 0.0);
        if mottled && matches!(join, Join::AtLeast) {
            m += mottle(samples[i].position);
        }
        colour * (m / 255.0)
    };
    if minlight.level != 0.0 {
        let values: Vec<Vec3> = (0..samples.len())
            .map(|i| value(i, minlight.level, minlight.colour, minlight.mottle))
            .collect();
        apply(maps, 0, &values, join);
    }
    if let Some(glow) = &minlight.glow {
        let values: Vec<Vec3> = (0..samples.len())
            .map(|i| value(i, glow.level, glow.colour, minlight.mottle))
            .collect();
        apply(maps, glow.style, &values, join);
    }
}

/// Gives the light at a brush model's probe to the luxels of a surface that ask for it, and tells
/// whether the surface took part: then none of its luxels counts as occluded any more.
pub(crate) fn automatic(
    surface: &Surface,
    samples: &[Sample],
    probe: Option<&Probe>,
    maps: &mut Vec<StyleLight>,
) -> bool {
    let Some(probe) = probe else { return false };
    let all = surface.minlight.auto == AutoMinlight::All;
    if !wants_probe(surface, samples) {
        return false;
    }
    for &(style, level) in probe {
        let values: Vec<Vec3> =
            samples.iter().map(|s| if all || s.occluded { level } else { Vec3::MIN }).collect();
        apply(maps, style, &values, Join::AtLeast);
    }
    true
}

/// Whether a surface takes light from the probe of its brush model.
pub(crate) fn wants_probe(surface: &Surface, samples: &[Sample]) -> bool {
    match surface.minlight.auto {
        AutoMinlight::Off => false,
        AutoMinlight::All => !samples.is_empty(),
        AutoMinlight::Occluded => samples.iter().any(|s| s.occluded),
    }
}

/// Joins one value a sample with a style. A map is made only if that changes something.
fn apply(maps: &mut Vec<StyleLight>, style: u16, values: &[Vec3], join: Join) {
    let known = maps.iter().position(|m| m.style == style);
    let at = |i: usize| known.map_or(Vec3::ZERO, |k| maps[k].irradiance[i].0);
    let joined: Vec<Irradiance> =
        values.iter().enumerate().map(|(i, v)| Irradiance(join.apply(at(i), *v))).collect();
    match known {
        Some(k) => maps[k].irradiance = joined,
        None if joined.iter().any(|e| *e != Irradiance::ZERO) => {
            maps.push(StyleLight { style, irradiance: joined });
        }
        None => {}
    }
}

fn map_of(maps: &mut Vec<StyleLight>, style: u16, samples: usize) -> &mut StyleLight {
    let known = maps.iter().position(|m| m.style == style).unwrap_or_else(|| {
        maps.push(StyleLight { style, irradiance: vec![Irradiance::ZERO; samples] });
        maps.len() - 1
    });
    &mut maps[known]
}

/// Smooth noise from 0 to [`MOTTLE`] that depends on the place in the world only: values at the
/// corners of cells, blended linearly.
pub(crate) fn mottle(p: Vec3) -> f32 {
    let cell = (p / MOTTLE_CELL).floor();
    let f = p / MOTTLE_CELL - cell;
    let mut sum = 0.0;
    for corner in 0..8_i32 {
        let step = glam::IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
        let one = |i: usize| if step[i] == 1 { f[i] } else { 1.0 - f[i] };
        let at = cell.as_ivec3().wrapping_add(step);
        sum += one(0) * one(1) * one(2) * lattice(at.to_array());
    }
    sum * MOTTLE
}

/// Value of a corner, 0 to 1: the coordinates mixed by multiplication with odd constants.
fn lattice(corner: [i32; 3]) -> f32 {
    let mut hash = 0x9E37_79B9_u32;
    for c in corner {
        hash = (hash ^ c as u32).wrapping_mul(0x85EB_CA6B);
        hash ^= hash >> 13;
    }
    (hash.wrapping_mul(0xC2B2_AE35) >> 8) as f32 / (1 << 24) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(style: u16, values: &[f32]) -> StyleLight {
        let irradiance = values.iter().map(|&v| Irradiance(Vec3::splat(v))).collect();
        StyleLight { style, irradiance }
    }

    #[test]
    fn clamping_makes_no_map_that_it_does_not_raise() {
        let mut maps = vec![map(0, &[10.0, 30.0])];
        apply(&mut maps, 0, &[Vec3::splat(20.0); 2], Join::AtLeast);
        apply(&mut maps, 3, &[Vec3::ZERO; 2], Join::AtLeast);
        assert_eq!(maps, [map(0, &[20.0, 30.0])]);
        apply(&mut maps, 3, &[Vec3::ONE, Vec3::ZERO], Join::Add);
        assert_eq!(maps[1], map(3, &[1.0, 0.0]));
    }

    #[test]
    fn mottling_is_smooth_and_within_its_range() {
        let mut last = mottle(Vec3::new(-100.0, 3.0, 7.0));
        let mut seen = [f32::MAX, f32::MIN];
        for i in 0..2000 {
            let m = mottle(Vec3::new(-100.0 + i as f32 * 0.1, 3.0, 7.0));
            assert!((0.0..=MOTTLE).contains(&m) && (m - last).abs() < 0.31, "{m} after {last}");
            seen = [seen[0].min(m), seen[1].max(m)];
            last = m;
        }
        assert!(seen[1] - seen[0] > MOTTLE / 3.0, "{seen:?}");
        assert!(mottle(Vec3::splat(1e30)).is_finite());
    }
}
