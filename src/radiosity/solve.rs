//! Solving the radiosity equation M_i = E_i + rho_i (D_i + sum_j F_ij M_j) by passes of gathering. Where
//! light passes through sheets, M_i also has tau_k times what meets the other side k.

use super::transfers::Transfers;
use crate::patch::Passage;
use crate::photometry::{Exitance, Irradiance, Reflectance};
use glam::{DVec3, Vec3};

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Largest number of passes (bounces), `None` for no limit.
    pub passes: Option<u32>,
    /// Done when the light still to be sent is at most this share of all light, in (0, 1).
    pub residual: f64,
}

/// Light at the patches of a scene before any bounce.
#[derive(Clone, Copy, Debug)]
pub struct Sources<'a> {
    /// What each patch emits itself.
    pub emission: &'a [Exitance],
    /// Irradiance of each patch from lights that are not patches; empty for none.
    pub direct: &'a [Irradiance],
}

/// Final exitance of one light style.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Exitance of each patch: emission and what it reflects.
    pub exitance: Vec<Exitance>,
    /// Passes made.
    pub passes: u32,
    /// Share of all light that was still to be sent.
    pub residual: f64,
    /// Whether the residual fell to the limit before the passes were used up.
    pub settled: bool,
}

/// Sends the light on, pass by pass: what a patch reflects in one pass is what it sends in the next.
/// Sums run in a fixed order in double precision, so the bytes do not depend on the number of
/// threads. `reflectance` below 1 makes it converge.
pub fn solve(
    transfers: &Transfers,
    reflectance: &[Reflectance],
    sources: Sources<'_>,
    limits: Limits,
) -> Solution {
    solve_with(transfers, reflectance, &[], sources, limits)
}

/// The same where light passes through patches diffusely: with `passages`, of which reflectance and
/// transmittance together are below 1.
pub fn solve_with(
    transfers: &Transfers,
    reflectance: &[Reflectance],
    passages: &[Passage],
    sources: Sources<'_>,
    limits: Limits,
) -> Solution {
    let mut total: Vec<DVec3> = sources.emission.iter().map(|m| limited(m.0)).collect();
    let mut unsent = total.clone();
    // Irradiance that the next pass reflects besides what the patches send each other.
    let mut direct: Vec<DVec3> = sources.direct.iter().map(|e| limited(e.0)).collect();
    let mut passes = 0;
    loop {
        let left = largest(&unsent).max(largest(&direct));
        let all = largest(&total).max(left);
        let residual = if all > 0.0 { left / all } else { 0.0 };
        let settled = residual <= limits.residual;
        if settled || limits.passes.is_some_and(|n| passes >= n) {
            let exitance =
                total.into_iter().map(|m| Exitance(limited(m.as_vec3()).as_vec3())).collect();
            return Solution { exitance, passes, residual, settled };
        }
        unsent = if largest(&unsent) > 0.0 {
            transfers.gather(&unsent)
        } else {
            vec![DVec3::ZERO; unsent.len()]
        };
        for (sum, e) in unsent.iter_mut().zip(direct.drain(..)) {
            *sum += e;
        }
        let through = |p: &Passage| p.transmittance.as_dvec3() * unsent[p.from.0 as usize];
        let through: Vec<DVec3> = passages.iter().map(through).collect();
        for (m, rho) in unsent.iter_mut().zip(reflectance) {
            *m *= rho.0.as_dvec3();
        }
        for (passage, light) in passages.iter().zip(through) {
            unsent[passage.to.0 as usize] += light;
        }
        for (m, total) in unsent.iter().zip(&mut total) {
            *total += *m;
        }
        passes += 1;
    }
}

/// Light that is no finite number would never settle: it becomes 0 or the largest that a map can hold.
fn limited(light: Vec3) -> DVec3 {
    const MOST: f32 = 1e30;
    let channel = |c: f32| if c.is_nan() { 0.0 } else { c.clamp(-MOST, MOST) };
    Vec3::from_array(light.to_array().map(channel)).as_dvec3()
}

/// Largest absolute value of any channel.
fn largest(light: &[DVec3]) -> f64 {
    light.iter().fold(0.0, |max, m| max.max(m.abs().max_element()))
}
