//! Reading material files: every complaint names file, line and key.

use super::{
    Emitting, Material, MaterialEmission, MaterialFile, MaterialReflectance, Modifier, Named,
};
use crate::error::nearest;
use crate::{Error, Result};
use glam::Vec3;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

const KEYS: [&str; 9] = [
    "texture",
    "reflectance",
    "emission",
    "transmission",
    "diffuse_transmission",
    "two_sided",
    "alpha_test",
    "bounce",
    "modifier",
];
const EMISSION_KEYS: [&str; 3] = ["colour", "intensity", "parts"];
const PARTS: [&str; 3] = ["face", "fullbright", "texture"];
const MODIFIER_KEYS: [&str; 5] = ["kind", "size", "colour", "from", "to"];
const KINDS: [&str; 3] = ["texel", "checker", "gradient"];
/// Sums of decimal fractions may exceed 1 by rounding.
const ROUNDING: f32 = 1e-5;

impl MaterialFile {
    /// Reads the text of the file `name`.
    ///
    /// # Errors
    /// [`Error::Format`] with file, line and key for everything that cannot be used.
    pub fn parse(text: &str, name: &str) -> Result<Self> {
        let ends: Vec<usize> = text.match_indices('\n').map(|(at, _)| at).collect();
        let reader = Reader { name, ends: &ends };
        let table = DeTable::parse(text).map_err(|e| {
            let at = e.span().map_or(0, |span| span.start);
            let message = e.message().lines().next().unwrap_or("not TOML").to_owned();
            reader.error(at, message)
        })?;
        let mut entries = Vec::new();
        for (key, value) in table.get_ref() {
            reader.known(key.get_ref(), key.span().start, &["material"])?;
            let DeValue::Array(list) = value.get_ref() else {
                let problem = "material: write [[material]], with two brackets, before each";
                return Err(reader.error(value.span().start, problem));
            };
            for entry in list {
                entries.push(reader.entry(entry)?);
            }
        }
        Ok(Self { name: name.to_owned(), entries })
    }
}

type Value<'a> = Spanned<DeValue<'a>>;

/// Where complaints are placed.
#[derive(Clone, Copy)]
struct Reader<'a> {
    name: &'a str,
    /// Where lines end.
    ends: &'a [usize],
}

impl Reader<'_> {
    /// The line of a place in the text.
    fn line(&self, at: usize) -> usize {
        1 + self.ends.partition_point(|&end| end < at)
    }

    fn error(&self, at: usize, problem: impl Into<String>) -> Error {
        Error::format(format!("{}: line {}", self.name, self.line(at)), problem)
    }

    /// Refuses keys other than those `known`.
    fn known(&self, key: &str, at: usize, known: &[&str]) -> Result<()> {
        if known.contains(&key) {
            return Ok(());
        }
        let shown: String = key.chars().take(40).collect::<String>().escape_debug().collect();
        let like = nearest(&shown, known.iter().copied());
        Err(self.error(at, format!("unknown key \"{shown}\"; did you mean \"{like}\"?")))
    }

    fn entry(&self, entry: &Value<'_>) -> Result<(Vec<Named>, Material)> {
        let at = entry.span().start;
        let DeValue::Table(table) = entry.get_ref() else {
            return Err(self.error(at, "material: a table of keys is expected"));
        };
        let mut patterns = Vec::new();
        let mut m = Material::default();
        // Where the transmissions stand, straight and diffuse.
        let mut passing_at = [at; 2];
        for (key, value) in table {
            let key_at = key.span().start;
            let key: &str = key.get_ref();
            self.known(key, key_at, &KEYS)?;
            match key {
                "texture" => patterns = self.patterns(value)?,
                "reflectance" => {
                    m.reflectance = Some(match value.get_ref() {
                        DeValue::Array(_) => MaterialReflectance::Colour(self.share(key, value)?),
                        _ => MaterialReflectance::Scale(self.number(key, value, [0.0, 100.0])?),
                    });
                }
                "emission" => m.emission = Some(self.emission(value)?),
                "transmission" => {
                    passing_at[0] = key_at;
                    m.transmission = Some(self.share(key, value)?);
                }
                "diffuse_transmission" => {
                    passing_at[1] = key_at;
                    m.diffuse_transmission = Some(self.share(key, value)?);
                }
                "two_sided" => m.two_sided = Some(self.flag(key, value)?),
                "alpha_test" => m.alpha_test = Some(self.flag(key, value)?),
                "bounce" => m.bounce = Some(self.flag(key, value)?),
                _ => m.modifier = Some(self.modifier(value)?),
            }
        }
        if patterns.is_empty() {
            return Err(self.error(at, "texture: an entry names a texture or a list of them"));
        }
        self.check_sum(&m, passing_at)?;
        Ok((patterns, m))
    }

    /// Refuses a material that sends on more light than meets it.
    fn check_sum(&self, m: &Material, [straight, diffuse]: [usize; 2]) -> Result<()> {
        let own = match m.reflectance {
            Some(MaterialReflectance::Colour(colour)) => colour,
            _ => Vec3::ZERO,
        };
        let or_none = |share: Option<Vec3>| share.unwrap_or(Vec3::ZERO);
        let sum = own + or_none(m.transmission) + or_none(m.diffuse_transmission);
        if sum.max_element() > 1.0 + ROUNDING {
            let (key, at) = match m.transmission {
                Some(_) => ("transmission", straight),
                None => ("diffuse_transmission", diffuse),
            };
            let problem = format!(
                "{key}: reflectance, transmission and diffuse_transmission sum to {} in one channel, \
                 which is more than 1",
                sum.max_element()
            );
            return Err(self.error(at, problem));
        }
        if m.transmission.is_some() && m.diffuse_transmission.is_some() {
            let problem = "diffuse_transmission: a texture has this or transmission, not both";
            return Err(self.error(diffuse, problem));
        }
        Ok(())
    }

    fn patterns(&self, value: &Value<'_>) -> Result<Vec<Named>> {
        let one = |value: &Value<'_>| match value.get_ref() {
            DeValue::String(name) if !name.is_empty() => Ok(Named {
                pattern: name.to_ascii_lowercase(),
                line: self.line(value.span().start),
            }),
            _ => Err(self.error(value.span().start, "texture: a name in quotes is expected")),
        };
        match value.get_ref() {
            DeValue::Array(names) => names.iter().map(one).collect(),
            _ => Ok(vec![one(value)?]),
        }
    }

    fn number(&self, key: &str, value: &Value<'_>, [low, high]: [f32; 2]) -> Result<f32> {
        let number = match value.get_ref() {
            DeValue::Integer(n) if n.radix() == 10 => n.as_str().parse().ok(),
            DeValue::Float(x) => x.as_str().parse::<f32>().ok(),
            _ => None,
        };
        number.filter(|x| (low..=high).contains(x)).ok_or_else(|| {
            self.error(value.span().start, format!("{key}: give a number from {low} to {high}"))
        })
    }

    /// Three shares, or one for all channels.
    fn share(&self, key: &str, value: &Value<'_>) -> Result<Vec3> {
        let DeValue::Array(list) = value.get_ref() else {
            return self.number(key, value, [0.0, 1.0]).map(Vec3::splat);
        };
        let numbers: Vec<f32> =
            list.iter().map(|value| self.number(key, value, [0.0, 1.0])).collect::<Result<_>>()?;
        let three: std::result::Result<[f32; 3], _> = numbers.try_into();
        three.map(Vec3::from).map_err(|_| {
            self.error(value.span().start, format!("{key}: give three numbers, red, green, blue"))
        })
    }

    fn flag(&self, key: &str, value: &Value<'_>) -> Result<bool> {
        match value.get_ref() {
            DeValue::Boolean(flag) => Ok(*flag),
            _ => Err(self.error(value.span().start, format!("{key}: give true or false"))),
        }
    }

    fn word<'w>(&self, key: &str, value: &Value<'_>, known: &[&'w str]) -> Result<&'w str> {
        let found = match value.get_ref() {
            DeValue::String(word) => known.iter().find(|k| **k == &**word),
            _ => None,
        };
        found.copied().ok_or_else(|| {
            let known = known.join("\", \"");
            self.error(value.span().start, format!("{key}: give one of \"{known}\""))
        })
    }

    fn table<'t, 'v>(&self, key: &str, value: &'t Value<'v>) -> Result<&'t DeTable<'v>> {
        match value.get_ref() {
            DeValue::Table(table) => Ok(table),
            _ => Err(self.error(value.span().start, format!("{key}: write {{ ... }}"))),
        }
    }

    fn emission(&self, value: &Value<'_>) -> Result<MaterialEmission> {
        let (mut colour, mut intensity, mut parts) = (None, None, Emitting::default());
        for (key, value) in self.table("emission", value)? {
            let at = key.span().start;
            let key: &str = key.get_ref();
            self.known(key, at, &EMISSION_KEYS)?;
            match key {
                "colour" => colour = Some(self.share("emission.colour", value)?),
                "intensity" => {
                    intensity = Some(self.number("emission.intensity", value, [0.0, 1e6])?);
                }
                _ => {
                    parts = match self.word("emission.parts", value, &PARTS)? {
                        "fullbright" => Emitting::Fullbright,
                        "texture" => Emitting::Texture,
                        _ => Emitting::Face,
                    };
                }
            }
        }
        let intensity = intensity
            .ok_or_else(|| self.error(value.span().start, "emission.intensity is missing"))?;
        Ok(MaterialEmission { colour, intensity, parts })
    }

    fn modifier(&self, value: &Value<'_>) -> Result<Modifier> {
        let (mut kind, mut colour) = (None, None);
        let mut numbers = [None; 3];
        for (key, value) in self.table("modifier", value)? {
            let at = key.span().start;
            let key: &str = key.get_ref();
            self.known(key, at, &MODIFIER_KEYS)?;
            match key {
                "kind" => kind = Some(self.word("modifier.kind", value, &KINDS)?),
                "colour" => colour = Some(self.share("modifier.colour", value)?),
                "size" => numbers[0] = Some(self.number("modifier.size", value, [1.0, 4096.0])?),
                "from" => numbers[1] = Some(self.number("modifier.from", value, [-1e6, 1e6])?),
                _ => numbers[2] = Some(self.number("modifier.to", value, [-1e6, 1e6])?),
            }
        }
        let missing =
            |key: &str| self.error(value.span().start, format!("modifier.{key} is missing"));
        let kind = kind.ok_or_else(|| missing("kind"))?;
        let of_kind: &[&str] = match kind {
            "texel" => &["kind"],
            "checker" => &["kind", "size", "colour"],
            _ => &["kind", "from", "to", "colour"],
        };
        for (key, _) in self.table("modifier", value)? {
            let (at, key): (usize, &str) = (key.span().start, key.get_ref());
            if !of_kind.contains(&key) {
                let known = of_kind.join(", ");
                let problem = format!("modifier.{key}: a {kind} has none, only {known}");
                return Err(self.error(at, problem));
            }
        }
        let colour = || colour.ok_or_else(|| missing("colour"));
        Ok(match kind {
            "texel" => Modifier::Texel,
            "checker" => Modifier::Checker(numbers[0].unwrap_or(32.0), colour()?),
            _ => {
                let from = numbers[1].ok_or_else(|| missing("from"))?;
                let to = numbers[2].ok_or_else(|| missing("to"))?;
                Modifier::Gradient([from, to], colour()?)
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn refused(text: &str, line: usize, words: &str) {
        let message = MaterialFile::parse(text, "m.toml").unwrap_err().to_string();
        assert!(message.starts_with(&format!("m.toml: line {line}: ")), "{message}");
        assert!(message.contains(words) && !message.contains('\n'), "{message}");
    }

    #[test]
    fn all_keys_are_read() {
        let text = "# a comment\n[[material]]\ntexture = [\"A*\", \"b\"]\n\
            reflectance = [0.1, 0.2, 0.3]\ndiffuse_transmission = 0.5\ntwo_sided = true\n\
            alpha_test = true\nbounce = true\nmodifier = { kind = \"checker\", size = 16, colour = 0.5 }\n\
            emission = { colour = [1, 0.5, 0], intensity = 300, parts = \"fullbright\" }\n\
            [[material]]\ntexture = \"c\"\ntransmission = [0.9, 0.1, 0.1]\n\
            modifier = { kind = \"gradient\", from = -64, to = 64.5, colour = [0, 0, 1] }\n";
        let file = MaterialFile::parse(text, "m").unwrap();
        let a = file.of("abc");
        assert_eq!(a.diffuse_transmission, Some(Vec3::splat(0.5)));
        assert_eq!((a.two_sided, a.alpha_test, a.bounce), (Some(true), Some(true), Some(true)));
        assert_eq!(a.modifier, Some(Modifier::Checker(16.0, Vec3::splat(0.5))));
        let emission = a.emission.unwrap();
        assert_eq!((emission.intensity, emission.parts), (300.0, Emitting::Fullbright));
        let c = file.of("C");
        assert_eq!(c.transmission, Some(Vec3::new(0.9, 0.1, 0.1)));
        assert_eq!(c.modifier, Some(Modifier::Gradient([-64.0, 64.5], Vec3::Z)));
        assert_eq!(file.of("d"), Material::default());
    }

    #[test]
    fn complaints_name_line_and_key() {
        let entry = |line: &str| format!("[[material]]\ntexture = \"a\"\n{line}\n");
        refused(&entry("reflektance = 1"), 3, "did you mean \"reflectance\"");
        refused(&entry("reflectance = [1, 2, 3]"), 3, "reflectance: give a number from 0 to 1");
        refused(&entry("reflectance = [1, 0]"), 3, "reflectance: give three numbers");
        refused(&entry("bounce = 1"), 3, "bounce: give true or false");
        refused(&entry("transmission = nan"), 3, "transmission: give a number");
        refused(&entry("emission = { colour = 1 }"), 3, "emission.intensity is missing");
        refused(&entry("emission = { intensty = 1 }"), 3, "did you mean \"intensity\"");
        refused(&entry("modifier = { kind = \"cheker\" }"), 3, "modifier.kind: give one of");
        refused(
            &entry("modifier = { kind = \"gradient\", from = 1 }"),
            3,
            "modifier.to is missing",
        );
        refused("[[material]]\nbounce = true\n", 1, "texture: an entry names");
        refused("[material]\ntexture = \"a\"\n", 1, "two brackets");
        refused("[[materials]]\ntexture = \"a\"\n", 1, "did you mean \"material\"");
        refused(&entry("reflectance = [0.7, 0, 0]\ntransmission = 0.4"), 4, "more than 1");
        refused(&entry("modifier = { kind = \"texel\", size = 8 }"), 3, "modifier.size: a texel");
        refused(&entry("bounce = true\ntransmission = 0\ndiffuse_transmission = 0"), 5, "not both");
        refused("[[material]\n", 1, "");
        refused("a = \n", 1, "");
    }
}
