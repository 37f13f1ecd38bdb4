//! What stands after the six numbers of a patch's second line: light that passes through the patch,
//! and shaders that vary its values over its area.

use super::text_check::Checked;
use super::text_lines::excerpt;
use super::text_scene::{Reading, write_number};
use crate::error::nearest;

/// What a patch of a text scene does besides giving off and reflecting light. The default is nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PatchEffects {
    /// Share of light that passes straight through, RGB, from 0 to 1. Such a patch blocks nothing else.
    pub straight: Option<[f64; 3]>,
    /// Share of light that leaves the other side diffusely, RGB, from 0 to 1.
    pub diffuse: Option<[f64; 3]>,
    /// The back reflects and gives off light as the front does.
    pub two_sided: bool,
    /// How all values of the patch vary over it.
    pub shader: Option<Shader>,
    /// In a lit scene: final exitance of the back of a patch with two sides.
    pub back: Option<[f64; 3]>,
}

/// How the values of a patch vary over it: each is multiplied by a factor from 0 to 1 a channel. The
/// patch's first edge and the direction at right angles to it, inwards, are the axes; both run from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shader {
    /// Columns and rows of equal cells, 1 to 4096 each; every other one, not the first, is multiplied.
    Checker([u32; 2], [f64; 3]),
    /// Grows along the second axis: 1 at the first edge, this where the patch ends.
    Gradient([f64; 3]),
}

/// Most columns and rows of a checker.
const MAX_CELLS: u32 = 4096;
/// The keywords.
const WORDS: [&str; 6] = ["straight", "diffuse", "two-sided", "checker", "gradient", "back"];
const CHANNELS: [&str; 3] = ["red", "green", "blue"];
/// Sums of decimal fractions may exceed 1 by rounding.
const ROUNDING: f64 = 1e-9;

impl Shader {
    /// The colour that it multiplies by at most.
    pub fn colour_mut(&mut self) -> &mut [f64; 3] {
        match self {
            Self::Checker(_, colour) | Self::Gradient(colour) => colour,
        }
    }

    /// Factor of each channel at a place, the axes running from 0 to 1.
    pub fn factor(&self, s: f64, t: f64) -> [f64; 3] {
        match *self {
            Self::Checker([columns, rows], colour) => {
                let cell = |x: f64, n: u32| (x * f64::from(n)).clamp(0.0, f64::from(n - 1)) as u32;
                let odd = (cell(s, columns) + cell(t, rows)) % 2 == 1;
                if odd { colour } else { [1.0; 3] }
            }
            Self::Gradient(colour) => colour.map(|c| 1.0 + (c - 1.0) * t.clamp(0.0, 1.0)),
        }
    }
}

impl PatchEffects {
    /// Whether the patch has two sides that light meets and leaves: any transmission makes it so.
    pub fn has_two_sides(&self) -> bool {
        self.two_sided || self.straight.is_some() || self.diffuse.is_some()
    }

    /// Whether light passes straight through in some channel.
    pub fn is_translucent(&self) -> bool {
        self.straight.is_some_and(|t| t.iter().any(|&t| t > 0.0))
    }

    /// What is left of them in a lit scene, where `back` is the final exitance of the back.
    pub fn lit(&self, back: Option<[f64; 3]>) -> Self {
        Self { diffuse: None, two_sided: false, back, ..*self }
    }

    /// Reads the words after the six numbers, in any order, each keyword once.
    pub(super) fn read(words: &str, reading: Reading) -> Checked<Self> {
        let mut effects = Self::default();
        let mut words = Words { key: "", words: words.split_whitespace() };
        let mut seen = Vec::new();
        while let Some(word) = words.words.next() {
            let Some(&key) = WORDS.iter().find(|w| **w == word) else {
                let word = excerpt(word);
                let nearest = nearest(&word, WORDS);
                return Err(format!("unknown keyword \"{word}\"; did you mean \"{nearest}\"?"));
            };
            if seen.contains(&key) {
                return Err(format!("{key} is given twice"));
            }
            seen.push(key);
            words.key = key;
            match key {
                "straight" => effects.straight = Some(words.colour(1.0)?),
                "diffuse" => effects.diffuse = Some(words.colour(1.0)?),
                "two-sided" => effects.two_sided = true,
                "gradient" => effects.set(Shader::Gradient(words.colour(1.0)?))?,
                "checker" => {
                    let cells = [words.count("columns")?, words.count("rows")?];
                    effects.set(Shader::Checker(cells, words.colour(1.0)?))?;
                }
                _ if reading == Reading::Raw => {
                    return Err("back: only scenes that are lit already have it".into());
                }
                _ => effects.back = Some(words.colour(f64::MAX)?),
            }
        }
        Ok(effects)
    }

    fn set(&mut self, shader: Shader) -> Checked<()> {
        match self.shader.replace(shader) {
            None => Ok(()),
            Some(_) => Err("a patch has one shader: checker or gradient".into()),
        }
    }

    /// Refuses a patch that would send on more light than meets it.
    pub(super) fn check(&self, reflectance: [f64; 3]) -> Checked<()> {
        let of = |share: Option<[f64; 3]>, i: usize| share.map_or(0.0, |s| s[i]);
        for (i, channel) in CHANNELS.iter().enumerate() {
            let (straight, diffuse) = (of(self.straight, i), of(self.diffuse, i));
            let sum = reflectance[i] + straight + diffuse;
            if sum > 1.0 + ROUNDING {
                let key = if diffuse > 0.0 { "diffuse" } else { "straight" };
                return Err(format!(
                    "{key}: reflectance {} + straight {straight} + diffuse {diffuse} is more than 1 \
                     in {channel}",
                    reflectance[i]
                ));
            }
        }
        Ok(())
    }

    /// Appends the words to a line, a blank before each.
    pub(super) fn write(&self, text: &mut String) {
        let mut add = |key: &str, numbers: &[f64]| {
            text.push(' ');
            text.push_str(key);
            for &x in numbers {
                text.push(' ');
                write_number(text, x);
            }
        };
        self.straight.iter().for_each(|t| add("straight", t));
        self.diffuse.iter().for_each(|t| add("diffuse", t));
        if self.two_sided {
            add("two-sided", &[]);
        }
        match self.shader {
            Some(Shader::Checker([columns, rows], [r, g, b])) => {
                add("checker", &[columns.into(), rows.into(), r, g, b]);
            }
            Some(Shader::Gradient(colour)) => add("gradient", &colour),
            None => {}
        }
        self.back.iter().for_each(|m| add("back", m));
    }
}

/// What follows a keyword.
struct Words<'a> {
    key: &'static str,
    words: std::str::SplitWhitespace<'a>,
}

impl Words<'_> {
    fn value<T: std::str::FromStr>(
        &mut self,
        what: &str,
        fits: impl Fn(&T) -> bool,
        range: &str,
    ) -> Checked<T> {
        let key = self.key;
        let word = self.words.next().ok_or_else(|| format!("{key}: {what} is missing"))?;
        let value = word.parse().ok().filter(fits);
        value.ok_or_else(|| format!("{key}: {what} is \"{}\", not a {range}", excerpt(word)))
    }

    fn colour(&mut self, most: f64) -> Checked<[f64; 3]> {
        let range = if most == 1.0 { "number from 0 to 1" } else { "number from 0 up" };
        let mut colour = [0.0; 3];
        for (value, channel) in colour.iter_mut().zip(CHANNELS) {
            *value = self.value(channel, |x: &f64| (0.0..=most).contains(x), range)?;
        }
        Ok(colour)
    }

    fn count(&mut self, what: &str) -> Checked<u32> {
        let range = format!("whole number from 1 to {MAX_CELLS}");
        self.value(what, |n| (1..=MAX_CELLS).contains(n), &range)
    }
}
