//! Direct light on small rooms with answers worked out by hand.

mod support;

use glam::Vec3;
use qrad::bsp::Format;
use qrad::light::{DirectLight, at, direct};
use qrad::scene::{Sample, Scene, SceneSettings, Sidecar, luxels};
use support::lit_room::surface_at;
use support::map_builder::MapBuilder;

/// A room of 512 x 512 x 256 units with the given entities after worldspawn.
fn room(entities: &str) -> MapBuilder {
    MapBuilder::room([-256.0, -256.0, 0.0], [256.0, 256.0, 256.0])
        .solid_texture("wall", 8)
        .solid_texture("panel", 8)
        .entities(format!("{{\n\"classname\" \"worldspawn\"\n}}\n{entities}"))
}

fn light(keys: &[(&str, &str)]) -> String {
    let keys: String = keys.iter().map(|(k, v)| format!("\"{k}\" \"{v}\"\n")).collect();
    format!("{{\n\"classname\" \"light\"\n{keys}}}\n")
}

fn scene(map: &MapBuilder) -> Scene {
    let bsp = map.build(Format::Bsp29);
    Scene::build(&bsp, Sidecar::default(), &SceneSettings::default()).unwrap()
}

fn light_at(scene: &Scene, point: [f32; 3], normal: Vec3) -> (DirectLight, Vec<Sample>, usize) {
    let surface = surface_at(scene, point.into(), normal);
    let samples = luxels::place(scene, surface, 1);
    let grid = scene.surfaces[surface].luxels.as_ref().unwrap();
    let l = grid.luxel_of(point.into()).round();
    let index = l.y as usize * grid.width as usize + l.x as usize;
    (direct(scene, surface, &samples), samples, index)
}

/// Irradiance of a style at the luxel of a floor point.
fn floor(scene: &Scene, style: u16, x: f32, y: f32) -> Vec3 {
    let (light, _, index) = light_at(scene, [x, y, 0.0], Vec3::Z);
    let map = light.styles.iter().find(|s| s.style == style);
    map.map_or(Vec3::ZERO, |m| m.irradiance[index].0)
}

/// Equal up to the rounding of single precision.
fn near(got: Vec3, want: f32) -> bool {
    (got - Vec3::splat(want)).abs().max_element() <= 4.0 * f32::EPSILON * want.abs()
}

/// The level that the irradiance is stored as.
fn level(irradiance: Vec3) -> [u8; 3] {
    (irradiance * 0.5).to_array().map(|v| v as u8)
}

/// Linear falloff and half a cosine law, as in the contract, for a light over the floor.
fn linear(brightness: f64, height: f64, aside: f64) -> f64 {
    let d = (height * height + aside * aside).sqrt();
    (brightness - d).max(0.0) * (0.5 + 0.5 * height / d)
}

#[test]
fn three_numbers_are_a_colour_at_brightness_300() {
    let scene = scene(&room(&light(&[("origin", "8 0 72"), ("light", "255 127 0")])));
    let e = floor(&scene, 0, 0.0, 0.0);
    assert_eq!(level(e), [113, 56, 0]);
    assert!((f64::from(e.x) - linear(300.0, 71.0, 8.0)).abs() < 1e-3);
}

#[test]
fn four_numbers_are_a_colour_and_a_brightness() {
    let scene = scene(&room(&light(&[("origin", "0 0 72"), ("light", "1 0.5 0 100")])));
    assert_eq!(level(floor(&scene, 0, 0.0, 0.0)), [14, 7, 0]);
}

#[test]
fn an_unknown_delay_is_a_dark_light_with_a_warning() {
    let scene = scene(&room(&light(&[("origin", "0 0 72"), ("delay", "15")])));
    assert!(scene.lights.is_empty());
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    assert!(scene.warnings[0].contains("delay 15") && scene.warnings[0].contains("0 0 72"));
    assert_eq!(floor(&scene, 0, 0.0, 0.0), Vec3::ZERO);
}

#[test]
fn every_delay_has_its_closed_form_on_the_floor() {
    // The sample is 1 above the floor, the light 65: 64 apart, 128 in units scaled by wait 2.
    for (delay, want) in [
        ("0", 172.0),
        ("linear", 172.0),
        ("1", 300.0),
        ("Inverse", 300.0),
        ("2", 300.0),
        ("2.0", 300.0),
        ("3", 300.0),
        ("5", 75.0),
        ("6", 300.0 / 16384.0),
    ] {
        let keys = [("origin", "0 0 65"), ("light", "300"), ("wait", "2"), ("delay", delay)];
        let got = floor(&scene(&room(&light(&keys))), 0, 0.0, 0.0);
        assert!(near(got, want), "delay {delay}: {got}");
    }
    let keys = [("origin", "0 0 65"), ("light", "300"), ("wait", "2"), ("falloff", "256")];
    assert!(near(floor(&scene(&room(&light(&keys))), 0, 0.0, 0.0), 225.0));
}

#[test]
fn angle_scale_and_world_settings_apply() {
    let keys = [("origin", "48 0 65"), ("light", "300"), ("delay", "3"), ("_anglescale", "1")];
    // Sample to light is (48, 0, 64): cosine 0.8.
    assert!((floor(&scene(&room(&light(&keys))), 0, 0.0, 0.0).x - 240.0).abs() < 1e-3);
    let world = "{\n\"classname\" \"worldspawn\"\n\"_dist\" \"2\"\n\"_anglescale\" \"0\"\n}\n";
    let keys = [("origin", "48 0 65"), ("light", "300")];
    let map = room("").entities(format!("{world}{}", light(&keys)));
    assert!((floor(&scene(&map), 0, 0.0, 0.0).x - (300.0 - 160.0)).abs() < 1e-3);
}

#[test]
fn spots_light_their_cone_only() {
    // Half angle 20 degrees at distance 199: radius 72.4; the three spellings agree.
    let cone = 199.0 * 20_f32.to_radians().tan();
    for extra in [("angle", "40"), ("_cone", "20"), ("angle", "0")] {
        let keys = [
            ("origin", "0 0 200"),
            ("light", "300"),
            ("delay", "3"),
            ("mangle", "0 -90 0"),
            ("_anglescale", "0"),
            extra,
        ];
        let scene = scene(&room(&light(&keys)));
        for x in (0..256).step_by(16) {
            let want = if (x as f32) < cone { 300.0 } else { 0.0 };
            assert!(near(floor(&scene, 0, x as f32, 0.0), want), "{extra:?} at {x}");
        }
    }
}

#[test]
fn soft_spots_fade_linearly_in_the_cosine_towards_their_target() {
    let spot = [
        ("origin", "0 0 201"),
        ("light", "300"),
        ("delay", "3"),
        ("target", "There"),
        ("_anglescale", "0"),
        ("angle", "60"),
        ("_softangle", "20"),
    ];
    let target =
        "{\n\"classname\" \"info_null\"\n\"targetname\" \"there\"\n\"origin\" \"0 0 1\"\n}\n";
    let scene = scene(&room(&format!("{}{target}", light(&spot))));
    assert!(near(floor(&scene, 0, 0.0, 0.0), 300.0));
    let (outer, inner) = (30_f64.to_radians().cos(), 10_f64.to_radians().cos());
    for x in [48.0, 64.0, 96.0] {
        let cosine = 200.0 / f64::hypot(200.0, x);
        let want = 300.0 * (cosine - outer) / (inner - outer);
        assert!((f64::from(floor(&scene, 0, x as f32, 0.0).x) - want).abs() < 0.01, "{x}");
    }
    assert_eq!(floor(&scene, 0, 128.0, 0.0).x, 0.0);
}

#[test]
fn pillars_cast_shadows_and_hide_the_luxels_below_them() {
    let keys = [("origin", "0 0 65"), ("light", "300"), ("delay", "3")];
    let map = room(&light(&keys)).pillar([64.0, -32.0, 0.0], [96.0, 32.0, 128.0], 0);
    let scene = scene(&map);
    assert!(floor(&scene, 0, 32.0, 0.0).x > 0.0);
    assert_eq!(floor(&scene, 0, 128.0, 0.0).x, 0.0, "in the shadow");
    assert!(floor(&scene, 0, 128.0, 128.0).x > 0.0, "beside the shadow");
    let (_, samples, below) = light_at(&scene, [80.0, 0.0, 0.0], Vec3::Z);
    assert!(samples[below].occluded);
    assert_eq!(floor(&scene, 0, 80.0, 0.0), Vec3::ZERO);
    // The luxel on the pillar's edge is freed by half a unit, still one unit above the floor.
    let (_, samples, edge) = light_at(&scene, [64.0, 0.0, 0.0], Vec3::Z);
    assert!(!samples[edge].occluded);
    assert_eq!(samples[edge].position, Vec3::new(63.5, -0.5, 0.5));
}

#[test]
fn luxels_beyond_the_edge_snap_to_it_or_hop_to_the_joined_face() {
    let map = || MapBuilder::room([0.0, 0.0, 0.0], [104.0, 96.0, 64.0]).solid_texture("wall", 8);
    // 104 is half a luxel past 96: the last column snaps to the edge, and the wall's solid pushes it
    // half a unit back on every axis.
    let whole = scene(&map());
    let surface = surface_at(&whole, Vec3::new(50.0, 50.0, 0.0), Vec3::Z);
    let samples = luxels::place(&whole, surface, 1);
    let grid = whole.surfaces[surface].luxels.as_ref().unwrap();
    assert_eq!((grid.width, grid.height), (8, 7));
    assert_eq!(grid.world_of(glam::Vec2::new(7.0, 0.0)).x, 112.0);
    assert_eq!(samples[3 * 8 + 7].position, Vec3::new(103.5, 47.5, 0.5));
    assert!(samples.iter().all(|s| !s.occluded && s.normal == Vec3::Z));

    // Cut at 40 and 80, luxels past the cut lie on the joined face, where they are.
    let cut = scene(&map().subdivide(40.0));
    let surface = surface_at(&cut, Vec3::new(20.0, 60.0, 0.0), Vec3::Z);
    let samples = luxels::place(&cut, surface, 1);
    let past = samples.iter().find(|s| s.position.x > 40.0).expect("a luxel past the cut");
    assert_eq!((past.position.x, past.position.z), (48.0, 1.0));
}

#[test]
fn supersamples_surround_their_luxel() {
    let scene = scene(&room(""));
    let surface = surface_at(&scene, Vec3::ZERO, Vec3::Z);
    let width = scene.surfaces[surface].luxels.as_ref().unwrap().width as usize;
    let one = luxels::place(&scene, surface, 1);
    let four = luxels::place(&scene, surface, 4);
    assert_eq!(four.len(), 16 * one.len());
    let mean = (0..16)
        .map(|i| four[(4 * 5 + i / 4) * 4 * width + 4 * 5 + i % 4].position)
        .fold(Vec3::ZERO, |a, b| a + b)
        / 16.0;
    assert!((mean - one[5 * width + 5].position).length() < 1e-3);
}

#[test]
fn switchable_lights_get_styles_from_32_in_order() {
    let lights = [("a", "0"), ("b", "64"), ("a", "128")]
        .map(|(name, x)| {
            light(&[("origin", &format!("{x} 0 65")), ("targetname", name), ("style", "5")])
        })
        .concat();
    let scene = scene(&room(&lights));
    assert_eq!(scene.lights.iter().map(|l| l.style).collect::<Vec<_>>(), [32, 33, 32]);
    assert!(floor(&scene, 33, 64.0, 0.0).x > floor(&scene, 33, 0.0, 0.0).x);
    assert_eq!(floor(&scene, 0, 0.0, 0.0), Vec3::ZERO);
}

#[test]
fn negative_lights_are_kept_apart() {
    let pair = light(&[("origin", "0 0 65"), ("light", "-100")])
        + &light(&[("origin", "0 0 65"), ("light", "300")]);
    let (light, _, index) = light_at(&scene(&room(&pair)), [0.0; 3], Vec3::Z);
    assert!(near(light.styles[0].irradiance[index].0, 236.0));
    assert!(near(light.negative[0].irradiance[index].0, -36.0));
}

#[test]
fn surface_lights_are_points_before_their_face() {
    let template = light(&[
        ("origin", "0 0 128"),
        ("light", "120"),
        ("delay", "2"),
        ("_surface", "PANEL"),
        ("_color", "1 0 0"),
    ]);
    let map = room(&template).room_textures([0, 0, 0, 0, 0, 1]);
    let scene = scene(&map);
    // The ceiling is cut at multiples of 128: 16 pieces, the highest x and y first.
    assert_eq!(scene.lights.len(), 16);
    assert_eq!(scene.lights[0].origin, Vec3::new(192.0, 192.0, 254.0));
    assert!(scene.lights.iter().all(|l| l.origin.z == 254.0 && l.brightness == 120.0));
    let e = floor(&scene, 0, 0.0, 0.0);
    let want: f64 = scene
        .lights
        .iter()
        .map(|l| {
            let to = (l.origin - Vec3::Z).as_dvec3();
            120.0 * 16384.0 / to.length_squared() * (0.5 + 0.5 * to.z / to.length())
        })
        .sum();
    assert!((f64::from(e.x) - want).abs() < 1e-3 * want && e.y == 0.0, "{e} {want}");
}

#[test]
fn surface_spotlights_shine_along_the_normal() {
    let template = light(&[
        ("origin", "0 0 128"),
        ("_surface", "panel"),
        ("_surface_spotlight", "1"),
        ("_surface_offset", "6"),
    ]);
    let scene = scene(&room(&template).room_textures([0, 0, 0, 0, 0, 1]));
    assert!(scene.lights.iter().all(|l| l.origin.z == 250.0));
    assert!(scene.lights.iter().all(|l| l.spot.is_some_and(|s| s.direction == -Vec3::Z)));
}

#[test]
fn jittered_lights_spread_evenly_and_always_alike() {
    let keys = [("origin", "0 0 100"), ("delay", "2"), ("_deviance", "10"), ("_samples", "64")];
    let map = room(&light(&keys));
    let (a, b) = (scene(&map), scene(&map));
    assert_eq!(a.lights, b.lights);
    assert_eq!(a.lights.len(), 64);
    let centre = Vec3::new(0.0, 0.0, 100.0);
    assert_eq!(a.lights[0].origin, centre);
    let away = |l: &qrad::scene::Light| (l.origin - centre).abs().max_element();
    assert!(a.lights.iter().all(|l| away(l) <= 10.0));
    assert!(a.lights.iter().filter(|l| away(l) > 5.0).count() > 32);
    assert!((a.lights.iter().map(|l| l.brightness).sum::<f32>() - 300.0).abs() < 1e-3);
}

#[test]
fn lights_in_walls_move_out_if_two_units_are_enough() {
    let scene = scene(&room(
        &(light(&[("origin", "-256 0 100")])
            + &light(&[("origin", "-256 0 100"), ("nonudge", "1")])
            + &light(&[("origin", "-300 0 100")])),
    ));
    let origins: Vec<f32> = scene.lights.iter().map(|l| l.origin.x).collect();
    assert_eq!(origins, [-254.0, -256.0, -300.0]);
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
}

#[test]
fn light_at_a_free_point_agrees_with_the_luxel_there() {
    let lights = light(&[("origin", "40 0 65")]) + &light(&[("origin", "0 9 65"), ("style", "3")]);
    let scene = scene(&room(&lights));
    let at = at(&scene, Vec3::new(0.0, 0.0, 1.0), Vec3::Z);
    assert_eq!(at.iter().map(|s| s.0).collect::<Vec<_>>(), [0, 3]);
    for (style, e) in at {
        assert_eq!(e.0, floor(&scene, style, 0.0, 0.0));
    }
}

#[test]
fn a_map_without_entities_or_with_wild_numbers_is_no_trouble() {
    for entities in [
        String::new(),
        light(&[("origin", "1e38 -1e38 1e38"), ("light", "1e38"), ("delay", "1")]),
        light(&[("origin", "0 0 64"), ("light", "nan"), ("wait", "-1"), ("angle", "720")]),
        light(&[("origin", "0 0 1"), ("light", "1e38"), ("delay", "2"), ("mangle", "1e30 0 0")]),
    ] {
        let scene = scene(&room("").entities(entities));
        for surface in 0..scene.surfaces.len() {
            let samples = luxels::place(&scene, surface, 1);
            direct(&scene, surface, &samples);
        }
    }
    let many = light(&[("_deviance", "1"), ("_samples", "2000000000")]);
    let bsp = room(&many).build(Format::Bsp29);
    let error = Scene::build(&bsp, Sidecar::default(), &SceneSettings::default()).err().unwrap();
    assert!(error.to_string().contains("_samples"), "{error}");
}
