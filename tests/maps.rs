//! Whole maps through the program: what it writes, and what stays as it was.

mod support;

use glam::Vec3;
use qbsp::{BspData, BspParseInput, BspParseSettings};
use qrad::bsp::{Bsp, Format, read_lit};
use std::path::{Path, PathBuf};
use support::map_builder::MapBuilder;
use support::program::{arg, qrad, run};
use tempfile::TempDir;

/// Coarse and quick, where it matters only that all stages run.
const QUICK: [&str; 4] = ["--hemicube", "16", "--patch-size", "8"];

fn project_map(name: &str) -> PathBuf {
    support::maps_dir().join(format!("{name}.bsp"))
}

/// A copy of a map of the project with its sidecar, to be changed.
fn copy_of(name: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let (from, to) = (project_map(name), folder.path().join("map.bsp"));
    std::fs::copy(&from, &to).unwrap();
    std::fs::copy(from.with_extension("texinfo.json"), to.with_extension("texinfo.json")).unwrap();
    (folder, to)
}

fn read(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The map and the payload of its `.lit` file.
fn read_lit_map(path: &Path) -> (Bsp, Vec<u8>) {
    let bsp = Bsp::read(&read(path)).unwrap();
    let lit = read(&path.with_extension("lit"));
    assert_eq!(lit.len(), 8 + 3 * bsp.lighting.len(), "the size of {}", path.display());
    (bsp, read_lit(&lit).unwrap())
}

/// Bytes of each lump of a BSP file.
fn lumps(file: &[u8]) -> Vec<&[u8]> {
    let number = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    (0..15).map(|l| &file[number(4 + 8 * l)..][..number(8 + 8 * l)]).collect()
}

/// Luxels of a face, and its number of styles; none if it is unlit.
fn size_of(bsp: &Bsp, face: usize) -> (usize, usize) {
    if bsp.faces[face].light_offset < 0 {
        return (0, 0);
    }
    let [w, h] = bsp.face_extents(face, 16.0).unwrap().size;
    let styles = bsp.faces[face].styles.iter().filter(|&&s| s != 255).count();
    ((w * h) as usize, styles)
}

/// Every lightmap is within the lump, and the mono level is the largest channel.
fn check_lighting(bsp: &Bsp, rgb: &[u8]) {
    let mut end = 0;
    for face in 0..bsp.faces.len() {
        let (luxels, styles) = size_of(bsp, face);
        if luxels == 0 {
            assert_eq!(bsp.faces[face].styles, [255; 4], "face {face}");
            continue;
        }
        assert!(styles > 0, "face {face} is lit by no style");
        let offset = bsp.faces[face].light_offset as usize;
        assert!(offset >= end, "face {face} overlaps the one before");
        end = offset + luxels * styles;
        assert!(end <= bsp.lighting.len(), "face {face} ends outside the lump");
    }
    assert!(bsp.lighting.len() < end + 4, "nothing but padding follows");
    for (i, (mono, rgb)) in bsp.lighting.iter().zip(rgb.chunks(3)).enumerate() {
        assert_eq!(Some(mono), rgb.iter().max(), "luxel {i}");
    }
}

/// Levels of the faces that lie in the box, whatever their style, and the directions they face.
fn levels_in(bsp: &Bsp, low: Vec3, high: Vec3) -> (Vec<u8>, Vec<Vec3>) {
    let (mut levels, mut normals) = (Vec::new(), Vec::new());
    for face in 0..bsp.models[0].face_count as usize {
        let inside = |v: Vec3| v.cmpge(low).all() && v.cmple(high).all();
        if !bsp.face_vertices(face).all(inside) {
            continue;
        }
        let (luxels, styles) = size_of(bsp, face);
        let offset = bsp.faces[face].light_offset.max(0) as usize;
        levels.extend_from_slice(&bsp.lighting[offset..offset + luxels * styles]);
        normals.push(bsp.face_plane(face).normal);
    }
    (levels, normals)
}

/// The second leg of the west passage of `atrium`: round a corner from the only lamp near it.
const CORRIDOR: [Vec3; 2] = [Vec3::new(-960.0, -368.0, 0.0), Vec3::new(-672.0, -256.0, 136.0)];

#[test]
fn atrium_is_lit_and_only_bounces_reach_its_corridor() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (project_map("atrium"), folder.path().join("lit.bsp"));
    let before = read(&input);
    run(&input, &["-o", arg(&output)]);
    assert!(read(&input) == before, "the original is as it was");
    assert!(!input.with_extension("lit").exists());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "the map and its .lit");

    let (bsp, rgb) = read_lit_map(&output);
    check_lighting(&bsp, &rgb);
    let after = read(&output);
    for (lump, (old, new)) in lumps(&before).into_iter().zip(lumps(&after)).enumerate() {
        // Entities get the styles of switchable lights; faces and lighting are what lighting is.
        let changes = [0, 7, 8].contains(&lump);
        assert!(changes || old == new, "lump {lump} differs");
    }
    let settings = BspParseSettings { use_bspx_rgb_lighting: false, parse_bspx_structures: false };
    let lit = read(&output.with_extension("lit"));
    let theirs = BspData::parse(BspParseInput { bsp: &after, lit: Some(&lit), settings }).unwrap();
    assert_eq!(theirs.faces.len(), bsp.faces.len());
    assert!(theirs.lighting.is_some(), "another reader finds the light");

    let [low, high] = CORRIDOR;
    let (levels, normals) = levels_in(&bsp, low, high);
    for side in [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z] {
        assert!(normals.contains(&side), "a face towards {side}");
    }
    let mean = levels.iter().map(|&l| f64::from(l)).sum::<f64>() / levels.len() as f64;
    let dark = levels.iter().filter(|&&l| l == 0).count();
    println!("corridor: {} luxels, mean level {mean:.2}, {dark} dark", levels.len());
    assert!(levels.len() > 500 && mean > 3.0 && dark * 20 < levels.len(), "{mean} {dark}");

    run(&input, &["-o", arg(&output), "--bounces", "0"]);
    let (levels, again) = levels_in(&read_lit_map(&output).0, low, high);
    assert_eq!(again.len(), normals.len());
    assert!(levels.iter().all(|&l| l == 0), "direct light alone does not reach it");
}

#[test]
fn relighting_gives_the_same_bytes_in_place_too() {
    // atrium has switchable lights, whose styles are in the entity text from the first run on.
    for (name, options) in [("atrium", &QUICK[..]), ("cornell", &[])] {
        let (folder, map) = copy_of(name);
        let other = folder.path().join("other.bsp");
        run(&map, &[&["-o", arg(&other)], options].concat());
        assert!(read(&map) == read(&project_map(name)));
        for _ in 0..2 {
            run(&map, options);
            assert!(read(&map) == read(&other), "{name}");
            let lit = [&map, &other].map(|m| read(&m.with_extension("lit")));
            assert!(lit[0] == lit[1], "{name}");
        }
    }
}

#[test]
fn bytes_do_not_depend_on_the_number_of_threads() {
    for (name, options) in
        [("atrium", &QUICK[..]), ("cornell", &[]), ("cornell", &["--gather", "luxel"])]
    {
        let folder = tempfile::tempdir().unwrap();
        let lit = ["1", "2"].map(|threads| {
            let output = folder.path().join(format!("{threads}.bsp"));
            let options = [&["-o", arg(&output), "--threads", threads], options].concat();
            run(&project_map(name), &options);
            (read(&output), read(&output.with_extension("lit")))
        });
        assert!(lit[0] == lit[1], "{name} {options:?}");
    }
}

/// A grey room with a light, as a file.
fn grey_room(folder: &Path, light: &str) -> PathBuf {
    let path = folder.join("room.bsp");
    let bsp = MapBuilder::room([-128.0; 3], [128.0; 3])
        .solid_texture("grey", 8)
        .entities(format!(
            "{{\n\"classname\" \"worldspawn\"\n}}\n{{\n\"classname\" \"light\"\n{light}}}\n"
        ))
        .build(Format::Bsp2);
    std::fs::write(&path, bsp.write().unwrap()).unwrap();
    path
}

#[test]
fn a_stale_lit_file_goes_when_the_light_has_no_colour() {
    let folder = tempfile::tempdir().unwrap();
    let lit = folder.path().join("room.lit");
    for (light, options, coloured) in [
        ("", &[][..], false),
        ("\"_color\" \"255 128 128\"\n", &[], true),
        ("\"_color\" \"128 128 128\"\n", &["--grey"], false),
    ] {
        std::fs::write(&lit, b"QLIT, and old").unwrap();
        let map = grey_room(folder.path(), light);
        run(&map, options);
        assert_eq!(lit.exists(), coloured, "{light}");
        let bsp = Bsp::read(&read(&map)).unwrap();
        assert!(bsp.lighting.iter().any(|&l| l > 50));
        if coloured {
            let (bsp, rgb) = read_lit_map(&map);
            check_lighting(&bsp, &rgb);
        }
    }
}

#[test]
fn dumped_lightmaps_are_those_of_the_map() {
    let folder = tempfile::tempdir().unwrap();
    let (output, dump) = (folder.path().join("styles.bsp"), folder.path().join("new/dump"));
    let options = [&["-o", arg(&output), "--dump-lightmaps", arg(&dump)], &QUICK[..]].concat();
    run(&project_map("styles"), &options);
    let (bsp, rgb) = read_lit_map(&output);
    let index = std::fs::read_to_string(dump.join("index.csv")).unwrap();
    let mut lines = index.lines();
    assert_eq!(lines.next(), Some("face,style,x,y,width,height"));
    let (mut maps, mut styles) = (0, std::collections::BTreeMap::new());
    for line in lines {
        let row: Vec<usize> = line.split(',').map(|n| n.parse().unwrap()).collect();
        let [face, style, x, y, w, h] = row[..] else { panic!("{line}") };
        let picture = styles.entry(style).or_insert_with(|| {
            image::open(dump.join(format!("style_{style}.png"))).unwrap().into_rgb8()
        });
        let slot = bsp.faces[face].styles.iter().position(|&s| usize::from(s) == style).unwrap();
        assert_eq!(w * h, size_of(&bsp, face).0, "{line}");
        let first = bsp.faces[face].light_offset as usize + slot * w * h;
        for (i, level) in rgb[3 * first..3 * (first + w * h)].chunks(3).enumerate() {
            let pixel = picture.get_pixel((x + i % w) as u32, (y + i / w) as u32);
            assert_eq!(pixel.0, level, "face {face} style {style} luxel {i}");
        }
        maps += 1;
    }
    let stored: usize = (0..bsp.faces.len()).map(|face| size_of(&bsp, face).1).sum();
    assert!(maps == stored && styles.len() > 3, "{maps} of {stored} maps, {} styles", styles.len());
}

#[test]
fn previews_show_the_lit_map() {
    let folder = tempfile::tempdir().unwrap();
    let (output, picture) = (folder.path().join("c.bsp"), folder.path().join("c.png"));
    // Bright, since the box is dim.
    let picture_of = ["--preview", arg(&picture), "--preview-size", "96x64", "--set", "_range=6"];
    let fixed = [&["-o", arg(&output)][..], &picture_of].concat();
    let [start, door, dark] =
        [&[][..], &["--camera=0,-250,0,0,90"], &["--camera", "0,-250,0,0,90", "--bounces", "0"]]
            .map(|options| {
                run(&project_map("cornell"), &[&fixed[..], options, &QUICK].concat());
                let picture = image::open(&picture).unwrap().into_rgb8();
                assert_eq!(picture.dimensions(), (96, 64));
                picture
            });
    let mean = |picture: &image::RgbImage| {
        picture.iter().map(|&v| f64::from(v)).sum::<f64>() / picture.len() as f64
    };
    println!("mean levels {:.1} {:.1} {:.1}", mean(&start), mean(&door), mean(&dark));
    assert!(mean(&start) > 10.0 && mean(&door) > 10.0 && start != door);
    assert!(mean(&dark) > 0.5 && mean(&dark) < mean(&door));
    // Red on the left, green on the right.
    let column = |x: u32| door.get_pixel(x, 32).0;
    assert!(column(8)[0] > column(8)[1] && column(87)[1] > column(87)[0]);
}

#[test]
fn reports_say_what_was_done_and_quiet_runs_say_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let map = grey_room(folder.path(), "");
    let output = run(&map, &[]);
    let report = String::from_utf8(output.stdout).unwrap();
    for name in [
        "faces",
        "luxels",
        "patches",
        "lights",
        "light styles",
        "shadow rays",
        "transfers",
        "bounces",
        "residual",
        "form factors",
        "peak memory",
        "room.bsp",
    ] {
        assert!(report.contains(name), "{name} is not in\n{report}");
    }
    let quiet = qrad().arg("-q").arg(&map).assert().success().get_output().clone();
    assert!(quiet.stdout.is_empty() && quiet.stderr.is_empty());
    // The extension may be left out.
    run(&map.with_extension(""), &[]);
}
