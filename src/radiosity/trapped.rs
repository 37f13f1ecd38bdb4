//! Parts of a scene that light never leaves and where nothing absorbs it.

use super::transfers::Transfers;
use crate::patch::Passage;
use crate::photometry::Reflectance;
use glam::Vec3;

/// A row whose sum is short by more than this lets light escape; less is rounding.
const ESCAPE: f64 = 1e-4;

/// Lowers reflectances above `limit` to it where light from the patch can reach nothing that absorbs
/// more, nor escape: it would never settle. Where patches send light on through `passages`, what they
/// reflect and transmit counts together and is lowered together. Returns how many patches were changed.
pub fn let_out(
    transfers: &Transfers,
    reflectance: &mut [Reflectance],
    passages: &mut [Passage],
    limit: f32,
) -> usize {
    let mut albedo: Vec<Vec3> = reflectance.iter().map(|rho| rho.0).collect();
    for passage in &*passages {
        albedo[passage.from.0 as usize] += passage.transmittance;
    }
    if albedo.iter().all(|a| a.max_element() <= limit) {
        return 0;
    }
    let mut changed = vec![false; reflectance.len()];
    for channel in [Vec3::X, Vec3::Y, Vec3::Z] {
        let losing =
            leads_to_loss((transfers, passages), channel, |i| albedo[i].dot(channel) <= limit);
        let kept = |i: usize| {
            let value = albedo[i].dot(channel);
            (value > limit && !losing[i]).then_some(value)
        };
        for passage in &mut *passages {
            if let Some(value) = kept(passage.from.0 as usize) {
                let share = passage.transmittance.dot(channel);
                passage.transmittance += channel * (share * (limit / value - 1.0));
            }
        }
        for (i, rho) in reflectance.iter_mut().enumerate() {
            if let Some(value) = kept(i) {
                let own = rho.0.dot(channel);
                // Without transmission exactly the limit.
                let lowered = if own == value { limit } else { own * (limit / value) };
                rho.0 += channel * (lowered - own);
                changed[i] = true;
            }
        }
    }
    changed.into_iter().filter(|&c| c).count()
}

/// For each patch, whether light of a channel that leaves it can come to one that `absorbs` or escapes.
fn leads_to_loss(
    (transfers, passages): (&Transfers, &[Passage]),
    channel: Vec3,
    absorbs: impl Fn(usize) -> bool,
) -> Vec<bool> {
    let escapes = |i: usize| {
        let sum: f64 = transfers.entries(i).map(|(_, f)| f64::from(f)).sum();
        let more = transfers.overlay_row(i).iter().map(|(_, f)| f64::from(f.dot(channel)));
        sum + more.sum::<f64>() < 1.0 - ESCAPE
    };
    let mut leads: Vec<bool> = (0..transfers.rows()).map(|i| absorbs(i) || escapes(i)).collect();
    let mut open: Vec<usize> = (0..leads.len()).filter(|&i| leads[i]).collect();
    while let Some(i) = open.pop() {
        // Row i is what sends light to patch i, and so do the other sides of sheets.
        let seen = transfers.entries(i).map(|(j, _)| j);
        let layers = transfers.overlay_row(i).iter().map(|&(j, _)| j);
        let through = passages.iter().filter(|p| p.to.0 as usize == i).map(|p| p.from.0);
        for j in seen.chain(layers).chain(through) {
            if !std::mem::replace(&mut leads[j as usize], true) {
                open.push(j as usize);
            }
        }
    }
    leads
}
