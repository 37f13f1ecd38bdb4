//! Four or eight numbers at a time.

use bytemuck::cast;
use std::ops::{Add, BitAnd, Div, Mul, Sub};
use wide::{CmpGe, CmpGt, CmpLe, CmpLt, f32x4, f32x8};

/// The larger of the two numbers of lanes.
pub(super) const LANES: usize = 8;

/// The number of each lane.
pub(super) const STEPS: f32x8 = f32x8::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);

/// Centres of as many cells.
pub(super) const CENTRES: f32x8 = f32x8::new([0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5]);

/// Numbers in lanes. Most polygons have up to four corners, so that half of eight lanes would be idle.
pub(super) trait Lanes:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + BitAnd<Output = Self>
    + CmpLt<Output = Self>
    + CmpLe<Output = Self>
    + CmpGt<Output = Self>
    + CmpGe<Output = Self>
{
    /// Their number.
    const COUNT: usize;
    /// All bits of a mask of so many lanes.
    const EVERY: i32 = (1 << Self::COUNT) - 1;

    /// The same number in all.
    fn all(v: f32) -> Self;
    /// Lane by lane the smaller one.
    fn smaller(self, other: Self) -> Self;
    /// Lane by lane the larger one.
    fn larger(self, other: Self) -> Self;
    /// Without signs.
    fn size(self) -> Self;
    /// Rounded towards 0. All must be whole numbers of `i32` then.
    fn truncated(self) -> Self;
    /// Where this is a mask the lanes of `yes`, else those of `no`.
    fn choose(self, yes: Self, no: Self) -> Self;
    /// A bit for each lane of a mask.
    fn mask(self) -> i32;
    /// Four numbers of which the smallest and the largest are those of all lanes.
    fn folded(self) -> [f32x4; 2];
    /// Moved one lane up; the first lane is the last of `before`.
    fn rotated(self, before: Self) -> Self;
    /// Writes the lanes to the start of `to`.
    fn store(self, to: &mut [f32]);
}

macro_rules! lanes {
    ($lanes:ident, $count:expr, $folded:expr) => {
        impl Lanes for $lanes {
            const COUNT: usize = $count;

            #[inline(always)]
            fn all(v: f32) -> Self {
                Self::splat(v)
            }
            #[inline(always)]
            fn smaller(self, other: Self) -> Self {
                self.fast_min(other)
            }
            #[inline(always)]
            fn larger(self, other: Self) -> Self {
                self.fast_max(other)
            }
            #[inline(always)]
            fn size(self) -> Self {
                self.abs()
            }
            #[inline(always)]
            fn truncated(self) -> Self {
                self.fast_trunc_int().round_float()
            }
            #[inline(always)]
            fn choose(self, yes: Self, no: Self) -> Self {
                self.blend(yes, no)
            }
            #[inline(always)]
            fn mask(self) -> i32 {
                self.move_mask()
            }
            #[inline(always)]
            fn folded(self) -> [f32x4; 2] {
                $folded(self)
            }
            #[inline(always)]
            fn rotated(self, before: Self) -> Self {
                let (v, last) = (self.to_array(), before.to_array()[$count - 1]);
                Self::new(std::array::from_fn(|k| if k == 0 { last } else { v[k - 1] }))
            }
            #[inline(always)]
            fn store(self, to: &mut [f32]) {
                to[..$count].copy_from_slice(&self.to_array());
            }
        }
    };
}

lanes!(f32x4, 4, |v: f32x4| [v, v]);
lanes!(f32x8, 8, |v: f32x8| {
    let [a, b]: [f32x4; 2] = cast(v);
    [a.fast_min(b), a.fast_max(b)]
});

/// The smallest x, the smallest y, the largest x and the largest y.
#[inline(always)]
pub(super) fn extent<V: Lanes>(x: V, y: V) -> f32x4 {
    let ([low_x, high_x], [low_y, high_y]) = (x.folded(), y.folded());
    let zero = f32x4::ZERO;
    // The largest is the smallest of the negative ones, with its sign changed.
    let [a, b, c, d] = f32x4::transpose([low_x, low_y, zero - high_x, zero - high_y]);
    let least = a.fast_min(b).fast_min(c.fast_min(d));
    least * f32x4::new([1.0, 1.0, -1.0, -1.0])
}

/// The smallest.
#[inline(always)]
pub(super) fn least<V: Lanes>(v: V) -> f32 {
    let [a, b, c, d] = v.folded()[0].to_array();
    let smaller = |a: f32, b: f32| if b < a { b } else { a };
    smaller(smaller(a, c), smaller(b, d))
}

/// The largest.
#[inline(always)]
pub(super) fn greatest<V: Lanes>(v: V) -> f32 {
    let [a, b, c, d] = v.folded()[1].to_array();
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
