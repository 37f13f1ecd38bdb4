//! What the options under "Outputs" write, and what other readers make of it.

mod support;

use glam::Vec3;
use qbsp::data::lighting::BspLighting;
use qbsp::{BspData, BspParseInput, BspParseSettings};
use qrad::bsp::{Bsp, Format, read_hdr_lit, read_lit, unpack_e5bgr9};
use std::path::{Path, PathBuf};
use support::map_builder::MapBuilder;
use support::program::{fail, qrad, run};
use tempfile::TempDir;

/// Coarse and quick, where it matters only that all stages run.
const QUICK: [&str; 4] = ["--hemicube", "16", "--patch-size", "8"];
/// Height of the light over the floor.
const HEIGHT: f32 = 200.0;

/// A room with a light over the middle of its floor, and its floor's face.
fn room(brightness: f32, colour: &str, worldspawn: &str) -> MapBuilder {
    MapBuilder::room([-128.0, -128.0, 0.0], [128.0, 128.0, 256.0])
        .solid_texture("wall", 100)
        .entities(format!(
            "{{\n\"classname\" \"worldspawn\"\n{worldspawn}}}\n\
             {{\n\"classname\" \"light\"\n\"origin\" \"0 0 {}\"\n\"light\" \"{brightness}\"\n\
             \"delay\" \"2\"\n\"_color\" \"{colour}\"\n}}\n",
            HEIGHT + 1.0
        ))
}

/// Writes a map into a new folder.
fn on_disk(map: &MapBuilder) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.bsp");
    std::fs::write(&path, map.build(Format::Bsp2).write().unwrap()).unwrap();
    (folder, path)
}

fn read(path: &Path) -> Bsp {
    Bsp::read(&std::fs::read(path).unwrap()).unwrap()
}

fn lit_file(path: &Path) -> Vec<u8> {
    std::fs::read(path.with_extension("lit")).unwrap()
}

fn lump<'a>(bsp: &'a Bsp, name: &str) -> Option<&'a [u8]> {
    bsp.bspx.iter().find(|l| l.name == name).map(|l| &l.data[..])
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect()
}

/// The face of the floor.
fn floor(bsp: &Bsp) -> usize {
    (0..bsp.faces.len()).find(|&f| bsp.face_plane(f).normal == Vec3::Z).unwrap()
}

/// Index in the lighting lump of the luxel at the middle of the floor.
fn floor_middle(bsp: &Bsp) -> usize {
    let face = floor(bsp);
    let extents = bsp.face_extents(face, 16.0).unwrap();
    let [x, y] = extents.mins.map(|low| -low as usize);
    bsp.faces[face].light_offset as usize + y * extents.size[0] as usize + x
}

/// What another reader finds in the map.
fn oracle(path: &Path) -> BspData {
    let settings = BspParseSettings { use_bspx_rgb_lighting: true, parse_bspx_structures: true };
    let bsp = std::fs::read(path).unwrap();
    BspData::parse(BspParseInput { bsp: &bsp, lit: None, settings }).unwrap()
}

#[test]
fn hdr_lits_hold_light_that_bytes_cannot() {
    // Directly under the light, from which the luxel's sample is HEIGHT away.
    let want = |b: f32| 0.5 * b * 128.0 * 128.0 / HEIGHT.powi(2) / 128.0;
    for brightness in [0.4, 60.0, 90000.0] {
        let (_folder, path) = on_disk(&room(brightness, "1 0.5 0.25", ""));
        run(&path, &["--hdr", "--bounces", "0"]);
        let bsp = read(&path);
        assert!(bsp.bspx.is_empty());
        let colours = read_hdr_lit(&lit_file(&path)).unwrap();
        assert_eq!(colours.len(), bsp.lighting.len());
        let middle = floor_middle(&bsp);
        let got = unpack_e5bgr9(colours[middle]);
        let want = Vec3::new(1.0, 0.5, 0.25) * want(brightness);
        assert!(((got - want).abs() / want.x).max_element() < 2e-3, "{got} not {want}");
        // What bytes can hold of it.
        let level = (want.x * 128.0).min(255.0) as u8;
        assert_eq!(bsp.lighting[middle], level, "{brightness}");
    }
}

#[test]
fn hdr_goes_into_the_map_with_the_same_values() {
    let (_folder, path) = on_disk(&room(0.4, "1 0.5 0.25", ""));
    run(&path, &["--hdr", "--bounces", "0"]);
    let colours = read_hdr_lit(&lit_file(&path)).unwrap();
    run(&path, &["--bspxhdr", "--bounces", "0"]);
    let bsp = read(&path);
    assert_eq!(bsp.bspx.len(), 1);
    assert_eq!(words(lump(&bsp, "LIGHTING_E5BGR9").unwrap()), colours);
    assert!(!path.with_extension("lit").exists(), "the old one is gone");
    // Without HDR nothing is bright enough to be stored, and the old lump goes.
    run(&path, &["--bounces", "0"]);
    let bsp = read(&path);
    assert!(bsp.bspx.is_empty() && bsp.lighting.is_empty());
}

#[test]
fn hdr_changes_no_byte_of_what_others_read() {
    let (_folder, path) = on_disk(&room(300.0, "1 0.5 0.25", ""));
    run(&path, &QUICK);
    let (plain, lit) = (read(&path), lit_file(&path));
    run(&path, &[&QUICK[..], &["--bspxhdr", "--lit"]].concat());
    let mut hdr = read(&path);
    assert_eq!(lit_file(&path), lit);
    assert_eq!(hdr.bspx.len(), 1);
    hdr.bspx.clear();
    assert!(hdr == plain);
}

#[test]
fn colours_in_the_map_are_those_of_the_lit_file() {
    let (_folder, path) = on_disk(&room(300.0, "1 0.5 0.25", ""));
    run(&path, &QUICK);
    let (plain, lit) = (read(&path), lit_file(&path));
    run(&path, &[&QUICK[..], &["--bspxlit"]].concat());
    assert!(!path.with_extension("lit").exists());
    let mut inside = read(&path);
    assert_eq!(lump(&inside, "RGBLIGHTING").unwrap(), read_lit(&lit).unwrap());
    let Some(BspLighting::Colored(rgb)) = oracle(&path).lighting else { panic!("no colours") };
    assert_eq!(rgb.as_flattened(), read_lit(&lit).unwrap());
    inside.bspx.clear();
    assert!(inside == plain);
    // Both on request.
    run(&path, &[&QUICK[..], &["--bspxlit", "--lit"]].concat());
    assert_eq!(lit_file(&path), lit);
    assert_eq!(read(&path).bspx.len(), 1);
}

#[test]
fn without_vanilla_lightmaps_the_colours_stay_in_their_places() {
    let (_folder, path) = on_disk(&room(300.0, "1 0.5 0.25", ""));
    run(&path, &QUICK);
    let (plain, lit) = (read(&path), lit_file(&path));
    for options in [&["--novanilla"][..], &["--novanilla", "--bspxlit"]] {
        run(&path, &[&QUICK[..], options].concat());
        assert!(!path.with_extension("lit").exists());
        let bsp = read(&path);
        assert!(bsp.lighting.is_empty());
        assert_eq!(lump(&bsp, "RGBLIGHTING").unwrap(), read_lit(&lit).unwrap());
        assert!(bsp.faces == plain.faces);
    }
    // Light without colour is held by nothing else and stays.
    let (_folder, path) = on_disk(&room(300.0, "1 1 1", ""));
    run(&path, &[&QUICK[..], &["--novanilla", "--grey"]].concat());
    let bsp = read(&path);
    assert!(bsp.bspx.is_empty() && !bsp.lighting.is_empty());
    assert!(!path.with_extension("lit").exists());
}

#[test]
fn a_lit_file_without_colour_is_written_on_request() {
    let (_folder, path) = on_disk(&room(300.0, "1 1 1", ""));
    run(&path, &[&QUICK[..], &["--grey", "--lit"]].concat());
    let grey: Vec<u8> = read(&path).lighting.iter().flat_map(|&l| [l; 3]).collect();
    assert_eq!(read_lit(&lit_file(&path)).unwrap(), grey);
    let message = fail(&path, &["--facestyles", "17"]);
    assert!(message.contains("--facestyles") && message.contains("1 to 16"), "{message}");
    for both in [&["--lit", "--hdr"][..], &["--novanilla", "--preview", "x.png"]] {
        qrad().arg(&path).args(both).assert().code(2);
    }
}

/// A room with lights of six styles over its floor, the later the dimmer.
fn six_styles() -> MapBuilder {
    let mut text = "{\n\"classname\" \"worldspawn\"\n}\n".to_owned();
    for style in 1..=6 {
        text += &format!(
            "{{\n\"classname\" \"light\"\n\"origin\" \"0 0 120\"\n\"light\" \"{}\"\n\"style\" \
             \"{style}\"\n}}\n",
            400 - 20 * style
        );
    }
    room(0.0, "1 1 1", "").entities(text)
}

#[test]
fn more_styles_than_a_record_holds_follow_the_first_four() {
    let (_folder, path) = on_disk(&six_styles());
    run(&path, &["--bounces", "0", "--facestyles", "2"]);
    let two = read(&path);
    assert!(two.bspx.is_empty());
    assert_eq!(two.faces[floor(&two)].styles, [1, 2, 255, 255]);
    run(&path, &["--bounces", "0"]);
    let four = read(&path);
    assert!(four.bspx.is_empty());
    run(&path, &["--bounces", "0", "--facestyles", "16"]);
    let bsp = read(&path);
    assert_eq!(bsp.bspx.len(), 1, "the offsets are those of the records");
    let styles = lump(&bsp, "LMSTYLE").unwrap();
    assert_eq!(styles.len(), 6 * bsp.faces.len());
    let face = floor(&bsp);
    assert_eq!(styles[6 * face..][..6], [1, 2, 3, 4, 5, 6]);
    assert_eq!(bsp.faces[face].styles, [1, 2, 3, 4]);
    let [w, h] = bsp.face_extents(face, 16.0).unwrap().size;
    let luxels = (w * h) as usize;
    let maps = |bsp: &Bsp, count: usize| {
        bsp.lighting[bsp.faces[face].light_offset as usize..][..count * luxels].to_vec()
    };
    assert_eq!(maps(&bsp, 4), maps(&four, 4));
    let middles: Vec<u8> = (0..6).map(|s| bsp.lighting[floor_middle(&bsp) + s * luxels]).collect();
    assert!(middles.windows(2).all(|m| m[0] > m[1]), "{middles:?}");
}
