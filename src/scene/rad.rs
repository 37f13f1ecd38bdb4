//! Texture lights in `.rad` files (contract section 4.9): each line names a texture, a colour and a
//! brightness, and is read as a light entity with `_surface`.

use crate::bsp::Entity;

/// The light entities that the lines of the file `name` stand for. Lines that cannot be read give a
/// warning.
pub(crate) fn entities(name: &str, text: &str, warnings: &mut Vec<String>) -> Vec<Entity> {
    let mut entities = Vec::new();
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
        let mut entity = Entity::default();
        entity.set("classname", "light");
        entity.set("_surface", texture);
        entity.set("_color", format!("{r} {g} {b}"));
        entity.set("light", brightness);
        entities.push(entity);
    }
    entities
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_become_lights_and_bad_ones_warnings() {
        let mut warnings = Vec::new();
        let text =
            "\nlava1 255 128 0 900\r\n// note\nsky 1 2 3\nslime x 0 0 5\nglow 1 1 1 20 more\n";
        let lights = entities("lights.rad", text, &mut warnings);
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
