//! The classic sky: two layers of clouds on a flattened dome far away.

use super::mipmap::{Mipmap, Texel};
use super::texture::fill_holes;
use crate::bsp::{MipTex, PALETTE};
use glam::DVec3;

/// Height of the dome against its width: directions are stretched by it before they meet the sphere.
const FLATTENING: f64 = 3.0;
/// Texels from the top of the dome to its rim.
const REACH: f64 = 6.0 * 63.0;
/// Texels after which a layer repeats, whatever its size.
const PERIOD: f64 = 128.0;

/// A sky texture: the right half is the back layer, the left half clouds with holes at index 0. The
/// layers move in engines; here they stand as at time 0.
pub(super) struct Sky {
    back: Mipmap,
    clouds: Mipmap,
}

impl Sky {
    /// `None` for a texture without texels or less than two columns.
    pub fn new(miptex: &MipTex) -> Option<Self> {
        let (width, height) = (miptex.width as usize, miptex.height as usize);
        let pixels = miptex.pixels.as_deref()?;
        let half = width / 2;
        if half == 0 || width.checked_mul(height) != Some(pixels.len()) {
            return None;
        }
        let layer = |from: usize, texel: &dyn Fn(u8) -> Texel| {
            let rows = pixels.chunks_exact(width).flat_map(|row| &row[from..from + half]);
            let mut texels: Vec<Texel> = rows.map(|&index| texel(index)).collect();
            fill_holes(&mut texels, half, height);
            Mipmap::flat(half, height, texels)
        };
        let opaque = |index: u8| {
            let [r, g, b] = PALETTE[usize::from(index)];
            [r, g, b, 255]
        };
        let clouds = |index: u8| if index == 0 { [0; 4] } else { opaque(index) };
        Some(Self { back: layer(half, &opaque), clouds: layer(0, &clouds) })
    }

    /// Colour seen along a direction, 0 to 255.
    pub fn colour(&self, direction: DVec3) -> [f32; 3] {
        let dome = DVec3 { z: direction.z * FLATTENING, ..direction };
        let scale = REACH / dome.length() / PERIOD;
        let (u, v) = (dome.x * scale, dome.y * scale);
        let back = self.back.sample(u, v, 1.0);
        let clouds = self.clouds.sample(u, v, 1.0);
        let cover = clouds[3] / 255.0;
        std::array::from_fn(|i| back[i] + (clouds[i] - back[i]) * cover)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clouds_hide_the_back_layer_except_in_their_holes() {
        let sky = |cloud: u8| {
            let pixels = [cloud, cloud, 15, 15].repeat(2);
            let texture = MipTex { name: "sky".into(), width: 4, height: 2, pixels: Some(pixels) };
            Sky::new(&texture).unwrap().colour(DVec3::new(0.3, -0.2, 0.9))
        };
        assert_eq!(sky(0), [235.0; 3]);
        assert_eq!(sky(251), [255.0, 0.0, 0.0]);
    }

    #[test]
    fn textures_without_two_halves_are_no_sky() {
        for (width, pixels) in [(1, Some(vec![1])), (2, None), (4, Some(vec![1; 3]))] {
            assert!(Sky::new(&MipTex { name: "sky".into(), width, height: 1, pixels }).is_none());
        }
    }
}
