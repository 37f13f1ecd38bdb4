//! Clipping polygons to the view pyramid of one hemicube side.

use super::lanes::Lanes;
use glam::Vec3;

/// A point as (column x depth, row x depth, depth): dividing by the depth gives cell coordinates.
pub(super) type Homogeneous = Vec3;

/// Signed distances to the four planes of the pyramid; all at least 0 means inside. The planes meet
/// in the eye, so what they keep has depth >= 0.
fn distance(p: Homogeneous, width: f32, height: f32, plane: usize) -> f32 {
    match plane {
        0 => p.x,
        1 => width * p.z - p.x,
        2 => p.y,
        _ => height * p.z - p.y,
    }
}

/// The lanes that are outside of each of the four planes, a bit each.
#[inline(always)]
pub(super) fn outside<V: Lanes>(p: &[V; 3], size: [f32; 2]) -> [i32; 4] {
    let [x, y, z] = *p;
    let far = |at: V, size: f32| V::all(size) * z - at;
    let below = |d: V| d.cmp_lt(V::all(0.0)).mask();
    [below(x), below(far(x, size[0])), below(y), below(far(y, size[1]))]
}

/// Clips the polygon in `points` in place; `spare` is working space. Returns whether anything is
/// left.
///
/// Cut points are always computed from the inner to the outer end of an edge, so two polygons that
/// share an edge get the same cut and leave no crack.
pub(super) fn clip(
    points: &mut Vec<Homogeneous>,
    spare: &mut Vec<Homogeneous>,
    width: f32,
    height: f32,
) -> bool {
    // One bit a plane: outside for some point, outside for all.
    let (mut some, mut all) = (0u8, 15u8);
    for p in points.iter() {
        let code = (0..4).fold(0, |code, plane| {
            code | u8::from(distance(*p, width, height, plane) < 0.0) << plane
        });
        some |= code;
        all &= code;
    }
    if all != 0 {
        return false;
    }
    for plane in (0..4).filter(|plane| some >> plane & 1 == 1) {
        spare.clear();
        let mut from = points[points.len() - 1];
        let mut from_d = distance(from, width, height, plane);
        for &to in points.iter() {
            let to_d = distance(to, width, height, plane);
            if from_d >= 0.0 && to_d < 0.0 {
                spare.push(from + (to - from) * (from_d / (from_d - to_d)));
            } else if from_d < 0.0 && to_d >= 0.0 {
                spare.push(to + (from - to) * (to_d / (to_d - from_d)));
            }
            if to_d >= 0.0 {
                spare.push(to);
            }
            (from, from_d) = (to, to_d);
        }
        std::mem::swap(points, spare);
        if points.len() < 3 {
            return false;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn h(x: f32, y: f32, depth: f32) -> Homogeneous {
        Vec3::new(x * depth, y * depth, depth)
    }

    #[test]
    fn inside_polygons_stay_as_they_are() {
        let mut p = vec![h(1.0, 1.0, 2.0), h(3.0, 1.0, 5.0), h(2.0, 3.0, 1.0)];
        let before = p.clone();
        assert!(clip(&mut p, &mut Vec::new(), 4.0, 4.0));
        assert_eq!(p, before);
    }

    #[test]
    fn polygons_behind_or_beside_vanish() {
        let behind = [h(1.0, 1.0, -2.0), h(3.0, 1.0, -5.0), h(2.0, 3.0, -1.0)];
        let beside = [h(5.0, 1.0, 2.0), h(9.0, 1.0, 5.0), h(7.0, 3.0, 1.0)];
        assert!(!clip(&mut behind.to_vec(), &mut Vec::new(), 4.0, 4.0));
        assert!(!clip(&mut beside.to_vec(), &mut Vec::new(), 4.0, 4.0));
    }

    #[test]
    fn a_polygon_around_the_view_is_cut_to_its_corners() {
        let mut p =
            vec![h(-9.0, -9.0, 2.0), h(19.0, -9.0, 2.0), h(19.0, 19.0, 2.0), h(-9.0, 19.0, 2.0)];
        assert!(clip(&mut p, &mut Vec::new(), 4.0, 4.0));
        assert_eq!(p.len(), 4);
        for q in p {
            let (x, y) = (q.x / q.z, q.y / q.z);
            assert!((x.abs() < 1e-5 || (x - 4.0).abs() < 1e-5) && (y * (y - 4.0)).abs() < 1e-4);
        }
    }

    #[test]
    fn neighbours_are_cut_at_the_same_points() {
        let (a, b) = (h(-3.3, 0.7, 1.3), h(2.9, 3.1, 4.1));
        let mut one = vec![a, b, h(3.0, 0.5, 2.0)];
        let mut two = vec![b, a, h(1.0, 3.9, 7.0)];
        assert!(clip(&mut one, &mut Vec::new(), 4.0, 4.0));
        assert!(clip(&mut two, &mut Vec::new(), 4.0, 4.0));
        let shared = one.iter().filter(|p| two.contains(p)).count();
        assert!(shared >= 2, "{one:?} {two:?}");
    }
}
