//! What several integration tests need.
// Each test binary uses its own part of this module.
#![allow(dead_code)]

pub mod attacks;
pub mod grid_reader;
pub mod invariants;
pub mod lit_levels;
pub mod lit_light;
pub mod lit_map;
pub mod lit_room;
pub mod map_builder;
pub mod map_energy;
pub mod map_invariants;
pub mod polygons;
pub mod program;
pub mod quads;
pub mod tiny;
pub mod views;
pub mod wads;
pub mod written;

use std::path::{Path, PathBuf};

/// The folder of read-only test material: `QRAD_SHARED`, or `shared` beside the project. Prints a line
/// and returns `None` where there is none: the test that asked then has nothing to check.
pub fn shared_dir() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"); // may be absent
    let dir = std::env::var_os("QRAD_SHARED").map_or(beside, PathBuf::from);
    if dir.join("maps").is_dir() {
        return Some(dir);
    }
    println!("skipped: no shared test material at {}", dir.display());
    None
}

/// The project's own maps.
pub fn maps_dir() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("maps")
}

/// Every `.bsp` of the project, and of the shared material where it is present, by path.
pub fn all_maps() -> Vec<PathBuf> {
    let mut dirs = vec![maps_dir()];
    if let Some(shared) = shared_dir() {
        dirs.extend([shared.join("maps/demo"), shared.join("maps/librequake")]);
    }
    let mut maps: Vec<PathBuf> = dirs
        .iter()
        .flat_map(|dir| std::fs::read_dir(dir).expect("a folder of maps"))
        .map(|entry| entry.expect("a folder entry").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "bsp"))
        .collect();
    maps.sort();
    maps
}
