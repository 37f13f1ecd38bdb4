//! Running `qrad` as a program.

use assert_cmd::Command;
use std::path::Path;
use std::process::Output;

/// `qrad` with a clean environment.
pub fn qrad() -> Command {
    let mut command = Command::cargo_bin("qrad").unwrap();
    command.env_remove("RUST_LOG").env_remove("RUST_BACKTRACE").env_remove("RAYON_NUM_THREADS");
    command
}

/// Runs `qrad INPUT OPTIONS...`, which must succeed.
#[track_caller]
pub fn run(input: &Path, options: &[&str]) -> Output {
    qrad().arg(input).args(options).assert().success().get_output().clone()
}

/// Runs `qrad INPUT OPTIONS...`, which must fail with exit code 1 and one line on standard error
/// that starts with `qrad: error:`. Returns that line.
#[track_caller]
pub fn fail(input: &Path, options: &[&str]) -> String {
    let output = qrad().arg(input).args(options).assert().code(1).get_output().clone();
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(text.starts_with("qrad: error: ") && text.trim_end().lines().count() == 1, "{text}");
    assert!(output.stdout.is_empty(), "a failed run prints no report");
    text
}

/// A path as an argument.
pub fn arg(path: &Path) -> &str {
    path.to_str().unwrap()
}
