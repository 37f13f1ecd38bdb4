//! Interrupting a run at any moment leaves the old file or the new one, whole.
#![cfg(unix)]

mod support;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use qrad::bsp::Bsp;

const OPTIONS: [&str; 4] = ["--hemicube", "32", "--threads", "2"];

fn qrad(map: &Path) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("qrad"));
    command.arg(map).args(OPTIONS).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// Names of the files in a folder.
fn names(folder: &Path) -> Vec<PathBuf> {
    let mut names: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    names
}

/// Interrupts runs with `signal` at moments spread over a whole run; returns how many ended early.
fn interrupt(signal: &str, moments: u32, leaves_nothing: bool) -> u32 {
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("map.bsp");
    let (lit, source) = (map.with_extension("lit"), support::maps_dir().join("cornell.bsp"));
    std::fs::copy(&source, &map).unwrap();
    let start = Instant::now();
    assert!(qrad(&map).status().unwrap().success());
    let whole = start.elapsed();
    let (new_map, new_lit) = (std::fs::read(&map).unwrap(), std::fs::read(&lit).unwrap());
    let old_map = std::fs::read(&source).unwrap();
    assert!(old_map != new_map && Bsp::read(&new_map).is_ok());

    let mut early = 0;
    for moment in 0..moments {
        for file in names(folder.path()) {
            std::fs::remove_file(file).unwrap();
        }
        std::fs::copy(&source, &map).unwrap();
        let mut child = qrad(&map).spawn().unwrap();
        // More of the moments fall near the end, where files are written.
        let share = 1.1 * (f64::from(moment + 1) / f64::from(moments)).sqrt();
        std::thread::sleep(Duration::from_secs_f64(whole.as_secs_f64() * share));
        let id = child.id().to_string();
        let _ = Command::new("kill").args([signal, &id]).stderr(Stdio::null()).status();
        early += u32::from(!child.wait().unwrap().success());

        let found = std::fs::read(&map).unwrap();
        assert!(found == old_map || found == new_map, "{signal} at {share:.2}: a broken map");
        if let Ok(found) = std::fs::read(&lit) {
            assert!(found == new_lit, "{signal} at {share:.2}: a broken .lit");
        }
        if leaves_nothing {
            let others: Vec<PathBuf> =
                names(folder.path()).into_iter().filter(|p| *p != map && *p != lit).collect();
            assert!(others.is_empty(), "{signal} at {share:.2} leaves {others:?}");
            assert_eq!(found == new_map, lit.exists(), "{signal} at {share:.2}: half a pair");
        }
    }
    println!("{signal}: {early} of {moments} runs ended early");
    early
}

#[test]
fn sigint_at_any_moment_leaves_the_old_map_or_the_new_pair_and_nothing_else() {
    assert!(interrupt("-INT", 12, true) > 0);
}

#[test]
fn sigterm_at_any_moment_leaves_the_old_map_or_the_new_pair_and_nothing_else() {
    assert!(interrupt("-TERM", 6, true) > 0);
}

#[test]
fn sigkill_at_any_moment_leaves_the_old_map_or_the_new_one() {
    assert!(interrupt("-KILL", 12, false) > 0);
}
