//! Some samples of a surface that stand for all: one in each block of them.

use super::spread::Shares;
use super::{DirectLight, StyleLight};
use crate::scene::Sample;

/// One sample of each block of a surface that has a free one.
pub(super) struct Lattice {
    /// Indices of the samples.
    chosen: Vec<u32>,
    /// Number in `chosen` of each block, row by row.
    blocks: Vec<Option<u32>>,
    /// Blocks in a row.
    columns: usize,
    /// Samples along the edge of a block.
    block: usize,
    /// Samples in a row of the surface.
    width: usize,
}

impl Lattice {
    /// Blocks of `block` x `block` samples, of which there are `width` in a row: the free sample nearest
    /// to the middle of each.
    pub fn new(samples: &[Sample], width: usize, block: u32) -> Self {
        let (block, width) = (block.max(1) as usize, width.max(1));
        let height = samples.len().div_ceil(width);
        let columns = width.div_ceil(block);
        let mut made = Self { chosen: Vec::new(), blocks: Vec::new(), columns, block, width };
        for top in (0..height).step_by(block) {
            for left in (0..width).step_by(block) {
                let (bottom, right) = ((top + block).min(height), (left + block).min(width));
                let rows = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
                let free = rows.filter(|(x, y)| {
                    samples.get(y * width + x).is_some_and(|sample| !sample.occluded)
                });
                let away = |(x, y): &(usize, usize)| {
                    (2 * x + 1).abs_diff(left + right) + (2 * y + 1).abs_diff(top + bottom)
                };
                let nearest = free.min_by_key(away);
                made.blocks.push(nearest.map(|(x, y)| {
                    made.chosen.push((y * width + x) as u32);
                    made.chosen.len() as u32 - 1
                }));
            }
        }
        made
    }

    /// The samples of the lattice among all.
    pub fn of(&self, samples: &[Sample]) -> Vec<Sample> {
        self.chosen.iter().map(|&i| samples[i as usize]).collect()
    }

    /// Mean difference of light between neighbours of the lattice; a share of the light where there are
    /// none.
    pub fn variation(&self, light: &DirectLight) -> f32 {
        /// What a surface lit at one sample is taken to vary by.
        const UNKNOWN: f32 = 0.3;
        let level = |k: u32| -> f32 {
            let of = |s: &StyleLight| s.irradiance[k as usize].0.element_sum();
            light.styles.iter().map(of).sum()
        };
        let (mut sum, mut pairs) = (0.0, 0);
        for (n, block) in self.blocks.iter().enumerate() {
            let Some(k) = *block else { continue };
            let right = (n + 1) % self.columns != 0;
            let others = [right.then_some(n + 1), Some(n + self.columns)];
            for other in others.into_iter().flatten().filter_map(|m| *self.blocks.get(m)?) {
                sum += (level(k) - level(other)).abs();
                pairs += 1;
            }
        }
        match pairs {
            0 => UNKNOWN * (0..self.chosen.len() as u32).map(level).sum::<f32>(),
            n => sum / n as f32,
        }
    }

    /// Light at all samples of a surface from that at the lattice.
    pub fn spread(&self, light: &DirectLight, samples: &[Sample]) -> DirectLight {
        let shares = samples.iter().enumerate();
        let of = |(i, sample): (usize, &Sample)| {
            if sample.occluded { Vec::new() } else { self.shares(i) }
        };
        light.spread(&shares.map(of).collect::<Vec<_>>())
    }

    /// What the lattice says of a sample: bilinear where all four blocks around have a free sample, else
    /// the nearest.
    fn shares(&self, sample: usize) -> Shares {
        let rows = self.blocks.len() / self.columns;
        let along = |i: usize, blocks: usize| {
            let at = (i as f32 + 0.5) / self.block as f32 - 0.5;
            let at = at.clamp(0.0, (blocks - 1) as f32);
            (at as usize, at.fract())
        };
        let (x, s) = along(sample % self.width, self.columns);
        let (y, t) = along(sample / self.width, rows);
        let around = [
            (0, 0, (1.0 - s) * (1.0 - t)),
            (1, 0, s * (1.0 - t)),
            (0, 1, (1.0 - s) * t),
            (1, 1, s * t),
        ];
        let found: Shares = around
            .into_iter()
            .filter(|c| c.2 > 0.0)
            .filter_map(|(i, j, w)| {
                Some((self.blocks[(y + j) * self.columns + x + i]? as usize, w))
            })
            .collect();
        let sum: f32 = found.iter().map(|f| f.1).sum();
        if sum > 1e-3 {
            return found.into_iter().map(|(k, w)| (k, w / sum)).collect();
        }
        let at = |i: usize| (i % self.width, i / self.width);
        let (u, v) = at(sample);
        let away = |&k: &usize| {
            let (x, y) = at(self.chosen[k] as usize);
            x.abs_diff(u).pow(2) + y.abs_diff(v).pow(2)
        };
        (0..self.chosen.len()).min_by_key(away).map(|k| (k, 1.0)).into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photometry::Irradiance;
    use glam::Vec3;

    fn samples(count: usize, occluded: impl Fn(usize) -> bool) -> Vec<Sample> {
        let sample = |i| Sample { position: Vec3::ZERO, normal: Vec3::Z, occluded: occluded(i) };
        (0..count).map(sample).collect()
    }

    #[test]
    fn a_ramp_is_kept_between_the_middles_of_blocks() {
        let samples = samples(12 * 9, |_| false);
        let lattice = Lattice::new(&samples, 12, 3);
        assert_eq!(lattice.chosen.len(), 12);
        let ramp = |i: usize| 2.0 * (i % 12) as f32 + 5.0 * (i / 12) as f32;
        let light = |i: &u32| Irradiance(Vec3::splat(ramp(*i as usize)));
        let irradiance = lattice.chosen.iter().map(light).collect();
        let styles = vec![StyleLight { style: 7, irradiance }];
        let few = DirectLight { styles, ..DirectLight::default() };
        assert_eq!(lattice.variation(&few), 3.0 * (9.0 * 6.0 + 8.0 * 15.0) / 17.0);
        let all = lattice.spread(&few, &samples);
        for i in 0..samples.len() {
            let inside = (1..11).contains(&(i % 12)) && (1..8).contains(&(i / 12));
            let off = (all.styles[0].irradiance[i].0.x - ramp(i)).abs();
            assert!(off < if inside { 1e-4 } else { 7.1 }, "{i}: {off}");
        }
    }

    #[test]
    fn samples_inside_solid_give_no_light_and_get_none() {
        let samples = samples(8 * 8, |i| i % 8 < 5 || i == 63);
        let lattice = Lattice::new(&samples, 8, 4);
        assert_eq!(lattice.blocks, [None, Some(0), None, Some(1)]);
        let irradiance = vec![Irradiance(Vec3::X); 2];
        let styles = vec![StyleLight { style: 0, irradiance }];
        let all = lattice.spread(&DirectLight { styles, ..DirectLight::default() }, &samples);
        for (e, sample) in all.styles[0].irradiance.iter().zip(&samples) {
            let red = if sample.occluded { 0.0 } else { 1.0 };
            assert!((e.0 - Vec3::X * red).length() < 1e-6);
        }
    }
}
