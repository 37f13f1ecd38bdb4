//! Groups of neighbouring patches of a face, one of which may see for all.

use super::{MapPatches, PatchGrid, PolygonPatches};

impl MapPatches {
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
