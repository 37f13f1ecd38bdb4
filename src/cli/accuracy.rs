//! Options that tell of errors and times, and choose by them.

use clap::Args;
use std::path::PathBuf;

/// What is told of errors and times.
#[derive(Clone, Debug, Default, Args)]
pub struct AccuracyArgs {
    /// Do not light some points again to tell how far off the result is
    #[arg(long, help_heading = "Accuracy")]
    pub no_check: bool,

    /// Write a report of the run: .html with plots and lightmaps, or .json
    #[arg(long, value_name = "FILE", help_heading = "Accuracy")]
    pub report: Option<PathBuf>,

    /// Light it at many settings and write into a folder what each costs and how far off it is:
    /// sweep.csv, plots and sweep.html; goes on where it was interrupted, writes no map
    #[arg(long, value_name = "DIR", conflicts_with_all = ["report", "output"], help_heading = "Accuracy")]
    pub sweep: Option<PathBuf>,

    /// Light that should come out, as a CSV file, for --sweep to compare with [default: the finest]
    #[arg(long, value_name = "FILE.csv", requires = "sweep", help_heading = "Accuracy")]
    pub truth: Option<PathBuf>,
}
