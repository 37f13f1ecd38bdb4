//! Drawing a hemicube: the hierarchy is walked front to back, once for all five sides, and what lies
//! behind covered tiles is skipped.

use super::clip::{Homogeneous, clip, outside};
use super::frame::{ALL_SIDES, Frame, SideSet};
use super::lanes::greatest;
use super::outline::Outline;
use super::side::{NOTHING, Side};
use super::{HemicubeSize, SIDES, SideId, View};
use crate::scene::{Piece, Tracer};
use glam::Vec3;
use wide::{CmpGt, f32x8};

/// What [`outside`] tells of a plane that all corners are outside of.
const ALL_CORNERS: i32 = 255;

/// Which polygon a point sees through each cell. Reused from one hemicube to the next.
pub struct ItemBuffer {
    size: HemicubeSize,
    sides: [Side; 5],
    /// Nodes still to be looked at, the nearer child last, with the sides that they may be seen on.
    stack: Vec<(u32, SideSet)>,
    points: Vec<Homogeneous>,
    spare: Vec<Homogeneous>,
}

/// Cells of one row that lie beside each other in memory.
pub struct Cells<'a> {
    /// The side they are on.
    pub side: SideId,
    /// Column of the first cell.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// Polygon seen in each cell, `u32::MAX` for none.
    pub items: &'a [u32],
    /// 1 / depth along the side's axis, in 1 / world units.
    pub nearness: &'a [f32],
}

impl Cells<'_> {
    /// Marks a cell through which nothing is seen.
    pub const NOTHING: u32 = NOTHING;
}

impl ItemBuffer {
    /// An empty buffer.
    pub fn new(size: HemicubeSize) -> Self {
        Self {
            size,
            sides: SIDES.map(|s| Side::new(size.width(), size.rows(s))),
            stack: Vec::new(),
            points: Vec::new(),
            spare: Vec::new(),
        }
    }

    /// Number of cells.
    pub fn size(&self) -> HemicubeSize {
        self.size
    }

    /// Replaces the contents by what is seen from `view`.
    pub fn draw(&mut self, tracer: &Tracer, view: &View) {
        self.sides.iter_mut().for_each(Side::clear);
        let pieces = tracer.pieces();
        let nodes = pieces.nodes();
        let frame = Frame::new(view, self.size);
        self.stack.clear();
        if !nodes.is_empty() {
            self.stack.push((0, ALL_SIDES));
        }
        while let Some((index, sides)) = self.stack.pop() {
            let node = &nodes[index as usize];
            if node.count > 0 {
                // Polygons are tested by themselves, more exactly than by their box.
                for piece in pieces.of(node) {
                    self.draw_piece(piece, &frame, sides);
                }
                continue;
            }
            let corners = frame.corners(node);
            let sides = members(sides)
                .filter(|&side| !frame.hidden(&corners, side, &mut self.sides[side]))
                .fold(0, |set, side| set | 1 << side);
            if sides == 0 {
                continue;
            }
            let children = [node.first, node.first + 1];
            let [a, b] = children.map(|child| &nodes[child as usize]);
            let seen = [sides & frame.sides_of_box(a), sides & frame.sides_of_box(b)];
            let nearer = usize::from(frame.distance(b) < frame.distance(a));
            for k in [1 - nearer, nearer] {
                if seen[k] != 0 {
                    self.stack.push((children[k], seen[k]));
                }
            }
        }
    }

    /// Polygon seen in a cell, [`Cells::NOTHING`] for none, and 1 / depth.
    pub fn cell(&self, side: SideId, x: u32, y: u32) -> (u32, f32) {
        let place = SIDES.iter().position(|&s| s == side).expect("one of the five");
        self.sides[place].cell(x as usize, y as usize)
    }

    /// Visits all cells, in a fixed order.
    pub fn for_each_row(&self, mut visit: impl FnMut(Cells<'_>)) {
        for (side, id) in self.sides.iter().zip(SIDES) {
            side.for_each_row(|x, y, items, nearness| {
                visit(Cells { side: id, x: x as u32, y: y as u32, items, nearness });
            });
        }
    }

    fn draw_piece(&mut self, piece: &Piece, frame: &Frame, sides: SideSet) {
        let local = frame.local(&piece.corners);
        for number in members(sides) {
            let side = frame.side(number);
            let target = &mut self.sides[number];
            let size = target.size();
            let points = side.project(&local);
            let outside = outside(&points, size);
            if outside.contains(&ALL_CORNERS) {
                continue;
            }
            let inverse = f32x8::ONE / points[2];
            let whole = Outline::projected(&points, inverse);
            let before = points[2].cmp_gt(f32x8::ZERO).all();
            let (outline, nearest);
            if before && (outside == [0; 4] || whole.is_near(size)) {
                (outline, nearest) = (whole, greatest(inverse));
            } else {
                self.points.clear();
                let [x, y, z] = [points[0].to_array(), points[1].to_array(), points[2].to_array()];
                self.points.extend((0..piece.count as usize).map(|k| Vec3::new(x[k], y[k], z[k])));
                if !clip(&mut self.points, &mut self.spare, size[0], size[1]) {
                    continue;
                }
                outline = Outline::clipped(&self.points, size);
                nearest = 1.0 / self.points.iter().map(|p| p.z).fold(f32::INFINITY, f32::min);
            }
            let Some(cells) = outline.cells(size) else { continue };
            if target.covered(cells, nearest) {
                continue;
            }
            let Some(slope) = frame.nearness(piece.on, piece.normal) else { return };
            target.fill(&outline.edges(size[1]), cells, side.nearness(slope), piece.polygon);
        }
    }
}

/// The numbers of the sides in a set.
fn members(set: SideSet) -> impl Iterator<Item = usize> {
    (0..5).filter(move |side| set >> side & 1 == 1)
}
