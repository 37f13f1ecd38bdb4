//! What lighting changes in the entity text: switchable styles, an old key name, bold text.

use super::entities::{Entity, parse_entities, write_entities};
use crate::{Error, Result};
use std::collections::HashMap;

/// The light styles that switchable lights get.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StyleRange {
    /// The first, handed out to the first name.
    pub first: u16,
    /// The first that is not handed out any more.
    pub limit: u16,
}

impl Default for StyleRange {
    /// What engines can switch.
    fn default() -> Self {
        Self { first: 32, limit: 64 }
    }
}

/// Parses an entity lump and makes the changes of [`normalise`]. The second part is the new lump, or
/// `None` if there is nothing to change, so that the old one can stay byte for byte.
///
/// # Errors
/// As [`parse_entities`] and [`normalise`].
pub fn rewrite_entities(lump: &[u8], styles: StyleRange) -> Result<(Vec<Entity>, Option<Vec<u8>>)> {
    let mut entities = parse_entities(lump)?;
    let changed = normalise(&mut entities, styles)?;
    let text = changed.then(|| write_entities(&entities));
    Ok((entities, text))
}

/// Makes the changes to entities that a light compiler writes back, and tells whether there were any:
///
/// 1. In values, `\b` goes and toggles bold letters (128 is added to their codes).
/// 2. `lightmap_scale` becomes `_lightmap_scale`.
/// 3. Entities whose classname begins with `light` and that have a `targetname` get the `style` of
///    that name: the first of `styles` for the first name, and so on, in entity order.
/// 4. Entities with `_switchableshadow` 1 get `switchshadstyle` in the same way; without a targetname,
///    a style of their own.
///
/// A second run finds nothing to change.
///
/// # Errors
/// `Limit` if more styles are needed than there are.
pub fn normalise(entities: &mut [Entity], styles: StyleRange) -> Result<bool> {
    let before = entities.to_vec();
    // First, as it may change names.
    for (_, value) in entities.iter_mut().flat_map(Entity::pairs_mut) {
        if value.contains("\\b") {
            *value = embolden(value);
        }
    }
    let mut styles = Styles { by_name: HashMap::new(), next: styles.first, limit: styles.limit };
    for entity in entities.iter_mut() {
        if let Some(scale) = entity.remove("lightmap_scale") {
            log::warn!("key lightmap_scale renamed to _lightmap_scale");
            // Moved to the end even if the right name was there already.
            entity.remove("_lightmap_scale");
            entity.set("_lightmap_scale", scale);
        }
        let name = entity.get("targetname").unwrap_or("").to_owned();
        if entity.classname().starts_with("light") && !name.is_empty() {
            entity.set("style", styles.of(&name)?.to_string());
        }
        if is_one(entity.get("_switchableshadow").unwrap_or("")) {
            entity.set("switchshadstyle", styles.of(&name)?.to_string());
        }
    }
    Ok(entities != before)
}

/// Whether the first word is an integer of value 1.
fn is_one(value: &str) -> bool {
    let word = value.split_ascii_whitespace().next().unwrap_or("");
    let word = word.strip_prefix('+').unwrap_or(word);
    let digits = word.find(|c: char| !c.is_ascii_digit()).map_or(word, |end| &word[..end]);
    digits.trim_start_matches('0') == "1"
}

struct Styles {
    by_name: HashMap<String, u16>,
    next: u16,
    limit: u16,
}

impl Styles {
    /// Style of a targetname; an empty one gets a new style each time.
    fn of(&mut self, name: &str) -> Result<u16> {
        if let Some(&style) = self.by_name.get(name) {
            return Ok(style);
        }
        let style = self.next;
        if style >= self.limit {
            return Err(Error::Limit {
                what: format!("light style for targetname \"{name}\""),
                value: style.into(),
                limit: u64::from(self.limit).saturating_sub(1),
                advice: "give fewer different targetnames to lights and switchable shadows, or raise \
                         _compilerstyle_max where the engine knows more styles",
            });
        }
        self.next += 1;
        if !name.is_empty() {
            self.by_name.insert(name.to_owned(), style);
        }
        Ok(style)
    }
}

/// Removes each `\b` and sets the high bit of every second stretch between them.
fn embolden(value: &str) -> String {
    let (mut out, mut bold, mut escape) = (String::new(), false, false);
    for c in value.chars() {
        // A plain backslash may also come to stand before a plain b when a mark between them goes.
        let joined = !bold && out.ends_with('\\');
        if c == 'b' && (escape || joined) {
            out.pop();
            bold = !bold;
            escape = false;
            continue;
        }
        escape = c == '\\';
        match u8::try_from(u32::from(c)) {
            Ok(byte) if bold => out.push(char::from(byte | 128)),
            _ => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_that_appear_when_others_go_are_marks_too() {
        for value in ["\\\\bb", "x\\\\b\\bb", "\\b\\\\bb", "\\\\\\bbb", "\\b\\b1", "\\b"] {
            let text = format!(
                "{{ \"classname\" \"light\" \"targetname\" \"{value}\" \
                 \"_switchableshadow\" \"{value}\" }}"
            );
            let mut entities = parse_entities(text.as_bytes()).unwrap();
            normalise(&mut entities, StyleRange::default()).unwrap();
            assert!(!normalise(&mut entities, StyleRange::default()).unwrap(), "{value}");
        }
    }

    fn rewritten(text: &str) -> String {
        let (_, lump) = rewrite_entities(text.as_bytes(), StyleRange::default()).unwrap();
        let lump = lump.expect("something changes");
        let again = rewrite_entities(&lump, StyleRange::default()).unwrap();
        assert_eq!(again.1, None, "a second run changes nothing");
        lump.into_iter()
            .filter(|&byte| byte != 0)
            .map(char::from)
            .collect::<String>()
            .replace('\n', " ")
    }

    #[test]
    fn switchable_lights_and_shadows_share_styles_by_name() {
        let text = "{ classname light targetname a style 5 } { classname light_torch targetname b }
            { classname func_wall _switchableshadow 1 targetname a }
            { classname func_wall _switchableshadow 1 } { classname func_wall _switchableshadow 1 }
            { classname Light targetname c } { classname light targetname a }";
        let expected = r#"{ "classname" "light" "targetname" "a" "style" "32" } { "classname" "light_torch" "targetname" "b" "style" "33" } { "classname" "func_wall" "_switchableshadow" "1" "targetname" "a" "switchshadstyle" "32" } { "classname" "func_wall" "_switchableshadow" "1" "switchshadstyle" "34" } { "classname" "func_wall" "_switchableshadow" "1" "switchshadstyle" "35" } { "classname" "Light" "targetname" "c" } { "classname" "light" "targetname" "a" "style" "32" } "#;
        assert_eq!(rewritten(text), expected);
    }

    #[test]
    fn old_scale_key_moves_to_the_end() {
        let text = "{ lightmap_scale 8 a b }";
        assert_eq!(rewritten(text), r#"{ "a" "b" "_lightmap_scale" "8" } "#);
    }

    #[test]
    fn bold_sets_the_high_bit() {
        assert_eq!(rewritten(r#"{ message "a\bBC\bd" }"#), "{ \"message\" \"a\u{C2}\u{C3}d\" } ");
        assert_eq!(embolden(r"x\by"), "x\u{F9}");
    }

    #[test]
    fn nothing_to_change_leaves_the_text_alone() {
        let text =
            b"{ classname  worldspawn }{ \"classname\" \"light\" targetname \"\" style 3 }\0";
        let (entities, lump) = rewrite_entities(text, StyleRange::default()).unwrap();
        assert_eq!(entities.len(), 2);
        assert_eq!(lump, None);
    }

    #[test]
    fn the_33rd_style_is_an_error() {
        let lights = |count: u32| -> String {
            (0..count).map(|i| format!("{{ classname light targetname t{i} }}\n")).collect()
        };
        let rewrite = |count, first, limit| {
            rewrite_entities(lights(count).as_bytes(), StyleRange { first, limit })
        };
        assert!(rewrite(32, 32, 64).is_ok() && rewrite(54, 10, 64).is_ok());
        assert!(rewrite(1, 40, 40).is_err() && rewrite(1, u16::MAX, u16::MAX).is_err());
        let (entities, _) = rewrite(2, 100, 102).unwrap();
        assert_eq!(entities[1].get("style"), Some("101"));
        let error = rewrite(33, 32, 64).unwrap_err();
        assert!(matches!(error, Error::Limit { value: 64, limit: 63, .. }), "{error}");
    }
}
