//! The geometry of a face in the space of its brush model, as luxel placement needs it (contract
//! sections 2.2 and 2.4).

use super::exact::{distance, dot, length, normalize};
use crate::bsp::{Plane, TexInfo};
use glam::{DMat3, DVec3, Vec2, Vec3, Vec4};

/// Tolerance of point-in-polygon tests and length of a degenerate edge, in world units.
pub(crate) const POINT_EQ: f32 = 0.05;
/// Area of a degenerate polygon, in square units.
pub(crate) const AREA_EPS: f32 = 0.0001;

/// A face polygon with the inward planes of its edges.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    /// Corner points, clockwise from the front.
    pub vertices: Vec<Vec3>,
    /// Unit normal of the face's plane, side applied.
    pub normal: Vec3,
    /// Distance of that plane.
    pub dist: f32,
    /// Inward planes of the edges that are not degenerate: normal and distance.
    pub edges: Vec<(Vec3, f32)>,
    /// Brush model of the face.
    pub model: Option<u32>,
}

impl Shape {
    /// The shape of a polygon in `plane`. A polygon without area has no edge planes.
    pub fn new(vertices: Vec<Vec3>, plane: Plane, model: Option<u32>) -> Self {
        let polygon_normal = largest_triangle_normal(&vertices);
        let mut edges = Vec::with_capacity(vertices.len());
        if polygon_normal != Vec3::ZERO {
            for (i, &a) in vertices.iter().enumerate() {
                let b = vertices[(i + 1) % vertices.len()];
                edges.extend(inward_plane(a, b, polygon_normal));
            }
        }
        Self { vertices, normal: plane.normal, dist: plane.dist, edges, model }
    }

    /// Corner points `edge` and the next.
    pub fn edge(&self, edge: usize) -> (Vec3, Vec3) {
        (self.vertices[edge], self.vertices[(edge + 1) % self.vertices.len()])
    }

    /// Whether a point is within the edges, or at most [`POINT_EQ`] outside, whatever its height. A
    /// polygon without area has no point.
    pub fn surrounds(&self, p: Vec3) -> bool {
        let within = |(n, d): &(Vec3, f32)| distance(p, *n, *d) >= -POINT_EQ;
        !self.edges.is_empty() && self.edges.iter().all(within)
    }

    /// The point one unit in front of the plane, over or under `p`.
    pub fn lift(&self, p: Vec3) -> Vec3 {
        p - self.normal * distance(p, self.normal, self.dist) + self.normal
    }

    /// The point of the boundary nearest to `p`; the first edge wins ties.
    pub fn nearest_on_boundary(&self, p: Vec3) -> Vec3 {
        let mut best = (f32::INFINITY, p);
        for i in 0..self.vertices.len() {
            let (a, b) = self.edge(i);
            let f = fraction_along(a, b, p);
            let c = if f >= 1.0 {
                b
            } else if f <= 0.0 {
                a
            } else {
                a + (b - a) * f
            };
            let d = length(c - p);
            if d < best.0 {
                best = (d, c);
            }
        }
        best.1
    }
}

/// Plane through an edge, facing into the polygon whose normal is given; `None` for a short edge.
pub(crate) fn inward_plane(a: Vec3, b: Vec3, polygon_normal: Vec3) -> Option<(Vec3, f32)> {
    let edge = b - a;
    if length(edge) < POINT_EQ {
        return None;
    }
    let normal = normalize(edge).cross(polygon_normal);
    Some((normal, dot(normal, a)))
}

/// Where `p` lies along the line from `a` (0) to `b` (1).
pub(crate) fn fraction_along(a: Vec3, b: Vec3, p: Vec3) -> f32 {
    let ab = b - a;
    let square = dot(ab, ab);
    if square == 0.0 { 0.0 } else { dot(p - a, ab) / square }
}

/// Normal of the largest triangle of the fan around the first corner; zero without area.
pub(crate) fn largest_triangle_normal(v: &[Vec3]) -> Vec3 {
    let mut best = (0.0, Vec3::ZERO);
    for i in 2..v.len() {
        let cross = (v[i] - v[0]).cross(v[i - 1] - v[0]);
        let area = 0.5 * length(cross);
        if area > best.0 {
            best = (area, cross);
        }
    }
    if best.0 < AREA_EPS { Vec3::ZERO } else { normalize(best.1) }
}

/// Area and area-weighted centre of a polygon: a fan around its first corner. The centre of a
/// polygon without area is not a number.
pub(crate) fn area_and_centre(v: &[Vec3]) -> (f32, Vec3) {
    let (mut area, mut centre) = (0.0, Vec3::ZERO);
    for i in 2..v.len() {
        let a = 0.5 * length((v[i] - v[0]).cross(v[i - 1] - v[0]));
        let middle = (v[0] + v[i - 1] + v[i]) / 3.0;
        area += a;
        centre += middle * a;
    }
    (area, centre / area)
}

/// Luxel coordinates to model space and back.
#[derive(Clone, Debug)]
pub(crate) struct LuxelMap {
    /// Model-space point is `row.x s + row.y t + row.w` for each of x, y, z.
    to_world: [Vec4; 3],
    /// Luxel coordinate is `row . (p, 1)` for each of s, t.
    to_luxel: [Vec4; 2],
}

impl LuxelMap {
    /// The map of a face whose luxel (0, 0) is `mins` luxels of `size` texels from the texture
    /// origin; `None` if the texture axes do not span the plane.
    pub fn new(texinfo: &TexInfo, plane: Plane, mins: [i32; 2], size: u32) -> Option<Self> {
        let (s, t) = (texinfo.s, texinfo.t);
        let axes = DMat3::from_cols(
            s.truncate().as_dvec3(),
            t.truncate().as_dvec3(),
            plane.normal.as_dvec3(),
        )
        .transpose();
        let inverse = axes.inverse();
        let shift = DVec3::new(s.w.into(), t.w.into(), -f64::from(plane.dist));
        let origin = -(inverse * shift);
        if axes.determinant() == 0.0 || !inverse.is_finite() || !origin.is_finite() {
            return None;
        }
        let k = size as f32;
        let (low_s, low_t) = (mins[0] as f32 * k, mins[1] as f32 * k);
        let to_world = std::array::from_fn(|i| {
            let row = inverse.row(i).as_vec3();
            let w = row.x * low_s + row.y * low_t + origin[i] as f32;
            Vec4::new(row.x * k, row.y * k, row.z, w)
        });
        let per = (1.0 / f64::from(size)) as f32;
        let row = |axis: Vec4, low: i32| {
            let scaled = axis * per;
            Vec4::new(scaled.x, scaled.y, scaled.z, scaled.w - low as f32)
        };
        let map = Self { to_world, to_luxel: [row(s, mins[0]), row(t, mins[1])] };
        map.to_world.iter().chain(&map.to_luxel).all(|r| r.is_finite()).then_some(map)
    }

    /// Point on the face plane at luxel coordinates.
    pub fn world_of(&self, s: f32, t: f32) -> Vec3 {
        let at = |row: Vec4| row.x * s + row.y * t + row.w;
        Vec3::from(self.to_world.map(at))
    }

    /// Luxel coordinates of a point, seen along the plane's normal.
    pub fn luxel_of(&self, p: Vec3) -> Vec2 {
        let at = |row: Vec4| row.x * p.x + row.y * p.y + row.z * p.z + row.w;
        Vec2::from(self.to_luxel.map(at))
    }

    /// Rows of the map to luxels for points that are `offset` further on.
    pub fn rows_at(&self, offset: Vec3) -> [Vec4; 2] {
        self.to_luxel.map(|r| Vec4::new(r.x, r.y, r.z, r.w - dot(r.truncate(), offset)))
    }

    /// Steps from one luxel to the next along s and t.
    pub fn steps(&self) -> [Vec3; 2] {
        let r = &self.to_world;
        [Vec3::new(r[0].x, r[1].x, r[2].x), Vec3::new(r[0].y, r[1].y, r[2].y)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOOR: Plane = Plane { normal: Vec3::Z, dist: 0.0, kind: 2 };

    fn polygon(corners: &[[f32; 2]]) -> Shape {
        let v = corners.iter().map(|&[x, y]| Vec3::new(x, y, 0.0)).collect();
        Shape::new(v, FLOOR, Some(0))
    }

    fn square() -> Shape {
        polygon(&[[0.0, 0.0], [0.0, 64.0], [64.0, 64.0], [64.0, 0.0]])
    }

    #[test]
    fn edges_face_inwards_with_their_tolerance() {
        let plain = square();
        // Corners that repeat, and one that lies on an edge.
        let more = [[0.0, 0.0], [0.0, 32.0], [0.0, 64.0], [0.0, 64.0], [64.0, 64.0], [64.0, 0.0]];
        let more = polygon(&more);
        assert_eq!([plain.edges.len(), more.edges.len()], [4, 5]);
        for square in [plain, more] {
            let mut inside = square.vertices.clone();
            inside.extend([Vec3::new(32.0, 32.0, 0.0), Vec3::new(1.0, 63.0, 5.0)]);
            for p in inside {
                assert!(square.surrounds(p) && square.surrounds(p - Vec3::Z * 100.0), "{p}");
            }
            assert!(square.surrounds(Vec3::new(64.04, 32.0, 0.0)));
            for (x, y) in [(-0.1, 32.0), (64.1, 32.0), (32.0, -0.1), (32.0, 64.1)] {
                assert!(!square.surrounds(Vec3::new(x, y, 0.0)), "{x} {y}");
            }
        }
    }

    #[test]
    fn polygons_without_area_surround_nothing() {
        let line = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]];
        let (none, point) = (polygon(&[]), polygon(&[[1.0, 0.0]; 3]));
        for shape in [none, point, polygon(&line), polygon(&line[..2])] {
            assert!(shape.edges.is_empty());
            assert!(!shape.surrounds(Vec3::X));
        }
    }

    #[test]
    fn a_slight_notch_leaves_a_polygon_usable() {
        // Ten corners on a circle, one of them pulled in past the line of its neighbours.
        let mut corners = [[0.0_f32; 2]; 10];
        for (i, corner) in corners.iter_mut().enumerate() {
            let (sin, cos) = (-(i as f32) * 36_f32.to_radians()).sin_cos();
            let radius = if i == 4 { 128.0 * 36_f32.to_radians().cos() - 0.01 } else { 128.0 };
            *corner = [radius * cos, radius * sin];
        }
        let shape = polygon(&corners);
        assert_eq!(shape.edges.len(), 10);
        assert!(shape.surrounds(Vec3::ZERO) && shape.surrounds(Vec3::new(100.0, 0.0, 0.0)));
        assert!(shape.vertices.iter().all(|v| shape.surrounds(*v)));
        assert!(!shape.surrounds(Vec3::new(128.2, 0.0, 0.0)));
    }

    #[test]
    fn the_first_edge_is_nearest_of_equals() {
        let mut square = square();
        assert_eq!(square.nearest_on_boundary(Vec3::new(32.0, 32.0, 0.0)), Vec3::Y * 32.0);
        assert_eq!(
            square.nearest_on_boundary(Vec3::new(48.0, 48.0, 0.0)).x,
            48.0,
            "edge 1 of 1 and 2"
        );
        assert_eq!(square.nearest_on_boundary(Vec3::new(-5.0, 70.0, 1.0)), square.vertices[1]);
        square.vertices = vec![Vec3::ONE; 2];
        assert_eq!(square.nearest_on_boundary(Vec3::ZERO), Vec3::ONE, "an edge without length");
    }

    #[test]
    fn fractions_of_a_line() {
        let (a, b) = (Vec3::new(10.0, 10.0, 5.0), Vec3::new(20.0, 30.0, 5.0));
        for f in [0.0, 0.5, 1.0, 2.0, -1.0] {
            let beside = Vec3::new(-2.0, 1.0, 7.0);
            for p in [a + (b - a) * f, a + (b - a) * f + beside] {
                assert!((fraction_along(a, b, p) - f).abs() < 1e-6, "{f} at {p}");
            }
        }
        assert_eq!(fraction_along(a, a, b), 0.0);
    }

    #[test]
    fn area_and_centre_of_a_square_with_a_colinear_corner() {
        let mut v = square().vertices;
        v.insert(1, Vec3::new(0.0, 32.0, 0.0));
        assert_eq!(area_and_centre(&v), (4096.0, Vec3::new(32.0, 32.0, 0.0)));
        assert!((0..3).all(|n| area_and_centre(&v[..n]).0 == 0.0));
        assert!((0..3).all(|n| area_and_centre(&v[..n]).1.is_nan()));
    }

    #[test]
    fn luxels_sit_on_multiples_of_the_luxel_size() {
        let texinfo = TexInfo {
            s: Vec4::new(1.0, 0.0, 0.0, 8.0),
            t: Vec4::new(0.0, -2.0, 0.0, 0.0),
            miptex: 0,
            flags: 0,
        };
        let plane = Plane { dist: 100.0, ..FLOOR };
        let map = LuxelMap::new(&texinfo, plane, [-3, 2], 16).unwrap();
        let p = map.world_of(1.0, 2.0);
        assert_eq!(p, Vec3::new(-32.0 - 8.0, -32.0, 100.0));
        assert_eq!(map.luxel_of(p), Vec2::new(1.0, 2.0));
        assert_eq!(map.steps(), [Vec3::new(16.0, 0.0, 0.0), Vec3::new(0.0, -8.0, 0.0)]);
        let flat = TexInfo { t: texinfo.s, ..texinfo };
        assert!(LuxelMap::new(&flat, plane, [0, 0], 16).is_none());
    }

    #[test]
    fn maps_to_luxels_and_back_are_inverse() {
        let texinfo = TexInfo {
            s: Vec4::new(0.5, 0.25, -0.3, 17.0),
            t: Vec4::new(-0.1, -1.5, 0.2, -2000.0),
            miptex: 0,
            flags: 0,
        };
        let normal = Vec3::new(1.0, 2.0, 5.0).normalize();
        let map = LuxelMap::new(&texinfo, Plane { normal, dist: -700.0, kind: 5 }, [9, -130], 16)
            .unwrap();
        for (s, t) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (16.0, 16.0), (-3.5, 7.25)] {
            let p = map.world_of(s, t);
            assert!((map.luxel_of(p) - Vec2::new(s, t)).length() < 1e-3, "{s} {t} {p}");
            assert!((distance(p, normal, -700.0)).abs() < 1e-3, "on the plane");
        }
    }
}
