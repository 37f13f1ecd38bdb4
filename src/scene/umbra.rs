//! The full shadow that one polygon casts in the light of a point, so that whole surfaces in it need
//! no rays.

use glam::{DVec3, Vec3};

/// What is nearer to the rim of the shadow than this, in world units and as an angle from the light,
/// is left to rays.
const MARGIN: f64 = 0.01;
const MARGIN_ANGLE: f64 = 1e-4;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    middle: DVec3,
    half: DVec3,
}

impl Bounds {
    /// The box around points; `None` without any.
    pub fn around(mut points: impl Iterator<Item = Vec3>) -> Option<Self> {
        let first = points.next()?;
        let (min, max) = points.fold((first, first), |(a, b), p| (a.min(p), b.max(p)));
        let (min, max) = (min.as_dvec3(), max.as_dvec3());
        Some(Self { middle: (min + max) * 0.5, half: (max - min) * 0.5 })
    }

    /// Middle, rounded.
    pub fn centre(&self) -> Vec3 {
        self.middle.as_vec3()
    }

    /// Distance from the middle to a corner.
    pub fn radius(&self) -> f32 {
        self.half.length() as f32
    }

    /// The box of all places at which its points are after a move by `way`.
    pub fn moved(&self, way: DVec3) -> Self {
        Self { middle: self.middle + way, half: self.half }
    }

    /// The box around this one and another.
    pub fn with(&self, other: &Self) -> Self {
        let (low, high) = (self.low().min(other.low()), self.high().max(other.high()));
        Self { middle: (low + high) * 0.5, half: (high - low) * 0.5 }
    }

    /// Whether a point is in the box.
    pub(super) fn contains(&self, point: Vec3) -> bool {
        (point.as_dvec3() - self.middle).abs().cmple(self.half).all()
    }

    /// Whether all of another box is in this one.
    pub(super) fn contains_box(&self, other: &Self) -> bool {
        ((other.middle - self.middle).abs() + other.half).cmple(self.half).all()
    }

    /// Middle.
    pub(super) fn middle(&self) -> DVec3 {
        self.middle
    }

    /// Half the size.
    pub(super) fn half(&self) -> DVec3 {
        self.half
    }

    /// Corner of the least coordinates.
    pub(super) fn low(&self) -> DVec3 {
        self.middle - self.half
    }

    /// Corner of the greatest coordinates.
    pub(super) fn high(&self) -> DVec3 {
        self.middle + self.half
    }
}

/// The space behind a polygon as seen from a light.
#[derive(Clone, Debug)]
pub struct Umbra {
    light: DVec3,
    /// Unit normals of the planes through the light and the edges, to the inside.
    sides: Vec<DVec3>,
    /// Unit normal of the polygon, away from the light, and its distance from the light.
    front: (DVec3, f64),
}

impl Umbra {
    /// The shadow of a convex polygon with the given corners and unit normal; `None` if the light is
    /// in its plane or the polygon has no area.
    pub fn new(corners: &[Vec3], normal: Vec3, light: Vec3) -> Option<Self> {
        let light = light.as_dvec3();
        let away = |v: &Vec3| v.as_dvec3() - light;
        let mut normal = normal.as_dvec3();
        let mut distance = normal.dot(away(corners.first()?));
        if distance < 0.0 {
            (normal, distance) = (-normal, -distance);
        }
        let middle: DVec3 = corners.iter().map(away).sum::<DVec3>() / corners.len() as f64;
        let mut sides = Vec::with_capacity(corners.len());
        for (i, a) in corners.iter().enumerate() {
            let b = &corners[(i + 1) % corners.len()];
            let Some(side) = away(a).cross(away(b)).try_normalize() else { continue };
            sides.push(if side.dot(middle) < 0.0 { -side } else { side });
        }
        (distance > MARGIN && sides.len() > 2).then_some(Self {
            light,
            sides,
            front: (normal, distance),
        })
    }

    /// Whether all of a box is in the shadow, well away from its rim.
    pub fn covers(&self, bounds: &Bounds) -> bool {
        let middle = bounds.middle - self.light;
        let least = |normal: DVec3| normal.dot(middle) - normal.abs().dot(bounds.half);
        let margin = MARGIN + MARGIN_ANGLE * (middle.abs() + bounds.half).element_sum();
        least(self.front.0) >= self.front.1 + MARGIN
            && self.sides.iter().all(|&side| least(side) >= margin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shade() -> Umbra {
        let corners = [[-8.0, -8.0], [-8.0, 8.0], [8.0, 8.0], [8.0, -8.0]];
        let corners = corners.map(|[x, y]| Vec3::new(x, y, 32.0));
        Umbra::new(&corners, Vec3::Z, Vec3::new(0.0, 0.0, 64.0)).unwrap()
    }

    fn covers(min: [f32; 3], max: [f32; 3]) -> bool {
        let corners = [Vec3::from(min), Vec3::from(max)];
        shade().covers(&Bounds::around(corners.into_iter()).unwrap())
    }

    #[test]
    fn boxes_in_the_shadow_are_covered_and_others_not() {
        // The shadow on z = 0 reaches to 16.
        assert!(covers([-15.9, -15.9, 0.0], [15.9, 15.9, 0.0]));
        assert!(!covers([-15.9, -15.9, 0.0], [16.0, 15.9, 0.0]), "at the rim");
        assert!(!covers([0.0, 0.0, 0.0], [0.0, 40.0, 0.0]), "part of it beyond");
        assert!(!covers([-1.0, -1.0, 10.0], [1.0, 1.0, 33.0]), "part of it before the polygon");
        assert!(covers([-1.0, -1.0, 10.0], [1.0, 1.0, 31.0]));
        assert!(!covers([-1.0, -1.0, 90.0], [1.0, 1.0, 100.0]), "behind the light");
    }

    #[test]
    fn lights_in_the_plane_and_slivers_cast_none() {
        let line = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0];
        let of_line = Umbra::new(&line, Vec3::Z, Vec3::Z);
        let below = Bounds::around(std::iter::once(Vec3::new(0.5, 0.0, -9.0))).unwrap();
        assert!(!of_line.is_some_and(|u| u.covers(&below)), "a line covers nothing");
        let square = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        assert!(Umbra::new(&square, Vec3::Z, Vec3::new(9.0, 0.0, 0.0)).is_none());
        assert!(Bounds::around(std::iter::empty()).is_none());
    }
}
