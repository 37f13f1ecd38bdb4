//! Whether something stands between two polygons.

use super::contour::area;
use crate::scene::{Node, Polygon, Tracer};
use glam::{DVec3, Vec3};

/// The polygons that can hide anything: those with something on either side of their plane. In a
/// convex room there are none.
pub struct Occluders {
    tracer: Tracer,
    shapes: Vec<OccluderShape>,
    /// Polygons whose back is the front of another in the same place.
    two_sided: Vec<bool>,
    /// Lengths below this are rounding errors, in world units.
    slack: f64,
}

/// A sphere around an occluder, and its area.
pub struct OccluderShape {
    /// Mean of the corners.
    pub centre: DVec3,
    /// Distance of the farthest corner.
    pub radius: f64,
    /// Square world units.
    pub area: f64,
    normal: DVec3,
}

impl OccluderShape {
    fn new(polygon: &Polygon) -> Self {
        let corners: Vec<DVec3> = polygon.vertices.iter().map(|v| v.as_dvec3()).collect();
        let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let radius = corners.iter().map(|p| p.distance(centre)).fold(0.0, f64::max);
        Self { centre, radius, area: area(&corners), normal: polygon.normal.as_dvec3() }
    }

    /// Upper bound on how far it rises above its centre along a unit direction.
    pub fn height(&self, direction: DVec3) -> f64 {
        let cosine = direction.dot(self.normal);
        self.radius * (1.0 - cosine * cosine).max(0.0).sqrt()
    }
}

/// Share of the scene's size that counts as rounding error of a position.
const SLACK: f64 = 1e-6;

impl Occluders {
    /// Finds them among the polygons of a scene.
    pub fn new(scene: &Tracer) -> Self {
        Self::with_sheets(scene, &[])
    }

    /// The same where some polygons are the two sides of a sheet, back to back in one place; true for
    /// those, none left out or empty for none.
    pub fn with_sheets(scene: &Tracer, sheets: &[bool]) -> Self {
        let extent = scene.nodes().first().map_or(0.0, |n| (n.max - n.min).max_element());
        let slack = SLACK * f64::from(extent);
        let found: Vec<usize> = (0..scene.polygons().len())
            .filter(|&i| something_behind(scene, &scene.polygons()[i], slack as f32))
            .collect();
        let polygons: Vec<Polygon> = found.iter().map(|&i| scene.polygons()[i].clone()).collect();
        let shapes = polygons.iter().map(OccluderShape::new).collect();
        let two_sided = found.iter().map(|&i| sheets.get(i) == Some(&true)).collect();
        Self { tracer: Tracer::new(polygons), shapes, two_sided, slack }
    }

    /// Whether something is to be seen of a polygon from its back.
    pub fn is_two_sided(&self, polygon: u32) -> bool {
        self.two_sided[polygon as usize]
    }

    /// Whether nothing can hide anything.
    pub fn is_empty(&self) -> bool {
        self.tracer.polygons().is_empty()
    }

    /// The polygons.
    pub fn tracer(&self) -> &Tracer {
        &self.tracer
    }

    /// Where the polygons are.
    pub fn shapes(&self) -> &[OccluderShape] {
        &self.shapes
    }

    /// Whether a point just in front of `from` sees one just in front of `to`. The points are
    /// already lifted off their surfaces.
    pub fn clear(&self, from: DVec3, to: DVec3) -> bool {
        let (from, to) = (from.as_vec3(), to.as_vec3());
        self.tracer.first_hit(from, to - from, 1.0).is_none()
    }

    /// Whether any occluder may reach into the space between two convex polygons: into their convex
    /// hull, in front of both. Never false when one does.
    pub fn between(&self, shaft: &Shaft) -> bool {
        any_between(&self.tracer, shaft, self.slack)
    }
}

/// Whether any polygon reaches into the shaft by more than `slack`. Never false when one does.
pub(super) fn any_between(tracer: &Tracer, shaft: &Shaft, slack: f64) -> bool {
    let nodes = tracer.nodes();
    if nodes.is_empty() {
        return false;
    }
    let mut stack = vec![0u32];
    while let Some(index) = stack.pop() {
        let node = &nodes[index as usize];
        if shaft.misses_box(node, slack) {
            continue;
        }
        if node.count == 0 {
            stack.extend([node.first, node.first + 1]);
        } else if (node.first..node.first + node.count)
            .any(|slot| !shaft.misses(tracer.polygon(slot).0, slack))
        {
            return true;
        }
    }
    false
}

/// Whether a corner of the scene lies behind the plane of `polygon`.
fn something_behind(scene: &Tracer, polygon: &Polygon, slack: f32) -> bool {
    let (n, on) = (polygon.normal, polygon.vertices[0]);
    let mut stack = vec![0u32];
    while let Some(index) = stack.pop() {
        let node = &scene.nodes()[index as usize];
        let (centre, half) = ((node.min + node.max) * 0.5, (node.max - node.min) * 0.5);
        if n.dot(centre - on) - n.abs().dot(half) >= -slack {
            continue;
        }
        if node.count == 0 {
            stack.extend([node.first, node.first + 1]);
        } else if (node.first..node.first + node.count)
            .any(|slot| scene.polygon(slot).0.iter().any(|&v| n.dot(v - on) < -slack))
        {
            return true;
        }
    }
    false
}

/// The space between two convex polygons: the planes that bound their convex hull (E. Haines and
/// J. Wallace, "Shaft culling for efficient ray-traced radiosity", 1991).
pub struct Shaft {
    /// Outward unit normals and offsets: inside is `normal . p <= offset`.
    planes: Vec<(DVec3, f64)>,
}

impl Shaft {
    /// Polygons in front of each other, with the unit normals of their fronts.
    pub fn new((a, a_normal): (&[DVec3], DVec3), (b, b_normal): (&[DVec3], DVec3)) -> Self {
        let mut planes = vec![(-a_normal, -a_normal.dot(a[0])), (-b_normal, -b_normal.dot(b[0]))];
        add_sides(a, b, &mut planes);
        add_sides(b, a, &mut planes);
        Self { planes }
    }

    fn misses(&self, polygon: &[Vec3], slack: f64) -> bool {
        self.planes.iter().any(|&(normal, offset)| {
            polygon.iter().all(|v| normal.dot(v.as_dvec3()) >= offset - slack)
        })
    }

    fn misses_box(&self, node: &Node, slack: f64) -> bool {
        let (low, high) = (node.min.as_dvec3(), node.max.as_dvec3());
        let (centre, half) = ((low + high) * 0.5, (high - low) * 0.5);
        self.planes
            .iter()
            .any(|&(normal, offset)| normal.dot(centre) - normal.abs().dot(half) >= offset - slack)
    }
}

/// Planes through an edge of `a` and a corner of `b` that have both polygons on one side.
fn add_sides(a: &[DVec3], b: &[DVec3], planes: &mut Vec<(DVec3, f64)>) {
    for (i, &to) in a.iter().enumerate() {
        let from = a[(i + a.len() - 1) % a.len()];
        let edge = to - from;
        for &corner in b {
            let cross = edge.cross(corner - from);
            let length = cross.length();
            if length <= 1e-9 * edge.length() * (corner - from).length() {
                continue;
            }
            let normal = cross / length;
            let offset = normal.dot(from);
            let (mut low, mut high) = (0.0f64, 0.0f64);
            for p in a.iter().chain(b) {
                let d = normal.dot(*p) - offset;
                low = low.min(d);
                high = high.max(d);
            }
            let flat = 1e-9 * (high - low);
            if high <= flat {
                planes.push((normal, offset + high));
            } else if low >= -flat {
                planes.push((-normal, -offset - low));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(origin: Vec3, u: Vec3, v: Vec3) -> Polygon {
        let vertices = vec![origin, origin + u, origin + u + v, origin + v];
        Polygon { vertices, normal: u.cross(v).normalize() }
    }

    fn floor_and_ceiling() -> Vec<Polygon> {
        vec![square(Vec3::ZERO, Vec3::X, Vec3::Y), square(Vec3::Z * 2.0, Vec3::Y, Vec3::X)]
    }

    fn between(occluders: &Occluders) -> bool {
        let corners = |p: &Polygon| p.vertices.iter().map(|v| v.as_dvec3()).collect::<Vec<_>>();
        let [a, b]: [Polygon; 2] = floor_and_ceiling().try_into().unwrap();
        let shaft = Shaft::new((&corners(&a), DVec3::Z), (&corners(&b), -DVec3::Z));
        occluders.between(&shaft)
    }

    #[test]
    fn nothing_hides_anything_in_a_convex_room() {
        let mut room = floor_and_ceiling();
        room.push(square(Vec3::ZERO, Vec3::Y, Vec3::Z * 2.0));
        let occluders = Occluders::new(&Tracer::new(room));
        assert!(occluders.is_empty() && !between(&occluders));
    }

    #[test]
    fn what_reaches_into_the_shaft_is_found() {
        for (shift, inside) in [(0.0, true), (0.9, true), (1.01, false), (-1.01, false)] {
            let mut scene = floor_and_ceiling();
            scene.push(square(Vec3::new(shift, 0.0, 1.0), Vec3::X, Vec3::Y));
            let occluders = Occluders::new(&Tracer::new(scene));
            assert_eq!(occluders.shapes().len(), 1, "only the one in the middle");
            assert_eq!(between(&occluders), inside, "shifted by {shift}");
            let ray = (DVec3::new(0.5, 0.5, 0.01), DVec3::new(0.5, 0.5, 1.99));
            assert_eq!(occluders.clear(ray.0, ray.1), shift.abs() > 0.5);
        }
    }

    #[test]
    fn what_touches_the_shaft_from_outside_is_not_between() {
        let mut scene = floor_and_ceiling();
        // A wall from the edge outwards and a slab below the floor.
        scene.push(square(Vec3::X, Vec3::X, Vec3::Z * 2.0));
        scene.push(square(Vec3::Z * -1.0, Vec3::X, Vec3::Y));
        let occluders = Occluders::new(&Tracer::new(scene));
        assert!(!occluders.is_empty() && !between(&occluders));
    }
}
