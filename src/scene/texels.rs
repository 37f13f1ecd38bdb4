//! Single texels of a texture: fences, glass and projected pictures.

use crate::bsp::{Bsp, MipTex, PALETTE, TRANSPARENT};
use glam::Vec3;

/// The pixels of a texture and how texture coordinates address them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Texels {
    width: u32,
    height: u32,
    /// Pixels per unit of the texture coordinates; above or below 1 for pixels of another size.
    scale: [f32; 2],
    pixels: Vec<u8>,
}

impl Texels {
    /// The texture in a slot of the texture lump; its pixels may come from `replacements`. `None` if
    /// nobody has them.
    pub fn find(bsp: &Bsp, texture: u32, replacements: &[MipTex]) -> Option<Self> {
        let slot = bsp.textures.get(texture as usize)?.as_ref()?;
        let full = |t: &&MipTex| t.pixels.is_some();
        let source = Some(slot).filter(full).or_else(|| {
            replacements.iter().filter(full).find(|r| r.name.eq_ignore_ascii_case(&slot.name))
        })?;
        let pixels = source.pixels.clone()?;
        let (width, height) = (source.width, source.height);
        if width == 0 || height == 0 || pixels.len() < width as usize * height as usize {
            return None;
        }
        let scale = |pixels: u32, units: u32| {
            if units == 0 { 1.0 } else { pixels as f32 / units as f32 }
        };
        let scale = [scale(width, slot.width), scale(height, slot.height)];
        Some(Self { width, height, scale, pixels })
    }

    /// Columns and rows.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Palette index at texture coordinates.
    #[inline]
    pub fn index_at(&self, s: f32, t: f32) -> u8 {
        let column = wrap(s * self.scale[0], self.width);
        let row = wrap(t * self.scale[1], self.height);
        self.pixels[row * self.width as usize + column]
    }

    /// Colour at texture coordinates, 0 to 255; `None` where the texture is see-through.
    #[inline]
    pub fn colour_at(&self, s: f32, t: f32) -> Option<Vec3> {
        let index = self.index_at(s, t);
        (index != TRANSPARENT).then(|| colour(index))
    }

    /// Share of the pixels that are not see-through, 0 to 1.
    pub fn covered(&self) -> f32 {
        let pixels = &self.pixels[..self.width as usize * self.height as usize];
        let opaque = pixels.iter().filter(|&&p| p != TRANSPARENT).count();
        opaque as f32 / pixels.len() as f32
    }

    /// Colour of a pixel, 0 to 255; columns and rows wrap.
    pub fn pixel(&self, column: usize, row: usize) -> Vec3 {
        let (width, height) = (self.width as usize, self.height as usize);
        colour(self.pixels[row % height * width + column % width])
    }
}

fn colour(index: u8) -> Vec3 {
    Vec3::from(PALETTE[usize::from(index)].map(f32::from))
}

/// The texel that a coordinate falls on; negative coordinates wrap one texel late on whole numbers,
/// as in the reference.
fn wrap(x: f32, size: u32) -> usize {
    // The same in numbers that are divided faster.
    if x.abs() < 2_147_483_648.0 {
        let whole = x.abs() as u32;
        let ends_within = x < 0.0 && (whole as f32) < -x;
        let texel = (whole + u32::from(ends_within)) % size;
        return if x >= 0.0 || texel == 0 { texel } else { size - texel } as usize;
    }
    let n = u64::from(size);
    let texel = if x >= 0.0 { x as u64 % n } else { (n - (-x).ceil() as u64 % n) % n };
    texel as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_wrap_at_the_ends_of_the_texture() {
        // The table of the contract's section 12.5.
        for (x, want) in [
            (0.0, 0),
            (0.5, 0),
            (1.0, 1),
            (1.5, 1),
            (2.0, 0),
            (2.5, 0),
            (-0.5, 1),
            (-1.0, 1),
            (-1.5, 0),
            (-2.0, 0),
            (-2.5, 1),
        ] {
            assert_eq!(wrap(x, 2), want, "{x} of 2");
        }
        for (x, want) in [
            (64.5, 64),
            (127.0, 127),
            (128.0, 0),
            (129.0, 1),
            (-0.5, 127),
            (-1.0, 127),
            (-127.0, 1),
            (-127.5, 0),
            (-128.0, 0),
            (-129.0, 127),
        ] {
            assert_eq!(wrap(x, 128), want, "{x} of 128");
        }
        // Numbers of either width.
        for x in [3e9_f32, 2_147_483_648.0, 2_147_483_520.0, 1e7, 255.75, 0.25, 0.0] {
            assert_eq!(wrap(x, 7), (x as u64 % 7) as usize, "{x}");
            let up = x.ceil() as u64 % 7;
            assert_eq!(wrap(-x, 7), ((7 - up) % 7) as usize, "-{x}");
        }
        assert!(wrap(f32::NAN, 3) < 3 && wrap(f32::INFINITY, 3) < 3 && wrap(-1e30, 3) < 3);
    }
}
