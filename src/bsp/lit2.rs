//! Version 2 of `.lit` files: lightmaps with sizes, offsets, styles and light directions of their own,
//! beside a map that stays as it is (contract section 1.6).

/// Styles that a face has in the file.
const STYLES: usize = 4;
/// What fills the list of styles up.
const NO_STYLE: u16 = 0xFFFF;
const VERSION: i32 = 2;

/// What the file says of a face.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LitFace {
    /// Offset of its first lightmap in luxels; -1 for none.
    pub offset: i32,
    /// Its light styles, of which the file holds four.
    pub styles: Vec<u16>,
    /// Columns and rows of a lightmap.
    pub size: [u16; 2],
    /// A luxel has `1 << shift` texels.
    pub shift: u8,
}

/// Bytes of the file: a record for each of `faces`, then `rgb` and `directions`, three bytes a luxel each.
///
/// # Panics
/// If `rgb` and `directions` are not of the same length.
pub fn write_lit2(faces: &[LitFace], rgb: &[u8], directions: &[u8]) -> Vec<u8> {
    assert_eq!(rgb.len(), directions.len(), "a colour and a direction a luxel");
    let counts = [VERSION, faces.len() as i32, (rgb.len() / 3) as i32];
    let mut file = b"QLIT".to_vec();
    file.extend(counts.iter().flat_map(|n| n.to_le_bytes()));
    for face in faces {
        file.extend_from_slice(&face.offset.to_le_bytes());
        let styles = face.styles.iter().copied().chain(std::iter::repeat(NO_STYLE)).take(STYLES);
        file.extend(styles.chain(face.size).flat_map(u16::to_le_bytes));
        file.push(face.shift);
    }
    [&file, rgb, directions].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_stand_between_header_and_luxels() {
        let faces = [
            LitFace { offset: 0, styles: vec![3, 300], size: [2, 1], shift: 4 },
            LitFace { offset: -1, ..LitFace::default() },
        ];
        let file = write_lit2(&faces, &[1, 2, 3, 4, 5, 6], &[7; 6]);
        assert_eq!(file.len(), 16 + 2 * 17 + 12);
        assert_eq!(file[..16], *b"QLIT\x02\0\0\0\x02\0\0\0\x02\0\0\0");
        let first = [0, 0, 0, 0, 3, 0, 44, 1, 255, 255, 255, 255, 2, 0, 1, 0, 4];
        assert_eq!(file[16..33], first);
        assert_eq!(file[33..37], [255; 4]);
        assert_eq!(file[50..], [1, 2, 3, 4, 5, 6, 7, 7, 7, 7, 7, 7]);
    }
}
