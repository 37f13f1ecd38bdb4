//! Light for a time, by clocks that jump: how much is done follows from the clock alone, so that no test
//! depends on the speed of the machine.

mod support;

use qrad::aim::{Aim, Ladder};
use qrad::bsp::Bsp;
use qrad::light::{InTime, Receivers, direct_from, direct_in_time};
use qrad::lightmap::FinishedFace;
use qrad::progress::Progress;
use qrad::scene::{LuxelGrid, Sample, Scene, SceneSettings, Sidecar, luxels};
use qrad::settings::Settings;
use qrad::{MapLight, light_bsp, light_bsp_in_steps};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

const LATE: Duration = Duration::from_secs(1_000_000);

/// A clock that stands at 0 for some looks at it and then is late, and the number of looks.
fn jumping(looks: u64) -> (Progress, Arc<AtomicU64>) {
    let seen = Arc::new(AtomicU64::new(0));
    let count = Arc::clone(&seen);
    let clock = move || {
        if count.fetch_add(1, Ordering::Relaxed) < looks { Duration::ZERO } else { LATE }
    };
    (Progress::with_clock(false, Box::new(clock)), seen)
}

fn bsp(name: &str) -> Bsp {
    Bsp::read(&std::fs::read(support::maps_dir().join(name)).unwrap()).unwrap()
}

/// Direct light of a map until the clock jumps after so many looks.
fn direct(scene: &Scene, samples: &[Vec<Sample>], looks: u64) -> InTime {
    let (progress, _) = jumping(looks);
    let to = Receivers { scene, samples, extra: 1, directions: true };
    direct_in_time(to, progress.deadline(Duration::from_secs(1)))
}

/// Sum of the squares of what light lacks of `whole`, over the squares of that.
fn error(found: &InTime, whole: &InTime) -> f64 {
    let level = |light: &qrad::light::DirectLight, i: usize| -> f64 {
        light.styles.iter().map(|s| f64::from(s.irradiance[i].0.element_sum())).sum()
    };
    let (mut off, mut all) = (0.0, 0.0);
    for (found, whole) in found.light.iter().zip(&whole.light) {
        let count = whole.styles.first().map_or(0, |s| s.irradiance.len());
        for i in 0..count {
            off += (level(found, i) - level(whole, i)).powi(2);
            all += level(whole, i).powi(2);
        }
    }
    off / all
}

#[test]
fn direct_light_stops_at_any_piece_and_is_whole_with_enough_time() {
    let scene =
        Scene::build(&bsp("styles.bsp"), Sidecar::default(), &SceneSettings::default()).unwrap();
    let samples: Vec<_> = (0..scene.surfaces.len()).map(|f| luxels::place(&scene, f, 1)).collect();
    let whole = direct(&scene, &samples, u64::MAX);
    assert_eq!((whole.whole, whole.dark, whole.text()), (whole.surfaces, 0, None));
    for (face, samples) in samples.iter().enumerate() {
        let mut blockers = qrad::light::Blockers::new(&scene);
        let expected =
            direct_from(&scene, face, samples, qrad::light::Directions::wanted(), &mut blockers);
        assert!(whole.light[face] == expected, "face {face}");
    }
    let (mut last, mut reached) = (0, f64::INFINITY);
    for looks in [0, 1, 2, 5, 20, 60, 100, 150, 200, 300, 500] {
        let found = direct(&scene, &samples, looks);
        // No piece of work is begun without a look at the clock that finds time left.
        assert!(found.pieces as u64 <= looks, "{} pieces, {looks} looks", found.pieces);
        assert!(found.pieces >= last, "more looks, less work");
        assert_eq!(found.text().is_none(), found.whole == found.surfaces);
        for (light, samples) in found.light.iter().zip(&samples) {
            let lists = light.styles.iter().chain(&light.negative).chain(&light.excess);
            assert!(lists.into_iter().all(|s| s.irradiance.len() == samples.len()));
            assert!(light.directions.styles().iter().all(|d| d.vectors.len() == samples.len()));
        }
        let error = error(&found, &whole);
        println!("{looks} looks, {} pieces: error {:.4}", found.pieces, error.sqrt());
        if found.dark == 0 {
            assert!(error.sqrt() < 0.7, "some light is better than none");
        }
        (last, reached) = (found.pieces, error);
    }
    assert!(reached < 0.1, "{reached}");
}

/// Enough time for all that the clock lets happen, and rough settings, which end soon.
fn settings() -> Settings {
    let ladder = Ladder::default().down_to(0.04);
    Settings { aim: Aim::Time(1000.0), ladder, ..Settings::default() }
}

fn light_whole() -> MapLight {
    let (sidecar, progress) = (Sidecar::default(), Progress::new(false));
    let mut map = bsp("styles.bsp");
    light_bsp(&mut map, sidecar, Vec::new(), &Settings::default(), &progress).unwrap()
}

/// Whether there is light of any style at each luxel.
fn lit_luxels(lit: &MapLight) -> Vec<bool> {
    let luxels = lit.scene.surfaces.iter().map(|s| s.luxels.as_ref().map_or(0, LuxelGrid::len));
    let faces = lit.faces.iter().zip(luxels);
    let bright = |face: &FinishedFace, i: usize| {
        face.styles.iter().any(|style| style.levels[i].iter().any(|&level| level > 3))
    };
    faces.flat_map(|(face, luxels)| (0..luxels).map(move |i| bright(face, i))).collect()
}

#[test]
fn maps_are_whole_whenever_time_is_over() {
    let mut luxels_drawn = Vec::new();
    let whole = lit_luxels(&light_whole());
    for looks in [0, 3, 120, 400, 440, 480, 520, 560, 600, 650, 2000] {
        let (progress, seen) = jumping(looks);
        let (mut map, unlit) = (bsp("styles.bsp"), bsp("styles.bsp"));
        let lit: MapLight =
            light_bsp(&mut map, Sidecar::default(), Vec::new(), &settings(), &progress).unwrap();
        let faces = |bsp: &Bsp| bsp.faces.len();
        let again = Bsp::read(&map.write().unwrap()).unwrap();
        assert_eq!(faces(&again), faces(&unlit));
        assert!(!again.lighting.is_empty(), "{looks} looks: a map without light");
        println!("{looks} of {} looks: {:?}", seen.load(Ordering::Relaxed), lit.choices);
        let [patches, luxels] = lit.counts.hemicubes;
        let lit_now = lit_luxels(&lit);
        assert!(lit_now.len() == whole.len());
        if !lit.choices.iter().any(|s| s.contains("direct light")) {
            let dark = whole.iter().zip(&lit_now).filter(|(whole, now)| **whole && !**now).count();
            assert!(dark * 50 < whole.len(), "{looks} looks: {dark} of {} dark", whole.len());
        }
        if progress.elapsed() > Duration::ZERO && patches + luxels == 0 {
            assert!(lit.choices.iter().any(|s| s.contains("too few")), "{:?}", lit.choices);
        }
        luxels_drawn.push(patches + luxels);
    }
    assert_eq!(luxels_drawn[0], 0, "nothing is drawn when it is late");
    assert!(luxels_drawn.is_sorted(), "{luxels_drawn:?}");
}

#[test]
fn rough_light_is_kept_on_the_way_if_that_is_wanted() {
    let kept = |keep_partial| {
        let (progress, _) = jumping(u64::MAX);
        let settings = Settings { keep_partial, ..settings() };
        let mut count = 0;
        let mut keep = |bsp: &Bsp, _: &qrad::Files| {
            assert!(Bsp::read(&bsp.write().unwrap()).is_ok_and(|b| !b.lighting.is_empty()));
            count += 1;
        };
        let (sidecar, none) = (Sidecar::default(), Vec::new());
        let mut map = bsp("styles.bsp");
        light_bsp_in_steps(&mut map, sidecar, none, &settings, &progress, &mut keep).unwrap();
        count
    };
    assert_eq!(kept(false), 0);
    assert!(kept(true) >= 2);
}
