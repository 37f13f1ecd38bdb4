//! Light over rows of form factors: what patches receive of each other.

use super::rows::{BLOCK, Chunk, PAGE, Tile, part};
use super::weights::{Weight, Weights};
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
    /// rows are read once for several. Glows of the overlay come after the patches; without them, they are
    /// dark.
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
        let mut light = vec![[[0.0; C]; S]; padded(columns)];
        let of = |list: &[[f64; C]], j: usize| list.get(j).copied().unwrap_or([0.0; C]);
        let known = light[..columns].par_iter_mut().enumerate().with_min_len(PIECE);
        known.for_each(|(j, light)| *light = lists.map(|list| of(list, j)));
        let rows: Vec<Vec<[[f64; C]; S]>> = self
            .chunks
            .par_iter()
            .map(|chunk| {
                let mut rows = chunk.sums(&light);
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

/// How much light lists of so many columns are made to hold: whole blocks; whole pages where that is no more
/// than four times as much, as no column of a page has to be checked then.
fn padded(patches: usize) -> usize {
    let pages = patches.next_multiple_of(PAGE);
    if pages <= 4 * patches { pages } else { patches.next_multiple_of(BLOCK) }
}

impl Chunk {
    /// Sums of weight times light over each row. `light` is as long as [`padded`] says.
    pub(super) fn sums<const C: usize, const S: usize>(
        &self,
        light: &[[[f64; C]; S]],
    ) -> Vec<[[f64; C]; S]> {
        let mut sums = vec![[[0.0; C]; S]; self.rows()];
        for (tile, light) in self.tiles.iter().zip(light.chunks(self.width())) {
            match &tile.weights {
                Weights::Single(weights) => tile.add_sums(weights, light, &mut sums),
                Weights::Short(weights) => tile.add_sums(weights, light, &mut sums),
            }
        }
        sums
    }
}

impl Tile {
    /// Adds the sums over the part of each row in this tile; `light` begins where it does.
    fn add_sums<W: Weight, const C: usize, const S: usize>(
        &self,
        weights: &[W],
        light: &[[[f64; C]; S]],
        sums: &mut [[[f64; C]; S]],
    ) {
        let page: Option<&[_; PAGE]> = light.try_into().ok();
        for (i, sum) in sums.iter_mut().enumerate() {
            let range = part(&self.ends, i);
            let weights = &weights[range.clone()];
            let mut parts = Parts::default();
            if self.run_ends.is_empty() {
                let columns = &self.columns[range];
                match page {
                    Some(light) => parts.add_columns(weights, columns, |j| &light[usize::from(j)]),
                    None => parts.add_columns(weights, columns, |j| &light[usize::from(j)]),
                }
            } else {
                parts.add_blocks(weights, self.runs(i), light.as_chunks().0);
            }
            add(sum, &parts.sum().map(|s| s.map(|s| s * W::SCALE)));
        }
    }
}

/// Several sums at a time: each addition would wait for the one before.
struct Parts<const C: usize, const S: usize>([[[f64; C]; S]; PARTS]);

/// More would not fit into a processor's registers with three channels.
const PARTS: usize = 4;

impl<const C: usize, const S: usize> Default for Parts<C, S> {
    fn default() -> Self {
        Self([[[0.0; C]; S]; PARTS])
    }
}

impl<const C: usize, const S: usize> Parts<C, S> {
    /// Adds weights times the light of as many columns.
    #[inline]
    fn add_columns<'a, W: Weight>(
        &mut self,
        weights: &[W],
        columns: &[u16],
        light: impl Fn(u16) -> &'a [[f64; C]; S],
    ) {
        let (columns, last) = columns.as_chunks::<PARTS>();
        let (weights, own_last) = weights.as_chunks::<PARTS>();
        for (columns, weights) in columns.iter().zip(weights) {
            for k in 0..PARTS {
                add_scaled(&mut self.0[k], light(columns[k]), weights[k]);
            }
        }
        for (&column, &weight) in last.iter().zip(own_last) {
            add_scaled(&mut self.0[0], light(column), weight);
        }
    }

    /// Adds weights times the light of runs of blocks.
    #[inline]
    fn add_blocks<W: Weight>(
        &mut self,
        weights: &[W],
        runs: &[[u16; 2]],
        light: &[[[[f64; C]; S]; BLOCK]],
    ) {
        let (mut weights, _) = weights.as_chunks::<BLOCK>();
        let mut light = light;
        for &[skip, count] in runs {
            let (own, rest) = weights.split_at(count.into());
            let (blocks, beyond) = light[usize::from(skip)..].split_at(count.into());
            (weights, light) = (rest, beyond);
            for (weights, light) in own.iter().zip(blocks) {
                for k in 0..BLOCK {
                    add_scaled(&mut self.0[k % PARTS], &light[k], weights[k]);
                }
            }
        }
    }

    fn sum(self) -> [[f64; C]; S] {
        let [mut a, b, mut c, d] = self.0;
        add(&mut a, &b);
        add(&mut c, &d);
        add(&mut a, &c);
        a
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

#[inline]
fn add_scaled<W: Weight, const C: usize, const S: usize>(
    sum: &mut [[f64; C]; S],
    light: &[[f64; C]; S],
    weight: W,
) {
    let weight = weight.unscaled();
    for (sum, light) in sum.as_flattened_mut().iter_mut().zip(light.as_flattened()) {
        *sum += light * weight;
    }
}

fn add<const C: usize, const S: usize>(sum: &mut [[f64; C]; S], more: &[[f64; C]; S]) {
    for (sum, more) in sum.as_flattened_mut().iter_mut().zip(more.as_flattened()) {
        *sum += more;
    }
}
