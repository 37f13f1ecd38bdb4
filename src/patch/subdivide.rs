//! Cutting the faces of a map into patches along their luxel grids.
//!
//! A patch is a block of luxel intervals, clipped to the face polygon. So its mean irradiance comes
//! from the luxels inside it, with bilinear interpolation between them as the engine draws them, and
//! no second sampling exists. Thin walls and doors that stand within a block divide it: `cuts`.

use super::blocks::{Block, FaceBlocks, LIFT};
use super::spots::Spots;
use super::{
    Glow, Intervals, Overlay, Patch, PatchGrid, PatchId, PatchLookup, PatchSet, Pattern,
    PolygonPatches, Sheet, Tint,
};
use crate::photometry::{Exitance, Irradiance, Reflectance};
use crate::scene::{Emitter, Sample, Scene, Surface, luxels};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

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
    /// How far apart the middles of whole patches are on each surface, in world units; 0 without patches.
    pub spacing: Vec<f32>,
    /// First patch of each surface, and one more entry: surface i has `first[i]..first[i + 1]`.
    pub first: Vec<u32>,
    /// Their luxel intervals.
    pub intervals: Intervals,
    /// Share and colour of what each patch emits, where only parts of a surface do; empty for none.
    pub glow: Vec<Vec3>,
    /// How many have a reflectance of their own, as that of their surface varies.
    pub patterned: usize,
    /// Mean reflectance of each luxel interval of the surfaces on which it varies.
    pub(super) varied: BTreeMap<usize, Vec<Vec3>>,
}

/// Light that the patches of a map give off by themselves, in one style.
#[derive(Clone, Debug)]
pub struct Emission {
    /// The light style.
    pub style: u16,
    /// One entry a patch, and then one for each glow of the overlay.
    pub exitance: Vec<Exitance>,
    /// What counts of it where its light bounces: `exitance` with the `bouncescale` of the lights.
    pub bouncing: Vec<Exitance>,
}

impl MapPatches {
    /// Cuts every face with luxels into blocks of at most `size` luxel intervals a side. `samples`
    /// holds the luxels of each surface.
    pub fn new(scene: &Scene, samples: &[Vec<Sample>], size: u32) -> Self {
        let faces: Vec<Option<FaceBlocks>> = scene
            .surfaces
            .par_iter()
            .zip(samples)
            .map(|(surface, samples)| FaceBlocks::cut(scene, surface, samples, size))
            .collect();
        let mut patches = Self::default();
        let mut patterns = Vec::new();
        let mut grids = Vec::with_capacity(faces.len());
        for (index, face) in faces.into_iter().enumerate() {
            patches.first.push(patches.surface.len() as u32);
            patches.intervals.next_surface();
            patches.spacing.push(0.0);
            grids.push(
                face.map(|face| patches.add_face(scene, samples, (index, face), &mut patterns)),
            );
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
        let (polygons, panes) = scene.panes();
        let sheet = |pane| Sheet { tint: Tint::Pane(pane), sides: [None; 2] };
        let sheets = panes.into_iter().map(sheet).collect();
        patches.set.passages = patches.passages(scene, &patterns);
        let glows = (patches.glows(scene, &patterns), patches.set.patches.len());
        patches.set.overlay = Overlay::with_glows(polygons, sheets, patterns, glows).map(Arc::new);
        patches
    }

    /// What patches give off by themselves that is spread otherwise than what they reflect.
    fn glows(&self, scene: &Scene, patterns: &[Option<Pattern>]) -> Vec<Glow> {
        let mut glows = Vec::new();
        let shining: BTreeMap<u32, Vec<bool>> =
            scene.emitters.iter().fold(BTreeMap::new(), |mut of, e| {
                of.entry(e.surface).or_insert_with(Vec::new).push(e.varied);
                of
            });
        for (&surface, varied) in &shining {
            let shading = scene.shading(surface as usize);
            let Some(shading) = shading.filter(|_| scene.surfaces[surface as usize].reflects)
            else {
                continue;
            };
            for i in self.first[surface as usize]..self.first[surface as usize + 1] {
                let (patch, mean) = (PatchId(i), self.glow.get(i as usize).copied());
                let texels = varied.contains(&true) && shading.glows_unevenly();
                if let Some(mean) = mean.filter(|&m| texels && m != Vec3::ZERO) {
                    let pattern = Some(Pattern::of_glow(shading.clone(), mean));
                    glows.push(Glow { patch, pattern });
                }
                let reflects = matches!(patterns.get(i as usize), Some(Some(_)));
                if varied.contains(&false) && reflects {
                    glows.push(Glow { patch, pattern: None });
                }
            }
        }
        glows.sort_by_key(|glow| glow.patch);
        glows
    }

    /// Appends the patches of a face, and the `patterns` of those that send light on unevenly, and completes its
    /// grid with their numbers.
    fn add_face(
        &mut self,
        scene: &Scene,
        samples: &[Vec<Sample>],
        (index, face): (usize, FaceBlocks),
        patterns: &mut Vec<Option<Pattern>>,
    ) -> PatchGrid {
        let surface = &scene.surfaces[index];
        let luxels = surface.luxels.as_ref().expect("only faces with luxels are cut");
        let unit = f64::from(luxels.s_step.cross(luxels.t_step).length());
        self.spacing[index] = face.size() as f32 * unit.sqrt() as f32;
        self.intervals.add(luxels.width, face.intervals().iter().copied());
        let (mut grid, blocks) = face.into_patches(self.surface.len() as u32);
        grid.complete(index as u32);
        let spots = scene.varies(index).then(|| Spots::of(surface, luxels));
        let mut of_patches = BTreeMap::new();
        if let Some(spots) = &spots {
            of_patches = spots.of_patches(luxels, &grid);
            let of = |points| Some(scene.mean_albedo(index, points)? * surface.reflected_share());
            let varied: Option<Vec<Vec3>> = spots.of_intervals(luxels).map(of).collect();
            self.varied.extend(varied.map(|varied| (index, varied)));
        }
        for block in blocks {
            let centroid = (block.moment / block.area).as_vec2();
            let eye = luxels.world_of(centroid) + surface.normal * LIFT;
            let here = PatchId(self.set.patches.len() as u32);
            let points = of_patches.remove(&here).unwrap_or_default();
            // Slivers may have none.
            let points = || points.iter().copied().chain(points.is_empty().then_some(eye));
            let varied = scene.mean_albedo(index, points());
            self.patterned += usize::from(varied.is_some());
            let shading = scene.uneven(index).filter(|_| surface.reflects);
            if let (Some(mean), Some(shading)) = (varied, shading) {
                patterns.resize(self.surface.len(), None);
                patterns.push(Some(Pattern::of_surface(shading.clone(), surface.albedo(), mean)));
            }
            if let Some(glow) = scene.mean_glow(index, points()) {
                self.glow.resize(self.surface.len(), Vec3::ZERO);
                self.glow.push(glow);
            }
            self.set.patches.push(Patch {
                eye: free_eye(scene, surface, eye, &samples[index], &block),
                normal: surface.normal,
                area: (block.area * unit) as f32,
                reflectance: if surface.reflects {
                    let of = |albedo| Reflectance(albedo * surface.reflected_share());
                    varied.map_or(surface.reflectance, of)
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
        let overlay = self.set.overlay.as_deref();
        let columns = self.set.columns();
        for e in emitters {
            let i = styles.iter().position(|s| s.style == e.style).unwrap_or_else(|| {
                let exitance = vec![Exitance::ZERO; columns];
                styles.push(Emission { style: e.style, bouncing: exitance.clone(), exitance });
                styles.len() - 1
            });
            let patches = self.first[e.surface as usize]..self.first[e.surface as usize + 1];
            for patch in patches {
                let patch = patch as usize;
                let share = if e.varied { self.glow.get(patch) } else { None };
                let exitance = share.map_or(e.exitance, |&share| Exitance(e.exitance.0 * share));
                let id = PatchId(patch as u32);
                let glows = overlay.into_iter().flat_map(|o| o.glows_of(id));
                let own = glows.filter(|(_, glow)| glow.pattern.is_some() == e.varied);
                for column in std::iter::once(id).chain(own.map(|(column, _)| column)) {
                    styles[i].exitance[column.0 as usize] += exitance;
                    styles[i].bouncing[column.0 as usize] += exitance * e.bounce_scale;
                }
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

/// `eye`, or if that is inside solid or in a divided block the position of the patch's nearest luxel that
/// is not.
fn free_eye(
    scene: &Scene,
    surface: &Surface,
    eye: Vec3,
    samples: &[Sample],
    block: &Block,
) -> Vec3 {
    let model = surface.model.unwrap_or(0) as usize;
    if !block.divided && !luxels::in_solid(scene, model, eye - surface.offset) {
        return eye;
    }
    let positions = block.luxels.iter().map(|&(luxel, _)| samples[luxel as usize].position);
    positions
        .min_by(|a, b| a.distance_squared(eye).total_cmp(&b.distance_squared(eye)))
        .unwrap_or(eye)
}
