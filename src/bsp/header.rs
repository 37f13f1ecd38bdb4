//! The BSP header: ident and the table of 15 lumps.

use super::cursor::Cursor;
use super::records::Format;
use crate::{Error, Result};

/// Number of lumps.
pub(crate) const LUMP_COUNT: usize = 15;
/// Bytes of ident and lump table.
pub(crate) const HEADER_SIZE: usize = 4 + 8 * LUMP_COUNT;

/// The lumps, by their place in the header's table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lump {
    Entities,
    Planes,
    Textures,
    Vertices,
    Visibility,
    Nodes,
    TexInfos,
    Faces,
    Lighting,
    ClipNodes,
    Leafs,
    MarkSurfaces,
    Edges,
    SurfEdges,
    Models,
}

impl Lump {
    /// All lumps in the order in which their bytes follow each other in a written file.
    pub(crate) const PHYSICAL_ORDER: [Self; LUMP_COUNT] = [
        Self::Planes,
        Self::Leafs,
        Self::Vertices,
        Self::Nodes,
        Self::TexInfos,
        Self::Faces,
        Self::ClipNodes,
        Self::MarkSurfaces,
        Self::SurfEdges,
        Self::Edges,
        Self::Models,
        Self::Lighting,
        Self::Visibility,
        Self::Entities,
        Self::Textures,
    ];

    /// Name in messages.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Entities => "entities",
            Self::Planes => "planes",
            Self::Textures => "textures",
            Self::Vertices => "vertices",
            Self::Visibility => "visibility",
            Self::Nodes => "nodes",
            Self::TexInfos => "texinfo",
            Self::Faces => "faces",
            Self::Lighting => "lighting",
            Self::ClipNodes => "clipnodes",
            Self::Leafs => "leafs",
            Self::MarkSurfaces => "marksurfaces",
            Self::Edges => "edges",
            Self::SurfEdges => "surfedges",
            Self::Models => "models",
        }
    }
}

/// The ident of a format.
pub(crate) fn ident(format: Format) -> [u8; 4] {
    match format {
        Format::Bsp29 => [29, 0, 0, 0],
        Format::Bsp2 => *b"BSP2",
        Format::TwoPsb => *b"2PSB",
    }
}

/// Tells the format from the ident.
fn format_of(ident: [u8; 4]) -> Result<Format> {
    for format in [Format::Bsp29, Format::Bsp2, Format::TwoPsb] {
        if ident == self::ident(format) {
            return Ok(format);
        }
    }
    let other = match &ident {
        [30, 0, 0, 0] => "a Half-Life BSP (version 30)",
        [28, 0, 0, 0] => "a BSP of the Quake test release (version 28)",
        b"IBSP" => "a Quake II or Quake III BSP (IBSP)",
        b"QBSP" => "a Qbism Quake II BSP (QBSP)",
        b"RBSP" => "a Raven BSP (RBSP)",
        b"VBSP" => "a Source BSP (VBSP)",
        _ => {
            return Err(Error::format(
                "BSP header",
                format!("{ident:02X?} is no ident of a BSP: give a compiled Quake map"),
            ));
        }
    };
    Err(Error::Unsupported(format!(
        "this is {other}; qrad lights Quake maps only (BSP29, BSP2, 2PSB)"
    )))
}

/// Where each lump's bytes are in a file, checked to lie inside it.
#[derive(Debug)]
pub(crate) struct Header<'a> {
    pub(crate) format: Format,
    lumps: [&'a [u8]; LUMP_COUNT],
    /// End of the last byte that any lump uses.
    pub(crate) end: usize,
    /// Start, end and name of every stretch in use, by start.
    used: Vec<(usize, usize, &'static str)>,
}

impl<'a> Header<'a> {
    /// Reads ident and lump table.
    pub(crate) fn read(file: &'a [u8]) -> Result<Self> {
        let mut cursor = Cursor::new(file, "BSP header");
        let format = format_of(cursor.u32()?.to_le_bytes())?;
        let mut lumps: [&[u8]; LUMP_COUNT] = [&[]; LUMP_COUNT];
        let mut end = HEADER_SIZE;
        let mut used = vec![(0, HEADER_SIZE, "header")];
        let mut names = Lump::PHYSICAL_ORDER;
        names.sort_by_key(|&lump| lump as usize);
        for lump in names {
            let (offset, length) = (cursor.i32()?, cursor.i32()?);
            if length == 0 {
                continue;
            }
            let range = usize::try_from(offset)
                .ok()
                .zip(usize::try_from(length).ok())
                .and_then(|(start, length)| Some(start..start.checked_add(length)?))
                .filter(|range| range.end <= file.len());
            let Some(range) = range else {
                return Err(Error::format(
                    format!("{} lump", lump.name()),
                    format!(
                        "{length} bytes at offset {offset} are not inside the file of {} bytes: it is cut off or damaged",
                        file.len()
                    ),
                ));
            };
            end = end.max(range.end);
            lumps[lump as usize] = &file[range.clone()];
            used.push((range.start, range.end, lump.name()));
        }
        used.sort_unstable();
        Ok(Self { format, lumps, end, used })
    }

    /// Fails if two lumps, or one and the header, have bytes in common.
    pub(crate) fn check_overlaps(&self) -> Result<()> {
        for pair in self.used.windows(2) {
            let [(_, end, before), (start, _, after)] = *pair else { continue };
            if start < end {
                return Err(Error::format(
                    format!("{after} lump"),
                    format!(
                        "it begins at {start}, before the end of the {before} at {end}: the file is damaged"
                    ),
                ));
            }
        }
        Ok(())
    }

    /// Bytes of a lump.
    pub(crate) fn lump(&self, lump: Lump) -> &'a [u8] {
        self.lumps[lump as usize]
    }
}
