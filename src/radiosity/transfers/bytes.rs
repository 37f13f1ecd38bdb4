//! Transfers as plain bytes, to keep them from one run to the next.

use super::rows::Chunk;
use super::{CHUNK, Distances, Transfers};
use byteorder::{ByteOrder, LittleEndian, ReadBytesExt, WriteBytesExt};
use std::io;

impl Transfers {
    /// All rows as bytes, which [`from_bytes`](Self::from_bytes) reads; without what an overlay adds.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        put(&mut bytes, &self.row_of, LittleEndian::write_u32_into);
        put(&mut bytes, &self.drawn_at, LittleEndian::write_u32_into);
        put_length(&mut bytes, self.chunks.len());
        for chunk in &self.chunks {
            let distances: Vec<f32> =
                chunk.distances.iter().flat_map(|d| [d.openness, d.nearest]).collect();
            put(&mut bytes, &distances, LittleEndian::write_f32_into);
            put(&mut bytes, &chunk.ends, LittleEndian::write_u32_into);
            put(&mut bytes, &chunk.column_ends, LittleEndian::write_u32_into);
            put(&mut bytes, &chunk.columns, LittleEndian::write_u16_into);
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
            let rows = chunk.distances.len();
            let are_whole = |ends: &[u32], count: usize| {
                let last = ends.last().copied().unwrap_or(0) as usize;
                ends.len() == rows && ends.is_sorted() && last == count
            };
            rows <= CHUNK
                && are_whole(&chunk.ends, chunk.weights.len())
                && are_whole(&chunk.column_ends, chunk.columns.len())
                && (0..rows).all(|i| chunk.is_whole(i, patches))
                && chunk.weights.iter().all(|w| w.is_finite())
        };
        let is_row = |&at: &u32| {
            let chunk = self.chunks.get(at as usize / CHUNK);
            chunk.is_some_and(|c| at as usize % CHUNK < c.ends.len())
        };
        self.row_of.len() == patches
            && self.drawn_at.len() == patches
            && self.drawn_at.iter().all(|&i| (i as usize) < patches)
            && self.chunks.iter().all(rows_of)
            && self.row_of.iter().all(is_row)
    }
}

fn put_length(bytes: &mut Vec<u8>, length: usize) {
    bytes.write_u64::<LittleEndian>(length as u64).expect("memory takes all");
}

/// Appends a list of numbers after its length.
fn put<T>(bytes: &mut Vec<u8>, values: &[T], write: fn(&[T], &mut [u8])) {
    put_length(bytes, values.len());
    let from = bytes.len();
    bytes.resize(from + std::mem::size_of_val(values), 0);
    write(values, &mut bytes[from..]);
}

fn read(bytes: &mut &[u8]) -> io::Result<Transfers> {
    let row_of = get(bytes, LittleEndian::read_u32_into)?;
    let drawn_at = get(bytes, LittleEndian::read_u32_into)?;
    let mut chunks = Vec::new();
    for _ in 0..bytes.read_u64::<LittleEndian>()? {
        let distances: Vec<f32> = get(bytes, LittleEndian::read_f32_into)?;
        let (distances, _) = distances.as_chunks::<2>();
        chunks.push(Chunk {
            distances: distances
                .iter()
                .map(|&[openness, nearest]| Distances { openness, nearest })
                .collect(),
            ends: get(bytes, LittleEndian::read_u32_into)?,
            column_ends: get(bytes, LittleEndian::read_u32_into)?,
            columns: get(bytes, LittleEndian::read_u16_into)?,
            weights: get(bytes, LittleEndian::read_f32_into)?,
            overlay: Vec::new(),
        });
    }
    Ok(Transfers { chunks, row_of, drawn_at, ..Transfers::default() })
}

fn get<T: Clone + Default>(bytes: &mut &[u8], read: fn(&[u8], &mut [T])) -> io::Result<Vec<T>> {
    let length = bytes.read_u64::<LittleEndian>()?;
    let each = size_of::<T>();
    let size = length.checked_mul(each as u64).filter(|&size| size <= bytes.len() as u64);
    let size = size.ok_or(io::ErrorKind::UnexpectedEof)? as usize;
    let (own, rest) = bytes.split_at(size);
    *bytes = rest;
    let mut values = vec![T::default(); size / each];
    read(own, &mut values);
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patch::PatchId;

    fn transfers() -> Transfers {
        let mut chunk = Chunk::default();
        let distances = |openness, nearest| Distances { openness, nearest };
        chunk.push(&[(PatchId(1), 0.25), (PatchId(2), 0.5)], distances(8.0, 1.0));
        chunk.push(&[], distances(f32::INFINITY, f32::INFINITY));
        chunk.push(&[(PatchId(0), 1.0)], distances(2.0, 1.5));
        let (row_of, drawn_at) = (vec![0, 1, 2, 2], vec![0, 1, 2, 2]);
        Transfers { chunks: vec![chunk], row_of, drawn_at, drawn: 3, overlay: None }
    }

    #[test]
    fn rows_come_back_as_they_were() {
        let (rows, bytes) = (transfers(), transfers().to_bytes());
        let back = Transfers::from_bytes(&bytes, 4).unwrap();
        assert_eq!((back.to_bytes(), back.drawn()), (bytes, 0));
        for i in 0..4 {
            assert_eq!((back.row(i), back.distances(i)), (rows.row(i), rows.distances(i)));
            assert_eq!(back.drawn_at(i), rows.drawn_at(i));
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
                    let seen = (0..4).flat_map(|i| rows.row(i).0);
                    assert!(seen.max().unwrap_or(0) < 4);
                }
            }
        }
    }
}
