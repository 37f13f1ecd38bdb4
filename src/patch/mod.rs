//! Patches: the pieces of surface between which light is exchanged, from maps and from text scenes.

mod blocks;
mod cuts;
mod detail;
mod leaders;
mod lookup;
mod polygon2;
mod subdivide;
mod text_check;
mod text_lines;
mod text_patches;
mod text_scene;

pub use detail::{Detail, Intervals};
pub use lookup::{PatchGrid, PatchLookup, PolygonPatches};
pub use subdivide::{Emission, MapPatches};
pub use text_check::{MAX_HEMICUBE, MAX_IMAGE, MAX_REFLECTANCE};
pub use text_lines::decode;
pub use text_patches::TextPatches;
pub use text_scene::{CameraSpec, Quad, Reading, Repair, TextScene};

use crate::photometry::Reflectance;
use glam::{DVec3, Vec3};

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
}
