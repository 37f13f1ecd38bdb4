//! Options that say which files and lumps are written.

use crate::engine::Engine;
use crate::outputs::{DirectionFile, LitFile, Outputs, Scope};
use crate::scene::{LightGrid, LuxelSettings};
use clap::{Args, ValueEnum};

/// Spelling of [`Outputs`].
#[derive(Clone, Debug, Default, Args)]
pub struct OutputArgs {
    /// Write what an engine reads; options below add to it. docs/outputs.md has the table
    #[arg(long, value_enum, help_heading = "Outputs")]
    pub engine: Option<Engine>,

    /// Write a .lit file even if the light has no colour
    #[arg(long, help_heading = "Outputs")]
    pub lit: bool,

    /// Write the .lit file in HDR
    #[arg(long, conflicts_with = "lit", help_heading = "Outputs")]
    pub hdr: bool,

    /// Write a .lit file of version 2 with all that describes its lightmaps, and leave the map as it is
    #[arg(long, conflicts_with_all = ["hdr", "world_units_per_luxel", "litonly", "onlyents", "preview"])]
    #[arg(help_heading = "Outputs")]
    pub lit2: bool,

    /// Write where light comes from into a .lux file, for normal maps (a .dlit file for DarkPlaces)
    #[arg(long, help_heading = "Outputs")]
    pub lux: bool,

    /// Put the colours into the map (RGBLIGHTING), instead of a .lit file
    #[arg(long, help_heading = "Outputs")]
    pub bspxlit: bool,

    /// Put HDR colours into the map (LIGHTING_E5BGR9)
    #[arg(long, help_heading = "Outputs")]
    pub bspxhdr: bool,

    /// Put where light comes from into the map (LIGHTINGDIR)
    #[arg(long, help_heading = "Outputs")]
    pub bspxlux: bool,

    /// --bspxlit and --bspxlux
    #[arg(long, help_heading = "Outputs")]
    pub bspx: bool,

    /// --bspx and --novanilla
    #[arg(long, conflicts_with = "preview", help_heading = "Outputs")]
    pub bspxonly: bool,

    /// Put normals at the corners of faces into the map (FACENORMALS), for smooth light that engines compute
    #[arg(long, help_heading = "Outputs")]
    pub wrnormals: bool,

    /// Leave out what the original engine reads where other lumps hold the light
    #[arg(long, conflicts_with = "preview", help_heading = "Outputs")]
    pub novanilla: bool,

    /// Most light styles of a face, 1 to 16; above 4 is for engines that read LMSTYLE
    #[arg(long, value_name = "N", default_value_t = 4, help_heading = "Outputs")]
    pub facestyles: u32,

    /// Luxels of 2^N texels on every face, for engines that read LMSHIFT [default: what the map says]
    #[arg(long, value_name = "N", help_heading = "Outputs")]
    pub lmshift: Option<u8>,

    /// Luxels of U world units that do not follow textures, for engines that read DECOUPLED_LM
    #[arg(long, value_name = "U", conflicts_with = "lmshift", help_heading = "Outputs")]
    pub world_units_per_luxel: Option<f32>,

    /// Write a light grid: light at points in the air, for what moves there
    #[arg(long, help_heading = "Outputs")]
    pub lightgrid: bool,

    /// World units between its points: one number, or three for x, y and z [default: 32]
    #[arg(long, value_name = "X,Y,Z", value_parser = grid_step, help_heading = "Outputs")]
    pub lightgrid_dist: Option<String>,

    /// One colour a point (LIGHTGRID_OCTREE), or one for each of six directions (LIGHTGRIDS)
    #[arg(long, value_enum, help_heading = "Outputs")]
    pub lightgrid_format: Option<GridFormatArg>,

    /// Write the light grid as asked for even if it has more than 2 million points
    #[arg(long, help_heading = "Outputs")]
    pub lightgrid_force: bool,

    /// Write only the .lit file, for the lightmaps that the map has
    #[arg(long, conflicts_with_all = ["lmshift", "world_units_per_luxel"], help_heading = "Outputs")]
    pub litonly: bool,

    /// Write only the entities: the styles of switchable lights and the like; lighting stays
    #[arg(long, conflicts_with_all = ["litonly", "preview", "dump_lightmaps"], help_heading = "Outputs")]
    pub onlyents: bool,
}

impl OutputArgs {
    /// The options of the light grid as worldspawn keys, which is what they are in a map too.
    pub(super) fn grid_keys(&self) -> impl Iterator<Item = (String, String)> {
        let flag = |on: bool| on.then(|| "1".to_owned());
        let format = self.lightgrid_format.map(|format| format!("{format:?}"));
        [
            ("lightgrid", flag(self.lightgrid)),
            ("lightgrid_force", flag(self.lightgrid_force)),
            ("lightgrid_dist", self.lightgrid_dist.clone()),
            ("lightgrid_format", format),
        ]
        .into_iter()
        .filter_map(|(key, value)| Some((key.to_owned(), value?)))
    }

    /// The outputs that the options ask for, not checked yet.
    pub(super) fn outputs(&self) -> Outputs {
        let base = self.engine.map_or_else(Outputs::default, Engine::outputs);
        let bspx = self.bspx || self.bspxonly;
        Outputs {
            lit: match (self.lit, self.hdr, self.lit2) {
                (_, _, true) => LitFile::Version2,
                (_, true, _) => LitFile::Hdr,
                (true, ..) => LitFile::Always,
                _ => base.lit,
            },
            lux: match self.engine {
                _ if !self.lux => DirectionFile::No,
                Some(Engine::Darkplaces) => DirectionFile::Dlit,
                _ => DirectionFile::Lux,
            },
            bspx_lit: base.bspx_lit || self.bspxlit || bspx,
            bspx_hdr: base.bspx_hdr || self.bspxhdr,
            bspx_lux: self.bspxlux || bspx,
            face_normals: self.wrnormals,
            vanilla: base.vanilla && !(self.novanilla || self.bspxonly),
            face_styles: self.facestyles,
            luxels: LuxelSettings { shift: self.lmshift, world_units: self.world_units_per_luxel },
            scope: match (self.litonly, self.onlyents) {
                (_, true) => Scope::EntitiesOnly,
                (true, _) => Scope::LitOnly,
                _ => Scope::All,
            },
        }
    }
}

/// Spelling of [`GridFormat`](crate::scene::GridFormat): names of the values of the key.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum GridFormatArg {
    /// One colour a point
    Octree,
    /// Six colours a point
    Lightgrids,
}

/// A step of the light grid, as the key has it.
fn grid_step(text: &str) -> std::result::Result<String, String> {
    let value = text.replace(',', " ");
    let usable = LightGrid::parse_step(&value).is_some();
    usable.then_some(value).ok_or_else(|| "give one number or three, each 1 to 65536".into())
}
