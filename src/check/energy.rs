//! Whether light that is sent arrives.

use crate::patch::PatchSet;
use crate::radiosity::transfers::Transfers;
use glam::DVec3;

/// Where the light goes that patches send.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Energy {
    /// Light that patches receive of each other over what their rows say that they send to patches: 1
    /// where form factors keep reciprocity, A_i F_ij = A_j F_ji.
    pub balance: f64,
    /// Share of the light sent that meets no patch: it goes to the sky, to backs or to the void.
    pub lost: f64,
}

impl Energy {
    /// Of a solution: `exitance` has one entry a patch. `None` if nothing is sent to any patch.
    pub fn new(patches: &PatchSet, transfers: &Transfers, exitance: &[DVec3]) -> Option<Self> {
        let received = transfers.gather(exitance);
        // Liquids take light, but no ray of others ends on them.
        let mut met = vec![false; exitance.len()];
        for i in 0..transfers.rows() {
            transfers.row(i).0.iter().for_each(|&j| met[j as usize] = true);
        }
        let (mut all, mut sent, mut arrived) = (0.0, 0.0, 0.0);
        for (i, patch) in patches.patches.iter().enumerate() {
            let area = f64::from(patch.area);
            let light = area * exitance[i].element_sum();
            let row = transfers.row(i).1.iter().map(|&f| f64::from(f)).sum::<f64>();
            all += light;
            sent += light * row;
            if met[i] {
                arrived += area * received[i].element_sum();
            }
        }
        let usable = |x: f64| x > 0.0 && x.is_finite();
        (usable(all) && usable(sent))
            .then(|| Self { balance: arrived / sent, lost: (1.0 - sent / all).max(0.0) })
    }
}
