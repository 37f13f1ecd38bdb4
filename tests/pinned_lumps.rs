//! Acceptance cases of the contract's sections 12.2 to 12.4 about BSPX lumps: light grids, normals beside
//! special faces, lightmaps apart from textures.

mod support;

use glam::Vec3;
use qrad::bsp::{Bsp, Format, PALETTE};
use qrad::progress::Progress;
use qrad::scene::{Scene, SceneSettings, Sidecar, luxels};
use qrad::settings::Settings;
use qrad::{light_bsp, outputs::Outputs};
use support::grid_reader::Grid;
use support::lit_levels::texinfo;
use support::lit_light::LitLight;
use support::lit_room::entity;
use support::map_builder::MapBuilder;

/// A room of 256 x 256 x 256 units under sky; the grid's points are 32 units apart.
fn room(lights: &str) -> MapBuilder {
    MapBuilder::room([-128.0, -128.0, 0.0], [128.0, 128.0, 256.0])
        .solid_texture("wall", 0)
        .solid_texture("sky1", 8)
        .flags(1)
        .solid_texture("yellow", 111)
        .room_textures([0, 0, 0, 0, 0, 1])
        .entities(entity("worldspawn", &[]) + lights)
}

/// The map with its grid, without bounces.
fn lit(map: &MapBuilder, format: &str) -> Bsp {
    let overrides = [("lightgrid", "1"), ("lightgrid_format", format)]
        .map(|(k, v)| (k.to_owned(), v.to_owned()))
        .to_vec();
    let settings = Settings { bounces: Some(0), overrides, ..Settings::default() };
    let mut bsp = map.build(Format::Bsp29);
    light_bsp(&mut bsp, Sidecar::default(), Vec::new(), &settings, &Progress::new(false)).unwrap();
    bsp
}

/// Colours at the point at 0 0 128, which has one style.
fn middle(map: &MapBuilder, format: &str) -> Vec<[u8; 3]> {
    let grid = Grid::of(&lit(map, format));
    let at = grid.all().find(|at| grid.position(*at).as_vec3() == Vec3::new(0.0, 0.0, 128.0));
    let [(0, colours)] = grid.light(at.unwrap()).unwrap() else { panic!("style 0 alone") };
    colours.clone()
}

#[track_caller]
fn assert_near(got: [u8; 3], want: Vec3) {
    let off = (Vec3::from(got.map(f32::from)) - want).abs().max_element();
    assert!(off <= 1.0, "{got:?} instead of {want}");
}

#[test]
fn p27_lights_of_other_channels_do_not_reach_the_grid() {
    let lamp = |keys: &[(&str, &str)]| {
        entity("light", &[&[("origin", "60 -70 200"), ("light", "300")], keys].concat())
    };
    for format in ["octree", "lightgrids"] {
        let grid = |lights: String| lit(&room(&lights), format).bspx;
        let one = grid(lamp(&[]));
        assert!(grid(lamp(&[]) + &lamp(&[("_light_channel_mask", "2")])) == one);
        assert!(grid(lamp(&[]) + &lamp(&[("_light_channel_mask", "3")])) == one, "exactly 1");
        assert!(grid(lamp(&[]) + &lamp(&[])) != one);
    }
}

#[test]
fn p48_grids_serialise_to_the_bytes_that_they_are_read_from() {
    let lights = entity("light", &[("origin", "60 -70 200"), ("light", "1 0.5 0.2 300")])
        + &entity("light", &[("origin", "-60 70 100"), ("light", "200"), ("style", "3")]);
    let map = room(&lights).pillar([-96.0, -96.0, 0.0], [0.0, 0.0, 128.0], 0);
    let bsp = lit(&map, "octree");
    assert!(Grid::of(&bsp).write() == bsp.bspx[0].data);
    let bsp = lit(&map, "lightgrids");
    assert!(Grid::of(&bsp).write() == bsp.bspx[0].data[4..]);
}

#[test]
fn p50_two_suns_add_up_side_by_side() {
    // Suns that stand in the directions 3 4 12 and -4 -3 12, all over 13.
    let sun = |x: i32, y: i32, colour: &str, brightness: &str| {
        let (x, y) = (x.to_string(), y.to_string());
        let keys = [("_sun", "1"), ("origin", &*format!("{x} {y} 112")), ("target", "t")];
        let light = [("_color", colour), ("light", brightness)];
        entity("light", &[&keys[..], &light].concat())
    };
    let lights = sun(3, 4, "1 0.4 0.4", "200")
        + &sun(-4, -3, "0.4 0.4 1", "250")
        + &entity("info_null", &[("targetname", "t"), ("origin", "0 0 100")]);
    let map = room(&lights);
    let suns = [
        (Vec3::new(3.0, 4.0, 12.0) / 13.0, Vec3::new(1.0, 0.4, 0.4) * 100.0),
        (Vec3::new(-4.0, -3.0, 12.0) / 13.0, Vec3::new(0.4, 0.4, 1.0) * 125.0),
    ];
    let share = |cosine: f32| if cosine > 0.0 { 0.5 + 0.5 * cosine } else { 0.0 };
    let sides = middle(&map, "lightgrids");
    let axes = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    for (got, side) in sides.iter().zip(axes) {
        assert_near(*got, suns.iter().map(|(u, c)| *c * share(u.dot(side))).sum());
    }
    assert_eq!(sides[5], [0; 3], "nothing from below");
    let best = |u: &Vec3| share(u.abs().max_element());
    assert_near(middle(&map, "octree")[0], suns.iter().map(|(u, c)| *c * best(u)).sum());
}

#[test]
fn p51_a_point_in_the_beam_is_full_on_the_sides_that_the_light_sees() {
    let beam = |towards: &str| {
        let keys = [("origin", "100 90 240"), ("target", "t"), ("light", "10000"), ("delay", "2")];
        let target = [("targetname", "t"), ("origin", towards)];
        room(&(entity("light", &keys) + &entity("info_null", &target)))
    };
    let on = [255; 3];
    assert_eq!(middle(&beam("0 0 128"), "lightgrids"), [on, [0; 3], on, [0; 3], on, [0; 3]]);
    assert_eq!(middle(&beam("0 0 128"), "octree"), [on]);
    let grid = Grid::of(&lit(&beam("100 90 0"), "octree"));
    let at = grid.all().find(|at| grid.position(*at).as_vec3() == Vec3::new(0.0, 0.0, 128.0));
    assert_eq!(grid.light(at.unwrap()), Some(&[][..]), "beside the beam");
}

#[test]
fn p41_bounced_light_has_the_colour_of_what_it_bounces_off() {
    // Light straight up at a yellow ceiling in a black room. How much comes back differs on purpose.
    let keys = [("origin", "0 0 128"), ("mangle", "0 90 0"), ("light", "10000"), ("delay", "2")];
    let map = room(&entity("light", &keys)).room_textures([0, 0, 0, 0, 0, 2]);
    // Maps reflect 99 % at most.
    let colour = Vec3::from(PALETTE[111].map(f32::from)).min(Vec3::splat(0.99 * 255.0));
    assert!(colour.x > 1.5 * colour.z && colour.y > 1.2 * colour.z, "yellow: {colour}");
    let lit = LitLight::bounced(&map);
    let bounced: Vec<Vec3> = lit.all(0).into_iter().filter(|c| c.x > 1.0).collect();
    assert!(bounced.len() > 1000, "{}", bounced.len());
    for c in bounced {
        let want = colour * (c.x / colour.x);
        assert!((c - want).abs().max_element() < 1e-3 * c.x, "{c} {want}");
    }
}

#[test]
fn p52_normals_are_never_smoothed_with_those_of_special_faces() {
    let map = room("");
    for special in [true, false] {
        let bsp = if special {
            map.build(Format::Bsp29)
        } else {
            room("").room_textures([0, 0, 0, 0, 0, 2]).build(Format::Bsp29)
        };
        let keys = texinfo(&bsp, |_| Some(r#"{"phong_angle": 120}"#));
        let sidecar = Sidecar { texinfo: Some(&keys), ..Sidecar::default() };
        let scene = Scene::build(&bsp, sidecar, &SceneSettings::default()).unwrap();
        let wall = scene.surfaces.iter().position(|s| s.normal == Vec3::X).unwrap();
        let samples = luxels::place(&scene, wall, 1);
        let at = |z: f32| {
            let at =
                samples.iter().find(|s| (s.position.z - z).abs() < 1.0 && s.position.y.abs() < 1.0);
            at.expect("a luxel in the middle").normal
        };
        assert!(at(0.0).z > 0.1, "the floor is not special: {}", at(0.0));
        assert_eq!(at(256.0).z < -0.1, !special, "the ceiling: {}", at(256.0));

        // A whole run with the lump of normals ends well.
        let mut bsp = bsp;
        let outputs = Outputs { face_normals: true, ..Outputs::default() };
        let settings = Settings { bounces: Some(0), outputs, ..Settings::default() };
        let quiet = Progress::new(false);
        light_bsp(&mut bsp, sidecar, Vec::new(), &settings, &quiet).unwrap();
        assert_eq!(bsp.bspx.len(), 1);
    }
}

#[test]
fn p47_sizes_follow_the_world_not_the_texture_and_unlit_faces_have_none() {
    let mut bsp = room("")
        .room_textures([0, 0, 0, 0, 2, 1])
        .entities(entity("worldspawn", &[("_world_units_per_luxel", "8"), ("_minlight", "100")]))
        .build(Format::Bsp29);
    for texinfo in &mut bsp.texinfos {
        (texinfo.s, texinfo.t) = (texinfo.s * 0.3, texinfo.t * 2.0);
    }
    let keys =
        texinfo(&bsp, |name| (name == "yellow").then_some(r#"{"world_units_per_luxel": 48}"#));
    let sidecar = Sidecar { texinfo: Some(&keys), ..Sidecar::default() };
    let outputs = Outputs { vanilla: false, ..Outputs::default() };
    let settings = Settings { bounces: Some(0), outputs, ..Settings::default() };
    light_bsp(&mut bsp, sidecar, Vec::new(), &settings, &Progress::new(false)).unwrap();
    assert_eq!(bsp.bspx.len(), 1);
    assert_eq!(bsp.bspx[0].name, "DECOUPLED_LM");
    let mut total = 0;
    for (face, record) in bsp.bspx[0].data.chunks_exact(40).enumerate() {
        let size = [0, 2].map(|i| u16::from_le_bytes([record[i], record[i + 1]]));
        let normal = bsp.face_plane(face).normal;
        // 256 units are 32 steps of 8; from -3 to 3 steps of 48 are needed to hold -128 to 128.
        let (want, style) = if normal == -Vec3::Z {
            ([0, 0], 255)
        } else if normal == Vec3::Z {
            ([7, 7], 0)
        } else {
            ([33, 33], 0)
        };
        assert_eq!(size, want, "face {face}");
        assert_eq!(bsp.faces[face].styles, [style, 255, 255, 255], "face {face}");
        assert_eq!(bsp.faces[face].light_offset, -1);
        total += (usize::from(size[0]) * usize::from(size[1])).next_multiple_of(4);
    }
    assert_eq!(bsp.lighting.len(), total);
}
