//! What last blocked each light. The next surface is likely to be in its shadow too, and often all of
//! it is. What is remembered makes light faster but does not change it.

use crate::scene::{Bounds, Scene, Umbra};

/// Blockers that are remembered of each light.
const MOST: usize = 4;

/// The blockers of all lights of a scene, the last of each first.
#[derive(Default)]
pub struct Blockers(Vec<Vec<Blocker>>);

struct Blocker {
    /// Index in the scene's tracer.
    polygon: u32,
    umbra: Option<Umbra>,
}

impl Blockers {
    /// Nothing remembered yet.
    pub fn new(scene: &Scene) -> Self {
        Self(scene.lights.iter().map(|_| Vec::new()).collect())
    }

    /// Whether a box is in full shadow of one of those that blocked light `light` before.
    pub(super) fn cover(&self, light: usize, bounds: &Bounds) -> bool {
        self.0[light].iter().any(|b| b.umbra.as_ref().is_some_and(|u| u.covers(bounds)))
    }

    /// What blocked light `light` last.
    pub(super) fn of(&self, light: usize) -> Option<u32> {
        self.0[light].first().map(|b| b.polygon)
    }

    /// Remembers that `polygon` blocked light `light`.
    pub(super) fn remember(&mut self, scene: &Scene, light: usize, polygon: u32) {
        let known = &mut self.0[light];
        if let Some(at) = known.iter().position(|b| b.polygon == polygon) {
            known[..=at].rotate_right(1);
            return;
        }
        let shape = &scene.tracer.polygons()[polygon as usize];
        let umbra = Umbra::new(&shape.vertices, shape.normal, scene.lights[light].origin);
        known.truncate(MOST - 1);
        known.insert(0, Blocker { polygon, umbra });
    }
}
