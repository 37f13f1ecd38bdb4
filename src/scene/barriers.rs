//! What keeps bounced light of two nearby points apart: walls, doors and models of `skip` that cast shadow,
//! but not fences, through which both sides see each other.

use super::narrow::Limits;
use super::shadow::ShadowRays;
use super::shaft::Shaft;
use super::{Bounds, Scene};
use glam::Vec3;

/// Most triangles among which rays that run together look for what they meet.
const MOST: usize = 32;
/// Nodes that may be looked at to find them, for each ray.
const STEPS_A_RAY: usize = 4;

/// Traces rays between nearby points.
pub struct Barriers<'a> {
    opaque: ShadowRays<'a>,
    /// Outlines of models without faces.
    hulls: Option<ShadowRays<'a>>,
}

impl<'a> Barriers<'a> {
    /// The barriers of a scene.
    pub fn new(scene: &'a Scene) -> Self {
        let hulls = scene.obstacles.as_ref().map(|o| ShadowRays::new(o.hulls()));
        Self { opaque: ShadowRays::new(&scene.tracer), hulls }
    }

    /// Whether something stands between two points; the ends count as in [`ShadowRays::blocked`].
    pub fn blocked(&mut self, from: Vec3, to: Vec3) -> bool {
        self.opaque.blocked(from, to)
            || self.hulls.as_mut().is_some_and(|hulls| hulls.blocked(from, to))
    }

    /// Until [`Self::anywhere`] is called, [`Self::blocked`] is asked only for that number of points in
    /// these boxes, and is quick.
    pub(crate) fn within(&mut self, from: &Bounds, to: &Bounds, rays: usize) {
        let shaft = Shaft::new(from, to, None);
        let limits = Limits { triangles: MOST, steps: STEPS_A_RAY * rays };
        for rays in std::iter::once(&mut self.opaque).chain(&mut self.hulls) {
            let tree = rays.tracer.wide();
            rays.narrow.enter(tree, &shaft, limits, |_| true);
        }
    }

    /// Points may be anywhere.
    pub(crate) fn anywhere(&mut self) {
        std::iter::once(&mut self.opaque).chain(&mut self.hulls).for_each(|r| r.narrow.leave());
    }

    /// How far it is free from one point towards another, as a share of the way from 0 to 1.
    pub fn free(&mut self, from: Vec3, to: Vec3) -> f32 {
        let Some(direction) = (to - from).try_normalize() else { return 1.0 };
        let reach = from.distance(to);
        let nearest = std::iter::once(&mut self.opaque)
            .chain(&mut self.hulls)
            .filter_map(|rays| rays.first_hit(from, direction, reach))
            .map(|hit| hit.distance)
            .fold(reach, f32::min);
        nearest / reach
    }
}
