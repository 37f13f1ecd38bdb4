//! Patches that are much brighter than all others: most of the light of a lamp close to a wall comes from a
//! spot that hemicubes see in a cell or in none.

mod support;

use glam::Vec3;
use qrad::bsp::Format;
use qrad::lightmap::Gather;
use qrad::scene::Sample;
use qrad::settings::Settings;
use std::f32::consts::PI;
use support::lit_map::Prepared;
use support::map_builder::MapBuilder;

/// A room with a lamp three units below its ceiling, and one bounce; `between` may stand in it.
fn room(between: impl Fn(MapBuilder) -> MapBuilder) -> Prepared {
    let room = MapBuilder::room([-512.0, -512.0, 0.0], [512.0, 512.0, 512.0])
        .solid_texture("grey", 12)
        .entities(
            "{\n\"classname\" \"worldspawn\"\n}\n\
             {\n\"classname\" \"light\"\n\"origin\" \"40 24 509\"\n\"light\" \"60\"\n\"delay\" \"2\"\n}\n",
        );
    let settings = Settings { bounces: Some(1), ..Settings::default() };
    Prepared::new(&between(room).build(Format::Bsp2), settings, false)
}

/// What arrives at a point of the floor from all luxels of the ceiling and of the walls, as from small
/// squares, in their middles: the sum of rho E A cos cos / (pi d^2), where nothing is between.
fn sum_of_luxels(map: &Prepared, at: Vec3) -> f32 {
    let mut sum = 0.0;
    for (face, direct) in map.direct().iter().enumerate() {
        let surface = &map.scene.surfaces[face];
        let Some(light) = direct.styles.first() else { continue };
        for (i, e) in light.irradiance.iter().enumerate() {
            let sample = &map.samples[face][i];
            let way = at - sample.position;
            let cosines = way.dot(surface.normal).max(0.0) * (-way.z).max(0.0);
            if cosines <= 0.0 {
                continue;
            }
            let area = share(surface.vertices.as_slice(), sample) * 256.0;
            let distance = way.length_squared();
            sum += e.0.x * surface.reflectance.0.x * area * cosines / (PI * distance * distance);
        }
    }
    sum
}

/// The part of a luxel's square that is on the room's face: luxels at its edges stick out.
fn share(corners: &[Vec3], sample: &Sample) -> f32 {
    let low = corners.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = corners.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let inside = |k: usize| {
        if high[k] - low[k] < 1.0 {
            return 1.0;
        }
        let [from, to] = [sample.position[k] - 8.0, sample.position[k] + 8.0];
        ((to.min(high[k]) - from.max(low[k])) / 16.0).clamp(0.0, 1.0)
    };
    (0..3).map(inside).product()
}

#[test]
fn the_light_of_a_spot_is_that_of_its_luxels() {
    let map = room(|room| room);
    let bounced = map.bounce(&map.direct());
    for gather in [Gather::Interpolate, Gather::Luxel] {
        let light = map.gather(&bounced, gather);
        let (mut error, mut squares, mut worst, mut count) = (0.0, 0.0, 0.0_f32, 0);
        for (face, samples) in map.samples.iter().enumerate() {
            let floor = map.scene.surfaces[face].normal.z > 0.9;
            for (i, sample) in samples.iter().enumerate().step_by(7).filter(|_| floor) {
                // Beside the walls, their luxels are no small squares.
                if sample.position.abs().truncate().max_element() > 448.0 {
                    continue;
                }
                let exact = sum_of_luxels(&map, sample.position);
                let got = light[face][0].irradiance[i].0.x;
                error += (got - exact).powi(2);
                squares += exact * exact;
                worst = worst.max((got / exact - 1.0).abs());
                count += 1;
            }
        }
        let rms = (error / squares).sqrt();
        println!("{gather:?}: {count} luxels of the floor, rms {rms:.4}, worst {worst:.4}");
        assert!(count > 400 && rms < 0.02 && worst < 0.06, "{gather:?}");
    }
}

#[test]
fn a_spot_that_is_hidden_gives_no_light() {
    // A board under the lamp, wider than the spot: the floor below it is in its shadow.
    let open = room(|room| room);
    let hidden = room(|room| room.pillar([-200.0, -216.0, 400.0], [280.0, 264.0, 416.0], 0));
    let below = |map: &Prepared| {
        let light = map.gather(&map.bounce(&map.direct()), Gather::Interpolate);
        let mut sums = Vec::new();
        for (face, samples) in map.samples.iter().enumerate() {
            let floor = map.scene.surfaces[face].normal.z > 0.9;
            for (i, s) in samples.iter().enumerate().filter(|_| floor) {
                if s.position.z < 2.0 && s.position.x.abs() < 32.0 && s.position.y.abs() < 32.0 {
                    sums.push(light[face][0].irradiance[i].0.x);
                }
            }
        }
        assert!(sums.len() > 8);
        sums.iter().sum::<f32>() / sums.len() as f32
    };
    let [lit, dark] = [below(&open), below(&hidden)];
    println!("{lit} without the board, {dark} with it");
    assert!(dark < 0.2 * lit && dark >= 0.0);
}
