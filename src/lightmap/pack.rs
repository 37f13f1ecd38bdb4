//! The lighting lump: finished faces one after another.

use super::FinishedFace;
use crate::{Error, Result};

/// Lightmaps as a map file stores them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Packed {
    /// One level a luxel: the largest channel.
    pub mono: Vec<u8>,
    /// Three levels a luxel, at three times the offset.
    pub rgb: Vec<u8>,
    /// For each face: offset into `mono`, -1 for none, and its styles, 255 for none.
    pub faces: Vec<(i32, [u8; 4])>,
    /// Whether any face has colour.
    pub coloured: bool,
}

/// Packs faces in order, each at a multiple of four bytes.
///
/// # Errors
/// When the lump would pass 2 GiB, which offsets cannot address.
pub fn pack(faces: &[FinishedFace]) -> Result<Packed> {
    let mut packed = Packed::default();
    for face in faces {
        packed.coloured |= face.coloured;
        if face.styles.is_empty() {
            packed.faces.push((-1, [255; 4]));
            continue;
        }
        let offset = i32::try_from(packed.mono.len()).map_err(|_| Error::Limit {
            what: "lighting lump in bytes".into(),
            value: packed.mono.len() as u64,
            limit: i32::MAX as u64,
            advice: "use fewer light styles or larger luxels",
        })?;
        let mut styles = [255; 4];
        for (slot, map) in styles.iter_mut().zip(&face.styles) {
            *slot = map.style;
            for level in &map.levels {
                packed.mono.push(level.iter().copied().max().unwrap_or(0));
                packed.rgb.extend_from_slice(level);
            }
        }
        let end = packed.mono.len().next_multiple_of(4);
        packed.mono.resize(end, 0);
        packed.rgb.resize(3 * end, 0);
        packed.faces.push((offset, styles));
    }
    Ok(packed)
}

#[cfg(test)]
mod tests {
    use super::super::FinishedStyle;
    use super::*;

    #[test]
    fn blocks_are_aligned_and_in_face_order() {
        let lit = |style, levels: &[[u8; 3]]| FinishedFace {
            styles: vec![FinishedStyle { style, levels: levels.to_vec() }],
            ..FinishedFace::default()
        };
        let faces = [lit(0, &[[1, 2, 3]; 5]), FinishedFace::default(), lit(7, &[[9, 4, 4]; 4])];
        let packed = pack(&faces).unwrap();
        assert_eq!(packed.faces[0], (0, [0, 255, 255, 255]));
        assert_eq!(packed.faces[1], (-1, [255; 4]));
        assert_eq!(packed.faces[2], (8, [7, 255, 255, 255]));
        assert_eq!(packed.mono, [3, 3, 3, 3, 3, 0, 0, 0, 9, 9, 9, 9]);
        assert_eq!(packed.rgb.len(), 36);
        assert_eq!(packed.rgb[24..27], [9, 4, 4]);
    }
}
