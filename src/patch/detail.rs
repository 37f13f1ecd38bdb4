//! What patches are too coarse for: the light of single luxel intervals, the squares between four
//! luxels. From nearby, an eye sees how direct light varies over a patch.

use super::{MapPatches, PolygonPatches};
use crate::photometry::Irradiance;
use glam::Vec3;
use rayon::prelude::*;

/// The luxel intervals of a map, face by face and row by row.
#[derive(Clone, Debug, Default)]
pub struct Intervals {
    /// First interval of each surface, and one more entry.
    first: Vec<u32>,
    /// Luxels in a row of each surface, and one more entry.
    widths: Vec<u32>,
    /// The polygon of the tracer that each surface is, if it sends light back; and one more entry.
    pub(super) polygons: Vec<Option<u32>>,
    /// Weights of the luxels at the corners (low, next column, next row, both), in 255ths; all zero
    /// where none is free or the face does not reach.
    weights: Vec<[u8; 4]>,
}

/// How much the exitance of each luxel interval differs from that of its patch, in one style: of each
/// surface its intervals row by row, or nothing where that style sheds no direct light.
pub type Detail = Vec<Vec<Vec3>>;

impl Intervals {
    /// Begins the next surface, or ends the last.
    pub(super) fn next_surface(&mut self) {
        self.first.push(self.weights.len() as u32);
        self.widths.push(0);
        self.polygons.push(None);
    }

    /// Adds all intervals of the surface begun last, whose rows are `width` luxels long, by the weights
    /// of their corners.
    pub(super) fn add(&mut self, width: u32, weights: impl Iterator<Item = [f32; 4]>) {
        *self.widths.last_mut().expect("a surface has begun") = width;
        self.weights.extend(weights.map(|w| w.map(|w| (w * 255.0).round() as u8)));
    }

    /// Number of intervals.
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.weights.is_empty()
    }

    /// Mean of `luxels`, one a luxel of a surface, over its interval number `k`; `None` where all
    /// corners are in solid.
    fn mean(&self, surface: usize, k: usize, luxels: &[Irradiance]) -> Option<Irradiance> {
        let weights = self.weights[self.first[surface] as usize + k];
        let sum = weights.iter().map(|&w| u32::from(w)).sum::<u32>();
        if sum == 0 {
            return None;
        }
        let width = self.widths[surface] as usize;
        let corner = k / (width - 1) * width + k % (width - 1);
        let around = [corner, corner + 1, corner + width, corner + width + 1];
        let light = around.iter().zip(weights);
        let total = light.fold(Irradiance::ZERO, |e, (&i, w)| e + luxels[i] * f32::from(w));
        Some(total * (1.0 / sum as f32))
    }
}

impl MapPatches {
    /// How the light that patches reflect varies over them: reflectance, where it varies that of the
    /// interval, times the difference of an interval's direct irradiance from the mean of its patch.
    /// `luxels` is the direct light of each surface (empty for none), `mean` that of each patch.
    pub fn detail(&self, luxels: &[&[Irradiance]], mean: &[Irradiance]) -> Detail {
        luxels
            .par_iter()
            .enumerate()
            .map(|(surface, luxels)| {
                let polygon = self.intervals.polygons[surface].filter(|_| !luxels.is_empty());
                let Some(PolygonPatches::Grid(grid)) = polygon.map(|p| self.set.lookup.polygon(p))
                else {
                    return Vec::new();
                };
                let count = grid.block_column.len() * grid.block_row.len();
                let varied = self.varied.get(&surface);
                let difference = |k: usize| {
                    let (s, t) = (k % grid.block_column.len(), k / grid.block_column.len());
                    // Intervals that are cut have no mean.
                    let patch = grid.at(s as f32, t as f32).0 as usize;
                    let light = self.intervals.mean(surface, k, luxels)?;
                    let of_patch = self.set.patches[patch].reflectance.0;
                    let reflectance = varied.map_or(of_patch, |of| of[k]);
                    Some((light - mean[patch]).0 * reflectance)
                };
                (0..count).map(|k| difference(k).unwrap_or_default()).collect()
            })
            .collect()
    }
}
