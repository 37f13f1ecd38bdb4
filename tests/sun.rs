//! Suns and sky domes in rooms under sky, with answers worked out by hand.

mod support;

use glam::Vec3;
use qrad::bsp::Format;
use qrad::scene::{Scene, SceneSettings, Sidecar};
use support::lit_room::{LitRoom, entity, level};
use support::map_builder::MapBuilder;

/// A room of 512 x 512 x 256 units under sky.
fn room(world: &[(&str, &str)], others: &str) -> MapBuilder {
    MapBuilder::room([-256.0, -256.0, 0.0], [256.0, 256.0, 256.0])
        .solid_texture("wall", 8)
        .solid_texture("sky_void", 8)
        .solid_texture("sky3", 8)
        .flags(1)
        .room_textures([0, 0, 0, 0, 0, 1])
        .entities(entity("worldspawn", world) + others)
}

fn sun(keys: &[(&str, &str)]) -> String {
    entity("light", &[&[("_sun", "1")], keys].concat())
}

#[test]
fn sunlight_follows_its_mangle_and_half_the_cosine() {
    let room = LitRoom::new(&room(&[("_sunlight", "100"), ("_sun_mangle", "0 -80 0")], ""));
    // 100 (0.5 + 0.5 sin 80) / 2 = 49.6
    assert_eq!(level(room.floor(0, 0.0, 0.0)), [49; 3]);
    // The low wall x = -256 looks along the light and gets none of it; the other one looks at it.
    assert_eq!(room.at(0, [-256.0, 0.0, 128.0], Vec3::X), Vec3::ZERO);
    let want = 100.0 * (0.5 + 0.5 * 80_f32.to_radians().cos());
    let wall = room.at(0, [256.0, 0.0, 32.0], Vec3::NEG_X);
    assert!((wall.x - want).abs() < 1e-3, "{wall} {want}");
}

#[test]
fn without_a_mangle_the_sun_stands_in_the_zenith() {
    let map =
        room(&[("_sunlight", "100")], "").pillar([-32.0, -32.0, 96.0], [32.0, 32.0, 128.0], 0);
    let room = LitRoom::new(&map);
    assert_eq!(room.floor(0, 0.0, 0.0), Vec3::ZERO, "below the block");
    for (x, y) in [(48.0, 0.0), (-48.0, 0.0), (0.0, 48.0), (0.0, -48.0)] {
        assert_eq!(room.floor(0, x, y), Vec3::splat(100.0));
    }
}

#[test]
fn sunlight_leaves_no_cracks() {
    // Faces, and the sky, are cut at whole numbers, which luxels and many rays meet exactly.
    for cell in [16.0, 32.0, 64.0, 100.0] {
        let keys = [("light", "300"), ("_color", "1 0 0"), ("mangle", "0 -45 0")];
        let map = MapBuilder::room([-128.0, -256.0, 0.0], [1024.0, 256.0, 256.0])
            .solid_texture("wall", 8)
            .solid_texture("sky1", 8)
            .flags(1)
            .room_textures([1, 1, 1, 1, 0, 1])
            .subdivide(cell)
            .entities(entity("worldspawn", &[]) + &sun(&keys));
        let room = LitRoom::new(&map);
        let mut luxels = 0;
        for (_, samples, light) in room.facing(Vec3::Z) {
            for i in (0..samples.len()).filter(|i| !samples[*i].occluded) {
                luxels += 1;
                let at = samples[i].position;
                assert_eq!(level(light.styles[0].irradiance[i].0), [128, 0, 0], "{at} {cell}");
            }
        }
        assert!(luxels > 2000, "{luxels}");
    }
}

#[test]
fn straight_sunlight_leaves_no_cracks_either() {
    for cell in [16.0, 64.0] {
        let map = room(&[("_sunlight", "200")], "").subdivide(cell);
        for (surface, samples, light) in LitRoom::new(&map).facing(Vec3::Z) {
            let map = &light.styles[0].irradiance;
            for i in (0..samples.len()).filter(|i| !samples[*i].occluded) {
                assert_eq!(map[i].0, Vec3::splat(200.0), "{surface} {}", samples[i].position);
            }
        }
    }
}

#[test]
fn suns_of_a_texture_shine_through_that_sky_only() {
    // Two halls, one under each sky, and a wall between them.
    let target = |x: i32| {
        entity("info_null", &[("targetname", &format!("t{x}")), ("origin", &format!("{x} 0 0"))])
    };
    let one = |texture: &str, colour: &str, x: i32| {
        let origin = format!("{} 0 {}", x + 64, 136);
        let target = format!("t{x}");
        sun(&[
            ("origin", &origin),
            ("target", &target),
            ("light", "300"),
            ("_color", colour),
            ("_suntexture", texture),
        ])
    };
    let entities =
        [one("SKY_VOID", "0.25 0 0", 0), one("sky3", "0 0 1", 8), target(0), target(8)].concat();
    for (sky, want) in [(1, [35, 0, 0]), (2, [0, 0, 142])] {
        let map = room(&[], &entities).room_textures([0, 0, 0, 0, 0, sky]);
        assert_eq!(level(LitRoom::new(&map).floor(0, 0.0, 0.0)), want);
    }
}

#[test]
fn a_sun_aims_by_target_or_mangle_alike() {
    let block = |keys: &[(&str, &str)]| {
        let target = entity("info_null", &[("targetname", "t"), ("origin", "0 0 -100")]);
        let keys = [&[("light", "220"), ("_color", "1 0 0"), ("origin", "0 0 50")], keys].concat();
        LitRoom::new(&room(&[], &(sun(&keys) + &target)).pillar(
            [-32.0, -32.0, 96.0],
            [32.0, 32.0, 128.0],
            0,
        ))
    };
    for room in [block(&[("target", "t")]), block(&[("mangle", "0 -90 0")])] {
        assert!(room.scene.lights.is_empty(), "the entity itself does not shine");
        assert_eq!(room.floor(0, 0.0, 0.0), Vec3::ZERO);
        assert_eq!(room.floor(0, 128.0, 0.0), Vec3::new(220.0, 0.0, 0.0));
        assert_eq!(room.floor(0, -128.0, 0.0), Vec3::new(220.0, 0.0, 0.0));
    }
}

#[test]
fn the_whole_dome_lights_open_ground_and_only_from_its_side() {
    // No wall hides any of the dome: all of the sides are sky.
    let open = |keys: &[(&str, &str)], entities: &str| {
        LitRoom::new(&room(keys, entities).room_textures([1, 1, 1, 1, 0, 1]))
    };
    let rings: f64 = [9.0_f64, 27.0, 45.0, 63.0].iter().map(|e| 16.0 * e.to_radians().sin()).sum();
    let want = 130.0 * (0.5 + 0.5 * (rings + 1.0) / 65.0);
    for room in [
        open(&[("_sunlight2", "130")], ""),
        open(&[], &entity("light", &[("_sunlight2", "1"), ("light", "130"), ("origin", "0 0 9")])),
    ] {
        let got = f64::from(room.floor(0, 16.0, 32.0).x);
        assert!((got - want).abs() < 1e-3, "{got} {want}");
    }
    let lower = open(&[("_sunlight3", "130")], "");
    assert_eq!(lower.floor(0, 16.0, 32.0), Vec3::ZERO);
}

#[test]
fn penumbra_softens_the_shadow_of_an_edge() {
    let block = |keys: &[(&str, &str)]| {
        let map = room(keys, "").pillar([-256.0, -256.0, 192.0], [0.0, 256.0, 224.0], 0);
        let room = LitRoom::new(&map);
        let row: Vec<f32> = (-6..7).map(|i| room.floor(0, i as f32 * 16.0, 0.0).x).collect();
        let between = |v: &&f32| **v > 1.0 && **v < 99.0;
        (row.iter().filter(between).count(), row[0], row[12])
    };
    assert_eq!(block(&[("_sunlight", "100")]), (0, 0.0, 100.0));
    let keys =
        [("_sunlight", "100"), ("_sunlight_mangle", "0 -89.9"), ("_sunlight_penumbra", "12")];
    let (soft, dark, bright) = block(&keys);
    assert!(soft >= 3 && dark == 0.0 && bright > 98.0, "{soft} {dark} {bright}");
}

#[test]
fn negative_suns_are_kept_apart_and_style_and_channels_hold() {
    let style = sun(&[("light", "50"), ("style", "3"), ("mangle", "0 -90 0")]);
    let map = room(&[("_sunlight", "-40"), ("_sun2", "100")], &style);
    let room = LitRoom::new(&map);
    assert_eq!(room.floor(0, 0.0, 0.0).x, 100.0);
    assert_eq!(room.floor(3, 0.0, 0.0).x, 50.0);
    let (_, _, light) = &room.facing(Vec3::Z)[0];
    assert!(light.negative[0].irradiance.iter().any(|e| e.0 == Vec3::splat(-40.0)));

    let other = |name: &str| (name == "wall").then_some(r#"{"object_channel_mask": 2}"#);
    let room = LitRoom::with_texinfo(&map, other);
    assert_eq!((room.floor(0, 0.0, 0.0), room.floor(3, 0.0, 0.0)), (Vec3::ZERO, Vec3::ZERO));
}

#[test]
fn light_ignoring_faces_see_no_sun() {
    let ignore = |name: &str| (name == "wall").then_some(r#"{"light_ignore": true}"#);
    let map = room(&[("_sunlight", "100"), ("_sunlight2", "100")], "");
    assert_eq!(LitRoom::with_texinfo(&map, ignore).floor(0, 0.0, 0.0), Vec3::ZERO);
}

#[test]
fn wild_suns_are_no_trouble_and_too_many_are_refused() {
    let wild = sun(&[("origin", "1e38 -1e38 1e38"), ("light", "1e38")])
        + &sun(&[("origin", "0 0 0"), ("deviance", "1e9"), ("mangle", "1e30 0 0")])
        + &entity("light", &[("_sunlight3", "1"), ("origin", "0 0 9"), ("samples", "2000000000")]);
    let keys = [("_sunlight", "-1e38"), ("_sun_mangle", "x"), ("_sunlight_penumbra", "999")];
    let bsp = room(&keys, &wild).build(Format::Bsp29);
    let scene = Scene::build(&bsp, Sidecar::default(), &SceneSettings::default()).unwrap();
    LitRoom { scene }.facing(Vec3::Z);

    let dome = entity("light", &[("_sunlight2", "1"), ("origin", "0 0 9")]);
    let bsp = room(&[("_sunsamples", "2048")], &dome.repeat(1000)).build(Format::Bsp29);
    let error = Scene::build(&bsp, Sidecar::default(), &SceneSettings::default()).err().unwrap();
    assert!(error.to_string().contains("_sunsamples"), "{error}");
}
