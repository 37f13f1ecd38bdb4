//! From patches back to luxels: indirect light, the stored levels, packing and pictures of them.

mod atlas;
mod finish;
mod indirect;
mod interpolate;
mod pack;

pub use atlas::dump;
pub use finish::{FinishSettings, FinishedFace, FinishedStyle, finish};
pub use indirect::{Gather, PatchLight, indirect};
pub use pack::{Packed, pack};

use crate::photometry::Irradiance;

/// Light of one style at the luxels of a face, row by row, before range scaling.
#[derive(Clone, Debug, PartialEq)]
pub struct StyleMap {
    /// Light style: 0 to 254, or more (which only BSPX outputs can store).
    pub style: u16,
    /// One entry a luxel.
    pub light: Vec<Irradiance>,
}

/// Adds `more` to the map of `style`, which is made if it is not there.
pub fn accumulate(maps: &mut Vec<StyleMap>, style: u16, more: &[Irradiance]) {
    if let Some(map) = maps.iter_mut().find(|m| m.style == style) {
        for (sum, e) in map.light.iter_mut().zip(more) {
            *sum += *e;
        }
    } else {
        maps.push(StyleMap { style, light: more.to_vec() });
    }
}
