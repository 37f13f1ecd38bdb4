//! One run on a text scene: files in, files out.

use anyhow::Context;
use qrad::aim::TextLadder;
use qrad::cli::Cli;
use qrad::patch::{PatchEffects, TextScene, decode};
use qrad::progress::Progress;
use qrad::radiosity::near_pairs::NearLimits;
use qrad::report::Report;
use qrad::run_report::{self, RunReport};
use qrad::scene::effects::Effect;
use qrad::{aim, check, light_patches_with, output, sweep, text_plan};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

/// Lights the scene in `path` and writes it where the command line says, with `writing` locked.
pub fn run(cli: &Cli, path: &Path, visible: bool, writing: &Mutex<()>) -> anyhow::Result<()> {
    let start = Instant::now();
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let name = path.display().to_string();
    let mut scene = TextScene::parse(decode(&bytes, &name)?, &name)?;
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
        let target = cli.accuracy.target_error;
        let mut bench = sweep::TextBench::new(&name, scene, truth, target, &[&bytes, &file])?;
        return crate::sweep_job::run(folder, &mut bench, cli.quiet, visible);
    }
    let switches = cli.effects.switches()?;
    text_plan::apply(&switches, &mut scene);
    let asked = text_plan::plan(&scene, cli.near().is_some(), &switches);
    switches.check(|effect| asked.is_on(effect))?;
    if cli.effects.explain {
        let near = cli.near().is_some() && !switches.off(Effect::NearField);
        let mut plan = text_plan::plan(&scene, near, &switches);
        text_plan::predict(&mut plan, &scene, cli.quality)?;
        print!("{plan}");
        return Ok(());
    }
    if cli.accuracy.estimate {
        print!(
            "{}",
            crate::estimate_table::of_text(&aim::estimate_text(
                &scene,
                &TextLadder::default(),
                |_| true
            )?)
        );
        return Ok(());
    }
    let target = cli.output.clone().unwrap_or_else(|| lit_name(path));
    let to_stdout = target == Path::new("-");
    if !to_stdout {
        output::check_distinct(&[&target], &[path])?;
        output::check_writable(&target)?;
    }
    if let Some(report) = &cli.accuracy.report {
        run_report::check_name(report)?;
        output::check_distinct(&[&target, report], &[path])?;
        output::check_writable(report)?;
    }
    let progress = Progress::new(visible);
    let (near, choices) = chosen(cli, &scene)?;
    let near = near.filter(|_| !switches.off(Effect::NearField));
    choices.iter().for_each(|sentence| progress.say(sentence));
    let (transfers, solution) = light_patches_with(&scene, near, &progress)?;
    let checked = if cli.accuracy.no_check {
        (None, None)
    } else {
        let end = progress.deadline(check::end(progress.elapsed(), check::SHARE));
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
    let mut report = Report::new();
    for sentence in &choices {
        report.row("chosen", sentence);
    }
    report.count("patches", scene.patches.len() as u64);
    report.count("transfers", transfers.len() as u64);
    report.row("passes", format!("{} of at most {}", solution.passes, scene.passes));
    report.count("channels", solution.channels.count());
    report.row("residual", format!("{:.1e}", solution.residual));
    report.row("ended", if solution.settled { "nothing left to send" } else { "passes used up" });
    report.accuracy(&checked);
    let stages = progress.stages();
    if checked.0.is_some() && choices.is_empty() {
        let quality = near.is_some().then_some(cli.quality);
        let seconds = start.elapsed().as_secs_f64();
        let half = aim::half_error_text(quality, &stages, seconds);
        report.half_error(half.map(|h| h.0));
    }
    report.resources(&stages, start.elapsed());
    report.row("written", if to_stdout { "-".into() } else { target.display().to_string() });
    if let Some(file) = &cli.accuracy.report {
        let mut all = RunReport::new(path, &report, &stages, start.elapsed(), checked);
        let [width, height] = scene.hemicube;
        let mut plan = text_plan::plan(&scene, near.is_some(), &switches);
        text_plan::measure(&mut plan, &scene, (&transfers, &solution), &stages);
        all.plan = plan.to_string();
        let near = near.map_or("off".to_owned(), |n| format!("{n:?}"));
        all.settings = vec![
            ("hemicube".into(), format!("{width} x {height}")),
            ("near field".into(), near),
            ("passes".into(), scene.passes.to_string()),
        ];
        all.choices = choices;
        let _whole = writing.lock();
        all.write(file)?;
    }
    if cli.quiet {
        return Ok(());
    }
    // The scene has standard output for itself.
    if to_stdout {
        eprint!("{report}");
    } else {
        print!("{report}");
    }
    Ok(())
}

/// Which pairs get closed forms, and how that was chosen if an error is asked for.
fn chosen(cli: &Cli, scene: &TextScene) -> anyhow::Result<(Option<NearLimits>, Vec<String>)> {
    let Some(target) = cli.accuracy.target_error else { return Ok((cli.near(), Vec::new())) };
    let ladder = TextLadder::default();
    let quality = ladder.quality(target);
    let start = Instant::now();
    let predicted = aim::estimate_text(scene, &ladder, |q| q == quality)?;
    let pilot = start.elapsed().as_secs_f64();
    let of = predicted.iter().find(|p| p.quality == quality);
    let (seconds, error) = of.map_or((0.0, 0.0), |p| (p.seconds, p.error));
    let sentence = format!(
        "for an error of {:.2} %: quality {}, with an error below {:.2} % expected, in {:.2} s as a whole",
        100.0 * target,
        format!("{quality:?}").to_lowercase(),
        100.0 * error,
        pilot + seconds
    );
    let mut said = vec![sentence];
    if scene.patches.iter().any(|q| q.effects != PatchEffects::default()) {
        said.push(
            "expected errors are those of scenes without light that comes through and without \
             patterns: the check at the end tells that of this one"
                .into(),
        );
    }
    if error > target {
        said.push("the target is out of reach of all presets".into());
    }
    Ok((Some(quality.near()), said))
}

/// `NAME-lit.txt` beside `NAME.txt`.
fn lit_name(path: &Path) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push("-lit.txt");
    path.with_file_name(name)
}
