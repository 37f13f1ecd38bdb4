//! Interpolating indirect irradiance between points where it is known.
//!
//! Known points are the patches and, where those do not suffice, some luxels. Each is trusted within
//! a reach that follows from how far away the things are that it sees (Ward, Rubinstein and Clear,
//! 1988). A luxel takes the value of a linear function fitted by moving least squares (Lancaster and
//! Salkauskas, 1981) to the points that it can see. The value depends on where the luxel is in the
//! world and not on its face, so coplanar and smoothly touching faces meet without a seam.

use super::overlooked::overlooked;
use crate::scene::{Barriers, Bounds, Sample};
use glam::{DMat3, DVec3, Vec3};
use std::collections::HashMap;

/// Reach of a point relative to the harmonic mean distance of what it sees.
const TRUST: f32 = 0.5;
/// Limits of the reach in world units, if points are not farther apart.
const REACH: [f32; 2] = [16.0, 128.0];
/// A gap of a few units ends its points' reach, which is at most this many times its width.
const GAP: f32 = 8.0;
/// How much a difference of normals counts: this times sqrt(1 - cosine) is added to the distance,
/// relative to the reach.
const BEND: f32 = 3.0;
/// How much more an offset along the normals counts than one across them: the linear function knows
/// only the latter.
const RAISED: f32 = 8.0;
/// Points one of which is this many times as open as another are in unlike places.
const UNLIKE: f32 = 4.0;
/// Weight that the points seen must have together: one in the middle, or several around.
const ENOUGH: f64 = 0.4;
/// Luxels with less than this share of the map's mean light are interpolated whatever is right beside them.
const DIM: f64 = 0.3;
/// Holds the gradient back where points do not determine it, relative to the weights.
const RIDGE: f64 = 0.02;

/// A point where irradiance is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    position: Vec3,
    normal: Vec3,
    reach: f32,
    openness: f32,
}

impl Known {
    /// `openness` is the harmonic mean distance to what is seen from the point, `apart` the distance of
    /// such points. They reach each other: where none did, those farther off would be taken for all there
    /// is, and light that gathers in a corner would be missed between the points. Points in a gap do not
    /// reach out of it.
    pub fn new(position: Vec3, normal: Vec3, openness: f32, apart: f32) -> Self {
        let low = apart.min(GAP * openness).clamp(REACH[0], REACH[1]);
        let reach = (TRUST * openness).clamp(low, REACH[1]);
        Self { position, normal, reach, openness }
    }
}

/// Known points and their irradiance.
#[derive(Default)]
pub(super) struct Interpolator {
    known: Vec<Known>,
    /// Irradiance of each point, `styles` entries each.
    irradiance: Vec<DVec3>,
    /// Brightness of each point: the sum over all styles of the mean of the channels.
    level: Vec<f64>,
    /// Sum of that over all points.
    sum: f64,
    styles: usize,
    error: f64,
    cells: HashMap<[i32; 3], Vec<u32>>,
}

impl Interpolator {
    /// No points yet; each will have irradiance in `styles` styles. `error` is what interpolation may
    /// differ by, see [`GatherSettings`](super::GatherSettings).
    pub fn new(styles: usize, error: f64) -> Self {
        Self { styles, error, ..Self::default() }
    }

    /// Adds a point and its irradiance in every style.
    pub fn add(&mut self, point: Known, irradiance: impl IntoIterator<Item = DVec3>) {
        let index = self.known.len() as u32;
        self.cells.entry(cell(point.position)).or_default().push(index);
        self.known.push(point);
        let before = self.irradiance.len();
        self.irradiance.extend(irradiance);
        let level = self.irradiance[before..].iter().map(|e| e.element_sum() / 3.0).sum::<f64>();
        self.level.push(level);
        self.sum += level;
    }

    /// Points that may matter to some of the samples, in ascending order.
    pub fn candidates(&self, samples: &[Sample]) -> Vec<u32> {
        let free = || samples.iter().filter(|s| !s.occluded).map(|s| s.position);
        let low = cell(free().fold(Vec3::INFINITY, Vec3::min) - Vec3::splat(REACH[1]));
        let high = cell(free().fold(Vec3::NEG_INFINITY, Vec3::max) + Vec3::splat(REACH[1]));
        let mut found = Vec::new();
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                for x in low[0]..=high[0] {
                    found.extend(self.cells.get(&[x, y, z]).into_iter().flatten());
                }
            }
        }
        found.sort_unstable();
        found
    }

    /// Irradiance at each of the `samples`, which are close together, in each style; `None` where the
    /// points around that can be seen from it do not tell it well enough or do not agree.
    pub fn at(
        &self,
        barriers: &mut Barriers<'_>,
        samples: &[Sample],
        candidates: &[u32],
    ) -> Vec<Option<Vec<DVec3>>> {
        let candidates = self.near(samples, candidates);
        let mut around: Vec<Vec<Neighbour>> =
            samples.iter().map(|sample| self.around(sample, &candidates)).collect();
        let position = |n: &Neighbour| self.known[n.point as usize].position;
        let from = Bounds::around(samples.iter().map(|s| s.position));
        let to = Bounds::around(around.iter().flatten().map(position));
        let rays = around.iter().map(Vec::len).sum();
        if let (Some(from), Some(to)) = (from, to) {
            barriers.within(&from, &to, rays);
        }
        for (sample, around) in samples.iter().zip(&mut around) {
            around.retain(|n| !barriers.blocked(sample.position, position(n)));
        }
        barriers.anywhere();
        samples.iter().zip(&around).map(|(s, around)| self.fit(barriers, s, around)).collect()
    }

    /// Those of the candidates that may matter to these samples.
    fn near(&self, samples: &[Sample], candidates: &[u32]) -> Vec<u32> {
        let Some(first) = samples.first() else { return Vec::new() };
        let far = |s: &Sample| first.position.distance(s.position);
        let radius = samples.iter().map(far).fold(0.0, f32::max) + 1.0;
        let flat = samples.iter().all(|s| s.normal == first.normal);
        let matters = |i: &u32| {
            let point = &self.known[*i as usize];
            let reach = point.reach + radius;
            point.position.distance_squared(first.position) < reach * reach
                && !(flat && bend(point, first.normal) >= 1.0)
        };
        candidates.iter().copied().filter(matters).collect()
    }

    /// The points that count at a sample if they can be seen from it.
    fn around(&self, sample: &Sample, candidates: &[u32]) -> Vec<Neighbour> {
        let neighbour = |&point: &u32| {
            let known = &self.known[point as usize];
            let offset = known.position - sample.position;
            let weight = weight(known, sample.normal, offset);
            (weight > 0.0).then_some(Neighbour { point, offset, weight })
        };
        candidates.iter().filter_map(neighbour).collect()
    }

    /// What these points tell of the irradiance at `sample`.
    fn fit(
        &self,
        barriers: &mut Barriers<'_>,
        sample: &Sample,
        around: &[Neighbour],
    ) -> Option<Vec<DVec3>> {
        let (tangent, bitangent) = sample.normal.any_orthonormal_pair();
        let mut moments = DMat3::ZERO;
        let mut used: Vec<(u32, DVec3)> = Vec::with_capacity(around.len());
        let (mut rhs, mut squares) = (DVec3::ZERO, 0.0);
        let (mut centre, mut nearness, mut strain) = (DVec3::ZERO, 0.0, 0.0);
        let (mut narrowest, mut widest) = (f32::INFINITY, 0.0_f32);
        for &Neighbour { point: i, offset, weight } in around {
            let along = |axis: Vec3| f64::from(offset.dot(axis) / REACH[1]);
            let basis = DVec3::new(1.0, along(tangent), along(bitangent));
            moments += DMat3::from_cols(basis * basis.x, basis * basis.y, basis * basis.z) * weight;
            used.push((i, basis * weight));
            let level = self.level[i as usize];
            rhs += basis * (weight * level);
            squares += weight * level * level;
            centre += offset.as_dvec3() * weight;
            let openness = self.known[i as usize].openness;
            nearness += weight / f64::from(openness);
            strain += weight * f64::from(offset.length() / openness);
            (narrowest, widest) = (narrowest.min(openness), widest.max(openness));
        }
        if moments.x_axis.x < ENOUGH {
            return None;
        }
        let total = moments.x_axis.x;
        // Relative to how far the points are spread, so that dense points may show steep gradients.
        let spread = moments.y_axis.y + moments.z_axis.z;
        let ridge = RIDGE * spread + 1e-9;
        moments.y_axis.y += ridge;
        moments.z_axis.z += ridge;
        // The fit's value at the luxel is the first entry of inverse x right-hand side: a weighted
        // sum of the points' values with these coefficients.
        let inverse = moments.inverse();
        let first = inverse.transpose().x_axis;
        // Weighted mean square of what the points differ from the fit by.
        let fit = inverse * rhs;
        let held = ridge * (fit.y * fit.y + fit.z * fit.z);
        let residual = (squares - fit.dot(rhs) - held).max(0.0) / total;
        let mean = self.sum / self.known.len() as f64;
        let tolerance = self.error * 0.5 * (fit.x.abs() + mean.abs());
        if residual > tolerance * tolerance {
            return None;
        }
        let (centre, openness) = ((centre / total).as_vec3(), (total / nearness) as f32);
        // At the mouth of a gap, one point in it and one far out agree with any fit.
        let between = || strain > total && widest > UNLIKE * narrowest;
        if self.error.is_finite()
            && fit.x.abs() > DIM * mean.abs()
            && (between() || overlooked(barriers, sample, (centre, around), openness))
        {
            return None;
        }
        let light = (0..self.styles).map(|style| {
            let value = |i: u32| self.irradiance[i as usize * self.styles + style];
            let (mut sum, mut low, mut high) = (DVec3::ZERO, DVec3::INFINITY, DVec3::NEG_INFINITY);
            for &(i, w) in &used {
                sum += value(i) * first.dot(w);
                low = low.min(value(i));
                high = high.max(value(i));
            }
            // The fit may run a little past its data, but never to nonsense.
            let slack = (high - low) * 0.5;
            sum.clamp((low - slack).max(DVec3::ZERO).min(low), high + slack)
        });
        Some(light.collect())
    }
}

/// A point that counts at a sample.
#[derive(Clone, Copy)]
pub(super) struct Neighbour {
    point: u32,
    /// Where it is, from the sample.
    pub offset: Vec3,
    /// How much it counts.
    pub weight: f64,
}

/// How much the difference of the normals adds to the distance from a point, relative to its reach.
fn bend(point: &Known, here: Vec3) -> f32 {
    BEND * (1.0 - here.dot(point.normal)).max(0.0).sqrt()
}

/// How much a point at `offset` counts at normal `here`, from 0 for not at all to 1. It falls smoothly
/// to 0, so that no point appears or vanishes with a jump.
fn weight(point: &Known, here: Vec3, offset: Vec3) -> f64 {
    if offset.length_squared() >= point.reach * point.reach {
        return 0.0;
    }
    let bend = bend(point, here);
    // Between two points of a round wall the mean of their normals is across the offset.
    let raised = offset.dot((here + point.normal).normalize_or_zero());
    let squared = offset.length_squared() + (RAISED * RAISED - 1.0) * raised * raised;
    let error = squared.sqrt() / point.reach + bend;
    if error >= 1.0 { 0.0 } else { f64::from((1.0 - error * error).powi(2)) }
}

fn cell(p: Vec3) -> [i32; 3] {
    [p.x, p.y, p.z].map(|v| (v / REACH[1]).floor() as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsp::Bsp;
    use crate::scene::{Scene, SceneSettings, Sidecar, luxels};

    /// What tiles of luxels look up together is what each finds alone, with every point looked at.
    #[test]
    fn luxels_together_get_what_each_gets_alone() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/maps/atrium.bsp");
        let bsp = Bsp::read(&std::fs::read(path).unwrap()).unwrap();
        let scene = Scene::build(&bsp, Sidecar::default(), &SceneSettings::default()).unwrap();
        let faces = (0..scene.surfaces.len()).step_by(7);
        let samples: Vec<_> = faces.map(|face| luxels::place(&scene, face, 1)).collect();
        let free = |samples: &[Sample]| samples.iter().copied().filter(|s| !s.occluded).collect();
        let faces: Vec<Vec<Sample>> = samples.iter().map(|s| free(s)).collect();
        let mut known = Interpolator::new(1, f64::INFINITY);
        for (k, s) in faces.iter().flatten().step_by(3).enumerate() {
            let light = DVec3::splat(1.0 + (k % 5) as f64);
            known.add(Known::new(s.position, s.normal.normalize(), 80.0, 32.0), [light]);
        }
        let all: Vec<u32> = (0..known.known.len() as u32).collect();
        let mut barriers = Barriers::new(&scene);
        let (mut found, mut none, mut hidden) = (0, 0, 0);
        for tile in faces.iter().flat_map(|samples| samples.chunks(13)) {
            let together = known.at(&mut barriers, tile, &known.candidates(tile));
            for (sample, light) in tile.iter().zip(together) {
                let mut around = known.around(sample, &all);
                let before = around.len();
                let at = |n: &Neighbour| known.known[n.point as usize].position;
                around.retain(|n| !barriers.blocked(sample.position, at(n)));
                hidden += before - around.len();
                assert_eq!(light, known.fit(&mut barriers, sample, &around), "{sample:?}");
                *if light.is_some() { &mut found } else { &mut none } += 1;
            }
        }
        println!("{found} luxels, {none} without, {hidden} points hidden");
        assert!(found > 1000 && none > 10 && hidden > 100);
    }
}
