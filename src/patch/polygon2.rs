//! Convex polygons in luxel coordinates.

use glam::DVec2;

/// Keeps the part of the convex polygon `points` where `distance`, which is linear, is at least 0.
pub(super) fn clip(points: &[DVec2], distance: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let mut kept = Vec::with_capacity(points.len() + 1);
    for (i, &to) in points.iter().enumerate() {
        let from = points[(i + points.len() - 1) % points.len()];
        let (a, b) = (distance(from), distance(to));
        if (a < 0.0) != (b < 0.0) {
            kept.push(from + (to - from) * (a / (a - b)));
        }
        if b >= 0.0 {
            kept.push(to);
        }
    }
    kept
}

/// The part of a convex polygon with `low <= coordinate[axis] <= high`.
pub(super) fn strip(points: &[DVec2], axis: usize, low: f64, high: f64) -> Vec<DVec2> {
    clip(&clip(points, |p| high - p[axis]), |p| p[axis] - low)
}

/// Area (at least 0, in square luxels) and area times centroid.
pub(super) fn moments(points: &[DVec2]) -> (f64, DVec2) {
    let Some(&origin) = points.first() else { return (0.0, DVec2::ZERO) };
    let (mut area, mut moment) = (0.0, DVec2::ZERO);
    for pair in points[1..].windows(2) {
        let (a, b) = (pair[0] - origin, pair[1] - origin);
        let doubled = a.perp_dot(b);
        area += 0.5 * doubled;
        moment += (a + b) * (doubled / 6.0);
    }
    (area.abs(), moment * area.signum() + origin * area.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Vec<DVec2> {
        vec![DVec2::new(0.0, 0.0), DVec2::new(4.0, 0.0), DVec2::new(0.0, 4.0)]
    }

    #[test]
    fn moments_of_a_triangle_either_way_round() {
        let mut t = triangle();
        for _ in 0..2 {
            let (area, moment) = moments(&t);
            assert!((area - 8.0).abs() < 1e-12);
            assert!((moment / area - DVec2::splat(4.0 / 3.0)).length() < 1e-12);
            t.reverse();
        }
    }

    #[test]
    fn strips_of_a_polygon_add_up_to_it() {
        let t = triangle();
        let parts: f64 =
            (0..4).map(|i| moments(&strip(&t, 1, f64::from(i), f64::from(i + 1))).0).sum();
        assert!((parts - 8.0).abs() < 1e-12);
        assert!((moments(&strip(&t, 0, 1.0, 2.0)).0 - 2.5).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_left_outside() {
        assert!(moments(&strip(&triangle(), 0, 5.0, 6.0)).0 == 0.0);
        assert!(moments(&[]).0 == 0.0);
    }
}
