//! How the reference's ray tracer decides about a ray that meets the very edge of a polygon.
//!
//! Its single precision, with fused multiply-add in the box and triangle tests, lets some such rays
//! through and not others. Either answer is right for the scene; following its rounding makes whole
//! rows of luxels on whole-number maps equal. Fused operations are computed in double precision, in
//! which a product of two single numbers is exact.

use super::exact::length;
use glam::Vec3;

/// Components of directions smaller than this count as this.
const LEAST_DIRECTION: f32 = 1e-18;

/// Whether the reference counts the polygon `v` as between the two points.
pub(crate) fn blocked(v: &[Vec3], from: Vec3, to: Vec3) -> bool {
    let way = to - from;
    let reach = length(way);
    blocked_along(v, from, way / reach, reach)
}

/// Whether the reference counts the polygon `v` as met by a ray of length `reach` in the unit
/// direction `direction`.
pub(crate) fn blocked_along(v: &[Vec3], from: Vec3, direction: Vec3, reach: f32) -> bool {
    enters_box(v, from, direction, reach)
        && (2..v.len()).any(|i| meets_triangle([v[i - 1], v[i], v[0]], from, direction, reach))
}

/// Slab test against the bounding box of the polygon.
fn enters_box(v: &[Vec3], from: Vec3, direction: Vec3, reach: f32) -> bool {
    let min = v.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let max = v.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let (mut near, mut far) = (0.0_f32, reach);
    for axis in 0..3 {
        let d = direction[axis];
        let inverse = 1.0 / if d.abs() < LEAST_DIRECTION { LEAST_DIRECTION } else { d };
        let start = -(from[axis] * inverse);
        let (first, last) =
            if inverse >= 0.0 { (min[axis], max[axis]) } else { (max[axis], min[axis]) };
        near = near.max(fused(first, inverse, start));
        far = far.min(fused(last, inverse, start));
    }
    near <= far
}

/// Möller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997), both sides,
/// without division.
fn meets_triangle([a, b, c]: [Vec3; 3], from: Vec3, direction: Vec3, reach: f32) -> bool {
    let (ab, ac) = (a - b, c - a);
    let normal = cross(ac, ab);
    let to_a = a - from;
    let r = cross(to_a, direction);
    let det = dot(normal, direction);
    let (sign, det) = (det.signum(), det.abs());
    let (u, v, t) = (dot(r, ac) * sign, dot(r, ab) * sign, dot(normal, to_a) * sign);
    det > 0.0 && u >= 0.0 && v >= 0.0 && u + v <= det && t > 0.0 && t <= det * reach
}

/// `a b + c` rounded once.
fn fused(a: f32, b: f32, c: f32) -> f32 {
    (f64::from(a) * f64::from(b) + f64::from(c)) as f32
}

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(
        fused(a.y, b.z, -(a.z * b.y)),
        fused(a.z, b.x, -(a.x * b.z)),
        fused(a.x, b.y, -(a.y * b.x)),
    )
}

fn dot(a: Vec3, b: Vec3) -> f32 {
    fused(a.x, b.x, fused(a.y, b.y, a.z * b.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clear_cases_are_clear() {
        let square =
            [[0.0, 0.0], [0.0, 8.0], [8.0, 8.0], [8.0, 0.0]].map(|[y, z]| Vec3::new(0.0, y, z));
        let from = Vec3::new(-3.0, 1.0, 2.0);
        assert!(blocked(&square, from, Vec3::new(4.0, 5.0, 3.0)));
        assert!(!blocked(&square, from, Vec3::new(4.0, -5.0, 3.0)));
        assert!(!blocked(&square, from, Vec3::new(-1.0, 5.0, 3.0)));
        assert!(!blocked(&square, from, from), "a ray of no length");
    }

    #[test]
    fn rays_in_the_plane_of_a_rim_pass_on_one_side() {
        // What the reference does with a ray at y = 8 along the upper end of a box, and at y = 0.
        let square =
            [[0.0, 0.0], [0.0, 8.0], [8.0, 8.0], [8.0, 0.0]].map(|[y, z]| Vec3::new(0.0, y, z));
        let ray = |y: f32| blocked(&square, Vec3::new(-3.0, y, 2.0), Vec3::new(4.0, y, 3.0));
        assert!(!ray(8.0));
        assert!(ray(0.0));
    }
}
