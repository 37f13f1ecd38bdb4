//! `.lit` files, version 1: the colours of a lighting lump, kept beside the BSP.

use super::cursor::Cursor;
use crate::{Error, Result};

const MAGIC: &[u8; 4] = b"QLIT";
const VERSION: i32 = 1;

/// Bytes of a `.lit` file for `rgb`, three bytes for each byte of the lighting lump: those of lump byte
/// `k` are at `3 * k` here and at `8 + 3 * k` in the file.
pub fn write_lit(rgb: &[u8]) -> Vec<u8> {
    [&MAGIC[..], &VERSION.to_le_bytes(), rgb].concat()
}

/// The colours of a `.lit` file, see [`write_lit`].
///
/// # Errors
/// If the file is no `.lit`, of another version, or does not hold whole colours.
pub fn read_lit(file: &[u8]) -> Result<Vec<u8>> {
    let mut cursor = Cursor::new(file, ".lit header");
    if cursor.take(4)? != MAGIC {
        return Err(Error::format(".lit header", "it does not begin with QLIT: not a .lit file"));
    }
    let version = cursor.i32()?;
    if version != VERSION {
        return Err(Error::Unsupported(format!(
            ".lit version {version:#x}, only version 1 is read"
        )));
    }
    let rgb = &file[8..];
    if !rgb.len().is_multiple_of(3) {
        return Err(Error::format(
            ".lit file",
            format!("{} bytes of colours are no multiple of 3: the file is cut off", rgb.len()),
        ));
    }
    Ok(rgb.to_vec())
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
    fn damaged_lits_are_errors() {
        for file in [&b""[..], b"QLIT", b"TILQ\x01\0\0\0", b"QLIT\x01\0\0\0ab"] {
            assert!(matches!(read_lit(file), Err(Error::Format { .. })), "{file:?}");
        }
        assert!(matches!(read_lit(b"QLIT\x02\0\0\0"), Err(Error::Unsupported(_))));
    }
}
