//! Glass for light that bounces: the same tint as for direct light (`filter`).

use super::texels::Texels;
use glam::{Vec3, Vec4};
use std::sync::Arc;

/// A face of glass.
#[derive(Clone, Debug)]
pub struct Pane {
    /// Unit normal; light is tinted where a look leaves through this side, so that a pane with a front and
    /// a back tints once.
    pub(super) normal: Vec3,
    /// Share of light that takes on the colour, 0 to 1.
    pub(super) opacity: f32,
    /// Where the colour is from; `None` changes no light.
    pub(super) colour: Option<PaneColour>,
}

/// Colour of glass.
#[derive(Clone, Debug)]
pub(super) enum PaneColour {
    /// The same all over, 0 to 1.
    Even(Vec3),
    /// Texels, the coefficients of the texture's two axes and the offset of the brush model.
    Texture(Arc<Texels>, [Vec4; 2], Vec3),
}

impl Pane {
    /// Share of each channel that comes through at `point` to an eye that looks along `direction`.
    pub fn tint(&self, point: Vec3, direction: Vec3) -> Vec3 {
        if direction.dot(self.normal) <= 0.0 {
            return Vec3::ONE;
        }
        let colour = match &self.colour {
            None => None,
            Some(PaneColour::Even(colour)) => Some(*colour),
            Some(PaneColour::Texture(texels, axes, offset)) => {
                let p = (point - *offset).extend(1.0);
                let [s, t] = axes.map(|axis| axis.dot(p));
                texels.colour_at(s, t).map(|c| c / 255.0)
            }
        };
        colour.map_or(Vec3::ONE, |c| Vec3::ONE.lerp(c, self.opacity))
    }
}
