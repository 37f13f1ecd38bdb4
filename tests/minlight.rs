//! Minimum light in all its variants, in small rooms lit by the whole program.

mod support;

use glam::Vec3;
use support::lit_levels::LitMap;
use support::lit_room::entity;
use support::map_builder::MapBuilder;

/// A room of 512 x 512 x 256 units, worldspawn first in `entities`.
fn room(entities: String) -> MapBuilder {
    MapBuilder::room([-256.0, -256.0, 0.0], [256.0, 256.0, 256.0])
        .solid_texture("wall", 8)
        .solid_texture("panel", 8)
        .entities(entities)
}

fn world(keys: &[(&str, &str)]) -> String {
    entity("worldspawn", keys)
}

fn model(keys: &[(&str, &str)]) -> String {
    entity("func_wall", &[&[("model", "*1")], keys].concat())
}

/// A block on the floor in the middle.
fn with_block(entities: String, texture: usize) -> MapBuilder {
    room(entities).model([-32.0, -32.0, 0.0], [32.0, 32.0, 64.0], Some(texture))
}

/// The level on top of the block.
fn on_block(map: &LitMap) -> [u8; 3] {
    map.level(0, [0.0, 0.0, 64.0], Vec3::Z)
}

#[test]
fn minimum_light_is_flat_halved_and_does_not_bounce() {
    for bounces in [Some(0), None] {
        let map = room(world(&[("_minlight", "100")]));
        let map = LitMap::with(&map, |_| None, bounces);
        for face in 0..map.faces.len() {
            assert!(map.levels(face, 0).unwrap().iter().all(|l| *l == [50; 3]), "face {face}");
        }
    }
}

#[test]
fn faces_inherit_the_worlds_and_may_have_more_with_a_colour_of_their_own() {
    let dim_red = [("_minlight", "64"), ("_minlight_color", "1 0 0")];
    let level = |keys: &[(&str, &str)]| {
        let map = with_block(world(&dim_red) + &model(keys), 0);
        on_block(&LitMap::new(&map))
    };
    assert_eq!(level(&[]), [32, 0, 0]);
    assert_eq!(level(&[("_minlight", "128")]), [64, 0, 0]);
    assert_eq!(level(&[("_minlight", "128"), ("_minlight_color", "0 1 0")]), [0, 64, 0]);
    assert_eq!(level(&[("_minlight", "128"), ("_mincolor", "0 0 255")]), [0, 0, 64]);
    // Neither less light nor a colour alone has an effect.
    assert_eq!(level(&[("_minlight", "10"), ("_minlight_color", "0 1 0")]), [32, 0, 0]);
    assert_eq!(level(&[("_minlight_color", "0 1 0")]), [32, 0, 0]);
}

#[test]
fn texinfo_keys_apply_to_their_faces_and_models_win_over_them() {
    let map = |keys: &[(&str, &str)], texinfo: &'static str| {
        let map = with_block(world(&[]) + &model(keys), 1);
        on_block(&LitMap::with(&map, |name| (name == "panel").then_some(texinfo), Some(0)))
    };
    let texinfo = r#"{"minlight": 40, "minlight_color": [255, 255, 0]}"#;
    assert_eq!(map(&[], texinfo), [20, 20, 0]);
    assert_eq!(map(&[("_minlight", "60")], texinfo), [30, 30, 0]);
    assert_eq!(map(&[("_minlight", "60")], r#"{"no_minlight": true}"#), [0; 3]);
}

#[test]
fn minimum_light_is_the_least_of_each_channel_or_is_added() {
    let lamp = entity("light", &[("origin", "0 0 65"), ("light", "1 0 0 200"), ("delay", "3")]);
    for (addmin, want) in [("0", [100, 30, 30]), ("1", [130, 30, 30])] {
        let map = room(world(&[("_minlight", "60"), ("_addmin", addmin)]) + &lamp);
        assert_eq!(LitMap::new(&map).level(0, [0.0; 3], Vec3::Z), want, "addmin {addmin}");
    }
}

#[test]
fn negative_lights_take_from_minimum_light_too() {
    let dark = entity("light", &[("origin", "0 0 65"), ("light", "-1000"), ("delay", "3")]);
    let map = LitMap::new(&room(world(&[("_minlight", "128")]) + &dark));
    let floor = map.face([0.0; 3], Vec3::Z);
    assert_eq!(map.levels(floor, 0), None, "all black, so nothing is stored");
}

#[test]
fn mottling_adds_up_to_48_units_and_is_the_same_every_time() {
    let map = room(world(&[("_minlight", "100"), ("_minlight_mottle", "1")]));
    let (a, b) = (LitMap::new(&map), LitMap::new(&map));
    let floor = a.face([0.0; 3], Vec3::Z);
    let levels = a.levels(floor, 0).unwrap();
    assert_eq!(Some(levels), b.levels(floor, 0));
    assert!(levels.iter().all(|l| (50..=74).contains(&l[0])));
    let (low, high) = (levels.iter().min().unwrap(), levels.iter().max().unwrap());
    assert!(high[0] - low[0] >= 8, "{low:?} to {high:?}");
}

#[test]
fn local_minimum_light_lights_what_it_sees_whatever_the_distance_and_angle() {
    let local = [("origin", "0 0 128"), ("light", "80"), ("_color", "0 1 0.5"), ("delay", "4")];
    let map = room(world(&[]) + &entity("light", &local)).pillar(
        [96.0, -256.0, 0.0],
        [112.0, 256.0, 256.0],
        0,
    );
    for bounces in [Some(0), None] {
        let map = LitMap::with(&map, |_| None, bounces);
        for (point, normal) in [
            ([0.0, 0.0, 0.0], Vec3::Z),
            ([-240.0, 240.0, 0.0], Vec3::Z),
            ([-256.0, 0.0, 128.0], Vec3::X),
        ] {
            assert_eq!(map.level(0, point, normal), [0, 40, 20], "{point:?}");
        }
        assert_eq!(map.level(0, [240.0, 0.0, 0.0], Vec3::Z), [0; 3], "behind the wall");
    }
}

#[test]
fn local_minimum_light_keeps_to_its_channels() {
    let local = [("origin", "0 0 128"), ("light", "80"), ("delay", "localmin")];
    let local = entity("light", &[&local[..], &[("_light_channel_mask", "16")]].concat());
    let map = with_block(world(&[]) + &model(&[("_object_channel_mask", "16")]) + &local, 0);
    let map = LitMap::new(&map);
    assert_eq!(on_block(&map), [40; 3]);
    assert_eq!(map.level(0, [128.0, 0.0, 0.0], Vec3::Z), [0; 3]);
}

#[test]
fn luxels_inside_solid_take_the_light_in_the_middle_of_their_model() {
    // The block is half in the wall; the probe at its middle is free. Range applies twice.
    let lamp = entity("light", &[("origin", "0 0 128"), ("light", "200"), ("delay", "3")]);
    let build = |keys: &[(&str, &str)]| {
        let lamp = lamp.clone();
        let map = room(world(&[("_anglescale", "0")]) + &model(keys) + &lamp)
            .pillar([64.0, -64.0, 0.0], [128.0, 64.0, 128.0], 0)
            .model([0.0, -32.0, 0.0], [96.0, 32.0, 64.0], Some(0));
        LitMap::new(&map)
    };
    let end = |map: &LitMap| map.level(0, [96.0, 0.0, 32.0], Vec3::X);
    assert_eq!(end(&build(&[])), [50; 3], "200 halved twice");
    assert_eq!(end(&build(&[("_autominlight", "0")])), [0; 3]);
    let map = build(&[("_autominlight", "1")]);
    assert_eq!(map.level(0, [32.0, 0.0, 0.0], -Vec3::Z), [50; 3], "also below, where all is free");
}

#[test]
fn the_probe_may_be_moved_to_an_entity_and_must_be_free() {
    let dim = |origin: &str| {
        let lamp = entity("light", &[("origin", "-128 0 200"), ("light", "200")]);
        let target = entity("info_null", &[("targetname", "probe"), ("origin", origin)]);
        let keys = [("_autominlight", "1"), ("_autominlight_target", "probe")];
        let map = with_block(world(&[]) + &model(&keys) + &lamp + &target, 0);
        LitMap::new(&map).level(0, [0.0, 0.0, 0.0], -Vec3::Z)
    };
    // Straight below the lamp, at 100 units: (200 - 100) / 2 / 2.
    assert_eq!(dim("-128 0 100"), [25; 3]);
    assert_eq!(dim("0 0 -50"), [0; 3], "in solid");
}

#[test]
fn light_surfaces_in_the_manner_of_radiosity_light_and_glow() {
    let light = |more: &[(&str, &str)]| {
        let keys = [
            ("origin", "0 0 128"),
            ("light", "100"),
            ("_color", "1 0.5 0"),
            ("_surface", "panel"),
            ("_surface_radiosity", "1"),
        ];
        entity("light", &[&keys[..], more].concat())
    };
    let block = |entities: String| {
        let map = room(entities).pillar([-8.0, -8.0, 0.0], [8.0, 8.0, 16.0], 1);
        LitMap::new(&map)
    };
    let map = block(world(&[]) + &light(&[]));
    assert!(map.scene.lights.is_empty());
    assert_eq!(map.level(0, [0.0, 0.0, 16.0], Vec3::Z), [50, 25, 0], "its own glow");
    // Only the top face sees the ceiling: 256 square units at 100, from 17 to 255 above the floor.
    let k = 100.0 * 256.0 / (238.0 * 238.0) * 0.5_f32;
    assert_eq!(map.level(0, [0.0, 0.0, 256.0], -Vec3::Z), [k as u8, (k / 2.0) as u8, 0]);
    let dark = block(world(&[("_surflight_minlight_scale", "0")]) + &light(&[]));
    // Its one point meets the luxel there at no distance, with both softened cosines at a half:
    // 100 * 256 / 16^2 / 4.
    assert_eq!(dark.level(0, [0.0, 0.0, 16.0], Vec3::Z), [12, 6, 0]);
    let styled = block(world(&[]) + &light(&[("style", "5")]));
    assert_eq!(styled.level(5, [0.0, 0.0, 16.0], Vec3::Z), [50, 25, 0]);
}
