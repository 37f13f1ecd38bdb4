//! Files that a map run reads and writes besides the map and its `.lit`.

mod support;

use qrad::bsp::{Bsp, Format, MipTex};
use std::path::{Path, PathBuf};
use support::lit_room::entity;
use support::map_builder::MapBuilder;
use support::program::{arg, fail, run};
use tempfile::TempDir;

/// A dark room with one texture that may glow, as a file.
fn room(text: &str) -> (TempDir, PathBuf) {
    let builder = MapBuilder::room([-128.0, -128.0, 0.0], [128.0, 128.0, 128.0])
        .solid_texture("wall", 8)
        .solid_texture("glow", 254)
        .room_textures([0, 0, 0, 0, 0, 1])
        .pillar([-16.0, -16.0, 32.0], [16.0, 16.0, 64.0], 0)
        .entities(entity("worldspawn", &[]) + text);
    saved(&builder.build(Format::Bsp29))
}

fn saved(bsp: &Bsp) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.bsp");
    std::fs::write(&path, bsp.write().unwrap()).unwrap();
    (folder, path)
}

fn brightness(map: &Path) -> u64 {
    let bsp = Bsp::read(&std::fs::read(map).unwrap()).unwrap();
    bsp.lighting.iter().map(|&level| u64::from(level)).sum()
}

/// Names of the files in the folder of a map, sorted.
fn beside(map: &Path) -> Vec<String> {
    let files = std::fs::read_dir(map.parent().unwrap()).unwrap();
    let mut names: Vec<String> =
        files.map(|f| f.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn texture_lights_come_from_rad_files_and_entity_files() {
    let (folder, map) = room("");
    run(&map, &["-bounce", "0"]);
    assert_eq!(brightness(&map), 0);
    let rad = folder.path().join("mine.RAD");
    std::fs::write(&rad, "glow 255 255 255 200\n").unwrap();
    run(&map, &["-bounce", "0", "-radlights", arg(&rad)]);
    let from_rad = brightness(&map);
    let ent = folder.path().join("mine.ent");
    let keys = [("_surface", "glow"), ("_color", "255 255 255"), ("light", "200")];
    std::fs::write(&ent, entity("light", &keys)).unwrap();
    run(&map, &["-bounce", "0", "-radlights", arg(&ent)]);
    assert!(from_rad > 0 && brightness(&map) == from_rad);
    run(&map, &["-bounce", "0", "-radlights", arg(&ent), "-radlights", arg(&rad)]);
    assert!(brightness(&map) > from_rad * 3 / 2, "both shine");
    // A file beside the map needs no option.
    std::fs::rename(&rad, map.with_extension("rad")).unwrap();
    run(&map, &["-bounce", "0"]);
    assert_eq!(brightness(&map), from_rad);
    std::fs::write(&ent, "{ no end").unwrap();
    fail(&map, &["-radlights", arg(&ent)]);
    let line = fail(&map, &["-radlights", arg(&rad)]);
    assert!(line.contains("mine.RAD"), "{line}");
}

#[test]
fn folders_are_searched_for_the_wads_that_the_map_names() {
    let mut bsp = MapBuilder::room([-128.0; 3], [128.0; 3])
        .solid_texture("wall", 8)
        .entities(entity("worldspawn", &[("wad", "c:\\quake\\far.wad")]))
        .build(Format::Bsp29);
    bsp.textures[0] = Some(MipTex { pixels: None, ..bsp.textures[0].clone().expect("the wall") });
    let bsp = bsp.assemble().unwrap();
    let (folder, map) = saved(&bsp);
    let wads = folder.path().join("wads");
    std::fs::create_dir(&wads).unwrap();
    let demo = support::maps_dir().join("demo.wad");
    std::fs::copy(demo, wads.join("far.wad")).unwrap();
    let said = |options: &[&str]| String::from_utf8(run(&map, options).stderr).unwrap();
    assert!(said(&["-bounce", "0"]).contains("far.wad"));
    assert!(!said(&["-bounce", "0", "-path", arg(&wads)]).contains("far.wad"));
}

#[test]
fn faces_are_exported_with_outward_normals() {
    let (_folder, map) = room("");
    let before = std::fs::read(&map).unwrap();
    run(&map, &["-phongdebug_obj"]);
    assert_eq!(beside(&map), ["room.bsp", "room.obj"]);
    assert!(std::fs::read(&map).unwrap() == before, "the map is not lit");
    let text = std::fs::read_to_string(map.with_extension("obj")).unwrap();
    run(&map, &["-exportobj", "-bounce", "0"]);
    assert_eq!(std::fs::read_to_string(map.with_extension("obj")).unwrap(), text);
    let vectors = |kind: &str| -> Vec<glam::Vec3> {
        text.lines()
            .filter_map(|line| line.strip_prefix(kind))
            .map(|line| {
                let n: Vec<f32> = line.split(' ').map(|w| w.parse().unwrap()).collect();
                glam::Vec3::from_slice(&n)
            })
            .collect()
    };
    let (corners, normals) = (vectors("v "), vectors("vn "));
    assert_eq!(corners.len(), normals.len());
    let mut faces = 0;
    for line in text.lines().filter_map(|line| line.strip_prefix("f ")) {
        let index = |word: &str| word.split("//").next().unwrap().parse::<usize>().unwrap() - 1;
        let face: Vec<usize> = line.split(' ').map(index).collect();
        let [a, b, c] = [0, 1, 2].map(|i| corners[face[i]]);
        let normal = (b - a).cross(c - a).normalize();
        assert!(normal.dot(normals[face[0]]) > 0.999, "anticlockwise from the front");
        faces += 1;
    }
    assert_eq!(faces, Bsp::read(&before).unwrap().faces.len());
}

#[test]
fn the_points_of_surface_lights_become_a_map() {
    for mode in ["0", "1"] {
        let keys = [("_surface", "glow"), ("light", "200"), ("_surface_radiosity", mode)];
        let (_folder, map) = room(&entity("light", &keys));
        run(&map, &["-surflight_dump", "-bounce", "0"]);
        let text = std::fs::read(map.with_file_name("room-surflights.map")).unwrap();
        let entities = qrad::bsp::parse_entities(&text).unwrap();
        assert_eq!(entities[0].classname(), "worldspawn");
        assert!(entities.len() > 1, "mode {mode}");
        for light in &entities[1..] {
            assert_eq!(light.classname(), "light");
            let z = light.get("origin").unwrap().split(' ').nth(2).unwrap();
            // The ceiling is at 128; points are 2 and 1 below it.
            assert_eq!(z, if mode == "0" { "126" } else { "127" });
        }
    }
}

#[test]
fn what_cannot_be_written_is_known_before_anything_is() {
    let (folder, map) = room(&entity("light", &[("origin", "0 0 100")]));
    let before = std::fs::read(&map).unwrap();
    let nowhere = folder.path().join("no/such/place.png");
    let file = map.join("below-a-file");
    for options in [
        &["--preview", arg(&nowhere)][..],
        &["--preview", arg(folder.path())],
        &["--dump-lightmaps", arg(&map)],
        &["--dump-lightmaps", arg(&file)],
    ] {
        fail(&map, options);
        assert!(std::fs::read(&map).unwrap() == before, "{options:?}");
        assert_eq!(beside(&map), ["room.bsp"]);
    }
    for (name, option) in [("room.obj", "--exportobj"), ("room-surflights.map", "--surflight-dump")]
    {
        let taken = folder.path().join(name);
        std::fs::create_dir(&taken).unwrap();
        let line = fail(&map, &[option]);
        assert!(line.contains(name), "{line}");
        assert!(std::fs::read(&map).unwrap() == before);
        std::fs::remove_dir(taken).unwrap();
    }
    run(&map, &["--dump-lightmaps", arg(&folder.path().join("a/b/c")), "--bounces", "0"]);
    assert!(folder.path().join("a/b/c/index.csv").is_file());
}
