//! Off means nothing: pairs of maps that differ in one thing, and what that costs in rays, cells and
//! bytes. Nothing else changes, and without the thing its counter is zero.
//!
//! `QRAD_WRITE_DOCS=1` puts the table into docs/plan.md.

mod support;

use qrad::bsp::Format;
use qrad::light::RayCounts;
use qrad::progress::Progress;
use qrad::report::Counts;
use qrad::scene::Sidecar;
use qrad::settings::{Quality, Settings};
use std::fmt::Write;
use std::path::Path;
use support::lit_room::entity;
use support::map_builder::MapBuilder;

const WALL: usize = 0;
const SKY: usize = 1;
const FENCE: usize = 2;
const GLASS: usize = 3;
const LAMP: usize = 4;

/// What a run counts that an effect may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Used {
    rays: RayCounts,
    /// Hemicubes at patches and at luxels.
    hemicubes: [u64; 2],
    factors: u64,
    styles: u64,
}

impl Used {
    fn of(counts: &Counts) -> Self {
        Self {
            rays: counts.rays,
            hemicubes: counts.hemicubes,
            factors: counts.transfers as u64,
            styles: counts.styles as u64,
        }
    }

    fn named(&self) -> [(&'static str, u64); 11] {
        let Self { rays: r, hemicubes: [patches, luxels], factors, styles } = *self;
        [
            ("rays of lights", r.lights),
            ("rays of surface lights", r.surface_lights),
            ("rays of suns", r.suns),
            ("rays of domes", r.sky_domes),
            ("rays of dirt", r.dirt),
            ("rays of least light", r.minlight),
            ("rays tested against filters", r.filtered),
            ("hemicubes at patches", patches),
            ("hemicubes at luxels", luxels),
            ("form factors", factors),
            ("styles", styles),
        ]
    }
}

/// A room under the sky with a pillar, a lamp and a screen that lets all light pass unless its keys say
/// otherwise.
fn room(
    world: &[(&str, &str)],
    lamp: &[(&str, &str)],
    screen: (&[(&str, &str)], usize),
    more: &str,
) -> MapBuilder {
    let stripes = (0..16 * 32).map(|i| if i % 32 < 16 { 255 } else { 8 }).collect();
    let lamp = [&[("origin", "-60 20 150"), ("light", "300")], lamp].concat();
    let wall = [&[("model", "*1")], screen.0].concat();
    MapBuilder::room([-192.0, -192.0, 0.0], [192.0, 192.0, 256.0])
        .solid_texture("wall", 8)
        .solid_texture("sky1", 8)
        .texture("{fence", 32, 16, stripes)
        .solid_texture("glass", 251)
        .solid_texture("lamp", 8)
        .room_textures([WALL, WALL, WALL, WALL, WALL, SKY])
        .pillar([48.0, -32.0, 0.0], [96.0, 32.0, 96.0], LAMP)
        .model([-128.0, -128.0, 64.0], [-16.0, 128.0, 66.0], Some(screen.1))
        .entities(
            entity("worldspawn", world)
                + &entity("light", &lamp)
                + &entity("func_wall", &wall)
                + more,
        )
}

fn used(map: &MapBuilder, settings: &Settings) -> Used {
    let mut bsp = map.build(Format::Bsp29);
    let progress = Progress::new(false);
    let lit = qrad::light_bsp(&mut bsp, Sidecar::default(), Vec::new(), settings, &progress);
    Used::of(&lit.unwrap().counts)
}

struct Pair {
    name: &'static str,
    without: Used,
    with: Used,
    /// What may differ.
    counters: &'static [&'static str],
}

fn pairs() -> Vec<Pair> {
    let settings = Settings::default();
    let plain = (&[][..], GLASS);
    let base = || room(&[], &[], plain, "");
    let without = used(&base(), &settings);
    let pair = |name, with: &MapBuilder, counters| Pair {
        name,
        without,
        with: used(with, &settings),
        counters,
    };
    let second = entity("light", &[("origin", "100 100 200"), ("light", "200")]);
    let negative = entity("light", &[("origin", "100 100 200"), ("light", "-200")]);
    let shining = entity("light", &[("origin", "0 0 9"), ("light", "100"), ("_surface", "lamp")]);
    let least = entity("light", &[("origin", "0 0 200"), ("light", "60"), ("delay", "4")]);
    let of_lights = &["rays of lights"][..];
    let filtered = &["rays tested against filters"][..];
    vec![
        pair("one more light", &room(&[], &[], plain, &second), of_lights),
        pair("a negative light", &room(&[], &[], plain, &negative), of_lights),
        pair("a shining texture", &room(&[], &[], plain, &shining), &["rays of surface lights"]),
        pair("a sun", &room(&[("_sunlight", "100")], &[], plain, ""), &["rays of suns"]),
        pair("a sky dome", &room(&[("_sunlight2", "100")], &[], plain, ""), &["rays of domes"]),
        pair("dirt", &room(&[("_dirt", "1")], &[], plain, ""), &["rays of dirt"]),
        pair("a light of least light", &room(&[], &[], plain, &least), &["rays of least light"]),
        pair("least light of the world", &room(&[("_minlight", "9")], &[], plain, ""), &[]),
        pair("a fence", &room(&[], &[], (&[("_shadow", "1")], FENCE), ""), filtered),
        Pair {
            name: "glass",
            without: used(&room(&[], &[], (&[("alpha", "0.5")], GLASS), ""), &settings),
            with: used(
                &room(&[], &[], (&[("_shadow", "1"), ("alpha", "0.5")], GLASS), ""),
                &settings,
            ),
            counters: filtered,
        },
        pair(
            "a shadow on the world only",
            &room(&[], &[], (&[("_shadowworldonly", "1")], GLASS), ""),
            filtered,
        ),
        Pair {
            name: "bounces",
            without: used(&room(&[("_bounce", "0")], &[], plain, ""), &settings),
            with: without,
            counters: &["hemicubes at patches", "hemicubes at luxels", "form factors"],
        },
        Pair {
            name: "luxels that look for themselves",
            without: used(
                &base(),
                &Settings { gather_error: f64::INFINITY, ..Settings::of_quality(Quality::Normal) },
            ),
            with: without,
            counters: &["hemicubes at luxels"],
        },
    ]
}

/// Hemicubes at luxels depend on where light varies, so any light may change their number a little.
const FOLLOWS: &str = "hemicubes at luxels";
/// What patches see, and with that which of them share a hemicube, depends on what stands in the room.
const OF_PATCHES: [&str; 2] = ["hemicubes at patches", "form factors"];

#[test]
fn what_is_off_takes_nothing_and_what_is_on_changes_nothing_else() {
    let pairs = pairs();
    let mut table = String::from("| a map with | and without it | with it |\n|---|---|---|\n");
    for pair in &pairs {
        let (mut without, mut with) = (Vec::new(), Vec::new());
        let filters = pair.counters.contains(&"rays tested against filters");
        for ((name, before), (_, after)) in pair.without.named().into_iter().zip(pair.with.named())
        {
            if pair.counters.contains(&name) {
                // The room has a lamp already, and luxels that no patch is near to must always look.
                let first = match name {
                    "rays of lights" => pair.without.rays.lights,
                    FOLLOWS if pair.without.factors > 0 => pair.without.hemicubes[1],
                    _ => 0,
                };
                assert_eq!(before, first, "{}: {name} without it", pair.name);
                assert!(after > before, "{}: {name} with it", pair.name);
                without.push(format!("{before} {name}"));
                with.push(format!("{after} {name}"));
            } else if name != FOLLOWS && !(filters && OF_PATCHES.contains(&name)) {
                assert_eq!(after, before, "{}: {name}", pair.name);
            }
        }
        let list = |parts: &[String]| match parts {
            [] => "the same".to_owned(),
            parts => parts.join(", "),
        };
        let _ = writeln!(table, "| {} | {} | {} |", pair.name, list(&without), list(&with));
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/plan.md");
    let text = std::fs::read_to_string(&file).unwrap();
    let (head, rest) = text.split_once("<!-- pairs -->\n").unwrap();
    let (old, tail) = rest.split_once("<!-- end of pairs -->").unwrap();
    if std::env::var_os("QRAD_WRITE_DOCS").is_some() {
        let text = format!("{head}<!-- pairs -->\n{table}<!-- end of pairs -->{tail}");
        std::fs::write(&file, text).unwrap();
    } else {
        assert_eq!(old, table, "docs/plan.md is stale: run this with QRAD_WRITE_DOCS=1");
    }
}
