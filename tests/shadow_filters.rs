//! Fences, glass, special shadows and channels in small rooms.

mod support;

use glam::Vec3;
use qrad::scene::Surface;
use support::lit_room::{LitRoom, entity};
use support::map_builder::MapBuilder;

/// A lamp in the middle of the room, the same at any distance and angle.
const LAMP: [(&str, &str); 4] =
    [("origin", "0 0 200"), ("light", "150"), ("delay", "3"), ("_anglescale", "0")];
/// Textures of [`room`].
const WALL: usize = 0;
const FENCE: usize = 1;
const RED: usize = 2;
const HOLLOW: usize = 3;

/// A room of 512 x 512 x 256 units. The fence has columns of 16 texels, see-through and not in turn;
/// the glass is pure red.
fn room(entities: &str) -> MapBuilder {
    let stripes = (0..16 * 32).map(|i| if i % 32 < 16 { 255 } else { 8 }).collect();
    MapBuilder::room([-256.0, -256.0, 0.0], [256.0, 256.0, 256.0])
        .solid_texture("wall", 8)
        .texture("{fence", 32, 16, stripes)
        .solid_texture("glass", 251)
        .solid_texture("{none", 255)
        .entities(entity("worldspawn", &[]) + entities)
}

fn lamp(keys: &[(&str, &str)]) -> String {
    entity("light", &[&LAMP, keys].concat())
}

fn wall(number: usize, keys: &[(&str, &str)]) -> String {
    entity("func_wall", &[&[("model", &*format!("*{number}"))], keys].concat())
}

/// A lid of 128 x 128 units 100 above the floor, one unit thick, around a point.
fn lid(map: MapBuilder, x: f32, texture: Option<usize>) -> MapBuilder {
    map.model([x - 64.0, -64.0, 100.0], [x + 64.0, 64.0, 101.0], texture)
}

#[test]
fn fences_stop_light_at_their_texels_only() {
    let entities = lamp(&[]) + &wall(1, &[("_shadow", "1")]);
    let room = LitRoom::new(&lid(room(&entities), 0.0, Some(FENCE)));
    let (mut lit, mut dark) = (0, 0);
    for x in (-112_i8..=112).step_by(16).map(f32::from) {
        // Where the ray from one unit above the floor to the lamp meets the lid's two sides.
        let hollow = [99.0, 100.0].map(|up| (x * (1.0 - up / 199.0)).rem_euclid(32.0) < 16.0);
        if hollow[0] == hollow[1] {
            let want = if hollow[0] { 150.0 } else { 0.0 };
            assert_eq!(room.floor(0, x, 16.0).x, want, "{x}");
            *(if hollow[0] { &mut lit } else { &mut dark }) += 1;
        }
    }
    assert!(lit >= 4 && dark >= 4, "{lit} {dark}");
    assert_eq!(room.floor(0, 240.0, 0.0).x, 150.0, "beside the lid");
}

#[test]
fn a_fence_of_no_texels_blocks_nothing_and_one_without_pixels_all() {
    let entities = lamp(&[]) + &wall(1, &[("_shadow", "1")]);
    let map = lid(room(&entities), 0.0, Some(HOLLOW));
    assert_eq!(LitRoom::new(&map).floor(0, 0.0, 0.0).x, 150.0);
    let mut bsp = map.build(qrad::bsp::Format::Bsp29);
    bsp.textures[HOLLOW].as_mut().unwrap().pixels = None;
    let scene = qrad::scene::Scene::build(&bsp, Default::default(), &Default::default()).unwrap();
    assert_eq!(LitRoom { scene }.floor(0, 0.0, 0.0).x, 0.0);
}

#[test]
fn glass_tints_by_its_opacity_and_panes_multiply() {
    // Index 251 is (255, 0, 0): each pane of opacity a leaves 1 - a of green and blue.
    let pane = |alpha: &str, panes: usize| {
        let walls: String =
            (1..=panes).map(|i| wall(i, &[("_shadow", "1"), ("alpha", alpha)])).collect();
        let mut map = room(&(lamp(&[]) + &walls));
        for i in 0..panes {
            let z = 60.0 + 20.0 * i as f32;
            map = map.model([-64.0, -64.0, z], [64.0, 64.0, z + 1.0], Some(RED));
        }
        LitRoom::new(&map).floor(0, 0.0, 0.0)
    };
    assert_eq!(pane("0.4", 1), Vec3::new(150.0, 90.0, 90.0));
    let near = |a: Vec3, b: Vec3| (a - b).abs().max_element() < 1e-3;
    assert!(near(pane("0.4", 2), Vec3::new(150.0, 54.0, 54.0)));
    assert!(near(pane("0.4", 3), Vec3::new(150.0, 32.4, 32.4)));
    assert_eq!(pane("0", 1), Vec3::splat(150.0));
    assert_eq!(pane("1", 1), Vec3::ZERO, "opaque");
}

#[test]
fn opacity_of_the_texture_wins_over_that_of_the_model_and_suns_see_it_too() {
    let half = |name: &str| (name == "glass").then_some(r#"{"light_alpha": 0.5}"#);
    let entities = entity("worldspawn", &[("_sunlight", "100")])
        + &wall(1, &[("_shadow", "1"), ("alpha", "0.9")]);
    let map = lid(room(""), 0.0, Some(RED))
        .solid_texture("sky1", 8)
        .flags(1)
        .room_textures([0, 0, 0, 0, 0, 4])
        .entities(entities);
    let room = LitRoom::with_texinfo(&map, half);
    assert_eq!(room.floor(0, 0.0, 0.0), Vec3::new(100.0, 50.0, 50.0));
    assert_eq!(room.floor(0, 128.0, 0.0), Vec3::splat(100.0));
}

#[test]
fn models_of_skip_cast_the_shadow_of_their_solid() {
    for (keys, want) in [(&[("_shadow", "1")][..], 0.0), (&[][..], 150.0)] {
        let entities = lamp(&[]) + &wall(1, keys);
        let room = LitRoom::new(&lid(room(&entities), 0.0, None));
        assert_eq!(room.floor(0, 0.0, 0.0).x, want);
        assert_eq!(room.floor(0, 240.0, 0.0).x, 150.0);
    }
}

#[test]
fn shadows_follow_the_origin_of_their_model() {
    for (texture, shadow, want) in
        [(Some(WALL), "1", 0.0), (None, "1", 0.0), (Some(WALL), "0", 150.0), (None, "0", 150.0)]
    {
        let keys = [("_shadow", shadow), ("origin", "160 0 0")];
        let entities =
            entity("light", &[&LAMP[1..], &[("origin", "160 0 200")]].concat()) + &wall(1, &keys);
        let room = LitRoom::new(&lid(room(&entities), 0.0, texture));
        assert_eq!(room.floor(0, 160.0, 0.0).x, want, "{texture:?}");
        assert_eq!(room.floor(0, -112.0, 0.0).x, 150.0, "where it was built");
    }
}

#[test]
fn self_shadow_falls_on_the_model_and_world_shadow_on_the_world() {
    // A lid above a plate, both of the model: the plate's top is in the shadow of the lid.
    for (key, on_floor, on_plate) in [
        ("_shadow", 0.0, 0.0),
        ("_shadowself", 150.0, 150.0),
        ("_shadowworldonly", 0.0, 150.0),
        ("_none", 150.0, 150.0),
    ] {
        let entities = lamp(&[]) + &wall(1, &[(key, "1")]) + &wall(2, &[]);
        let map = lid(room(&entities), 0.0, Some(WALL)).model(
            [-32.0, -32.0, 40.0],
            [32.0, 32.0, 48.0],
            Some(WALL),
        );
        let room = LitRoom::new(&map);
        assert_eq!(room.floor(0, 96.0, 0.0).x, on_floor, "{key} on the floor");
        assert_eq!(room.at(0, [0.0, 0.0, 48.0], Vec3::Z).x, on_plate, "{key} on another model");
        // The underside of the lid looks away from the lamp; bleed lights it but for the lid itself.
        let entities = lamp(&[("_bleed", "1")]) + &wall(1, &[(key, "1")]);
        let room = LitRoom::new(&lid(self::room(&entities), 0.0, Some(WALL)));
        let below = room.at(0, [0.0, 0.0, 100.0], Vec3::NEG_Z).x;
        let own = if matches!(key, "_shadow" | "_shadowself") { 0.0 } else { 150.0 };
        assert_eq!(below, own, "{key} on itself");
    }
}

#[test]
fn a_switched_shadow_moves_light_to_its_style_in_both_forms() {
    let quakec = lamp(&[]) + &wall(1, &[("_switchableshadow", "1")]);
    let vanilla = lamp(&[])
        + &wall(1, &[("targetname", "door1")])
        + &entity(
            "light",
            &[("_switchableshadow_target", "door1"), ("targetname", "s"), ("origin", "99 9 99")],
        );
    for entities in [quakec, vanilla] {
        // 32 belongs to the first switch.
        let entities = entities.replace(
            "\"_switchableshadow\" \"1\"",
            "\"_switchableshadow\" \"1\"\n\"switchshadstyle\" \"32\"",
        );
        let room = LitRoom::new(&lid(room(&entities), 0.0, Some(WALL)));
        assert_eq!(room.scene.lights.len(), 1, "the switch itself does not shine");
        assert_eq!((room.floor(0, 0.0, 0.0).x, room.floor(32, 0.0, 0.0).x), (0.0, 150.0));
        assert_eq!((room.floor(0, 240.0, 0.0).x, room.floor(32, 240.0, 0.0).x), (150.0, 0.0));
    }
}

#[test]
fn other_styles_pass_a_switched_shadow_and_the_model_shades_itself() {
    let entities = lamp(&[("style", "5")]) + &wall(1, &[("_switchableshadow", "1")]);
    let room_5 = LitRoom::new(&lid(room(&entities), 0.0, Some(WALL)));
    assert_eq!((room_5.floor(5, 0.0, 0.0).x, room_5.floor(32, 0.0, 0.0).x), (150.0, 0.0));
    let entities = lamp(&[("_bleed", "1")]) + &wall(1, &[("_switchableshadow", "1")]);
    let room = LitRoom::new(&lid(room(&entities), 0.0, Some(WALL)));
    for style in [0, 32] {
        assert_eq!(room.at(style, [0.0, 0.0, 100.0], Vec3::NEG_Z), Vec3::ZERO, "{style}");
    }
    assert_eq!(room.at(0, [0.0, 0.0, 101.0], Vec3::Z).x, 150.0);
}

#[test]
fn channels_keep_light_and_shadow_to_themselves() {
    // A default lamp, and one of channel 2; a lid of channel 2 that needs no _shadow.
    let entities = lamp(&[])
        + &lamp(&[("_light_channel_mask", "2"), ("style", "7")])
        + &wall(1, &[("_object_channel_mask", "2")]);
    let room = LitRoom::new(&lid(room(&entities), 0.0, Some(WALL)));
    assert_eq!(room.floor(0, 0.0, 0.0).x, 150.0, "no shadow in default light");
    assert_eq!(room.floor(7, 0.0, 0.0).x, 0.0, "and no light of the other channel");
    assert_eq!(room.at(0, [0.0, 0.0, 101.0], Vec3::Z).x, 0.0);
    assert_eq!(room.at(7, [0.0, 0.0, 101.0], Vec3::Z).x, 150.0);
}

#[test]
fn shadow_channels_choose_what_blocks() {
    // Light for the default channel that only surfaces of channel 4 shade.
    for (mask, shade, want) in
        [("4", "4", 0.0), ("4", "8", 150.0), ("4", "5", 0.0), ("2", "1", 150.0)]
    {
        let keys = [("_light_channel_mask", "1"), ("_shadow_channel_mask", shade)];
        let entities = lamp(&keys) + &wall(1, &[("_object_channel_mask", mask)]);
        let room = LitRoom::new(&lid(room(&entities), 0.0, Some(WALL)));
        assert_eq!(room.floor(0, 0.0, 0.0).x, want, "{mask} {shade}");
    }
    // A solid of the default channel does not shade such light.
    let keys = [("_light_channel_mask", "1"), ("_shadow_channel_mask", "4")];
    let entities = lamp(&keys) + &wall(1, &[("_shadow", "1")]);
    assert_eq!(LitRoom::new(&lid(room(&entities), 0.0, Some(WALL))).floor(0, 0.0, 0.0).x, 150.0);
}

#[test]
fn faces_without_shadow_let_light_through() {
    let none = |name: &str| (name == "glass").then_some(r#"{"no_shadow": true}"#);
    let entities = lamp(&[]) + &wall(1, &[("_shadow", "1")]);
    let map = lid(room(&entities), 0.0, Some(RED));
    assert_eq!(LitRoom::with_texinfo(&map, none).floor(0, 0.0, 0.0), Vec3::splat(150.0));
    assert_eq!(LitRoom::new(&map).floor(0, 0.0, 0.0), Vec3::ZERO);
}

#[test]
fn a_projected_texture_is_seen_on_the_floor() {
    // 90 degrees of a square picture from 199 above the samples: twice as bright as the light.
    let keys = [("_project_texture", "GLASS"), ("_project_mangle", "0 -90 0")];
    let room = LitRoom::new(&room(&lamp(&keys)));
    assert_eq!(room.floor(0, 0.0, 0.0), Vec3::new(300.0, 0.0, 0.0));
    assert_eq!(room.floor(0, 192.0, 192.0), Vec3::new(300.0, 0.0, 0.0));
    assert_eq!(room.floor(0, 208.0, 0.0), Vec3::ZERO);
}

#[test]
fn glass_stays_out_of_the_scene_that_bounces() {
    let walls = wall(1, &[("_shadow", "1")]) + &wall(2, &[("_shadow", "1"), ("alpha", "0.5")]);
    let plain = LitRoom::new(&room(&lamp(&[])));
    let map = room(&(lamp(&[]) + &walls));
    let filtered = LitRoom::new(&lid(lid(map, 0.0, Some(HOLLOW)), 160.0, Some(RED)));
    assert!(!plain.scene.has_filters() && filtered.scene.has_filters());
    let counts = |room: &LitRoom| {
        [&room.scene.tracer, room.scene.bounce_tracer()].map(|t| t.polygons().len())
    };
    assert_eq!(counts(&plain), counts(&filtered));
    let glass = |s: &&Surface| s.model == Some(2);
    assert!(filtered.scene.surfaces.iter().filter(glass).all(|s| !s.reflects));
}
