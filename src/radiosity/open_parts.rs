//! The parts of a patch that other geometry leaves open: where things stand on it, lie on it or
//! cross it, light reaches only some of it.

use super::area_points::{Spread, spread};
use super::contour::{area, clip_front};
use crate::scene::Tracer;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// What is this many lifts from the points of a patch touches it: more than coordinates are rounded.
const TOUCH: f64 = 4.0;
/// A patch is cut into no more parts.
const MOST_PARTS: usize = 16;
/// Points of a part, and rays from each, that look for something other than backs.
const LOOKS: (u32, u32) = (4, 32);

/// A flat convex polygon that may be covered in part.
#[derive(Clone, Copy)]
pub struct Ground<'a> {
    /// Corners, counter-clockwise seen from the front.
    pub outline: &'a [DVec3],
    /// Unit normal of the front.
    pub normal: DVec3,
    /// Points of the polygon look out from this far in front of it.
    pub lift: f64,
}

/// The convex parts of `ground` from which anything but backs of polygons is seen; `None` where
/// that is all of it. `occluders` are what can cover it.
/// Polygons that are `two_sided` have no back.
pub fn open_parts(
    ground: Ground<'_>,
    occluders: &Tracer,
    two_sided: impl Fn(u32) -> bool,
) -> Option<Vec<Vec<DVec3>>> {
    let whole = area(ground.outline);
    let mut parts = vec![ground.outline.to_vec()];
    for contact in contacts(ground, occluders) {
        for k in 0..parts.len() {
            if parts.len() == MOST_PARTS {
                break;
            }
            if let Some([left, right]) = cut(&parts[k], ground, contact) {
                parts[k] = left;
                parts.push(right);
            }
        }
    }
    let cut = parts.len() > 1;
    parts.retain(|part| !covered(part, ground, occluders, &two_sided));
    let open: f64 = parts.iter().map(|part| area(part)).sum();
    // Parts that are all open are as good as the whole.
    (parts.is_empty() || (cut && open < whole * (1.0 - 1e-9))).then_some(parts)
}

/// The lines along which polygons meet the plane that `ground` looks out from, the longest first.
fn contacts(ground: Ground<'_>, occluders: &Tracer) -> Vec<[DVec3; 2]> {
    let mut found = Vec::new();
    let tolerance = TOUCH * ground.lift;
    let low = ground.outline.iter().copied().fold(DVec3::INFINITY, DVec3::min) - tolerance;
    let high = ground.outline.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max) + tolerance;
    let mut stack = if occluders.nodes().is_empty() { vec![] } else { vec![0u32] };
    while let Some(index) = stack.pop() {
        let node = &occluders.nodes()[index as usize];
        if node.max.as_dvec3().cmplt(low).any() || node.min.as_dvec3().cmpgt(high).any() {
            continue;
        }
        if node.count == 0 {
            stack.extend([node.first, node.first + 1]);
            continue;
        }
        for slot in node.first..node.first + node.count {
            let corners: Vec<DVec3> =
                occluders.polygon(slot).0.iter().map(|v| v.as_dvec3()).collect();
            section(&corners, ground, tolerance, &mut found);
        }
    }
    let length = |c: &[DVec3; 2]| c[0].distance_squared(c[1]);
    found.sort_by(|a, b| length(b).total_cmp(&length(a)));
    found
}

/// Where a polygon meets the plane: a line, or its edges where it lies in the plane.
fn section(corners: &[DVec3], ground: Ground<'_>, tolerance: f64, found: &mut Vec<[DVec3; 2]>) {
    let height = |p: DVec3| ground.normal.dot(p - ground.outline[0]) - ground.lift;
    let near = |p: DVec3| height(p).abs() <= tolerance;
    let edges = || corners.iter().zip(corners.iter().cycle().skip(1)).map(|(&a, &b)| [a, b]);
    if corners.iter().all(|&p| near(p)) {
        found.extend(edges());
        return;
    }
    let mut ends: Option<[DVec3; 2]> = None;
    let mut add = |p: DVec3| {
        ends = match ends {
            None => Some([p, p]),
            Some([a, b]) if p.distance_squared(a) > b.distance_squared(a) => Some([a, p]),
            Some([a, b]) if p.distance_squared(b) > b.distance_squared(a) => Some([p, b]),
            same => same,
        };
    };
    for [a, b] in edges() {
        if near(a) {
            add(a);
        } else if !near(b) && (height(a) < 0.0) != (height(b) < 0.0) {
            add(a.lerp(b, height(a) / (height(a) - height(b))));
        }
    }
    found.extend(ends.filter(|[a, b]| a != b));
}

/// Divides a part along the line of a contact that runs through it.
fn cut(part: &[DVec3], ground: Ground<'_>, [from, to]: [DVec3; 2]) -> Option<[Vec<DVec3>; 2]> {
    let way = to - from;
    let across = ground.normal.cross(way).try_normalize()?;
    let inside = way.normalize();
    let radius = part.iter().map(|p| p.distance(part[0])).fold(0.0, f64::max);
    let slack = (TOUCH * ground.lift).min(1e-3 * radius);
    let side = |p: DVec3| across.dot(p - from);
    let (low, high) =
        part.iter().fold((0.0f64, 0.0f64), |(low, high), &p| (low.min(side(p)), high.max(side(p))));
    if low > -slack || high < slack {
        return None;
    }
    // Where the line runs through the part, and where the contact is.
    let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
    for (&a, &b) in part.iter().zip(part.iter().cycle().skip(1)) {
        if (side(a) < 0.0) != (side(b) < 0.0) {
            let t = inside.dot(a.lerp(b, side(a) / (side(a) - side(b))) - from);
            (first, last) = (first.min(t), last.max(t));
        }
    }
    if last.min(way.length()) - first.max(0.0) < slack {
        return None;
    }
    let mut halves = [Vec::new(), Vec::new()];
    clip_front(part, from, across, &mut halves[0]);
    clip_front(part, from, -across, &mut halves[1]);
    halves.iter().all(|half| half.len() >= 3).then_some(halves)
}

/// Whether nothing but backs is seen from a part.
fn covered(
    part: &[DVec3],
    ground: Ground<'_>,
    occluders: &Tracer,
    two_sided: &impl Fn(u32) -> bool,
) -> bool {
    let on = Spread::new([part]);
    let tangent = ground.normal.any_orthonormal_vector();
    let bitangent = ground.normal.cross(tangent);
    (0..LOOKS.0).all(|k| {
        let origin = on.point(DVec2::from_array(spread(k, 0.1))) + ground.normal * ground.lift;
        (0..LOOKS.1).all(|ray| {
            // Even in the disc below the hemisphere is weighted by the cosine above.
            let [u, v] = spread(ray, f64::from(k) / f64::from(LOOKS.0));
            let (sin, cos) = (TAU * u).sin_cos();
            let flat = (tangent * cos + bitangent * sin) * v.sqrt();
            let direction = (flat + ground.normal * (1.0 - v).sqrt()).as_vec3();
            let hit = occluders.first_hit(origin.as_vec3(), direction, f32::INFINITY);
            hit.is_some_and(|hit| {
                occluders.polygons()[hit.polygon as usize].normal.dot(direction) >= 0.0
                    && !two_sided(hit.polygon)
            })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Polygon;
    use glam::Vec3;

    const LIFT: f64 = 1e-5;

    fn floor() -> Vec<DVec3> {
        [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)]
            .map(|(x, y)| DVec3::new(x, y, 0.0))
            .to_vec()
    }

    /// Area of the floor that a box leaves open, and the number of its open parts.
    fn open_around(sides: &[[f64; 2]], [bottom, top]: [f64; 2]) -> Option<(f64, usize)> {
        let at = |[x, y]: [f64; 2], z: f64| DVec3::new(x, y, z).as_vec3();
        let polygon = |vertices: Vec<Vec3>| {
            let normal = (vertices[1] - vertices[0]).cross(vertices[2] - vertices[1]).normalize();
            Polygon { vertices, normal }
        };
        let next = sides.iter().cycle().skip(1);
        let mut polygons: Vec<Polygon> = sides
            .iter()
            .zip(next)
            .map(|(&a, &b)| polygon(vec![at(a, bottom), at(b, bottom), at(b, top), at(a, top)]))
            .collect();
        polygons.push(polygon(sides.iter().map(|&p| at(p, top)).collect()));
        let floor = floor();
        let ground = Ground { outline: &floor, normal: DVec3::Z, lift: LIFT };
        let parts = open_parts(ground, &Tracer::new(polygons), |_| false)?;
        Some((parts.iter().map(|p| area(p)).sum(), parts.len()))
    }

    const SQUARE: [[f64; 2]; 4] = [[1.0, 1.0], [2.0, 1.0], [2.0, 3.0], [1.0, 3.0]];
    const TURNED: [[f64; 2]; 4] = [[1.0, 2.0], [2.0, 1.0], [3.0, 2.0], [2.0, 3.0]];
    const OVER_THE_EDGE: [[f64; 2]; 4] = [[3.0, 1.0], [7.0, 1.0], [7.0, 2.0], [3.0, 2.0]];

    #[test]
    fn boxes_that_touch_or_cross_the_floor_cover_it() {
        // Also where rounding puts the box slightly above or below.
        for bottom in [0.0, -1.0, 2.0 * LIFT, -LIFT] {
            for (sides, covered) in [(SQUARE, 2.0), (TURNED, 2.0), (OVER_THE_EDGE, 1.0)] {
                let (open, parts) = open_around(&sides, [bottom, 2.0]).unwrap();
                assert!((open - (16.0 - covered)).abs() < 1e-5, "{bottom} {sides:?}: {open}");
                assert!(parts <= 8, "{parts}");
            }
        }
    }

    #[test]
    fn what_floats_or_stands_beside_covers_nothing() {
        assert_eq!(open_around(&SQUARE, [0.5, 2.0]), None);
        assert_eq!(
            open_around(&SQUARE.map(|[x, y]| [x + 3.0, y]), [0.0, 2.0]),
            None,
            "at its edge"
        );
        assert_eq!(open_around(&SQUARE, [-2.0, -1.0]), None, "below");
    }

    #[test]
    fn a_floor_under_a_large_box_is_covered_whole() {
        let around = [[-1.0, -1.0], [9.0, -1.0], [9.0, 9.0], [-1.0, 9.0]];
        assert_eq!(open_around(&around, [0.0, 2.0]), Some((0.0, 0)));
    }

    #[test]
    fn many_sides_do_not_cut_without_end() {
        let circle: Vec<[f64; 2]> = (0..200)
            .map(|k| f64::from(k) * TAU / 200.0)
            .map(|a| [2.0 + a.cos(), 2.0 + a.sin()])
            .collect();
        let parts = open_around(&circle, [0.0, 1.0]).map_or(1, |(_, parts)| parts);
        assert!(parts <= MOST_PARTS);
    }
}
