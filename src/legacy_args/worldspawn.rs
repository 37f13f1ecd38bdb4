//! Options that a map gives itself: in the reference every option can be a worldspawn key.

use super::{Effect, Values, find, number};
use crate::bsp::Entity;
use clap::Command;
use std::ffi::OsString;

/// Options that the scene reads as keys itself.
const OF_THE_SCENE: &[&str] = &["world-units-per-luxel"];

/// Options that a map must not set: they say how a run talks to its user, not what it makes.
const OF_THE_USER: [&str; 2] = ["quiet", "verbose"];

/// Arguments of `qrad` that mean what the keys of worldspawn say, as far as the scene does not read
/// those keys itself. Paths and unusable values are left out; 0 and -1 switch off.
pub fn of_worldspawn(world: &Entity, own: &Command) -> Vec<OsString> {
    let mut args = Vec::new();
    for (key, value) in world.pairs() {
        let Some(option) = find(key.trim_start_matches('_')) else { continue };
        let Effect::Own(long, _) = option.effect else { continue };
        if OF_THE_USER.contains(&long)
            || OF_THE_SCENE.contains(&long)
            || !own.get_arguments().any(|a| a.get_long() == Some(long))
        {
            continue;
        }
        let value = value.trim();
        let is_number = value.split_ascii_whitespace().all(|w| number(w).is_some());
        let given = match option.values {
            Values::Switch => (!matches!(value, "0" | "-1")).then(|| format!("--{long}")),
            Values::OptionalNumber if value.is_empty() => Some(format!("--{long}")),
            Values::Text => None,
            Values::Word(_) => Some(format!("--{long}={value}")),
            _ => (is_number && !value.is_empty()).then(|| format!("--{long}={value}")),
        };
        args.extend(given.map(OsString::from));
    }
    args
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::Cli;
    use clap::CommandFactory;

    #[test]
    fn keys_of_options_become_options_and_others_do_not() {
        let mut world = Entity::default();
        for (key, value) in [
            ("classname", "worldspawn"),
            ("_extra4", "1"),
            ("lit", ""),
            ("_hdr", "0"),
            ("__facestyles", "8"),
            ("_lmshift", "x"),
            ("_soft", ""),
            ("_dist", "2"),
            ("_quiet", "1"),
            ("radlights", "/etc/passwd"),
            ("message", "-extra"),
        ] {
            world.set(key, value);
        }
        let args = of_worldspawn(&world, &Cli::command());
        assert_eq!(args, ["--extra4", "--lit", "--facestyles=8", "--soft"]);
    }
}
