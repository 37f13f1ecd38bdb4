//! Drawing a hemicube: the hierarchy is walked front to back once a side, and what lies behind
//! covered tiles is skipped.

use super::clip::{Homogeneous, clip};
use super::side::{NOTHING, Nearness, Side};
use super::{HemicubeSize, SIDES, SideId, View};
use crate::scene::{Node, Tracer};
use glam::Vec3;

/// Which polygon a point sees through each cell. Reused from one hemicube to the next.
pub struct ItemBuffer {
    size: HemicubeSize,
    sides: [Side; 5],
    stack: Vec<u32>,
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
            stack: Vec::new(),
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

    /// Visits all cells, in a fixed order.
    pub fn for_each_row(&self, mut visit: impl FnMut(Cells<'_>)) {
        for (side, id) in self.sides.iter().zip(SIDES) {
            side.for_each_row(|x, y, items, nearness| {
                visit(Cells { side: id, x: x as u32, y: y as u32, items, nearness });
            });
        }
    }

    fn draw_side(&mut self, side: usize, tracer: &Tracer, projection: &Projection) {
        self.stack.clear();
        self.stack.push(0);
        while let Some(index) = self.stack.pop() {
            let node = &tracer.nodes()[index as usize];
            if !projection.may_be_seen(node, &mut self.sides[side]) {
                continue;
            }
            if node.count > 0 {
                for slot in node.first..node.first + node.count {
                    self.draw_polygon(side, tracer, slot, projection);
                }
            } else {
                let (a, b) = (node.first, node.first + 1);
                let distance = |n: u32| projection.distance(&tracer.nodes()[n as usize]);
                let (near, far) = if distance(a) <= distance(b) { (a, b) } else { (b, a) };
                self.stack.push(far);
                self.stack.push(near);
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
        target.fill(&self.corners, nearness, item);
    }
}

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
        let inverse = 1.0 / normal.dot(on - self.eye);
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
        let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        for corner in 0..8u32 {
            let sign = |bit: u32| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
            let p = centre + half * Vec3::new(sign(0), sign(1), sign(2));
            let inverse = 1.0 / self.depth.dot(p);
            let at = [self.column.dot(p) * inverse, self.row.dot(p) * inverse];
            for k in 0..2 {
                low[k] = low[k].min(at[k]);
                high[k] = high[k].max(at[k]);
            }
        }
        !side.covered(low, high, 1.0 / nearest)
    }
}
