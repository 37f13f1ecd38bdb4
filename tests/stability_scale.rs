//! The stability contract: text scenes that are tiny, huge or far from the origin. `docs/stability.md`
//! lists the cases.

mod support;

use glam::DVec3;
use qrad::patch::Quad;
use support::invariants::{Expect, Solved, hold};
use support::quads::{Light, cuboid};

/// A closed room with a box in it and a lamp, mapped by `place`.
fn room(place: impl Fn(DVec3) -> DVec3) -> Vec<Quad> {
    let grey = Light { exitance: 0.0, reflectance: 0.6 };
    let mut quads = cuboid(DVec3::ZERO, DVec3::new(3.0, 2.0, 2.5), 4, true, grey);
    quads.extend(cuboid(DVec3::splat(0.6), DVec3::splat(1.4), 2, false, grey));
    quads[85].exitance = [0.9, 0.6, 0.3];
    for quad in &mut quads {
        quad.vertices = quad.vertices.map(&place);
    }
    quads
}

/// The largest change of a patch's light against the plain room, as share of the room's mean.
fn change(case: &str, quads: &[Quad]) -> f64 {
    let solved = hold(case, quads, Expect::default()).exitance();
    let plain = Solved::new(&room(|p| p), 128, 1_000_000).exitance();
    let mean = plain.iter().map(|m| m.element_sum()).sum::<f64>() / plain.len() as f64;
    let worst = solved.iter().zip(&plain).map(|(a, b)| (*a - *b).abs().max_element());
    let worst = worst.fold(0.0, f64::max) / mean;
    println!("{case}: the light of a patch changes by {worst:.1e} of the mean");
    worst
}

#[test]
fn scenes_scaled_by_a_thousandth_and_by_a_thousand_have_the_same_light() {
    for scale in [1e-3, 1e3] {
        let worst = change(&format!("scaled by {scale}"), &room(|p| p * scale));
        assert!(worst < 5e-3, "{worst}");
    }
}

#[test]
fn scenes_scaled_by_powers_of_two_have_the_same_bytes() {
    for scale in [1.0 / 1024.0, 4096.0] {
        let worst = change(&format!("scaled by {scale}"), &room(|p| p * scale));
        assert!(worst == 0.0, "{worst}");
    }
}

#[test]
fn scenes_shifted_by_1e5_have_the_same_light() {
    for shift in [DVec3::splat(1e5), DVec3::new(-1e5, 0.0, 1e5)] {
        let worst = change(&format!("shifted by {shift}"), &room(|p| p + shift));
        assert!(worst < 5e-3, "{worst}");
    }
}

#[test]
fn scenes_at_the_format_s_limits_keep_every_invariant() {
    // Coordinates go to 1e12; a room 1e12 wide, and one of 1e6 units far out.
    hold("1e12 wide", &room(|p| p * 3e11), Expect::default());
    hold("far out", &room(|p| p * 1e6 + DVec3::splat(9e11)), Expect::default());
    hold("1e-9 wide", &room(|p| p * 1e-9), Expect::default());
}

#[test]
fn very_different_sizes_in_one_scene_keep_every_invariant() {
    // A box of a hundredth of a unit just over the floor of a room of 3 units.
    let mut quads = room(|p| p);
    let grey = Light { exitance: 0.0, reflectance: 0.6 };
    let low = DVec3::new(2.0, 1.0, 0.005);
    quads.extend(cuboid(low, low + DVec3::splat(0.01), 1, false, grey));
    hold("a tiny box", &quads, Expect::default());
}
