//! The outline of a polygon on one side, in cell coordinates.

use super::clip::Homogeneous;
use super::lanes::{CENTRES, LANES, Lanes, STEPS, all, bits, extent};
use wide::{CmpGe, CmpLt, f32x4, f32x8};

/// Corners may be as far from the corner (0, 0) as this many times the side's width and height.
const GUARD: f32 = 2.0;

/// The upper of two points.
const UPPER: f32x4 = f32x4::new([0.0, 0.0, ON, ON]);
const ON: f32 = f32::from_bits(u32::MAX);

/// Corners of a convex polygon, up to twice the lanes; lanes that are left over repeat the last one.
pub(super) struct Outline<V> {
    x: [V; 2],
    y: [V; 2],
    groups: usize,
}

/// A range of cells: columns and rows `low..high`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    pub low: [i32; 2],
    pub high: [i32; 2],
}

impl Cells {
    /// The cells whose centres lie between two points, the lower and the upper.
    #[inline(always)]
    pub fn between(points: f32x4, size: [f32; 2]) -> Option<Self> {
        let v = points + f32x4::splat(0.5);
        let size = f32x4::new([size[0], size[1], size[0], size[1]]);
        // Truncation is rounding down here, and much faster than `ceil` on plain x86-64.
        let first = v.fast_max(f32x4::ZERO).fast_min(size).fast_trunc_int().to_array();
        let (low, high) = ([first[0], first[1]], [first[2], first[3]]);
        (low[0] < high[0] && low[1] < high[1]).then_some(Self { low, high })
    }
}

/// The first cell whose centre is at or beyond coordinate `v` of 0 to `size`, as a whole number.
#[inline(always)]
fn first_centre<V: Lanes>(v: V, size: f32) -> V {
    (v + V::all(0.5)).larger(V::all(0.0)).smaller(V::all(size)).truncated()
}

impl<V: Lanes> Outline<V> {
    /// Of points before the eye.
    #[inline(always)]
    pub fn projected(p: &[V; 3], inverse: V) -> Self {
        let (x, y) = (p[0] * inverse, p[1] * inverse);
        Self { x: [x, x], y: [y, y], groups: 1 }
    }

    /// Whether no corner is so far out that rounding would tell.
    #[inline(always)]
    pub fn is_near(&self, size: [f32; 2]) -> bool {
        let far = V::all(GUARD * (size[0] + size[1]));
        self.x[0].size().larger(self.y[0].size()).cmp_le(far).mask() == V::EVERY
    }

    /// The cells in the rectangle around the polygon; `None` if no centre is in it.
    #[inline(always)]
    pub fn cells(&self, size: [f32; 2]) -> Option<Cells> {
        let mut around = extent(self.x[0], self.y[0]);
        if self.groups == 2 {
            let more = extent(self.x[1], self.y[1]);
            let (low, high) = (around.fast_min(more), around.fast_max(more));
            around = UPPER.blend(high, low);
        }
        Cells::between(around, size)
    }

    /// Its edges, on a side with `height` rows.
    pub fn edges(&self, height: f32, edges: &mut Edges) {
        edges.crossing = 0;
        for group in 0..self.groups {
            let before = if group == 0 { self.groups - 1 } else { 0 };
            let (x1, y1) = (self.x[group], self.y[group]);
            let (x0, y0) = (x1.rotated(self.x[before]), y1.rotated(self.y[before]));
            // From the lower to the higher end, so that neighbours compute the same crossings.
            let down = y0.cmp_gt(y1);
            let (ax, ay) = (down.choose(x1, x0), down.choose(y1, y0));
            let (bx, by) = (down.choose(x0, x1), down.choose(y0, y1));
            let first = first_centre(ay, height);
            let end = first_centre(by, height);
            let slope = (bx - ax) / (by - ay);
            let at = group * V::COUNT;
            ax.store(&mut edges.x[at..]);
            ay.store(&mut edges.y[at..]);
            slope.store(&mut edges.slope[at..]);
            first.store(&mut edges.first[at..]);
            end.store(&mut edges.end[at..]);
            edges.crossing |= first.cmp_lt(end).mask().cast_unsigned() << at;
        }
    }
}

impl Outline<f32x8> {
    /// Of points that are left of a clipped polygon.
    pub fn clipped(points: &[Homogeneous], size: [f32; 2]) -> Self {
        // Clipping leaves rounding errors, and 0 / 0 where a polygon touches the eye: `max` and
        // `min` bring both back into the side.
        let groups = if points.len() > LANES { 2 } else { 1 };
        let (mut x, mut y) = ([0.0; 2 * LANES], [0.0; 2 * LANES]);
        let mut last = (0.0, 0.0);
        for (k, (x, y)) in x.iter_mut().zip(&mut y).enumerate().take(groups * LANES) {
            if let Some(p) = points.get(k) {
                let inverse = 1.0 / p.z;
                let within = |v: f32, size: f32| (v * inverse).max(0.0).min(size);
                last = (within(p.x, size[0]), within(p.y, size[1]));
            }
            (*x, *y) = last;
        }
        let (x, y) = (halves(x), halves(y));
        Self { x, y, groups }
    }
}

/// The edges of an outline that cross a row of centres.
#[derive(Default)]
pub(super) struct Edges {
    /// The lower end of each.
    x: [f32; 16],
    y: [f32; 16],
    slope: [f32; 16],
    /// Rows `first..end` are crossed.
    first: [f32; 16],
    end: [f32; 16],
    /// A bit for each edge that crosses any.
    crossing: u32,
}

impl Edges {
    /// Where the outline begins and ends in the rows of a band: columns; nothing where the first is not
    /// less than the second.
    pub fn spans(&self, row: usize, width: f32) -> [f32x8; 2] {
        let rows = all(row as f32) + STEPS;
        let centres = all(row as f32) + CENTRES;
        let (mut from, mut to) = (all(f32::INFINITY), all(f32::NEG_INFINITY));
        for k in bits(self.crossing) {
            let here = rows.cmp_ge(all(self.first[k])) & rows.cmp_lt(all(self.end[k]));
            let x = all(self.x[k]) + (centres - all(self.y[k])) * all(self.slope[k]);
            from = here.blend(x, all(f32::INFINITY)).fast_min(from);
            to = here.blend(x, all(f32::NEG_INFINITY)).fast_max(to);
        }
        [first_centre(from, width), first_centre(to, width)]
    }
}

fn halves(v: [f32; 16]) -> [f32x8; 2] {
    [0, 1].map(|h| f32x8::new(std::array::from_fn(|k| v[h * LANES + k])))
}
