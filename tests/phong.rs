//! Smoothed normals: which faces are blended, and what it does to luxels.

mod support;

use glam::Vec3;
use qrad::bsp::{Bsp, Format};
use qrad::scene::{Sample, Scene, SceneSettings, Sidecar, luxels};
use support::map_builder::MapBuilder;

/// A room with a block in the middle whose texture is `block`; every face of it meets others at 90
/// degrees.
fn map(world: &str) -> Bsp {
    MapBuilder::room([-256.0, -256.0, 0.0], [256.0, 256.0, 256.0])
        .solid_texture("wall", 8)
        .solid_texture("block", 8)
        .pillar([-32.0, -32.0, 64.0], [32.0, 32.0, 128.0], 1)
        .entities(format!("{{\n\"classname\" \"worldspawn\"\n{world}}}\n"))
        .build(Format::Bsp29)
}

fn scene(world: &str, keys: &str) -> Scene {
    let bsp = map(world);
    let members: Vec<String> = (0..bsp.texinfos.len())
        .filter(|&i| bsp.texinfos[i].miptex == 1)
        .map(|i| format!("\"{i}\": {keys}"))
        .collect();
    let texinfo = format!("{{{}}}", members.join(","));
    let sidecar = Sidecar { texinfo: Some(&texinfo), ..Sidecar::default() };
    Scene::build(&bsp, sidecar, &SceneSettings::default()).unwrap()
}

/// Samples of the top of the block.
fn top(scene: &Scene) -> Vec<Sample> {
    let top = scene.surfaces.iter().position(|s| s.normal == Vec3::Z && s.dist == 128.0).unwrap();
    luxels::place(scene, top, 1)
}

fn is_flat(samples: &[Sample]) -> bool {
    samples.iter().all(|s| s.normal == Vec3::Z)
}

#[test]
fn corners_get_the_mean_of_their_faces_and_the_middle_is_a_blend() {
    let scene = scene("", r#"{"phong_angle": 91}"#);
    let samples = top(&scene);
    let corner = samples.iter().find(|s| s.position.x == -32.0 && s.position.y == -32.0);
    let diagonal = Vec3::new(-1.0, -1.0, 1.0).normalize();
    let normal = corner.expect("a luxel at the corner").normal;
    assert!((normal - diagonal).length() < 1e-3, "{normal}");
    let middle = samples.iter().find(|s| s.position.x == 0.0 && s.position.y == 0.0).unwrap();
    // Not brought back to unit length, as in the reference.
    assert!((middle.normal - Vec3::Z / 3_f32.sqrt()).length() < 1e-3, "{}", middle.normal);
    assert!(scene.surfaces.iter().filter(|s| s.curved).count() == 6);
}

#[test]
fn the_angle_between_faces_decides() {
    assert!(is_flat(&top(&scene("", "{}"))));
    assert!(is_flat(&top(&scene("", r#"{"phong_angle": 89}"#))), "the faces meet at 90 degrees");
    assert!(is_flat(&top(&scene("", r#"{"phong_group": 3}"#))), "a group alone means 89 degrees");
    assert!(!is_flat(&top(&scene("", r#"{"phong_angle": 91, "phong_group": 3}"#))));
    // All edges of the block are convex.
    let keys = r#"{"phong_angle": 10, "phong_angle_concave": 120}"#;
    assert!(is_flat(&top(&scene("", keys))));
}

#[test]
fn concave_edges_have_an_angle_of_their_own() {
    let inside = |keys: &str| {
        let bsp = map("");
        let members: Vec<String> =
            (0..bsp.texinfos.len()).map(|i| format!("\"{i}\": {keys}")).collect();
        let texinfo = format!("{{{}}}", members.join(","));
        let sidecar = Sidecar { texinfo: Some(&texinfo), ..Sidecar::default() };
        let scene = Scene::build(&bsp, sidecar, &SceneSettings::default()).unwrap();
        let floor =
            scene.surfaces.iter().position(|s| s.normal == Vec3::Z && s.dist == 0.0).unwrap();
        is_flat(&luxels::place(&scene, floor, 1))
    };
    assert!(!inside(r#"{"phong_angle": 91}"#));
    assert!(inside(r#"{"phong_angle": 91, "phong_angle_concave": 10}"#));
    assert!(!inside(r#"{"phong_angle": 10, "phong_angle_concave": 91}"#));
}

#[test]
fn the_world_may_ask_for_smoothing_or_forbid_it() {
    assert!(!is_flat(&top(&scene("\"_phong_angle\" \"91\"\n", "{}"))));
    let off = scene("\"_phong\" \"0\"\n", r#"{"phong_angle": 91}"#);
    assert!(is_flat(&top(&off)));
    assert!(off.surfaces.iter().any(|s| s.curved), "faces still count as curved");
}

#[test]
fn brush_models_ask_for_all_their_faces() {
    for (key, value, curved) in [("_phong", "1", true), ("_phong_angle", "0.4", false)] {
        let text = format!(
            "{{\n\"classname\" \"worldspawn\"\n}}\n{{\n\"classname\" \"func_wall\"\n\"model\" \"*1\"\n\
             \"{key}\" \"{value}\"\n}}\n"
        );
        let bsp = MapBuilder::room([-256.0, -256.0, 0.0], [256.0, 256.0, 256.0])
            .solid_texture("wall", 8)
            .solid_texture("block", 8)
            .model([-32.0, -32.0, 64.0], [32.0, 32.0, 128.0], Some(1))
            .entities(text)
            .build(Format::Bsp29);
        let scene = Scene::build(&bsp, Sidecar::default(), &SceneSettings::default()).unwrap();
        let of = |model| scene.surfaces.iter().filter(move |s| s.model == Some(model));
        assert!(of(1).all(|s| s.curved == curved), "{key}");
        assert!(of(0).all(|s| !s.curved));
    }
}
