//! The lighting lump: finished faces one after another.

use super::{FinishedFace, FinishedStyle};
use crate::bsp::{pack_direction, pack_e5bgr9};
use crate::{Error, Result};
use glam::Vec3;

/// Levels that HDR lightmaps call 1.
const HDR_UNIT: f32 = 128.0;
/// What a face record has in place of a style that it lacks.
const NO_STYLE: u8 = 255;
/// Styles that a face record holds.
const RECORD_STYLES: usize = 4;

/// Lightmaps as a map file stores them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Packed {
    /// One level a luxel: the largest channel.
    pub mono: Vec<u8>,
    /// Three levels a luxel, at three times the offset.
    pub rgb: Vec<u8>,
    /// One HDR colour a luxel (see [`crate::bsp::pack_e5bgr9`]), at the same index.
    pub hdr: Vec<u32>,
    /// Three bytes a luxel, where light comes from (see [`crate::bsp::pack_direction`]), at three times
    /// the offset; none unless wanted.
    pub directions: Vec<u8>,
    /// For each face record: offset into `mono`, -1 for none, and its styles, 255 for none and for those
    /// that a byte cannot name.
    pub faces: Vec<(i32, [u8; 4])>,
    /// For each face: all its lightmaps, at the luxel size they were made with.
    pub blocks: Vec<Block>,
    /// Whether any face has colour.
    pub coloured: bool,
}

/// The lightmaps of a face in the lump.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Offset into [`Packed::mono`]; -1 for none.
    pub offset: i32,
    /// Styles in the order of the maps.
    pub styles: Vec<u16>,
}

/// What the record of a face tells of its lightmaps: engines that read no lump about other luxel sizes
/// take the size that the texture gives.
#[derive(Clone, Debug, PartialEq)]
pub enum Vanilla {
    /// The maps have that size: the record points to them.
    Same,
    /// Other maps, of that size, are stored for them.
    Copy(Vec<FinishedStyle>),
    /// Nothing is stored for them.
    Absent,
}

/// Packs faces in order, each at a multiple of four bytes. `vanilla` has an entry a face, or none at
/// all where every face is [`Vanilla::Same`].
///
/// # Errors
/// When the lump would pass 2 GiB, which offsets cannot address.
pub fn pack(faces: &[FinishedFace], vanilla: &[Vanilla]) -> Result<Packed> {
    let mut packed = Packed::default();
    for (index, face) in faces.iter().enumerate() {
        packed.coloured |= face.coloured;
        let offset = packed.push(&face.styles)?;
        let record = match vanilla.get(index).unwrap_or(&Vanilla::Same) {
            Vanilla::Same => offset,
            Vanilla::Copy(maps) => packed.push(&maps[..maps.len().min(RECORD_STYLES)])?,
            Vanilla::Absent => -1,
        };
        let mut styles = [NO_STYLE; RECORD_STYLES];
        for (slot, map) in styles.iter_mut().zip(&face.styles) {
            *slot = u8::try_from(map.style).unwrap_or(NO_STYLE);
        }
        packed.faces.push((record, styles));
        let styles = face.styles.iter().map(|map| map.style).collect();
        packed.blocks.push(Block { offset, styles });
    }
    Ok(packed)
}

impl Packed {
    /// Appends the maps of a face; returns where they begin, -1 for none.
    fn push(&mut self, maps: &[FinishedStyle]) -> Result<i32> {
        if maps.is_empty() {
            return Ok(-1);
        }
        let offset = i32::try_from(self.mono.len()).map_err(|_| Error::Limit {
            what: "lighting lump in bytes".into(),
            value: self.mono.len() as u64,
            limit: i32::MAX as u64,
            advice: "use fewer light styles or larger luxels",
        })?;
        for map in maps {
            for level in &map.levels {
                self.mono.push(level.iter().copied().max().unwrap_or(0));
                self.rgb.extend_from_slice(level);
            }
            self.hdr.extend(map.light.iter().map(|&light| hdr_colour(light)));
            self.directions.extend(map.directions.iter().flat_map(|&d| pack_direction(d)));
        }
        let end = self.mono.len().next_multiple_of(4);
        self.mono.resize(end, 0);
        self.rgb.resize(3 * end, 0);
        self.hdr.resize(end, 0);
        if !self.directions.is_empty() {
            self.directions.resize(3 * end, 0);
        }
        Ok(offset)
    }
}

/// Light in levels as HDR lightmaps store it (see [`crate::bsp::pack_e5bgr9`]).
pub fn hdr_colour(light: Vec3) -> u32 {
    pack_e5bgr9(light / HDR_UNIT)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn maps(style: u16, light: &[[f32; 3]]) -> Vec<FinishedStyle> {
        vec![FinishedStyle::new(style, light.iter().copied().map(Vec3::from).collect())]
    }

    fn lit(style: u16, light: &[[f32; 3]]) -> FinishedFace {
        FinishedFace { styles: maps(style, light), ..FinishedFace::default() }
    }

    #[test]
    fn blocks_are_aligned_and_in_face_order() {
        let faces = [
            lit(0, &[[1.0, 2.0, 3.0]; 5]),
            FinishedFace::default(),
            lit(7, &[[9.0, 512.0, 4.0]; 4]),
        ];
        let packed = pack(&faces, &[]).unwrap();
        assert_eq!(packed.faces[0], (0, [0, 255, 255, 255]));
        assert_eq!(packed.faces[1], (-1, [255; 4]));
        assert_eq!(packed.faces[2], (8, [7, 255, 255, 255]));
        assert_eq!(packed.mono, [3, 3, 3, 3, 3, 0, 0, 0, 255, 255, 255, 255]);
        assert_eq!(packed.rgb.len(), 36);
        assert_eq!(packed.rgb[24..27], [4, 255, 1]);
        assert_eq!(packed.hdr.len(), 12);
        assert_eq!(packed.hdr[5..8], [0; 3]);
        // Not limited: 512 levels are 4.
        assert_eq!(packed.hdr[8], pack_e5bgr9(Vec3::new(9.0 / 128.0, 4.0, 4.0 / 128.0)));
    }

    #[test]
    fn copies_for_vanilla_engines_have_places_of_their_own() {
        let face = lit(5, &[[8.0; 3]; 9]);
        let copy = Vanilla::Copy(maps(5, &[[2.0; 3]; 4]));
        let faces = [face.clone(), face.clone(), face];
        let packed = pack(&faces, &[copy, Vanilla::Absent, Vanilla::Same]).unwrap();
        let records: Vec<i32> = packed.faces.iter().map(|f| f.0).collect();
        let blocks: Vec<i32> = packed.blocks.iter().map(|b| b.offset).collect();
        assert_eq!((records, blocks), (vec![12, -1, 28], vec![0, 16, 28]));
        assert_eq!(packed.mono[12..16], [2; 4]);
        assert!(packed.faces.iter().all(|f| f.1 == [5, 255, 255, 255]));
    }
}
