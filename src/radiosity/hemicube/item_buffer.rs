//! Drawing a hemicube: the hierarchy is walked front to back, once for all five sides, and what lies
//! behind covered tiles is skipped.

use super::clip::{Homogeneous, clip, outside};
use super::frame::{ALL_SIDES, Frame, SideSet};
use super::lanes::{LANES, Lanes, greatest};
use super::outline::{Edges, Outline};
use super::side::{NOTHING, Side};
use super::{HemicubeSize, SIDES, SideId, View};
use crate::scene::{Piece, Tracer};
use glam::Vec3;

/// Which polygon a point sees through each cell. Reused from one hemicube to the next.
pub struct ItemBuffer {
    size: HemicubeSize,
    sides: [Side; 5],
    /// Nodes still to be looked at, the nearer child last, with the sides that they may be seen on.
    stack: Vec<(u32, SideSet)>,
    points: Vec<Homogeneous>,
    spare: Vec<Homogeneous>,
    edges: Edges,
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
            edges: Edges::default(),
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
                let (small, large) = pieces.of(node);
                small.iter().for_each(|piece| self.draw_piece(piece, &frame, sides));
                large.iter().for_each(|piece| self.draw_piece(piece, &frame, sides));
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

    fn draw_piece<V: Lanes>(&mut self, piece: &Piece<V>, frame: &Frame, sides: SideSet) {
        let local = frame.local(&piece.corners);
        for number in members(sides) {
            let size = self.sides[number].size();
            let points = frame.side(number).project(&local);
            let outside = outside(&points, size);
            // Outside of one of the planes with all corners.
            if outside.contains(&V::EVERY) {
                continue;
            }
            let inverse = V::all(1.0) / points[2];
            let whole = Outline::projected(&points, inverse);
            let before = points[2].cmp_gt(V::all(0.0)).mask() == V::EVERY;
            if before && (outside == [0; 4] || whole.is_near(size)) {
                self.fill(&whole, greatest(inverse), piece, frame, number);
                continue;
            }
            let mut lanes = [[0.0; LANES]; 3];
            points.iter().zip(&mut lanes).for_each(|(p, lanes)| p.store(lanes));
            let [x, y, z] = &lanes;
            self.points.clear();
            self.points.extend((0..piece.count as usize).map(|k| Vec3::new(x[k], y[k], z[k])));
            if clip(&mut self.points, &mut self.spare, size[0], size[1]) {
                let outline = Outline::clipped(&self.points, size);
                let nearest = 1.0 / self.points.iter().map(|p| p.z).fold(f32::INFINITY, f32::min);
                self.fill(&outline, nearest, piece, frame, number);
            }
        }
    }

    /// Draws a piece with this outline on side `number`, unless all of it is hidden.
    #[inline(always)]
    fn fill<V: Lanes, P>(
        &mut self,
        outline: &Outline<V>,
        nearest: f32,
        piece: &Piece<P>,
        frame: &Frame,
        number: usize,
    ) {
        let side = &mut self.sides[number];
        let size = side.size();
        let Some(cells) = outline.cells(size) else { return };
        if side.covered(cells, nearest) {
            return;
        }
        let Some(slope) = frame.nearness(piece.on, piece.normal) else { return };
        outline.edges(size[1], &mut self.edges);
        side.fill(&self.edges, cells, frame.side(number).nearness(slope), piece.polygon);
    }
}

/// The numbers of the sides in a set.
fn members(set: SideSet) -> impl Iterator<Item = usize> {
    (0..5).filter(move |side| set >> side & 1 == 1)
}
