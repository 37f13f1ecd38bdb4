//! Things so close to a luxel that the points from which it would be interpolated overlook them: the
//! side of a pilaster next to it, a capital or a shelf right in front.

use super::interpolate::Neighbour;
use crate::scene::{Barriers, Sample};
use glam::Vec3;

/// Something straight in front of a luxel counts up to this distance, in world units.
const FRONT: f32 = 8.0;
/// It is overlooked by points that are open to this many times its distance. Under an endless ceiling the
/// openness is 1.5 times the distance.
const OPEN: f32 = 4.0;
/// A thing beside a luxel counts up to this distance.
const BESIDE: f32 = 12.0;
/// It is overlooked by points whose middle is this much farther from it.
const BEYOND: f32 = 12.0;
/// It counts if it rises by this much over that distance: what is lower fills a twentieth of the view.
const RISE: f32 = 6.0;
/// Points that are as near to it as the luxel, or farther by less than this, see it too...
const NEARLY: f32 = 4.0;
/// ...and suffice with this share of the weight.
const CLOSE: f64 = 0.25;
/// Walls higher than this look much the same from the points as from the luxel.
const HIGH: f32 = 32.0;

/// Whether something right at `sample` is overlooked by the points `around`, whose weighted mean is at
/// `centre`, relative to it, and whose harmonic mean openness is `openness`.
pub(super) fn overlooked(
    barriers: &mut Barriers<'_>,
    sample: &Sample,
    (centre, around): (Vec3, &[Neighbour]),
    openness: f32,
) -> bool {
    // What the points see is nearer to them than they are to the luxel.
    centre.length() > openness
        || in_front(barriers, sample, openness)
        || beside(barriers, sample, centre, around)
}

fn in_front(barriers: &mut Barriers<'_>, sample: &Sample, openness: f32) -> bool {
    let (from, reach) = (sample.position, FRONT.min(openness / OPEN));
    barriers.blocked(from, from + sample.normal * reach)
}

fn beside(
    barriers: &mut Barriers<'_>,
    sample: &Sample,
    centre: Vec3,
    around: &[Neighbour],
) -> bool {
    let away = -centre.reject_from_normalized(sample.normal);
    if away.length_squared() < BEYOND * BEYOND {
        return false;
    }
    let towards = away.normalize();
    let weight = |n: &Neighbour| n.weight;
    let close = around.iter().filter(|n| n.offset.dot(towards) > -NEARLY).map(weight).sum::<f64>();
    if close >= CLOSE * around.iter().map(weight).sum::<f64>() {
        return false;
    }
    let (low, aside) = (sample.position, towards * BESIDE);
    let rise = sample.normal * RISE;
    let high = low + sample.normal * HIGH;
    barriers.blocked(low, low + aside + rise)
        && (barriers.blocked(low, high) || !barriers.blocked(high, high + aside))
}
