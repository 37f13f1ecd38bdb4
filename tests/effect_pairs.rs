//! Off means nothing: for each effect of the plan a pair of maps that differ in one thing, and what that
//! costs in rays, cells and bytes. Nothing else changes, and without the thing its counter is zero.
//!
//! `QRAD_WRITE_DOCS=1` puts the table into docs/plan.md.

mod support;

use clap::ValueEnum;
use qrad::bsp::Format;
use qrad::light::RayCounts;
use qrad::outputs::{LitFile, Outputs};
use qrad::progress::Progress;
use qrad::radiosity::channels::Channels;
use qrad::report::Counts;
use qrad::scene::effects::{Effect, Switches};
use qrad::scene::material_file::MaterialFile;
use qrad::scene::{LuxelSettings, Sidecar};
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
    passages: u64,
    patterned: u64,
    /// Cells of hemicubes behind glass and on patterns.
    overlaid: [u64; 2],
    /// Bytes of smoothed normals.
    smoothed: u64,
    styles: u64,
    channels: u64,
    /// Of lumps and of files beside the map.
    bytes: [u64; 2],
}

impl Used {
    fn of(counts: &Counts, bytes: [usize; 2]) -> Self {
        Self {
            rays: counts.rays,
            hemicubes: counts.hemicubes,
            factors: counts.transfers as u64,
            passages: counts.passages as u64,
            patterned: counts.patterned as u64,
            overlaid: counts.overlay.map(|cost| cost.cells),
            smoothed: counts.smoothed,
            styles: counts.styles as u64,
            channels: counts.channels.map_or(0, Channels::count),
            bytes: bytes.map(|n| n as u64),
        }
    }

    fn named(&self) -> [(&'static str, u64); 19] {
        let Self { rays: r, hemicubes: [patches, luxels], factors, bytes: [lumps, files], .. } =
            *self;
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
            ("ways through curtains", self.passages),
            ("patches with patterns", self.patterned),
            ("cells behind glass", self.overlaid[0]),
            ("cells on patterns", self.overlaid[1]),
            ("bytes of smoothed normals", self.smoothed),
            ("styles", self.styles),
            ("channels", self.channels),
            ("bytes of lumps", lumps),
            ("bytes beside the map", files),
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

/// A map with what it is lit with.
struct Case {
    map: MapBuilder,
    settings: Settings,
    materials: &'static str,
}

impl Case {
    fn new(map: MapBuilder) -> Self {
        Self { map, settings: Settings::default(), materials: "" }
    }

    fn outputs(self, outputs: Outputs) -> Self {
        Self { settings: Settings { outputs, ..self.settings }, ..self }
    }

    /// What it takes, and which effects its plan has.
    fn light(&self) -> (Used, Vec<Effect>) {
        let mut bsp = self.map.build(Format::Bsp29);
        let materials = MaterialFile::parse(self.materials, "m").unwrap();
        let sidecar = Sidecar { materials: Some(&materials), ..Sidecar::default() };
        let progress = Progress::new(false);
        let lit =
            qrad::light_bsp(&mut bsp, sidecar, Vec::new(), &self.settings, &progress).unwrap();
        let lumps = bsp.bspx.iter().map(|lump| lump.data.len()).sum();
        let files = [&lit.files.lit, &lit.files.lux].map(|f| f.as_ref().map_or(0, Vec::len));
        let plan = qrad::plan(&lit.scene, &self.settings);
        let on = Effect::value_variants().iter().copied().filter(|&e| plan.is_on(e)).collect();
        (Used::of(&lit.counts, [lumps, files.iter().sum()]), on)
    }
}

struct Pair {
    effect: Effect,
    name: &'static str,
    without: Case,
    with: Case,
    /// What grows.
    counters: &'static [&'static str],
    /// What may differ, too, as light falls elsewhere.
    follows: &'static [&'static str],
}

const LIGHTS: &str = "rays of lights";
const FILTERED: &str = "rays tested against filters";
const LUMPS: &str = "bytes of lumps";
const FILES: &str = "bytes beside the map";
/// Hemicubes at luxels depend on where light varies, so any light may change their number a little.
const FOLLOWS: &str = "hemicubes at luxels";
/// What patches see, and with that which of them share a hemicube, depends on what stands in the room.
const OF_PATCHES: [&str; 2] = ["hemicubes at patches", "form factors"];

const CLOTH: &str = "[[material]]\ntexture = \"glass\"\nreflectance = [0.5, 0.5, 0.5]\n";
const CURTAIN: &str = "[[material]]\ntexture = \"glass\"\nreflectance = [0.5, 0.5, 0.5]\n\
    diffuse_transmission = 0.4\n";
const CHECKER: &str = "[[material]]\ntexture = \"wall\"\n\
    modifier = { kind = \"checker\", size = 32, colour = 0.5 }\n";

/// Effects of light.
fn of_light() -> Vec<Pair> {
    let plain = (&[][..], GLASS);
    let base = || Case::new(room(&[], &[], plain, ""));
    let pair = |effect, name, with, counters| Pair {
        effect,
        name,
        without: base(),
        with: Case::new(with),
        counters,
        follows: &[],
    };
    let at = |keys: &[(&str, &str)]| {
        entity("light", &[&[("origin", "100 100 200"), ("light", "200")], keys].concat())
    };
    let second = at(&[]);
    let negative = entity("light", &[("origin", "100 100 200"), ("light", "-200")]);
    let shining = entity("light", &[("origin", "0 0 9"), ("light", "100"), ("_surface", "lamp")]);
    let least = entity("light", &[("origin", "0 0 200"), ("light", "60"), ("delay", "4")]);
    let world = |key| room(&[key], &[], plain, "");
    let more = |text: &str| room(&[], &[], plain, text);
    let screen = |keys, texture| room(&[], &[], (keys, texture), "");
    let filtered = &[FILTERED][..];
    vec![
        pair(Effect::Lights, "one more light", more(&second), &[LIGHTS]),
        pair(Effect::NegativeLight, "a negative light", more(&negative), &[LIGHTS]),
        Pair {
            without: Case::new(more(&second)),
            follows: &[FILES],
            ..pair(Effect::Styles, "a light of style 5", more(&at(&[("style", "5")])), &["styles"])
        },
        Pair {
            follows: &[LIGHTS],
            ..pair(
                Effect::Projections,
                "a lamp that projects",
                room(
                    &[],
                    &[("_project_texture", "wall"), ("_project_mangle", "0 -90 0")],
                    plain,
                    "",
                ),
                &[],
            )
        },
        pair(
            Effect::SurfaceLights,
            "a shining texture",
            more(&shining),
            &["rays of surface lights"],
        ),
        pair(Effect::Suns, "a sun", world(("_sunlight", "100")), &["rays of suns"]),
        pair(Effect::SkyDomes, "a sky dome", world(("_sunlight2", "100")), &["rays of domes"]),
        pair(Effect::Dirt, "dirt", world(("_dirt", "1")), &["rays of dirt"]),
        pair(Effect::Minlight, "a light of least light", more(&least), &["rays of least light"]),
        pair(Effect::Minlight, "least light of the world", world(("_minlight", "9")), &[]),
        Pair {
            follows: &[LIGHTS],
            ..pair(
                Effect::Phong,
                "smoothed normals",
                screen(&[("_phong", "1")], GLASS),
                &["bytes of smoothed normals"],
            )
        },
        pair(Effect::Fences, "a fence", screen(&[("_shadow", "1")], FENCE), filtered),
        Pair {
            without: Case::new(screen(&[("alpha", "0.5")], GLASS)),
            follows: &["channels", FILES],
            ..pair(
                Effect::Glass,
                "glass",
                screen(&[("_shadow", "1"), ("alpha", "0.5")], GLASS),
                &[FILTERED, "cells behind glass"],
            )
        },
        pair(
            Effect::ModelShadows,
            "a shadow on the world only",
            screen(&[("_shadowworldonly", "1")], GLASS),
            filtered,
        ),
    ]
}

/// Effects that a material file or settings decide.
fn of_settings() -> Vec<Pair> {
    let base = || Case::new(room(&[], &[], (&[], GLASS), ""));
    let cloth = |materials| {
        let map = room(&[], &[], (&[("_shadow", "1")], GLASS), "");
        Case { materials, ..Case::new(map) }
    };
    let coloured = || Case::new(room(&[], &[("_color", "255 128 64")], (&[], GLASS), ""));
    let set = |settings| Case { settings, ..base() };
    let outputs = |outputs| base().outputs(outputs);
    let pair = |effect, name, with, counters| Pair {
        effect,
        name,
        without: base(),
        with,
        counters,
        follows: &[],
    };
    let default = Outputs::default;
    let bounced = &["hemicubes at patches", FOLLOWS, "form factors"][..];
    let grey = Switches::parse("-colour").unwrap();
    let luxels = LuxelSettings { world_units: Some(8.0), ..LuxelSettings::default() };
    let mut fine = Settings::default();
    fine.smoothing.extra = 4;
    vec![
        Pair {
            without: cloth(CLOTH),
            ..pair(Effect::Curtains, "a curtain", cloth(CURTAIN), &["ways through curtains"])
        },
        pair(
            Effect::Shaders,
            "a checker",
            Case { materials: CHECKER, ..base() },
            &["patches with patterns", "cells on patterns"],
        ),
        Pair {
            without: Case {
                settings: Settings { switches: grey, ..Settings::default() },
                ..coloured()
            },
            ..pair(Effect::Colour, "a lamp with colour", coloured(), &["channels", FILES])
        },
        Pair {
            without: Case::new(room(&[("_bounce", "0")], &[], (&[], GLASS), "")),
            follows: &["channels", FILES],
            ..pair(Effect::Bounces, "bounces", base(), bounced)
        },
        Pair {
            without: set(Settings {
                gather_error: f64::INFINITY,
                ..Settings::of_quality(Quality::Normal)
            }),
            ..pair(Effect::NearField, "luxels that look for themselves", base(), &[FOLLOWS])
        },
        pair(Effect::Supersampling, "16 samples a luxel", set(fine), &[LIGHTS]),
        Pair {
            without: coloured().outputs(Outputs { lit: LitFile::Never, ..default() }),
            ..pair(Effect::Lit, "a .lit file", coloured(), &[FILES])
        },
        pair(
            Effect::Hdr,
            "light beyond bytes",
            outputs(Outputs { bspx_hdr: true, ..default() }),
            &[LUMPS],
        ),
        pair(
            Effect::BspxLight,
            "colours in the map",
            outputs(Outputs { bspx_lit: true, ..default() }),
            &[LUMPS],
        ),
        pair(
            Effect::Directions,
            "where light comes from",
            outputs(Outputs { bspx_lux: true, ..default() }),
            &[LUMPS],
        ),
        pair(
            Effect::FaceNormals,
            "normals at corners",
            outputs(Outputs { face_normals: true, ..default() }),
            &[LUMPS],
        ),
        pair(
            Effect::FaceStyles,
            "room for 8 styles a face",
            outputs(Outputs { face_styles: 8, ..default() }),
            &[],
        ),
        Pair {
            follows: &[OF_PATCHES[0], OF_PATCHES[1], LIGHTS, FILES],
            ..pair(
                Effect::LuxelSizes,
                "luxels of 8 units",
                outputs(Outputs { luxels, ..default() }),
                &[LUMPS],
            )
        },
        pair(
            Effect::LightGrid,
            "light at points in space",
            Case::new(room(&[("_lightgrid", "1")], &[], (&[], GLASS), "")),
            &[LUMPS],
        ),
    ]
}

/// What is there even without the thing: the room has a lamp and one style in one channel, and luxels that
/// no patch is near to must always look.
fn least(name: &str, without: &Used) -> u64 {
    match name {
        LIGHTS => without.rays.lights,
        FOLLOWS if without.factors > 0 => without.hemicubes[1],
        "styles" | "channels" if without.factors > 0 => 1,
        _ => 0,
    }
}

#[test]
fn what_is_off_takes_nothing_and_what_is_on_changes_nothing_else() {
    let mut table =
        String::from("| effect | a map with | and without it | with it |\n|---|---|---|---|\n");
    let (mut seen, mut wrong) = (Vec::new(), Vec::new());
    let mut want = |holds: bool, what: String| wrong.extend((!holds).then_some(what));
    for Pair { effect, name: thing, without, with, counters, follows } in
        of_light().into_iter().chain(of_settings())
    {
        let [(without, off), (with, on)] = [without, with].map(|case| case.light());
        want(on.contains(&effect), format!("{thing}: {effect:?} with it"));
        // The room has a lamp, and its screen may take the light of its middle as least light.
        let there = [Effect::Lights, Effect::Minlight].contains(&effect);
        want(there || !off.contains(&effect), format!("{thing}: {effect:?} without it"));
        let filters = counters.contains(&FILTERED);
        let [mut before_all, mut after_all] = [Vec::new(), Vec::new()];
        for ((name, before), (_, after)) in without.named().into_iter().zip(with.named()) {
            let grows = counters.contains(&name);
            if grows {
                let first = least(name, &without);
                want(before == first, format!("{thing}: {name} without it: {before}"));
                want(after > before, format!("{thing}: {name} with it: {after} after {before}"));
            } else if !follows.contains(&name)
                && name != FOLLOWS
                && !(filters && OF_PATCHES.contains(&name))
            {
                want(after == before, format!("{thing}: {name}: {after} after {before}"));
            }
            if grows || follows.contains(&name) && after != before {
                before_all.push(format!("{before} {name}"));
                after_all.push(format!("{after} {name}"));
            }
        }
        let list = |parts: &[String]| match parts {
            [] => "the same".to_owned(),
            parts => parts.join(", "),
        };
        let (before, after) = (list(&before_all), list(&after_all));
        let _ = writeln!(table, "| {} | {thing} | {before} | {after} |", effect.name());
        seen.push(effect);
    }
    for effect in Effect::value_variants() {
        want(seen.contains(effect), format!("no pair shows what {effect:?} costs"));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
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
