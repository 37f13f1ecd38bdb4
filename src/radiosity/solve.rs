//! Solving the radiosity equation M_i = E_i + rho_i (D_i + sum_j F_ij M_j) by passes of gathering. Where
//! light passes through sheets, M_i also has tau_k times what meets the other side k.
//!
//! With a limit of passes each is a bounce. Without one, passes are made to leave as little as they can,
//! by conjugate residuals.

use super::channels::{Channels, channels, colour};
use super::direction::Direction;
use super::transfers::{AT_A_TIME, Transfers};
use crate::patch::Passage;
use crate::photometry::{Exitance, Irradiance, Reflectance};
use crate::scene::effects::COMPILED;
use glam::Vec3;
use rayon::prelude::*;

/// Patches that are treated as one piece.
pub(super) const PIECE: usize = 4096;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Largest number of passes, each of which is a bounce then; `None` is until little is left, in
    /// as few passes as that takes.
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
    /// Share of all light that was still to be sent: how far the equation was from being solved before
    /// what was still to be sent was counted as if it had been.
    pub residual: f64,
    /// Whether the residual fell to the limit before the passes were used up.
    pub settled: bool,
    /// Channels that were carried.
    pub channels: Channels,
}

/// Sends the light on, pass by pass. With a limit of passes, what a patch reflects in one is what it sends
/// in the next; without, a pass sends a mixture of what is left and what the one before it sent. Sums run
/// in a fixed order in double precision, so the bytes do not depend on the number of threads. It converges
/// where `reflectance` is below 1.
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
    let surfaces = Surfaces { transfers, reflectance, passages };
    let channels = Channels::of(surfaces, [sources]);
    let mut solutions = solve_styles(surfaces, &[sources], limits, channels);
    solutions.pop().expect("as many as sources")
}

/// Bytes that solving so many light styles takes for a patch, at most, besides its form factors.
pub fn bytes_of_a_patch(styles: usize) -> u64 {
    // Light in all, unsent, arriving, sent and gone, and what is gathered from and into.
    const SOLVING: usize = 7 * size_of::<[f64; 3]>();
    const SOLVED: usize = size_of::<Exitance>() + size_of::<Irradiance>();
    (styles.min(AT_A_TIME) * SOLVING + styles * SOLVED) as u64
}

/// What light meets.
#[derive(Clone, Copy)]
pub struct Surfaces<'a> {
    /// What each patch sees.
    pub transfers: &'a Transfers,
    /// What each patch reflects; below 1.
    pub reflectance: &'a [Reflectance],
    /// Where light passes through diffusely; below 1 with what is reflected.
    pub passages: &'a [Passage],
}

/// Solves many light styles, each as if it were alone; form factors are read once for several. `channels`
/// must be those that [`Channels::of`] finds, or more.
pub fn solve_styles(
    surfaces: Surfaces<'_>,
    sources: &[Sources<'_>],
    limits: Limits,
    channels: Channels,
) -> Vec<Solution> {
    match channels {
        Channels::One => solve_in::<1>(surfaces, sources, limits),
        Channels::Three => solve_in::<3>(surfaces, sources, limits),
    }
}

fn solve_in<const C: usize>(
    surfaces: Surfaces<'_>,
    sources: &[Sources<'_>],
    limits: Limits,
) -> Vec<Solution> {
    let mut styles: Vec<Style<C>> = sources.iter().map(Style::new).collect();
    loop {
        let mut open: Vec<&mut Style<C>> =
            styles.iter_mut().filter_map(|s| (!s.is_done(limits)).then_some(s)).collect();
        if open.is_empty() {
            return styles.into_iter().map(Style::solution).collect();
        }
        let sending: Vec<&[[f64; C]]> =
            open.iter().filter(|s| s.sends()).map(|s| &s.unsent[..]).collect();
        let mut arriving = surfaces.transfers.gather_all(&sending).into_iter();
        for style in &mut open {
            let arriving = if style.sends() { arriving.next() } else { None };
            let arriving = arriving.unwrap_or_else(|| vec![[0.0; C]; style.total.len()]);
            style.pass(surfaces, arriving, limits);
        }
    }
}

/// A light style on its way to a solution.
struct Style<const C: usize> {
    /// Exitance by now.
    total: Vec<[f64; C]>,
    /// What of it the patches have not sent each other.
    unsent: Vec<[f64; C]>,
    /// Irradiance that the next pass reflects besides what the patches send each other.
    direct: Vec<[f64; C]>,
    /// What the last pass added, where passes are more than bounces.
    direction: Option<Direction<C>>,
    passes: u32,
    residual: f64,
    settled: bool,
}

impl<const C: usize> Style<C> {
    fn new(sources: &Sources<'_>) -> Self {
        let total: Vec<_> = sources.emission.iter().map(|m| channels(limited(m.0))).collect();
        Self {
            unsent: total.clone(),
            total,
            direct: sources.direct.iter().map(|e| channels(limited(e.0))).collect(),
            direction: None,
            passes: 0,
            residual: 0.0,
            settled: false,
        }
    }

    /// Whether to stop here.
    fn is_done(&mut self, limits: Limits) -> bool {
        let left = largest(&self.unsent).max(largest(&self.direct));
        let all = largest(&self.total).max(left);
        self.residual = if all > 0.0 { left / all } else { 0.0 };
        self.settled = self.residual <= limits.residual;
        self.settled || limits.passes.is_some_and(|n| self.passes >= n)
    }

    /// Whether the patches have anything to send each other.
    fn sends(&self) -> bool {
        largest(&self.unsent) > 0.0
    }

    /// Sends on what is `arriving` at each patch, and direct light.
    fn pass(&mut self, surfaces: Surfaces<'_>, mut arriving: Vec<[f64; C]>, limits: Limits) {
        let first = self.passes == 0;
        self.passes += 1;
        for (sum, e) in arriving.iter_mut().zip(std::mem::take(&mut self.direct)) {
            add(sum, e);
        }
        let returned = sent_on(surfaces, arriving);
        if first || limits.passes.is_some() {
            for (total, &m) in self.total.iter_mut().zip(&returned) {
                add(total, m);
            }
            self.unsent = returned;
        } else {
            let before = self.direction.take();
            let (total, unsent) = (&mut self.total, &mut self.unsent);
            self.direction = Some(Direction::pass(before, total, unsent, &returned));
        }
    }

    fn solution(self) -> Solution {
        let Self { total, passes, residual, settled, .. } = self;
        let exitance = total.into_iter().map(|m| Exitance(limited(colour(m)))).collect();
        let channels = if C == 1 { Channels::One } else { Channels::Three };
        Solution { exitance, passes, residual, settled, channels }
    }
}

/// What patches reflect and let through of what is `arriving` at them.
fn sent_on<const C: usize>(surfaces: Surfaces<'_>, arriving: Vec<[f64; C]>) -> Vec<[f64; C]> {
    let mut light = arriving;
    let product = |a: [f64; C], b: Vec3| {
        let b: [f64; C] = channels(b);
        std::array::from_fn(|c| b[c] * a[c])
    };
    let passages = if COMPILED { surfaces.passages } else { &[] };
    let through: Vec<[f64; C]> =
        passages.iter().map(|p| product(light[p.from.0 as usize], p.transmittance)).collect();
    let reflecting = light.par_iter_mut().zip(surfaces.reflectance).with_min_len(PIECE);
    reflecting.for_each(|(m, rho)| *m = product(*m, rho.0));
    for (passage, through) in passages.iter().zip(through) {
        add(&mut light[passage.to.0 as usize], through);
    }
    light
}

fn add<const C: usize>(sum: &mut [f64; C], more: [f64; C]) {
    for (sum, more) in sum.iter_mut().zip(more) {
        *sum += more;
    }
}

/// Light that is no finite number would never settle: it becomes 0 or the largest that a map can hold.
fn limited(light: Vec3) -> Vec3 {
    const MOST: f32 = 1e30;
    let channel = |c: f32| if c.is_nan() { 0.0 } else { c.clamp(-MOST, MOST) };
    Vec3::from_array(light.to_array().map(channel))
}

/// Largest absolute value of any channel.
fn largest<const C: usize>(light: &[[f64; C]]) -> f64 {
    let of_piece =
        |piece: &[[f64; C]]| piece.as_flattened().iter().fold(0.0_f64, |max, m| max.max(m.abs()));
    light.par_chunks(PIECE).map(of_piece).reduce(|| 0.0, f64::max)
}
