//! What the options under "Outputs" write, and what other readers make of it.

mod support;

use glam::Vec3;
use qbsp::data::lighting::BspLighting;
use qbsp::{BspData, BspParseInput, BspParseSettings};
use qrad::bsp::{Bsp, Format, read_hdr_lit, read_lit, unpack_e5bgr9};
use std::path::Path;
use support::map_builder::MapBuilder;
use support::program::{arg, fail, qrad, run};
use support::written::{lit_file, lump, on_disk, read, words};

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
    assert!(words(lump(&bsp, "LIGHTING_E5BGR9").unwrap()) == colours);
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
    assert!(lit_file(&path) == lit);
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
    assert!(lump(&inside, "RGBLIGHTING").unwrap() == read_lit(&lit).unwrap());
    let Some(BspLighting::Colored(rgb)) = oracle(&path).lighting else { panic!("no colours") };
    assert!(rgb.as_flattened() == read_lit(&lit).unwrap());
    inside.bspx.clear();
    assert!(inside == plain);
    // Both on request.
    run(&path, &[&QUICK[..], &["--bspxlit", "--lit"]].concat());
    assert!(lit_file(&path) == lit);
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
        assert!(lump(&bsp, "RGBLIGHTING").unwrap() == read_lit(&lit).unwrap());
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
    assert!(read_lit(&lit_file(&path)).unwrap() == grey);
    let message = fail(&path, &["--facestyles", "17"]);
    assert!(message.contains("--facestyles") && message.contains("1 to 16"), "{message}");
    for both in [&["--lit", "--hdr"][..], &["--novanilla", "--preview", "x.png"]] {
        qrad().arg(&path).args(both).assert().code(2);
    }
}

/// A room with lights of six styles over its floor, the later the dimmer.
fn six_styles() -> MapBuilder {
    styled([1, 2, 3, 4, 5, 6])
}

/// A room with lights of some styles over its floor, the later the dimmer.
fn styled<const N: usize>(styles: [u32; N]) -> MapBuilder {
    let mut text = "{\n\"classname\" \"worldspawn\"\n}\n".to_owned();
    for (place, style) in styles.iter().enumerate() {
        text += &format!(
            "{{\n\"classname\" \"light\"\n\"origin\" \"0 0 120\"\n\"light\" \"{}\"\n\"style\" \
             \"{style}\"\n}}\n",
            380 - 20 * place
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
    assert!(maps(&bsp, 4) == maps(&four, 4));
    let middles: Vec<u8> = (0..6).map(|s| bsp.lighting[floor_middle(&bsp) + s * luxels]).collect();
    assert!(middles.windows(2).all(|m| m[0] > m[1]), "{middles:?}");
}

#[test]
fn styles_that_no_byte_names_are_in_words() {
    let (_folder, path) = on_disk(&styled([300, 3, 65534, 255, 1, 2]));
    // Without leave for more styles they are as good as absent.
    run(&path, &["--bounces", "0"]);
    let narrow = read(&path);
    assert!(narrow.bspx.is_empty());
    let face = floor(&narrow);
    assert_eq!(narrow.faces[face].styles, [3, 1, 2, 255]);
    run(&path, &["--bounces", "0", "--facestyles", "5"]);
    let bsp = read(&path);
    assert_eq!(bsp.bspx.len(), 1);
    let words = lump(&bsp, "LMSTYLE16").unwrap();
    assert_eq!(words.len(), 2 * 5 * bsp.faces.len());
    let words: Vec<u16> =
        words.chunks_exact(2).map(|b| u16::from_le_bytes(b.try_into().unwrap())).collect();
    // The five brightest; those that the record can name are first, in its order.
    assert_eq!(words[5 * face..][..5], [3, 1, 300, 65534, 255]);
    assert_eq!(bsp.faces[face].styles, [3, 1, 255, 255]);
    let luxels = size_of(&bsp, face, 16.0).iter().product::<usize>();
    let map = |bsp: &Bsp, slot: usize| {
        bsp.lighting[bsp.faces[face].light_offset as usize + slot * luxels..][..luxels].to_vec()
    };
    assert!((0..2).all(|slot| map(&bsp, slot) == map(&narrow, slot)));
    // Each map is that of its style: a brighter light has a brighter one.
    let middle = floor_middle(&bsp);
    let level = |slot: usize| bsp.lighting[middle + slot * luxels];
    let by_brightness = [level(2), level(0), level(3), level(4), level(1)];
    assert!(by_brightness.windows(2).all(|m| m[0] > m[1]), "{by_brightness:?}");
    // A list ends early where a face has fewer styles.
    let (_folder, path) = on_disk(&styled([300]));
    run(&path, &["--bounces", "0", "--facestyles", "16"]);
    let bsp = read(&path);
    let face = floor(&bsp);
    assert_eq!(lump(&bsp, "LMSTYLE16").unwrap()[2 * face..][..2], 300_u16.to_le_bytes());
    assert_eq!(bsp.faces[face].styles, [255; 4]);
    assert!(bsp.faces[face].light_offset >= 0);
}

/// Width and height of a face's lightmap with luxels of a size.
fn size_of(bsp: &Bsp, face: usize, luxel: f32) -> [usize; 2] {
    bsp.face_extents(face, luxel).unwrap().size.map(|side| side as usize)
}

fn offsets(bsp: &Bsp, name: &str) -> Vec<i32> {
    words(lump(bsp, name).unwrap()).into_iter().map(|word| word as i32).collect()
}

/// Ranges of the lighting lump, none of which may overlap; together with padding they must be all of it.
fn check_tiling(mut ranges: Vec<std::ops::Range<usize>>, total: usize) {
    ranges.sort_by_key(|range| range.start);
    let mut end = 0_usize;
    for range in ranges {
        assert_eq!(range.start, end.next_multiple_of(4));
        end = range.end;
    }
    assert_eq!(total, end.next_multiple_of(4));
}

#[test]
fn scaled_faces_have_fine_lightmaps_and_copies_for_others() {
    let map = room(300.0, "1 0.5 0.25", "");
    let (_folder, path) = on_disk(&map);
    run(&path, &["--bounces", "0"]);
    let (plain, plain_lit) = (read(&path), read_lit(&lit_file(&path)).unwrap());
    let face = floor(&plain);
    let mut shifts = vec![4; plain.faces.len()];
    shifts[face] = 2;
    let (_folder, path) = on_disk(&map.bspx("LMSHIFT", &shifts));
    run(&path, &["--bounces", "0"]);
    let (bsp, lit) = (read(&path), read_lit(&lit_file(&path)).unwrap());
    assert_eq!(lump(&bsp, "LMSHIFT").unwrap(), shifts);
    assert_eq!(bsp.bspx.len(), 2);
    let fine = offsets(&bsp, "LMOFFSET");
    let mut ranges = Vec::new();
    for (f, record) in bsp.faces.iter().enumerate() {
        let ([w, h], start) = (size_of(&bsp, f, 16.0), record.light_offset as usize);
        let old = plain.faces[f].light_offset as usize;
        assert_eq!(record.styles, plain.faces[f].styles);
        assert_eq!(fine[f] != record.light_offset, f == face);
        ranges.push(start..start + w * h);
        // The copy is what the face has without LMSHIFT.
        for i in 0..3 * w * h {
            let (got, want) = (lit[3 * start + i], plain_lit[3 * old + i]);
            assert!(got.abs_diff(want) <= 1, "face {f}: {got} {want}");
        }
    }
    // Every fourth of the fine luxels is where a coarse one is.
    let ([w, h], [columns, rows]) = (size_of(&bsp, face, 16.0), size_of(&bsp, face, 4.0));
    let (start, old) = (fine[face] as usize, plain.faces[face].light_offset as usize);
    assert!([w, h, columns, rows] == [17, 17, 65, 65]);
    ranges.push(start..start + columns * rows);
    for (x, y) in (0..w).flat_map(|x| (0..h).map(move |y| (x, y))) {
        let got = bsp.lighting[start + 4 * y * columns + 4 * x];
        assert!(got.abs_diff(plain.lighting[old + y * w + x]) <= 1);
    }
    check_tiling(ranges, bsp.lighting.len());

    run(&path, &["--bounces", "0", "--novanilla", "--bspxlit"]);
    let lone = read(&path);
    assert!(lone.lighting.is_empty() && lone.faces[face].light_offset == -1);
    assert_eq!(lone.faces[face].styles, [0, 255, 255, 255]);
    let at = 3 * offsets(&lone, "LMOFFSET")[face] as usize;
    let fine_rgb = &lit[3 * start..][..3 * columns * rows];
    assert_eq!(lump(&lone, "RGBLIGHTING").unwrap()[at..][..fine_rgb.len()], *fine_rgb);

    run(&path, &["--bounces", "0", "--lmshift", "3"]);
    let eight = read(&path);
    assert_eq!(lump(&eight, "LMSHIFT").unwrap(), vec![3; shifts.len()]);
    let fine = offsets(&eight, "LMOFFSET");
    let block = |f: usize, start: i32, luxel| {
        let [w, h] = size_of(&eight, f, luxel);
        start as usize..start as usize + w * h
    };
    let all = 0..eight.faces.len();
    let fine = all.clone().map(|f| block(f, fine[f], 8.0));
    let coarse = all.map(|f| block(f, eight.faces[f].light_offset, 16.0));
    check_tiling(fine.chain(coarse).collect(), eight.lighting.len());
}

#[test]
fn bounced_light_does_not_depend_on_the_luxel_size() {
    let map = room(300.0, "1 1 1", "").pillar([-16.0, -64.0, 0.0], [16.0, 64.0, 128.0], 0);
    let (_folder, path) = on_disk(&map);
    let middle = |options: &[&str]| {
        run(&path, options);
        let bsp = read(&path);
        // Under the pillar's face to the side of low x there is light from all around.
        let side = (0..bsp.faces.len()).find(|&f| {
            bsp.face_vertices(f).all(|v| v.x == -16.0) && bsp.face_plane(f).normal == -Vec3::X
        });
        let side = side.unwrap();
        let [w, h] = size_of(&bsp, side, 16.0);
        let start = bsp.faces[side].light_offset as usize;
        let levels = &bsp.lighting[start..start + w * h];
        levels.iter().map(|&l| f64::from(l)).sum::<f64>() / levels.len() as f64
    };
    let coarse = middle(&[]);
    for options in [["--lmshift", "2"], ["--world-units-per-luxel", "8"]] {
        let fine = middle(&options);
        assert!((fine / coarse - 1.0).abs() < 0.03, "{fine} {coarse} {options:?}");
    }
}

#[test]
fn decoupled_lightmaps_are_where_another_reader_looks() {
    // A texture scale that must not matter: the axes of the map are 1 texel a unit.
    let (_folder, path) = on_disk(&room(300.0, "1 0.5 0.25", ""));
    let bsp = read(&path);
    let face = floor(&bsp);
    let texinfo = bsp.faces[face].texinfo;
    let sidecar = format!("{{\"{texinfo}\": {{\"world_units_per_luxel\": 32}}}}");
    std::fs::write(path.with_extension("texinfo.json"), sidecar).unwrap();
    run(&path, &["--bounces", "0", "--world-units-per-luxel", "8"]);
    let (bsp, rgb) = (read(&path), read_lit(&lit_file(&path)).unwrap());
    assert_eq!(bsp.bspx.len(), 1);
    let theirs = oracle(&path).bspx.decoupled_lm.expect("another reader finds the lump");
    assert_eq!(theirs.len(), bsp.faces.len());
    let mut ranges = Vec::new();
    for (f, lm) in theirs.iter().enumerate() {
        let own = bsp.faces[f].texinfo == texinfo;
        // All sides of the room are 256 by 256.
        assert_eq!(lm.size.to_array(), if own { [9; 2] } else { [33; 2] }, "face {f}");
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for vertex in bsp.face_vertices(f) {
            // That reader adds half a luxel.
            let at = lm.projection.project(vertex.to_array().into()) - 0.5;
            let at = Vec3::new(at.x, at.y, 0.0);
            (low, high) = (low.min(at), high.max(at));
        }
        assert!(low.abs().max_element() < 1e-3, "face {f} begins at {low}");
        assert!((high.x - f32::from(lm.size.x - 1)).abs() < 1e-3, "face {f} ends at {high}");
        let start = lm.offset.pixels as usize;
        ranges.push(start..start + lm.size.x as usize * lm.size.y as usize);
        let start = bsp.faces[f].light_offset as usize;
        ranges.push(start..start + 17 * 17);
    }
    check_tiling(ranges, bsp.lighting.len());
    // Under the light both the decoupled map and its copy have the level that belongs there.
    let want = (0.5 * 300.0 * 128.0 * 128.0 / HEIGHT.powi(2)) as u8;
    let at = theirs[face].projection.project([0.0, 0.0, 0.0].into());
    let index = theirs[face].offset.pixels as usize + at.y as usize * 9 + at.x as usize;
    assert_eq!([bsp.lighting[index], rgb[3 * index]], [want; 2]);
    let copy = floor_middle(&bsp);
    assert_eq!([bsp.lighting[copy], rgb[3 * copy + 1]], [want, want / 2]);
}

#[test]
fn decoupled_lightmaps_alone_fill_the_lump() {
    let (_folder, path) = on_disk(&room(300.0, "1 1 1", "\"_world_units_per_luxel\" \"8\"\n"));
    run(&path, &["--bounces", "0", "--novanilla"]);
    let bsp = read(&path);
    assert_eq!(bsp.bspx.len(), 1);
    assert!(bsp.faces.iter().all(|f| f.light_offset == -1 && f.styles == [0, 255, 255, 255]));
    assert_eq!(bsp.lighting.len(), bsp.faces.len() * (33 * 33_usize).next_multiple_of(4));
    assert!(lump(&bsp, "DECOUPLED_LM").unwrap().len() == 40 * bsp.faces.len());
}

#[test]
fn luxel_sizes_out_of_range_are_refused() {
    let (_folder, path) = on_disk(&room(300.0, "1 1 1", ""));
    for (option, value) in [
        ("--lmshift", "9"),
        ("--world-units-per-luxel", "0"),
        ("--world-units-per-luxel", "nan"),
        ("--world-units-per-luxel", "1e9"),
    ] {
        let message = fail(&path, &[option, value]);
        assert!(message.contains(option) && message.contains("use 0"), "{message}");
    }
    // A lump for another number of faces, and shifts that are none.
    for lump in [&[2_u8; 3][..], &[200; 6]] {
        let (_folder, path) = on_disk(&room(300.0, "1 1 1", "").bspx("LMSHIFT", lump));
        let output = run(&path, &["--bounces", "0"]);
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.contains("LMSHIFT"), "{text}");
    }
}

#[test]
fn lit_only_leaves_the_map_as_it_is() {
    let (_folder, path) = on_disk(&room(300.0, "1 0.5 0.25", ""));
    let message = fail(&path, &["--litonly"]);
    assert!(message.contains("light the map first"), "{message}");
    run(&path, &QUICK);
    let (map, lit) = (std::fs::read(&path).unwrap(), lit_file(&path));
    std::fs::remove_file(path.with_extension("lit")).unwrap();
    run(&path, &[&QUICK[..], &["--litonly"]].concat());
    assert!(std::fs::read(&path).unwrap() == map);
    assert!(lit_file(&path) == lit);
    run(&path, &[&QUICK[..], &["--litonly", "--hdr"]].concat());
    assert!(std::fs::read(&path).unwrap() == map);
    assert_eq!(read_hdr_lit(&lit_file(&path)).unwrap().len(), read(&path).lighting.len());

    // Styles that the light has no more are black; the order is that of the map.
    let (_folder, path) = on_disk(&six_styles());
    run(&path, &["--bounces", "0", "--lit"]);
    let (bsp, lit) = (read(&path), read_lit(&lit_file(&path)).unwrap());
    let mut swapped = bsp.clone();
    let face = floor(&bsp);
    swapped.faces[face].styles = [2, 1, 9, 4];
    std::fs::write(&path, swapped.write().unwrap()).unwrap();
    run(&path, &["--bounces", "0", "--litonly"]);
    let got = read_lit(&lit_file(&path)).unwrap();
    let luxels = size_of(&bsp, face, 16.0).iter().product::<usize>();
    let map = |rgb: &[u8], slot: usize| {
        rgb[3 * (bsp.faces[face].light_offset as usize + slot * luxels)..][..3 * luxels].to_vec()
    };
    for (slot, from) in [(0, 1), (1, 0), (3, 3)] {
        assert!(map(&got, slot) == map(&lit, from));
    }
    assert!(map(&got, 2).iter().all(|&level| level == 0));
}

#[test]
fn only_entities_are_written_when_only_they_are_asked_for() {
    let lights = |targetname: &str| {
        let base = room(300.0, "1 0.5 0.25", "");
        base.entities(format!(
            "{{\n\"classname\" \"worldspawn\"\n}}\n{{\n\"classname\" \"light\"\n\"origin\" \
             \"0 0 99\"\n\"_color\" \"1 0 0\"\n{targetname}}}\n"
        ))
    };
    let (_folder, path) = on_disk(&lights(""));
    run(&path, &QUICK);
    let (lit_map, lit) = (read(&path), lit_file(&path));
    let mut renamed = lit_map.clone();
    renamed.entities = lights("\"targetname\" \"lamp\"\n").build(Format::Bsp2).entities;
    std::fs::write(&path, renamed.write().unwrap()).unwrap();
    run(&path, &["--onlyents"]);
    let mut after = read(&path);
    let text = String::from_utf8_lossy(&after.entities).into_owned();
    assert!(text.contains("\"style\" \"32\""), "{text}");
    assert!(lit_file(&path) == lit);
    after.entities = lit_map.entities.clone();
    assert!(after == lit_map);
    let folder = tempfile::tempdir().unwrap();
    let elsewhere = folder.path().join("other.bsp");
    run(&path, &["--onlyents", "-o", arg(&elsewhere)]);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
