//! Options that tell of errors and times, and choose by them.

use crate::aim::Aim;
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

    /// Choose the settings of bounced light for an error, such as 2%, and tell what they take; with
    /// --sweep, that is the only point of the sweep
    #[arg(long, value_name = "PERCENT", value_parser = share)]
    #[arg(conflicts_with_all = ["time_budget", "quality", "hemicube", "patch_size", "gather"])]
    #[arg(help_heading = "Accuracy")]
    pub target_error: Option<f64>,

    /// Give the best light that fits into a time, such as 30s or 2m (maps)
    #[arg(long, value_name = "TIME", value_parser = seconds, conflicts_with = "patches")]
    #[arg(conflicts_with_all = ["sweep", "quality", "hemicube", "patch_size", "gather"])]
    #[arg(help_heading = "Accuracy")]
    pub time_budget: Option<f64>,

    /// Write the map whenever there is light for it, so that an interrupt leaves the best so far
    #[arg(long, requires = "time_budget", help_heading = "Accuracy")]
    pub keep_partial: bool,

    /// Print what each preset would take on this map, and how far off it would be; light nothing
    #[arg(long, conflicts_with_all = ["sweep", "report", "target_error", "time_budget", "output"])]
    #[arg(help_heading = "Accuracy")]
    pub estimate: bool,
}

impl AccuracyArgs {
    /// What the run is to reach.
    pub fn aim(&self) -> Aim {
        match (self.target_error, self.time_budget) {
            (Some(error), _) => Aim::Error(error),
            (_, Some(seconds)) => Aim::Time(seconds),
            _ => Aim::Settings,
        }
    }
}

/// Reads `2%` or `2` as 0.02.
fn share(text: &str) -> Result<f64, String> {
    let number = text.trim_end_matches('%').trim().parse::<f64>();
    number.map(|n| n / 100.0).map_err(|_| "give percent, such as 2%".into())
}

/// Reads `30`, `30s`, `2m` or `1h` as seconds.
fn seconds(text: &str) -> Result<f64, String> {
    let (number, unit) = match text.strip_suffix(['s', 'm', 'h']) {
        Some(number) => (number, &text[number.len()..]),
        None => (text, "s"),
    };
    let factor = match unit {
        "h" => 3600.0,
        "m" => 60.0,
        _ => 1.0,
    };
    let number = number.trim().parse::<f64>();
    number.map(|n| n * factor).map_err(|_| "give a time, such as 30s or 2m".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_and_times_are_read() {
        assert_eq!(share("2%"), Ok(0.02));
        assert_eq!(share("0.5"), Ok(0.005));
        assert!(share("few").is_err());
        assert_eq!(["30", "30s", "2m", "1h"].map(seconds), [Ok(30.), Ok(30.), Ok(120.), Ok(3600.)]);
        assert!(seconds("soon").is_err() && seconds("").is_err());
    }
}
