//! The item buffer of one side: which polygon is nearest in each cell.
//!
//! Cells are stored in 8 x 8 tiles. Nearness is 1 / depth, which is linear over a side, so a polygon
//! is three numbers there and the nearest one has the largest. Each tile knows the smallest nearness
//! in it: what lies beyond that everywhere cannot be seen (masked occlusion culling).

use super::lanes::{CENTRES, LANES, all, bits, greatest, least};
use super::outline::{Cells, Edges};
use bytemuck::{cast, cast_slice};
use std::ops::Range;
use wide::{CmpGt, CmpLt, f32x8, i32x8};

/// Cells on the edge of a tile.
const TILE: usize = LANES;
/// Cells in a tile.
const CELLS: usize = TILE * TILE;
/// Marks a cell through which no polygon is seen.
pub(super) const NOTHING: u32 = u32::MAX;

/// 1 / depth as a linear function of cell coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearness {
    /// At the side's corner (0, 0).
    pub base: f32,
    /// Change from one column to the next.
    pub dx: f32,
    /// Change from one row to the next.
    pub dy: f32,
}

impl Nearness {
    /// Upper bound on the nearness at the cell centres of a tile.
    fn largest_in_tile(&self, tx: usize, ty: usize) -> f32 {
        let half = 0.5 * TILE as f32;
        let (x, y) = ((tx * TILE) as f32 + half, (ty * TILE) as f32 + half);
        self.base + self.dx * x + self.dy * y + (self.dx.abs() + self.dy.abs()) * half
    }
}

/// The buffer of one side.
pub(super) struct Side {
    width: usize,
    height: usize,
    size: [f32; 2],
    tiles_x: usize,
    nearness: Vec<f32>,
    item: Vec<u32>,
    /// Smallest nearness in each tile; stale where `touched`.
    farthest: Vec<f32>,
    touched: Vec<bool>,
}

impl Side {
    pub fn new(width: u32, height: u32) -> Self {
        let (width, height) = (width as usize, height as usize);
        let (tiles_x, tiles_y) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let tiles = tiles_x * tiles_y;
        Self {
            width,
            height,
            size: [width as f32, height as f32],
            tiles_x,
            nearness: vec![0.0; tiles * CELLS],
            item: vec![NOTHING; tiles * CELLS],
            farthest: vec![0.0; tiles],
            touched: vec![false; tiles],
        }
    }

    /// Forgets everything drawn. Cells of the last tiles that stick out of the side count as covered.
    pub fn clear(&mut self) {
        self.item.fill(NOTHING);
        self.farthest.fill(0.0);
        self.touched.fill(false);
        self.nearness.fill(0.0);
        if !self.width.is_multiple_of(TILE) || !self.height.is_multiple_of(TILE) {
            for (i, n) in self.nearness.iter_mut().enumerate() {
                let (tile, cell) = (i / CELLS, i % CELLS);
                let x = tile % self.tiles_x * TILE + cell % TILE;
                let y = tile / self.tiles_x * TILE + cell / TILE;
                if x >= self.width || y >= self.height {
                    *n = f32::INFINITY;
                }
            }
        }
    }

    /// Columns and rows.
    pub fn size(&self) -> [f32; 2] {
        self.size
    }

    /// Item and nearness of a cell.
    pub fn cell(&self, x: usize, y: usize) -> (u32, f32) {
        let tile = y / TILE * self.tiles_x + x / TILE;
        let at = tile * CELLS + y % TILE * TILE + x % TILE;
        (self.item[at], self.nearness[at])
    }

    /// Item and nearness of the cell at cell coordinates, or of the nearest one.
    pub fn at(&self, x: f32, y: f32) -> (u32, f32) {
        // `as` saturates: below 0 and NaN become the first cell.
        self.cell((x as usize).min(self.width - 1), (y as usize).min(self.height - 1))
    }

    /// Calls `visit(x, y, items, nearness)` for each run of eight (or fewer, at the right edge)
    /// cells of a row, tile by tile.
    pub fn for_each_row(&self, mut visit: impl FnMut(usize, usize, &[u32], &[f32])) {
        for (tile, (items, near)) in
            self.item.chunks_exact(CELLS).zip(self.nearness.chunks_exact(CELLS)).enumerate()
        {
            let (x, y) = (tile % self.tiles_x * TILE, tile / self.tiles_x * TILE);
            let columns = TILE.min(self.width - x);
            for row in 0..TILE.min(self.height - y) {
                let cells = row * TILE..row * TILE + columns;
                visit(x, y + row, &items[cells.clone()], &near[cells]);
            }
        }
    }

    /// Whether something at least as near as `nearness` covers all of the cells.
    pub fn covered(&self, cells: Cells, nearness: f32) -> bool {
        let range = |k: usize| cells.low[k] as usize..cells.high[k] as usize;
        let (xs, ys) = (range(0), range(1));
        for ty in ys.start / TILE..=(ys.end - 1) / TILE {
            for tx in xs.start / TILE..=(xs.end - 1) / TILE {
                let tile = ty * self.tiles_x + tx;
                // Where `farthest` is stale, cells have come nearer since.
                if self.farthest[tile] < nearness
                    && !self.covered_in_tile(tile, [tx * TILE, ty * TILE], &xs, &ys, nearness)
                {
                    return false;
                }
            }
        }
        true
    }

    /// As `covered`, looking at single cells of one tile.
    fn covered_in_tile(
        &self,
        tile: usize,
        corner: [usize; 2],
        xs: &Range<usize>,
        ys: &Range<usize>,
        nearness: f32,
    ) -> bool {
        let from = ys.start.max(corner[1]) - corner[1];
        let to = ys.end.min(corner[1] + TILE) - corner[1];
        let inside = columns_within(corner[0], xs.start, xs.end);
        let cells = &self.nearness[tile * CELLS + from * TILE..tile * CELLS + to * TILE];
        let open = cells
            .chunks_exact(TILE)
            .fold(f32x8::ZERO, |open, row| open | eight(row).cmp_lt(all(nearness)));
        !(open & inside).any()
    }

    fn farthest(&mut self, tile: usize) -> f32 {
        if self.touched[tile] {
            self.touched[tile] = false;
            let cells = &self.nearness[tile * CELLS..][..CELLS];
            let least = cells
                .chunks_exact(TILE)
                .fold(all(f32::INFINITY), |least, row| least.fast_min(eight(row)));
            self.farthest[tile] = least.to_array().into_iter().fold(f32::INFINITY, f32::min);
        }
        self.farthest[tile]
    }

    /// Draws a convex polygon with corners in cell coordinates, inside the side. A cell belongs to
    /// it if the cell's centre does; centres on an edge go to the polygon on its right. Returns whether
    /// any cell shows it.
    pub fn fill(&mut self, edges: &Edges, cells: Cells, nearness: Nearness, item: u32) -> bool {
        let mut shown = false;
        for ty in cells.low[1] as usize / TILE..=(cells.high[1] as usize - 1) / TILE {
            let [from, to] = edges.spans(ty * TILE, self.size[0]);
            let rows = from.cmp_lt(to).move_mask() as u32;
            if rows != 0 {
                shown |= self.fill_tile_row(ty, rows, [from, to], nearness, item);
            }
        }
        shown
    }

    /// Fills the `rows` of one row of tiles, a bit each, between the columns `from` and `to`.
    fn fill_tile_row(
        &mut self,
        ty: usize,
        rows: u32,
        [from, to]: [f32x8; 2],
        nearness: Nearness,
        item: u32,
    ) -> bool {
        let mut shown = false;
        let some = from.cmp_lt(to);
        let first = least(some.blend(from, all(f32::INFINITY))) as usize;
        let last = greatest(some.blend(to, f32x8::ZERO)) as usize - 1;
        let (from, to) = (from.to_array(), to.to_array());
        for tx in first / TILE..=last / TILE {
            let tile = ty * self.tiles_x + tx;
            let x0 = (tx * TILE) as f32;
            if self.farthest(tile) >= nearness.largest_in_tile(tx, ty) {
                continue;
            }
            let x = all(x0) + CENTRES;
            let along_row = all(nearness.dx) * x;
            let mut changed = false;
            for row in bits(rows) {
                let y = ty * TILE + row;
                let at = tile * CELLS + row * TILE;
                let start = nearness.base + nearness.dy * (y as f32 + 0.5);
                let here = all(start) + along_row;
                let near = eight(&self.nearness[at..at + TILE]);
                let inside = x.cmp_gt(all(from[row])) & x.cmp_lt(all(to[row]));
                let take = inside & here.cmp_gt(near);
                if take.any() {
                    let store = &mut self.nearness[at..at + TILE];
                    store.copy_from_slice(&take.blend(here, near).to_array());
                    let items = &mut self.item[at..at + TILE];
                    let old = eight_items(items);
                    let new = cast::<f32x8, i32x8>(take).blend(i32x8::splat(item as i32), old);
                    items.copy_from_slice(cast_slice(&new.to_array()));
                    changed = true;
                }
            }
            self.touched[tile] |= changed;
            shown |= changed;
        }
        shown
    }
}

/// Mask of the columns `from..to` in the tile whose first column is `x0`.
fn columns_within(x0: usize, from: usize, to: usize) -> f32x8 {
    let relative = |x: usize| all((x as i32 - x0 as i32) as f32);
    CENTRES.cmp_gt(relative(from)) & CENTRES.cmp_lt(relative(to))
}

fn eight_items(row: &[u32]) -> i32x8 {
    i32x8::from(<[i32; TILE]>::try_from(cast_slice(row)).expect("rows of a tile have eight cells"))
}

fn eight(row: &[f32]) -> f32x8 {
    f32x8::from(<[f32; TILE]>::try_from(row).expect("rows of a tile have eight cells"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiosity::hemicube::outline::Outline;
    use glam::Vec3;
    use wide::f32x4;

    const FLAT: Nearness = Nearness { base: 1.0, dx: 0.0, dy: 0.0 };

    /// Fills a polygon with these corners.
    fn fill(side: &mut Side, corners: &[[f32; 2]], nearness: Nearness, item: u32) {
        let points: Vec<Vec3> = corners.iter().map(|c| Vec3::new(c[0], c[1], 1.0)).collect();
        let size = side.size();
        let outline = Outline::clipped(&points, size);
        let mut edges = Edges::default();
        if let Some(cells) = outline.cells(size) {
            outline.edges(size[1], &mut edges);
            side.fill(&edges, cells, nearness, item);
        }
    }

    /// Whether the cells between two points are covered, or there are none.
    fn covered(side: &Side, low: [f32; 2], high: [f32; 2], nearness: f32) -> bool {
        let around = f32x4::new([low[0], low[1], high[0], high[1]]);
        let cells = Cells::between(around, side.size());
        cells.is_none_or(|cells| side.covered(cells, nearness))
    }

    fn cells(side: &Side) -> Vec<Vec<u32>> {
        let mut rows = vec![vec![NOTHING; side.width]; side.height];
        side.for_each_row(|x, y, items, _| rows[y][x..x + items.len()].copy_from_slice(items));
        rows
    }

    #[test]
    fn polygons_that_share_edges_cover_each_cell_once() {
        // A fan of triangles around an off-grid point, drawn at equal nearness: the first to reach
        // a cell keeps it, so overlap would show as a missing cell when drawn in reverse order.
        let rim = [[0.0, 0.0], [20.0, 0.0], [20.0, 7.3], [20.0, 13.0], [0.0, 13.0], [0.0, 5.1]];
        let hub = [7.77, 6.31];
        let draw = |reverse: bool| {
            let mut side = Side::new(20, 13);
            side.clear();
            for k in 0..rim.len() {
                let i = if reverse { rim.len() - 1 - k } else { k };
                fill(&mut side, &[hub, rim[i], rim[(i + 1) % rim.len()]], FLAT, i as u32);
            }
            cells(&side)
        };
        let forth = draw(false);
        assert!(forth.iter().flatten().all(|&i| i != NOTHING));
        assert_eq!(forth, draw(true));
    }

    #[test]
    fn the_nearer_polygon_wins_whatever_the_order() {
        let quad = [[0.0, 0.0], [16.0, 0.0], [16.0, 16.0], [0.0, 16.0]];
        let slope = Nearness { base: 0.0, dx: 0.125, dy: 0.0 };
        for order in [[0, 1], [1, 0]] {
            let mut side = Side::new(16, 16);
            side.clear();
            for i in order {
                fill(&mut side, &quad, if i == 0 { FLAT } else { slope }, i);
            }
            for row in cells(&side) {
                assert!(row[..8].iter().all(|&i| i == 0) && row[8..].iter().all(|&i| i == 1));
            }
        }
    }

    #[test]
    fn coverage_needs_every_cell() {
        let mut side = Side::new(20, 12);
        side.clear();
        fill(&mut side, &[[0.0, 0.0], [19.0, 0.0], [19.0, 12.0], [0.0, 12.0]], FLAT, 0);
        assert!(covered(&side, [0.0, 0.0], [15.0, 11.0], 0.9));
        assert!(!covered(&side, [0.0, 0.0], [15.0, 11.0], 1.1));
        assert!(!covered(&side, [0.0, 0.0], [20.0, 11.0], 0.9));
        assert!(covered(&side, [16.0, 1.0], [19.4, 11.0], 0.9), "no centre right of column 18");
        assert!(!covered(&side, [16.0, 1.0], [19.6, 11.0], 0.9));
        fill(&mut side, &[[19.0, 0.0], [20.0, 0.0], [20.0, 12.0], [19.0, 12.0]], FLAT, 0);
        assert!(covered(&side, [f32::NEG_INFINITY, -3.0], [f32::INFINITY, 99.0], 0.9));
    }

    #[test]
    fn wild_coordinates_do_no_harm() {
        let mut side = Side::new(10, 10);
        side.clear();
        let (nan, inf) = (f32::NAN, f32::INFINITY);
        fill(&mut side, &[[nan, nan], [1.0, inf], [-inf, 3.0]], FLAT, 0);
        fill(
            &mut side,
            &[[-inf, -inf], [inf, -inf], [inf, inf]],
            Nearness { base: nan, dx: inf, dy: 0.0 },
            1,
        );
        covered(&side, [nan, nan], [nan, inf], 1.0);
    }
}
