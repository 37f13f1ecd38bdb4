//! Before a run: what each preset would take on this map.

use super::{Costs, Predicted};
use crate::bsp::{Bsp, MipTex};
use crate::light::{self, Directions, RayCounts};
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
    let direct = sample_direct(&scene, &points).0;
    let costs = Costs::measure(&scene, &points.luxels);
    let of = |quality: Quality| {
        let preset = Settings::of_quality(quality);
        let rung = settings.ladder.nearest(&preset);
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

/// Seconds and rays of direct light, from some faces.
pub(crate) fn sample_direct(scene: &Scene, points: &stage::Points) -> (f64, RayCounts) {
    let samples = points.samples();
    let all: usize = samples.iter().map(Vec::len).sum();
    let mut rays = RayCounts::default();
    if all == 0 {
        return (0.0, rays);
    }
    // Faces as they come along a walk through all of them in even steps.
    let step = (samples.len() as f64 * 0.618) as usize | 1;
    let order = (0..samples.len()).map(|k| k * step % samples.len());
    let order: Vec<usize> = order.filter(|&f| !samples[f].is_empty()).collect();
    let start = Instant::now();
    let (mut done, mut luxels) = (0, 0);
    for faces in order.chunks(8 * rayon::current_num_threads()) {
        let traced: Vec<RayCounts> = faces
            .par_iter()
            .map_init(
                || light::Blockers::new(scene),
                |blockers, &face| {
                    let none = Directions::default();
                    light::direct_from(scene, face, &samples[face], none, blockers).rays
                },
            )
            .collect();
        traced.into_iter().for_each(|more| rays += more);
        done += faces.len();
        luxels += faces.iter().map(|&f| samples[f].len()).sum::<usize>();
        let late = start.elapsed().as_secs_f64() > PATIENCE;
        if late || luxels as f64 > SAMPLED * all as f64 && done >= 64 {
            break;
        }
    }
    let share = all as f64 / luxels.max(1) as f64;
    (start.elapsed().as_secs_f64() * share, rays.scaled(share))
}
