//! The plan of a run: which effects of light the scene calls for, and why. An effect that is off costs
//! nothing: no ray, no memory, no pass.

mod apply;
mod survey;
mod switches;

pub(crate) use apply::{Parts, apply};
pub(crate) use survey::check_switches;
pub use survey::plan;
pub use switches::Switches;

use std::fmt::{self, Display};

/// Whether the code of effects is there. The feature `without-effects`, which is for
/// `benches/effect_code.sh` alone, leaves out of the hot loops what scenes of plain lights, like
/// `maps/effects_none.bsp`, do not call for.
pub(crate) const COMPILED: bool = !cfg!(feature = "without-effects");

/// An effect that a scene may call for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, clap::ValueEnum)]
pub enum Effect {
    /// Three channels of light instead of one
    Colour,
    /// Light styles besides the steady one
    Styles,
    /// Point lights and spotlights
    Lights,
    /// Pictures that lights project
    Projections,
    /// Textures that shine
    SurfaceLights,
    /// Light of suns through sky
    Suns,
    /// Light of the whole sky
    SkyDomes,
    /// Lights that take light away
    NegativeLight,
    /// Minimum light: of the world, of surfaces, of lights and of brush models
    Minlight,
    /// Dirt: corners are darker
    Dirt,
    /// Smoothed normals
    Phong,
    /// Shadows of textures with holes
    Fences,
    /// Light that takes on colour in glass
    Glass,
    /// Shadows that are switched, or fall on some models only
    ModelShadows,
    /// Light that leaves the other side of curtains and paper in all directions
    Curtains,
    /// Reflectance that varies over a surface
    Shaders,
    /// Light that surfaces send back
    Bounces,
    /// Luxels that look for themselves where the points around them disagree
    NearField,
    /// Several samples a luxel
    Supersampling,
    /// Colours in a `.lit` file
    Lit,
    /// Light beyond what bytes hold
    Hdr,
    /// Colours in the map
    BspxLight,
    /// Where light comes from
    Directions,
    /// Normals at the corners of faces
    FaceNormals,
    /// More styles a face than four
    FaceStyles,
    /// Luxels of other sizes than the texture's
    LuxelSizes,
    /// Light at points in space
    LightGrid,
}

impl Effect {
    /// Its name on the command line.
    pub fn name(self) -> String {
        let value = clap::ValueEnum::to_possible_value(&self).expect("no effect is hidden");
        value.get_name().to_owned()
    }
}

/// What an effect takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Rays.
    pub rays: u64,
    /// Cells of hemicubes.
    pub cells: u64,
    /// Bytes of memory.
    pub bytes: u64,
    /// Seconds of one processor.
    pub seconds: f64,
}

impl Display for Cost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = Vec::new();
        for (amount, unit) in [(self.rays, "rays"), (self.cells, "cells"), (self.bytes, "bytes")] {
            if amount > 0 {
                parts.push(format!("{} {unit}", rounded(amount)));
            }
        }
        if self.seconds >= 5e-4 {
            parts.push(format!("{:.3} s", self.seconds));
        }
        f.write_str(if parts.is_empty() { "nothing" } else { "" })?;
        f.write_str(&parts.join(", "))
    }
}

/// A count in three digits and a prefix: 1234567 is 1.23M.
fn rounded(count: u64) -> String {
    let (mut value, mut prefixes) = (count as f64, ["", "k", "M", "G", "T"].iter());
    let mut prefix = prefixes.next().expect("there are five");
    while value >= 999.5 {
        let Some(next) = prefixes.next() else { break };
        (value, prefix) = (value / 1000.0, next);
    }
    match (prefix.is_empty(), value) {
        (true, _) => format!("{value:.0}"),
        (_, v) if v < 9.995 => format!("{v:.2}{prefix}"),
        (_, v) if v < 99.95 => format!("{v:.1}{prefix}"),
        _ => format!("{value:.0}{prefix}"),
    }
}

/// What the plan says of one effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The effect.
    pub effect: Effect,
    /// Whether it is simulated.
    pub on: bool,
    /// Why, in words: what caused it, how often and where.
    pub reason: String,
    /// What it is expected to take, if it is on and that was worked out.
    pub predicted: Option<Cost>,
    /// What it took, after the run.
    pub measured: Option<Cost>,
}

/// Every effect, in the order of [`Effect`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// One entry an effect.
    pub entries: Vec<Entry>,
}

impl Plan {
    /// Whether an effect is on.
    pub fn is_on(&self, effect: Effect) -> bool {
        self.entries.iter().any(|e| e.effect == effect && e.on)
    }

    /// What the plan says of an effect, for a change.
    pub fn entry_mut(&mut self, effect: Effect) -> Option<&mut Entry> {
        self.entries.iter_mut().find(|e| e.effect == effect)
    }
}

impl Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<String> = self.entries.iter().map(|e| e.effect.name()).collect();
        let width = names.iter().map(String::len).max().unwrap_or(0);
        for (entry, name) in self.entries.iter().zip(&names) {
            let state = if entry.on { "on" } else { "off" };
            write!(f, "{name:width$}  {state:3}  {}", entry.reason)?;
            for (when, cost) in [("about", entry.predicted), ("took", entry.measured)] {
                if let Some(cost) = cost {
                    write!(f, "; {when} {cost}")?;
                }
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_three_digits_and_a_prefix() {
        let cases = [(0, "0"), (999, "999"), (1000, "1.00k"), (99_960, "100k"), (12_345, "12.3k")];
        for (count, text) in cases.into_iter().chain([(1_234_567, "1.23M"), (999_999, "1.00M")]) {
            assert_eq!(rounded(count), text);
        }
        let cost = Cost { rays: 1500, seconds: 0.25, ..Cost::default() };
        assert_eq!(cost.to_string(), "1.50k rays, 0.250 s");
        assert_eq!(Cost::default().to_string(), "nothing");
    }
}
