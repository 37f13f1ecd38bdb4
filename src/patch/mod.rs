//! Patches: the pieces of surface between which light is exchanged, from maps and from text scenes.

mod blocks;
mod cuts;
mod detail;
mod groups;
mod lookup;
mod opposite;
mod overlay;
mod pattern;
mod polygon2;
mod spots;
mod subdivide;
mod text_check;
mod text_effects;
mod text_lines;
mod text_patches;
mod text_scene;
mod work;

pub use detail::{Detail, Intervals};
pub use groups::Groups;
pub use lookup::{PatchGrid, PatchLookup, PolygonPatches};
pub use overlay::{Glow, Overlay, Sheet, Tint, in_cone};
pub use pattern::Pattern;
pub use subdivide::{Emission, MapPatches};
pub use text_check::{MAX_HEMICUBE, MAX_IMAGE, MAX_REFLECTANCE};
pub use text_effects::{PatchEffects, Shader};
pub use text_lines::decode;
pub use text_patches::TextPatches;
pub use text_scene::{CameraSpec, Quad, Reading, Repair, TextScene};
pub use work::Work;

use crate::photometry::Reflectance;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Index of a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PatchId(pub u32);

/// A flat, diffuse, one-sided piece of surface.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Point that its hemicube stands on, a little above the surface.
    pub eye: Vec3,
    /// Unit normal of the side that gives and takes light.
    pub normal: Vec3,
    /// Area in square world units.
    pub area: f32,
    /// Share of light it sends back, per channel.
    pub reflectance: Reflectance,
}

/// All patches of a scene.
#[derive(Clone, Debug, Default)]
pub struct PatchSet {
    /// The patches; [`PatchId`] indexes them.
    pub patches: Vec<Patch>,
    /// Corners of each patch, a convex polygon, counter-clockwise seen from its front; empty where
    /// they are not known.
    pub outlines: Vec<Vec<DVec3>>,
    /// Which patch a point of a polygon belongs to.
    pub lookup: PatchLookup,
    /// Light that meets one patch and leaves another.
    pub passages: Vec<Passage>,
    /// Translucent polygons and patterns; `None` where there are none.
    pub overlay: Option<Arc<Overlay>>,
}

impl PatchSet {
    /// Number of columns of light: one for each patch, and after them one for each glow of the overlay.
    pub fn columns(&self) -> usize {
        self.patches.len() + self.overlay.as_deref().map_or(0, |overlay| overlay.glows().len())
    }
}

/// Diffuse transmission: light that meets a patch and leaves another, the other side of the sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// The patch that the light meets.
    pub from: PatchId,
    /// The patch that it leaves.
    pub to: PatchId,
    /// Share of the irradiance of `from` that becomes exitance of `to`, per channel; with the reflectance
    /// of `from` at most 1.
    pub transmittance: Vec3,
}

impl PatchSet {
    /// Share of the light that meets each patch that it sends on, by reflection and transmission; per
    /// channel, from 0 to 1.
    pub fn albedo(&self) -> Vec<Vec3> {
        let mut albedo: Vec<Vec3> = self.patches.iter().map(|p| p.reflectance.0).collect();
        for passage in &self.passages {
            albedo[passage.from.0 as usize] += passage.transmittance;
        }
        albedo
    }
}
