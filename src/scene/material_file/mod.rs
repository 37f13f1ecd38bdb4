//! Material files: what textures do to light, said by name or pattern. The format is in
//! `docs/materials.md`.

mod read;

use super::unknown_names::TextureNames;
use glam::Vec3;

/// The materials of a file, in its order. The default has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialFile {
    /// Its name.
    name: String,
    entries: Vec<(Vec<Named>, Material)>,
}

/// What an entry is about.
#[derive(Clone, Debug, PartialEq)]
struct Named {
    /// In lower case; `*` stands for any letters.
    pattern: String,
    /// Line of the file.
    line: usize,
}

/// What a texture does to light; `None` is as without the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Material {
    /// Share of light sent back.
    pub reflectance: Option<MaterialReflectance>,
    /// Light given off.
    pub emission: Option<MaterialEmission>,
    /// Share of light that passes straight through, per channel, 0 to 1.
    pub transmission: Option<Vec3>,
    /// Share of light that leaves the other side diffusely, per channel, 0 to 1.
    pub diffuse_transmission: Option<Vec3>,
    /// Lit from behind as well.
    pub two_sided: Option<bool>,
    /// Texels of the last palette index are holes.
    pub alpha_test: Option<bool>,
    /// Sends light back at all.
    pub bounce: Option<bool>,
    /// How what a face sends on varies over it.
    pub modifier: Option<Modifier>,
}

/// Reflectance of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MaterialReflectance {
    /// Of its own, per channel, 0 to 1.
    Colour(Vec3),
    /// So many times the mean colour of the texture, 0 and up.
    Scale(f32),
}

/// Light that a texture gives off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialEmission {
    /// Colour, 0 to 1 a channel; `None` is the mean colour of the texture, or that of each texel.
    pub colour: Option<Vec3>,
    /// As `light` of a light with `_surface`, and the last number of a line of a `.rad` file.
    pub intensity: f32,
    /// Which parts shine.
    pub parts: Emitting,
}

/// Which parts of a texture shine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Emitting {
    /// The whole face alike.
    #[default]
    Face,
    /// Fullbright texels (palette index 224 and up), each in its colour.
    Fullbright,
    /// All texels, each in its colour.
    Texture,
}

/// How what a face sends on varies over it: a factor on its reflectance and diffuse transmission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Modifier {
    /// As the texels do.
    Texel,
    /// Squares of a size in texels; every other one is multiplied by a colour.
    Checker(f32, Vec3),
    /// Between two heights, in world units, the factor goes from 1 to a colour.
    Gradient([f32; 2], Vec3),
}

impl MaterialFile {
    /// Whether no texture is named.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// What the file says of a texture: of all entries whose patterns fit, the last one counts, key by
    /// key. Upper and lower case are alike.
    pub fn of(&self, texture: &str) -> Material {
        let texture = texture.to_ascii_lowercase();
        let mut all = Material::default();
        for (patterns, m) in &self.entries {
            if !patterns.iter().any(|p| fits(p.pattern.as_bytes(), texture.as_bytes())) {
                continue;
            }
            all.reflectance = m.reflectance.or(all.reflectance);
            all.emission = m.emission.or(all.emission);
            all.transmission = m.transmission.or(all.transmission);
            all.diffuse_transmission = m.diffuse_transmission.or(all.diffuse_transmission);
            all.two_sided = m.two_sided.or(all.two_sided);
            all.alpha_test = m.alpha_test.or(all.alpha_test);
            all.bounce = m.bounce.or(all.bounce);
            all.modifier = m.modifier.or(all.modifier);
        }
        all
    }

    /// Warns of patterns that fit no texture of a map.
    pub(super) fn warn(&self, textures: &TextureNames, warnings: &mut Vec<String>) {
        let named = self.entries.iter().flat_map(|(patterns, _)| patterns);
        let named = named.map(|p| (p.line, p.pattern.clone()));
        let fits = |pattern: &str, name: &str| fits(pattern.as_bytes(), name.as_bytes());
        textures.warn(&self.name, named, fits, warnings);
    }
}

/// Whether a name fits a pattern in which `*` stands for any letters. A `*` that starts the name of a
/// liquid fits itself, too.
fn fits(pattern: &[u8], name: &[u8]) -> bool {
    // Where to go on when the letters after the last star do not fit.
    let (mut p, mut n) = (0, 0);
    let mut again: Option<(usize, usize)> = None;
    while n < name.len() {
        if p < pattern.len() && pattern[p] == b'*' {
            again = Some((p + 1, n));
            p += 1;
        } else if p < pattern.len() && pattern[p] == name[n] {
            p += 1;
            n += 1;
        } else if let Some((star, from)) = again {
            again = Some((star, from + 1));
            (p, n) = (star, from + 1);
        } else {
            return false;
        }
    }
    pattern[p..].iter().all(|&b| b == b'*')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_stand_for_any_letters() {
        let fits = |pattern: &str, name: &str| fits(pattern.as_bytes(), name.as_bytes());
        assert!(fits("curtain*", "curtain_red") && fits("*red", "curtain_red"));
        assert!(fits("*tain*r*d", "curtain_red") && fits("*", "") && fits("a", "a"));
        assert!(!fits("a", "ab") && !fits("*b*c", "ac") && !fits("curtain", "curtain_red"));
        assert!(fits("*water*", "*water0"), "liquids");
        // No pattern takes long.
        assert!(!fits(&"*a".repeat(200), &"a".repeat(199)));
    }

    #[test]
    fn later_entries_win_key_by_key() {
        let file = MaterialFile::parse(
            "[[material]]\ntexture = \"*\"\nreflectance = 0.5\nbounce = false\n\
             [[material]]\ntexture = [\"x\", \"wall*\"]\nreflectance = [0.1, 0.2, 0.3]\n",
            "m",
        )
        .unwrap();
        let wall = file.of("WALL1");
        let colour = Vec3::new(0.1, 0.2, 0.3);
        assert_eq!(wall.reflectance, Some(MaterialReflectance::Colour(colour)));
        assert_eq!(wall.bounce, Some(false));
        assert_eq!(file.of("floor").reflectance, Some(MaterialReflectance::Scale(0.5)));
    }
}
