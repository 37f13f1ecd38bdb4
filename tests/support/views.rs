//! Real geometry to look at: a map's opaque faces in a tracer, and points on them.

use glam::Vec3;
use qrad::bsp::Bsp;
use qrad::radiosity::hemicube::View;
use qrad::scene::{Polygon, Tracer};
use std::path::Path;

/// The world faces of the map at `path`, and a hemicube view one unit above about `count` of them.
pub fn bsp_views(path: &Path, count: usize) -> (Tracer, Vec<View>) {
    let bsp = Bsp::read(&std::fs::read(path).unwrap()).unwrap();
    let world = bsp.models[0];
    let (mut polygons, mut views) = (Vec::new(), Vec::new());
    let step = (world.face_count as usize / count).max(1);
    for face in (world.first_face..world.first_face + world.face_count).map(|f| f as usize) {
        if bsp.texture_of(face).is_some_and(|t| t.name.starts_with(['*', '{'])) {
            continue;
        }
        let vertices: Vec<Vec3> = bsp.face_vertices(face).collect();
        let normal = bsp.face_plane(face).normal;
        let sky = bsp.texture_of(face).is_some_and(|t| t.name.starts_with("sky"));
        if face % step == 0 && !sky {
            let middle = vertices.iter().sum::<Vec3>() / vertices.len() as f32;
            views.push(View::turned(middle + normal, normal, face as u64));
        }
        polygons.push(Polygon { vertices, normal });
    }
    (Tracer::new(polygons), views)
}
