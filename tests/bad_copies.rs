//! Damaged copies of a lit map, of the kinds that engines crash on: qrad refuses them with one line and
//! leaves them as they are. A damaged `.lit` beside a good map is replaced, which is said.

mod support;

use qrad::bsp::{Bsp, read_lit};
use std::path::{Path, PathBuf};
use support::program::{fail, qrad, run};
use tempfile::TempDir;

const FACES: usize = 4 + 8 * 7;
const LIGHTING: usize = 4 + 8 * 8;
const QUICK: [&str; 4] = ["--hemicube", "16", "--bounces", "1"];

/// A lit map and its `.lit`.
fn lit_map() -> (TempDir, PathBuf, Vec<u8>, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("map.bsp");
    std::fs::copy(support::maps_dir().join("cornell.bsp"), &map).unwrap();
    run(&map, &QUICK);
    let bytes = std::fs::read(&map).unwrap();
    let lit = std::fs::read(map.with_extension("lit")).unwrap();
    (folder, map, bytes, lit)
}

fn word(file: &[u8], at: usize) -> usize {
    u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize
}

fn with_word(file: &[u8], at: usize, value: usize) -> Vec<u8> {
    let mut bad = file.to_vec();
    bad[at..at + 4].copy_from_slice(&(value as u32).to_le_bytes());
    bad
}

#[test]
fn copies_that_engines_crash_on_are_refused_and_left_alone() {
    let (_folder, map, good, lit) = lit_map();
    let (faces, light) = (word(&good, FACES), word(&good, LIGHTING + 4));
    let mut past_lump = good.clone();
    for face in 0..word(&good, FACES + 4) / 20 {
        past_lump = with_word(&past_lump, faces + 20 * face + 16, light + 1_000_000);
    }
    for (name, bad) in [
        ("half", good[..good.len() / 2].to_vec()),
        ("90 %", good[..good.len() * 9 / 10].to_vec()),
        ("100 bytes", good[..100].to_vec()),
        ("empty", Vec::new()),
        ("version 31", with_word(&good, 0, 31)),
        ("lighting past the end", with_word(&good, LIGHTING, good.len() - 100)),
        ("lightmaps past the lump", past_lump),
    ] {
        std::fs::write(&map, &bad).unwrap();
        let line = fail(&map, &QUICK);
        assert!(line.contains("map.bsp"), "{name}: {line}");
        assert!(std::fs::read(&map).unwrap() == bad, "{name}: the map changed");
        assert!(
            std::fs::read(map.with_extension("lit")).unwrap() == lit,
            "{name}: the .lit changed"
        );
    }
}

/// Warnings of a run on a map.
fn warnings(map: &Path) -> String {
    let output = qrad().arg(map).args(QUICK).assert().success().get_output().clone();
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn a_damaged_lit_beside_a_good_map_is_named_and_replaced() {
    let (_folder, map, good, lit) = lit_map();
    let path = map.with_extension("lit");
    assert!(!warnings(&map).contains("map.lit"));
    let with_version = with_word(&lit, 4, 2);
    let bad_magic = [b"XLIT", &lit[4..]].concat();
    let longer = [&lit[..], &[1; 300]].concat();
    // Whole colours, but not as many as the map has luxels, are no better than broken ones.
    let whole = [&lit[..lit.len() - 3], &longer, &lit[..8]];
    let broken = [&lit[..lit.len() - 2], &with_version, &bad_magic, b"", &lit[..7]];
    for bad in whole.into_iter().chain(broken) {
        std::fs::write(&map, &good).unwrap();
        std::fs::write(&path, bad).unwrap();
        let said = warnings(&map);
        assert!(said.contains("map.lit") && said.contains("replaced"), "{said}");
        let rgb = read_lit(&std::fs::read(&path).unwrap()).unwrap();
        let bytes = Bsp::read(&std::fs::read(&map).unwrap()).unwrap().lighting.len();
        assert_eq!(rgb.len(), 3 * bytes);
    }
}
