//! The stages of a map run: each calls one room, over all faces, and shows its progress.

use crate::light::{self, DirectLight, Probe, StyleLight};
use crate::lightmap;
use crate::patch::MapPatches;
use crate::progress::Progress;
use crate::radiosity::bounce::{self, Bounced};
use crate::radiosity::solve::Limits;
use crate::radiosity::transfers::Transfers;
use crate::scene::{Sample, Scene, luxels};
use crate::settings::Settings;
use rayon::prelude::*;

/// The luxels of every surface.
pub(crate) fn place_luxels(scene: &Scene, progress: &Progress) -> Vec<Vec<Sample>> {
    let faces = scene.surfaces.len();
    let stage = progress.stage("luxels", faces);
    (0..faces)
        .into_par_iter()
        .map(|face| {
            let samples = luxels::place(scene, face, 1);
            stage.advance(1);
            samples
        })
        .collect()
}

/// Direct light at every luxel.
pub(crate) fn direct(
    scene: &Scene,
    samples: &[Vec<Sample>],
    progress: &Progress,
) -> Vec<DirectLight> {
    let stage = progress.stage("direct light", samples.len());
    samples
        .par_iter()
        .enumerate()
        .map(|(face, samples)| {
            let light = light::direct(scene, face, samples);
            stage.advance(1);
            light
        })
        .collect()
}

/// The patches; none when no light is to bounce.
pub(crate) fn patches(
    scene: &Scene,
    samples: &[Vec<Sample>],
    settings: &Settings,
    progress: &Progress,
) -> MapPatches {
    let _stage = progress.stage("patches", samples.len());
    if settings.bounces == Some(0) && scene.emitters.is_empty() {
        return MapPatches::default();
    }
    MapPatches::new(scene, samples, settings.patch_size)
}

/// Form factors between the patches.
pub(crate) fn transfers(
    scene: &Scene,
    patches: &MapPatches,
    settings: &Settings,
    progress: &Progress,
) -> Transfers {
    let stage = progress.stage("form factors", patches.set.patches.len());
    Transfers::compute(&scene.tracer, &patches.set, settings.hemicube, |n| stage.advance(n))
}

/// Final light of the patches in every style.
pub(crate) fn bounce(
    scene: &Scene,
    patches: &MapPatches,
    transfers: &Transfers,
    direct: &[DirectLight],
    settings: &Settings,
    progress: &Progress,
) -> Bounced {
    if patches.set.patches.is_empty() {
        return Bounced::default();
    }
    let emission = patches.emission(&scene.emitters);
    let stage = progress.stage("bounces", bounce::styles(direct, &emission).len());
    let limits = Limits { passes: settings.bounces, residual: settings.residual };
    bounce::bounce(patches, transfers, direct, &emission, limits, |n| stage.advance(n))
}

/// Indirect light at luxels.
pub(crate) struct Gathered {
    /// Maps of each surface.
    pub maps: Vec<Vec<StyleLight>>,
    /// Hemicubes drawn.
    pub hemicubes: u64,
}

/// Indirect light at every luxel.
pub(crate) fn gather(
    sources: lightmap::Sources<'_>,
    samples: &[Vec<Sample>],
    settings: &Settings,
    progress: &Progress,
) -> Gathered {
    let stage = progress.stage("gather", samples.iter().map(Vec::len).sum());
    let how = (settings.gather, settings.hemicube);
    let (maps, hemicubes) = lightmap::indirect(sources, samples, how, |n| stage.advance(n));
    Gathered { maps, hemicubes }
}

/// Light in the middle of brush models, for automatic minimum light.
pub(crate) fn probes(
    scene: &Scene,
    patches: &MapPatches,
    samples: &[Vec<Sample>],
    bounced: &Bounced,
    settings: &Settings,
) -> Vec<Option<Probe>> {
    lightmap::probes(scene, patches, samples, &bounced.styles, settings.hemicube)
}
