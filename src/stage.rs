//! The stages of a map run: each calls one room, over all faces, and shows its progress.

use crate::Result;
use crate::bsp::BspxLump;
use crate::light::{self, DirectLight, Directions, Probe, StyleLight};
use crate::lightmap::{self, DebugSources, DebugView, FinishedFace};
use crate::patch::MapPatches;
use crate::progress::Progress;
use crate::radiosity::bounce::{self, Bounced};
use crate::radiosity::solve::Limits;
use crate::radiosity::transfers::Transfers;
use crate::scene::{Sample, Scene, luxels};
use crate::settings::Settings;
use rayon::prelude::*;
use std::borrow::Cow;

/// The points of every surface that take light.
pub(crate) struct Points {
    /// One a luxel.
    pub luxels: Vec<Vec<Sample>>,
    /// `extra` x `extra` a luxel; none when that is the same.
    fine: Option<Vec<Vec<Sample>>>,
}

impl Points {
    /// Where direct light is sampled.
    pub fn samples(&self) -> &[Vec<Sample>] {
        self.fine.as_ref().unwrap_or(&self.luxels)
    }
}

/// Places luxels and samples on every surface.
pub(crate) fn place(scene: &Scene, settings: &Settings, progress: &Progress) -> Points {
    let faces = scene.surfaces.len();
    let stage = progress.stage("luxels", 2 * faces);
    let place = |extra: u32| -> Vec<Vec<Sample>> {
        (0..faces)
            .into_par_iter()
            .map(|face| {
                stage.advance(1);
                luxels::place(scene, face, extra)
            })
            .collect()
    };
    let extra = settings.smoothing.extra;
    Points { luxels: place(1), fine: (extra > 1).then(|| place(extra)) }
}

/// Direct light at every sample.
pub(crate) fn direct(
    scene: &Scene,
    samples: &[Vec<Sample>],
    settings: &Settings,
    progress: &Progress,
) -> Vec<DirectLight> {
    let stage = progress.stage("direct light", samples.len());
    samples
        .par_iter()
        .enumerate()
        .map_init(
            || light::Blockers::new(scene),
            |blockers, (face, samples)| {
                let directions = if settings.outputs.directions() {
                    Directions::wanted()
                } else {
                    Directions::default()
                };
                let light = light::direct_from(scene, face, samples, directions, blockers);
                stage.advance(1);
                light
            },
        )
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
    if scene.world.bounce.most == Some(0) && scene.emitters.is_empty() {
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
    let (tracer, leaders) = (scene.bounce_tracer(), patches.leaders());
    let sharing = (leaders.as_slice(), settings.share);
    Transfers::shared(tracer, &patches.set, sharing, settings.hemicube, |n| stage.advance(n))
}

/// Final light of the patches in every style.
pub(crate) fn bounce(
    scene: &Scene,
    patches: &MapPatches,
    transfers: &Transfers,
    (points, direct): (&Points, &[DirectLight]),
    settings: &Settings,
    progress: &Progress,
) -> Bounced {
    if patches.set.patches.is_empty() {
        return Bounced::default();
    }
    let rules = &scene.world.bounce;
    let arriving: Vec<Cow<'_, [StyleLight]>> = direct
        .iter()
        .zip(points.samples())
        .zip(&scene.surfaces)
        .map(|((direct, samples), surface)| {
            let width = surface.luxels.as_ref().map_or(1, |g| g.width);
            let light = light::bounce_source(direct, samples, width, settings.smoothing.extra);
            bounce::ruled(light, rules)
        })
        .collect();
    let mut emission = patches.emission(&scene.emitters);
    bounce::rule_emission(&mut emission, rules);
    let stage = progress.stage("bounces", bounce::styles(&arriving, &emission).len());
    let limits = Limits { passes: rules.most, residual: settings.residual };
    bounce::bounce(patches, transfers, &arriving, &emission, limits, |n| stage.advance(n))
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
    let how = settings.gathering();
    let (maps, hemicubes) = lightmap::indirect(sources, samples, how, |n| stage.advance(n));
    Gathered { maps, hemicubes }
}

/// Where bounced light comes from, if that is wanted, added to `direct`.
pub(crate) fn directions(
    sources: lightmap::Sources<'_>,
    luxels: &[Vec<Sample>],
    gathered: &Gathered,
    direct: &mut [DirectLight],
    settings: &Settings,
) {
    let extra = settings.smoothing.extra;
    lightmap::add_bounced_directions(sources, luxels, &gathered.maps, extra, direct);
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

/// The lump of the light grid, if there is to be one.
pub(crate) fn light_grid(
    scene: &Scene,
    patches: &MapPatches,
    bounced: &Bounced,
    progress: &Progress,
) -> Result<Option<BspxLump>> {
    let Some(grid) = &scene.light_grid else { return Ok(None) };
    let stage = progress.stage("light grid", grid.place.len());
    let sources = lightmap::GridSources { scene, patches, light: &bounced.styles };
    lightmap::light_grid(sources, grid, |n| stage.advance(n)).map(Some)
}

/// Lightmaps that show something else than light.
pub(crate) fn debug(
    view: DebugView,
    sources: DebugSources<'_>,
    settings: &Settings,
) -> Vec<FinishedFace> {
    lightmap::debug_faces(view, sources, (settings.smoothing, settings.outputs.style_choice()))
}

/// All light of every face put together, as lightmaps.
pub(crate) fn finish(
    scene: &Scene,
    points: &Points,
    direct: Vec<DirectLight>,
    indirect: Vec<Vec<StyleLight>>,
    probes: &[Option<Probe>],
    settings: &Settings,
) -> Vec<FinishedFace> {
    let how = (settings.smoothing, settings.outputs.style_choice());
    lightmap::finish_faces(scene, points.samples(), direct, indirect, probes, how)
}
