//! Damaged BSP files: every byte that is cut off, every field of header and records, every index. Each
//! gives an error that names the place, or a map that can be lit; never a panic.

mod support;

use glam::Vec3;
use qrad::bsp::{Bsp, Format};
use support::attacks;
use support::map_builder::MapBuilder;
use support::tiny;

const FORMATS: [Format; 3] = [Format::Bsp29, Format::Bsp2, Format::TwoPsb];
/// Names of the lumps in the order of the header's table.
const LUMPS: [&str; 15] = [
    "entities",
    "planes",
    "textures",
    "vertices",
    "visibility",
    "nodes",
    "texinfo",
    "faces",
    "lighting",
    "clipnodes",
    "leafs",
    "marksurfaces",
    "edges",
    "surfedges",
    "models",
];
const HEADER: usize = 4 + 8 * 15;

fn word(file: &[u8], at: usize) -> i32 {
    i32::from_le_bytes(file[at..at + 4].try_into().unwrap())
}

fn set(file: &mut [u8], at: usize, value: u32) {
    file[at..at + 4].copy_from_slice(&value.to_le_bytes());
}

/// Offset and length of a lump.
fn lump(file: &[u8], index: usize) -> (usize, usize) {
    (word(file, 4 + 8 * index) as usize, word(file, 8 + 8 * index) as usize)
}

fn message(file: &[u8]) -> String {
    Bsp::read(file).expect_err("a damaged file").to_string()
}

#[test]
fn files_cut_anywhere_before_the_end_of_the_last_lump_are_refused() {
    for format in FORMATS {
        let file = tiny::map(format).write().unwrap();
        let end = (0..15).map(|i| lump(&file, i)).map(|(o, l)| o + l).max().unwrap();
        for length in 0..end {
            let line = message(&file[..length]);
            assert!(
                line.contains("lump") || line.contains("header"),
                "{format:?} {length}: {line}"
            );
        }
        // BSPX is an extension: engines go without it, and so does this.
        for length in end..file.len() {
            attacks::bsp(&file[..length]);
        }
    }
}

#[test]
fn every_header_field_out_of_range_is_refused_with_the_name_of_its_lump() {
    for format in FORMATS {
        let file = tiny::map(format).write().unwrap();
        for (index, name) in LUMPS.iter().enumerate() {
            let (offset, length) = lump(&file, index);
            if length == 0 {
                continue;
            }
            let past = file.len() as u32 + 1;
            for (field, values) in [
                (4 + 8 * index, [u32::MAX, 1 << 31, i32::MAX as u32, past, past - 1]),
                (8 + 8 * index, [u32::MAX, 1 << 31, i32::MAX as u32, past, past - offset as u32]),
            ] {
                for value in values {
                    let mut bad = file.clone();
                    set(&mut bad, field, value);
                    let line = message(&bad);
                    assert!(line.contains(name), "{name} {value:#x}: {line}");
                }
            }
        }
    }
}

#[test]
fn lumps_that_overlap_each_other_or_the_header_are_refused() {
    let file = tiny::map(Format::Bsp29).write().unwrap();
    for (index, name) in LUMPS.iter().enumerate() {
        let (offset, length) = lump(&file, index);
        if length == 0 {
            continue;
        }
        for start in [0, HEADER - 1, offset - 1] {
            let mut bad = file.clone();
            set(&mut bad, 4 + 8 * index, start as u32);
            let line = message(&bad);
            assert!(line.contains("lump"), "{name} at {start}: {line}");
        }
        for other in (0..15).filter(|&o| o != index) {
            let (offset, length) = lump(&file, other);
            let mut bad = file.clone();
            set(&mut bad, 4 + 8 * index, offset as u32);
            set(&mut bad, 8 + 8 * index, length as u32);
            assert!(length == 0 || Bsp::read(&bad).is_err(), "{name} over {other}");
        }
    }
}

#[test]
fn every_ident_but_quake_s_is_refused() {
    let file = tiny::map(Format::Bsp29).write().unwrap();
    for value in (0..64).chain([u32::MAX, 1 << 31, 0x1D00, 0x1D00_0000]).filter(|&v| v != 29) {
        let mut bad = file.clone();
        set(&mut bad, 0, value);
        assert!(message(&bad).contains("BSP"), "{value}");
    }
}

/// A room with nothing in it but a light.
fn small(format: Format) -> Bsp {
    MapBuilder::room([0.0; 3], [64.0; 3])
        .solid_texture("wall", 8)
        .entities("{\n\"classname\" \"worldspawn\"\n}\n{\n\"classname\" \"light\"\n\"origin\" \"32 32 32\"\n}\n")
        .build(format)
}

#[test]
fn every_field_of_every_record_may_hold_anything() {
    const VALUES: [u32; 8] = [
        u32::MAX,
        i32::MAX as u32,
        1 << 31,
        0x7FFF_7FFF,
        0x7FC0_0000, // NaN
        0x7F80_0000, // infinite
        0xFF7F_FFFF, // the least finite number
        0x0001_0001,
    ];
    for format in FORMATS {
        let file = small(format).write().unwrap();
        for at in (HEADER..file.len() - 3).step_by(4) {
            for value in VALUES {
                let mut bad = file.clone();
                set(&mut bad, at, value);
                attacks::bsp(&bad);
                attacks::light(&bad);
            }
        }
    }
}

#[test]
fn every_byte_of_a_map_with_everything_may_be_flipped() {
    let file = tiny::map(Format::Bsp29).write().unwrap();
    for at in (HEADER..file.len()).step_by(3) {
        let mut bad = file.clone();
        bad[at] ^= 1 << (at % 8);
        attacks::bsp(&bad);
        if at % 4 == 0 {
            attacks::light(&bad);
        }
    }
}

/// The map with a change to its records is refused with all of `words`.
#[track_caller]
fn refused(change: impl Fn(&mut Bsp), words: &[&str]) {
    for format in FORMATS {
        let mut map = tiny::map(format);
        change(&mut map);
        let line = map.assemble().expect_err("a damaged map").to_string();
        for word in words {
            assert!(line.contains(word), "{word:?} is not in {line}");
        }
    }
}

#[test]
fn indices_out_of_range_are_refused_with_lump_and_record() {
    refused(|m| m.faces[3].plane = 9999, &["faces lump", "record 3", "plane is 9999"]);
    refused(|m| m.faces[4].first_edge = 9999, &["faces lump", "record 4", "surfedges"]);
    refused(|m| m.faces[5].edge_count = 60000, &["faces lump", "record 5", "surfedges"]);
    refused(|m| m.edges[2] = [0, 9999], &["edges lump", "record 2", "vertex is 9999"]);
    refused(|m| m.surfedges[7] = -9999, &["surfedges lump", "record 7", "edge is 9999"]);
    refused(|m| m.surfedges[7] = i32::MIN, &["surfedges lump", "record 7"]);
    refused(|m| m.marksurfaces[1] = 9999, &["marksurfaces lump", "record 1", "face is 9999"]);
    refused(|m| m.leafs[2].first_mark = 9999, &["leafs lump", "marksurfaces 9999"]);
    refused(|m| m.nodes[1].plane = 9999, &["nodes lump", "record 1", "plane is 9999"]);
    refused(|m| m.nodes[1].children[0] = 9999, &["nodes lump", "record 1", "node is 9999"]);
    refused(|m| m.nodes[1].children[1] = -9999, &["nodes lump", "record 1", "leaf is 9998"]);
    refused(|m| m.models[1].head_node = 9999, &["models lump", "record 1", "node is 9999"]);
    refused(|m| m.models[1].first_face = 9999, &["models lump", "record 1", "faces 9999"]);
    refused(|m| m.models[1].face_count = 9999, &["models lump", "record 1", "faces"]);
    refused(|m| m.models[0].vis_leafs = 9999, &["models lump", "record 0", "9999"]);
    refused(|m| m.models.clear(), &["models lump", "empty"]);
}

#[test]
fn numbers_that_are_not_finite_are_refused_with_lump_and_record() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        refused(|m| m.vertices[5].y = bad, &["vertices lump", "vertex 5"]);
        refused(|m| m.planes[2].normal.z = bad, &["planes lump", "plane 2"]);
        refused(|m| m.planes[2].dist = bad, &["planes lump", "plane 2"]);
    }
}

#[test]
fn loops_and_shared_branches_of_the_node_tree_are_refused() {
    refused(|m| m.nodes[3].children[0] = 3, &["nodes lump"]);
    refused(|m| m.nodes[3].children[0] = 0, &["nodes lump"]);
    refused(|m| m.nodes[3].children = m.nodes[2].children, &["nodes lump", "already has a parent"]);
}

#[test]
fn a_chain_of_nodes_deeper_than_any_map_is_refused() {
    let mut map = tiny::map(Format::Bsp2);
    let first = map.nodes.len() as i32;
    for i in 0..5000 {
        let mut node = map.nodes[0];
        node.children = [first + i + 1, -1];
        map.nodes.push(node);
    }
    map.nodes.last_mut().unwrap().children[0] = -1;
    let line = map.assemble().unwrap_err().to_string();
    assert!(line.contains("depth of the node tree"), "{line}");
}

#[test]
fn faces_that_share_all_surfedges_are_refused_before_they_eat_memory() {
    let mut map = tiny::map(Format::Bsp2);
    let all = map.surfedges.len() as u32;
    for face in &mut map.faces {
        (face.first_edge, face.edge_count) = (0, all);
    }
    let line = map.assemble().unwrap_err().to_string();
    assert!(line.contains("shared again and again"), "{line}");
}

#[test]
fn lightmaps_outside_the_lighting_lump_are_refused_with_the_face() {
    refused(
        |m| {
            m.lighting = vec![7; 100];
            (m.faces[2].styles, m.faces[2].light_offset) = ([0, 255, 255, 255], 100);
        },
        &["faces lump, record 2", "lightmap is at 100 of 100"],
    );
}

#[test]
fn texture_axes_and_models_out_of_bounds_leave_faces_unlit_or_are_lit() {
    for bad in [f32::NAN, f32::INFINITY, 1e30, 1e-30, 0.0, f32::MAX, -f32::MAX] {
        let mut map = tiny::map(Format::Bsp2);
        map.texinfos[0].s = glam::Vec4::new(bad, 0.0, 0.0, 0.0);
        map.texinfos[1].t.w = bad;
        map.models[1].mins = Vec3::splat(bad);
        attacks::light(&map.assemble().unwrap().write().unwrap());
    }
    for bad in [f32::MAX, -f32::MAX, 1e20, 1e6] {
        for vertex in [0, 9] {
            let mut map = tiny::map(Format::Bsp2);
            map.vertices[vertex].x = bad;
            attacks::light(&map.assemble().unwrap().write().unwrap());
        }
    }
}
