//! BSPX: named lumps appended to a BSP file.

use super::cursor::Cursor;
use crate::{Error, Result};
use byteorder::{LittleEndian, WriteBytesExt};
use std::collections::HashMap;

const MAGIC: &[u8; 4] = b"BSPX";
const NAME_SIZE: usize = 24;
const ENTRY_SIZE: usize = NAME_SIZE + 8;

/// Lumps that hold or describe lighting, which a new lighting makes stale.
pub const LIGHTING_LUMPS: [&str; 10] = [
    "RGBLIGHTING",
    "LIGHTING_E5BGR9",
    "LIGHTINGDIR",
    "FACENORMALS",
    "LMSTYLE",
    "LMSTYLE16",
    "LMOFFSET",
    "DECOUPLED_LM",
    "LIGHTGRID_OCTREE",
    "LIGHTGRIDS",
];

/// One BSPX lump.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BspxLump {
    /// Name, at most 24 bytes; each byte of the file is one char (Latin-1).
    pub name: String,
    /// Contents.
    pub data: Vec<u8>,
}

/// Reads the BSPX section of `file`, whose last ordinary lump ends at `end`.
///
/// A section that is damaged ends the reading with a warning, as engines do; of two lumps with the
/// same name the later one stays.
pub(crate) fn read(file: &[u8], end: usize) -> Vec<BspxLump> {
    let mut lumps: Vec<BspxLump> = Vec::new();
    let mut place_of: HashMap<String, usize> = HashMap::new();
    let start = end.next_multiple_of(4);
    let Some(section) = file.get(start..).filter(|section| !section.is_empty()) else {
        return lumps;
    };
    if !section.starts_with(MAGIC) {
        log::warn!("{} bytes after the last lump are no BSPX section: dropped", section.len());
        return lumps;
    }
    let mut cursor = Cursor::new(&section[MAGIC.len()..], "BSPX directory");
    let count = cursor.u32().unwrap_or(0);
    // Lumps may overlap in a damaged file; this keeps their copies from eating all memory.
    let mut budget = file.len().saturating_mul(4);
    for index in 0..count {
        let lump = read_entry(file, &mut cursor).ok().filter(|lump| lump.data.len() <= budget);
        let Some(lump) = lump else {
            log::warn!(
                "BSPX lump {index} of {count} is not inside the file: it and the rest are dropped"
            );
            break;
        };
        budget -= lump.data.len();
        match place_of.get(&lump.name) {
            Some(&place) => lumps[place] = lump,
            None => {
                place_of.insert(lump.name.clone(), lumps.len());
                lumps.push(lump);
            }
        }
    }
    lumps
}

fn read_entry(file: &[u8], cursor: &mut Cursor<'_>) -> Result<BspxLump> {
    let name = cursor.take(NAME_SIZE)?.split(|&byte| byte == 0).next().unwrap_or_default();
    let (offset, length) = (cursor.u32()? as usize, cursor.u32()? as usize);
    let data = offset.checked_add(length).and_then(|end| file.get(offset..end));
    let data = data.ok_or_else(|| Error::format("BSPX directory", "lump outside the file"))?;
    Ok(BspxLump { name: name.iter().copied().map(char::from).collect(), data: data.to_vec() })
}

/// Appends the BSPX section to a file whose length is a multiple of 4. No lumps, no section.
pub(crate) fn append(file: &mut Vec<u8>, lumps: &[BspxLump]) -> Result<()> {
    if lumps.is_empty() {
        return Ok(());
    }
    let directory = file.len() + MAGIC.len() + 4;
    file.extend_from_slice(MAGIC);
    push_u32(file, lumps.len())?;
    file.resize(directory + ENTRY_SIZE * lumps.len(), 0);
    for (index, lump) in lumps.iter().enumerate() {
        let mut entry = encode_name(&lump.name)?;
        push_u32(&mut entry, file.len())?;
        push_u32(&mut entry, lump.data.len())?;
        let at = directory + ENTRY_SIZE * index;
        file[at..at + ENTRY_SIZE].copy_from_slice(&entry);
        file.extend_from_slice(&lump.data);
        file.resize(file.len().next_multiple_of(4), 0);
    }
    Ok(())
}

fn encode_name(name: &str) -> Result<Vec<u8>> {
    let bytes: Option<Vec<u8>> = name.chars().map(|c| u8::try_from(u32::from(c)).ok()).collect();
    let bytes = bytes.filter(|bytes| bytes.len() <= NAME_SIZE && !bytes.contains(&0));
    let Some(mut bytes) = bytes else {
        return Err(Error::format(
            format!("BSPX lump {name:?}"),
            "the name must be at most 24 Latin-1 characters",
        ));
    };
    bytes.resize(NAME_SIZE, 0);
    Ok(bytes)
}

/// Appends a size or offset; BSP files end at 2 GiB because the header's numbers are signed.
pub(crate) fn push_u32(out: &mut Vec<u8>, value: usize) -> Result<()> {
    let checked = i32::try_from(value).map_err(|_| Error::Limit {
        what: "size of the BSP file in bytes".to_owned(),
        value: value as u64,
        limit: i32::MAX as u64,
        advice: "make the map smaller or its luxels larger",
    })?;
    out.write_i32::<LittleEndian>(checked).expect("writing to memory cannot fail");
    Ok(())
}
