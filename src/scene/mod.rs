//! What light needs of a map: surfaces with materials, the ray tracer, the lights and the luxels.

mod barriers;
mod bounce_keys;
mod build;
mod corner_frames;
mod dirt;
pub mod effects;
mod emission;
mod entity_lights;
pub(crate) mod exact;
pub mod export;
mod extremes;
mod face_reader;
mod filter;
mod first_hit;
mod hull;
mod keys;
mod light_grid;
mod light_list;
mod light_rays;
pub mod lights;
mod luxel_grid;
mod luxel_size;
pub mod luxels;
pub mod material_file;
mod materials;
mod minlight;
mod models;
mod narrow;
mod neighbours;
mod obstacles;
mod overrides;
mod packet;
mod pane;
mod phong;
mod pieces;
mod projection;
mod rad;
mod radiosity_lights;
pub(crate) mod random;
mod shading;
mod shadow;
mod shaft;
mod shape;
mod sidecar;
mod sky_rays;
mod solid;
mod suns;
mod surface;
mod surface_lights;
mod texels;
mod tie;
mod tracer;
mod umbra;
mod unknown_names;
mod visibility;
mod walls;
mod wander;
mod wide_tree;
mod winding;
mod world;

pub use barriers::Barriers;
pub(crate) use bounce_keys::ALL_BOUNCES;
pub use bounce_keys::BounceSettings;
pub use build::SceneSettings;
pub use dirt::{DirtKeys, DirtSettings};
pub use filter::Filters;
pub use light_grid::{GridFormat, LightGrid};
pub use light_rays::{Arrival, LightRays};
pub use lights::Light;
pub use luxel_size::{LuxelSettings, LuxelSize};
pub use luxels::Sample;
pub use minlight::{Glow, Minlight};
pub use models::{AutoMinlight, Model, ShadowClass};
pub use pane::Pane;
pub use pieces::{Piece, Pieces};
pub use projection::Projection;
pub use radiosity_lights::{EmissiveQuality, RadiosityLight, SurflightSettings};
pub use shading::Shading;
pub use shadow::ShadowRays;
pub(crate) use shaft::Floor;
pub use sidecar::Sidecar;
pub use sky_rays::Sky;
pub use solid::Solid;
pub use suns::Sun;
pub use surface::{LuxelGrid, Role, Surface};
pub use surface_lights::Emitter;
pub use tracer::{Hit, Node, Polygon, Tracer};
pub(crate) use umbra::{Bounds, Umbra};
pub use visibility::{Reach, Visibility};
pub(crate) use walls::Hidden;
pub use world::{WorldSettings, style_range};

use std::sync::Arc;

/// A map made ready for light. Nothing in it changes while the map is lit, so faces can be lit in
/// parallel from one shared scene.
pub struct Scene {
    /// One surface a BSP face, by the same index.
    pub surfaces: Vec<Surface>,
    /// Brush models, by the same index as in the BSP.
    pub models: Vec<Model>,
    /// The lights that shine, copies included, in the order in which they are added up.
    pub lights: Vec<Light>,
    /// Lights that keep the places they see from being darker than themselves.
    pub local_minlights: Vec<Light>,
    /// The surfaces that emit light from points over them.
    pub radiosity_lights: Vec<RadiosityLight>,
    /// Suns and the suns that sky domes are made of, in the order in which they are added up.
    pub suns: Vec<Sun>,
    /// The surfaces that emit light as areas.
    pub emitters: Vec<Emitter>,
    /// Luxels follow the faces and not their textures.
    pub decoupled: bool,
    /// The points of the light grid, if one is asked for.
    pub light_grid: Option<LightGrid>,
    /// What worldspawn sets for the whole map.
    pub world: WorldSettings,
    /// The surfaces that block all light.
    pub tracer: Tracer,
    /// The sky among its polygons.
    pub sky: Sky,
    /// Index in `surfaces` of each polygon of `tracer`.
    pub tracer_surface: Vec<u32>,
    /// What blocks some light, or changes it.
    pub filters: Filters,
    /// What the lights can reach.
    pub visibility: Visibility,
    /// Solid space of the brush models.
    pub solid: Solid,
    /// What is odd about the map, one sentence each.
    pub warnings: Vec<String>,
    /// Lower-case texture names of the surfaces; empty where there is none.
    pub(crate) names: Vec<String>,
    /// By surface; empty if none varies.
    shadings: Vec<Option<Arc<Shading>>>,
    obstacles: Option<obstacles::Obstacles>,
    shapes: Vec<shape::Shape>,
    neighbours: neighbours::Neighbours,
    smoothing: phong::Smoothing,
    luxel_maps: Vec<Option<shape::LuxelMap>>,
}

impl Scene {
    /// Smoothed unit normals at the corners of a surface; empty where it is flat.
    pub fn corner_normals(&self, surface: usize) -> &[glam::Vec3] {
        self.smoothing.corner_normals(surface)
    }

    /// Bytes of smoothed normals.
    pub fn smoothed_bytes(&self) -> u64 {
        let all = (0..self.surfaces.len()).map(|s| size_of_val(self.corner_normals(s)) as u64);
        all.sum()
    }
}
