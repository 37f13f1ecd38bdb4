//! Shadow rays: whether light gets from one point to another (contract section 7.3).
//!
//! Map geometry and luxels lie on whole numbers, so rays that meet the very edge of a face come in
//! whole rows. Where every ray a hair beside such a ray is blocked in the same place, it runs through
//! the seam of two faces and is blocked too. Otherwise it touches the rim of a solid, where either
//! answer is right, and [`tie`] gives the reference's.

use super::narrow::Narrow;
use super::tie;
use super::tracer::Tracer;
use super::wide_tree::Child;
use glam::{DVec3, Vec3};

/// Barycentric distance to an edge, relative to the triangle, below which a ray meets the edge.
const ON_EDGE: f64 = 1e-6;
/// How far beside a ray its neighbours run, in world units.
const BESIDE: f64 = 1.0 / 512.0;
/// How far apart along its way a ray and its neighbours may meet a surface that is closed around
/// the ray, in world units. Surfaces seen more flatly than 1 in 32 count as open at their seams.
const SAME_PLACE: f64 = 1.0 / 16.0;
/// By how much the neighbours are turned about the ray, in radians: seams run along the axes, and
/// neighbours must not meet edges themselves.
const TURN: f64 = 0.4;

/// No part of a ray is of interest any more.
const STOP: f32 = -1.0;

/// Traces shadow rays and remembers what blocked the last one, as the next is likely to meet it too.
/// What it remembers makes it faster but does not change an answer.
pub struct ShadowRays<'a> {
    pub(super) tracer: &'a Tracer,
    pub(super) last_blocker: Option<u32>,
    pub(super) last_first: Option<u32>,
    pub(super) last_before_sky: Option<u32>,
    /// Where polygons are looked for; neighbours of a ray look everywhere.
    pub(super) narrow: Narrow,
    /// The same for the sky.
    pub(super) narrow_sky: Narrow,
    /// Room for the walk through the tree.
    pub(super) stack: Vec<(f32, Child)>,
    /// Where the last ray met polygons at an edge, and which.
    touched: Vec<(f64, u32)>,
    pub(super) rays: u64,
}

/// How a ray meets a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Contact {
    None,
    Edge,
    /// Where two triangles of its fan meet, which is no edge of the polygon.
    Diagonal,
    Inside,
}

impl Contact {
    /// Whether the ray goes through the polygon, not only along its edge.
    pub(super) fn is_inside(self) -> bool {
        self >= Self::Diagonal
    }
}

impl<'a> ShadowRays<'a> {
    /// A tracer of rays through `tracer`'s polygons.
    pub fn new(tracer: &'a Tracer) -> Self {
        Self {
            tracer,
            last_blocker: None,
            last_first: None,
            last_before_sky: None,
            narrow: Narrow::default(),
            narrow_sky: Narrow::default(),
            stack: Vec::new(),
            touched: Vec::new(),
            rays: 0,
        }
    }

    /// Rays asked for so far.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Whether a polygon lies between the two points. Both sides of a polygon block. A polygon
    /// through `to` itself blocks, one through `from` does not.
    pub fn blocked(&mut self, from: Vec3, to: Vec3) -> bool {
        self.rays += 1;
        if self.narrow.is_empty() {
            return false;
        }
        let (start, way) = (from.as_dvec3(), to.as_dvec3() - from.as_dvec3());
        if let Some(last) = self.last_blocker.filter(|_| !self.narrow.is_on()) {
            let ray = (from, way.as_vec3());
            if let Some(met) = self.tracer.wide().met_beside(last, ray, 1.0, |_| true) {
                self.last_blocker = Some(met);
                return true;
            }
        }
        match self.contact(start, way) {
            Contact::None => false,
            Contact::Diagonal | Contact::Inside => true,
            Contact::Edge => {
                let touched = std::mem::take(&mut self.touched);
                let tied = touched.iter().any(|&(_, p)| tie::blocked(self.corners(p), from, to));
                let mut places = touched.iter().map(|m| m.0);
                let blocked = tied || self.seam(start, way, &mut places).is_some();
                self.touched = touched;
                blocked
            }
        }
    }

    /// The first of the `places`, in lengths of a ray's way, at which the rays a hair beside it all
    /// meet a polygon too: a seam of a closed surface.
    pub(super) fn seam(
        &mut self,
        start: DVec3,
        way: DVec3,
        places: &mut dyn Iterator<Item = f64>,
    ) -> Option<f64> {
        let near = SAME_PLACE / way.length();
        let (x, y) = way.normalize_or_zero().any_orthonormal_pair();
        let (sin, cos) = TURN.sin_cos();
        let (a, b) = (x * cos + y * sin, y * cos - x * sin);
        let mut places: Vec<f64> = places.collect();
        let reach = places.iter().copied().fold(0.0, f64::max) + near;
        let mut found = Vec::new();
        for side in [a, -a, b, -b] {
            self.crossings_beside(start + side * BESIDE, way * reach, &mut found);
            places.retain(|p| found.iter().any(|m| (m.0 * reach - p).abs() <= near));
            if places.is_empty() {
                return None;
            }
        }
        places.into_iter().reduce(f64::min)
    }

    /// Every polygon on the way 0 < t <= 1, in no order: where, which and how it is met.
    pub(super) fn crossings(
        &mut self,
        start: DVec3,
        way: DVec3,
        found: &mut Vec<(f64, u32, Contact)>,
    ) {
        let narrow = std::mem::take(&mut self.narrow);
        self.find_crossings(&narrow, (start, way), found);
        self.narrow = narrow;
    }

    /// The same of a neighbour of a ray.
    fn crossings_beside(&mut self, start: DVec3, way: DVec3, found: &mut Vec<(f64, u32, Contact)>) {
        self.find_crossings(&Narrow::default(), (start, way), found);
    }

    fn find_crossings(
        &mut self,
        narrow: &Narrow,
        (start, way): (DVec3, DVec3),
        found: &mut Vec<(f64, u32, Contact)>,
    ) {
        found.clear();
        let tracer = self.tracer;
        let ray = (start.as_vec3(), way.as_vec3());
        narrow.walk(tracer.wide(), ray, 1.0, &mut self.stack, |polygon, _| {
            let (contact, t) = meet(corners(tracer, polygon), start, way);
            if contact != Contact::None {
                found.push((t, polygon, contact));
            }
            1.0
        });
    }

    pub(super) fn corners(&self, polygon: u32) -> &'a [Vec3] {
        corners(self.tracer, polygon)
    }

    /// The closest contact of a ray with any polygon.
    fn contact(&mut self, start: DVec3, way: DVec3) -> Contact {
        let mut best = Contact::None;
        let (tracer, touched) = (self.tracer, &mut self.touched);
        touched.clear();
        self.narrow.walk(
            tracer.wide(),
            (start.as_vec3(), way.as_vec3()),
            1.0,
            &mut self.stack,
            |polygon, surely| {
                let (contact, t) = if surely {
                    (Contact::Inside, 0.0)
                } else {
                    meet(corners(tracer, polygon), start, way)
                };
                best = best.max(contact);
                match contact {
                    Contact::Diagonal | Contact::Inside => {
                        self.last_blocker = Some(polygon);
                        return STOP;
                    }
                    Contact::Edge => touched.push((t, polygon)),
                    Contact::None => {}
                }
                1.0
            },
        );
        best
    }
}

pub(super) fn corners(tracer: &Tracer, polygon: u32) -> &[Vec3] {
    &tracer.polygons()[polygon as usize].vertices
}

/// How the ray `start + t way`, 0 < t <= 1, meets the fan of triangles around a polygon's first
/// corner. Möller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997), both
/// sides, in double precision so that whole-number geometry is exact. The number is t.
pub(super) fn meet(v: &[Vec3], start: DVec3, way: DVec3) -> (Contact, f64) {
    let corner = v[0].as_dvec3();
    let from_corner = start - corner;
    let mut best = (Contact::None, f64::INFINITY);
    let mut ab = v[1].as_dvec3() - corner;
    // How the triangle before is turned, if the ray meets it on the diagonal to the next.
    let mut shared = 0.0;
    for c in &v[2..] {
        let ac = c.as_dvec3() - corner;
        let p = way.cross(ac);
        let q = from_corner.cross(ab);
        let det = ab.dot(p);
        let scale = det.abs();
        let sign = det.signum();
        let (u, v, t) = (from_corner.dot(p) * sign, way.dot(q) * sign, ac.dot(q) * sign);
        let w = scale - u - v;
        let edge = ON_EDGE * scale;
        let before = std::mem::take(&mut shared);
        if scale > 0.0 && t > 0.0 && t <= scale && u.min(v).min(w) >= -edge {
            let contact = match (u.min(w) > edge, v > edge, before == sign) {
                (true, true, _) => return (Contact::Inside, t / scale),
                (true, false, true) => Contact::Diagonal,
                _ => Contact::Edge,
            };
            if contact > best.0 {
                best = (contact, t / scale);
            }
            shared = if v.min(w) > edge { sign } else { 0.0 };
        }
        ab = ac;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::super::tracer::Polygon;
    use super::*;

    fn square(corners: [[f32; 3]; 4]) -> Polygon {
        let vertices = corners.map(Vec3::from).to_vec();
        let normal = (vertices[2] - vertices[0]).cross(vertices[1] - vertices[0]).normalize();
        Polygon { vertices, normal }
    }

    /// Two halves of a wall in the plane x = 0 that meet at y = 0.
    fn wall() -> Tracer {
        let half = |y0: f32, y1: f32| {
            square([[0.0, y0, -8.0], [0.0, y0, 8.0], [0.0, y1, 8.0], [0.0, y1, -8.0]])
        };
        Tracer::new(vec![half(-8.0, 0.0), half(0.0, 8.0)])
    }

    fn blocked(tracer: &Tracer, from: [f32; 3], to: [f32; 3]) -> bool {
        let (from, to) = (Vec3::from(from), Vec3::from(to));
        let answer = ShadowRays::new(tracer).blocked(from, to);
        assert_eq!(answer, ShadowRays::new(tracer).blocked(to, from), "from either end");
        answer
    }

    #[test]
    fn walls_block_even_through_their_seams() {
        let wall = wall();
        assert!(blocked(&wall, [-4.0, 2.0, 1.0], [4.0, 3.0, 1.0]));
        assert!(blocked(&wall, [-4.0, 0.0, 1.0], [4.0, 0.0, 1.0]), "along the seam");
        assert!(blocked(&wall, [-4.0, -1.0, 1.0], [4.0, 1.0, -1.0]), "across the seam");
        assert!(!blocked(&wall, [-4.0, 9.0, 1.0], [4.0, 9.0, 1.0]), "beside");
        assert!(!blocked(&wall, [-4.0, 2.0, 1.0], [-1.0, 3.0, 1.0]), "ends before");
    }

    #[test]
    fn inner_diagonals_are_inside() {
        // A house front with a corner on its left side, looked at along the plane x = z / slope, as
        // flat as can be. The fan around the first corner has its diagonals where no edge is.
        let front: [[f32; 2]; 6] =
            [[0.0, 0.0], [0.0, 4.0], [0.0, 8.0], [4.0, 12.0], [8.0, 8.0], [8.0, 0.0]];
        let corners = front.map(|[y, z]| Vec3::new(0.0, y, z));
        let through = |y: f64, z: f64, slope: f64| {
            let way = DVec3::new(1.0, slope, 0.5 * slope);
            meet(&corners, DVec3::new(0.0, y, z) - way, way * 4.0)
        };
        for slope in [0.0, 1.0, 1024.0] {
            for along in [0.25, 0.5, 0.75] {
                for [y, z] in &front[2..5] {
                    let (contact, t) = through(f64::from(*y) * along, f64::from(*z) * along, slope);
                    let real = *y == 0.0;
                    let want = if real { Contact::Edge } else { Contact::Diagonal };
                    assert_eq!((contact, t), (want, 0.25), "{slope}: {along} of {y} {z}");
                }
            }
            for [y, z] in front {
                assert_eq!(through(y.into(), z.into(), slope).0, Contact::Edge, "corner {y} {z}");
            }
        }
    }

    #[test]
    fn folds_of_a_fan_are_edges() {
        // The fan around the corner 0 0 of this dart covers the notch between 4 1 and 8 0 twice.
        let dart = [[0.0, 0.0], [8.0, 0.0], [4.0, 1.0], [4.0, 8.0]];
        let dart = dart.map(|[y, z]| Vec3::new(0.0, y, z));
        let at = |y: f64, z: f64| meet(&dart, DVec3::new(-1.0, y, z), DVec3::X * 2.0).0;
        assert_eq!(at(2.0, 0.5), Contact::Diagonal, "no edge");
        let fold = [[0.0, 0.0], [8.0, 0.0], [4.0, 1.0], [6.0, 0.5]];
        let fold = fold.map(|[y, z]| Vec3::new(0.0, y, z));
        let on = meet(&fold, DVec3::new(-1.0, 2.0, 0.5), DVec3::X * 2.0).0;
        assert_eq!(on, Contact::Edge, "the fan turns back here");
    }

    #[test]
    fn walls_block_at_the_edge_where_they_meet() {
        // The sides x = 0 and y = 0 of a block with its edge along the z axis.
        let sides = Tracer::new(vec![
            square([[0.0, 0.0, -8.0], [0.0, 0.0, 8.0], [0.0, 8.0, 8.0], [0.0, 8.0, -8.0]]),
            square([[0.0, 0.0, -8.0], [8.0, 0.0, -8.0], [8.0, 0.0, 8.0], [0.0, 0.0, 8.0]]),
        ]);
        for (x, y) in [(1.0, 1.0), (1.0, 2.0), (5.0, 1.0)] {
            assert!(blocked(&sides, [-x, -y, 1.0], [x, y, 1.0]), "{x} {y} into the block");
            assert!(blocked(&sides, [-x, -y, -4.0], [x, y, 5.0]), "{x} {y} and up");
        }
        // Past the edge on the outside: no seam, whatever rounding makes of it.
        let (start, way) = (DVec3::new(-4.0, 4.0, 1.0), DVec3::new(8.0, -8.0, 0.0));
        assert_eq!(ShadowRays::new(&sides).seam(start, way, &mut [0.5].into_iter()), None);
    }

    #[test]
    fn rims_at_different_depths_are_no_seam() {
        // Seen along x, a plate below y = 8 in front and one above it behind, or both below.
        let plate = |x: f32, y0: f32, y1: f32| {
            square([[x, y0, -8.0], [x, y0, 8.0], [x, y1, 8.0], [x, y1, -8.0]])
        };
        let (from, to) = (Vec3::new(-4.0, 8.0, 1.0), Vec3::new(20.0, 8.0, 1.0));
        let seam = |behind: [f32; 3]| {
            let tracer =
                Tracer::new(vec![plate(0.0, 0.0, 8.0), plate(behind[0], behind[1], behind[2])]);
            let mut rays = ShadowRays::new(&tracer);
            let tied = tracer.polygons().iter().any(|p| tie::blocked(&p.vertices, from, to));
            let (start, way) = (from.as_dvec3(), (to - from).as_dvec3());
            let places = [4.0, 4.0 + f64::from(behind[0])].map(|d| d / way.x);
            let seam = rays.seam(start, way, &mut places.into_iter()).is_some();
            assert_eq!(rays.blocked(from, to), tied || seam, "{behind:?}");
            (seam, tied)
        };
        assert_eq!(seam([0.0, 8.0, 16.0]), (true, true), "one wall");
        assert_eq!(seam([0.5, 8.0, 16.0]), (false, true), "the low rim behind decides");
        assert_eq!(seam([10.0, 8.0, 16.0]), (false, true));
        assert_eq!(seam([10.0, 0.0, 8.0]), (false, false), "light passes two high rims");
    }

    #[test]
    fn only_rays_along_the_rim_depend_on_rounding() {
        let wall = wall();
        assert!(!blocked(&wall, [-4.0, 8.0, 1.0], [4.0, 8.0, 1.0]), "as the reference has it");
        assert!(blocked(&wall, [-4.0, 7.9999, 1.0], [4.0, 7.9999, 1.0]));
        assert!(!blocked(&wall, [-4.0, 8.0001, 1.0], [4.0, 8.0001, 1.0]));
    }

    #[test]
    fn ends_count_as_documented() {
        let wall = wall();
        let mut rays = ShadowRays::new(&wall);
        assert!(rays.blocked(Vec3::new(-4.0, 2.0, 1.0), Vec3::new(0.0, 2.0, 1.0)));
        assert!(
            !ShadowRays::new(&wall).blocked(Vec3::new(0.0, 2.0, 1.0), Vec3::new(4.0, 2.0, 1.0))
        );
        assert!(!rays.blocked(Vec3::ONE, Vec3::ONE), "a ray of no length");
        assert!(!ShadowRays::new(&Tracer::new(Vec::new())).blocked(Vec3::ZERO, Vec3::ONE));
        assert_eq!(rays.rays(), 2);
    }

    #[test]
    fn memory_of_the_last_blocker_changes_no_answer() {
        let wall = wall();
        let mut remembering = ShadowRays::new(&wall);
        for i in 0..400_u16 {
            let (a, b) = (f32::from(i % 20) - 10.0, f32::from(i / 20) - 10.0);
            let (from, to) = (Vec3::new(-3.0, a, b), Vec3::new(5.0, b, a));
            assert_eq!(
                remembering.blocked(from, to),
                ShadowRays::new(&wall).blocked(from, to),
                "{from} {to}"
            );
        }
    }
}
