//! Records to lump bytes.

use super::header::Lump;
use super::records::{Face, Format};
use crate::{Error, Result};
use byteorder::{ByteOrder, LittleEndian};
use glam::Vec3;

/// Little-endian appending with range checks for the fields of one record.
pub(crate) struct Record<'a> {
    out: &'a mut Vec<u8>,
    lump: Lump,
    index: usize,
}

impl<'a> Record<'a> {
    /// A record of `lump` to be appended to `out`.
    pub(crate) fn new(out: &'a mut Vec<u8>, lump: Lump, index: usize) -> Self {
        Self { out, lump, index }
    }

    /// Appends bytes as they are.
    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        self.out.extend_from_slice(bytes);
    }

    pub(crate) fn i32(&mut self, value: i32) {
        let mut bytes = [0; 4];
        LittleEndian::write_i32(&mut bytes, value);
        self.bytes(&bytes);
    }

    pub(crate) fn f32(&mut self, value: f32) {
        self.bytes(&value.to_le_bytes());
    }

    pub(crate) fn vec3(&mut self, value: Vec3) {
        for number in value.to_array() {
            self.f32(number);
        }
    }

    /// An unsigned field: 16 bits in BSP29, otherwise 31 bits.
    pub(crate) fn index(&mut self, format: Format, field: &str, value: i64) -> Result<()> {
        let limit: i64 = if format == Format::Bsp29 { 0xFFFF } else { 0x7FFF_FFFF };
        if !(0..=limit).contains(&value) {
            return Err(self.too_large(field, value, limit));
        }
        if format == Format::Bsp29 {
            let mut bytes = [0; 2];
            LittleEndian::write_u16(&mut bytes, value as u16);
            self.bytes(&bytes);
        } else {
            self.i32(value as i32);
        }
        Ok(())
    }

    /// A field of 31 bits in every format.
    pub(crate) fn wide(&mut self, field: &str, value: u32) -> Result<()> {
        let checked = i32::try_from(value);
        let checked = checked.map_err(|_| self.too_large(field, value.into(), i32::MAX.into()))?;
        self.i32(checked);
        Ok(())
    }

    /// The error for a field that does not fit.
    pub(crate) fn too_large(&self, field: &str, value: i64, limit: i64) -> Error {
        Error::format(
            format!("{} lump, record {}", self.lump.name(), self.index),
            format!("{field} {value} does not fit the format (0 to {limit}): compile as BSP2"),
        )
    }
}

/// The faces lump.
pub(crate) fn faces(format: Format, faces: &[Face]) -> Result<Vec<u8>> {
    let mut out = Vec::with_capacity(faces.len() * 28);
    for (index, face) in faces.iter().enumerate() {
        let mut record = Record::new(&mut out, Lump::Faces, index);
        record.index(format, "plane", face.plane.into())?;
        if format == Format::Bsp29 {
            record.index(format, "side", face.side.into())?;
        } else {
            record.i32(face.side);
        }
        record.wide("first surfedge", face.first_edge)?;
        record.index(format, "edge count", face.edge_count.into())?;
        if format == Format::Bsp29 {
            record.index(format, "texinfo", face.texinfo.into())?;
        } else {
            record.i32(face.texinfo);
        }
        record.bytes(&face.styles);
        record.i32(face.light_offset);
    }
    Ok(out)
}
