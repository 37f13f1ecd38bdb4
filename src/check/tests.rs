//! Solutions made wrong on purpose are found out, and right ones are not.

use super::*;
use crate::bsp::Bsp;
use crate::light::{bounce_source, direct};
use crate::lightmap::{Gather, GatherSettings, Sources, indirect};
use crate::patch::{MapPatches, TextPatches, TextScene};
use crate::radiosity::bounce::bounce;
use crate::radiosity::hemicube::HemicubeSize;
use crate::radiosity::solve::{self, Limits, solve};
use crate::radiosity::transfers::Transfers;
use crate::scene::{Scene, SceneSettings, Sidecar, luxels};
use crate::settings::Quality;
use std::path::PathBuf;

/// Enough for all points of small scenes on a busy machine.
const TIME: Duration = Duration::from_secs(6);

fn project_map(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("maps").join(name)
}

fn check_text(damage: Option<usize>) -> (Findings, Energy) {
    let text = std::fs::read_to_string(project_map("cornell/cornell.txt")).unwrap();
    let mut scene = TextScene::parse(&text, "cornell").unwrap();
    scene.hemicube = [128, 128];
    let progress = crate::progress::Progress::new(false);
    let near = Some(Quality::Draft.near());
    let (mut transfers, mut solution) = crate::light_patches_with(&scene, near, &progress).unwrap();
    if let Some(row) = damage {
        transfers.clear_row(row);
        let patches = TextPatches::new(&scene);
        let sources = solve::Sources { emission: &patches.emission, direct: &[] };
        let limits = Limits { passes: Some(100), residual: 1e-9 };
        solution = solve(&transfers, &patches.reflectance(), sources, limits);
    }
    let (findings, energy) = check_patches(&scene, &transfers, &solution, Instant::now() + TIME);
    (findings.unwrap(), energy.unwrap())
}

#[test]
fn a_zeroed_row_of_a_text_scene_is_reported() {
    let (right, energy) = check_text(None);
    println!("{right:?} {energy:?}");
    assert_eq!(right.odd, 0);
    // How much noise there is depends on the time that the machine gives: it must be told as such.
    assert!(right.error().is_none_or(|e| e < 0.02), "{right:?}");
    assert!(right.at_most() < 0.06 && (right.bias - 1.0).abs() < 0.02);
    assert!((energy.balance - 1.0).abs() < 0.005 && (0.15..0.18).contains(&energy.lost));
    assert_eq!(energy.dead, 0);
    // A patch of a wall, in the middle of it.
    let (wrong, energy) = check_text(Some(40));
    println!("{wrong:?} {energy:?}");
    assert_eq!((wrong.odd, &*wrong.worst.unwrap().name), (1, "patch 40"));
    assert_eq!((energy.dead, energy.first_dead), (1, Some(40)));
}

fn check_map(damage: bool) -> (Findings, Energy) {
    let bsp = Bsp::read(&std::fs::read(project_map("cornell.bsp")).unwrap()).unwrap();
    let scene = Scene::build(&bsp, Sidecar::default(), &SceneSettings::default()).unwrap();
    let faces = 0..scene.surfaces.len();
    let samples: Vec<_> = faces.map(|face| luxels::place(&scene, face, 1)).collect();
    let patches = MapPatches::new(&scene, &samples, 2);
    let size = HemicubeSize::new(32, 32).unwrap();
    let mut transfers = Transfers::compute(scene.bounce_tracer(), &patches.set, size, |_| {});
    if damage {
        (0..transfers.rows()).step_by(40).for_each(|row| transfers.clear_row(row));
    }
    let light: Vec<_> = samples.iter().enumerate().map(|(i, s)| direct(&scene, i, s)).collect();
    let source = light.iter().zip(&samples).map(|(light, s)| bounce_source(light, s, 1, 1));
    let arriving: Vec<_> = source.collect();
    let emission = patches.emission(&scene.emitters);
    let limits = Limits { passes: None, residual: 1e-5 };
    let bounced = bounce(&patches, &transfers, &arriving, &emission, limits, |_| {});
    let sources =
        Sources { scene: &scene, patches: &patches, transfers: &transfers, light: &bounced.styles };
    let how = GatherSettings { gather: Gather::Interpolate, error: 0.05, hemicube: size };
    let (found, _) = indirect(sources, &samples, how, |_| {});
    let run = Run {
        sources,
        samples: &samples,
        arriving: &arriving,
        emission: &emission,
        found: &found,
        bounces: None,
        hemicube: size,
    };
    let (findings, energy) = check_luxels(&run, Instant::now() + TIME);
    (findings.unwrap(), energy.unwrap())
}

#[test]
fn zeroed_rows_of_a_map_are_reported() {
    let (right, energy) = check_map(false);
    println!("{right:?} {energy:?}");
    assert_eq!(right.odd, 0);
    assert!(right.at_most() < 0.06 && (right.bias - 1.0).abs() < 0.02);
    assert!((right.bias_by_rays - 1.0).abs() < 0.05);
    assert!((energy.balance - 1.0).abs() < 0.01);
    assert_eq!(energy.dead, 0);
    let (wrong, energy) = check_map(true);
    println!("{wrong:?} {energy:?}");
    assert!(energy.dead > 0 && energy.first_dead == Some(0));
    assert!(wrong.square > 3.0 * right.square && wrong.bias < 0.98, "the light that is missing");
}
