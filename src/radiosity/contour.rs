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
