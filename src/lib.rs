//! `qrad` lights Quake maps and plain scenes of quads with hemicube radiosity.
//!
//! Two functions are the whole of it: [`light_bsp`] for maps and [`light_patches`] for text scenes.
//! Both read as the algorithm; each line is a stage that lives in a room of its own.

pub mod bsp;
pub mod error;
pub mod light;
pub mod lightmap;
pub mod output;
pub mod patch;
pub mod photometry;
pub mod progress;
pub mod radiosity;
pub mod render;
pub mod report;
pub mod scene;
pub mod settings;

pub use error::{Error, Result};

use bsp::Bsp;
use patch::{MapPatches, TextPatches, TextScene};
use progress::Progress;
use radiosity::hemicube::HemicubeSize;
use radiosity::solve::{Limits, Solution, Sources, solve};
use radiosity::transfers::Transfers;
use settings::Settings;

/// Share of a text scene's light that may be left unsent when it counts as settled.
const TEXT_RESIDUAL: f64 = 1e-9;

/// Lights a text scene: hemicubes of the size it names, then passes of gathering until nothing is
/// left to send or its number of passes is used up. The solution holds the final exitance of each
/// patch in file order.
///
/// # Errors
/// When the scene's hemicube size is out of range.
pub fn light_patches(scene: &TextScene, progress: &Progress) -> Result<(Transfers, Solution)> {
    let size = HemicubeSize::new(scene.hemicube[0], scene.hemicube[1])?;
    let patches = TextPatches::new(scene);
    let transfers = {
        let stage = progress.stage("form factors", patches.set.patches.len());
        Transfers::compute(&patches.tracer, &patches.set, size, |n| stage.advance(n))
    };
    let sources = Sources { emission: &patches.emission, direct: &[] };
    let limits = Limits { passes: Some(scene.passes), residual: TEXT_RESIDUAL };
    let solution = {
        let _stage = progress.stage("passes", scene.passes as usize);
        solve(&transfers, &patches.reflectance(), sources, limits)
    };
    Ok((transfers, solution))
}
