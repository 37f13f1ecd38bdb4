//! Patches so bright that the cells of a hemicube tell their light too roughly: a lamp close to a wall
//! makes some. From afar such a patch is seen in one cell or in none. Its light is corrected by what rays
//! to points of it find.

use super::transfers::Transfers;
use crate::patch::{MapPatches, Overlay};
use crate::photometry::{Exitance, Irradiance};
use crate::scene::{Scene, ShadowRays};
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::PI;

/// A patch is a highlight whose exitance is more than this many times that below which...
const BRIGHT: f32 = 20.0;
/// ...this share of all reflected light is.
const DIM: f64 = 0.25;
/// Highlights of all styles, at most; a style gets at most half of what those before it left.
pub(super) const MOST: usize = 512;
/// Hemicubes do from distances whose square is less than so many times the area.
const NEAR: f32 = 4.0;
/// Rays to a highlight that gives more than [`MUCH`] of what is usual; one to others.
const RAYS: usize = 4;
const MUCH: f32 = 0.02;

/// A patch that is much brighter than others.
#[derive(Clone, Debug)]
struct Highlight {
    patch: u32,
    area: f32,
    normal: Vec3,
    exitance: Vec3,
    /// Points of it, and the share of its light that comes from them and those before.
    points: Vec<(Vec3, f32)>,
}

/// The highlights of a light style.
#[derive(Clone, Debug, Default)]
pub struct Highlights {
    all: Vec<Highlight>,
    /// The number of each patch among them; empty if there are none.
    numbers: Vec<u16>,
    /// What most patches are as bright as.
    usual: f32,
}

const NONE: u16 = u16::MAX;

impl Highlights {
    /// Those among `patches` whose first light, per patch, is `first`; their final exitance is
    /// `exitance`. `luxels` is the direct light of each surface; so many highlights are `left` to be found.
    pub(super) fn find(
        scene: &Scene,
        patches: &MapPatches,
        (first, exitance): (&[Vec3], &[Exitance]),
        luxels: &[&[Irradiance]],
        left: &mut usize,
    ) -> Self {
        let all = &patches.set.patches;
        let brightness = |i: usize| first[i].element_sum() / 3.0;
        let mut order: Vec<usize> = (0..all.len()).filter(|&i| brightness(i) > 0.0).collect();
        order.sort_by(|&a, &b| brightness(a).total_cmp(&brightness(b)).then(a.cmp(&b)));
        let light = |i: usize| f64::from(brightness(i)) * f64::from(all[i].area);
        let whole: f64 = order.iter().map(|&i| light(i)).sum();
        let mut sum = 0.0;
        let usual = order.iter().find(|&&i| {
            sum += light(i);
            sum >= DIM * whole
        });
        let Some(usual) = usual.map(|&i| brightness(i)) else { return Self::default() };
        let from = order.partition_point(|&i| brightness(i) <= BRIGHT * usual);
        let mut chosen = order.split_off(from);
        chosen.retain(|&i| exitance[i] != Exitance::ZERO);
        let strength = |i: usize| light(i) * f64::from(brightness(i));
        chosen.sort_by(|&a, &b| strength(b).total_cmp(&strength(a)).then(a.cmp(&b)));
        // Those that reflect most for their size.
        chosen.truncate(left.div_ceil(2));
        chosen.sort_unstable();
        let mut found = Self { all: Vec::new(), numbers: Vec::new(), usual };
        for i in chosen {
            let points = points(scene, patches, i, luxels);
            if points.is_empty() {
                continue;
            }
            found.numbers.resize(all.len(), NONE);
            found.numbers[i] = found.all.len() as u16;
            let (area, normal, exitance) = (all[i].area, all[i].normal, exitance[i].0);
            found.all.push(Highlight { patch: i as u32, area, normal, exitance, points });
        }
        *left -= found.all.len();
        found
    }

    /// A correction of what arrives at points of a map; `None` if there is nothing to correct.
    pub(crate) fn correction<'a>(
        &'a self,
        scene: &'a Scene,
        patches: &'a MapPatches,
    ) -> Option<Correction<'a>> {
        let overlay = patches.set.overlay.as_deref();
        (!self.all.is_empty()).then(|| Correction::new(self, scene, overlay))
    }

    /// Corrects what arrives at the patches from the highlights.
    pub(super) fn correct_patches(
        &self,
        scene: &Scene,
        patches: &MapPatches,
        transfers: &Transfers,
        irradiance: &mut [Irradiance],
    ) {
        if self.all.is_empty() {
            return;
        }
        let groups = patches.groups();
        let corrections: Vec<Vec3> = (0..transfers.rows())
            .into_par_iter()
            .map_init(
                || Correction::new(self, scene, patches.set.overlay.as_deref()),
                |correction, i| {
                    if transfers.first_of(i) != i {
                        return Vec3::ZERO;
                    }
                    let eye = transfers.eye(i, &patches.set, &groups);
                    correction.stand(eye, patches.set.patches[i].normal);
                    let mut sum = correction.light();
                    for (patch, f) in transfers.entries(i) {
                        if let Some(exitance) = correction.takes(patch) {
                            sum -= exitance * f64::from(f);
                        }
                    }
                    for &(patch, f) in transfers.overlay_row(i) {
                        if let Some(exitance) = correction.takes(patch) {
                            sum -= exitance * f.as_dvec3();
                        }
                    }
                    sum.as_vec3()
                },
            )
            .collect();
        for (i, e) in irradiance.iter_mut().enumerate() {
            let corrected = e.0 + corrections[transfers.first_of(i)];
            // What hemicubes saw is taken off: rounding may leave less than nothing.
            *e = Irradiance(corrected.max(e.0.min(Vec3::ZERO)));
        }
    }
}

/// Points of a patch that shine: its luxels, each with what share of the light comes from them and
/// those before.
fn points(
    scene: &Scene,
    patches: &MapPatches,
    patch: usize,
    luxels: &[&[Irradiance]],
) -> Vec<(Vec3, f32)> {
    let surface = patches.surface[patch] as usize;
    let Some(grid) = scene.surfaces[surface].luxels.as_ref() else { return Vec::new() };
    let light = |k: u32| luxels[surface].get(k as usize).map_or(0.0, |e| e.0.element_sum());
    let mut sum = 0.0;
    let mut points: Vec<(Vec3, f32)> = patches.luxels[patch]
        .iter()
        .map(|&(k, weight)| {
            sum += weight * light(k).max(0.0);
            let at = Vec2::new((k % grid.width) as f32, (k / grid.width) as f32);
            (grid.world_of(at) + scene.surfaces[surface].normal, sum)
        })
        .collect();
    points.iter_mut().for_each(|p| p.1 /= sum);
    if sum > 0.0 { points } else { Vec::new() }
}

/// The light of highlights, point by point, instead of what hemicubes there see of it.
pub(crate) struct Correction<'a> {
    highlights: &'a Highlights,
    shadows: ShadowRays<'a>,
    overlay: Option<&'a Overlay>,
    at: Vec3,
    normal: Vec3,
    /// Whether each is so near that the hemicube does.
    near: Vec<bool>,
}

impl<'a> Correction<'a> {
    fn new(highlights: &'a Highlights, scene: &'a Scene, overlay: Option<&'a Overlay>) -> Self {
        let near = vec![false; highlights.all.len()];
        let shadows = ShadowRays::new(scene.bounce_tracer());
        Self { highlights, shadows, overlay, at: Vec3::ZERO, normal: Vec3::Z, near }
    }

    /// Goes to a point; all else is about this point.
    pub(crate) fn stand(&mut self, at: Vec3, normal: Vec3) {
        (self.at, self.normal) = (at, normal);
        for (near, highlight) in self.near.iter_mut().zip(&self.highlights.all) {
            let way = highlight.points[0].0 - at;
            *near = way.length_squared() < NEAR * highlight.area;
        }
    }

    /// The exitance of a patch whose light is not to be taken from a hemicube.
    pub(crate) fn takes(&self, patch: u32) -> Option<DVec3> {
        let &number = self.highlights.numbers.get(patch as usize)?;
        let far = number != NONE && !self.near[number as usize];
        far.then(|| self.highlights.all[number as usize].exitance.as_dvec3())
    }

    /// Irradiance from these.
    pub(crate) fn light(&mut self) -> DVec3 {
        let mut sum = DVec3::ZERO;
        let highlights = self.highlights.all.iter().zip(&self.near);
        for highlight in highlights.filter_map(|(h, near)| (!near).then_some(h)) {
            let points = &highlight.points;
            let usual = factor(highlight, points[0].0 - self.at, self.normal);
            let level = highlight.exitance.element_sum() / 3.0 * usual;
            let rays = if level > MUCH * self.highlights.usual { RAYS } else { 1 };
            let start = start(self.at, highlight.patch);
            let mut arriving = Vec3::ZERO;
            for ray in 0..rays {
                let place = (start + ray as f32 / rays as f32).fract();
                let point = points.partition_point(|p| p.1 <= place).min(points.len() - 1);
                let point = points[point].0;
                let factor = factor(highlight, point - self.at, self.normal);
                if factor > 0.0 && !self.shadows.blocked(self.at, point) {
                    arriving += self.tint(self.at, point) * factor;
                }
            }
            sum += (highlight.exitance * arriving / rays as f32).as_dvec3();
        }
        sum
    }

    /// What translucent polygons let through.
    fn tint(&self, from: Vec3, to: Vec3) -> Vec3 {
        let Some(overlay) = self.overlay else { return Vec3::ONE };
        let (from, to) = (from.as_dvec3(), to.as_dvec3());
        let tint = |(t, polygon)| overlay.tint(polygon, from + (to - from) * t, to - from);
        overlay.crossings(from, to).into_iter().map(tint).product::<DVec3>().as_vec3()
    }
}

/// Form factor of a small disc of the highlight's area that is `way` off.
fn factor(highlight: &Highlight, way: Vec3, normal: Vec3) -> f32 {
    let distance = way.length();
    let cosines = way.dot(normal).max(0.0) * (-way.dot(highlight.normal)).max(0.0);
    highlight.area * cosines / (distance * distance * (PI * distance * distance + highlight.area))
}

/// Where rays from a point start among the points of a patch, from 0 to 1.
fn start(at: Vec3, patch: u32) -> f32 {
    let mix = |seed: u32, x: f32| (seed ^ x.to_bits()).wrapping_mul(0x9E37_79B1).rotate_left(13);
    let bits = at.to_array().into_iter().fold(patch.wrapping_mul(0x85EB_CA6B), mix);
    (bits >> 8) as f32 / (1 << 24) as f32
}
