//! The solver against closed forms, against the series of its own passes, and against the equation
//! that it solves.

mod support;

use glam::{DVec3, Vec3};
use qrad::patch::{Passage, PatchId, TextPatches, TextScene};
use qrad::photometry::{Exitance, Irradiance, Reflectance};
use qrad::progress::Progress;
use qrad::radiosity::solve::{Limits, Solution, Sources, solve, solve_with};
use qrad::radiosity::transfers::Transfers;
use support::quads::{BLACK, Light, cuboid, grid, scene, transfers};

const EXACT: Limits = Limits { passes: None, residual: 1e-12 };

fn light(scene: &TextScene) -> (Transfers, Solution) {
    qrad::light_patches(scene, &Progress::new(false)).unwrap()
}

/// Form factor of the program, 0 where nothing is seen.
fn factor(transfers: &Transfers, i: usize, j: usize) -> f64 {
    let (columns, factors) = transfers.row(i);
    columns.binary_search(&(j as u32)).map_or(0.0, |k| f64::from(factors[k]))
}

/// Two unit squares that face each other; the first emits, both reflect.
fn two_squares(passes: u32) -> TextScene {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let first = Light { exitance: 0.75, reflectance: 0.5 };
    let second = Light { exitance: 0.25, reflectance: 0.875 };
    let mut quads = grid(DVec3::ZERO, x, y, [1, 1], first);
    quads.extend(grid(z, y, x, [1, 1], second));
    scene(quads, 128, passes)
}

fn close(got: f64, want: f64) -> bool {
    (got - want).abs() <= 1e-6 * want
}

#[test]
fn two_patches_reflect_each_other_without_end() {
    let (transfers, solution) = light(&two_squares(1000));
    let (f, back) = (factor(&transfers, 0, 1), factor(&transfers, 1, 0));
    assert!(f > 0.1 && (f / back - 1.0).abs() < 0.02, "{f} {back}");
    // M0 = E0 + r0 f M1 and M1 = E1 + r1 b M0, solved by hand.
    let loss = 1.0 - 0.5 * 0.875 * f * back;
    let want = [(0.75 + 0.5 * f * 0.25) / loss, (0.25 + 0.875 * back * 0.75) / loss];
    for (got, want) in solution.exitance.iter().zip(want) {
        assert!(got.0.to_array().iter().all(|c| close((*c).into(), want)), "{got:?} {want}");
    }
    assert!(solution.settled && solution.passes < 20 && solution.residual <= 1e-9);
}

#[test]
fn each_pass_adds_one_term_of_the_series() {
    let (e, rho) = ([0.75, 0.25], [0.5, 0.875]);
    let mut sum = e;
    let mut term = e;
    for passes in 0..8 {
        let (transfers, solution) = light(&two_squares(passes));
        assert_eq!((solution.passes, solution.settled), (passes, false));
        for (got, want) in solution.exitance.iter().zip(sum) {
            assert!(close(got.0.x.into(), want), "{passes} passes: {got:?} instead of {want}");
        }
        let f = [factor(&transfers, 0, 1), factor(&transfers, 1, 0)];
        term = [rho[0] * f[0] * term[1], rho[1] * f[1] * term[0]];
        sum = [sum[0] + term[0], sum[1] + term[1]];
    }
}

#[test]
fn no_pass_sends_nothing() {
    let (_, solution) = light(&two_squares(0));
    let exitance: Vec<Vec3> = solution.exitance.iter().map(|m| m.0).collect();
    assert_eq!(exitance, [Vec3::splat(0.75), Vec3::splat(0.25)]);
    assert_eq!((solution.passes, solution.settled, solution.residual), (0, false, 1.0));
}

#[test]
fn a_dark_scene_is_settled_at_once() {
    let dark = Light { exitance: 0.0, reflectance: 0.9 };
    let room = cuboid(DVec3::ZERO, DVec3::ONE, 1, true, dark);
    let (_, solution) = light(&scene(room, 16, 10));
    assert_eq!((solution.passes, solution.settled, solution.residual), (0, true, 0.0));
    assert!(solution.exitance.iter().all(|m| *m == Exitance::ZERO));
}

#[test]
fn black_surfaces_settle_in_one_pass() {
    let mut quads = grid(DVec3::ZERO, DVec3::X, DVec3::Y, [1, 1], BLACK);
    quads.extend(grid(DVec3::Z, DVec3::Y, DVec3::X, [1, 1], Light { exitance: 1.0, ..BLACK }));
    let (_, solution) = light(&scene(quads, 16, 10));
    assert_eq!((solution.passes, solution.settled), (1, true));
    assert_eq!(solution.exitance[0], Exitance::ZERO);
}

/// In a closed room whose surfaces all emit e and reflect rho, exitance is e / (1 - rho) everywhere:
/// the reflected part is rho / (1 - rho) times what is emitted.
#[test]
fn furnaces_have_the_exact_level_whatever_their_shape() {
    for reflectance in [0.5, 0.9, 0.99, 0.999] {
        let grey = Light { exitance: 0.001, reflectance };
        let mut quads = cuboid(DVec3::ZERO, DVec3::new(3.0, 2.0, 5.0), 4, true, grey);
        let (low, high) = (DVec3::new(1.0, 0.5, 1.0), DVec3::new(1.7, 1.5, 2.0));
        quads.extend(cuboid(low, high, 2, false, grey));
        let (_, solution) = light(&scene(quads, 32, 100_000));
        let reflected = 0.001 * reflectance / (1.0 - reflectance);
        let worst = solution
            .exitance
            .iter()
            .flat_map(|m| m.0.to_array())
            .map(|m| ((f64::from(m) - 0.001) / reflected - 1.0).abs())
            .fold(0.0, f64::max);
        println!("reflectance {reflectance}: off by {worst:.1e}, {} passes", solution.passes);
        assert!(solution.settled && worst <= 2e-4, "{reflectance}: {worst}");
    }
}

/// A room with a box, every patch of another colour: form factors and reflectances.
fn colourful() -> (TextPatches, Transfers, Vec<Reflectance>) {
    let mut quads = cuboid(DVec3::ZERO, DVec3::new(3.0, 2.0, 2.5), 4, true, BLACK);
    quads.extend(cuboid(DVec3::splat(0.6), DVec3::splat(1.3), 2, false, BLACK));
    let (patches, transfers) = transfers(&quads, 64);
    let wave = |k: usize| 0.45 + 0.45 * (k as f32 * 1.7).sin();
    let rho = (0..quads.len()).map(|i| Reflectance(Vec3::new(wave(i), wave(i + 7), wave(3 * i))));
    let rho = rho.collect();
    (patches, transfers, rho)
}

/// Largest |M - E - rho (D + F M)| over the largest M: 0 for the exact solution.
fn residual(transfers: &Transfers, rho: &[Reflectance], from: Sources<'_>, m: &[Exitance]) -> f64 {
    let (mut worst, mut most) = (0.0_f64, 0.0_f64);
    for i in 0..m.len() {
        let direct = from.direct.get(i).map_or(DVec3::ZERO, |d| d.0.as_dvec3());
        // The sum is written out here, so that the solver's own gathering is tested too.
        let (columns, factors) = transfers.row(i);
        let arriving = columns
            .iter()
            .zip(&factors)
            .fold(direct, |sum, (&j, &f)| sum + m[j as usize].0.as_dvec3() * f64::from(f));
        let want = from.emission[i].0.as_dvec3() + rho[i].0.as_dvec3() * arriving;
        worst = worst.max((m[i].0.as_dvec3() - want).abs().max_element());
        most = most.max(want.max_element());
    }
    worst / most
}

#[test]
fn the_solution_satisfies_the_radiosity_equation() {
    let (patches, transfers, rho) = colourful();
    let count = patches.set.patches.len();
    assert_eq!(count, 120);
    let mut emission = vec![Exitance::ZERO; count];
    emission[3] = Exitance(Vec3::new(20.0, 5.0, 1.0));
    emission[77] = Exitance(Vec3::new(0.0, 0.5, 300.0));
    let direct: Vec<Irradiance> =
        (0..count).map(|i| Irradiance(Vec3::splat((i % 5) as f32))).collect();
    let dark = vec![Exitance::ZERO; count];
    for sources in [
        Sources { emission: &emission, direct: &[] },
        Sources { emission: &dark, direct: &direct },
        Sources { emission: &emission, direct: &direct },
    ] {
        let solution = solve(&transfers, &rho, sources, EXACT);
        let left = residual(&transfers, &rho, sources, &solution.exitance);
        println!("{} passes, equation off by {left:.1e}", solution.passes);
        // The solution is stored in single precision.
        assert!(solution.settled && left < 1e-6, "{left}");
        // The measure itself can tell: one bounce less than all is no solution.
        let early = solve(&transfers, &rho, sources, Limits { passes: Some(2), residual: 1e-12 });
        assert!(residual(&transfers, &rho, sources, &early.exitance) > 1e-3);
    }
}

/// Without a limit of passes, they are not bounces, but end at the same light.
#[test]
fn few_passes_find_what_all_bounces_do() {
    let (patches, transfers, colours) = colourful();
    let count = patches.set.patches.len();
    let mut emission = vec![Exitance::ZERO; count];
    emission[3] = Exitance(Vec3::new(20.0, 5.0, 0.0));
    // A light that takes away.
    emission[100] = Exitance(Vec3::new(-7.0, 0.0, 0.0));
    let direct: Vec<Irradiance> =
        (0..count).map(|i| Irradiance(Vec3::new((i % 5) as f32, 0.0, -0.5))).collect();
    // Light goes through from each patch of the box to another.
    let passage = |i: usize| Passage {
        from: PatchId(i as u32),
        to: PatchId((count - 1 + 96 - i) as u32),
        transmittance: Vec3::new(0.08, 0.02, 0.0),
    };
    let through: Vec<Passage> = (96..count).map(passage).collect();
    let bright = vec![Reflectance(Vec3::splat(0.99)); count];
    for (name, rho, passages) in
        [("colours", &colours, &[][..]), ("bright", &bright, &[]), ("sheets", &colours, &through)]
    {
        for (emission, direct) in [(&emission, &direct[..]), (&emission, &[])] {
            let sources = Sources { emission, direct };
            for limit in [1e-3, 1e-5, 1e-9] {
                let solved = |passes| {
                    let limits = Limits { passes, residual: limit };
                    solve_with(&transfers, rho, passages, sources, limits)
                };
                let (few, all) = (solved(None), solved(Some(100_000)));
                println!("{name}, {limit:.0e}: {} passes, {} bounces", few.passes, all.passes);
                assert!(few.settled && all.settled && few.residual <= limit);
                assert!(few.passes <= all.passes, "{name}: {}", few.passes);
                assert!(limit > 1e-5 || few.passes * 4 <= all.passes * 3, "{}", few.passes);
                let most = all.exitance.iter().map(|m| m.0.abs().max_element()).fold(0.0, f32::max);
                let pairs = few.exitance.iter().zip(&all.exitance);
                let off = pairs.map(|(a, b)| (a.0 - b.0).abs().max_element()).fold(0.0, f32::max);
                // What is left comes back at most 1 / (1 - 0.99) times.
                let may = 2.0 * limit / (1.0 - 0.99) + 1e-6;
                assert!(f64::from(off / most) <= may, "{name}: {} off", off / most);
                if passages.is_empty() {
                    let left = residual(&transfers, rho, sources, &few.exitance);
                    assert!(left <= few.residual + 1e-6, "{name}: {left}, not {}", few.residual);
                }
            }
        }
    }
}

#[test]
fn light_adds_up() {
    let (patches, transfers, rho) = colourful();
    let count = patches.set.patches.len();
    let lone = |at: usize| {
        let mut emission = vec![Exitance::ZERO; count];
        emission[at] = Exitance(Vec3::new(3.0, 7.0, 11.0));
        emission
    };
    let solved = |emission: &[Exitance]| {
        solve(&transfers, &rho, Sources { emission, direct: &[] }, EXACT).exitance
    };
    let both: Vec<Exitance> = lone(5).iter().zip(lone(80)).map(|(a, b)| *a + b).collect();
    for ((a, b), sum) in solved(&lone(5)).iter().zip(solved(&lone(80))).zip(solved(&both)) {
        assert!(((*a + b).0 - sum.0).abs().max_element() <= 1e-6 * sum.0.max_element());
    }
}
