//! Indirect light at luxels.

use super::interpolate::{Interpolator, Known};
use crate::light::StyleLight;
use crate::patch::{MapPatches, PatchId};
use crate::photometry::Irradiance;
use crate::radiosity::bounce::PatchLight;
use crate::radiosity::hemicube::{DeltaFormFactors, HemicubeSize, View};
use crate::radiosity::highlights::Correction;
use crate::radiosity::transfers::{Gatherer, Transfers};
use crate::scene::{Barriers, Sample, Scene};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Width of a luxel in world units, unless the map asks for another.
const LUXEL: f32 = 16.0;
/// Distance of those luxels from which others are interpolated.
const EVERY_OTHER: f32 = 2.0 * LUXEL;

/// Luxels along the edge of those that are interpolated together.
const TILE: usize = 4;

/// How indirect light gets from patches to luxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gather {
    /// Interpolate between patches; where they do not tell the light well, between some luxels that get
    /// a hemicube of their own.
    #[default]
    Interpolate,
    /// A hemicube at every luxel.
    Luxel,
}

/// How and how well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GatherSettings {
    /// The way.
    pub gather: Gather,
    /// Luxels are interpolated where what is known around them differs from a linear function by at most
    /// this share, root mean square, of the mean of the local light and that of the whole map. Above 0;
    /// infinite is allowed.
    pub error: f64,
    /// Cells of the hemicubes at luxels.
    pub hemicube: HemicubeSize,
}

/// The solution that luxels gather from.
#[derive(Clone, Copy)]
pub struct Sources<'a> {
    /// The map.
    pub scene: &'a Scene,
    /// Its patches.
    pub patches: &'a MapPatches,
    /// What the patches see.
    pub transfers: &'a Transfers,
    /// Their light in every style.
    pub light: &'a [PatchLight],
}

/// Indirect irradiance at the luxels of every surface, one map a style that reaches it, and the
/// number of hemicubes drawn. `samples` holds the luxels of each surface; `advance(n)` is told of
/// every n luxels done.
pub fn indirect(
    sources: Sources<'_>,
    samples: &[Vec<Sample>],
    settings: GatherSettings,
    advance: impl Fn(u64) + Sync,
) -> (Vec<Vec<StyleLight>>, u64) {
    indirect_while(sources, samples, settings, || true, advance)
}

/// The same with hemicubes at luxels for as long as there is `time`; those that still lack light then
/// get that of their patch.
pub(crate) fn indirect_while(
    sources: Sources<'_>,
    samples: &[Vec<Sample>],
    settings: GatherSettings,
    time: impl Fn() -> bool + Sync,
    advance: impl Fn(u64) + Sync,
) -> (Vec<Vec<StyleLight>>, u64) {
    if sources.light.is_empty() {
        return (vec![Vec::new(); samples.len()], 0);
    }
    let mut faces: Vec<Face<'_>> = samples
        .iter()
        .zip(&sources.scene.surfaces)
        .map(|(samples, surface)| Face {
            samples: if surface.light_ignore { &[] } else { samples },
            width: surface.luxels.as_ref().map_or(1, |grid| grid.width.max(1) as usize),
            normal: surface.normal,
            light: vec![None; samples.len()],
        })
        .collect();
    let size = settings.hemicube;
    let drawn = Drawn::new(sources, size);
    let mut hemicubes = 0;
    if settings.gather == Gather::Interpolate {
        let mut known = known_patches(sources, settings.error);
        interpolate(sources, &known, &mut faces);
        // Some of the luxels left, and then the rest between them.
        for turn in TURNS {
            let of_turn = |s: &Sample| of_parity(s, turn);
            hemicubes += drawn.fill(&mut faces, (of_turn, &time), Some(&mut known));
            if time() {
                interpolate(sources, &known, &mut faces);
            }
        }
    }
    hemicubes += drawn.fill(&mut faces, (|_: &Sample| true, &time), None);
    if !time() {
        as_patches(sources, &mut faces);
    }
    add_passing(sources, &mut faces);
    let maps = faces
        .into_par_iter()
        .map(|face| {
            advance(face.samples.len() as u64);
            face.maps(sources.light)
        })
        .collect();
    (maps, hemicubes)
}

/// Gives luxels that are still dark the light of their patch.
fn as_patches(sources: Sources<'_>, faces: &mut [Face<'_>]) {
    faces.par_iter_mut().enumerate().for_each(|(surface, face)| {
        for i in face.missing().collect::<Vec<_>>() {
            let patch = sources.patches.at(surface, face.samples[i].position);
            face.light[i] = patch.map(|patch| {
                let of = |style: &PatchLight| style.irradiance[patch.0 as usize].0.as_dvec3();
                sources.light.iter().map(of).collect()
            });
        }
    });
}

/// Adds what comes through thin brushes from their other side.
fn add_passing(sources: Sources<'_>, faces: &mut [Face<'_>]) {
    if sources.light.iter().all(|l| l.passing.is_empty()) {
        return;
    }
    let surfaces = &sources.scene.surfaces;
    faces.par_iter_mut().enumerate().for_each(|(surface, face)| {
        let Some(grid) = surfaces[surface].luxels.as_ref() else { return };
        if surfaces[surface].diffuse.is_none() {
            return;
        }
        for (sample, light) in face.samples.iter().zip(&mut face.light) {
            let Some(light) = light else { continue };
            // A mean over some luxels around: patches have edges that are not to be seen.
            let near = (0..25).map(|k| [k % 5 - 2, k / 5 - 2].map(|d| d as f32 * 0.5));
            for [s, t] in near {
                let at = sample.position + grid.s_step * s + grid.t_step * t;
                let Some(patch) = sources.patches.at(surface, at) else { continue };
                for (sum, style) in light.iter_mut().zip(sources.light) {
                    if let Some(e) = style.passing.get(patch.0 as usize) {
                        *sum += e.0.as_dvec3() / 25.0;
                    }
                }
            }
        }
    });
}

/// The luxels of a face while they are being filled.
struct Face<'a> {
    samples: &'a [Sample],
    /// Luxels in a row, at least 1.
    width: usize,
    normal: Vec3,
    /// Irradiance in every style, where it is known by now.
    light: Vec<Option<Vec<DVec3>>>,
}

impl Face<'_> {
    /// A luxel with a unit normal: blended normals of curved surfaces are shorter.
    fn sample(&self, i: usize) -> Sample {
        let sample = self.samples[i];
        Sample { normal: sample.normal.normalize_or(self.normal), ..sample }
    }

    /// Luxels that still need light.
    fn missing(&self) -> impl Iterator<Item = usize> + '_ {
        let free = self.samples.iter().enumerate().filter(|(_, s)| !s.occluded);
        free.map(|(i, _)| i).filter(|&i| self.light[i].is_none())
    }

    /// Luxels by tiles of neighbours.
    fn tiles(&self, luxels: Vec<usize>) -> Vec<Vec<usize>> {
        let mut tiles = BTreeMap::<_, Vec<usize>>::new();
        for i in luxels {
            tiles.entry([i / self.width / TILE, i % self.width / TILE]).or_default().push(i);
        }
        tiles.into_values().collect()
    }

    fn maps(&self, light: &[PatchLight]) -> Vec<StyleLight> {
        let map = |(k, l): (usize, &PatchLight)| {
            let irradiance = self
                .light
                .iter()
                .map(|e| e.as_ref().map_or(Irradiance::ZERO, |e| Irradiance(e[k].as_vec3())))
                .collect();
            StyleLight { style: l.style, irradiance }
        };
        let maps = light.iter().enumerate().map(map);
        maps.filter(|m| m.irradiance.iter().any(|e| *e != Irradiance::ZERO)).collect()
    }
}

/// The patches as known points. Those that the edge of a face cuts off stand as far apart as whole ones.
fn known_patches(sources: Sources<'_>, error: f64) -> Interpolator {
    let mut known = Interpolator::new(sources.light.len(), error);
    let groups = sources.patches.groups();
    for (i, patch) in sources.patches.set.patches.iter().enumerate() {
        if sources.transfers.first_of(i) != i {
            continue;
        }
        let eye = sources.transfers.eye(i, &sources.patches.set, &groups);
        let openness = sources.transfers.distances(i).openness;
        let spacing = sources.patches.spacing[sources.patches.surface[i] as usize];
        // Middles of groups of two by two.
        let apart = if sources.transfers.is_shared(i) { 2.0 * spacing } else { spacing };
        let point = Known::new(eye, patch.normal, openness, apart);
        known.add(point, sources.light.iter().map(|l| l.irradiance[i].0.as_dvec3()));
    }
    known
}

/// Interpolates what can be.
fn interpolate(sources: Sources<'_>, known: &Interpolator, faces: &mut [Face<'_>]) {
    faces.par_iter_mut().for_each_init(
        || Barriers::new(sources.scene),
        |barriers, face| {
            let missing: Vec<usize> = face.missing().collect();
            if missing.is_empty() {
                return;
            }
            let candidates = known.candidates(face.samples);
            for tile in face.tiles(missing) {
                let samples: Vec<Sample> = tile.iter().map(|&i| face.sample(i)).collect();
                for (i, light) in tile.into_iter().zip(known.at(barriers, &samples, &candidates)) {
                    face.light[i] = light;
                }
            }
        },
    );
}

/// What drawing hemicubes at luxels needs.
pub(super) struct Drawn<'a> {
    sources: Sources<'a>,
    delta: DeltaFormFactors,
    size: HemicubeSize,
}

impl<'a> Drawn<'a> {
    /// For hemicubes of a size.
    pub fn new(sources: Sources<'a>, size: HemicubeSize) -> Self {
        Self { sources, delta: DeltaFormFactors::new(size), size }
    }

    /// Draws a hemicube at every luxel that still needs light and is `wanted`, while there is `time`;
    /// adds them to `known`. Returns how many.
    fn fill(
        &self,
        faces: &mut [Face<'_>],
        (wanted, time): (impl Fn(&Sample) -> bool + Sync, &(impl Fn() -> bool + Sync)),
        known: Option<&mut Interpolator>,
    ) -> u64 {
        let drawn: Vec<Vec<(Known, Vec<DVec3>)>> = faces
            .par_iter_mut()
            .map_init(
                || self.looks(),
                |looks, face| {
                    let here: Vec<usize> =
                        face.missing().filter(|&i| wanted(&face.sample(i))).collect();
                    here.into_iter()
                        .take_while(|_| time())
                        .map(|i| {
                            let sample = face.sample(i);
                            let (at, seed) = (sample.position, seed(sample.position));
                            let view = View::turned(at, sample.normal, seed);
                            let light = self.arriving(looks, &view);
                            face.light[i] = Some(light.clone());
                            let openness = looks.gatherer.distances().openness;
                            let (at, normal) = (sample.position, sample.normal);
                            (Known::new(at, normal, openness, EVERY_OTHER), light)
                        })
                        .collect()
                },
            )
            .collect();
        let count = drawn.iter().map(Vec::len).sum::<usize>() as u64;
        if let Some(known) = known {
            for (point, light) in drawn.into_iter().flatten() {
                known.add(point, light);
            }
        }
        count
    }

    /// What is looked through at luxels.
    pub fn looks(&self) -> Looks<'_> {
        let Sources { scene, patches, light, .. } = self.sources;
        let correction = |style: &'a PatchLight| style.highlights.correction(scene, patches);
        Looks {
            gatherer: Gatherer::new(scene.bounce_tracer(), &patches.set, &self.delta, self.size),
            corrections: light.iter().map(correction).collect(),
        }
    }

    /// What arrives at `view` in each style: of far patches their mean light, of near ones that of each
    /// luxel interval.
    pub fn arriving(&self, looks: &mut Looks<'_>, view: &View) -> Vec<DVec3> {
        let light = self.sources.light;
        let Looks { gatherer, corrections } = looks;
        let mut sums = vec![DVec3::ZERO; light.len()];
        for (sum, correction) in sums.iter_mut().zip(&mut *corrections) {
            if let Some(correction) = correction {
                correction.stand(view.position, view.normal);
                *sum = correction.light();
            }
        }
        let takes = |style: usize, patch: PatchId| {
            corrections[style].as_ref().is_some_and(|c| c.takes(patch.0).is_some())
        };
        // Cells beyond this depth are too wide to tell intervals apart.
        let reach = 0.5 * self.size.width() as f32 * LUXEL;
        gatherer.visit(view, reach, |patch, interval, f| {
            for (k, (sum, style)) in sums.iter_mut().zip(light).enumerate() {
                if takes(k, patch) {
                    continue;
                }
                let mut exitance = style.exitance[patch.0 as usize].0;
                if let Some(i) = interval
                    && let Some(surface) = style.detail.get(i.surface as usize)
                    && let Some(more) = surface.get(i.number as usize)
                {
                    exitance += *more;
                }
                *sum += exitance.as_dvec3() * f64::from(f);
            }
        });
        for &(patch, f) in gatherer.overlay() {
            for (k, (sum, style)) in sums.iter_mut().zip(light).enumerate() {
                if !takes(k, patch) {
                    *sum += style.exitance[patch.0 as usize].0.as_dvec3() * f;
                }
            }
        }
        sums
    }
}

/// What one thread looks at luxels with.
pub(super) struct Looks<'a> {
    gatherer: Gatherer<'a>,
    /// Of each style.
    corrections: Vec<Option<Correction<'a>>>,
}

/// Seed of the turn of a luxel's hemicube. It follows from the place, so that luxels of two faces in
/// one place get the same light.
pub(super) fn seed(position: Vec3) -> u64 {
    (position * 8.0).round().to_array().iter().fold(0, |seed: u64, &x| {
        (seed ^ u64::from((x as i32).cast_unsigned())).wrapping_mul(0x9E37_79B9_7F4A_7C15)
    })
}

/// Which luxels get hemicubes in turn: those in even columns and rows, then those in odd ones, so that
/// every row has some.
const TURNS: [i32; 2] = [0, 1];

/// Whether a luxel is in columns and rows of this parity of a grid of luxels in the world: the same for
/// two faces that have a luxel in one place.
fn of_parity(sample: &Sample, parity: i32) -> bool {
    let steep = sample.normal.abs().max_position();
    let same = |k: usize| ((sample.position[k] / LUXEL).round() as i32).rem_euclid(2) == parity;
    (0..3).filter(|&k| k != steep).all(same)
}
