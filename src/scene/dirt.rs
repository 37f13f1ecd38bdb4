//! Settings of dirt, the darkening of corners, and what lights ask of it (contract section 6.3).

use super::keys;
use crate::bsp::Entity;

/// Reads the numbers with the given names into a value and limits it to the given range.
pub(crate) type SetNumber<'a> = dyn FnMut(&[&str], f32, f32, &mut f32) + 'a;

/// Worldspawn's settings of dirt.
#[derive(Clone, Debug, PartialEq)]
pub struct DirtSettings {
    /// Something asks for dirt, so that it is worth tracing.
    pub in_use: bool,
    /// `dirt`: lights get dirt unless they say otherwise.
    pub lights: bool,
    /// `minlight_dirt`: minimum light gets dirt.
    pub minlight: bool,
    /// `dirtmode` 1: directions are random instead of fixed.
    pub random: bool,
    /// `dirtdepth`: how far dirt looks, in world units, 1 or more.
    pub depth: f32,
    /// `dirtscale`: factor on occlusion, 0 to 100.
    pub scale: f32,
    /// `dirtgain`: exponent on occlusion, 0 to 100.
    pub gain: f32,
    /// `dirtangle`: largest angle between the normal and the directions, in degrees, 1 to 90.
    pub angle: f32,
}

impl Default for DirtSettings {
    fn default() -> Self {
        Self {
            in_use: false,
            lights: false,
            minlight: false,
            random: false,
            depth: 128.0,
            scale: 1.0,
            gain: 1.0,
            angle: 88.0,
        }
    }
}

impl DirtSettings {
    pub(crate) fn read(world: &Entity, set: &mut SetNumber<'_>) -> Self {
        let mut s = Self::default();
        set(&["dirtdepth"], 1.0, f32::MAX, &mut s.depth);
        set(&["dirtscale"], 0.0, 100.0, &mut s.scale);
        set(&["dirtgain"], 0.0, 100.0, &mut s.gain);
        set(&["dirtangle"], 1.0, 90.0, &mut s.angle);
        let value = |name: &str| world.setting(name);
        s.random = value("dirtmode").is_some_and(|v| keys::integer(v) == 1);
        s.lights = ["dirt", "dirty"].iter().any(|k| value(k).is_some_and(keys::boolean));
        s.minlight = value("minlight_dirt").map_or(s.lights, keys::boolean);
        let of_sky = |name: &str| value(name).and_then(keys::number).is_some_and(|v| v > 0.0);
        s.in_use = s.lights || s.minlight || of_sky("sunlight_dirt") || of_sky("sunlight2_dirt");
        s
    }
}

/// The `dirt` key of a light: 1 asks for dirt, -1 for none, anything else follows `world`.
fn wanted(value: f32, world: bool) -> bool {
    match value {
        1.0 => true,
        -1.0 => false,
        _ => world,
    }
}

/// What a light asks of dirt.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DirtKeys {
    /// The light gets dirt.
    pub wanted: bool,
    /// Replaces the world's exponent unless 0.
    pub gain: f32,
    /// Replaces the world's factor unless 0.
    pub scale: f32,
    /// Distances from the light up to which there is no dirt and from which there is all of it.
    pub radii: Option<[f32; 2]>,
}

impl DirtKeys {
    /// Those of a light entity.
    pub(crate) fn read(entity: &Entity, world: &DirtSettings) -> Self {
        let number = |name: &str| entity.setting(name).and_then(keys::number);
        let radii = number("dirt_off_radius").zip(number("dirt_on_radius"));
        Self {
            wanted: number("dirt").map_or(world.lights, |v| wanted(v, world.lights)),
            gain: number("dirtgain").unwrap_or(0.0),
            scale: number("dirtscale").unwrap_or(0.0),
            radii: radii.map(|(off, on)| [off, on]),
        }
    }

    /// Those of light that gets dirt without saying more.
    pub fn plain(wanted: bool) -> Self {
        Self { wanted, ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(pairs: &[(&str, &str)]) -> DirtSettings {
        let mut world = Entity::default();
        for (key, value) in pairs {
            world.set(key, *value);
        }
        DirtSettings::read(&world, &mut |names, low, high, value| {
            if let Some(v) = names.iter().find_map(|n| world.setting(n).and_then(keys::number)) {
                *value = v.clamp(low, high);
            }
        })
    }

    #[test]
    fn dirt_switches_on_that_of_minimum_light_unless_it_is_set() {
        let s = settings(&[("_dirt", "1"), ("_minlight_dirt", "0")]);
        assert!(s.in_use && s.lights && !s.minlight);
        let s = settings(&[("_sunlight_dirt", "1"), ("_dirtdepth", "0")]);
        assert!(s.in_use && !s.lights && !s.minlight && s.depth == 1.0);
        assert_eq!(settings(&[]), DirtSettings::default());
    }

    #[test]
    fn lights_follow_the_world_unless_they_say_one_or_minus_one() {
        let world = settings(&[("dirt", "1")]);
        let light = |value: &str| {
            let mut entity = Entity::default();
            entity.set("_dirt", value);
            entity.set("_dirt_off_radius", "8");
            DirtKeys::read(&entity, &world)
        };
        assert!(light("0").wanted && light("1").wanted && !light("-1").wanted);
        assert_eq!(light("1").radii, None, "both radii are needed");
    }
}
