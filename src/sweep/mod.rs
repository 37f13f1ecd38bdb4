//! Sweeps: one map or scene at many settings, what each costs and how far off it is.

mod bench;
mod frontier;
mod map_bench;
mod pages;
mod table;
mod text_bench;
mod truth;

pub use bench::{Bench, Knobs, Measured};
pub use frontier::{exponent, pareto};
pub use map_bench::MapBench;
pub use table::{Row, Table};
pub use text_bench::TextBench;
pub use truth::{MapTruth, TextTruth, map_truth, text_truth};

use crate::progress::Progress;
use crate::{Error, Result, output};
use std::collections::BTreeMap;
use std::path::Path;

/// What a sweep made.
pub struct Swept {
    /// All points that are known.
    pub table: Table,
    /// How many of them were measured now.
    pub measured: usize,
}

/// Measures what `folder` lacks of the points of `bench` and writes the table, the plots and the page.
/// The table is renewed after each point: an interrupted sweep goes on where it was. Points of other
/// builds of the program, and of other files, are forgotten.
///
/// # Errors
/// When a file cannot be read or written, or the map cannot be lit.
pub fn sweep(folder: &Path, bench: &mut dyn Bench, progress: &Progress) -> Result<Swept> {
    std::fs::create_dir_all(folder).map_err(Error::io("make folder", folder))?;
    let path = folder.join("sweep.csv");
    let mut table = Table::read(&path)?;
    let identity = bench.identity();
    let key = |knobs: &Knobs| knobs.key(identity);
    let all = bench.points();
    // What other builds found says nothing of this one.
    table.retain(&all.iter().map(key).collect::<Vec<_>>());
    let pictures = folder.join("lightmaps");
    let reference = Reference { path: folder.join("finest.f32") };
    let mut truth = bench.truth();
    let finest = all.last().cloned().unwrap_or_default();
    let has_truth = truth.is_some();
    if truth.is_none() {
        truth = reference.read(key(&finest));
    }
    let lacks = |table: &Table, knobs: &Knobs| {
        let picture = knobs.picture && !pictures.join(format!("{:016x}.png", key(knobs))).exists();
        picture || table.row(key(knobs)).is_none()
    };
    let mut wanted: Vec<&Knobs> = all.iter().filter(|k| lacks(&table, k)).collect();
    if truth.is_none() {
        // The others are measured against the finest.
        wanted.retain(|k| key(k) != key(&finest));
        wanted.insert(0, &finest);
    }
    let stage = progress.stage("sweep", wanted.len());
    let count = wanted.len();
    for knobs in wanted {
        let measured = bench.measure(knobs)?;
        let truth = truth.get_or_insert_with(|| {
            reference.write(key(&finest), &measured.values);
            measured.values.clone()
        });
        let [error, worst] = bench.errors(&measured.values, truth);
        let against = if has_truth { "truth" } else { "finest" };
        table.insert(key(knobs), Row::new(knobs, &measured, [error, worst], against));
        output::write(&path, table.text().as_bytes())?;
        if let Some(picture) = measured.picture.filter(|_| knobs.picture) {
            std::fs::create_dir_all(&pictures).map_err(Error::io("make folder", &pictures))?;
            output::write_png(&pictures.join(format!("{:016x}.png", key(knobs))), &picture)?;
        }
        stage.advance(1);
    }
    drop(stage);
    let shown: Vec<(Knobs, Row)> =
        all.iter().filter_map(|k| Some((k.clone(), table.row(key(k))?.clone()))).collect();
    let mut kept = BTreeMap::new();
    for knobs in all.iter().filter(|k| k.picture) {
        let path = pictures.join(format!("{:016x}.png", key(knobs)));
        if let Ok(picture) = image::open(&path) {
            kept.insert(knobs.name.clone(), picture.to_rgb8());
        }
    }
    pages::write(folder, &bench.title(), &shown, &kept)?;
    Ok(Swept { table, measured: count })
}

/// Light of the finest settings, kept for the next time: its key, then one number a point.
struct Reference {
    path: std::path::PathBuf,
}

impl Reference {
    fn read(&self, key: u64) -> Option<Vec<f32>> {
        let bytes = std::fs::read(&self.path).ok()?;
        let values = bytes.strip_prefix(&key.to_le_bytes())?;
        let number = |b: &[u8]| f32::from_le_bytes(b.try_into().expect("four bytes"));
        (values.len() % 4 == 0).then(|| values.chunks_exact(4).map(number).collect())
    }

    fn write(&self, key: u64, values: &[f32]) {
        let mut bytes = key.to_le_bytes().to_vec();
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        if let Err(error) = output::write(&self.path, &bytes) {
            log::warn!("{error}; the finest settings will be measured again next time");
        }
    }
}
