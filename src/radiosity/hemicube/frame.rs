//! The coordinates of a view, (right, up, normal) from its eye: boxes and polygons are brought into
//! them once, and the five sides are then exchanges of axes.

use super::lanes::{Lanes, all, extent, greatest, least};
use super::outline::Cells;
use super::side::{Nearness, Side};
use super::{HemicubeSize, SIDES, SideId, View};
use crate::scene::Node;
use glam::Vec3;
use wide::{CmpGe, CmpLe, f32x4, f32x8};

/// A bit for each of the five sides, in the order of [`SIDES`].
pub(super) type SideSet = u8;

/// All five.
pub(super) const ALL_SIDES: SideSet = 31;

/// Backs are drawn farther by this factor, so that of two polygons back to back (a thin wall) the one
/// that faces the eye is seen, whatever the rounding.
const BACK: f32 = 1.0 - 1e-5;

/// A view with what tests of boxes against it need.
pub(super) struct Frame {
    eye: Vec3,
    axes: [Vec3; 3],
    /// Normals, component by component, of the planes through the eye between the sides: with x, y and z
    /// along the axes, where x + y, x - y, x + z, x - z, y + z, y - z and z are 0.
    planes: [f32x8; 3],
    sides: [SideFrame; 5],
}

/// How one side lies in the frame, and its cells.
struct SideFrame {
    /// Which axis of the frame its horizontal, vertical and depth axis are, and with which sign.
    axis: [usize; 3],
    sign: [f32; 3],
    /// Half the columns.
    columns: f32,
    /// Rows from vertical coordinate 0 to 1 at depth 1.
    rows: f32,
    /// Lowest vertical coordinate at depth 1, times -1.
    lowest: f32,
}

/// A box as its eight corners in the frame.
pub(super) struct Corners([f32x8; 3]);

impl Frame {
    pub fn new(view: &View, size: HemicubeSize) -> Self {
        let axes = [view.right, view.up, view.normal];
        let [x, y, z] = axes;
        let planes = [x + y, x - y, x + z, x - z, y + z, y - z, z, z];
        let along = |k: usize| f32x8::new(planes.map(|p| p[k]));
        Self {
            eye: view.position,
            axes,
            planes: [along(0), along(1), along(2)],
            sides: SIDES.map(|side| SideFrame::new(side, size)),
        }
    }

    /// The frame's coordinates of points in lanes.
    #[inline(always)]
    pub fn local<V: Lanes>(&self, [x, y, z]: &[V; 3]) -> [V; 3] {
        let all = V::all;
        let (x, y, z) = (*x - all(self.eye.x), *y - all(self.eye.y), *z - all(self.eye.z));
        let along = |axis: Vec3| x * all(axis.x) + y * all(axis.y) + z * all(axis.z);
        let [right, up, normal] = self.axes;
        [along(right), along(up), along(normal)]
    }

    /// Where the eye is, from a point.
    #[inline(always)]
    pub fn eye_from(&self, point: Vec3) -> Vec3 {
        self.eye - point
    }

    /// The side that a point is seen on, its column, row and depth there; `None` below the horizon.
    pub fn place(&self, point: Vec3) -> Option<(usize, [f32; 3])> {
        let from = point - self.eye;
        let [x, y, z] = self.axes.map(|axis| axis.dot(from));
        let number = match () {
            () if z < 0.0 => return None,
            () if z >= x.abs() && z >= y.abs() => 0,
            () if x.abs() >= y.abs() => {
                if x > 0.0 {
                    1
                } else {
                    3
                }
            }
            () => {
                if y > 0.0 {
                    2
                } else {
                    4
                }
            }
        };
        let side = &self.sides[number];
        let [across, along, depth] = side.turned(Vec3::new(x, y, z));
        let column = (across / depth + 1.0) * side.columns;
        Some((number, [column, (along / depth + side.lowest) * side.rows, depth]))
    }

    /// Squared distance from the eye to a node's box.
    pub fn distance(&self, node: &Node) -> f32 {
        (self.eye.clamp(node.min, node.max) - self.eye).length_squared()
    }

    /// Sides in whose view a node's box may reach.
    pub fn sides_of_box(&self, node: &Node) -> SideSet {
        let centre = (node.min + node.max) * 0.5 - self.eye;
        let half = (node.max - node.min) * 0.5;
        let [x, y, z] = &self.planes;
        let sum =
            |x: f32x8, y: f32x8, z: f32x8, v: Vec3| x * all(v.x) + y * all(v.y) + z * all(v.z);
        let (middle, reach) = (sum(*x, *y, *z, centre), sum(x.abs(), y.abs(), z.abs(), half));
        sides(middle + reach, middle - reach)
    }

    /// The corners of a node's box.
    pub fn corners(&self, node: &Node) -> Corners {
        const X: f32x8 = f32x8::new([-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0]);
        const Y: f32x8 = f32x8::new([-1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0]);
        const Z: f32x8 = f32x8::new([-1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0]);
        let centre = (node.min + node.max) * 0.5 - self.eye;
        let half = (node.max - node.min) * 0.5;
        let along = |axis: Vec3| {
            let step = axis * half;
            let steps = X * all(step.x) + Y * all(step.y);
            all(axis.dot(centre)) + (steps + Z * all(step.z))
        };
        let [right, up, normal] = self.axes;
        Corners([along(right), along(up), along(normal)])
    }

    /// Whether a box within the view of side `number` is behind cells of that side that are covered.
    pub fn hidden(&self, corners: &Corners, number: usize, side: &mut Side) -> bool {
        let frame = &self.sides[number];
        let along = |k: usize| corners.0[frame.axis[k]] * all(frame.sign[k]);
        let depth = along(2);
        let nearest = least(depth);
        // The eye is in the box or almost: everything may be seen.
        if nearest <= 1e-6 * (greatest(depth) - nearest) {
            return false;
        }
        let inverse = f32x8::ONE / depth;
        let around = frame.cells(extent(along(0) * inverse, along(1) * inverse));
        match Cells::between(around, side.size()) {
            Some(cells) => side.covered(cells, 1.0 / nearest),
            None => true,
        }
    }

    /// 1 / depth of the plane through `on` is this times the direction of depth 1. None for a plane
    /// through the eye, which is seen edge-on. `normal` and `on` are in the world.
    pub fn nearness(&self, on: Vec3, normal: Vec3) -> Option<Vec3> {
        let mut inverse = 1.0 / normal.dot(on - self.eye);
        if inverse > 0.0 {
            inverse *= BACK;
        }
        let slope = Vec3::from_array(self.axes.map(|axis| axis.dot(normal) * inverse));
        slope.is_finite().then_some(slope)
    }

    /// Side `number` of the frame.
    pub fn side(&self, number: usize) -> SideView<'_> {
        SideView(&self.sides[number])
    }
}

/// Projection to one side.
pub(super) struct SideView<'a>(&'a SideFrame);

impl SideView<'_> {
    /// Points of the frame, as the side's cells have them.
    #[inline(always)]
    pub fn project<V: Lanes>(&self, p: &[V; 3]) -> [V; 3] {
        let (f, all) = (self.0, V::all);
        let turned = |k: usize| p[f.axis[k]] * all(f.sign[k]);
        let (a, b, c) = (turned(0), turned(1), turned(2));
        [(a + c) * all(f.columns), (b + c * all(f.lowest)) * all(f.rows), c]
    }

    /// What [`Frame::nearness`] tells of a plane, cell by cell.
    pub fn nearness(&self, slope: Vec3) -> Nearness {
        let f = self.0;
        let [a, b, c] = f.turned(slope);
        Nearness { base: c - a - b * f.lowest, dx: a / f.columns, dy: b / f.rows }
    }
}

impl SideFrame {
    fn new(side: SideId, size: HemicubeSize) -> Self {
        // As `View::axes` has them.
        let (axis, sign) = match side {
            SideId::Top => ([0, 1, 2], [1.0, 1.0, 1.0]),
            SideId::Right => ([1, 2, 0], [1.0, 1.0, 1.0]),
            SideId::Up => ([0, 2, 1], [-1.0, 1.0, 1.0]),
            SideId::Left => ([1, 2, 0], [-1.0, 1.0, -1.0]),
            SideId::Down => ([0, 2, 1], [1.0, 1.0, -1.0]),
        };
        // The top spans [-1, 1] both ways, a side [-1, 1] x [0, 1].
        let lowest = if side == SideId::Top { 1.0 } else { 0.0 };
        Self {
            axis,
            sign,
            columns: 0.5 * size.width() as f32,
            rows: 0.5 * size.height() as f32,
            lowest,
        }
    }

    fn turned(&self, p: Vec3) -> [f32; 3] {
        let p = p.to_array();
        std::array::from_fn(|k| p[self.axis[k]] * self.sign[k])
    }

    /// Cell coordinates of two points at depth 1.
    fn cells(&self, points: f32x4) -> f32x4 {
        let (start, scale) = ([1.0, self.lowest], [self.columns, self.rows]);
        let twice = |[a, b]: [f32; 2]| f32x4::new([a, b, a, b]);
        (points + twice(start)) * twice(scale)
    }
}

/// The sides whose pyramids a box may reach into: of each plane of [`Frame`], `high` and `low` are the
/// largest and the smallest signed distance of the box to it.
fn sides(high: f32x8, low: f32x8) -> SideSet {
    // A bit each: part of the body is on the positive side of the plane, on the negative side.
    let above = high.cmp_ge(f32x8::ZERO).move_mask();
    let below = low.cmp_le(f32x8::ZERO).move_mask();
    let every = |above_of: i32, below_of: i32, side: u32| {
        u8::from(above & above_of == above_of && below & below_of == below_of) << side
    };
    const XY: i32 = 1;
    const X_Y: i32 = 2;
    const XZ: i32 = 4;
    const X_Z: i32 = 8;
    const YZ: i32 = 16;
    const Y_Z: i32 = 32;
    const Z: i32 = 64;
    every(XZ | YZ, X_Z | Y_Z, 0)
        | every(XY | X_Y | X_Z | Z, 0, 1)
        | every(XY | Y_Z | Z, X_Y, 2)
        | every(Z, XY | X_Y | XZ, 3)
        | every(X_Y | Z, XY | YZ, 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> View {
        View::turned(Vec3::new(3.0, -2.0, 5.0), Vec3::new(0.6, 0.0, 0.8), 5)
    }

    fn projected(frame: &Frame, side: usize, p: Vec3) -> [f32; 3] {
        let p = frame.side(side).project(&frame.local(&p.to_array().map(f32x8::splat)));
        p.map(|v| v.to_array()[3])
    }

    #[test]
    fn sides_have_the_axes_of_the_view() {
        let view = view();
        let size = HemicubeSize::new(16, 12).unwrap();
        let frame = Frame::new(&view, size);
        for (number, side) in SIDES.into_iter().enumerate() {
            for (x, y) in [(0, 0), (5, 3), (15, 5)] {
                let at = size.cell_centre(side, x, y);
                let [a, b, c] = view.axes(side);
                let p = view.position + (a * at.x + b * at.y + c) * 7.0;
                let [across, along, depth] = projected(&frame, number, p);
                let seen = [across / depth, along / depth, depth];
                let expected = [x as f32 + 0.5, y as f32 + 0.5, 7.0];
                for k in 0..3 {
                    assert!(
                        (seen[k] - expected[k]).abs() < 1e-4,
                        "{side:?}: {seen:?} {expected:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_point_is_in_the_side_that_it_projects_to() {
        let size = HemicubeSize::new(2, 2).unwrap();
        let frame = Frame::new(&view(), size);
        let at = |k: u32| ((k as f32 * 0.618).fract() - 0.5) * 10.0;
        for k in 0..500 {
            let p = Vec3::new(at(k), at(k / 7 + 300), at(k / 31 + 90));
            let node = Node { min: p, max: p, count: 0, first: 0 };
            let expected = (0..5).filter(|&side| {
                let [x, y, depth] = projected(&frame, side, p);
                let height = if side == 0 { 2.0 } else { 1.0 };
                x >= 0.0 && x <= 2.0 * depth && y >= 0.0 && y <= height * depth
            });
            let expected = expected.fold(0, |set, side| set | 1 << side);
            assert_eq!(frame.sides_of_box(&node), expected, "{p}");
        }
    }
}
