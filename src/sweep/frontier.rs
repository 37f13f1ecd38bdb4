//! Which points are worth their cost, and what a halved error costs.

/// Numbers of the points (cost, error) that no other beats in both, by rising cost.
pub fn pareto(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| {
        points[a].0.total_cmp(&points[b].0).then(points[a].1.total_cmp(&points[b].1))
    });
    let mut least = f64::INFINITY;
    order.retain(|&i| {
        let better = points[i].1 < least;
        least = least.min(points[i].1);
        better
    });
    order
}

/// Exponent p of error ~ cost^-p by least squares of the logarithms; `None` if the costs are all but
/// the same. A halved error takes 2^(1/p) times as long.
pub fn exponent(points: &[(f64, f64)]) -> Option<f64> {
    let usable = |p: &&(f64, f64)| p.0 > 0.0 && p.1 > 0.0;
    let logs: Vec<(f64, f64)> =
        points.iter().filter(usable).map(|p| (p.0.ln(), p.1.ln())).collect();
    let n = logs.len() as f64;
    let (mx, my) = logs.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / n, m.1 + p.1 / n));
    let (mut xx, mut xy) = (0.0, 0.0);
    for (x, y) in &logs {
        xx += (x - mx) * (x - mx);
        xy += (x - mx) * (y - my);
    }
    (logs.len() > 1 && xx / n > 0.01).then(|| -xy / xx)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beaten_points_are_not_on_the_front() {
        let points = [(4.0, 1.0), (1.0, 8.0), (2.0, 9.0), (3.0, 2.0), (3.0, 3.0), (5.0, 1.0)];
        assert_eq!(pareto(&points), [1, 3, 0]);
        assert!(pareto(&[]).is_empty());
    }

    #[test]
    fn the_exponent_of_a_power_law_is_found() {
        let points: Vec<_> =
            (1..6).map(|k| (f64::from(k), 3.0 * f64::from(k).powf(-0.7))).collect();
        assert!((exponent(&points).unwrap() - 0.7).abs() < 1e-9);
        assert_eq!(exponent(&[(1.0, 2.0)]), None);
        assert_eq!(exponent(&[(1.0, 2.0), (1.0, 1.0)]), None);
    }
}
