//! Runs on maps that cannot end well: one line says why, and no file changes.

mod support;

use std::path::{Path, PathBuf};
use support::program::{arg, fail, qrad};
use tempfile::TempDir;

/// A folder with a copy of a small map of the project.
fn small_map() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("map.bsp");
    std::fs::copy(support::maps_dir().join("furnace.bsp"), &map).unwrap();
    (folder, map)
}

/// Names and bytes of the files in a folder.
fn contents(folder: &Path) -> Vec<(PathBuf, Option<Vec<u8>>)> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = entries.map(|path| (path.clone(), std::fs::read(path).ok())).collect();
    files.sort();
    files
}

/// The run fails, names `words`, and leaves the folder as it was.
#[track_caller]
fn refused(folder: &TempDir, map: &Path, options: &[&str], words: &[&str]) {
    let before = contents(folder.path());
    let line = fail(map, options);
    let cause = line.trim_end().rsplit(": ").next().unwrap();
    assert_eq!(line.matches(cause).count(), 1, "the cause is told once: {line}");
    for word in words {
        assert!(line.contains(word), "{word:?} is not in {line}");
    }
    assert!(contents(folder.path()) == before, "a file changed: {line}");
}

#[test]
fn a_missing_map_is_named() {
    let (folder, _) = small_map();
    refused(&folder, &folder.path().join("gone.bsp"), &[], &["gone.bsp", "cannot read"]);
    refused(&folder, &folder.path().join("gone"), &[], &["gone"]);
    refused(&folder, folder.path(), &[], &["cannot read", arg(folder.path())]);
}

#[test]
fn garbage_is_no_map() {
    let (folder, map) = small_map();
    for bytes in [&b""[..], b"BSP", b"this is a text file and not a map at all\n", &[0; 4096]] {
        std::fs::write(&map, bytes).unwrap();
        refused(&folder, &map, &[], &["map.bsp"]);
    }
}

#[test]
fn a_map_cut_short_is_refused_wherever_it_is_cut() {
    let (folder, map) = small_map();
    let whole = std::fs::read(&map).unwrap();
    for share in [0.003, 0.01, 0.1, 0.3, 0.5, 0.8, 0.97] {
        std::fs::write(&map, &whole[..(whole.len() as f64 * share) as usize]).unwrap();
        refused(&folder, &map, &[], &["map.bsp"]);
    }
}

#[test]
fn damaged_entities_are_named_with_their_place() {
    let (folder, map) = small_map();
    let mut bytes = std::fs::read(&map).unwrap();
    let at = bytes.windows(11).position(|w| w == b"\"classname\"").unwrap();
    bytes[at - 2] = b'x';
    std::fs::write(&map, &bytes).unwrap();
    refused(&folder, &map, &[], &["map.bsp", "entit"]);
}

#[test]
fn options_out_of_range_are_named() {
    let (folder, map) = small_map();
    for (options, name) in [
        (&["--hemicube", "63"][..], "hemicube"),
        (&["--hemicube", "0"], "hemicube"),
        (&["--hemicube", "99999"], "hemicube"),
        (&["--patch-size", "0"], "--patch-size"),
        (&["--patch-size", "100000"], "--patch-size"),
        (&["--threads", "0"], "--threads"),
        (&["--threads", "1000000"], "--threads"),
        (&["--residual", "0"], "--residual"),
        (&["--residual", "NaN"], "--residual"),
        (&["--reflectance-scale", "inf"], "--reflectance-scale"),
        (&["--reflectance-scale=-1"], "--reflectance-scale"),
        (&["--preview", "p.png", "--camera", "1,2"], "--camera"),
        (&["--preview", "p.png", "--camera", "1,2,3,4,inf"], "--camera"),
        (&["--preview", "p.png", "--preview-size", "64"], "--preview-size"),
        (&["--preview", "p.png", "--preview-size", "0x64"], "--preview-size"),
    ] {
        refused(&folder, &map, options, &[name]);
    }
}

#[test]
fn options_that_are_no_options_get_usage_and_exit_code_2() {
    let (folder, map) = small_map();
    let before = contents(folder.path());
    for options in [
        &["--bounces", "many"][..],
        &["--gather", "guess"],
        &["--no-such-option"],
        &["--camera", "0,0,0,0,0"],
        &["--patches", "scene.txt"],
    ] {
        let output = qrad().arg(&map).args(options).assert().code(2).get_output().clone();
        assert!(output.stdout.is_empty() && !output.stderr.is_empty());
    }
    qrad().assert().code(2);
    assert!(contents(folder.path()) == before);
}

#[test]
fn output_that_cannot_be_written_is_named() {
    let (folder, map) = small_map();
    let inside = |name: &str| folder.path().join(name);
    let there = inside("folder.bsp");
    std::fs::create_dir(&there).unwrap();
    refused(&folder, &map, &["-o", arg(&there)], &["folder.bsp"]);
    refused(&folder, &map, &["-o", arg(&inside("no/such/out.bsp"))], &["no/such/out.bsp"]);
    // A file is no folder.
    refused(&folder, &map, &["-o", arg(&map.join("out.bsp"))], &["out.bsp"]);
    // Where the .lit belongs is a folder, for light with and without colour: nothing is replaced.
    std::fs::create_dir(inside("map.lit")).unwrap();
    refused(&folder, &map, &[], &["map.lit"]);
    std::fs::copy(support::maps_dir().join("cornell.bsp"), &map).unwrap();
    refused(&folder, &map, &["--bounces", "0"], &["map.lit"]);
    // The map's place is a folder: its .lit is not written either.
    refused(&folder, &map, &["-o", arg(&there), "--bounces", "0"], &["folder.bsp"]);
}

#[cfg(unix)]
#[test]
fn a_folder_without_write_permission_is_named() {
    use std::os::unix::fs::PermissionsExt;
    let (folder, map) = small_map();
    let locked = folder.path().join("locked");
    std::fs::create_dir(&locked).unwrap();
    std::fs::set_permissions(&locked, std::fs::Permissions::from_mode(0o555)).unwrap();
    if std::fs::write(locked.join("probe"), b"").is_ok() {
        println!("skipped: this user may write everywhere");
        return;
    }
    refused(&folder, &map, &["-o", arg(&locked.join("out.bsp"))], &["locked/out.bsp"]);
}

#[test]
fn pictures_that_cannot_be_written_are_named() {
    let (folder, map) = small_map();
    let out = folder.path().join("out.bsp");
    for option in ["--preview", "--dump-lightmaps"] {
        let nowhere = map.join("below-a-file");
        let line = fail(&map, &["-o", arg(&out), option, arg(&nowhere)]);
        assert!(!out.exists(), "{option} is checked before the map is written");
        assert!(line.contains("below-a-file"), "{line}");
    }
}

#[test]
fn missing_or_damaged_wads_are_named() {
    let (folder, map) = small_map();
    let wad = folder.path().join("t.wad");
    refused(&folder, &map, &["--wad", arg(&wad)], &["t.wad", "cannot read"]);
    std::fs::write(&wad, b"WAD2 but no more").unwrap();
    refused(&folder, &map, &["--wad", arg(&wad)], &["t.wad"]);
}
