//! Light of some samples put in the place of that of others.

use super::{DirectLight, StyleDirections, StyleLight};
use crate::photometry::Irradiance;
use glam::Vec3;
use std::ops::Range;

/// Samples and the shares that they have in another.
pub(super) type Shares = Vec<(usize, f32)>;

impl DirectLight {
    /// Light at other samples, each a sum of shares of those here.
    pub(super) fn spread(&self, shares: &[Shares]) -> Self {
        let spread = |styles: &[StyleLight]| {
            let of = |light: &StyleLight| StyleLight {
                style: light.style,
                irradiance: sums(shares, |k| light.irradiance[k].0).map(Irradiance).collect(),
            };
            styles.iter().map(of).collect()
        };
        let mut directions = self.directions.clone();
        for of in directions.styles_mut() {
            of.vectors = sums(shares, |k| of.vectors[k]).collect();
        }
        Self {
            styles: spread(&self.styles),
            negative: spread(&self.negative),
            excess: spread(&self.excess),
            local_minimum: spread(&self.local_minimum),
            directions,
            dirt: self.dirt.spread(shares),
            rays: self.rays,
        }
    }

    /// Puts the light of the samples in `range` into that of `count`.
    pub(super) fn put(&mut self, range: &Range<usize>, part: &Self, count: usize) {
        let lists = [
            (&mut self.styles, &part.styles),
            (&mut self.negative, &part.negative),
            (&mut self.excess, &part.excess),
            (&mut self.local_minimum, &part.local_minimum),
        ];
        for (all, part) in lists {
            all.iter_mut().for_each(|l| l.irradiance[range.clone()].fill(Irradiance::ZERO));
            for light in part {
                let known = all.iter().position(|l| l.style == light.style).unwrap_or_else(|| {
                    let irradiance = vec![Irradiance::ZERO; count];
                    all.push(StyleLight { style: light.style, irradiance });
                    all.len() - 1
                });
                all[known].irradiance[range.clone()].copy_from_slice(&light.irradiance);
            }
        }
        let all = self.directions.styles_mut();
        all.iter_mut().for_each(|d| d.vectors[range.clone()].fill(Vec3::ZERO));
        for of in part.directions.styles() {
            let known = all.iter().position(|d| d.style == of.style).unwrap_or_else(|| {
                all.push(StyleDirections { style: of.style, vectors: vec![Vec3::ZERO; count] });
                all.len() - 1
            });
            all[known].vectors[range.clone()].copy_from_slice(&of.vectors);
        }
        self.dirt.put(range, &part.dirt, count);
        self.rays += part.rays;
    }
}

fn sums<'a>(
    shares: &'a [Shares],
    of: impl Fn(usize) -> Vec3 + 'a,
) -> impl Iterator<Item = Vec3> + 'a {
    shares.iter().map(move |s| s.iter().map(|&(k, share)| of(k) * share).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(style: u16, values: &[f32]) -> StyleLight {
        let irradiance = values.iter().map(|&v| Irradiance(Vec3::splat(v))).collect();
        StyleLight { style, irradiance }
    }

    #[test]
    fn parts_replace_what_was_there() {
        let coarse = vec![light(0, &[1.0; 4]), light(3, &[2.0; 4])];
        let mut all = DirectLight { styles: coarse, ..DirectLight::default() };
        let part = vec![light(5, &[7.0, 8.0]), light(0, &[5.0, 6.0])];
        all.put(&(1..3), &DirectLight { styles: part, ..DirectLight::default() }, 4);
        let expected = [
            light(0, &[1.0, 5.0, 6.0, 1.0]),
            light(3, &[2.0, 0.0, 0.0, 2.0]),
            light(5, &[0.0, 7.0, 8.0, 0.0]),
        ];
        assert_eq!(all.styles, expected);
    }
}
