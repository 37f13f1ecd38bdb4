//! Checking maps: bounced light at luxels.

use super::corners::in_corner;
use super::lamps::Lamps;
use super::walk::{Bundle, Direct, Lit, Met, cosine, passages};
use super::{Again, Energy, Findings, Points, check};
use crate::light::StyleLight;
use crate::lightmap::Sources;
use crate::patch::{Emission, MapPatches, PatchGrid};
use crate::photometry::{Exitance, Irradiance};
use crate::progress::Deadline;
use crate::radiosity::hemicube::{DeltaFormFactors, HemicubeSize, View};
use crate::radiosity::transfers::Gatherer;
use crate::scene::Sample;
use crate::scene::random::SplitMix;
use glam::{DVec3, Vec3};
use std::borrow::Cow;

/// Distance of points from surfaces in world units.
const LIFT: f32 = 0.05;
/// Width of a luxel in world units, unless the map asks for another.
const LUXEL: f32 = 16.0;
/// Fewest cells along the edge of a hemicube. With 48 the standard error of as many luxels is the same: it
/// comes from how far errors are apart.
const CELLS: u32 = 32;
/// Most patches on a path of hemicubes.
const PATH: u32 = 8;

/// The luxels of a map that take bounced light.
pub struct MapLuxels<'a> {
    run: &'a Run<'a>,
    lit: &'a Lit<'a>,
    /// Surface and luxel.
    chosen: Vec<(u32, u32)>,
    /// Exitance of each patch and each glow, all styles added up.
    exitance: &'a [Vec3],
    /// Bounced irradiance of each patch, all styles added up.
    irradiance: Vec<Vec3>,
    delta: DeltaFormFactors,
    size: HemicubeSize,
}

impl MapLuxels<'_> {
    fn sample(&self, point: usize) -> (Vec3, Vec3) {
        let (surface, luxel) = self.chosen[point];
        let sample = &self.run.samples[surface as usize][luxel as usize];
        let flat = self.run.sources.scene.surfaces[surface as usize].normal;
        (sample.position, sample.normal.normalize_or(flat))
    }

    /// Irradiance at a point that a fresh hemicube finds in the solution.
    fn gather(&self, gatherer: &mut Gatherer<'_>, (at, normal): (Vec3, Vec3), seed: u64) -> Vec3 {
        let light = self.run.sources.light;
        // Cells beyond this depth are too wide to tell intervals apart.
        let reach = 0.5 * self.size.width() as f32 * LUXEL;
        let mut sum = Vec3::ZERO;
        gatherer.visit(&View::turned(at, normal, seed), reach, |patch, interval, f| {
            sum += self.exitance[patch.0 as usize] * f;
            let Some(interval) = interval else { return };
            for style in light {
                let surface = style.detail.get(interval.surface as usize);
                if let Some(more) = surface.and_then(|d| d.get(interval.number as usize)) {
                    sum += *more * f;
                }
            }
        });
        for &(patch, f) in gatherer.overlay() {
            sum += self.exitance[patch.0 as usize] * f.as_vec3();
        }
        sum
    }

    /// The same, and what the solution is wrong by along one path.
    fn gather_path(&self, gatherer: &mut Gatherer<'_>, point: usize, half: u64) -> Vec3 {
        let mut random = SplitMix((point as u64) << 1 | half);
        let (mut at, mut normal) = self.sample(point);
        let mut sum = self.gather(gatherer, (at, normal), random.next().to_bits());
        let mut share = Vec3::ONE;
        for met_so_far in 1..=PATH {
            if self.run.bounces.is_some_and(|n| met_so_far > n) {
                break;
            }
            let direction = cosine(normal, random.next() as f32, random.next() as f32);
            let meeting = self.lit.meet(at, direction, &mut random, |_, _| {});
            let Some((met, through)) = meeting else { break };
            let Some((met, sent)) = self.lit.side(met, &mut random) else { break };
            share *= through * sent;
            // Paths go on as likely as they still matter.
            let matters = (2.0 * share.max_element()).min(1.0);
            if random.next() as f32 >= matters {
                break;
            }
            share /= matters;
            let Some(luxel) = self.luxel_of(met.patch, random.next() as f32) else { break };
            (at, normal) = (luxel, self.lit.patches.patches[met.patch].normal);
            let anew = self.gather(gatherer, (at, normal), random.next().to_bits());
            sum += share * (anew - self.irradiance[met.patch]);
        }
        sum
    }

    /// Position of a luxel of a patch, as likely as it counts there.
    fn luxel_of(&self, patch: usize, u: f32) -> Option<Vec3> {
        let patches = self.run.sources.patches;
        let mut left = u;
        let luxels = &patches.luxels[patch];
        let found = luxels.iter().find(|(_, weight)| {
            left -= weight;
            left < 0.0
        });
        let (luxel, _) = found.or(luxels.last())?;
        Some(self.run.samples[patches.surface[patch] as usize][*luxel as usize].position)
    }
}

impl Points for MapLuxels<'_> {
    fn count(&self) -> usize {
        self.chosen.len()
    }

    fn counts(&self, point: usize) -> bool {
        let scene = self.run.sources.scene;
        let surface = &scene.surfaces[self.chosen[point].0 as usize];
        let (at, _) = self.sample(point);
        // Those of sheets have light of their other side, as the irradiance that looks the same.
        surface.diffuse.is_none()
            && !in_corner(scene.bounce_tracer(), at, surface.normal, surface.dist)
    }

    fn found(&self, point: usize) -> Vec3 {
        let (surface, luxel) = self.chosen[point];
        let styles = self.run.found[surface as usize].iter();
        styles.map(|s| s.irradiance[luxel as usize].0).sum()
    }

    fn name(&self, point: usize) -> String {
        let (surface, luxel) = self.chosen[point];
        let (at, _) = self.sample(point);
        format!("luxel {luxel} of face {surface} at {:.0} {:.0} {:.0}", at.x, at.y, at.z)
    }

    fn channels_count(&self) -> bool {
        false
    }

    fn by_paths(&self) -> bool {
        false
    }

    fn again(&self) -> Box<dyn FnMut(usize, u32) -> Again + '_> {
        let Sources { scene, patches, .. } = self.run.sources;
        let mut gatherer =
            Gatherer::new(scene.bounce_tracer(), &patches.set, &self.delta, self.size);
        Box::new(move |point, paths| {
            let seed = point as u64;
            let rays = self.lit.light(Bundle { seed, paths, starts: false }, |_| {
                let (at, normal) = self.sample(point);
                (at, normal, Vec3::ONE)
            });
            let mut half = |half| self.gather_path(&mut gatherer, point, half);
            Again { halves: [half(0), half(1)], rays }
        })
    }
}

/// Direct light between luxels.
struct Between<'a> {
    patches: &'a MapPatches,
    samples: &'a [Vec<Sample>],
    /// Sum of all styles at the luxels of each surface; empty where there is none.
    luxels: Vec<Vec<Irradiance>>,
    /// Mean of each patch.
    means: Vec<Irradiance>,
}

impl Direct for Between<'_> {
    fn at(&self, met: &Met) -> Vec3 {
        let surface = self.patches.surface[met.patch] as usize;
        let luxels = &self.luxels[surface];
        let Some(grid) = self.patches.grid(surface) else { return self.means[met.patch].0 };
        if luxels.is_empty() {
            return Vec3::ZERO;
        }
        let along = |row: glam::Vec4, intervals: usize| {
            let x = row.truncate().dot(met.position) + row.w;
            let first = (x as usize).min(intervals - 1);
            (first, (x - first as f32).clamp(0.0, 1.0))
        };
        let (column, s) = along(grid.s_row, grid.block_column.len());
        let (row, t) = along(grid.t_row, grid.block_row.len());
        let cell = usize::from(grid.block_row[row]) * grid.columns
            + usize::from(grid.block_column[column]);
        if grid.blocks[cell] == PatchGrid::DIVIDED {
            // The luxels around may be beyond the wall that divides it.
            return self.means[met.patch].0;
        }
        let width = grid.block_column.len() + 1;
        let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
        for (i, j, w) in [
            (0, 0, (1.0 - s) * (1.0 - t)),
            (1, 0, s * (1.0 - t)),
            (0, 1, (1.0 - s) * t),
            (1, 1, s * t),
        ] {
            let luxel = (row + j) * width + column + i;
            if !self.samples[surface][luxel].occluded {
                sum += luxels[luxel].0 * w;
                weights += w;
            }
        }
        if weights > 1e-3 { sum / weights } else { self.means[met.patch].0 }
    }
}

/// What of a run is checked.
#[derive(Clone, Copy)]
pub struct Run<'a> {
    /// The solution.
    pub sources: Sources<'a>,
    /// Luxels of each surface.
    pub samples: &'a [Vec<Sample>],
    /// Direct light that was bounced, for each surface.
    pub arriving: &'a [Cow<'a, [StyleLight]>],
    /// What patches gave off.
    pub emission: &'a [Emission],
    /// Bounced light found at luxels, for each surface.
    pub found: &'a [Vec<StyleLight>],
    /// Most bounces.
    pub bounces: Option<u32>,
    /// Cells of the run's hemicubes.
    pub hemicube: HemicubeSize,
}

/// Checks bounced light of a map, until `end`.
pub fn check_luxels(run: &Run<'_>, end: Deadline<'_>) -> (Option<Findings>, Option<Energy>) {
    let Sources { scene, patches, transfers, light } = run.sources;
    let passages = passages(&patches.set);
    let (count, columns) = (patches.set.patches.len(), patches.set.columns());
    let total = |each: &mut dyn Iterator<Item = &[Exitance]>| {
        let mut sum = vec![Vec3::ZERO; columns];
        for style in each {
            sum.iter_mut().zip(style).for_each(|(sum, m)| *sum += m.0);
        }
        sum
    };
    let exitance = total(&mut light.iter().map(|l| &l.exitance[..]));
    let sent: Vec<DVec3> = exitance.iter().map(|m| m.as_dvec3()).collect();
    let energy = Energy::new(&patches.set, transfers, &sent);
    let emission = total(&mut run.emission.iter().map(|e| &e.exitance[..]));
    let bouncing = total(&mut run.emission.iter().map(|e| &e.bouncing[..]));
    let luxels: Vec<Vec<Irradiance>> =
        run.arriving.iter().map(|styles| all_styles(styles)).collect();
    let slices: Vec<&[Irradiance]> = luxels.iter().map(|l| &l[..]).collect();
    let means = patches.mean_irradiance(&slices);
    let direct = Between { patches, samples: run.samples, luxels, means };
    let lit = Lit {
        tracer: scene.bounce_tracer(),
        patches: &patches.set,
        emission: &emission,
        bouncing: &bouncing,
        exitance: &exitance,
        passages: &passages,
        lamps: Lamps::default(),
        direct: &direct,
        bounces: run.bounces,
        lift: LIFT,
    };
    let mut chosen = Vec::new();
    for (surface, samples) in run.samples.iter().enumerate() {
        if scene.surfaces[surface].light_ignore {
            continue;
        }
        let free = samples.iter().enumerate().filter(|(_, s)| !s.occluded);
        chosen.extend(free.map(|(luxel, _)| (surface as u32, luxel as u32)));
    }
    let mut irradiance = vec![Vec3::ZERO; count];
    for style in light {
        irradiance.iter_mut().zip(&style.irradiance).for_each(|(sum, e)| *sum += e.0);
    }
    let cells = run.hemicube.width().max(CELLS);
    let size = HemicubeSize::new(cells, cells).unwrap_or(run.hemicube);
    let points = MapLuxels {
        run,
        lit: &lit,
        chosen,
        exitance: &exitance,
        irradiance,
        delta: DeltaFormFactors::new(size),
        size,
    };
    (check(&points, end), energy)
}

/// Light of all styles of a surface.
fn all_styles(styles: &[StyleLight]) -> Vec<Irradiance> {
    let mut sum: Vec<Irradiance> = Vec::new();
    for style in styles {
        sum.resize(style.irradiance.len(), Irradiance::ZERO);
        sum.iter_mut().zip(&style.irradiance).for_each(|(sum, e)| *sum += *e);
    }
    sum
}
