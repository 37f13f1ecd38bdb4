//! Directions to send light in so that little is left to send after few passes: conjugate residuals.
//!
//! With T the share of what patches send that they send again (reflectance times form factors), the
//! exitance M solves (1 - T) M = E. A pass of plain bounces adds what is left to send, r, to what was
//! sent, and T r is left. Here p, what a pass adds, is r less a share of what the pass before added, so that
//! q = (1 - T) p stands upright on its q, and so much of it as leaves the smallest sum of squares of r: the
//! method Orthomin(1), in which one earlier direction is as good as all of them where T is symmetric but
//! for factors on rows and columns, as it is here but for errors of form factors (P. Vinsome, "Orthomin,
//! an iterative method for solving sparse sets of simultaneous linear equations", 1976; S. Eisenstat, H.
//! Elman and M. Schultz, "Variational iterative methods for nonsymmetric systems of linear equations", 1983).

use super::solve::PIECE;
use rayon::prelude::*;

/// A pass that leaves more than this share of the largest patch's light, and more than a plain one would, is
/// made a plain one.
const ENOUGH: f64 = 0.9;

/// What the last pass added, but for a factor. Each of the `C` channels is treated by itself.
pub(super) struct Direction<const C: usize> {
    /// Light that was sent.
    sent: Vec<[f64; C]>,
    /// How much less there was to send then.
    gone: Vec<[f64; C]>,
    /// Sum of the squares of `gone`; 0 where the direction is of no use.
    squares: [f64; C],
}

impl<const C: usize> Direction<C> {
    /// Makes a pass where sending all that is `unsent` brings `returned` back to be sent: changes `total`, the
    /// light sent and unsent together, and `unsent`. Of the largest absolute values of `unsent`, at least
    /// a tenth goes, or as much as in a plain pass, which puts `returned` in its place: so passes come
    /// to an end wherever plain ones do.
    pub(super) fn pass(
        before: Option<Self>,
        total: &mut [[f64; C]],
        unsent: &mut [[f64; C]],
        returned: &[[f64; C]],
    ) -> Self {
        let mut sent = unsent.to_vec();
        let mut gone = sent.clone();
        change(&mut gone, returned, |gone, returned, _| gone - returned);
        if let Some(before) = before {
            let share = share(products(&gone, &before.gone), before.squares, 0.0);
            change(&mut gone, &before.gone, |gone, before, c| gone - share[c] * before);
            change(&mut sent, &before.sent, |sent, before, c| sent - share[c] * before);
        }
        let mut squares = products(&gone, &gone);
        let share = share(products(unsent, &gone), squares, 1.0);
        let left: [f64; C] = largest(unsent, &gone, |unsent, gone, c| unsent - share[c] * gone);
        let [all, plain]: [[f64; C]; 2] =
            [largest(unsent, unsent, |m, _, _| m), largest(returned, returned, |m, _, _| m)];
        let well: [bool; C] = std::array::from_fn(|c| left[c] <= plain[c].max(ENOUGH * all[c]));
        for (squares, well) in squares.iter_mut().zip(well) {
            *squares = if well { *squares } else { 0.0 };
        }
        let lists = (total, unsent, &sent, &gone, returned);
        lists.into_par_iter().with_min_len(PIECE).for_each(|(total, unsent, p, q, returned)| {
            for c in 0..C {
                if well[c] {
                    total[c] += share[c] * (p[c] - q[c]);
                    unsent[c] -= share[c] * q[c];
                } else {
                    total[c] += returned[c];
                    unsent[c] = returned[c];
                }
            }
        });
        Self { sent, gone, squares }
    }
}

/// Changes each value of a list by that of another.
fn change<const C: usize>(
    list: &mut [[f64; C]],
    by: &[[f64; C]],
    changed: impl Fn(f64, f64, usize) -> f64 + Sync,
) {
    list.par_iter_mut().zip(by).with_min_len(PIECE).for_each(|(value, by)| {
        for c in 0..C {
            value[c] = changed(value[c], by[c], c);
        }
    });
}

/// Sum of products, by channel, in an order that does not depend on the number of threads.
fn products<const C: usize>(a: &[[f64; C]], b: &[[f64; C]]) -> [f64; C] {
    let of_piece = |(a, b): (&[[f64; C]], &[[f64; C]])| {
        let mut sum = [0.0; C];
        for (a, b) in a.iter().zip(b) {
            for c in 0..C {
                sum[c] += a[c] * b[c];
            }
        }
        sum
    };
    let pieces: Vec<[f64; C]> =
        a.par_chunks(PIECE).zip(b.par_chunks(PIECE)).map(of_piece).collect();
    std::array::from_fn(|c| pieces.iter().map(|sum| sum[c]).sum())
}

/// Products over squares, `otherwise` where that is no number of use.
fn share<const C: usize>(products: [f64; C], squares: [f64; C], otherwise: f64) -> [f64; C] {
    std::array::from_fn(|c| {
        let share = products[c] / squares[c];
        if share.is_finite() { share } else { otherwise }
    })
}

/// Largest absolute value of what is made of two lists, by channel.
fn largest<const C: usize>(
    a: &[[f64; C]],
    b: &[[f64; C]],
    value: impl Fn(f64, f64, usize) -> f64 + Sync,
) -> [f64; C] {
    let larger = |a: [f64; C], b: [f64; C]| std::array::from_fn(|c| a[c].max(b[c]));
    a.par_iter()
        .zip(b)
        .with_min_len(PIECE)
        .map(|(a, b)| std::array::from_fn(|c| value(a[c], b[c], c).abs()))
        .reduce(|| [0.0; C], larger)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Passes until 1e-9 of the light of patch 0 is left, plain or not, and the light then.
    fn passes(back: impl Fn(&[[f64; 2]]) -> Vec<[f64; 2]>, plain: bool) -> (u32, Vec<[f64; 2]>) {
        let mut unsent = vec![[0.0_f64; 2]; 60];
        unsent[0] = [1.0, -3.0];
        let mut total = unsent.clone();
        let (mut passes, mut direction) = (0, None);
        while unsent.as_flattened().iter().any(|m| m.abs() > 1e-9) {
            let returned = back(&unsent);
            if plain {
                for (total, m) in total.as_flattened_mut().iter_mut().zip(returned.as_flattened()) {
                    *total += m;
                }
                unsent = returned;
            } else {
                direction = Some(Direction::pass(direction, &mut total, &mut unsent, &returned));
            }
            passes += 1;
        }
        (passes, total)
    }

    fn compare(back: impl Fn(&[[f64; 2]]) -> Vec<[f64; 2]>) -> [u32; 2] {
        let ((plain, expected), (few, total)) = (passes(&back, true), passes(&back, false));
        let off = |(a, b): (&f64, &f64)| (a - b).abs();
        let pairs = expected.as_flattened().iter().zip(total.as_flattened());
        assert!(pairs.map(off).fold(0.0, f64::max) < 1e-7);
        println!("{few} passes for {plain}");
        [few, plain]
    }

    #[test]
    fn neighbours_that_light_each_other_take_few_passes() {
        let [few, plain] = compare(|m| {
            let sides = |i: usize, c: usize| m[(i + 1) % 60][c] + m[(i + 59) % 60][c];
            (0..60).map(|i| [0.47 * sides(i, 0), 0.3 * sides(i, 1)]).collect()
        });
        assert!(few * 3 < plain, "{few} and {plain}");
    }

    #[test]
    fn light_that_only_goes_round_ends_as_soon_as_by_plain_passes_or_a_tenth_a_pass() {
        for share in [0.5, 0.95, 0.99] {
            let [few, plain] =
                compare(|m| (0..60).map(|i| m[(i + 59) % 60].map(|m| share * m)).collect());
            assert!(few <= plain.max(230), "{few} and {plain}");
        }
    }

    #[test]
    fn dark_channels_and_patches_that_return_nothing_leave_no_nonsense() {
        let [few, plain] = compare(|m| m.iter().map(|_| [0.0; 2]).collect());
        assert_eq!([few, plain], [1, 1]);
        let [few, _] = compare(|m| (0..60).map(|i| [0.0, 0.9 * m[i][1]]).collect());
        assert!(few <= 3, "{few}");
    }
}
