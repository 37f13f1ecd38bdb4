//! Lights as plain data, ready to shine: what [`crate::light`] evaluates.

use super::dirt::DirtKeys;
use super::projection::Projection;
use glam::Vec3;
use std::sync::Arc;

/// How light falls off with distance. The numbers are those of the `delay` key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attenuation {
    /// 0: brightness minus scaled distance.
    Linear,
    /// 0 with a `falloff` key: linear down to zero at this radius, in world units.
    Falloff(f32),
    /// 1: inverse of distance, full at 128 scaled units.
    Inverse,
    /// 2: inverse square, full at 128 scaled units.
    InverseSquare,
    /// 3: none.
    Infinite,
    /// 4: what the light sees is at least as bright as the light; listed apart from other lights.
    LocalMinimum,
    /// 5: inverse square of distance plus 128.
    InverseSquareOffset,
    /// 6: inverse square in plain units, no nearer than 128.
    InverseSquareClamped,
}

/// A cone of light. Cosines are negated as they are compared with the direction *to* the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Unit direction in which the light shines.
    pub direction: Vec3,
    /// `-cos` of half the outer cone: no light beyond.
    pub outer: f32,
    /// `-cos` of half the inner cone: full light within.
    pub inner: f32,
}

/// A point or spot light.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// World position.
    pub origin: Vec3,
    /// Brightness in light units, never 0; negative takes light away.
    pub brightness: f32,
    /// Colour, 0 to 255 a channel (not limited).
    pub colour: Vec3,
    /// Scale on distance, above 0 (`wait`).
    pub wait: f32,
    /// Falloff with distance.
    pub attenuation: Attenuation,
    /// Share of the cosine law, 0 (no angle dependence) to 1.
    pub angle_scale: f32,
    /// Lights faces from behind as well.
    pub bleed: bool,
    /// Light style the light belongs to.
    pub style: u16,
    /// Cone, for spotlights.
    pub spot: Option<Spot>,
    /// Picture that it projects.
    pub projection: Option<Arc<Projection>>,
    /// Channels; faces without a common channel are not lit.
    pub channel_mask: i32,
    /// Channels of the surfaces that cast shadow in its light.
    pub shadow_mask: i32,
    /// What it asks of dirt.
    pub dirt: DirtKeys,
    /// Factor on its light where it bounces (`bouncescale`), 0 and up.
    pub bounce_scale: f32,
    /// For copies of surface lights: radius of a disc as large as the piece of surface that the copy
    /// stands for, in world units; 0 for others. Nearer, a point light is no likeness of it.
    pub piece_radius: f32,
    /// Index of the entity that it comes from.
    pub entity: u32,
}
