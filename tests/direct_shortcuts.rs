//! What makes direct light fast must not change it.

use qrad::bsp::Bsp;
use qrad::light_bsp;
use qrad::progress::Progress;
use qrad::scene::{Scene, SceneSettings, Sidecar};
use qrad::settings::Settings;
use std::path::Path;

fn atrium() -> Bsp {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/atrium.bsp");
    Bsp::read(&std::fs::read(path).unwrap()).unwrap()
}

fn lighting(mut bsp: Bsp) -> Vec<u8> {
    let settings = Settings { bounces: Some(0), ..Settings::default() };
    light_bsp(&mut bsp, Sidecar::default(), Vec::new(), &settings, &Progress::new(false)).unwrap();
    bsp.lighting
}

#[test]
fn visibility_saves_rays_and_changes_no_light() {
    let scene = Scene::build(&atrium(), Sidecar::default(), &SceneSettings::default()).unwrap();
    let unseen = (0..scene.lights.len())
        .filter(|&l| {
            let reach = scene.visibility.of_light(l);
            scene.surfaces.iter().filter_map(|s| s.vertices.first()).any(|&corner| {
                let above = corner + glam::Vec3::splat(1.0);
                !reach.includes(scene.visibility.leaf(&scene.solid, above))
            })
        })
        .count();
    assert!(unseen > 10, "{unseen} lights do not reach everywhere");

    let mut without = atrium();
    without.visibility.clear();
    assert!(lighting(without) == lighting(atrium()));
}

#[test]
fn damaged_visibility_only_costs_time() {
    // A row that ends early, and one past the end of the lump.
    let mut bsp = atrium();
    let length = bsp.visibility.len();
    bsp.visibility.truncate(length / 2);
    for leaf in bsp.leafs.iter_mut().skip(1).step_by(3) {
        leaf.vis_offset = i32::MAX;
    }
    assert!(lighting(bsp) == lighting(atrium()));
}
