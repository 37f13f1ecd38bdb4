//! What makes direct light fast must not change it.

use qrad::bsp::Bsp;
use qrad::light::{Blockers, Candidates, Directions, direct, direct_from};
use qrad::light_bsp;
use qrad::progress::Progress;
use qrad::scene::{Scene, SceneSettings, Sidecar, luxels};
use qrad::settings::Settings;
use std::path::Path;
use std::sync::Arc;

fn map(name: &str) -> Bsp {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps").join(name);
    Bsp::read(&std::fs::read(path).unwrap()).unwrap()
}

fn atrium() -> Bsp {
    map("atrium.bsp")
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

/// Lights every `step`-th surface as a run does, and then sample by sample with nothing remembered, so
/// that no ray shares its work with another. Tells how many samples were compared.
fn compare_with_single_samples(
    name: &str,
    (extra, step): (u32, usize),
    keys: &[(&str, &str)],
) -> usize {
    let overrides = keys.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    let settings = SceneSettings { overrides, extra, ..SceneSettings::default() };
    let scene = Scene::build(&map(name), Sidecar::default(), &settings).unwrap();
    let mut blockers = Blockers::new(&scene);
    let (mut compared, mut lit) = (0, 0);
    for face in (0..scene.surfaces.len()).step_by(step) {
        let samples = luxels::place(&scene, face, extra);
        let together = direct_from(&scene, face, &samples, Directions::default(), &mut blockers);
        for (i, sample) in samples.iter().enumerate() {
            let alone = direct(&scene, face, std::slice::from_ref(sample));
            for (all, one) in [
                (&together.styles, &alone.styles),
                (&together.negative, &alone.negative),
                (&together.excess, &alone.excess),
            ] {
                for map in all {
                    let one = one.iter().find(|s| s.style == map.style);
                    let one = one.map_or_else(Default::default, |s| s.irradiance[0]);
                    assert_eq!(map.irradiance[i], one, "{name}, face {face}, sample {i}");
                    lit += usize::from(one.0.max_element() > 0.0);
                }
                for map in one {
                    assert!(all.iter().any(|s| s.style == map.style), "a style is lost");
                }
            }
        }
        compared += samples.len();
    }
    assert!(lit * 4 > compared, "{name}: {lit} of {compared} samples are lit");
    compared
}

#[test]
fn luxels_are_lit_alike_together_and_alone() {
    // Fences, glass, switched shadows, spots and suns; then sky domes and models.
    assert!(compare_with_single_samples("effects_all.bsp", (1, 1), &[]) > 5000);
    assert!(compare_with_single_samples("atrium.bsp", (1, 16), &[]) > 3000);
}

#[test]
fn supersamples_with_dirt_are_lit_alike_together_and_alone() {
    let dirt = [("_dirt", "1")];
    assert!(compare_with_single_samples("effects_all.bsp", (4, 16), &dirt) > 3000);
    assert!(compare_with_single_samples("atrium.bsp", (4, 256), &dirt) > 2000);
}

/// Lights a map as a run does, and with all lights at every surface, which must be the same. `most` is what
/// the lists of lights may have together. Tells the share of pairs of a surface and a light that are left,
/// and how many surfaces have no list.
fn compare_with_all_lights(name: &str, extra: u32, most: usize) -> (f64, usize) {
    let settings = SceneSettings { extra, ..SceneSettings::default() };
    let scene = Scene::build(&map(name), Sidecar::default(), &settings).unwrap();
    let faces = 0..scene.surfaces.len();
    let samples: Vec<_> = faces.clone().map(|f| luxels::place(&scene, f, extra)).collect();
    let candidates = Arc::new(Candidates::find_at_most(&scene, &samples, 1, most));
    let mut few = Blockers::among(&scene, Arc::clone(&candidates));
    let mut all = Blockers::new(&scene);
    let (mut entries, mut pairs, mut without) = (0, 0, 0);
    for face in faces {
        let lit = |blockers| {
            let samples = &samples[face];
            let light = direct_from(&scene, face, samples, Directions::default(), blockers);
            (light.styles, light.negative, light.excess)
        };
        assert!(lit(&mut few) == lit(&mut all), "{name}, face {face}");
        let list = candidates.of(face);
        entries += list.map_or(0, <[u32]>::len);
        pairs += list.map_or(scene.lights.len(), <[u32]>::len);
        without += usize::from(list.is_none());
    }
    assert!(entries <= most, "{name}: {entries} entries, and no more than {most} may be");
    (pairs as f64 / (scene.surfaces.len() * scene.lights.len().max(1)) as f64, without)
}

#[test]
fn lights_left_out_for_groups_of_surfaces_give_none() {
    for (name, extra, most) in
        [("effects_all.bsp", 1, 1.0), ("atrium.bsp", 1, 0.4), ("slit.bsp", 2, 1.0)]
    {
        let (share, without) = compare_with_all_lights(name, extra, usize::MAX);
        assert!(share <= most, "{name}: {share} of all pairs of a surface and a light are left");
        assert_eq!(without, 0, "{name}");
    }
}

#[test]
fn lists_of_lights_that_grow_too_long_are_given_up() {
    let surfaces = map("atrium.bsp").faces.len();
    // Some groups have room for theirs.
    let (_, without) = compare_with_all_lights("atrium.bsp", 1, 8 * surfaces);
    assert!(without > 0 && without < surfaces, "{without} of {surfaces} have no list");
    let (_, without) = compare_with_all_lights("atrium.bsp", 1, 0);
    assert!(without > surfaces / 2, "{without} of {surfaces} have no list");
}
