//! Parts of a scene that light never leaves and where nothing absorbs it.

use super::transfers::Transfers;
use crate::photometry::Reflectance;
use glam::Vec3;

/// A row whose sum is short by more than this lets light escape; less is rounding.
const ESCAPE: f64 = 1e-4;

/// Lowers reflectances above `limit` to it where light from the patch can reach nothing that absorbs
/// more, nor escape: it would never settle. Returns how many patches were changed.
pub fn let_out(transfers: &Transfers, reflectance: &mut [Reflectance], limit: f32) -> usize {
    if reflectance.iter().all(|rho| rho.0.max_element() <= limit) {
        return 0;
    }
    let mut changed = vec![false; reflectance.len()];
    for channel in [Vec3::X, Vec3::Y, Vec3::Z] {
        let losing = leads_to_loss(transfers, |i| reflectance[i].0.dot(channel) <= limit);
        for (i, rho) in reflectance.iter_mut().enumerate() {
            let value = rho.0.dot(channel);
            if value > limit && !losing[i] {
                rho.0 += channel * (limit - value);
                changed[i] = true;
            }
        }
    }
    changed.into_iter().filter(|&c| c).count()
}

/// For each patch, whether light that leaves it can come to one that `absorbs` or escapes.
fn leads_to_loss(transfers: &Transfers, absorbs: impl Fn(usize) -> bool) -> Vec<bool> {
    let escapes = |i: usize| {
        let sum: f64 = transfers.entries(i).map(|(_, f)| f64::from(f)).sum();
        sum < 1.0 - ESCAPE
    };
    let mut leads: Vec<bool> = (0..transfers.rows()).map(|i| absorbs(i) || escapes(i)).collect();
    let mut open: Vec<usize> = (0..leads.len()).filter(|&i| leads[i]).collect();
    while let Some(i) = open.pop() {
        // Row i is what sends light to patch i.
        for (j, _) in transfers.entries(i) {
            if !std::mem::replace(&mut leads[j as usize], true) {
                open.push(j as usize);
            }
        }
    }
    leads
}
