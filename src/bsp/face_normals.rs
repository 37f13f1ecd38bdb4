//! The `FACENORMALS` lump: normals and texture directions at the corners of faces (contract section
//! 1.7).

use glam::Vec3;
use std::collections::HashMap;

/// The lump for normal, tangent and bitangent at every corner of every face, in order: the number of
/// different vectors, the vectors, and three indices a corner.
///
/// # Panics
/// If there are more vectors than 32 bits can count.
pub fn write_face_normals(corners: impl IntoIterator<Item = [Vec3; 3]>) -> Vec<u8> {
    let mut places: HashMap<[u32; 3], u32> = HashMap::new();
    let (mut vectors, mut indices) = (Vec::new(), Vec::new());
    for vector in corners.into_iter().flatten() {
        // Adding 0 makes one zero of two.
        let vector = (vector + Vec3::ZERO).to_array();
        let place = *places.entry(vector.map(f32::to_bits)).or_insert_with(|| {
            vectors.extend(vector.iter().flat_map(|x| x.to_le_bytes()));
            u32::try_from(vectors.len() / 12 - 1).expect("a BSP file has fewer corners")
        });
        indices.extend(place.to_le_bytes());
    }
    [&(places.len() as u32).to_le_bytes()[..], &vectors, &indices].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_stored_once() {
        let lump = write_face_normals([[Vec3::Z, Vec3::X, Vec3::Y], [Vec3::Z, -Vec3::X, Vec3::Y]]);
        assert_eq!(lump.len(), 4 + 4 * 12 + 6 * 4);
        let word = |i: usize| u32::from_le_bytes(lump[4 * i..4 * i + 4].try_into().unwrap());
        assert_eq!(word(0), 4);
        assert_eq!([1, 2, 3].map(|i| f32::from_bits(word(i))), [0.0, 0.0, 1.0]);
        assert_eq!([13, 14, 15, 16, 17, 18].map(word), [0, 1, 2, 0, 3, 2]);
        assert_eq!(write_face_normals([[Vec3::ZERO, -Vec3::ZERO, Vec3::ZERO]]).len(), 4 + 12 + 12);
        assert_eq!(write_face_normals([]), [0; 4]);
    }
}
