//! A run plans its memory before it takes it: larger patches, saying so, rather than too much.

mod support;

use assert_cmd::Command;
use std::path::Path;

fn light(limit: &str, out: &Path, more: &[&str]) -> std::process::Output {
    let mut command = Command::cargo_bin("qrad").unwrap();
    command.arg(support::maps_dir().join("atrium.bsp")).arg("-o").arg(out);
    command.args(["--memory-limit", limit]).args(more).output().unwrap()
}

fn row(text: &str, name: &str) -> u64 {
    let line = text.lines().find(|l| l.starts_with(name)).unwrap();
    let number: String = line[name.len()..].chars().filter(char::is_ascii_digit).collect();
    number.parse().unwrap()
}

#[test]
fn patches_grow_until_form_factors_fit_and_that_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let run = |limit: &str| {
        let out = folder.path().join(limit).with_extension("bsp");
        let output = light(limit, &out, &["--quality", "draft", "--patch-size", "2"]);
        assert!(output.status.success());
        let said = String::from_utf8(output.stderr).unwrap();
        (String::from_utf8(output.stdout).unwrap(), said)
    };
    let (large, said) = run("8G");
    assert!(!said.contains("memory-limit"), "{said}");
    let whole = row(&large, "peak memory");
    let (small, said) = run("40M");
    assert!(said.contains("luxels instead of 2") && said.contains("--memory-limit"), "{said}");
    assert!(row(&small, "patches") < row(&large, "patches") / 2);
    // Nothing promises the last megabyte: the estimate is one of form factors.
    let kept = row(&small, "peak memory");
    assert!(whole > 50 && kept <= 45, "{whole} and {kept} MiB");
}

#[test]
fn samples_that_do_not_fit_are_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.bsp");
    let output = light("24M", &out, &["--extra4"]);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("memory for the samples of") && said.contains("--extra4"), "{said}");
    assert!(!out.exists());
}
