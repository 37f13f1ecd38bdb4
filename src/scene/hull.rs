//! The solid leafs of a brush model's hull 0 as convex bodies: how a model without faces, built from
//! `skip` alone, casts its shadow (contract section 7.2).

use super::tracer::Polygon;
use crate::bsp::{Bsp, Model};
use glam::Vec3;

/// How far points may lie beyond a plane that they are clipped with, in world units.
const ON_PLANE: f32 = 0.1;
/// The deepest tree, and the most polygons, of one model.
const DEPTH_LIMIT: usize = 512;
const POLYGON_LIMIT: usize = 1 << 16;
/// Contents of a solid leaf.
const SOLID: i32 = -2;

/// A plane whose front side is outside of the body.
type Side = (Vec3, f32);

/// Faces of the solid leafs of a model, in its own coordinates; `None` if its tree is too large.
pub(crate) fn polygons(bsp: &Bsp, model: &Model) -> Option<Vec<Polygon>> {
    let mut polygons = Vec::new();
    let mut open: Vec<(i32, Vec<Side>)> = vec![(model.head_node, Vec::new())];
    // A tree has at most two children a node; what goes on for longer is no tree.
    let mut steps = 2 * bsp.nodes.len() + 2;
    while let Some((node, sides)) = open.pop() {
        steps = steps.checked_sub(1)?;
        if sides.len() > DEPTH_LIMIT || polygons.len() > POLYGON_LIMIT {
            return None;
        }
        let Ok(index) = usize::try_from(node) else {
            let leaf = bsp.leafs.get(!node as usize);
            if leaf.is_some_and(|l| l.contents == SOLID) {
                add_body(model, &sides, &mut polygons);
            }
            continue;
        };
        let node = bsp.nodes.get(index)?;
        let plane = bsp.planes.get(node.plane as usize)?;
        let with = |side: Side| sides.iter().copied().chain([side]).collect();
        // The front child lies before the plane, so the plane's back is outside of it.
        open.push((node.children[0], with((-plane.normal, -plane.dist))));
        open.push((node.children[1], with((plane.normal, plane.dist))));
    }
    Some(polygons)
}

/// Adds the faces of the body between planes.
fn add_body(model: &Model, sides: &[Side], polygons: &mut Vec<Polygon>) {
    for (i, &(normal, dist)) in sides.iter().enumerate() {
        let mut vertices = square(model, normal, dist);
        for (j, &other) in sides.iter().enumerate() {
            let same = other.0 == normal && other.1 == dist;
            if i != j && !same {
                vertices = clip(&vertices, other);
            }
        }
        if vertices.len() >= 3 && vertices.iter().all(|v| v.is_finite()) {
            polygons.push(Polygon { vertices, normal });
        }
    }
}

/// A square of the plane that holds all of the model.
fn square(model: &Model, normal: Vec3, dist: f32) -> Vec<Vec3> {
    let middle = (model.mins + model.maxs) * 0.5;
    let centre = middle - normal * (normal.dot(middle) - dist);
    let (u, v) = normal.any_orthonormal_pair();
    let reach = (model.maxs - model.mins).length() + 64.0;
    [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
        .map(|(a, b)| centre + (u * a + v * b) * reach)
        .to_vec()
}

/// The part of a polygon behind a plane.
fn clip(polygon: &[Vec3], (normal, dist): Side) -> Vec<Vec3> {
    let height = |p: Vec3| normal.dot(p) - dist;
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (ha, hb) = (height(a), height(b));
        if ha <= ON_PLANE {
            kept.push(a);
        }
        if ha > ON_PLANE && hb < -ON_PLANE || ha < -ON_PLANE && hb > ON_PLANE {
            kept.push(a + (b - a) * (ha / (ha - hb)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsp::{Format, Leaf, Node, Plane};

    /// A box from -8 to 8 cut by six planes, and a tree that loops.
    fn cube() -> (Bsp, Model) {
        let mut bsp = Bsp::empty(Format::Bsp29);
        let leaf = |contents| Leaf { contents, vis_offset: -1, first_mark: 0, mark_count: 0 };
        bsp.leafs = vec![leaf(SOLID), leaf(-1)];
        for i in 0..6 {
            let (axis, high) = (i / 2, i % 2 == 1);
            let dist = if high { 8.0 } else { -8.0 };
            bsp.planes.push(Plane { normal: Vec3::AXES[axis], dist, kind: axis as i32 });
            let next = if i == 5 { -1 } else { i as i32 + 1 };
            let children = if high { [-2, next] } else { [next, -2] };
            bsp.nodes.push(Node { plane: i as u32, children });
        }
        let (mins, maxs) = (Vec3::splat(-8.0), Vec3::splat(8.0));
        let (vis_leafs, first_face, face_count, head_node) = (0, 0, 0, 0);
        (bsp, Model { mins, maxs, head_node, vis_leafs, first_face, face_count })
    }

    #[test]
    fn a_solid_leaf_becomes_its_faces_looking_out() {
        let (bsp, model) = cube();
        let faces = polygons(&bsp, &model).unwrap();
        assert_eq!(faces.len(), 6);
        for face in faces {
            assert_eq!(face.vertices.len(), 4);
            assert!(face.vertices.iter().all(|v| (v.abs() - 8.0).abs().max_element() < 1e-4));
            assert!(face.vertices.iter().all(|v| (v.dot(face.normal) - 8.0).abs() < 1e-4));
        }
    }

    #[test]
    fn trees_that_loop_end() {
        let (mut bsp, model) = cube();
        bsp.nodes[5].children = [0, 0];
        assert!(polygons(&bsp, &model).is_none());
    }
}
