//! Sparse rows of form factors: which share of a patch's view each other patch fills.

mod bytes;
mod estimate;
mod gather;
mod gatherer;
mod rows;
mod share;
mod weights;

pub(super) use gather::AT_A_TIME;
pub use gatherer::{Distances, Gatherer, Interval};
pub use share::Sharing;

use self::rows::{Chunk, Found};
use self::weights::Precision;
use super::hemicube::{DeltaFormFactors, HemicubeSize, View};
use super::near_pairs::NearPairs;
use crate::patch::{Groups, Overlay, Patch, PatchId, PatchSet};
use crate::scene::Tracer;
use crate::scene::effects::Cost;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Rows computed, and stored, as one piece.
const CHUNK: usize = 32;

/// Bytes of what an overlay adds to one form factor.
pub(crate) const OVERLAY_ENTRY: usize = size_of::<(u32, Vec3)>();

/// Form factors `F_ij`: the share of the hemisphere above patch i (cosine-weighted) in which patch j
/// is seen from its front. Rows sum to 1 in a closed room.
#[derive(Default)]
pub struct Transfers {
    /// Rows are stored in them one after the other; the last of those drawn at one time may have fewer
    /// than [`CHUNK`].
    chunks: Vec<Chunk>,
    /// Where the row of each patch is: chunk times [`CHUNK`], and place in the chunk.
    row_of: Vec<u32>,
    /// The first of the patches that share that row.
    first_of: Vec<u32>,
    /// Rows before this are shared: `row_of` says where they are.
    shared: usize,
    drawn: u64,
    precision: Precision,
    /// What changes light on its way; `None` where nothing does.
    overlay: Option<Arc<Overlay>>,
}

/// Where a row is drawn.
struct Eye {
    at: Vec3,
    /// The patch it is on, which may be one of several.
    patch: u32,
}

impl Transfers {
    /// Draws a hemicube at every patch. `advance(n)` is told of every n patches done.
    pub fn compute(
        tracer: &Tracer,
        patches: &PatchSet,
        size: HemicubeSize,
        advance: impl Fn(u64) + Sync,
    ) -> Self {
        let eye = |(patch, i): (&Patch, u32)| Eye { at: patch.eye, patch: i };
        let all: Vec<Eye> = patches.patches.iter().zip(0..).map(eye).collect();
        let mut transfers = Self::undrawn(all.len(), Precision::Single);
        let goes_on = |n| {
            advance(n);
            true
        };
        transfers.draw(tracer, patches, size, &all, &goes_on).expect("not stopped");
        transfers
    }

    /// For `count` patches whose rows are still to be drawn.
    fn undrawn(count: usize, precision: Precision) -> Self {
        let [row_of, first_of] = [vec![0; count], vec![0; count]];
        Self { row_of, first_of, precision, ..Self::default() }
    }

    /// Draws hemicubes while it `goes_on`.
    fn draw(
        &mut self,
        tracer: &Tracer,
        patches: &PatchSet,
        size: HemicubeSize,
        eyes: &[Eye],
        goes_on: &(impl Fn(u64) -> bool + Sync),
    ) -> Option<()> {
        let before = self.chunks.len() * CHUNK;
        for (k, eye) in eyes.iter().enumerate() {
            self.row_of[eye.patch as usize] = (before + k) as u32;
            self.first_of[eye.patch as usize] = eye.patch;
        }
        self.drawn += eyes.len() as u64;
        self.overlay.clone_from(&patches.overlay);
        let (delta, precision) = (DeltaFormFactors::new(size), self.precision);
        let drawn: Option<Vec<Chunk>> = eyes
            .par_chunks(CHUNK)
            .map_init(
                || Gatherer::new(tracer, patches, &delta, size),
                |gatherer, eyes| {
                    let (mut rows, mut overlay) = (Found::new(precision), Vec::new());
                    for eye in eyes {
                        let normal = patches.patches[eye.patch as usize].normal;
                        gatherer.look(&View::turned(eye.at, normal, eye.patch.into()));
                        rows.push(gatherer.row(), gatherer.distances());
                        overlay.extend(gatherer.overlay_row());
                    }
                    let rows = Chunk { overlay, ..rows.keep() };
                    goes_on(eyes.len() as u64).then_some(rows)
                },
            )
            .collect();
        self.chunks.extend(drawn?);
        Some(())
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
        let (delta, precision) = (DeltaFormFactors::new(size), self.precision);
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
                let mut rows = Found::new(precision);
                for (k, &distances) in chunk.distances.iter().enumerate() {
                    row.clear();
                    row.extend(chunk.entries(k).map(|(j, f)| (PatchId(j), f64::from(f))));
                    near.improve(number * CHUNK + k, row, work, gatherer);
                    rows.push(row, distances);
                }
                *chunk = Chunk { overlay: std::mem::take(&mut chunk.overlay), ..rows.keep() };
                advance(chunk.rows() as u64);
            },
        );
    }

    /// Number of patches: each has a row.
    pub fn rows(&self) -> usize {
        self.row_of.len()
    }

    /// Number of rows that are stored: fewer where patches share them.
    pub fn stored(&self) -> usize {
        self.chunks.iter().map(Chunk::rows).sum()
    }

    /// Number of hemicubes drawn for them: none where they come from bytes.
    pub fn drawn(&self) -> u64 {
        self.drawn
    }

    /// Number of form factors stored.
    pub fn len(&self) -> usize {
        self.chunks.iter().map(Chunk::len).sum()
    }

    /// Bytes that form factors take with their columns and all that rows take besides, without what an
    /// overlay adds.
    pub fn bytes(&self) -> u64 {
        let of_patches = 2 * size_of::<u32>() * self.rows();
        (of_patches + self.chunks.iter().map(Chunk::bytes).sum::<usize>()) as u64
    }

    /// Whether no patch sees another.
    pub fn is_empty(&self) -> bool {
        self.chunks.iter().all(|c| c.len() == 0)
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

    /// What looking through translucent polygons, and at patterns, took so far.
    pub fn overlay_costs(&self) -> [Cost; 2] {
        let rows = self.chunks.iter().flat_map(|c| &c.overlay);
        let bytes = rows.map(|row| (row.len() * OVERLAY_ENTRY) as u64).sum();
        self.overlay.as_ref().map_or_else(Default::default, |overlay| overlay.costs(bytes))
    }

    /// Replaces what an overlay adds to each row, where all rows were drawn.
    ///
    /// # Panics
    /// If there is not one entry a row.
    pub fn set_overlay_rows(&mut self, rows: Vec<Vec<(u32, Vec3)>>) {
        assert_eq!(rows.len(), self.stored(), "one entry a row");
        let mut rows = rows.into_iter();
        for chunk in &mut self.chunks {
            chunk.overlay = rows.by_ref().take(chunk.rows()).collect();
        }
    }

    /// Damage for tests: patch `row` sees nothing.
    #[cfg(test)]
    pub(crate) fn clear_row(&mut self, row: usize) {
        let at = self.row_of[row] as usize;
        self.chunks[at / CHUNK].clear_row(at % CHUNK);
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

    /// Whether patch `i` shares its row with others of its group.
    pub fn is_shared(&self, i: usize) -> bool {
        (self.row_of[i] as usize) < self.shared
    }

    /// Where the row of patch `i` was drawn: at its eye, or in the middle of the group that shares it.
    pub fn eye(&self, i: usize, patches: &PatchSet, groups: &Groups) -> Vec3 {
        let middle = groups.eyes.get(groups.of[i] as usize).filter(|_| self.is_shared(i));
        middle.copied().unwrap_or(patches.patches[i].eye)
    }

    /// The first of the patches that share the row of patch `i`.
    pub fn first_of(&self, i: usize) -> usize {
        self.first_of[i] as usize
    }
}
