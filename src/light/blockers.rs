//! What last blocked each light. The next surface is likely to be in its shadow too, and often all of
//! it is. What is remembered makes light faster but does not change it.

use crate::scene::{Bounds, Scene, Umbra};

/// The blockers of all lights of a scene.
#[derive(Default)]
pub struct Blockers(Vec<Option<Blocker>>);

struct Blocker {
    /// Index in the scene's tracer.
    polygon: u32,
    umbra: Option<Umbra>,
}

impl Blockers {
    /// Nothing remembered yet.
    pub fn new(scene: &Scene) -> Self {
        Self(scene.lights.iter().map(|_| None).collect())
    }

    /// Whether a box is in full shadow of what blocked light `light` before.
    pub(super) fn cover(&self, light: usize, bounds: &Bounds) -> bool {
        let umbra = self.0[light].as_ref().and_then(|b| b.umbra.as_ref());
        umbra.is_some_and(|u| u.covers(bounds))
    }

    /// What blocked light `light` last.
    pub(super) fn of(&self, light: usize) -> Option<u32> {
        self.0[light].as_ref().map(|b| b.polygon)
    }

    /// Remembers that `polygon` blocked light `light`.
    pub(super) fn remember(&mut self, scene: &Scene, light: usize, polygon: u32) {
        if self.of(light) == Some(polygon) {
            return;
        }
        let shape = &scene.tracer.polygons()[polygon as usize];
        let umbra = Umbra::new(&shape.vertices, shape.normal, scene.lights[light].origin);
        self.0[light] = Some(Blocker { polygon, umbra });
    }
}
