//! The item buffer against one ray a cell, on the same hemicubes: `cargo bench --bench hemicube`.
//!
//! After divan's own table a second one gives the ratio, each pair of timings taken back to back.
//! Larger maps are added from the folder `QRAD_SHARED` (../shared by default) when it is present.

#[path = "../tests/support/views.rs"]
mod views;

use divan::Bencher;
use qrad::radiosity::hemicube::{HemicubeSize, ItemBuffer, View};
use qrad::radiosity::per_ray;
use qrad::scene::Tracer;
use std::hint::black_box;
use std::path::PathBuf;
use std::time::Instant;

const SIZES: [u32; 4] = [32, 64, 128, 256];

fn maps() -> Vec<PathBuf> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let mut maps = vec![root.join("maps/atrium.bsp")];
    let shared = std::env::var_os("QRAD_SHARED").map_or_else(|| root.join("../shared"), Into::into);
    for name in ["lqdm2", "lq_e0m1", "lq_e2m3", "lq_e4m4"] {
        maps.push(shared.join(format!("maps/librequake/{name}.bsp")));
    }
    maps.retain(|m| m.exists());
    maps
}

fn atrium() -> (Tracer, Vec<View>) {
    views::bsp_views(&maps()[0], 100)
}

#[divan::bench(args = SIZES)]
fn item_buffer(bencher: Bencher<'_, '_>, cells: u32) {
    let (tracer, views) = atrium();
    let mut buffer = ItemBuffer::new(HemicubeSize::new(cells, cells).unwrap());
    let mut views = views.iter().cycle();
    bencher.bench_local(|| buffer.draw(&tracer, views.next().unwrap()));
}

#[divan::bench(args = SIZES)]
fn one_ray_a_cell(bencher: Bencher<'_, '_>, cells: u32) {
    let (tracer, views) = atrium();
    let size = HemicubeSize::new(cells, cells).unwrap();
    let mut views = views.iter().cycle();
    bencher.bench_local(|| per_ray::trace(&tracer, views.next().unwrap(), size));
}

/// Seconds that `work` takes, once.
fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    divan::main();
    println!("\nmap            cells   item buffer   one ray a cell   times faster");
    for map in maps() {
        let (tracer, views) = views::bsp_views(&map, 30);
        for cells in SIZES {
            let size = HemicubeSize::new(cells, cells).unwrap();
            let mut buffer = ItemBuffer::new(size);
            let pairs: Vec<(f64, f64)> = views
                .iter()
                .map(|view| {
                    buffer.draw(&tracer, view);
                    let fast = seconds(|| (0..8).for_each(|_| buffer.draw(&tracer, view))) / 8.0;
                    let slow = seconds(|| drop(black_box(per_ray::trace(&tracer, view, size))));
                    (fast, slow)
                })
                .collect();
            let sum = |f: fn(&(f64, f64)) -> f64| pairs.iter().map(f).sum::<f64>();
            let mean = 1e6 / pairs.len() as f64;
            println!(
                "{:14} {cells:5} {:10.0} us {:13.0} us {:8.1} (median of pairs {:.1})",
                map.file_stem().unwrap().to_string_lossy(),
                sum(|p| p.0) * mean,
                sum(|p| p.1) * mean,
                sum(|p| p.1) / sum(|p| p.0),
                median(pairs.iter().map(|p| p.1 / p.0).collect()),
            );
        }
    }
}
