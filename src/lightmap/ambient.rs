//! Bounced light where there is no time for patches: the same everywhere, as if all surfaces stood in one
//! closed room (the ambient term of M. Cohen et al., "A progressive refinement approach to fast radiosity
//! image generation", 1988).

use crate::light::StyleLight;
use crate::photometry::Irradiance;
use crate::scene::{Sample, Scene};
use glam::Vec3;
use std::borrow::Cow;

/// Luxels from which rays tell how much light is lost.
const LUXELS: usize = 256;
/// Rays of each.
const RAYS: usize = 4;

/// Bounced light of each surface. `arriving` is direct light at its luxels as it bounces.
pub(crate) fn ambient(
    scene: &Scene,
    samples: &[Vec<Sample>],
    arriving: &[Cow<'_, [StyleLight]>],
) -> Vec<Vec<StyleLight>> {
    let mut maps: Vec<Vec<StyleLight>> = vec![Vec::new(); samples.len()];
    if scene.world.bounce.most == Some(0) {
        return maps;
    }
    let kept = kept(scene, samples);
    let (mut areas, mut albedo) = (0.0, Vec3::ZERO);
    // What is sent back of direct light, by style: area times exitance.
    let mut sent: Vec<(u16, Vec3)> = Vec::new();
    let mut send = |style: u16, light: Vec3| match sent.iter_mut().find(|s| s.0 == style) {
        Some(sum) => sum.1 += light,
        None => sent.push((style, light)),
    };
    for (face, samples) in samples.iter().enumerate() {
        let surface = &scene.surfaces[face];
        let Some(grid) = surface.luxels.as_ref().filter(|_| surface.reflects) else { continue };
        let area = grid.s_step.cross(grid.t_step).length();
        let free = samples.iter().filter(|s| !s.occluded).count() as f32 * area;
        areas += free;
        albedo += surface.reflectance.0 * free;
        for light in arriving[face].iter() {
            let sum: Vec3 = light.irradiance.iter().map(|e| e.0).sum();
            send(light.style, surface.reflectance.0 * sum * area);
        }
    }
    for emitter in &scene.emitters {
        let grid = scene.surfaces[emitter.surface as usize].luxels.as_ref();
        let area = grid.map_or(0.0, |g| g.len() as f32 * g.s_step.cross(g.t_step).length());
        send(emitter.style, emitter.exitance.0 * area);
    }
    let left = albedo / areas.max(1.0) * kept;
    // 1 + left + left^2 + ..., as many as there are bounces.
    let further = |x: f32| match scene.world.bounce.most {
        Some(n) => (1.0 - x.powf(n as f32)) / (1.0 - x),
        None => 1.0 / (1.0 - x),
    };
    let all = left.min(Vec3::splat(0.95)).to_array().map(further);
    for (face, samples) in samples.iter().enumerate() {
        if scene.surfaces[face].light_ignore {
            continue;
        }
        for &(style, light) in &sent {
            let light = light / areas.max(1.0) * kept * Vec3::from(all);
            let at = |s: &Sample| if s.occluded { Irradiance::ZERO } else { Irradiance(light) };
            maps[face].push(StyleLight { style, irradiance: samples.iter().map(at).collect() });
        }
    }
    maps
}

/// Share of the light from luxels that meets surfaces which send some back.
fn kept(scene: &Scene, samples: &[Vec<Sample>]) -> f32 {
    let free: Vec<(usize, &Sample)> = samples
        .iter()
        .enumerate()
        .flat_map(|(face, samples)| samples.iter().map(move |s| (face, s)))
        .filter(|(_, s)| !s.occluded)
        .collect();
    let (mut met, mut rays) = (0, 0);
    for (k, (face, sample)) in free.iter().step_by(free.len().div_ceil(LUXELS).max(1)).enumerate() {
        let normal = scene.surfaces[*face].normal;
        let (t, b) = normal.any_orthonormal_pair();
        for ray in 0..RAYS {
            // Steps of R2 (M. Roberts, 2018): even in any number.
            let n = (k * RAYS + ray) as f64;
            let (u, v) = ((n * 0.754_877_666).fract() as f32, (n * 0.569_840_291).fract() as f32);
            let (sin, cos) = (v * std::f32::consts::TAU).sin_cos();
            let way = (t * cos + b * sin) * u.sqrt() + normal * (1.0 - u).sqrt();
            let hit = scene.tracer.first_hit(sample.position, way, f32::MAX);
            let seen =
                hit.map(|hit| &scene.surfaces[scene.tracer_surface[hit.polygon as usize] as usize]);
            met += usize::from(seen.is_some_and(|s| s.reflects && s.normal.dot(way) < 0.0));
            rays += 1;
        }
    }
    met as f32 / rays.max(1) as f32
}
