//! Worldspawn keys that the user sets instead of the map.

use crate::bsp::Entity;

/// Spellings of the same setting (contract section 9.2): alias, then its main name.
const ALIASES: [(&str, &str); 13] = [
    ("anglesense", "anglescale"),
    ("choplight", "surflightsubdivision"),
    ("dirty", "dirt"),
    ("light", "minlight"),
    ("mincolor", "minlight_color"),
    ("minlightMottle", "minlight_mottle"),
    ("sun_angle", "sunlight_mangle"),
    ("sun_color", "sunlight_color"),
    ("sun_light", "sunlight"),
    ("sun_mangle", "sunlight_mangle"),
    ("sunlight_color2", "sunlight2_color"),
    ("sunlight_color3", "sunlight3_color"),
    ("sun_surface", "sky_surface"),
];

/// Main name of a setting, without leading underscores.
fn main_name(key: &str) -> &str {
    let key = key.trim_start_matches('_');
    ALIASES.iter().find(|(alias, _)| *alias == key).map_or(key, |(_, main)| main)
}

/// The worldspawn entity with its keys replaced by `overrides`, in any spelling of the key; a later
/// override wins over an earlier one.
pub(crate) fn apply(worldspawn: &Entity, overrides: &[(String, String)]) -> Entity {
    let mut entity = worldspawn.clone();
    for (key, value) in overrides {
        let name = main_name(key);
        let old: Vec<String> =
            entity.pairs().map(|(k, _)| k.to_owned()).filter(|k| main_name(k) == name).collect();
        for key in old {
            entity.remove(&key);
        }
        entity.set(name, value.as_str());
    }
    entity
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsp::parse_entities;

    #[test]
    fn every_spelling_of_the_key_is_replaced() {
        let text = b"{ _sun_mangle \"1 2 3\" __sunlight_mangle \"4 5 6\" _dist 2 }";
        let world = &parse_entities(text).unwrap()[0];
        let set = |key: &str, value: &str| (key.to_owned(), value.to_owned());
        let world = apply(world, &[set("sun_angle", "0 0 0"), set("_sun_angle", "7 8 9")]);
        let pairs: Vec<_> = world.pairs().collect();
        assert_eq!(pairs, [("_dist", "2"), ("sunlight_mangle", "7 8 9")]);
    }
}
