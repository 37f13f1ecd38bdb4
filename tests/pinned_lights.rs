//! Acceptance cases of the contract's section 12.1 and 12.3: lights, suns, minimum light and surface
//! lights on maps built here. What the other tests of these effects pin is not repeated.

mod support;

use glam::Vec3;
use support::lit_levels::LitMap;
use support::lit_room::{LitRoom, entity};
use support::map_builder::MapBuilder;

/// A room of 512 x 512 x 256 units.
fn room(world: &[(&str, &str)], others: &str) -> MapBuilder {
    MapBuilder::room([-256.0, -256.0, 0.0], [256.0, 256.0, 256.0])
        .solid_texture("wall", 8)
        .solid_texture("sky_void", 8)
        .flags(1)
        .solid_texture("sky3", 8)
        .flags(1)
        .solid_texture("bolt16", 8)
        .entities(entity("worldspawn", world) + others)
}

fn floor(map: &LitMap, x: f32, y: f32) -> [u8; 3] {
    map.level(0, [x, y, 0.0], Vec3::Z)
}

/// Whether each channel is within one level, as all cases allow.
#[track_caller]
fn assert_level(got: [u8; 3], want: [u8; 3]) {
    let near = got.iter().zip(want).all(|(a, b)| a.abs_diff(b) <= 1);
    assert!(near, "{got:?} instead of {want:?}");
}

#[test]
fn p1_minimum_light_does_not_add_to_sunlight() {
    let keys = [("_sunlight", "100"), ("_sun_mangle", "0 -80 0"), ("light", "5")];
    let map = LitMap::new(&room(&keys, "").room_textures([0, 0, 0, 0, 0, 1]));
    assert_eq!(floor(&map, 0.0, 0.0), [49; 3]);
    // What the sun cannot reach has 5, halved.
    assert_eq!(map.level(0, [-256.0, 0.0, 128.0], Vec3::X), [2; 3]);
}

#[test]
fn p7_suns_of_two_skies_of_one_map_do_not_mix() {
    let target = |name: &str, x: i32| {
        entity("info_null", &[("targetname", name), ("origin", &format!("{x} 0 0"))])
    };
    let sun = |texture: &str, colour: &str, name: &str, x: i32| {
        let keys = [("_sun", "1"), ("light", "300"), ("_color", colour), ("target", name)];
        let from = [("origin", &*format!("{x} 0 136")), ("_suntexture", texture)];
        entity("light", &[&keys[..], &from].concat())
    };
    let others = sun("sky_void", "0.25 0 0", "a", 64)
        + &target("a", 0)
        + &sun("sky3", "0 0 1", "b", 192)
        + &target("b", 128);
    // The other sky is the underside of a slab below half of the ceiling.
    let map = room(&[], &others).room_textures([0, 0, 0, 0, 0, 1]).pillar(
        [0.0, -256.0, 240.0],
        [256.0, 256.0, 256.0],
        2,
    );
    let map = LitMap::new(&map);
    // Towards the sky a ray goes 113 units along x: luxels left of -113 see the ceiling, those right of
    // it the slab, until its rays meet the wall.
    for x in [-240.0, -192.0, -128.0] {
        assert_eq!(floor(&map, x, 0.0), [35, 0, 0], "{x}");
    }
    for x in [-96.0, 0.0, 128.0] {
        assert_eq!(floor(&map, x, 0.0), [0, 0, 142], "{x}");
    }
    assert_eq!(floor(&map, 160.0, 0.0), [0; 3]);
}

#[test]
fn p10_spots_of_10_degrees_have_their_radius_in_both_spellings() {
    for extra in [("_cone", "10"), ("angle", "20")] {
        let keys = [("origin", "0 0 253"), ("light", "500"), ("mangle", "0 -90 0"), extra];
        let room = LitRoom::new(&room(&[], &entity("light", &keys)));
        // 252 above the samples: radius 44.43.
        assert_eq!(room.floor(0, 64.0, 0.0), Vec3::ZERO);
        assert_eq!(room.floor(0, 48.0, 0.0), Vec3::ZERO);
        let d = f32::hypot(252.0, 32.0);
        let want = (500.0 - d) * (0.5 + 0.5 * 252.0 / d);
        let got = room.floor(0, 32.0, 0.0);
        assert!((got - Vec3::splat(want)).length() < 0.01, "{got} {want}");
        assert!((want - 245.0).abs() < 1.0, "243 at 4 units more");
    }
}

#[test]
fn p11_negative_light_leaves_nothing_with_bounces_too() {
    let dark = entity("light", &[("origin", "0 0 65"), ("light", "-1000"), ("delay", "3")]);
    for bounces in [Some(0), Some(1), None] {
        let map = room(&[("_minlight", "128")], &dark);
        let map = LitMap::with(&map, |_| None, bounces);
        let floor = map.face([0.0; 3], Vec3::Z);
        assert_eq!(map.levels(floor, 0), None, "{bounces:?}");
    }
}

#[test]
fn p12_minimum_light_without_mottle_is_flat() {
    let map = LitMap::new(&room(&[("_minlight", "66"), ("_minlight_mottle", "0")], ""));
    for face in 0..map.faces.len() {
        assert!(map.levels(face, 0).unwrap().iter().all(|l| *l == [33; 3]), "face {face}");
    }
}

#[test]
fn p13_groups_and_models_inherit_minimum_light_and_may_have_more() {
    let world = [("_minlight", "128"), ("_minlight_color", "1 0 0")];
    // A block on the floor: a brush model with the key of a wall, or with the keys that the compiler
    // gives the faces of a group.
    let top = |keys: &[(&str, &str)], texinfo: Option<&'static str>| {
        let wall = entity("func_wall", &[&[("model", "*1")], keys].concat());
        let map = room(&world, &wall).model([-32.0, -32.0, 0.0], [32.0, 32.0, 64.0], Some(3));
        let map = LitMap::with(&map, |name| texinfo.filter(|_| name == "bolt16"), Some(0));
        assert_eq!(floor(&map, 128.0, 0.0), [64, 0, 0], "the world");
        map.level(0, [0.0, 0.0, 64.0], Vec3::Z)
    };
    let more = Some(r#"{"minlight": 256, "minlight_color": [255, 0, 0]}"#);
    assert_eq!(top(&[], None), [64, 0, 0]);
    assert_eq!(top(&[], more), [128, 0, 0], "a group");
    let keys = [("_minlight", "256"), ("_minlight_color", "1 0 0")];
    for texinfo in [None, more] {
        assert_eq!(top(&keys, texinfo), [128, 0, 0], "with and without the file: {texinfo:?}");
    }
    // A colour alone has an effect in Quake II only (contract section 6.1).
    assert_eq!(top(&[("_minlight_color", "0 1 0")], None), [64, 0, 0]);
}

#[test]
fn p15_faces_without_light_have_no_lightmap() {
    let keys = [("origin", "0 0 128"), ("mangle", "0 -90 0"), ("light", "300")];
    let map = room(&[], &entity("light", &keys)).solid_texture("*water", 8).liquid(
        [128.0, 128.0, 200.0],
        [192.0, 192.0, 240.0],
        4,
    );
    let map = LitMap::new(&map);
    let lit = map.face([0.0; 3], Vec3::Z);
    assert_eq!(map.bsp.faces[lit].styles, [0, 255, 255, 255]);
    assert!(map.bsp.faces[lit].light_offset >= 0);
    for (at, normal) in [
        ([0.0, 0.0, 256.0], -Vec3::Z),
        ([256.0, 0.0, 128.0], -Vec3::X),
        ([160.0, 160.0, 240.0], Vec3::Z),
    ] {
        let record = &map.bsp.faces[map.face(at, normal)];
        assert_eq!((record.styles, record.light_offset), ([255; 4], -1), "{at:?}");
    }
}

#[test]
fn p35_surface_lights_keep_to_the_faces_of_their_group() {
    // Lamps of one texture at the ceiling, the right one of group 1, and a wall between them. Five sides
    // of a lamp shine, each as a point of 30 units.
    let template = |colour: &str, group: &str| {
        let keys = [("_surface", "bolt16"), ("light", "30"), ("delay", "3"), ("_anglescale", "0")];
        entity("light", &[&keys[..], &[("_color", colour), ("_surflight_group", group)]].concat())
    };
    let map = room(&[], &(template("1 0 0", "0") + &template("0 0 1", "1")))
        .solid_texture("BOLT16", 8)
        .pillar([-8.0, -256.0, 0.0], [8.0, 256.0, 256.0], 0)
        .pillar([-128.0, 0.0, 240.0], [-112.0, 16.0, 256.0], 3)
        .pillar([112.0, 0.0, 240.0], [128.0, 16.0, 256.0], 4);
    let group = |name: &str| (name == "BOLT16").then_some(r#"{"surflight_group": 1}"#);
    let map = LitMap::with(&map, group, Some(0));
    assert_eq!(floor(&map, -112.0, 16.0), [75, 0, 0]);
    assert_eq!(floor(&map, 112.0, 16.0), [0, 0, 75]);
}

#[test]
fn p36_light_set_into_a_wall_leaves_no_black_beside_it() {
    let lamp =
        entity("light", &[("_surface", "bolt16"), ("light", "100"), ("_surface_radiosity", "1")]);
    // The whole end wall shines, and meets the floor, the ceiling and two walls.
    let map = LitMap::new(&room(&[], &lamp).room_textures([3, 0, 0, 0, 0, 0]));
    assert!(map.bsp.bspx.is_empty());
    for (at, normal) in [
        ([0.0, 0.0, 0.0], Vec3::Z),
        ([0.0, 0.0, 256.0], -Vec3::Z),
        ([0.0, -256.0, 128.0], Vec3::Y),
        ([0.0, 256.0, 128.0], -Vec3::Y),
    ] {
        let levels = map.levels(map.face(at, normal), 0).unwrap();
        assert!(levels.iter().all(|l| l[0] > 0), "{at:?}");
    }
}

#[test]
fn p37_light_grows_towards_a_shining_cube() {
    let keys = [("_surface", "bolt16"), ("light", "1 1 1 100"), ("_surface_radiosity", "1")];
    let map = room(&[("_lightmap_scale", "4")], &entity("light", &keys)).pillar(
        [-16.0, -16.0, 112.0],
        [16.0, 16.0, 144.0],
        3,
    );
    let hard = |name: &str| (name == "bolt16").then_some(r#"{"surflight_rescale": false}"#);
    let room = LitRoom::with_texinfo(&map, hard);
    let mut last = 0.0;
    for x in (0..=60).rev().map(|i| 4.0 * i as f32) {
        // The middles of the underside and of the side that looks this way, one unit before them.
        let (x1, h1) = (x - 17.0, 127.0);
        let (x2, h2) = (x, 110.0);
        let side = if x1 > 0.0 { x1 * h1 / (x1 * x1 + h1 * h1).powi(2) } else { 0.0 };
        let under = h2 * h2 / (x2 * x2 + h2 * h2).powi(2);
        let want = 100.0 * 32.0 * 32.0 * (side + under);
        let got = room.floor(0, x, 0.0).x;
        assert!((got - want).abs() < 0.01, "{x}: {got} {want}");
        assert!(got >= last, "{x}: {got} after {last}");
        last = got;
    }
}

#[test]
fn p42_sparse_luxels_lie_where_dense_ones_do() {
    // Light and dirt on a cube in a corner, with luxels 16 and 32 units apart.
    let lamp = entity("light", &[("origin", "100 -100 200"), ("light", "1 0.8 0 400")]);
    let cube = |scale: &str| {
        let map = room(&[("_dirt", "1"), ("_lightmap_scale", scale)], &lamp);
        LitMap::new(&map.pillar([128.0, -64.0, 0.0], [256.0, 64.0, 128.0], 3))
    };
    let (dense, sparse) = (cube("16"), cube("32"));
    let mut seen = 0;
    for (a, b) in (0..=4).flat_map(|a| (0..=4).map(move |b| (32.0 * a as f32, 32.0 * b as f32))) {
        for (at, normal) in [
            ([128.0, a - 64.0, b], -Vec3::X),
            ([128.0 + a, -64.0, b], -Vec3::Y),
            ([128.0 + a, b - 64.0, 128.0], Vec3::Z),
        ] {
            let (dense, sparse) = (dense.level(0, at, normal), sparse.level(0, at, normal));
            assert_eq!(dense, sparse, "{at:?} {normal}");
            assert!(sparse[0] > 10 && sparse[2] == 0, "{at:?}: {sparse:?}");
            seen += 1;
        }
    }
    assert_eq!(seen, 75);
}

#[test]
fn p40_the_whole_of_a_light_surface_glows() {
    let keys = [("_surface", "bolt16"), ("light", "100"), ("_surface_radiosity", "1")];
    let lamp = entity("light", &[&keys[..], &[("_color", "1 0.5 0")]].concat());
    let map =
        room(&[], &lamp).solid_texture("*bolt16", 8).pillar([-8.0, -8.0, 0.0], [8.0, 8.0, 16.0], 3);
    let map = LitMap::new(&map);
    for normal in [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z] {
        let at = Vec3::new(0.0, 0.0, 8.0) + normal * 8.0;
        let levels = map.levels(map.face(at.into(), normal), 0).unwrap();
        for l in levels {
            assert!((50..=75).contains(&l[0]) && (25..=35).contains(&l[1]) && l[2] == 0, "{l:?}");
        }
    }
    assert_level(map.level(0, [0.0, 0.0, 16.0], Vec3::Z), [50, 25, 0]);
}
