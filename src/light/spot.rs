//! Cones of spotlights (contract section 4.5).

use crate::scene::exact::dot;
use crate::scene::lights::Spot;
use glam::Vec3;

/// Share of the light within the cone, 0 to 1, seen in the unit direction `to_light`: full inside
/// the inner cone, then linear in the cosine; `None` outside the outer cone.
pub(crate) fn share(spot: &Spot, to_light: Vec3) -> Option<f32> {
    let f = dot(spot.direction, to_light);
    if f > spot.outer {
        None
    } else if f > spot.inner {
        Some(1.0 - (f - spot.inner) / (spot.outer - spot.inner))
    } else {
        Some(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_inside_linear_between_none_outside() {
        let spot = Spot { direction: -Vec3::Z, outer: -0.5, inner: -0.75 };
        let at = |cosine: f32| Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        assert_eq!(share(&spot, at(1.0)), Some(1.0));
        assert_eq!(share(&spot, at(0.75)), Some(1.0));
        assert_eq!(share(&spot, at(0.625)), Some(0.5));
        assert_eq!(share(&spot, at(0.5)), Some(0.0));
        assert_eq!(share(&spot, at(0.4375)), None);
        assert_eq!(share(&spot, at(-1.0)), None);
    }

    #[test]
    fn without_a_soft_rim_the_cone_ends_sharply() {
        let spot = Spot { direction: -Vec3::Z, outer: -0.5, inner: -0.5 };
        assert_eq!(share(&spot, Vec3::new(0.0, 0.0, 0.5)), Some(1.0));
        assert_eq!(share(&spot, Vec3::new(0.0, 0.0, 0.4375)), None);
    }
}
