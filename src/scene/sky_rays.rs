//! Whether a ray sees the sky, without a search for the first thing that it meets. Where a ray meets
//! edges this file gives no answer and [`super::first_hit`] decides.

use super::shadow::{Contact, ShadowRays, corners, meet};
use super::tracer::{Hit, Polygon, Tracer};
use glam::Vec3;

/// The sky polygons of a scene.
pub struct Sky {
    pub(super) tracer: Tracer,
    /// Index in the scene's tracer of each polygon of `tracer`.
    polygons: Vec<u32>,
    /// Whether each polygon of the scene's tracer is sky.
    pub(super) is_sky: Vec<bool>,
}

impl Sky {
    /// Picks the sky out of `all`.
    pub(super) fn new(all: &[Polygon], is_sky: Vec<bool>) -> Self {
        let polygons: Vec<u32> = (0..all.len() as u32).filter(|&p| is_sky[p as usize]).collect();
        let own = polygons.iter().map(|&p| all[p as usize].clone()).collect();
        Self { tracer: Tracer::new(own), polygons, is_sky }
    }
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum View {
    /// Sky.
    Sky(Hit),
    /// Something else, or nothing.
    NoSky,
    /// Rounding matters.
    Unsure,
}

impl ShadowRays<'_> {
    /// Whether the first polygon within `reach` of `from` in the unit direction `direction` is sky.
    /// One through `from` itself is not met.
    pub(super) fn view(&mut self, sky: &Sky, from: Vec3, direction: Vec3, reach: f32) -> View {
        let view = self.quick_view(sky, from, direction, reach);
        self.rays += u64::from(view != View::Unsure);
        view
    }

    fn quick_view(&mut self, sky: &Sky, from: Vec3, direction: Vec3, reach: f32) -> View {
        if self.narrow_sky.is_empty() {
            return View::NoSky;
        }
        let (start, way) = (from.as_dvec3(), direction.as_dvec3() * f64::from(reach));
        let (start32, way32) = (start.as_vec3(), way.as_vec3());
        let mut unsure = false;
        let mut nearest: Option<(f64, u32)> = None;
        let ray = (start32, way32);
        self.narrow_sky.walk(sky.tracer.wide(), ray, 1.0, &mut self.stack, |polygon, _| {
            let (contact, t) = meet(corners(&sky.tracer, polygon), start, way);
            match contact {
                Contact::None => {}
                Contact::Edge => unsure = true,
                Contact::Diagonal | Contact::Inside => {
                    let polygon = sky.polygons[polygon as usize];
                    if nearest.is_none_or(|n| t < n.0 || t == n.0 && polygon < n.1) {
                        nearest = Some((t, polygon));
                    }
                }
            }
            1.0
        });
        if unsure {
            return View::Unsure;
        }
        let Some((t, polygon)) = nearest else { return View::NoSky };
        let limit = t as f32 * (1.0 + f32::EPSILON);
        if let Some(last) = self.last_before_sky.filter(|_| !self.narrow.is_on()) {
            let wide = self.tracer.wide();
            if let Some(met) = wide.met_beside(last, ray, limit, |p| !sky.is_sky[p as usize]) {
                self.last_before_sky = Some(met);
                return View::NoSky;
            }
        }
        let (tracer, mut blocker) = (self.tracer, None);
        self.narrow.walk(tracer.wide(), ray, limit, &mut self.stack, |other, surely| {
            if sky.is_sky[other as usize] {
                return limit;
            }
            if surely {
                blocker = Some(other);
                return -1.0;
            }
            let (contact, before) = meet(corners(tracer, other), start, way);
            if contact.is_inside() && before < t {
                blocker = Some(other);
                return -1.0;
            }
            unsure |= contact != Contact::None;
            limit
        });
        if blocker.is_some() {
            self.last_before_sky = blocker;
            View::NoSky
        } else if unsure {
            View::Unsure
        } else {
            View::Sky(Hit { polygon, distance: (t * f64::from(reach)) as f32 })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// An upright square around a point, across the x or y axis.
    fn wall(middle: [i16; 3], across_x: bool) -> Polygon {
        let [x, y, z] = middle.map(f32::from);
        let corner = |side: f32, up: f32| {
            let (dx, dy) = if across_x { (0.0, side) } else { (side, 0.0) };
            Vec3::new(x + dx, y + dy, z + up)
        };
        let vertices = [(-9.0, -9.0), (-9.0, 9.0), (9.0, 9.0), (9.0, -9.0)];
        Polygon {
            vertices: vertices.map(|(side, up)| corner(side, up)).to_vec(),
            normal: if across_x { Vec3::X } else { Vec3::Y },
        }
    }

    proptest! {
        #[test]
        fn the_quick_view_is_what_is_met_first(
            walls in prop::collection::vec(([-40_i16..40, -40_i16..40, -9_i16..9], any::<bool>(), any::<bool>()), 1..40),
            rays in prop::collection::vec(([-50_i16..50, -50_i16..50, -5_i16..5], 0.0_f32..6.3, -0.2_f32..0.2), 40),
        ) {
            let all: Vec<Polygon> = walls.iter().map(|w| wall(w.0, w.1)).collect();
            let is_sky: Vec<bool> = walls.iter().map(|w| w.2).collect();
            let sky = Sky::new(&all, is_sky.clone());
            let tracer = Tracer::new(all);
            // One remembers what it met, which must not matter.
            let mut quick = ShadowRays::new(&tracer);
            for (from, turn, up) in rays {
                let from = Vec3::from(from.map(f32::from)) + Vec3::splat(0.3);
                let direction = Vec3::new(turn.cos(), turn.sin(), up).normalize();
                let met = ShadowRays::new(&tracer).first_hit(from, direction, 1e6);
                let met = met.filter(|h| is_sky[h.polygon as usize]);
                match quick.view(&sky, from, direction, 1e6) {
                    View::Unsure => {}
                    View::NoSky => prop_assert_eq!(met, None),
                    View::Sky(hit) => prop_assert_eq!(Some(hit), met),
                }
            }
        }
    }
}
