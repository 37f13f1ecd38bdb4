//! Bouncing the light of a map: every light style over one set of transfers.

use super::channels::{Channels, channels, colour};
use super::highlights::{self, Highlights};
use super::solve::{Limits, Solution, Sources, Surfaces, solve_styles};
use super::transfers::{AT_A_TIME, Transfers};
use crate::light::StyleLight;
use crate::patch::{Detail, Emission, MapPatches, PatchSet};
use crate::photometry::{Exitance, Irradiance, Reflectance};
use crate::scene::{BounceSettings, Scene};
use glam::Vec3;
use std::borrow::Cow;
use std::collections::BTreeSet;

/// The solution of one light style.
#[derive(Clone, Debug)]
pub struct PatchLight {
    /// The light style.
    pub style: u16,
    /// Final exitance of each patch, and then of each glow of the overlay.
    pub exitance: Vec<Exitance>,
    /// Indirect irradiance of each patch: what it receives from that exitance.
    pub irradiance: Vec<Irradiance>,
    /// Light that comes through from the other side, as the irradiance that would look the same on this
    /// side; empty where none does.
    pub passing: Vec<Irradiance>,
    /// How the exitance of luxel intervals differs from that of their patches.
    pub detail: Detail,
    /// Patches whose light is corrected where hemicubes see it too roughly.
    pub(crate) highlights: Highlights,
}

/// All styles of a map.
#[derive(Clone, Debug, Default)]
pub struct Bounced {
    /// One solution a style, by ascending style; styles that reach no patch are left out.
    pub styles: Vec<PatchLight>,
    /// Most passes that any style took: bounces, if there is a limit to these.
    pub passes: u32,
    /// Largest share of light left unsent in any style.
    pub residual: f64,
    /// Most channels that any style was carried in; `None` without bounces.
    pub channels: Option<Channels>,
}

/// Solves each style: patches emit `emission`, reflect the mean of the direct light of their luxels
/// (`direct`, for each surface), and then each other's light. Direct light may be below zero; so is what
/// comes of it. `advance(n)` is told of every n styles done.
pub fn bounce(
    scene: &Scene,
    patches: &MapPatches,
    transfers: &Transfers,
    direct: &[Cow<'_, [StyleLight]>],
    emission: &[Emission],
    limits: Limits,
    advance: impl Fn(u64),
) -> Bounced {
    let set = &patches.set;
    let reflectance: Vec<Reflectance> = set.patches.iter().map(|p| p.reflectance).collect();
    let surfaces = Surfaces { transfers, reflectance: &reflectance, passages: &set.passages };
    let mut bounced = Bounced::default();
    let mut left = highlights::MOST;
    let styles: Vec<u16> = styles(direct, emission).into_iter().collect();
    for styles in styles.chunks(AT_A_TIME) {
        let starts: Vec<Start<'_>> =
            styles.iter().map(|&s| Start::new(patches, transfers, direct, emission, s)).collect();
        let sources: Vec<Sources<'_>> = starts.iter().map(Start::sources).collect();
        let shining = starts.iter().map(|s| Sources { emission: s.apart, direct: &[] });
        let channels = Channels::of(surfaces, sources.iter().copied().chain(shining));
        let mut solutions = solve_styles(surfaces, &sources, limits, channels);
        for (start, solution) in starts.iter().zip(&mut solutions) {
            start.add_what_shines(&mut solution.exitance);
            bounced.passes = bounced.passes.max(solution.passes);
            bounced.residual = bounced.residual.max(solution.residual);
        }
        bounced.channels = bounced.channels.max(Some(channels));
        advance(styles.len() as u64);
        let lit = |(_, solution): &(Start<'_>, Solution)| {
            solution.exitance.iter().any(|m| *m != Exitance::ZERO)
        };
        let lit: Vec<_> = starts.into_iter().zip(solutions).filter(lit).collect();
        let exitance: Vec<&[Exitance]> = lit.iter().map(|(_, s)| &s.exitance[..]).collect();
        let received = received(transfers, &exitance, channels);
        for ((start, solution), mut irradiance) in lit.into_iter().zip(received) {
            let highlights = start.highlights(scene, patches, &solution.exitance, &mut left);
            highlights.correct_patches(scene, patches, transfers, &mut irradiance);
            let light = start.light(patches, solution.exitance, irradiance, limits);
            bounced.styles.push(PatchLight { highlights, ..light });
        }
    }
    bounced
}

/// A light style before its light bounces.
struct Start<'a> {
    style: u16,
    /// Direct light at luxels.
    luxels: Vec<&'a [Irradiance]>,
    /// Direct light at patches.
    of_lights: Vec<Irradiance>,
    /// Emission that bounces as it shines.
    emitted: Cow<'a, [Exitance]>,
    /// Irradiance that bounces: direct light, and what is received of emission that bounces by another factor
    /// than it shines with, as if it were direct light that happens to come from patches.
    arriving: Vec<Irradiance>,
    /// Such emission as it shines.
    apart: &'a [Exitance],
}

impl<'a> Start<'a> {
    fn new(
        patches: &MapPatches,
        transfers: &Transfers,
        direct: &'a [Cow<'_, [StyleLight]>],
        emission: &'a [Emission],
        style: u16,
    ) -> Self {
        let luxels = luxels_of(direct, style);
        let of_lights = patches.mean_irradiance(&luxels);
        let dark = Cow::Owned(vec![Exitance::ZERO; patches.set.columns()]);
        let mut start = Self {
            style,
            luxels,
            arriving: of_lights.clone(),
            of_lights,
            emitted: dark,
            apart: &[],
        };
        match emission.iter().find(|e| e.style == style) {
            Some(own) if own.exitance != own.bouncing => {
                let bouncing = received(transfers, &[&own.bouncing], Channels::Three);
                for (sum, e) in start.arriving.iter_mut().zip(bouncing.into_iter().flatten()) {
                    *sum += e;
                }
                start.apart = &own.exitance;
            }
            Some(own) => start.emitted = Cow::Borrowed(&own.exitance),
            None => {}
        }
        start
    }

    fn sources(&self) -> Sources<'_> {
        Sources { emission: &self.emitted, direct: &self.arriving }
    }

    fn add_what_shines(&self, exitance: &mut [Exitance]) {
        for (m, e) in exitance.iter_mut().zip(self.apart) {
            *m += *e;
        }
    }

    /// The patches that are much brighter than others by this light alone; so many may be `left` to find.
    fn highlights(
        &self,
        scene: &Scene,
        patches: &MapPatches,
        exitance: &[Exitance],
        left: &mut usize,
    ) -> Highlights {
        let rho = patches.set.patches.iter().map(|p| p.reflectance.0);
        let first: Vec<Vec3> = self.of_lights.iter().zip(rho).map(|(e, rho)| e.0 * rho).collect();
        Highlights::find(scene, patches, (&first, exitance), &self.luxels, left)
    }

    /// The style with its solution.
    fn light(
        self,
        patches: &MapPatches,
        exitance: Vec<Exitance>,
        irradiance: Vec<Irradiance>,
        limits: Limits,
    ) -> PatchLight {
        let Self { style, luxels, of_lights, .. } = self;
        let (mut through, mut detail) = (Vec::new(), Vec::new());
        if limits.passes != Some(0) {
            through = passing(&patches.set, &irradiance, &of_lights);
            detail = patches.detail(&luxels, &of_lights);
        }
        let highlights = Highlights::default();
        PatchLight { style, exitance, irradiance, passing: through, detail, highlights }
    }
}

/// Direct light as the keys of worldspawn let it bounce: `bouncescale` and `bouncestyled`.
pub fn ruled<'a>(light: Cow<'a, [StyleLight]>, rules: &BounceSettings) -> Cow<'a, [StyleLight]> {
    let kept = |style: u16| style == 0 || rules.styled;
    if rules.scale == 1.0 && light.iter().all(|l| kept(l.style)) {
        return light;
    }
    let mut light = light.into_owned();
    light.retain(|l| kept(l.style));
    for e in light.iter_mut().flat_map(|l| &mut l.irradiance) {
        *e = *e * rules.scale;
    }
    Cow::Owned(light)
}

/// The same for what patches emit: it shines in any case.
pub fn rule_emission(emission: &mut [Emission], rules: &BounceSettings) {
    for e in emission {
        let scale = if e.style == 0 || rules.styled { rules.scale } else { 0.0 };
        e.bouncing.iter_mut().for_each(|m| *m = *m * scale);
    }
}

/// What the patches receive of each other's exitance, for each style.
fn received(
    transfers: &Transfers,
    exitance: &[&[Exitance]],
    channels: Channels,
) -> Vec<Vec<Irradiance>> {
    match channels {
        Channels::One => received_in::<1>(transfers, exitance),
        Channels::Three => received_in::<3>(transfers, exitance),
    }
}

fn received_in<const C: usize>(
    transfers: &Transfers,
    exitance: &[&[Exitance]],
) -> Vec<Vec<Irradiance>> {
    let light: Vec<Vec<[f64; C]>> =
        exitance.iter().map(|m| m.iter().map(|m| channels(m.0)).collect()).collect();
    let lists: Vec<&[[f64; C]]> = light.iter().map(Vec::as_slice).collect();
    let received = transfers.gather_all(&lists);
    received.into_iter().map(|e| e.into_iter().map(|e| Irradiance(colour(e))).collect()).collect()
}

/// Textures show exitance as reflected irradiance: what comes through looks as bright with this more.
fn passing(set: &PatchSet, bounced: &[Irradiance], direct: &[Irradiance]) -> Vec<Irradiance> {
    /// Surfaces that reflect nothing would have to be lit without end.
    const LEAST: Vec3 = Vec3::splat(0.05);
    if set.passages.is_empty() {
        return Vec::new();
    }
    let mut passing = vec![Irradiance::ZERO; bounced.len()];
    for p in &set.passages {
        let (from, to) = (p.from.0 as usize, p.to.0 as usize);
        let arriving = bounced[from].0 + direct[from].0;
        let reflectance = set.patches[to].reflectance.0.max(LEAST);
        passing[to] += Irradiance(arriving * p.transmittance / reflectance);
    }
    passing
}

/// The styles that [`bounce`] solves.
pub fn styles(direct: &[Cow<'_, [StyleLight]>], emission: &[Emission]) -> BTreeSet<u16> {
    let lit = direct.iter().flat_map(|d| d.iter().map(|s| s.style));
    lit.chain(emission.iter().map(|e| e.style)).collect()
}

/// Direct light of one style at the luxels of each surface, empty where there is none.
fn luxels_of<'a>(direct: &'a [Cow<'_, [StyleLight]>], style: u16) -> Vec<&'a [Irradiance]> {
    direct
        .iter()
        .map(|d| d.iter().find(|s| s.style == style).map_or(&[][..], |s| &s.irradiance))
        .collect()
}
