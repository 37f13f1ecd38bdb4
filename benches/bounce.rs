//! The stages of bounced light at default quality, each on the same maps: `cargo bench --bench bounce`.
//!
//! Groups: `transfers` (every patch), `solve` (all styles, until settled), `gather` (every luxel) and
//! `whole_map` (everything, and direct light alone). Larger maps are added from the folder `QRAD_SHARED`
//! (../shared by default) when it is present. Threads are as `RAYON_NUM_THREADS` says.

#[allow(dead_code)] // Tests use the rest of it.
#[path = "../tests/support/lit_map.rs"]
mod lit_map;

use divan::Bencher;
use lit_map::Prepared;
use qrad::bsp::Bsp;
use qrad::light_bsp;
use qrad::lightmap::Gather;
use qrad::progress::Progress;
use qrad::scene::Sidecar;
use qrad::settings::Settings;
use std::path::PathBuf;

/// Samples of what takes seconds.
const FEW: u32 = 5;

fn maps_dir() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("maps")
}

fn maps() -> Vec<&'static str> {
    let all = ["atrium", "cornell", "start", "lqdm2"];
    all.into_iter().filter(|name| path(name).exists()).collect()
}

fn path(name: &str) -> PathBuf {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let shared = std::env::var_os("QRAD_SHARED").map_or_else(|| root.join("../shared"), Into::into);
    let own = maps_dir().join(format!("{name}.bsp"));
    if own.exists() { own } else { shared.join(format!("maps/librequake/{name}.bsp")) }
}

fn read(name: &str) -> Bsp {
    Bsp::read(&std::fs::read(path(name)).unwrap()).unwrap()
}

fn prepared(name: &str) -> Prepared {
    Prepared::new(&read(name), Settings::default(), false)
}

mod transfers {
    use super::*;
    use qrad::radiosity::transfers::{Sharing, Transfers};

    #[divan::bench(args = maps(), sample_count = FEW)]
    fn shared(bencher: Bencher<'_, '_>, name: &str) {
        let map = prepared(name);
        let set = &map.patches.set;
        let (groups, small) = (map.patches.groups(), map.patches.small());
        let share = map.settings.share;
        let sharing = Sharing { groups: &groups, share, small: &small };
        let (tracer, size) = (map.scene.bounce_tracer(), map.settings.hemicube);
        bencher.bench_local(|| Transfers::shared(tracer, set, sharing, size, |_| {}).len());
    }

    #[divan::bench(args = maps(), sample_count = FEW)]
    fn one_a_patch(bencher: Bencher<'_, '_>, name: &str) {
        let map = prepared(name);
        let (tracer, size) = (map.scene.bounce_tracer(), map.settings.hemicube);
        bencher.bench_local(|| Transfers::compute(tracer, &map.patches.set, size, |_| {}).len());
    }
}

mod solve {
    use super::*;
    use qrad::patch::{Quad, TextPatches, TextScene};
    use qrad::photometry::Reflectance;
    use qrad::radiosity::channels::Channels;
    use qrad::radiosity::hemicube::HemicubeSize;
    use qrad::radiosity::solve::{Limits, Solution, Sources, Surfaces, solve_styles};
    use qrad::radiosity::transfers::Transfers;
    use std::time::Instant;

    /// Each pass takes as long as another.
    const PASSES: u32 = 4;
    /// Pairs of runs whose times are compared.
    const PAIRS: usize = 7;

    #[divan::bench(args = maps(), sample_count = FEW)]
    fn until_settled(bencher: Bencher<'_, '_>, name: &str) {
        let map = prepared(name);
        let direct = map.direct();
        bencher.bench_local(|| map.bounce(&direct).passes);
    }

    /// A box without colour, ready to be solved.
    struct GreyBox {
        patches: TextPatches,
        reflectance: Vec<Reflectance>,
        transfers: Transfers,
    }

    impl GreyBox {
        fn new() -> Self {
            let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
            let shared =
                std::env::var_os("QRAD_SHARED").map_or_else(|| root.join("../shared"), Into::into);
            let large = shared.join("scenes/cornell_8000.txt");
            let own = maps_dir().join("cornell/cornell_fine.txt");
            let text = std::fs::read_to_string(&large).or_else(|_| std::fs::read_to_string(own));
            let mut scene = TextScene::parse(&text.unwrap(), "scene").unwrap();
            let grey = |c: &mut [f64; 3]| *c = [c.iter().sum::<f64>() / 3.0; 3];
            for Quad { exitance, reflectance, .. } in &mut scene.patches {
                grey(exitance);
                grey(reflectance);
            }
            let size = HemicubeSize::new(scene.hemicube[0], scene.hemicube[1]).unwrap();
            let patches = TextPatches::new(&scene);
            let transfers = Transfers::compute(&patches.tracer, &patches.set, size, |_| {});
            println!("  {} patches, {} form factors", transfers.rows(), transfers.len());
            Self { reflectance: patches.reflectance(), patches, transfers }
        }

        /// The same light in so many styles.
        fn solve(&self, channels: Channels, styles: usize) -> Vec<Solution> {
            let Self { patches, reflectance, transfers } = self;
            let surfaces = Surfaces { transfers, reflectance, passages: &[] };
            let sources = vec![Sources { emission: &patches.emission, direct: &[] }; styles];
            let limits = Limits { passes: Some(PASSES), residual: 1e-9 };
            solve_styles(surfaces, &sources, limits, channels)
        }
    }

    /// Median of how many times longer `slow` takes than `fast`, in turns.
    fn ratio(fast: impl Fn(), slow: impl Fn()) -> f64 {
        let time = |run: &dyn Fn()| {
            let start = Instant::now();
            run();
            start.elapsed().as_secs_f64()
        };
        let mut ratios: Vec<f64> = (0..PAIRS).map(|_| time(&slow) / time(&fast)).collect();
        ratios.sort_by(f64::total_cmp);
        ratios[PAIRS / 2]
    }

    /// Three channels over one, and four styles one by one over together.
    #[divan::bench(sample_count = 1, sample_size = 1)]
    fn ratios_in_a_box_without_colour() {
        let grey = GreyBox::new();
        let run = |channels| drop(divan::black_box(grey.solve(channels, 1)));
        let three = ratio(|| run(Channels::One), || run(Channels::Three));
        println!("  three channels take {three:.2} times as long as one");
        for channels in [Channels::One, Channels::Three] {
            let each = || (0..4).for_each(|_| run(channels));
            let together = || drop(divan::black_box(grey.solve(channels, 4)));
            let ratio = ratio(together, each);
            println!("  {channels:?}: one by one takes {ratio:.2} times as long as together");
        }
    }
}

mod gather {
    use super::*;

    #[divan::bench(args = maps(), sample_count = FEW)]
    fn interpolated(bencher: Bencher<'_, '_>, name: &str) {
        let map = prepared(name);
        let bounced = map.bounce(&map.direct());
        bencher.bench_local(|| map.gather(&bounced, Gather::Interpolate).len());
    }
}

mod whole_map {
    use super::*;

    fn light(name: &str, bounces: Option<u32>) -> usize {
        let settings = Settings { bounces, ..Settings::default() };
        let mut bsp = read(name);
        let quiet = Progress::new(false);
        let lit = light_bsp(&mut bsp, Sidecar::default(), Vec::new(), &settings, &quiet);
        lit.unwrap().faces.len()
    }

    #[divan::bench(args = maps(), sample_count = FEW)]
    fn bounced(name: &str) -> usize {
        light(name, None)
    }

    #[divan::bench(args = maps(), sample_count = FEW)]
    fn direct_only(name: &str) -> usize {
        light(name, Some(0))
    }
}

fn main() {
    divan::main();
}
