//! Where a luxel outside its face takes its light: it hops to joined faces or snaps to the edge
//! (contract section 2.4, "wander").

use super::exact::{distance, length};
use super::neighbours::Neighbours;
use super::phong::Smoothing;
use super::shape::{LuxelMap, POINT_EQ, Shape, fraction_along, inward_plane};
use glam::Vec3;

/// Hops from face to face before a point must snap.
const HOP_LIMIT: u32 = 3;

/// A point in the space of the brush model of its face, one unit above the face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placed {
    pub position: Vec3,
    pub normal: Vec3,
    /// The point can receive no light.
    pub occluded: bool,
}

/// Everything that placement looks at.
pub(crate) struct Wanderer<'a, F> {
    /// Shape of every face.
    pub shapes: &'a [Shape],
    /// How faces join.
    pub neighbours: &'a Neighbours,
    /// Smoothed normals, if the face that the sample belongs to is curved.
    pub smoothing: Option<&'a Smoothing>,
    /// Luxels of the face that the sample belongs to.
    pub luxels: &'a LuxelMap,
    /// Whether a point in the space of a brush model is in solid.
    pub in_solid: F,
}

impl<F: Fn(u32, Vec3) -> bool> Wanderer<'_, F> {
    /// Places the sample that wants to be at `p`, near face `face`.
    pub fn place(&self, face: usize, p: Vec3) -> Placed {
        self.place_from(face, p, 0)
    }

    fn place_from(&self, face: usize, p: Vec3, hops: u32) -> Placed {
        let shape = &self.shapes[face];
        let occluded = |position| Placed { position, normal: shape.normal, occluded: true };
        if shape.edges.is_empty() {
            return occluded(p);
        }
        let q = shape.lift(p);
        if shape.surrounds(q) {
            return self.accept(face, q);
        }
        if hops < HOP_LIMIT {
            let neighbour = nearest_edge(shape, q).and_then(|e| self.neighbours.across(face, e));
            if let Some(neighbour) = neighbour {
                return self.place_from(neighbour as usize, q, hops + 1);
            }
        }
        let snapped = shape.nearest_on_boundary(q);
        let moved = self.luxels.luxel_of(q) - self.luxels.luxel_of(snapped);
        let moved = (moved.x * moved.x + moved.y * moved.y).sqrt();
        if moved <= 1.0 { self.accept(face, snapped + shape.normal) } else { occluded(q) }
    }

    /// Takes a point over the face, or one of eight points around it, if it is not in solid.
    fn accept(&self, face: usize, p: Vec3) -> Placed {
        let shape = &self.shapes[face];
        let flat = Placed { position: p, normal: shape.normal, occluded: true };
        let height = distance(p, shape.normal, shape.dist);
        let fits = (height - 1.0).abs() <= 0.1 && shape.surrounds(p);
        let Some(model) = shape.model.filter(|_| fits) else { return flat };
        let normal = match self.smoothing {
            None => Some(shape.normal),
            Some(smoothing) => smoothing.normal_at(face, shape, p),
        };
        let Some(normal) = normal else { return flat };
        let at = |position, occluded| Placed { position, normal, occluded };
        if !(self.in_solid)(model, p) {
            return at(p, false);
        }
        let ends = [-0.5, 0.5];
        for x in ends {
            for y in ends {
                for z in ends {
                    let corner = p + Vec3::new(x, y, z);
                    if !(self.in_solid)(model, corner) {
                        return at(corner, false);
                    }
                }
            }
        }
        at(p, true)
    }
}

/// The edge that `q` lies behind, preferring one that it lies beside; the first of equals.
fn nearest_edge(shape: &Shape, q: Vec3) -> Option<usize> {
    let mut best = None;
    for i in 0..shape.vertices.len() {
        let (a, b) = shape.edge(i);
        let Some((normal, dist)) = inward_plane(a, b, shape.normal) else { continue };
        if distance(q, normal, dist) >= POINT_EQ {
            continue;
        }
        let f = fraction_along(a, b, q);
        // The contract's penalty past the end is f, not f - 1, times the length.
        let penalty = if (0.0..=1.0).contains(&f) { 0.0 } else { f.abs() * length(b - a) };
        if best.is_none_or(|(least, _)| penalty < least) {
            best = Some((penalty, i));
        }
    }
    best.map(|(_, i)| i)
}
