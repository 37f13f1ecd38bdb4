//! Options about the effects that are simulated.

use crate::Result;
use crate::scene::effects::Switches;
use clap::Args;

/// Which effects are simulated, and why.
#[derive(Clone, Debug, Default, Args)]
pub struct EffectArgs {
    /// Print which effects of light the map or scene calls for, why, and what they are expected to take; light
    /// nothing
    #[arg(long, help_heading = "Effects", conflicts_with_all = ["output", "quiet"])]
    pub explain: bool,

    /// Switch effects on or off, whatever the map calls for, such as +dirt,-suns; `--explain` lists them
    #[arg(long, value_name = "+ON,-OFF", allow_hyphen_values = true, help_heading = "Effects")]
    pub effects: Option<String>,
}

impl EffectArgs {
    /// What is switched by hand.
    ///
    /// # Errors
    /// When a word cannot be read.
    pub fn switches(&self) -> Result<Switches> {
        self.effects.as_deref().map_or(Ok(Switches::default()), Switches::parse)
    }
}
