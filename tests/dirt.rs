//! Dirt: corners are darker, for those who ask for it.

mod support;

use glam::Vec3;
use support::lit_levels::LitMap;
use support::lit_room::entity;
use support::map_builder::MapBuilder;

/// A room with light from everywhere: minimum light, and a lamp without falloff or angle.
fn room(world: &[(&str, &str)], lamp: &[(&str, &str)]) -> MapBuilder {
    let lamp_keys = [("origin", "0 0 128"), ("delay", "3"), ("_anglescale", "0")];
    let text = entity("worldspawn", world) + &entity("light", &[&lamp_keys[..], lamp].concat());
    MapBuilder::room([-256.0, -256.0, 0.0], [256.0, 256.0, 256.0])
        .solid_texture("wall", 8)
        .solid_texture("*lava", 8)
        .entities(text)
}

fn floor(map: &LitMap, x: f32, y: f32) -> u8 {
    map.level(0, [x, y, 0.0], Vec3::Z)[0]
}

const LAMP: &[(&str, &str)] = &[("light", "200")];

#[test]
fn corners_are_darker_and_the_open_is_not() {
    let map = LitMap::new(&room(&[("_dirt", "1")], LAMP));
    assert_eq!(floor(&map, 0.0, 0.0), 100, "nothing within 128 units");
    let (edge, corner) = (floor(&map, 240.0, 0.0), floor(&map, 240.0, 240.0));
    assert!(corner < edge && edge < 100 && corner > 20, "{edge} {corner}");
    let none = LitMap::new(&room(&[], LAMP));
    assert_eq!(floor(&none, 240.0, 240.0), 100);
}

#[test]
fn the_rays_are_those_of_the_contract() {
    // A wall 17 units from the sample stops each of the 48 rays that reaches it within 128 units.
    let map = LitMap::new(&room(&[("_dirt", "1")], LAMP));
    let mut sum = 0.0;
    for azimuth in (0..16).map(|i| (f64::from(i) * 22.5).to_radians()) {
        for elevation in [0.5, 1.5, 2.5].map(|e| (e * 88.0 / 3.0_f64).to_radians()) {
            let along = elevation.sin() * azimuth.cos();
            sum += if along > 1e-9 { (16.0 / along).min(128.0) } else { 128.0 };
        }
    }
    let share = sum / 48.0 / 128.0;
    assert_eq!(f64::from(floor(&map, 240.0, 0.0)), (share * 100.0).floor());
}

#[test]
fn depth_scale_gain_and_angle_change_it() {
    let edge = |keys: &[(&str, &str)]| {
        let keys = [&[("_dirt", "1")], keys].concat();
        i32::from(floor(&LitMap::new(&room(&keys, LAMP)), 240.0, 0.0))
    };
    let plain = edge(&[]);
    let dirt = 100 - plain;
    assert_eq!(edge(&[("_dirtscale", "0")]), 100);
    assert!((100 - edge(&[("_dirtscale", "2")]) - 2 * dirt).abs() <= 1);
    assert!(edge(&[("_dirtgain", "2")]) > plain, "a weaker effect where dirt is light");
    assert!(edge(&[("_dirtdepth", "17")]) > plain);
    assert_eq!(edge(&[("_dirtdepth", "15")]), 100);
    assert_eq!(edge(&[("_dirtangle", "5")]), 100, "the wall is not above");
}

#[test]
fn random_directions_are_the_same_every_time_and_agree_on_average() {
    let map = room(&[("_dirt", "1"), ("_dirtmode", "1")], LAMP);
    let (a, b) = (LitMap::new(&map), LitMap::new(&map));
    let fixed = LitMap::new(&room(&[("_dirt", "1")], LAMP));
    let face = a.face([0.0; 3], Vec3::Z);
    let levels = |map: &LitMap| map.levels(face, 0).unwrap().to_vec();
    assert_eq!(levels(&a), levels(&b));
    assert_ne!(levels(&a), levels(&fixed));
    let mean = |map: &LitMap| {
        let l = levels(map);
        l.iter().map(|l| f64::from(l[0])).sum::<f64>() / l.len() as f64
    };
    assert!((mean(&a) - mean(&fixed)).abs() < 1.0, "{} {}", mean(&a), mean(&fixed));
}

#[test]
fn lights_choose_for_themselves() {
    let corner = |world: &[(&str, &str)], lamp: &[(&str, &str)]| {
        floor(&LitMap::new(&room(world, &[LAMP, lamp].concat())), 240.0, 240.0)
    };
    let dirty = corner(&[("_dirt", "1")], &[]);
    assert_eq!(corner(&[("_dirt", "1")], &[("_dirt", "-1")]), 100);
    assert_eq!(corner(&[], &[("_dirt", "1")]), dirty, "one light is enough to trace dirt");
    assert!(corner(&[], &[("_dirt", "1"), ("_dirtscale", "2")]) < dirty);
    assert!(corner(&[], &[("_dirt", "1"), ("_dirtgain", "0.5")]) < dirty);
    // The corner is 339 units across and 128 below: 362 away.
    let radii = |off, on| {
        corner(&[], &[("_dirt", "1"), ("_dirt_off_radius", off), ("_dirt_on_radius", on)])
    };
    assert_eq!(radii("400", "500"), 100);
    assert_eq!(radii("100", "200"), dirty);
    assert!((dirty + 5..95).contains(&radii("300", "424")));
}

#[test]
fn minimum_light_gets_dirt_if_it_is_to() {
    let corner = |dirt: &str| {
        let keys = [("_dirt", "1"), ("_minlight", "100"), ("_minlight_dirt", dirt)];
        floor(&LitMap::new(&room(&keys, &[("light", "0")])), 240.0, 240.0)
    };
    assert_eq!(corner("0"), 50);
    assert!(corner("1") < 40);
}

#[test]
fn liquids_and_faces_without_dirt_stay_clean_and_liquids_make_none() {
    let pool = room(&[("_dirt", "1"), ("_dirtscale", "2")], LAMP).pillar(
        [128.0, -64.0, 0.0],
        [192.0, 64.0, 32.0],
        1,
    );
    let map = LitMap::new(&pool);
    assert_eq!(map.level(0, [160.0, 0.0, 32.0], Vec3::Z), [100; 3]);
    assert_eq!(floor(&map, 112.0, 0.0), 100, "beside the liquid");
    let map =
        LitMap::with(&room(&[("_dirt", "1")], LAMP), |_| Some(r#"{"no_dirt": true}"#), Some(0));
    assert_eq!(floor(&map, 240.0, 240.0), 100);
    let wall = entity("func_wall", &[("model", "*1"), ("_dirt", "-1")]);
    let text = entity("worldspawn", &[("_dirt", "1")])
        + &entity("light", &[("origin", "0 0 128"), ("delay", "3"), ("_anglescale", "0")])
        + &wall;
    let map =
        room(&[], LAMP).entities(text).model([208.0, 208.0, 0.0], [256.0, 256.0, 8.0], Some(0));
    assert_eq!(LitMap::new(&map).level(0, [240.0, 240.0, 8.0], Vec3::Z), [150; 3]);
}
