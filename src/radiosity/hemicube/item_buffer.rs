//! Drawing a hemicube: the hierarchy is walked front to back once a side, and what lies behind
//! covered tiles is skipped.

use super::clip::{Homogeneous, clip};
use super::side::{NOTHING, Nearness, Side};
use super::{HemicubeSize, SIDES, SideId, View};
use crate::scene::{Node, Tracer};
use glam::Vec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Which polygon a point sees through each cell. Reused from one hemicube to the next.
pub struct ItemBuffer {
    size: HemicubeSize,
    sides: [Side; 5],
    queue: BinaryHeap<Reverse<(u32, u32)>>,
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
        for (i, id) in SIDES.into_iter().enumerate() {
            self.sides[i].clear();
            if !tracer.nodes().is_empty() {
                let projection = Projection::new(view, id, &self.sides[i]);
                self.draw_side(i, tracer, &projection);
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

    fn draw_side(&mut self, side: usize, tracer: &Tracer, projection: &Projection) {
        self.queue.clear();
        self.queue.push(Reverse((0, 0)));
        while let Some(Reverse((_, index))) = self.queue.pop() {
            let node = &tracer.nodes()[index as usize];
            if !projection.may_be_seen(node, &mut self.sides[side]) {
                continue;
            }
            if node.count > 0 {
                for slot in node.first..node.first + node.count {
                    self.draw_polygon(side, tracer, slot, projection);
                }
            } else {
                for child in [node.first, node.first + 1] {
                    let distance = projection.distance(&tracer.nodes()[child as usize]);
                    self.queue.push(Reverse((distance.to_bits(), child)));
                }
            }
        }
    }

    fn draw_polygon(&mut self, side: usize, tracer: &Tracer, slot: u32, projection: &Projection) {
        let (corners, normal, item) = tracer.polygon(slot);
        let Some(nearness) = projection.nearness(corners[0], normal) else { return };
        self.points.clear();
        self.points.extend(corners.iter().map(|&c| projection.project(c)));
        let target = &mut self.sides[side];
        let (width, height) = (target.width(), target.height());
        if !clip(&mut self.points, &mut self.spare, width, height) {
            return;
        }
        self.corners.clear();
        // Clipping leaves rounding errors, and 0 / 0 where a polygon touches the eye: `max` and
        // `min` bring both back into the side.
        self.corners.extend(
            self.points
                .iter()
                .map(|p| [(p.x / p.z).max(0.0).min(width), (p.y / p.z).max(0.0).min(height)]),
        );
        let (mut low, mut high) = ([width, height], [0.0f32; 2]);
        for c in &self.corners {
            for k in 0..2 {
                low[k] = low[k].min(c[k]);
                high[k] = high[k].max(c[k]);
            }
        }
        let depth = self.points.iter().map(|p| p.z).fold(f32::INFINITY, f32::min);
        if !target.covered(low, high, 1.0 / depth) {
            target.fill(&self.corners, nearness, item);
        }
    }
}

/// Backs are drawn farther by this factor, so that of two polygons back to back (a thin wall) the one
/// that faces the eye is seen, whatever the rounding.
const BACK: f32 = 1.0 - 1e-5;

/// World to cell coordinates of one side. `column . (p - eye)` is column x depth, and so on, so that
/// projecting a point takes three dot products and a division.
struct Projection {
    eye: Vec3,
    column: Vec3,
    row: Vec3,
    depth: Vec3,
    /// World direction of cell corner (0, 0), at depth 1.
    corner: Vec3,
    /// World step to the next column, at depth 1.
    dx: Vec3,
    /// World step to the next row, at depth 1.
    dy: Vec3,
    width: f32,
    height: f32,
}

impl Projection {
    fn new(view: &View, id: SideId, side: &Side) -> Self {
        let [a, b, c] = view.axes(id);
        let (width, height) = (side.width(), side.height());
        // The top spans [-1, 1] both ways, a side [-1, 1] x [0, 1].
        let lowest = if id == SideId::Top { 1.0 } else { 0.0 };
        let rows_per_unit = height / (1.0 + lowest);
        Self {
            eye: view.position,
            column: (a + c) * (0.5 * width),
            row: (b + c * lowest) * rows_per_unit,
            depth: c,
            corner: c - a - b * lowest,
            dx: a * (2.0 / width),
            dy: b / rows_per_unit,
            width,
            height,
        }
    }

    fn project(&self, p: Vec3) -> Homogeneous {
        let p = p - self.eye;
        Vec3::new(self.column.dot(p), self.row.dot(p), self.depth.dot(p))
    }

    /// 1 / depth of the plane through `on` over the side: `normal . direction / distance`. None for
    /// a plane through the eye, which is seen edge-on.
    fn nearness(&self, on: Vec3, normal: Vec3) -> Option<Nearness> {
        let mut inverse = 1.0 / normal.dot(on - self.eye);
        if inverse > 0.0 {
            inverse *= BACK;
        }
        let (base, dx, dy) = (
            normal.dot(self.corner) * inverse,
            normal.dot(self.dx) * inverse,
            normal.dot(self.dy) * inverse,
        );
        (base.is_finite() && dx.is_finite() && dy.is_finite()).then_some(Nearness { base, dx, dy })
    }

    /// Squared distance from the eye to a node's box.
    fn distance(&self, node: &Node) -> f32 {
        (self.eye.clamp(node.min, node.max) - self.eye).length_squared()
    }

    /// Whether any part of the node's box is within the view and not behind covered cells.
    fn may_be_seen(&self, node: &Node, side: &mut Side) -> bool {
        let centre = (node.min + node.max) * 0.5 - self.eye;
        let half = (node.max - node.min) * 0.5;
        let inside = |plane: Vec3| plane.dot(centre) + plane.abs().dot(half) >= 0.0;
        if !(inside(self.column)
            && inside(self.row)
            && inside(self.depth * self.width - self.column)
            && inside(self.depth * self.height - self.row))
        {
            return false;
        }
        let reach = self.depth.abs().dot(half);
        let nearest = self.depth.dot(centre) - reach;
        // The eye is in the box or almost: everything may be seen.
        if nearest <= 1e-6 * reach {
            return true;
        }
        let (low, high) = self.bounds(centre, half);
        !side.covered(low, high, 1.0 / nearest)
    }

    /// Low and high corner, in cell coordinates, of a box in front of the eye. Written in arrays of
    /// eight, one entry a corner, so that it becomes vector code.
    fn bounds(&self, centre: Vec3, half: Vec3) -> ([f32; 2], [f32; 2]) {
        const X: [f32; 8] = [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0];
        const Y: [f32; 8] = [-1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0];
        const Z: [f32; 8] = [-1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0];
        let along = |axis: Vec3| {
            let (middle, step) = (axis.dot(centre), axis * half);
            std::array::from_fn::<f32, 8, _>(|i| {
                middle + (X[i] * step.x + Y[i] * step.y + Z[i] * step.z)
            })
        };
        let depths = along(self.depth).map(|d| 1.0 / d);
        let range = |axis: Vec3| {
            let values = along(axis);
            let at: [f32; 8] = std::array::from_fn(|i| values[i] * depths[i]);
            let halves = |f: fn(f32, f32) -> f32| {
                let q: [f32; 4] = std::array::from_fn(|i| f(at[i], at[i + 4]));
                f(f(q[0], q[1]), f(q[2], q[3]))
            };
            (halves(|a, b| if b < a { b } else { a }), halves(|a, b| if b > a { b } else { a }))
        };
        let (columns, rows) = (range(self.column), range(self.row));
        ([columns.0, rows.0], [columns.1, rows.1])
    }
}
