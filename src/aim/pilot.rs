//! Before a run: what each preset would take on this map.

use super::{Costs, Predicted, Rung};
use crate::bsp::{Bsp, MipTex};
use crate::light::{self, Directions};
use crate::progress::Progress;
use crate::scene::{Scene, Sidecar};
use crate::settings::{Quality, Settings};
use crate::{Result, stage};
use rayon::prelude::*;
use std::time::Instant;

/// Share of the luxels whose direct light is sampled.
const SAMPLED: f64 = 0.04;
/// Seconds after which sampling direct light ends.
const PATIENCE: f64 = 1.5;

/// What a preset would take.
#[derive(Clone, Copy, Debug)]
pub struct Estimated {
    /// The preset.
    pub quality: Quality,
    /// What it takes, direct light included.
    pub predicted: Predicted,
}

/// Predicts each preset on a map from samples of faces and patches, with the other settings as given.
///
/// # Errors
/// When the map cannot be lit.
pub fn estimate(
    bsp: &mut Bsp,
    sidecar: Sidecar<'_>,
    textures: Vec<MipTex>,
    settings: &Settings,
) -> Result<Vec<Estimated>> {
    let start = Instant::now();
    bsp.clear_lighting();
    bsp.rewrite_entities(settings.styles(bsp)?)?;
    let scene = Scene::build(bsp, sidecar, &settings.scene(textures))?;
    let points = stage::place(&scene, settings, &Progress::new(false))?;
    let before = start.elapsed().as_secs_f64();
    let direct = direct_seconds(&scene, &points);
    let costs = Costs::measure(&scene, &points.luxels);
    let of = |quality: Quality| {
        let preset = Settings::of_quality(quality);
        let rung = Rung::of(&Settings { hemicube: preset.hemicube, ..preset });
        let bounces = scene.world.bounce.most != Some(0);
        let mut predicted = costs.predict(&rung);
        if !bounces {
            predicted.seconds = 0.0;
            predicted.error = 0.0;
        }
        predicted.seconds = 1.05 * (before + direct + predicted.seconds);
        Estimated { quality, predicted }
    };
    Ok([Quality::Draft, Quality::Normal, Quality::High, Quality::Final].map(of).to_vec())
}

/// Seconds of direct light, from some faces.
fn direct_seconds(scene: &Scene, points: &stage::Points) -> f64 {
    let samples = points.samples();
    let all: usize = samples.iter().map(Vec::len).sum();
    if all == 0 {
        return 0.0;
    }
    // Faces as they come along a walk through all of them in even steps.
    let step = (samples.len() as f64 * 0.618) as usize | 1;
    let order = (0..samples.len()).map(|k| k * step % samples.len());
    let order: Vec<usize> = order.filter(|&f| !samples[f].is_empty()).collect();
    let start = Instant::now();
    let (mut done, mut luxels) = (0, 0);
    for faces in order.chunks(8 * rayon::current_num_threads()) {
        faces.par_iter().for_each_init(
            || light::Blockers::new(scene),
            |blockers, &face| {
                let none = Directions::default();
                light::direct_from(scene, face, &samples[face], none, blockers);
            },
        );
        done += faces.len();
        luxels += faces.iter().map(|&f| samples[f].len()).sum::<usize>();
        let late = start.elapsed().as_secs_f64() > PATIENCE;
        if late || luxels as f64 > SAMPLED * all as f64 && done >= 64 {
            break;
        }
    }
    start.elapsed().as_secs_f64() * all as f64 / luxels.max(1) as f64
}
