//! Direct light of whole maps, with and without supersampling: `cargo bench --bench direct`.

use divan::Bencher;
use qrad::bsp::Bsp;
use qrad::light::{Blockers, Directions, direct_from};
use qrad::scene::{Sample, Scene, SceneSettings, Sidecar, luxels};
use std::path::PathBuf;

const MAPS: [&str; 3] = ["effects_all", "slit", "atrium"];

/// A map and the samples of its surfaces.
struct Map {
    scene: Scene,
    samples: Vec<Vec<Sample>>,
}

impl Map {
    fn read(name: &str, extra: u32, dirt: bool) -> Self {
        let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
        let bytes = std::fs::read(root.join(format!("maps/{name}.bsp"))).unwrap();
        let bsp = Bsp::read(&bytes).unwrap();
        let dirt = dirt.then(|| ("_dirt".to_owned(), "1".to_owned()));
        let settings =
            SceneSettings { overrides: dirt.into_iter().collect(), extra, ..Default::default() };
        let scene = Scene::build(&bsp, Sidecar::default(), &settings).unwrap();
        let faces = 0..scene.surfaces.len();
        let samples = faces.map(|face| luxels::place(&scene, face, extra)).collect();
        Self { scene, samples }
    }

    /// Lights all surfaces on one thread.
    fn light(&self) -> u64 {
        let mut blockers = Blockers::new(&self.scene);
        let lit = self.samples.iter().enumerate().map(|(face, samples)| {
            direct_from(&self.scene, face, samples, Directions::default(), &mut blockers).rays
        });
        lit.sum()
    }
}

#[divan::bench(args = MAPS, sample_count = 5)]
fn plain(bencher: Bencher<'_, '_>, map: &str) {
    let map = Map::read(map, 1, false);
    bencher.bench_local(|| map.light());
}

#[divan::bench(args = MAPS, sample_count = 5)]
fn with_dirt(bencher: Bencher<'_, '_>, map: &str) {
    let map = Map::read(map, 1, true);
    bencher.bench_local(|| map.light());
}

#[divan::bench(args = MAPS, sample_count = 3)]
fn supersampled(bencher: Bencher<'_, '_>, map: &str) {
    let map = Map::read(map, 4, false);
    bencher.bench_local(|| map.light());
}

fn main() {
    divan::main();
}
