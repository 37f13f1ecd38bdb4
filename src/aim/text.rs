//! What text scenes take at each preset, from samples of their rows.

use super::TextLadder;
use crate::patch::{MAX_REFLECTANCE, PatchId, TextPatches, TextScene};
use crate::radiosity::hemicube::{DeltaFormFactors, HemicubeSize, View};
use crate::radiosity::importance::Importance;
use crate::radiosity::near_pairs::NearPairs;
use crate::radiosity::overlay_pairs::OverlayRows;
use crate::radiosity::solve::{Limits, Sources, solve_with};
use crate::radiosity::transfers::{Gatherer, OVERLAY_ENTRY, Transfers};
use crate::radiosity::trapped;
use crate::radiosity::visibility::Occluders;
use crate::settings::Quality;
use crate::{Result, TEXT_RESIDUAL};
use rayon::prelude::*;
use std::time::Instant;

/// Rows that are sampled.
const SAMPLED: usize = 48;
/// Cells of the hemicubes of the rough solution.
const ROUGH: u32 = 32;
/// Seconds of a pass for each form factor, on one thread.
const PASS: f64 = 2e-9;

/// What a preset takes on a text scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextPredicted {
    /// The preset.
    pub quality: Quality,
    /// Seconds.
    pub seconds: f64,
    /// Bytes.
    pub memory: f64,
    /// Relative root mean square error of reflected light.
    pub error: f64,
}

/// Predicts the presets that are `wanted`.
///
/// # Errors
/// When the scene's hemicube size is out of range.
pub fn estimate_text(
    scene: &TextScene,
    ladder: &TextLadder,
    wanted: impl Fn(Quality) -> bool,
) -> Result<Vec<TextPredicted>> {
    let begin = Instant::now();
    let size = HemicubeSize::new(scene.hemicube[0], scene.hemicube[1])?;
    let patches = TextPatches::new(scene);
    let (tracer, set) = (&patches.tracer, &patches.set);
    let count = set.patches.len();
    let setup = begin.elapsed().as_secs_f64();
    let rough = HemicubeSize::new(ROUGH, ROUGH)?;
    let transfers = Transfers::compute(tracer, set, rough, |_| {});
    let sources = Sources { emission: &patches.emission, direct: &[] };
    let limits = Limits { passes: Some(scene.passes), residual: TEXT_RESIDUAL };
    let (mut reflectance, mut passages) = (patches.reflectance(), set.passages.clone());
    trapped::let_out(&transfers, &mut reflectance, &mut passages, MAX_REFLECTANCE as f32);
    let solution = solve_with(&transfers, &reflectance, &passages, sources, limits);
    let chosen: Vec<usize> = (0..count).step_by(count.div_ceil(SAMPLED).max(1)).collect();
    let n = chosen.len().max(1) as f64;
    let delta = DeltaFormFactors::new(size);
    let start = Instant::now();
    let rows: Vec<Vec<(PatchId, f64)>> = chosen
        .par_iter()
        .map_init(
            || Gatherer::new(tracer, set, &delta, size),
            |gatherer, &i| {
                let patch = &set.patches[i];
                gatherer.look(&View::turned(patch.eye, patch.normal, i as u64));
                gatherer.row().to_vec()
            },
        )
        .collect();
    let each = start.elapsed().as_secs_f64() / n;
    let length = rows.iter().map(Vec::len).sum::<usize>() as f64 / n;
    let factors = length * count as f64;
    let threads = rayon::current_num_threads() as f64;
    let plain = setup + count as f64 * each;
    let coarser = size.coarser();
    let delta = DeltaFormFactors::new(coarser);
    let of = |(quality, error): (Quality, f64)| {
        let importance = Importance::new(set, &patches.emission, &solution.exitance);
        let start = Instant::now();
        let occluders = Occluders::with_sheets(tracer, &patches.sheets);
        let near = NearPairs::new(set, occluders, importance, quality.near(), size.cells());
        let begun = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let overlay = set.overlay.as_deref().map(|overlay| OverlayRows::new(overlay, &near));
        let lengths: Vec<[usize; 2]> = chosen
            .par_iter()
            .zip(&rows)
            .map_init(
                || (near.work(), Gatherer::new(tracer, set, &delta, coarser).without_overlay()),
                |(work, gatherer), (&i, row)| {
                    let mut row = row.clone();
                    near.improve(i, &mut row, work, gatherer);
                    let pairs = || row.iter().map(|&(j, f)| (j.0, f as f32));
                    let through = overlay.as_ref().map_or(0, |rows| rows.row(i, pairs()).len());
                    [row.len(), through]
                },
            )
            .collect();
        let mean = |k: usize| lengths.iter().map(|l| l[k]).sum::<usize>() as f64 / n;
        let improving = count as f64 * start.elapsed().as_secs_f64() / n;
        let factors = factors * mean(0) / length.max(1.0);
        let through = mean(1) * (count * OVERLAY_ENTRY) as f64;
        let passes = f64::from(solution.passes) * factors * PASS / threads;
        let memory = 6e6 + factors * 8.5 + through + count as f64 * 1500.0;
        TextPredicted { quality, seconds: plain + begun + improving + passes, memory, error }
    };
    Ok(ladder.errors().into_iter().filter(|e| wanted(e.0)).map(of).collect())
}
