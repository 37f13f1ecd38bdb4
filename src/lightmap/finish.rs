//! From light to stored levels, in the order of the reference compiler (its section 3.6).

use crate::light::StyleLight;
use crate::photometry::Irradiance;
use glam::Vec3;

/// How light becomes levels on a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinishSettings {
    /// Stored level per light unit (`_range`), at least 0; 0.5 by default.
    pub range: f32,
    /// Output gamma, above 0; 1 by default.
    pub gamma: f32,
    /// Cap on the largest channel, in half light units; 0 is none.
    pub max_light: f32,
    /// Saturation of the light, from 0 (grey) to 1.
    pub colour_scale: f32,
    /// Which maps are stored.
    pub choice: StyleChoice,
}

/// Which of the maps of a face are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StyleChoice {
    /// The most maps of a face.
    pub most: usize,
    /// Keeps maps that are too dim for bytes (all but black ones).
    pub dim: bool,
    /// Keeps maps of styles above [`LAST_BYTE_STYLE`], which only `LMSTYLE16` can name.
    pub wide: bool,
}

impl Default for StyleChoice {
    fn default() -> Self {
        Self { most: 4, dim: false, wide: false }
    }
}

impl Default for FinishSettings {
    fn default() -> Self {
        Self {
            range: 0.5,
            gamma: 1.0,
            max_light: 0.0,
            colour_scale: 1.0,
            choice: StyleChoice::default(),
        }
    }
}

/// Most levels of a sample: the sum of a face's is still within single precision.
const BRIGHTEST: f32 = 1e30;

/// The last light style that a byte names: 255 stands for none.
pub const LAST_BYTE_STYLE: u16 = 254;

/// One stored lightmap.
#[derive(Clone, Debug, PartialEq)]
pub struct FinishedStyle {
    /// Light style, below 65535.
    pub style: u16,
    /// RGB level of each luxel, row by row.
    pub levels: Vec<[u8; 3]>,
    /// The light of each luxel in levels, before it is limited to 255 and truncated.
    pub light: Vec<Vec3>,
    /// Where the light of each luxel comes from, in tangent space (along the texture's s, against its
    /// t, along the normal) and of any length; none unless wanted.
    pub directions: Vec<Vec3>,
}

impl FinishedStyle {
    /// A map of a style from its light in levels.
    pub fn new(style: u16, light: Vec<Vec3>) -> Self {
        let levels = light.iter().copied().map(level).collect();
        Self { style, levels, light, directions: Vec::new() }
    }
}

/// The lightmaps of a face, brightest on average first; those of styles above [`LAST_BYTE_STYLE`] after
/// the others, so that readers of bytes find theirs in the first places.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FinishedFace {
    /// What is stored.
    pub styles: Vec<FinishedStyle>,
    /// Whether any map, even a dropped one, has colour.
    pub coloured: bool,
    /// Maps that found no place.
    pub dropped: u32,
}

/// From samples to luxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Smoothing {
    /// Samples along the edge of a luxel: 1, 2 or 4.
    pub extra: u32,
    /// Radius of a box blur in samples; 0 is none.
    pub soft: u32,
}

/// Scales, fills in luxels inside solid from their neighbours, selects styles and converts to bytes.
/// `occluded` tells for each sample whether it is inside solid; rows are `width` samples long.
pub fn finish(
    maps: Vec<StyleLight>,
    occluded: &[bool],
    width: usize,
    settings: FinishSettings,
    smoothing: Smoothing,
) -> FinishedFace {
    let mut face = FinishedFace::default();
    // (average brightness, style, light)
    let mut kept: Vec<(f32, u16, Vec<Vec3>)> = Vec::new();
    let last_style = if settings.choice.wide { u16::MAX - 1 } else { LAST_BYTE_STYLE };
    for map in maps {
        let mut light: Vec<Vec3> = map.irradiance.iter().map(|&e| scale(e, settings)).collect();
        face.coloured |=
            light.iter().any(|c| (c.y - c.x).abs() > 0.001 || (c.z - c.x).abs() > 0.001);
        let brightest = light.iter().map(|c| brightness(*c)).fold(0.0, f32::max);
        if map.style > last_style {
            face.dropped += 1;
            continue;
        }
        let enough = if settings.choice.dim { brightest > 0.0 } else { brightest >= 1.0 };
        if !enough {
            continue;
        }
        let average = light.iter().map(|c| brightness(*c)).sum::<f32>() / light.len() as f32;
        flood_fill(&mut light, occluded, width);
        let light = reduce(soften(light, width, smoothing.soft), width, smoothing.extra);
        kept.push((average, map.style, light));
    }
    // Stable on the reversed list: of equals, the one made later goes first.
    kept.reverse();
    kept.sort_by(|a, b| b.0.total_cmp(&a.0));
    let most = settings.choice.most;
    face.dropped += kept.len().saturating_sub(most) as u32;
    kept.truncate(most);
    kept.sort_by_key(|map| map.1 > LAST_BYTE_STYLE);
    face.styles =
        kept.into_iter().map(|(_, style, light)| FinishedStyle::new(style, light)).collect();
    face
}

/// Makes luxels of the samples' directions, in the way that [`finish`] does it with their light.
pub(super) fn finish_directions(
    mut vectors: Vec<Vec3>,
    occluded: &[bool],
    width: usize,
    smoothing: Smoothing,
) -> Vec<Vec3> {
    flood_fill(&mut vectors, occluded, width);
    reduce(soften(vectors, width, smoothing.soft), width, smoothing.extra)
}

fn brightness(c: Vec3) -> f32 {
    (c.x + c.y + c.z) / 3.0
}

/// Light units to levels, not yet limited to 255.
pub(super) fn scale(e: Irradiance, settings: FinishSettings) -> Vec3 {
    // `max` would keep -0 and drop NaN: both are wanted here.
    let mut c = e.0.max(Vec3::ZERO);
    if settings.max_light > 0.0 && c.max_element() > 2.0 * settings.max_light {
        c *= 2.0 * settings.max_light / c.max_element();
    }
    if settings.colour_scale != 1.0 {
        c = Vec3::splat(c.max_element()).lerp(c, settings.colour_scale);
    }
    c *= settings.range;
    if settings.gamma != 1.0 {
        c = Vec3::from_array(c.to_array().map(|v| (v / 255.0).powf(1.0 / settings.gamma) * 255.0));
    }
    // What is infinite has no mean.
    c.min(Vec3::splat(BRIGHTEST))
}

/// Limits to 255 keeping the hue, and truncates.
fn level(c: Vec3) -> [u8; 3] {
    let max = c.max_element();
    let c = if max > 255.0 { c * (255.0 / max) } else { c };
    c.to_array().map(|v| v as u8)
}

/// Gives occluded luxels the mean of their filled neighbours, scan after scan, each fill being
/// visible at once to those after it. A face with no free luxel stays as it is.
fn flood_fill(light: &mut [Vec3], occluded: &[bool], width: usize) {
    let mut empty = occluded.to_vec();
    let height = light.len() / width.max(1);
    loop {
        let left = empty.iter().filter(|&&e| e).count();
        if left == 0 || left == empty.len() {
            return;
        }
        for y in 0..height {
            for x in 0..width {
                if !empty[y * width + x] {
                    continue;
                }
                let (mut sum, mut count) = (Vec3::ZERO, 0);
                for v in y.saturating_sub(1)..(y + 2).min(height) {
                    for u in x.saturating_sub(1)..(x + 2).min(width) {
                        if !empty[v * width + u] {
                            sum += light[v * width + u];
                            count += 1;
                        }
                    }
                }
                if count > 0 {
                    light[y * width + x] = sum / count as f32;
                    empty[y * width + x] = false;
                }
            }
        }
    }
}

/// Box blur of radius `soft`; the edges of the map repeat.
fn soften(light: Vec<Vec3>, width: usize, soft: u32) -> Vec<Vec3> {
    if soft == 0 {
        return light;
    }
    let (height, reach) = (light.len() / width, soft as usize);
    let near =
        |at: usize, offset: usize, size: usize| (at + offset).saturating_sub(reach).min(size - 1);
    let count = ((2 * reach + 1) * (2 * reach + 1)) as f32;
    (0..light.len())
        .map(|i| {
            let (x, y) = (i % width, i / width);
            let mut sum = Vec3::ZERO;
            for v in 0..=2 * reach {
                for u in 0..=2 * reach {
                    sum += light[near(y, v, height) * width + near(x, u, width)];
                }
            }
            sum / count
        })
        .collect()
}

/// Mean of each block of `extra` x `extra` samples.
fn reduce(light: Vec<Vec3>, width: usize, extra: u32) -> Vec<Vec3> {
    let extra = extra as usize;
    if extra == 1 {
        return light;
    }
    let columns = width / extra;
    (0..light.len() / (extra * extra))
        .map(|luxel| {
            let (x, y) = (luxel % columns * extra, luxel / columns * extra);
            let rows = (y..y + extra).map(|y| &light[y * width + x..y * width + x + extra]);
            rows.flatten().copied().sum::<Vec3>() / (extra * extra) as f32
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: Smoothing = Smoothing { extra: 1, soft: 0 };

    #[test]
    fn samples_are_blurred_and_averaged() {
        let light: Vec<Vec3> = [0.0, 9.0, 0.0, 0.0].map(Vec3::splat).to_vec();
        assert_eq!(soften(light.clone(), 4, 1), [3.0, 3.0, 3.0, 0.0].map(Vec3::splat));
        let edge: Vec<Vec3> = [9.0, 0.0, 0.0, 0.0].map(Vec3::splat).to_vec();
        assert_eq!(soften(edge, 4, 1)[0], Vec3::splat(6.0), "the edge repeats");
        let block = [1.0, 2.0, 10.0, 10.0, 3.0, 6.0, 10.0, 30.0].map(Vec3::splat).to_vec();
        assert_eq!(reduce(block, 4, 2), [3.0, 15.0].map(Vec3::splat));
    }

    fn map(style: u16, levels: &[f32]) -> StyleLight {
        let irradiance = levels.iter().map(|&v| Irradiance(Vec3::splat(v))).collect();
        StyleLight { style, irradiance }
    }

    fn plain(maps: Vec<StyleLight>) -> FinishedFace {
        let n = maps[0].irradiance.len();
        finish(maps, &vec![false; n], n, FinishSettings::default(), PLAIN)
    }

    #[test]
    fn levels_are_halved_truncated_and_never_negative() {
        let face = plain(vec![map(0, &[3.9, -5.0, 100.0])]);
        assert_eq!(face.styles[0].levels, [[1; 3], [0; 3], [50; 3]]);
        assert!(!face.coloured);
    }

    #[test]
    fn overbright_light_keeps_its_hue() {
        let irradiance = vec![Irradiance(Vec3::new(1020.0, 510.0, 0.0))];
        let face = plain(vec![StyleLight { style: 0, irradiance }]);
        assert_eq!(face.styles[0].levels, [[255, 127, 0]]);
        assert!(face.coloured);
    }

    #[test]
    fn dim_styles_go_and_the_brightest_four_stay_in_order() {
        let maps = (0..7).map(|i| map(i, &[f32::from(i) * 1.9])).collect();
        let face = plain(maps);
        let styles: Vec<u16> = face.styles.iter().map(|s| s.style).collect();
        assert_eq!(styles, [6, 5, 4, 3]);
        assert_eq!(face.dropped, 1, "style 2 has no place, 0 and 1 are too dim to count");
    }

    #[test]
    fn dim_styles_stay_when_asked_for_and_light_is_not_limited() {
        let choice = StyleChoice { most: 6, dim: true, wide: false };
        let settings = FinishSettings { choice, ..FinishSettings::default() };
        let maps = (0..8).map(|i| map(i, &[f32::from(i) * 0.25, 1000.0 * f32::from(i)])).collect();
        let face = finish(maps, &[false; 2], 2, settings, PLAIN);
        let styles: Vec<u16> = face.styles.iter().map(|s| s.style).collect();
        assert_eq!(styles, [7, 6, 5, 4, 3, 2]);
        assert_eq!(face.dropped, 1, "style 1 has no place, 0 is black");
        assert_eq!(face.styles[0].light, [Vec3::splat(0.875), Vec3::splat(3500.0)]);
        assert_eq!(face.styles[0].levels, [[0; 3], [255; 3]]);
    }

    #[test]
    fn of_equal_styles_the_later_goes_first() {
        let face = plain(vec![map(3, &[10.0]), map(1, &[10.0])]);
        assert_eq!(face.styles[0].style, 1);
    }

    #[test]
    fn styles_that_do_not_fit_a_byte_are_dropped() {
        assert!(plain(vec![map(255, &[10.0])]).styles.is_empty());
        assert!(plain(vec![map(300, &[10.0])]).styles.is_empty());
    }

    #[test]
    fn wide_styles_stay_when_asked_for_after_the_others() {
        let choice = StyleChoice { most: 4, dim: false, wide: true };
        let settings = FinishSettings { choice, ..FinishSettings::default() };
        let maps = [(255, 50.0), (9, 20.0), (65534, 90.0), (65535, 99.0), (3, 10.0), (7, 30.0)]
            .map(|(style, light)| map(style, &[light]));
        let face = finish(maps.to_vec(), &[false], 1, settings, PLAIN);
        let styles: Vec<u16> = face.styles.iter().map(|s| s.style).collect();
        assert_eq!(styles, [7, 9, 65534, 255], "the four brightest that can be named");
        assert_eq!(face.dropped, 2);
    }

    #[test]
    fn occluded_luxels_are_filled_from_neighbours() {
        let maps = vec![map(0, &[40.0, 0.0, 0.0, 80.0])];
        let face = finish(maps, &[false, true, true, false], 4, FinishSettings::default(), PLAIN);
        // The second fill already sees the first.
        assert_eq!(face.styles[0].levels, [[20; 3], [20; 3], [30; 3], [40; 3]]);
    }

    #[test]
    fn max_light_and_gamma() {
        let s =
            FinishSettings { range: 1.0, gamma: 2.0, max_light: 32.0, ..FinishSettings::default() };
        let face = finish(vec![map(0, &[255.0, 16.0])], &[false; 2], 2, s, PLAIN);
        // 255 is capped to 64: 255 * sqrt(64 / 255) = 127.7; 16 gives 63.87.
        assert_eq!(face.styles[0].levels, [[127; 3], [63; 3]]);
    }
}
