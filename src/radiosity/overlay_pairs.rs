//! What an overlay adds to form factors of pairs that are known better than from one hemicube: the share
//! of light that gets through from patch to patch is a mean over rays, and translucent patches have closed
//! forms.

use super::area_points::{Spread, sobol};
use super::near_pairs::NearPairs;
use super::pair_factor::{Facing, Shape};
use super::transfers::Transfers;
use super::visibility::{Shaft, any_between};
use crate::patch::{Overlay, PatchId, PatchSet};
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

/// Works out anew what the overlay of `patches` adds to every row. `near` is what the rows were improved
/// with.
pub fn improve(transfers: &mut Transfers, patches: &PatchSet, near: &NearPairs<'_>) {
    let Some(overlay) = patches.overlay.as_deref() else { return };
    let rows = OverlayRows::new(overlay, near);
    let all = (0..transfers.rows()).into_par_iter();
    let found = all.map(|i| rows.row(i, transfers.entries(i))).collect();
    transfers.set_overlay_rows(found);
}

/// What an overlay adds to rows that are improved already.
pub struct OverlayRows<'a> {
    overlay: &'a Overlay,
    layers: Vec<(PatchId, Option<DVec3>)>,
    near: &'a NearPairs<'a>,
}

impl<'a> OverlayRows<'a> {
    /// For rows improved with `near`.
    pub fn new(overlay: &'a Overlay, near: &'a NearPairs<'a>) -> Self {
        Self { overlay, layers: overlay.layer_patches().collect(), near }
    }

    /// What is added to row `i`, which has these columns and form factors, by ascending column and per
    /// channel.
    pub fn row(&self, i: usize, entries: impl Iterator<Item = (u32, f32)>) -> Vec<(u32, Vec3)> {
        let Self { overlay, layers, near } = self;
        if !near.matters(i) {
            return Vec::new();
        }
        let (mut row, mut lost, mut sum) = (Vec::new(), Vec::new(), 0.0);
        for (j, factor) in entries {
            let factor = f64::from(factor);
            sum += factor;
            let Shares { tint, patterned } = near.through(overlay, (i, j as usize), factor);
            if tint != DVec3::ONE {
                lost.push((j, (tint - DVec3::ONE) * factor));
            }
            if patterned != tint {
                row.push((j, ((patterned - tint) * factor).as_vec3()));
            }
        }
        // What the layers keep of the view; none if one is uneven.
        let mut kept = Some(DVec3::ZERO);
        let mut facing = Facing::default();
        for &(PatchId(j), share) in layers.iter().filter(|l| l.0.0 as usize != i) {
            let Some(factor) = near.layer_factor((i, j as usize), &mut facing) else { continue };
            let Shares { tint, patterned } = near.through(overlay, (i, j as usize), factor);
            row.push((j, (patterned * factor).as_vec3()));
            let keeps = |share: DVec3| tint * factor * (DVec3::ONE - share);
            kept = kept.zip(share).map(|(sum, share)| sum + keeps(share));
        }
        if let Some(kept) = kept.filter(|_| sum > 1.0 - CLOSED) {
            balance(&mut lost, kept);
        }
        row.extend(lost.into_iter().map(|(j, f)| (j, f.as_vec3())));
        row.sort_unstable_by_key(|&(j, _)| j);
        row
    }
}

/// Rows that miss less than this of 1 see patches all around.
const CLOSED: f64 = 1e-4;

/// Makes the view whole where patches are all around: what is lost on the way to those behind layers is
/// what the layers keep. Their form factors are known better, from closed forms.
fn balance(lost: &mut [(u32, DVec3)], kept: DVec3) {
    let sum: DVec3 = lost.iter().map(|&(_, f)| -f).sum();
    let scale = |sum: f64, kept: f64| {
        let scale = kept / sum;
        // Farther off, the layers are not what is in the way.
        if scale > 0.8 && scale < 1.25 { scale } else { 1.0 }
    };
    let scale = DVec3::new(scale(sum.x, kept.x), scale(sum.y, kept.y), scale(sum.z, kept.z));
    lost.iter_mut().for_each(|(_, f)| *f *= scale);
}

/// Mean shares of light that get from one patch to another.
#[derive(Clone, Copy)]
pub(super) struct Shares {
    /// Past what is translucent.
    pub tint: DVec3,
    /// The same with the pattern of the patch that it comes from.
    pub patterned: DVec3,
}

/// Mean share of the light from shape `b`, the patch `patch`, that gets to `a` past what may hide it, over
/// `rays` rays that start and end `lift` in front of the two. `hidden` tells whether one is blocked.
pub(super) fn mean_share(
    overlay: &Overlay,
    (a, b): (&Shape<'_>, &Shape<'_>),
    patch: PatchId,
    (rays, lift, seed): (u32, f64, u32),
    hidden: impl Fn(DVec3, DVec3) -> bool,
) -> Shares {
    const ALL: Shares = Shares { tint: DVec3::ONE, patterned: DVec3::ONE };
    let patterned = overlay.pattern(patch, b.centre).is_some();
    let shaft = Shaft::new((a.outline, a.normal), (b.outline, b.normal));
    if !patterned && !any_between(overlay.layers(), &shaft, 0.0) {
        return ALL;
    }
    let work = if patterned { &overlay.pattern_work } else { &overlay.layer_work };
    work.add_rays(rays.into());
    let (on_a, on_b) = (Spread::new(a.parts()), Spread::new(b.parts()));
    let (mut all, mut tint, mut with_pattern) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for k in 0..rays {
        let [s, t, u, v] = sobol(k, seed);
        let (p, q) = (on_a.point(DVec2::new(s, t)), on_b.point(DVec2::new(u, v)));
        let way = q - p;
        let square = way.length_squared();
        let cosines = a.normal.dot(way).max(0.0) * (-b.normal.dot(way)).max(0.0);
        let kernel = cosines / (square * square);
        let (from, to) = (p + a.normal * lift, q + b.normal * lift);
        if !(kernel > 0.0 && kernel.is_finite()) || hidden(from, to) {
            continue;
        }
        all += kernel;
        let pattern = overlay.pattern(patch, q).unwrap_or(DVec3::ONE);
        let through = overlay.through(from, to) * kernel;
        tint += through;
        with_pattern += through * pattern;
    }
    if all > 0.0 { Shares { tint: tint / all, patterned: with_pattern / all } } else { ALL }
}
