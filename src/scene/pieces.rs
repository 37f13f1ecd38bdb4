//! Polygons as hemicubes draw them: in pieces of at most eight corners, which lie in lanes.

use super::tracer::{Node, Tracer};
use glam::Vec3;
use std::ops::Range;
use wide::{f32x4, f32x8};

/// The most corners of a piece.
const LANES: usize = 8;
/// The most corners of a small one.
const FEW: u16 = 4;

/// A convex part of a polygon.
#[derive(Clone, Debug)]
pub struct Piece<V> {
    /// Coordinates of the corners, in order; the last corner is repeated.
    pub corners: [V; 3],
    /// A point of the polygon's plane.
    pub on: Vec3,
    /// Unit normal of its front.
    pub normal: Vec3,
    /// A point inside of it.
    pub middle: Vec3,
    /// Square of the distance from there to the farthest corner.
    pub radius_squared: f32,
    /// Index of the polygon, as given to [`Tracer::new`].
    pub polygon: u32,
    /// Number of corners, at least 3.
    pub count: u16,
    /// Whether there is solid space behind it.
    pub on_solid: bool,
}

/// The hierarchy of a [`Tracer`] with pieces in its leafs.
#[derive(Default)]
pub struct Pieces {
    nodes: Vec<Node>,
    /// Where the small and the large pieces of each leaf are.
    leafs: Vec<[Range<usize>; 2]>,
    small: Vec<Piece<f32x4>>,
    large: Vec<Piece<f32x8>>,
}

impl Pieces {
    /// The pieces of all polygons of `tracer`.
    pub(super) fn new(tracer: &Tracer) -> Self {
        let mut pieces = Self { nodes: tracer.nodes().to_vec(), ..Self::default() };
        for k in 0..pieces.nodes.len() {
            let Node { first, count, .. } = pieces.nodes[k];
            if count == 0 {
                continue;
            }
            let from = [pieces.small.len(), pieces.large.len()];
            for slot in first..first + count {
                let (corners, normal, polygon) = tracer.polygon(slot);
                let on_solid = tracer.is_on_solid(polygon);
                pieces.cut(corners, (normal, on_solid), polygon);
            }
            pieces.nodes[k].first = pieces.leafs.len() as u32;
            let end = [pieces.small.len(), pieces.large.len()];
            pieces.leafs.push([from[0]..end[0], from[1]..end[1]]);
        }
        pieces
    }

    /// The nodes; the root is node 0. Empty for an empty scene.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The pieces in a leaf: places of [`small`](Self::small) and of [`large`](Self::large) ones.
    pub fn of(&self, leaf: &Node) -> &[Range<usize>; 2] {
        &self.leafs[leaf.first as usize]
    }

    /// All pieces of up to four corners.
    pub fn small(&self) -> &[Piece<f32x4>] {
        &self.small
    }

    /// All pieces of more.
    pub fn large(&self) -> &[Piece<f32x8>] {
        &self.large
    }

    /// Appends the pieces of a polygon, a fan around its first corner.
    fn cut(&mut self, corners: &[Vec3], (normal, on_solid): (Vec3, bool), polygon: u32) {
        let on = corners[0];
        let mut from = 1;
        while from + 1 < corners.len() {
            let rim = &corners[from..(from + LANES - 1).min(corners.len())];
            let corner = |lane: usize| match lane {
                0 => on,
                _ => rim[(lane - 1).min(rim.len() - 1)],
            };
            let count = rim.len() as u16 + 1;
            let middle = (on + rim[0] + rim[1]) / 3.0;
            let distances = rim.iter().chain([&on]).map(|c| c.distance_squared(middle));
            let radius_squared = distances.fold(0.0, f32::max);
            macro_rules! piece {
                ($lanes:ident) => {{
                    let along = |k| $lanes::new(std::array::from_fn(|lane| corner(lane)[k]));
                    let corners = [along(0), along(1), along(2)];
                    Piece { corners, on, normal, middle, radius_squared, polygon, count, on_solid }
                }};
            }
            if count <= FEW {
                self.small.push(piece!(f32x4));
            } else {
                self.large.push(piece!(f32x8));
            }
            from += rim.len() - 1;
        }
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
            let mut add = |piece: [&[f32]; 3], real: u16| {
                let [x, y, z] = piece;
                let corners: Vec<Vec3> =
                    (0..x.len()).map(|k| Vec3::new(x[k], y[k], z[k])).collect();
                let (real, padding) = corners.split_at(real as usize);
                assert!(real.len() >= 3 && padding.iter().all(|p| p == &real[real.len() - 1]));
                assert!(area(real) > 0.0);
                sum += area(real);
            };
            let [small, large] = pieces.of(&pieces.nodes()[0]).clone();
            for piece in &pieces.small()[small] {
                add([0, 1, 2].map(|k| &piece.corners[k].as_array_ref()[..]), piece.count);
            }
            for piece in &pieces.large()[large] {
                assert!(piece.count > FEW);
                add([0, 1, 2].map(|k| &piece.corners[k].as_array_ref()[..]), piece.count);
            }
            assert!((sum - whole).abs() < 1e-5 * whole, "{count} corners: {sum} of {whole}");
        }
    }
}
