//! Closed forms between polygons by contour integrals: Lambert's formula from a point, and the
//! double integral of ln r along both outlines from one polygon to another.
//!
//! Source: E. M. Sparrow, "A new and simpler formulation for radiative angle factors" (1963): by
//! Stokes' theorem 2 pi A_i F_ij = sum over pairs of edges of (u . v) times the integral of ln r.

use glam::DVec3;
use std::f64::consts::PI;

/// Form factor, in [0, 1], from a point of a surface with unit normal `normal` to a convex polygon
/// that lies in front of that surface and turns its front (counter-clockwise side) to the point.
pub fn point_to_polygon(point: DVec3, normal: DVec3, polygon: &[DVec3]) -> f64 {
    let Some(&last) = polygon.last() else { return 0.0 };
    let mut sum = 0.0;
    let mut from = last - point;
    for &corner in polygon {
        let to = corner - point;
        let cross = to.cross(from);
        let sine = cross.length();
        // An edge that points at the eye subtends nothing, whatever its normal.
        if sine > 0.0 {
            sum += sine.atan2(from.dot(to)) * cross.dot(normal) / sine;
        }
        from = to;
    }
    (sum / (2.0 * PI)).clamp(0.0, 1.0)
}

/// The part of a convex polygon at or above a plane: `normal . (p - on) >= 0`.
pub fn clip_front(polygon: &[DVec3], on: DVec3, normal: DVec3, out: &mut Vec<DVec3>) {
    out.clear();
    let height = |p: DVec3| normal.dot(p - on);
    let Some(&last) = polygon.last() else { return };
    let (mut from, mut from_height) = (last, height(last));
    for &to in polygon {
        let to_height = height(to);
        if (from_height < 0.0) != (to_height < 0.0) {
            out.push(from + (to - from) * (from_height / (from_height - to_height)));
        }
        if to_height >= 0.0 {
            out.push(to);
        }
        (from, from_height) = (to, to_height);
    }
}

/// What two convex polygons exchange when nothing is between them: A_i F_ij = A_j F_ji, in square
/// world units. Both lie in front of each other ([`clip_front`]) and are counter-clockwise seen from
/// their fronts. Exact for parallel edges, else to about `error` (square world units).
///
/// The terms grow with r^2 ln r and cancel: for polygons more than a thousand diameters apart use
/// [`point_to_polygon`] instead.
pub fn exchange(a: &[DVec3], b: &[DVec3], error: f64) -> f64 {
    let edges = (a.len() * b.len()) as f64;
    let mut sum = 0.0;
    for (i, &a1) in a.iter().enumerate() {
        let a0 = a[(i + a.len() - 1) % a.len()];
        for (j, &b1) in b.iter().enumerate() {
            let b0 = b[(j + b.len() - 1) % b.len()];
            sum += edge_pair([a0, a1], [b0, b1], 2.0 * PI * error / edges);
        }
    }
    (sum / (2.0 * PI)).max(0.0)
}

/// Edges whose directions differ by less than this angle count as parallel.
const PARALLEL: f64 = 1e-9;

/// (u . v) times the double integral of ln r over two edges with the unit directions u and v.
fn edge_pair(a: [DVec3; 2], b: [DVec3; 2], error: f64) -> f64 {
    let (la, lb) = (a[0].distance(a[1]), b[0].distance(b[1]));
    if la == 0.0 || lb == 0.0 {
        return 0.0;
    }
    let (u, v) = ((a[1] - a[0]) / la, (b[1] - b[0]) / lb);
    let cosine = u.dot(v);
    if cosine.abs() < 1e-15 {
        return 0.0;
    }
    if u.cross(v).length() < PARALLEL {
        // Along the common direction: edge a is [0, la], edge b is [s0, s1].
        let (s0, s1) = (u.dot(b[0] - a[0]), u.dot(b[1] - a[0]));
        let beside = (b[0] - a[0] - u * s0).length();
        let second = |z: f64| ln_twice(z, beside);
        return second(s1) - second(s1 - la) - (second(s0) - second(s0 - la));
    }
    // The inner integral is in closed form, the outer one by quadrature along the shorter edge.
    let (from, along, length, start, direction, reach) =
        if la <= lb { (a[0], u, la, b[0], v, lb) } else { (b[0], v, lb, a[0], u, la) };
    let inner = |t: f64| {
        let p = from + along * t - start;
        let s = direction.dot(p);
        let beside = (p - direction * s).length();
        ln_once(reach - s, beside) - ln_once(-s, beside)
    };
    cosine * adaptive(&inner, 0.0, length, error / cosine.abs(), DEEPEST)
}

/// Antiderivative in z of ln sqrt(z^2 + d^2).
fn ln_once(z: f64, d: f64) -> f64 {
    let square = z * z + d * d;
    if square == 0.0 {
        return 0.0;
    }
    0.5 * z * square.ln() - z + d * z.atan2(d)
}

/// Antiderivative of [`ln_once`] in z.
fn ln_twice(z: f64, d: f64) -> f64 {
    let square = z * z + d * d;
    if square == 0.0 {
        return 0.0;
    }
    0.25 * (z * z - d * d) * square.ln() - 0.75 * z * z + d * z * z.atan2(d)
}

/// How often an interval is halved at most: ends with logarithmic kinks need about half of it.
const DEEPEST: u32 = 40;

/// Nodes in (0, 1) and weights of the Kronrod rule of 15 points, and weights of the Gauss rule of 7
/// points that it contains; the rule is symmetric.
const KRONROD: [(f64, f64, f64); 8] = [
    (0.991_455_371_120_812_6, 0.022_935_322_010_529_22, 0.0),
    (0.949_107_912_342_758_5, 0.063_092_092_629_978_55, 0.129_484_966_168_869_7),
    (0.864_864_423_359_769_1, 0.104_790_010_322_250_18, 0.0),
    (0.741_531_185_599_394_4, 0.140_653_259_715_525_9, 0.279_705_391_489_276_7),
    (0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0),
    (0.405_845_151_377_397_2, 0.190_350_578_064_785_4, 0.381_830_050_505_118_9),
    (0.207_784_955_007_898_47, 0.204_432_940_075_298_9, 0.0),
    (0.0, 0.209_482_141_084_727_8, 0.417_959_183_673_469_4),
];

/// Integral of `f` from `low` to `high`, halved until two rules agree.
fn adaptive(f: &impl Fn(f64) -> f64, low: f64, high: f64, error: f64, depth: u32) -> f64 {
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let (mut fine, mut coarse, mut size) = (0.0, 0.0, 0.0);
    for (x, kronrod, gauss) in KRONROD {
        let value = if x == 0.0 { f(middle) } else { f(middle - half * x) + f(middle + half * x) };
        size += kronrod * value.abs();
        fine += kronrod * value;
        coarse += gauss * value;
    }
    let apart = half * (fine - coarse).abs();
    // Below the rounding error of the sum, halving gains nothing.
    if apart <= error.max(half * size * 1e-14) || depth == 0 || apart.is_nan() {
        return half * fine;
    }
    adaptive(f, low, middle, 0.5 * error, depth - 1)
        + adaptive(f, middle, high, 0.5 * error, depth - 1)
}

/// Area of a flat polygon.
pub fn area(polygon: &[DVec3]) -> f64 {
    let Some(&origin) = polygon.first() else { return 0.0 };
    polygon[1..]
        .windows(2)
        .fold(DVec3::ZERO, |sum, p| sum + (p[0] - origin).cross(p[1] - origin))
        .length()
        * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiosity::area_points::gauss;

    const X: DVec3 = DVec3::X;
    const Y: DVec3 = DVec3::Y;
    const Z: DVec3 = DVec3::Z;

    /// Counter-clockwise about u x v.
    fn parallelogram(origin: DVec3, u: DVec3, v: DVec3) -> Vec<DVec3> {
        vec![origin, origin + u, origin + u + v, origin + v]
    }

    /// Form factor between equal rectangles x by y, opposite at distance z (Howell C-11).
    fn opposite(x: f64, y: f64, z: f64) -> f64 {
        let (x, y) = (x / z, y / z);
        let (rx, ry) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
        let log = ((rx * ry).powi(2) / (1.0 + x * x + y * y)).ln() / 2.0;
        let arcs =
            x * ry * (x / ry).atan() + y * rx * (y / rx).atan() - x * x.atan() - y * y.atan();
        2.0 / (PI * x * y) * (log + arcs)
    }

    /// Form factor from a rectangle l by w to one l by h that stands upright on its edge l
    /// (Howell C-14).
    fn upright(l: f64, w: f64, h: f64) -> f64 {
        let (h, w) = (h / l, w / l);
        let (h2, w2) = (h * h, w * w);
        let both = (h2 + w2).sqrt();
        let a = (1.0 + w2) * (1.0 + h2) / (1.0 + w2 + h2);
        let b = w2 * (1.0 + w2 + h2) / ((1.0 + w2) * (w2 + h2));
        let c = h2 * (1.0 + h2 + w2) / ((1.0 + h2) * (h2 + w2));
        let logs = 0.25 * (a.ln() + w2 * b.ln() + h2 * c.ln());
        let arcs = w * (1.0 / w).atan() + h * (1.0 / h).atan() - both * (1.0 / both).atan();
        (arcs + logs) / (PI * w)
    }

    #[track_caller]
    fn close(got: f64, want: f64, relative: f64) {
        assert!((got / want - 1.0).abs() < relative, "{got} instead of {want}");
    }

    #[test]
    fn opposite_rectangles_at_any_distance() {
        for (x, y) in [(1.0, 1.0), (3.0, 0.5), (1.0, 0.01)] {
            for z in [1e-4, 0.01, 0.1, 1.0, 10.0] {
                let a = parallelogram(DVec3::ZERO, X * x, Y * y);
                let b = parallelogram(Z * z, Y * y, X * x);
                close(exchange(&a, &b, 1e-10) / (x * y), opposite(x, y, z), 1e-7);
            }
        }
    }

    #[test]
    fn upright_rectangles_that_share_an_edge() {
        for (l, w, h) in [(1.0, 1.0, 1.0), (2.0, 0.1, 5.0), (1.0, 1e-3, 1.0), (1.0, 1.0, 1e-4)] {
            let a = parallelogram(DVec3::ZERO, X * w, Y * l);
            let b = parallelogram(DVec3::ZERO, Y * l, Z * h);
            close(exchange(&a, &b, 1e-10) / (w * l), upright(l, w, h), 1e-7);
        }
    }

    #[test]
    fn offset_squares_by_form_factor_algebra() {
        // Opposite squares side by side: what four squares exchange with four is known.
        let square = |x: f64, z: f64, up: bool| {
            let o = DVec3::new(x, 0.0, z);
            if up { parallelogram(o, X, Y) } else { parallelogram(o, Y, X) }
        };
        let both = 2.0 * opposite(2.0, 1.0, 1.0);
        let diagonal = (both - 2.0 * opposite(1.0, 1.0, 1.0)) / 2.0;
        close(exchange(&square(0.0, 0.0, true), &square(1.0, 1.0, false), 1e-10), diagonal, 1e-8);
    }

    /// Brute force: the point formula over a mesh of `n` x `n` cells of the parallelogram.
    fn by_points(a: [DVec3; 3], n: usize, b: &[DVec3]) -> f64 {
        let [origin, u, v] = a;
        let normal = u.cross(v).normalize();
        let mut sum = 0.0;
        // Cells shrink towards the edges, where the integrand is steep.
        let cut = |k: usize| 0.5 - 0.5 * (PI * k as f64 / n as f64).cos();
        for (i, j) in (0..n * n).map(|k| (k % n, k / n)) {
            let (s, t) = ([cut(i), cut(i + 1)], [cut(j), cut(j + 1)]);
            let corner = origin + u * s[0] + v * t[0];
            let cell = parallelogram(corner, u * (s[1] - s[0]), v * (t[1] - t[0]));
            gauss(&cell, 3, |p, w| sum += w * point_to_polygon(p, normal, b));
        }
        sum
    }

    #[test]
    fn wedges_of_any_angle_match_the_point_formula() {
        for degrees in [0.1f64, 1.0, 5.0, 30.0, 77.0, 130.0, 179.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let a = [DVec3::ZERO, X, Y];
            // Skewed, so that no edges but the shared one are parallel.
            let wall = (X * cos + Z * sin) + Y * 0.2;
            let b = parallelogram(DVec3::ZERO, Y, wall);
            let got = exchange(&parallelogram(a[0], a[1], a[2]), &b, 1e-10);
            close(got, by_points(a, 60, &b), if degrees < 10.0 { 2e-4 } else { 2e-5 });
            assert!(got <= 1.0);
        }
    }

    #[test]
    fn the_exchange_is_the_same_both_ways() {
        let a = parallelogram(DVec3::ZERO, X, Y);
        let b = parallelogram(DVec3::new(0.3, -2.0, 1.5), Y * 0.3 + Z * 0.1, X * 2.0 - Z * 0.2);
        close(exchange(&a, &b, 1e-12), exchange(&b, &a, 1e-12), 1e-9);
    }

    #[test]
    fn slivers_and_extreme_ratios_match_the_point_formula() {
        let sliver = parallelogram(DVec3::new(-5.0, 0.4, 0.3), Y * 1e-4, X * 10.0);
        close(
            exchange(&parallelogram(DVec3::ZERO, X, Y), &sliver, 1e-12),
            by_points([DVec3::ZERO, X, Y], 40, &sliver),
            1e-4,
        );
        let huge = parallelogram(DVec3::new(-500.0, -500.0, 1.0), Y * 1e3, X * 1e3);
        let tiny = parallelogram(DVec3::ZERO, X * 1e-2, Y * 1e-2);
        close(exchange(&tiny, &huge, 1e-12) / 1e-4, 1.0, 1e-4);
    }

    #[test]
    fn a_point_sees_polygons_by_the_catalogue() {
        use crate::radiosity::form_factor::{parallel_corner, rectangle};
        let above = [[-0.3, 0.8], [0.1, 0.9]];
        let want = rectangle(parallel_corner, above[0], above[1]);
        let polygon = parallelogram(DVec3::new(-0.3, 0.1, 1.0), Y * 0.8, X * 1.1);
        close(point_to_polygon(DVec3::ZERO, Z, &polygon), want, 1e-12);
        assert_eq!(point_to_polygon(DVec3::ZERO, Z, &[]), 0.0);
        let away: Vec<DVec3> = polygon.iter().rev().copied().collect();
        assert_eq!(point_to_polygon(DVec3::ZERO, Z, &away), 0.0, "its back is turned");
    }

    #[test]
    fn clipping_keeps_what_is_above() {
        let mut kept = Vec::new();
        clip_front(&parallelogram(-X - Z, X * 2.0, Z * 2.0), DVec3::ZERO, Z, &mut kept);
        assert!((area(&kept) - 2.0).abs() < 1e-12 && kept.iter().all(|p| p.z >= 0.0));
        clip_front(&parallelogram(-X - Z, X * 2.0, Z * 0.5), DVec3::ZERO, Z, &mut kept);
        assert!(kept.is_empty() && area(&kept) == 0.0);
    }

    #[test]
    fn wild_numbers_come_back() {
        let nan = vec![DVec3::NAN; 3];
        exchange(&nan, &parallelogram(DVec3::ZERO, X, Y), 1e-8);
        exchange(&[DVec3::ZERO; 4], &parallelogram(DVec3::ZERO, X, Y), 0.0);
        assert_eq!(exchange(&[], &nan, 1e-8), 0.0);
    }
}
