//! Four triangles, tested against a ray in single precision at a time.

use glam::Vec3;
use wide::{CmpGt, CmpLt, f32x4};

/// Bound of the rounding of the triangle test, relative to the product of the lengths that go into
/// it: each sum of products has fewer than 16 roundings.
pub(super) const ROUNDING: f32 = 16.0 * f32::EPSILON;
/// Relative barycentric distance to an edge within which a ray counts as on the edge, widened.
const NEAR_EDGE: f32 = 2e-6;
/// Marks the lanes of a packet that hold no triangle.
pub(super) const NOTHING: u32 = u32::MAX;

/// Four triangles.
#[derive(Clone)]
pub(super) struct Packet {
    pub corner: [f32x4; 3],
    pub ab: [f32x4; 3],
    pub ac: [f32x4; 3],
    /// Length of the longer of the two edges, in the 1-norm.
    pub size: f32x4,
    /// That and the 1-norm of the corner.
    pub extent: f32x4,
    pub polygons: [u32; 4],
}

/// A ray prepared for the tests: the points `start + t way`, 0 < t <= 1.
pub(super) struct WideRay {
    pub start: [f32x4; 3],
    way: [f32x4; 3],
    pub inverse: [f32x4; 3],
    pub backwards: [bool; 3],
    /// 1-norms of `start` and `way`.
    place: f32x4,
    length: f32x4,
}

impl WideRay {
    pub fn new(start: Vec3, way: Vec3) -> Self {
        // A component of zero gets a huge finite inverse, so that no product is 0 times infinity.
        let inverse = way.to_array().map(|d| if d.abs() < 1e-30 { 1e30 } else { 1.0 / d });
        Self {
            start: start.to_array().map(f32x4::splat),
            way: way.to_array().map(f32x4::splat),
            inverse: inverse.map(f32x4::splat),
            backwards: inverse.map(|i| i < 0.0),
            place: f32x4::splat(start.abs().element_sum()),
            length: f32x4::splat(way.abs().element_sum()),
        }
    }
}

impl Packet {
    pub fn new(triangles: &[([Vec3; 3], u32)]) -> Self {
        let mut packet = Self {
            corner: [f32x4::ZERO; 3],
            ab: [f32x4::ZERO; 3],
            ac: [f32x4::ZERO; 3],
            size: f32x4::ZERO,
            extent: f32x4::ZERO,
            polygons: [NOTHING; 4],
        };
        for (lane, &([a, b, c], polygon)) in triangles.iter().enumerate() {
            let (ab, ac) = (b - a, c - a);
            for axis in 0..3 {
                packet.corner[axis].as_array_mut()[lane] = a[axis];
                packet.ab[axis].as_array_mut()[lane] = ab[axis];
                packet.ac[axis].as_array_mut()[lane] = ac[axis];
            }
            let size = ab.abs().element_sum().max(ac.abs().element_sum());
            packet.size.as_array_mut()[lane] = size;
            packet.extent.as_array_mut()[lane] = size + a.abs().element_sum();
            packet.polygons[lane] = polygon;
        }
        packet
    }

    /// Takes over a triangle of another packet.
    pub fn copy_lane(&mut self, to: usize, other: &Self, from: usize) {
        let copy = |into: &mut f32x4, of: &f32x4| into.as_array_mut()[to] = of.as_array_ref()[from];
        for axis in 0..3 {
            copy(&mut self.corner[axis], &other.corner[axis]);
            copy(&mut self.ab[axis], &other.ab[axis]);
            copy(&mut self.ac[axis], &other.ac[axis]);
        }
        copy(&mut self.size, &other.size);
        copy(&mut self.extent, &other.extent);
        self.polygons[to] = other.polygons[from];
    }

    /// Calls `visit(polygon, surely)` for the polygons that the ray may meet up to `limit`, other
    /// than the one `shown` last, as [`super::wide_tree::WideTree::walk`] says.
    #[inline]
    pub fn show(
        &self,
        ray: &WideRay,
        limit: &mut f32,
        shown: &mut u32,
        visit: &mut impl FnMut(u32, bool) -> f32,
    ) {
        let (mut possible, sure) = self.meet(ray, *limit);
        while possible != 0 {
            let lane = possible.trailing_zeros();
            possible &= possible - 1;
            let polygon = self.polygons[lane as usize];
            if polygon != *shown && polygon != NOTHING {
                *shown = polygon;
                *limit = limit.min(visit(polygon, sure >> lane & 1 == 1));
            }
        }
    }

    /// Masks of the triangles that the ray may meet, and of those that it surely meets inside, both
    /// with t up to `limit`. The test of Möller and Trumbore, "Fast, minimum storage ray/triangle
    /// intersection" (1997), both sides, without division.
    #[inline(always)] // It is the inmost loop of all rays; left to itself, the compiler often calls it.
    pub fn meet(&self, ray: &WideRay, limit: f32) -> (u32, u32) {
        let from_corner = [0, 1, 2].map(|i| ray.start[i] - self.corner[i]);
        let p = cross(ray.way, self.ac);
        let q = cross(from_corner, self.ab);
        let det = dot(self.ab, p);
        let sign = det & f32x4::splat(-0.0);
        let scale = det.abs();
        let u = dot(from_corner, p) ^ sign;
        let v = dot(ray.way, q) ^ sign;
        let t = dot(self.ac, q) ^ sign;
        let least = u.fast_min(v).fast_min(scale - u - v);
        // Lengths that go into the products bound the rounding of their sums.
        let unit = self.size * f32x4::splat(ROUNDING);
        let reach = ray.place + self.extent;
        let across = unit * ray.length * reach;
        let along = unit * self.size * (reach + ray.length);
        let edge = across + f32x4::splat(NEAR_EDGE) * scale;
        let flat = unit * ray.length * self.size;
        let end = f32x4::splat(limit) * scale;
        let turned = scale.cmp_gt(flat);
        let miss = turned & (least.cmp_lt(-edge) | t.cmp_lt(-along)) | t.abs().cmp_gt(end + along);
        let inside = turned & least.cmp_gt(edge) & t.cmp_gt(along) & t.cmp_lt(end - along);
        (!miss.move_mask() as u32 & 15, inside.move_mask() as u32)
    }
}

pub(super) fn dot(a: [f32x4; 3], b: [f32x4; 3]) -> f32x4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: [f32x4; 3], b: [f32x4; 3]) -> [f32x4; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
