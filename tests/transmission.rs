//! Text scenes with patches that light passes through: closed forms, a dense solve, energy, reciprocity.

mod support;

use faer::Mat;
use faer::linalg::solvers::Solve;
use glam::{DVec3, Vec3};
use qrad::light_patches_with;
use qrad::patch::{PatchEffects, Quad, Shader, TextPatches};
use qrad::progress::Progress;
use qrad::radiosity::hemicube::{DeltaFormFactors, HemicubeSize, SIDES, SideId, View};
use qrad::radiosity::near_pairs::NearLimits;
use qrad::radiosity::per_ray;
use qrad::radiosity::solve::Solution;
use qrad::radiosity::transfers::Transfers;
use qrad::settings::Quality;
use support::quads::{BLACK, Light, cuboid, grid, scene};

const O: DVec3 = DVec3::ZERO;
const X: DVec3 = DVec3::X;
const Y: DVec3 = DVec3::Y;
const Z: DVec3 = DVec3::Z;
/// The most that closed forms are missed by.
const CLOSE: f64 = 2e-3;

fn lit(quads: &[Quad], cells: u32) -> (Transfers, Solution) {
    lit_at(Quality::Normal, quads, cells)
}

fn lit_at(quality: Quality, quads: &[Quad], cells: u32) -> (Transfers, Solution) {
    let scene = scene(quads.to_vec(), cells, 100_000);
    light_patches_with(&scene, Some(quality.near()), &Progress::new(false)).unwrap()
}

fn with(mut quads: Vec<Quad>, effects: PatchEffects) -> Vec<Quad> {
    quads.iter_mut().for_each(|q| q.effects = effects);
    quads
}

fn diffuse(tau: f64) -> PatchEffects {
    PatchEffects { diffuse: Some([tau; 3]), ..PatchEffects::default() }
}

fn straight(share: [f64; 3]) -> PatchEffects {
    PatchEffects { straight: Some(share), ..PatchEffects::default() }
}

fn level(solution: &Solution, i: usize) -> f64 {
    solution.exitance[i].0.x.into()
}

fn off(got: f64, want: f64) -> f64 {
    (got / want - 1.0).abs()
}

/// Largest relative error of the patches `range`.
fn worst(solution: &Solution, range: impl Iterator<Item = usize>, want: f64) -> f64 {
    range.map(|i| off(level(solution, i), want)).fold(0.0, f64::max)
}

/// A box of 2 x 1 x 1 of 6 n n patches, and a sheet of n n patches that divides it at `x`.
fn divided(n: usize, x: f64, walls: Light, sheet: Light, effects: PatchEffects) -> Vec<Quad> {
    let mut quads = cuboid(O, DVec3::new(2.0, 1.0, 1.0), n, true, walls);
    quads.extend(with(grid(X * x, Y, Z, [n, n], sheet), effects));
    quads
}

#[test]
fn a_furnace_divided_by_a_sheet_that_absorbs_nothing_keeps_its_level() {
    let walls = Light { exitance: 0.01, reflectance: 0.7 };
    let want = 0.01 / (1.0 - 0.7);
    for x in [1.0, 0.3] {
        for (tau, rho) in [(0.4, 0.6), (1.0, 0.0), (0.05, 0.95)] {
            let sheet = Light { exitance: 0.0, reflectance: rho };
            let quads = divided(3, x, walls, sheet, diffuse(tau));
            let (_, solution) = lit(&quads, 64);
            assert_eq!(solution.exitance.len(), 54 + 9 + 9, "backs follow");
            let error = worst(&solution, 0..72, want);
            println!("tau {tau}, rho {rho}, at {x}: off by {error:.1e}");
            assert!(solution.settled && error < CLOSE, "{error}");
        }
    }
}

#[test]
fn a_sheet_like_the_walls_of_a_furnace_changes_nothing() {
    let walls = Light { exitance: 0.01, reflectance: 0.7 };
    let sheet = Light { exitance: 0.01, reflectance: 0.3 };
    let (_, solution) = lit(&divided(3, 0.8, walls, sheet, diffuse(0.4)), 64);
    assert!(worst(&solution, 0..72, 0.01 / 0.3) < CLOSE);
}

/// Black walls of one half emit: the sheet sees nothing else on that side.
#[test]
fn each_side_of_a_sheet_has_an_exitance_of_its_own() {
    let mut quads = divided(2, 1.0, BLACK, Light { exitance: 0.0, reflectance: 0.3 }, diffuse(0.6));
    // The sheet faces +x.
    for quad in &mut quads {
        let middle = quad.vertices.iter().sum::<DVec3>() / 4.0;
        if quad.effects == PatchEffects::default() && middle.x > 1.9 {
            quad.exitance = [0.5; 3];
        }
    }
    let (transfers, solution) = lit(&quads, 64);
    for k in 0..4 {
        let exitance: Vec<DVec3> = solution.exitance.iter().map(|m| m.0.as_dvec3()).collect();
        let arriving = transfers.gather(&exitance)[24 + k].x;
        assert!(off(level(&solution, 24 + k), 0.3 * arriving) < 1e-6);
        assert!(off(level(&solution, 28 + k), 0.6 * arriving) < 1e-6, "the back");
        assert!(arriving > 0.0);
    }
    // All walls of the lit half emit, not just its end.
    for quad in &mut quads[..24] {
        let middle = quad.vertices.iter().sum::<DVec3>() / 4.0;
        quad.exitance = if middle.x > 1.0 { [0.5; 3] } else { [0.0; 3] };
    }
    let long: Vec<Quad> = quads;
    let (_, solution) = lit(&long, 64);
    let errors = (worst(&solution, 24..28, 0.15), worst(&solution, 28..32, 0.3));
    println!("front off by {:.1e}, back by {:.1e}", errors.0, errors.1);
    assert!(errors.0 < CLOSE && errors.1 < CLOSE);
}

/// Two unit squares at distance 1 with sheets between; the lower emits 0.8 and the upper reflects all.
fn through_sheets(sheets: &[Vec<Quad>]) -> Vec<Quad> {
    let mut quads = grid(O, X, Y, [1, 1], Light { exitance: 0.8, ..BLACK });
    quads.extend(grid(Z, Y, X, [1, 1], Light { exitance: 0.0, reflectance: 1.0 }));
    quads.extend(sheets.iter().flatten().copied());
    quads
}

/// A square of 1.2 x 1.2 over and under the unit square.
fn pane(z: f64) -> Vec<Quad> {
    grid(DVec3::new(-0.1, -0.1, z), X * 1.2, Y * 1.2, [1, 1], BLACK)
}

/// Form factor of opposite unit squares at distance 1 (Howell C-11).
const OPPOSITE: f64 = 0.199_824_9;

#[test]
fn translucent_sheets_multiply_each_channel() {
    let tint: [f64; 3] = [0.9, 0.5, 0.2];
    for n in 0..6 {
        let sheets: Vec<_> =
            (0..n).map(|k| with(pane(0.1 + 0.15 * f64::from(k)), straight(tint))).collect();
        let (_, solution) = lit(&through_sheets(&sheets), 64);
        for (got, t) in solution.exitance[1].0.to_array().into_iter().zip(tint) {
            let want = 0.8 * OPPOSITE * t.powi(n);
            assert!(off(got.into(), want) < CLOSE, "{n} layers of {t}: {got}, not {want}");
        }
    }
}

/// By symmetry, half of the light passes on either side of the middle, at any height.
#[test]
fn half_covered_ways_let_half_of_the_light_through_untouched() {
    for z in [0.02, 0.5, 0.9] {
        let half = grid(DVec3::new(-3.0, -1.0, z), X * 3.5, Y * 3.0, [1, 1], BLACK);
        let quads = through_sheets(&[with(half, straight([0.2; 3]))]);
        let (_, solution) = lit_at(Quality::Final, &quads, 64);
        let (got, want) = (level(&solution, 1), 0.8 * OPPOSITE * 0.6);
        println!("at {z}: off by {:.1e}", off(got, want));
        assert!(off(got, want) < CLOSE, "{z}: {got}, not {want}");
    }
}

#[test]
fn a_translucent_sheet_shines_itself_and_dims_what_is_behind() {
    // Nearer to farther, both shine; each dims those behind it.
    let shining = |z: f64, exitance: f64, share: f64| {
        let light = Light { exitance, reflectance: 0.0 };
        with(grid(Z * z, X, Y, [1, 1], light), straight([share; 3]))
    };
    let (near, far) = (shining(0.9, 0.3, 0.5), shining(0.5, 0.2, 0.7));
    let quads = through_sheets(&[near, far]);
    let (transfers, solution) = lit(&quads, 64);
    // Opposite unit squares at 0.1 and 0.5 (C-11).
    let want = 0.3 * 0.826_994_5 + 0.5 * (0.2 * 0.415_253 + 0.7 * 0.8 * OPPOSITE);
    let got = level(&solution, 1);
    println!("{got} for {want}, off by {:.1e}", off(got, want));
    assert!(off(got, want) < CLOSE);
    // Opaque patches see each other as if the sheets were not there; the overlay has the rest.
    assert_eq!(transfers.row(1).0, [0]);
}

#[test]
fn furnaces_with_translucent_sheets_keep_their_level() {
    let walls = Light { exitance: 0.01, reflectance: 0.7 };
    let want = 0.01 / (1.0 - 0.7);
    for (share, rho, tau) in [(0.5, 0.5, 0.0), (0.3, 0.3, 0.4), (1.0, 0.0, 0.0)] {
        let effects = PatchEffects { diffuse: Some([tau; 3]), ..straight([share; 3]) };
        let sheet = Light { exitance: 0.0, reflectance: rho };
        let (_, solution) = lit(&divided(3, 0.6, walls, sheet, effects), 64);
        let error = worst(&solution, 0..54, want);
        println!("straight {share}, rho {rho}, tau {tau}: off by {error:.1e}");
        assert!(error < CLOSE);
        let sheets = worst(&solution, 54..72, want * (rho + tau));
        assert!(share == 1.0 || sheets < CLOSE, "{sheets}");
    }
}

/// A room with a box, a diffusing sheet, a translucent one, one that is both, a patterned floor.
fn mixed() -> Vec<Quad> {
    let mut quads = cuboid(O, DVec3::new(3.0, 4.0, 2.5), 3, true, BLACK);
    quads.extend(cuboid(DVec3::new(0.7, 1.1, 0.0), DVec3::new(1.5, 1.9, 0.9), 1, false, BLACK));
    let sheet = |origin, u, v, effects| with(grid(origin, u, v, [2, 2], BLACK), effects);
    quads.extend(sheet(DVec3::new(0.3, 2.5, 0.4), X * 1.2, Z * 1.5, diffuse(0.4)));
    quads.extend(sheet(DVec3::new(1.8, 0.5, 1.5), X, Y * 2.0, straight([0.7, 0.4, 0.1])));
    let both = PatchEffects { diffuse: Some([0.2, 0.1, 0.3]), ..straight([0.3, 0.2, 0.4]) };
    quads.extend(sheet(DVec3::new(2.2, 3.0, 0.3), X * 0.5 + Y * 0.3, Z, both));
    for (k, quad) in quads.iter_mut().enumerate() {
        let rho = |c: usize| 0.2 + 0.1 * ((k * 3 + c) % 4) as f64;
        quad.reflectance = if quad.effects == PatchEffects::default() {
            [rho(0), rho(1), rho(2)]
        } else {
            [0.25; 3]
        };
        quad.exitance = if k % 7 == 0 { [0.9, 0.5, 0.3] } else { [0.0; 3] };
    }
    quads[40].effects.shader = Some(Shader::Checker([2, 3], [0.2, 0.5, 1.0]));
    quads[41].effects.shader = Some(Shader::Gradient([0.0, 0.5, 1.0]));
    quads
}

/// Form factors of a channel with all that an overlay adds.
fn dense(transfers: &Transfers, channel: usize) -> Mat<f64> {
    let n = transfers.rows();
    let mut f = Mat::zeros(n, n);
    for i in 0..n {
        let (columns, weights) = transfers.row(i);
        for (&j, &w) in columns.iter().zip(&weights) {
            f[(i, j as usize)] += f64::from(w);
        }
        for &(j, w) in transfers.overlay_row(i) {
            f[(i, j as usize)] += f64::from(w[channel]);
        }
    }
    f
}

#[test]
fn the_solver_agrees_with_a_dense_solve() {
    let quads = mixed();
    let patches = TextPatches::new(&scene(quads.clone(), 32, 1000));
    let (transfers, solution) = lit(&quads, 32);
    let n = transfers.rows();
    for channel in 0..3 {
        let f = dense(&transfers, channel);
        // M - rho F M - (tau F M of the other side) = E.
        let mut matrix: Mat<f64> = Mat::identity(n, n);
        for i in 0..n {
            let rho = f64::from(patches.set.patches[i].reflectance.0[channel]);
            for j in 0..n {
                matrix[(i, j)] -= rho * f[(i, j)];
            }
        }
        for p in &patches.set.passages {
            let (from, to) = (p.from.0 as usize, p.to.0 as usize);
            for j in 0..n {
                matrix[(to, j)] -= f64::from(p.transmittance[channel]) * f[(from, j)];
            }
        }
        let emission = Mat::from_fn(n, 1, |i, _| f64::from(patches.emission[i].0[channel]));
        let want = matrix.partial_piv_lu().solve(&emission);
        let largest = (0..n).map(|i| want[(i, 0)]).fold(0.0, f64::max);
        for i in 0..n {
            let got = f64::from(solution.exitance[i].0[channel]);
            assert!((got - want[(i, 0)]).abs() < 1e-6 * largest, "patch {i}, channel {channel}");
        }
    }
}

/// Share of the emitted light that is absorbed nowhere, the largest of the channels.
fn lost_energy(quads: &[Quad], quality: Quality) -> f64 {
    let patches = TextPatches::new(&scene(quads.to_vec(), 64, 1000));
    let (transfers, solution) = lit_at(quality, quads, 64);
    let exitance: Vec<DVec3> = solution.exitance.iter().map(|m| m.0.as_dvec3()).collect();
    let arriving = transfers.gather(&exitance);
    let albedo = patches.set.albedo();
    let backs = quads.iter().filter(|q| q.effects.has_two_sides());
    let (mut emitted, mut absorbed) = (DVec3::ZERO, DVec3::ZERO);
    for (i, quad) in quads.iter().chain(backs).enumerate() {
        let area = f64::from(patches.set.patches[i].area);
        let passing = DVec3::from(quad.effects.straight.unwrap_or_default());
        emitted += patches.emission[i].0.as_dvec3() * area;
        absorbed += (DVec3::ONE - albedo[i].as_dvec3() - passing) * arriving[i] * area;
    }
    (absorbed / emitted - DVec3::ONE).abs().max_element()
}

#[test]
fn all_light_is_absorbed_somewhere() {
    let quads = mixed();
    let mut opaque = mixed();
    for quad in &mut opaque {
        let two_sided = quad.effects.has_two_sides();
        quad.effects = PatchEffects { two_sided, ..PatchEffects::default() };
    }
    // Boxes that stand on patches cost half a percent with or without transmission.
    for quality in [Quality::Normal, Quality::Final] {
        let (error, without) = (lost_energy(&quads, quality), lost_energy(&opaque, quality));
        println!("{quality:?}: energy off by {error:.1e}, by {without:.1e} with all opaque");
        assert!(error < without + CLOSE && error < 1e-2, "{quality:?}: {error}");
    }
}

#[test]
fn light_is_exchanged_alike_both_ways() {
    // Patterns change what a patch sends, not what it receives: they are left out.
    let mut quads = mixed();
    quads.iter_mut().for_each(|q| q.effects.shader = None);
    let patches = TextPatches::new(&scene(quads.clone(), 64, 0));
    let (transfers, _) = lit(&quads, 64);
    for channel in 0..3 {
        let f = dense(&transfers, channel);
        let area = |i: usize| f64::from(patches.set.patches[i].area);
        let (mut error, mut all) = (0.0, 0.0);
        for i in 0..f.nrows() {
            for j in 0..i {
                let (there, back) = (area(i) * f[(i, j)], area(j) * f[(j, i)]);
                error += (there - back).powi(2);
                all += there.max(back).powi(2);
            }
        }
        let rms = f64::sqrt(error / all);
        println!("channel {channel}: {rms:.4} apart");
        assert!(rms < 0.02, "{rms}");
    }
}

/// Without near pairs, the overlay's rows are those of one ray a cell.
#[test]
fn the_hemicube_has_the_layers_that_rays_meet() {
    let quads = mixed();
    let text = scene(quads, 32, 0);
    let patches = TextPatches::new(&text);
    let none: Option<NearLimits> = None;
    let (transfers, _) = light_patches_with(&text, none, &Progress::new(false)).unwrap();
    let size = HemicubeSize::new(32, 32).unwrap();
    let delta = DeltaFormFactors::new(size);
    let overlay = patches.set.overlay.as_deref().unwrap();
    for (i, patch) in patches.set.patches.iter().enumerate() {
        let view = View::turned(patch.eye, patch.normal, i as u64);
        let mut want = DVec3::ZERO;
        let seen = per_ray::trace(&patches.tracer, &view, size);
        let mut cell = 0;
        for side in SIDES {
            let rows = if side == SideId::Top { 32 } else { 16 };
            for y in 0..rows {
                for x in 0..32 {
                    let way = per_ray::direction(&view, size, side, x, y);
                    let hit =
                        seen[cell].map(|polygon| &patches.tracer.polygons()[polygon as usize]);
                    cell += 1;
                    let Some(polygon) = hit.filter(|p| p.normal.dot(way) < 0.0) else { continue };
                    let t = polygon.normal.dot(polygon.vertices[0] - view.position)
                        / polygon.normal.dot(way);
                    let end = view.position + way * t * (1.0 - 1e-6);
                    let share = overlay.through(view.position.as_dvec3(), end.as_dvec3());
                    let f = f64::from(delta.of(side)[(y * 32 + x) as usize]);
                    want += (share - DVec3::ONE) * f;
                }
            }
        }
        // What is behind counts as negative; patterns and the layers' own patches are left out.
        let plain: Vec<u32> = overlay.layer_patches().map(|p| p.0.0).chain([40, 41]).collect();
        let row = transfers.overlay_row(i).iter().filter(|(j, _)| !plain.contains(j));
        let got = row.fold(DVec3::ZERO, |sum, (_, f)| sum + f.as_dvec3());
        let near_patterns = patches.set.patches[40].eye; // their cells are not in the sum
        let slack = if near_patterns.distance(patch.eye) > 0.0 { 0.15 } else { 1.0 };
        assert!((got - want).abs().max_element() < slack, "patch {i}: {got} for {want}");
    }
}

#[test]
fn sheets_next_to_walls_do_not_cover_them() {
    // The wall sees nothing but the back of the sheet, from which light comes.
    let mut quads = grid(O, X, Y, [1, 1], Light { exitance: 0.0, reflectance: 0.5 });
    quads.extend(with(
        grid(DVec3::new(-9.0, -9.0, 0.01), X * 19.0, Y * 19.0, [1, 1], BLACK),
        diffuse(0.8),
    ));
    quads.extend(cuboid(
        DVec3::new(-9.0, -9.0, 0.01),
        DVec3::new(10.0, 10.0, 5.0),
        2,
        true,
        Light { exitance: 0.5, reflectance: 0.0 },
    ));
    // The floor of that box is the sheet's place.
    quads.retain(|q| {
        q.effects != PatchEffects::default() || q.normal.z < 0.5 || q.vertices[0].z < 0.005
    });
    let (_, solution) = lit(&quads, 64);
    let want = 0.5 * 0.8 * 0.5;
    let got = level(&solution, 0);
    assert!(off(got, want) < 0.01, "{got} for {want}");
}

#[test]
fn scenes_without_effects_have_no_overlay() {
    let quads = cuboid(O, DVec3::ONE, 2, true, Light { exitance: 0.1, reflectance: 0.5 });
    let patches = TextPatches::new(&scene(quads.clone(), 16, 0));
    assert!(patches.set.overlay.is_none() && patches.set.passages.is_empty());
    assert!(patches.sheets.is_empty());
    let (transfers, _) = lit(&quads, 16);
    assert!((0..transfers.rows()).all(|i| transfers.overlay_row(i).is_empty()));
}

#[test]
fn patterns_keep_the_light_of_a_patch_and_move_it() {
    // A checker of two cells: one half shines, the other not; the mean is half.
    let shader = Some(Shader::Checker([2, 1], [0.0; 3]));
    let mut emitter = grid(O, X, Y, [1, 1], Light { exitance: 0.8, ..BLACK });
    emitter[0].effects.shader = shader;
    let upper = Light { exitance: 0.0, reflectance: 0.9 };
    for (origin, u, v) in [(Z, Y, X * 0.5), (Z + X * 0.5, Y, X * 0.5)] {
        let mut quads = emitter.clone();
        quads.extend(grid(origin, u, v, [1, 1], upper));
        let (_, solution) = lit(&quads, 128);
        assert!(off(level(&solution, 0), 0.4) < 1e-6, "the mean");
        // The same with the shining half as a patch of its own.
        let mut halves = grid(O, X * 0.5, Y, [1, 1], Light { exitance: 0.8, ..BLACK });
        halves.extend(grid(origin, u, v, [1, 1], upper));
        let (_, want) = lit(&halves, 128);
        let (got, want) = (level(&solution, 1), level(&want, 1));
        println!("{got} for {want}, off by {:.1e}", off(got, want));
        assert!(off(got, want) < 5e-3, "{got} {want}");
    }
}

#[test]
fn channels_of_tinted_light_do_not_mix() {
    let quads = through_sheets(&[with(pane(0.5), straight([1.0, 0.0, 0.5]))]);
    let (_, solution) = light_patches_with(
        &scene(quads, 64, 100),
        Some(Quality::Draft.near()),
        &Progress::new(false),
    )
    .unwrap();
    let Vec3 { x, y, z } = solution.exitance[1].0;
    assert!(y == 0.0 && off(z.into(), 0.5 * f64::from(x)) < 1e-6);
}
