//! Whether light that is sent arrives.

use crate::patch::{PatchId, PatchSet};
use crate::radiosity::transfers::Transfers;
use glam::DVec3;

/// A row counts as dead if it sees less than this share of what others see of its patch...
const DEAD: f64 = 0.1;
/// ...where that is at least such a part of its view...
const SEEN: f64 = 0.2;
/// ...and so many of them see it.
const WITNESSES: u32 = 16;

/// Where the light goes that patches send.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Energy {
    /// Light that patches receive of each other over what their rows say that they send to patches: 1
    /// where form factors keep reciprocity, A_i F_ij = A_j F_ji.
    pub balance: f64,
    /// Share of the light sent that meets no patch: it goes to the sky, to backs or to the void.
    pub lost: f64,
    /// Patches whose rows are all but empty although many patches see them.
    pub dead: usize,
    /// The first of those.
    pub first_dead: Option<usize>,
}

impl Energy {
    /// Of a solution: `exitance` has one entry a patch, and may have those of glows. `None` if nothing is
    /// sent to any patch.
    pub fn new(patches: &PatchSet, transfers: &Transfers, exitance: &[DVec3]) -> Option<Self> {
        let received = transfers.gather(exitance);
        // What others see of each patch, times its area; and how many see it. Liquids take light, but no
        // ray of others ends on them.
        let mut seen = vec![(0.0, 0_u32); exitance.len()];
        let mut sees = vec![DVec3::ZERO; exitance.len()];
        let flags = patterned(patches);
        let patterned = |column: u32| flags.get(column as usize).is_none_or(|&is| is);
        for (i, patch) in patches.patches.iter().enumerate() {
            for (j, f) in transfers.entries(i) {
                let of = &mut seen[j as usize];
                *of = (of.0 + f64::from(patch.area * f), of.1 + 1);
                sees[i] += f64::from(f);
            }
            for &(j, f) in transfers.overlay_row(i).iter().filter(|e| !patterned(e.0)) {
                sees[i] += f.as_dvec3();
                let of = &mut seen[j as usize];
                *of = (of.0 + f64::from(patch.area * f.element_sum() / 3.0), of.1 + 1);
            }
        }
        let (mut all, mut sent, mut arrived) = (0.0, 0.0, 0.0);
        let mut dead = (0, None);
        for (i, patch) in patches.patches.iter().enumerate() {
            let area = f64::from(patch.area);
            let light = area * exitance[i].element_sum();
            all += light;
            sent += area * exitance[i].dot(sees[i]);
            let (by_others, witnesses) = seen[i];
            if witnesses == 0 {
                continue;
            }
            arrived += area * received[i].element_sum();
            let share = by_others / area;
            if witnesses >= WITNESSES && share > SEEN && sees[i].element_sum() / 3.0 < DEAD * share
            {
                dead = (dead.0 + 1, dead.1.or(Some(i)));
            }
        }
        let usable = |x: f64| x > 0.0 && x.is_finite();
        (usable(all) && usable(sent)).then(|| Self {
            balance: arrived / sent,
            lost: (1.0 - sent / all).max(0.0),
            dead: dead.0,
            first_dead: dead.1,
        })
    }
}

/// Which patches have patterns and are not translucent. What an overlay adds to their form factors tells
/// from which parts of them light comes, not how much of them is seen.
fn patterned(patches: &PatchSet) -> Vec<bool> {
    let mut found = vec![false; patches.patches.len()];
    if let Some(overlay) = patches.overlay.as_deref().filter(|o| o.has_patterns()) {
        for (i, found) in found.iter_mut().enumerate() {
            *found = overlay.varies(PatchId(i as u32));
        }
        for (PatchId(layer), _) in overlay.layer_patches() {
            found[layer as usize] = false;
        }
    }
    found
}
