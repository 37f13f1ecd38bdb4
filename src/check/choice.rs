//! Sequences that fill a range evenly however many of their numbers are taken.

use crate::scene::random::SplitMix;

/// Golden ratio less 1: the most even step on a circle.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Its like in two and four dimensions: powers of 1 / x where x^3 = x + 1 and x^5 = x + 1 (M. Roberts,
/// "The unreasonable effectiveness of quasirandom sequences", 2018).
const PLANE: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
const FOUR: [f64; 4] = [
    0.856_674_883_854_502_9,
    0.733_891_856_627_126,
    0.628_706_721_038_087,
    0.538_597_257_226_131_7,
];

/// Indices below `count`, each once, the first of them well spread.
pub(super) fn spread(count: usize) -> impl Iterator<Item = usize> {
    // A step without a common divisor meets every index once.
    let mut step = ((count as f64 * GOLDEN) as usize).max(1);
    while gcd(step, count) != 1 {
        step += 1;
    }
    (0..count).map(move |k| (k as u128 * step as u128 % count as u128) as usize)
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Four numbers from 0 to 1 for path `k` of a point: two for its direction, two for its start. `shift`
/// makes the sequence of every point another.
pub(super) fn four(k: u32, shift: u64, start_counts: bool) -> [f32; 4] {
    let steps = if start_counts { FOUR } else { [PLANE[0], PLANE[1], 0.0, 0.0] };
    let mut random = SplitMix(shift);
    steps.map(|step| {
        let value = (random.next() + f64::from(k) * step).fract() as f32;
        value.min(1.0 - f32::EPSILON)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_index_comes_once() {
        for count in [1, 2, 3, 10, 97, 1000] {
            let mut all: Vec<usize> = spread(count).collect();
            all.sort_unstable();
            assert_eq!(all, (0..count).collect::<Vec<_>>());
        }
    }

    #[test]
    fn the_first_indices_leave_no_large_gap() {
        let mut first: Vec<usize> = spread(10_000).take(100).collect();
        first.sort_unstable();
        let gap = first.windows(2).map(|w| w[1] - w[0]).max().unwrap();
        assert!(gap < 300, "{gap}");
    }

    #[test]
    fn a_thousand_paths_know_a_mean_well() {
        for start_counts in [false, true] {
            let mean = |f: fn([f32; 4]) -> f32| {
                (0..1000).map(|k| f(four(k, 7, start_counts))).sum::<f32>() / 1000.0
            };
            assert!((mean(|u| u[0] * u[1]) - 0.25).abs() < 0.005);
            assert!((mean(|u| f32::from(u[0] < 0.3)) - 0.3).abs() < 0.005);
        }
    }
}
