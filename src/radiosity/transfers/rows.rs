//! How rows of form factors are kept.

use super::Distances;
use crate::patch::PatchId;
use glam::Vec3;

/// Mean length of runs from which on a row's columns are kept as runs.
const LONG: usize = 8;
/// The longest that a run or the way to it may be.
const LONGEST: u16 = u16::MAX;

/// Rows one after the other, in six bytes an entry or, where many patches beside each other are seen,
/// which mostly have numbers beside each other, little more than four.
#[derive(Default)]
pub(super) struct Chunk {
    pub(super) distances: Vec<Distances>,
    /// Where the entries of each row end in `weights`.
    pub(super) ends: Vec<u32>,
    /// Where what tells the columns of each row ends in `columns`.
    pub(super) column_ends: Vec<u32>,
    /// See [`Columns`].
    pub(super) columns: Vec<u16>,
    pub(super) weights: Vec<f32>,
    /// What an overlay adds to each row; empty without one.
    pub(super) overlay: Vec<Vec<(u32, Vec3)>>,
}

/// The columns of a row, ascending. Runs take fewer numbers than there are entries, the other way at least
/// as many: so they are told apart.
#[derive(Clone, Copy, Debug)]
pub(super) enum Columns<'a> {
    /// How many columns are left out since the run before, and how many follow each other then. What
    /// is too long for one is several.
    Runs(&'a [[u16; 2]]),
    /// The lower half of each column. They are sorted by pages, the upper half; for each page but the first:
    /// at which entry it begins, lower half first.
    Pages { low: &'a [u16], begins: &'a [[u16; 2]] },
}

impl<'a> Columns<'a> {
    fn new(numbers: &'a [u16], entries: usize) -> Self {
        if numbers.len() < entries {
            return Self::Runs(numbers.as_chunks().0);
        }
        let (low, begins) = numbers.split_at(entries);
        Self::Pages { low, begins: begins.as_chunks().0 }
    }
}

/// The entries of each page, from one to another.
pub(super) fn pages(
    entries: usize,
    begins: &[[u16; 2]],
) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
    let begin = |&[low, high]: &[u16; 2]| usize::from(low) | usize::from(high) << 16;
    let from = std::iter::once(0).chain(begins.iter().map(begin));
    let to = begins.iter().map(begin).chain(std::iter::once(entries));
    from.zip(to).map(|(from, to)| from..to)
}

impl Chunk {
    pub(super) fn push(&mut self, row: &[(PatchId, f64)], distances: Distances) {
        self.distances.push(distances);
        let runs = 1 + row.windows(2).filter(|two| two[1].0.0 > two[0].0.0 + 1).count();
        let last = row.last().map_or(0, |(j, _)| j.0 as usize);
        if row.len() >= LONG * (runs + last / usize::from(LONGEST)) {
            self.push_runs(row);
        } else {
            self.push_pages(row);
        }
        self.weights.extend(row.iter().map(|&(_, f)| f as f32));
        self.ends.push(self.weights.len() as u32);
        self.column_ends.push(self.columns.len() as u32);
    }

    fn push_runs(&mut self, row: &[(PatchId, f64)]) {
        let (mut next, mut run) = (0, [0, 0]);
        for &(j, _) in row {
            let mut skip = j.0 - next;
            next = j.0 + 1;
            if run[1] > 0 && (skip > 0 || run[1] == LONGEST) {
                self.columns.extend(run);
                run = [0, 0];
            }
            while skip > u32::from(LONGEST) {
                self.columns.extend([LONGEST, 0]);
                skip -= u32::from(LONGEST);
            }
            run = [run[0] + skip as u16, run[1] + 1];
        }
        self.columns.extend(run);
    }

    fn push_pages(&mut self, row: &[(PatchId, f64)]) {
        self.columns.extend(row.iter().map(|(j, _)| j.0 as u16));
        let last = row.last().map_or(0, |(j, _)| j.0 >> 16);
        for page in 1..=last {
            let begin = row.partition_point(|(j, _)| j.0 >> 16 < page);
            self.columns.extend([begin as u16, (begin >> 16) as u16]);
        }
    }

    /// Columns and weights of a row.
    pub(super) fn row(&self, i: usize) -> (Columns<'_>, &[f32]) {
        let range = |ends: &[u32]| {
            let from = if i == 0 { 0 } else { ends[i - 1] as usize };
            from..ends[i] as usize
        };
        let weights = &self.weights[range(&self.ends)];
        (Columns::new(&self.columns[range(&self.column_ends)], weights.len()), weights)
    }

    /// Columns and weights of a row, one by one.
    pub(super) fn entries(&self, i: usize) -> impl Iterator<Item = (u32, f32)> + '_ {
        let (columns, weights) = self.row(i);
        let (runs, low, begins) = match columns {
            Columns::Runs(runs) => (runs, &[][..], &[][..]),
            Columns::Pages { low, begins } => (&[][..], low, begins),
        };
        let mut column = 0;
        let of_runs = runs.iter().flat_map(move |&[skip, length]| {
            let first = column + u32::from(skip);
            column = first + u32::from(length);
            first..column
        });
        let of_pages = (0..).zip(pages(low.len(), begins)).flat_map(move |(page, entries)| {
            low[entries].iter().map(move |&low| page << 16 | u32::from(low))
        });
        of_runs.chain(of_pages).zip(weights.iter().copied())
    }

    /// Whether the columns of a row are as many as its entries, ascend and are below `patches`.
    pub(super) fn is_whole(&self, i: usize, patches: usize) -> bool {
        let (columns, weights) = self.row(i);
        match columns {
            Columns::Runs(runs) => {
                let sum = |k: usize| runs.iter().map(|run| u64::from(run[k])).sum::<u64>();
                sum(1) == weights.len() as u64 && sum(0) + sum(1) <= patches as u64
            }
            Columns::Pages { begins, .. } => {
                // No page may end before it begins, or beyond the entries.
                let sorted = pages(weights.len(), begins).all(|p| p.start <= p.end);
                let ascending = || self.entries(i).map(|(j, _)| j).is_sorted_by(|a, b| a < b);
                let last = || self.entries(i).last().map_or(0, |(j, _)| j as usize + 1);
                let known = begins.len() <= patches.saturating_sub(1) >> 16;
                known && sorted && ascending() && last() <= patches
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_however_far_apart_their_columns_are() {
        const PATCHES: usize = 700_001;
        let far = vec![0, 1, 65_535, 65_536, 131_070 + 65_534, 500_000, 500_001];
        let long: Vec<u32> = (3..80_000).chain(90_000..170_000).chain(400_000..700_000).collect();
        let next_page: Vec<u32> = (0..65_536).step_by(2).chain([65_537, 65_538]).collect();
        let short_far = (600_000..600_009).collect();
        let rows = [far, vec![], vec![65_535], long, vec![700_000], next_page, short_far];
        let mut chunk = Chunk::default();
        let distances = Distances { openness: 1.0, nearest: 1.0 };
        let weight = |j: u32| 1.0 / f64::from(j % 7 + 2);
        for row in &rows {
            let row: Vec<_> = row.iter().map(|&j| (PatchId(j), weight(j))).collect();
            chunk.push(&row, distances);
        }
        let light: Vec<[[f64; 1]; 1]> = (0..PATCHES).map(|j| [[j as f64]]).collect();
        for (i, row) in rows.iter().enumerate() {
            let expected: Vec<_> = row.iter().map(|&j| (j, weight(j) as f32)).collect();
            assert_eq!(chunk.entries(i).collect::<Vec<_>>(), expected);
            let sum: f64 = expected.iter().map(|&(j, f)| f64::from(j) * f64::from(f)).sum();
            assert!((chunk.sum(i, &light)[0][0] - sum).abs() <= 1e-9 * sum, "row {i}");
            assert!(chunk.is_whole(i, PATCHES), "row {i}");
            let last = row.last().map_or(0, |&j| j as usize);
            assert!(last == 0 || !chunk.is_whole(i, last), "row {i} has a patch too many");
        }
        let runs = |i: usize| matches!(chunk.row(i).0, Columns::Runs(_));
        assert_eq!(rows.iter().enumerate().filter(|(i, _)| runs(*i)).count(), 1);
        assert!(runs(3));
        let bytes = 4 * chunk.weights.len() + 2 * chunk.columns.len();
        assert!(bytes as f64 <= 6.001 * chunk.weights.len() as f64, "{bytes} bytes");
    }
}
