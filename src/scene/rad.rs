//! Texture lights in `.rad` files (contract section 4.9): each line names a texture, a colour and a
//! brightness, and is read as a light entity with `_surface`.

use super::unknown_names::TextureNames;
use crate::bsp::Entity;

/// The light entities that the lines of the file `name` stand for. Lines that cannot be read, and those for
/// textures that the map lacks, give a warning.
pub(super) fn entities(
    name: &str,
    text: &str,
    textures: &TextureNames,
    warnings: &mut Vec<String>,
) -> Vec<Entity> {
    let (mut entities, mut named) = (Vec::new(), Vec::new());
    for (index, line) in text.lines().enumerate() {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        if words.first().is_none_or(|w| w.starts_with("//") || w.starts_with('#')) {
            continue;
        }
        let [texture, r, g, b, brightness, ..] = words[..] else {
            warnings.push(format!(
                "{name}: line {}: {line:?} is not a texture, a colour and a brightness",
                index + 1
            ));
            continue;
        };
        let numbers = [r, g, b, brightness];
        if let Some(bad) = numbers.iter().find(|n| !n.parse::<f32>().is_ok_and(f32::is_finite)) {
            warnings.push(format!("{name}: line {}: {bad:?} is not a number", index + 1));
            continue;
        }
        named.push((index + 1, texture.to_owned()));
        let mut entity = Entity::default();
        entity.set("classname", "light");
        entity.set("_surface", texture);
        entity.set("_color", format!("{r} {g} {b}"));
        entity.set("light", brightness);
        entities.push(entity);
    }
    textures.warn(name, named.into_iter(), |_, _| false, warnings);
    entities
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_no_texture_are_told_once_with_the_nearest() {
        let mut warnings = Vec::new();
        let textures = TextureNames::of(["brick1", "lava1"]);
        let text = "brikc1 1 1 1 20\nlava1 1 1 1 20\na 1 1 1 1\nb 1 1 1 1\nc 1 1 1 1\n";
        assert_eq!(entities("x.rad", text, &textures, &mut warnings).len(), 5);
        assert_eq!(warnings.len(), 1);
        let told = "x.rad: no texture of the map is named so: line 1: texture \"brikc1\" \
                    (did you mean \"brick1\"?)";
        assert!(warnings[0].starts_with(told), "{}", warnings[0]);
        assert!(warnings[0].ends_with("and 1 more"), "{}", warnings[0]);
        warnings.clear();
        entities("x.rad", text, &TextureNames::of([]), &mut warnings);
        assert!(warnings.is_empty(), "nothing to compare with: {warnings:?}");
    }

    #[test]
    fn lines_become_lights_and_bad_ones_warnings() {
        let mut warnings = Vec::new();
        let text =
            "\nlava1 255 128 0 900\r\n// note\nsky 1 2 3\nslime x 0 0 5\nglow 1 1 1 20 more\n";
        let textures = TextureNames::of(["Lava1", "glow"]);
        let lights = entities("lights.rad", text, &textures, &mut warnings);
        assert_eq!(lights.len(), 2);
        assert_eq!(lights[0].get("_surface"), Some("lava1"));
        assert_eq!(lights[0].get("_color"), Some("255 128 0"));
        assert_eq!(lights[1].get("light"), Some("20"));
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert!(
            warnings[0].starts_with("lights.rad: line 4: ") && warnings[1].contains("line 5: ")
        );
    }
}
