//! Direct light as patches take it up.

use super::{DirectLight, StyleLight, accumulate};
use crate::photometry::Irradiance;
use crate::scene::Sample;
use std::borrow::Cow;

/// Direct light of a surface at its luxels, `width` in a row, as it bounces: less what negative lights
/// take away, which may leave less than none; without the excess that copies of surface lights give
/// right in front of their surface; with the `bouncescale` of each light; and averaged over the `extra`
/// x `extra` samples of each luxel, those inside solid left out.
pub fn bounce_source<'a>(
    direct: &'a DirectLight,
    samples: &[Sample],
    width: u32,
    extra: u32,
) -> Cow<'a, [StyleLight]> {
    if direct.excess.is_empty() && direct.negative.is_empty() && extra == 1 {
        return Cow::Borrowed(&direct.styles);
    }
    let mut styles = direct.styles.clone();
    for negative in &direct.negative {
        accumulate(&mut styles, negative);
    }
    for excess in &direct.excess {
        for light in styles.iter_mut().filter(|s| s.style == excess.style) {
            for (e, more) in light.irradiance.iter_mut().zip(&excess.irradiance) {
                *e = *e - *more;
            }
        }
    }
    if extra > 1 {
        for light in &mut styles {
            light.irradiance = means(&light.irradiance, samples, width as usize, extra as usize);
        }
    }
    Cow::Owned(styles)
}

/// Mean of the free samples of each luxel, zero where there is none.
fn means(fine: &[Irradiance], samples: &[Sample], width: usize, extra: usize) -> Vec<Irradiance> {
    let luxels = fine.len() / (extra * extra);
    (0..luxels)
        .map(|luxel| {
            let (column, row) = (luxel % width * extra, luxel / width * extra);
            let (mut sum, mut free) = (Irradiance::ZERO, 0);
            for y in row..row + extra {
                for i in y * width * extra + column..y * width * extra + column + extra {
                    if !samples[i].occluded {
                        sum += fine[i];
                        free += 1;
                    }
                }
            }
            sum * (1.0 / free.max(1) as f32)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn luxels_take_the_mean_of_their_free_samples() {
        let e = |v: f32| Irradiance(Vec3::splat(v));
        let sample = |occluded| Sample { position: Vec3::ZERO, normal: Vec3::Z, occluded };
        // Two luxels beside each other, 2 x 2 samples each.
        let fine = [1.0, 2.0, 10.0, 20.0, 3.0, 4.0, 90.0, 90.0].map(e);
        let samples = [false, false, false, false, false, false, true, true].map(sample);
        assert_eq!(means(&fine, &samples, 2, 2), [e(2.5), e(15.0)]);
    }

    #[test]
    fn excess_does_not_bounce() {
        let light = |v: f32| StyleLight { style: 3, irradiance: vec![Irradiance(Vec3::splat(v))] };
        let sample = [Sample { position: Vec3::ZERO, normal: Vec3::Z, occluded: false }];
        let mut direct = DirectLight { styles: vec![light(9.0)], ..DirectLight::default() };
        assert!(matches!(bounce_source(&direct, &sample, 1, 1), Cow::Borrowed(_)));
        direct.excess = vec![light(8.0)];
        assert_eq!(*bounce_source(&direct, &sample, 1, 1), [light(1.0)]);
    }
}
