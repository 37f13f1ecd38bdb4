//! What is so close to a luxel that the points around it do not see it: such luxels must not be
//! interpolated past it. Each test holds default light against a hemicube at every luxel.

mod support;

use glam::Vec3;
use qrad::bsp::Format;
use qrad::lightmap::Gather;
use qrad::settings::Settings;
use support::lit_map::Prepared;
use support::map_builder::MapBuilder;

/// A free luxel: where it is, its normal, and its bounced light as it is by default and exactly.
struct Luxel {
    at: Vec3,
    normal: Vec3,
    got: f32,
    exact: f32,
}

/// A grey room with dark texture 1 and a light at `origin`, filled by `furnish`; its luxels.
fn luxels(origin: &str, furnish: impl Fn(MapBuilder) -> MapBuilder) -> Vec<Luxel> {
    let room = MapBuilder::room([-192.0, -192.0, 0.0], [192.0, 192.0, 192.0])
        .solid_texture("grey", 12)
        .solid_texture("dark", 2)
        .entities(format!(
            "{{\n\"classname\" \"worldspawn\"\n}}\n\
             {{\n\"classname\" \"light\"\n\"origin\" \"{origin}\"\n\"light\" \"500\"\n}}\n"
        ));
    let map = Prepared::new(&furnish(room).build(Format::Bsp2), Settings::default(), false);
    let [got, exact] = [map.settings.gather, Gather::Luxel].map(|g| map.light(g).indirect);
    let mut all = Vec::new();
    for (face, samples) in map.samples.iter().enumerate() {
        for (i, s) in samples.iter().enumerate().filter(|(_, s)| !s.occluded) {
            let [got, exact] = [&got, &exact]
                .map(|light| light[face].first().map_or(0.0, |style| style.irradiance[i].0.x));
            all.push(Luxel { at: s.position, normal: s.normal, got, exact });
        }
    }
    all
}

/// The largest error of the luxels that `wanted` picks, relative to the mean light there.
fn worst(name: &str, all: &[Luxel], wanted: impl Fn(&Luxel) -> bool) -> f32 {
    let picked: Vec<&Luxel> = all.iter().filter(|l| wanted(l)).collect();
    assert!(picked.len() >= 8, "{name}: {}", picked.len());
    let mean = picked.iter().map(|l| l.exact).sum::<f32>() / picked.len() as f32;
    let error = picked.iter().map(|l| (l.got - l.exact).abs()).fold(0.0, f32::max) / mean;
    println!("{name}: {} luxels, mean {mean:.2}, worst off by {error:.3} of it", picked.len());
    error
}

/// A beam over a pillar that ends six units below it: the gap is as dark as it is.
#[test]
fn no_light_in_the_gap_between_a_pillar_and_a_beam() {
    let all = luxels("-90 60 60", |room| {
        room.pillar([-160.0, -8.0, 96.0], [160.0, 8.0, 112.0], 0).pillar(
            [-24.0, -24.0, 0.0],
            [24.0, 24.0, 90.0],
            0,
        )
    });
    let under_beam =
        |l: &Luxel| l.normal.z < -0.9 && (94.0..97.0).contains(&l.at.z) && l.at.x.abs() < 100.0;
    assert!(worst("gap", &all, under_beam) < 0.07);
}

/// Pilasters whose dark sides take half of the view of the luxels next to them.
#[test]
fn luxels_beside_a_dark_pilaster_see_it() {
    for depth in [8.0, 16.0, 24.0] {
        let all = luxels("-90 60 100", |room| {
            room.pillar([0.0, 192.0 - depth, 0.0], [64.0, 192.0, 192.0], 1)
        });
        let beside = |l: &Luxel| {
            let beside = (56.0..72.0).contains(&l.at.x) || (-8.0..0.0).contains(&l.at.x);
            l.normal.y < -0.9 && l.at.y > 190.0 && beside
        };
        assert!(worst(&format!("pilaster {depth} deep"), &all, beside) < 0.1, "{depth}");
    }
}
