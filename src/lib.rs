//! `qrad` lights Quake maps and plain scenes of quads with hemicube radiosity.
//!
//! Two functions are the whole of it: [`light_bsp`] for maps and [`light_patches`] for text scenes.
//! Both read as the algorithm; each line is a stage that lives in a room of its own.

pub mod aim;
pub mod bsp;
pub mod cache;
pub mod check;
pub mod cli;
pub mod engine;
pub mod error;
pub mod legacy_args;
pub mod light;
pub mod lightmap;
mod map_stages;
pub mod memory;
pub mod output;
pub mod outputs;
mod overlay_estimate;
pub mod patch;
pub mod photometry;
pub mod plan_costs;
pub mod plot;
pub mod progress;
pub mod radiosity;
pub mod render;
pub mod report;
pub mod run_report;
pub mod scene;
pub mod settings;
mod stage;
mod store;
pub mod sweep;
pub mod text_plan;

pub use error::{Error, Result};
pub use scene::effects::plan;
pub use store::Files;

use bsp::{Bsp, MipTex};
use check::{Energy, Findings};
use lightmap::FinishedFace;
use map_stages::{BouncedLight, DirectLit};
use patch::{MAX_REFLECTANCE, TextPatches, TextScene};
use progress::Progress;
use radiosity::hemicube::HemicubeSize;
use radiosity::importance::Importance;
use radiosity::near_pairs::{NearLimits, NearPairs};
use radiosity::overlay_pairs;
use radiosity::solve::{Limits, Solution, Sources, solve_with};
use radiosity::transfers::Transfers;
use radiosity::trapped;
use radiosity::visibility::Occluders;
use report::Counts;
use scene::{Scene, Sidecar};
use settings::{Quality, Settings};

/// Share of a text scene's light that may be left unsent when it counts as settled.
pub(crate) const TEXT_RESIDUAL: f64 = 1e-9;

/// Passes that tell which patches are bright enough to matter.
const ROUGH_PASSES: u32 = 16;

/// Lights a text scene: hemicubes of the size it names, closed forms where those err, then passes of
/// gathering until nothing is left to send or its number of passes is used up. The solution holds the
/// final exitance of each patch in file order, and then of the backs of patches with two sides.
///
/// # Errors
/// When the scene's hemicube size is out of range.
pub fn light_patches(scene: &TextScene, progress: &Progress) -> Result<(Transfers, Solution)> {
    light_patches_with(scene, Some(Quality::default().near()), progress)
}

/// As [`light_patches`], with closed forms within the limits given, or without any.
///
/// # Errors
/// When the scene's hemicube size is out of range.
pub fn light_patches_with(
    scene: &TextScene,
    near: Option<NearLimits>,
    progress: &Progress,
) -> Result<(Transfers, Solution)> {
    let size = HemicubeSize::new(scene.hemicube[0], scene.hemicube[1])?;
    let patches = TextPatches::new(scene);
    let mut transfers = {
        let stage = progress.stage("form factors", patches.set.patches.len());
        Transfers::compute(&patches.tracer, &patches.set, size, |n| stage.advance(n))
    };
    let (mut reflectance, mut passages) = (patches.reflectance(), patches.set.passages.clone());
    let limit = MAX_REFLECTANCE as f32;
    let changed = trapped::let_out(&transfers, &mut reflectance, &mut passages, limit);
    if changed > 0 {
        log::warn!(
            "nothing absorbs the light of {changed} patches, which would never settle; their \
             reflectances are lowered to {MAX_REFLECTANCE}"
        );
    }
    let sources = Sources { emission: &patches.emission, direct: &[] };
    if let Some(near) = near {
        let stage = progress.stage("near pairs", patches.set.patches.len());
        let rough = Limits { passes: Some(scene.passes.min(ROUGH_PASSES)), residual: 1e-2 };
        let set = &patches.set;
        let first = solve_with(&transfers, &patches.reflectance(), &set.passages, sources, rough);
        let importance = Importance::new(&patches.set, &patches.emission, &first.exitance);
        let occluders = Occluders::with_sheets(&patches.tracer, &patches.sheets);
        let near = NearPairs::new(&patches.set, occluders, importance, near, size.cells());
        transfers.improve(&patches.tracer, &patches.set, size, &near, |n| stage.advance(n));
        overlay_pairs::improve(&mut transfers, &patches.set, &near);
    }
    let limits = Limits { passes: Some(scene.passes), residual: TEXT_RESIDUAL };
    let solution = {
        let _stage = progress.stage("passes", scene.passes as usize);
        solve_with(&transfers, &reflectance, &passages, sources, limits)
    };
    Ok((transfers, solution))
}

/// What a map run makes besides the lightmaps in the BSP.
pub struct MapLight {
    /// The map as light saw it.
    pub scene: Scene,
    /// The lightmaps of each face.
    pub faces: Vec<FinishedFace>,
    /// Three levels for each byte of the lighting lump, when the light has colour.
    pub rgb: Option<Vec<u8>>,
    /// What stands beside the map.
    pub files: Files,
    /// What the run counted.
    pub counts: Counts,
    /// How far off its bounced light is, and where that light goes, if that was checked.
    pub checked: (Option<Findings>, Option<Energy>),
    /// How the work was chosen, one sentence each, if the settings left that open.
    pub choices: Vec<String>,
}

/// Lights a map: replaces the lighting of `bsp`, unless only a `.lit` file for it is asked for.
/// `sidecar` is what qbsp wrote beside it, `textures` are those that the map may lack.
///
/// # Errors
/// When the entity text is damaged or something is too large for the format.
pub fn light_bsp(
    bsp: &mut Bsp,
    sidecar: Sidecar<'_>,
    textures: Vec<MipTex>,
    settings: &Settings,
    progress: &Progress,
) -> Result<MapLight> {
    light_bsp_in_steps(bsp, sidecar, textures, settings, progress, &mut |_, _| {})
}

/// As [`light_bsp`]; `keep` gets the map and its files each time that they are whole, before the light in
/// them gets better.
///
/// # Errors
/// As [`light_bsp`].
pub fn light_bsp_in_steps(
    bsp: &mut Bsp,
    sidecar: Sidecar<'_>,
    textures: Vec<MipTex>,
    settings: &Settings,
    progress: &Progress,
    keep: &mut dyn FnMut(&Bsp, &Files),
) -> Result<MapLight> {
    let unlit = bsp.clone();
    let direct = DirectLit::new(bsp, sidecar, textures, settings, progress)?;
    let whole = |bsp: &mut Bsp, light: &BouncedLight| {
        let faces = direct.finish(light, settings, progress);
        let stored = direct.store(bsp, &unlit, (&faces, light), settings, progress)?;
        Ok::<_, Error>((faces, stored))
    };
    let (bounced, chosen) = aim::bounced(&direct, settings, progress, &mut |light| {
        let mut bsp = bsp.clone();
        if let Ok((_, (_, files))) = whole(&mut bsp, light) {
            keep(&bsp, &files);
        }
    });
    let (faces, (rgb, files)) = whole(bsp, &bounced)?;
    let BouncedLight { counts, checked, .. } = bounced;
    let choices = chosen.said;
    Ok(MapLight { scene: direct.scene, faces, rgb, files, counts, checked, choices })
}
