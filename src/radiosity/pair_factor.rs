//! The form factor of one pair of patches: closed form, times the share of it that is visible.

use super::area_points::{Spread, gauss, spread};
use super::contour::{area, clip_front, exchange, point_to_polygon};
use super::open_parts::{Ground, open_parts};
use super::visibility::{Occluders, Shaft};
use glam::{DVec2, DVec3};

/// A flat convex polygon with its measures.
pub struct Shape<'a> {
    /// Corners, counter-clockwise seen from the front.
    pub outline: &'a [DVec3],
    /// Mean of the corners.
    pub centre: DVec3,
    /// Unit normal of the front.
    pub normal: DVec3,
    /// Distance of the farthest corner from the centre.
    pub radius: f64,
    /// Square world units.
    pub area: f64,
    /// The parts of it that nothing covers, see [`open_parts`]; `None` where that is all of it.
    open: Option<Vec<Vec<DVec3>>>,
}

impl<'a> Shape<'a> {
    /// `normal` serves where the outline has no area to take one from.
    pub fn new(outline: &'a [DVec3], normal: DVec3) -> Self {
        let centre = outline.iter().sum::<DVec3>() / outline.len() as f64;
        let normal = outline[1..]
            .windows(2)
            .fold(DVec3::ZERO, |sum, p| sum + (p[0] - outline[0]).cross(p[1] - outline[0]))
            .try_normalize()
            .unwrap_or(normal);
        let radius = outline.iter().map(|p| p.distance(centre)).fold(0.0, f64::max);
        Self { outline, centre, normal, radius, area: area(outline), open: None }
    }

    /// The same, with what `occluders` cover of it left out; `lift` as in [`Ground`].
    pub fn uncovered(mut self, occluders: &Occluders, lift: f64) -> Self {
        let ground = Ground { outline: self.outline, normal: self.normal, lift };
        self.open =
            open_parts(ground, occluders.tracer(), |polygon| occluders.is_two_sided(polygon));
        self
    }

    /// The convex parts that nothing covers.
    pub fn parts(&self) -> impl Iterator<Item = &[DVec3]> {
        let whole = self.open.is_none().then_some(self.outline);
        whole.into_iter().chain(self.open.iter().flatten().map(|part| &part[..]))
    }

    /// Whether something covers a part of it.
    pub fn partly_covered(&self) -> bool {
        self.open.is_some()
    }

    /// Share of the area that nothing covers.
    pub fn open_share(&self) -> f64 {
        let Some(open) = &self.open else { return 1.0 };
        (open.iter().map(|part| area(part)).sum::<f64>() / self.area).clamp(0.0, 1.0)
    }
}

/// How well a form factor has to be known.
#[derive(Clone, Copy, Debug)]
pub struct Precision {
    /// Relative error of the closed form.
    pub closed: f64,
    /// Rays that tell how much of it is visible.
    pub rays: u32,
    /// Chooses the rays.
    pub seed: u64,
}

/// Parts of two patches that lie in front of each other; buffers that are reused.
#[derive(Default)]
pub struct Facing {
    one: Vec<DVec3>,
    two: Vec<DVec3>,
}

impl Facing {
    /// Form factor from `a` to `b`, in [0, 1], and its uncertainty. Rays start and end `lift` in
    /// front of the patches. `None` where numbers fail: a patch without area.
    pub fn factor(
        &mut self,
        (a, b): (&Shape<'_>, &Shape<'_>),
        occluders: &Occluders,
        lift: f64,
        precision: Precision,
    ) -> Option<(f64, f64)> {
        let (mut factor, mut error) = (0.0, 0.0);
        let pairs = a.parts().count() * b.parts().count();
        let precision =
            Precision { rays: (precision.rays / pairs.max(1) as u32).max(16), ..precision };
        for part_a in a.parts() {
            for part_b in b.parts() {
                let part = self.part((part_a, a), (part_b, b), occluders, lift, precision)?;
                factor += part.0;
                error += part.1;
            }
        }
        Some((factor.min(1.0), error))
    }

    /// The same for a part of each.
    fn part(
        &mut self,
        (part_a, a): (&[DVec3], &Shape<'_>),
        (part_b, b): (&[DVec3], &Shape<'_>),
        occluders: &Occluders,
        lift: f64,
        precision: Precision,
    ) -> Option<(f64, f64)> {
        clip_front(part_a, b.outline[0], b.normal, &mut self.one);
        clip_front(part_b, a.outline[0], a.normal, &mut self.two);
        // Faces that lie on each other leave no room for light, whatever the closed form says.
        let apart = |part: &[DVec3], of: &Shape<'_>| {
            part.len() >= 3 && part.iter().any(|p| of.normal.dot(*p - of.outline[0]) > lift)
        };
        if !(apart(&self.one, b) && apart(&self.two, a)) {
            return Some((0.0, 0.0));
        }
        let (one, two) = ((&self.one[..], a), (&self.two[..], b));
        let (smaller, larger) = if a.radius <= b.radius { (one, two) } else { (two, one) };
        let (exchanged, error) = unoccluded(smaller, larger, precision.closed);
        let (factor, error) = ((exchanged / a.area).min(1.0), error / a.area);
        if !(factor.is_finite() && error.is_finite()) {
            return None;
        }
        if factor == 0.0 || occluders.is_empty() {
            return Some((factor, error));
        }
        let (one, two) = ((one.0, a.normal), (two.0, b.normal));
        if !occluders.between(&Shaft::new(one, two)) {
            return Some((factor, error));
        }
        let share = visible(one, two, occluders, lift, precision);
        // Points spread evenly in four dimensions err by about n^-0.7 at an edge.
        let unsure = 0.5 * f64::from(precision.rays).powf(-0.7);
        Some((factor * share, error + factor * unsure))
    }
}

/// Exchange of two clipped polygons, the first being the smaller, and its uncertainty: the mean over
/// few points where it is flat enough, else the double contour integral. `allowed` is relative.
fn unoccluded(
    (small, a): (&[DVec3], &Shape<'_>),
    (large, b): (&[DVec3], &Shape<'_>),
    allowed: f64,
) -> (f64, f64) {
    let way = b.centre - a.centre;
    let gap = (way.length() - b.radius).max(way.dot(b.normal).abs());
    let apart = gap / a.radius;
    // Gauss rules of n points are exact for polynomials of degree 2 n - 1.
    let bound = |order: i32| (0.5 / apart).powi(2 * order);
    let order = if apart > 2.0 { (1..=4).find(|&order| bound(order) <= allowed) } else { None };
    // Far away the contour integral cancels, and four points are exact.
    let order = order.or((apart > 20.0).then_some(4));
    let Some(order) = order else {
        return (exchange(small, large, 1e-8 * a.area.min(b.area)), 0.0);
    };
    let mut sum = 0.0;
    gauss(small, order as usize, |p, w| sum += w * point_to_polygon(p, a.normal, large));
    (sum, sum * bound(order))
}

/// Share of the exchange of two polygons, each with its normal, that gets past the occluders.
fn visible(
    (a, a_normal): (&[DVec3], DVec3),
    (b, b_normal): (&[DVec3], DVec3),
    occluders: &Occluders,
    lift: f64,
    precision: Precision,
) -> f64 {
    let (on_a, on_b) = (Spread::new([a]), Spread::new([b]));
    let shift = (precision.seed as f64 * 0.618_033_988_749_894_9).fract();
    let (mut all, mut clear) = (0.0, 0.0);
    for k in 0..precision.rays {
        let [s, t, u, v] = spread(k, shift);
        let (p, q) = (on_a.point(DVec2::new(s, t)), on_b.point(DVec2::new(u, v)));
        let way = q - p;
        let square = way.length_squared();
        let cosines = a_normal.dot(way).max(0.0) * (-b_normal.dot(way)).max(0.0);
        let kernel = cosines / (square * square);
        if kernel > 0.0 && kernel.is_finite() {
            all += kernel;
            if occluders.clear(p + a_normal * lift, q + b_normal * lift) {
                clear += kernel;
            }
        }
    }
    if all > 0.0 { clear / all } else { 0.0 }
}
