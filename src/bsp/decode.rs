//! Lump bytes to records, for the three record layouts.

use super::cursor::Cursor;
use super::header::Lump;
use super::records::{Face, Format, Leaf, Model, Node, Plane, TexInfo};
use crate::{Error, Result};
use glam::Vec3;

/// Bytes of one record of a lump in a format; `None` for lumps without records.
pub(crate) fn record_size(format: Format, lump: Lump) -> Option<usize> {
    let [bsp29, two_psb, bsp2] = match lump {
        Lump::Planes => [20; 3],
        Lump::Vertices => [12; 3],
        Lump::Nodes => [24, 32, 44],
        Lump::TexInfos => [40; 3],
        Lump::Faces => [20, 28, 28],
        Lump::ClipNodes => [8, 12, 12],
        Lump::Leafs => [28, 32, 44],
        Lump::MarkSurfaces => [2, 4, 4],
        Lump::Edges => [4, 8, 8],
        Lump::SurfEdges => [4; 3],
        Lump::Models => [64; 3],
        Lump::Entities | Lump::Textures | Lump::Visibility | Lump::Lighting => return None,
    };
    Some(match format {
        Format::Bsp29 => bsp29,
        Format::TwoPsb => two_psb,
        Format::Bsp2 => bsp2,
    })
}

/// Fails unless a lump holds whole records; returns the size of one.
pub(crate) fn check_size(format: Format, lump: Lump, bytes: &[u8]) -> Result<usize> {
    let size = record_size(format, lump).expect("only lumps with records are checked");
    if bytes.len().is_multiple_of(size) {
        return Ok(size);
    }
    Err(Error::format(
        format!("{} lump", lump.name()),
        format!(
            "its length {} is no multiple of the record size {size}: the file is damaged",
            bytes.len()
        ),
    ))
}

/// Splits a lump into its records and decodes each.
fn records<T>(
    format: Format,
    lump: Lump,
    bytes: &[u8],
    decode: impl Fn(&mut Cursor<'_>, usize) -> Result<T>,
) -> Result<Vec<T>> {
    let size = check_size(format, lump, bytes)?;
    let records = bytes.chunks_exact(size).enumerate();
    records.map(|(index, record)| decode(&mut Cursor::new(record, lump.name()), index)).collect()
}

/// A count or index stored as a signed 32-bit number that must not be negative.
fn unsigned(value: i32, lump: Lump, index: usize, field: &str) -> Result<u32> {
    u32::try_from(value).map_err(|_| {
        Error::format(
            format!("{} lump, record {index}", lump.name()),
            format!("{field} is {value}, it cannot be negative: the file is damaged"),
        )
    })
}

/// Skips a bounding box: 16-bit in BSP29 and 2PSB, float in BSP2.
fn skip_bounds(cursor: &mut Cursor<'_>, format: Format) -> Result<()> {
    cursor.take(if format == Format::Bsp2 { 24 } else { 12 }).map(|_| ())
}

pub(crate) fn planes(format: Format, bytes: &[u8]) -> Result<Vec<Plane>> {
    records(format, Lump::Planes, bytes, |cursor, _| {
        Ok(Plane { normal: cursor.vec3()?, dist: cursor.f32()?, kind: cursor.i32()? })
    })
}

pub(crate) fn vertices(format: Format, bytes: &[u8]) -> Result<Vec<Vec3>> {
    records(format, Lump::Vertices, bytes, |cursor, _| cursor.vec3())
}

pub(crate) fn nodes(format: Format, bytes: &[u8]) -> Result<Vec<Node>> {
    let lump = Lump::Nodes;
    records(format, lump, bytes, |cursor, index| {
        let plane = unsigned(cursor.i32()?, lump, index, "plane")?;
        let children = match format {
            Format::Bsp29 => [i32::from(cursor.i16()?), i32::from(cursor.i16()?)],
            Format::Bsp2 | Format::TwoPsb => [cursor.i32()?, cursor.i32()?],
        };
        Ok(Node { plane, children })
    })
}

pub(crate) fn texinfos(format: Format, bytes: &[u8]) -> Result<Vec<TexInfo>> {
    records(format, Lump::TexInfos, bytes, |cursor, _| {
        let (s, t) = (cursor.vec4()?, cursor.vec4()?);
        Ok(TexInfo { s, t, miptex: cursor.i32()?, flags: cursor.i32()? })
    })
}

pub(crate) fn faces(format: Format, bytes: &[u8]) -> Result<Vec<Face>> {
    let lump = Lump::Faces;
    records(format, lump, bytes, |cursor, index| {
        let (plane, side, first_edge, edge_count, texinfo) = if format == Format::Bsp29 {
            let (plane, side) = (cursor.u16()?.into(), cursor.u16()?.into());
            (plane, side, cursor.i32()?, cursor.u16()?.into(), cursor.u16()?.into())
        } else {
            let (plane, side) = (unsigned(cursor.i32()?, lump, index, "plane")?, cursor.i32()?);
            let (first, count) = (cursor.i32()?, cursor.i32()?);
            (plane, side, first, unsigned(count, lump, index, "edge count")?, cursor.i32()?)
        };
        let first_edge = unsigned(first_edge, lump, index, "first surfedge")?;
        let styles = cursor.u32()?.to_le_bytes();
        let light_offset = cursor.i32()?;
        Ok(Face { plane, side, first_edge, edge_count, texinfo, styles, light_offset })
    })
}

pub(crate) fn leafs(format: Format, bytes: &[u8]) -> Result<Vec<Leaf>> {
    records(format, Lump::Leafs, bytes, |cursor, _| {
        let (contents, vis_offset) = (cursor.i32()?, cursor.i32()?);
        skip_bounds(cursor, format)?;
        let (first_mark, mark_count) = match format {
            Format::Bsp29 => (cursor.u16()?.into(), cursor.u16()?.into()),
            Format::Bsp2 | Format::TwoPsb => (cursor.u32()?, cursor.u32()?),
        };
        Ok(Leaf { contents, vis_offset, first_mark, mark_count })
    })
}

pub(crate) fn mark_surfaces(format: Format, bytes: &[u8]) -> Result<Vec<u32>> {
    records(format, Lump::MarkSurfaces, bytes, |cursor, _| match format {
        Format::Bsp29 => cursor.u16().map(u32::from),
        Format::Bsp2 | Format::TwoPsb => cursor.u32(),
    })
}

pub(crate) fn edges(format: Format, bytes: &[u8]) -> Result<Vec<[u32; 2]>> {
    records(format, Lump::Edges, bytes, |cursor, _| match format {
        Format::Bsp29 => Ok([cursor.u16()?.into(), cursor.u16()?.into()]),
        Format::Bsp2 | Format::TwoPsb => Ok([cursor.u32()?, cursor.u32()?]),
    })
}

pub(crate) fn surf_edges(format: Format, bytes: &[u8]) -> Result<Vec<i32>> {
    records(format, Lump::SurfEdges, bytes, |cursor, _| cursor.i32())
}

pub(crate) fn models(format: Format, bytes: &[u8]) -> Result<Vec<Model>> {
    let lump = Lump::Models;
    // Hexen II shares the ident but has eight hulls, 80 bytes a model.
    if bytes.len().is_multiple_of(80) && !bytes.len().is_multiple_of(64) {
        return Err(Error::Unsupported(
            "this is a Hexen II BSP (80-byte models); qrad lights Quake maps only".to_owned(),
        ));
    }
    records(format, lump, bytes, |cursor, index| {
        let (mins, maxs) = (cursor.vec3()?, cursor.vec3()?);
        let _origin = cursor.vec3()?;
        let head_node = cursor.i32()?;
        let _clip_hulls = cursor.take(12)?;
        let vis_leafs = unsigned(cursor.i32()?, lump, index, "vis leaf count")?;
        let first_face = unsigned(cursor.i32()?, lump, index, "first face")?;
        let face_count = unsigned(cursor.i32()?, lump, index, "face count")?;
        Ok(Model { mins, maxs, head_node, vis_leafs, first_face, face_count })
    })
}
