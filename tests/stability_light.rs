//! The stability contract: hard reflectances and lights in text scenes. `docs/stability.md` lists the
//! cases.

mod support;

use glam::DVec3;
use qrad::patch::{MAX_REFLECTANCE, Quad, Reading, TextScene};
use support::invariants::{Expect, Solved, hold};
use support::quads::{Light, cuboid, scene};

/// The patch that emits, one of the inner four of the ceiling.
const LAMP: usize = 85;

/// A closed room with a box in it: `reflectance` everywhere, a patch of the ceiling emits `emission`.
fn room(reflectance: [f64; 3], emission: f64) -> Vec<Quad> {
    let dark = Light { exitance: 0.0, reflectance: 0.0 };
    let mut quads = cuboid(DVec3::ZERO, DVec3::new(3.0, 2.0, 2.5), 4, true, dark);
    quads.extend(cuboid(DVec3::splat(0.6), DVec3::splat(1.4), 2, false, dark));
    for quad in &mut quads {
        quad.reflectance = reflectance;
    }
    quads[LAMP].exitance = [emission; 3];
    quads
}

/// The scene after a round through its text, with what reading it repaired.
fn read_back(quads: &[Quad]) -> (TextScene, Vec<String>) {
    let text = scene(quads.to_vec(), 128, 1_000_000).to_text();
    let (scene, repairs) = TextScene::parse_repaired(&text, "s", Reading::Raw).unwrap();
    (scene, repairs.into_iter().map(|r| r.what).collect())
}

#[test]
fn reflectance_0_settles_in_one_pass_and_keeps_every_invariant() {
    // What black patches receive lights nothing: their rows stay as one hemicube each saw them.
    let expect = Expect { noise: 0.04, asymmetry: 0.06, ..Expect::default() };
    let solved = hold("reflectance 0", &room([0.0; 3], 1.0), expect);
    assert_eq!(solved.solution.passes, 1);
    assert!(solved.exitance()[LAMP + 1..].iter().all(|m| *m == DVec3::ZERO));
}

#[test]
fn reflectance_0_999_settles_and_keeps_every_invariant() {
    let solved = hold("reflectance 0.999", &room([0.999; 3], 1.0), Expect::default());
    assert!(solved.solution.settled && solved.solution.passes > 5000);
}

#[test]
fn reflectance_1_everywhere_is_lowered_with_a_line_and_keeps_every_invariant() {
    let (scene, repairs) = read_back(&room([1.0; 3], 0.001));
    assert!(repairs.len() == 1 && repairs[0].contains("never settle"), "{repairs:?}");
    assert!(scene.patches.iter().all(|q| q.reflectance == [MAX_REFLECTANCE; 3]));
    let solved = Solved::new(&scene.patches, 64, 1_000_000);
    assert!(solved.solution.settled);
    solved.check("reflectance 1", Expect::default());
}

#[test]
fn a_closed_room_of_reflectance_1_beside_a_dark_box_settles() {
    // The dark box is outside: inside the room nothing absorbs, whatever the file says elsewhere.
    let mut quads = room([1.0; 3], 0.001);
    let dark = Light { exitance: 0.0, reflectance: 0.0 };
    quads.extend(cuboid(DVec3::splat(9.0), DVec3::splat(10.0), 1, false, dark));
    let (scene, repairs) = read_back(&quads);
    assert!(repairs.is_empty(), "{repairs:?}");
    let solved = Solved::new(&scene.patches, 32, u32::MAX);
    assert!(solved.solution.settled, "{} passes", solved.solution.passes);
    let level = solved.exitance()[0].x;
    assert!(level.is_finite() && level > 0.01, "{level}");
}

#[test]
fn reflectance_1_is_kept_where_light_comes_to_something_that_absorbs() {
    let mut quads = room([1.0, 1.0, 0.5], 0.001);
    quads[20].reflectance = [0.0; 3];
    let solved = Solved::new(&quads, 64, 1_000_000);
    assert!(solved.solution.settled && solved.solution.passes < 100_000);
    solved.check("reflectance 1 beside 0", Expect::default());
}

#[test]
fn reflectances_mixed_per_channel_keep_every_invariant_and_channels_apart() {
    let solved = hold("mixed channels", &room([0.0, 0.5, 0.99], 0.5), Expect::default());
    let plain = Solved::plain(&room([0.0, 0.5, 0.99], 0.5), 128, 1_000_000).exitance();
    for (channel, rho) in [0.0, 0.5, 0.99].into_iter().enumerate() {
        // Which pairs are near depends on the brightest channel: without them all is the same.
        let near = Solved::new(&room([rho; 3], 0.5), 128, 1_000_000).exitance();
        for (m, near) in solved.exitance().iter().zip(near) {
            assert!((m[channel] - near[channel]).abs() <= 0.005 * near[channel], "{m} {near}");
        }
        let alone = Solved::plain(&room([rho; 3], 0.5), 128, 1_000_000).exitance();
        for (m, alone) in plain.iter().zip(alone) {
            let off = (m[channel] - alone[channel]).abs();
            // Each solution ends when its brightest channel is done.
            assert!(off <= 1e-6 * (1.0 + alone[channel]), "{m} {alone}");
        }
    }
}

#[test]
fn an_emitter_a_million_times_brighter_drowns_no_other() {
    let mut quads = room([0.5; 3], 1.0);
    quads[50].exitance = [1e-6; 3];
    let both = hold("10^6 times brighter", &quads, Expect::default()).exitance();
    let bright = Solved::new(&room([0.5; 3], 1.0), 128, 1_000_000).exitance();
    let mut dim_only = room([0.5; 3], 0.0);
    dim_only[50].exitance = [1e-6; 3];
    let dim = Solved::new(&dim_only, 128, 1_000_000).exitance();
    for ((both, bright), dim) in both.into_iter().zip(bright).zip(dim) {
        // Sums of doubles, stored as singles; each series ends at its own residual of 1e-9.
        assert!((both - bright - dim).abs().max_element() <= 2e-7 * both.max_element());
    }
    let lit = Solved::new(&dim_only, 128, 1_000_000);
    lit.check("a dim emitter alone", Expect::default());
}

#[test]
fn no_lights_leave_a_dark_and_finite_scene() {
    let solved = hold("no lights", &room([0.9; 3], 0.0), Expect::default());
    assert_eq!((solved.solution.passes, solved.solution.residual), (0, 0.0));
    assert!(solved.exitance().iter().all(|m| *m == DVec3::ZERO));
}
