//! Form factors between near, large, small and partly hidden patches, as `light_patches` makes them.

mod support;

use glam::DVec3;
use proptest::prelude::*;
use qrad::light_patches_with;
use qrad::patch::Quad;
use qrad::progress::Progress;
use qrad::radiosity::near_pairs::NearLimits;
use qrad::radiosity::solve::Solution;
use qrad::radiosity::transfers::Transfers;
use qrad::settings::Quality;
use support::quads::{Light, cuboid, grid, scene};

const O: DVec3 = DVec3::ZERO;
const X: DVec3 = DVec3::X;
const Y: DVec3 = DVec3::Y;
const Z: DVec3 = DVec3::Z;
const GREY: Light = Light { exitance: 0.5, reflectance: 0.5 };

fn lit(quads: Vec<Quad>, cells: u32, near: Option<NearLimits>) -> (Transfers, Solution) {
    light_patches_with(&scene(quads, cells, 1000), near, &Progress::new(false)).unwrap()
}

fn factor(transfers: &Transfers, i: usize, j: usize) -> f64 {
    let (columns, factors) = transfers.row(i);
    columns.binary_search(&(j as u32)).map_or(0.0, |k| f64::from(factors[k]))
}

/// Two patches of equal exitance, each the parallelogram of an origin and two edges.
fn pair(a: [DVec3; 3], b: [DVec3; 3]) -> (Vec<Quad>, [f64; 2]) {
    let mut quads = grid(a[0], a[1], a[2], [1, 1], GREY);
    quads.extend(grid(b[0], b[1], b[2], [1, 1], GREY));
    (quads, [a, b].map(|p| p[1].cross(p[2]).length()))
}

#[test]
fn a_pair_has_the_form_factor_of_the_catalogue_at_any_distance() {
    // Opposite and upright unit squares (Howell C-11, C-14).
    for (z, want) in
        [(0.01, 0.980_494_2), (0.1, 0.826_994_5), (1.0, 0.199_824_9), (10.0, 0.003_162_06)]
    {
        let (quads, _) = pair([O, X, Y], [Z * z, Y, X]);
        let got = factor(&lit(quads, 32, Some(Quality::Normal.near())).0, 0, 1);
        assert!((got / want - 1.0).abs() < 1e-3, "{z}: {got} instead of {want}");
    }
    let (quads, _) = pair([O, X, Y], [O, Y, Z]);
    let got = factor(&lit(quads, 32, Some(Quality::Normal.near())).0, 0, 1);
    assert!((got / 0.200_043_78 - 1.0).abs() < 1e-3, "{got}");
}

#[test]
fn plain_quality_leaves_the_hemicube_alone() {
    let (quads, _) = pair([O, X, Y], [Z, Y, X]);
    let got = factor(&lit(quads, 256, None).0, 0, 1);
    assert!((got / 0.239_3 - 1.0).abs() < 0.005, "a middle sees more: {got}");
}

fn coordinate() -> impl Strategy<Value = f64> {
    -1.0f64..1.0
}

fn vector() -> impl Strategy<Value = DVec3> {
    [coordinate(), coordinate(), coordinate()].prop_map(DVec3::from_array)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Nothing is between two patches: A_i F_ij = A_j F_ji.
    #[test]
    fn pairs_are_reciprocal(
        (u, v, way, p, q) in (vector(), vector(), vector(), vector(), vector()),
        size in -3.0f64..3.0,
    ) {
        let b = [way * 2.0 - (p + q) * 0.5, p * size.exp(), q * size.exp()];
        prop_assume!(u.cross(v).length() > 0.05 && p.cross(q).length() > 0.05);
        let (quads, areas) = pair([O, u, v], b);
        // Patches that cross each other hide parts of themselves.
        let crosses = |one: &Quad, two: &Quad| {
            let heights = two.vertices.map(|w| one.normal.dot(w - one.vertices[0]));
            heights.iter().any(|&h| h < 0.0) && heights.iter().any(|&h| h > 0.0)
        };
        prop_assume!(!(crosses(&quads[0], &quads[1]) || crosses(&quads[1], &quads[0])));
        let (transfers, _) = lit(quads, 32, Some(Quality::Final.near()));
        let (there, back) = (areas[0] * factor(&transfers, 0, 1), areas[1] * factor(&transfers, 1, 0));
        let larger = there.max(back);
        prop_assert!((there - back).abs() <= 2e-3 * larger + 1e-5 * areas[0].min(areas[1]), "{there} {back}");
    }
}

fn sums(transfers: &Transfers) -> impl Iterator<Item = f64> + '_ {
    (0..transfers.rows()).map(|i| transfers.row(i).1.iter().map(|&f| f64::from(f)).sum())
}

/// A closed room with a box on its floor, which covers the middle of the floor.
fn room_with_box() -> Vec<Quad> {
    let mut quads = cuboid(O, DVec3::new(3.0, 4.0, 2.5), 3, true, GREY);
    quads.extend(cuboid(DVec3::new(0.7, 1.1, 0.0), DVec3::new(1.9, 2.3, 1.4), 2, false, GREY));
    quads
}

#[test]
fn rows_of_closed_rooms_still_sum_to_one() {
    let empty = cuboid(O, DVec3::new(3.0, 4.0, 2.5), 4, true, GREY);
    for quality in
        [Some(Quality::Draft.near()), Some(Quality::Normal.near()), Some(Quality::Final.near())]
    {
        for sum in sums(&lit(empty.clone(), 32, quality).0) {
            assert!((sum - 1.0).abs() < 1e-5, "{quality:?}: {sum}");
        }
    }
    let mut floating = cuboid(O, DVec3::new(3.0, 4.0, 2.5), 3, true, GREY);
    let corners = (DVec3::new(0.7, 1.1, 0.6), DVec3::new(1.9, 2.3, 1.4));
    floating.extend(cuboid(corners.0, corners.1, 2, false, GREY));
    for sum in sums(&lit(floating, 32, Some(Quality::Normal.near())).0) {
        assert!((sum - 1.0).abs() < 1e-5, "{sum}");
    }
}

#[test]
fn covered_parts_of_a_patch_receive_nothing() {
    let (transfers, _) = lit(room_with_box(), 32, Some(Quality::Normal.near()));
    // The floor is side 4: nine patches of 1 x 4/3; the box covers 1.44 of its 12.
    let floor: Vec<f64> = sums(&transfers).skip(4 * 9).take(9).collect();
    println!("floor rows {floor:.4?}");
    let open = |from: f64, to: f64, low: f64, high: f64| (to.min(high) - from.max(low)).max(0.0);
    let mut left = 12.0;
    for y in 0..3 {
        for x in 0..3 {
            let along = open(f64::from(x), f64::from(x + 1), 0.7, 1.9);
            let across = open(f64::from(y) * 4.0 / 3.0, f64::from(y + 1) * 4.0 / 3.0, 1.1, 2.3);
            let want = 1.0 - along * across * 0.75;
            let near = floor.iter().filter(|&&sum| (sum - want).abs() < 1e-3).count();
            assert!(near > 0, "no floor patch is open to {want}");
            left -= along * across;
        }
    }
    let sum = floor.iter().sum::<f64>() / 9.0 * 12.0;
    assert!((sum - left).abs() < 2e-3, "{sum} instead of {left} of 12 are open");
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    for quality in [Quality::Normal, Quality::Final] {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let (transfers, solution) =
                pool.install(|| lit(room_with_box(), 32, Some(quality.near())));
            let rows: Vec<_> = (0..transfers.rows())
                .map(|i| {
                    let (columns, factors) = transfers.row(i);
                    (columns.clone(), factors.iter().map(|f| f.to_bits()).collect::<Vec<_>>())
                })
                .collect();
            let light: Vec<_> =
                solution.exitance.iter().map(|m| m.0.to_array().map(f32::to_bits)).collect();
            (rows, light)
        };
        assert!(with(1) == with(2), "{quality:?}");
    }
}

#[test]
fn light_between_bright_and_dark_patches_is_the_same_both_ways() {
    // Sums over surfaces, hidden parts included.
    let quads = room_with_box();
    let area: Vec<f64> = quads
        .iter()
        .map(|q| {
            0.5 * (q.vertices[2] - q.vertices[0]).cross(q.vertices[3] - q.vertices[1]).length()
        })
        .collect();
    let (transfers, _) = lit(quads, 64, Some(Quality::Normal.near()));
    let (mut error, mut all) = (0.0, 0.0);
    for i in 0..transfers.rows() {
        for j in 0..i {
            let (there, back) =
                (area[i] * factor(&transfers, i, j), area[j] * factor(&transfers, j, i));
            error += (there - back).powi(2);
            all += there.max(back).powi(2);
        }
    }
    let rms = f64::sqrt(error / all);
    println!("{rms:.4} apart");
    assert!(rms < 0.02, "{rms}");
}
