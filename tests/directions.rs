//! Where light comes from: `.lux` files, `LIGHTINGDIR` and version 2 of `.lit`, against directions
//! worked out by hand.

mod support;

use glam::Vec3;
use qrad::bsp::{Bsp, Format, read_hdr_lit, read_lit};
use qrad::light::{DirectLight, Directions};
use qrad::lightmap::{Gather, Sources, add_bounced_directions};
use qrad::scene::material_file::MaterialFile;
use qrad::scene::{Sample, Scene, SceneSettings, Sidecar, luxels};
use qrad::settings::Settings;
use std::path::Path;
use support::lit_map::Prepared;
use support::lit_room::entity;
use support::map_builder::MapBuilder;
use support::program::{fail, qrad, run};
use support::written::{beside, lit_file, lump, on_disk, read, words};

/// Direct light only.
const DIRECT: [&str; 3] = ["--lux", "--bounces", "0"];
/// Palette indices of black and of a colour that reflects a third.
const BLACK: u8 = 0;
const MIDDLE: u8 = 5;

fn room(texture: u8, lights: &str) -> MapBuilder {
    MapBuilder::room([-128.0, -128.0, 0.0], [128.0, 128.0, 256.0])
        .solid_texture("wall", texture)
        .entities(entity("worldspawn", &[]) + lights)
}

fn light(origin: &str, keys: &[(&str, &str)]) -> String {
    entity("light", &[&[("origin", origin), ("light", "300")], keys].concat())
}

/// How the texture of a face runs: its s axis, against its t axis, and the normal.
fn tangents(bsp: &Bsp, face: usize) -> [Vec3; 3] {
    let texinfo = bsp.texinfo_of(face).unwrap();
    let unit = |v: glam::Vec4| v.truncate().normalize();
    [unit(texinfo.s), -unit(texinfo.t), bsp.face_plane(face).normal]
}

/// A luxel of a lightmap: its face, light style, place in the lump, and where it was sampled.
struct Luxel {
    face: usize,
    style: u8,
    at: usize,
    sample: Sample,
}

/// The luxels of a map in the order of the lump, those inside solid left out.
fn luxels_of(bsp: &Bsp) -> Vec<Luxel> {
    // Records are for those who know no lumps.
    let mut plain = bsp.clone();
    plain.bspx.clear();
    let scene = Scene::build(&plain, Sidecar::default(), &SceneSettings::default()).unwrap();
    let mut found = Vec::new();
    for (face, record) in bsp.faces.iter().enumerate() {
        let samples = luxels::place(&scene, face, 1);
        let styles = record.styles.iter().take_while(|&&style| style != 255);
        for (slot, &style) in styles.enumerate() {
            let first = record.light_offset as usize + slot * samples.len();
            let free = samples.iter().enumerate().filter(|(_, s)| !s.occluded);
            found.extend(free.map(|(i, &sample)| Luxel { face, style, at: first + i, sample }));
        }
    }
    found
}

/// Direction in world space that three bytes stand for, where texture axes are square to each other.
fn decoded(bytes: &[u8], tangents: [Vec3; 3]) -> Vec3 {
    let x = |i: usize| (f32::from(bytes[i]) + 0.5) / 128.0 - 1.0;
    tangents[0] * x(0) + tangents[1] * x(1) + tangents[2] * x(2)
}

/// Whether three bytes are those of a direction, given that the last digit of it is not known.
fn is_stored(bytes: &[u8], towards: Vec3, tangents: [Vec3; 3]) -> bool {
    bytes.iter().zip(tangents).all(|(&byte, axis)| {
        let exact = (towards.dot(axis) + 1.0) * 128.0;
        let [low, high] = [exact - 1e-3, exact + 1e-3].map(|x| x.clamp(0.0, 255.0).floor());
        (low..=high).contains(&f32::from(byte))
    })
}

#[test]
fn luxels_point_at_the_only_light_on_every_side_of_the_room() {
    let at = Vec3::new(40.0, -24.0, 100.0);
    let (_folder, path) = on_disk(&room(MIDDLE, &light("40 -24 100", &[])));
    run(&path, &DIRECT);
    let (bsp, lux) = (read(&path), read_lit(&beside(&path, "lux")).unwrap());
    assert_eq!(lux.len(), 3 * bsp.lighting.len());
    let found = luxels_of(&bsp);
    assert!(found.len() > 6 * 16 * 16 && found.iter().any(|l| l.face == 5));
    for Luxel { face, at: index, sample, .. } in found {
        let towards = (at - sample.position).normalize();
        let bytes = &lux[3 * index..3 * index + 3];
        let place = sample.position;
        assert!(is_stored(bytes, towards, tangents(&bsp, face)), "{place}: {bytes:?} {towards}");
    }
}

#[test]
fn equal_lights_on_opposite_sides_come_from_the_normal_and_others_by_strength() {
    let weak = [("light", "100"), ("_color", "1 0.5 0"), ("delay", "5")];
    let strong = [("light", "300"), ("delay", "5")];
    // Both are equally far and at 45 degrees: 1 to 3 makes (-1 + 3, 0, 1 + 3) = (2, 0, 4).
    for (first, want) in [(&strong[..], Vec3::Z), (&weak, Vec3::new(2.0, 0.0, 4.0).normalize())] {
        let lights = light("-60 0 61", first) + &light("60 0 61", &strong);
        let (_folder, path) = on_disk(&room(MIDDLE, &lights));
        run(&path, &DIRECT);
        let (bsp, lux) = (read(&path), read_lit(&beside(&path, "lux")).unwrap());
        let middle = luxels_of(&bsp);
        let middle = middle.iter().find(|l| l.sample.position == Vec3::Z).unwrap();
        let bytes = &lux[3 * middle.at..3 * middle.at + 3];
        assert!(is_stored(bytes, want, [Vec3::X, Vec3::Y, Vec3::Z]), "{bytes:?} {want}");
    }
}

#[test]
fn every_style_has_directions_of_its_own_in_the_order_of_the_lightmaps() {
    let places = [Vec3::new(100.0, 0.0, 100.0), Vec3::new(-100.0, 50.0, 150.0)];
    let lights: String = (places.iter().zip(["7", "9"]))
        .map(|(p, style)| {
            light(&format!("{} {} {}", p.x, p.y, p.z), &[("style", style), ("light", "900")])
        })
        .collect();
    let (_folder, path) = on_disk(&room(MIDDLE, &lights));
    run(&path, &[&DIRECT[..], &["--bspxlux"]].concat());
    let (bsp, lux) = (read(&path), read_lit(&beside(&path, "lux")).unwrap());
    assert!(lump(&bsp, "LIGHTINGDIR").unwrap() == lux);
    let found = luxels_of(&bsp);
    assert!(found.iter().any(|l| l.style == 7) && found.iter().any(|l| l.style == 9));
    for Luxel { face, style, at, sample } in found {
        let towards = (places[usize::from(style == 9)] - sample.position).normalize();
        let bytes = &lux[3 * at..3 * at + 3];
        assert!(is_stored(bytes, towards, tangents(&bsp, face)), "{} {style}", sample.position);
    }
}

#[test]
fn sunlight_comes_from_the_sun() {
    let world = [("_sunlight", "200"), ("_sun_mangle", "30 -50 0")];
    let map = MapBuilder::room([-256.0, -256.0, 0.0], [256.0, 256.0, 64.0])
        .solid_texture("wall", MIDDLE)
        .solid_texture("sky1", MIDDLE)
        .flags(1)
        .room_textures([0, 0, 0, 0, 0, 1])
        .entities(entity("worldspawn", &world));
    let (_folder, path) = on_disk(&map);
    run(&path, &DIRECT);
    let (bsp, lux) = (read(&path), read_lit(&beside(&path, "lux")).unwrap());
    let [yaw, pitch] = [30_f32, 50.0].map(f32::to_radians);
    let sun = -Vec3::new(yaw.cos() * pitch.cos(), yaw.sin() * pitch.cos(), -pitch.sin());
    let lit: Vec<Luxel> = luxels_of(&bsp).into_iter().filter(|l| bsp.lighting[l.at] > 0).collect();
    assert!(lit.len() > 500, "{}", lit.len());
    for Luxel { face, at, .. } in lit {
        let bytes = &lux[3 * at..3 * at + 3];
        assert!(is_stored(bytes, sun, tangents(&bsp, face)), "{bytes:?}");
    }
}

/// A black room lit by a lamp under its ceiling that is an area light, and the directions of its luxels.
fn lamp_angles(options: &[&str], texture: u8) -> Vec<f32> {
    let lamp = entity("light", &[("_surface", "lamp"), ("light", "20000"), ("origin", "0 0 9")]);
    let map = room(texture, &lamp).solid_texture("lamp", 15).pillar(
        [-16.0, -16.0, 255.0],
        [16.0, 16.0, 256.0],
        1,
    );
    let (_folder, path) = on_disk(&map);
    run(&path, &[&["--lux", "--surface-lights", "area"], options].concat());
    let (bsp, lux) = (read(&path), read_lit(&beside(&path, "lux")).unwrap());
    let lamp = Vec3::Z * 254.0;
    let below = luxels_of(&bsp).into_iter().filter(|l| l.sample.position.z < 160.0);
    below
        .map(|l| {
            let got = decoded(&lux[3 * l.at..3 * l.at + 3], tangents(&bsp, l.face));
            got.angle_between(lamp - l.sample.position).to_degrees()
        })
        .collect()
}

#[test]
fn bounced_light_comes_from_what_sends_it() {
    // Nothing but the lamp sends light; it is 5 degrees wide for the nearest luxels, and patches are 64
    // units apart.
    let coarse = ["--patch-size", "4", "--hemicube", "64"];
    let angles = lamp_angles(&coarse, BLACK);
    assert!(angles.len() > 900);
    let worst = angles.iter().copied().fold(0.0, f32::max);
    let mean = angles.iter().sum::<f32>() / angles.len() as f32;
    assert!(worst < 8.0 && mean < 2.5, "{worst} {mean}");
    // With smaller patches it must become better.
    let fine = lamp_angles(&["--patch-size", "1"], BLACK);
    let fine_worst = fine.iter().copied().fold(0.0, f32::max);
    let fine_mean = fine.iter().sum::<f32>() / fine.len() as f32;
    assert!(fine_worst < worst && fine_mean < 0.6 * mean, "{fine_worst} {fine_mean}");
    // Where walls send light back, it comes from them too: the mean turns to the normal.
    let grey = lamp_angles(&coarse, 12);
    assert!(grey.iter().sum::<f32>() / grey.len() as f32 > 3.0 * mean);
}

#[test]
fn light_from_all_sides_comes_from_the_normal() {
    // Every side gives off the same light, so that none comes from one side more than from another.
    let glow = entity("light", &[("_surface", "wall"), ("light", "30"), ("origin", "0 0 9")]);
    let (_folder, path) = on_disk(&room(MIDDLE, &glow));
    run(&path, &["--lux", "--surface-lights", "area"]);
    let (bsp, lux) = (read(&path), read_lit(&beside(&path, "lux")).unwrap());
    let mut worst = 0_f32;
    for Luxel { at, .. } in luxels_of(&bsp) {
        let up = decoded(&lux[3 * at..3 * at + 3], [Vec3::X, Vec3::Y, Vec3::Z]);
        worst = worst.max(up.angle_between(Vec3::Z).to_degrees());
    }
    assert!(worst < 3.0, "{worst}");
}

#[test]
fn directions_change_no_other_byte_and_go_when_they_are_stale() {
    let (_folder, path) = on_disk(&room(MIDDLE, &light("40 -24 100", &[("_color", "1 0 0")])));
    run(&path, &["--hemicube", "16"]);
    let (plain, lit) = (read(&path), lit_file(&path));
    assert!(!path.with_extension("lux").exists());
    run(&path, &["--hemicube", "16", "--lux", "--bspxlux"]);
    assert!(lit_file(&path) == lit && beside(&path, "lux").len() == lit.len());
    let lux = beside(&path, "lux");
    run(&path, &["--hemicube", "16", "--lux", "--bspxlux", "--threads", "1"]);
    assert!(beside(&path, "lux") == lux, "whatever the number of threads");
    let mut with = read(&path);
    with.bspx.retain(|l| l.name != "LIGHTINGDIR");
    assert!(with == plain);
    run(&path, &["--hemicube", "16"]);
    assert!(read(&path) == plain && !path.with_extension("lux").exists());
    // DarkPlaces looks for another name; only one of the two is there.
    run(&path, &["--hemicube", "16", "--lux"]);
    let output = run(&path, &["--hemicube", "16", "--lux", "--engine", "darkplaces"]);
    assert!(output.stderr.is_empty());
    assert!(beside(&path, "dlit") == lux && !path.with_extension("lux").exists());
    let output = run(&path, &["--hemicube", "16", "--lux", "--engine", "quakespasm"]);
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(text.contains("not known to read .lux files"), "{text}");
    assert!(!path.with_extension("dlit").exists());
}

#[test]
fn directions_follow_supersampling_scaled_luxels_and_decoupled_ones() {
    let at = Vec3::new(40.0, -24.0, 100.0);
    let map = room(MIDDLE, &light("40 -24 100", &[]));
    let (_folder, path) = on_disk(&map);
    let check = |options: &[&str], most: f32| {
        run(&path, &[&DIRECT[..], options].concat());
        let (bsp, lux) = (read(&path), read_lit(&beside(&path, "lux")).unwrap());
        assert_eq!(lux.len(), 3 * bsp.lighting.len(), "{options:?}");
        for Luxel { face, at: index, sample, .. } in luxels_of(&bsp) {
            let got = decoded(&lux[3 * index..3 * index + 3], tangents(&bsp, face));
            let off = got.angle_between(at - sample.position).to_degrees();
            assert!(off < most, "{options:?} {}: {off}", sample.position);
        }
    };
    check(&["--extra4"], 6.0);
    check(&["--extra", "--soft=1"], 6.0);
    // These luxels are the copies for engines that do not know LMSHIFT.
    check(&["--lmshift", "3"], 1.0);
    run(&path, &[&DIRECT[..], &["--world-units-per-luxel", "32"]].concat());
    let (bsp, lux) = (read(&path), read_lit(&beside(&path, "lux")).unwrap());
    for (face, entry) in lump(&bsp, "DECOUPLED_LM").unwrap().chunks_exact(40).enumerate() {
        let words = words(entry);
        let (columns, rows) = ((words[0] & 0xFFFF) as usize, (words[0] >> 16) as usize);
        let [s, t] = [2, 6].map(|i| {
            let row = [0, 1, 2, 3].map(|k| f32::from_bits(words[i + k]));
            (Vec3::new(row[0], row[1], row[2]), row[3])
        });
        let plane = bsp.face_plane(face);
        for (x, y) in (1..columns - 1).flat_map(|x| (1..rows - 1).map(move |y| (x, y))) {
            // The rows are 1/32 long and square to each other.
            let along = |(axis, w): (Vec3, f32), i: usize| axis * (i as f32 - w) * 1024.0;
            let luxel = along(s, x) + along(t, y) + plane.normal * (plane.dist + 1.0);
            let index = words[1] as usize + y * columns + x;
            let bytes = &lux[3 * index..3 * index + 3];
            let towards = (at - luxel).normalize();
            assert!(is_stored(bytes, towards, tangents(&bsp, face)), "{luxel} {bytes:?}");
        }
    }
}

#[test]
fn bspx_and_bspxonly_stand_for_what_they_are_made_of() {
    let (_folder, path) = on_disk(&room(MIDDLE, &light("40 -24 100", &[("_color", "1 0 0")])));
    let run_with = |options: &[&str]| {
        run(&path, &[&["--bounces", "0"], options].concat());
        assert!(!path.with_extension("lit").exists() && !path.with_extension("lux").exists());
        std::fs::read(&path).unwrap()
    };
    let both = run_with(&["--bspxlit", "--bspxlux"]);
    assert!(run_with(&["--bspx"]) == both && run_with(&["-bspx"]) == both);
    let names: Vec<String> = read(&path).bspx.into_iter().map(|l| l.name).collect();
    assert_eq!(names, ["RGBLIGHTING", "LIGHTINGDIR"]);
    let only = run_with(&["--bspx", "--novanilla"]);
    assert!(run_with(&["--bspxonly"]) == only && run_with(&["-bspxonly"]) == only);
    assert!(read(&path).lighting.is_empty());
}

#[test]
fn directions_for_the_lightmaps_of_a_lit_map() {
    let (_folder, path) = on_disk(&room(MIDDLE, &light("40 -24 100", &[])));
    run(&path, &DIRECT);
    let (map, lux) = (std::fs::read(&path).unwrap(), beside(&path, "lux"));
    std::fs::remove_file(path.with_extension("lux")).unwrap();
    run(&path, &["--litonly", "--bounces", "0"]);
    assert!(!path.with_extension("lux").exists());
    run(&path, &[&DIRECT[..], &["--litonly", "--hdr"]].concat());
    assert!(std::fs::read(&path).unwrap() == map);
    let again = beside(&path, "lux");
    assert_eq!(read_hdr_lit(&lit_file(&path)).unwrap().len() * 3, again.len() - 8);
    // Between the faces, where nothing reads, bytes may differ.
    for Luxel { at, .. } in luxels_of(&read(&path)) {
        assert_eq!(again[8 + 3 * at..][..3], lux[8 + 3 * at..][..3]);
    }
}

/// A face in version 2 of a `.lit` file.
struct Lit2Face {
    offset: i32,
    styles: [u16; 4],
    size: [u16; 2],
    shift: u8,
}

/// Takes version 2 of a `.lit` file apart: faces, colours, directions.
fn lit2(file: &[u8]) -> (Vec<Lit2Face>, &[u8], &[u8]) {
    let [version, faces, luxels] = words(&file[4..16])[..] else { panic!("no header") };
    assert!(file.starts_with(b"QLIT") && version == 2);
    let (records, rest) = file[16..].split_at(17 * faces as usize);
    let short = |b: &[u8]| u16::from_le_bytes([b[0], b[1]]);
    let records = records.chunks_exact(17).map(|r| Lit2Face {
        offset: words(&r[..4])[0] as i32,
        styles: [4, 6, 8, 10].map(|i| short(&r[i..])),
        size: [12, 14].map(|i| short(&r[i..])),
        shift: r[16],
    });
    assert_eq!(rest.len(), 6 * luxels as usize);
    let (rgb, directions) = rest.split_at(3 * luxels as usize);
    (records.collect(), rgb, directions)
}

#[test]
fn lit_files_of_version_2_stand_alone() {
    let lights =
        light("40 -24 100", &[("_color", "1 0.5 0")]) + &light("0 0 200", &[("style", "3")]);
    let map = room(MIDDLE, &lights);
    let shifts = [4, 4, 3, 2, 5, 4];
    let (_folder, path) = on_disk(&map.bspx("LMSHIFT", &shifts));
    let before = std::fs::read(&path).unwrap();
    run(&path, &["--bounces", "0", "--lit2"]);
    assert!(std::fs::read(&path).unwrap() == before, "the map stays as it is");
    let file = lit_file(&path);
    let (faces, rgb, directions) = lit2(&file);
    assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 2);

    // The same light, at places that the map names.
    run(&path, &["--bounces", "0", "--lit", "--lux"]);
    let (bsp, lit) = (read(&path), read_lit(&lit_file(&path)).unwrap());
    let lux = read_lit(&beside(&path, "lux")).unwrap();
    let offsets = words(lump(&bsp, "LMOFFSET").unwrap());
    assert_eq!(faces.len(), bsp.faces.len());
    for (index, face) in faces.iter().enumerate() {
        assert_eq!(face.shift, shifts[index], "face {index}");
        let size = bsp.face_extents(index, (1 << face.shift) as f32).unwrap().size;
        assert_eq!(face.size.map(u32::from), size);
        let styles = bsp.faces[index].styles.map(|s| if s == 255 { 0xFFFF } else { s.into() });
        assert_eq!(face.styles, styles);
        let maps = styles.iter().filter(|&&s| s != 0xFFFF).count();
        assert_eq!(maps, 2);
        let luxels = 3 * maps * (size[0] * size[1]) as usize;
        let (here, there) = (3 * face.offset as usize, 3 * offsets[index] as usize);
        assert!(rgb[here..here + luxels] == lit[there..there + luxels]);
        assert!(directions[here..here + luxels] == lux[there..there + luxels]);
    }
}

#[test]
fn lit_files_of_version_2_cannot_describe_everything() {
    let map = room(MIDDLE, &light("0 0 99", &[]));
    let world = entity("worldspawn", &[("_world_units_per_luxel", "8")]);
    let (_folder, path) = on_disk(&map.entities(world + &light("0 0 99", &[])));
    let message = fail(&path, &["--lit2"]);
    assert!(message.contains("--lit2") && message.contains("_world_units_per_luxel"), "{message}");
    for other in [&["--hdr"][..], &["--litonly"], &["--world-units-per-luxel", "8"]] {
        qrad().arg::<&Path>(&path).arg("--lit2").args(other).assert().code(2);
    }
}

/// Unit direction of the bounced light on the floor of a room, left of a pane across its middle that lets
/// a share of light pass; the brighter lamp is right of it.
fn past_pane(share: f32) -> Vec<Vec3> {
    let lamp =
        |x: &str, level| entity("light", &[("origin", &format!("{x} 10 70")), ("light", level)]);
    let lamps = lamp("90", "300") + &lamp("-90", "200");
    let pane = entity("func_wall", &[("model", "*1"), ("_shadow", "1")]);
    let bsp = MapBuilder::room([-128.0, -64.0, 0.0], [128.0, 64.0, 128.0])
        .solid_texture("wall", MIDDLE)
        .solid_texture("glass", MIDDLE)
        .model([0.0, -64.0, 0.0], [4.0, 64.0, 128.0], Some(1))
        .entities(entity("worldspawn", &[]) + &lamps + &pane)
        .build(Format::Bsp29);
    let text = format!("[[material]]\ntexture = \"glass\"\ntransmission = {share}\n");
    let file = MaterialFile::parse(&text, "m").unwrap();
    let sidecar = Sidecar { materials: Some(&file), ..Sidecar::default() };
    let map = Prepared::with(&bsp, Settings::default(), false, sidecar);
    let lit = map.light(Gather::Interpolate);
    let Prepared { scene, samples, patches, transfers, .. } = &map;
    let sources = Sources { scene, patches, transfers, light: &lit.bounced.styles };
    let wanted = DirectLight { directions: Directions::wanted(), ..DirectLight::default() };
    let mut found = vec![wanted; samples.len()];
    add_bounced_directions(sources, samples, &lit.indirect, 1, &mut found);
    let mut directions = Vec::new();
    for (face, samples) in samples.iter().enumerate() {
        for (i, s) in samples.iter().enumerate().filter(|(_, s)| !s.occluded) {
            if s.normal.z > 0.9 && s.position.z < 2.0 && s.position.x < -8.0 {
                let style = found[face].directions.styles().iter().find(|d| d.style == 0);
                directions.push(style.unwrap().vectors[i].normalize());
            }
        }
    }
    directions
}

#[test]
fn bounced_light_comes_from_behind_panes_as_far_as_they_let_it() {
    let [none, half, all] = [0.0, 0.5, 1.0].map(past_pane);
    let mean = |d: &[Vec3]| d.iter().map(|d| d.x).sum::<f32>() / d.len() as f32;
    println!("towards the pane: {:.3} {:.3} {:.3}", mean(&none), mean(&half), mean(&all));
    assert!(none.len() > 40 && none.len() == all.len());
    // What no light passes is dark: beside it, all light comes from the other end.
    let far_side = |d: &[Vec3]| d.iter().map(|d| d.x).fold(-1.0, f32::max);
    assert!(mean(&none) < mean(&half) - 0.1 && mean(&half) < mean(&all) - 0.05);
    assert!(far_side(&none) < far_side(&all) - 0.1);
}
