//! Fog, from the worldspawn key of the same name.

use crate::bsp::Entity;

/// Engines divide the density by this.
const DENSITY_UNIT: f64 = 64.0;
/// Part of the sky that fog hides.
const SKY_FOG: f32 = 0.5;

/// Fog over the whole map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fog {
    /// Per world unit.
    density: f64,
    /// 0 to 255.
    colour: [f32; 3],
    /// Part of the sky that is hidden.
    sky: f32,
}

impl Fog {
    /// Reads `fog` "density red green blue" and `skyfog` of the worldspawn. `None` without fog.
    pub fn of(world: &Entity) -> Option<Self> {
        let mut numbers =
            world.setting("fog")?.split_ascii_whitespace().map_while(|word| word.parse().ok());
        let density: f64 = numbers.next()?;
        if !(density.is_finite() && density > 0.0) {
            return None;
        }
        // Channels that are left out keep the engine's grey.
        let colour = [0.3_f64; 3]
            .map(|usual| (numbers.next().unwrap_or(usual).clamp(0.0, 1.0) * 255.0).round() as f32);
        let sky = world.setting("skyfog").and_then(|text| text.trim().parse().ok());
        let sky = sky.filter(|part| (0.0..=1.0).contains(part)).unwrap_or(SKY_FOG);
        Some(Self { density: density / DENSITY_UNIT, colour, sky })
    }

    /// A surface's colour seen through fog `depth` units deep along the view.
    pub fn surface(&self, colour: [f32; 3], depth: f64) -> [f32; 3] {
        self.mix(colour, 1.0 - (-(self.density * depth).powi(2)).exp() as f32)
    }

    /// The sky's colour seen through fog.
    pub fn sky(&self, colour: [f32; 3]) -> [f32; 3] {
        self.mix(colour, self.sky)
    }

    fn mix(&self, colour: [f32; 3], part: f32) -> [f32; 3] {
        std::array::from_fn(|i| colour[i] + (self.colour[i] - colour[i]) * part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fog_thickens_with_the_square_of_depth() {
        let mut world = Entity::default();
        assert_eq!(Fog::of(&world), None);
        world.set("_fog", "0.64 1 0.5 0");
        let fog = Fog::of(&world).unwrap();
        assert_eq!(fog.colour, [255.0, 128.0, 0.0]);
        assert_eq!(fog.surface([9.0; 3], 0.0), [9.0; 3]);
        // Density 0.01 a unit at 100 units: 1/e of the colour is left.
        let seen = fog.surface([0.0; 3], 100.0)[0];
        assert!((seen - 255.0 * (1.0 - 1.0 / std::f32::consts::E)).abs() < 1e-3, "{seen}");
        assert_eq!(fog.sky([0.0; 3])[0], 127.5);
        for bad in ["", "x", "0 1 1 1", "-1", "nan 1 1 1"] {
            world.set("_fog", bad);
            assert_eq!(Fog::of(&world), None, "{bad}");
        }
    }
}
