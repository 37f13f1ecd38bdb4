//! Light at the probes of brush models, for automatic minimum light.

use super::finish::{FinishSettings, scale};
use crate::light::{self, Probe};
use crate::patch::MapPatches;
use crate::photometry::Irradiance;
use crate::radiosity::bounce::PatchLight;
use crate::radiosity::hemicube::{DeltaFormFactors, HemicubeSize, View};
use crate::radiosity::transfers::Gatherer;
use crate::scene::{Model, Sample, Scene};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Styles that a probe keeps.
const MOST_STYLES: usize = 4;

/// Direct and bounced light at the probe of every brush model that has a surface which asks for it,
/// in levels: the reference scales this light to levels before it scales the luxels' light.
pub fn probes(
    scene: &Scene,
    patches: &MapPatches,
    samples: &[Vec<Sample>],
    light: &[PatchLight],
    size: HemicubeSize,
) -> Vec<Option<Probe>> {
    let places = places(scene, samples);
    let settings = FinishSettings {
        range: scene.world.range,
        gamma: scene.world.gamma,
        max_light: scene.world.max_light,
        ..FinishSettings::default()
    };
    let delta = DeltaFormFactors::new(size);
    places
        .into_par_iter()
        .map(|place| {
            let place = place?;
            let mut styles = light::probe(scene, place);
            if !light.is_empty() {
                let mut gatherer = Gatherer::new(scene.bounce_tracer(), &patches.set, &delta, size);
                bounced(&mut gatherer, place, light, &mut styles);
            }
            let mut levels: Probe =
                styles.into_iter().map(|(style, e)| (style, scale(e, settings))).collect();
            levels.sort_by(|a, b| b.1.element_sum().total_cmp(&a.1.element_sum()));
            levels.truncate(MOST_STYLES);
            Some(levels)
        })
        .collect()
}

/// Where the probe of each brush model is; `None` for those that need none.
fn places(scene: &Scene, samples: &[Vec<Sample>]) -> Vec<Option<Vec3>> {
    let mut wanted = vec![false; scene.models.len()];
    for (surface, samples) in scene.surfaces.iter().zip(samples) {
        if let Some(model) = surface.model
            && light::wants_probe(surface, samples)
        {
            wanted[model as usize] = true;
        }
    }
    let place = |(wanted, model): (bool, &Model)| {
        wanted.then(|| light::probe_place(scene, model.centre)).flatten()
    };
    wanted.into_iter().zip(&scene.models).map(place).collect()
}

/// Hemicubes that [`probes`] draws where light bounces.
pub fn probe_hemicubes(scene: &Scene, samples: &[Vec<Sample>]) -> u64 {
    let probes = places(scene, samples).into_iter().flatten().count();
    (probes * light::SIDES.len()) as u64
}

/// Adds bounced light: that of the side of a cube around the point which gets most.
fn bounced(
    gatherer: &mut Gatherer<'_>,
    place: Vec3,
    patch_light: &[PatchLight],
    styles: &mut Vec<(u16, Irradiance)>,
) {
    let exitance: Vec<Vec<Vec3>> =
        patch_light.iter().map(|l| l.exitance.iter().map(|m| m.0).collect()).collect();
    let mut best = vec![DVec3::ZERO; patch_light.len()];
    let mut sums: Vec<DVec3> = Vec::new();
    for side in light::SIDES {
        gatherer.look(&View::turned(place, side, 0));
        gatherer.irradiance(&exitance, &mut sums);
        for (best, sum) in best.iter_mut().zip(&sums) {
            if sum.element_sum() > best.element_sum() {
                *best = *sum;
            }
        }
    }
    for (light, best) in patch_light.iter().zip(best).filter(|(_, b)| *b != DVec3::ZERO) {
        match styles.iter_mut().find(|s| s.0 == light.style) {
            Some(sum) => sum.1 += Irradiance(best.as_vec3()),
            None => styles.push((light.style, Irradiance(best.as_vec3()))),
        }
    }
}
