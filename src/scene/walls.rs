//! Polygons that hide a light from all of a box together, as they are joined at their edges: the umbra
//! of a wall of many faces, or of two walls at a corner. [`super::umbra`] is that of one polygon.
//!
//! All is seen from the light, in a plane across the way to the box (for a point by central, for a sun
//! by parallel projection). If the first polygon holds the middle of the box, and each edge that comes
//! near the box leads on to another polygon on its far side, then no way from the middle to any other
//! point of the box leaves them. Where two polygons share an edge, both of its ends the same to the last
//! bit, rays cannot pass between: those a hair beside meet one of the two in the same place
//! ([`super::shadow`]).

use super::tracer::{Polygon, Tracer};
use super::umbra::Bounds;
use glam::{DVec3, Vec3};

/// For edges that belong to one polygon only.
const NOTHING: u32 = u32::MAX;
/// Polygons that are narrower, or less flat, than this are left out, in world units.
const NARROW: f64 = 0.25;
const UNEVEN: f64 = 1.0 / 64.0;
/// How far the box must be behind each polygon, and the light before it, in world units.
const BEHIND: f64 = 1.0 / 16.0;
/// Least cosine between the way of light and the normal of a polygon. Twice what makes a seam tight.
const STEEP: f64 = 1.0 / 16.0;
/// What is nearer to the rim of joined polygons than this, in world units and as a tangent seen from
/// the light, is left to rays.
const MARGIN: f64 = 1.0 / 32.0;
const MARGIN_TANGENT: f64 = 5e-4;
/// Boxes that look wider than this from the light, as a tangent to either side, are left to their parts.
const WIDE: f64 = 1.5;
/// Most polygons that are looked at.
const MOST: usize = 32;

/// How the polygons of a tracer are joined.
pub(super) struct Walls {
    /// Where the edges of a polygon end in `across`.
    ends: Vec<u32>,
    /// The polygon across each edge, or [`NOTHING`].
    across: Vec<u32>,
    /// Whether each polygon can be part of a wall.
    fit: Vec<bool>,
}

impl Walls {
    /// Joins polygons.
    pub fn new(polygons: &[Polygon]) -> Self {
        let (mut ends, mut edges) = (Vec::with_capacity(polygons.len()), Vec::new());
        for (index, polygon) in polygons.iter().enumerate() {
            let v = &polygon.vertices;
            for (i, a) in v.iter().enumerate() {
                let b = &v[(i + 1) % v.len()];
                // Minus zero is zero.
                let [a, b] = [a, b].map(|p| (*p + Vec3::ZERO).to_array().map(f32::to_bits));
                edges.push((a.min(b), a.max(b), index as u32, edges.len() as u32));
            }
            ends.push(edges.len() as u32);
        }
        let mut across = vec![NOTHING; edges.len()];
        edges.sort_unstable();
        let normal = |p: u32| polygons[p as usize].normal;
        for shared in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            for &(.., polygon, edge) in shared {
                // The flattest way on.
                let others = shared.iter().map(|s| s.2).filter(|&p| p != polygon);
                let flat = |p: &u32| normal(*p).dot(normal(polygon));
                let best = others.max_by(|a, b| flat(a).total_cmp(&flat(b)).then(b.cmp(a)));
                across[edge as usize] = best.unwrap_or(NOTHING);
            }
        }
        Self { ends, across, fit: polygons.iter().map(is_fit).collect() }
    }

    /// The polygons across the edges of a polygon, in the order of its corners.
    fn across(&self, polygon: u32) -> &[u32] {
        let first = if polygon == 0 { 0 } else { self.ends[polygon as usize - 1] };
        &self.across[first as usize..self.ends[polygon as usize] as usize]
    }
}

/// Whether a polygon is flat and wide.
fn is_fit(polygon: &Polygon) -> bool {
    let v: Vec<DVec3> = polygon.vertices.iter().map(|v| v.as_dvec3()).collect();
    let normal = polygon.normal.as_dvec3();
    let is_flat = v.iter().all(|p| normal.dot(*p - v[0]).abs() <= UNEVEN);
    let width = |i: usize| {
        let (a, b) = (v[i], v[(i + 1) % v.len()]);
        let side = normal.cross(b - a).try_normalize()?;
        v.iter().map(|p| side.dot(*p - a).abs()).reduce(f64::max)
    };
    is_flat && (0..v.len()).filter_map(width).reduce(f64::min).is_some_and(|w| w >= NARROW)
}

/// Where rays of light come from.
#[derive(Clone, Copy, Debug)]
pub(super) enum Origin {
    /// A point.
    Point(Vec3),
    /// Far away in a unit direction.
    Far(Vec3),
}

/// An edge of a polygon before the box.
struct Side {
    /// Distance to the inner side of the edge in the plane of projection: that of a point and a constant.
    inwards: [f64; 2],
    rest: f64,
    across: u32,
    /// Whether it comes near the box.
    is_near: bool,
}

/// A box as a light sees it.
struct View {
    from: Origin,
    bounds: Bounds,
    /// The light, or the middle of the box for one that is far away.
    origin: DVec3,
    /// Along the way of light, and two directions across.
    ahead: DVec3,
    axes: [DVec3; 2],
    /// Where the corners of the box are in the plane of projection; its middle is at zero.
    corners: [[f64; 2]; 8],
    count: usize,
}

impl View {
    /// `None` if the box is too wide.
    fn new(from: Origin, bounds: &Bounds) -> Option<Self> {
        let (origin, ahead) = match from {
            Origin::Point(light) => (light.as_dvec3(), bounds.middle() - light.as_dvec3()),
            Origin::Far(direction) => (bounds.middle(), -direction.as_dvec3()),
        };
        let ahead = ahead.try_normalize()?;
        let (x, y) = ahead.any_orthonormal_pair();
        let mut view = Self {
            from,
            bounds: *bounds,
            origin,
            ahead,
            axes: [x, y],
            corners: [[0.0; 2]; 8],
            count: 0,
        };
        for k in 0..8_u32 {
            let sign = |axis: u32| if k >> axis & 1 == 0 { -1.0 } else { 1.0 };
            let signs = DVec3::new(sign(0), sign(1), sign(2));
            // A box without depth has four corners.
            if (0..3).any(|axis| signs[axis] > 0.0 && bounds.half()[axis] == 0.0) {
                continue;
            }
            let corner = view.project(bounds.middle() + bounds.half() * signs - origin)?;
            if matches!(from, Origin::Point(_)) && corner.iter().any(|c| c.abs() > WIDE) {
                return None;
            }
            view.corners[view.count] = corner;
            view.count += 1;
        }
        Some(view)
    }

    fn corners(&self) -> &[[f64; 2]] {
        &self.corners[..self.count]
    }

    /// Place in the plane of projection; `None` behind the light.
    fn project(&self, off: DVec3) -> Option<[f64; 2]> {
        let at = self.axes.map(|axis| off.dot(axis));
        match self.from {
            Origin::Far(_) => Some(at),
            Origin::Point(_) => {
                let depth = off.dot(self.ahead);
                (depth > 0.0).then(|| at.map(|c| c / depth))
            }
        }
    }

    /// Adds the edges of a polygon, the first of which is to hold the middle of the box. The answer is how
    /// far away it is at most, for light from far away; `None` if it is not before all of the box, or may
    /// not count.
    fn add(
        &self,
        walls: &Walls,
        (shape, index): (&Polygon, u32),
        sides: &mut Vec<Side>,
    ) -> Option<f64> {
        if !walls.fit[index as usize] {
            return None;
        }
        let corner = |i: usize| shape.vertices[i].as_dvec3() - self.origin;
        let mut normal = shape.normal.as_dvec3();
        let mut place = normal.dot(corner(0));
        let backwards = match self.from {
            Origin::Point(_) => place < 0.0,
            Origin::Far(_) => normal.dot(self.ahead) < 0.0,
        };
        if backwards {
            (normal, place) = (-normal, -place);
        }
        let middle = normal.dot(self.bounds.middle() - self.origin);
        let reach = normal.abs().dot(self.bounds.half());
        if middle - reach < place + BEHIND {
            return None;
        }
        let along = normal.dot(self.ahead);
        let (margin, depth) = match self.from {
            Origin::Far(_) if along < STEEP => return None,
            Origin::Far(_) => (MARGIN, (middle + reach - place) / along),
            Origin::Point(_) => {
                if place < BEHIND {
                    return None;
                }
                let across = self.axes.map(|a| normal.dot(a));
                let mut most = 0.0_f64;
                for [x, y] in self.corners() {
                    let cosine = across[0] * x + across[1] * y + along;
                    if cosine < STEEP * (1.0 + x * x + y * y).sqrt() {
                        return None;
                    }
                    most = most.max(cosine);
                }
                (MARGIN_TANGENT + MARGIN * most / place, 0.0)
            }
        };
        let count = shape.vertices.len();
        let centre = (0..count).map(corner).sum::<DVec3>() / count as f64;
        let is_first = sides.is_empty();
        for (i, &across) in walls.across(index).iter().enumerate() {
            let (a, b) = (corner(i), corner((i + 1) % count));
            let (normal, inside, rest) = match self.from {
                Origin::Point(_) => {
                    let n = a.cross(b);
                    (n, n.dot(centre), n.dot(self.ahead))
                }
                Origin::Far(_) => {
                    let n = (b - a).cross(self.ahead);
                    (n, n.dot(centre - a), -n.dot(a))
                }
            };
            let [x, y] = self.axes.map(|axis| normal.dot(axis));
            let size = (x * x + y * y).sqrt();
            if size <= 1e-9 * normal.length() {
                return None;
            }
            let unit = size.recip().copysign(inside);
            let mut side =
                Side { inwards: [x * unit, y * unit], rest: rest * unit, across, is_near: false };
            // The first is to hold the middle of the box, which is at zero.
            if is_first && side.rest < 0.0 {
                return None;
            }
            side.is_near = self.is_near(&side, [a, b], margin);
            sides.push(side);
        }
        Some(depth)
    }

    /// Whether an edge between two points may come nearer to the box than a margin.
    fn is_near(&self, side: &Side, ends: [DVec3; 2], margin: f64) -> bool {
        let [x, y] = side.inwards;
        let least =
            self.corners().iter().map(|c| c[0] * x + c[1] * y).fold(f64::INFINITY, f64::min);
        if least + side.rest >= margin {
            return false;
        }
        let [Some(a), Some(b)] = ends.map(|e| self.project(e)) else { return true };
        let along = |c: &[f64; 2]| c[1] * x - c[0] * y;
        let (low, high) = self
            .corners()
            .iter()
            .map(along)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c), h.max(c)));
        let (a, b) = (along(&a), along(&b));
        a.min(b) - margin < high && a.max(b) + margin > low
    }
}

/// What polygons that are joined to one hide of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Hidden {
    /// All of it. They are at most so far away, for light from far away.
    All(f64),
    /// Its middle, behind that polygon.
    Middle,
    /// Perhaps nothing.
    Unknown,
}

/// Finds walls before a box; the room for it is kept.
#[derive(Default)]
pub(super) struct Cover {
    view: Option<View>,
    /// Polygons, and where their sides end.
    polygons: Vec<(u32, usize)>,
    sides: Vec<Side>,
}

impl Cover {
    /// From now on it is asked what is between a box and where light comes from. False if the box is too
    /// wide for an answer.
    pub fn look_at(&mut self, bounds: &Bounds, from: Origin) -> bool {
        self.view = View::new(from, bounds);
        self.view.is_some()
    }

    /// What `first`, and polygons joined to it that pass `wanted`, hide of the box.
    pub fn hidden_by(
        &mut self,
        tracer: &Tracer,
        first: u32,
        wanted: impl Fn(u32) -> bool,
    ) -> Hidden {
        let Some(view) = &self.view else { return Hidden::Unknown };
        self.polygons.clear();
        self.sides.clear();
        let shape = &tracer.polygons()[first as usize];
        let depth = view.add(tracer.walls(), (shape, first), &mut self.sides);
        let Some(depth) = depth else { return Hidden::Unknown };
        self.polygons.push((first, self.sides.len()));
        self.spread(tracer, depth, wanted).map_or(Hidden::Middle, Hidden::All)
    }

    /// Follows the edges near the box from polygon to polygon. `None` if one leads nowhere.
    fn spread(
        &mut self,
        tracer: &Tracer,
        mut depth: f64,
        wanted: impl Fn(u32) -> bool,
    ) -> Option<f64> {
        let (view, walls) = (self.view.as_ref()?, tracer.walls());
        let (mut own, mut at) = (0, 0);
        while at < self.sides.len() {
            while self.polygons[own].1 <= at {
                own += 1;
            }
            let Side { across, is_near, inwards, .. } = self.sides[at];
            at += 1;
            if !is_near {
                continue;
            }
            if across == NOTHING || !wanted(across) {
                return None;
            }
            let there = match self.polygons.iter().position(|p| p.0 == across) {
                Some(known) => known,
                None if self.polygons.len() == MOST => return None,
                None => {
                    let shape = (&tracer.polygons()[across as usize], across);
                    depth = depth.max(view.add(walls, shape, &mut self.sides)?);
                    self.polygons.push((across, self.sides.len()));
                    self.polygons.len() - 1
                }
            };
            // The other polygon is to be on the other side.
            let first = if there == 0 { 0 } else { self.polygons[there - 1].1 };
            let goes_on = self.sides[first..self.polygons[there].1].iter().any(|s| {
                let same = s.inwards[0] * inwards[0] + s.inwards[1] * inwards[1];
                s.across == self.polygons[own].0 && same < -0.9
            });
            if !goes_on {
                return None;
            }
        }
        Some(depth)
    }
}

#[cfg(test)]
mod tests {
    use super::super::shadow::ShadowRays;
    use super::*;
    use proptest::prelude::*;

    /// The outside of a block, each side cut into faces along whole numbers.
    fn block(low: [i16; 3], size: [i16; 3], cuts: i16, polygons: &mut Vec<Polygon>) {
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for (high, i, j) in [0, 1]
                .into_iter()
                .flat_map(|h| (0..cuts).flat_map(move |i| (0..cuts).map(move |j| (h, i, j))))
            {
                let corner = |i: i16, j: i16| {
                    let mut p = low;
                    p[axis] += high * size[axis];
                    p[u] += size[u] * i / cuts;
                    p[v] += size[v] * j / cuts;
                    Vec3::from(p.map(f32::from))
                };
                let vertices =
                    vec![corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
                let normal = Vec3::AXES[axis] * (f32::from(high) * 2.0 - 1.0);
                polygons.push(Polygon { vertices, normal });
            }
        }
    }

    /// Whether the light of a point or a direction is hidden from a box, by what is met first on the way to
    /// its middle.
    fn is_hidden(tracer: &Tracer, origin: Origin, bounds: &Bounds) -> bool {
        let middle = bounds.middle().as_vec3();
        let first = match origin {
            Origin::Point(light) => {
                let mut rays = ShadowRays::new(tracer);
                if rays.blocked(light, middle) { rays.last_blocker } else { None }
            }
            Origin::Far(way) => {
                ShadowRays::new(tracer).first_hit(middle, way, 1e6).map(|h| h.polygon)
            }
        };
        let mut cover = Cover::default();
        cover.look_at(bounds, origin)
            && first.is_some_and(|p| matches!(cover.hidden_by(tracer, p, |_| true), Hidden::All(_)))
    }

    fn around(low: [f32; 3], high: [f32; 3]) -> Bounds {
        Bounds::around([Vec3::from(low), Vec3::from(high)].into_iter()).unwrap()
    }

    #[test]
    fn corners_of_many_faces_hide_what_no_face_does() {
        let mut polygons = Vec::new();
        block([-64, -64, 0], [128, 128, 128], 4, &mut polygons);
        let tracer = Tracer::new(polygons);
        for light in [[-300.0, -280.0, 40.0], [-300.0, 1.0, 40.0]] {
            let hidden = |low, high| {
                is_hidden(&tracer, Origin::Point(Vec3::from(light)), &around(low, high))
            };
            assert!(hidden([70.0, 70.0, 4.0], [100.0, 90.0, 30.0]), "behind the block");
            assert!(!hidden([70.0, 70.0, 4.0], [300.0, 100.0, 30.0]), "part of it beside");
            assert!(!hidden([70.0, 70.0, 4.0], [100.0, 100.0, 600.0]), "part of it above");
            assert!(!hidden([-90.0, -90.0, 4.0], [-70.0, -70.0, 30.0]), "before the block");
            assert!(!hidden([60.0, 60.0, 4.0], [100.0, 100.0, 200.0]), "part of it on the block");
        }
        let low_sun = Origin::Far(Vec3::new(-1.0, -0.9, 0.2).normalize());
        assert!(is_hidden(&tracer, low_sun, &around([70.0, 70.0, 4.0], [100.0, 100.0, 30.0])));
        assert!(!is_hidden(&tracer, low_sun, &around([70.0, 70.0, 4.0], [100.0, 100.0, 130.0])));
    }

    #[test]
    fn a_missing_face_lets_light_through() {
        let mut polygons = Vec::new();
        block([-64, -64, 0], [128, 128, 128], 4, &mut polygons);
        let box_behind = around([70.0, -90.0, 4.0], [100.0, 90.0, 170.0]);
        let light = Origin::Point(Vec3::new(-300.0, 1.0, 40.0));
        assert!(is_hidden(&Tracer::new(polygons.clone()), light, &box_behind));
        // Only the side towards the light counts, as the search begins there.
        polygons.retain(|p| p.normal != Vec3::X);
        let whole = polygons.clone();
        let towards = |p: &Polygon| p.normal == -Vec3::X;
        for hole in (0..whole.len()).filter(|&i| towards(&whole[i])) {
            let mut holed = whole.clone();
            holed.remove(hole);
            assert!(!is_hidden(&Tracer::new(holed), light, &box_behind), "face {hole}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]
        #[test]
        fn what_is_hidden_gets_no_ray(
            blocks in prop::collection::vec(
                (prop::array::uniform3(-60_i16..40), prop::array::uniform3(1_i16..9), 1_i16..4), 1..6),
            light in prop::array::uniform3(-120_i16..120),
            boxes in prop::collection::vec(
                (prop::array::uniform3(-120_i16..120), prop::array::uniform3(0_i16..30)), 12),
            far in any::<bool>(),
            raised in prop_oneof![Just(0.0_f32), Just(0.03)],
        ) {
            let mut polygons = Vec::new();
            for (low, size, cuts) in blocks {
                // So that faces end at whole numbers.
                block(low, size.map(|s| 12 * s), cuts, &mut polygons);
            }
            let tracer = Tracer::new(polygons);
            let light = Vec3::from(light.map(f32::from)) + raised;
            let way = light.normalize_or(Vec3::Z);
            let origin = if far { Origin::Far(way) } else { Origin::Point(light) };
            for (low, size) in boxes {
                let low = Vec3::from(low.map(f32::from));
                let size = Vec3::from(size.map(f32::from));
                let bounds = Bounds::around([low, low + size].into_iter()).unwrap();
                if !is_hidden(&tracer, origin, &bounds) {
                    continue;
                }
                for k in 0..125_u8 {
                    let share = [k % 5, k / 5 % 5, k / 25].map(|i| f32::from(i) / 4.0);
                    let at = low + size * Vec3::from(share);
                    let mut rays = ShadowRays::new(&tracer);
                    let reaches = if far {
                        rays.first_hit(at, way, 1e6).is_none()
                    } else {
                        !rays.blocked(at, light)
                    };
                    prop_assert!(!reaches, "{origin:?} reaches {at}");
                }
            }
        }
    }
}
