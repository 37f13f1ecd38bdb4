//! Options that tell of errors and times, and choose by them.

use clap::Args;

/// What is told of errors and times.
#[derive(Clone, Debug, Default, Args)]
pub struct AccuracyArgs {
    /// Do not light some points again to tell how far off the result is
    #[arg(long, help_heading = "Accuracy")]
    pub no_check: bool,
}
