//! Smooth shading: which faces smooth with which, the normals of their corners, and the normals of
//! points between them (contract section 6.4).

use super::exact::{distance, dot, normalize, radians};
use super::shape::{POINT_EQ, Shape, area_and_centre, inward_plane, largest_triangle_normal};
use super::sidecar::TexInfoKeys;
use crate::bsp::Bsp;
use glam::Vec3;

/// Smoothing angle in degrees of faces that ask for smoothing without giving one.
pub(crate) const DEFAULT_ANGLE: f32 = 89.0;
/// A face whose centre is further than this in front of its neighbour's plane, in world units, makes
/// a concave edge with it.
const CONCAVE: f32 = 0.1;

/// How one face wants to be smoothed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Wish {
    /// Largest angle between normals at convex edges, in degrees; 0 is flat.
    angle: f32,
    /// The same at concave edges.
    concave_angle: f32,
    /// Faces smooth within their group only.
    group: i32,
    /// Faces without lightmap do not smooth with others.
    special: bool,
}

impl Wish {
    /// The wish that a texinfo makes for its faces.
    pub fn new(keys: &TexInfoKeys, special: bool) -> Self {
        let group = keys.phong_group;
        let angle =
            if keys.phong_angle == 0.0 && group != 0 { DEFAULT_ANGLE } else { keys.phong_angle };
        let concave = keys.phong_angle_concave;
        let concave_angle = if concave == 0.0 { angle } else { concave };
        Self { angle, concave_angle, group, special }
    }

    /// Whether the face is to look curved.
    pub fn is_curved(&self) -> bool {
        self.angle != 0.0
    }
}

/// Smoothed normals of a map.
#[derive(Debug, Default)]
pub(crate) struct Smoothing {
    /// For each face, the faces that its normals are blended with, in ascending order.
    partners: Vec<Vec<u32>>,
    /// Normal at each corner of each face; none for flat faces.
    normals: Vec<Vec<Vec3>>,
}

impl Smoothing {
    /// Works out who smooths with whom; `wishes` and `shapes` have one entry a face.
    pub fn new(bsp: &Bsp, shapes: &[Shape], wishes: &[Wish]) -> Self {
        let corners: Vec<Vec<u32>> = (0..shapes.len())
            .map(|f| match wishes[f].is_curved() {
                true => bsp.face_vertex_indices(f).collect(),
                false => Vec::new(),
            })
            .collect();
        let partners = partners(bsp.vertices.len(), shapes, wishes, &corners);
        let normals =
            (0..shapes.len()).map(|f| corner_normals(f, shapes, &corners, &partners[f])).collect();
        Self { partners, normals }
    }

    /// Whether the normals of `face` are blended with those of `other`.
    pub fn joins(&self, face: u32, other: u32) -> bool {
        self.partners.get(face as usize).is_some_and(|p| p.binary_search(&other).is_ok())
    }

    /// Normals at the corners of a face; empty where it is flat.
    pub fn corner_normals(&self, face: usize) -> &[Vec3] {
        self.normals.get(face).map_or(&[], Vec::as_slice)
    }

    /// Normal over a point of a face, not brought back to unit length, as the reference has it;
    /// `None` where no triangle of the face holds the point.
    pub fn normal_at(&self, face: usize, shape: &Shape, p: Vec3) -> Option<Vec3> {
        let flat;
        let normals = match self.normals.get(face) {
            Some(normals) if normals.len() == shape.vertices.len() => normals,
            _ => {
                flat = vec![shape.normal; shape.vertices.len()];
                &flat
            }
        };
        interpolate(&shape.vertices, normals, p)
    }
}

/// For each face, the faces that share a corner with it and are near enough in angle.
fn partners(
    vertex_count: usize,
    shapes: &[Shape],
    wishes: &[Wish],
    corners: &[Vec<u32>],
) -> Vec<Vec<u32>> {
    let mut at_vertex: Vec<Vec<u32>> = vec![Vec::new(); vertex_count];
    for (face, corners) in corners.iter().enumerate() {
        for &v in corners {
            if let Some(faces) = at_vertex.get_mut(v as usize) {
                faces.push(face as u32);
            }
        }
    }
    let centres: Vec<Vec3> = shapes.iter().map(|s| area_and_centre(&s.vertices).1).collect();
    let smooth = |f: usize, g: usize| {
        let (a, b) = (&wishes[f], &wishes[g]);
        if f == g || a.group != b.group || a.special != b.special {
            return false;
        }
        let concave = distance(centres[g], shapes[f].normal, shapes[f].dist) > CONCAVE;
        let most =
            if concave { a.concave_angle.min(b.concave_angle) } else { a.angle.min(b.angle) };
        f64::from(dot(shapes[f].normal, shapes[g].normal)) >= radians(most).cos()
    };
    let mut result = Vec::with_capacity(corners.len());
    for (face, corners) in corners.iter().enumerate() {
        let mut found: Vec<u32> = corners
            .iter()
            .filter_map(|&v| at_vertex.get(v as usize))
            .flatten()
            .copied()
            .filter(|&g| smooth(face, g as usize))
            .collect();
        found.sort_unstable();
        found.dedup();
        result.push(found);
    }
    result
}

/// Normals at the corners of a face: those of the face and its partners, weighted by area and by the
/// angle that each face has at the corner.
fn corner_normals(
    face: usize,
    shapes: &[Shape],
    corners: &[Vec<u32>],
    partners: &[u32],
) -> Vec<Vec3> {
    let own = &corners[face];
    let mut sums = vec![Vec3::ZERO; own.len()];
    for other in std::iter::once(face).chain(partners.iter().map(|&p| p as usize)) {
        let shape = &shapes[other];
        let (area, _) = area_and_centre(&shape.vertices);
        for (i, vertex) in corners[other].iter().enumerate() {
            if !own.contains(vertex) {
                continue;
            }
            let weight = area * corner_angle(&shape.vertices, i);
            let weighted = shape.normal * if weight.is_finite() { weight } else { 0.0 };
            for (sum, _) in sums.iter_mut().zip(own).filter(|(_, v)| *v == vertex) {
                *sum += weighted;
            }
        }
    }
    for sum in &mut sums {
        *sum = normalize(*sum);
        if *sum == Vec3::ZERO || !sum.is_finite() {
            *sum = shapes[face].normal;
        }
    }
    sums
}

/// Angle of a polygon at corner `i`, in radians.
fn corner_angle(v: &[Vec3], i: usize) -> f32 {
    let n = v.len();
    let to = |other: usize| normalize(v[other] - v[i]);
    dot(to((i + n - 1) % n), to((i + 1) % n)).clamp(-1.0, 1.0).acos()
}

/// Blends the normals at the corners of a polygon for a point over it: barycentric in the first
/// triangle of the fan around corner 0 that holds the point; `None` if there is none.
fn interpolate(v: &[Vec3], normals: &[Vec3], p: Vec3) -> Option<Vec3> {
    (2..v.len()).find_map(|i| {
        let triangle = [v[0], v[i - 1], v[i]];
        let up = largest_triangle_normal(&triangle);
        if up == Vec3::ZERO {
            return None;
        }
        for (k, &a) in triangle.iter().enumerate() {
            let (n, d) = inward_plane(a, triangle[(k + 1) % 3], up)?;
            if distance(p, n, d) < -POINT_EQ {
                return None;
            }
        }
        let b = barycentric(triangle, p);
        Some(normals[0] * b.x + normals[i - 1] * b.y + normals[i] * b.z)
    })
}

/// Barycentric coordinates of the point of a triangle's plane nearest to `p`. C. Ericson, "Real-Time
/// Collision Detection" (2005), section 3.4.
fn barycentric([a, b, c]: [Vec3; 3], p: Vec3) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (bb, bc, cc) = (dot(ab, ab), dot(ab, ac), dot(ac, ac));
    let (pb, pc) = (dot(ap, ab), dot(ap, ac));
    let det = bb * cc - bc * bc;
    let y = (cc * pb - bc * pc) / det;
    let z = (bb * pc - bc * pb) / det;
    Vec3::new(1.0 - y - z, y, z)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [Vec3; 3] = [Vec3::ZERO, Vec3::new(0.0, 64.0, 0.0), Vec3::new(64.0, 0.0, 0.0)];

    #[test]
    fn barycentric_coordinates_of_corners_and_edge_middles() {
        let [a, b, c] = TRIANGLE;
        for (p, want) in [
            (a, Vec3::X),
            (b, Vec3::Y),
            (c, Vec3::Z),
            ((a + b) / 2.0, Vec3::new(0.5, 0.5, 0.0)),
            ((b + c) / 2.0, Vec3::new(0.0, 0.5, 0.5)),
            ((a + c) / 2.0 + Vec3::Z, Vec3::new(0.5, 0.0, 0.5)),
        ] {
            assert!((barycentric(TRIANGLE, p) - want).length() < 1e-6, "{p}");
        }
    }

    #[test]
    fn normals_are_reproduced_at_corners_and_averaged_in_the_middle() {
        let normals = [Vec3::Z, Vec3::Y, Vec3::X];
        for (p, want) in TRIANGLE.iter().zip(normals) {
            let got = interpolate(&TRIANGLE, &normals, *p + Vec3::Z).unwrap();
            assert!((got - want).length() < 0.05, "{p} {got}");
        }
        let middle = (TRIANGLE[0] + TRIANGLE[1] + TRIANGLE[2]) / 3.0;
        let got = interpolate(&TRIANGLE, &normals, middle).unwrap();
        assert!((got - Vec3::splat(1.0 / 3.0)).length() < 1e-5, "{got}");
        assert!(got.length() < 0.6, "not brought back to unit length");
    }

    #[test]
    fn interpolation_fails_outside_and_without_a_triangle() {
        let normals = [Vec3::Z; 3];
        assert_eq!(interpolate(&TRIANGLE, &normals, Vec3::new(-1.0, 5.0, 0.0)), None);
        assert_eq!(interpolate(&TRIANGLE[..2], &normals[..2], Vec3::ZERO), None);
        let flat = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0];
        assert_eq!(interpolate(&flat, &normals, Vec3::X), None);
    }

    #[test]
    fn a_point_in_the_second_triangle_of_the_fan_is_found() {
        let square = [[0.0, 0.0], [0.0, 64.0], [64.0, 64.0], [64.0, 0.0]];
        let square = square.map(|[x, y]| Vec3::new(x, y, 0.0));
        let normals = [Vec3::Z, Vec3::Z, Vec3::X, Vec3::X];
        let got = interpolate(&square, &normals, Vec3::new(48.0, 16.0, 1.0)).unwrap();
        assert!((got - Vec3::new(0.75, 0.0, 0.25)).length() < 1e-6, "{got}");
    }

    #[test]
    fn a_group_alone_asks_for_the_default_angle() {
        let keys = TexInfoKeys { phong_group: 2, ..TexInfoKeys::default() };
        assert_eq!(Wish::new(&keys, false).angle, DEFAULT_ANGLE);
        assert!(!Wish::new(&TexInfoKeys::default(), false).is_curved());
    }

    #[test]
    fn corner_angles() {
        assert!((corner_angle(&TRIANGLE, 0).to_degrees() - 90.0).abs() < 1e-4);
        assert!((corner_angle(&TRIANGLE, 1).to_degrees() - 45.0).abs() < 1e-3);
        assert!(corner_angle(&[Vec3::ZERO, Vec3::ZERO, Vec3::X], 0).is_finite());
    }
}
