//! What half the error would take, told after a run from what it took.

use super::Rung;
use crate::report::Counts;
use crate::settings::{Quality, Settings};
use std::time::Duration;

/// Seconds of hemicubes grow as this power of the cells along an edge.
const CELLS: f64 = 1.1;

/// Seconds of the stages of a run that have one of some names.
fn seconds_of(stages: &[(&'static str, Duration)], names: &[&str]) -> f64 {
    stages.iter().filter(|s| names.contains(&s.0)).map(|s| s.1.as_secs_f64()).sum()
}

/// Seconds that a map run would take with about half the error, and the settings that would do, after one
/// that counted `counts` and took `seconds` as a whole, `stages` being its parts. `None` if no settings
/// are known to reach that.
pub fn half_error(
    settings: &Settings,
    counts: &Counts,
    stages: &[(&'static str, Duration)],
    seconds: f64,
) -> Option<(f64, Rung)> {
    let now = settings.ladder.nearest(settings);
    let of_patches = seconds_of(stages, &["form factors"]);
    let at_luxels = seconds_of(stages, &["gather"]);
    let each = of_patches / counts.hemicubes[0].max(1) as f64;
    // What luxels take that get no hemicube.
    let between = (at_luxels - counts.hemicubes[1] as f64 * each).max(0.0);
    let of = |next: &Rung| {
        let finer = (f64::from(next.cells) / f64::from(now.cells)).powf(CELLS);
        let size = f64::from(now.patch_size) / f64::from(next.patch_size);
        let hemicubes =
            counts.hemicubes[0] as f64 * size * size + counts.luxels as f64 * next.luxels;
        let between = if next.gather_error == 0.0 { 0.0 } else { between };
        seconds - of_patches - at_luxels + hemicubes * each * finer + between
    };
    let enough = settings.ladder.rungs().iter().filter(|r| r.error <= 0.55 * now.error);
    enough.map(|r| (of(r), *r)).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The same for text scenes and the next preset, which has about half the error: closed forms take so
/// many times as long there, and all else the same.
pub fn half_error_text(
    quality: Option<Quality>,
    stages: &[(&'static str, Duration)],
    seconds: f64,
) -> Option<(f64, Quality)> {
    let near = seconds_of(stages, &["near pairs"]);
    let (times, next) = match quality {
        // Nothing is known yet of the closed forms of this scene.
        None => return Some((1.3 * seconds, Quality::Draft)),
        Some(Quality::Draft) => (4.0, Quality::Normal),
        Some(Quality::Normal) => (1.8, Quality::High),
        Some(Quality::High) => (1.8, Quality::Final),
        Some(Quality::Final) => return None,
    };
    Some((seconds + near * (times - 1.0), next))
}
