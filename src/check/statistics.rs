//! What the two halves of a check say together.
//!
//! Each point has two independent estimates a and b of the light x that the run found. The mean of
//! (a - x)(b - x) is the mean square error without a bias, as the noise of a and b is independent: it
//! may come out below zero where there is less error than noise.

use super::{Again, Points};
use glam::Vec3;
use std::time::Duration;

/// A point counts as odd if it is off by more than this share of its light...
const ODD: f32 = 0.5;
/// ...or of this share of the mean light, where that is more...
const DIM: f32 = 0.2;
/// ...and by so many standard errors.
const SURE: f32 = 6.0;

/// A point, what was found there and two estimates of it.
pub(super) struct Pair {
    pub point: usize,
    pub found: Vec3,
    pub weight: f64,
    pub again: Again,
}

/// What a check found.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Findings {
    /// Points lit again.
    pub points: usize,
    /// Of so many.
    pub of: usize,
    /// Paths a point.
    pub paths: u32,
    /// Mean square error relative to the mean square of the light. Below zero where noise hides it.
    pub square: f64,
    /// Standard error of `square`.
    pub square_deviation: f64,
    /// Light found over light expected, both summed; 1 where they agree.
    pub bias: f64,
    /// The same against rays alone: the noise of a few hundredths is in it.
    pub bias_by_rays: f64,
    /// Points that are off by more than noise can explain and half their light.
    pub odd: usize,
    /// The worst of those.
    pub worst: Option<Odd>,
    /// Seconds that the check took.
    pub seconds: f64,
}

/// A point that is far off.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Odd {
    /// Where.
    pub name: String,
    /// Light found, mean of the channels.
    pub found: f32,
    /// Light expected.
    pub expected: f32,
    /// Standard error of that.
    pub deviation: f32,
}

impl Findings {
    /// Relative root mean square error; `None` if it is lost in noise.
    pub fn error(&self) -> Option<f64> {
        (self.square > self.sure()).then(|| self.square.sqrt())
    }

    /// The error is hardly above this.
    pub fn at_most(&self) -> f64 {
        (self.square.max(0.0) + self.sure()).sqrt()
    }

    /// Two standard errors of the square, and more if few points tell them.
    fn sure(&self) -> f64 {
        (2.0 + 8.0 / self.points as f64) * self.square_deviation
    }

    /// Standard error of [`error`](Self::error).
    pub fn deviation(&self) -> f64 {
        0.5 * self.square_deviation / self.square.max(self.square_deviation).sqrt()
    }

    /// The worst point in words, with all that are far off.
    pub fn odd_text(&self) -> Option<String> {
        let Odd { name, found, expected, deviation } = self.worst.as_ref()?;
        // Light may be of any size: three digits that count.
        let size = found.abs().max(expected.abs()).max(1e-30).log10().floor();
        let digits = (2 - size as i32).clamp(0, 12) as usize;
        let others = match self.odd {
            1 => String::new(),
            n => format!(", and {} more points", n - 1),
        };
        Some(format!(
            "{name} has {found:.digits$}, not {expected:.digits$} +- {deviation:.digits$}{others}"
        ))
    }

    /// The error in words: percent, with its standard error.
    pub fn text(&self) -> String {
        let (error, deviation) = (self.error(), self.deviation());
        match error {
            Some(error) => format!("{:.2} % +- {:.2} %", 100.0 * error, 100.0 * deviation),
            None => format!("below {:.2} %", 100.0 * self.at_most()),
        }
    }
}

/// Puts pairs together.
pub(super) fn findings(
    points: &impl Points,
    pairs: &[Pair],
    paths: u32,
    time: Duration,
) -> Option<Findings> {
    // One channel stands for all if errors of their mean count.
    let channels = |v: Vec3| if points.channels_count() { v } else { mean(v) };
    let terms: Vec<(f64, f64, f64)> = pairs
        .iter()
        .map(|pair| {
            let [a, b] = pair.again.halves.map(channels);
            let x = channels(pair.found);
            let dot = |a: Vec3, b: Vec3| a.as_dvec3().dot(b.as_dvec3());
            (pair.weight, dot(a - x, b - x), dot(a, b))
        })
        .collect();
    let weights = terms.iter().map(|t| t.0).sum::<f64>();
    let light = terms.iter().map(|t| t.0 * t.2).sum::<f64>() / weights;
    if !(light > 0.0 && light.is_finite()) {
        return None;
    }
    let square = terms.iter().map(|t| t.0 * t.1).sum::<f64>() / weights;
    let spread = terms.iter().map(|t| (t.0 * (t.1 - square)).powi(2)).sum::<f64>().sqrt() / weights;
    let level = |v: Vec3| f64::from(v.element_sum());
    let sum = |f: &dyn Fn(&Pair) -> f64| pairs.iter().map(|p| p.weight * f(p)).sum::<f64>();
    let expected = sum(&|p| level(p.again.halves[0] + p.again.halves[1]) * 0.5);
    let by_rays = sum(&|p| level(p.again.rays));
    let (odd, worst) = odd_points(points, pairs);
    Some(Findings {
        points: pairs.len(),
        of: points.count(),
        paths,
        square: square / light,
        square_deviation: spread / light,
        bias: sum(&|p| level(p.found)) / expected,
        bias_by_rays: sum(&|p| level(p.found)) / by_rays,
        odd,
        worst,
        seconds: time.as_secs_f64(),
    })
}

/// How many points are far off, and the one that is so by the most.
fn odd_points(points: &impl Points, pairs: &[Pair]) -> (usize, Option<Odd>) {
    let of = |pair: &Pair| {
        let [a, b] = pair.again.halves.map(|h| mean(h).x);
        (mean(pair.found).x, 0.5 * (a + b), 0.5 * (a - b).abs())
    };
    // What noise is usual relative to the light: two halves may agree by chance.
    let squares =
        pairs.iter().map(of).map(|(_, e, d)| (f64::from(e).powi(2), f64::from(d).powi(2)));
    let (light, noise) = squares.fold((0.0, 0.0), |s, x| (s.0 + x.0, s.1 + x.1));
    let usual = (noise / f64::max(light, 1e-300)).sqrt() as f32;
    let average = pairs.iter().map(|p| of(p).1).sum::<f32>() / pairs.len() as f32;
    let off = |pair: &Pair| {
        let (found, expected, deviation) = of(pair);
        let deviation = deviation.max(usual * expected.abs());
        let limit = ODD * found.abs().max(expected.abs()).max(DIM * average);
        let off = (found - expected).abs();
        (off > limit && off > SURE * deviation).then_some((off, found, expected, deviation))
    };
    let odd: Vec<_> = pairs.iter().filter_map(|p| Some((p.point, off(p)?))).collect();
    let worst = odd.iter().max_by(|a, b| a.1.0.total_cmp(&b.1.0));
    let worst = worst.map(|&(point, (_, found, expected, deviation))| Odd {
        name: points.name(point),
        found,
        expected,
        deviation,
    });
    (odd.len(), worst)
}

/// Mean of the channels in the first, and 0.
fn mean(v: Vec3) -> Vec3 {
    Vec3::X * (v.element_sum() / 3.0)
}
