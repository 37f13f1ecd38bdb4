//! Patches for which less than a fine hemicube of their own does: groups of neighbours on a face, for
//! which one in their middle may do, and small ones.

use super::{MapPatches, PatchGrid, PolygonPatches};
use glam::Vec3;

/// Patches of less than this share of a whole one's area are small.
const SMALL: f32 = 0.5;

/// Patches beside each other on a face, two by two blocks. Patches of a block that is divided are in a
/// group each: they see different things.
#[derive(Clone, Debug, Default)]
pub struct Groups {
    /// The group of each patch.
    pub of: Vec<u32>,
    /// The middle of the patches of each group, as far above the face as their eyes.
    pub eyes: Vec<Vec3>,
}

impl Groups {
    /// The patches of each group.
    pub fn members(&self) -> Vec<Vec<u32>> {
        let mut members = vec![Vec::new(); self.eyes.len()];
        self.of.iter().zip(0..).for_each(|(&group, patch)| members[group as usize].push(patch));
        members
    }
}

impl MapPatches {
    /// For each patch whether it is small: the edge of its face or an obstacle cuts off most of it, so
    /// that it receives and sends little.
    pub fn small(&self) -> Vec<bool> {
        let whole = |surface: u32| self.spacing[surface as usize].powi(2);
        let patches = self.set.patches.iter().zip(&self.surface);
        patches.map(|(patch, &surface)| patch.area < SMALL * whole(surface)).collect()
    }

    /// The groups of all patches.
    pub fn groups(&self) -> Groups {
        // By its first patch, and then numbered.
        let mut first: Vec<u32> = (0..self.set.patches.len() as u32).collect();
        let mut grouped = vec![false; first.len()];
        for polygon in self.intervals.polygons.iter().flatten() {
            if let PolygonPatches::Grid(grid) = self.set.lookup.polygon(*polygon) {
                group(grid, &mut first, &mut grouped);
            }
        }
        let mut groups = Groups::default();
        let mut areas: Vec<f32> = Vec::new();
        let mut number = vec![0; first.len()];
        for (i, (patch, &first)) in self.set.patches.iter().zip(&first).enumerate() {
            if first as usize == i {
                number[i] = groups.eyes.len() as u32;
                groups.eyes.push(patch.eye);
                areas.push(patch.area);
            } else {
                let group = number[first as usize] as usize;
                areas[group] += patch.area;
                let share = patch.area / areas[group];
                groups.eyes[group] = groups.eyes[group].lerp(patch.eye, share);
            }
            groups.of.push(number[first as usize]);
        }
        groups
    }
}

/// Notes the first patch of each group of a face.
fn group(grid: &PatchGrid, first: &mut [u32], grouped: &mut [bool]) {
    let rows = grid.blocks.len() / grid.columns;
    for row in (0..rows).step_by(2) {
        for column in (0..grid.columns).step_by(2) {
            let blocks = [(0, 0), (0, 1), (1, 0), (1, 1)]
                .map(|(down, right)| (row + down, column + right))
                .into_iter()
                .filter(|&(row, column)| row < rows && column < grid.columns);
            // Blocks outside the face name a patch of some group: the first that comes is its own.
            let members: Vec<u32> = blocks
                .map(|(row, column)| grid.blocks[row * grid.columns + column])
                .filter(|&patch| patch != PatchGrid::DIVIDED)
                .map(|patch| patch.0)
                .filter(|&patch| !std::mem::replace(&mut grouped[patch as usize], true))
                .collect();
            let Some(&least) = members.iter().min() else { continue };
            members.into_iter().for_each(|patch| first[patch as usize] = least);
        }
    }
}
