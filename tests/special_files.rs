//! A run does not take the place of what is no plain file, and follows links.
#![cfg(unix)]

mod support;

use assert_cmd::Command;
use qrad::bsp::Bsp;
use std::os::unix::fs::{FileTypeExt, symlink};
use std::path::Path;

fn light(map: &Path, more: &[&str]) {
    Command::cargo_bin("qrad")
        .unwrap()
        .arg(map)
        .args(["-q", "--bounces", "0"])
        .args(more)
        .assert()
        .success();
}

#[test]
fn a_pipe_gets_the_map_and_stays_a_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let (pipe, plain) = (folder.path().join("pipe"), folder.path().join("plain.bsp"));
    let map = support::maps_dir().join("cornell.bsp");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || std::fs::read(pipe).unwrap()
    });
    light(&map, &["--lit", "-o", pipe.to_str().unwrap()]);
    // A run that renames over the pipe leaves its reader waiting.
    assert!(pipe.symlink_metadata().unwrap().file_type().is_fifo());
    light(&map, &["-o", plain.to_str().unwrap()]);
    assert!(reader.join().unwrap() == std::fs::read(&plain).unwrap());
    assert!(!pipe.with_extension("lit").exists());
}

#[test]
fn a_link_stays_and_its_file_is_lit() {
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("file.bsp"), folder.path().join("link.bsp"));
    std::fs::copy(support::maps_dir().join("cornell.bsp"), &file).unwrap();
    let before = std::fs::read(&file).unwrap();
    symlink("file.bsp", &link).unwrap();
    light(&link, &["--lit"]);
    assert!(link.is_symlink());
    let after = std::fs::read(&file).unwrap();
    assert!(before != after && !Bsp::read(&after).unwrap().lighting.is_empty());
    assert!(link.with_extension("lit").exists());
}
