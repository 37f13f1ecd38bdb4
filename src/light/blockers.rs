//! What last blocked each light. The next surface is likely to be in its shadow too, and often all of
//! it is. What is remembered makes light faster but does not change it.

use super::Candidates;
use crate::scene::{Bounds, Scene, Umbra};
use std::sync::Arc;

/// Blockers that are remembered of each light.
const MOST: usize = 4;

/// The blockers of all lights of a scene, the last of each first.
pub struct Blockers {
    of_lights: Vec<Vec<Blocker>>,
    /// The lights that surfaces may get light from, if that is known.
    candidates: Option<Arc<Candidates>>,
}

struct Blocker {
    /// Index in the scene's tracer.
    polygon: u32,
    umbra: Option<Umbra>,
}

impl Blockers {
    /// Nothing remembered yet.
    pub fn new(scene: &Scene) -> Self {
        let of_lights = scene.lights.iter().map(|_| Vec::new()).collect();
        Self { of_lights, candidates: None }
    }

    /// The same, where it is known which lights each surface may get light from.
    pub fn among(scene: &Scene, candidates: Arc<Candidates>) -> Self {
        Self { candidates: Some(candidates), ..Self::new(scene) }
    }

    /// The lights of which `surface` may get light, as far as is known, in their order.
    pub(super) fn lights_of(&self, surface: usize) -> Vec<u32> {
        match self.candidates.as_ref().and_then(|known| known.of(surface)) {
            Some(known) => known.to_vec(),
            None => (0..self.of_lights.len() as u32).collect(),
        }
    }

    /// Whether a box is in full shadow of one of those that blocked light `light` before.
    pub(super) fn cover(&self, light: usize, bounds: &Bounds) -> bool {
        self.of_lights[light].iter().any(|b| b.umbra.as_ref().is_some_and(|u| u.covers(bounds)))
    }

    /// What blocked light `light` last.
    pub(super) fn of(&self, light: usize) -> Option<u32> {
        self.of_lights[light].first().map(|b| b.polygon)
    }

    /// Remembers that `polygon` blocked light `light`.
    pub(super) fn remember(&mut self, scene: &Scene, light: usize, polygon: u32) {
        let known = &mut self.of_lights[light];
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
