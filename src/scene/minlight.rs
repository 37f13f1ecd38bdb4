//! Minimum light that surfaces ask for (contract sections 3.2, 6.1 and 6.7).

use super::models::{AutoMinlight, Model};
use super::sidecar::TexInfoKeys;
use super::world::WorldSettings;
use glam::Vec3;

/// Minimum light of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Minlight {
    /// Level in light units; 0 is none.
    pub level: f32,
    /// Colour, 0 to 255 a channel.
    pub colour: Vec3,
    /// Noise is added to the level.
    pub mottle: bool,
    /// Minimum light does not apply, neither the world's nor that of local lights.
    pub exempt: bool,
    /// Automatic minimum light.
    pub auto: AutoMinlight,
    /// Light that the surface has because it gives off light.
    pub glow: Option<Glow>,
}

/// Minimum light of a surface that gives off light itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glow {
    /// Level in light units, above 0.
    pub level: f32,
    /// Colour, 0 to 255 a channel.
    pub colour: Vec3,
    /// Light style.
    pub style: u16,
}

impl Minlight {
    /// What a face of `model` gets. The face's own level counts if it is higher than the world's, and
    /// only then its colour does.
    pub(crate) fn of(keys: &TexInfoKeys, model: Option<&Model>, world: &WorldSettings) -> Self {
        let own = model.and_then(|m| m.minlight).or(keys.minlight).unwrap_or(world.minlight);
        let colour = model.and_then(|m| m.minlight_colour).or(keys.minlight_colour);
        let (level, colour) = if own > world.minlight {
            (own, colour.unwrap_or(world.minlight_colour))
        } else {
            (world.minlight, world.minlight_colour)
        };
        Self {
            level,
            colour,
            mottle: model.and_then(|m| m.minlight_mottle).unwrap_or(world.minlight_mottle),
            exempt: keys.no_minlight,
            auto: model.map_or(AutoMinlight::Off, |m| m.auto_minlight),
            glow: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_higher_of_world_and_face_counts_with_its_own_colour() {
        let world = WorldSettings { minlight: 50.0, ..WorldSettings::default() };
        let red = Vec3::new(255.0, 0.0, 0.0);
        let keys = |minlight| TexInfoKeys {
            minlight: Some(minlight),
            minlight_colour: Some(red),
            ..TexInfoKeys::default()
        };
        let of = |minlight| {
            let m = Minlight::of(&keys(minlight), None, &world);
            (m.level, m.colour)
        };
        assert_eq!(of(60.0), (60.0, red));
        assert_eq!(of(50.0), (50.0, Vec3::splat(255.0)), "not above the world's");
        assert_eq!(of(10.0), (50.0, Vec3::splat(255.0)));
    }
}
