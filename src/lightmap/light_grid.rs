//! Light at the points of the light grid: direct light as at the probes of brush models, and bounced
//! light from all around.

use super::finish::{FinishSettings, scale};
use crate::Result;
use crate::bsp::{BspxLump, GridPoint, GridStyle, octree_lump, sides_lump};
use crate::light::{self, SIDES};
use crate::patch::MapPatches;
use crate::photometry::Irradiance;
use crate::radiosity::bounce::PatchLight;
use crate::radiosity::hemicube::{DeltaFormFactors, HemicubeSize, View};
use crate::radiosity::transfers::Gatherer;
use crate::scene::{GridFormat, LightGrid, Scene};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Styles of a point that engines have room for.
const MOST_STYLES: usize = 4;
/// Cells along a hemicube: few, as what they see is summed up and stored in whole levels.
const CELLS: u32 = 32;
/// Points between reports of progress.
const CHUNK: usize = 64;
/// Hemicubes in these directions see everything.
const WHOLE: [Vec3; 2] = [Vec3::Z, Vec3::NEG_Z];

/// The solution that the points gather from.
#[derive(Clone, Copy)]
pub struct GridSources<'a> {
    /// The map.
    pub scene: &'a Scene,
    /// Its patches.
    pub patches: &'a MapPatches,
    /// Their light in every style.
    pub light: &'a [PatchLight],
}

/// The lump of a grid. `advance(n)` is told of every n points done.
///
/// Where a point has one colour, each direct light counts as on the best lit side of a cube, as in the
/// reference, and bounced light as the mean of all sides: it comes from everywhere, and the best side
/// for every patch would add up to more than any surface gets.
///
/// # Errors
/// If the lump would pass 2 GiB.
pub fn light_grid(
    sources: GridSources<'_>,
    grid: &LightGrid,
    advance: impl Fn(u64) + Sync,
) -> Result<BspxLump> {
    let size = HemicubeSize::new(CELLS, CELLS).expect("an even number in range");
    match grid.format {
        GridFormat::Octree => {
            let kind = Kind {
                size,
                weights: DeltaFormFactors::of_sphere(size),
                along: &WHOLE,
                direct: |scene, position| {
                    let light = light::probe(scene, position);
                    light.into_iter().map(|(style, light)| (style, [light])).collect()
                },
                bounced: |halves| [Irradiance((halves[0] + halves[1]).as_vec3())],
            };
            octree_lump(&grid.place, &points(sources, grid, &kind, advance))
        }
        GridFormat::Sides => {
            let kind = Kind {
                size,
                weights: DeltaFormFactors::new(size),
                along: &SIDES,
                direct: light::probe_sides,
                bounced: |sides| std::array::from_fn(|side| Irradiance(sides[side].as_vec3())),
            };
            sides_lump(&grid.place, &points(sources, grid, &kind, advance))
        }
    }
}

/// Light of a point on so many sides, by style.
type Styles<const N: usize> = Vec<(u16, [Irradiance; N])>;

/// How the light of a point is found.
struct Kind<const N: usize> {
    /// Of the hemicubes, which look along these directions.
    size: HemicubeSize,
    weights: DeltaFormFactors,
    along: &'static [Vec3],
    /// Direct light at a place.
    direct: fn(&Scene, Vec3) -> Styles<N>,
    /// Bounced irradiance from that of the hemicubes.
    bounced: fn(&[DVec3]) -> [Irradiance; N],
}

/// Every point.
fn points<const N: usize>(
    GridSources { scene, patches, light }: GridSources<'_>,
    grid: &LightGrid,
    kind: &Kind<N>,
    advance: impl Fn(u64) + Sync,
) -> Vec<GridPoint<N>> {
    let exitance: Vec<Vec<Vec3>> =
        light.iter().map(|l| l.exitance.iter().map(|m| m.0).collect()).collect();
    let settings = FinishSettings {
        range: scene.world.range,
        gamma: scene.world.gamma,
        max_light: scene.world.max_light,
        ..FinishSettings::default()
    };
    let count = grid.place.len();
    let chunks: Vec<Vec<GridPoint<N>>> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map_init(
            || Gatherer::new(scene.bounce_tracer(), &patches.set, &kind.weights, kind.size),
            |gatherer, chunk| {
                let members = chunk * CHUNK..((chunk + 1) * CHUNK).min(count);
                let done = members.len() as u64;
                let points = members
                    .map(|index| {
                        let position = light::probe_place(scene, grid.place.position(index))?;
                        let mut styles = (kind.direct)(scene, position);
                        let around =
                            around(gatherer, position, index as u64, kind.along, &exitance);
                        for (light, around) in light.iter().zip(around) {
                            add(&mut styles, light.style, (kind.bounced)(&around));
                        }
                        Some(levels(styles, settings))
                    })
                    .collect();
                advance(done);
                points
            },
        )
        .collect();
    chunks.into_iter().flatten().collect()
}

/// Bounced irradiance of each style, by hemicubes in these directions.
fn around(
    gatherer: &mut Gatherer<'_>,
    position: Vec3,
    seed: u64,
    directions: &[Vec3],
    exitance: &[Vec<Vec3>],
) -> Vec<Vec<DVec3>> {
    let mut styles = vec![Vec::with_capacity(directions.len()); exitance.len()];
    if exitance.is_empty() {
        return styles;
    }
    let mut sums = Vec::new();
    for direction in directions {
        gatherer.look(&View::turned(position, *direction, seed));
        gatherer.irradiance(exitance, &mut sums);
        for (style, sum) in styles.iter_mut().zip(&sums) {
            style.push(*sum);
        }
    }
    styles
}

/// Adds light to that of the same style.
fn add<const N: usize>(styles: &mut Styles<N>, style: u16, light: [Irradiance; N]) {
    match styles.iter_mut().find(|s| s.0 == style) {
        Some(sums) => sums.1.iter_mut().zip(light).for_each(|(sum, e)| *sum += e),
        None => styles.push((style, light)),
    }
}

/// Light as stored: the brightest styles first, levels rounded, what is black left out.
fn levels<const N: usize>(styles: Styles<N>, settings: FinishSettings) -> Vec<GridStyle<N>> {
    let mut scaled: Vec<(u8, [Vec3; N])> = styles
        .into_iter()
        .filter_map(|(style, light)| {
            let style = u8::try_from(style).ok().filter(|style| *style < 255)?;
            Some((style, light.map(|e| scale(e, settings))))
        })
        .collect();
    let total = |light: &[Vec3; N]| light.iter().map(|c| c.element_sum()).sum::<f32>();
    scaled.sort_by(|a, b| total(&b.1).total_cmp(&total(&a.1)).then(a.0.cmp(&b.0)));
    scaled.truncate(MOST_STYLES);
    let rounded =
        scaled.into_iter().map(|(style, light)| GridStyle { style, levels: light.map(round) });
    rounded.filter(|entry| entry.levels != [[0; 3]; N]).collect()
}

/// Limits to 255 keeping the hue, and rounds.
fn round(light: Vec3) -> [u8; 3] {
    let most = light.max_element();
    let light = if most > 255.0 { light * (255.0 / most) } else { light };
    light.to_array().map(|v| v.round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_styles_are_kept_in_order_and_rounded() {
        let light = |v: f32| [Irradiance(Vec3::new(v, 0.0, 0.0))];
        let styles = vec![
            (3, light(2.9)),
            (300, light(9000.0)),
            (7, light(0.98)),
            (9, light(3.1)),
            (1, light(1020.0)),
            (2, light(-50.0)),
            (4, light(2.9)),
        ];
        let kept = levels(styles, FinishSettings::default());
        let got: Vec<(u8, u8)> = kept.iter().map(|s| (s.style, s.levels[0][0])).collect();
        assert_eq!(got, [(1, 255), (9, 2), (3, 1), (4, 1)]);
        let dim = levels(vec![(0, light(0.9)), (5, light(-1.0))], FinishSettings::default());
        assert!(dim.is_empty());
    }

    #[test]
    fn the_hue_of_bright_light_stays() {
        assert_eq!(round(Vec3::new(510.0, 255.0, 0.4)), [255, 128, 0]);
        assert_eq!(round(Vec3::new(0.5, 0.49, f32::NAN)), [1, 0, 0]);
    }
}
