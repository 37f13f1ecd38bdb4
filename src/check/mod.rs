//! After a run: how far off is it? A few hundred luxels or patches are lit again in another way, which
//! uses no row of transfers.
//!
//! With K the true exchange of light, M the true solution and m that of the run, the error M - m is
//! r + K r + K^2 r + ..., where r = E + rho (D + K m) - m is by how much light gathered anew from m
//! differs from m. Both ways below sum up that series along paths of light, backwards from the point
//! that is checked:
//!
//! * on maps by fresh hemicubes at luxels, so that the noise is a share of the error and not of the
//!   light, and besides by rays, which know nothing of hemicubes;
//! * in text scenes by rays from random points of patches, with rays to random points of lamps.

mod choice;
mod corners;
mod energy;
mod lamps;
mod map_light;
mod statistics;
mod text_light;
mod walk;

pub use energy::Energy;
pub use lamps::Lamps;
pub use map_light::{MapLuxels, Run, check_luxels};
pub use statistics::{Findings, Odd};
pub use text_light::{TextQuads, check_patches};
pub use walk::{Direct, Lit, Met};

use crate::progress::Deadline;
use choice::spread;
use glam::Vec3;
use rayon::prelude::*;
use statistics::{Pair, findings};
use std::time::Duration;

/// Most points.
const MOST_POINTS: usize = 600;
/// Paths of a point by rays, in each of two halves: at least, and at most.
const PATHS: [u32; 2] = [64, 4096];
/// Share of a run's time that its check may take.
pub const SHARE: f64 = 0.03;
/// Seconds that a check may take after the shortest run: nobody waits for them, and fewer tell nothing.
const LEAST: f64 = 0.02;

/// Where light is checked: points with the light that the run found there, and how it is found again.
pub trait Points: Sync {
    /// How many points there are to choose from.
    fn count(&self) -> usize;
    /// Whether a point is of use.
    fn counts(&self, _point: usize) -> bool {
        true
    }
    /// Light that the run found at a point, per channel, in light units.
    fn found(&self, point: usize) -> Vec3;
    /// How much the point counts among the others: its area, or 1.
    fn weight(&self, _point: usize) -> f64 {
        1.0
    }
    /// A name for people.
    fn name(&self, point: usize) -> String;
    /// Whether errors of single channels count, or of their mean.
    fn channels_count(&self) -> bool;
    /// Whether points gain by many paths.
    fn by_paths(&self) -> bool;
    /// Begins work that lights points again, by so many paths a half.
    fn again(&self) -> Box<dyn FnMut(usize, u32) -> Again + '_>;
}

/// Light of a point, found again.
#[derive(Clone, Copy, Debug)]
pub struct Again {
    /// Twice, with independent noise.
    pub halves: [Vec3; 2],
    /// And by rays alone.
    pub rays: Vec3,
}

/// When a check is to end that begins after a run of some length: it may take a share of that.
pub fn end(run: Duration, share: f64) -> Duration {
    run + Duration::from_secs_f64((run.as_secs_f64() * share).max(LEAST))
}

/// Lights as many points again as the time until `end` allows, chosen and lit by fixed sequences: the
/// time decides only how many. `None` if there are no points or no light.
pub fn check(points: &impl Points, end: Deadline<'_>) -> Option<Findings> {
    let begun = end.now();
    let useful = spread(points.count()).filter(|&p| points.counts(p)).take(MOST_POINTS);
    let mut paths = PATHS[0];
    let (mut pairs, whole) = light_again(points, useful, paths, end);
    let taken = end.now().saturating_sub(begun);
    let left = end.left();
    if points.by_paths() && whole && left > 2 * taken {
        let more = 0.8 * left.as_secs_f64() / taken.as_secs_f64() * f64::from(paths);
        paths = (more as u32).min(PATHS[1]);
        let (better, _) = light_again(points, pairs.iter().map(|p| p.point), paths, end);
        pairs = if better.len() * 4 > pairs.len() { better } else { pairs };
    }
    findings(points, &pairs, 2 * paths, end.now().saturating_sub(begun))
}

/// As many of the `chosen` points as there is time for, and whether that was all.
fn light_again(
    points: &impl Points,
    mut chosen: impl Iterator<Item = usize>,
    paths: u32,
    end: Deadline<'_>,
) -> (Vec<Pair>, bool) {
    let begun = end.now();
    let mut pairs: Vec<Pair> = Vec::new();
    let mut size = rayon::current_num_threads();
    loop {
        let some: Vec<usize> = chosen.by_ref().take(size).collect();
        if some.is_empty() {
            return (pairs, true);
        }
        let more = some.par_iter().map_init(
            || points.again(),
            |again, &point| Pair {
                point,
                found: points.found(point),
                weight: points.weight(point),
                again: again(point, paths),
            },
        );
        let more: Vec<Pair> = more.collect();
        pairs.extend(more);
        // As many as fit into half of the time left, since the time of a point varies; at the end one for each
        // thread.
        let each = end.now().saturating_sub(begun).as_secs_f64() / pairs.len() as f64;
        let fit = end.left().as_secs_f64() / each;
        let threads = rayon::current_num_threads();
        if end.passed() || fit < threads as f64 {
            return (pairs, false);
        }
        size = ((0.5 * fit) as usize).clamp(threads, MOST_POINTS.max(threads));
    }
}

#[cfg(test)]
mod tests;
