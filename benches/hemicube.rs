//! The item buffer against one ray a cell, on the same hemicubes: `cargo bench --bench hemicube`.
//!
//! After divan's own table a second one gives the ratio, medians of rounds of both
//! (seconds of the processor, where the system tells), and how many cells are the same.
//! Larger maps are added from the folder `QRAD_SHARED` (../shared by default) when it is present.

#[path = "../tests/support/views.rs"]
mod views;

use divan::Bencher;
use qrad::radiosity::hemicube::{Cells, HemicubeSize, ItemBuffer, SIDES, SideId, View};
use qrad::radiosity::per_ray;
use qrad::scene::Tracer;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;

const SIZES: [u32; 4] = [16, 32, 64, 256];
/// Timings of each.
const ROUNDS: usize = 3;
/// How often the faster way draws in a round, to be timed at all.
const DRAWS: usize = 16;

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

/// As maps are drawn, whose faces have solid space behind them.
fn on_solid(map: &Path, count: usize) -> (Tracer, Vec<View>) {
    let (tracer, views) = views::bsp_views(map, count);
    let polygons = tracer.polygons().len();
    (tracer.on_solid(polygons), views)
}

fn atrium() -> (Tracer, Vec<View>) {
    on_solid(&maps()[0], 100)
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

/// Seconds of the processor so far where the system tells, of the clock elsewhere.
fn now(start: Instant) -> f64 {
    let told = std::fs::read_to_string("/proc/self/schedstat").ok();
    let nanoseconds = told.and_then(|t| t.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| start.elapsed().as_secs_f64(), |n| 1e-9 * n)
}

/// Seconds that `work` takes, once.
fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    let before = now(start);
    work();
    now(start) - before
}

/// How many cells show the same polygon in both.
fn same_cells(buffer: &ItemBuffer, traced: &[Option<u32>]) -> usize {
    let (size, mut traced) = (buffer.size(), traced.iter());
    let rows = |side| if side == SideId::Top { size.height() } else { size.height() / 2 };
    let cells = SIDES.into_iter().flat_map(|side| {
        (0..rows(side)).flat_map(move |y| (0..size.width()).map(move |x| (side, x, y)))
    });
    let shown = cells.map(|(side, x, y)| buffer.cell(side, x, y).0);
    shown.filter(|&i| *traced.next().unwrap() == (i != Cells::NOTHING).then_some(i)).count()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    divan::main();
    println!("\nmap            cells   item buffer   one ray a cell   times faster   same cells");
    for map in maps() {
        let (tracer, views) = on_solid(&map, 20);
        for cells in SIZES {
            let size = HemicubeSize::new(cells, cells).unwrap();
            let mut buffer = ItemBuffer::new(size);
            let same = |view| {
                buffer.draw(&tracer, view);
                same_cells(&buffer, &per_ray::trace(&tracer, view, size))
            };
            let same: usize = views.iter().map(same).sum();
            let rounds: Vec<[f64; 2]> = (0..ROUNDS)
                .map(|_| {
                    let many = (0..DRAWS).flat_map(|_| &views);
                    let fast = seconds(|| many.for_each(|view| buffer.draw(&tracer, view)));
                    let trace = |view| drop(black_box(per_ray::trace(&tracer, view, size)));
                    [fast / DRAWS as f64, seconds(|| views.iter().for_each(trace))]
                })
                .collect();
            let each = 1e6 / views.len() as f64;
            println!(
                "{:14} {cells:5} {:10.0} us {:13.0} us {:14.1} {:10.3} %",
                map.file_stem().unwrap().to_string_lossy(),
                median(rounds.iter().map(|r| r[0] * each).collect()),
                median(rounds.iter().map(|r| r[1] * each).collect()),
                median(rounds.iter().map(|r| r[1] / r[0]).collect()),
                100.0 * same as f64 / (views.len() * size.cells()) as f64,
            );
        }
    }
}
