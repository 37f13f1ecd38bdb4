//! Keys and settings of bounced light: each does to it what it says, and nothing else.

mod support;

use glam::{Vec2, Vec3};
use qrad::bsp::{Format, PALETTE};
use qrad::lightmap::{DebugView, Gather};
use qrad::scene::luxels;
use qrad::settings::{Settings, SurfaceLights};
use support::lit_light::{LitLight, difference, settings};
use support::lit_room::entity;
use support::map_builder::MapBuilder;

/// A closed room of grey and brown with a block in it; `text` is its lights.
fn room(world: &[(&str, &str)], text: &str) -> MapBuilder {
    MapBuilder::room([-192.0, -128.0, 0.0], [192.0, 128.0, 192.0])
        .solid_texture("grey", 8)
        .solid_texture("brown", 107)
        .solid_texture("glow", 254)
        .room_textures([0, 1, 0, 0, 1, 0])
        .pillar([48.0, -32.0, 0.0], [112.0, 32.0, 64.0], 1)
        .entities(entity("worldspawn", world) + text)
}

fn lamp(origin: &str, keys: &[(&str, &str)]) -> String {
    entity("light", &[&[("origin", origin)], keys].concat())
}

/// One lamp near a corner.
fn one(keys: &[(&str, &str)]) -> String {
    lamp("-100 -60 120", keys)
}

/// Another, of another colour, on the other side.
fn other(keys: &[(&str, &str)]) -> String {
    lamp("140 80 60", &[&[("_color", "255 200 100")], keys].concat())
}

fn bounced(world: &[(&str, &str)], text: &str) -> LitLight {
    LitLight::bounced(&room(world, text))
}

fn scaled(light: Vec<Vec3>, factor: f32) -> Vec<Vec3> {
    light.into_iter().map(|c| c * factor).collect()
}

#[test]
fn the_bounce_view_is_all_light_less_direct_light() {
    let map = room(&[], &(one(&[]) + &other(&[])));
    let all = LitLight::new(&map, &settings(None));
    let direct = LitLight::new(&map, &Settings { bounces: Some(0), ..settings(None) });
    let bounced = LitLight::bounced(&map);
    let sum: Vec<Vec3> = direct.all(0).iter().zip(bounced.all(0)).map(|(d, b)| *d + b).collect();
    assert!(difference(&all.all(0), &sum) < 1e-3);
    assert!(bounced.mean(0) > 5.0 && direct.mean(0) > 50.0, "{}", bounced.mean(0));
}

#[test]
fn the_number_of_bounces_caps_the_series() {
    let map = |count: &str| room(&[("_bounce", count)], &one(&[]));
    let means = ["0", "1", "2", "8"].map(|n| LitLight::bounced(&map(n)).mean(0));
    let all = bounced(&[], &one(&[]));
    assert_eq!(means[0], 0.0);
    assert!(means[0] < means[1] && means[1] < means[2] && means[2] < means[3], "{means:?}");
    // Every texture reflects less than half, so eight bounces are all but 1 / 256 of the light.
    assert!(means[3] < all.mean(0) && means[3] > 0.99 * all.mean(0));
    // What the user says wins over the map; a value that is no number says nothing.
    let view = settings(Some(DebugView::Bounce));
    let two = LitLight::new(&map("0"), &Settings { bounces: Some(2), ..view.clone() });
    assert_eq!(two.mean(0), means[2]);
    let over = vec![("bounce".to_owned(), "all".to_owned())];
    let unlimited = LitLight::new(&map("1"), &Settings { overrides: over, ..view });
    assert_eq!(unlimited.all(0), all.all(0));
    assert_eq!(LitLight::bounced(&map("x")).all(0), all.all(0));
}

#[test]
fn scales_act_on_bounced_light_alone() {
    let plain = bounced(&[], &one(&[]));
    for (text, factor) in [("2", 2.0), ("0.25", 0.25), ("0", 0.0)] {
        let world = bounced(&[("_bouncescale", text)], &one(&[]));
        assert!(difference(&world.all(0), &scaled(plain.all(0), factor)) < 1e-3, "world {text}");
        let own = bounced(&[], &one(&[("_bouncescale", text)]));
        assert!(difference(&own.all(0), &scaled(plain.all(0), factor)) < 1e-3, "lamp {text}");
    }
    let direct = Settings { bounces: Some(0), ..settings(None) };
    let direct = |world: &[(&str, &str)], keys: &[(&str, &str)]| {
        LitLight::new(&room(world, &one(keys)), &direct).all(0)
    };
    assert_eq!(direct(&[], &[]), direct(&[("_bouncescale", "3")], &[("_bouncescale", "0.2")]));
}

#[test]
fn the_scale_of_a_light_is_its_own() {
    let both = bounced(&[], &(one(&[]) + &other(&[("_bouncescale", "0")])));
    let first = bounced(&[], &one(&[]));
    assert!(difference(&both.all(0), &first.all(0)) < 1e-3);
    assert!(bounced(&[], &other(&[])).mean(0) > 1.0);
}

#[test]
fn suns_and_surface_lights_have_scales_too() {
    let sky = |scale: &str| {
        let sun =
            [("_sun", "1"), ("light", "200"), ("mangle", "30 -60 0"), ("_bouncescale", scale)];
        room(&[], &lamp("0 0 100", &sun))
            .solid_texture("sky1", 0)
            .flags(1)
            .room_textures([0, 1, 0, 0, 1, 3])
    };
    let glow = |radiosity: &'static str| {
        move |scale: &str| {
            let keys = [
                ("_surface", "glow"),
                ("light", "40"),
                ("_surface_radiosity", radiosity),
                ("_bouncescale", scale),
            ];
            room(&[], &lamp("0 0 0", &keys)).room_textures([0, 1, 0, 0, 1, 2])
        }
    };
    let maps: [&dyn Fn(&str) -> MapBuilder; 3] = [&sky, &glow("0"), &glow("1")];
    for (kind, map) in maps.into_iter().enumerate() {
        let plain = LitLight::bounced(&map("1"));
        let half = LitLight::bounced(&map("0.5"));
        assert!(plain.mean(0) > 1.0, "kind {kind}: {}", plain.mean(0));
        let off = difference(&half.all(0), &scaled(plain.all(0), 0.5));
        assert!(off < 1e-3 * plain.mean(0), "kind {kind}: {off}");
    }
    // As area light, its own light is that of patches: it stays, and only what comes of it changes.
    let area = Settings { surface_lights: SurfaceLights::Area, ..settings(None) };
    let lit = |scale: &str, bounces| {
        LitLight::new(&glow("0")(scale), &Settings { bounces, ..area.clone() }).all(0)
    };
    let (direct, whole) = (lit("1", Some(0)), lit("1", None));
    assert!(difference(&lit("0", None), &direct) < 1e-3);
    let middle: Vec<Vec3> = direct.iter().zip(&whole).map(|(a, b)| (*a + *b) * 0.5).collect();
    assert!(difference(&lit("0.5", None), &middle) < 1e-2);
    assert!(difference(&direct, &whole) > 1.0);
}

#[test]
fn styles_bounce_each_for_itself_unless_the_map_says_no() {
    let lamps = one(&[]) + &other(&[("style", "5")]);
    let plain = bounced(&[], &lamps);
    assert!(difference(&plain.all(0), &bounced(&[], &one(&[])).all(0)) < 1e-3);
    assert!(difference(&plain.all(5), &bounced(&[], &other(&[])).all(0)) < 1e-3);
    let map = room(&[("_bouncestyled", "0")], &lamps);
    let only = LitLight::bounced(&map);
    assert_eq!((only.all(0), only.mean(5)), (plain.all(0), 0.0));
    let direct = LitLight::new(&map, &Settings { bounces: Some(0), ..settings(None) });
    assert_eq!(LitLight::new(&map, &settings(None)).all(5), direct.all(5));
    assert!(direct.mean(5) > 5.0);
    assert_eq!(bounced(&[("_bouncestyled", "1")], &lamps).all(5), plain.all(5));
}

#[test]
fn negative_light_takes_bounced_light_away_and_the_floor_comes_last() {
    // Every luxel gathers for itself: interpolation keeps to the range of its points, so that the light
    // of two lamps is not quite the sum of what each gives alone.
    let view = settings(Some(DebugView::Bounce));
    let view = Settings { gather: Gather::Luxel, residual: 1e-9, ..view };
    let bounced = |world: &[(&str, &str)], text: &str| LitLight::new(&room(world, text), &view);
    // Luxels in solid take the mean of their neighbours, after the floor.
    let free = |lit: &LitLight| -> Vec<Vec3> {
        let of_surface = |surface| {
            let samples = luxels::place(&lit.scene, surface, 1);
            let light = samples.into_iter().zip(lit.of(surface, 0));
            light.filter(|(s, _)| !s.occluded).map(|(_, c)| c).collect::<Vec<_>>()
        };
        (0..lit.scene.surfaces.len()).flat_map(of_surface).collect()
    };
    let minus = |keys: &[(&str, &str)]| other(&[&[("light", "-200")], keys].concat());
    let plain = bounced(&[], &one(&[]));
    let taken = bounced(&[], &other(&[("light", "200")]));
    let want: Vec<Vec3> =
        free(&plain).iter().zip(free(&taken)).map(|(p, t)| (*p - t).max(Vec3::ZERO)).collect();
    let got = bounced(&[], &(one(&[]) + &minus(&[])));
    assert!(difference(&free(&got), &want) < 1e-3);
    assert!(got.mean(0) < 0.9 * plain.mean(0));
    assert!(want.iter().any(|c| c.max_element() == 0.0), "somewhere nothing is left");
    // It takes from its own style only, and not twice.
    let styled = bounced(&[], &(one(&[]) + &minus(&[("style", "5")])));
    assert_eq!(styled.all(0), plain.all(0));
    assert_eq!(styled.mean(5), 0.0);
    let unscaled = bounced(&[], &(one(&[]) + &minus(&[("_bouncescale", "0")])));
    assert!(difference(&unscaled.all(0), &plain.all(0)) < 1e-3);
}

#[test]
fn negative_light_wins_over_minimum_and_bounced_light() {
    // The contract's P11, with light to bounce.
    let lamps = lamp("0 0 140", &[("light", "100")]) + &lamp("0 0 40", &[("light", "-1000")]);
    let lit = LitLight::new(&room(&[("_minlight", "64")], &lamps), &settings(None));
    let floor =
        lit.scene.surfaces.iter().position(|s| s.normal == Vec3::Z && s.dist == 0.0).unwrap();
    let grid = lit.scene.surfaces[floor].luxels.as_ref().unwrap();
    let (mut dark, mut shadowed) = (0, 0);
    for (i, light) in lit.of(floor, 0).into_iter().enumerate() {
        let at = grid
            .world_of(Vec2::new((i as u32 % grid.width) as f32, (i as u32 / grid.width) as f32));
        if at.x < 40.0 {
            assert_eq!(light, Vec3::ZERO, "{at}");
            dark += 1;
        } else {
            // The block keeps the light away that takes, so minimum light stays behind it.
            shadowed += u32::from(light == Vec3::splat(64.0));
        }
    }
    assert!(dark > 100 && shadowed > 10);
}

#[test]
fn dirt_does_not_darken_what_has_bounced() {
    let lamps = one(&[("_dirt", "-1")]);
    let (clean, dirty) = (bounced(&[], &lamps), bounced(&[("_dirt", "1")], &lamps));
    assert!(dirty.scene.world.dirt.in_use);
    assert_eq!(clean.all(0), dirty.all(0));
}

#[test]
fn models_and_faces_that_do_not_bounce_still_receive() {
    let map = |keys: &[(&str, &str)]| {
        let wall = [&[("model", "*1"), ("_shadow", "1")], keys].concat();
        room(&[], &(one(&[]) + &entity("func_wall", &wall))).model(
            [-32.0, 64.0, 0.0],
            [32.0, 96.0, 96.0],
            Some(2),
        )
    };
    let plain = LitLight::bounced(&map(&[]));
    let silent = LitLight::bounced(&map(&[("_bounce", "-1")]));
    let of_model = |lit: &LitLight| -> Vec<usize> {
        (0..lit.scene.surfaces.len()).filter(|&s| lit.scene.surfaces[s].model == Some(1)).collect()
    };
    let model = of_model(&silent);
    assert!(model.len() >= 5 && model.iter().all(|&s| !silent.scene.surfaces[s].reflects));
    assert!(of_model(&plain).iter().all(|&s| plain.scene.surfaces[s].reflects));
    let brightest = model.iter().flat_map(|&s| silent.of(s, 0)).fold(Vec3::ZERO, Vec3::max);
    assert!(brightest.min_element() > 1.0, "{brightest}");
    assert!(silent.mean(0) < plain.mean(0));
    // The sidecar says the same of texinfos.
    let view = settings(Some(DebugView::Bounce));
    let bsp = map(&[]).build(Format::Bsp29);
    let all: Vec<String> =
        (0..bsp.texinfos.len()).map(|i| format!("\"{i}\":{{\"no_bounce\":true}}")).collect();
    let none = LitLight::with_texinfo(&map(&[]), &view, &format!("{{{}}}", all.join(",")));
    assert_eq!(none.mean(0), 0.0);
}

#[test]
fn reflectance_is_colour_or_grey_as_asked() {
    let reflectance = |world: &[(&str, &str)], compat_bounce: bool| {
        let none = Settings { compat_bounce, bounces: Some(0), ..settings(None) };
        let lit = LitLight::new(&room(world, ""), &none);
        let brown = lit.scene.surfaces.iter().find(|s| s.texture == Some(1)).unwrap();
        brown.reflectance.0
    };
    let near = |a: Vec3, b: Vec3| assert!((a - b).length() < 1e-6, "{a} {b}");
    let grey = Vec3::splat(127.0 / 255.0);
    let own = reflectance(&[], false);
    near(own, Vec3::from(PALETTE[107].map(f32::from)) / 255.0);
    near(reflectance(&[("_bouncecolorscale", "1")], false), own);
    near(reflectance(&[("_bouncecolorscale", "0")], false), grey);
    near(reflectance(&[("_bouncecolorscale", "0.25")], false), grey.lerp(own, 0.25));
    near(reflectance(&[], true), grey);
    near(reflectance(&[("_bouncecolorscale", "1")], true), own);
    let square = own * own * 2.0;
    let bright = square / square.max_element().max(1.0);
    near(reflectance(&[("_tex_saturation_boost", "0.5")], false), own.lerp(bright, 0.5));
}

#[test]
fn without_lighting_only_switchable_lights_and_suns_shine() {
    let lamps = one(&[]) + &other(&[("style", "5")]);
    let world = [("_nolighting", "1"), ("_minlight", "40")];
    let lit = LitLight::new(&room(&world, &lamps), &settings(None));
    let direct = LitLight::new(&room(&[("_bounce", "0")], &lamps), &settings(None));
    assert_eq!(lit.mean(0), 0.0);
    assert_eq!(lit.all(5), direct.all(5));
    assert!(direct.mean(0) > 5.0 && direct.mean(5) > 5.0);
}

#[test]
fn styles_of_switchable_lights_start_where_the_map_says() {
    let named = one(&[("targetname", "a")]) + &other(&[("targetname", "b")]);
    let world = [("_compilerstyle_start", "100"), ("_compilerstyle_max", "102")];
    let lit = LitLight::new(&room(&world, &named), &settings(None));
    assert!(lit.mean(100) > 1.0 && lit.mean(101) > 1.0);
    let bsp = room(&world[..1], &named).build(Format::Bsp29);
    let error = Settings::default().styles(&bsp).and_then(|s| bsp.clone().rewrite_entities(s));
    assert!(error.unwrap_err().to_string().contains("_compilerstyle_max"));
}
