//! Bouncing the light of a map: every light style over one set of transfers.

use super::solve::{Limits, Sources, solve};
use super::transfers::Transfers;
use crate::light::StyleLight;
use crate::patch::{Detail, Emission, MapPatches};
use crate::photometry::{Exitance, Irradiance, Reflectance};
use glam::DVec3;
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
/// (`direct`, for each surface), and then each other's light. `advance(n)` is told of every n styles done.
pub fn bounce(
    patches: &MapPatches,
    transfers: &Transfers,
    direct: &[Cow<'_, [StyleLight]>],
    emission: &[Emission],
    limits: Limits,
    advance: impl Fn(u64),
) -> Bounced {
    let reflectance: Vec<Reflectance> = patches.set.patches.iter().map(|p| p.reflectance).collect();
    let mut bounced = Bounced::default();
    for style in styles(direct, emission) {
        let luxels = luxels_of(direct, style);
        let arriving = patches.mean_irradiance(&luxels);
        let dark = vec![Exitance::ZERO; reflectance.len()];
        let emitted = emission.iter().find(|e| e.style == style).map_or(&dark, |e| &e.exitance);
        let sources = Sources { emission: emitted, direct: &arriving };
        let solution = solve(transfers, &reflectance, sources, limits);
        bounced.bounces = bounced.bounces.max(solution.passes);
        bounced.residual = bounced.residual.max(solution.residual);
        advance(1);
        if solution.exitance.iter().all(|m| *m == Exitance::ZERO) {
            continue;
        }
        let exitance: Vec<DVec3> = solution.exitance.iter().map(|m| m.0.as_dvec3()).collect();
        let received = transfers.gather(&exitance);
        bounced.styles.push(PatchLight {
            style,
            detail: if limits.passes == Some(0) {
                Vec::new()
            } else {
                patches.detail(&luxels, &arriving)
            },
            exitance: solution.exitance,
            irradiance: received.into_iter().map(|e| Irradiance(e.as_vec3())).collect(),
        });
    }
    bounced
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
