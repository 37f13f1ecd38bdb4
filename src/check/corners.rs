//! Luxels right beside other surfaces.

use crate::scene::{Polygon, Tracer};
use glam::Vec3;

/// Luxels with other surfaces within so many world units are in a corner: what they take changes within
/// less than a luxel, and no luxel's worth of light is right for them.
const CORNER: f32 = 4.0;

/// Whether something that is not in the plane through a point of a surface is near. `point` is some way
/// above its surface, of which `normal` is the unit normal and `dist` the plane's distance.
pub(super) fn in_corner(tracer: &Tracer, point: Vec3, normal: Vec3, dist: f32) -> bool {
    let (low, high) = (point - CORNER, point + CORNER);
    let mut stack = vec![0];
    if tracer.nodes().is_empty() {
        return false;
    }
    while let Some(node) = stack.pop() {
        let node = &tracer.nodes()[node as usize];
        if node.min.cmpgt(high).any() || node.max.cmplt(low).any() {
            continue;
        }
        if node.count == 0 {
            stack.extend([node.first, node.first + 1]);
            continue;
        }
        for slot in node.first..node.first + node.count {
            let polygon = &tracer.polygons()[tracer.polygon(slot).2 as usize];
            let in_plane = |v: &Vec3| (normal.dot(*v) - dist).abs() < 0.1;
            if !polygon.vertices.iter().all(in_plane) && distance(polygon, point) < CORNER {
                return true;
            }
        }
    }
    false
}

/// Distance of a point from a convex polygon.
fn distance(polygon: &Polygon, point: Vec3) -> f32 {
    let corners = &polygon.vertices;
    let edges = || (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]));
    // Corners go round either way.
    let sides = edges().map(|(a, b)| (b - a).cross(point - a).dot(polygon.normal));
    let (low, high) = sides.fold((0.0_f32, 0.0_f32), |(l, h), s| (l.min(s), h.max(s)));
    if low >= 0.0 || high <= 0.0 {
        return polygon.normal.dot(point - corners[0]).abs();
    }
    let to_edge = |(a, b): (Vec3, Vec3)| {
        let along = (point - a).dot(b - a) / (b - a).length_squared().max(1e-12);
        point.distance(a + (b - a) * along.clamp(0.0, 1.0))
    };
    edges().map(to_edge).fold(f32::INFINITY, f32::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luxels_beside_a_wall_are_in_its_corner() {
        let quad = |corners: [[f32; 3]; 4], normal| Polygon {
            vertices: corners.map(Vec3::from).to_vec(),
            normal,
        };
        let floor = quad([[0., 0., 0.], [0., 64., 0.], [64., 64., 0.], [64., 0., 0.]], Vec3::Z);
        let wall = quad([[0., 0., 0.], [0., 64., 0.], [0., 64., 64.], [0., 0., 64.]], Vec3::X);
        let tracer = Tracer::new(vec![floor, wall]);
        let at = |x| in_corner(&tracer, Vec3::new(x, 30.0, 1.0), Vec3::Z, 0.0);
        assert_eq!([1.0, 3.9, 4.1, 40.0].map(at), [true, true, false, false]);
        let beyond = in_corner(&tracer, Vec3::new(3.0, 80.0, 1.0), Vec3::Z, 0.0);
        assert!(!beyond, "the wall ends before");
    }
}
