//! What `--engine` writes for each engine.

mod support;

use support::map_builder::MapBuilder;
use support::program::{qrad, run};
use support::written::{on_disk, read, words};

#[test]
fn engines_get_what_they_read() {
    let light = "{ \"classname\" \"light\" \"origin\" \"0 0 99\" \"_color\" \"1 0.5 0.25\" }";
    let map = MapBuilder::room([-64.0, -64.0, 0.0], [64.0, 64.0, 128.0])
        .solid_texture("wall", 100)
        .entities(format!("{{ \"classname\" \"worldspawn\" }} {light}"));
    let (_folder, path) = on_disk(&map);
    for (engine, lit_version, lumps) in [
        ("quakespasm", Some(1), &[][..]),
        ("ironwail", Some(1), &[]),
        ("vkquake", Some(1), &[]),
        ("darkplaces", Some(1), &[]),
        ("qss", None, &["RGBLIGHTING"]),
        ("ezquake", None, &["RGBLIGHTING"]),
        ("fte", None, &["LIGHTING_E5BGR9"]),
    ] {
        let output = run(&path, &["--bounces", "0", "--engine", engine]);
        let text = String::from_utf8(output.stdout).unwrap();
        let first = text.lines().next().unwrap();
        assert!(first.contains("lighting lump"), "{engine}: {first}");
        assert!(output.stderr.is_empty(), "{engine}");
        let lit = std::fs::read(path.with_extension("lit")).ok();
        assert_eq!(lit.map(|lit| words(&lit[4..8])[0]), lit_version, "{engine}");
        let bsp = read(&path);
        assert!(!bsp.lighting.is_empty());
        assert!(bsp.bspx.iter().map(|l| &*l.name).eq(lumps.iter().copied()), "{engine}");
    }
    let output = run(&path, &["--bounces", "0", "--engine", "ironwail", "--bspxhdr"]);
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(text.contains("Ironwail is not known to read LIGHTING_E5BGR9"), "{text}");
    qrad().arg(&path).args(["--engine", "doom"]).assert().code(2);
}
