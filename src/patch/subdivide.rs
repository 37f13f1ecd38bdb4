//! Cutting the faces of a map into patches along their luxel grids.
//!
//! A patch is a block of luxel intervals, clipped to the face polygon. So its mean irradiance comes
//! from the luxels inside it, with bilinear interpolation between them as the engine draws them, and
//! no second sampling exists.

use super::polygon2::{moments, strip};
use super::{Intervals, Patch, PatchGrid, PatchId, PatchLookup, PatchSet, PolygonPatches};
use crate::photometry::{Exitance, Irradiance, Reflectance};
use crate::scene::{Emitter, LuxelGrid, Sample, Scene, Surface};
use glam::{DVec2, Vec2};
use rayon::prelude::*;

/// Distance of a patch's eye from its surface in world units: where luxels are sampled too.
const LIFT: f32 = 1.0;

/// Blocks with a smaller share of a full luxel's area than this join a neighbour.
const SMALLEST: f64 = 1e-3;

/// Patches of a map.
#[derive(Debug, Default)]
pub struct MapPatches {
    /// The patches and how to find them.
    pub set: PatchSet,
    /// Surface of each patch.
    pub surface: Vec<u32>,
    /// Luxels that make up each patch and their weights, which sum to 1; empty when all luxels of
    /// the patch are inside solid.
    pub luxels: Vec<Vec<(u32, f32)>>,
    /// First patch of each surface, and one more entry: surface i has `first[i]..first[i + 1]`.
    pub first: Vec<u32>,
    /// Their luxel intervals.
    pub intervals: Intervals,
}

/// Light that the patches of a map give off by themselves, in one style.
#[derive(Clone, Debug)]
pub struct Emission {
    /// The light style.
    pub style: u16,
    /// One entry a patch.
    pub exitance: Vec<Exitance>,
    /// What counts of it where its light bounces: `exitance` with the `bouncescale` of the lights.
    pub bouncing: Vec<Exitance>,
}

/// One block while it is being summed up.
#[derive(Clone, Default)]
struct Block {
    area: f64,
    moment: DVec2,
    luxels: Vec<(u32, f32)>,
}

/// The blocks of one face.
struct FaceBlocks {
    grid: PatchGrid,
    blocks: Vec<Block>,
    /// Corner weights of each luxel interval.
    intervals: Vec<[f32; 4]>,
}

impl MapPatches {
    /// Cuts every face with luxels into blocks of at most `size` luxel intervals a side. `samples`
    /// holds the luxels of each surface.
    pub fn new(scene: &Scene, samples: &[Vec<Sample>], size: u32) -> Self {
        let faces: Vec<Option<FaceBlocks>> = scene
            .surfaces
            .par_iter()
            .zip(samples)
            .map(|(surface, samples)| Some(cut(surface, surface.luxels.as_ref()?, samples, size)))
            .collect();
        let mut patches = Self::default();
        let mut grids = Vec::with_capacity(faces.len());
        for (index, face) in faces.into_iter().enumerate() {
            patches.first.push(patches.surface.len() as u32);
            patches.intervals.next_surface();
            grids.push(face.map(|face| patches.add_face(scene, samples, index, face)));
        }
        patches.first.push(patches.surface.len() as u32);
        patches.intervals.next_surface();
        let grid_of = |surface: Option<u32>| {
            let surface = surface.filter(|&s| scene.surfaces[s as usize].reflects)?;
            // Slats of a fence share its patches.
            let grid = grids[surface as usize].as_ref().filter(|g| !g.blocks.is_empty())?;
            Some((surface, grid.clone()))
        };
        let mut divisions = Vec::new();
        for (polygon, surface) in scene.bounce_surfaces().enumerate() {
            divisions.push(match grid_of(surface) {
                Some((surface, grid)) => {
                    patches.intervals.polygons[surface as usize] = Some(polygon as u32);
                    PolygonPatches::Grid(grid)
                }
                None => PolygonPatches::None,
            });
        }
        patches.set.lookup = PatchLookup::new(divisions);
        patches
    }

    /// Appends the patches of a face and completes its grid with their numbers.
    fn add_face(
        &mut self,
        scene: &Scene,
        samples: &[Vec<Sample>],
        index: usize,
        face: FaceBlocks,
    ) -> PatchGrid {
        let surface = &scene.surfaces[index];
        let luxels = surface.luxels.as_ref().expect("only faces with luxels are cut");
        let unit = f64::from(luxels.s_step.cross(luxels.t_step).length());
        let mut grid = face.grid;
        grid.first_interval = self.intervals.add(luxels.width, face.intervals.iter().copied());
        let kept: Vec<bool> = face.blocks.iter().map(|b| b.area > SMALLEST).collect();
        let mut number = self.surface.len() as u32;
        let numbers: Vec<u32> = kept
            .iter()
            .map(|&kept| {
                number += u32::from(kept);
                number.wrapping_sub(1)
            })
            .collect();
        grid.blocks = (0..kept.len())
            .filter_map(|b| nearest_kept(&kept, grid.columns, b).map(|b| PatchId(numbers[b])))
            .collect();
        for (block, _) in face.blocks.into_iter().zip(kept).filter(|&(_, kept)| kept) {
            let centroid = (block.moment / block.area).as_vec2();
            let eye = luxels.world_of(centroid) + surface.normal * LIFT;
            self.set.patches.push(Patch {
                eye: free_eye(scene, eye, &samples[index], &block.luxels),
                normal: surface.normal,
                area: (block.area * unit) as f32,
                reflectance: if surface.reflects {
                    surface.reflectance
                } else {
                    Reflectance::default()
                },
            });
            self.surface.push(index as u32);
            self.luxels.push(block.luxels);
        }
        grid
    }

    /// What each patch emits, by light style.
    pub fn emission(&self, emitters: &[Emitter]) -> Vec<Emission> {
        let mut styles: Vec<Emission> = Vec::new();
        for e in emitters {
            let i = styles.iter().position(|s| s.style == e.style).unwrap_or_else(|| {
                let exitance = vec![Exitance::ZERO; self.surface.len()];
                styles.push(Emission { style: e.style, bouncing: exitance.clone(), exitance });
                styles.len() - 1
            });
            let patches = self.first[e.surface as usize]..self.first[e.surface as usize + 1];
            for patch in patches {
                styles[i].exitance[patch as usize] += e.exitance;
                styles[i].bouncing[patch as usize] += e.exitance * e.bounce_scale;
            }
        }
        styles
    }

    /// Mean irradiance of each patch, given that of the luxels of each surface (empty for none).
    pub fn mean_irradiance(&self, luxels: &[&[Irradiance]]) -> Vec<Irradiance> {
        self.luxels
            .par_iter()
            .zip(&self.surface)
            .map(|(weights, &surface)| {
                let light = luxels[surface as usize];
                if light.is_empty() {
                    return Irradiance::ZERO;
                }
                weights
                    .iter()
                    .fold(Irradiance::ZERO, |sum, &(luxel, w)| sum + light[luxel as usize] * w)
            })
            .collect()
    }
}

/// Sums up the blocks of a face, luxel interval by luxel interval.
fn cut(surface: &Surface, luxels: &LuxelGrid, samples: &[Sample], size: u32) -> FaceBlocks {
    let size = patch_size(surface, luxels, size);
    let intervals = [luxels.width - 1, luxels.height - 1];
    let block_column = division(intervals[0], size);
    let block_row = division(intervals[1], size);
    let count = |d: &[u16]| d.last().map_or(0, |&b| b as usize + 1);
    let columns = count(&block_column);
    let mut blocks = vec![Block::default(); columns * count(&block_row)];
    let mut pieces = vec![[0.0; 4]; intervals[0] as usize * intervals[1] as usize];
    let outline: Vec<DVec2> =
        surface.vertices.iter().map(|&v| luxels.luxel_of(v).as_dvec2()).collect();
    for j in 0..intervals[1] {
        let row = strip(&outline, 1, f64::from(j), f64::from(j + 1));
        for i in 0..intervals[0] {
            let (area, moment) = moments(&strip(&row, 0, f64::from(i), f64::from(i + 1)));
            if area <= 0.0 {
                continue;
            }
            let b = block_row[j as usize] as usize * columns + block_column[i as usize] as usize;
            let block = &mut blocks[b];
            block.area += area;
            block.moment += moment;
            let inside = (moment / area - DVec2::new(f64::from(i), f64::from(j))).as_vec2();
            let corners = corners(luxels.width, [i, j], inside, samples);
            pieces[(j * intervals[0] + i) as usize] = corners.map(|c| c.1);
            let weighed = corners.into_iter().filter(|c| c.1 > 0.0);
            block.luxels.extend(weighed.map(|(l, w)| (l, w * area as f32)));
        }
    }
    for block in &mut blocks {
        settle(&mut block.luxels);
    }
    let grid = PatchGrid {
        s_row: luxels.s_row,
        t_row: luxels.t_row,
        block_column,
        block_row,
        blocks: Vec::new(),
        columns,
        first_interval: 0,
    };
    FaceBlocks { grid, blocks, intervals: pieces }
}

/// Luxels along a patch: `size` of the luxels that the texture gives, whatever the size of those that
/// the map asks for.
fn patch_size(surface: &Surface, luxels: &LuxelGrid, size: u32) -> u32 {
    let Some(vanilla) = &surface.vanilla_luxels else { return size };
    let edge = |grid: &LuxelGrid| grid.s_step.cross(grid.t_step).length().sqrt();
    let size = size as f32 * edge(vanilla) / edge(luxels);
    // Casting limits what is out of range.
    (size.round() as u32).max(1)
}

/// Block of each of `intervals` luxel intervals when they are shared out evenly among the fewest
/// blocks of at most `size`.
fn division(intervals: u32, size: u32) -> Vec<u16> {
    let blocks = intervals.div_ceil(size.max(1));
    (0..intervals)
        .map(|i| (u64::from(i) * u64::from(blocks) / u64::from(intervals)) as u16)
        .collect()
}

/// The four luxels around a piece of an interval and their bilinear weights at its centroid, shared out
/// among those that are not inside solid: they sum to 1, or to 0 if all are.
fn corners(width: u32, interval: [u32; 2], inside: Vec2, samples: &[Sample]) -> [(u32, f32); 4] {
    let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(di, dj)| {
        let luxel = (interval[1] + dj) * width + interval[0] + di;
        let along = |d: u32, x: f32| if d == 0 { 1.0 - x } else { x };
        let weight = (along(di, inside.x) * along(dj, inside.y)).clamp(0.0, 1.0);
        let free = samples.get(luxel as usize).is_some_and(|s| !s.occluded);
        (luxel, if free { weight } else { 0.0 })
    });
    let sum: f32 = corners.iter().map(|c| c.1).sum();
    corners.map(|(l, w)| (l, if sum > 0.0 { w / sum } else { 0.0 }))
}

/// Merges entries of the same luxel and makes the weights sum to 1.
fn settle(list: &mut Vec<(u32, f32)>) {
    list.sort_by_key(|&(luxel, _)| luxel);
    list.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    let sum: f32 = list.iter().map(|&(_, w)| w).sum();
    for (_, w) in list.iter_mut() {
        *w /= sum;
    }
    list.shrink_to_fit();
}

/// The kept block nearest to block `from` in the grid, first one on ties.
fn nearest_kept(kept: &[bool], columns: usize, from: usize) -> Option<usize> {
    let at = |b: usize| [(b % columns) as i64, (b / columns) as i64];
    let distance = |b: usize| {
        let ([x, y], [u, v]) = (at(b), at(from));
        (x - u).pow(2) + (y - v).pow(2)
    };
    (0..kept.len()).filter(|&b| kept[b]).min_by_key(|&b| distance(b))
}

/// `eye`, or if that is inside solid the position of the patch's nearest luxel that is not.
fn free_eye(
    scene: &Scene,
    eye: glam::Vec3,
    samples: &[Sample],
    luxels: &[(u32, f32)],
) -> glam::Vec3 {
    if !scene.solid.contains(0, eye) {
        return eye;
    }
    luxels
        .iter()
        .map(|&(luxel, _)| samples[luxel as usize].position)
        .min_by(|a, b| a.distance_squared(eye).total_cmp(&b.distance_squared(eye)))
        .unwrap_or(eye)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_shared_out_evenly() {
        assert_eq!(division(5, 4), [0, 0, 0, 1, 1]);
        assert_eq!(division(8, 4), [0, 0, 0, 0, 1, 1, 1, 1]);
        assert_eq!(division(3, 4), [0, 0, 0]);
        assert!(division(0, 4).is_empty());
        for n in 1..40 {
            let d = division(n, 4);
            for b in 0..=*d.last().unwrap() {
                let members = d.iter().filter(|&&x| x == b).count();
                assert!((1..=4).contains(&members), "{n}: {d:?}");
            }
        }
    }

    #[test]
    fn weights_of_a_luxel_list_sum_to_one() {
        let mut list = vec![(3, 0.5), (1, 1.0), (3, 0.5)];
        settle(&mut list);
        assert_eq!(list, [(1, 0.5), (3, 0.5)]);
    }

    #[test]
    fn dropped_blocks_fall_to_the_nearest_kept() {
        let kept = [false, false, true, false, false, true];
        assert_eq!(nearest_kept(&kept, 3, 0), Some(2));
        assert_eq!(nearest_kept(&kept, 3, 4), Some(5));
        assert_eq!(nearest_kept(&[false], 1, 0), None);
    }
}
