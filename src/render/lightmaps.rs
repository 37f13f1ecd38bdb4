//! Light on a face as the engine's surface cache computes it.

use super::styles::style_scale;
use crate::bsp::{Bsp, Extents};
use crate::{Error, Result};

/// Texels a luxel.
const LUXEL_SIZE: f32 = 16.0;
/// Style number that ends a face's list.
const NO_STYLE: u8 = 255;

/// Light on a face.
#[derive(Clone, Copy)]
pub(super) enum Light {
    /// The same everywhere, in the units of [`Lightmaps::at`].
    Even(f32),
    /// From lightmaps.
    Map(FaceMaps),
}

/// Where the lightmaps of a face are.
#[derive(Clone, Copy)]
pub(super) struct FaceMaps {
    extents: Extents,
    /// First luxel in the lighting lump.
    start: usize,
    /// Brightness of each stored lightmap in 1/256.
    scales: [u32; 4],
    count: usize,
}

/// The lighting of a map: three bytes a luxel, or one.
pub(super) struct Lightmaps {
    bytes: Vec<u8>,
    channels: usize,
}

impl Lightmaps {
    /// Full light, which doubles a texture.
    pub const FULL: f32 = 255.0;

    /// The lightmaps of `bsp`, in the colours `rgb` if given.
    ///
    /// # Errors
    /// If `rgb` does not hold three bytes for each byte of the lighting lump.
    pub fn new(bsp: &Bsp, rgb: Option<&[u8]>) -> Result<Self> {
        let Some(rgb) = rgb else {
            return Ok(Self { bytes: bsp.lighting.clone(), channels: 1 });
        };
        if rgb.len() != 3 * bsp.lighting.len() {
            let problem = format!(
                "{} bytes of colours for {} luxels, there must be 3 each: light the map again",
                rgb.len(),
                bsp.lighting.len()
            );
            return Err(Error::format(".lit file", problem));
        }
        Ok(Self { bytes: rgb.to_vec(), channels: 3 })
    }

    /// The light of a face that is not special. Without lightmaps it is dark, or full if the map has
    /// no lighting at all, as in engines. `Err` says what is wrong with its lightmaps.
    pub fn of_face(&self, bsp: &Bsp, face: usize) -> std::result::Result<Light, String> {
        if self.bytes.is_empty() {
            return Ok(Light::Even(Self::FULL));
        }
        let record = &bsp.faces[face];
        let Ok(start) = usize::try_from(record.light_offset) else { return Ok(Light::Even(0.0)) };
        let count = record.styles.iter().take_while(|&&style| style != NO_STYLE).count();
        if count == 0 {
            return Ok(Light::Even(0.0));
        }
        let extents = bsp.face_extents(face, LUXEL_SIZE).map_err(|error| error.to_string())?;
        let area = u64::from(extents.size[0]) * u64::from(extents.size[1]);
        let end = start as u64 + area * count as u64;
        let held = (self.bytes.len() / self.channels) as u64;
        if end > held {
            return Err(format!(
                "face {face}: its lightmaps are luxels {start} to {end} but there are only {held}"
            ));
        }
        let scales = record.styles.map(style_scale);
        Ok(Light::Map(FaceMaps { extents, start, scales, count }))
    }

    /// Light at texture coordinates (`s`, `t`) of a face, from 0 to 255 a channel: 255 doubles the
    /// texture. Each luxel is the sum of the face's styles, cut to a whole number and to 255 as the
    /// engine does; bilinear between luxels.
    pub fn at(&self, light: &Light, s: f64, t: f64) -> [f32; 3] {
        let map = match light {
            Light::Even(level) => return [*level; 3],
            Light::Map(map) => map,
        };
        let place = |coordinate: f64, side: usize| {
            let last = map.extents.size[side] - 1;
            let luxel = coordinate / f64::from(LUXEL_SIZE) - f64::from(map.extents.mins[side]);
            let luxel = luxel.clamp(0.0, last.into());
            let floor = luxel.floor();
            let low = floor as usize;
            (low, (low + 1).min(last as usize), (luxel - floor) as f32)
        };
        let (x0, x1, fx) = place(s, 0);
        let (y0, y1, fy) = place(t, 1);
        let (a, b) = (self.luxel(map, x0, y0), self.luxel(map, x1, y0));
        let (c, d) = (self.luxel(map, x0, y1), self.luxel(map, x1, y1));
        std::array::from_fn(|i| {
            let top = a[i] + (b[i] - a[i]) * fx;
            let bottom = c[i] + (d[i] - c[i]) * fx;
            top + (bottom - top) * fy
        })
    }

    fn luxel(&self, map: &FaceMaps, x: usize, y: usize) -> [f32; 3] {
        let [width, height] = map.extents.size.map(|side| side as usize);
        let first = map.start + y * width + x;
        let mut sum = [0_u32; 3];
        for (style, scale) in map.scales[..map.count].iter().enumerate() {
            let at = (first + style * width * height) * self.channels;
            for (i, channel) in sum.iter_mut().enumerate() {
                *channel += u32::from(self.bytes[at + i % self.channels]) * scale;
            }
        }
        sum.map(|channel| (channel >> 8).min(255) as f32)
    }
}
