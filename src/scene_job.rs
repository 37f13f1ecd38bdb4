//! One run on a text scene: files in, files out.

use anyhow::Context;
use qrad::cli::Cli;
use qrad::patch::{TextScene, decode};
use qrad::progress::Progress;
use qrad::report::Report;
use qrad::{check, light_patches_with, output, sweep};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

/// Lights the scene in `path` and writes it where the command line says, with `writing` locked.
pub fn run(cli: &Cli, path: &Path, visible: bool, writing: &Mutex<()>) -> anyhow::Result<()> {
    let start = Instant::now();
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let name = path.display().to_string();
    let scene = TextScene::parse(decode(&bytes, &name)?, &name)?;
    if let Some(folder) = &cli.accuracy.sweep {
        let file = crate::map_job::read_optional(cli.accuracy.truth.as_deref())?;
        let truth = match &cli.accuracy.truth {
            Some(path) => {
                let (text, name) = (String::from_utf8_lossy(&file), path.display().to_string());
                Some(sweep::text_truth(&text, &name)?)
            }
            None => None,
        };
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let mut bench = sweep::TextBench::new(&name, scene, truth, &[&bytes, &file])?;
        return crate::sweep_job::run(folder, &mut bench, cli.quiet, visible);
    }
    let target = cli.output.clone().unwrap_or_else(|| lit_name(path));
    let to_stdout = target == Path::new("-");
    if !to_stdout {
        output::check_distinct(&[&target], &[path])?;
        output::check_writable(&target)?;
    }
    let progress = Progress::new(visible);
    let (transfers, solution) = light_patches_with(&scene, cli.near(), &progress)?;
    let checked = if cli.accuracy.no_check {
        (None, None)
    } else {
        let end = Instant::now() + check::budget(progress.elapsed());
        let _stage = progress.stage("check", 1);
        check::check_patches(&scene, &transfers, &solution, end)
    };
    let exitance: Vec<[f64; 3]> =
        solution.exitance.iter().map(|m| m.0.as_dvec3().to_array()).collect();
    let text = scene.lit(&exitance).to_text();
    if to_stdout {
        std::io::stdout().write_all(text.as_bytes()).context("cannot write standard output")?;
    } else {
        let _whole = writing.lock();
        output::write(&target, text.as_bytes())?;
    }
    if cli.quiet {
        return Ok(());
    }
    let mut report = Report::new();
    report.count("patches", scene.patches.len() as u64);
    report.count("transfers", transfers.len() as u64);
    report.row("passes", format!("{} of at most {}", solution.passes, scene.passes));
    report.row("residual", format!("{:.1e}", solution.residual));
    report.row("ended", if solution.settled { "nothing left to send" } else { "passes used up" });
    report.accuracy(&checked);
    report.resources(&progress.stages(), start.elapsed());
    report.row("written", if to_stdout { "-".into() } else { target.display().to_string() });
    // The scene has standard output for itself.
    if to_stdout {
        eprint!("{report}");
    } else {
        print!("{report}");
    }
    Ok(())
}

/// `NAME-lit.txt` beside `NAME.txt`.
fn lit_name(path: &Path) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push("-lit.txt");
    path.with_file_name(name)
}
