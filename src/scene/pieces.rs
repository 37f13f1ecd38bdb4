//! Polygons as hemicubes draw them: in pieces of at most eight corners, which lie in lanes.

use super::tracer::{Node, Tracer};
use glam::Vec3;
use wide::f32x8;

/// The most corners of a piece.
const LANES: usize = 8;

/// A convex part of a polygon.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Coordinates of the corners, in order; the last corner is repeated.
    pub corners: [f32x8; 3],
    /// A point of the polygon's plane.
    pub on: Vec3,
    /// Unit normal of its front.
    pub normal: Vec3,
    /// Index of the polygon, as given to [`Tracer::new`].
    pub polygon: u32,
    /// Number of corners, 3 to 8.
    pub count: u32,
}

/// The hierarchy of a [`Tracer`] with pieces in its leafs.
pub struct Pieces {
    nodes: Vec<Node>,
    pieces: Vec<Piece>,
}

impl Pieces {
    /// The pieces of all polygons of `tracer`.
    pub(super) fn new(tracer: &Tracer) -> Self {
        let mut pieces = Vec::with_capacity(tracer.polygons().len());
        let mut nodes = tracer.nodes().to_vec();
        for node in nodes.iter_mut().filter(|node| node.count > 0) {
            let first = pieces.len() as u32;
            for slot in node.first..node.first + node.count {
                let (corners, normal, polygon) = tracer.polygon(slot);
                cut(corners, normal, polygon, &mut pieces);
            }
            (node.first, node.count) = (first, pieces.len() as u32 - first);
        }
        Self { nodes, pieces }
    }

    /// The nodes; the root is node 0. Empty for an empty scene.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The pieces in a leaf.
    pub fn of(&self, leaf: &Node) -> &[Piece] {
        &self.pieces[leaf.first as usize..(leaf.first + leaf.count) as usize]
    }
}

/// Appends the pieces of a polygon, a fan around its first corner.
fn cut(corners: &[Vec3], normal: Vec3, polygon: u32, pieces: &mut Vec<Piece>) {
    let mut from = 1;
    while from + 1 < corners.len() {
        let rim = &corners[from..(from + LANES - 1).min(corners.len())];
        let corner = |lane: usize| match lane {
            0 => corners[0],
            _ => rim[(lane - 1).min(rim.len() - 1)],
        };
        let along = |k: usize| f32x8::new(std::array::from_fn(|lane| corner(lane)[k]));
        pieces.push(Piece {
            corners: [along(0), along(1), along(2)],
            on: corners[0],
            normal,
            polygon,
            count: rim.len() as u32 + 1,
        });
        from += rim.len() - 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Polygon;

    #[test]
    fn pieces_cover_their_polygon() {
        for count in 3..40 {
            let corner = |k: usize| {
                let (sin, cos) = (k as f32 / count as f32 * std::f32::consts::TAU).sin_cos();
                Vec3::new(cos, sin, 0.5)
            };
            let vertices: Vec<Vec3> = (0..count).map(corner).collect();
            let area = |corners: &[Vec3]| -> f32 {
                let fan = corners.windows(2).map(|w| (w[0] - corners[0]).cross(w[1] - corners[0]));
                fan.map(|cross| 0.5 * cross.z).sum()
            };
            let whole = area(&vertices);
            let tracer = Tracer::new(vec![Polygon { vertices, normal: Vec3::Z }]);
            let pieces = tracer.pieces();
            assert_eq!(pieces.nodes().len(), 1);
            let mut sum = 0.0;
            for piece in pieces.of(&pieces.nodes()[0]) {
                let [x, y, z] = piece.corners.map(f32x8::to_array);
                assert!((3..=8).contains(&piece.count) && piece.polygon == 0);
                let corners: Vec<Vec3> = (0..8).map(|k| Vec3::new(x[k], y[k], z[k])).collect();
                let (real, padding) = corners.split_at(piece.count as usize);
                assert!(padding.iter().all(|p| p == &real[real.len() - 1]));
                assert!(area(real) > 0.0);
                sum += area(real);
            }
            assert!((sum - whole).abs() < 1e-5 * whole, "{count} corners: {sum} of {whole}");
        }
    }
}
