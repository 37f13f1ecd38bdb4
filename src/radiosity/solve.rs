//! Solving the radiosity equation M_i = M0_i + rho_i sum_j F_ij M_j by passes of gathering.

use super::transfers::Transfers;
use crate::photometry::{Exitance, Reflectance};
use glam::DVec3;
use rayon::prelude::*;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Largest number of passes (bounces), `None` for no limit.
    pub passes: Option<u32>,
    /// Done when the light still to be sent is at most this share of all light, in (0, 1).
    pub residual: f64,
}

/// Final exitance of one light style.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Exitance of each patch, initial exitance included.
    pub exitance: Vec<Exitance>,
    /// Passes made.
    pub passes: u32,
    /// Share of all light that was still to be sent.
    pub residual: f64,
    /// Whether the residual fell to the limit before the passes were used up.
    pub settled: bool,
}

/// Sends the initial exitance on, pass by pass: what a patch reflects in one pass is what it sends
/// in the next. Sums run in a fixed order in double precision, so the bytes do not depend on the
/// number of threads. `reflectance` below 1 makes it converge.
pub fn solve(
    transfers: &Transfers,
    reflectance: &[Reflectance],
    initial: &[Exitance],
    limits: Limits,
) -> Solution {
    let mut total: Vec<DVec3> = initial.iter().map(|m| m.0.as_dvec3()).collect();
    let mut unsent = total.clone();
    let mut passes = 0;
    loop {
        let (left, all) = (largest(&unsent), largest(&total));
        let residual = if all > 0.0 { left / all } else { 0.0 };
        let settled = residual <= limits.residual;
        if settled || limits.passes.is_some_and(|n| passes >= n) {
            let exitance = total.into_iter().map(|m| Exitance(m.as_vec3())).collect();
            return Solution { exitance, passes, residual, settled };
        }
        unsent = transfers.gather(&unsent);
        unsent.par_iter_mut().zip(&mut total).zip(reflectance).with_min_len(1024).for_each(
            |((m, total), rho)| {
                *m *= rho.0.as_dvec3();
                *total += *m;
            },
        );
        passes += 1;
    }
}

/// Largest absolute value of any channel.
fn largest(light: &[DVec3]) -> f64 {
    light.iter().fold(0.0, |max, m| max.max(m.abs().max_element()))
}
