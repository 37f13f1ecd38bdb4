//! The stability contract: hard geometry in text scenes. `docs/stability.md` lists the cases.

mod support;

use glam::DVec3;
use qrad::patch::{Quad, Reading, TextScene};
use support::invariants::{Expect, Solved, hold};
use support::quads::{Light, cuboid, grid, scene};

const GREY: Light = Light { exitance: 0.0, reflectance: 0.6 };
const LAMP: Light = Light { exitance: 0.8, reflectance: 0.3 };

/// A room of 4 x 3 x 2 units, each side n x n patches, with a lamp in the middle of the ceiling's
/// patches.
fn room(n: usize) -> Vec<Quad> {
    let mut quads = cuboid(DVec3::ZERO, DVec3::new(4.0, 3.0, 2.0), n, true, GREY);
    let ceiling = 5 * n * n;
    quads[ceiling + n * n / 2].exitance = [0.9, 0.8, 0.7];
    quads
}

/// A rectangle whose back is closed by another: a thin plate that light does not enter.
fn plate(origin: DVec3, u: DVec3, v: DVec3, n: usize, light: Light) -> Vec<Quad> {
    let mut quads = grid(origin, u, v, [n, n], light);
    quads.extend(grid(origin, v, u, [n, n], light));
    quads
}

#[test]
fn touching_boxes_keep_every_invariant() {
    let mut quads = room(4);
    // On the floor, against a wall and against each other, without a gap.
    quads.extend(cuboid(DVec3::new(0.0, 1.0, 0.0), DVec3::new(1.0, 2.0, 1.0), 2, false, GREY));
    quads.extend(cuboid(DVec3::new(1.0, 1.0, 0.0), DVec3::new(2.0, 2.0, 0.5), 2, false, LAMP));
    // Sides pressed together look into the other box: their rows are open.
    hold("touching boxes", &quads, Expect { closed: false, ..Expect::default() });
}

#[test]
fn crossing_plates_keep_every_invariant_and_rows_sum_to_one() {
    let mut quads = room(4);
    quads.extend(plate(DVec3::new(1.0, 1.5, 0.4), DVec3::X * 2.0, DVec3::Z, 2, GREY));
    quads.extend(plate(DVec3::new(2.0, 0.5, 0.4), DVec3::Y * 2.0, DVec3::Z, 2, LAMP));
    quads.extend(plate(
        DVec3::new(1.2, 0.7, 0.5),
        DVec3::new(1.5, 1.5, 0.0),
        DVec3::new(0.0, 0.0, 0.9),
        2,
        GREY,
    ));
    hold("crossing plates", &quads, Expect::default());
}

#[test]
fn coincident_patches_keep_every_invariant_and_rows_sum_to_one() {
    let at = DVec3::new(1.0, 1.0, 0.7);
    let mut quads = room(4);
    // Twice the same side, twice the other side: each pair is one surface listed twice.
    quads.extend(plate(at, DVec3::X, DVec3::Y, 2, GREY));
    quads.extend(plate(at, DVec3::X, DVec3::Y, 2, GREY));
    // Each copy takes all light that falls on the place, but only one is seen to send it back: what the
    // place absorbs counts twice, and pairs with it are not reciprocal.
    hold("coincident plates", &quads, Expect { noise: 0.05, asymmetry: 0.05, ..Expect::default() });
}

#[test]
fn a_front_listed_twice_gives_no_more_light_than_once() {
    let at = DVec3::new(1.0, 1.0, 0.7);
    let mut once = room(4);
    once.extend(plate(at, DVec3::X, DVec3::Y, 1, LAMP));
    let mut twice = once.clone();
    twice.extend(plate(at, DVec3::X, DVec3::Y, 1, LAMP));
    let mean = |quads: &[Quad]| {
        let solved = Solved::new(quads, 128, 1000);
        solved.exitance()[..96].iter().map(|m| m.element_sum()).sum::<f64>()
    };
    let (once, twice) = (mean(&once), mean(&twice));
    assert!((twice / once - 1.0).abs() < 0.02, "{once} becomes {twice}");
}

fn slivers(count: usize, width: f64) -> Vec<Quad> {
    let mut quads = room(3);
    // The middle of the floor is `count` slivers side by side, on a plate just over it.
    let (low, length) = (DVec3::new(1.5, 1.0, 0.25), 1.0);
    let across = DVec3::X * (width * count as f64);
    quads.extend(grid(low, across, DVec3::Y * length, [count, 1], LAMP));
    quads.extend(grid(low, DVec3::Y * length, across, [1, count], GREY));
    quads
}

#[test]
fn slivers_1_to_1000_keep_every_invariant_and_rows_sum_to_one() {
    hold("slivers 1:1000", &slivers(20, 1e-3), Expect::default());
}

#[test]
fn slivers_1_to_100000_keep_every_invariant_and_rows_sum_to_one() {
    hold("slivers 1:100000", &slivers(20, 1e-5), Expect::default());
}

#[test]
fn zero_area_patches_are_refused_with_their_line() {
    let mut quads = room(1);
    let p = quads[2].vertices[0];
    for vertices in [[p; 4], [p, p + DVec3::X, p + DVec3::X * 2.0, p + DVec3::X * 3.0]] {
        quads[2].vertices = vertices;
        let text = scene(quads.clone(), 16, 1).to_text();
        let error = TextScene::parse_repaired(&text, "s", Reading::Raw).unwrap_err().to_string();
        assert!(error.contains("line 7") && error.contains("no area"), "{error}");
    }
}

#[test]
fn colinear_and_doubled_vertices_keep_every_invariant_and_rows_sum_to_one() {
    let mut quads = room(2);
    // One patch of the floor as two triangles: with a vertex on an edge, and with one doubled.
    let at = quads.iter().position(|q| q.unit_normal().z > 0.5).unwrap();
    let cut = quads.remove(at);
    let [a, b, c, d] = cut.vertices;
    quads.push(Quad { vertices: [a, (a + b) * 0.5, b, c], ..cut });
    quads.push(Quad { vertices: [a, c, d, d], ..cut });
    let text = scene(quads.clone(), 16, 1).to_text();
    let (_, repairs) = TextScene::parse_repaired(&text, "s", Reading::Raw).unwrap();
    assert!(repairs.is_empty(), "{repairs:?}");
    hold("colinear vertices", &quads, Expect::default());
}

/// Length of the strips of a wedge.
const LONG: f64 = 400.0;

/// Two strips of width 1 hinged along an edge, [`LONG`] long, cut into patches across that shrink towards the
/// hinge. Their form factor is 1 - sin(angle / 2) (Hottel's crossed strings) but for the ends.
fn wedge(degrees: f64) -> Vec<Quad> {
    const CUTS: usize = 12;
    let angle = degrees.to_radians();
    let along = DVec3::Y * LONG;
    let sides = [(DVec3::X, true), (DVec3::new(angle.cos(), 0.0, angle.sin()), false)];
    let cut = |k: usize| (k as f64 / CUTS as f64).powi(2);
    let mut quads = Vec::new();
    for (out, first) in sides {
        for k in 0..CUTS {
            let (near, width) = (out * cut(k), out * (cut(k + 1) - cut(k)));
            let light = if first { LAMP } else { GREY };
            let (u, v) = if first { (width, along) } else { (along, width) };
            quads.extend(grid(near - along * 0.5, u, v, [1, 1], light));
        }
    }
    quads
}

#[test]
fn dihedral_angles_from_a_tenth_to_179_point_9_degrees_have_hottels_form_factor() {
    for degrees in [0.1, 1.0, 5.0, 30.0, 90.0, 150.0, 179.0, 179.9] {
        let quads = wedge(degrees);
        let expect = Expect { closed: false, hemicube: 256, ..Expect::default() };
        let solved = hold(&format!("wedge of {degrees} degrees"), &quads, expect);
        let half = quads.len() / 2;
        let between: f64 = (0..half)
            .map(|i| {
                let area: f64 = solved.patches.set.patches[i].area.into();
                area * solved.row_sum(i) / LONG
            })
            .sum();
        let want = 1.0 - (0.5 * degrees.to_radians()).sin();
        // Light that leaves at the ends: less than a fifth of the width at both.
        let ends = 0.2 / LONG;
        // An eye stands over its patch by a millionth of the scene: what is nearer, it cannot see.
        let unseen = LONG * 1e-6 / degrees.to_radians().sin();
        println!("wedge of {degrees} degrees: form factor {between:.5}, exact {want:.5}");
        assert!(
            between <= want + 5e-4 && between >= want - ends - 1.5e-3 - unseen,
            "{degrees} degrees: {between} instead of {want}"
        );
    }
}

#[test]
fn back_faces_block_light_and_give_none() {
    let mut quads = room(3);
    let before = Solved::new(&quads, 128, 0);
    // A bright plate that shows its back to the floor: what the floor sees there is dark.
    let light = Light { exitance: 1.0, reflectance: 0.5 };
    quads.extend(grid(DVec3::new(1.0, 1.0, 1.0), DVec3::X, DVec3::Y, [1, 1], light));
    let solved = hold("back faces", &quads, Expect { closed: false, ..Expect::default() });
    let plate = quads.len() - 1;
    let mut hidden = 0;
    for i in (0..plate).filter(|&i| quads[i].vertices.iter().all(|v| v.z < 1.0)) {
        assert!(!solved.transfers.row(i).0.contains(&(plate as u32)), "patch {i} sees the back");
        hidden += usize::from(solved.row_sum(i) < before.row_sum(i) - 0.01);
    }
    assert!(hidden > 8, "only {hidden} patches have the back in view");
}

#[test]
fn a_slit_lets_its_share_of_light_through() {
    // Two rooms side by side, a wall with a slit of 1/32 of its width between them.
    let lamp = Light { exitance: 1.0, reflectance: 0.0 };
    // Patches that reflect nothing would keep the form factors of one hemicube.
    let dim = Light { exitance: 0.0, reflectance: 0.5 };
    let mut quads = cuboid(DVec3::ZERO, DVec3::splat(1.0), 3, true, lamp);
    quads.retain(|q| q.unit_normal().x > -0.5);
    let mut far = cuboid(DVec3::X, DVec3::new(2.0, 1.0, 1.0), 3, true, dim);
    far.retain(|q| q.unit_normal().x < 0.5);
    let first = quads.len();
    quads.extend(far);
    for (low, high) in [(0.0, 0.5 - 1.0 / 64.0), (0.5 + 1.0 / 64.0, 1.0)] {
        let origin = DVec3::new(1.0, low, 0.0);
        let (u, v) = (DVec3::Y * (high - low), DVec3::Z);
        quads.extend(grid(origin, v, u, [4, 2], lamp));
        quads.extend(grid(origin, u, v, [2, 4], dim));
    }
    let expect = Expect { hemicube: 256, ..Expect::default() };
    let solved = hold("slit", &quads, expect);
    // All that goes through the slit is absorbed behind it: its area times the exitance of 1.
    let through: f64 = (first..quads.len())
        .filter(|&i| quads[i].exitance[0] == 0.0)
        .map(|i| {
            let (columns, factors) = solved.transfers.row(i);
            let lit = columns.iter().zip(&factors);
            let lit = lit.filter(|c| quads[*c.0 as usize].exitance[0] > 0.0);
            let area: f64 = solved.patches.set.patches[i].area.into();
            area * lit.map(|(_, &f)| f64::from(f)).sum::<f64>()
        })
        .sum();
    println!("through the slit: {through:.5}, exact {:.5}", 1.0 / 32.0);
    assert!((through * 32.0 - 1.0).abs() < 0.02, "{through}");
}
