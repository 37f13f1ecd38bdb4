//! From a polygon of the scene, and a point on it, to the patch there.

use super::PatchId;
use glam::{Vec3, Vec4};

/// The patches of each polygon of a scene's tracer.
#[derive(Clone, Debug, Default)]
pub struct PatchLookup {
    polygons: Vec<PolygonPatches>,
}

/// How a polygon is divided.
#[derive(Clone, Debug)]
pub enum PolygonPatches {
    /// It sends no light back.
    None,
    /// It is one patch.
    Whole(PatchId),
    /// It is cut along luxel coordinates.
    Grid(PatchGrid),
}

/// Patches of a face: blocks of its luxel grid.
#[derive(Clone, Debug)]
pub struct PatchGrid {
    /// World to luxel column: `row.xyz . p + row.w`.
    pub s_row: Vec4,
    /// World to luxel row.
    pub t_row: Vec4,
    /// Block column of each luxel interval.
    pub block_column: Vec<u16>,
    /// Block row of each luxel interval.
    pub block_row: Vec<u16>,
    /// Patch of each block, row by row. Blocks outside the polygon name their nearest neighbour; those in
    /// which an obstacle stands are [`DIVIDED`](Self::DIVIDED).
    pub blocks: Vec<PatchId>,
    /// Blocks in a row.
    pub columns: usize,
    /// The intervals of divided blocks, ascending.
    pub(super) pieces: Vec<Piece>,
    /// Number of the first luxel interval of the face among those of the map: see
    /// [`Detail`](super::Detail).
    pub first_interval: u32,
}

/// A luxel interval of a block that has several patches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// Number of the interval in the face.
    pub interval: u32,
    /// The line that cuts it: coefficients of column, row and 1. All 0 for none.
    pub line: Vec3,
    /// Patches where they sum to 0 or less, and to more.
    pub patches: [PatchId; 2],
}

impl PatchGrid {
    /// Stands for the patch of blocks that have several.
    pub const DIVIDED: PatchId = PatchId(u32::MAX);

    /// Tells all that the grid depends on, as words.
    fn words(&self, word: &mut impl FnMut(u32)) {
        let sizes = [self.block_column.len(), self.block_row.len(), self.blocks.len()];
        let sizes = sizes.into_iter().chain([self.columns, self.pieces.len()]);
        [2, self.first_interval].into_iter().for_each(&mut *word);
        sizes.for_each(|size| word(size as u32));
        let rows = [self.s_row, self.t_row];
        rows.iter().flat_map(Vec4::to_array).for_each(|v| word(v.to_bits()));
        let blocks = self.block_column.iter().chain(&self.block_row);
        blocks.for_each(|&block| word(block.into()));
        self.blocks.iter().for_each(|patch| word(patch.0));
        for Piece { interval, line, patches } in &self.pieces {
            let line = line.to_array().map(f32::to_bits);
            [*interval, patches[0].0, patches[1].0].into_iter().chain(line).for_each(&mut *word);
        }
    }

    /// The patch at luxel coordinates; points outside (by rounding) belong to the nearest block.
    pub fn at(&self, s: f32, t: f32) -> PatchId {
        self.of_interval(self.column_and_row(s, t), [s, t])
    }

    /// The patch at luxel coordinates, which are in the luxel interval in this column and row.
    pub fn of_interval(&self, [column, row]: [usize; 2], [s, t]: [f32; 2]) -> PatchId {
        let cell = usize::from(self.block_row[row]) * self.columns;
        let patch = self.blocks[cell + usize::from(self.block_column[column])];
        if patch != Self::DIVIDED {
            return patch;
        }
        let piece = self.piece(row * self.block_column.len() + column);
        let piece = piece.expect("divided blocks list their intervals");
        piece.patches[usize::from(piece.line.dot(Vec3::new(s, t, 1.0)) > 0.0)]
    }

    /// The luxel interval at luxel coordinates.
    fn column_and_row(&self, s: f32, t: f32) -> [usize; 2] {
        // `as` saturates: below 0 and NaN become the first interval.
        [(s as usize).min(self.block_column.len() - 1), (t as usize).min(self.block_row.len() - 1)]
    }

    /// Block of interval number `k` of the face.
    pub(super) fn cell(&self, k: usize) -> usize {
        let (column, row) = (k % self.block_column.len(), k / self.block_column.len());
        usize::from(self.block_row[row]) * self.columns + usize::from(self.block_column[column])
    }

    /// Interval number `k` of the face, if its block is divided.
    pub(super) fn piece(&self, k: usize) -> Option<&Piece> {
        let found = self.pieces.binary_search_by_key(&(k as u32), |p| p.interval);
        found.ok().map(|i| &self.pieces[i])
    }

    /// The patch at a world point.
    pub fn at_point(&self, p: Vec3) -> PatchId {
        self.at(
            self.s_row.truncate().dot(p) + self.s_row.w,
            self.t_row.truncate().dot(p) + self.t_row.w,
        )
    }
}

impl PatchLookup {
    /// A lookup with one entry for each polygon of the tracer.
    pub fn new(polygons: Vec<PolygonPatches>) -> Self {
        Self { polygons }
    }

    /// Tells all that the lookup depends on, as words.
    pub fn words(&self, word: &mut impl FnMut(u32)) {
        for polygon in &self.polygons {
            match polygon {
                PolygonPatches::None => word(0),
                PolygonPatches::Whole(patch) => [1, patch.0].into_iter().for_each(&mut *word),
                PolygonPatches::Grid(grid) => grid.words(word),
            }
        }
    }

    /// The patches of every polygon of the tracer.
    pub fn polygons(&self) -> &[PolygonPatches] {
        &self.polygons
    }

    /// The patches of a polygon of the tracer.
    pub fn polygon(&self, polygon: u32) -> &PolygonPatches {
        &self.polygons[polygon as usize]
    }
}
