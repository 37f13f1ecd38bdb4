//! Sparse rows of form factors: which share of a patch's view each other patch fills.

mod bytes;
mod estimate;
mod gather;
mod gatherer;

pub(super) use gather::AT_A_TIME;
pub use gatherer::{Distances, Gatherer, Interval};

use super::hemicube::{DeltaFormFactors, HemicubeSize, View};
use super::near_pairs::NearPairs;
use crate::patch::{PatchId, PatchSet};
use crate::scene::{ShadowRays, Tracer};
use glam::Vec3;
use rayon::prelude::*;

/// The longest that a run or the way to it may be.
const LONGEST: u16 = u16::MAX;
/// Rows computed, and stored, as one piece.
const CHUNK: usize = 32;

/// Form factors `F_ij`: the share of the hemisphere above patch i (cosine-weighted) in which patch j
/// is seen from its front. Rows sum to 1 in a closed room.
#[derive(Default)]
pub struct Transfers {
    /// Rows are stored in them one after the other; the last of those drawn at one time may have fewer
    /// than [`CHUNK`].
    chunks: Vec<Chunk>,
    /// Where the row of each patch is: chunk times [`CHUNK`], and place in the chunk.
    row_of: Vec<u32>,
    /// The patch at whose eye that row was drawn.
    drawn_at: Vec<u32>,
    drawn: u64,
}

/// Rows one after the other. Patches beside each other mostly have numbers beside each other, so columns
/// are kept as runs: four bytes an entry and four a run.
#[derive(Default)]
struct Chunk {
    distances: Vec<Distances>,
    /// Where the entries of each row end in `weights`.
    ends: Vec<u32>,
    /// Where those of each row end in `runs`.
    run_ends: Vec<u32>,
    /// How many columns are left out since the run before, and how many follow each other then. What
    /// is too long for one is several.
    runs: Vec<[u16; 2]>,
    weights: Vec<f32>,
    /// What an overlay adds to each row; empty without one.
    overlay: Vec<Vec<(u32, Vec3)>>,
}

impl Chunk {
    fn push(&mut self, row: &[(PatchId, f64)], distances: Distances) {
        self.distances.push(distances);
        let (start, mut next) = (self.runs.len(), 0);
        for &(j, f) in row {
            let mut skip = j.0 - next;
            while skip > u32::from(LONGEST) {
                self.runs.push([LONGEST, 0]);
                skip -= u32::from(LONGEST);
            }
            match self.runs[start..].last_mut() {
                Some([_, length]) if skip == 0 && *length < LONGEST => *length += 1,
                _ => self.runs.push([skip as u16, 1]),
            }
            self.weights.push(f as f32);
            next = j.0 + 1;
        }
        self.ends.push(self.weights.len() as u32);
        self.run_ends.push(self.runs.len() as u32);
    }

    /// Runs and weights of a row.
    fn row(&self, i: usize) -> (&[[u16; 2]], &[f32]) {
        let range = |ends: &[u32]| {
            let from = if i == 0 { 0 } else { ends[i - 1] as usize };
            from..ends[i] as usize
        };
        (&self.runs[range(&self.run_ends)], &self.weights[range(&self.ends)])
    }

    /// Columns and weights of a row.
    fn entries(&self, i: usize) -> impl Iterator<Item = (u32, f32)> + '_ {
        let (runs, weights) = self.row(i);
        let mut column = 0;
        let columns = runs.iter().flat_map(move |&[skip, length]| {
            let first = column + u32::from(skip);
            column = first + u32::from(length);
            first..column
        });
        columns.zip(weights.iter().copied())
    }
}

/// Which patches of a map do without a fine hemicube of their own.
#[derive(Clone, Copy, Debug)]
pub struct Sharing<'a> {
    /// The patch, on the same face, whose row each patch may take. A leader leads itself.
    pub leaders: &'a [u32],
    /// It does where they see each other and the distance between them is less than this share of the
    /// harmonic mean distance of what the leader sees. With 0 all rows are drawn.
    pub share: f32,
    /// Whether half as many cells along an edge do for a patch.
    pub small: &'a [bool],
}

impl Transfers {
    /// Draws a hemicube at every patch. `advance(n)` is told of every n patches done.
    pub fn compute(
        tracer: &Tracer,
        patches: &PatchSet,
        size: HemicubeSize,
        advance: impl Fn(u64) + Sync,
    ) -> Self {
        let all: Vec<u32> = (0..patches.patches.len() as u32).collect();
        let mut transfers = Self::undrawn(all.len());
        transfers.draw(tracer, patches, size, &all, advance);
        transfers
    }

    /// The same, but some patches share their rows, and for some a coarser hemicube does.
    pub fn shared(
        tracer: &Tracer,
        patches: &PatchSet,
        Sharing { leaders, share, small }: Sharing<'_>,
        size: HemicubeSize,
        advance: impl Fn(u64) + Sync,
    ) -> Self {
        let draw = |transfers: &mut Self, members: &[u32]| {
            let (coarse, fine): (Vec<u32>, Vec<u32>) =
                members.iter().partition(|&&i| small[i as usize]);
            transfers.draw(tracer, patches, size, &fine, &advance);
            transfers.draw(tracer, patches, size.halved(), &coarse, &advance);
        };
        let all = 0..leaders.len() as u32;
        let (first, rest): (Vec<u32>, Vec<u32>) = all.partition(|&i| leaders[i as usize] == i);
        let mut transfers = Self::undrawn(leaders.len());
        draw(&mut transfers, &first);
        let alone: Vec<u32> = rest
            .par_iter()
            .copied()
            .map_init(
                || ShadowRays::new(tracer),
                |shadows, i| {
                    let leader = leaders[i as usize];
                    let [here, there] = [i, leader].map(|k| patches.patches[k as usize].eye);
                    let reach = share * transfers.distances(leader as usize).openness;
                    (here.distance(there) >= reach || shadows.blocked(here, there)).then_some(i)
                },
            )
            .flatten()
            .collect();
        for &i in &rest {
            let leader = leaders[i as usize];
            transfers.row_of[i as usize] = transfers.row_of[leader as usize];
            transfers.drawn_at[i as usize] = leader;
        }
        advance((rest.len() - alone.len()) as u64);
        draw(&mut transfers, &alone);
        transfers
    }

    /// For `count` patches whose rows are still to be drawn.
    fn undrawn(count: usize) -> Self {
        Self { row_of: vec![0; count], drawn_at: vec![0; count], ..Self::default() }
    }

    /// Draws hemicubes at these patches.
    fn draw(
        &mut self,
        tracer: &Tracer,
        patches: &PatchSet,
        size: HemicubeSize,
        members: &[u32],
        advance: impl Fn(u64) + Sync,
    ) {
        let before = self.chunks.len() * CHUNK;
        for (k, &i) in members.iter().enumerate() {
            self.row_of[i as usize] = (before + k) as u32;
            self.drawn_at[i as usize] = i;
        }
        self.drawn += members.len() as u64;
        let delta = DeltaFormFactors::new(size);
        self.chunks.par_extend(members.par_chunks(CHUNK).map_init(
            || Gatherer::new(tracer, patches, &delta, size),
            |gatherer, members| {
                let mut rows = Chunk::default();
                for &i in members {
                    let patch = &patches.patches[i as usize];
                    gatherer.look(&View::turned(patch.eye, patch.normal, i.into()));
                    rows.push(gatherer.row(), gatherer.distances());
                    rows.overlay.extend(gatherer.overlay_row());
                }
                advance(members.len() as u64);
                rows.runs.shrink_to_fit();
                rows.weights.shrink_to_fit();
                rows
            },
        ));
    }

    /// Improves the rows that one hemicube of `size` at the middle of a patch gets wrong, see
    /// [`NearPairs`]. Row sums stay what they are where all around is patches. `advance(n)` is told
    /// of every n patches done.
    pub fn improve(
        &mut self,
        tracer: &Tracer,
        patches: &PatchSet,
        size: HemicubeSize,
        near: &NearPairs<'_>,
        advance: impl Fn(u64) + Sync,
    ) {
        let size = size.coarser();
        let delta = DeltaFormFactors::new(size);
        let start = || {
            (
                near.work(),
                Gatherer::new(tracer, patches, &delta, size).without_overlay(),
                Vec::new(),
            )
        };
        self.chunks.par_iter_mut().enumerate().for_each_init(
            start,
            |(work, gatherer, row), (number, chunk)| {
                let mut old = std::mem::take(chunk);
                chunk.overlay = std::mem::take(&mut old.overlay);
                for k in 0..old.ends.len() {
                    row.clear();
                    row.extend(old.entries(k).map(|(j, f)| (PatchId(j), f64::from(f))));
                    near.improve(number * CHUNK + k, row, work, gatherer);
                    chunk.push(row, old.distances[k]);
                }
                advance(old.ends.len() as u64);
            },
        );
    }

    /// Number of patches: each has a row.
    pub fn rows(&self) -> usize {
        self.row_of.len()
    }

    /// Number of rows that are stored: fewer where patches share them.
    pub fn stored(&self) -> usize {
        self.chunks.iter().map(|c| c.ends.len()).sum()
    }

    /// Number of hemicubes drawn for them: none where they come from bytes.
    pub fn drawn(&self) -> u64 {
        self.drawn
    }

    /// Number of form factors stored.
    pub fn len(&self) -> usize {
        self.chunks.iter().map(|c| c.weights.len()).sum()
    }

    /// Whether no patch sees another.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What patch `row` sees: patch indices, ascending, and their form factors.
    pub fn row(&self, row: usize) -> (Vec<u32>, Vec<f32>) {
        self.entries(row).unzip()
    }

    /// What an overlay adds to the form factors of a row, per channel, by ascending patch: positive for
    /// translucent patches, negative for those behind them. Empty without one.
    pub fn overlay_row(&self, row: usize) -> &[(u32, Vec3)] {
        let at = self.row_of[row] as usize;
        self.chunks[at / CHUNK].overlay.get(at % CHUNK).map_or(&[], |row| row)
    }

    /// Replaces what an overlay adds to each row, where all rows were drawn.
    ///
    /// # Panics
    /// If there is not one entry a row.
    pub fn set_overlay_rows(&mut self, rows: Vec<Vec<(u32, Vec3)>>) {
        assert_eq!(rows.len(), self.stored(), "one entry a row");
        let mut rows = rows.into_iter();
        for chunk in &mut self.chunks {
            chunk.overlay = rows.by_ref().take(chunk.ends.len()).collect();
        }
    }

    /// Damage for tests: patch `row` sees nothing.
    #[cfg(test)]
    pub(crate) fn clear_row(&mut self, row: usize) {
        let at = self.row_of[row] as usize;
        let (chunk, i) = (&mut self.chunks[at / CHUNK], at % CHUNK);
        let from = if i == 0 { 0 } else { chunk.ends[i - 1] as usize };
        chunk.weights[from..chunk.ends[i] as usize].fill(0.0);
    }

    /// The same, pair by pair.
    pub fn entries(&self, row: usize) -> impl Iterator<Item = (u32, f32)> + '_ {
        let at = self.row_of[row] as usize;
        self.chunks[at / CHUNK].entries(at % CHUNK)
    }

    /// How far what patch `row` sees is from where its row was drawn.
    pub fn distances(&self, row: usize) -> Distances {
        let at = self.row_of[row] as usize;
        self.chunks[at / CHUNK].distances[at % CHUNK]
    }

    /// The patch from which the row of patch `i` was drawn: `i` itself, or one that it shares it with.
    pub fn drawn_at(&self, i: usize) -> usize {
        self.drawn_at[i] as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_however_far_apart_their_columns_are() {
        let columns = [0, 1, 65_535, 131_070, 131_070 + 65_534, 500_000, 500_001];
        let rows: [&[u32]; 4] = [&columns, &[], &[65_535], &[700_000]];
        let mut chunk = Chunk::default();
        let distances = Distances { openness: 1.0, nearest: 1.0 };
        let weight = |j: u32| 1.0 / f64::from(j % 7 + 2);
        for row in rows {
            let row: Vec<_> = row.iter().map(|&j| (PatchId(j), weight(j))).collect();
            chunk.push(&row, distances);
        }
        let light: Vec<[[f64; 1]; 1]> = (0..700_001).map(|j| [[f64::from(j)]]).collect();
        for (i, row) in rows.into_iter().enumerate() {
            let expected: Vec<_> = row.iter().map(|&j| (j, weight(j) as f32)).collect();
            assert_eq!(chunk.entries(i).collect::<Vec<_>>(), expected);
            let sum: f64 = expected.iter().map(|&(j, f)| f64::from(j) * f64::from(f)).sum();
            assert!((chunk.sum(i, &light)[0][0] - sum).abs() <= 1e-9 * sum, "row {i}");
        }
    }
}
