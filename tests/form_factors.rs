//! Form factors against closed forms (J. R. Howell, *A Catalog of Radiation Heat Transfer
//! Configuration Factors*) and against the laws that all form factors obey.

mod support;

use glam::{DVec3, Vec3};
use qrad::patch::{PatchSet, Quad, TextPatches};
use qrad::radiosity::form_factor::{parallel_corner, rectangle, upright_corner};
use qrad::radiosity::hemicube::{DeltaFormFactors, HemicubeSize, SIDES, SideId, View};
use qrad::radiosity::transfers::{Gatherer, Sharing, Transfers};
use std::f64::consts::PI;
use std::ops::Range;
use support::lit_map::Prepared;
use support::quads::{BLACK, Light, cuboid, grid, scene, transfers};

const O: DVec3 = DVec3::ZERO;
const X: DVec3 = DVec3::X;
const Y: DVec3 = DVec3::Y;
const Z: DVec3 = DVec3::Z;

/// Sum of A_i F_ij over the patches i of `from` and j of `to`: the light that `from` catches when
/// `to` has exitance 1.
fn caught(p: &TextPatches, t: &Transfers, from: Range<usize>, to: Range<usize>) -> f64 {
    from.map(|i| {
        let (columns, factors) = t.row(i);
        let seen = columns.iter().zip(&factors).filter(|(j, _)| to.contains(&(**j as usize)));
        f64::from(p.set.patches[i].area) * seen.map(|(_, f)| f64::from(*f)).sum::<f64>()
    })
    .sum()
}

/// Errors of the mean form factor between two unit squares of n x n patches, relative.
fn square_errors(exact: f64, two: [DVec3; 3]) -> Vec<f64> {
    [1, 2, 4, 8, 16]
        .map(|n| {
            let mut quads = grid(O, X, Y, [n, n], BLACK);
            quads.extend(grid(two[0], two[1], two[2], [n, n], BLACK));
            let (patches, transfers) = transfers(&quads, 256);
            let got = caught(&patches, &transfers, 0..n * n, n * n..2 * n * n);
            (got / exact - 1.0).abs()
        })
        .to_vec()
}

#[track_caller]
fn errors_fall_below(errors: &[f64], limit: f64) {
    println!("relative errors {errors:.6?}");
    assert!(errors.windows(2).all(|e| e[1] < e[0]), "{errors:?}");
    assert!(errors[errors.len() - 1] < limit, "{errors:?}");
}

#[test]
fn opposite_unit_squares() {
    errors_fall_below(&square_errors(0.199825, [Z, Y, X]), 0.002);
}

#[test]
fn adjacent_unit_squares() {
    // They meet in the y axis: the integrand is singular there, and the centre rule still gets it.
    errors_fall_below(&square_errors(0.200044, [O, Y, Z]), 0.002);
}

/// Root mean square of the error at 64 points that look at a unit square, parallel to theirs or
/// upright on it, with hemicubes of `cells`; relative to that of the exact values.
fn point_error(cells: u32, upright: bool) -> f64 {
    let target = if upright { [X * 2.0, Z, Y] } else { [Z, Y, X] };
    let quads = grid(target[0], target[1], target[2], [1, 1], BLACK);
    let patches = TextPatches::new(&scene(quads.clone(), cells, 0));
    // The scene's middle is at the origin of its tracer.
    let middle = quads[0].vertices.iter().sum::<DVec3>() / 4.0;
    let size = HemicubeSize::new(cells, cells).unwrap();
    let delta = DeltaFormFactors::new(size);
    let mut gatherer = Gatherer::new(&patches.tracer, &patches.set, &delta, size);
    let (mut errors, mut values) = (0.0, 0.0);
    for k in 0..64 {
        let at = DVec3::new(f64::from(k % 8) * 0.23, f64::from(k / 8) * 0.19, 0.0);
        let view = View::turned((at - middle).as_vec3(), Vec3::Z, k as u64);
        let got: f64 = {
            gatherer.look(&view);
            gatherer.row()
        }
        .iter()
        .map(|r| r.1)
        .sum();
        let exact = if upright {
            // At distance 1: everything over the distance to the wall.
            let d = 2.0 - at.x;
            rectangle(upright_corner, [-at.y / d, (1.0 - at.y) / d], [0.0, 1.0 / d])
        } else {
            rectangle(parallel_corner, [-at.x, 1.0 - at.x], [-at.y, 1.0 - at.y])
        };
        errors += (got - exact).powi(2);
        values += exact * exact;
    }
    (errors / values).sqrt()
}

#[test]
fn finer_hemicubes_are_nearer_to_the_closed_form() {
    for upright in [false, true] {
        let errors = [8, 16, 32, 64, 128, 256, 512].map(|cells| point_error(cells, upright));
        errors_fall_below(&errors, 0.001);
    }
}

#[test]
fn delta_form_factors_are_the_integrals_over_their_cells() {
    // Midpoint rule with 16 x 16 points a cell.
    let integral = |a: [f64; 2], b: [f64; 2], f: &dyn Fn(f64, f64) -> f64| {
        let at = |r: [f64; 2], k: usize| r[0] + (r[1] - r[0]) * (k as f64 + 0.5) / 16.0;
        let sum: f64 = (0..256).map(|k| f(at(a, k % 16), at(b, k / 16))).sum();
        sum * (a[1] - a[0]) * (b[1] - b[0]) / 256.0
    };
    for (w, h) in [(16, 16), (6, 34)] {
        let delta = DeltaFormFactors::new(HemicubeSize::new(w, h).unwrap());
        for side in SIDES {
            let low = if side == SideId::Top { -1.0 } else { 0.0 };
            for (i, got) in delta.of(side).iter().enumerate() {
                let (x, y) = (i as u32 % w, i as u32 / w);
                let edge = |k: u32, n: u32, low: f64| low + 2.0 * f64::from(k) / f64::from(n);
                let a = [edge(x, w, -1.0), edge(x + 1, w, -1.0)];
                let b = [edge(y, h, low), edge(y + 1, h, low)];
                // Cosines at both ends over pi r^2, for a cell at distance 1.
                let want = integral(a, b, &|a, b| {
                    let square = 1.0 + a * a + b * b;
                    let own = if side == SideId::Top { 1.0 } else { b };
                    own / (PI * square * square)
                });
                let error = (f64::from(*got) / want - 1.0).abs();
                assert!(error < 1e-3, "{w}x{h} {side:?} {x} {y}: {got} {want}");
            }
        }
    }
}

/// Two rectangles of different size and patch count that face each other askew.
fn askew() -> (Vec<Quad>, usize) {
    let mut quads = grid(O, X, Y, [6, 6], BLACK);
    let first = quads.len();
    quads.extend(grid(DVec3::new(-1.0, 0.5, 3.0), Y * 2.0 + Z * 0.5, X * 3.0, [10, 14], BLACK));
    (quads, first)
}

#[test]
fn the_light_two_surfaces_exchange_is_the_same_both_ways() {
    let (quads, first) = askew();
    let (patches, transfers) = transfers(&quads, 256);
    let there = caught(&patches, &transfers, 0..first, first..quads.len());
    let back = caught(&patches, &transfers, first..quads.len(), 0..first);
    println!("there {there:.6}, back {back:.6}: {:.2e} apart", (there / back - 1.0).abs());
    assert!((there / back - 1.0).abs() < 1e-3);
}

#[test]
fn each_far_pair_of_patches_is_reciprocal() {
    // Every pair is at least 15 patch sizes apart, so the centre stands for its patch; what is left
    // is the aliasing of a patch that is about 30 cells wide.
    let (quads, first) = askew();
    let (patches, transfers) = transfers(&quads, 1024);
    let factor = |i: usize, j: usize| {
        let (columns, factors) = transfers.row(i);
        columns.binary_search(&(j as u32)).map_or(0.0, |k| f64::from(factors[k]))
    };
    let area = |i: usize| f64::from(patches.set.patches[i].area);
    let mut errors: Vec<f64> = (0..first)
        .flat_map(|i| (first..quads.len()).map(move |j| (i, j)))
        .map(|(i, j)| ((area(i) * factor(i, j)) / (area(j) * factor(j, i)) - 1.0).abs())
        .collect();
    errors.sort_by(f64::total_cmp);
    let (median, worst) = (errors[errors.len() / 2], errors[errors.len() - 1]);
    println!("{} pairs, median {median:.4}, worst {worst:.4}", errors.len());
    assert!(worst < 0.05 && median < 0.01, "{median} {worst}");
}

/// Largest distance of a row sum from 1.
fn worst_row(transfers: &Transfers) -> f64 {
    (0..transfers.rows())
        .map(|i| transfers.row(i).1.iter().map(|&f| f64::from(f)).sum::<f64>())
        .fold(0.0, |worst, sum| (sum - 1.0).abs().max(worst))
}

#[test]
fn rows_sum_to_one_in_a_closed_room_of_quads() {
    let grey = Light { exitance: 0.1, reflectance: 0.5 };
    let mut quads = cuboid(O, DVec3::new(3.0, 4.0, 2.5), 5, true, grey);
    let empty = worst_row(&transfers(&quads, 64).1);
    quads.extend(cuboid(DVec3::new(0.7, 1.1, 0.6), DVec3::new(1.9, 2.3, 1.4), 3, false, grey));
    let boxed = worst_row(&transfers(&quads, 64).1);
    println!("worst row sum: {empty:.1e} from 1 in the empty room, {boxed:.1e} with a box inside");
    assert!(empty < 1e-6 && boxed < 1e-6);
}

#[test]
fn rows_sum_to_one_in_closed_maps() {
    for name in ["furnace.bsp", "furnace_inner.bsp", "cornell.bsp"] {
        let transfers = row_each(&Prepared::project_map(name, false));
        let worst = worst_row(&transfers);
        println!("{name}: {} rows, worst {worst:.1e} from 1", transfers.rows());
        assert!(transfers.rows() > 100 && worst < 1e-6, "{name}: {worst}");
    }
}

/// Light that varies over a room.
fn waves(set: &PatchSet) -> Vec<DVec3> {
    let wave = |p: Vec3| 1.0 + 0.5 * (f64::from(p.x + 2.0 * p.y - p.z) / 300.0).sin();
    set.patches.iter().map(|p| DVec3::splat(wave(p.eye))).collect()
}

/// A row for each patch of a map, all of the same hemicubes.
fn row_each(map: &Prepared) -> Transfers {
    Transfers::compute(map.scene.bounce_tracer(), &map.patches.set, map.settings.hemicube, |_| {})
}

/// Rows that patches share against a row for each.
#[test]
fn shared_rows_tell_almost_the_same_light() {
    let map = support::lit_map::Prepared::project_map("atrium.bsp", false);
    let (set, groups) = (&map.patches.set, map.patches.groups());
    let none_small = vec![false; groups.of.len()];
    let drawn = |share: f32, small: &[bool]| {
        let (tracer, size) = (map.scene.bounce_tracer(), map.settings.hemicube);
        let sharing = Sharing { groups: &groups, share, small };
        Transfers::shared(tracer, set, sharing, size, |_| {})
    };
    let shared = |share: f32| drawn(share, &none_small);
    let exitance = waves(set);
    let all = row_each(&map);
    let none = shared(0.0);
    let exact = none.gather(&exitance);
    assert_eq!((none.stored(), none.len()), (none.rows(), all.len()), "nothing is shared");
    // Two bytes a form factor against four.
    for i in 0..none.rows() {
        let ((patches, kept), (seen, factors)) = (none.row(i), all.row(i));
        assert_eq!(patches, seen, "patch {i}");
        let near = |(a, b): (&f32, &f32)| (a - b).abs() <= b * 2.0_f32.powi(-11);
        assert!(kept.iter().zip(&factors).all(near), "patch {i}");
    }
    let single = all.gather(&exitance);
    let off =
        exact.iter().zip(&single).filter(|(_, b)| b.x > 0.0).map(|(a, b)| (a.x / b.x - 1.0).abs());
    let worst = off.fold(0.0, f64::max);
    println!("two bytes a form factor: irradiance off by {worst:.1e} at worst");
    // No light is negative: none can be further off than the factors are.
    assert!(worst > 0.0 && worst <= 2.0_f64.powi(-11), "{worst}");
    let some = shared(0.25);
    assert!(some.stored() * 10 < some.rows() * 9, "{} of {}", some.stored(), some.rows());
    let light = some.gather(&exitance);
    let (mut error, mut sum) = (0.0, 0.0);
    for (i, (a, b)) in light.iter().zip(&exact).enumerate() {
        if !some.is_shared(i) {
            assert_eq!(some.row(i), none.row(i), "patch {i} has its own row");
        }
        error += (a.x - b.x).powi(2);
        sum += b.x.powi(2);
    }
    let rms = (error / sum).sqrt();
    println!("{} of {} rows drawn, rms {rms:.4}", some.stored(), some.rows());
    // What irradiance varies by over this share of the distance to what is seen, in the model of Ward,
    // Rubinstein and Clear (1988); patches that share are half of that apart or less on the whole.
    assert!(rms < 4.0 / PI * 0.25 / 2.0, "{rms}");
}

/// Coarser hemicubes at small patches against fine ones everywhere.
#[test]
fn small_patches_do_with_fewer_cells() {
    let map = support::lit_map::Prepared::project_map("atrium.bsp", false);
    let (set, size) = (&map.patches.set, map.settings.hemicube);
    let (groups, small) = (map.patches.groups(), map.patches.small());
    let few = small.iter().filter(|&&small| small).count();
    assert!(few > 20 && few * 2 < small.len(), "{few} of {}", small.len());
    let none_small = vec![false; small.len()];
    let drawn = |small: &[bool]| {
        let sharing = Sharing { groups: &groups, share: 0.0, small };
        Transfers::shared(map.scene.bounce_tracer(), set, sharing, size, |_| {})
    };
    let (exitance, rough, fine) = (waves(set), drawn(&small), drawn(&none_small));
    let [light, exact] = [&rough, &fine].map(|t| t.gather(&exitance));
    let (mut error, mut sum) = (0.0, 0.0);
    for (i, patch) in set.patches.iter().enumerate() {
        if !small[i] {
            assert_eq!(rough.row(i), fine.row(i), "patch {i} is not small");
        }
        // What matters is the light that they reflect.
        let area = f64::from(patch.area);
        error += area * (light[i].x - exact[i].x).powi(2);
        sum += area * exact[i].x.powi(2);
    }
    let rms = (error / sum).sqrt();
    println!("{few} of {} small, rms {rms:.5}", small.len());
    // In squares that adds less than a tenth of a percent to the 3.5 % by which default light on maps errs.
    let most = (0.036f64.powi(2) - 0.035f64.powi(2)).sqrt();
    assert!(rms > 0.0 && rms < most, "{rms}");
}

/// A look that is visited run by run has the form factors of the row.
#[test]
fn visits_sum_to_the_row() {
    let map = support::lit_map::Prepared::project_map("atrium.bsp", false);
    let set = &map.patches.set;
    for cells in [16, 26] {
        let size = HemicubeSize::new(cells, cells).unwrap();
        let delta = DeltaFormFactors::new(size);
        let mut gatherer = Gatherer::new(map.scene.bounce_tracer(), set, &delta, size);
        for (i, patch) in set.patches.iter().enumerate().step_by(37) {
            let view = View::turned(patch.eye, patch.normal, i as u64);
            let mut sums = vec![0.0; set.patches.len()];
            gatherer.visit(&view, 200.0, |patch, _, f| sums[patch.0 as usize] += f64::from(f));
            let distances = gatherer.distances();
            gatherer.look(&view);
            assert_eq!(gatherer.distances(), distances);
            for &(patch, f) in gatherer.row() {
                let sum = std::mem::take(&mut sums[patch.0 as usize]);
                assert!((sum - f).abs() < 1e-6, "patch {i}: {sum} {f}");
            }
            assert!(sums.iter().all(|&f| f == 0.0), "patch {i} visits more than its row");
        }
    }
}
