//! The command line of `qrad`.

mod accuracy;
mod effects;
mod outputs;
mod values;

pub use accuracy::AccuracyArgs;
pub use effects::EffectArgs;
pub use outputs::{GridFormatArg, OutputArgs};
pub use values::{BounceCount, GatherArg, NearFieldArg, SurfaceLightsArg};

use crate::aim::Ladder;
use crate::cache::Cache;
use crate::lightmap::{DebugView, Gather, Smoothing};
use crate::memory::MemoryLimit;
use crate::radiosity::hemicube::HemicubeSize;
use crate::radiosity::near_pairs::NearLimits;
use crate::scene::ALL_BOUNCES;
use crate::settings::{Quality, Settings, SurfaceLights};
use crate::{Error, Result};
use clap::{ArgGroup, Parser};
use clap_complete::Shell;
use std::path::{Path, PathBuf};
use values::{bounce_count, key_value};

/// Least cells along the edge of a hemicube where lamps emit as areas.
const AREA_CELLS: u32 = 32;

/// Lights a Quake map with real radiosity: run it after qbsp and vis.
///
/// `qrad map.bsp` computes direct light as ericw-tools' light does, bounces it between the surfaces of
/// the map, and writes the lightmaps back into map.bsp (and map.lit when the light has colour).
/// `qrad --patches scene.txt` does the bouncing for a plain-text scene of quads.
#[derive(Debug, Parser)]
#[command(name = "qrad", version, max_term_width = 100, args_override_self = true)]
#[command(after_help = "The options of ericw-tools' light are accepted too; see docs/options.md.")]
#[command(group(ArgGroup::new("input").required(true).args(["map", "patches", "completions"])))]
pub struct Cli {
    /// The map to light, BSP29, BSP2 or 2PSB; `.bsp` may be left out
    pub map: Option<PathBuf>,

    /// Light a text scene of quads instead of a map; see docs/cornell-format.md
    #[arg(long, value_name = "SCENE.txt")]
    pub patches: Option<PathBuf>,

    /// Write here instead of in place [text scenes: NAME-lit.txt; `-` is standard output]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// 2 x 2 samples of direct light a luxel
    #[arg(long, help_heading = "Direct light", conflicts_with = "extra4")]
    pub extra: bool,

    /// 4 x 4 samples of direct light a luxel
    #[arg(long, help_heading = "Direct light")]
    pub extra4: bool,

    /// Trace every sample of --extra and --extra4, also where its neighbours agree
    #[arg(long, help_heading = "Direct light")]
    pub exact_extra: bool,

    /// Blur by N samples [without a number: 1 with --extra, 2 with --extra4, else 0]
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "auto")]
    #[arg(require_equals = true)]
    #[arg(help_heading = "Direct light")]
    pub soft: Option<String>,

    /// Most bounces of light; 0 is direct light only, `all` is until the residual is reached [default:
    /// worldspawn _bounce, or all]
    #[arg(long, value_name = "N", value_parser = bounce_count, help_heading = "Bounced light")]
    pub bounces: Option<BounceCount>,

    /// Share of the light that may be left when bouncing ends
    #[arg(long, value_name = "SHARE", default_value_t = 1e-5, help_heading = "Bounced light")]
    pub residual: f64,

    /// How much work goes into bounced light; the three options below change single parts of it
    #[arg(long, value_enum, default_value_t, help_heading = "Bounced light")]
    pub quality: Quality,

    /// Improve what one hemicube a patch gets wrong in a text scene: near, large and bright pairs
    #[arg(long, value_enum, default_value_t, requires = "patches", help_heading = "Bounced light")]
    pub near_field: NearFieldArg,

    /// Edge of a hemicube in cells, even: more is finer and slower [default: 16; area lights: 32; final: 64]
    #[arg(long, value_name = "CELLS", help_heading = "Bounced light")]
    pub hemicube: Option<u32>,

    /// Longest edge of a patch in luxels (one luxel is 16 units) [default: 2; draft: 4]
    #[arg(long, value_name = "LUXELS", help_heading = "Bounced light")]
    pub patch_size: Option<u32>,

    /// How bounced light gets from patches to luxels [default: interpolate; final: luxel]
    #[arg(long, value_enum, help_heading = "Bounced light")]
    pub gather: Option<GatherArg>,

    /// Keep form factors in a folder, so that lighting the map again after lights have changed skips them
    #[arg(long, value_name = "DIR", conflicts_with = "patches", help_heading = "Bounced light")]
    pub cache: Option<PathBuf>,

    /// Factor on how much light textures send back
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, help_heading = "Materials")]
    pub reflectance_scale: f32,

    /// Ignore the colour of textures: every surface sends back half the light
    #[arg(long, help_heading = "Materials")]
    pub grey: bool,

    /// Where worldspawn has no _bouncecolorscale, every surface sends back the same grey, as in light
    #[arg(long, conflicts_with = "grey", help_heading = "Materials")]
    pub compat_bounce: bool,

    /// WAD file with textures that the map does not contain; may be given more than once
    #[arg(long, value_name = "FILE.wad", help_heading = "Materials")]
    pub wad: Vec<PathBuf>,

    /// Folder to search for the WAD files that the map names; may be given more than once
    #[arg(long, value_name = "DIR", help_heading = "Materials")]
    pub path: Vec<PathBuf>,

    /// Texture lights: a .rad file, or light entities in an .ent file; may be given more than once
    #[arg(long, value_name = "FILE", help_heading = "Materials")]
    pub radlights: Vec<PathBuf>,

    /// Material file: what textures do to light; see docs/materials.md [default: MAP.materials.toml]
    #[arg(long, value_name = "FILE.toml", help_heading = "Materials")]
    pub materials: Option<PathBuf>,

    /// How `_surface` lights shine
    #[arg(long, value_enum, default_value_t, help_heading = "Materials")]
    pub surface_lights: SurfaceLightsArg,

    /// Set a worldspawn key instead of the map, such as _sunlight_penumbra=0; may be given more than once
    #[arg(long, value_name = "KEY=VALUE", value_parser = key_value, help_heading = "Materials")]
    pub set: Vec<(String, String)>,

    /// Which files and lumps are written
    #[command(flatten)]
    pub outputs: OutputArgs,

    /// Which effects are simulated
    #[command(flatten)]
    pub effects: EffectArgs,

    /// Write the lightmaps as pictures, one PNG a light style, and index.csv, into a folder
    #[arg(long, value_name = "DIR", help_heading = "Pictures")]
    pub dump_lightmaps: Option<PathBuf>,

    /// Show this in the lightmaps instead of light
    #[arg(long, value_enum, value_name = "VIEW", help_heading = "Pictures")]
    pub debug: Option<DebugView>,

    /// Write the map's faces to MAP.obj
    #[arg(long, help_heading = "Pictures")]
    pub exportobj: bool,

    /// Write MAP.obj with smoothed normals, and nothing else
    #[arg(long, help_heading = "Pictures")]
    pub phongdebug_obj: bool,

    /// Write the points that stand for surface lights to MAP-surflights.map
    #[arg(long, help_heading = "Pictures")]
    pub surflight_dump: bool,

    /// Draw the lit map
    #[arg(long, value_name = "OUT.png", help_heading = "Pictures")]
    pub preview: Option<PathBuf>,

    /// Camera of the preview: eye and angles, pitch down [default: the player's start]
    #[arg(
        long,
        value_name = "X,Y,Z,PITCH,YAW",
        allow_hyphen_values = true,
        requires = "preview",
        help_heading = "Pictures"
    )]
    pub camera: Option<String>,

    /// Size of the preview in pixels
    #[arg(
        long,
        value_name = "WIDTHxHEIGHT",
        default_value = "1024x768",
        requires = "preview",
        help_heading = "Pictures"
    )]
    pub preview_size: String,

    /// What is told of errors and times
    #[command(flatten)]
    pub accuracy: AccuracyArgs,

    /// Threads to use; the result does not depend on it [default: all cores]
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,

    /// Most memory to take, such as 2G: patches become larger where they would not fit [default: three
    /// quarters of what is free]
    #[arg(long, value_name = "SIZE", conflicts_with = "patches")]
    pub memory_limit: Option<String>,

    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,

    /// Print what is done in detail
    #[arg(short, long, conflicts_with = "quiet")]
    pub verbose: bool,

    /// Print a completion script for a shell
    #[arg(long, value_name = "SHELL")]
    pub completions: Option<Shell>,
}

impl Cli {
    /// The settings of a map run.
    ///
    /// # Errors
    /// When an option is out of range.
    pub fn settings(&self) -> Result<Settings> {
        let mut overrides: Vec<_> =
            self.set.iter().cloned().chain(self.outputs.grid_keys()).collect();
        if self.bounces == Some(BounceCount::All) {
            overrides.push(("bounce".into(), ALL_BOUNCES.into()));
        }
        // Lamps that emit as areas are small and bright: no luxel may miss one.
        let area = matches!(self.surface_lights, SurfaceLightsArg::Area);
        let least = if area { AREA_CELLS } else { 0 };
        let cells = self.hemicube.unwrap_or(self.quality.hemicube().max(least));
        Settings {
            hemicube: HemicubeSize::new(cells, cells)?,
            patch_size: self.patch_size.unwrap_or(self.quality.patch_size()),
            bounces: match self.bounces {
                Some(BounceCount::Most(n)) => Some(n),
                _ => None,
            },
            residual: self.residual,
            smoothing: self.smoothing()?,
            exact_extra: self.exact_extra,
            gather: match self.gather {
                None => self.quality.gather(),
                Some(GatherArg::Interpolate) => Gather::Interpolate,
                Some(GatherArg::Luxel) => Gather::Luxel,
            },
            gather_error: self.quality.gather_error(),
            share: self.quality.share(),
            reflectance_scale: self.reflectance_scale,
            grey: self.grey,
            compat_bounce: self.compat_bounce,
            surface_lights: match self.surface_lights {
                SurfaceLightsArg::Points => SurfaceLights::Points,
                SurfaceLightsArg::Area => SurfaceLights::Area,
            },
            overrides,
            debug: self.debug,
            outputs: self.outputs.outputs(),
            check: !self.accuracy.no_check,
            check_share: crate::check::SHARE,
            aim: self.accuracy.aim(),
            ladder: Ladder::default(),
            keep_partial: self.accuracy.keep_partial,
            switches: self.effects.switches()?,
            memory: match &self.memory_limit {
                Some(text) => MemoryLimit::parse(text)?,
                None => MemoryLimit::of_system(),
            },
            cache: self.cache.clone().map(Cache::new),
        }
        .switched()
        .checked()
    }

    /// Which pairs of patches of a text scene get more than a hemicube; `None` for none.
    pub fn near(&self) -> Option<NearLimits> {
        (self.near_field == NearFieldArg::On).then(|| self.quality.near())
    }

    /// Samples a luxel and blur.
    fn smoothing(&self) -> Result<Smoothing> {
        let (extra, auto) = match (self.extra, self.extra4) {
            (_, true) => (4, 2),
            (true, _) => (2, 1),
            _ => (1, 0),
        };
        let soft = match self.soft.as_deref() {
            None => 0,
            Some("auto") => auto,
            Some(text) => text.parse().map_err(|_| {
                Error::setting("--soft", format!("{text:?}: give a number of samples"))
            })?,
        };
        Ok(Smoothing { extra, soft })
    }

    /// Number of threads; 0 stands for one a core.
    ///
    /// # Errors
    /// When it is 0 or above 1024.
    pub fn threads(&self) -> Result<usize> {
        match self.threads {
            None => Ok(0),
            Some(n @ 1..=1024) => Ok(n),
            Some(n) => Err(Error::setting("--threads", format!("{n}: use 1 to 1024"))),
        }
    }

    /// The `--camera` numbers: eye x, y, z, pitch, yaw.
    ///
    /// # Errors
    /// When they are not five finite numbers.
    pub fn camera(&self) -> Result<Option<[f32; 5]>> {
        let Some(text) = &self.camera else { return Ok(None) };
        let numbers: Option<Vec<f32>> = text
            .split([',', ' '])
            .filter(|t| !t.is_empty())
            .map(|t| t.parse().ok().filter(|v: &f32| v.is_finite()))
            .collect();
        numbers.and_then(|n| n.try_into().ok()).map(Some).ok_or_else(|| {
            Error::setting("--camera", format!("{text:?}: give five numbers, x,y,z,pitch,yaw"))
        })
    }

    /// Width and height of the preview, from 1 to 8192.
    ///
    /// # Errors
    /// When the option is not two such numbers with an x between.
    pub fn preview_size(&self) -> Result<[u32; 2]> {
        self.preview_size
            .split_once('x')
            .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]))
            .filter(|size| size.iter().all(|n| (1..=8192).contains(n)))
            .ok_or_else(|| {
                let problem = format!("{:?}: give WIDTHxHEIGHT, each 1 to 8192", self.preview_size);
                Error::setting("--preview-size", problem)
            })
    }
}

/// `path`, or `path.bsp` if it names no file and that does.
pub fn map_path(path: &Path) -> PathBuf {
    let mut with = path.as_os_str().to_owned();
    with.push(".bsp");
    let with = PathBuf::from(with);
    if !path.exists() && with.exists() { with } else { path.to_path_buf() }
}
