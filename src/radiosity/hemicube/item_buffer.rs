//! Drawing a hemicube: the hierarchy is walked front to back, once for all five sides, and what lies
//! behind covered tiles is skipped.

use super::clip::{Homogeneous, clip};
use super::frame::{ALL_SIDES, Frame, SideSet};
use super::side::{NOTHING, Side};
use super::{HemicubeSize, SIDES, SideId, View};
use crate::scene::Tracer;
use glam::Vec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Which polygon a point sees through each cell. Reused from one hemicube to the next.
pub struct ItemBuffer {
    size: HemicubeSize,
    sides: [Side; 5],
    /// Nodes still to be looked at, the nearest first, with the sides that they may be seen on.
    queue: BinaryHeap<Reverse<(u32, u32, SideSet)>>,
    /// Corners of a polygon in the coordinates of the view.
    local: Vec<Vec3>,
    points: Vec<Homogeneous>,
    spare: Vec<Homogeneous>,
    corners: Vec<[f32; 2]>,
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
            queue: BinaryHeap::new(),
            local: Vec::new(),
            points: Vec::new(),
            spare: Vec::new(),
            corners: Vec::new(),
        }
    }

    /// Number of cells.
    pub fn size(&self) -> HemicubeSize {
        self.size
    }

    /// Replaces the contents by what is seen from `view`.
    pub fn draw(&mut self, tracer: &Tracer, view: &View) {
        self.sides.iter_mut().for_each(Side::clear);
        let nodes = tracer.nodes();
        let frame = Frame::new(view, self.size);
        let backs = tracer.hidden_backs(view.position);
        self.queue.clear();
        if !nodes.is_empty() {
            self.queue.push(Reverse((0, 0, ALL_SIDES)));
        }
        while let Some(Reverse((_, index, sides))) = self.queue.pop() {
            let node = &nodes[index as usize];
            if node.count > 0 {
                // Polygons are tested by themselves, more exactly than by their box.
                for slot in node.first..node.first + node.count {
                    let hidden = backs.get(slot as usize).copied().unwrap_or(false);
                    if hidden && tracer.faces_away(slot, view.position) {
                        continue;
                    }
                    self.draw_polygon(tracer, slot, &frame, sides);
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
            for child in [node.first, node.first + 1] {
                let node = &nodes[child as usize];
                let sides = sides & frame.sides_of_box(node);
                if sides != 0 {
                    self.queue.push(Reverse((frame.distance(node).to_bits(), child, sides)));
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

    fn draw_polygon(&mut self, tracer: &Tracer, slot: u32, frame: &Frame, sides: SideSet) {
        let (corners, normal, item) = tracer.polygon(slot);
        let Some(slope) = frame.nearness(corners[0], normal) else { return };
        self.local.clear();
        self.local.extend(corners.iter().map(|&c| frame.local(c)));
        for number in members(sides & Frame::sides_of_polygon(&self.local)) {
            let side = frame.side(number);
            self.points.clear();
            self.points.extend(self.local.iter().map(|&c| side.project(c)));
            let target = &mut self.sides[number];
            let (width, height) = (target.width(), target.height());
            if !clip(&mut self.points, &mut self.spare, width, height) {
                continue;
            }
            // Clipping leaves rounding errors, and 0 / 0 where a polygon touches the eye: `max` and
            // `min` bring both back into the side.
            self.corners.clear();
            self.corners.extend(self.points.iter().map(|p| {
                let inverse = 1.0 / p.z;
                [(p.x * inverse).max(0.0).min(width), (p.y * inverse).max(0.0).min(height)]
            }));
            let (mut low, mut high) = ([width, height], [0.0f32; 2]);
            for c in &self.corners {
                for k in 0..2 {
                    low[k] = low[k].min(c[k]);
                    high[k] = high[k].max(c[k]);
                }
            }
            let depth = self.points.iter().map(|p| p.z).fold(f32::INFINITY, f32::min);
            if !target.covered(low, high, 1.0 / depth) {
                target.fill(&self.corners, side.nearness(slope), item);
            }
        }
    }
}

/// The numbers of the sides in a set.
fn members(set: SideSet) -> impl Iterator<Item = usize> {
    (0..5).filter(move |side| set >> side & 1 == 1)
}
