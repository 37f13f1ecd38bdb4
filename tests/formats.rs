//! The file formats against real maps, generated maps, another reader, and damaged files.

mod support;

use qrad::bsp::Bsp;

/// Lump table of a BSP file: offset and length.
fn lumps(file: &[u8]) -> Vec<(usize, usize)> {
    let number = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    (0..15).map(|lump| (number(4 + 8 * lump), number(8 + 8 * lump))).collect()
}

#[test]
fn real_maps_come_back_byte_for_byte() {
    let maps = support::all_maps();
    assert!(maps.len() >= 9, "the project's own maps are there");
    for path in maps {
        let file = std::fs::read(&path).unwrap();
        let bsp = Bsp::read(&file).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let written = bsp.write().unwrap();
        for (lump, (old, new)) in lumps(&file).into_iter().zip(lumps(&written)).enumerate() {
            let same = file[old.0..old.0 + old.1] == written[new.0..new.0 + new.1];
            assert!(same, "{}: lump {lump} differs", path.display());
        }
        // qbsp and vis write the same order and padding, so here even the whole files agree.
        assert!(file == written, "{}: BSPX or padding differs", path.display());
    }
}
