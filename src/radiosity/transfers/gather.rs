//! Light over rows of form factors: what patches receive of each other.

use super::rows::{Chunk, Columns, pages};
use super::{CHUNK, Transfers};
use crate::scene::effects::COMPILED;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Lists of light that one reading of the rows serves; more keep the processor's registers too busy.
pub(in crate::radiosity) const AT_A_TIME: usize = 4;

/// Patches copied as one piece.
const PIECE: usize = 4096;

impl Transfers {
    /// Irradiance at each patch when patch j has exitance `exitance[j]`: E_i = sum_j F_ij M_j.
    pub fn gather(&self, exitance: &[DVec3]) -> Vec<DVec3> {
        let exitance: Vec<[f64; 3]> = exitance.iter().map(DVec3::to_array).collect();
        let mut received = self.gather_all(&[&exitance]);
        received.pop().into_iter().flatten().map(DVec3::from_array).collect()
    }

    /// The same for many lists of exitance of `C` channels, 1 to 3. Each comes out as if it were alone;
    /// rows are read once for several. Glows of the overlay come after the patches; without them, they are dark.
    pub fn gather_all<const C: usize>(&self, exitance: &[&[[f64; C]]]) -> Vec<Vec<[f64; C]>> {
        let some = |lists: &[&[[f64; C]]]| match *lists {
            [] => Vec::new(),
            [a] => self.gather_some([a]),
            [a, b] => self.gather_some([a, b]),
            [a, b, c] => self.gather_some([a, b, c]),
            [a, b, c, d, ..] => self.gather_some([a, b, c, d]),
        };
        exitance.chunks(AT_A_TIME).flat_map(some).collect()
    }

    fn gather_some<const C: usize, const S: usize>(
        &self,
        lists: [&[[f64; C]]; S],
    ) -> Vec<Vec<[f64; C]>> {
        // Side by side in memory, as they are read.
        let glows = self.overlay.as_deref().map_or(0, |overlay| overlay.glows().len());
        let columns = self.rows() + glows;
        let side_by_side = (0..columns).into_par_iter().with_min_len(PIECE);
        let of = |list: &[[f64; C]], j: usize| list.get(j).copied().unwrap_or([0.0; C]);
        let light: Vec<[[f64; C]; S]> =
            side_by_side.map(|j| lists.map(|list| of(list, j))).collect();
        let rows: Vec<Vec<[[f64; C]; S]>> = self
            .chunks
            .par_iter()
            .map(|chunk| {
                let mut rows: Vec<_> =
                    (0..chunk.ends.len()).map(|i| chunk.sum(i, &light)).collect();
                let overlay = if COMPILED { &chunk.overlay[..] } else { &[] };
                for (sum, row) in rows.iter_mut().zip(overlay) {
                    add(sum, &overlay_sum(row, &light));
                }
                rows
            })
            .collect();
        let row = |at: u32| &rows[at as usize / CHUNK][at as usize % CHUNK];
        let of_patches = || self.row_of.par_iter().with_min_len(PIECE);
        (0..S).map(|s| of_patches().map(|&at| row(at)[s]).collect()).collect()
    }

    /// What an overlay adds to form factors, all of it.
    pub(in crate::radiosity) fn overlay(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.chunks.iter().flat_map(|c| &c.overlay).flatten().map(|&(_, f)| f)
    }
}

impl Chunk {
    /// Sum of weight times light over a row.
    pub(super) fn sum<const C: usize, const S: usize>(
        &self,
        i: usize,
        light: &[[[f64; C]; S]],
    ) -> [[f64; C]; S] {
        let (columns, mut weights) = self.row(i);
        // Several sums at a time: each addition would wait for the one before.
        let mut sums = [[[0.0; C]; S]; 4];
        match columns {
            Columns::Runs(runs) => {
                let mut column = 0;
                for &[skip, length] in runs {
                    let (first, length) = (column + usize::from(skip), usize::from(length));
                    column = first + length;
                    let (own, rest) = weights.split_at(length);
                    weights = rest;
                    add_products(&mut sums, own, &light[first..column], |light| light);
                }
            }
            Columns::Pages { low, begins } => {
                for (page, entries) in pages(low.len(), begins).enumerate() {
                    let light = &light[page << 16..];
                    let of = |low: &u16| &light[usize::from(*low)];
                    add_products(&mut sums, &weights[entries.clone()], &low[entries], of);
                }
            }
        }
        let [mut a, b, mut c, d] = sums;
        add(&mut a, &b);
        add(&mut c, &d);
        add(&mut a, &c);
        a
    }
}

/// Adds weights times the light of as many columns to four sums in turn.
#[inline]
fn add_products<'a, T, const C: usize, const S: usize>(
    sums: &mut [[[f64; C]; S]; 4],
    weights: &[f32],
    columns: &'a [T],
    light: impl Fn(&'a T) -> &'a [[f64; C]; S],
) {
    let (by_four, last) = columns.as_chunks::<4>();
    let (own_by_four, own_last) = weights.as_chunks::<4>();
    for (columns, weights) in by_four.iter().zip(own_by_four) {
        for k in 0..4 {
            add_scaled(&mut sums[k], light(&columns[k]), weights[k]);
        }
    }
    for ((sum, column), &weight) in sums.iter_mut().zip(last).zip(own_last) {
        add_scaled(sum, light(column), weight);
    }
}

/// Sum over what an overlay adds to a row.
fn overlay_sum<const C: usize, const S: usize>(
    row: &[(u32, Vec3)],
    light: &[[[f64; C]; S]],
) -> [[f64; C]; S] {
    let mut sum = [[0.0; C]; S];
    for &(j, f) in row {
        for (sum, light) in sum.iter_mut().zip(&light[j as usize]) {
            for (c, (sum, light)) in sum.iter_mut().zip(light).enumerate() {
                *sum += light * f64::from(f[c]);
            }
        }
    }
    sum
}

fn add_scaled<const C: usize, const S: usize>(
    sum: &mut [[f64; C]; S],
    light: &[[f64; C]; S],
    weight: f32,
) {
    let weight = f64::from(weight);
    for (sum, light) in sum.as_flattened_mut().iter_mut().zip(light.as_flattened()) {
        *sum += light * weight;
    }
}

fn add<const C: usize, const S: usize>(sum: &mut [[f64; C]; S], more: &[[f64; C]; S]) {
    for (sum, more) in sum.as_flattened_mut().iter_mut().zip(more.as_flattened()) {
        *sum += more;
    }
}
