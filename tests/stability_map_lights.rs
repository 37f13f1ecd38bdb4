//! The stability contract: lights in odd places and rooms of odd sizes, in maps. `docs/stability.md`
//! lists the cases.

mod support;

use qrad::bsp::{Bsp, Format};
use support::lit_room::entity;
use support::map_builder::MapBuilder;
use support::map_invariants::{Expect, hold};

const CLOSED: Expect = Expect { closed: true, negative: false };

/// A room of 192 units with a pillar and the lights of `entities`.
fn lit_by(entities: &str) -> Bsp {
    MapBuilder::room([0.0; 3], [192.0, 192.0, 128.0])
        .solid_texture("wall", 8)
        .pillar([64.0, 64.0, 0.0], [96.0, 96.0, 64.0], 0)
        .entities(entity("worldspawn", &[]) + entities)
        .build(Format::Bsp2)
}

fn lights(origins: &[&str], keys: &[(&str, &str)]) -> String {
    let light = |origin: &&str| entity("light", &[&[("origin", *origin)], keys].concat());
    origins.iter().map(light).collect()
}

/// The falloffs that divide by distance, and the plain one.
const DELAYS: [&str; 4] = ["0", "1", "2", "5"];

#[test]
fn lights_on_a_surface_keep_every_invariant() {
    for delay in DELAYS {
        // On the floor, in a corner, on a luxel's sample point one unit over the floor.
        let keys = [("light", "200"), ("delay", delay)];
        let places = ["32 32 0", "0 0 0", "128 128 1", "80 80 64"];
        hold(&format!("on a surface, delay {delay}"), &lit_by(&lights(&places, &keys)), CLOSED);
    }
}

#[test]
fn lights_in_solid_and_in_the_void_keep_every_invariant() {
    for delay in DELAYS {
        let keys = [("light", "200"), ("delay", delay)];
        let places = ["80 80 32", "-500 20 20", "1e9 1e9 1e9", "96 96 9999"];
        hold(&format!("in solid, delay {delay}"), &lit_by(&lights(&places, &keys)), CLOSED);
    }
}

#[test]
fn a_map_without_lights_is_dark_and_keeps_every_invariant() {
    let light = hold("no lights", &lit_by(""), CLOSED);
    let levels = light.faces.iter().flat_map(|f| &f.styles).flat_map(|s| &s.levels);
    assert!(levels.flatten().all(|&level| level == 0));
}

#[test]
fn ten_thousand_lights_keep_every_invariant() {
    let mut text = String::new();
    for i in 0..10_000 {
        let origin = format!("{} {} {}", 5 + i % 180, 100 + i / 180 % 80, 20 + i / 1000 * 10);
        text += &lights(&[&origin], &[("light", "20"), ("wait", "8")]);
    }
    let map = MapBuilder::room([0.0; 3], [192.0, 192.0, 128.0])
        .solid_texture("wall", 8)
        .entities(entity("worldspawn", &[("_lightmap_scale", "64")]) + &text)
        .build(Format::Bsp2);
    hold("10,000 lights", &map, CLOSED);
}

#[test]
fn bright_negative_and_absurd_lights_stay_finite() {
    for level in ["1e6", "1e20", "-1e6", "-1e20", "1e-30"] {
        for delay in DELAYS {
            let keys = [("light", level), ("delay", delay), ("style", "2")];
            let text = lights(&["32 32 64"], &[("light", "100")]) + &lights(&["150 150 60"], &keys);
            let negative = Expect { negative: true, ..CLOSED };
            hold(&format!("light {level}, delay {delay}"), &lit_by(&text), negative);
        }
    }
}

/// A closed room from `low` with sides of `size`, luxels `scale` units apart, a light in its middle.
fn sized(low: f32, size: f32, scale: &str) -> Bsp {
    let middle = low + size * 0.5;
    let origin = format!("{middle} {middle} {middle}");
    let level = (size * 2.0).to_string();
    MapBuilder::room([low; 3], [low + size; 3])
        .solid_texture("wall", 8)
        .entities(
            entity("worldspawn", &[("_lightmap_scale", scale)])
                + &lights(&[&origin], &[("light", &level)]),
        )
        .build(Format::Bsp2)
}

#[test]
fn a_room_10_units_wide_keeps_every_invariant_and_rows_sum_to_one() {
    hold("10 units", &sized(0.0, 10.0, "16"), CLOSED);
    hold("10 units, fine", &sized(-3.0, 10.0, "1"), CLOSED);
}

#[test]
fn a_room_65536_units_wide_keeps_every_invariant_and_rows_sum_to_one() {
    hold("65,536 units", &sized(-32768.0, 65536.0, "4096"), CLOSED);
}

#[test]
fn rooms_near_the_format_s_limits_and_shifted_by_1e5_keep_every_invariant() {
    hold("at 32,000", &sized(32000.0, 512.0, "32"), CLOSED);
    hold("at 1e5", &sized(1e5, 512.0, "32"), CLOSED);
    hold("at -1e5", &sized(-1e5, 512.0, "32"), CLOSED);
}
