//! The `FACENORMALS` lump, taken apart by a reader of its own.

mod support;

use glam::Vec3;
use qrad::bsp::Bsp;
use support::lit_levels::texinfo;
use support::lit_room::entity;
use support::map_builder::MapBuilder;
use support::program::run;
use support::written::{lump, on_disk, read, words};

/// Quick to light.
const OPTIONS: [&str; 3] = ["--bounces", "0", "--wrnormals"];

/// A block in the middle of a room, with faces that meet at 90 degrees.
fn map(world: &[(&str, &str)]) -> MapBuilder {
    MapBuilder::room([-128.0, -128.0, 0.0], [128.0, 128.0, 256.0])
        .solid_texture("wall", 8)
        .solid_texture("block", 8)
        .pillar([-32.0, -32.0, 64.0], [32.0, 32.0, 128.0], 1)
        .entities(
            entity("worldspawn", world)
                + &entity("light", &[("origin", "0 0 200"), ("light", "300")]),
        )
}

/// Lights a map whose faces of a texture have a smoothing angle. Returns the map and normal, tangent
/// and bitangent at every corner of every face.
fn frames(map: &MapBuilder, smooth: &str) -> (Bsp, Vec<Vec<[Vec3; 3]>>) {
    let (_folder, path) = on_disk(map);
    let keys = texinfo(&read(&path), |name| (name == smooth).then_some(r#"{"phong_angle": 91}"#));
    std::fs::write(path.with_extension("texinfo.json"), keys).unwrap();
    run(&path, &OPTIONS);
    let bsp = read(&path);
    let data = words(lump(&bsp, "FACENORMALS").unwrap());
    let count = data[0] as usize;
    let vector = |i: u32| {
        assert!((i as usize) < count);
        Vec3::from([0, 1, 2].map(|k| f32::from_bits(data[1 + 3 * i as usize + k])))
    };
    let all: Vec<Vec3> = (0..count as u32).map(vector).collect();
    assert!(all.iter().enumerate().all(|(i, v)| !all[..i].contains(v)), "vectors are unique");
    let mut corners = data[1 + 3 * count..].chunks_exact(3);
    let mut face = |face| {
        let corner = |_| {
            let indices = corners.next().expect("three indices a corner");
            [0, 1, 2].map(|k| vector(indices[k]))
        };
        bsp.face_vertices(face).map(corner).collect()
    };
    let frames = (0..bsp.faces.len()).map(&mut face).collect();
    assert!(corners.next().is_none());
    (bsp, frames)
}

fn is_flat(bsp: &Bsp, face: usize, frames: &[[Vec3; 3]]) -> bool {
    frames.iter().all(|[normal, ..]| *normal == bsp.face_plane(face).normal)
}

#[test]
fn flat_faces_have_the_normals_of_their_planes_and_run_with_their_textures() {
    let (bsp, faces) = frames(&map(&[]), "");
    assert_eq!(faces.len(), 12);
    for (face, corners) in faces.iter().enumerate() {
        assert!(is_flat(&bsp, face, corners), "face {face}");
        let axes = bsp.texinfo_of(face).unwrap();
        for [_, tangent, bitangent] in corners {
            // The textures of the map run within its faces.
            assert_eq!([*tangent, *bitangent], [axes.s.truncate(), -axes.t.truncate()]);
        }
    }
}

#[test]
fn smooth_corners_have_the_mean_of_their_faces() {
    let (bsp, faces) = frames(&map(&[]), "block");
    let mut smooth = 0;
    for (face, corners) in faces.iter().enumerate() {
        if bsp.texture_of(face).unwrap().name == "wall" {
            assert!(is_flat(&bsp, face, corners));
            continue;
        }
        let axes = bsp.texinfo_of(face).unwrap();
        for ([normal, tangent, bitangent], vertex) in corners.iter().zip(bsp.face_vertices(face)) {
            let diagonal = (vertex - Vec3::Z * 96.0).normalize();
            assert!((*normal - diagonal).length() < 1e-5, "{vertex} {normal}");
            // Across the normal, and as near to the texture's axes as that allows.
            for (got, axis) in [(tangent, axes.s.truncate()), (bitangent, -axes.t.truncate())] {
                assert!((got.length() - 1.0).abs() < 1e-5 && got.dot(*normal).abs() < 1e-5);
                assert!((got.dot(axis) - (2.0_f32 / 3.0).sqrt()).abs() < 1e-5, "{got}");
            }
            smooth += 1;
        }
    }
    assert_eq!(smooth, 24);
}

#[test]
fn a_world_without_smoothing_is_flat_and_old_lumps_go() {
    let (bsp, faces) = frames(&map(&[("_phong", "0")]), "block");
    assert!(faces.iter().enumerate().all(|(face, corners)| is_flat(&bsp, face, corners)));
    let (_folder, path) = on_disk(&map(&[]));
    run(&path, &OPTIONS);
    assert!(lump(&read(&path), "FACENORMALS").is_some());
    run(&path, &["--bounces", "0"]);
    assert!(read(&path).bspx.is_empty());
}
