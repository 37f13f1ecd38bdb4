//! Transfers as plain bytes, to keep them from one run to the next.

use super::{CHUNK, Chunk, Transfers};
use byteorder::{ByteOrder, LittleEndian, ReadBytesExt, WriteBytesExt};
use std::io;

impl Transfers {
    /// All rows as bytes, which [`from_bytes`](Self::from_bytes) reads; without what an overlay adds.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        put(&mut bytes, &self.row_of, LittleEndian::write_u32_into);
        put_length(&mut bytes, self.chunks.len());
        for chunk in &self.chunks {
            put(&mut bytes, &chunk.openness, LittleEndian::write_f32_into);
            put(&mut bytes, &chunk.ends, LittleEndian::write_u32_into);
            put(&mut bytes, &chunk.columns, LittleEndian::write_u32_into);
            put(&mut bytes, &chunk.weights, LittleEndian::write_f32_into);
        }
        bytes
    }

    /// The rows between `patches` patches, if these are bytes of such rows.
    pub fn from_bytes(mut bytes: &[u8], patches: usize) -> Option<Self> {
        let transfers = read(&mut bytes).ok()?;
        (bytes.is_empty() && transfers.is_whole(patches)).then_some(transfers)
    }

    /// Whether every index is that of something that is there.
    fn is_whole(&self, patches: usize) -> bool {
        let rows_of = |chunk: &Chunk| {
            let ends = &chunk.ends;
            ends.len() <= CHUNK
                && ends.len() == chunk.openness.len()
                && ends.is_sorted()
                && ends.last().copied().unwrap_or(0) as usize == chunk.columns.len()
                && chunk.columns.len() == chunk.weights.len()
                && chunk.columns.iter().all(|&c| (c as usize) < patches)
                && chunk.weights.iter().all(|w| w.is_finite())
        };
        let is_row = |&at: &u32| {
            let chunk = self.chunks.get(at as usize / CHUNK);
            chunk.is_some_and(|c| at as usize % CHUNK < c.ends.len())
        };
        self.row_of.len() == patches
            && self.chunks.iter().all(rows_of)
            && self.row_of.iter().all(is_row)
    }
}

fn put_length(bytes: &mut Vec<u8>, length: usize) {
    bytes.write_u64::<LittleEndian>(length as u64).expect("memory takes all");
}

/// Appends a list of numbers of four bytes each, after its length.
fn put<T>(bytes: &mut Vec<u8>, values: &[T], write: fn(&[T], &mut [u8])) {
    put_length(bytes, values.len());
    let from = bytes.len();
    bytes.resize(from + 4 * values.len(), 0);
    write(values, &mut bytes[from..]);
}

fn read(bytes: &mut &[u8]) -> io::Result<Transfers> {
    let row_of = get(bytes, LittleEndian::read_u32_into)?;
    let mut chunks = Vec::new();
    for _ in 0..bytes.read_u64::<LittleEndian>()? {
        chunks.push(Chunk {
            openness: get(bytes, LittleEndian::read_f32_into)?,
            ends: get(bytes, LittleEndian::read_u32_into)?,
            columns: get(bytes, LittleEndian::read_u32_into)?,
            weights: get(bytes, LittleEndian::read_f32_into)?,
            overlay: Vec::new(),
        });
    }
    Ok(Transfers { chunks, row_of, drawn: 0 })
}

fn get<T: Clone + Default>(bytes: &mut &[u8], read: fn(&[u8], &mut [T])) -> io::Result<Vec<T>> {
    let length = bytes.read_u64::<LittleEndian>()?;
    let size = length.checked_mul(4).filter(|&size| size <= bytes.len() as u64);
    let size = size.ok_or(io::ErrorKind::UnexpectedEof)? as usize;
    let (own, rest) = bytes.split_at(size);
    *bytes = rest;
    let mut values = vec![T::default(); size / 4];
    read(own, &mut values);
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patch::PatchId;

    fn transfers() -> Transfers {
        let mut chunk = Chunk::default();
        chunk.push(&[(PatchId(1), 0.25), (PatchId(2), 0.5)], 8.0);
        chunk.push(&[], f32::INFINITY);
        chunk.push(&[(PatchId(0), 1.0)], 2.0);
        Transfers { chunks: vec![chunk], row_of: vec![0, 1, 2, 2], drawn: 3 }
    }

    #[test]
    fn rows_come_back_as_they_were() {
        let (rows, bytes) = (transfers(), transfers().to_bytes());
        let back = Transfers::from_bytes(&bytes, 4).unwrap();
        assert_eq!((back.to_bytes(), back.drawn()), (bytes, 0));
        for i in 0..4 {
            assert_eq!((back.row(i), back.openness(i)), (rows.row(i), rows.openness(i)));
        }
    }

    #[test]
    fn damaged_bytes_are_none_or_whole_rows_and_never_a_panic() {
        let bytes = transfers().to_bytes();
        assert!(Transfers::from_bytes(&bytes, 5).is_none());
        for length in 0..bytes.len() {
            assert!(Transfers::from_bytes(&bytes[..length], 4).is_none(), "{length} bytes");
        }
        for at in 0..bytes.len() {
            for value in [0, 1, 2, 0x7f, 0x80, 0xff] {
                let mut bytes = bytes.clone();
                bytes[at] = value;
                if let Some(rows) = Transfers::from_bytes(&bytes, 4) {
                    let seen = (0..4).flat_map(|i| rows.row(i).0.iter().copied());
                    assert!(seen.max().unwrap_or(0) < 4);
                }
            }
        }
    }
}
