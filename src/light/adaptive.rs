//! Supersampling where it matters. Each light is looked at from the corners of the cells of a surface,
//! one or two for each luxel. Where it arrives at all of them, or at none, that holds for the samples
//! between; where it does so at some, the rim of a shadow runs through the cell, and all its samples
//! are traced, unless the light is too weak to matter.

use super::cells::{CellSums, Cells};
use super::source::Source;
use super::wanted::Wanted;
use crate::scene::{Arrival, DirtKeys};
use glam::Vec3;

/// Share of its light by which a shadow's rim is off where only the corners of a cell are known, root
/// mean square.
const RIM: f32 = 0.2;
/// How far off the light of a luxel may be by all such rims, in levels, root mean square.
const ALLOWED: f32 = 0.3;
/// Lights that vary less over a cell count as linear, in levels.
const STEADY: f32 = 0.5;
/// How far off the middle of a cell may be from linear, in levels.
const LINEAR: f32 = 0.3;
/// Light that is brighter than this, in levels, is looked at from the middle of cells as well.
const BRIGHT: f32 = 2.0;

/// How far off the cells of a surface still may be.
pub(super) struct Leeway {
    /// Levels a light unit.
    scale: f32,
    /// Sum of squares, in levels, that each cell has left.
    left: Vec<f32>,
}

impl Leeway {
    /// For a number of cells; levels are `scale` a light unit, and `exact` leaves nothing to guess.
    pub fn new(cells: usize, scale: f32, exact: bool) -> Self {
        let allowed = if exact { 0.0 } else { ALLOWED * ALLOWED };
        Self { scale, left: vec![allowed; cells] }
    }

    fn levels(&self, colour: Vec3) -> f32 {
        colour.abs().max_element() * self.scale
    }

    /// Whether the rim of a shadow in light of a colour may be left to the corners of a cell.
    fn takes(&mut self, cell: usize, brightest: f32) -> bool {
        let off = (RIM * brightest).powi(2);
        let takes = off <= self.left[cell];
        if takes {
            self.left[cell] -= off;
        }
        takes
    }
}

/// Lights all samples.
pub(super) fn light_cells(
    source: &mut impl Source,
    cells: &Cells,
    leeway: &mut Leeway,
    wanted: &mut Wanted,
    sums: &mut CellSums<'_, '_>,
) {
    let Some(whole) = cells.coarse.whole() else { return };
    if !source.want(&cells.corners, wanted) {
        return;
    }
    for cell in cells.cells() {
        let level = |i: &u32| wanted.sent[*i as usize].map_or(0.0, |c| leeway.levels(c));
        let middle = cell.middle as usize;
        if cell.corners.iter().map(level).fold(0.0, f32::max) > BRIGHT
            && wanted.sent[middle].is_none()
        {
            wanted.sent[middle] = source.sent(middle);
        }
    }
    source.trace(&cells.coarse, whole, wanted);
    let mut open = std::mem::take(&mut wanted.open);
    let mut filtered = std::mem::take(&mut wanted.filtered);
    open.sort_unstable();
    filtered.sort_unstable();
    let mut verdicts: Vec<Verdict> = (0..cells.cells().len())
        .map(|at| judge(source, cells, at, leeway, wanted, [&open, &filtered]))
        .collect();
    // What casts a shadow that is seen in one cell may cast a fine one in the next.
    let is_mixed: Vec<bool> = verdicts.iter().map(|v| matches!(v, Verdict::Mixed)).collect();
    if is_mixed.contains(&true) {
        for (at, beside) in cells.beside(&is_mixed).into_iter().enumerate() {
            let cell = &cells.cells()[at];
            let level = |i: &u32| wanted.sent[*i as usize].map_or(0.0, |c| leeway.levels(c));
            if beside
                && cell.corners.iter().any(|i| level(i) > BRIGHT)
                && open.binary_search(&cell.corners[0]).is_err()
            {
                verdicts[at] = Verdict::Mixed;
            }
        }
    }
    let mut mixed = Vec::new();
    for (at, (cell, verdict)) in cells.cells().iter().zip(verdicts).enumerate() {
        match verdict {
            Verdict::Dark => {}
            Verdict::Linear(arrivals, keys) => {
                let given =
                    |k: usize| arrivals[k].map(|a| source.given(cell.corners[k] as usize, a));
                sums.add_cell(cells, at, [0, 1, 2, 3].map(given), (source, keys));
            }
            Verdict::Lit => {
                for &i in cells.fine.members(&cells.fine.all()[at]) {
                    if let Some(colour) = source.sent(i as usize) {
                        let given = source.given(i as usize, plain(colour));
                        sums.sums.add(i as usize, &given);
                    }
                }
            }
            Verdict::Mixed => {
                for &i in cells.fine.members(&cells.fine.all()[at]) {
                    let known = wanted.arrived[i as usize].filter(|_| cells.is_corner[i as usize]);
                    if let Some(arrival) = known {
                        sums.sums.add(i as usize, &source.given(i as usize, arrival));
                    }
                }
                mixed.push(at);
            }
        }
    }
    wanted.forget(&cells.corners);
    wanted.forget(&cells.middles);
    for at in mixed {
        let tile = &cells.fine.all()[at];
        let members = cells.fine.members(tile);
        let others: Vec<u32> =
            members.iter().copied().filter(|&i| !cells.is_corner[i as usize]).collect();
        if source.want(&others, wanted) {
            source.trace(&cells.fine, tile, wanted);
            for &i in &others {
                if let Some(arrival) = wanted.arrived[i as usize] {
                    sums.sums.add(i as usize, &source.given(i as usize, arrival));
                }
            }
        }
        wanted.forget(&others);
    }
}

/// What the corners of a cell say of a light.
enum Verdict {
    /// None arrives.
    Dark,
    /// What arrives is linear between the corners, dirt by some keys aside.
    Linear([Option<Arrival>; 4], DirtKeys),
    /// All arrives, but varies.
    Lit,
    /// Some arrives.
    Mixed,
}

fn plain(colour: Vec3) -> Arrival {
    Arrival { colour, style: None }
}

/// By how much the light that arrives at a sample is to be multiplied to take dirt out of it.
pub(super) fn clean_again(source: &impl Source, sample: u32) -> f32 {
    // No light passes complete dirt.
    source.share_left(sample as usize).max(f32::EPSILON).recip()
}

fn judge(
    source: &impl Source,
    cells: &Cells,
    at: usize,
    leeway: &mut Leeway,
    wanted: &Wanted,
    [open, filtered]: [&[u32]; 2],
) -> Verdict {
    let cell = &cells.cells()[at];
    let sent = cell.corners.map(|i| wanted.sent[i as usize]);
    let is_open = open.binary_search(&cell.corners[0]).is_ok();
    let arrived = if is_open {
        sent.map(|s| s.map(plain))
    } else {
        cell.corners.map(|i| wanted.arrived[i as usize])
    };
    let middle = cell.middle as usize;
    let there = wanted.sent[middle];
    let odd = |lit: bool| there.is_some() && wanted.arrived[middle].is_some() != lit;
    let brightest = || {
        let all = sent.iter().chain([&there]).flatten();
        all.map(|c| leeway.levels(*c)).fold(0.0, f32::max)
    };
    // Fences cast finer shadows than any cell, each sun of a dome the same.
    let filtered = |i: &u32| !filtered.is_empty() && filtered.binary_search(i).is_ok();
    if cell.corners.iter().chain([&cell.middle]).any(filtered) {
        return Verdict::Mixed;
    }
    if arrived.iter().all(Option::is_none) {
        return if odd(false) { Verdict::Mixed } else { Verdict::Dark };
    }
    let whole = sent.iter().zip(&arrived).all(|(s, a)| match (s, a) {
        (Some(s), Some(a)) => a.colour == *s && a.style.is_none(),
        _ => false,
    });
    if !whole {
        let brightest = brightest();
        return match source.dirt() {
            Some(keys) if leeway.takes(at, brightest) => Verdict::Linear(arrived, keys),
            _ => Verdict::Mixed,
        };
    }
    if !is_open && odd(true) {
        return Verdict::Mixed;
    }
    let Some(keys) = source.dirt() else { return Verdict::Lit };
    if source.is_even() {
        return Verdict::Linear(arrived, keys);
    }
    let clean = |i: u32, colour: Vec3| colour * clean_again(source, i);
    let colours =
        [0, 1, 2, 3].map(|k| sent[k].map_or(Vec3::ZERO, |colour| clean(cell.corners[k], colour)));
    let (low, high) = colours
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), c| (a.min(*c), b.max(*c)));
    if leeway.levels(high - low) <= STEADY {
        return Verdict::Linear(arrived, keys);
    }
    let w = cell.weights(cell.middle);
    let expected = (0..4).fold(Vec3::ZERO, |sum, k| sum + colours[k] * w[k]);
    match there.or_else(|| source.sent(middle)) {
        Some(there) if leeway.levels(clean(cell.middle, there) - expected) <= LINEAR => {
            Verdict::Linear(arrived, keys)
        }
        _ => Verdict::Lit,
    }
}
