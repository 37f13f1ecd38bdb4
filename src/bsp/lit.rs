//! `.lit` files: the colours of a lighting lump, kept beside the BSP. Version 1 holds bytes, version
//! 0x10001 (HDR) colours with a shared exponent.

use super::cursor::Cursor;
use crate::{Error, Result};

const MAGIC: &[u8; 4] = b"QLIT";
const VERSION: i32 = 1;
const HDR_VERSION: i32 = 0x1_0001;

/// Bytes of a `.lit` file for `rgb`, three bytes for each byte of the lighting lump: those of lump byte
/// `k` are at `3 * k` here and at `8 + 3 * k` in the file.
pub fn write_lit(rgb: &[u8]) -> Vec<u8> {
    [&MAGIC[..], &VERSION.to_le_bytes(), rgb].concat()
}

/// Bytes of an HDR `.lit` file for `colours`, one for each byte of the lighting lump, packed by
/// [`super::pack_e5bgr9`].
pub fn write_hdr_lit(colours: &[u32]) -> Vec<u8> {
    let mut file = [&MAGIC[..], &HDR_VERSION.to_le_bytes()].concat();
    file.extend(colours.iter().flat_map(|colour| colour.to_le_bytes()));
    file
}

/// The colours of a `.lit` file, see [`write_lit`].
///
/// # Errors
/// If the file is no `.lit`, of another version, or does not hold whole colours.
pub fn read_lit(file: &[u8]) -> Result<Vec<u8>> {
    payload(file, VERSION, 3).map(<[u8]>::to_vec)
}

/// The colours of an HDR `.lit` file, see [`write_hdr_lit`].
///
/// # Errors
/// If the file is no `.lit`, of another version, or does not hold whole colours.
pub fn read_hdr_lit(file: &[u8]) -> Result<Vec<u32>> {
    let word = |b: &[u8]| u32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    Ok(payload(file, HDR_VERSION, 4)?.chunks_exact(4).map(word).collect())
}

/// What follows the header of a file of a version, colours of `size` bytes.
fn payload(file: &[u8], expected: i32, size: usize) -> Result<&[u8]> {
    let mut cursor = Cursor::new(file, ".lit header");
    if cursor.take(4)? != MAGIC {
        return Err(Error::format(".lit header", "it does not begin with QLIT: not a .lit file"));
    }
    let version = cursor.i32()?;
    if version != expected {
        return Err(Error::Unsupported(format!(
            ".lit version {version:#x}, only version {expected:#x} is read here"
        )));
    }
    let colours = &file[8..];
    if !colours.len().is_multiple_of(size) {
        return Err(Error::format(
            ".lit file",
            format!("{} bytes of colours are no multiple of {size}: it is cut off", colours.len()),
        ));
    }
    Ok(colours)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lit_has_eight_bytes_of_header_and_comes_back() {
        let rgb = [1, 2, 3, 250, 251, 252];
        let file = write_lit(&rgb);
        assert_eq!(file, b"QLIT\x01\0\0\0\x01\x02\x03\xFA\xFB\xFC");
        assert_eq!(read_lit(&file).unwrap(), rgb);
        assert!(read_lit(&write_lit(&[])).unwrap().is_empty());
    }

    #[test]
    fn hdr_lits_come_back_and_are_told_from_others() {
        let colours = [0, 0x8000_0001, u32::MAX];
        let file = write_hdr_lit(&colours);
        assert_eq!(&file[..12], b"QLIT\x01\0\x01\0\0\0\0\0");
        assert_eq!(file.len(), 8 + 4 * 3);
        assert_eq!(read_hdr_lit(&file).unwrap(), colours);
        assert!(matches!(read_lit(&file), Err(Error::Unsupported(_))));
        assert!(matches!(read_hdr_lit(&write_lit(&[0; 12])), Err(Error::Unsupported(_))));
        assert!(matches!(read_hdr_lit(&file[..19]), Err(Error::Format { .. })));
    }

    #[test]
    fn damaged_lits_are_errors() {
        for file in [&b""[..], b"QLIT", b"TILQ\x01\0\0\0", b"QLIT\x01\0\0\0ab"] {
            assert!(matches!(read_lit(file), Err(Error::Format { .. })), "{file:?}");
        }
        assert!(matches!(read_lit(b"QLIT\x02\0\0\0"), Err(Error::Unsupported(_))));
    }
}
