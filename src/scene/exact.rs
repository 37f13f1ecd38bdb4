//! Vector arithmetic in the order of operations of the parity contract (section 0.2). glam adds
//! from the left, the contract from the right; one unit in the last place decides whether a luxel
//! truncates to the same level.

use glam::{DVec3, Vec3};

/// Dot product, `a0 b0 + (a1 b1 + a2 b2)`.
pub(crate) fn dot(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + (a.y * b.y + a.z * b.z)
}

/// Dot product in double precision, in the same order.
pub(crate) fn dot64(a: DVec3, b: DVec3) -> f64 {
    a.x * b.x + (a.y * b.y + a.z * b.z)
}

/// Euclidean length.
pub(crate) fn length(v: Vec3) -> f32 {
    dot(v, v).sqrt()
}

/// Unit vector by component-wise division; a zero vector stays zero.
pub(crate) fn normalize(v: Vec3) -> Vec3 {
    let l = length(v);
    if l == 0.0 { v } else { v / l }
}

/// Signed distance of a point from the plane `normal . p = dist`.
pub(crate) fn distance(p: Vec3, normal: Vec3, dist: f32) -> f32 {
    dot(p, normal) - dist
}

/// Mean of the channels.
pub(crate) fn brightness(c: Vec3) -> f32 {
    (c.x + c.y + c.z) / 3.0
}

/// Degrees to radians, in double precision.
pub(crate) fn radians(degrees: f32) -> f64 {
    f64::from(degrees) * (2.0 * std::f64::consts::PI / 360.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_from_a_plane() {
        for (z, want) in [(100.0, 90.0), (10.0, 0.0), (-5.0, -15.0)] {
            assert_eq!(distance(Vec3::new(-7.0, 3.0, z), Vec3::Z, 10.0), want);
        }
        // A plane through a point that its normal says.
        let (normal, point) = (normalize(Vec3::new(1.0, 2.0, 2.0)), Vec3::new(3.0, 0.0, 3.0));
        assert!((dot(normal, point) - 3.0).abs() < 1e-6);
        assert!(distance(point, normal, 3.0).abs() < 1e-6);
        assert_eq!(normalize(Vec3::ZERO), Vec3::ZERO);
    }
}
