//! How many luxels a face has, and where they lie in texture space.

use super::file::Bsp;
use super::records::TexInfo;
use crate::{Error, Result};
use glam::{Vec3, Vec4};

/// Most luxels along a side. Engines stop at 18; far more means damaged texture axes.
pub const MAX_LUXELS: u32 = 4096;

/// Luxels of a face. Luxel (i, j) is at texture coordinates `(mins + (i, j)) * luxel_size`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extents {
    /// Smallest texture coordinates, in luxels, rounded down.
    pub mins: [i32; 2],
    /// Luxels along s (width) and t (height), at least 1 and at most [`MAX_LUXELS`].
    pub size: [u32; 2],
}

/// Luxel extents of a polygon, with the rounding that the engines use: texture coordinates are summed
/// in f64 from left to right and rounded to f32, then divided by `luxel_size` (texels a luxel, 16
/// unless the map scales it) and rounded outwards in f64.
///
/// # Errors
/// If there are no vertices, a coordinate is not finite or does not fit, or there are more than
/// [`MAX_LUXELS`] on a side. The error names the world coordinates of the first vertex.
pub fn extents(
    vertices: impl IntoIterator<Item = Vec3>,
    texinfo: &TexInfo,
    luxel_size: f32,
) -> Result<Extents> {
    located(None, vertices, texinfo, luxel_size)
}

impl Bsp {
    /// Luxel extents of a face, see [`extents`].
    ///
    /// # Errors
    /// As [`extents`], and if the face's texinfo is out of range. The error names the face.
    ///
    /// # Panics
    /// If there is no face `face`.
    pub fn face_extents(&self, face: usize, luxel_size: f32) -> Result<Extents> {
        let Some(texinfo) = self.texinfo_of(face) else {
            return Err(Error::format(format!("face {face}"), "it has no texinfo, so no luxels"));
        };
        located(Some(face), self.face_vertices(face), texinfo, luxel_size)
    }
}

fn located(
    face: Option<usize>,
    vertices: impl IntoIterator<Item = Vec3>,
    texinfo: &TexInfo,
    luxel_size: f32,
) -> Result<Extents> {
    let mut first = None;
    let vertices = vertices.into_iter().inspect(|&vertex| {
        first.get_or_insert(vertex);
    });
    measure(vertices, texinfo, luxel_size).map_err(|problem| {
        let face = face.map_or_else(|| "face".to_owned(), |face| format!("face {face}"));
        let at = first.map_or_else(String::new, |p| format!(" at ({} {} {})", p.x, p.y, p.z));
        Error::format(face + &at, problem)
    })
}

fn measure(
    vertices: impl Iterator<Item = Vec3>,
    texinfo: &TexInfo,
    luxel_size: f32,
) -> std::result::Result<Extents, String> {
    if !(luxel_size.is_finite() && luxel_size > 0.0) {
        return Err(format!("luxel size {luxel_size} must be a positive number"));
    }
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for vertex in vertices {
        for (side, axis) in [texinfo.s, texinfo.t].into_iter().enumerate() {
            let coordinate = f64::from(texture_coordinate(vertex, axis));
            if !coordinate.is_finite() {
                return Err("its texture coordinates are not finite: fix its texture axes".into());
            }
            low[side] = low[side].min(coordinate);
            high[side] = high[side].max(coordinate);
        }
    }
    if low[0] > high[0] {
        return Err("it has no vertices".into());
    }
    let size = f64::from(luxel_size);
    let mut extents = Extents { mins: [0; 2], size: [0; 2] };
    for side in 0..2 {
        let (from, to) = ((low[side] / size).floor(), (high[side] / size).ceil());
        if from.abs() > 2_f64.powi(30) || to - from + 1.0 > f64::from(MAX_LUXELS) {
            return Err(format!(
                "luxels {from} to {to} along {}, more than {MAX_LUXELS}: fix its texture axes or scale",
                ["s", "t"][side]
            ));
        }
        extents.mins[side] = from as i32;
        extents.size[side] = (to - from) as u32 + 1;
    }
    Ok(extents)
}

/// Texture coordinate of a point along one texture axis, in texels.
fn texture_coordinate(p: Vec3, axis: Vec4) -> f32 {
    let (p, a) = (p.as_dvec3(), axis.as_dvec4());
    (p.x * a.x + p.y * a.y + p.z * a.z + a.w) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texinfo(s: Vec4) -> TexInfo {
        TexInfo { s, t: Vec4::new(0.0, 1.0, 0.0, 0.0), miptex: 0, flags: 0 }
    }

    fn square(low: f32, high: f32) -> Vec<Vec3> {
        [(low, low), (low, high), (high, high), (high, low)]
            .map(|(x, y)| Vec3::new(x, y, 5.0))
            .into()
    }

    #[test]
    fn luxels_lie_on_multiples_of_the_luxel_size_around_the_face() {
        let plain = texinfo(Vec4::X);
        let of = |low, high, size| extents(square(low, high), &plain, size).unwrap();
        assert_eq!(of(0.0, 64.0, 16.0), Extents { mins: [0; 2], size: [5; 2] });
        assert_eq!(of(-1.0, 65.0, 16.0), Extents { mins: [-1; 2], size: [7; 2] });
        assert_eq!(of(0.0, 64.0, 8.0), Extents { mins: [0; 2], size: [9; 2] });
        assert_eq!(of(3.0, 3.0, 16.0), Extents { mins: [0; 2], size: [2; 2] });
    }

    #[test]
    fn coordinates_are_rounded_to_f32_before_the_outward_rounding() {
        // 64 + 2^-20 in f64 would need a sixth luxel; as f32 it is 64 exactly.
        let nudged = texinfo(Vec4::new(1.0, 0.0, 0.0, 2_f32.powi(-20)));
        let found = extents(square(0.0, 64.0), &nudged, 16.0).unwrap();
        assert_eq!(found.size, [5, 5]);
        // A sum in f32 would lose the 0.5 between the large terms: 2^25 + 0.5 - 2^25.
        let axis = Vec4::new(2_f32.powi(25), 0.5, 0.0, -(2_f32.powi(25)));
        assert_eq!(texture_coordinate(Vec3::ONE, axis), 0.5);
    }

    #[test]
    fn absurd_faces_are_errors_that_say_where() {
        let message =
            |axis, size| extents(square(8.0, 64.0), &texinfo(axis), size).unwrap_err().to_string();
        assert!(message(Vec4::X * 1e6, 16.0).contains("(8 8 5)"));
        assert!(message(Vec4::X * f32::NAN, 16.0).contains("not finite"));
        assert!(message(Vec4::X * f32::MAX, 16.0).contains("not finite"));
        assert!(message(Vec4::X, 0.0).contains("luxel size"));
        assert!(message(Vec4::X, f32::NAN).contains("luxel size"));
        assert!(message(Vec4::W * 1e20, 16.0).contains("luxels"));
        assert!(
            extents([], &texinfo(Vec4::X), 16.0).unwrap_err().to_string().contains("no vertices")
        );
    }
}
