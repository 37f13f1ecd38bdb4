//! Transfers as plain bytes, to keep them from one run to the next.

use super::rows::{Chunk, Tile};
use super::weights::{Short, Weights};
use super::{CHUNK, Distances, Transfers};
use byteorder::{ByteOrder, LittleEndian, ReadBytesExt, WriteBytesExt};
use std::io;

/// How weights are kept.
const SINGLE: u8 = 4;
const SHORT: u8 = 2;

impl Transfers {
    /// All rows as bytes, which [`from_bytes`](Self::from_bytes) reads; without what an overlay adds.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        put(&mut bytes, &self.row_of, LittleEndian::write_u32_into);
        put(&mut bytes, &self.first_of, LittleEndian::write_u32_into);
        put_length(&mut bytes, self.shared);
        put_length(&mut bytes, self.chunks.len());
        for chunk in &self.chunks {
            let distances: Vec<f32> =
                chunk.distances.iter().flat_map(|d| [d.openness, d.nearest]).collect();
            put(&mut bytes, &distances, LittleEndian::write_f32_into);
            bytes.push(chunk.dense.into());
            put_length(&mut bytes, chunk.tiles.len());
            for tile in &chunk.tiles {
                put(&mut bytes, &tile.ends, LittleEndian::write_u32_into);
                put(&mut bytes, &tile.run_ends, LittleEndian::write_u32_into);
                put(&mut bytes, &tile.columns, LittleEndian::write_u16_into);
                put(&mut bytes, tile.runs.as_flattened(), LittleEndian::write_u16_into);
                match &tile.weights {
                    Weights::Single(weights) => {
                        bytes.push(SINGLE);
                        put(&mut bytes, weights, LittleEndian::write_f32_into);
                    }
                    Weights::Short(weights) => {
                        let weights: Vec<u16> = weights.iter().map(|w| w.0).collect();
                        bytes.push(SHORT);
                        put(&mut bytes, &weights, LittleEndian::write_u16_into);
                    }
                }
            }
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
        let are_rows = |chunk: &Chunk| {
            let numbers = |tile: &Tile| match &tile.weights {
                Weights::Single(weights) => weights.iter().all(|w| w.is_finite()),
                Weights::Short(_) => true,
            };
            chunk.rows() <= CHUNK && chunk.is_whole(patches) && chunk.tiles.iter().all(numbers)
        };
        let is_row = |&at: &u32| {
            let chunk = self.chunks.get(at as usize / CHUNK);
            chunk.is_some_and(|c| at as usize % CHUNK < c.rows())
        };
        self.row_of.len() == patches
            && self.first_of.len() == patches
            && self.first_of.iter().all(|&i| (i as usize) < patches)
            && self.chunks.iter().all(are_rows)
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
    let first_of = get(bytes, LittleEndian::read_u32_into)?;
    let shared = bytes.read_u64::<LittleEndian>()? as usize;
    let mut chunks = Vec::new();
    for _ in 0..bytes.read_u64::<LittleEndian>()? {
        let distances: Vec<f32> = get(bytes, LittleEndian::read_f32_into)?;
        let (distances, _) = distances.as_chunks::<2>();
        let distances =
            distances.iter().map(|&[openness, nearest]| Distances { openness, nearest }).collect();
        let dense = match bytes.read_u8()? {
            0 => false,
            1 => true,
            _ => return Err(io::ErrorKind::InvalidData.into()),
        };
        let tiles = (0..bytes.read_u64::<LittleEndian>()?).map(|_| read_tile(bytes));
        let tiles = tiles.collect::<io::Result<_>>()?;
        chunks.push(Chunk { distances, dense, tiles, overlay: Vec::new() });
    }
    Ok(Transfers { chunks, row_of, first_of, shared, ..Transfers::default() })
}

fn read_tile(bytes: &mut &[u8]) -> io::Result<Tile> {
    let ends = get(bytes, LittleEndian::read_u32_into)?;
    let run_ends = get(bytes, LittleEndian::read_u32_into)?;
    let columns = get(bytes, LittleEndian::read_u16_into)?;
    let runs: Vec<u16> = get(bytes, LittleEndian::read_u16_into)?;
    let weights = match bytes.read_u8()? {
        SINGLE => Weights::Single(get(bytes, LittleEndian::read_f32_into)?),
        SHORT => {
            let weights: Vec<u16> = get(bytes, LittleEndian::read_u16_into)?;
            Weights::Short(weights.into_iter().map(Short).collect())
        }
        _ => return Err(io::ErrorKind::InvalidData.into()),
    };
    Ok(Tile { ends, run_ends, columns, runs: runs.as_chunks().0.to_vec(), weights })
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
    use super::super::rows::Found;
    use super::super::weights::Precision;
    use super::*;
    use crate::patch::PatchId;

    const PATCHES: usize = 23;

    /// Rows of four patches; the first and the last see all of the others, if rows are to be dense.
    fn transfers(precision: Precision, dense: bool) -> Transfers {
        let mut rows = Found::new(precision);
        let distances = |openness, nearest| Distances { openness, nearest };
        let all: Vec<_> = (0..PATCHES as u32).map(|j| (PatchId(j), 1.0 / 32.0)).collect();
        let few = [(PatchId(1), 0.125), (PatchId(2), 0.0625)];
        rows.push(if dense { &all } else { &few }, distances(8.0, 1.0));
        rows.push(&[], distances(f32::INFINITY, f32::INFINITY));
        rows.push(if dense { &all[9..] } else { &few[1..] }, distances(2.0, 1.5));
        let rows = rows.keep();
        assert_eq!(rows.dense, dense);
        let row_of: Vec<u32> = (0..PATCHES as u32).map(|i| i.min(2)).collect();
        Transfers {
            chunks: vec![rows],
            first_of: row_of.clone(),
            row_of,
            shared: 1,
            ..Transfers::default()
        }
    }

    fn all_kinds() -> impl Iterator<Item = Transfers> {
        let kinds = [(false, false), (false, true), (true, false), (true, true)];
        kinds.into_iter().map(|(short, dense)| {
            transfers(if short { Precision::Short } else { Precision::Single }, dense)
        })
    }

    #[test]
    fn rows_come_back_as_they_were() {
        for rows in all_kinds() {
            let bytes = rows.to_bytes();
            let back = Transfers::from_bytes(&bytes, PATCHES).unwrap();
            assert_eq!((back.to_bytes(), back.drawn()), (bytes, 0));
            for i in 0..PATCHES {
                assert_eq!((back.row(i), back.distances(i)), (rows.row(i), rows.distances(i)));
                assert_eq!(
                    (back.first_of(i), back.is_shared(i)),
                    (rows.first_of(i), rows.is_shared(i))
                );
            }
        }
    }

    #[test]
    fn damaged_bytes_are_none_or_whole_rows_and_never_a_panic() {
        let light = [[1.0]; PATCHES];
        for rows in all_kinds() {
            let bytes = rows.to_bytes();
            assert!(Transfers::from_bytes(&bytes, PATCHES + 1).is_none());
            for length in 0..bytes.len() {
                let found = Transfers::from_bytes(&bytes[..length], PATCHES);
                assert!(found.is_none(), "{length} bytes");
            }
            for at in 0..bytes.len() {
                for value in [0, 1, 2, 3, 4, 0x7f, 0x80, 0xff] {
                    let mut bytes = bytes.clone();
                    bytes[at] = value;
                    if let Some(rows) = Transfers::from_bytes(&bytes, PATCHES) {
                        let seen = (0..PATCHES).flat_map(|i| rows.row(i).0);
                        assert!(seen.max().unwrap_or(0) < PATCHES as u32);
                        assert_eq!(rows.gather_all(&[&light])[0].len(), PATCHES);
                    }
                }
            }
        }
    }
}
