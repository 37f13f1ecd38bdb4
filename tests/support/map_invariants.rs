//! What holds for every map, whatever its shape: checked on what a run makes.

use super::lit_map::Prepared;
use super::map_energy::MapSums;
use glam::Vec3;
use qrad::bsp::{Bsp, write_entities};
use qrad::lightmap::Gather;
use qrad::progress::Progress;
use qrad::radiosity::hemicube::HemicubeSize;
use qrad::scene::Sidecar;
use qrad::settings::Settings;
use qrad::{MapLight, light_bsp};

/// Row sums are exact but for sums of weights in single precision.
const ROW_SUM: f64 = 1e-4;

/// Rounding of exitances to single precision, relative to the largest.
const SINGLE: f64 = 1e-6;
/// What is known about a map.
#[derive(Clone, Copy, Debug)]
pub struct Expect {
    /// Every patch sees lit faces wherever it looks.
    pub closed: bool,
    /// Some lights subtract: light may be below zero.
    pub negative: bool,
    /// How far absorbed and escaped light may be off, as share of the first reflected light.
    pub energy: f64,
    /// The same for reciprocity between planes.
    pub asymmetry: f64,
    /// Patches share no rows where energy and reciprocity are summed up.
    pub own_rows: bool,
}

impl Expect {
    pub const OPEN: Self =
        Self { closed: false, negative: false, energy: 0.02, asymmetry: 0.02, own_rows: false };
    pub const CLOSED: Self = Self { closed: true, ..Self::OPEN };
}

/// Settings that light a small map in a moment.
pub fn quick() -> Settings {
    let hemicube = HemicubeSize::new(32, 32).unwrap();
    Settings { hemicube, ..Settings::default() }
}

/// Lights a map, with `threads` threads.
pub fn lit(map: &Bsp, settings: &Settings, threads: usize) -> (MapLight, Bsp) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let mut bsp = map.clone();
    let progress = Progress::new(false);
    let light = pool.install(|| {
        light_bsp(&mut bsp, Sidecar::default(), Vec::new(), settings, &progress).unwrap()
    });
    (light, bsp)
}

/// Checks everything and returns the light: finite, not negative, the same bytes at any number of
/// threads, a file that reads back, row sums, the residual, more light from more emission.
#[track_caller]
pub fn hold(case: &str, map: &Bsp, expect: Expect) -> MapLight {
    let settings = quick();
    let (light, bsp) = lit(map, &settings, 1);
    let file = bsp.write().unwrap();
    assert!(Bsp::read(&file).unwrap().write().unwrap() == file, "{case}: it reads back");
    let (other, again) = lit(map, &settings, 3);
    assert!(
        again.write().unwrap() == file && other.files.lit == light.files.lit,
        "{case}: threads count"
    );

    for (index, face) in light.faces.iter().enumerate() {
        for style in &face.styles {
            for (i, l) in style.light.iter().enumerate() {
                assert!(l.is_finite(), "{case}: face {index}, luxel {i} has {l}");
                let least = if expect.negative { f32::MIN } else { 0.0 };
                assert!(l.min_element() >= least, "{case}: face {index}, luxel {i} has {l}");
            }
        }
    }
    let residual = light.counts.residual;
    assert!(residual <= settings.residual, "{case}: the residual is {residual}");
    check_rows(case, map, expect, settings.clone());
    if !expect.negative {
        check_monotone(case, map, &light, &settings);
    }
    light
}

#[track_caller]
fn check_rows(case: &str, map: &Bsp, expect: Expect, settings: Settings) {
    let share = if expect.own_rows { 0.0 } else { settings.share };
    let prepared = Prepared::new(map, Settings { share, ..settings }, false);
    let transfers = &prepared.transfers;
    let mut low = f64::INFINITY;
    for i in 0..transfers.rows() {
        let factors = transfers.row(i).1;
        assert!(factors.iter().all(|f| f.is_finite() && *f >= 0.0), "{case}: row {i}");
        let sum: f64 = factors.iter().map(|&f| f64::from(f)).sum();
        assert!(sum <= 1.0 + ROW_SUM, "{case}: row {i} sums to {sum}");
        low = low.min(sum);
    }
    println!("{case}: {} patches, row sums from {low:.5}", transfers.rows());
    assert!(!expect.closed || low >= 1.0 - ROW_SUM, "{case}: closed, a row sums to {low}");
    if !expect.negative {
        let lit = prepared.light(Gather::Interpolate);
        let sums = MapSums::new(&prepared, &lit);
        println!("{case}: {sums:?}");
        let left = lit.bounced.residual + SINGLE;
        assert!(sums.residual <= left, "{case}: one more pass adds {}", sums.residual);
        assert!(
            sums.asymmetry <= expect.asymmetry,
            "{case}: reciprocity is off by {}",
            sums.asymmetry
        );
        assert!(sums.imbalance <= expect.energy, "{case}: energy is off by {}", sums.imbalance);
    }
}

/// Every light is a tenth brighter: no luxel has less.
#[track_caller]
fn check_monotone(case: &str, map: &Bsp, light: &MapLight, settings: &Settings) {
    let mut entities = qrad::bsp::parse_entities(&map.entities).unwrap();
    for entity in &mut entities {
        if entity.classname().starts_with("light")
            && let Some(level) = entity.get("light").and_then(|l| l.parse::<f64>().ok())
        {
            entity.set("light", (level * 1.1).to_string());
        }
    }
    let mut brighter = map.clone();
    brighter.entities = write_entities(&entities);
    let (more, _) = lit(&brighter, settings, 2);
    let styles = |l: &MapLight| -> Vec<(usize, u16, Vec<Vec3>)> {
        let faces = l.faces.iter().enumerate();
        faces
            .flat_map(|(f, face)| face.styles.iter().map(move |s| (f, s.style, s.light.clone())))
            .collect()
    };
    let most =
        styles(light).iter().flat_map(|s| s.2.clone()).map(Vec3::max_element).fold(0.0, f32::max);
    for (face, style, before) in styles(light) {
        let found = more.faces[face].styles.iter().find(|s| s.style == style);
        let after =
            &found.unwrap_or_else(|| panic!("{case}: face {face} loses style {style}")).light;
        for (a, b) in after.iter().zip(&before) {
            let ends = Vec3::splat(most * 1e-4 + 1e-3);
            assert!(a.cmpge(*b - ends).all(), "{case}: face {face} falls from {b} to {a}");
        }
    }
}
