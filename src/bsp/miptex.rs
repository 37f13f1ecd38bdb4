//! The texture lump: miptextures with 8-bit palette indices.

use super::cursor::Cursor;
use crate::{Error, Result};

/// Bytes before a miptexture's pixels: name, size, four mip offsets.
pub(crate) const MIPTEX_HEADER: usize = 40;

/// A texture: its name, its size and, if the file holds them, the texels of its first mip.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MipTex {
    /// Name up to the first NUL; bytes that are no UTF-8 become U+FFFD.
    pub name: String,
    /// Columns, as the file says (may be 0 in a damaged file).
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Palette indices, row by row, `width * height` of them and at least one; `None` for a header
    /// without pixels.
    pub pixels: Option<Vec<u8>>,
}

impl MipTex {
    /// Reads a miptexture record, which may be followed by other bytes. Pixels that do not lie inside
    /// `record` are left out with a warning.
    ///
    /// # Errors
    /// If `record` is shorter than the 40-byte header.
    pub fn read(record: &[u8]) -> Result<Self> {
        let mut cursor = Cursor::new(record, "miptexture header");
        let name = cursor.take(16)?.split(|&byte| byte == 0).next().unwrap_or_default();
        let name = String::from_utf8_lossy(name).into_owned();
        let (width, height) = (cursor.u32()?, cursor.u32()?);
        let offset = cursor.i32()?;
        let _smaller_mips = cursor.take(12)?;
        let pixels = if offset <= 0 {
            None
        } else {
            let pixels = texels(record, offset, width, height);
            if pixels.is_none() {
                log::warn!(
                    "texture {name}: {width} x {height} texels at offset {offset} are not inside its {} bytes: treated as a texture without pixels",
                    record.len()
                );
            }
            pixels
        };
        Ok(Self { name, width, height, pixels })
    }
}

fn texels(record: &[u8], offset: i32, width: u32, height: u32) -> Option<Vec<u8>> {
    let start = usize::try_from(offset).ok().filter(|&start| start >= MIPTEX_HEADER)?;
    let size = usize::try_from(u64::from(width).checked_mul(u64::from(height))?).ok()?;
    let texels = record.get(start..start.checked_add(size)?)?;
    (!texels.is_empty()).then(|| texels.to_vec())
}

/// Reads the texture lump. A texture with offset -1 is absent: `None`.
///
/// # Errors
/// If the table of offsets or a texture's header lies outside the lump, or textures share their bytes
/// so often that the copies would be many times the lump.
pub(crate) fn read_lump(lump: &[u8]) -> Result<Vec<Option<MipTex>>> {
    if lump.is_empty() {
        return Ok(Vec::new());
    }
    let mut cursor = Cursor::new(lump, "textures lump");
    let count = cursor.i32()?;
    let room = (lump.len() - 4) / 4;
    if !usize::try_from(count).is_ok_and(|count| count <= room) {
        return Err(Error::format(
            "textures lump",
            format!("it claims {count} textures but has room for {room}: the file is damaged"),
        ));
    }
    let mut budget = lump.len().saturating_mul(4);
    let mut textures = Vec::new();
    for index in 0..count {
        let offset = cursor.i32()?;
        if offset < 0 {
            textures.push(None);
            continue;
        }
        let place = || format!("textures lump, texture {index}");
        let record = lump.get(offset as usize..).filter(|record| record.len() >= MIPTEX_HEADER);
        let record = record.ok_or_else(|| {
            let problem = format!(
                "its header at offset {offset} is not inside the lump of {} bytes: the file is damaged",
                lump.len()
            );
            Error::format(place(), problem)
        })?;
        let texture = MipTex::read(record)?;
        let size = texture.pixels.as_ref().map_or(0, Vec::len);
        budget = budget.checked_sub(size).ok_or_else(|| {
            Error::format(place(), "textures overlap each other: the file is damaged")
        })?;
        textures.push(Some(texture));
    }
    Ok(textures)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(width: u32, height: u32, offset: i32, pixels: &[u8]) -> Vec<u8> {
        let mut bytes = b"brick\xFF\0junk......".to_vec();
        bytes.truncate(16);
        bytes.extend(width.to_le_bytes());
        bytes.extend(height.to_le_bytes());
        for mip in [offset, 0, 0, 0] {
            bytes.extend(mip.to_le_bytes());
        }
        bytes.extend(pixels);
        bytes
    }

    #[test]
    fn reads_name_size_and_pixels() {
        let texture = MipTex::read(&record(2, 1, 40, &[7, 8, 9])).unwrap();
        let pixels = Some(vec![7, 8]);
        assert_eq!(texture, MipTex { name: "brick\u{FFFD}".into(), width: 2, height: 1, pixels });
    }

    #[test]
    fn damaged_pixels_are_left_out() {
        for (width, height, offset) in [
            (2, 2, 40),
            (1, 1, 39),
            (1, 1, i32::MAX),
            (0, 1, 40),
            (u32::MAX, u32::MAX, 40),
            (1, 1, 0),
        ] {
            let texture = MipTex::read(&record(width, height, offset, &[1, 2, 3])).unwrap();
            assert_eq!(texture.pixels, None, "{width} x {height} at {offset}");
        }
        assert!(MipTex::read(&[0; 39]).is_err());
    }

    #[test]
    fn damaged_lumps_are_errors() {
        assert_eq!(read_lump(&[]).unwrap(), []);
        assert_eq!(read_lump(&[0; 4]).unwrap(), []);
        assert_eq!(read_lump(&[1, 0, 0, 0, 255, 255, 255, 255]).unwrap(), [None]);
        for lump in [&[1, 0][..], &[1, 0, 0, 0], &[255; 8], &[1, 0, 0, 0, 9, 0, 0, 0]] {
            assert!(read_lump(lump).is_err(), "{lump:?}");
        }
    }

    #[test]
    fn shared_pixels_cannot_multiply_memory() {
        let count = 64_u32;
        let mut lump = count.to_le_bytes().to_vec();
        for _ in 0..count {
            lump.extend((4 + 4 * count).to_le_bytes());
        }
        lump.extend(record(64, 64, 40, &[1; 4096]));
        assert!(read_lump(&lump).unwrap_err().to_string().contains("overlap"));
    }
}
