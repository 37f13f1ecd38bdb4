//! Sparse rows of form factors: which share of a patch's view each other patch fills.

use super::hemicube::{Cells, DeltaFormFactors, HemicubeSize, ItemBuffer, View};
use super::near_pairs::NearPairs;
use super::overlay_view::{self, OverlayView, Shown};
use crate::patch::{PatchId, PatchSet, PolygonPatches};
use crate::scene::Tracer;
use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;

/// Rows computed, and stored, as one piece.
const CHUNK: usize = 32;

/// Form factors `F_ij`: the share of the hemisphere above patch i (cosine-weighted) in which patch j
/// is seen from its front. Rows sum to 1 in a closed room.
#[derive(Default)]
pub struct Transfers {
    chunks: Vec<Chunk>,
}

#[derive(Default)]
struct Chunk {
    openness: Vec<f32>,
    ends: Vec<u32>,
    columns: Vec<u32>,
    weights: Vec<f32>,
    /// What an overlay adds to each row; empty without one.
    overlay: Vec<Vec<(u32, Vec3)>>,
}

impl Chunk {
    fn push(&mut self, row: &[(PatchId, f64)], openness: f32) {
        self.openness.push(openness);
        for &(j, f) in row {
            self.columns.push(j.0);
            self.weights.push(f as f32);
        }
        self.ends.push(self.columns.len() as u32);
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
        let delta = DeltaFormFactors::new(size);
        let count = patches.patches.len();
        let chunks = (0..count.div_ceil(CHUNK))
            .into_par_iter()
            .map_init(
                || Gatherer::new(tracer, patches, &delta, size),
                |gatherer, chunk| {
                    let mut rows = Chunk::default();
                    let members = chunk * CHUNK..((chunk + 1) * CHUNK).min(count);
                    let done = members.len() as u64;
                    for i in members {
                        let patch = &patches.patches[i];
                        let view = View::turned(patch.eye, patch.normal, i as u64);
                        gatherer.look(&view);
                        rows.push(gatherer.row(), gatherer.openness());
                        rows.overlay.extend(gatherer.overlay_row());
                    }
                    advance(done);
                    rows.columns.shrink_to_fit();
                    rows.weights.shrink_to_fit();
                    rows
                },
            )
            .collect();
        Self { chunks }
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
                let mut from = 0;
                for (k, &to) in old.ends.iter().enumerate() {
                    let members = from..to as usize;
                    from = members.end;
                    row.clear();
                    row.extend(
                        members.map(|c| (PatchId(old.columns[c]), f64::from(old.weights[c]))),
                    );
                    near.improve(number * CHUNK + k, row, work, gatherer);
                    chunk.push(row, old.openness[k]);
                }
                advance(old.ends.len() as u64);
            },
        );
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.chunks.iter().map(|c| c.ends.len()).sum()
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
    pub fn row(&self, row: usize) -> (&[u32], &[f32]) {
        let chunk = &self.chunks[row / CHUNK];
        let i = row % CHUNK;
        let from = if i == 0 { 0 } else { chunk.ends[i - 1] as usize };
        let to = chunk.ends[i] as usize;
        (&chunk.columns[from..to], &chunk.weights[from..to])
    }

    /// What an overlay adds to the form factors of a row, per channel, by ascending patch: positive for
    /// translucent patches, negative for those behind them. Empty without one.
    pub fn overlay_row(&self, row: usize) -> &[(u32, Vec3)] {
        self.chunks[row / CHUNK].overlay.get(row % CHUNK).map_or(&[], |row| row)
    }

    /// Replaces what an overlay adds to each row.
    ///
    /// # Panics
    /// If there is not one entry a row.
    pub fn set_overlay_rows(&mut self, rows: Vec<Vec<(u32, Vec3)>>) {
        assert_eq!(rows.len(), self.rows(), "one entry a row");
        let mut rows = rows.into_iter();
        for chunk in &mut self.chunks {
            chunk.overlay = rows.by_ref().take(chunk.ends.len()).collect();
        }
    }

    /// Harmonic mean distance to what patch `row` sees, see [`Gatherer::openness`].
    pub fn openness(&self, row: usize) -> f32 {
        self.chunks[row / CHUNK].openness[row % CHUNK]
    }

    /// Irradiance at each patch when patch j has exitance `exitance[j]`: E_i = sum_j F_ij M_j.
    pub fn gather(&self, exitance: &[DVec3]) -> Vec<DVec3> {
        (0..self.rows())
            .into_par_iter()
            .with_min_len(64)
            .map(|i| {
                let (columns, weights) = self.row(i);
                let plain = columns
                    .iter()
                    .zip(weights)
                    .fold(DVec3::ZERO, |sum, (&j, &f)| sum + exitance[j as usize] * f64::from(f));
                match self.overlay_row(i) {
                    [] => plain,
                    row => plain + overlay_view::gather(row, exitance),
                }
            })
            .collect()
    }
}

/// The luxel intervals that a hemicube shows from nearby.
#[derive(Default)]
struct Near {
    /// Cells beyond this depth are too wide to tell intervals apart; 0 if they are not wanted.
    reach: f32,
    /// Sum for each interval; zero outside a call of `look`.
    sums: Vec<f32>,
    row: Vec<(u32, f64)>,
}

/// Turns hemicubes into sums over patches. Holds the buffers that are reused.
pub struct Gatherer<'a> {
    tracer: &'a Tracer,
    patches: &'a PatchSet,
    delta: &'a DeltaFormFactors,
    buffer: ItemBuffer,
    /// Sum for each patch; zero outside a call of `look`.
    sums: Vec<f64>,
    row: Vec<(PatchId, f64)>,
    near: Near,
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
            row: Vec::new(),
            near: Near::default(),
            overlay: OverlayView::new(patches),
        }
    }

    /// The same without what an overlay adds.
    pub fn without_overlay(mut self) -> Self {
        self.overlay = None;
        self
    }

    /// The same, but it also tells apart the `intervals` luxel intervals of the map, of which a luxel is
    /// `luxel` world units wide: see [`intervals`](Self::intervals).
    pub fn with_intervals(mut self, intervals: usize, luxel: f32) -> Self {
        let width = self.buffer.size().width() as f32;
        self.near =
            Near { reach: 0.5 * width * luxel, sums: vec![0.0; intervals], row: Vec::new() };
        self
    }

    /// Draws the hemicube of `view`; the other functions tell what it shows.
    pub fn look(&mut self, view: &View) {
        self.buffer.draw(self.tracer, view);
        self.row.clear();
        let (sums, row) = (&mut self.sums, &mut self.row);
        let near = &mut self.near;
        let (reach, fine, fine_row) = (near.reach, &mut near.sums, &mut near.row);
        fine_row.clear();
        let seen = (&self.buffer, self.tracer, self.patches, self.delta);
        for_each_patch(seen, view, reach, |patch, interval, f| {
            let sum = &mut sums[patch.0 as usize];
            if *sum == 0.0 {
                row.push((patch, 0.0));
            }
            *sum += f64::from(f);
            if let Some(interval) = interval {
                let sum = &mut fine[interval as usize];
                if *sum == 0.0 {
                    fine_row.push((interval, 0.0));
                }
                *sum += f;
            }
        });
        fine_row.sort_unstable_by_key(|&(interval, _)| interval);
        for (interval, f) in fine_row.iter_mut() {
            *f = std::mem::take(&mut fine[*interval as usize]).into();
        }
        row.sort_unstable_by_key(|&(patch, _)| patch);
        for (patch, f) in row.iter_mut() {
            *f = std::mem::take(&mut sums[patch.0 as usize]);
        }
        if let Some(overlay) = &mut self.overlay {
            let (buffer, tracer, patches, delta) = seen;
            overlay.look(Shown { buffer, tracer, patches, delta }, view);
        }
    }

    /// What an overlay adds to [`row`](Self::row), as [`Transfers::overlay_row`] has it; `None` without.
    fn overlay_row(&self) -> Option<Vec<(u32, Vec3)>> {
        let row = self.overlay.as_ref()?.row();
        Some(row.iter().map(|&(patch, f)| (patch.0, f.as_vec3())).collect())
    }

    /// Form factors from the point looked from to all patches seen, in ascending order of patch.
    pub fn row(&self) -> &[(PatchId, f64)] {
        &self.row
    }

    /// Form factors from the point looked from to the luxel intervals that are near enough to be told
    /// apart, by ascending number of the interval; part of what [`row`](Self::row) has.
    pub fn intervals(&self) -> &[(u32, f64)] {
        &self.near.row
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
        for &(patch, f) in self.overlay.iter().flat_map(OverlayView::row) {
            for (sum, style) in out.iter_mut().zip(exitance) {
                *sum += style[patch.0 as usize].as_dvec3() * f;
            }
        }
    }

    /// Harmonic mean of the distances to what is seen, weighted by form factor, in world units;
    /// infinite when nothing is seen. Irradiance varies over lengths of this order (G. Ward, F.
    /// Rubinstein and R. Clear, "A ray tracing solution for diffuse interreflection", 1988).
    pub fn openness(&self) -> f32 {
        let mut inverse = 0.0;
        self.buffer.for_each_row(|cells| {
            let from = (cells.y * self.buffer.size().width() + cells.x) as usize;
            let weights = &self.delta.over_length(cells.side)[from..];
            inverse += cells.nearness.iter().zip(weights).map(|(n, w)| n * w).sum::<f32>();
        });
        1.0 / inverse
    }
}

/// Calls `visit(patch, luxel interval, form factor)` for every cell or run of cells that shows the front
/// of a patch; intervals are told up to depth `reach`.
fn for_each_patch(
    (buffer, tracer, patches, delta): (&ItemBuffer, &Tracer, &PatchSet, &DeltaFormFactors),
    view: &View,
    reach: f32,
    mut visit: impl FnMut(PatchId, Option<u32>, f32),
) {
    let size = buffer.size();
    buffer.for_each_row(|cells| {
        let weights = &delta.of(cells.side)[(cells.y * size.width() + cells.x) as usize..];
        let mut from = 0;
        while from < cells.items.len() {
            let item = cells.items[from];
            let run = cells.items[from..].iter().take_while(|&&i| i == item).count();
            let (first, to) = (from, from + run);
            from = to;
            if item == Cells::NOTHING {
                continue;
            }
            let division = patches.lookup.polygon(item);
            if matches!(division, PolygonPatches::None) {
                continue;
            }
            let polygon = &tracer.polygons()[item as usize];
            if polygon.normal.dot(view.position - polygon.vertices[0]) <= 0.0 {
                continue;
            }
            match division {
                PolygonPatches::None => {}
                PolygonPatches::Whole(patch) => {
                    visit(*patch, None, weights[first..to].iter().sum());
                }
                PolygonPatches::Grid(grid) => {
                    // Luxel coordinates along the ray: at the eye, plus direction / nearness.
                    let [a, b, c] = view.axes(cells.side);
                    let at = size.cell_centre(cells.side, cells.x, cells.y);
                    let next = size.cell_centre(cells.side, cells.x + 1, cells.y).x - at.x;
                    let start = c + b * at.y + a * at.x;
                    let linear = |row: Vec4| {
                        let r = row.truncate();
                        (r.dot(view.position) + row.w, r.dot(start), r.dot(a) * next)
                    };
                    let (s, t) = (linear(grid.s_row), linear(grid.t_row));
                    let cells = cells.nearness.iter().zip(weights).enumerate();
                    for (i, (near, weight)) in cells.take(to).skip(first) {
                        let depth = 1.0 / near;
                        let column = s.0 + (s.1 + s.2 * i as f32) * depth;
                        let row = t.0 + (t.1 + t.2 * i as f32) * depth;
                        let interval = (depth < reach).then(|| grid.interval(column, row));
                        visit(grid.at(column, row), interval, *weight);
                    }
                }
            }
        }
    });
}
