//! The polygons of a scene in a bounding volume hierarchy. The only file that uses `obvhs`.

use super::pieces::Pieces;
use super::walls::Walls;
use super::wide_tree::WideTree;
use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ray::{Ray, RayHit};
use std::sync::OnceLock;
use std::time::Duration;

/// How the hierarchy is built. Moving every node once to where it costs least, instead of one in twenty,
/// takes some milliseconds more and saves a tenth of each hemicube, as do slightly larger leafs.
const BUILD: BvhBuildParams = BvhBuildParams {
    reinsertion_batch_ratio: 1.0,
    collapse_traversal_cost: 5.0,
    ..BvhBuildParams::medium_build()
};

/// A flat convex polygon that blocks light.
#[derive(Clone, Debug)]
pub struct Polygon {
    /// Corner points in order.
    pub vertices: Vec<Vec3>,
    /// Unit normal of its front.
    pub normal: Vec3,
}

/// Where a ray met a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the polygon, as given to [`Tracer::new`].
    pub polygon: u32,
    /// Distance from the ray's origin, in lengths of its direction.
    pub distance: f32,
}

/// A node of the hierarchy, as [`Tracer::nodes`] shows it.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Bounding box.
    pub min: Vec3,
    /// Number of polygons; 0 marks an inner node.
    pub count: u32,
    /// Bounding box.
    pub max: Vec3,
    /// Inner node: its children are `first` and `first + 1`. Leaf: its polygons are those in the
    /// slots `first..first + count`, see [`Tracer::polygon`].
    pub first: u32,
}

/// Polygons and the hierarchy over them.
pub struct Tracer {
    polygons: Vec<Polygon>,
    bvh: Bvh2,
    nodes: Vec<Node>,
    /// Corner points of all polygons, in the order of the hierarchy's leafs.
    corners: Vec<Vec3>,
    /// Where the corners of a slot end.
    ends: Vec<u32>,
    /// Normal of each slot's polygon.
    normals: Vec<Vec3>,
    wide: WideTree,
    /// So many polygons, the first ones, have solid space behind them.
    solid: u32,
    /// Made when a hemicube is drawn first.
    pieces: OnceLock<Pieces>,
    /// Made when a wall is looked for first.
    walls: OnceLock<Walls>,
}

impl Tracer {
    /// Builds the hierarchy. Polygons need three vertices and finite coordinates.
    pub fn new(polygons: Vec<Polygon>) -> Self {
        let boxes: Vec<Aabb> = polygons
            .iter()
            .map(|p| {
                let mut b = Aabb::empty();
                for v in &p.vertices {
                    b.extend((*v).into());
                }
                b
            })
            .collect();
        let bvh = if boxes.is_empty() {
            Bvh2::default()
        } else {
            build_bvh2(&boxes, BUILD, &mut Duration::default())
        };
        let nodes = bvh
            .nodes
            .iter()
            .map(|n| Node {
                min: n.aabb().min.into(),
                count: n.prim_count,
                max: n.aabb().max.into(),
                first: n.first_index,
            })
            .collect();
        let (mut corners, mut ends, mut normals) = (Vec::new(), Vec::new(), Vec::new());
        for &i in &bvh.primitive_indices {
            let polygon = &polygons[i as usize];
            corners.extend_from_slice(&polygon.vertices);
            ends.push(corners.len() as u32);
            normals.push(polygon.normal);
        }
        let mut tracer = Self {
            polygons,
            bvh,
            nodes,
            corners,
            ends,
            normals,
            wide: WideTree::default(),
            solid: 0,
            pieces: OnceLock::new(),
            walls: OnceLock::new(),
        };
        tracer.wide = WideTree::new(&tracer.nodes, |slot| {
            let (corners, _, polygon) = tracer.polygon(slot);
            (corners, polygon)
        });
        tracer
    }

    /// Tells that the first `count` polygons have solid space behind them, as those of brushes do, so that
    /// hardly anything sees their backs. Hemicubes are drawn faster then.
    pub fn on_solid(mut self, count: usize) -> Self {
        self.solid = count as u32;
        self.pieces = OnceLock::new();
        self
    }

    /// Whether a polygon has solid space behind it.
    pub(super) fn is_on_solid(&self, polygon: u32) -> bool {
        polygon < self.solid
    }

    /// The polygons, in the order given.
    pub fn polygons(&self) -> &[Polygon] {
        &self.polygons
    }

    /// The nodes; the root is node 0. Empty for an empty scene.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The same hierarchy for shadow rays.
    pub(super) fn wide(&self) -> &WideTree {
        &self.wide
    }

    /// The polygons for hemicubes.
    pub fn pieces(&self) -> &Pieces {
        self.pieces.get_or_init(|| Pieces::new(self))
    }

    /// How the polygons are joined.
    pub(super) fn walls(&self) -> &Walls {
        self.walls.get_or_init(|| Walls::new(&self.polygons))
    }

    /// Corner points, normal and index of the polygon in a leaf's slot.
    pub fn polygon(&self, slot: u32) -> (&[Vec3], Vec3, u32) {
        let slot = slot as usize;
        let from = if slot == 0 { 0 } else { self.ends[slot - 1] };
        let corners = &self.corners[from as usize..self.ends[slot] as usize];
        (corners, self.normals[slot], self.bvh.primitive_indices[slot])
    }

    /// The nearest polygon along `origin + t direction`, 0 < t < `limit`.
    pub fn first_hit(&self, origin: Vec3, direction: Vec3, limit: f32) -> Option<Hit> {
        if self.nodes.is_empty() {
            return None;
        }
        let ray = Ray::new(origin.into(), direction.into(), 0.0, limit);
        let mut hit = RayHit::none();
        self.bvh.ray_traverse(ray, &mut hit, |_, slot| self.intersect(slot, origin, direction));
        (hit.t < limit).then(|| Hit {
            polygon: self.bvh.primitive_indices[hit.primitive_id as usize],
            distance: hit.t,
        })
    }

    /// Distance to the polygon in `slot` of the hierarchy, infinite for a miss or t <= 0.
    /// Two-sided Möller-Trumbore on the fan around the first vertex.
    fn intersect(&self, slot: usize, origin: Vec3, direction: Vec3) -> f32 {
        let (v, _, _) = self.polygon(slot as u32);
        (2..v.len())
            .map(|i| triangle(v[0], v[i - 1], v[i], origin, direction))
            .fold(f32::INFINITY, f32::min)
    }
}

/// Möller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997), both sides.
fn triangle(a: Vec3, b: Vec3, c: Vec3, origin: Vec3, direction: Vec3) -> f32 {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let det = ab.dot(p);
    if det == 0.0 {
        return f32::INFINITY;
    }
    let inv = 1.0 / det;
    let from_a = origin - a;
    let u = from_a.dot(p) * inv;
    let q = from_a.cross(ab);
    let v = direction.dot(q) * inv;
    let t = ac.dot(q) * inv;
    if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 { t } else { f32::INFINITY }
}
