//! The first polygon that a ray meets, with the care for edges that [`super::shadow`] describes: a
//! ray through the seam of two polygons meets one of them.

use super::narrow::Narrow;
use super::shadow::{Contact, ShadowRays, corners, meet};
use super::tie;
use super::tracer::Hit;
use glam::{DVec3, Vec3};

/// Polygons that a ray meets: the nearest one that it meets inside, and those met before it at an
/// edge.
struct Meetings {
    inside: Option<(f64, u32)>,
    edges: Vec<(f64, u32)>,
}

impl ShadowRays<'_> {
    /// The first polygon within `reach` of `from` in the unit direction `direction`, from either
    /// side. One through `from` itself is not met.
    pub fn first_hit(&mut self, from: Vec3, direction: Vec3, reach: f32) -> Option<Hit> {
        self.first(from, direction, reach, true)
    }

    /// The same, but rays that meet edges go where the reference lets them, through seams and inner
    /// diagonals too. For
    /// the many short rays of dirt, of which single ones do not matter to an eye.
    pub(crate) fn first_hit_as_reference(
        &mut self,
        from: Vec3,
        direction: Vec3,
        reach: f32,
    ) -> Option<Hit> {
        self.first(from, direction, reach, false)
    }

    fn first(&mut self, from: Vec3, direction: Vec3, reach: f32, tight: bool) -> Option<Hit> {
        self.rays += 1;
        if !tight && self.narrow.is_empty() {
            return None;
        }
        let (start, way) = (from.as_dvec3(), direction.as_dvec3() * f64::from(reach));
        let mut meetings = self.meetings(start, way, tight);
        self.last_first = meetings.inside.map(|m| m.1);
        let hit =
            |(t, polygon): (f64, u32)| Hit { polygon, distance: (t * f64::from(reach)) as f32 };
        if meetings.edges.is_empty() {
            return meetings.inside.map(hit);
        }
        meetings.edges.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let edges = &meetings.edges;
        let corners = |polygon| self.corners(polygon);
        let tied = edges
            .iter()
            .copied()
            .find(|&(_, polygon)| tie::blocked_along(corners(polygon), from, direction, reach));
        let before = edges.iter().take_while(|e| tied.is_none_or(|t| e.0 < t.0)).map(|e| e.0);
        let before: Vec<f64> = if tight { before.collect() } else { Vec::new() };
        let seam =
            if before.is_empty() { None } else { self.seam(start, way, &mut before.into_iter()) };
        let first = seam
            .and_then(|place| edges.iter().copied().find(|e| e.0 >= place))
            .or(tied)
            .or(meetings.inside);
        first.map(hit)
    }

    /// Inner diagonals count as inside if `tight`, and else as edges.
    fn meetings(&mut self, start: DVec3, way: DVec3, tight: bool) -> Meetings {
        let mut found = Meetings { inside: None, edges: Vec::new() };
        // What was met last is likely to be met again and then bounds the search.
        let narrow = if tight { &Narrow::default() } else { &self.narrow };
        if let Some(last) = self.last_first.filter(|_| !narrow.is_on()) {
            let (contact, t) = meet(self.corners(last), start, way);
            if contact == Contact::Inside {
                found.inside = Some((t, last));
            }
        }
        let tracer = self.tracer;
        let limit = |m: Option<(f64, u32)>| m.map_or(1.0, |m| m.0 as f32 * (1.0 + f32::EPSILON));
        let (start32, way32, at_most) = (start.as_vec3(), way.as_vec3(), limit(found.inside));
        narrow.walk(tracer.wide(), (start32, way32), at_most, &mut self.stack, |polygon, _| {
            match meet(corners(tracer, polygon), start, way) {
                (Contact::None, _) => {}
                (Contact::Edge, t) => found.edges.push((t, polygon)),
                (Contact::Diagonal, t) if !tight => found.edges.push((t, polygon)),
                (Contact::Diagonal | Contact::Inside, t) => {
                    let nearer = |m: (f64, u32)| t < m.0 || t == m.0 && polygon < m.1;
                    if found.inside.is_none_or(nearer) {
                        found.inside = Some((t, polygon));
                    }
                }
            }
            limit(found.inside)
        });
        if let Some((limit, _)) = found.inside {
            found.edges.retain(|e| e.0 < limit);
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::super::tracer::{Polygon, Tracer};
    use super::*;

    /// Squares of side 8 in the planes x = 0 and x = 16, each in two halves that meet at y = 0.
    fn walls() -> Tracer {
        let half = |x: f32, y: [f32; 2]| {
            let vertices = [[y[0], -8.0], [y[0], 8.0], [y[1], 8.0], [y[1], -8.0]]
                .map(|[y, z]| Vec3::new(x, y, z));
            Polygon { vertices: vertices.to_vec(), normal: -Vec3::X }
        };
        Tracer::new(vec![
            half(16.0, [-80.0, 0.0]),
            half(16.0, [0.0, 80.0]),
            half(0.0, [-8.0, 0.0]),
            half(0.0, [0.0, 8.0]),
        ])
    }

    fn hit(tracer: &Tracer, from: [f32; 3], direction: Vec3) -> Option<Hit> {
        ShadowRays::new(tracer).first_hit(from.into(), direction, 1e6)
    }

    #[test]
    fn the_nearest_polygon_is_hit_even_through_seams() {
        let walls = walls();
        let at =
            |y: f32, x: f32| hit(&walls, [x, y, 1.0], Vec3::X).map(|h| (h.polygon, h.distance));
        assert_eq!(at(3.0, -4.0), Some((3, 4.0)));
        assert_eq!(at(-3.0, -4.0), Some((2, 4.0)));
        assert_eq!(at(9.0, -4.0), Some((1, 20.0)), "beside the near wall");
        assert_eq!(at(3.0, 1.0), Some((1, 15.0)), "starts behind it");
        assert_eq!(at(3.0, 17.0), None);
        for x in [-4.0, 1.0] {
            let distance = if x < 0.0 { 4.0 } else { 15.0 };
            assert_eq!(at(0.0, x).map(|h| h.1), Some(distance), "along the seam from {x}");
        }
        assert_eq!(hit(&walls, [0.0, 3.0, 1.0], Vec3::X).map(|h| h.polygon), Some(1), "from it");
    }

    #[test]
    fn memory_of_the_last_hit_changes_no_answer() {
        let walls = walls();
        let mut remembering = ShadowRays::new(&walls);
        for i in 0..441_u16 {
            let from = Vec3::new(-3.0, f32::from(i % 21) - 10.0, f32::from(i / 21) - 10.0);
            let direction = Vec3::new(4.0, f32::from(i % 3) - 1.0, f32::from(i % 5) - 2.0);
            let direction = direction.normalize();
            let fresh = ShadowRays::new(&walls).first_hit(from, direction, 1e6);
            assert_eq!(remembering.first_hit(from, direction, 1e6), fresh, "{from} {direction}");
        }
    }
}
