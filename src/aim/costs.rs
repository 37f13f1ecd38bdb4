//! What bounced light of a map takes, from samples of it.

use super::Rung;
use crate::patch::MapPatches;
use crate::radiosity::hemicube::{DeltaFormFactors, HemicubeSize, View};
use crate::radiosity::transfers::{Gatherer, OVERLAY_ENTRY, Transfers};
use crate::scene::{Sample, Scene};
use crate::settings::{Quality, coarse_luxels_do};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::time::Instant;

/// Sizes of patches and of hemicubes that are sampled.
const PATCH_SIZES: [u32; 3] = [2, 4, 8];
const CELLS: [u32; 3] = [16, 32, 64];
/// Hemicubes of each size that are timed.
const SAMPLED: usize = 96;
/// Patches beside each other that are timed together.
const NEIGHBOURS: usize = 4;
/// Interpolating a luxel takes this share of a hemicube of 16 cells.
const INTERPOLATED: f64 = 0.06;
/// A luxel's hemicube takes this times that of a patch, as it keeps no row.
const OF_LUXEL: f64 = 0.9;
/// So many cells and more tell luxel intervals apart from farther away, which takes...
const FINE: u32 = 32;
/// ...this times that of a patch.
const OF_LUXEL_FINE: f64 = 1.2;
/// The same where it has half as many cells along an edge.
const OF_LUXEL_HALVED: f64 = 0.55;
/// A small patch's hemicube takes this times that of another: half as many cells along an edge.
const OF_SMALL: f64 = 0.55;
/// Seconds of a pass of bounces for each form factor, on one thread.
const PASS: f64 = 1.5e-9;
/// Passes until light has settled, about.
const PASSES: f64 = 10.0;
/// Bytes of a form factor, with room for lists that grow.
const FACTOR_BYTES: f64 = 4.5;
/// Bytes of a luxel in all that is kept for it.
const LUXEL_BYTES: f64 = 220.0;

/// What samples tell.
#[derive(Clone, Debug)]
pub struct Costs {
    luxels: f64,
    /// By size.
    patches: BTreeMap<u32, Cut>,
    /// By cells: seconds of a hemicube with all threads at work, form factors in a row, and how many of
    /// them glass or patterns change.
    hemicubes: BTreeMap<u32, (f64, [f64; 2])>,
    /// Size of the patches of those rows.
    rows_of: f64,
    /// Bytes in use before.
    base: f64,
}

/// A map cut into patches.
#[derive(Clone, Copy, Debug, Default)]
struct Cut {
    patches: f64,
    /// Share of them that have rows of their own where sharing is allowed.
    own: f64,
    /// Share of them that are small.
    small: f64,
}

/// What a run is expected to take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// Seconds.
    pub seconds: f64,
    /// Bytes.
    pub memory: f64,
    /// Relative root mean square error of bounced light.
    pub error: f64,
}

impl Costs {
    /// Cuts patches and times some hemicubes.
    pub fn measure(scene: &Scene, luxels: &[Vec<Sample>]) -> Self {
        Self::sampled(scene, luxels, &PATCH_SIZES, &CELLS, SAMPLED)
    }

    /// The same for the roughest settings, at once.
    pub fn measure_rough(scene: &Scene, luxels: &[Vec<Sample>]) -> Self {
        let (largest, fewest) = (PATCH_SIZES[PATCH_SIZES.len() - 1], CELLS[0]);
        Self::sampled(scene, luxels, &[largest], &[fewest], SAMPLED / 2)
    }

    fn sampled(
        scene: &Scene,
        luxels: &[Vec<Sample>],
        patch_sizes: &[u32],
        cells: &[u32],
        sampled: usize,
    ) -> Self {
        let cut = |&size| (size, MapPatches::new(scene, luxels, size));
        let patches: Vec<(u32, MapPatches)> = patch_sizes.iter().map(cut).collect();
        let (finest_size, finest) = &patches[0];
        let count = finest.set.patches.len();
        let step = count.div_ceil(sampled).max(1);
        let time = |&cells: &u32| {
            let size = HemicubeSize::new(cells, cells).expect("even and in range");
            let delta = DeltaFormFactors::new(size);
            // In a run a hemicube finds in the cache what its neighbours left there.
            let chosen: Vec<usize> =
                (0..count).filter(|i| (i / NEIGHBOURS).is_multiple_of(step)).collect();
            let start = Instant::now();
            let lengths: Vec<[usize; 2]> = chosen
                .par_iter()
                .map_init(
                    || Gatherer::new(scene.bounce_tracer(), &finest.set, &delta, size),
                    |gatherer, &i| {
                        let patch = &finest.set.patches[i];
                        gatherer.look(&View::turned(patch.eye, patch.normal, i as u64));
                        [gatherer.row().len(), gatherer.overlay().len()]
                    },
                )
                .collect();
            let n = chosen.len().max(1) as f64;
            let mean = |k: usize| lengths.iter().map(|l| l[k]).sum::<usize>() as f64 / n;
            (cells, (start.elapsed().as_secs_f64() / n, [mean(0), mean(1)]))
        };
        Self {
            luxels: luxels.iter().flatten().filter(|s| !s.occluded).count() as f64,
            hemicubes: cells.iter().map(time).collect(),
            rows_of: f64::from(*finest_size),
            patches: patches.iter().map(|(size, cut)| (*size, Cut::of(scene, cut))).collect(),
            base: crate::memory::peak().unwrap_or(8 << 20) as f64,
        }
    }

    /// Patches, hemicubes at patches, and form factors.
    pub fn counts(&self, rung: &Rung) -> [f64; 3] {
        let Cut { patches, own, .. } = self.cut(rung);
        // Fewer patches are seen where they are larger.
        let larger = self.rows_of / f64::from(rung.patch_size);
        let row = self.of(rung.cells).1[0] * larger.powf(1.2);
        [patches, patches * own, patches * own * row]
    }

    /// The patches of a rung. Between sizes that were cut: as areas go.
    fn cut(&self, rung: &Rung) -> Cut {
        let size = rung.patch_size;
        let near = self.patches.iter().min_by_key(|(s, _)| s.abs_diff(size));
        let (near, cut) = near.map_or((1, Cut::default()), |(s, cut)| (*s, *cut));
        let patches = cut.patches * (f64::from(near) / f64::from(size)).powi(2);
        if rung.share > 0.0 {
            Cut { patches, ..cut }
        } else {
            Cut { patches, own: 1.0, small: 0.0 }
        }
    }

    /// Seconds of a hemicube, length of its row, and how much of that glass or patterns change.
    fn of(&self, cells: u32) -> (f64, [f64; 2]) {
        let (near, of) = self
            .hemicubes
            .iter()
            .min_by_key(|(c, _)| c.abs_diff(cells))
            .expect("some sizes are timed");
        let share = f64::from(cells) / f64::from(*near);
        (of.0 * share, of.1.map(|length| length * share.powf(0.7)))
    }

    /// Hemicubes at luxels.
    pub fn luxels(&self, rung: &Rung) -> f64 {
        self.luxels * rung.luxels
    }

    /// Seconds of bounced light.
    pub fn seconds(&self, rung: &Rung) -> f64 {
        let [_, hemicubes, factors] = self.counts(rung);
        let hemicube = self.of(rung.cells).0;
        let bounces = factors * PASSES * PASS / rayon::current_num_threads() as f64;
        let halved = rung.share > 0.0 && coarse_luxels_do(rung.gather_error);
        let of_luxel = match () {
            () if halved => OF_LUXEL_HALVED,
            () if rung.cells >= FINE => OF_LUXEL_FINE,
            () => OF_LUXEL,
        };
        let interpolated =
            if rung.gather_error == 0.0 { 0.0 } else { INTERPOLATED * self.of(16).0 };
        let Cut { small, .. } = self.cut(rung);
        hemicubes * hemicube * (1.0 - small * (1.0 - OF_SMALL))
            + bounces
            + self.luxels * (rung.luxels * hemicube * of_luxel + interpolated)
    }

    /// All of bounced light.
    pub fn predict(&self, rung: &Rung) -> Predicted {
        let [patches, _, factors] = self.counts(rung);
        let [length, changed] = self.of(rung.cells).1;
        let factor = FACTOR_BYTES + OVERLAY_ENTRY as f64 * changed / length.max(1.0);
        let memory = self.base + factors * factor + patches * 300.0 + self.luxels * LUXEL_BYTES;
        Predicted { seconds: self.seconds(rung), memory, error: rung.error }
    }
}

impl Cut {
    fn of(scene: &Scene, patches: &MapPatches) -> Self {
        let (tracer, set) = (scene.bounce_tracer(), &patches.set);
        let share = Quality::default().share();
        let small = patches.small().into_iter().filter(|&small| small).count();
        Self {
            patches: set.patches.len() as f64,
            own: Transfers::expected_rows(tracer, set, &patches.groups(), share),
            small: small as f64 / set.patches.len().max(1) as f64,
        }
    }
}
