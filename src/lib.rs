//! `qrad` lights Quake maps and plain scenes of quads with hemicube radiosity.
//!
//! Two functions are the whole of it: [`light_bsp`] for maps and [`light_patches`] for text scenes.
//! Both read as the algorithm; each line is a stage that lives in a room of its own.

pub mod bsp;
pub mod cli;
pub mod engine;
pub mod error;
pub mod legacy_args;
pub mod light;
pub mod lightmap;
pub mod output;
pub mod outputs;
pub mod patch;
pub mod photometry;
pub mod progress;
pub mod radiosity;
pub mod render;
pub mod report;
pub mod scene;
pub mod settings;
mod stage;
mod store;

pub use error::{Error, Result};

use bsp::{Bsp, MipTex};
use lightmap::FinishedFace;
use outputs::Scope;
use patch::{MAX_REFLECTANCE, TextPatches, TextScene};
use progress::Progress;
use radiosity::hemicube::HemicubeSize;
use radiosity::solve::{Limits, Solution, Sources, solve};
use radiosity::transfers::Transfers;
use radiosity::trapped;
use report::Counts;
use scene::{Scene, Sidecar};
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
    let mut reflectance = patches.reflectance();
    let changed = trapped::let_out(&transfers, &mut reflectance, MAX_REFLECTANCE as f32);
    if changed > 0 {
        log::warn!(
            "nothing absorbs the light of {changed} patches, which would never settle; their \
             reflectances are lowered to {MAX_REFLECTANCE}"
        );
    }
    let sources = Sources { emission: &patches.emission, direct: &[] };
    let limits = Limits { passes: Some(scene.passes), residual: TEXT_RESIDUAL };
    let solution = {
        let _stage = progress.stage("passes", scene.passes as usize);
        solve(&transfers, &reflectance, sources, limits)
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
    /// Bytes of the `.lit` file, if there is to be one.
    pub lit: Option<Vec<u8>>,
    /// What the run counted.
    pub counts: Counts,
}

/// Lights a map: replaces the lighting of `bsp`, unless only a `.lit` file is asked for. `sidecar` is what qbsp wrote beside it, `textures`
/// are those that the map may lack.
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
    let outputs = &settings.outputs;
    let unchanged = (outputs.scope == Scope::LitOnly).then(|| bsp.clone());
    bsp.clear_lighting();
    bsp.rewrite_entities()?;
    let scene = Scene::build(bsp, sidecar, &settings.scene(textures))?;
    let points = stage::place(&scene, settings, progress);
    let direct = stage::direct(&scene, points.samples(), progress);
    let patches = stage::patches(&scene, &points.luxels, settings, progress);
    let transfers = stage::transfers(&scene, &patches, settings, progress);
    let bounced =
        stage::bounce(&scene, &patches, &transfers, (&points, &direct), settings, progress);
    let sources = lightmap::Sources {
        scene: &scene,
        patches: &patches,
        transfers: &transfers,
        light: &bounced.styles,
    };
    let indirect = stage::gather(sources, &points.luxels, settings, progress);
    let counts = Counts::new(&scene, &direct, &patches, &transfers, &bounced, &indirect);
    let probes = stage::probes(&scene, &patches, points.samples(), &bounced, settings);
    let faces = stage::finish(&scene, &points, direct, indirect.maps, &probes, settings);
    if let Some(unchanged) = unchanged {
        *bsp = unchanged;
        let store::LitOnly { rgb, file } = store::lit_only(bsp, &scene, &faces, outputs)?;
        return Ok(MapLight { scene, faces, rgb: Some(rgb), lit: Some(file), counts });
    }
    let vanilla = lightmap::vanilla_copies(&scene, &faces, outputs.vanilla);
    let packed = lightmap::pack(&faces, &vanilla)?;
    let lit = store::store(bsp, &packed, &scene, outputs);
    let rgb = packed.coloured.then_some(packed.rgb);
    Ok(MapLight { scene, faces, rgb, lit, counts })
}
