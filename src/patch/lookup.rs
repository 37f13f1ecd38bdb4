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
    /// Patch of each block, row by row. Blocks outside the polygon name their nearest neighbour.
    pub blocks: Vec<PatchId>,
    /// Blocks in a row.
    pub columns: usize,
    /// Number of the first luxel interval of the face among those of the map: see
    /// [`Detail`](super::Detail).
    pub first_interval: u32,
}

impl PatchGrid {
    /// The patch at luxel coordinates; points outside (by rounding) belong to the nearest block.
    pub fn at(&self, s: f32, t: f32) -> PatchId {
        // `as` saturates: below 0 and NaN become the first interval.
        let column = (s as usize).min(self.block_column.len() - 1);
        let row = (t as usize).min(self.block_row.len() - 1);
        self.of_interval(column, row)
    }

    /// The patch of the luxel interval in a column and a row.
    pub fn of_interval(&self, column: usize, row: usize) -> PatchId {
        let (column, row) = (self.block_column[column], self.block_row[row]);
        self.blocks[row as usize * self.columns + column as usize]
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

    /// The patches of a polygon of the tracer.
    pub fn polygon(&self, polygon: u32) -> &PolygonPatches {
        &self.polygons[polygon as usize]
    }
}
