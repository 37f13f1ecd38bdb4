//! Bouncing the light of a map: every light style over one set of transfers.

use super::solve::{Limits, Sources, solve_with};
use super::transfers::Transfers;
use crate::light::StyleLight;
use crate::patch::{Detail, Emission, MapPatches, PatchSet};
use crate::photometry::{Exitance, Irradiance, Reflectance};
use crate::scene::BounceSettings;
use glam::{DVec3, Vec3};
use std::borrow::Cow;
use std::collections::BTreeSet;

/// The solution of one light style.
#[derive(Clone, Debug)]
pub struct PatchLight {
    /// The light style.
    pub style: u16,
    /// Final exitance of each patch.
    pub exitance: Vec<Exitance>,
    /// Indirect irradiance of each patch: what it receives from that exitance.
    pub irradiance: Vec<Irradiance>,
    /// Light that comes through from the other side, as the irradiance that would look the same on this
    /// side; empty where none does.
    pub passing: Vec<Irradiance>,
    /// How the exitance of luxel intervals differs from that of their patches.
    pub detail: Detail,
}

/// All styles of a map.
#[derive(Clone, Debug, Default)]
pub struct Bounced {
    /// One solution a style, by ascending style; styles that reach no patch are left out.
    pub styles: Vec<PatchLight>,
    /// Most bounces that any style took.
    pub bounces: u32,
    /// Largest share of light left unsent in any style.
    pub residual: f64,
}

/// Solves each style: patches emit `emission`, reflect the mean of the direct light of their luxels
/// (`direct`, for each surface), and then each other's light. Direct light may be below zero; so is what
/// comes of it. `advance(n)` is told of every n styles done.
pub fn bounce(
    patches: &MapPatches,
    transfers: &Transfers,
    direct: &[Cow<'_, [StyleLight]>],
    emission: &[Emission],
    limits: Limits,
    advance: impl Fn(u64),
) -> Bounced {
    let passages = &patches.set.passages;
    let reflectance: Vec<Reflectance> = patches.set.patches.iter().map(|p| p.reflectance).collect();
    let mut bounced = Bounced::default();
    for style in styles(direct, emission) {
        let luxels = luxels_of(direct, style);
        let mut arriving = patches.mean_irradiance(&luxels);
        let of_lights = arriving.clone();
        let dark = vec![Exitance::ZERO; reflectance.len()];
        let own = emission.iter().find(|e| e.style == style);
        // Emission that bounces by another factor than it shines with is direct light that happens to
        // come from patches.
        let apart = own.filter(|e| e.exitance != e.bouncing);
        if let Some(emission) = apart {
            for (sum, e) in arriving.iter_mut().zip(received(transfers, &emission.bouncing)) {
                *sum += e;
            }
        }
        let emitted = own.filter(|_| apart.is_none()).map_or(&dark, |e| &e.exitance);
        let sources = Sources { emission: emitted, direct: &arriving };
        let mut solution = solve_with(transfers, &reflectance, passages, sources, limits);
        for (m, e) in solution.exitance.iter_mut().zip(apart.iter().flat_map(|a| &a.exitance)) {
            *m += *e;
        }
        bounced.bounces = bounced.bounces.max(solution.passes);
        bounced.residual = bounced.residual.max(solution.residual);
        advance(1);
        if solution.exitance.iter().all(|m| *m == Exitance::ZERO) {
            continue;
        }
        let irradiance = received(transfers, &solution.exitance);
        let passing = if limits.passes == Some(0) {
            Vec::new()
        } else {
            passing(&patches.set, &irradiance, &of_lights)
        };
        bounced.styles.push(PatchLight {
            style,
            irradiance,
            passing,
            detail: if limits.passes == Some(0) {
                Vec::new()
            } else {
                patches.detail(&luxels, &of_lights)
            },
            exitance: solution.exitance,
        });
    }
    bounced
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

/// What the patches receive of each other's exitance.
fn received(transfers: &Transfers, exitance: &[Exitance]) -> Vec<Irradiance> {
    let exitance: Vec<DVec3> = exitance.iter().map(|m| m.0.as_dvec3()).collect();
    transfers.gather(&exitance).into_iter().map(|e| Irradiance(e.as_vec3())).collect()
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
