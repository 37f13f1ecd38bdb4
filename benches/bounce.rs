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
    use qrad::radiosity::transfers::Transfers;

    #[divan::bench(args = maps(), sample_count = FEW)]
    fn shared(bencher: Bencher<'_, '_>, name: &str) {
        let map = prepared(name);
        let (set, leaders) = (&map.patches.set, map.patches.leaders());
        let sharing = (leaders.as_slice(), map.settings.share);
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

    #[divan::bench(args = maps(), sample_count = FEW)]
    fn until_settled(bencher: Bencher<'_, '_>, name: &str) {
        let map = prepared(name);
        let direct = map.direct();
        bencher.bench_local(|| map.bounce(&direct).bounces);
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
