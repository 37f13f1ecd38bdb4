//! Light grids: the BSPX lumps `LIGHTGRID_OCTREE` and `LIGHTGRIDS`, light at points of free space for
//! what moves there (contract sections 1.7 and 6.8).
//!
//! The points are cut into boxes by an octree, so that space inside walls takes no room.

use super::bspx::{BspxLump, push_u32};
use crate::Result;
use glam::{UVec3, Vec3};

/// Boxes are cut at most so often.
const MOST_CUTS: u32 = 5;
/// Boxes with fewer points along a side are not cut.
const LEAST_SIDE: u32 = 4;
/// Boxes with fewer points in solid are not cut: there is too little to save.
const LEAST_SOLID: usize = 8;
/// Bit of a child word: the rest is the index of a leaf.
const LEAF: u32 = 1 << 31;
/// Child word of a box with nothing but solid.
const SOLID: u32 = 1 << 30;
/// Number of styles of a point in solid.
const NO_DATA: u8 = 0xff;

/// Where the points of a grid are: point (i, j, k) is at `mins + (i, j, k) * step`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPlace {
    /// World position of the first point.
    pub mins: Vec3,
    /// World units from point to point along each axis, above 0.
    pub step: Vec3,
    /// Points along each axis, at least 1.
    pub size: UVec3,
}

impl GridPlace {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.size.to_array().iter().map(|&n| n as usize).product()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Index of a point in a list of all: x runs fastest, z slowest.
    pub fn index(&self, at: UVec3) -> usize {
        let [x, y, z] = at.to_array().map(|n| n as usize);
        (z * self.size.y as usize + y) * self.size.x as usize + x
    }

    /// World position of the point of an index.
    pub fn position(&self, index: usize) -> Vec3 {
        let (width, depth) = (self.size.x as usize, self.size.y as usize);
        let at = [index % width, index / width % depth, index / width / depth];
        self.mins + Vec3::from(at.map(|n| n as f32)) * self.step
    }
}

/// Light at a point: one entry a style, at most 254; `None` in solid. There is one colour that stands for
/// light from everywhere, or one for each of the sides of a small cube that look along +x, -x, +y, -y,
/// +z, -z.
pub type GridPoint<const SIDES: usize> = Option<Vec<GridStyle<SIDES>>>;

/// Light of one style at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridStyle<const SIDES: usize> {
    /// Light style, below 255.
    pub style: u8,
    /// RGB levels.
    pub levels: [[u8; 3]; SIDES],
}

/// The lump `LIGHTGRID_OCTREE`: one colour a style and point.
///
/// # Errors
/// If it would pass 2 GiB.
///
/// # Panics
/// If there is not one entry for each point.
pub fn octree_lump(place: &GridPlace, points: &[GridPoint<1>]) -> Result<BspxLump> {
    let data = Grid { place, points }.bytes()?;
    Ok(BspxLump { name: "LIGHTGRID_OCTREE".into(), data })
}

/// The lump `LIGHTGRIDS` with one grid: the colours on the sides of a cube. Black sides take no room.
///
/// # Errors
/// If it would pass 2 GiB.
///
/// # Panics
/// If there is not one entry for each point.
pub fn sides_lump(place: &GridPlace, points: &[GridPoint<6>]) -> Result<BspxLump> {
    let bytes = Grid { place, points }.bytes()?;
    let mut data = Vec::with_capacity(bytes.len() + 4);
    push_u32(&mut data, bytes.len())?;
    data.extend(bytes);
    Ok(BspxLump { name: "LIGHTGRIDS".into(), data })
}

/// A grid to be written.
struct Grid<'a, const SIDES: usize> {
    place: &'a GridPlace,
    points: &'a [GridPoint<SIDES>],
}

/// A part of the points.
#[derive(Clone, Copy)]
struct Box3 {
    mins: UVec3,
    size: UVec3,
}

/// Nodes and leafs as they are written.
#[derive(Default)]
struct Tree {
    node_count: u32,
    nodes: Vec<u8>,
    leaf_count: u32,
    leafs: Vec<u8>,
}

impl<const SIDES: usize> Grid<'_, SIDES> {
    fn bytes(&self) -> Result<Vec<u8>> {
        assert_eq!(self.points.len(), self.place.len(), "one entry a point");
        let GridPlace { mins, step, size } = *self.place;
        let mut tree = Tree::default();
        let root = self.cut(Box3 { mins: UVec3::ZERO, size }, 0, &mut tree);
        let mut out = Vec::new();
        put_floats(&mut out, step);
        put_words(&mut out, size.to_array());
        put_floats(&mut out, mins);
        // At least one: a reader may take none for a damaged lump.
        out.push(most_styles(self.points).max(1));
        put_words(&mut out, [root, tree.node_count]);
        out.append(&mut tree.nodes);
        put_words(&mut out, [tree.leaf_count]);
        out.append(&mut tree.leafs);
        // Whether the file can hold it.
        push_u32(&mut Vec::new(), out.len())?;
        Ok(out)
    }

    /// Writes the tree of a part of the points; returns the child word for it. Nodes come after their
    /// children.
    fn cut(&self, part: Box3, cuts: u32, tree: &mut Tree) -> u32 {
        let points = || self.points_of(part);
        let solid = points().filter(|p| p.is_none()).count();
        if solid == points().count() {
            return SOLID;
        }
        if cuts == MOST_CUTS || part.size.min_element() < LEAST_SIDE || solid < LEAST_SOLID {
            return self.leaf(part, tree);
        }
        let low = part.size / 2;
        let middle = part.mins + low;
        let children: [u32; 8] = std::array::from_fn(|child| {
            // Bit 2 is the high half along x, bit 1 along y, bit 0 along z.
            let high = [child & 4 != 0, child & 2 != 0, child & 1 != 0];
            let mut child = Box3 { mins: part.mins, size: low };
            for axis in (0..3).filter(|&axis| high[axis]) {
                child.mins[axis] = middle[axis];
                child.size[axis] = part.size[axis] - low[axis];
            }
            self.cut(child, cuts + 1, tree)
        });
        put_words(&mut tree.nodes, middle.to_array());
        put_words(&mut tree.nodes, children);
        tree.node_count += 1;
        tree.node_count - 1
    }

    fn leaf(&self, part: Box3, tree: &mut Tree) -> u32 {
        let out = &mut tree.leafs;
        put_words(out, part.mins.to_array());
        put_words(out, part.size.to_array());
        if SIDES > 1 {
            out.push(most_styles(self.points_of(part)));
        }
        for point in self.points_of(part) {
            let Some(styles) = point else {
                out.push(NO_DATA);
                continue;
            };
            out.push(styles.len() as u8);
            for GridStyle { style, levels } in styles {
                out.push(*style);
                if SIDES == 1 {
                    out.extend(levels[0]);
                    continue;
                }
                let lit = || levels.iter().enumerate().filter(|(_, side)| **side != [0; 3]);
                out.push(lit().map(|(side, _)| 1 << side).sum());
                out.extend(lit().flat_map(|(_, side)| side));
            }
        }
        tree.leaf_count += 1;
        LEAF | (tree.leaf_count - 1)
    }

    /// The points of a part; x runs fastest, z slowest.
    fn points_of(&self, part: Box3) -> impl Iterator<Item = &GridPoint<SIDES>> {
        let [width, depth, height] = part.size.to_array();
        (0..height).flat_map(move |z| (0..depth).map(move |y| (y, z))).flat_map(move |(y, z)| {
            let first = self.place.index(part.mins + UVec3::new(0, y, z));
            &self.points[first..first + width as usize]
        })
    }
}

/// The most styles of any point.
fn most_styles<'a, const SIDES: usize>(
    points: impl IntoIterator<Item = &'a GridPoint<SIDES>>,
) -> u8 {
    points.into_iter().flatten().map(|styles| styles.len() as u8).max().unwrap_or(0)
}

fn put_words<const N: usize>(out: &mut Vec<u8>, words: [u32; N]) {
    out.extend(words.iter().flat_map(|word| word.to_le_bytes()));
}

fn put_floats(out: &mut Vec<u8>, numbers: Vec3) {
    out.extend(numbers.to_array().iter().flat_map(|number| number.to_le_bytes()));
}
