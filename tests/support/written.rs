//! Maps on disk, and what a run wrote.

use super::map_builder::MapBuilder;
use qrad::bsp::{Bsp, Format};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Writes a map into a new folder.
pub fn on_disk(map: &MapBuilder) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.bsp");
    std::fs::write(&path, map.build(Format::Bsp2).write().unwrap()).unwrap();
    (folder, path)
}

/// The map at a path.
pub fn read(path: &Path) -> Bsp {
    Bsp::read(&std::fs::read(path).unwrap()).unwrap()
}

/// The file of the same name with another extension.
pub fn beside(path: &Path, extension: &str) -> Vec<u8> {
    std::fs::read(path.with_extension(extension)).unwrap()
}

/// The `.lit` file of a map.
pub fn lit_file(path: &Path) -> Vec<u8> {
    beside(path, "lit")
}

/// A BSPX lump.
pub fn lump<'a>(bsp: &'a Bsp, name: &str) -> Option<&'a [u8]> {
    bsp.bspx.iter().find(|l| l.name == name).map(|l| &l.data[..])
}

/// Numbers of 32 bits.
pub fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect()
}
