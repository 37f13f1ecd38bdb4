//! Damaged text: scenes, entities, what lies beside a map, WADs, `.lit` files. Cut everywhere, with
//! every number replaced.

mod support;

use proptest::prelude::*;
use qrad::bsp::{Bsp, Format, parse_entities, write_lit};
use qrad::patch::{Reading, TextScene};
use std::time::{Duration, Instant};
use support::map_builder::MapBuilder;
use support::wads::wad;
use support::{attacks, tiny};

const SCENE: &str = "0 0 0 0 5 0 0 0 1\n64 64 8 8 100\n\
    0 0 0 1 0 0 1 1 0 0 1 0 0 0 1\n0.5 0.5 0.5 0.9 0.8 0.7\n\
    0 0 1 0 1 1 1 1 1 1 0 1 0 0 -1\n0 0 0 0.9 0.8 0.7\n";

const TEXINFO: &str = r#"{"0":{"no_shadow":true,"phong_angle":89.5,"phong_group":2,
    "light_twosided":true,"light_alpha":0.5,"maxlight":100,"lightcolorscale":0.5,
    "object_channel_mask":2,"minlight":20,"minlight_color":[1,2,3],"surflight_style":3,
    "surflight_targetname":"torch","surflight_atten":0.5,"world_units_per_luxel":8},"1":{}}"#;

#[test]
fn scenes_cut_anywhere_are_refused_with_a_line_or_are_whole() {
    for length in 0..SCENE.len() {
        let text = &SCENE[..length];
        attacks::text(text.as_bytes());
        if let Err(error) = TextScene::parse(text, "s.txt") {
            let line = error.to_string();
            assert!(line.starts_with("s.txt: line "), "{line}");
        }
    }
}

#[test]
fn every_number_of_a_scene_replaced_is_refused_with_its_line_or_repaired() {
    let bad = [
        "nan",
        "inf",
        "-inf",
        "1e999",
        "-1",
        "1e13",
        "1e-320",
        "99999999999999999999",
        "x",
        "0x10",
        "",
    ];
    for (number, line) in SCENE.lines().enumerate() {
        for at in 0..line.split(' ').count() {
            for value in bad {
                let words = line.split(' ').enumerate();
                let words: Vec<&str> =
                    words.map(|(i, w)| if i == at { value } else { w }).collect();
                let mut lines: Vec<String> = SCENE.lines().map(str::to_owned).collect();
                lines[number] = words.join(" ");
                let text = lines.join("\n");
                attacks::text(text.as_bytes());
                let parsed = TextScene::parse_repaired(&text, "s", Reading::Raw);
                if let Err(error) = parsed {
                    let line = error.to_string();
                    assert!(line.starts_with(&format!("s: line {}", number + 1)), "{line}");
                } else {
                    assert!(!["nan", "inf", "-inf", "1e999", "x", "0x10", ""].contains(&value));
                }
            }
        }
    }
}

#[test]
fn lines_of_a_scene_left_out_or_doubled_are_refused_with_a_line() {
    let lines: Vec<&str> = SCENE.lines().collect();
    for at in 0..lines.len() {
        let mut without = lines.clone();
        without.remove(at);
        let mut twice = lines.clone();
        twice.insert(at, lines[at]);
        for text in [without.join("\n"), twice.join("\n")] {
            let line = TextScene::parse(&text, "s").unwrap_err().to_string();
            assert!(line.starts_with("s: line "), "{line}");
        }
    }
}

#[test]
fn entity_text_cut_anywhere_is_refused_with_a_line_or_whole() {
    let text = tiny::ENTITIES.as_bytes();
    for length in 0..text.len() {
        attacks::entities(&text[..length]);
        if let Err(error) = parse_entities(&text[..length]) {
            assert!(error.to_string().starts_with("entity text line "), "{error}");
        }
    }
}

/// The tiny map with other entity text.
fn with_entities(text: &str) -> Bsp {
    let mut map = tiny::map(Format::Bsp29);
    map.entities = text.as_bytes().to_vec();
    map
}

#[test]
fn every_value_of_every_entity_may_be_anything() {
    // One number and three, since a key may want either.
    let bad = ["nan", "-1e38", "1e38 1e38 1e38", "1e39", "99999999999", "", "-1e-38 x"];
    let lines: Vec<&str> = tiny::ENTITIES.lines().collect();
    for (number, line) in lines.iter().enumerate().filter(|(_, l)| l.starts_with('"')) {
        let key = line.split('"').nth(1).unwrap();
        for value in bad {
            let mut lines: Vec<String> = lines.iter().map(|&l| l.to_owned()).collect();
            lines[number] = format!("\"{key}\" \"{value}\"");
            let text = lines.join("\n");
            attacks::light_with(with_entities(&text), Default::default());
        }
    }
}

/// Runs `work`, which must not take long however large its input.
#[track_caller]
fn soon<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    let time = start.elapsed();
    println!("{what}: {time:?}");
    assert!(time < Duration::from_secs(10), "{what} took {time:?}");
    result
}

/// The same for work of this thread alone, by its own clock: the machine may be busy.
#[track_caller]
fn soon_alone<T>(what: &str, work: impl FnOnce() -> T) -> T {
    // Ticks of 1/100 s; the name before them may have spaces.
    let ticks = || -> Option<u64> {
        let text = std::fs::read_to_string("/proc/thread-self/stat").ok()?;
        let words: Vec<&str> = text.rsplit(')').next()?.split_whitespace().collect();
        Some(words.get(11)?.parse::<u64>().ok()? + words.get(12)?.parse::<u64>().ok()?)
    };
    let Some(start) = ticks() else { return soon(what, work) };
    let result = work();
    let time = (ticks().unwrap_or(start) - start) as f64 / 100.0;
    println!("{what}: {time} s of this thread");
    assert!(time < 5.0, "{what} took {time} s");
    result
}

#[test]
fn entity_texts_made_to_take_forever_do_not() {
    let keys: String = (0..200_000).map(|i| format!("k{i} v\n")).collect();
    soon_alone("a long entity", || attacks::entities(format!("{{ {keys} }}").as_bytes()));
    let braces = "{}".repeat(200_000);
    soon("many entities", || attacks::light_with(with_entities(&braces), Default::default()));
    let quotes = "{ a \"".to_owned() + &"\\\"".repeat(500_000);
    soon_alone("an open quote", || attacks::entities(quotes.as_bytes()));
    // Lights that all look for targets that come last, or never.
    let targets: String = (0..20_000)
        .map(|i| format!("{{ classname light target t{i} origin \"1 1 1\" }}\n"))
        .collect();
    soon("targets", || attacks::light_with(with_entities(&targets), Default::default()));
    let surfaces: String =
        (0..5_000).map(|i| format!("{{ classname light _surface lamp light {i} }}\n")).collect();
    soon("surface lights", || attacks::light_with(with_entities(&surfaces), Default::default()));
    let suns = "{ classname worldspawn _sunlight 100 _sunlight2 100 _sunsamples 1000000000 _sunlight_penumbra 30 }";
    soon("sun samples", || attacks::light_with(with_entities(suns), Default::default()));
    let dirt = "{ classname worldspawn _dirt 1 _dirtdepth 1e30 _dirtscale 1e30 _dirtgain 1e30 }{ classname light origin \"60 60 60\" }";
    soon("dirt", || attacks::light_with(with_entities(dirt), Default::default()));
    for (key, value) in [
        ("_lightmap_scale", "1"),
        ("_surflight_subdivide", "1"),
        ("_world_units_per_luxel", "0.25"),
    ] {
        let text =
            format!("{{ classname worldspawn {key} {value} }}{{ classname light _surface lamp }}");
        soon(key, || attacks::light_with(with_entities(&text), Default::default()));
    }
}

#[test]
fn files_beside_the_map_cut_anywhere_are_survived() {
    let map = tiny::map(Format::Bsp29);
    for length in (0..TEXINFO.len()).step_by(3) {
        attacks::sidecar(&TEXINFO.as_bytes()[..length], &map);
    }
    let deep = "[".repeat(100_000);
    attacks::sidecar(format!("{deep}\0{deep}\0{deep}").as_bytes(), &map);
}

#[test]
fn every_value_of_texinfo_json_may_be_anything() {
    let map = tiny::map(Format::Bsp29);
    let bad = [
        "null",
        "true",
        "-1",
        "1e38",
        "1e400",
        "99999999999999999999",
        "\"x\"",
        "[]",
        "{}",
        "[1e38,1e38,1e38]",
    ];
    let colons: Vec<usize> = TEXINFO.match_indices(':').map(|(i, _)| i + 1).collect();
    for at in colons {
        let rest = &TEXINFO[at..];
        let end = if rest.starts_with('[') {
            rest.find(']').map(|i| i + 1)
        } else if rest.starts_with('{') {
            None
        } else {
            rest.find([',', '}'])
        };
        let Some(end) = end else { continue };
        for value in bad {
            let text = format!("{}{value}{}", &TEXINFO[..at], &rest[end..]);
            attacks::sidecar(text.as_bytes(), &map);
        }
    }
}

#[test]
fn every_value_of_content_json_may_be_anything() {
    let map = tiny::map(Format::Bsp29);
    let bad = ["null", "7", "\"solid\"", "{}", "[[\"solid\"]]", "[1]", "[\"\\u0000\"]", "1e400"];
    for at in 0..map.leafs.len() {
        for value in bad {
            let leafs: Vec<&str> =
                (0..map.leafs.len()).map(|i| if i == at { value } else { "[\"solid\"]" }).collect();
            attacks::sidecar(format!("{{}}\0[{}]", leafs.join(",")).as_bytes(), &map);
        }
    }
    for text in ["[]", "[[],[]]", "{}", "null", "[[\"solid\"]"] {
        attacks::sidecar(format!("{{}}\0{text}").as_bytes(), &map);
    }
}

#[test]
fn every_field_of_a_wad_may_hold_anything() {
    let file = wad(8, 8);
    for at in 0..file.len() - 3 {
        for word in [0, 1, 3, 40, 0x44, 255, 0x7fff_ffff, 0x8000_0000, u32::MAX, file.len() as u32]
        {
            let mut bad = file.clone();
            bad[at..at + 4].copy_from_slice(&word.to_le_bytes());
            attacks::wad(&bad);
        }
    }
    for length in 0..file.len() {
        attacks::wad(&file[..length]);
    }
}

#[test]
fn lits_of_any_length_and_version_are_survived() {
    let file = write_lit(&[9; 30]);
    for length in 0..file.len() {
        attacks::lit(&file[..length]);
    }
    for at in 0..8 {
        for byte in 0..=255 {
            let mut bad = file.clone();
            bad[at] = byte;
            attacks::lit(&bad);
        }
    }
}

/// Bytes with some replaced, some doubled and an end cut off.
fn damaged(seed: Vec<u8>) -> impl Strategy<Value = Vec<u8>> {
    let edits = prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8);
    let words = prop::collection::vec((any::<prop::sample::Index>(), any::<u32>()), 0..3);
    (edits, words, any::<prop::sample::Index>(), 0..4_u8).prop_map(
        move |(edits, words, cut, how)| {
            let mut bytes = seed.clone();
            for (at, byte) in edits {
                let at = at.index(bytes.len());
                bytes[at] = byte;
            }
            for (at, word) in words {
                let at = at.index(bytes.len() - 3) & !3;
                bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
            }
            if how == 0 {
                bytes.truncate(cut.index(bytes.len()));
            }
            bytes
        },
    )
}

fn small() -> Bsp {
    MapBuilder::room([0.0; 3], [64.0; 3])
        .solid_texture("wall", 8)
        .entities(tiny::ENTITIES)
        .build(Format::Bsp2)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_maps_are_survived(bytes in damaged(small().write().unwrap())) {
        attacks::bsp(&bytes);
        attacks::light(&bytes);
    }

    #[test]
    fn damaged_entities_are_survived(bytes in damaged(tiny::ENTITIES.as_bytes().to_vec())) {
        attacks::entities(&bytes);
        let mut map = tiny::map(Format::Bsp29);
        map.entities = bytes;
        attacks::light_with(map, Default::default());
    }

    #[test]
    fn damaged_scenes_are_survived(bytes in damaged(SCENE.as_bytes().to_vec())) {
        attacks::text(&bytes);
    }

    #[test]
    fn damaged_sidecars_are_survived(bytes in damaged(TEXINFO.as_bytes().to_vec())) {
        attacks::sidecar(&bytes, &tiny::map(Format::Bsp29));
    }

    #[test]
    fn damaged_wads_are_survived(bytes in damaged(wad(8, 8))) {
        attacks::wad(&bytes);
    }

    #[test]
    fn damaged_lits_are_survived(bytes in damaged(write_lit(&[1, 2, 3, 4, 5, 6]))) {
        attacks::lit(&bytes);
    }
}
