//! Sparse rows of form factors: which share of a patch's view each other patch fills.

mod bytes;
mod estimate;

use super::hemicube::{Cells, DeltaFormFactors, HemicubeSize, ItemBuffer, View};
use super::near_pairs::NearPairs;
use super::overlay_view::{self, OverlayView, Shown};
use crate::patch::{PatchId, PatchSet, PolygonPatches};
use crate::scene::{ShadowRays, Tracer};
use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;
use wide::f32x8;

/// The longest step to the next column; a longer one is several.
const FAR: u16 = u16::MAX;
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

/// Rows one after the other, six bytes an entry.
#[derive(Default)]
struct Chunk {
    distances: Vec<Distances>,
    ends: Vec<u32>,
    /// By how much each entry's column is larger than the one before it in the row (the first: than 0);
    /// [`FAR`] moves on by that much and is no entry.
    steps: Vec<u16>,
    weights: Vec<f32>,
    /// What an overlay adds to each row; empty without one.
    overlay: Vec<Vec<(u32, Vec3)>>,
}

impl Chunk {
    fn push(&mut self, row: &[(PatchId, f64)], distances: Distances) {
        self.distances.push(distances);
        let mut column = 0;
        for &(j, f) in row {
            let mut step = j.0 - column;
            while step >= u32::from(FAR) {
                self.steps.push(FAR);
                self.weights.push(0.0);
                step -= u32::from(FAR);
            }
            self.steps.push(step as u16);
            self.weights.push(f as f32);
            column = j.0;
        }
        self.ends.push(self.steps.len() as u32);
    }

    /// Steps and weights of a row.
    fn row(&self, i: usize) -> (&[u16], &[f32]) {
        let from = if i == 0 { 0 } else { self.ends[i - 1] as usize };
        let to = self.ends[i] as usize;
        (&self.steps[from..to], &self.weights[from..to])
    }

    /// Columns and weights of a row.
    fn entries(&self, i: usize) -> impl Iterator<Item = (u32, f32)> + '_ {
        let (steps, weights) = self.row(i);
        let mut column = 0;
        steps.iter().zip(weights).filter_map(move |(&step, &weight)| {
            column += u32::from(step);
            (step != FAR).then_some((column, weight))
        })
    }

    /// Sum of weight times light over a row.
    fn sum(&self, i: usize, light: &[DVec3]) -> DVec3 {
        let (steps, weights) = self.row(i);
        // Several sums at a time: each addition would wait for the one before.
        let mut sums = [DVec3::ZERO; 4];
        let mut column = 0;
        let mut add = |sum: &mut DVec3, step: u16, weight: f32| {
            column += u32::from(step);
            *sum += light[column as usize] * f64::from(weight);
        };
        let (by_four, rest) = steps.as_chunks::<4>();
        let (weights, last) = weights.as_chunks::<4>();
        for (steps, weights) in by_four.iter().zip(weights) {
            for ((sum, &step), &weight) in sums.iter_mut().zip(steps).zip(weights) {
                add(sum, step, weight);
            }
        }
        for ((sum, &step), &weight) in sums.iter_mut().zip(rest).zip(last) {
            add(sum, step, weight);
        }
        (sums[0] + sums[1]) + (sums[2] + sums[3])
    }
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

    /// The same, but patch i does without a hemicube of its own where the row of patch `leaders[i]`, on
    /// the same face, does as well: where they see each other and the distance between them is less
    /// than `share` of the harmonic mean distance of what the leader sees. A leader leads itself; with
    /// a `share` of 0 all rows are drawn.
    pub fn shared(
        tracer: &Tracer,
        patches: &PatchSet,
        (leaders, share): (&[u32], f32),
        size: HemicubeSize,
        advance: impl Fn(u64) + Sync,
    ) -> Self {
        let all = 0..leaders.len() as u32;
        let (first, rest): (Vec<u32>, Vec<u32>) = all.partition(|&i| leaders[i as usize] == i);
        let mut transfers = Self::undrawn(leaders.len());
        transfers.draw(tracer, patches, size, &first, &advance);
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
        transfers.draw(tracer, patches, size, &alone, advance);
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
                rows.steps.shrink_to_fit();
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
        let entries = |c: &Chunk| c.steps.iter().filter(|&&step| step != FAR).count();
        self.chunks.iter().map(entries).sum()
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

    /// Irradiance at each patch when patch j has exitance `exitance[j]`: E_i = sum_j F_ij M_j.
    pub fn gather(&self, exitance: &[DVec3]) -> Vec<DVec3> {
        let rows: Vec<Vec<DVec3>> = self
            .chunks
            .par_iter()
            .map(|chunk| {
                let mut rows: Vec<DVec3> =
                    (0..chunk.ends.len()).map(|i| chunk.sum(i, exitance)).collect();
                for (sum, row) in rows.iter_mut().zip(&chunk.overlay) {
                    *sum += overlay_view::gather(row, exitance);
                }
                rows
            })
            .collect();
        self.row_of.iter().map(|&at| rows[at as usize / CHUNK][at as usize % CHUNK]).collect()
    }

    /// The patch from which the row of patch `i` was drawn: `i` itself, or one that it shares it with.
    pub fn drawn_at(&self, i: usize) -> usize {
        self.drawn_at[i] as usize
    }
}

/// Turns hemicubes into sums over patches. Holds the buffers that are reused.
pub struct Gatherer<'a> {
    tracer: &'a Tracer,
    patches: &'a PatchSet,
    delta: &'a DeltaFormFactors,
    buffer: ItemBuffer,
    /// Sum for each patch; zero outside a call of `look`.
    sums: Vec<f64>,
    /// A bit for each patch that has a sum.
    touched: Vec<u64>,
    row: Vec<(PatchId, f64)>,
    overlay: Option<OverlayView<'a>>,
}

impl<'a> Gatherer<'a> {
    /// `delta` must be of the same `size`.
    pub fn new(
        tracer: &'a Tracer,
        patches: &'a PatchSet,
        delta: &'a DeltaFormFactors,
        size: HemicubeSize,
    ) -> Self {
        Self {
            tracer,
            patches,
            delta,
            buffer: ItemBuffer::new(size),
            sums: vec![0.0; patches.patches.len()],
            touched: vec![0; patches.patches.len().div_ceil(64)],
            row: Vec::new(),
            overlay: OverlayView::new(patches),
        }
    }

    /// The same without what an overlay adds.
    pub fn without_overlay(mut self) -> Self {
        self.overlay = None;
        self
    }

    /// Draws the hemicube of `view`; the other functions tell what it shows.
    pub fn look(&mut self, view: &View) {
        self.buffer.draw(self.tracer, view);
        self.row.clear();
        let (sums, touched, row) = (&mut self.sums, &mut self.touched, &mut self.row);
        let seen = (&self.buffer, self.tracer, self.patches, self.delta);
        for_each_patch(seen, view, 0.0, |patch, _, f| {
            sums[patch.0 as usize] += f64::from(f);
            touched[patch.0 as usize / 64] |= 1 << (patch.0 % 64);
        });
        for (k, word) in touched.iter_mut().enumerate() {
            let mut bits = std::mem::take(word);
            while bits != 0 {
                let patch = 64 * k + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                row.push((PatchId(patch as u32), std::mem::take(&mut sums[patch])));
            }
        }
        self.look_at_overlay(view);
    }

    fn look_at_overlay(&mut self, view: &View) {
        if let Some(overlay) = &mut self.overlay {
            let (buffer, tracer) = (&self.buffer, self.tracer);
            let (patches, delta) = (self.patches, self.delta);
            overlay.look(Shown { buffer, tracer, patches, delta }, view);
        }
    }

    /// What an overlay adds to what the last look showed, per channel, by ascending patch.
    pub fn overlay(&self) -> &[(PatchId, DVec3)] {
        self.overlay.as_ref().map_or(&[], OverlayView::row)
    }

    /// What an overlay adds to [`row`](Self::row), as [`Transfers::overlay_row`] has it; `None` without.
    fn overlay_row(&self) -> Option<Vec<(u32, Vec3)>> {
        let row = self.overlay.as_ref()?.row();
        Some(row.iter().map(|&(patch, f)| (patch.0, f.as_vec3())).collect())
    }

    /// Draws the hemicube of `view` and calls `visit(patch, interval, form factor)` for what it shows, in
    /// a fixed order; patches come up many times. Luxel intervals, of those of the map, are told up to
    /// depth `reach`. Afterwards only [`distances`](Self::distances) and [`overlay`](Self::overlay) know of
    /// this look.
    pub fn visit(
        &mut self,
        view: &View,
        reach: f32,
        visit: impl FnMut(PatchId, Option<Interval>, f32),
    ) {
        self.buffer.draw(self.tracer, view);
        self.row.clear();
        let seen = (&self.buffer, self.tracer, self.patches, self.delta);
        for_each_patch(seen, view, reach, visit);
        self.look_at_overlay(view);
    }

    /// Form factors from the point looked from to all patches seen, in ascending order of patch.
    pub fn row(&self) -> &[(PatchId, f64)] {
        &self.row
    }

    /// Irradiance at the point looked from when patch j has exitance `exitance[j]`, for each style.
    pub fn irradiance(&self, exitance: &[Vec<Vec3>], out: &mut Vec<DVec3>) {
        out.clear();
        out.resize(exitance.len(), DVec3::ZERO);
        for &(patch, f) in &self.row {
            for (sum, style) in out.iter_mut().zip(exitance) {
                *sum += style[patch.0 as usize].as_dvec3() * f;
            }
        }
        for &(patch, f) in self.overlay() {
            for (sum, style) in out.iter_mut().zip(exitance) {
                *sum += style[patch.0 as usize].as_dvec3() * f;
            }
        }
    }

    /// How far what was looked at is away.
    pub fn distances(&self) -> Distances {
        let (mut inverse, mut largest) = (f32x8::ZERO, f32x8::ZERO);
        self.buffer.for_each_row(|cells| {
            let from = (cells.y * self.buffer.size().width() + cells.x) as usize;
            let cell = from..from + cells.nearness.len();
            let lengths = &self.delta.inverse_length(cells.side)[cell.clone()];
            let here = lanes(cells.nearness, 0.0) * lanes(lengths, 0.0);
            inverse += here * lanes(&self.delta.of(cells.side)[cell], 0.0);
            largest = largest.fast_max(here);
        });
        let largest = largest.to_array().into_iter().fold(0.0, f32::max);
        Distances { openness: 1.0 / inverse.reduce_add(), nearest: 1.0 / largest }
    }
}

/// Distances from a point to what it sees, in world units; infinite when nothing is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    /// Harmonic mean, weighted by form factor. Irradiance varies over lengths of this order (G. Ward, F.
    /// Rubinstein and R. Clear, "A ray tracing solution for diffuse interreflection", 1988).
    pub openness: f32,
    /// The smallest in any cell.
    pub nearest: f32,
}

/// A luxel interval of a face, the square between four luxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interval {
    /// Number of the face's first interval among those of the map.
    pub first: u32,
    /// Its number on the face.
    pub number: u32,
}

/// Up to eight values in lanes, the rest filled up.
fn lanes(values: &[f32], rest: f32) -> f32x8 {
    let mut all = [rest; 8];
    all[..values.len()].copy_from_slice(values);
    f32x8::new(all)
}

/// Calls `visit(patch, luxel interval, form factor)` for runs of cells that show the front of a patch;
/// intervals are told up to depth `reach`.
fn for_each_patch(
    (buffer, tracer, patches, delta): (&ItemBuffer, &Tracer, &PatchSet, &DeltaFormFactors),
    view: &View,
    reach: f32,
    mut visit: impl FnMut(PatchId, Option<Interval>, f32),
) {
    const STEPS: f32x8 = f32x8::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    let size = buffer.size();
    let mut fronts = Fronts::default();
    buffer.for_each_row(|cells| {
        let weights = &delta.of(cells.side)[(cells.y * size.width() + cells.x) as usize..];
        let mut from = 0;
        while from < cells.items.len() {
            let item = cells.items[from];
            let run = cells.items[from..].iter().take_while(|&&i| i == item).count();
            let (first, to) = (from, from + run);
            from = to;
            if item == Cells::NOTHING || !fronts.seen(item, tracer, view) {
                continue;
            }
            match patches.lookup.polygon(item) {
                PolygonPatches::None => {}
                PolygonPatches::Whole(patch) => {
                    visit(*patch, None, weights[first..to].iter().sum());
                }
                PolygonPatches::Grid(grid) => {
                    // Luxel coordinates along the ray: at the eye, plus direction / nearness.
                    let [a, b, c] = view.axes(cells.side);
                    let at = size.cell_centre(cells.side, cells.x, cells.y);
                    let next = 2.0 / size.width() as f32;
                    let start = c + b * at.y + a * at.x;
                    let depth = f32x8::ONE / lanes(cells.nearness, 1.0);
                    let interval = |row: Vec4, count: usize| {
                        let r = row.truncate();
                        let slope = STEPS * f32x8::splat(r.dot(a) * next);
                        let along = (f32x8::splat(r.dot(start)) + slope) * depth;
                        let at = along + f32x8::splat(r.dot(view.position) + row.w);
                        // What is out of range, by rounding, belongs to the last. Truncated numbers
                        // are small: the casts are exact, and quick to signed integers.
                        let last = f32x8::splat((count - 1) as f32);
                        let number = f32x8::ZERO.fast_max(at).fast_min(last).to_array();
                        (number.map(|v| v as i32 as u32), at.to_array())
                    };
                    let (columns, s) = interval(grid.s_row, grid.block_column.len());
                    let (rows, t) = interval(grid.t_row, grid.block_row.len());
                    let depth = depth.to_array();
                    let place = |i: usize| {
                        let (column, row) = (columns[i], rows[i]);
                        let near = depth[i] < reach;
                        let number = row * grid.block_column.len() as u32 + column;
                        let interval = Interval { first: grid.first_interval, number };
                        let patch = grid.of_interval([column as usize, row as usize], [s[i], t[i]]);
                        (patch, near.then_some(interval))
                    };
                    let (mut here, mut sum) = (place(first), weights[first]);
                    for (i, weight) in weights.iter().enumerate().take(to).skip(first + 1) {
                        let next = place(i);
                        if next != here {
                            visit(here.0, here.1, sum);
                            (here, sum) = (next, 0.0);
                        }
                        sum += weight;
                    }
                    visit(here.0, here.1, sum);
                }
            }
        }
    });
}

/// Which polygons are seen from their front: remembers the last ones asked for.
struct Fronts([(u32, bool); 16]);

impl Default for Fronts {
    fn default() -> Self {
        Self([(Cells::NOTHING, false); 16])
    }
}

impl Fronts {
    fn seen(&mut self, item: u32, tracer: &Tracer, view: &View) -> bool {
        let known = &mut self.0[item as usize % 16];
        if known.0 != item {
            let polygon = &tracer.polygons()[item as usize];
            *known = (item, polygon.normal.dot(view.position - polygon.vertices[0]) > 0.0);
        }
        known.1
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
        let light: Vec<DVec3> = (0..700_001).map(|j| DVec3::splat(f64::from(j))).collect();
        for (i, row) in rows.into_iter().enumerate() {
            let expected: Vec<_> = row.iter().map(|&j| (j, weight(j) as f32)).collect();
            assert_eq!(chunk.entries(i).collect::<Vec<_>>(), expected);
            let sum: f64 = expected.iter().map(|&(j, f)| f64::from(j) * f64::from(f)).sum();
            assert!((chunk.sum(i, &light).x - sum).abs() <= 1e-9 * sum, "row {i}");
        }
    }
}
