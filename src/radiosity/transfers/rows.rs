//! How rows of form factors are kept.

use super::Distances;
use super::weights::{Precision, Weights};
use crate::patch::PatchId;
use glam::Vec3;
use std::ops::Range;

/// Columns of a block.
pub(super) const BLOCK: usize = 8;
/// Columns of a tile where columns are kept as runs of blocks: the light of so many patches stays in a
/// processor's first cache while the rows of a chunk are read one after the other.
const DENSE: usize = 1024;
/// Columns of a tile where they are kept one by one: as many as two bytes can tell apart.
pub(super) const PAGE: usize = 1 << 16;

/// Rows as they were found, before they are kept.
pub(super) struct Found {
    precision: Precision,
    /// What the row needs that needs most.
    kept: Precision,
    entries: Vec<(u32, f32)>,
    /// Where the entries of each row end.
    ends: Vec<u32>,
    distances: Vec<Distances>,
}

/// Rows, one after the other in each tile of their columns. With single columns that takes little more
/// than two bytes an entry and its weight; less where most patches of most blocks are seen, as those
/// beside each other mostly have numbers beside each other.
#[derive(Default)]
pub(super) struct Chunk {
    pub(super) distances: Vec<Distances>,
    /// Whether columns are kept as runs of blocks.
    pub(super) dense: bool,
    /// By ascending column, up to the last that is seen.
    pub(super) tiles: Vec<Tile>,
    /// What an overlay adds to each row; empty without one.
    pub(super) overlay: Vec<Vec<(u32, Vec3)>>,
}

/// What rows have in one tile.
pub(super) struct Tile {
    /// Where the weights of each row end.
    pub(super) ends: Vec<u32>,
    /// Where the runs of each row end; empty where columns are kept one by one.
    pub(super) run_ends: Vec<u32>,
    /// Columns, counted from the first of the tile, ascending.
    pub(super) columns: Vec<u16>,
    /// How many blocks are left out since the run before, and how many follow each other then.
    pub(super) runs: Vec<[u16; 2]>,
    /// One for each column, of blocks for all that they have: 0 where a patch is not seen.
    pub(super) weights: Weights,
}

impl Found {
    pub(super) fn new(precision: Precision) -> Self {
        let kept = precision;
        Self { precision, kept, entries: Vec::new(), ends: Vec::new(), distances: Vec::new() }
    }

    pub(super) fn push(&mut self, row: &[(PatchId, f64)], distances: Distances) {
        let from = self.entries.len();
        self.entries.extend(row.iter().map(|&(j, f)| (j.0, f as f32)));
        let row = &mut self.entries[from..];
        let precision = self.precision.fit_for(row.iter().map(|e| e.1));
        precision.round(row.iter_mut().map(|(_, f)| f));
        self.kept = self.kept.max(precision);
        self.ends.push(self.entries.len() as u32);
        self.distances.push(distances);
    }

    fn rows(&self) -> impl Iterator<Item = &[(u32, f32)]> {
        (0..self.ends.len()).map(|i| &self.entries[part(&self.ends, i)])
    }

    /// Keeps them in whichever way takes less.
    pub(super) fn keep(self) -> Chunk {
        let block = |two: &[(u32, f32)], k: usize| two[k].0 as usize / BLOCK;
        let blocks =
            |row: &[(u32, f32)]| 1 + row.windows(2).filter(|r| block(r, 0) != block(r, 1)).count();
        let (blocks, weight) = (self.rows().map(blocks).sum::<usize>(), self.kept.bytes());
        // At most, as if each block were a run.
        let in_blocks = blocks * (BLOCK * weight + size_of::<[u16; 2]>());
        let dense = in_blocks < self.entries.len() * (weight + size_of::<u16>());
        let columns = self.entries.iter().map(|e| e.0 as usize + 1).max().unwrap_or(0);
        let mut chunk = Chunk { dense, ..Chunk::default() };
        for first in (0..columns).step_by(chunk.width()) {
            let mut tile = Tile::new(self.kept);
            for row in self.rows() {
                let at = |column: usize| row.partition_point(|e| (e.0 as usize) < column);
                tile.push(&row[at(first)..at(first + chunk.width())], first as u32, dense);
            }
            tile.weights.shrink_to_fit();
            tile.columns.shrink_to_fit();
            tile.runs.shrink_to_fit();
            chunk.tiles.push(tile);
        }
        chunk.distances = self.distances;
        chunk
    }
}

impl Chunk {
    /// Number of rows.
    pub(super) fn rows(&self) -> usize {
        self.distances.len()
    }

    /// Columns of a tile.
    pub(super) fn width(&self) -> usize {
        if self.dense { DENSE } else { PAGE }
    }

    /// Number of entries.
    pub(super) fn len(&self) -> usize {
        let seen = |tile: &Tile| match self.dense {
            true => tile.weights.range(0..tile.weights.len()).filter(|&f| f != 0.0).count(),
            false => tile.columns.len(),
        };
        self.tiles.iter().map(seen).sum()
    }

    /// Bytes that it takes, without what an overlay adds.
    pub(super) fn bytes(&self) -> usize {
        let tiles: usize = self.tiles.iter().map(Tile::bytes).sum();
        tiles + size_of_val(&self.distances[..]) + size_of::<Self>()
    }

    /// Columns and weights of a row.
    pub(super) fn entries(&self, i: usize) -> impl Iterator<Item = (u32, f32)> + '_ {
        let firsts = (0..).step_by(self.width());
        firsts.zip(&self.tiles).flat_map(move |(first, tile)| {
            tile.entries(i).map(move |(column, weight)| (first + column, weight))
        })
    }

    /// Whether the tiles hold as many weights as columns of each row, and these ascend and are below
    /// `patches`.
    pub(super) fn is_whole(&self, patches: usize) -> bool {
        let (rows, width) = (self.rows(), self.width());
        let columns = patches.next_multiple_of(BLOCK);
        let whole = |(first, tile): (usize, &Tile)| {
            let room = columns.saturating_sub(first).min(width) / BLOCK;
            tile.is_whole(rows, self.dense) && (0..rows).all(|i| tile.row_is_whole(i, room))
        };
        self.tiles.len() <= patches.div_ceil(width)
            && (0..).step_by(width).zip(&self.tiles).all(whole)
            && (0..rows).all(|i| self.entries(i).all(|(j, _)| (j as usize) < patches))
    }

    /// Damage for tests: nothing is seen in a row.
    #[cfg(test)]
    pub(super) fn clear_row(&mut self, i: usize) {
        for tile in &mut self.tiles {
            part(&tile.ends, i).for_each(|at| tile.weights.set(at, 0.0));
        }
    }
}

impl Tile {
    fn new(precision: Precision) -> Self {
        let weights = Weights::new(precision);
        let [ends, run_ends] = [Vec::new(), Vec::new()];
        Self { ends, run_ends, columns: Vec::new(), runs: Vec::new(), weights }
    }

    /// Adds what a row has in the tile that begins at column `first`.
    fn push(&mut self, row: &[(u32, f32)], first: u32, dense: bool) {
        if dense {
            self.push_blocks(row, first);
        } else {
            self.columns.extend(row.iter().map(|(j, _)| (j - first) as u16));
            self.weights.extend(row.iter().map(|&(_, f)| f));
        }
        self.ends.push(self.weights.len() as u32);
    }

    fn push_blocks(&mut self, row: &[(u32, f32)], first: u32) {
        let begin = self.runs.len();
        let mut next = 0;
        for &(j, f) in row {
            let (block, place) = ((j - first) as usize / BLOCK, (j - first) as usize % BLOCK);
            let begins = self.runs.len() == begin;
            if begins || block >= next {
                if begins || block > next {
                    self.runs.push([(block - next) as u16, 0]);
                }
                self.runs.last_mut().expect("there is one")[1] += 1;
                self.weights.extend([0.0; BLOCK].into_iter());
                next = block + 1;
            }
            self.weights.set(self.weights.len() - BLOCK + place, f);
        }
        self.run_ends.push(self.runs.len() as u32);
    }

    fn bytes(&self) -> usize {
        let ends = size_of_val(&self.ends[..]) + size_of_val(&self.run_ends[..]);
        let columns = size_of_val(&self.columns[..]) + size_of_val(&self.runs[..]);
        size_of::<Self>() + ends + columns + self.weights.bytes()
    }

    /// The runs of a row.
    pub(super) fn runs(&self, i: usize) -> &[[u16; 2]] {
        if self.run_ends.is_empty() { &[] } else { &self.runs[part(&self.run_ends, i)] }
    }

    /// Columns that are kept one by one, and weights of a row, which are more with runs.
    fn entries(&self, i: usize) -> impl Iterator<Item = (u32, f32)> + '_ {
        let weights = part(&self.ends, i);
        let columns = if self.run_ends.is_empty() { &self.columns[weights.clone()] } else { &[] };
        let mut next = 0;
        let in_runs = self.runs(i).iter().flat_map(move |&[skip, count]| {
            let from = next + u32::from(skip);
            next = from + u32::from(count);
            from * BLOCK as u32..next * BLOCK as u32
        });
        let dense = !self.run_ends.is_empty();
        let columns = columns.iter().map(|&column| u32::from(column)).chain(in_runs);
        columns.zip(self.weights.range(weights)).filter(move |&(_, f)| !dense || f != 0.0)
    }

    /// Whether lists are as long as they say.
    fn is_whole(&self, rows: usize, dense: bool) -> bool {
        let are_whole = |ends: &[u32], rows: usize, count: usize| {
            let last = ends.last().copied().unwrap_or(0) as usize;
            ends.len() == rows && ends.is_sorted() && last == count
        };
        let run_rows = if dense { rows } else { 0 };
        let columns = if dense { 0 } else { self.weights.len() };
        are_whole(&self.ends, rows, self.weights.len())
            && are_whole(&self.run_ends, run_rows, self.runs.len())
            && self.columns.len() == columns
    }

    /// Whether a row has as many columns as weights, which ascend, and its blocks have `room`.
    fn row_is_whole(&self, i: usize, room: usize) -> bool {
        let weights = part(&self.ends, i);
        if self.run_ends.is_empty() {
            return self.columns[weights].is_sorted_by(|a, b| a < b);
        }
        let sum = |k: usize| self.runs(i).iter().map(|run| usize::from(run[k])).sum::<usize>();
        sum(1) * BLOCK == weights.len() && sum(0) + sum(1) <= room
    }
}

/// Where what belongs to a row is, with the ends of all.
pub(super) fn part(ends: &[u32], i: usize) -> Range<usize> {
    let from = if i == 0 { 0 } else { ends[i - 1] };
    from as usize..ends[i] as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATCHES: usize = 700_001;

    fn weight(j: u32) -> f64 {
        0.1 / f64::from(j % 7 + 2)
    }

    fn kept(rows: &[Vec<u32>], precision: Precision) -> Chunk {
        let mut found = Found::new(precision);
        let distances = Distances { openness: 1.0, nearest: 1.0 };
        for row in rows {
            let row: Vec<_> = row.iter().map(|&j| (PatchId(j), weight(j))).collect();
            found.push(&row, distances);
        }
        found.keep()
    }

    /// Bytes of an entry with all that a chunk takes besides.
    fn bytes(chunk: &Chunk) -> f64 {
        chunk.bytes() as f64 / chunk.len() as f64
    }

    #[test]
    fn rows_come_back_however_far_apart_their_columns_are() {
        let far = vec![0, 1, 65_535, 65_536, 131_070 + 65_534, 500_000, 500_001];
        let long: Vec<u32> = (3..80_000).chain(90_000..170_000).chain(400_000..700_000).collect();
        let next_page: Vec<u32> = (0..65_536).step_by(2).chain([65_537, 65_538]).collect();
        let short_far = (600_000..600_009).collect();
        let scattered = (0..PATCHES as u32).step_by(977).collect();
        let sparse = vec![far, vec![], vec![65_535], scattered, vec![700_000], short_far];
        let dense = vec![vec![], long, vec![700_000], next_page, vec![7, 8]];
        let light: Vec<[[f64; 1]; 1]> =
            (0..PATCHES.next_multiple_of(BLOCK)).map(|j| [[j as f64]]).collect();
        for (rows, is_dense) in [(sparse, false), (dense, true)] {
            for precision in [Precision::Single, Precision::Short] {
                let chunk = kept(&rows, precision);
                assert_eq!((chunk.dense, chunk.rows()), (is_dense, rows.len()));
                let sums = chunk.sums(&light);
                for (i, row) in rows.iter().enumerate() {
                    let entries: Vec<_> = chunk.entries(i).collect();
                    assert_eq!(entries.iter().map(|e| e.0).collect::<Vec<_>>(), *row);
                    let error = if precision == Precision::Single { 1e-7 } else { 5e-4 };
                    assert!(
                        entries
                            .iter()
                            .all(|&(j, f)| (f64::from(f) / weight(j) - 1.0).abs() < error)
                    );
                    let sum: f64 = entries.iter().map(|&(j, f)| f64::from(j) * f64::from(f)).sum();
                    assert!((sums[i][0][0] - sum).abs() <= 1e-9 * sum, "row {i}");
                }
                assert_eq!(chunk.len(), rows.iter().map(Vec::len).sum::<usize>());
                assert!(chunk.is_whole(PATCHES) && !chunk.is_whole(PATCHES - 1));
            }
        }
    }

    #[test]
    fn an_entry_takes_little_more_than_its_column_and_weight() {
        let scattered = |i: u32| (0..150).map(|k| i + 7 * k * (k % 5 + 1)).collect::<Vec<u32>>();
        let mut sparse: Vec<Vec<u32>> = (0..32).map(scattered).collect();
        sparse.iter_mut().for_each(|row| row.sort_unstable());
        sparse.iter_mut().for_each(Vec::dedup);
        let half: Vec<Vec<u32>> =
            (0..32).map(|i| (i..3000).filter(|j| j % 40 < 36).collect()).collect();
        for (rows, single, short) in [(&sparse, 6.2, 4.2), (&half, 4.7, 2.5)] {
            let of = |precision| bytes(&kept(rows, precision));
            let [single_bytes, short_bytes] = [of(Precision::Single), of(Precision::Short)];
            assert!(single_bytes < single && short_bytes < short, "{single_bytes} {short_bytes}");
        }
    }
}
