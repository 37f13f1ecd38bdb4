//! Patches for which less than a fine hemicube of their own does: groups of neighbours on a face, one of
//! which may see for all, and small ones.

use super::{MapPatches, PatchGrid, PolygonPatches};

/// Patches of less than this share of a whole one's area are small.
const SMALL: f32 = 0.5;

impl MapPatches {
    /// For each patch whether it is small: the edge of its face or an obstacle cuts off most of it, so
    /// that it receives and sends little.
    pub fn small(&self) -> Vec<bool> {
        let whole = |surface: u32| self.spacing[surface as usize].powi(2);
        let patches = self.set.patches.iter().zip(&self.surface);
        patches.map(|(patch, &surface)| patch.area < SMALL * whole(surface)).collect()
    }

    /// For each patch the one that leads its group, two by two blocks of its face: the largest of them,
    /// the first of equal ones. It leads itself, and so does each patch of a block that is divided.
    pub fn leaders(&self) -> Vec<u32> {
        let mut leaders: Vec<u32> = (0..self.set.patches.len() as u32).collect();
        let mut grouped = vec![false; leaders.len()];
        for polygon in self.intervals.polygons.iter().flatten() {
            if let PolygonPatches::Grid(grid) = self.set.lookup.polygon(*polygon) {
                self.group(grid, &mut leaders, &mut grouped);
            }
        }
        leaders
    }

    fn group(&self, grid: &PatchGrid, leaders: &mut [u32], grouped: &mut [bool]) {
        let rows = grid.blocks.len() / grid.columns;
        for row in (0..rows).step_by(2) {
            for column in (0..grid.columns).step_by(2) {
                let blocks = [(0, 0), (0, 1), (1, 0), (1, 1)]
                    .map(|(down, right)| (row + down, column + right))
                    .into_iter()
                    .filter(|&(row, column)| row < rows && column < grid.columns);
                // Blocks outside the face name a patch of some group: the first that comes is its own.
                // The patches of divided blocks see different things and lead themselves.
                let members: Vec<u32> = blocks
                    .map(|(row, column)| grid.blocks[row * grid.columns + column])
                    .filter(|&patch| patch != PatchGrid::DIVIDED)
                    .map(|patch| patch.0)
                    .filter(|&patch| !std::mem::replace(&mut grouped[patch as usize], true))
                    .collect();
                let area = |patch: u32| self.set.patches[patch as usize].area;
                let larger = |a: u32, b: u32| if area(b) > area(a) { b } else { a };
                let Some(leader) = members.iter().copied().reduce(larger) else { continue };
                for patch in members {
                    leaders[patch as usize] = leader;
                }
            }
        }
    }
}
