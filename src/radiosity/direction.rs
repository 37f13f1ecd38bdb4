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

use rayon::prelude::*;

/// Patches whose products are summed as one piece.
const PIECE: usize = 4096;
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
