//! Solutions made wrong on purpose are found out, and right ones are not.

use super::*;
use crate::bsp::Bsp;
use crate::light::{bounce_source, direct};
use crate::lightmap::{Gather, GatherSettings, Sources, indirect};
use crate::patch::{MapPatches, TextPatches, TextScene};
use crate::progress::Progress;
use crate::radiosity::bounce::bounce;
use crate::radiosity::hemicube::HemicubeSize;
use crate::radiosity::solve::{self, Limits, solve_with};
use crate::radiosity::transfers::Transfers;
use crate::scene::{Scene, SceneSettings, Sidecar, luxels};
use crate::settings::Quality;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

/// Calls `check` with a deadline by a clock that moves with each look at it, on two threads: the work is
/// the same on every machine.
fn by_looks<T: Send>(check: impl FnOnce(Deadline<'_>) -> T + Send) -> T {
    let looks = AtomicU64::new(0);
    let clock = Box::new(move || Duration::from_secs(looks.fetch_add(1, Ordering::Relaxed)));
    let progress = Progress::with_clock(false, clock);
    let threads = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    threads.install(|| check(progress.deadline(Duration::from_secs(120))))
}

fn project_map(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("maps").join(name)
}

fn check_text(name: &str, damage: Option<usize>) -> (Findings, Energy) {
    let text = std::fs::read_to_string(project_map(name)).unwrap();
    let mut scene = TextScene::parse(&text, name).unwrap();
    scene.hemicube = [128, 128];
    let progress = Progress::new(false);
    let near = Some(Quality::Draft.near());
    let (mut transfers, mut solution) = crate::light_patches_with(&scene, near, &progress).unwrap();
    if let Some(row) = damage {
        transfers.clear_row(row);
        let patches = TextPatches::new(&scene);
        let sources = solve::Sources { emission: &patches.emission, direct: &[] };
        let limits = Limits { passes: Some(100), residual: 1e-9 };
        let passages = &patches.set.passages;
        solution = solve_with(&transfers, &patches.reflectance(), passages, sources, limits);
    }
    let (findings, energy) = by_looks(|end| check_patches(&scene, &transfers, &solution, end));
    (findings.unwrap(), energy.unwrap())
}

#[test]
fn a_zeroed_row_of_a_text_scene_is_reported() {
    let (right, energy) = check_text("cornell/cornell.txt", None);
    println!("{right:?} {energy:?}");
    assert_eq!(right.odd, 0);
    assert!(right.error().is_none_or(|e| e < 0.02), "{right:?}");
    assert!(right.at_most() < 0.06 && (right.bias - 1.0).abs() < 0.02);
    assert!((energy.balance - 1.0).abs() < 0.005 && (0.15..0.18).contains(&energy.lost));
    assert_eq!(energy.dead, 0);
    // A patch of a wall, in the middle of it.
    let (wrong, energy) = check_text("cornell/cornell.txt", Some(40));
    println!("{wrong:?} {energy:?}");
    assert_eq!((wrong.odd, &*wrong.worst.unwrap().name), (1, "patch 40"));
    assert_eq!((energy.dead, energy.first_dead), (1, Some(40)));
}

#[test]
fn checks_follow_light_through_glass_curtains_and_lanterns() {
    for name in ["stained_glass", "curtain", "lantern"] {
        let file = format!("cornell/{name}.txt");
        let (right, energy) = check_text(&file, None);
        println!("{name}: {right:?} {energy:?}");
        assert_eq!(right.odd, 0, "{name}");
        assert!((right.bias - 1.0).abs() < 0.03, "{name}: {}", right.bias);
        assert!(right.at_most() < 0.2, "{name}: {}", right.at_most());
        assert!((energy.balance - 1.0).abs() < 0.06, "{name}: {}", energy.balance);
    }
}

fn check_map(name: &str, damage: bool) -> (Findings, Energy) {
    let bsp = Bsp::read(&std::fs::read(project_map(name)).unwrap()).unwrap();
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
    let bounced = bounce(&scene, &patches, &transfers, &arriving, &emission, limits, |_| {});
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
    let (findings, energy) = by_looks(|end| check_luxels(&run, end));
    (findings.unwrap(), energy.unwrap())
}

#[test]
fn zeroed_rows_of_a_map_are_reported() {
    let (right, energy) = check_map("cornell.bsp", false);
    println!("{right:?} {energy:?}");
    assert_eq!(right.odd, 0);
    assert!(right.at_most() < 0.06 && (right.bias - 1.0).abs() < 0.02);
    assert!((right.bias_by_rays - 1.0).abs() < 0.05);
    assert!((energy.balance - 1.0).abs() < 0.01);
    assert_eq!(energy.dead, 0);
    let (wrong, energy) = check_map("cornell.bsp", true);
    println!("{wrong:?} {energy:?}");
    assert!(energy.dead > 0 && energy.first_dead == Some(0));
    assert!(wrong.square > 3.0 * right.square && wrong.bias < 0.98, "the light that is missing");
}
