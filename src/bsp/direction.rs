//! Directions as deluxemaps store them: `.lux` files, `LIGHTINGDIR` and version 2 of `.lit`.

use glam::Vec3;

/// A direction in tangent space, of any length, as three bytes: each coordinate of the unit vector, from
/// -1 at 0 to 1 at 256, cut to a whole number and limited to 255. No direction is straight up.
pub fn pack_direction(direction: Vec3) -> [u8; 3] {
    let unit = direction.try_normalize().unwrap_or(Vec3::Z);
    // `as` cuts off and limits.
    unit.to_array().map(|x| ((x + 1.0) * 128.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_and_diagonals() {
        assert_eq!(pack_direction(Vec3::Z * 1e6), [128, 128, 255]);
        assert_eq!(pack_direction(Vec3::NEG_X * 0.5), [0, 128, 128]);
        assert_eq!(pack_direction(Vec3::new(3.0, -4.0, 0.0)), [204, 25, 128]);
        for nothing in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
            assert_eq!(pack_direction(nothing), [128, 128, 255]);
        }
    }
}
