//! Direct light of all surfaces for as long as there is time: first at few samples of each surface, with
//! the others interpolated, then at all samples, those surfaces first whose light varies most.

use super::lattice::Lattice;
use super::{Blockers, DirectLight, Directions, direct_from};
use crate::progress::Deadline;
use crate::scene::{Sample, Scene};
use rayon::prelude::*;
use std::ops::Range;
use std::time::Duration;

/// Luxels along the edge of blocks that are lit at one sample, pass by pass.
const BLOCKS: [u32; 2] = [8, 3];
/// Most samples that a thread lights between two looks at the clock.
const MOST_SAMPLES: usize = 2048;
/// Pieces of work for each thread that are begun together: in order of worth.
const BATCH: usize = 16;

/// Where direct light is wanted.
#[derive(Clone, Copy)]
pub struct Receivers<'a> {
    /// The map.
    pub scene: &'a Scene,
    /// The samples of each surface.
    pub samples: &'a [Vec<Sample>],
    /// Samples along an edge of a luxel.
    pub extra: u32,
    /// Whether it matters where light comes from.
    pub directions: bool,
}

/// Direct light, as far as there was time for it.
#[derive(Clone, Debug, Default)]
pub struct InTime {
    /// Light of each surface, at all of its samples.
    pub light: Vec<DirectLight>,
    /// Surfaces with samples.
    pub surfaces: usize,
    /// How many of them were lit at every sample.
    pub whole: usize,
    /// How many were not lit at all.
    pub dark: usize,
    /// Pieces of work that were done: surfaces, or some thousand samples of one.
    pub pieces: usize,
}

impl InTime {
    /// How far it got, if not to the end.
    pub fn text(&self) -> Option<String> {
        let Self { surfaces, whole, dark, .. } = self;
        let few = surfaces - whole - dark;
        let all = format!("direct light: {whole} faces at each luxel, {few} at some");
        let none = if *dark > 0 { format!(", {dark} not at all") } else { String::new() };
        (whole < surfaces).then_some(all + &none)
    }
}

/// Lights all samples until `deadline`, which is looked at before each piece of work. The time decides
/// how much is done and nothing else; with enough of it the light is that of [`direct_from`].
pub fn direct_in_time(to: Receivers<'_>, deadline: Deadline<'_>) -> InTime {
    let mut order: Vec<usize> =
        (0..to.samples.len()).filter(|&f| !to.samples[f].is_empty()).collect();
    let mut made = InTime {
        light: to.samples.iter().map(|_| to.none()).collect(),
        surfaces: order.len(),
        dark: order.len(),
        ..InTime::default()
    };
    let all: usize = to.samples.iter().map(Vec::len).sum();
    // Surfaces from all over the map.
    order.sort_by_key(|&f| (f as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let mut worth: Vec<Option<f32>> = vec![None; to.samples.len()];
    for block in BLOCKS {
        let begun = deadline.now();
        let lattice = |&f: &usize| Lattice::new(&to.samples[f], to.width(f), block * to.extra);
        let lattices: Vec<Lattice> = order.par_iter().map(lattice).collect();
        let few: Vec<(usize, Vec<Sample>)> =
            order.iter().zip(&lattices).map(|(&f, l)| (f, l.of(&to.samples[f]))).collect();
        made.pieces += to.light(&few, deadline, |n, found| {
            let (face, lattice) = (few[n].0, &lattices[n]);
            made.dark -= usize::from(worth[face].is_none());
            worth[face] = Some(lattice.variation(&found));
            made.light[face] = lattice.spread(&found, &to.samples[face]);
        });
        order.sort_by(|&a, &b| {
            let [a, b] = [a, b].map(|f| (worth[f].unwrap_or(0.0), f));
            b.0.total_cmp(&a.0).then(a.1.cmp(&b.1))
        });
        let taken = deadline.now().saturating_sub(begun).as_secs_f64();
        let lit: usize = few.iter().map(|f| f.1.len()).sum();
        let whole = taken * all as f64 / lit.max(1) as f64;
        if Duration::try_from_secs_f64(whole).is_ok_and(|whole| whole < deadline.left()) {
            break;
        }
    }
    let ranges: Vec<(usize, Range<usize>)> =
        order.iter().flat_map(|&f| to.ranges(f).map(move |r| (f, r))).collect();
    let mut left: Vec<usize> = (0..to.samples.len()).map(|f| to.ranges(f).count()).collect();
    for some in ranges.chunks(64 * BATCH) {
        let pieces: Vec<(usize, Vec<Sample>)> =
            some.iter().map(|(f, range)| (*f, to.samples[*f][range.clone()].to_vec())).collect();
        made.pieces += to.light(&pieces, deadline, |n, found| {
            let (face, range) = &some[n];
            let count = to.samples[*face].len();
            left[*face] -= 1;
            if left[*face] == 0 {
                made.whole += 1;
                made.dark -= usize::from(worth[*face].is_none());
            }
            if range.len() == count {
                made.light[*face] = found;
            } else {
                made.light[*face].put(range, &found, count);
            }
        });
    }
    made
}

impl Receivers<'_> {
    /// No light.
    fn none(&self) -> DirectLight {
        let directions = if self.directions { Directions::wanted() } else { Directions::default() };
        DirectLight { directions, ..DirectLight::default() }
    }

    /// Samples in a row of a surface.
    fn width(&self, face: usize) -> usize {
        let grid = self.scene.surfaces[face].luxels.as_ref();
        grid.map_or(1, |g| (g.width * self.extra) as usize)
    }

    /// The samples of a surface, in parts that are lit at once.
    fn ranges(&self, face: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        let count = self.samples[face].len();
        (0..count).step_by(MOST_SAMPLES).map(move |i| i..count.min(i + MOST_SAMPLES))
    }

    /// Lights pieces, each some samples of a surface, in their order until `deadline`, and tells `done`
    /// of each. Returns how many that were.
    fn light(
        &self,
        pieces: &[(usize, Vec<Sample>)],
        deadline: Deadline<'_>,
        mut done: impl FnMut(usize, DirectLight),
    ) -> usize {
        let mut count = 0;
        let batch = BATCH * rayon::current_num_threads();
        for (number, some) in pieces.chunks(batch).enumerate() {
            let lit: Vec<Option<DirectLight>> = some
                .par_iter()
                .map_init(
                    || Blockers::new(self.scene),
                    |blockers, (face, samples)| {
                        let Self { scene, .. } = *self;
                        let directions = self.none().directions;
                        (!deadline.passed())
                            .then(|| direct_from(scene, *face, samples, directions, blockers))
                    },
                )
                .collect();
            for (n, light) in lit.into_iter().enumerate() {
                if let Some(light) = light {
                    done(number * batch + n, light);
                    count += 1;
                }
            }
            if deadline.passed() {
                break;
            }
        }
        count
    }
}
