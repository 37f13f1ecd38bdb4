//! Form factors that one hemicube at the middle of a patch gets wrong: of patches that are near,
//! large, small or bright. They are replaced by closed forms times visible shares.

use super::area_points::{Spread, gauss, spread};
use super::hemicube::View;
use super::transfers::Gatherer;
use super::contour::{area, clip_front, exchange, point_to_polygon};
use super::visibility::{Occluders, Shaft};
use crate::patch::{PatchId, PatchSet};
use glam::{DVec2, DVec3};

/// How far a row is improved. Errors are shares of the mean light that patches reflect.
#[derive(Clone, Copy, Debug)]
pub struct NearLimits {
    /// Error of a row that is let pass.
    pub row: f64,
    /// Most rays between two patches that see each other in part.
    pub rays: u32,
    /// Most hemicubes on a patch.
    pub points: u32,
}

/// What the light of a scene is about: which rows and columns matter.
pub struct Importance {
    /// Exitance of each patch, relative to the mean that patches reflect.
    pub exitance: Vec<f64>,
    /// Reflectance of each patch.
    pub reflectance: Vec<f64>,
}

/// The patches of a scene as polygons.
pub struct NearPairs<'a> {
    patches: &'a PatchSet,
    shapes: Vec<Shape>,
    occluders: Occluders,
    lift: f64,
    importance: Importance,
    limits: NearLimits,
    /// Form factor of one typical cell.
    cell: f64,
}

struct Shape {
    centre: DVec3,
    normal: DVec3,
    radius: f64,
    area: f64,
}

/// A pair of patches, seen from the first one.
#[derive(Clone, Copy)]
struct Pair {
    patch: u32,
    /// Form factor.
    factor: f64,
    /// What it may be without anything between, roughly.
    guess: f64,
    /// Error of the hemicube because the view changes over the patch.
    curve: f64,
    /// Error of the hemicube because its cells are of finite size.
    alias: f64,
    exact: bool,
    /// Uncertainty of `factor`.
    sigma: f64,
}

/// Buffers that are reused from row to row.
#[derive(Default)]
pub struct Work {
    mine: Vec<DVec3>,
    other: Vec<DVec3>,
    pairs: Vec<Pair>,
    order: Vec<u32>,
}

impl<'a> NearPairs<'a> {
    /// `cells` is the number of cells of a hemicube.
    pub fn new(
        patches: &'a PatchSet,
        occluders: Occluders,
        importance: Importance,
        limits: NearLimits,
        cells: usize,
    ) -> Self {
        let shapes = patches.outlines.iter().zip(&patches.patches).map(|(outline, patch)| {
            let centre = outline.iter().sum::<DVec3>() / outline.len() as f64;
            let normal = outline[1..]
                .windows(2)
                .fold(DVec3::ZERO, |sum, p| sum + (p[0] - outline[0]).cross(p[1] - outline[0]))
                .try_normalize()
                .unwrap_or(patch.normal.as_dvec3());
            let radius = outline.iter().map(|p| p.distance(centre)).fold(0.0, f64::max);
            Shape { centre, normal, radius, area: area(outline) }
        });
        let lift = patches
            .patches
            .first()
            .zip(patches.outlines.first())
            .map_or(0.0, |(p, o)| (p.eye.as_dvec3() - o[0]).dot(p.normal.as_dvec3()).abs());
        Self {
            patches,
            shapes: shapes.collect(),
            occluders,
            lift,
            importance,
            limits,
            cell: 2.0 / cells as f64,
        }
    }

    pub fn occluders(&self) -> &Occluders {
        &self.occluders
    }

    /// Improves row `i`, given as the hemicube at its middle saw it. `look(k)` gives what the k-th
    /// of the points spread over the patch sees.
    pub fn improve(
        &self,
        i: usize,
        row: &mut Vec<(PatchId, f64)>,
        work: &mut Work,
        look: &mut Gatherer<'_>,
    ) {
        let weight = self.importance.reflectance[i];
        if weight == 0.0 {
            return;
        }
        let mut pairs = std::mem::take(&mut work.pairs);
        pairs.clear();
        let mut seen = row.iter().copied().peekable();
        for j in 0..self.shapes.len() {
            let factor = seen.next_if(|&(p, _)| p.0 as usize == j).map_or(0.0, |p| p.1);
            let (guess, curve, alias) = if j == i { (0.0, 0.0, 0.0) } else { self.errors(i, j, factor) };
            if factor > 0.0 || curve + alias > 0.0 {
                pairs.push(Pair { patch: j as u32, factor, guess, curve, alias, exact: false, sigma: 0.0 });
            }
        }
        let void = (1.0 - pairs.iter().map(|p| p.factor).sum::<f64>()).max(0.0);
        let least = self.points_at_least(i);
        let hard = least > 1;
        self.choose(weight, hard, &mut pairs, &mut work.order);
        let mut void = if hard { self.look_around(i, weight, least, &mut pairs, look) } else { void };
        for pair in &mut pairs {
            if pair.exact {
                (pair.factor, pair.sigma) = self.factor(i, pair.patch as usize, pair.guess, work);
            } else {
                let sigma = pair.curve + pair.alias + if hard { 0.05 * pair.factor } else { 0.0 };
                pair.sigma = sigma.min(pair.factor);
            }
        }
        balance(&mut pairs, &mut void);
        row.clear();
        row.extend(pairs.iter().filter(|p| p.factor > 0.0).map(|p| (PatchId(p.patch), p.factor)));
        work.pairs = pairs;
    }

    /// Hemicubes that patch `i` needs at least: more than one where things that hide others are so
    /// near that different points of the patch see noticeably different things.
    fn points_at_least(&self, i: usize) -> u32 {
        if self.limits.points < 2 || self.occluders.is_empty() {
            return 1;
        }
        let a = &self.shapes[i];
        let get = |n: &str, d: f64| std::env::var(n).map_or(d, |v| v.parse().unwrap());
        // Solid angle of what is near, and the largest shift of it as the point moves.
        let (mut view, mut shift) = (0.0, 0.0f64);
        for o in self.occluders.shapes() {
            let way = o.centre - a.centre;
            if a.normal.dot(way) + o.height(a.normal) <= 1e-6 * a.radius {
                continue;
            }
            let gap = way.length() - o.radius;
            if gap < a.radius {
                return get("TOUCH", 48.0) as u32;
            }
            view += o.area / (gap * gap);
            shift = shift.max(a.radius / gap);
        }
        if view.sqrt() * shift > get("HARD", 0.1) { get("MINP", 4.0) as u32 } else { 1 }
    }

    /// Marks the pairs whose closed form is worth its time: those with the largest errors, until
    /// what is left is below the row's limit.
    fn choose(&self, weight: f64, hard: bool, pairs: &mut [Pair], order: &mut Vec<u32>) {
        let light = |p: &Pair| weight * self.importance.exitance[p.patch as usize];
        let parts = |p: &Pair| {
            let hidden = if hard { 0.1 * p.factor } else { 0.0 };
            (light(p) * p.curve, light(p) * (p.alias + hidden))
        };
        let (mut curves, mut aliases) = (0.0, 0.0);
        for p in pairs.iter() {
            let (curve, alias) = parts(p);
            curves += curve;
            aliases += alias * alias;
        }
        let limit = self.limits.row;
        order.clear();
        order.extend(0..pairs.len() as u32);
        let key = |k: u32| {
            let (curve, alias) = parts(&pairs[k as usize]);
            curve + alias
        };
        let floor = 0.05 * limit / (pairs.len() as f64).sqrt();
        order.retain(|&k| key(k) > floor);
        order.sort_by(|&a, &b| key(b).total_cmp(&key(a)).then(a.cmp(&b)));
        for &k in order.iter() {
            if curves + aliases.max(0.0).sqrt() <= limit {
                break;
            }
            let (curve, alias) = parts(&pairs[k as usize]);
            curves -= curve;
            aliases -= alias * alias;
            pairs[k as usize].exact = true;
        }
    }

    /// Replaces the form factors by the mean over points spread over the patch, as many as the
    /// light they see differs. Returns the share in which no patch is seen.
    fn look_around(
        &self,
        i: usize,
        weight: f64,
        least: u32,
        pairs: &mut Vec<Pair>,
        look: &mut Gatherer<'_>,
    ) -> f64 {
        let outline = &self.patches.outlines[i];
        let on = Spread::new(outline);
        let normal = self.shapes[i].normal;
        let shift = (i as f64 * 0.754_877_666_246_692_8).fract();
        let mut slot = std::collections::HashMap::new();
        for (k, p) in pairs.iter_mut().enumerate() {
            p.factor = 0.0;
            slot.insert(p.patch, k);
        }
        let (mut total, mut mean, mut spread_of) = (0.0, 0.0, 0.0);
        let mut points = 0;
        let mut goal = least.min(self.limits.points);
        loop {
            while points < goal {
                let at = spread::<2>(points, shift);
                let eye = on.point(DVec2::from_array(at)) + normal * self.lift;
                look.look(&View::turned(eye.as_vec3(), normal.as_vec3(), (i as u64) << 16 | u64::from(points)));
                let mut light = 0.0;
                for &(patch, f) in look.row() {
                    let k = *slot.entry(patch.0).or_insert_with(|| {
                        pairs.push(Pair { patch: patch.0, factor: 0.0, guess: 0.0, curve: 0.0, alias: 0.0, exact: false, sigma: 0.0 });
                        pairs.len() - 1
                    });
                    pairs[k].factor += f;
                    total += f;
                    if !pairs[k].exact {
                        light += f * self.importance.exitance[patch.0 as usize];
                    }
                }
                points += 1;
                let change = light - mean;
                mean += change / f64::from(points);
                spread_of += change * (light - mean);
            }
            // The points are spread evenly, which halves the error of independent ones.
            let error = weight * 0.5 * spread_of.sqrt() / f64::from(points);
            if error <= self.limits.row || points >= self.limits.points {
                break;
            }
            goal = (2 * points).min(self.limits.points);
        }
        let share = 1.0 / f64::from(points);
        for p in pairs.iter_mut() {
            p.factor *= share;
        }
        pairs.sort_unstable_by_key(|p| p.patch);
        (1.0 - total * share).max(0.0)
    }

    /// A guess at the form factor, and estimates of the two errors of the hemicube's.
    fn errors(&self, i: usize, j: usize, seen: f64) -> (f64, f64, f64) {
        let (a, b) = (&self.shapes[i], &self.shapes[j]);
        let way = b.centre - a.centre;
        let height_j = a.normal.dot(way);
        let height_i = -b.normal.dot(way);
        if height_j <= -b.radius || height_i <= -a.radius {
            return (0.0, 0.0, 0.0);
        }
        let square = way.length_squared();
        let distance = square.sqrt();
        let gap = (distance - b.radius).max(height_i).max(0.0);
        let guess = (height_j + b.radius).max(0.0) * (height_i + a.radius).max(0.0) * b.area
            / (std::f64::consts::PI * square * square + b.area * (a.area + b.area));
        let guess = guess.min(1.0).max(seen);
        let curve = guess * 0.3 * a.radius * a.radius / (gap * gap + a.radius * a.radius);
        let cells = guess / self.cell;
        let alias = self.cell * if cells < 1.0 { cells } else { 0.5 * cells.powf(0.25) };
        (guess, curve, alias)
    }

    /// Form factor from patch `i` to patch `j` and its uncertainty.
    fn factor(&self, i: usize, j: usize, guess: f64, work: &mut Work) -> (f64, f64) {
        let (a, b) = (&self.shapes[i], &self.shapes[j]);
        let (outline_i, outline_j) = (&self.patches.outlines[i], &self.patches.outlines[j]);
        clip_front(outline_i, outline_j[0], b.normal, &mut work.mine);
        clip_front(outline_j, outline_i[0], a.normal, &mut work.other);
        if work.mine.len() < 3 || work.other.len() < 3 {
            return (0.0, 0.0);
        }
        let (mine, other) = (&work.mine[..], &work.other[..]);
        // Relative error that leaves the pair a small part of the row's.
        let light = self.importance.reflectance[i] * self.importance.exitance[j];
        let allowed = (0.05 * self.limits.row / (light * guess)).min(1e-2);
        let (exchanged, error) = if a.radius <= b.radius {
            self.unoccluded((mine, a), (other, b), allowed)
        } else {
            self.unoccluded((other, b), (mine, a), allowed)
        };
        let (factor, error) = (exchanged / a.area, error / a.area);
        if factor == 0.0 || self.occluders.is_empty() {
            return (factor, error);
        }
        let shaft = Shaft::new((mine, a.normal), (other, b.normal));
        if !self.occluders.between(&shaft) {
            return (factor, error);
        }
        // Evenly spread rays err by about n^-0.7.
        let rays = (3.0 * light * factor / self.limits.row).powf(1.4).clamp(16.0, f64::from(self.limits.rays));
        let share = self.visible((mine, a.normal), (other, b.normal), rays as u32, i * 31 + j);
        (factor * share, error + factor * 0.5 * rays.powf(-0.7))
    }

    /// Exchange of two clipped polygons, the first being the smaller, and its uncertainty.
    fn unoccluded(
        &self,
        (a, shape_a): (&[DVec3], &Shape),
        (b, shape_b): (&[DVec3], &Shape),
        allowed: f64,
    ) -> (f64, f64) {
        let way = shape_b.centre - shape_a.centre;
        let gap = (way.length() - shape_b.radius).max(way.dot(shape_b.normal).abs());
        let apart = gap / shape_a.radius;
        let bound = |order: i32| (0.5 / apart).powi(2 * order);
        let Some(order) = (1..=4).find(|&order| apart > 2.0 && bound(order) <= allowed) else {
            return (exchange(a, b, 1e-8 * shape_a.area.min(shape_b.area)), 0.0);
        };
        let mut sum = 0.0;
        gauss(a, order as usize, |p, w| sum += w * point_to_polygon(p, shape_a.normal, b));
        (sum, sum * bound(order))
    }

    /// Share of the exchange of two polygons that gets through.
    fn visible(&self, (a, normal_a): (&[DVec3], DVec3), (b, normal_b): (&[DVec3], DVec3), rays: u32, seed: usize) -> f64 {
        let (on_a, on_b) = (Spread::new(a), Spread::new(b));
        let shift = (seed as f64 * 0.618_033_988_749_894_9).fract();
        let (mut all, mut clear) = (0.0, 0.0);
        for k in 0..rays {
            let [s, t, u, v] = spread(k, shift);
            let p = on_a.point(DVec2::new(s, t));
            let q = on_b.point(DVec2::new(u, v));
            let way = q - p;
            let square = way.length_squared();
            let kernel = normal_a.dot(way).max(0.0) * (-normal_b.dot(way)).max(0.0) / (square * square);
            if kernel.is_nan() || kernel <= 0.0 {
                continue;
            }
            all += kernel;
            if self.occluders.clear(p + normal_a * self.lift, q + normal_b * self.lift) {
                clear += kernel;
            }
        }
        if all > 0.0 { clear / all } else { 0.0 }
    }
}

/// Makes the view whole again: the form factors and the void sum to 1, so what the closed forms
/// changed is taken from those that are uncertain, most from the most uncertain (least squares).
fn balance(pairs: &mut [Pair], void: &mut f64) {
    let void_sigma = 0.5 * *void;
    // Again where a form factor would have become negative.
    for _ in 0..8 {
        let excess = pairs.iter().map(|p| p.factor).sum::<f64>() + *void - 1.0;
        let free = |p: &Pair| p.factor > 0.0;
        let squares = pairs.iter().filter(|p| free(p)).map(|p| p.sigma * p.sigma).sum::<f64>()
            + void_sigma * void_sigma;
        if squares <= 0.0 || excess.abs() < 1e-12 {
            return;
        }
        let step = excess / squares;
        for p in pairs.iter_mut().filter(|p| free(p)) {
            p.factor = (p.factor - step * p.sigma * p.sigma).max(0.0);
        }
        *void = (*void - step * void_sigma * void_sigma).max(0.0);
    }
}
