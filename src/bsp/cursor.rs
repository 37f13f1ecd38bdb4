//! A bounds-checked little-endian cursor: every read past the end is an error that names the place.

use crate::{Error, Result};
use byteorder::{ByteOrder, LittleEndian};
use glam::{Vec3, Vec4};

/// Reads numbers from a slice, in order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cursor<'a> {
    bytes: &'a [u8],
    position: usize,
    place: &'static str,
}

impl<'a> Cursor<'a> {
    /// Starts at the first byte; `place` names the bytes in errors.
    pub(crate) fn new(bytes: &'a [u8], place: &'static str) -> Self {
        Self { bytes, position: 0, place }
    }

    /// The next `count` bytes.
    pub(crate) fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let end = self.position.checked_add(count).filter(|&end| end <= self.bytes.len());
        let Some(end) = end else {
            return Err(Error::format(
                self.place,
                format!(
                    "{count} bytes wanted at offset {}, but it ends at {}: the file is cut off or damaged",
                    self.position,
                    self.bytes.len()
                ),
            ));
        };
        let taken = &self.bytes[self.position..end];
        self.position = end;
        Ok(taken)
    }

    pub(crate) fn u16(&mut self) -> Result<u16> {
        self.take(2).map(LittleEndian::read_u16)
    }

    pub(crate) fn i16(&mut self) -> Result<i16> {
        self.take(2).map(LittleEndian::read_i16)
    }

    pub(crate) fn u32(&mut self) -> Result<u32> {
        self.take(4).map(LittleEndian::read_u32)
    }

    pub(crate) fn i32(&mut self) -> Result<i32> {
        self.take(4).map(LittleEndian::read_i32)
    }

    pub(crate) fn f32(&mut self) -> Result<f32> {
        self.take(4).map(LittleEndian::read_f32)
    }

    pub(crate) fn vec3(&mut self) -> Result<Vec3> {
        Ok(Vec3::new(self.f32()?, self.f32()?, self.f32()?))
    }

    pub(crate) fn vec4(&mut self) -> Result<Vec4> {
        Ok(self.vec3()?.extend(self.f32()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_little_endian_and_stops_at_the_end() {
        let mut cursor = Cursor::new(&[1, 2, 0xFE, 0xFF, 9], "test bytes");
        assert_eq!(cursor.u16().unwrap(), 0x0201);
        assert_eq!(cursor.i16().unwrap(), -2);
        let message = cursor.u32().unwrap_err().to_string();
        assert!(message.contains("test bytes") && message.contains("offset 4"), "{message}");
        assert!(cursor.take(usize::MAX).is_err());
    }
}
