//! What half the error would take, told after a run from what it took.

use super::{Rung, rungs};
use crate::report::Counts;
use crate::settings::{Quality, Settings};
use std::time::Duration;

/// Seconds of hemicubes grow as this power of the cells along an edge.
const CELLS: f64 = 1.0;

/// Seconds that a map run would take with about half the error, after one that counted `counts` and took
/// `seconds` as a whole, `stages` being its parts. `None` if no settings are known to reach that.
pub fn half_error(
    settings: &Settings,
    counts: &Counts,
    stages: &[(&'static str, Duration)],
    seconds: f64,
) -> Option<f64> {
    let now = Rung::of(settings);
    let rungs = rungs();
    let next = rungs.iter().find(|r| r.error <= 0.55 * now.error)?;
    let stage = |name: &str| {
        let times = stages.iter().filter(|s| s.0 == name);
        times.map(|s| s.1.as_secs_f64()).sum::<f64>()
    };
    let bounced = stage("form factors") + stage("gather");
    let drawn = (counts.hemicubes[0] + counts.hemicubes[1]).max(1) as f64;
    let each = bounced / drawn;
    let finer = (f64::from(next.cells) / f64::from(now.cells)).powf(CELLS);
    let size = f64::from(now.patch_size) / f64::from(next.patch_size);
    let hemicubes = counts.hemicubes[0] as f64 * size * size + counts.luxels as f64 * next.luxels;
    Some(seconds - bounced + hemicubes * each * finer)
}

/// The same for text scenes, by what the presets took on scenes with known light: about half the error
/// for each step, and these times as long.
pub fn half_error_text(quality: Option<Quality>, seconds: f64) -> Option<f64> {
    let times = match quality {
        None => 1.7,
        Some(Quality::Draft) => 2.2,
        Some(Quality::Normal) => 2.5,
        Some(Quality::High) => 1.8,
        Some(Quality::Final) => return None,
    };
    Some(seconds * times)
}
