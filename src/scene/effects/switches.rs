//! Effects that the user switches, whatever the scene calls for.

use super::Effect;
use crate::{Error, Result};
use clap::ValueEnum;

/// The option that holds them.
const OPTION: &str = "--effects";

/// Which effects are switched on or off by hand; the last word on an effect counts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Switches(Vec<(Effect, bool)>);

impl Switches {
    /// Reads `+dirt,-suns`.
    ///
    /// # Errors
    /// When a sign is missing or a name is none of an effect.
    pub fn parse(text: &str) -> Result<Self> {
        let mut switches = Vec::new();
        for word in text.split(',').map(str::trim).filter(|w| !w.is_empty()) {
            let (on, name) = match (word.strip_prefix('+'), word.strip_prefix('-')) {
                (Some(name), _) => (true, name),
                (_, Some(name)) => (false, name),
                _ => {
                    let problem = format!("{word:?}: write +{word} or -{word}");
                    return Err(Error::setting(OPTION, problem));
                }
            };
            let effect = Effect::from_str(name, true).map_err(|_| unknown(name))?;
            switches.push((effect, on));
        }
        if switches.is_empty() {
            return Err(Error::setting(
                OPTION,
                format!("{text:?}: name effects, as in +dirt,-suns"),
            ));
        }
        Ok(Self(switches))
    }

    /// Whether the user switched an effect on or off; `None` is neither.
    pub fn of(&self, effect: Effect) -> Option<bool> {
        self.0.iter().rev().find(|(e, _)| *e == effect).map(|(_, on)| *on)
    }

    /// Refuses an effect that is switched on but is not `on`, as more would have to be known for that.
    ///
    /// # Errors
    /// The first such effect, with what to do.
    pub fn check(&self, on: impl Fn(Effect) -> bool) -> Result<()> {
        let wanted = self.0.iter().map(|s| s.0).filter(|&e| self.of(e) == Some(true));
        for effect in wanted {
            if let Some(advice) = needs(effect).filter(|_| !on(effect)) {
                return Err(Error::setting(OPTION, format!("+{}: {advice}", effect.name())));
            }
        }
        Ok(())
    }

    /// Whether the user switched an effect off.
    pub fn off(&self, effect: Effect) -> bool {
        self.of(effect) == Some(false)
    }
}

fn unknown(name: &str) -> Error {
    let names: Vec<String> = Effect::value_variants().iter().map(|e| e.name()).collect();
    Error::setting(OPTION, format!("{name:?} is no effect: use one of {}", names.join(", ")))
}

/// What else would have to be known to switch an effect on.
fn needs(effect: Effect) -> Option<&'static str> {
    match effect {
        Effect::Styles | Effect::Lights | Effect::NegativeLight | Effect::Projections => {
            Some("only lights of the map can ask for this")
        }
        Effect::SurfaceLights => Some("only lights with _surface can ask for this, or --radlights"),
        Effect::Suns => Some("say how bright: --set _sunlight=200"),
        Effect::SkyDomes => Some("say how bright: --set _sunlight2=100"),
        Effect::Minlight => Some("say how bright: --set _minlight=20"),
        Effect::Phong => Some("only brush models and texinfo with _phong can ask for this"),
        Effect::Fences | Effect::Glass | Effect::ModelShadows => {
            Some("only brush models, a material file or a text scene can ask for this")
        }
        Effect::Curtains | Effect::Shaders => {
            Some("only a material file or a text scene can ask for this")
        }
        Effect::FaceStyles => Some("say how many: --facestyles 8"),
        Effect::LuxelSizes => Some("say how large: --world_units_per_luxel 8"),
        Effect::LightGrid => Some("say so with --lightgrid"),
        Effect::Colour
        | Effect::Dirt
        | Effect::Bounces
        | Effect::NearField
        | Effect::Supersampling
        | Effect::Lit
        | Effect::Hdr
        | Effect::BspxLight
        | Effect::Directions
        | Effect::FaceNormals => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_word_on_an_effect_counts() {
        let switches = Switches::parse("+dirt, -suns,-dirt").unwrap();
        assert!(switches.off(Effect::Dirt) && switches.off(Effect::Suns));
        assert_eq!(switches.of(Effect::Lit), None);
    }

    #[test]
    fn what_cannot_be_read_is_refused_with_what_to_do() {
        let error = |text| Switches::parse(text).unwrap_err().to_string();
        assert!(error("dirt").contains("+dirt or -dirt"));
        assert!(error("-drit").contains("sky-domes"));
        assert!(error(" ,").contains("name effects"));
        let switches = Switches::parse("+suns,+dirt,+phong,-phong").unwrap();
        assert!(switches.check(|_| true).is_ok(), "what the map asks for may be named");
        assert!(switches.check(|_| false).unwrap_err().to_string().contains("_sunlight"));
    }
}
