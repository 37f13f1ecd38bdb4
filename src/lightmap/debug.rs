//! Lightmaps that show how light came about instead of light (contract section 9.3).

use super::faces::{settings_of, spread};
use super::finish::{FinishedFace, Smoothing, StyleChoice, finish};
use crate::light::{self, DirectLight, StyleLight};
use crate::patch::MapPatches;
use crate::photometry::{Exitance, Irradiance};
use crate::radiosity::bounce::PatchLight;
use crate::scene::{Sample, Scene, Surface};
use glam::Vec3;
use rayon::prelude::*;

/// Light units of a channel that is full on.
const FULL: f32 = 255.0;

/// What the lightmaps show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum DebugView {
    /// Dirt: 255 light units where there is none, less where there is more. Turns dirt on
    Dirt,
    /// Normals: red, green and blue are 255 times the size of x, y and z
    Phong,
    /// Samples inside solid in red, all others in green
    Occluded,
    /// The noise of mottled minimum light
    Mottle,
    /// Bounced light alone
    Bounce,
    /// What the patches send back and emit, which bounced light is gathered from
    BounceLights,
}

impl DebugView {
    /// Whether bounced light has to be solved for it.
    pub fn shows_bounces(self) -> bool {
        matches!(self, Self::Bounce | Self::BounceLights)
    }
}

/// What the views are made of: one entry a surface, but `light` has one a style.
#[derive(Clone, Copy)]
pub struct DebugSources<'a> {
    /// The map.
    pub scene: &'a Scene,
    /// Where direct light is sampled.
    pub samples: &'a [Vec<Sample>],
    /// Direct light there.
    pub direct: &'a [DirectLight],
    /// Bounced light at luxels.
    pub indirect: &'a [Vec<StyleLight>],
    /// The patches.
    pub patches: &'a MapPatches,
    /// Their light.
    pub light: &'a [PatchLight],
}

/// The lightmaps of a view. Range, gamma, blur and the choice of styles are those of light.
pub fn debug_faces(
    view: DebugView,
    sources: DebugSources<'_>,
    (smoothing, choice): (Smoothing, StyleChoice),
) -> Vec<FinishedFace> {
    let show = |(index, surface): (usize, &Surface)| {
        let Some(grid) = &surface.luxels else { return FinishedFace::default() };
        let samples = &sources.samples[index];
        let maps = match view {
            DebugView::Bounce => at_samples(&sources.indirect[index], grid.width, smoothing.extra),
            DebugView::BounceLights => {
                at_samples(&patches(sources, index, grid.len()), grid.width, smoothing.extra)
            }
            _ => vec![picture(view, &sources.direct[index], samples)],
        };
        // What is inside solid is part of the other pictures; light is filled in there.
        let filled = view == DebugView::Bounce;
        let occluded: Vec<bool> = samples.iter().map(|s| s.occluded && filled).collect();
        let width = (grid.width * smoothing.extra) as usize;
        let settings = settings_of(sources.scene, surface, choice);
        finish(maps, &occluded, width, settings, smoothing)
    };
    sources.scene.surfaces.par_iter().enumerate().map(show).collect()
}

/// A view that needs no bounced light, as light of style 0.
fn picture(view: DebugView, direct: &DirectLight, samples: &[Sample]) -> StyleLight {
    let colour = |(i, sample): (usize, &Sample)| {
        Irradiance(match view {
            DebugView::Dirt => Vec3::splat(FULL * direct.dirt.share_left(i)),
            DebugView::Phong => sample.normal.abs() * FULL,
            DebugView::Occluded if sample.occluded => Vec3::X * FULL,
            DebugView::Occluded => Vec3::Y * FULL,
            DebugView::Mottle => Vec3::splat(light::mottle(sample.position)),
            DebugView::Bounce | DebugView::BounceLights => Vec3::ZERO,
        })
    };
    StyleLight { style: 0, irradiance: samples.iter().enumerate().map(colour).collect() }
}

/// Exitance of the patch that each luxel has most part in, by style.
fn patches(sources: DebugSources<'_>, surface: usize, luxels: usize) -> Vec<StyleLight> {
    let MapPatches { first, luxels: parts, .. } = sources.patches;
    let (Some(&from), Some(&to)) = (first.get(surface), first.get(surface + 1)) else {
        return Vec::new();
    };
    let mut owner: Vec<(f32, Option<usize>)> = vec![(0.0, None); luxels];
    for (patch, part) in parts.iter().enumerate().take(to as usize).skip(from as usize) {
        for &(luxel, weight) in part {
            let slot = &mut owner[luxel as usize];
            if weight > slot.0 {
                *slot = (weight, Some(patch));
            }
        }
    }
    let of_style = |light: &PatchLight| {
        let sent = |patch: &Option<usize>| patch.map_or(Exitance::ZERO, |p| light.exitance[p]);
        let irradiance = owner.iter().map(|(_, patch)| Irradiance(sent(patch).0)).collect();
        StyleLight { style: light.style, irradiance }
    };
    sources.light.iter().map(of_style).collect()
}

/// Light of luxels at their samples.
fn at_samples(maps: &[StyleLight], width: u32, extra: u32) -> Vec<StyleLight> {
    let spread = |map: &StyleLight| StyleLight {
        style: map.style,
        irradiance: spread(&map.irradiance, width, extra),
    };
    maps.iter().map(spread).collect()
}
