//! What glass, curtains and patterns of a map are expected to take while light bounces, from some hemicubes.

use crate::patch::MapPatches;
use crate::radiosity::hemicube::{DeltaFormFactors, View};
use crate::radiosity::transfers::{Gatherer, OVERLAY_ENTRY};
use crate::scene::Scene;
use crate::scene::effects::Cost;
use crate::settings::Settings;
use crate::stage::Points;

/// Hemicubes that are drawn.
const SAMPLED: usize = 64;

/// What is expected of a map whose light bounces.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ThroughCosts {
    /// Of glass.
    pub glass: Cost,
    /// Of light that comes through diffusely.
    pub curtains: Cost,
    /// Of patterns.
    pub shaders: Cost,
}

impl ThroughCosts {
    /// Cuts patches as a run does and looks around from some; a run will draw so many hemicubes at patches
    /// and at luxels.
    pub fn sample(
        scene: &Scene,
        points: &Points,
        settings: &Settings,
        hemicubes: [f64; 2],
    ) -> Self {
        let patches = MapPatches::new(scene, &points.luxels, settings.patch_size);
        let curtains = curtain_cost(patches.set.passages.len(), patches.set.patches.len(), 1);
        let all = &patches.set.patches;
        let Some(overlay) = patches.set.overlay.as_deref().filter(|_| !all.is_empty()) else {
            return Self { curtains, ..Self::default() };
        };
        let delta = DeltaFormFactors::new(settings.hemicube);
        let tracer = scene.bounce_tracer();
        let mut gatherer = Gatherer::new(tracer, &patches.set, &delta, settings.hemicube);
        let (mut drawn, mut entries) = (0.0, 0.0);
        for (i, patch) in all.iter().enumerate().step_by(all.len().div_ceil(SAMPLED)) {
            gatherer.look(&View::turned(patch.eye, patch.normal, i as u64));
            drawn += 1.0;
            entries += gatherer.overlay().len() as f64;
        }
        let [at_patches, at_luxels] = hemicubes.map(|n| n / drawn);
        let costs = overlay.costs(entries as u64 * OVERLAY_ENTRY as u64);
        let [glass, shaders] = costs.map(|cost| Cost {
            cells: (cost.cells as f64 * (at_patches + at_luxels)) as u64,
            bytes: (cost.bytes as f64 * at_patches) as u64,
            seconds: cost.seconds * (at_patches + at_luxels),
            ..cost
        });
        Self { glass, curtains, shaders }
    }
}

/// Memory of light that so many passages carry between so many patches in so many styles.
pub(crate) fn curtain_cost(passages: usize, patches: usize, styles: usize) -> Cost {
    let of_light = if passages > 0 { patches * styles * size_of::<glam::Vec3>() } else { 0 };
    let bytes = passages * size_of::<crate::patch::Passage>() + of_light;
    Cost { bytes: bytes as u64, ..Cost::default() }
}
