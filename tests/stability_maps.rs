//! The stability contract: hard maps. `docs/stability.md` lists the cases.

mod support;

use glam::Vec3;
use qrad::bsp::{Bsp, Format};
use support::lit_room::entity;
use support::map_builder::MapBuilder;
use support::map_invariants::{Expect, hold};
use support::polygons::{add_face, carpet, disc};

const CLOSED: Expect = Expect::CLOSED;
const OPEN: Expect = Expect::OPEN;

fn room() -> MapBuilder {
    MapBuilder::room([0.0; 3], [192.0, 160.0, 128.0])
        .solid_texture("wall", 8)
        .solid_texture("lamp", 254)
        .entities(light("96 80 100", "200"))
}

fn light(origin: &str, level: &str) -> String {
    entity("worldspawn", &[]) + &entity("light", &[("origin", origin), ("light", level)])
}

/// The room with more faces, all with the second texture.
fn with_faces(faces: &[(Vec<Vec3>, Vec3)]) -> Bsp {
    let mut map = room().build(Format::Bsp2);
    for (vertices, normal) in faces {
        add_face(&mut map, vertices, *normal, 1);
    }
    map.assemble().unwrap()
}

/// The brightest light of a face.
fn brightest(light: &qrad::MapLight, face: usize) -> f32 {
    let maps = light.faces[face].styles.iter().flat_map(|s| &s.light);
    maps.map(|l| l.max_element()).fold(0.0, f32::max)
}

#[test]
fn a_map_of_one_face_keeps_every_invariant() {
    let mut map = room().build(Format::Bsp29);
    map.faces.truncate(1);
    map.marksurfaces.clear();
    for leaf in &mut map.leafs {
        leaf.mark_count = 0;
    }
    map.models[0].face_count = 1;
    let light = hold("one face", &map.assemble().unwrap(), OPEN);
    assert!(brightest(&light, 0) > 1.0);
}

#[test]
fn a_map_without_faces_is_lit_to_nothing() {
    let mut map = room().build(Format::Bsp29);
    map.faces.clear();
    map.marksurfaces.clear();
    for leaf in &mut map.leafs {
        leaf.mark_count = 0;
    }
    map.models[0].face_count = 0;
    let light = hold("no face", &map.assemble().unwrap(), OPEN);
    assert!(light.faces.is_empty() && light.files.lit.is_none());
}

#[test]
fn a_face_of_64_vertices_keeps_every_invariant() {
    let map = with_faces(&[(disc(Vec3::new(96.0, 80.0, 40.0), 60.0, 64), Vec3::Z)]);
    assert_eq!(map.faces.last().unwrap().edge_count, 64);
    let light = hold("64 vertices", &map, OPEN);
    assert!(brightest(&light, map.faces.len() - 1) > 1.0);
}

#[test]
fn faces_without_area_are_unlit_and_named_and_change_nothing_else() {
    let plain = hold("plain room", &room().build(Format::Bsp2), CLOSED);
    let at = Vec3::new(64.0, 64.0, 32.0);
    let line: Vec<Vec3> = (0..4).map(|i| at + Vec3::X * i as f32).collect();
    let map = with_faces(&[(vec![at; 4], Vec3::Z), (line, Vec3::Z), (vec![at, at], Vec3::Z)]);
    let light = hold("faces without area", &map, CLOSED);
    let named = light.scene.warnings.iter().any(|w| w.contains("without area"));
    assert!(named, "{:?}", light.scene.warnings);
    for (face, before) in plain.faces.iter().enumerate() {
        let levels = |f: &qrad::lightmap::FinishedFace| {
            f.styles.iter().map(|s| s.levels.clone()).collect::<Vec<_>>()
        };
        assert_eq!(levels(before), levels(&light.faces[face]), "face {face}");
    }
    let last = map.faces.len() - 3;
    assert!(light.faces[last..].iter().all(|f| f.styles.is_empty()));
}

#[test]
fn colinear_vertices_change_no_level() {
    let rectangle = carpet(Vec3::new(64.0, 48.0, 32.0), [64.0, 48.0]);
    let mut dotted = Vec::new();
    for (i, &a) in rectangle.iter().enumerate() {
        let b = rectangle[(i + 1) % 4];
        dotted.extend((0..4).map(|k| a.lerp(b, k as f32 / 4.0)));
    }
    let levels = |vertices: Vec<Vec3>| {
        let map = with_faces(&[(vertices, Vec3::Z)]);
        let light = hold("colinear vertices", &map, OPEN);
        light.faces.last().unwrap().styles[0].levels.clone()
    };
    assert_eq!(levels(rectangle), levels(dotted));
}

#[test]
fn sliver_faces_1_to_1000_and_1_to_100000_keep_every_invariant() {
    for width in [0.1, 0.001] {
        let carpets = |k: usize| {
            let low = Vec3::new(40.0 + width * k as f32, 30.0, 20.0);
            (carpet(low, [width, 100.0]), Vec3::Z)
        };
        let faces: Vec<_> = (0..10).map(carpets).collect();
        hold(&format!("slivers {width} wide"), &with_faces(&faces), OPEN);
    }
}

#[test]
fn touching_crossing_and_coincident_faces_keep_every_invariant() {
    let flat = |z: f32| (carpet(Vec3::new(40.0, 40.0, z), [80.0, 64.0]), Vec3::Z);
    // Twice in one place, on the floor itself, and one that leans through both.
    let slope =
        [[40.0, 40.0, 16.0], [40.0, 104.0, 16.0], [120.0, 104.0, 48.0], [120.0, 40.0, 48.0]];
    let normal = Vec3::new(-0.4, 0.0, 1.0).normalize();
    let slope = (slope.map(Vec3::from).to_vec(), normal);
    // Two faces in one place both get light, and only one of them is seen to send it on.
    let expect = Expect { energy: 0.06, asymmetry: 0.06, ..OPEN };
    hold("odd faces", &with_faces(&[flat(32.0), flat(32.0), flat(0.0), slope]), expect);
}

#[test]
fn a_sky_only_map_keeps_every_invariant_and_has_no_lightmap() {
    let suns = [("_sunlight", "200"), ("_sunlight2", "100"), ("_sun_mangle", "30 -60 0")];
    let map = MapBuilder::room([0.0; 3], [192.0; 3])
        .solid_texture("sky1", 8)
        .flags(1)
        .entities(entity("worldspawn", &suns))
        .build(Format::Bsp29);
    let light = hold("sky only", &map, OPEN);
    assert!(light.faces.iter().all(|f| f.styles.is_empty()));
}

#[test]
fn a_room_whose_textures_are_all_transparent_keeps_every_invariant() {
    let map = MapBuilder::room([0.0; 3], [192.0; 3])
        .solid_texture("{fence", 255)
        .pillar([64.0, 64.0, 0.0], [96.0, 96.0, 64.0], 0)
        .model([120.0, 120.0, 0.0], [140.0, 140.0, 64.0], Some(0))
        .entities(
            light("96 30 100", "200") + &entity("func_wall", &[("model", "*1"), ("_shadow", "1")]),
        )
        .build(Format::Bsp29);
    hold("all transparent", &map, OPEN);
}

#[test]
fn a_leaky_map_keeps_every_invariant() {
    // The ceiling is missing and a second light is outside.
    let mut map = room().build(Format::Bsp29);
    let ceiling = (0..map.faces.len()).find(|&f| map.face_plane(f).normal == -Vec3::Z).unwrap();
    map.faces.remove(ceiling);
    for mark in &mut map.marksurfaces {
        *mark = (*mark).min(map.faces.len() as u32 - 1);
    }
    map.models[0].face_count -= 1;
    map.entities = [
        light("96 80 60", "200").as_bytes(),
        entity("light", &[("origin", "96 80 400")]).as_bytes(),
        b"\0",
    ]
    .concat();
    hold("leaky", &map.assemble().unwrap(), OPEN);
}

#[test]
fn back_faces_in_view_keep_every_invariant() {
    let lamp = (carpet(Vec3::new(60.0, 60.0, 110.0), [64.0, 48.0]), Vec3::Z);
    let light = hold("back faces", &with_faces(&[lamp]), OPEN);
    assert!(brightest(&light, light.faces.len() - 1) > 0.0);
}

#[test]
fn t_junctions_keep_every_invariant_and_rows_sum_to_one() {
    // Walls cut into squares whose corners do not meet those of their neighbours' pillar.
    let map = room()
        .subdivide(40.0)
        .pillar([50.0, 50.0, 0.0], [70.0, 90.0, 128.0], 1)
        .build(Format::Bsp29);
    hold("T-junctions", &map, CLOSED);
}

#[test]
fn off_grid_brushes_keep_every_invariant_and_rows_sum_to_one() {
    let map = MapBuilder::room([-0.37, 0.21, -17.43], [191.83, 159.71, 110.57])
        .solid_texture("wall", 8)
        .pillar([33.33, 41.17, -17.43], [61.91, 77.77, 40.123], 0)
        .pillar([100.01, 60.49, 3.3], [130.77, 99.93, 50.55], 0)
        .entities(light("80 20 90", "200"))
        .build(Format::Bsp29);
    hold("off grid", &map, CLOSED);
}

#[test]
fn a_slit_one_unit_wide_keeps_every_invariant_and_is_no_black_gap() {
    let map = MapBuilder::room([0.0; 3], [193.0, 160.0, 128.0])
        .solid_texture("wall", 8)
        .pillar([0.0, 70.0, 0.0], [96.0, 90.0, 128.0], 0)
        .pillar([97.0, 70.0, 0.0], [193.0, 90.0, 128.0], 0)
        .entities(light("96.5 30 64", "300"))
        .build(Format::Bsp29);
    // Eyes in the slit see its other side half a unit away: cells are few and large there.
    let light = hold("slit", &map, Expect { energy: 0.03, asymmetry: 0.08, ..CLOSED });
    // The far room is lit by what comes through, and darker than the near one.
    let far = light.scene.surfaces.iter().position(|s| s.normal == -Vec3::Y && s.dist == -160.0);
    let near = light.scene.surfaces.iter().position(|s| s.normal == Vec3::Y && s.dist == 0.0);
    let (far, near) = (brightest(&light, far.unwrap()), brightest(&light, near.unwrap()));
    assert!(far > 0.0 && far < near, "{far} behind the slit, {near} before it");
}

#[test]
fn faces_in_another_order_have_the_same_light() {
    let map = tiny();
    let mut turned = map.clone();
    let count = map.models[0].face_count as usize;
    turned.faces[..count].reverse();
    for mark in turned.marksurfaces.iter_mut().filter(|m| (**m as usize) < count) {
        *mark = count as u32 - 1 - *mark;
    }
    let turned = hold("turned", &turned.assemble().unwrap(), OPEN);
    let plain = hold("plain", &map, OPEN);
    let (mut off, mut all) = (0.0, 0.0);
    for face in 0..count {
        let other = &turned.faces[count - 1 - face].styles;
        assert_eq!(plain.faces[face].styles.len(), other.len(), "face {face}");
        for (a, b) in plain.faces[face].styles.iter().zip(other) {
            off += a
                .light
                .iter()
                .zip(&b.light)
                .map(|(a, b)| (*a - *b).abs().element_sum())
                .sum::<f32>();
            all += a.light.iter().map(|l| l.element_sum()).sum::<f32>();
        }
    }
    println!("the order of faces changes {:.5} of the light", off / all);
    assert!(off <= 0.01 * all);
}

fn tiny() -> Bsp {
    room().pillar([50.0, 50.0, 0.0], [70.0, 90.0, 64.0], 1).build(Format::Bsp29)
}
