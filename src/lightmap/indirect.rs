//! Indirect light at luxels.

use super::interpolate::Interpolator;
use crate::light::StyleLight;
use crate::patch::MapPatches;
use crate::photometry::Irradiance;
use crate::radiosity::bounce::PatchLight;
use crate::radiosity::hemicube::{DeltaFormFactors, HemicubeSize, View};
use crate::radiosity::transfers::Gatherer;
use crate::scene::{Sample, Scene, ShadowRays};
use glam::DVec3;
use rayon::prelude::*;

/// How indirect light gets from patches to luxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gather {
    /// Interpolate between the patches around a luxel; luxels that see none of them get a hemicube.
    #[default]
    Interpolate,
    /// A hemicube at every luxel.
    Luxel,
}

/// Indirect irradiance at the luxels of every surface, one map a style that reaches it, and the
/// number of hemicubes drawn. `samples` holds the luxels of each surface; `advance(n)` is told of
/// every n luxels done.
pub fn indirect(
    scene: &Scene,
    patches: &MapPatches,
    samples: &[Vec<Sample>],
    light: &[PatchLight],
    (gather, size): (Gather, HemicubeSize),
    advance: impl Fn(u64) + Sync,
) -> (Vec<Vec<StyleLight>>, u64) {
    if light.is_empty() {
        return (vec![Vec::new(); samples.len()], 0);
    }
    let delta = DeltaFormFactors::new(size);
    let interpolator = Interpolator::new(&patches.set);
    let exitance: Vec<Vec<glam::Vec3>> =
        light.iter().map(|l| l.exitance.iter().map(|m| m.0).collect()).collect();
    let faces: Vec<(Vec<StyleLight>, u64)> = (0..samples.len())
        .into_par_iter()
        .map_init(
            || {
                let gatherer = Gatherer::new(&scene.tracer, &patches.set, &delta, size);
                (gatherer, ShadowRays::new(&scene.tracer))
            },
            |(gatherer, shadows), face| {
                let receives = !scene.surfaces[face].light_ignore;
                let samples = if receives { &samples[face][..] } else { &[] };
                let mut maps: Vec<StyleLight> = light
                    .iter()
                    .map(|l| StyleLight {
                        style: l.style,
                        irradiance: vec![Irradiance::ZERO; samples.len()],
                    })
                    .collect();
                let mut hemicubes = 0;
                let near = match gather {
                    Gather::Interpolate => interpolator.candidates(samples),
                    Gather::Luxel => Vec::new(),
                };
                let mut sums: Vec<DVec3> = Vec::new();
                for (luxel, sample) in samples.iter().enumerate().filter(|(_, s)| !s.occluded) {
                    // Blended normals of curved surfaces are shorter than 1.
                    let normal = sample.normal.normalize_or(scene.surfaces[face].normal);
                    let sample = &Sample { normal, ..*sample };
                    let found = gather == Gather::Interpolate
                        && interpolator.at(shadows, sample, &near, light, &mut sums);
                    if !found {
                        let seed = (face as u64) << 32 | luxel as u64;
                        let view = View::turned(sample.position, sample.normal, seed);
                        gatherer.irradiance(&view, &exitance, &mut sums);
                        hemicubes += 1;
                    }
                    for (map, sum) in maps.iter_mut().zip(&sums) {
                        map.irradiance[luxel] = Irradiance(sum.as_vec3());
                    }
                }
                maps.retain(|m| m.irradiance.iter().any(|e| *e != Irradiance::ZERO));
                advance(samples.len() as u64);
                (maps, hemicubes)
            },
        )
        .collect();
    let hemicubes = faces.iter().map(|f| f.1).sum();
    (faces.into_iter().map(|f| f.0).collect(), hemicubes)
}
