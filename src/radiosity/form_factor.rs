//! Closed-form form factors. All are dimensionless, in [0, 1].
//!
//! Sources: J. R. Howell, *A Catalog of Radiation Heat Transfer Configuration Factors*; the corner
//! functions are the double integrals of cos a cos b / (pi r^2) in closed form.

use std::f64::consts::PI;

/// Form factor from a point to the rectangle `[0, x] x [0, y]` at height 1 above it, parallel to the
/// point's own surface (Howell B-3). Odd in `x` and in `y`, so any rectangle is a signed sum of four.
pub fn parallel_corner(x: f64, y: f64) -> f64 {
    let (rx, ry) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / rx * (y / rx).atan() + y / ry * (x / ry).atan()) / (2.0 * PI)
}

/// Antiderivative for a rectangle at distance 1 that stands upright on the point's surface: `a` runs
/// along the surface, `b >= 0` along its normal (Howell B-4). Even in `b`, odd in `a`.
pub fn upright_corner(a: f64, b: f64) -> f64 {
    let r = (1.0 + b * b).sqrt();
    -(a / r).atan() / (2.0 * PI * r)
}

/// Share of the whole sphere of directions that the rectangle `[0, x] x [0, y]` at distance 1 fills: its
/// solid angle over 4 pi. Odd in `x` and in `y`.
pub fn sphere_corner(x: f64, y: f64) -> f64 {
    (x * y / (1.0 + x * x + y * y).sqrt()).atan() / (4.0 * PI)
}

/// Sum of a corner function over the four corners of a rectangle, with the signs of a definite
/// double integral.
pub fn rectangle(corner: impl Fn(f64, f64) -> f64, x: [f64; 2], y: [f64; 2]) -> f64 {
    (corner(x[1], y[1]) - corner(x[0], y[1])) - (corner(x[1], y[0]) - corner(x[0], y[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Midpoint rule with n x n points.
    fn integrate(f: impl Fn(f64, f64) -> f64, x: [f64; 2], y: [f64; 2], n: usize) -> f64 {
        let (dx, dy) = ((x[1] - x[0]) / n as f64, (y[1] - y[0]) / n as f64);
        let at = |i: usize, o: f64, d: f64| o + (i as f64 + 0.5) * d;
        (0..n * n).map(|k| f(at(k % n, x[0], dx), at(k / n, y[0], dy))).sum::<f64>() * dx * dy
    }

    #[test]
    fn parallel_rectangle_matches_numeric_integration() {
        let (x, y) = ([-0.3, 0.8], [0.1, 0.9]);
        let exact = rectangle(parallel_corner, x, y);
        let numeric = integrate(|x, y| 1.0 / (PI * (1.0 + x * x + y * y).powi(2)), x, y, 400);
        assert!((exact - numeric).abs() < 1e-6, "{exact} {numeric}");
    }

    #[test]
    fn upright_rectangle_matches_numeric_integration() {
        let (a, b) = ([-0.7, 0.2], [0.25, 1.0]);
        let exact = rectangle(upright_corner, a, b);
        let numeric = integrate(|a, b| b / (PI * (1.0 + a * a + b * b).powi(2)), a, b, 400);
        assert!((exact - numeric).abs() < 1e-6, "{exact} {numeric}");
    }

    #[test]
    fn solid_angle_matches_numeric_integration() {
        let (x, y) = ([-0.3, 0.8], [0.1, 0.9]);
        let exact = rectangle(sphere_corner, x, y);
        let numeric = integrate(|x, y| (1.0 + x * x + y * y).powf(-1.5) / (4.0 * PI), x, y, 400);
        assert!((exact - numeric).abs() < 1e-6, "{exact} {numeric}");
    }

    #[test]
    fn infinite_plane_above_takes_everything() {
        let far = [-1e9, 1e9];
        assert!((rectangle(parallel_corner, far, far) - 1.0).abs() < 1e-8);
        assert!((rectangle(upright_corner, far, [0.0, 1e9]) - 0.5).abs() < 1e-8);
    }
}
