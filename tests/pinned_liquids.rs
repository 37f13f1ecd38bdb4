//! Acceptance cases of the contract's section 12.3: liquids, and contents that the BSP cannot hold.

mod support;

use glam::Vec3;
use qrad::bsp::Format;
use qrad::light::direct;
use qrad::lightmap::DebugView;
use qrad::scene::{Scene, SceneSettings, Sidecar, luxels};
use support::lit_levels::LitMap;
use support::lit_light::{LitLight, settings};
use support::lit_room::entity;
use support::map_builder::MapBuilder;

const FENCE: usize = 1;
const LAVA: usize = 2;
const SPECIAL_WATER: usize = 3;
const CLEAN_WATER: usize = 4;

/// A room of 512 x 512 x 256 units.
fn room(world: &[(&str, &str)], others: &str) -> MapBuilder {
    MapBuilder::room([-256.0, -256.0, 0.0], [256.0, 256.0, 256.0])
        .solid_texture("wall", 8)
        .solid_texture("{fence", 255)
        .solid_texture("*lava", 251)
        .solid_texture("*water0", 40)
        .flags(1)
        .solid_texture("*water1", 40)
        .entities(entity("worldspawn", world) + others)
}

fn lamp(keys: &[(&str, &str)]) -> String {
    entity("light", keys)
}

#[test]
fn p28_fences_are_no_solid_for_luxels_if_the_compiler_says_so() {
    let at = |x: &'static str| lamp(&[("origin", x), ("light", "300"), ("wait", "0.3")]);
    let map = room(&[], &(at("-64 0 65") + &at("64 0 65"))).fence(
        [-32.0, -32.0, 0.0],
        [32.0, 32.0, 64.0],
        FENCE,
    );
    let bsp = map.build(Format::Bsp29);
    // Leaf 0 and the inside of the fence are natively solid.
    let fences: Vec<usize> =
        (1..bsp.leafs.len()).filter(|&l| bsp.leafs[l].contents == -2).collect();
    assert_eq!(fences.len(), 1);
    let content = |fence: &str| {
        let of = |leaf: usize| match leaf {
            0 => r#"["SOLID"]"#.to_owned(),
            _ if leaf == fences[0] => format!("[\"{fence}\"]"),
            _ => "[]".to_owned(),
        };
        format!("[{}]", (0..bsp.leafs.len()).map(of).collect::<Vec<_>>().join(","))
    };
    // Light on the floor in the middle of the fence, `None` if the luxel lies in solid.
    let middle = |content: Option<&str>| {
        let sidecar = Sidecar { content, ..Sidecar::default() };
        let scene = Scene::build(&bsp, sidecar, &SceneSettings::default()).unwrap();
        let floor = |s: &qrad::scene::Surface| s.normal == Vec3::Z && s.dist == 0.0;
        let floor = scene.surfaces.iter().position(floor).unwrap();
        let samples = luxels::place(&scene, floor, 1);
        let light = direct(&scene, floor, &samples);
        let i = samples.iter().position(|s| s.position.truncate().length() < 1.0).unwrap();
        (!samples[i].occluded).then(|| light.styles[0].irradiance[i].0)
    };
    assert_eq!(middle(None), None);
    assert_eq!(middle(Some(&content("SOLID"))), None);
    assert_eq!(middle(Some(&content("DETAIL_WALL"))), None);
    // Both lights are 64 aside and 64 above, at 0.3 of their distance.
    let d = 64.0 * 2_f32.sqrt();
    let want = 2.0 * (300.0 - 0.3 * d) * (0.5 + 0.5 * 64.0 / d);
    let got = middle(Some(&content("WINDOW"))).expect("a luxel in the open");
    assert!((got - Vec3::splat(want)).abs().max_element() < 1e-2, "{got} {want}");
}

#[test]
fn p29_p30_liquids_are_lit_from_both_sides_unless_they_are_special() {
    let above = lamp(&[("origin", "0 0 129"), ("light", "300"), ("_color", "0 0 1")]);
    let below = lamp(&[("origin", "0 0 1"), ("light", "200"), ("_color", "0 1 0")]);
    let ignored = r#"{"light_ignore": true, "minlight": 100}"#;
    let map = |texture: usize, keys: Option<&'static str>| {
        let map = room(&[], &(above.clone() + &below));
        let map = map.liquid([-32.0, -32.0, 32.0], [32.0, 32.0, 64.0], texture);
        LitMap::with(&map, |name| keys.filter(|_| name.starts_with('*')), Some(0))
    };
    let top = [0.0, 0.0, 64.0];
    let lava = map(LAVA, None);
    // The sample is at 65: 64 below one light and 64 above the other, which counts from behind too.
    assert_eq!(lava.level(0, top, Vec3::Z), [0, 68, 118]);
    assert_eq!(lava.level(0, [0.0, 0.0, 32.0], -Vec3::Z), [0, 85, 101], "the underside too");
    // Special faces have no lightmap.
    let special = map(SPECIAL_WATER, None);
    let record = &special.bsp.faces[special.face(top, Vec3::Z)];
    assert_eq!((record.styles, record.light_offset), ([255; 4], -1));
    assert_eq!(map(LAVA, Some(ignored)).level(0, top, Vec3::Z), [50; 3]);
}

#[test]
fn p31_water_without_shadow_does_not_bounce() {
    let light = lamp(&[("origin", "0 0 200"), ("light", "200"), ("delay", "2")]);
    let walls = |water: bool, keys: Option<&'static str>| {
        let map = room(&[], &light);
        let map = if water {
            map.liquid([-200.0, -200.0, 60.0], [200.0, 200.0, 64.0], CLEAN_WATER)
        } else {
            map
        };
        let map = LitMap::with(&map, |name| keys.filter(|_| name == "*water1"), Some(4));
        // The sides of the room but for the floor below the water, which the case does not look at.
        [0, 1, 2, 3, 5].map(|face| map.levels(face, 0).unwrap().to_vec())
    };
    let dry = walls(false, None);
    assert!(dry[0].iter().all(|l| l[0] > 10), "bounces are worth something");
    assert!(walls(true, None) == dry, "liquids of the world do not block or bounce");
    assert!(walls(true, Some(r#"{"no_shadow": true}"#)) == dry);
}

#[test]
fn p33_light_leaves_and_enters_liquids() {
    for (z, inside) in [("96", true), ("160", false)] {
        let light = lamp(&[("origin", &format!("0 0 {z}")), ("light", "450"), ("delay", "3")]);
        let map = room(&[], &light).liquid([-64.0, -64.0, 64.0], [64.0, 64.0, 128.0], LAVA);
        let map = LitMap::new(&map);
        assert!(map.level(0, [0.0, 0.0, 256.0], -Vec3::Z)[0] > 200, "light inside: {inside}");
        assert!(map.level(0, [0.0, 0.0, 0.0], Vec3::Z)[0] > 200, "light inside: {inside}");
    }
}

#[test]
fn p34_liquids_make_no_dirt_and_get_none() {
    let keys = [("_dirt", "1"), ("_minlight", "192"), ("_dirtscale", "2")];
    let map = room(&keys, "").liquid([-64.0, -64.0, 16.0], [64.0, 64.0, 64.0], LAVA);
    let lit = LitMap::new(&map);
    assert_eq!(lit.level(0, [0.0, 0.0, 0.0], Vec3::Z), [96; 3], "under the lava");
    assert_eq!(lit.level(0, [0.0, 0.0, 64.0], Vec3::Z), [96; 3], "on it");
    assert!(lit.level(0, [256.0, 256.0, 0.0], Vec3::Z)[0] < 40, "in a corner");

    let shown = LitLight::new(&map, &settings(Some(DebugView::Dirt)));
    let surfaces = &shown.scene.surfaces;
    let floor = surfaces.iter().position(|s| s.normal == Vec3::Z && s.dist == 0.0).unwrap();
    let grid = surfaces[floor].luxels.as_ref().unwrap();
    let at = |x: f32, y: f32| {
        let l = grid.luxel_of(Vec3::new(x, y, 0.0)).round();
        shown.of(floor, 0)[l.y as usize * grid.width as usize + l.x as usize]
    };
    assert_eq!(at(0.0, 0.0), Vec3::splat(255.0));
    assert_eq!(at(256.0, 256.0), Vec3::ZERO);
}
