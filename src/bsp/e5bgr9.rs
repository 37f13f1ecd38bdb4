//! Colours with a shared exponent in 32 bits: what HDR lightmaps hold (contract section 1.6).
//!
//! From the highest bit: 5 bits of exponent, then 9 bits each of blue, green and red. A channel is
//! mantissa * 2^(exponent - 24).

use glam::{DVec3, Vec3};

/// Largest value of a channel: 511 * 2^7.
pub const E5BGR9_MAX: f32 = 65408.0;
/// Mantissas are below this.
const MANTISSAS: f64 = 512.0;

/// Nearest colour that can be stored. Channels are limited to 0 to [`E5BGR9_MAX`], and what is not a
/// number becomes 0.
pub fn pack_e5bgr9(colour: Vec3) -> u32 {
    // Comparing sends what is not a number to 0, too.
    let limit = |c: f32| if c > 0.0 { f64::from(c.min(E5BGR9_MAX)) } else { 0.0 };
    let c = DVec3::from_array(colour.to_array().map(limit));
    let max = c.max_element();
    if max == 0.0 {
        return 0;
    }
    let least = (max.log2().floor() as i32).max(-16) + 16;
    let rounded = |c: f64, exponent: i32| (c / step(exponent) + 0.5).floor();
    let exponent = if rounded(max, least) < MANTISSAS { least } else { least + 1 }.clamp(0, 31);
    let [r, g, b] = c.to_array().map(|c| rounded(c, exponent).clamp(0.0, MANTISSAS - 1.0) as u32);
    (exponent as u32) << 27 | b << 18 | g << 9 | r
}

/// The colour that is stored.
pub fn unpack_e5bgr9(packed: u32) -> Vec3 {
    let step = step((packed >> 27) as i32);
    let channel = |shift: u32| (f64::from(packed >> shift & 511) * step) as f32;
    Vec3::new(channel(0), channel(9), channel(18))
}

/// What one unit of the mantissa is worth.
fn step(exponent: i32) -> f64 {
    f64::from(exponent - 24).exp2()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(packed: u32) -> [u32; 4] {
        [packed >> 27, packed & 511, packed >> 9 & 511, packed >> 18 & 511]
    }

    #[test]
    fn pinned_colours() {
        let colour = Vec3::new(511.0, 1.0, 0.0);
        assert_eq!(parts(pack_e5bgr9(colour)), [24, 511, 1, 0]);
        assert_eq!(unpack_e5bgr9(pack_e5bgr9(colour)), colour);
        let bright = pack_e5bgr9(Vec3::new(1e6, 0.0, 0.0));
        assert_eq!(parts(bright), [31, 511, 0, 0]);
        assert_eq!(unpack_e5bgr9(bright), Vec3::new(65408.0, 0.0, 0.0));
        let dim = Vec3::new(0.1, 0.01, 0.001);
        let error = (unpack_e5bgr9(pack_e5bgr9(dim)) - dim).abs();
        assert!(error.x < 9.8e-5 && error.y < 1e-5 && error.z < 2.5e-5, "{error}");
    }

    #[test]
    fn odd_numbers_become_black_or_the_limit() {
        assert_eq!(pack_e5bgr9(Vec3::ZERO), 0);
        assert_eq!(pack_e5bgr9(Vec3::new(-1.0, f32::NAN, -0.0)), 0);
        assert_eq!(unpack_e5bgr9(pack_e5bgr9(Vec3::INFINITY)), Vec3::splat(E5BGR9_MAX));
        assert_eq!(unpack_e5bgr9(pack_e5bgr9(Vec3::splat(1e-30))), Vec3::ZERO);
    }

    #[test]
    fn stored_colours_come_back_as_the_same_bits_or_normalised() {
        // A mantissa of at least 256 leaves one way to write a colour.
        for exponent in 1..32_u32 {
            for mantissa in [256, 300, 510, 511_u32] {
                let packed = exponent << 27 | 7 << 18 | (mantissa - 250) << 9 | mantissa;
                assert_eq!(pack_e5bgr9(unpack_e5bgr9(packed)), packed, "{exponent} {mantissa}");
            }
        }
    }

    #[test]
    fn the_error_is_at_most_half_a_step_of_the_largest_channel() {
        let mut x = 1.1e-4_f32;
        while x < 6e4 {
            let colour = Vec3::new(x, 0.6 * x, 0.01 * x);
            let error = (unpack_e5bgr9(pack_e5bgr9(colour)) - colour).abs().max_element();
            assert!(error <= x / 511.0, "{colour} is off by {error}");
            x *= 1.37;
        }
    }
}
