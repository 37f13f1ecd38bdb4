//! `qrad`: the command line. Reads files, calls the library, prints; the only place that decides an
//! exit code.

mod estimate_table;
mod map_job;
mod scene_job;
mod sweep_job;

use clap::{CommandFactory, Parser};
use log::LevelFilter;
use qrad::cli::Cli;
use qrad::legacy_args;
use std::ffi::OsString;
use std::io::{IsTerminal, Write};
use std::process::ExitCode;
use std::sync::{Arc, Mutex};

/// Exit code after an interrupt, as shells give it.
const INTERRUPTED: i32 = 130;
/// Exit code for a command line that cannot be used; clap exits with the same.
const USAGE: u8 = 2;

fn main() -> ExitCode {
    let (args, notes) = match legacy_args::rewrite(std::env::args_os().collect(), &Cli::command()) {
        Ok(rewritten) => rewritten,
        Err(error) => {
            eprintln!("qrad: error: {error}");
            return ExitCode::from(USAGE);
        }
    };
    let cli = Cli::parse_from(&args);
    let level = match (cli.quiet, cli.verbose) {
        (true, _) => LevelFilter::Error,
        (_, true) => LevelFilter::Debug,
        _ => LevelFilter::Warn,
    };
    env_logger::Builder::new()
        .filter_level(LevelFilter::Error)
        .filter_module("qrad", level)
        .format(|out, record| {
            writeln!(out, "{}: {}", record.level().as_str().to_lowercase(), record.args())
        })
        .init();
    for note in notes {
        log::warn!("{note}");
    }
    match run(&cli, &args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("qrad: error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(cli: &Cli, args: &[OsString]) -> anyhow::Result<()> {
    if let Some(shell) = cli.completions {
        clap_complete::generate(shell, &mut Cli::command(), "qrad", &mut std::io::stdout());
        return Ok(());
    }
    let threads = rayon::ThreadPoolBuilder::new().num_threads(cli.threads()?).build()?;
    let visible = !cli.quiet && std::io::stderr().is_terminal();
    // Locked while files are written: an interrupt then waits until they are whole and nothing that is
    // half written lies beside them.
    let writing = Arc::new(Mutex::new(()));
    let lock = Arc::clone(&writing);
    ctrlc::set_handler(move || {
        let _whole = lock.lock();
        std::process::exit(INTERRUPTED);
    })?;
    threads.install(|| match (&cli.patches, &cli.map) {
        (Some(scene), _) => scene_job::run(cli, scene, visible, &writing),
        (None, Some(map)) => {
            map_job::run((cli, args), &qrad::cli::map_path(map), visible, &writing)
        }
        (None, None) => Ok(()),
    })
}
