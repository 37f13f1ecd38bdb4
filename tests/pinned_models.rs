//! Acceptance cases of the contract's section 12.2: brush models, switchable shadows and channels.

mod support;

use glam::Vec3;
use qrad::bsp::parse_entities;
use support::lit_levels::LitMap;
use support::lit_room::entity;
use support::map_builder::MapBuilder;

/// A room of 512 x 512 x 256 units.
fn room(world: &[(&str, &str)], others: &str) -> MapBuilder {
    MapBuilder::room([-256.0, -256.0, 0.0], [256.0, 256.0, 256.0])
        .solid_texture("wall", 8)
        .solid_texture("panel", 8)
        .solid_texture("sky1", 8)
        .flags(1)
        .entities(entity("worldspawn", world) + others)
}

fn model(class: &str, number: usize, keys: &[(&str, &str)]) -> String {
    entity(class, &[&[("model", &*format!("*{number}"))], keys].concat())
}

fn lamp(origin: &str, light: &str, keys: &[(&str, &str)]) -> String {
    entity("light", &[&[("origin", origin), ("light", light)], keys].concat())
}

/// A wall across the whole room at x = 0.
fn across(map: MapBuilder) -> MapBuilder {
    map.model([-8.0, -256.0, 0.0], [8.0, 256.0, 256.0], Some(1))
}

fn floor(map: &LitMap, style: u16, x: f32, y: f32) -> [u8; 3] {
    map.level(style, [x, y, 0.0], Vec3::Z)
}

/// Level of a light with linear falloff at a luxel of the floor.
fn linear(light: [f32; 3], brightness: f32, x: f32) -> u8 {
    let to = Vec3::from(light) - Vec3::new(x, 0.0, 1.0);
    (0.5 * (brightness - to.length()) * (0.5 + 0.5 * to.z / to.length())) as u8
}

/// Value of a key of the entity `index` after lighting.
fn value(map: &LitMap, index: usize, key: &str) -> Option<String> {
    parse_entities(&map.bsp.entities).unwrap()[index].get(key).map(str::to_owned)
}

#[test]
fn p19_a_switch_moves_light_behind_a_door_to_style_32() {
    let switch = [("_switchableshadow_target", "door1"), ("targetname", "switch")];
    let others = lamp("-64 0 64", "500", &[("_color", "1 0 0")])
        + &model("func_door", 1, &[("targetname", "door1")])
        + &lamp("100 100 100", "300", &switch);
    let map = LitMap::new(&across(room(&[], &others)));
    assert_eq!(value(&map, 3, "style").as_deref(), Some("32"), "written into the map");
    assert_eq!(value(&map, 1, "style"), None);
    let red = |x: f32| [linear([-64.0, 0.0, 64.0], 500.0, x), 0, 0];
    for x in [-192.0, -128.0, -64.0] {
        assert_eq!((floor(&map, 0, x, 0.0), floor(&map, 32, x, 0.0)), (red(x), [0; 3]), "{x}");
    }
    for x in [64.0, 128.0, 192.0] {
        assert_eq!((floor(&map, 0, x, 0.0), floor(&map, 32, x, 0.0)), ([0; 3], red(x)), "{x}");
    }
}

#[test]
fn p20_a_door_with_a_switchable_shadow_shades_itself_in_every_style() {
    let others = lamp("-64 0 64", "500", &[])
        + &model("func_door", 1, &[("_switchableshadow", "1"), ("_minlight", "25")]);
    let map = LitMap::new(&across(room(&[], &others)));
    assert_eq!(value(&map, 2, "switchshadstyle").as_deref(), Some("32"));
    let shaded = map.face([8.0, 0.0, 128.0], Vec3::X);
    assert!(map.levels(shaded, 0).unwrap().iter().all(|l| *l == [12; 3]), "minimum light only");
    assert_eq!(map.levels(shaded, 32), None);
    let behind = linear([-64.0, 0.0, 64.0], 500.0, 128.0);
    assert_eq!(floor(&map, 0, 128.0, 0.0), [0; 3]);
    assert_eq!(floor(&map, 32, 128.0, 0.0), [behind; 3]);
}

#[test]
fn p21_light_ignoring_models_and_details_see_no_light_and_no_bounce() {
    let others = lamp("0 0 200", "300", &[]) + &model("func_wall", 1, &[("_lightignore", "1")]);
    let map = room(&[], &others).model([-96.0, -32.0, 16.0], [-64.0, 32.0, 80.0], Some(0)).pillar(
        [64.0, -32.0, 0.0],
        [96.0, 32.0, 64.0],
        1,
    );
    let ignore = |name: &str| (name == "panel").then_some(r#"{"light_ignore": true}"#);
    let map = LitMap::with(&map, ignore, None);
    for (face, surface) in map.scene.surfaces.iter().enumerate() {
        let ignores =
            surface.model == Some(1) || surface.vertices.iter().all(|v| v.x.abs() < 100.0);
        assert_eq!(map.levels(face, 0).is_none(), ignores, "{:?}", surface.vertices);
    }
    assert!(floor(&map, 0, 0.0, 64.0)[0] > 30);
}

#[test]
fn p22_p23_models_of_other_channels_are_lit_by_their_own_lights_alone() {
    // A red light of channel 2 and a green one of channel 4, each beside a wall of its channel; both
    // bleed, so that the far sides of the walls would be lit but for their own shadow.
    let own = |mask: &'static str, colour: &'static str| {
        [("_light_channel_mask", mask), ("_color", colour), ("delay", "3"), ("_bleed", "1")]
    };
    let others = lamp("0 0 64", "520", &own("2", "1 0 0"))
        + &lamp("0 100 64", "520", &own("4", "0 1 0"))
        + &model("func_wall", 1, &[("_object_channel_mask", "2")])
        + &model("func_wall", 2, &[("_object_channel_mask", "4")]);
    let map = |minlight: &str| {
        let map = room(&[("_sunlight", "100"), ("_minlight", minlight)], &others)
            .room_textures([0, 0, 0, 0, 0, 2])
            .model([-48.0, -32.0, 0.0], [-32.0, 32.0, 192.0], Some(0))
            .model([32.0, -32.0, 0.0], [48.0, 32.0, 192.0], Some(0));
        LitMap::new(&map)
    };
    let bright = map("128");
    for (x, y) in [(0.0, 0.0), (0.0, 100.0), (-128.0, 0.0), (128.0, 0.0)] {
        assert_eq!(floor(&bright, 0, x, y), [64; 3], "the floor at {x} {y}");
    }
    // Without minimum light there is the sun, in which the walls cast no shadow.
    let map = map("0");
    assert_eq!(floor(&map, 0, -64.0, 0.0), [50; 3]);
    let side = |x: f32, z: f32, normal: Vec3| map.level(0, [x, 0.0, z], normal);
    for z in [16.0, 64.0, 176.0] {
        let (red, green) = (side(-32.0, z, Vec3::X), side(32.0, z, -Vec3::X));
        assert!(red[0] > 100 && red[1..] == [0, 0], "{z}: {red:?}");
        assert!(green[1] > 100 && [green[0], green[2]] == [0, 0], "{z}: {green:?}");
        assert_eq!(side(-48.0, z, -Vec3::X), [0; 3], "in its own shadow at {z}");
        assert_eq!(side(48.0, z, Vec3::X), [0; 3], "in its own shadow at {z}");
    }
    assert!(side(-32.0, 64.0, Vec3::X)[0] >= 254);
    assert_eq!(map.level(0, [-40.0, 0.0, 192.0], Vec3::Z)[1..], [0, 0], "no sun on top");
}

#[test]
fn p24_models_and_groups_of_other_channels_neither_get_nor_shade_surface_light() {
    let template = [("_surface", "lamp"), ("_surface_radiosity", "1"), ("_color", "1 0.5 0.25")];
    let lights = entity("light", &[&template[..], &[("light", "600")]].concat())
        + &lamp("0 0 200", "600", &[("_light_channel_mask", "8"), ("_color", "0 0 1")]);
    let wall = model("func_wall", 1, &[("_object_channel_mask", "8")]);
    let built = |blocks: bool| {
        let entities = if blocks { lights.clone() + &wall } else { lights.clone() };
        let map = room(&[], &entities).solid_texture("lamp", 8).room_textures([0, 0, 0, 0, 0, 3]);
        if !blocks {
            return LitMap::new(&map);
        }
        let map = map.model([-64.0, -32.0, 0.0], [-32.0, 32.0, 64.0], Some(0)).pillar(
            [32.0, -32.0, 0.0],
            [64.0, 32.0, 64.0],
            1,
        );
        let mask = |name: &str| (name == "panel").then_some(r#"{"object_channel_mask": 8}"#);
        LitMap::with(&map, mask, Some(0))
    };
    let (with, without) = (built(true), built(false));
    // The floor, below and beside the model and beside the group.
    let mut seen = 0;
    for (x, y) in (-8_i8..=8).flat_map(|i| (-8_i8..=8).map(move |j| (i, j))) {
        let (x, y) = (f32::from(x) * 16.0, f32::from(y) * 16.0);
        if (16.0..=80.0).contains(&x) && y.abs() <= 48.0 {
            continue;
        }
        let (a, b) = (floor(&with, 0, x, y), floor(&without, 0, x, y));
        assert_eq!(a, b, "{x} {y}");
        assert!(b[0] > 50 && b[0].abs_diff(2 * b[1]) <= 1 && b[1].abs_diff(2 * b[2]) <= 1);
        seen += 1;
    }
    assert!(seen > 200);
    for x in [-48.0, 48.0] {
        let top = with.level(0, [x, 0.0, 64.0], Vec3::Z);
        assert!(top[..2] == [0, 0] && top[2] > 100, "blue alone at {x}: {top:?}");
    }
}

#[test]
fn p26_dirt_keeps_to_its_channel() {
    // Two walls of channel 2, 32 units apart, and a wall of the world.
    let keys = [("_dirt", "1"), ("_minlight", "128")];
    let others: String =
        (1..=2).map(|i| model("func_wall", i, &[("_object_channel_mask", "2")])).collect();
    let map = room(&keys, &others).model([-16.0, -64.0, 0.0], [0.0, 64.0, 160.0], Some(0)).model(
        [32.0, -64.0, 0.0],
        [48.0, 64.0, 160.0],
        Some(0),
    );
    let map = LitMap::new(&map);
    let corner = floor(&map, 0, 256.0, 256.0)[0];
    assert!(corner < 40, "a corner of the world: {corner}");
    for x in [-32.0, 16.0, 64.0] {
        assert_eq!(floor(&map, 0, x, 0.0), [64; 3], "the world beside the walls at {x}");
    }
    let side = |x: f32, z: f32, normal: Vec3| map.level(0, [x, 0.0, z], normal)[0];
    for z in [0.0, 16.0, 96.0] {
        assert_eq!(side(-16.0, z, -Vec3::X), 64, "a wall beside the world at {z}");
    }
    let between = side(0.0, 64.0, Vec3::X);
    assert!(between < 40, "between walls of one channel: {between}");
}
