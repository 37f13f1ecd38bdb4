//! Form factors that one hemicube at the middle of a patch gets wrong: of patches that are near,
//! large, small or bright. They are replaced by closed forms times visible shares.

use super::area_points::{Spread, gauss, spread};
use super::contour::{area, clip_front, exchange, point_to_polygon};
use super::visibility::{Occluders, Shaft};
use crate::patch::{PatchId, PatchSet};
use glam::DVec3;

/// How far a row is improved.
#[derive(Clone, Copy, Debug)]
pub struct NearLimits {
    /// Error of one pair that is let pass, as a share of the mean light that a patch reflects.
    pub pair: f64,
    /// Rays between two patches that see each other in part.
    pub rays: u32,
    /// Hemicubes on a patch.
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

/// One pair that is to be replaced.
#[derive(Clone, Copy)]
struct Replaced {
    patch: u32,
    factor: f64,
}

/// Buffers that are reused from row to row.
#[derive(Default)]
pub struct Work {
    mine: Vec<DVec3>,
    other: Vec<DVec3>,
    replaced: Vec<Replaced>,
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

    /// Improves row `i`, given as the hemicube saw it.
    pub fn improve(&self, i: usize, row: &mut Vec<(PatchId, f64)>, work: &mut Work) {
        let weight = self.importance.reflectance[i];
        if weight == 0.0 {
            return;
        }
        let mut replaced = std::mem::take(&mut work.replaced);
        replaced.clear();
        let mut seen = row.iter().copied().peekable();
        for j in 0..self.shapes.len() {
            let mut factor = 0.0;
            if let Some((_, f)) = seen.next_if(|&(patch, _)| patch.0 as usize == j) {
                factor = f;
            }
            if j != i && weight * self.importance.exitance[j] * self.error(i, j, factor) > self.limits.pair {
                let factor = self.factor(i, j, work);
                replaced.push(Replaced { patch: j as u32, factor });
            }
        }
        replace(row, &replaced);
        work.replaced = replaced;
    }

    /// Estimate of the error of the hemicube's form factor.
    fn error(&self, i: usize, j: usize, seen: f64) -> f64 {
        let (a, b) = (&self.shapes[i], &self.shapes[j]);
        let way = b.centre - a.centre;
        let height_j = a.normal.dot(way);
        let height_i = -b.normal.dot(way);
        if height_j <= -b.radius || height_i <= -a.radius {
            return 0.0;
        }
        let square = way.length_squared();
        let distance = square.sqrt();
        let gap = (distance - b.radius).max(height_i).max(0.0);
        let guess = (height_j + b.radius).max(0.0) * (height_i + a.radius).max(0.0) * b.area
            / (std::f64::consts::PI * square * square + b.area * (a.area + b.area));
        let guess = guess.min(1.0).max(seen);
        let curve = 0.3 * a.radius * a.radius / (gap * gap + a.radius * a.radius);
        let mut error = guess * curve;
        let cells = guess / self.cell;
        error += self.cell * if cells < 1.0 { cells } else { 0.5 * cells.powf(0.25) };
        if !self.occluders.is_empty() {
            error += 0.0 * guess;
        }
        error
    }

    fn factor(&self, i: usize, j: usize, work: &mut Work) -> f64 {
        let (a, b) = (&self.shapes[i], &self.shapes[j]);
        let (outline_i, outline_j) = (&self.patches.outlines[i], &self.patches.outlines[j]);
        clip_front(outline_i, outline_j[0], b.normal, &mut work.mine);
        clip_front(outline_j, outline_i[0], a.normal, &mut work.other);
        if work.mine.len() < 3 || work.other.len() < 3 {
            return 0.0;
        }
        let (mine, other) = (&work.mine[..], &work.other[..]);
        let exchanged = if a.radius <= b.radius {
            self.unoccluded((mine, a), (other, b))
        } else {
            self.unoccluded((other, b), (mine, a))
        };
        let factor = exchanged / a.area;
        if factor == 0.0 || self.occluders.is_empty() {
            return factor;
        }
        let shaft = Shaft::new((mine, a.normal), (other, b.normal));
        if !self.occluders.between(&shaft) {
            return factor;
        }
        factor * self.visible((mine, a.normal), (other, b.normal), i * 31 + j)
    }

    /// Exchange of two clipped polygons, the first being the smaller.
    fn unoccluded(&self, (a, shape_a): (&[DVec3], &Shape), (b, shape_b): (&[DVec3], &Shape)) -> f64 {
        let way = shape_b.centre - shape_a.centre;
        let gap = (way.length() - shape_b.radius).max(way.dot(shape_b.normal).abs());
        let apart = gap / shape_a.radius;
        let order = match apart {
            q if q > 20.0 => 1,
            q if q > 5.0 => 2,
            q if q > 2.5 => 3,
            _ => return exchange(a, b, 1e-8 * shape_a.area.min(shape_b.area)),
        };
        let mut sum = 0.0;
        gauss(a, order, |p, w| sum += w * point_to_polygon(p, shape_a.normal, b));
        sum
    }

    /// Share of the exchange of two polygons that gets through.
    fn visible(&self, (a, normal_a): (&[DVec3], DVec3), (b, normal_b): (&[DVec3], DVec3), seed: usize) -> f64 {
        let (on_a, on_b) = (Spread::new(a), Spread::new(b));
        let shift = (seed as f64 * 0.618_033_988_749_894_9).fract();
        let (mut all, mut clear) = (0.0, 0.0);
        for k in 0..self.limits.rays {
            let [s, t, u, v] = spread(k, shift);
            let p = on_a.point(glam::DVec2::new(s, t));
            let q = on_b.point(glam::DVec2::new(u, v));
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

/// Puts the replaced form factors into a row and scales the others so that the whole view, the void
/// included, stays 1: what near patches take, far ones lose.
fn replace(row: &mut Vec<(PatchId, f64)>, replaced: &[Replaced]) {
    if replaced.is_empty() {
        return;
    }
    let mut merged = Vec::with_capacity(row.len() + replaced.len());
    let mut old = 0.0;
    let mut list = replaced.iter().peekable();
    for &(patch, factor) in row.iter() {
        while let Some(r) = list.next_if(|r| r.patch < patch.0) {
            merged.push((PatchId(r.patch), r.factor, true));
        }
        if let Some(r) = list.next_if(|r| r.patch == patch.0) {
            old += factor;
            merged.push((patch, r.factor, true));
        } else {
            merged.push((patch, factor, false));
        }
    }
    merged.extend(list.map(|r| (PatchId(r.patch), r.factor, true)));
    let new: f64 = replaced.iter().map(|r| r.factor).sum();
    let scale = if old < 1.0 - 1e-9 { ((1.0 - new) / (1.0 - old)).clamp(0.0, 2.0) } else { 1.0 };
    row.clear();
    row.extend(merged.into_iter().filter(|m| m.1 > 0.0).map(|(patch, factor, exact)| {
        (patch, if exact { factor } else { factor * scale })
    }));
}
