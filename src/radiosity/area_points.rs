//! Points on convex polygons: for quadrature, and spread evenly for sampling.

use glam::{DVec2, DVec3};

/// Gauss-Legendre nodes in [0, 1] and weights that sum to 1, for 1 to 4 points.
const GAUSS: [&[(f64, f64)]; 4] = [
    &[(0.5, 1.0)],
    &[(0.211_324_865_405_187_1, 0.5), (0.788_675_134_594_812_9, 0.5)],
    &[
        (0.112_701_665_379_258_3, 5.0 / 18.0),
        (0.5, 8.0 / 18.0),
        (0.887_298_334_620_741_7, 5.0 / 18.0),
    ],
    &[
        (0.069_431_844_202_973_7, 0.173_927_422_568_726_9),
        (0.330_009_478_207_571_9, 0.326_072_577_431_273_1),
        (0.669_990_521_792_428_1, 0.326_072_577_431_273_1),
        (0.930_568_155_797_026_3, 0.173_927_422_568_726_9),
    ],
];

/// Calls `visit(point, area)` for the points of a product rule of `order` x `order` points (1 to 4)
/// on each quad that the convex polygon is made of; the areas sum to that of the polygon.
pub fn gauss(polygon: &[DVec3], order: usize, mut visit: impl FnMut(DVec3, f64)) {
    let rule = GAUSS[order.clamp(1, 4) - 1];
    let mut from = 1;
    while from + 1 < polygon.len() {
        let to = (from + 2).min(polygon.len() - 1);
        let (a, b, c) = (polygon[0], polygon[from], polygon[from + 1]);
        // A triangle is a quad whose last corner is its first.
        let d = if to == from + 2 { polygon[to] } else { a };
        for &(s, ws) in rule {
            for &(t, wt) in rule {
                let (du, dv) = ((b - a).lerp(c - d, t), (d - a).lerp(c - b, s));
                let point = a.lerp(b, s).lerp(d.lerp(c, s), t);
                visit(point, ws * wt * du.cross(dv).length());
            }
        }
        from += 2;
    }
}

/// Maps points of the unit square evenly to convex polygons.
pub struct Spread {
    triangles: Vec<[DVec3; 3]>,
    /// Area of the triangles up to and with each.
    sums: Vec<f64>,
}

impl Spread {
    /// There is at least one polygon, and each has at least three corners.
    pub fn new<'a>(polygons: impl IntoIterator<Item = &'a [DVec3]>) -> Self {
        let fan = |p: &'a [DVec3]| p[1..].windows(2).map(|edge| [p[0], edge[0], edge[1]]);
        let triangles: Vec<[DVec3; 3]> = polygons.into_iter().flat_map(fan).collect();
        let mut sum = 0.0;
        let sums = triangles
            .iter()
            .map(|[a, b, c]| {
                sum += 0.5 * (b - a).cross(c - a).length();
                sum
            })
            .collect();
        Self { triangles, sums }
    }

    /// The point for `at` in the unit square.
    pub fn point(&self, at: DVec2) -> DVec3 {
        let last = self.sums.len() - 1;
        let target = at.x * self.sums[last];
        let k = self.sums.iter().position(|&s| target < s).unwrap_or(last);
        let below = if k == 0 { 0.0 } else { self.sums[k - 1] };
        let share = ((target - below) / (self.sums[k] - below)).clamp(0.0, 1.0);
        let [a, b, c] = self.triangles[k];
        if share.is_nan() {
            return a;
        }
        // The fan opens from the first corner, so neighbouring triangles join along `share`.
        let across = b.lerp(c, share);
        a.lerp(across, at.y.sqrt())
    }
}

/// The `k`-th point of an evenly spread sequence in `N` dimensions (M. Roberts, "The unreasonable
/// effectiveness of quasirandom sequences", 2018), shifted by `shift` in [0, 1) along all of them.
pub fn spread<const N: usize>(k: u32, shift: f64) -> [f64; N] {
    // The root of x^(N + 1) = x + 1, by iteration.
    let root = (0..40).fold(1.5f64, |x, _| (1.0 + x).powf(1.0 / (N as f64 + 1.0)));
    std::array::from_fn(|d| {
        let step = root.powi(-(d as i32) - 1);
        (shift * (d as f64 + 1.0) + 0.5 + f64::from(k) * step).fract()
    })
}

/// The `k`-th point of Sobol's sequence in four dimensions (I. Sobol, "On the distribution of points in a
/// cube and the approximate evaluation of integrals", 1967), its bits turned over by those of `seed`. Where
/// what is summed jumps, powers of two of them err by half as much as points of [`spread`].
pub fn sobol(k: u32, seed: u32) -> [f64; 4] {
    // Primitive polynomials 1, x + 1, x^2 + x + 1, x^3 + x + 1: degree, inner coefficients, first numbers.
    const AXES: [(usize, u32, [u32; 3]); 4] =
        [(0, 0, [0; 3]), (1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];
    let mut turn = seed;
    AXES.map(|(degree, inner, first)| {
        let mut directions = [0u32; 32];
        let mut bits = 0;
        for i in 0..32 - k.leading_zeros() as usize {
            directions[i] = if degree == 0 {
                1 << (31 - i)
            } else if i < degree {
                first[i] << (31 - i)
            } else {
                let last = directions[i - degree];
                (1..degree)
                    .filter(|j| inner >> (degree - 1 - j) & 1 == 1)
                    .fold(last ^ (last >> degree), |v, j| v ^ directions[i - j])
            };
            if k >> i & 1 == 1 {
                bits ^= directions[i];
            }
        }
        turn = (turn ^ (turn >> 15)).wrapping_mul(0x2c1b_3c6d).wrapping_add(0x9e37_79b9);
        (f64::from(bits ^ turn) + 0.5) / 2f64.powi(32)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every cell of every division of two axes into 16 equal boxes has its share of the points.
    #[test]
    fn sobol_points_are_even() {
        for seed in [0, 1, 77] {
            let points: Vec<[f64; 4]> = (0..256).map(|k| sobol(k, seed)).collect();
            for d in 0..4 {
                let mut count = [0; 256];
                points.iter().for_each(|p| count[(p[d] * 256.0) as usize] += 1);
                assert_eq!(count, [1; 256], "axis {d}");
            }
            let mut count = [0; 256];
            points.iter().for_each(|p| {
                count[(p[0] * 16.0) as usize * 16 + (p[1] * 16.0) as usize] += 1;
            });
            assert_eq!(count, [1; 256], "the first two");
        }
    }

    fn pentagon() -> Vec<DVec3> {
        [(0.0, 0.0), (3.0, -1.0), (4.0, 1.0), (2.0, 3.0), (0.0, 2.0)]
            .map(|(x, y)| DVec3::new(x, y, 1.0))
            .to_vec()
    }

    #[test]
    fn the_rules_are_exact_for_low_polynomials() {
        // Area, and the integral of x, of the pentagon.
        let p = pentagon();
        let (mut area, mut moment) = (0.0, 0.0);
        for w in p[1..].windows(2) {
            let a = 0.5 * (w[0] - p[0]).cross(w[1] - p[0]).length();
            area += a;
            moment += a * (p[0].x + w[0].x + w[1].x) / 3.0;
        }
        for order in 1..=4 {
            let (mut weights, mut x) = (0.0, 0.0);
            gauss(&p, order, |q, w| {
                weights += w;
                x += w * q.x;
                assert!((q.z - 1.0).abs() < 1e-12);
            });
            assert!((weights - area).abs() < 1e-12, "order {order}");
            assert!(order == 1 || (x - moment).abs() < 1e-12, "order {order}: {x} {moment}");
        }
    }

    #[test]
    fn points_are_spread_evenly() {
        let p = pentagon();
        let on = Spread::new([&p[..]]);
        let n = 4000;
        let mut mean = DVec3::ZERO;
        for k in 0..n {
            let q = on.point(DVec2::from_array(spread(k, 0.3)));
            let inside = (0..5).all(|i| (p[(i + 1) % 5] - p[i]).cross(q - p[i]).z >= -1e-9);
            assert!(inside, "{q}");
            mean += q / f64::from(n);
        }
        let (mut area, mut moment) = (0.0, DVec3::ZERO);
        gauss(&p, 2, |q, w| {
            area += w;
            moment += q * w;
        });
        assert!((mean - moment / area).length() < 2e-3, "{mean} {}", moment / area);
    }

    #[test]
    fn polygons_without_area_give_points_too() {
        let line = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        assert!(Spread::new([&line[..]]).point(DVec2::new(0.7, 0.2)).is_finite());
    }
}
