//! The stages of a map run: each calls one room, over all faces, and shows its progress.

use crate::bsp::BspxLump;
use crate::cache::Key;
use crate::check::{self, Energy, Findings};
use crate::light::{self, DirectLight, Directions, InTime, Probe, StyleLight};
use crate::lightmap::{self, DebugSources, DebugView, FinishedFace};
use crate::patch::{Emission, Groups, MapPatches};
use crate::progress::{Deadline, Progress};
use crate::radiosity::bounce::{self, Bounced};
use crate::radiosity::solve::{self, Limits};
use crate::radiosity::transfers::{Sharing, Transfers};
use crate::scene::{Sample, Scene, Surface, luxels};
use crate::settings::Settings;
use crate::{Error, Result};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Longest edge of the largest patches in luxels.
const LARGEST_PATCH: u32 = 256;

/// Bytes that a style of light takes at a sample, while it is added up and finished.
const STYLE_BYTES: u64 = 24;

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
///
/// # Errors
/// When they would not fit into memory.
pub(crate) fn place(scene: &Scene, settings: &Settings, progress: &Progress) -> Result<Points> {
    let faces = scene.surfaces.len();
    let luxels: u64 = scene.surfaces.iter().flat_map(|s| &s.luxels).map(|g| g.len() as u64).sum();
    let fine = u64::from(settings.smoothing.extra).pow(2);
    let value = luxels * (1 + fine) * (size_of::<Sample>() as u64 + STYLE_BYTES);
    let limit = settings.memory.left();
    if value > limit {
        let what = format!("memory for the samples of {luxels} luxels, in bytes,");
        let advice = "take fewer samples (--extra, --extra4) or raise --memory-limit";
        return Err(Error::Limit { what, value, limit, advice });
    }
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
    Ok(Points { luxels: place(1), fine: (extra > 1).then(|| place(extra)) })
}

/// Direct light at every sample.
pub(crate) fn direct(
    scene: &Scene,
    samples: &[Vec<Sample>],
    settings: &Settings,
    progress: &Progress,
) -> Vec<DirectLight> {
    let stage = progress.stage("direct light", samples.len());
    let cell = if settings.exact_extra { 1 } else { settings.smoothing.extra };
    let candidates = Arc::new(light::Candidates::find(scene, samples, cell));
    samples
        .par_iter()
        .enumerate()
        .map_init(
            || light::Blockers::among(scene, Arc::clone(&candidates)),
            |blockers, (face, samples)| {
                let directions = if settings.outputs.directions() {
                    Directions::wanted()
                } else {
                    Directions::default()
                };
                let extra = settings.smoothing.extra;
                let light = if settings.exact_extra || extra == 1 {
                    light::direct_from(scene, face, samples, directions, blockers)
                } else {
                    light::direct_adaptive(scene, face, (samples, extra), directions, blockers)
                };
                stage.advance(1);
                light
            },
        )
        .collect()
}

/// The same until `deadline`, and how far that got.
pub(crate) fn direct_in_time(
    scene: &Scene,
    samples: &[Vec<Sample>],
    settings: &Settings,
    deadline: Deadline<'_>,
    progress: &Progress,
) -> InTime {
    let _stage = progress.stage("direct light", 1);
    let (extra, directions) = (settings.smoothing.extra, settings.outputs.directions());
    light::direct_in_time(light::Receivers { scene, samples, extra, directions }, deadline)
}

/// The patches; none when no light is to bounce. They are larger than the settings say where they, with the
/// form factors between them, would not fit into memory.
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
    let of_lights = scene.lights.iter().map(|l| l.style);
    let styles: BTreeSet<u16> = of_lights.chain(scene.emitters.iter().map(|e| e.style)).collect();
    let styles = styles.len().max(1);
    let mut size = settings.patch_size;
    loop {
        let patches = MapPatches::new(scene, samples, size);
        let (groups, small) = economies(&patches, settings);
        let sharing = Sharing { groups: &groups, share: settings.share, small: &small };
        let (tracer, cells) = (scene.bounce_tracer(), settings.hemicube);
        let of_light = solve::bytes_of_a_patch(styles) * patches.set.patches.len() as u64;
        let expected = of_light + Transfers::expected_bytes(tracer, &patches.set, sharing, cells);
        let left = settings.memory.left();
        if expected <= left || size >= LARGEST_PATCH {
            if size > settings.patch_size {
                log::warn!(
                    "patches of {size} luxels instead of {}, as form factors and the light of patches are \
                     to fit into the {} MiB that are left; raise --memory-limit for more accurate bounced light",
                    settings.patch_size,
                    left >> 20
                );
            }
            return patches;
        }
        size = (2 * size).min(LARGEST_PATCH);
    }
}

/// Which patches may share a row, and which are small enough for coarse hemicubes.
fn economies(patches: &MapPatches, settings: &Settings) -> (Groups, Vec<bool>) {
    let small = if settings.coarse_where_small() {
        patches.small()
    } else {
        vec![false; patches.set.patches.len()]
    };
    (patches.groups(), small)
}

/// Form factors between the patches, drawn or as they were kept; `None` if they are not there by `end`.
pub(crate) fn transfers(
    scene: &Scene,
    patches: &MapPatches,
    settings: &Settings,
    end: Deadline<'_>,
    progress: &Progress,
) -> Option<Transfers> {
    let count = patches.set.patches.len();
    let stage = progress.stage("form factors", count);
    let (groups, small) = economies(patches, settings);
    let sharing = Sharing { groups: &groups, share: settings.share, small: &small };
    let (tracer, size) = (scene.bounce_tracer(), settings.hemicube);
    // Files have no room for what an overlay adds.
    let cache = settings.cache.as_ref().filter(|_| count > 0 && patches.set.overlay.is_none());
    let kept = cache.map(|cache| (cache, Key::new(tracer, &patches.set, sharing, size)));
    if let Some(transfers) = kept.as_ref().and_then(|(cache, key)| cache.load(*key, count)) {
        return Some(transfers);
    }
    let goes_on = |n| {
        stage.advance(n);
        !end.passed()
    };
    let transfers = Transfers::shared_while(tracer, &patches.set, sharing, size, goes_on)?;
    if let Some((cache, key)) = kept {
        cache.keep(key, &transfers);
    }
    Some(transfers)
}

/// Light of the patches before any bounce.
#[derive(Default)]
pub(crate) struct Shining<'a> {
    /// Direct light at the luxels of each surface, as it bounces.
    arriving: Vec<Cow<'a, [StyleLight]>>,
    /// What patches give off.
    emission: Vec<Emission>,
}

/// What is to bounce.
pub(crate) fn shining<'a>(
    scene: &Scene,
    patches: &MapPatches,
    (points, direct): (&Points, &'a [DirectLight]),
    settings: &Settings,
) -> Shining<'a> {
    if patches.set.patches.is_empty() {
        return Shining::default();
    }
    let mut emission = patches.emission(&scene.emitters);
    bounce::rule_emission(&mut emission, &scene.world.bounce);
    Shining { arriving: arriving(scene, points, direct, settings), emission }
}

/// Direct light at the luxels of each surface, as it bounces.
fn arriving<'a>(
    scene: &Scene,
    points: &Points,
    direct: &'a [DirectLight],
    settings: &Settings,
) -> Vec<Cow<'a, [StyleLight]>> {
    let samples = points.samples().iter().zip(&scene.surfaces);
    let of = |(direct, (samples, surface)): (&'a DirectLight, (&Vec<Sample>, &Surface))| {
        let width = surface.luxels.as_ref().map_or(1, |g| g.width);
        let light = light::bounce_source(direct, samples, width, settings.smoothing.extra);
        bounce::ruled(light, &scene.world.bounce)
    };
    direct.iter().zip(samples).map(of).collect()
}

/// Bounced light without patches, the same everywhere.
pub(crate) fn ambient(
    scene: &Scene,
    (points, direct): (&Points, &[DirectLight]),
    settings: &Settings,
) -> Gathered {
    let arriving = arriving(scene, points, direct, settings);
    Gathered { maps: lightmap::ambient(scene, &points.luxels, &arriving), hemicubes: 0 }
}

/// Final light of the patches in every style.
pub(crate) fn bounce(
    scene: &Scene,
    patches: &MapPatches,
    transfers: &Transfers,
    Shining { arriving, emission }: &Shining<'_>,
    settings: &Settings,
    progress: &Progress,
) -> Bounced {
    if patches.set.patches.is_empty() {
        return Bounced::default();
    }
    let stage = progress.stage("bounces", bounce::styles(arriving, emission).len());
    let limits = Limits { passes: scene.world.bounce.most, residual: settings.residual };
    bounce::bounce(scene, patches, transfers, arriving, emission, limits, |n| stage.advance(n))
}

/// Indirect light at luxels.
pub(crate) struct Gathered {
    /// Maps of each surface.
    pub maps: Vec<Vec<StyleLight>>,
    /// Hemicubes drawn.
    pub hemicubes: u64,
}

/// Indirect light at every luxel, of hemicubes at luxels until `end`.
pub(crate) fn gather(
    sources: lightmap::Sources<'_>,
    samples: &[Vec<Sample>],
    settings: &Settings,
    end: Deadline<'_>,
    progress: &Progress,
) -> Gathered {
    let stage = progress.stage("gather", samples.iter().map(Vec::len).sum());
    let how = settings.gathering();
    let advance = |n| stage.advance(n);
    let time = || !end.passed();
    let (maps, hemicubes) = lightmap::indirect_while(sources, samples, how, time, advance);
    Gathered { maps, hemicubes }
}

/// How far off the bounced light is, if that is wanted and there is any.
pub(crate) fn check(
    sources: lightmap::Sources<'_>,
    shining: &Shining<'_>,
    luxels: &[Vec<Sample>],
    gathered: &Gathered,
    settings: &Settings,
    progress: &Progress,
) -> (Option<Findings>, Option<Energy>) {
    if !settings.check || sources.light.is_empty() {
        return (None, None);
    }
    let end = progress.deadline(check::end(progress.elapsed(), settings.check_share));
    let _stage = progress.stage("check", 1);
    let run = check::Run {
        sources,
        samples: luxels,
        arriving: &shining.arriving,
        emission: &shining.emission,
        found: &gathered.maps,
        bounces: sources.scene.world.bounce.most,
        hemicube: settings.hemicube,
    };
    check::check_luxels(&run, end)
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
