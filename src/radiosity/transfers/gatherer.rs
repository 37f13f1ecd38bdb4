//! Hemicubes turned into sums over patches.

use crate::patch::{PatchId, PatchSet, PolygonPatches};
use crate::radiosity::hemicube::{Cells, DeltaFormFactors, HemicubeSize, ItemBuffer, View};
use crate::radiosity::overlay_view::{OverlayView, Shown};
use crate::scene::Tracer;
use crate::scene::effects::COMPILED;
use glam::{DVec3, Vec3, Vec4};
use wide::{CmpLt, f32x8};

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
            overlay: OverlayView::new(patches).filter(|_| COMPILED),
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
        if let Some(overlay) = self.overlay.as_mut().filter(|_| COMPILED) {
            let (buffer, tracer) = (&self.buffer, self.tracer);
            let (patches, delta) = (self.patches, self.delta);
            overlay.look(Shown { buffer, tracer, patches, delta }, view);
        }
    }

    /// What an overlay adds to what the last look showed, per channel, by ascending patch.
    pub fn overlay(&self) -> &[(PatchId, DVec3)] {
        self.overlay.as_ref().filter(|_| COMPILED).map_or(&[], OverlayView::row)
    }

    /// What an overlay adds to [`row`](Self::row), as [`Transfers::overlay_row`] has it; `None` without.
    pub(super) fn overlay_row(&self) -> Option<Vec<(u32, Vec3)>> {
        let row = self.overlay.as_ref()?.row();
        Some(row.iter().map(|&(patch, f)| (patch.0, f.as_vec3())).collect())
    }

    /// Draws the hemicube of `view` and calls `visit(patch, interval, form factor)` for what it shows, in
    /// a fixed order; patches come up many times. Luxel intervals, of those of the map, are told up to
    /// depth `reach`. Afterwards only [`distances`](Self::distances) and [`overlay`](Self::overlay) know
    /// of this look.
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
    /// Number of the surface.
    pub surface: u32,
    /// Its number on the surface, row by row.
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
                    let along = |row: Vec4| {
                        let r = row.truncate();
                        let slope = STEPS * f32x8::splat(r.dot(a) * next);
                        let along = (f32x8::splat(r.dot(start)) + slope) * depth;
                        along + f32x8::splat(r.dot(view.position) + row.w)
                    };
                    // What is out of range, by rounding, belongs to the last.
                    let interval = |at: f32x8, count: usize| {
                        let last = f32x8::splat((count - 1) as f32);
                        at.fast_max(f32x8::ZERO).fast_min(last).fast_trunc_int().to_array()
                    };
                    let (s, t) = (along(grid.s_row), along(grid.t_row));
                    let columns = grid.block_column.len();
                    let (column, row) = (interval(s, columns), interval(t, grid.block_row.len()));
                    let near = depth.cmp_lt(f32x8::splat(reach)).move_mask();
                    let place = |i: usize| {
                        let number = (row[i] * columns as i32 + column[i]).cast_unsigned();
                        let coordinates = || [s.to_array()[i], t.to_array()[i]];
                        let patch = grid.in_interval(number as usize, coordinates);
                        let interval = Interval { surface: grid.surface, number };
                        (patch, (near >> i & 1 == 1).then_some(interval))
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
