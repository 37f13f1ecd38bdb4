//! One channel of light instead of three, where all three would hold the same.

use super::solve::{Sources, Surfaces};
use glam::Vec3;

/// How many channels of light are carried from patch to patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channels {
    /// One stands for all three.
    One,
    /// Red, green and blue.
    Three,
}

impl Channels {
    /// What a scene calls for: one channel where neither its light nor anything that light meets has
    /// colour. Both give the same bytes then.
    pub fn of<'a>(surfaces: Surfaces<'_>, sources: impl IntoIterator<Item = Sources<'a>>) -> Self {
        let Surfaces { transfers, reflectance, passages } = surfaces;
        let grey = reflectance.iter().all(|rho| is_grey(rho.0))
            && passages.iter().all(|p| is_grey(p.transmittance))
            && sources.into_iter().all(|s| {
                s.emission.iter().all(|m| is_grey(m.0)) && s.direct.iter().all(|e| is_grey(e.0))
            })
            && transfers.overlay().all(is_grey);
        if grey { Self::One } else { Self::Three }
    }

    /// 1 or 3.
    pub fn count(self) -> u64 {
        match self {
            Self::One => 1,
            Self::Three => 3,
        }
    }
}

/// Whether all channels of a colour are the same.
fn is_grey(colour: Vec3) -> bool {
    colour.x == colour.y && colour.y == colour.z
}

/// The first `C` channels of a colour.
pub(super) fn channels<const C: usize>(colour: Vec3) -> [f64; C] {
    std::array::from_fn(|c| f64::from(colour[c]))
}

/// The colour that `C` channels stand for; the last of them counts for those that are missing.
pub(super) fn colour<const C: usize>(light: [f64; C]) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|c| light[c.min(C - 1)] as f32))
}
