//! A sweep: many settings, one map or scene.

use qrad::memory;
use qrad::progress::Progress;
use qrad::report::Report;
use qrad::sweep::{Bench, sweep};
use std::path::Path;

/// Measures what `folder` lacks and tells how much that was.
pub fn run(folder: &Path, bench: &mut dyn Bench, quiet: bool, visible: bool) -> anyhow::Result<()> {
    let progress = Progress::new(visible);
    let swept = sweep(folder, bench, &progress)?;
    if quiet {
        return Ok(());
    }
    let mut report = Report::new();
    report.count("points measured", swept.measured as u64);
    report.count("points known", swept.table.len() as u64);
    report.resources(&progress.stages(), progress.elapsed());
    report.row("written", folder.join("sweep.html").display());
    if memory::peak().is_none() {
        report.row("memory", "not known here");
    }
    print!("{report}");
    Ok(())
}
