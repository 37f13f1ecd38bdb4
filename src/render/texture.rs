//! Textures as engines upload them: colours, glowing texels apart, holes in fences.

use super::mipmap::{Mipmap, Texel};
use crate::bsp::{MipTex, PALETTE, TRANSPARENT};

/// First palette index that glows: it is drawn unlit.
const FIRST_GLOWING: u8 = 224;
/// Side of the picture drawn in place of a texture that is nowhere to be found, in texels.
const CHECKER_SIZE: usize = 64;

/// A texture ready to be drawn.
pub(super) struct Texture {
    /// Texels a repetition, from the map: a replacement may have another size.
    width: f64,
    height: f64,
    /// What is lit; black where the texture glows. Coverage is 0 in holes.
    lit: Mipmap,
    /// What glows, black elsewhere; `None` if nothing does.
    glow: Option<Mipmap>,
}

/// A filtered texel.
pub(super) struct Sample {
    /// Colour to be lit, 0 to 255.
    pub lit: [f32; 3],
    /// Colour added after lighting, 0 to 255.
    pub glow: [f32; 3],
    /// Part that is no hole, 0 to 1.
    pub coverage: f32,
}

impl Texture {
    /// A texture of `miptex`, or of `replacement` where it has no texels; grey squares without both.
    /// In fences, whose names begin with `{`, index 255 is a hole. Liquids (`*`) do not glow by
    /// themselves: where they have lightmaps, engines light all of their texels.
    pub fn new(miptex: &MipTex, replacement: Option<&MipTex>) -> Self {
        let source = if miptex.pixels.is_some() { Some(miptex) } else { replacement };
        let pixels = source.and_then(|source| {
            let pixels = source.pixels.as_deref()?;
            let (width, height) = (source.width as usize, source.height as usize);
            (!pixels.is_empty() && width.checked_mul(height) == Some(pixels.len()))
                .then_some((width, height, pixels))
        });
        let Some((width, height, pixels)) = pixels else {
            return Self::checker(miptex.width, miptex.height);
        };
        let fence = miptex.name.starts_with('{');
        let hole = |index: u8| fence && index == TRANSPARENT;
        let liquid = miptex.name.starts_with('*');
        let glowing = |index: u8| index >= FIRST_GLOWING && !hole(index) && !liquid;
        let colour = |index: u8| PALETTE[usize::from(index)];
        let with = |[r, g, b]: [u8; 3], alpha| [r, g, b, alpha];

        let mut lit: Vec<Texel> = pixels
            .iter()
            .map(|&index| match index {
                _ if hole(index) => [0; 4],
                _ if glowing(index) => [0, 0, 0, 255],
                _ => with(colour(index), 255),
            })
            .collect();
        fill_holes(&mut lit, width, height);
        let glow = pixels.iter().any(|&index| glowing(index)).then(|| {
            let texels = pixels
                .iter()
                .map(|&index| with(if glowing(index) { colour(index) } else { [0; 3] }, 255));
            Mipmap::new(width, height, texels.collect())
        });
        let or = |of_map: u32, of_pixels: usize| {
            if of_map == 0 { of_pixels as f64 } else { of_map.into() }
        };
        Self {
            width: or(miptex.width, width),
            height: or(miptex.height, height),
            lit: Mipmap::new(width, height, lit),
            glow,
        }
    }

    /// Grey squares, repeating every `width` x `height` texels (0: as many as there are).
    pub fn checker(width: u32, height: u32) -> Self {
        let texels = (0..CHECKER_SIZE * CHECKER_SIZE)
            .map(|i| {
                let odd = (i / (CHECKER_SIZE / 4) + i / (CHECKER_SIZE * CHECKER_SIZE / 4)) % 2 == 1;
                let level = if odd { 128 } else { 96 };
                [level, level, level, 255]
            })
            .collect();
        let side = |texels: u32| if texels == 0 { CHECKER_SIZE as f64 } else { texels.into() };
        Self {
            width: side(width),
            height: side(height),
            lit: Mipmap::new(CHECKER_SIZE, CHECKER_SIZE, texels),
            glow: None,
        }
    }

    /// The texture at texel coordinates `at`, filtered for a pixel whose right and lower neighbours
    /// are at `right` and `below`.
    pub fn sample(&self, at: [f64; 2], right: [f64; 2], below: [f64; 2]) -> Sample {
        let [columns, rows] = self.lit.size();
        let reach = |to: [f64; 2]| {
            let x = (to[0] - at[0]) * columns / self.width;
            let y = (to[1] - at[1]) * rows / self.height;
            x.hypot(y)
        };
        let (across, down) = (reach(right), reach(below));
        // A step that is not a number must not hide behind the other.
        let footprint = if across >= down || across.is_nan() { across } else { down };
        let (u, v) = (at[0] / self.width, at[1] / self.height);
        let [r, g, b, alpha] = self.lit.sample(u, v, footprint);
        let glow = self.glow.as_ref().map_or([0.0; 3], |glow| {
            let [r, g, b, _] = glow.sample(u, v, footprint);
            [r, g, b]
        });
        Sample { lit: [r, g, b], glow, coverage: alpha / 255.0 }
    }
}

/// Gives holes the mean colour of the texels around them, so that filtering at their edges does not
/// mix in another colour. Coverage stays 0.
pub(super) fn fill_holes(texels: &mut [Texel], width: usize, height: usize) {
    if texels.iter().all(|texel| texel[3] != 0) {
        return;
    }
    for y in 0..height {
        for x in 0..width {
            if texels[y * width + x][3] != 0 {
                continue;
            }
            let (mut sum, mut count) = ([0_u32; 3], 0);
            for (dx, dy) in [(0, 0), (1, 0), (2, 0), (0, 1), (2, 1), (0, 2), (1, 2), (2, 2)] {
                let (nx, ny) = ((x + width + dx - 1) % width, (y + height + dy - 1) % height);
                let [r, g, b, alpha] = texels[ny * width + nx];
                if alpha != 0 {
                    sum = [sum[0] + u32::from(r), sum[1] + u32::from(g), sum[2] + u32::from(b)];
                    count += 1;
                }
            }
            if count > 0 {
                let [r, g, b] = sum.map(|channel| (channel / count) as u8);
                texels[y * width + x] = [r, g, b, 0];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn miptex(name: &str, pixels: Option<Vec<u8>>) -> MipTex {
        MipTex { name: name.into(), width: 2, height: 2, pixels }
    }

    fn texel(texture: &Texture, x: f64, y: f64) -> Sample {
        texture.sample([x, y], [x, y], [x, y])
    }

    #[test]
    fn glowing_texels_are_apart() {
        let texture = Texture::new(&miptex("lamp", Some(vec![15, 251, 255, 0])), None);
        let plain = texel(&texture, 0.5, 0.5);
        assert_eq!((plain.lit, plain.glow), ([235.0; 3], [0.0; 3]));
        let red = texel(&texture, 1.5, 0.5);
        assert_eq!((red.lit, red.glow), ([0.0; 3], [255.0, 0.0, 0.0]));
        assert_eq!(texel(&texture, 0.5, 1.5).glow, [159.0, 91.0, 83.0]);
        let lava = Texture::new(&miptex("*lava", Some(vec![251; 4])), None);
        assert_eq!(texel(&lava, 1.5, 0.5).lit, [255.0, 0.0, 0.0]);
    }

    #[test]
    fn only_fences_have_holes() {
        let pixels = Some(vec![15, 255, 15, 15]);
        let fence = Texture::new(&miptex("{grate", pixels.clone()), None);
        let hole = texel(&fence, 1.5, 0.5);
        assert_eq!((hole.coverage, hole.lit), (0.0, [235.0; 3]));
        assert_eq!(texel(&fence, 0.5, 0.5).coverage, 1.0);
        let wall = Texture::new(&miptex("grate", pixels), None);
        assert_eq!(texel(&wall, 1.5, 0.5).coverage, 1.0);
    }

    #[test]
    fn replacements_stretch_over_the_size_in_the_map() {
        let big = MipTex { name: "WALL".into(), width: 4, height: 4, pixels: Some(vec![15; 16]) };
        let found = Texture::new(&miptex("wall", None), Some(&big));
        assert_eq!(texel(&found, 0.1, 0.9).lit, [235.0; 3]);
        assert_eq!((found.width, found.height), (2.0, 2.0));
        let lost = texel(&Texture::new(&miptex("wall", None), None), 0.1, 0.1).lit;
        assert!(lost == [96.0; 3] || lost[0] > 96.0 && lost[0] < 129.0, "{lost:?}");
    }
}
