//! The light grid, read back by a decoder of its own and by another reader, against closed forms.

mod support;

use glam::DVec3;
use qbsp::{BspData, BspParseInput, BspParseSettings};
use qrad::bsp::{Bsp, Format};
use qrad::light_bsp;
use qrad::progress::Progress;
use qrad::scene::Sidecar;
use qrad::settings::{Settings, SurfaceLights};
use std::f64::consts::PI;
use std::path::Path;
use support::grid_reader::{Grid, Light};
use support::lit_room::entity;
use support::map_builder::MapBuilder;
use support::program::{arg, run};

const ROOM: [DVec3; 2] = [DVec3::new(-128.0, -128.0, 0.0), DVec3::new(128.0, 128.0, 256.0)];
const PILLAR: [DVec3; 2] = [DVec3::new(-96.0, -96.0, 0.0), DVec3::new(0.0, 0.0, 128.0)];
const SIDES: [DVec3; 6] = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];

/// Where the light of every point should have been taken, and its light.
fn points(grid: &Grid) -> impl Iterator<Item = (Option<DVec3>, Option<&[Light]>)> {
    grid.all().map(|at| (freed(grid.position(at)), grid.light(at)))
}

/// A point, or the first of its neighbours 2 units away, that is neither in a wall nor in the pillar.
fn freed(point: DVec3) -> Option<DVec3> {
    let steps = [1, 0, 3, 2, 5, 4].map(|side: usize| SIDES[side] * 2.0);
    std::iter::once(DVec3::ZERO).chain(steps).map(|s| point + s).find(|p| {
        let inside = |[low, high]: [DVec3; 2], wider: f64| {
            p.cmpgt(low - wider).all() && p.cmplt(high + wider).all()
        };
        inside(ROOM, -0.1) && !inside(PILLAR, 0.1)
    })
}

/// Whether the way between two points meets the pillar; `None` if it passes close to its edges.
fn shadowed(from: DVec3, to: DVec3) -> Option<bool> {
    let meets = |wider: f64| {
        let way = to - from;
        let a = (PILLAR[0] - wider - from) / way;
        let b = (PILLAR[1] + wider - from) / way;
        let (enter, leave) = (a.min(b).max_element().max(0.0), a.max(b).min_element().min(1.0));
        enter < leave
    };
    (meets(1.0) == meets(-1.0)).then(|| meets(0.0))
}

/// The room with the pillar.
fn room(worldspawn: &[(&str, &str)], others: &str) -> MapBuilder {
    MapBuilder::room(ROOM[0].as_vec3().into(), ROOM[1].as_vec3().into())
        .solid_texture("wall", 100)
        .solid_texture("lamp", 15)
        .pillar(PILLAR[0].as_vec3().into(), PILLAR[1].as_vec3().into(), 0)
        .entities(entity("worldspawn", worldspawn) + others)
}

fn lit(map: &MapBuilder, format: &str, settings: Settings) -> Bsp {
    let mut bsp = map.build(Format::Bsp2);
    light(&mut bsp, format, settings);
    bsp
}

fn light(bsp: &mut Bsp, format: &str, settings: Settings) {
    let keys = [("lightgrid", "1"), ("lightgrid_dist", "16"), ("lightgrid_format", format)];
    let overrides = keys.map(|(k, v)| (k.to_owned(), v.to_owned())).to_vec();
    let settings = Settings { overrides, ..settings };
    light_bsp(bsp, Sidecar::default(), Vec::new(), &settings, &Progress::new(false)).unwrap();
}

fn direct_only() -> Settings {
    Settings { bounces: Some(0), ..Settings::default() }
}

/// Largest difference between levels as stored and as computed.
fn off(got: [u8; 3], want: DVec3) -> f64 {
    let most = want.max_element();
    let want = if most > 255.0 { want * (255.0 / most) } else { want };
    (DVec3::from(got.map(f64::from)) - want).abs().max_element()
}

#[test]
fn one_light_in_a_room_has_its_closed_form_at_every_point() {
    let at = DVec3::new(64.0, 72.0, 200.0);
    let keys = [("origin", "64 72 200"), ("delay", "2"), ("_color", "1 0.5 0.25")];
    let map = room(&[], &entity("light", &keys));
    for format in ["octree", "lightgrids"] {
        let grid = Grid::of(&lit(&map, format, direct_only()));
        assert_eq!((grid.size, grid.step), ([16; 3], [16.0; 3]));
        assert_eq!(grid.mins, ROOM[0].as_vec3().to_array());
        let (mut checked, mut dark, mut solid, mut close) = (0, 0, 0, 0);
        for (place, light) in points(&grid) {
            let (Some(place), Some(light)) = (place, light) else {
                assert!(place.is_none() && light.is_none(), "{place:?} {light:?}");
                solid += 1;
                continue;
            };
            let way = at - place;
            let Some(shadowed) = shadowed(place, at) else {
                close += 1;
                continue;
            };
            if shadowed {
                assert_eq!(light, [], "{place}");
                dark += 1;
                continue;
            }
            // Contract sections 4.4 and 4.5: inverse square, half of it by the cosine; range one half.
            let full =
                DVec3::new(1.0, 0.5, 0.25) * (0.5 * 300.0 * 128.0 * 128.0 / way.length_squared());
            let share = |cosine: f64| 0.5 + 0.5 * cosine;
            let towards = way.normalize();
            let want: Vec<DVec3> = if format == "octree" {
                vec![full * share(towards.abs().max_element())]
            } else {
                let on = |side: DVec3| side.dot(towards);
                let lit = |side| if on(side) > 0.0 { full * share(on(side)) } else { DVec3::ZERO };
                SIDES.map(lit).to_vec()
            };
            let [(0, got)] = light else { panic!("one style at {place}: {light:?}") };
            assert_eq!(got.len(), want.len());
            for (got, want) in got.iter().zip(&want) {
                assert!(off(*got, *want) < 0.501, "{place}: {got:?} {want}");
            }
            checked += 1;
        }
        assert!(
            checked > 2500 && dark > 150 && solid > 200 && close < 300,
            "{checked} {dark} {solid} {close}"
        );
    }
}

/// Antiderivative of the solid angle of a rectangle at a distance.
fn solid_angle(x: f64, y: f64, distance: f64) -> f64 {
    (x * y / (distance * (x * x + y * y + distance * distance).sqrt())).atan()
}

/// Sum over the corners of the ceiling as seen from a point, with the signs of an integral.
fn over_ceiling(corner: impl Fn(f64, f64) -> f64, from: DVec3) -> f64 {
    let [low, high] = ROOM.map(|corner| corner - from);
    corner(high.x, high.y) - corner(low.x, high.y) - corner(high.x, low.y) + corner(low.x, low.y)
}

#[test]
fn light_of_a_glowing_ceiling_has_its_closed_form() {
    // No pillar, and walls that send nothing back: all bounced light is that of the ceiling.
    let lamp = entity("light", &[("_surface", "lamp"), ("light", "60"), ("delay", "2")]);
    let map = MapBuilder::room(ROOM[0].as_vec3().into(), ROOM[1].as_vec3().into())
        .solid_texture("wall", 100)
        .solid_texture("lamp", 15)
        .room_textures([0, 0, 0, 0, 0, 1])
        .entities(entity("worldspawn", &[]) + &lamp);
    let settings = || Settings {
        reflectance_scale: 0.0,
        surface_lights: SurfaceLights::Area,
        ..Settings::default()
    };
    // Palette entry 15 is 235 of 255.
    let level = 0.5 * PI * 60.0 * 235.0 / 255.0;
    let near = |p: f64, low: f64, high: f64| p - low < 1.0 || high - p < 1.0;
    for format in ["octree", "lightgrids"] {
        let grid = Grid::of(&lit(&map, format, settings()));
        let (mut worst, mut sum, mut count) = (0.0_f64, 0.0, 0);
        for at in grid.all() {
            let p = grid.position(at);
            if (0..3).any(|i| near(p[i], ROOM[0][i], ROOM[1][i])) {
                continue;
            }
            let h = ROOM[1].z - p.z;
            let light = grid.light(at).expect("not solid");
            let got = light.iter().find(|l| l.0 == 0).map_or(&[[0; 3]; 6][..], |l| &l.1[..]);
            let want: Vec<f64> = if format == "octree" {
                vec![level * over_ceiling(|x, y| solid_angle(x, y, h), p) / (4.0 * PI)]
            } else {
                let parallel = |x: f64, y: f64| {
                    let (rx, ry) = ((x * x + h * h).sqrt(), (y * y + h * h).sqrt());
                    (x / rx * (y / rx).atan() + y / ry * (x / ry).atan()) / (2.0 * PI)
                };
                vec![level * over_ceiling(parallel, p)]
            };
            // The one colour, or that of the side that looks up; none arrives from below.
            let got = if format == "octree" { got[0] } else { got[4] };
            assert!(format == "octree" || light.iter().all(|l| l.1[5] == [0; 3]));
            let off = off(got, DVec3::splat(want[0]));
            (worst, sum, count) = (worst.max(off), sum + off, count + 1);
        }
        let mean = sum / f64::from(count);
        println!("{format}: {count} points, {worst:.2} levels off at most, {mean:.3} on average");
        assert!(count > 2500 && worst < 1.5 && mean < 0.35, "{format}: {worst} {mean}");
    }
}

#[test]
fn a_furnace_is_as_bright_at_every_point_and_side() {
    let path = support::maps_dir().join("furnace.bsp");
    for format in ["octree", "lightgrids"] {
        let mut bsp = Bsp::read(&std::fs::read(&path).unwrap()).unwrap();
        light(
            &mut bsp,
            format,
            Settings { surface_lights: SurfaceLights::Area, ..Settings::default() },
        );
        // All lightmaps have one level: truncated where the grid is rounded.
        let level = *bsp.lighting.iter().max().unwrap();
        let grid = Grid::of(&bsp);
        let points: Vec<&[Light]> = grid.all().filter_map(|at| grid.light(at)).collect();
        assert!(points.len() > 100 && level > 5);
        for light in points {
            let [(0, sides)] = light else { panic!("{light:?}") };
            for side in sides {
                let most = *side.iter().max().unwrap();
                assert!(most == level || most == level + 1, "{most} {level}");
            }
        }
    }
}

#[test]
fn the_four_brightest_styles_are_kept() {
    let lights: String = (0..8)
        .map(|i| {
            let (style, light) = ([0, 3, 12, 254, 255, 5, 6, 300][i], format!("{}", 200 + 20 * i));
            let keys = [("origin", "64 64 200"), ("delay", "3"), ("light", &light)];
            entity("light", &[&keys[..], &[("style", &style.to_string())]].concat())
        })
        .collect();
    let grid = Grid::of(&lit(&room(&[], &lights), "octree", direct_only()));
    assert_eq!(grid.most_styles, 4);
    let light = grid.light([12, 12, 2]).unwrap();
    let styles: Vec<u8> = light.iter().map(|l| l.0).collect();
    assert_eq!(styles, [6, 5, 254, 12]);
}

#[test]
fn both_spellings_and_the_key_write_one_grid_at_any_number_of_threads() {
    let lamp = entity("light", &[("origin", "64 64 200")]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.bsp");
    let written = |keys: &[(&str, &str)], options: &[&str]| {
        let map = room(keys, &lamp).build(Format::Bsp2).write().unwrap();
        std::fs::write(&path, map).unwrap();
        run(&path, &[&["--hemicube", "16", "--patch-size", "8"], options].concat());
        Bsp::read(&std::fs::read(&path).unwrap()).unwrap()
    };
    let plain = written(&[], &[]);
    assert!(plain.bspx.is_empty());
    let own = written(&[], &["--lightgrid", "--lightgrid-dist", "16,16,16", "--threads", "1"]);
    let old = "-lightgrid -lightgrid_dist 16 16 16 -lightgrid_format octree -threads 2";
    let old = written(&[], &old.split(' ').collect::<Vec<_>>());
    assert!(own == old);
    let keys = [("_lightgrid", "1"), ("_lightgrid_dist", "16 16 16")];
    assert!(written(&keys, &[]).bspx == own.bspx);
    assert!(written(&keys, &["-lightgrid", "0"]).bspx.is_empty());
    assert!(written(&[], &["--lightgrid-force", "--lightgrid-dist", "16"]).bspx == own.bspx);
    // Lightmaps do not change, and an old grid does not outlive its light.
    let mut bare = own.clone();
    bare.bspx.clear();
    assert!(bare == plain);
    std::fs::write(&path, own.write().unwrap()).unwrap();
    run(&path, &["--bounces", "0"]);
    assert!(Bsp::read(&std::fs::read(&path).unwrap()).unwrap().bspx.is_empty());
    for bad in ["0", "1,2", "x", "1,2,-3", "nan"] {
        let output = support::program::qrad().arg(&path).args(["--lightgrid-dist", bad]).output();
        assert_eq!(output.unwrap().status.code(), Some(2), "{bad}");
    }
    // Nothing is written where only entities or colours are.
    run(
        &path,
        &["--lightgrid", "--bounces", "0", "--litonly", "-o", arg(&folder.path().join("x"))],
    );
    assert!(Bsp::read(&std::fs::read(&path).unwrap()).unwrap().bspx.is_empty());
}

/// What another reader finds in the map.
fn oracle(path: &Path) -> BspData {
    let settings = BspParseSettings { use_bspx_rgb_lighting: true, parse_bspx_structures: true };
    let bsp = std::fs::read(path).unwrap();
    BspData::parse(BspParseInput { bsp: &bsp, lit: None, settings }).unwrap()
}

#[test]
fn another_reader_finds_the_same_grids() {
    let map = room(&[], &entity("light", &[("origin", "64 64 200"), ("_color", "1 0 0")]));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.bsp");
    for format in ["octree", "lightgrids"] {
        std::fs::write(&path, map.build(Format::Bsp29).write().unwrap()).unwrap();
        run(&path, &["--bounces", "0", "--lightgrid", "--lightgrid-format", format]);
        let ours = Grid::of(&Bsp::read(&std::fs::read(&path).unwrap()).unwrap());
        assert_eq!(ours.size, [8; 3], "32 units apart");
        let bspx = oracle(&path).bspx;
        let counts = if format == "octree" {
            let grid = bspx.light_grid_octree.unwrap();
            assert_eq!(grid.size.to_array(), ours.size);
            (grid.nodes.len(), grid.leafs.len())
        } else {
            let grids = bspx.light_grids.unwrap();
            assert_eq!(grids.len(), 1);
            (grids[0].nodes.len(), grids[0].leafs.len())
        };
        assert_eq!(counts, (ours.nodes.len(), ours.leafs.len()));
    }
}

#[test]
fn hints_outline_the_grid() {
    let hint = |origin| entity("info_null", &[("_lightgrid_hint", "1"), ("origin", origin)]);
    let others = entity("light", &[("origin", "64 64 200")])
        + &hint("16 16 32")
        + &hint("80 112 95")
        + &hint("40 100 40");
    let grid = Grid::of(&lit(&room(&[], &others), "octree", direct_only()));
    assert_eq!((grid.mins, grid.size), ([16.0, 16.0, 32.0], [4, 6, 4]));
}
