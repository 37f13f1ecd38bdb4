//! Writes the inputs that the fuzz targets start from into `corpus/TARGET/`: small maps of our own
//! making, and text of every kind.

#[path = "../../tests/support/map_builder.rs"]
#[allow(dead_code)]
mod map_builder;
#[path = "../../tests/support/tiny.rs"]
mod tiny;
#[path = "../../tests/support/wads.rs"]
mod wads;

use map_builder::MapBuilder;
use qrad::bsp::{Bsp, Format, write_hdr_lit, write_lit};
use std::fs;
use std::path::{Path, PathBuf};
use wads::wad;

fn main() -> std::io::Result<()> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let corpus = |target: &str, name: &str, bytes: &[u8]| -> std::io::Result<()> {
        let folder = here.join("corpus").join(target);
        fs::create_dir_all(&folder)?;
        fs::write(folder.join(name), bytes)
    };
    for (name, map) in maps() {
        let file = map.write().expect("a map of our own");
        corpus("bsp", &name, &file)?;
        corpus("light", &name, &file)?;
        corpus("entities", &name, &map.entities)?;
    }
    corpus("lit", "levels", &write_lit(&[1, 2, 3, 4, 5, 6]))?;
    corpus("lit", "hdr", &write_hdr_lit(&[0, 0x8000_0001]))?;
    corpus("wad", "one", &wad(8, 8))?;
    corpus("wad", "odd", &wad(3, 5))?;
    for path in text_scenes(&here.join("../maps/cornell"))? {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        corpus("text", &name, &fs::read(&path)?)?;
    }
    corpus("sidecar", "all", SIDECARS.as_bytes())?;
    corpus("sidecar", "none", b"{}\0[]\0")
}

/// Scenes small enough to be lit thousands of times.
fn text_scenes(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder)?.map(|entry| entry.map(|e| e.path()));
    let paths: Vec<PathBuf> = entries.collect::<std::io::Result<_>>()?;
    let small = |path: &PathBuf| fs::metadata(path).is_ok_and(|m| m.len() < 16_384);
    let text = |path: &PathBuf| path.extension().is_some_and(|e| e == "txt");
    Ok(paths.into_iter().filter(|p| text(p) && small(p)).collect())
}

fn maps() -> Vec<(String, Bsp)> {
    let room = MapBuilder::room([0.0; 3], [64.0; 3]).solid_texture("wall", 8).entities(
        "{\n\"classname\" \"worldspawn\"\n}\n{\n\"classname\" \"light\"\n\"origin\" \"32 32 32\"\n}\n",
    );
    [Format::Bsp29, Format::Bsp2, Format::TwoPsb]
        .into_iter()
        .flat_map(|format| {
            [
                (format!("tiny-{format:?}"), tiny::map(format)),
                (format!("room-{format:?}"), room.build(format)),
            ]
        })
        .collect()
}

/// texinfo.json, content.json and `.rad` with a NUL between.
const SIDECARS: &str = concat!(
    r#"{"0":{"no_shadow":true,"no_bounce":false,"light_ignore":false,"phong_angle":89.5,"#,
    r#""phong_angle_concave":30,"phong_group":2,"surflight_group":1,"light_twosided":true,"#,
    r#""light_alpha":0.5,"maxlight":100,"lightcolorscale":0.5,"object_channel_mask":2,"#,
    r#""no_dirt":true,"no_minlight":true,"minlight":20,"minlight_color":[1,2,3],"#,
    r#""surflight_rescale":true,"surflight_style":3,"surflight_targetname":"torch","#,
    r#""surflight_color":[255,0,0],"surflight_minlight_scale":2,"surflight_atten":0.5,"#,
    r#""world_units_per_luxel":8},"1":{}}"#,
    "\0",
    r#"[["solid"],[],["window","sky"]]"#,
    "\0lamp 255 255 200 500\nwall 1 2 3 4\n"
);
