//! What looking through or at something takes, counted by many threads.

use crate::scene::effects::Cost;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Sums that any thread adds to. Nothing of them enters a result.
#[derive(Debug, Default)]
pub struct Work {
    cells: AtomicU64,
    rays: AtomicU64,
    nanoseconds: AtomicU64,
}

impl Work {
    /// Adds cells of hemicubes, and how long they took.
    pub fn add_cells(&self, cells: u64, time: Duration) {
        self.cells.fetch_add(cells, Ordering::Relaxed);
        let time = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        self.nanoseconds.fetch_add(time, Ordering::Relaxed);
    }

    /// Adds rays.
    pub fn add_rays(&self, rays: u64) {
        self.rays.fetch_add(rays, Ordering::Relaxed);
    }

    /// The sums so far; seconds are those of all threads together.
    pub fn cost(&self) -> Cost {
        Cost {
            cells: self.cells.load(Ordering::Relaxed),
            rays: self.rays.load(Ordering::Relaxed),
            bytes: 0,
            seconds: self.nanoseconds.load(Ordering::Relaxed) as f64 * 1e-9,
        }
    }
}
