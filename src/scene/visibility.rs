//! Which leafs of the map a light can reach, by the visibility rows that `vis` stored: where it
//! cannot, no shadow ray is needed.

use super::lights::Light;
use super::solid::Solid;
use crate::bsp::{Bsp, Leaf};
use glam::Vec3;
use std::collections::HashMap;

/// Contents of leafs.
const EMPTY: i32 = -1;
const LIQUIDS: std::ops::RangeInclusive<i32> = -5..=-3;
/// Rows are kept up to this many bytes in all; lights beyond that reach everything.
const MOST_BYTES: usize = 64 << 20;

/// What the lights of a scene can reach.
#[derive(Default)]
pub struct Visibility {
    rows: Vec<Vec<u64>>,
    /// Whether each leaf is empty space.
    empty: Vec<bool>,
    /// Row of each light of the scene; `None` reaches everything.
    of_light: Vec<Option<u32>>,
}

/// The leafs that a light can reach.
#[derive(Clone, Copy)]
pub struct Reach<'a>(Option<&'a [u64]>);

impl Reach<'_> {
    /// Whether light can get to a point in `leaf`, as [`Visibility::leaf`] gives it.
    pub fn includes(self, leaf: Option<u32>) -> bool {
        let (Some(row), Some(leaf)) = (self.0, leaf) else { return true };
        row.get(leaf as usize / 64).is_none_or(|bits| bits >> (leaf % 64) & 1 == 1)
    }
}

impl Visibility {
    /// Finds the rows of the lights. A map without visibility, or one whose liquids are opaque to
    /// `vis` though they are not to light, has none.
    pub(super) fn new(bsp: &Bsp, solid: &Solid, lights: &[Light]) -> Self {
        if bsp.visibility.is_empty() || !sees_through_liquids(bsp) {
            return Self::default();
        }
        let mut found = Self {
            rows: Vec::new(),
            empty: bsp.leafs.iter().map(|l| l.contents == EMPTY).collect(),
            of_light: vec![None; lights.len()],
        };
        let mut bytes = 0;
        let mut of_leaf: HashMap<u32, Option<u32>> = HashMap::new();
        for (light, of_light) in lights.iter().zip(&mut found.of_light) {
            // Light that passes through the world is not held back by its walls.
            if light.shadow_mask & 1 == 0 {
                continue;
            }
            let Some(leaf) = solid.world_leaf(light.origin) else { continue };
            *of_light = *of_leaf.entry(leaf).or_insert_with(|| {
                let row = row(bsp, leaf).filter(|r| bytes + r.len() * 8 <= MOST_BYTES)?;
                bytes += row.len() * 8;
                found.rows.push(row);
                Some(found.rows.len() as u32 - 1)
            });
        }
        found
    }

    /// The empty leaf at a point of the world; `None` for any other place, of which visibility says
    /// little, and where nothing is known about any light.
    pub fn leaf(&self, solid: &Solid, point: Vec3) -> Option<u32> {
        if self.rows.is_empty() {
            return None;
        }
        solid.world_leaf(point).filter(|&leaf| self.empty[leaf as usize])
    }

    /// What light `light` of the scene can reach.
    pub fn of_light(&self, light: usize) -> Reach<'_> {
        let row = self.of_light.get(light).copied().flatten();
        Reach(row.map(|r| self.rows[r as usize].as_slice()))
    }
}

/// The leafs that a leaf sees, a bit each; `None` if all.
fn row(bsp: &Bsp, leaf: u32) -> Option<Vec<u64>> {
    let record = bsp.leafs.get(leaf as usize).filter(|l| l.contents == EMPTY)?;
    let count = bsp.models[0].vis_leafs;
    let mut bits = vec![0_u64; (count as usize + 1).div_ceil(64)];
    let mut set = |leaf: u32| bits[leaf as usize / 64] |= 1 << (leaf % 64);
    for seen in seen_from(bsp, record)? {
        set(seen);
    }
    if leaf > count {
        return None;
    }
    set(leaf);
    Some(bits)
}

/// Indices of the leafs in a leaf's row, which codes runs of zero bytes as a zero and their number;
/// bit n stands for leaf n + 1. `None` without a whole row.
fn seen_from(bsp: &Bsp, leaf: &Leaf) -> Option<Vec<u32>> {
    let start = usize::try_from(leaf.vis_offset).ok()?;
    let count = bsp.models[0].vis_leafs;
    let mut bytes = bsp.visibility.get(start..)?.iter();
    let (mut seen, mut bit) = (Vec::new(), 0);
    while bit < count {
        let byte = *bytes.next()?;
        if byte == 0 {
            bit = bit.saturating_add(8 * u32::from((*bytes.next()?).max(1)));
            continue;
        }
        seen.extend((0..8).filter(|i| byte >> i & 1 == 1).map(|i| bit + i + 1));
        bit += 8;
    }
    seen.retain(|&leaf| leaf <= count);
    Some(seen)
}

/// Whether every kind of liquid in a map is seen through: some leaf of it sees one of other
/// contents.
fn sees_through_liquids(bsp: &Bsp) -> bool {
    LIQUIDS.into_iter().all(|kind| {
        let mut of_kind = bsp.leafs.iter().filter(|l| l.contents == kind).peekable();
        of_kind.peek().is_none()
            || of_kind.any(|leaf| {
                seen_from(bsp, leaf).is_none_or(|seen| {
                    seen.iter()
                        .any(|&s| bsp.leafs.get(s as usize).is_some_and(|l| l.contents != kind))
                })
            })
    })
}
