//! WAD2 archives of miptextures.
//!
//! `quake-util` reads the directory. It trusts the entry count and the lengths with its allocations,
//! and panics on miptextures of odd sizes, so the counts are checked here before it is called and the
//! records are read by [`MipTex::read`].

use super::cursor::Cursor;
use super::miptex::MipTex;
use crate::{Error, Result};
use quake_util::{lump, wad};

const ENTRY_SIZE: usize = 32;

/// The miptextures of a WAD2 file, by their offset in the file, named as its directory names them.
/// Miptextures that are damaged are left out with a warning.
///
/// # Errors
/// If the header or directory is damaged; `Unsupported` for WAD3 (Half-Life), whose textures have
/// palettes of their own.
pub fn load_wad(file: &[u8]) -> Result<Vec<MipTex>> {
    check_header(file)?;
    let damaged = |error| Error::format("WAD directory", format!("{error}: the file is damaged"));
    let mut reader = std::io::Cursor::new(file);
    let (parser, warnings) = wad::Parser::new(&mut reader).map_err(damaged)?;
    for warning in warnings {
        log::warn!("WAD directory: {warning}");
    }
    let mut entries: Vec<(String, wad::Entry)> = parser.directory().into_iter().collect();
    // The parser keeps a hash map: restore an order that is the same every time.
    entries.sort_by(|(a, x), (b, y)| x.offset().cmp(&y.offset()).then_with(|| a.cmp(b)));

    // Entries may overlap in a damaged file; this keeps their copies from eating all memory.
    let mut budget = file.len().saturating_mul(4);
    let mut textures = Vec::new();
    for (name, entry) in entries {
        if entry.kind() != lump::kind::MIPTEX {
            continue;
        }
        let start = entry.offset() as usize;
        let record =
            start.checked_add(entry.length() as usize).and_then(|end| file.get(start..end));
        let texture = record.and_then(|record| MipTex::read(record).ok());
        let size = texture.as_ref().and_then(|texture| texture.pixels.as_ref()).map_or(0, Vec::len);
        match (texture, budget.checked_sub(size)) {
            (Some(texture), Some(rest)) => {
                budget = rest;
                textures.push(MipTex { name, ..texture });
            }
            _ => log::warn!("WAD texture {name} at offset {start} is damaged: left out"),
        }
    }
    Ok(textures)
}

/// Checks what `quake-util` takes on trust.
fn check_header(file: &[u8]) -> Result<()> {
    let mut cursor = Cursor::new(file, "WAD header");
    match cursor.take(4)? {
        b"WAD2" => {}
        b"WAD3" => {
            return Err(Error::Unsupported(
                "this is a WAD3 (Half-Life) file; give a WAD2 (Quake) file".to_owned(),
            ));
        }
        other => {
            let problem = format!("{other:02X?} is not WAD2: give a Quake WAD file");
            return Err(Error::format("WAD header", problem));
        }
    }
    let (count, offset) = (cursor.u32()? as usize, cursor.u32()? as usize);
    let room = file.len().saturating_sub(offset) / ENTRY_SIZE;
    if count > room {
        return Err(Error::format(
            "WAD header",
            format!(
                "it claims {count} entries at offset {offset} but has room for {room}: the file is damaged"
            ),
        ));
    }
    Ok(())
}

/// The texture called `name`, ASCII case ignored.
pub fn find_texture<'a>(textures: &'a [MipTex], name: &str) -> Option<&'a MipTex> {
    textures.iter().find(|texture| texture.name.eq_ignore_ascii_case(name))
}
