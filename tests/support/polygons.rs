//! Faces of any shape, added to a map that is there.

use glam::{Vec3, Vec4};
use qrad::bsp::{Bsp, Face, Plane, TexInfo};

/// Adds a face to the last model, which is to own the last faces: `vertices` clockwise seen from its
/// front, of a plane whose front `normal` looks to, with texture `miptex`.
pub fn add_face(map: &mut Bsp, vertices: &[Vec3], normal: Vec3, miptex: i32) {
    let dist = vertices.first().map_or(0.0, |v| v.dot(normal));
    map.planes.push(Plane { normal, dist, kind: 3 });
    let largest = normal.abs();
    let (s, t) = if largest.z >= largest.x.max(largest.y) {
        (Vec4::X, -Vec4::Y)
    } else if largest.x >= largest.y {
        (Vec4::Y, -Vec4::Z)
    } else {
        (Vec4::X, -Vec4::Z)
    };
    map.texinfos.push(TexInfo { s, t, miptex, flags: 0 });
    let first_vertex = map.vertices.len() as u32;
    map.vertices.extend(vertices);
    let first_edge = map.surfedges.len() as u32;
    let count = vertices.len() as u32;
    for i in 0..count {
        map.surfedges.push(map.edges.len() as i32);
        map.edges.push([first_vertex + i, first_vertex + (i + 1) % count]);
    }
    map.faces.push(Face {
        plane: map.planes.len() as u32 - 1,
        side: 0,
        first_edge,
        edge_count: count,
        texinfo: map.texinfos.len() as i32 - 1,
        styles: [255; 4],
        light_offset: -1,
    });
    map.models.last_mut().unwrap().face_count += 1;
}

/// A regular polygon that looks up, clockwise seen from above.
pub fn disc(middle: Vec3, radius: f32, corners: usize) -> Vec<Vec3> {
    let angle = |i: usize| -std::f32::consts::TAU * i as f32 / corners as f32;
    (0..corners).map(|i| middle + Vec3::new(angle(i).cos(), angle(i).sin(), 0.0) * radius).collect()
}

/// A rectangle that looks up, clockwise seen from above.
pub fn carpet(low: Vec3, size: [f32; 2]) -> Vec<Vec3> {
    let [x, y] = size;
    [[0.0, 0.0], [0.0, y], [x, y], [x, 0.0]].map(|[x, y]| low + Vec3::new(x, y, 0.0)).to_vec()
}
