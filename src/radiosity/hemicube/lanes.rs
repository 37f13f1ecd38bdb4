//! Eight numbers at a time.

use bytemuck::cast;
use wide::{f32x4, f32x8};

/// Their number.
pub(super) const LANES: usize = 8;

/// The number of each lane.
pub(super) const STEPS: f32x8 = f32x8::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);

/// Centres of as many cells.
pub(super) const CENTRES: f32x8 = f32x8::new([0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5]);

/// The smallest.
#[inline(always)]
pub(super) fn least(v: f32x8) -> f32 {
    let [a, b]: [f32x4; 2] = cast(v);
    let [a, b, c, d] = a.fast_min(b).to_array();
    let smaller = |a: f32, b: f32| if b < a { b } else { a };
    smaller(smaller(a, c), smaller(b, d))
}

/// The largest.
#[inline(always)]
pub(super) fn greatest(v: f32x8) -> f32 {
    let [a, b]: [f32x4; 2] = cast(v);
    let [a, b, c, d] = a.fast_max(b).to_array();
    let larger = |a: f32, b: f32| if b > a { b } else { a };
    larger(larger(a, c), larger(b, d))
}

/// The same number in all.
#[inline(always)]
pub(super) fn all(v: f32) -> f32x8 {
    f32x8::splat(v)
}

/// The numbers of the bits that are set.
#[inline(always)]
pub(super) fn bits(mut set: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let next = (set != 0).then(|| set.trailing_zeros() as usize);
        set &= set.wrapping_sub(1);
        next
    })
}
