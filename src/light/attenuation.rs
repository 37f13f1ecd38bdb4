//! Brightness over distance (contract section 4.4).

use crate::scene::Light;
use crate::scene::lights::Attenuation;

/// Distance in scaled units at which lights with inverse falloff have their full brightness.
const FULL_AT: f32 = 128.0;

/// Most light units of one light at one point: sums of many, in colour and scaled, stay within single
/// precision.
const MOST: f32 = 1e15;

/// Light units that `light` gives at distance `d` in world units, facing it, without cone; `dist` is
/// the world's distance scale. There is no cap near the light but that of single precision.
pub(crate) fn value(light: &Light, dist: f32, d: f32) -> f32 {
    let l = light.brightness;
    let v = dist * light.wait * d;
    let value = match light.attenuation {
        Attenuation::Falloff(radius) => {
            if d < radius {
                l * (1.0 - d / radius)
            } else {
                0.0
            }
        }
        Attenuation::Linear if l > 0.0 => (l - v).max(0.0),
        Attenuation::Linear => (l + v).min(0.0),
        Attenuation::Inverse => l / (v / FULL_AT),
        Attenuation::InverseSquare => l / (v * v / (FULL_AT * FULL_AT)),
        Attenuation::Infinite | Attenuation::LocalMinimum => l,
        Attenuation::InverseSquareOffset => {
            let w = v + FULL_AT;
            l / (w * w / (FULL_AT * FULL_AT))
        }
        Attenuation::InverseSquareClamped => {
            let h = v.max(FULL_AT);
            l / (h * h)
        }
    };
    value.clamp(-MOST, MOST)
}

/// Share of the light at distance `d` that a copy of a surface light gives although the surface it
/// stands for cannot, 0 for other lights. A disc of radius r that gives I / d^2 from afar gives at
/// most I / r^2, where it is touched; a point light with inverse falloff grows without end.
pub(crate) fn excess(light: &Light, dist: f32, d: f32) -> f32 {
    let inverse = matches!(light.attenuation, Attenuation::Inverse | Attenuation::InverseSquare);
    if !inverse || d >= light.piece_radius {
        return 0.0;
    }
    // Both may have vanished: 0 / 0 is no excess.
    (1.0 - value(light, dist, light.piece_radius) / value(light, dist, d)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn light(brightness: f32, attenuation: Attenuation) -> Light {
        Light {
            bounce_scale: 1.0,
            origin: Vec3::ZERO,
            brightness,
            colour: Vec3::splat(255.0),
            wait: 2.0,
            attenuation,
            angle_scale: 0.5,
            bleed: false,
            style: 0,
            spot: None,
            projection: None,
            channel_mask: 1,
            dirt: crate::scene::DirtKeys::default(),
            shadow_mask: 1,
            piece_radius: 0.0,
            entity: 0,
        }
    }

    #[test]
    fn every_formula_at_scaled_distance_256() {
        // dist 4, wait 2, d 32: 256 scaled units.
        for (attenuation, want) in [
            (Attenuation::Linear, 300.0 - 256.0),
            (Attenuation::Falloff(128.0), 300.0 * 0.75),
            (Attenuation::Inverse, 150.0),
            (Attenuation::InverseSquare, 75.0),
            (Attenuation::Infinite, 300.0),
            (Attenuation::InverseSquareOffset, 300.0 / 9.0),
            (Attenuation::InverseSquareClamped, 300.0 / 65536.0),
        ] {
            assert_eq!(value(&light(300.0, attenuation), 4.0, 32.0), want, "{attenuation:?}");
            if attenuation != Attenuation::Linear {
                assert_eq!(value(&light(-300.0, attenuation), 4.0, 32.0), -want);
            }
        }
    }

    #[test]
    fn linear_light_ends_at_zero_from_both_signs() {
        assert_eq!(value(&light(100.0, Attenuation::Linear), 1.0, 60.0), 0.0);
        assert_eq!(value(&light(-100.0, Attenuation::Linear), 1.0, 40.0), -20.0);
        assert_eq!(value(&light(-100.0, Attenuation::Linear), 1.0, 60.0), 0.0);
        assert_eq!(value(&light(100.0, Attenuation::Falloff(50.0)), 1.0, 50.0), 0.0);
    }
}
