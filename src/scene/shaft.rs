//! The space that all rays from one box to another run through, to tell what none of them meets.
//!
//! Its sides are those of E. Haines and J. Wallace, "Shaft culling for efficient ray-traced
//! radiosity" (1991): the box around both, and for each pair of axes the planes that touch an edge
//! of either.

use super::packet::{NOTHING, Packet, ROUNDING, cross, dot};
use super::umbra::Bounds;
use glam::{DVec3, Vec3};
use wide::{CmpGt, CmpLt, f32x4};

/// By how much a shaft is wider than its rays, in world units and relative to coordinates.
const SLACK: f64 = 1.0 / 64.0;
const SLACK_SHARE: f64 = 1e-6;
/// How far beside a triangle a ray may still touch it, relative to its size and place.
const TOUCH: f32 = 8e-6;
/// Most slanting sides: two for each pair of axes and side, and the floor.
const MOST_SLANTS: usize = 13;

/// A shaft.
pub(super) struct Shaft {
    low: [f32x4; 3],
    high: [f32x4; 3],
    slants: [Slant; MOST_SLANTS],
    slant_count: usize,
    ends: [End; 2],
    /// Bound of the 1-norm of all points of the shaft.
    place: f32x4,
}

/// A half space `normal p <= most`.
#[derive(Clone, Copy)]
struct Slant {
    normal: [f32x4; 3],
    positive: [bool; 3],
    most: f32x4,
}

/// One of the two boxes.
#[derive(Clone, Copy)]
struct End {
    middle: [f32x4; 3],
    half: [f32x4; 3],
}

/// A plane that all rays of a shaft stay in front of: a unit normal, and the least distance along it.
#[derive(Clone, Copy, Debug)]
pub struct Floor {
    /// Unit normal.
    pub normal: Vec3,
    /// Least product of the normal and a point.
    pub least: f64,
}

impl Shaft {
    /// The shaft of the rays between points of two boxes that stay in front of `floor`.
    pub fn new(from: &Bounds, to: &Bounds, floor: Option<Floor>) -> Self {
        let (low, high) = (from.low().min(to.low()), from.high().max(to.high()));
        let place = low.abs().max(high.abs()).element_sum();
        let nothing = Slant { normal: [f32x4::ZERO; 3], positive: [true; 3], most: f32x4::ZERO };
        let splat = |v: DVec3| v.as_vec3().to_array().map(f32x4::splat);
        let end = |b: &Bounds| End {
            middle: splat(b.middle()),
            half: splat(b.half() * (1.0 + SLACK_SHARE) + b.middle().abs() * SLACK_SHARE),
        };
        let widen = low.abs().max(high.abs()) * SLACK_SHARE + SLACK;
        let mut shaft = Self {
            low: splat(low - widen),
            high: splat(high + widen),
            slants: [nothing; MOST_SLANTS],
            slant_count: 0,
            ends: [end(from), end(to)],
            place: f32x4::splat(place as f32 * 1.001),
        };
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            for (left, down) in [(false, false), (false, true), (true, false), (true, true)] {
                let side = |b: &Bounds, axis: usize, negative: bool| {
                    if negative { -b.low()[axis] } else { b.high()[axis] }
                };
                let ahead = side(from, i, left) - side(to, i, left);
                let behind = side(to, j, down) - side(from, j, down);
                if ahead * behind > 0.0 {
                    let mut normal = DVec3::ZERO;
                    normal[i] = if left { -behind.abs() } else { behind.abs() };
                    normal[j] = if down { -ahead.abs() } else { ahead.abs() };
                    shaft.add_slant(normal.normalize(), [from, to]);
                }
            }
        }
        if let Some(floor) = floor {
            shaft.push(-floor.normal, -floor.least, floor.least.abs());
        }
        shaft
    }

    fn add_slant(&mut self, normal: DVec3, ends: [&Bounds; 2]) {
        let normal = normal.as_vec3();
        let n = normal.as_dvec3();
        let most = ends.map(|b| n.dot(b.middle()) + n.abs().dot(b.half()));
        let touched = ends.map(|b| n.abs().dot(b.middle().abs() + b.half()));
        self.push(normal, most[0].max(most[1]), touched[0].min(touched[1]));
    }

    /// `size` bounds what `most` is the sum of.
    fn push(&mut self, normal: Vec3, most: f64, size: f64) {
        if !(normal.is_finite() && most.is_finite()) {
            return;
        }
        self.slants[self.slant_count] = Slant {
            normal: normal.to_array().map(f32x4::splat),
            positive: normal.to_array().map(|n| n >= 0.0),
            most: f32x4::splat((most + SLACK + size * SLACK_SHARE) as f32),
        };
        self.slant_count += 1;
    }

    fn slants(&self) -> &[Slant] {
        &self.slants[..self.slant_count]
    }

    /// Which of four boxes the shaft may reach into, a bit each. The boxes are to be widened by more
    /// than the rounding of their coordinates.
    pub fn meets_boxes(&self, min: &[f32x4; 3], max: &[f32x4; 3]) -> u32 {
        let mut outside = f32x4::ZERO;
        for axis in 0..3 {
            outside |= min[axis].cmp_gt(self.high[axis]) | max[axis].cmp_lt(self.low[axis]);
        }
        for slant in self.slants() {
            let nearest = [0, 1, 2].map(|i| if slant.positive[i] { min[i] } else { max[i] });
            outside |= dot(slant.normal, nearest).cmp_gt(slant.most);
        }
        !outside.move_mask() as u32 & 15
    }

    /// Which triangles of a packet a ray of the shaft may meet, a bit each.
    pub fn meets(&self, packet: &Packet) -> u32 {
        let [a, ab, ac] = [packet.corner, packet.ab, packet.ac];
        let touch = f32x4::splat(SLACK as f32) + packet.extent * f32x4::splat(TOUCH);
        let mut outside = f32x4::ZERO;
        for i in 0..3 {
            let least = a[i] + ab[i].fast_min(ac[i]).fast_min(f32x4::ZERO) - touch;
            let most = a[i] + ab[i].fast_max(ac[i]).fast_max(f32x4::ZERO) + touch;
            outside |= least.cmp_gt(self.high[i]) | most.cmp_lt(self.low[i]);
        }
        if outside.move_mask() & 15 == 15 {
            return 0;
        }
        for slant in self.slants() {
            let n = slant.normal;
            let least = dot(n, a) + dot(n, ab).fast_min(dot(n, ac)).fast_min(f32x4::ZERO);
            outside |= (least - touch).cmp_gt(slant.most);
        }
        // Both ends on one side of the triangle's plane.
        let across = cross(ab, ac);
        let thick = across.map(f32x4::abs);
        let rounding =
            packet.size * packet.size * f32x4::splat(ROUNDING) * (packet.extent + self.place);
        let [[low0, high0], [low1, high1]] = self.ends.map(|end| {
            let middle = dot(across, [0, 1, 2].map(|i| end.middle[i] - a[i]));
            let reach = dot(thick, end.half) + rounding;
            [middle - reach, middle + reach]
        });
        let zero = f32x4::ZERO;
        outside |= low0.fast_min(low1).cmp_gt(zero) | high0.fast_max(high1).cmp_lt(zero);
        let mut met = !outside.move_mask() as u32 & 15;
        for (lane, &polygon) in packet.polygons.iter().enumerate() {
            if polygon == NOTHING {
                met &= !(1 << lane);
            }
        }
        met
    }
}
