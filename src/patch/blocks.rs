//! The blocks of luxel intervals that a face is cut into. Where an obstacle stands in one, it has parts.

use super::cuts::{Line, Luxels, halves};
use super::lookup::Piece;
use super::polygon2::{moments, strip};
use super::{PatchGrid, PatchId};
use crate::scene::{LuxelGrid, Sample, Scene, Surface};
use glam::{DVec2, Vec3};
use std::collections::BTreeMap;

/// Distance of a patch's eye from its surface in world units: where luxels are sampled too.
pub(super) const LIFT: f32 = 1.0;

/// Blocks with a smaller share of a full luxel's area than this join a neighbour.
const SMALLEST: f64 = 1e-3;

/// One block, or a part of it.
#[derive(Clone, Default)]
pub(super) struct Block {
    /// Which block of the grid it is, or is part of.
    cell: usize,
    /// It is one of several parts.
    pub divided: bool,
    /// In square luxels.
    pub area: f64,
    /// Area times centroid, in luxel coordinates.
    pub moment: DVec2,
    /// Luxels and their weights, which sum to 1.
    pub luxels: Vec<(u32, f32)>,
}

/// The blocks of one face.
pub(super) struct FaceBlocks {
    /// The division. Where it should name patches, it names blocks.
    grid: PatchGrid,
    /// Blocks of the grid (of divided ones the first part), and then the other parts.
    blocks: Vec<Block>,
    /// Corner weights of each luxel interval.
    intervals: Vec<[f32; 4]>,
    /// Luxel intervals along a whole block.
    size: u32,
}

impl FaceBlocks {
    /// Cuts a face into blocks of at most `size` luxel intervals a side.
    pub fn cut(scene: &Scene, surface: &Surface, samples: &[Sample], size: u32) -> Option<Self> {
        let luxels = surface.luxels.as_ref()?;
        let size = patch_size(surface, luxels, size);
        let block_column = division(luxels.width - 1, size);
        let block_row = division(luxels.height - 1, size);
        let count = |d: &[u16]| d.last().map_or(0, |&b| b as usize + 1);
        let columns = count(&block_column);
        let cells = columns * count(&block_row);
        let mut face = Self {
            intervals: vec![[0.0; 4]; block_column.len() * block_row.len()],
            grid: PatchGrid {
                s_row: luxels.s_row,
                t_row: luxels.t_row,
                block_column,
                block_row,
                blocks: (0..cells as u32).map(PatchId).collect(),
                columns,
                pieces: Vec::new(),
                intervals: Vec::new(),
                surface: 0,
            },
            blocks: (0..cells).map(|cell| Block { cell, ..Block::default() }).collect(),
            size,
        };
        let outline: Vec<DVec2> =
            surface.vertices.iter().map(|&v| luxels.luxel_of(v).as_dvec2()).collect();
        let luxels = Luxels::new(luxels, samples, surface.normal * LIFT);
        let cuts = luxels.cuts(scene);
        face.divide(&luxels, &cuts);
        face.sum_up(&outline, &luxels, &cuts);
        Some(face)
    }

    /// Divides the blocks whose luxels are not all joined by intervals: something stands between them.
    fn divide(&mut self, luxels: &Luxels<'_>, cuts: &[Option<Line>]) {
        if cuts.iter().all(Option::is_none) && luxels.all_free() {
            return;
        }
        let mut cells = vec![Vec::new(); self.blocks.len()];
        for k in 0..cuts.len() {
            cells[self.grid.cell(k)].push(k);
        }
        for (cell, intervals) in cells.into_iter().enumerate() {
            let mut joined = Joined::default();
            for &k in &intervals {
                halves(cuts[k]).for_each(|half| joined.join(luxels.corners(k, half)));
            }
            let groups = joined.groups();
            if groups.len() < 2 {
                continue;
            }
            let others = self.blocks.len() - 1;
            let block = Block { cell, divided: true, ..Block::default() };
            self.blocks[cell].divided = true;
            self.blocks.resize(others + groups.len(), block);
            self.grid.blocks[cell] = PatchGrid::DIVIDED;
            for k in intervals {
                let part = |half| {
                    let first = luxels.corners(k, half).next().map(|l| joined.first(l));
                    let part = first.map_or(0, |l| groups.partition_point(|&g| g < l));
                    PatchId(if part == 0 { cell } else { others + part } as u32)
                };
                let (low, high) = match cuts[k] {
                    Some(line) => (Some((line, 0)), Some((line, 1))),
                    None => (None, None),
                };
                self.grid.pieces.push(Piece {
                    interval: k as u32,
                    line: cuts[k].map_or(Vec3::ZERO, |line| line.coefficients()),
                    patches: [part(low), part(high)],
                });
            }
        }
        self.grid.pieces.sort_unstable_by_key(|p| p.interval);
    }

    /// Sums up the blocks of a face with this outline, luxel interval by luxel interval.
    fn sum_up(&mut self, outline: &[DVec2], luxels: &Luxels<'_>, cuts: &[Option<Line>]) {
        let columns = self.grid.block_column.len();
        for j in 0..self.grid.block_row.len() {
            let row = strip(outline, 1, j as f64, (j + 1) as f64);
            for i in 0..columns {
                let k = j * columns + i;
                let square = strip(&row, 0, i as f64, (i + 1) as f64);
                let piece = self.grid.piece(k).copied();
                // An obstacle that ends within its block does not divide it.
                for half in halves(cuts[k].filter(|_| piece.is_some())) {
                    let (area, moment) = match half {
                        Some((line, side)) => moments(&line.clip(&square, side)),
                        None => moments(&square),
                    };
                    if area <= 0.0 {
                        continue;
                    }
                    let side = half.map_or(0, |(_, side)| side);
                    let block = piece.map_or(self.grid.cell(k), |p| p.patches[side].0 as usize);
                    let block = &mut self.blocks[block];
                    block.area += area;
                    block.moment += moment;
                    let weights = luxels.weights(k, half, moment / area);
                    if half.is_none() {
                        self.intervals[k] = weights.map(|w| w.1);
                    }
                    let weighed = weights.into_iter().filter(|w| w.1 > 0.0);
                    block.luxels.extend(weighed.map(|(l, w)| (l, w * area as f32)));
                }
            }
        }
        for block in &mut self.blocks {
            settle(&mut block.luxels);
        }
    }

    /// Luxel intervals along a block that the face does not end in, at most.
    pub fn size(&self) -> u32 {
        self.size
    }

    /// Corner weights of each luxel interval; none where an obstacle cuts it.
    pub fn intervals(&self) -> &[[f32; 4]] {
        &self.intervals
    }

    /// The blocks that are large enough to be patches, and the division when the first of them is patch
    /// number `first`. Others join the nearest.
    pub fn into_patches(mut self, first: u32) -> (PatchGrid, impl Iterator<Item = Block>) {
        let kept = |b: &Block| b.area > SMALLEST;
        let mut next = first;
        let numbers: Vec<Option<PatchId>> = self
            .blocks
            .iter()
            .map(|block| {
                let number = kept(block).then_some(PatchId(next));
                next += u32::from(number.is_some());
                number
            })
            .collect();
        let places: Vec<[i64; 2]> = self
            .blocks
            .iter()
            .map(|b| [b.cell % self.grid.columns, b.cell / self.grid.columns].map(|x| x as i64))
            .collect();
        if next == first {
            self.grid.blocks.clear();
            self.grid.pieces.clear();
        }
        let patch = |block: PatchId| nearest(&numbers, &places, block.0 as usize);
        let pieces = self.grid.pieces.iter_mut().flat_map(|p| &mut p.patches);
        for block in self.grid.blocks.iter_mut().chain(pieces) {
            if *block != PatchGrid::DIVIDED {
                *block = patch(*block).expect("there is a patch");
            }
        }
        (self.grid, self.blocks.into_iter().filter(kept))
    }
}

/// Luxels along a patch: `size` of the luxels that the texture gives, whatever the size of those that
/// the map asks for.
fn patch_size(surface: &Surface, luxels: &LuxelGrid, size: u32) -> u32 {
    let Some(vanilla) = &surface.vanilla_luxels else { return size };
    let edge = |grid: &LuxelGrid| grid.s_step.cross(grid.t_step).length().sqrt();
    let size = size as f32 * edge(vanilla) / edge(luxels);
    // Casting limits what is out of range.
    (size.round() as u32).max(1)
}

/// Block of each of `intervals` luxel intervals when they are shared out evenly among the fewest
/// blocks of at most `size`.
fn division(intervals: u32, size: u32) -> Vec<u16> {
    let blocks = intervals.div_ceil(size.max(1));
    (0..intervals)
        .map(|i| (u64::from(i) * u64::from(blocks) / u64::from(intervals)) as u16)
        .collect()
}

/// Merges entries of the same luxel and makes the weights sum to 1.
fn settle(list: &mut Vec<(u32, f32)>) {
    list.sort_by_key(|&(luxel, _)| luxel);
    list.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    let sum: f32 = list.iter().map(|&(_, w)| w).sum();
    for (_, w) in list.iter_mut() {
        *w /= sum;
    }
    list.shrink_to_fit();
}

/// The number of the block nearest to block `from` that has one, the first on ties.
fn nearest(numbers: &[Option<PatchId>], places: &[[i64; 2]], from: usize) -> Option<PatchId> {
    let distance = |b: usize| {
        let ([x, y], [u, v]) = (places[b], places[from]);
        (x - u).pow(2) + (y - v).pow(2)
    };
    numbers[from].or_else(|| {
        let known = (0..numbers.len()).filter_map(|b| Some((distance(b), numbers[b]?)));
        known.min_by_key(|k| k.0).map(|k| k.1)
    })
}

/// Luxels in groups that are joined by intervals.
#[derive(Default)]
struct Joined {
    /// Each luxel and an earlier one of its group; the first is its own.
    earlier: BTreeMap<u32, u32>,
}

impl Joined {
    /// First luxel of the group of a luxel.
    fn first(&self, mut luxel: u32) -> u32 {
        while self.earlier[&luxel] != luxel {
            luxel = self.earlier[&luxel];
        }
        luxel
    }

    /// Joins some luxels.
    fn join(&mut self, luxels: impl Iterator<Item = u32>) {
        let mut one = None;
        for luxel in luxels {
            self.earlier.entry(luxel).or_insert(luxel);
            let (a, b) = (self.first(luxel), self.first(one.unwrap_or(luxel)));
            self.earlier.insert(a.max(b), a.min(b));
            one = Some(a.min(b));
        }
    }

    /// First luxels of all groups, ascending.
    fn groups(&self) -> Vec<u32> {
        self.earlier.iter().filter(|(l, first)| l == first).map(|(&l, _)| l).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_shared_out_evenly() {
        assert_eq!(division(5, 4), [0, 0, 0, 1, 1]);
        assert_eq!(division(8, 4), [0, 0, 0, 0, 1, 1, 1, 1]);
        assert_eq!(division(3, 4), [0, 0, 0]);
        assert!(division(0, 4).is_empty());
        for n in 1..40 {
            let d = division(n, 4);
            for b in 0..=*d.last().unwrap() {
                let members = d.iter().filter(|&&x| x == b).count();
                assert!((1..=4).contains(&members), "{n}: {d:?}");
            }
        }
    }

    #[test]
    fn weights_of_a_luxel_list_sum_to_one() {
        let mut list = vec![(3, 0.5), (1, 1.0), (3, 0.5)];
        settle(&mut list);
        assert_eq!(list, [(1, 0.5), (3, 0.5)]);
    }

    #[test]
    fn dropped_blocks_fall_to_the_nearest_kept() {
        let places: Vec<[i64; 2]> = (0..6).map(|b| [b % 3, b / 3]).collect();
        let numbers = [None, None, Some(PatchId(7)), None, None, Some(PatchId(8))];
        assert_eq!(nearest(&numbers, &places, 0), Some(PatchId(7)));
        assert_eq!(nearest(&numbers, &places, 4), Some(PatchId(8)));
        assert_eq!(nearest(&numbers, &places, 5), Some(PatchId(8)));
        assert_eq!(nearest(&[None], &places, 0), None);
    }

    #[test]
    fn luxels_join_in_groups() {
        let mut joined = Joined::default();
        for group in [&[5, 6][..], &[1, 2], &[], &[9], &[2, 5]] {
            joined.join(group.iter().copied());
        }
        assert_eq!(joined.groups(), [1, 9]);
        assert_eq!([1, 2, 5, 6, 9].map(|l| joined.first(l)), [1, 1, 1, 1, 9]);
    }
}
