//! Names in lists of textures that fit no texture of the map: mostly slips of the pen.

use crate::error::nearest;
use std::collections::BTreeSet;

/// Names that are told of each file.
const TOLD: usize = 3;

/// The textures of a map, in lower case.
pub(super) struct TextureNames(BTreeSet<String>);

impl TextureNames {
    pub fn of<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        Self(names.into_iter().map(str::to_ascii_lowercase).collect())
    }

    /// Warns once of the names in a file, each with its line, that `fits` finds for no texture of the map.
    /// A map without textures has no names to compare with.
    pub fn warn(
        &self,
        file: &str,
        names: impl Iterator<Item = (usize, String)>,
        fits: impl Fn(&str, &str) -> bool,
        warnings: &mut Vec<String>,
    ) {
        let known = |name: &str| {
            let name = name.to_ascii_lowercase();
            self.0.contains(&name) || self.0.iter().any(|texture| fits(&name, texture))
        };
        let unknown: Vec<_> = names.filter(|(_, name)| !known(name)).collect();
        if self.0.is_empty() || unknown.is_empty() {
            return;
        }
        let told = |(line, name): &(usize, String)| {
            let shown: String = name.chars().take(40).collect::<String>().escape_debug().collect();
            // Stars stand for letters that are not known.
            let letters = shown.replace('*', "").to_ascii_lowercase();
            let like = nearest(&letters, self.0.iter().map(String::as_str));
            format!("line {line}: texture \"{shown}\" (did you mean \"{like}\"?)")
        };
        let mut list: Vec<String> = unknown.iter().take(TOLD).map(told).collect();
        if unknown.len() > TOLD {
            list.push(format!("and {} more", unknown.len() - TOLD));
        }
        warnings.push(format!("{file}: no texture of the map is named so: {}", list.join(", ")));
    }
}
