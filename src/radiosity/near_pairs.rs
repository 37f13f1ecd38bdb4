//! Form factors that one hemicube at the middle of a patch gets wrong: of patches that are near,
//! large, small, bright or partly hidden. Those whose error matters are replaced by closed forms
//! times visible shares; where things stand on or close to a patch, more hemicubes look out of it.

use super::area_points::{Spread, spread};
use super::hemicube::View;
use super::importance::Importance;
use super::overlay_pairs::{Shares, mean_share};
use super::pair_factor::{Facing, Precision, Shape};
use super::transfers::Gatherer;
use super::view_pairs::{Pair, balance};
use super::visibility::Occluders;
use crate::patch::{Overlay, PatchId, PatchSet};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// How far rows are improved.
#[derive(Clone, Copy, Debug)]
pub struct NearLimits {
    /// Error of a row's light that is let pass, as a share of the mean light that patches reflect.
    pub row: f64,
    /// Most rays between two patches that see each other in part.
    pub rays: u32,
    /// Most hemicubes on a patch.
    pub points: u32,
    /// Hemicubes on a patch that something touches.
    pub crowded: u32,
}

/// The patches of a scene as polygons, and what may hide them from each other.
pub struct NearPairs<'a> {
    shapes: Vec<Shape<'a>>,
    /// How many patches are in the place of each, itself included: one eye sees only one of them.
    copies: Vec<u32>,
    occluders: Occluders,
    lift: f64,
    importance: Importance,
    limits: NearLimits,
    /// Form factor of a typical cell of a hemicube.
    cell: f64,
    /// Patches that are translucent: the overlay has them, not the rows. Empty for none.
    translucent: Vec<bool>,
}

/// Form factor of a typical cell, of which a hemicube has `n`: 2 / n.
const TYPICAL_CELL: f64 = 2.0;
/// Patches see different things from different points where what is near (as the root of its solid
/// angle) shifts by this much between them.
const SHIFT: f64 = 1.0;
/// Hemicubes on a patch that sees different things, at first.
const FEW: u32 = 4;
/// Relative uncertainty of what several hemicubes see.
const SPREAD_SIGMA: f64 = 0.05;

/// Buffers that are reused from row to row.
pub struct Work {
    facing: Facing,
    pairs: Vec<Pair>,
    order: Vec<u32>,
    /// Place of each patch in `pairs`, or `NOWHERE`.
    place: Vec<u32>,
}

const NOWHERE: u32 = u32::MAX;

impl<'a> NearPairs<'a> {
    /// All `patches` have outlines. `cells` is the number of cells of the hemicubes that made the
    /// rows, `occluders` those of the same scene.
    pub fn new(
        patches: &'a PatchSet,
        occluders: Occluders,
        importance: Importance,
        limits: NearLimits,
        cells: usize,
    ) -> Self {
        let shapes: Vec<Shape<'a>> = patches
            .outlines
            .iter()
            .zip(&patches.patches)
            .map(|(outline, patch)| Shape::new(outline, patch.normal.as_dvec3()))
            .collect();
        let above = |(p, s): (&crate::patch::Patch, &Shape<'_>)| {
            (p.eye.as_dvec3() - s.centre).dot(s.normal).abs()
        };
        let lift = patches.patches.iter().zip(&shapes).map(above).fold(0.0, f64::max);
        let copies = copies(&shapes, lift);
        let shapes = if occluders.is_empty() {
            shapes
        } else {
            shapes.into_par_iter().map(|shape| shape.uncovered(&occluders, lift)).collect()
        };
        let mut translucent = Vec::new();
        for (patch, _) in patches.overlay.iter().flat_map(|o| o.layer_patches()) {
            translucent.resize(shapes.len(), false);
            translucent[patch.0 as usize] = true;
        }
        Self {
            shapes,
            copies,
            occluders,
            lift,
            importance,
            limits,
            cell: TYPICAL_CELL / cells as f64,
            translucent,
        }
    }

    /// Whether row `i` matters at all: whether its patch sends light on.
    pub(super) fn matters(&self, i: usize) -> bool {
        self.importance.reflectance[i] > 0.0
    }

    /// Mean share of light from patch `j` to `i` that gets through what is translucent between the two;
    /// `factor` is their form factor.
    pub(super) fn through(&self, overlay: &Overlay, (i, j): (usize, usize), factor: f64) -> Shares {
        let pair = Pair { guess: factor, ..Pair::seen(j as u32, factor) };
        // Edges of what is translucent are many, and their errors add up.
        let rays = (4 * self.precision(i, &pair).rays).next_power_of_two();
        let shapes = (&self.shapes[i], &self.shapes[j]);
        let seed = (i * 31 + j) as u32;
        let hidden = |p, q| !self.occluders.is_empty() && !self.occluders.clear(p, q);
        mean_share(overlay, shapes, PatchId(j as u32), (rays, self.lift, seed), hidden)
    }

    /// Form factor from patch `i` to the translucent patch `j`; `None` where there is none.
    pub(super) fn layer_factor(&self, (i, j): (usize, usize), facing: &mut Facing) -> Option<f64> {
        let mut pair = Pair::seen(j as u32, 0.0);
        self.estimate(i, &mut pair);
        let factor = self.closed(i, &pair, facing).filter(|_| pair.guess > 0.0)?.0;
        (factor > 0.0).then_some(factor)
    }

    /// Buffers for [`Self::improve`].
    pub fn work(&self) -> Work {
        let place = vec![NOWHERE; self.shapes.len()];
        Work { facing: Facing::default(), pairs: Vec::new(), order: Vec::new(), place }
    }

    /// Improves row `i`, given as the hemicube at its middle saw it. `gatherer` looks out of more
    /// points where they are needed.
    pub fn improve(
        &self,
        i: usize,
        row: &mut Vec<(PatchId, f64)>,
        work: &mut Work,
        gatherer: &mut Gatherer<'_>,
    ) {
        if self.importance.reflectance[i] == 0.0 {
            return;
        }
        let open = self.shapes[i].open_share();
        if open == 0.0 {
            row.clear();
            return;
        }
        self.list(i, row, &mut work.pairs);
        let points = self.points_at_least(i);
        self.choose(i, points > 1, work);
        let void = if points > 1 {
            self.look_around(i, points, work, gatherer)
        } else {
            (1.0 - work.pairs.iter().map(|p| p.factor).sum::<f64>()).max(0.0)
        };
        let mut changed = points > 1;
        for pair in &mut work.pairs {
            let closed = if pair.closed { self.closed(i, pair, &mut work.facing) } else { None };
            changed |= closed.is_some();
            (pair.factor, pair.sigma) = closed.unwrap_or_else(|| {
                let several = if points > 1 { SPREAD_SIGMA * pair.factor } else { 0.0 };
                (pair.factor, (pair.curve + pair.alias + several).min(pair.factor))
            });
        }
        if changed {
            balance(&mut work.pairs, void, open);
            let kept = work.pairs.iter().filter(|p| p.factor > 0.0);
            row.clear();
            row.extend(kept.map(|p| (PatchId(p.patch), p.factor)));
        }
    }

    /// Everything that patch `i` sees or may see, by patch.
    fn list(&self, i: usize, row: &[(PatchId, f64)], pairs: &mut Vec<Pair>) {
        pairs.clear();
        let mut seen = row.iter().copied().peekable();
        for j in 0..self.shapes.len() {
            let factor = seen.next_if(|s| s.0.0 as usize == j).map_or(0.0, |s| s.1);
            let mut pair = Pair::seen(j as u32, factor);
            if j != i && self.translucent.get(j) != Some(&true) {
                self.estimate(i, &mut pair);
            }
            if factor > 0.0 || pair.guess > 0.0 {
                pairs.push(pair);
            }
        }
    }

    /// Estimates the two errors of what the hemicube saw.
    fn estimate(&self, i: usize, pair: &mut Pair) {
        let (a, b) = (&self.shapes[i], &self.shapes[pair.patch as usize]);
        let way = b.centre - a.centre;
        let (height_b, height_a) = (a.normal.dot(way), -b.normal.dot(way));
        if height_b <= -b.radius || height_a <= -a.radius {
            return;
        }
        let square = way.length_squared();
        let cosines = (height_b + b.radius).max(0.0) * (height_a + a.radius).max(0.0);
        let spread = PI * square * square + b.area * (a.area + b.area);
        pair.guess = (cosines * b.area / spread).min(1.0).max(pair.factor);
        // A middle stands for its patch up to the square of size over distance.
        let gap = (square.sqrt() - b.radius).max(height_a).max(0.0);
        let size = a.radius * a.radius;
        pair.curve = pair.guess * 0.3 * size / (gap * gap + size);
        // Cells along the outline err independently: the fourth root of their number inside.
        let cells = pair.guess / self.cell;
        pair.alias = self.cell * if cells < 1.0 { cells } else { 0.5 * cells.powf(0.25) };
    }

    /// How many hemicubes patch `i` needs at least: more than one where things that hide others
    /// are so near that different points of the patch see different things.
    fn points_at_least(&self, i: usize) -> u32 {
        if self.limits.points < 2 {
            return 1;
        }
        let a = &self.shapes[i];
        if a.partly_covered() {
            return self.limits.crowded;
        }
        let (mut solid_angle, mut shift) = (0.0, 0.0f64);
        for o in self.occluders.shapes() {
            let way = o.centre - a.centre;
            if a.normal.dot(way) + o.height(a.normal) <= 1e-6 * a.radius {
                continue;
            }
            let gap = way.length() - o.radius;
            if gap < a.radius {
                return self.limits.crowded;
            }
            solid_angle += o.area / (gap * gap);
            shift = shift.max(a.radius / gap);
        }
        if solid_angle.sqrt() * shift > SHIFT { FEW } else { 1 }
    }

    /// Light that an error of a pair's form factor stands for, per unit.
    fn light(&self, i: usize, pair: &Pair) -> f64 {
        self.importance.reflectance[i] * self.importance.exitance[pair.patch as usize]
    }

    /// Marks the pairs whose closed form is worth its time: those with the largest errors, until
    /// what is left is below the row's limit. Errors of curvature add up, those of cells do not.
    fn choose(&self, i: usize, several: bool, work: &mut Work) {
        let pairs = &mut work.pairs;
        let errors = |p: &Pair| {
            let hidden = if several { 2.0 * SPREAD_SIGMA * p.factor } else { 0.0 };
            [p.curve, p.alias + hidden].map(|e| self.light(i, p) * e)
        };
        let (mut curves, mut squares) = (0.0, 0.0);
        for p in pairs.iter() {
            let [curve, alias] = errors(p);
            curves += curve;
            squares += alias * alias;
        }
        let limit = self.limits.row;
        if curves + squares.sqrt() <= limit {
            return;
        }
        let total = |k: u32| errors(&pairs[k as usize]).iter().sum::<f64>();
        // All that are smaller make up less than a twentieth of the limit.
        let least = 0.05 * limit / (pairs.len() as f64).sqrt();
        work.order.clear();
        work.order.extend((0..pairs.len() as u32).filter(|&k| total(k) > least));
        work.order.sort_by(|&a, &b| total(b).total_cmp(&total(a)).then(a.cmp(&b)));
        for &k in &work.order {
            if curves + squares.max(0.0).sqrt() <= limit {
                break;
            }
            let pair = &mut pairs[k as usize];
            let [curve, alias] = errors(pair);
            curves -= curve;
            squares -= alias * alias;
            pair.closed = true;
        }
    }

    /// Replaces the form factors by the mean over points spread over patch `i`: at least `least`,
    /// more while the light that they see differs. Returns the share in which no patch is seen.
    fn look_around(
        &self,
        i: usize,
        least: u32,
        work: &mut Work,
        gatherer: &mut Gatherer<'_>,
    ) -> f64 {
        let shape = &self.shapes[i];
        let on = Spread::new(shape.parts());
        let shift = (i as f64 * 0.754_877_666_246_692_8).fract();
        let (pairs, place) = (&mut work.pairs, &mut work.place);
        for (k, pair) in pairs.iter_mut().enumerate() {
            pair.factor = 0.0;
            place[pair.patch as usize] = k as u32;
        }
        let weight = self.importance.reflectance[i];
        let (mut mean, mut squares, mut seen) = (0.0, 0.0, 0.0);
        let (mut points, mut goal) = (0, least.min(self.limits.points));
        loop {
            while points < goal {
                let at = on.point(DVec2::from_array(spread(points, shift)));
                let eye = (at + shape.normal * self.lift).as_vec3();
                let seed = (i as u64) << 16 | u64::from(points);
                gatherer.look(&View::turned(eye, shape.normal.as_vec3(), seed));
                let mut light = 0.0;
                for &(patch, factor) in gatherer.row() {
                    let slot = &mut place[patch.0 as usize];
                    if *slot == NOWHERE {
                        *slot = pairs.len() as u32;
                        pairs.push(Pair::seen(patch.0, 0.0));
                    }
                    let pair = &mut pairs[*slot as usize];
                    pair.factor += factor;
                    seen += factor;
                    if !pair.closed {
                        light += factor * self.importance.exitance[patch.0 as usize];
                    }
                }
                points += 1;
                let change = light - mean;
                mean += change / f64::from(points);
                squares += change * (light - mean);
            }
            // Evenly spread points err by about half as much as independent ones.
            let error = weight * 0.5 * squares.sqrt() / f64::from(points);
            if error <= self.limits.row || points >= self.limits.points {
                break;
            }
            goal = (2 * points).min(self.limits.points);
        }
        let open = shape.open_share();
        let share = open / f64::from(points);
        for pair in pairs.iter_mut() {
            pair.factor *= share;
            place[pair.patch as usize] = NOWHERE;
        }
        pairs.sort_unstable_by_key(|p| p.patch);
        (open - seen * share).max(0.0)
    }

    /// How well the form factor of a pair has to be known.
    fn precision(&self, i: usize, pair: &Pair) -> Precision {
        let share = self.light(i, pair) * pair.guess / self.limits.row;
        // Evenly spread rays err by about n^-0.7.
        let rays = (3.0 * share).powf(1.4).clamp(16.0, f64::from(self.limits.rays.max(16)));
        Precision {
            closed: (0.05 / share).min(1e-2),
            rays: rays as u32,
            seed: (i * 31 + pair.patch as usize) as u64,
        }
    }

    /// The closed form of a pair and its uncertainty, as precise as its light asks for.
    fn closed(&self, i: usize, pair: &Pair, facing: &mut Facing) -> Option<(f64, f64)> {
        let j = pair.patch as usize;
        let precision = self.precision(i, pair);
        let pair = (&self.shapes[i], &self.shapes[j]);
        let share = 1.0 / f64::from(self.copies[j]);
        let found = facing.factor(pair, &self.occluders, self.lift, precision);
        found.map(|(factor, sigma)| (factor * share, sigma * share))
    }
}

/// Number of patches that look the same way from the same place, for each patch; places nearer than
/// `slack` are the same.
fn copies(shapes: &[Shape<'_>], slack: f64) -> Vec<u32> {
    // In no plane that scenes have.
    const ACROSS: DVec3 = DVec3::new(0.5257, 0.6881, 0.5);
    let mut order: Vec<(f64, usize)> =
        shapes.iter().enumerate().map(|(i, s)| (s.centre.dot(ACROSS), i)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut copies = vec![1; shapes.len()];
    for (k, &(place, i)) in order.iter().enumerate() {
        for &(_, j) in order[k + 1..].iter().take_while(|o| o.0 - place <= 2.0 * slack) {
            let (a, b) = (&shapes[i], &shapes[j]);
            if a.centre.distance(b.centre) <= slack
                && a.normal.dot(b.normal) > 1.0 - 1e-6
                && (a.area - b.area).abs() <= 1e-6 * a.area
            {
                copies[i] += 1;
                copies[j] += 1;
            }
        }
    }
    copies
}
