//! Maps with a material file: what textures do to light, against closed forms.

mod support;

use glam::{DVec3, Vec3};
use qrad::lightmap::{DebugView, Gather};
use qrad::radiosity::contour::point_to_polygon;
use qrad::scene::Sidecar;
use qrad::scene::material_file::MaterialFile;
use qrad::settings::{Settings, SurfaceLights};
use std::f32::consts::PI;
use support::lit_light::{LitLight, settings};
use support::lit_room::entity;
use support::map_builder::MapBuilder;
use support::program::{fail, run};

/// The most that closed forms are missed by.
const CLOSE: f32 = 2e-3;

fn lit(map: &MapBuilder, settings: &Settings, materials: &str) -> LitLight {
    let file = MaterialFile::parse(materials, "m.toml").unwrap();
    LitLight::with(map, settings, Sidecar { materials: Some(&file), ..Sidecar::default() })
}

fn material(texture: &str, keys: &str) -> String {
    format!("[[material]]\ntexture = \"{texture}\"\n{keys}\n")
}

/// A room 256 long with a lamp at its low end and panes across it; what is beyond sends no light back.
fn room_with_panes(panes: usize, pane_keys: &[(&str, &str)]) -> MapBuilder {
    let mut entities = entity("worldspawn", &[]);
    entities += &entity("light", &[("origin", "-90 10 70"), ("light", "300")]);
    let mut map = MapBuilder::room([-128.0, -64.0, 0.0], [128.0, 64.0, 128.0])
        .solid_texture("far", 12)
        .solid_texture("near", 12)
        .solid_texture("glass", 79)
        .room_textures([1, 0, 0, 0, 0, 0])
        .subdivide(64.0);
    for k in 0..panes {
        let x = 16.0 * k as f32;
        map = map.model([x, -64.0, 0.0], [x + 4.0, 64.0, 128.0], Some(2));
        let number = format!("*{}", k + 1);
        let keys = [&[("model", &*number), ("_shadow", "1")], pane_keys].concat();
        entities += &entity("func_wall", &keys);
    }
    map.entities(entities)
}

/// Bounced light on the far end, of one bounce off the low end.
fn bounced_far(map: &MapBuilder, pane: &str) -> Vec<Vec3> {
    let settings = Settings { bounces: Some(1), ..settings(Some(DebugView::Bounce)) };
    let materials = material("far", "bounce = false") + &material("glass", pane);
    let lit = lit(map, &settings, &materials);
    let far = |s: &usize| lit.scene.surfaces[*s].vertices.iter().all(|v| v.x == 128.0);
    (0..lit.scene.surfaces.len()).filter(far).flat_map(|s| lit.of(s, 0)).collect()
}

#[test]
fn panes_filter_bounced_light_and_multiply() {
    let tint = Vec3::new(1.0, 0.5, 0.25);
    let clear = bounced_far(&room_with_panes(0, &[]), "");
    assert!(clear.iter().all(|e| e.min_element() > 0.05), "{:?}", clear[0]);
    for panes in 1..4 {
        // The direct light on the low end does not cross them.
        let got = bounced_far(&room_with_panes(panes, &[]), "transmission = [1, 0.5, 0.25]");
        let want = tint.powf(panes as f32);
        for (got, clear) in got.iter().zip(&clear) {
            let off = (*got / (*clear * want) - 1.0).abs().max_element();
            assert!(off < CLOSE, "{panes} panes: {got} of {clear}, off by {off}");
        }
    }
}

#[test]
fn alpha_of_a_brush_model_filters_bounced_light_by_its_texture() {
    let clear = bounced_far(&room_with_panes(0, &[]), "");
    let got = bounced_far(&room_with_panes(1, &[("alpha", "0.6")]), "");
    let colour = qrad::bsp::PALETTE[79].map(|c| f32::from(c) / 255.0);
    let want = Vec3::ONE.lerp(Vec3::from(colour), 0.6);
    assert!(want.max_element() - want.min_element() > 0.05, "a colour: {want}");
    for (got, clear) in got.iter().zip(&clear) {
        assert!((*got / (*clear * want) - 1.0).abs().max_element() < CLOSE, "{got} {clear}");
    }
}

/// In a closed room that all emits and sends on alike, light is the same everywhere.
#[test]
fn a_furnace_with_a_curtain_keeps_its_level() {
    let map = MapBuilder::room([-96.0, -64.0, 0.0], [96.0, 64.0, 96.0])
        .solid_texture("wall", 12)
        .solid_texture("cloth", 12)
        .pillar([-8.0, -64.0, 0.0], [0.0, 64.0, 96.0], 1);
    let settings = Settings { surface_lights: SurfaceLights::Area, ..settings(None) };
    let emission = "emission = { intensity = 10, parts = \"texture\" }";
    let materials = material("wall", "reflectance = [0.6, 0.5, 0.4]")
        + &material(
            "cloth",
            "reflectance = [0.2, 0.2, 0.2]\ndiffuse_transmission = [0.4, 0.3, 0.2]",
        )
        + &material("*", emission);
    let lit = lit(&map, &settings, &materials);
    let colour = Vec3::from(qrad::bsp::PALETTE[12].map(|c| f32::from(c) / 255.0));
    let want = colour * 10.0 * PI / (1.0 - Vec3::new(0.6, 0.5, 0.4));
    let mut walls = 0;
    for (s, surface) in lit.scene.surfaces.iter().enumerate() {
        // A curtain shows what comes through as well.
        let shown = match surface.diffuse {
            None => want,
            Some(tau) => want * (1.0 + tau / surface.reflectance.0),
        };
        for got in lit.of(s, 0) {
            let off = (got / shown - 1.0).abs().max_element();
            assert!(off < CLOSE, "surface {s}: {got} for {shown}");
        }
        walls += usize::from(surface.diffuse.is_none());
    }
    assert_eq!(walls, 6);
}

#[test]
fn a_curtain_lights_the_dark_side() {
    let map = |light: [&str; 2]| {
        MapBuilder::room([-96.0, -64.0, 0.0], [96.0, 64.0, 96.0])
            .solid_texture("wall", 12)
            .solid_texture("cloth", 12)
            .pillar([-8.0, -64.0, 0.0], [0.0, 64.0, 96.0], 1)
            .entities(
                entity("worldspawn", &[])
                    + &entity("light", &[("origin", light[0]), ("light", light[1])]),
            )
    };
    let map = map(["60 0 48", "300"]);
    let dark = |lit: &LitLight| -> f32 {
        let far = |s: &usize| lit.scene.surfaces[*s].vertices.iter().all(|v| v.x < -7.0);
        (0..lit.scene.surfaces.len()).filter(far).flat_map(|s| lit.of(s, 0)).map(|e| e.x).sum()
    };
    let opaque = lit(&map, &settings(None), "");
    assert_eq!(dark(&opaque), 0.0);
    let through = lit(&map, &settings(None), &material("cloth", "diffuse_transmission = 0.4"));
    assert!(dark(&through) > 1000.0, "{}", dark(&through));
}

#[test]
fn lines_of_rad_files_and_emission_agree() {
    let map = MapBuilder::room([-96.0, -64.0, 0.0], [96.0, 64.0, 96.0])
        .solid_texture("wall", 12)
        .solid_texture("panel", 70)
        .room_textures([0, 0, 0, 0, 0, 1]);
    let light = |lit: &LitLight| {
        (0..lit.scene.surfaces.len()).flat_map(|s| lit.of(s, 0)).collect::<Vec<Vec3>>()
    };
    let emission = material("p*l", "emission = { colour = [1, 0.5, 0], intensity = 120 }");
    let own = lit(&map, &settings(None), &emission);
    let rad = [("lights.rad".to_owned(), "panel 255 127.5 0 120\n".to_owned())];
    let with_rad = |materials: &str| {
        let file = MaterialFile::parse(materials, "m").unwrap();
        let sidecar = Sidecar { rad: &rad, materials: Some(&file), ..Sidecar::default() };
        light(&LitLight::with(&map, &settings(None), sidecar))
    };
    assert!(light(&own).iter().any(|e| e.x > 1.0));
    assert_eq!(light(&own), with_rad(""), "the same light");
    assert_eq!(light(&own), with_rad(&emission), "not twice");
}

#[test]
fn surfaces_take_what_the_file_says() {
    let map = MapBuilder::room([-96.0, -64.0, 0.0], [96.0, 64.0, 96.0])
        .solid_texture("a", 12)
        .solid_texture("b", 12)
        .room_textures([0, 0, 0, 0, 1, 0]);
    let none = lit(&map, &settings(None), "");
    let own = none.scene.surfaces[0].reflectance.0;
    let materials = material("a", "reflectance = 0.5\ntwo_sided = true\nalpha_test = true")
        + &material("b", "modifier = { kind = \"checker\", size = 32, colour = [0, 0.5, 1] }");
    let lit = lit(&map, &settings(None), &materials);
    for surface in &lit.scene.surfaces {
        if surface.normal == Vec3::Z {
            continue;
        }
        assert!((surface.reflectance.0 - own * 0.5).abs().max_element() < 1e-6);
        assert!(surface.two_sided && surface.fence);
    }
    // Half of the floor's cells are multiplied: 192 x 128 in cells of 32.
    let patches = {
        let scene = &lit.scene;
        let samples: Vec<_> = (0..scene.surfaces.len())
            .map(|face| qrad::scene::luxels::place(scene, face, 1))
            .collect();
        qrad::patch::MapPatches::new(scene, &samples, 2)
    };
    let (mut mean, mut area) = (Vec3::ZERO, 0.0);
    let mut kinds = 0;
    for patch in patches.set.patches.iter().filter(|p| p.normal == Vec3::Z) {
        mean += patch.reflectance.0 * patch.area;
        area += patch.area;
        kinds += usize::from(patch.reflectance.0.x < 0.1 * own.x);
    }
    let want = own * Vec3::new(0.5, 0.75, 1.0);
    assert!((mean / area - want).abs().max_element() < 0.02, "{} {want}", mean / area);
    assert!(kinds > 0, "whole patches are dark");
}

/// Tiles of 64 units over a floor of 256, half of them other than the rest: whether each is, and its corners.
fn tiles() -> Vec<(bool, Vec<DVec3>)> {
    const TILE: f32 = 64.0;
    let edge = |k: i32| f64::from(TILE) * f64::from(k);
    (-2..2)
        .flat_map(|i| (-2..2).map(move |j| (i, j)))
        .map(|(i, j)| {
            let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            // Luxels stand a unit before the walls, and see no more than what is before them.
            let x = |x| edge(x).clamp(-127.0, 127.0);
            // The second axis of a floor's texture runs against y.
            ((i + j) % 2 == 0, corners.map(|[i, j]| DVec3::new(x(i), edge(j), 0.0)).to_vec())
        })
        .collect()
}

/// Light on two walls over such a floor, whose tiles have an exitance of `other` or `one`: how far it is
/// off, root mean square, and how far the mean of the tiles would be.
fn off_on_walls(lit: &LitLight, [other, one]: [Vec3; 2]) -> [f32; 2] {
    let tiles = tiles();
    let (mut off, mut even, mut sum) = (0.0, 0.0, 0.0);
    for s in (0..lit.scene.surfaces.len()).filter(|&s| lit.scene.surfaces[s].normal.x != 0.0) {
        let samples = qrad::scene::luxels::place(&lit.scene, s, 1);
        for (sample, got) in samples.iter().zip(lit.of(s, 0)) {
            // Below may be another room.
            if sample.position.x.abs() != 127.0 || sample.position.z < 8.0 {
                continue;
            }
            let [at, normal] = [sample.position, sample.normal].map(Vec3::as_dvec3);
            let (mut want, mut mean) = (Vec3::ZERO, Vec3::ZERO);
            for (is_other, tile) in &tiles {
                let share = point_to_polygon(at, normal, tile) as f32;
                want += share * if *is_other { other } else { one };
                mean += share * (one + other) * 0.5;
            }
            off += (got - want).length_squared();
            even += (mean - want).length_squared();
            sum += want.length_squared();
        }
    }
    [off, even].map(|e| (e / sum).sqrt())
}

/// A room whose floor is 256 wide, and settings under which a wall sees it in patches of 128.
fn tiled_room(tiles: impl Fn(MapBuilder) -> MapBuilder) -> (MapBuilder, Settings) {
    let map = MapBuilder::room([-128.0, -128.0, 0.0], [128.0, 128.0, 128.0]);
    let map = tiles(map.solid_texture("wall", 12)).room_textures([0, 0, 0, 0, 1, 0]);
    let settings = Settings {
        bounces: Some(1),
        patch_size: 8,
        gather: Gather::Luxel,
        ..settings(Some(DebugView::Bounce))
    };
    (map, settings)
}

const CHECKER: &str = "modifier = { kind = \"checker\", size = 64, colour = [0, 0.5, 1] }";

/// Tiles much smaller than patches, lit evenly, as a wall sees them: against the closed form of every tile.
#[test]
fn patterns_are_seen_where_they_are() {
    let (map, settings) = tiled_room(|map| map.solid_texture("tiles", 12));
    let light = [("origin", "0 0 120"), ("light", "100"), ("delay", "3"), ("_anglescale", "0")];
    let map = map.entities(entity("worldspawn", &[]) + &entity("light", &light));
    let materials = material("wall", "bounce = false") + &material("tiles", CHECKER);
    let lit = lit(&map, &settings, &materials);
    let floor = lit.scene.surfaces.iter().find(|s| s.normal == Vec3::Z).unwrap();
    let one = floor.reflectance.0 * 100.0;
    let [off, even] = off_on_walls(&lit, [one * Vec3::new(0.0, 0.5, 1.0), one]);
    println!("off by {off}, means by {even}");
    assert!(even > 0.05, "means do not do: {even}");
    assert!(off < 0.02, "{off}");
}

/// A cloth with tiles between light above and light below it: what it reflects and what comes through it have
/// the same pattern.
#[test]
fn light_through_a_cloth_has_its_pattern() {
    let lamp = |z, light| {
        let origin = format!("0 0 {z}");
        let keys = [("light", light), ("delay", "3"), ("_anglescale", "0")];
        entity("light", &[&[("origin", origin.as_str())], &keys[..]].concat())
    };
    let map = MapBuilder::room([-128.0, -128.0, -136.0], [128.0, 128.0, 128.0])
        .solid_texture("wall", 12)
        .solid_texture("tiles", 12)
        .pillar([-128.0, -128.0, -8.0], [128.0, 128.0, 0.0], 1)
        .entities(entity("worldspawn", &[]) + &lamp(120, "50") + &lamp(-120, "100"));
    let (_, settings) = tiled_room(|map| map);
    let (rho, tau) = (Vec3::new(0.3, 0.2, 0.0), Vec3::new(0.4, 0.1, 0.6));
    let cloth = format!("reflectance = [{}, {}, {}]\n", rho.x, rho.y, rho.z)
        + &format!("diffuse_transmission = [{}, {}, {}]\n", tau.x, tau.y, tau.z);
    for modifier in ["", CHECKER] {
        let materials =
            material("wall", "bounce = false") + &material("tiles", &(cloth.clone() + modifier));
        let lit = lit(&map, &settings, &materials);
        let one = rho * 50.0 + tau * 100.0;
        let colour = if modifier.is_empty() { Vec3::ONE } else { Vec3::new(0.0, 0.5, 1.0) };
        let [off, even] = off_on_walls(&lit, [one * colour, one]);
        println!("off by {off}, means by {even}");
        assert!(modifier.is_empty() || even > 0.05, "means do not do: {even}");
        assert!(off < 0.02, "{off}");
    }
}

/// Texels much brighter than their mean would send on more light than falls on them.
#[test]
fn cloth_sends_on_less_than_it_gets_and_all_alike() {
    let pixels: Vec<u8> = (0..64 * 64).map(|k| if k % 64 < 16 { 254 } else { 0 }).collect();
    let map = MapBuilder::room([-96.0, -64.0, 0.0], [96.0, 64.0, 96.0])
        .solid_texture("wall", 12)
        .texture("cloth", 64, 64, pixels)
        .pillar([-8.0, -64.0, 0.0], [0.0, 64.0, 96.0], 1);
    let keys = "reflectance = 0.3\ndiffuse_transmission = 0.6\nmodifier = { kind = \"texel\" }";
    let file = MaterialFile::parse(&material("cloth", keys), "m.toml").unwrap();
    let scene = {
        let sidecar = Sidecar { materials: Some(&file), ..Sidecar::default() };
        LitLight::with(&map, &Settings { bounces: Some(0), ..settings(None) }, sidecar).scene
    };
    let faces = 0..scene.surfaces.len();
    let samples: Vec<_> = faces.map(|face| qrad::scene::luxels::place(&scene, face, 1)).collect();
    let patches = qrad::patch::MapPatches::new(&scene, &samples, 1);
    let (mut bright, mut dark) = (0, 0);
    for passage in &patches.set.passages {
        let surface = &scene.surfaces[patches.surface[passage.to.0 as usize] as usize];
        let rho = patches.set.patches[passage.to.0 as usize].reflectance.0;
        let albedo = rho + passage.transmittance;
        assert!(albedo.max_element() < 0.991, "{albedo}");
        let want = surface.diffuse.unwrap() / surface.reflectance.0;
        let alike = passage.transmittance - rho * want;
        assert!(alike.abs().max_element() < 1e-5, "{rho} {}", passage.transmittance);
        bright += usize::from(albedo.x > 0.98);
        dark += usize::from(albedo.x < 0.01);
    }
    assert!(bright > 0 && dark > 0, "{bright} bright and {dark} dark patches");
}

/// The same of tiles that shine, whose texels are fullbright.
#[test]
fn texels_shine_where_they_are() {
    // Tiles of 64 texels; the first is bright.
    let bright = |k: usize| (k % 128 / 64 + k / 128 / 64).is_multiple_of(2);
    let pixels: Vec<u8> = (0..128 * 128).map(|k| if bright(k) { 12 } else { 254 }).collect();
    let (map, settings) = tiled_room(|map| map.texture("tiles", 128, 128, pixels.clone()));
    let map = map.entities(entity("worldspawn", &[]));
    let emission = "emission = { intensity = 100, parts = \"fullbright\" }\nreflectance = 0\n";
    for modifier in ["", CHECKER] {
        let materials = material("wall", "bounce = false")
            + &material("tiles", &(emission.to_owned() + modifier));
        let lit = lit(&map, &settings, &materials);
        let shine = Vec3::from(qrad::bsp::PALETTE[254].map(f32::from)) / 255.0 * 100.0 * PI;
        let [off, even] = off_on_walls(&lit, [shine, Vec3::ZERO]);
        println!("off by {off}, means by {even}");
        // Twice the contrast of the tiles above, and more of the noise of hemicubes.
        assert!(even > 0.2, "means do not do: {even}");
        assert!(off < 0.03, "{off}");
    }
}

/// A floor that shines all over, lit by a lamp besides: what it gives off is even, what it reflects is not.
#[test]
fn floors_that_shine_reflect_their_pattern() {
    let (map, settings) = tiled_room(|map| map.solid_texture("tiles", 12));
    let light = [("origin", "0 0 120"), ("light", "100"), ("delay", "3"), ("_anglescale", "0")];
    let map = map.entities(entity("worldspawn", &[]) + &entity("light", &light));
    let settings = Settings { surface_lights: SurfaceLights::Area, ..settings };
    let shining = "emission = { colour = [1, 1, 1], intensity = 20 }\n".to_owned() + CHECKER;
    let materials = material("wall", "bounce = false") + &material("tiles", &shining);
    let lit = lit(&map, &settings, &materials);
    let floor = lit.scene.surfaces.iter().find(|s| s.normal == Vec3::Z).unwrap();
    let (one, own) = (floor.reflectance.0 * 100.0, Vec3::splat(20.0 * PI));
    let [off, even] = off_on_walls(&lit, [one * Vec3::new(0.0, 0.5, 1.0) + own, one + own]);
    println!("off by {off}, means by {even}");
    assert!(off < 0.02 && even > 2.0 * off, "{off}, means {even}");
}

#[test]
fn names_of_no_texture_are_warned_of() {
    let dir = tempfile::tempdir().unwrap();
    let map = dir.path().join("room.bsp");
    std::fs::copy(support::maps_dir().join("through.bsp"), &map).unwrap();
    let file = dir.path().join("room.materials.toml");
    std::fs::write(&file, material("flor", "bounce = false") + &material("clo*", "")).unwrap();
    let output = run(&map, &["--bounces=0"]);
    let err = String::from_utf8(output.stderr).unwrap();
    assert!(err.contains("room.materials.toml: no texture of the map is named so"), "{err}");
    assert!(err.contains("line 2: texture \"flor\" (did you mean \"floor\"?)"), "{err}");
    assert!(!err.contains("clo*"), "{err}");
}

#[test]
fn the_program_names_file_and_line() {
    let dir = tempfile::tempdir().unwrap();
    let map = dir.path().join("room.bsp");
    std::fs::copy(support::maps_dir().join("furnace.bsp"), &map).unwrap();
    let file = dir.path().join("room.materials.toml");
    std::fs::write(&file, material("mid", "reflectence = 0.5")).unwrap();
    let err = fail(&map, &["--bounces=0", "--quiet"]);
    assert!(err.contains("room.materials.toml: line 3: unknown key"), "{err}");
    assert!(err.contains("\"reflectance\""), "{err}");
}
