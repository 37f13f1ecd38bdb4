//! The triangles of a scene in a tree with four children a node, four triangles tested at a time in
//! single precision. It finds what a ray may meet, quickly; [`super::shadow::meet`] then decides in
//! double precision where rounding could matter.

use super::packet::{NOTHING, Packet, WideRay};
use super::shaft::Shaft;
use super::tracer::Node;
use glam::Vec3;
use wide::{CmpLe, f32x4};

/// The tree.
#[derive(Default)]
pub(super) struct WideTree {
    nodes: Vec<WideNode>,
    packets: Vec<Packet>,
    root: Option<Child>,
    /// The run of packets that each polygon is in.
    homes: Vec<Child>,
}

/// Boxes of up to four children; those of absent children are empty.
struct WideNode {
    min: [f32x4; 3],
    max: [f32x4; 3],
    children: [Child; 4],
}

/// An inner node (no packets) or a run of packets.
#[derive(Clone, Copy, Default)]
pub(super) struct Child {
    first: u32,
    packets: u32,
}

impl WideTree {
    /// Makes the tree from one of two children a node; `polygon(slot)` tells the corners and the
    /// index of the polygon in a slot of its leafs.
    pub fn new<'p>(nodes: &[Node], polygon: impl Fn(u32) -> (&'p [Vec3], u32)) -> Self {
        let mut tree = Self::default();
        if nodes.is_empty() {
            return tree;
        }
        let triangles = triangles_under(nodes, &polygon);
        let mut open = Vec::new();
        tree.root = Some(tree.child(nodes, 0, &triangles, &polygon, &mut open));
        while let Some((node, place)) = open.pop() {
            let mut group = vec![node];
            while let Some(at) = widest(nodes, &triangles, &group) {
                let first = nodes[group[at] as usize].first;
                group[at] = first;
                group.push(first + 1);
            }
            let mut wide = WideNode {
                min: [f32x4::splat(f32::INFINITY); 3],
                max: [f32x4::splat(f32::NEG_INFINITY); 3],
                children: [Child::default(); 4],
            };
            for (lane, &node) in group.iter().enumerate() {
                let n = &nodes[node as usize];
                for axis in 0..3 {
                    wide.min[axis].as_array_mut()[lane] = n.min[axis] - margin(n.min[axis]);
                    wide.max[axis].as_array_mut()[lane] = n.max[axis] + margin(n.max[axis]);
                }
                wide.children[lane] = tree.child(nodes, node, &triangles, &polygon, &mut open);
            }
            tree.nodes[place as usize] = wide;
        }
        tree
    }

    /// The child that stands for a node: its packets, or a place for an inner node that is put on
    /// the list of those to be filled.
    fn child<'p>(
        &mut self,
        nodes: &[Node],
        node: u32,
        triangles: &[u32],
        polygon: &impl Fn(u32) -> (&'p [Vec3], u32),
        open: &mut Vec<(u32, u32)>,
    ) -> Child {
        if !is_leaf(nodes, triangles, node) {
            let place = self.nodes.len() as u32;
            self.nodes.push(WideNode {
                min: [f32x4::ZERO; 3],
                max: [f32x4::ZERO; 3],
                children: [Child::default(); 4],
            });
            open.push((node, place));
            return Child { first: place, packets: 0 };
        }
        let mut all = Vec::new();
        let mut below = vec![node];
        while let Some(node) = below.pop() {
            let n = &nodes[node as usize];
            if n.count == 0 {
                below.extend([n.first, n.first + 1]);
            }
            for slot in n.first..n.first + n.count {
                let (v, index) = polygon(slot);
                all.extend((2..v.len()).map(|i| ([v[0], v[i - 1], v[i]], index)));
            }
        }
        let first = self.packets.len() as u32;
        self.packets.extend(all.chunks(4).map(Packet::new));
        let child = Child { first, packets: self.packets.len() as u32 - first };
        for &(_, polygon) in &all {
            let polygon = polygon as usize;
            if self.homes.len() <= polygon {
                self.homes.resize(polygon + 1, Child::default());
            }
            self.homes[polygon] = child;
        }
        child
    }

    /// Calls `visit(polygon, surely)` for the polygons that the ray `start + t way` may meet with
    /// 0 < t <= `limit`, the nearer parts of the tree first. `surely` tells that the ray meets the
    /// polygon well inside one of its triangles. `visit` returns the limit from then on.
    /// No polygon that the ray meets up to there is left out; each is shown once. `stack` is room to
    /// work in.
    #[inline(always)] // `Narrow::walk` alone calls it.
    pub fn walk(
        &self,
        start: Vec3,
        way: Vec3,
        mut limit: f32,
        stack: &mut Vec<(f32, Child)>,
        mut visit: impl FnMut(u32, bool) -> f32,
    ) {
        let ray = WideRay::new(start, way);
        stack.clear();
        stack.extend(self.root.map(|root| (0.0, root)));
        while let Some((entry, child)) = stack.pop() {
            if entry > limit {
                continue;
            }
            if child.packets == 0 {
                self.nodes[child.first as usize].push_met(&ray, limit, stack);
                continue;
            }
            let first = child.first as usize;
            let mut shown = NOTHING;
            for packet in &self.packets[first..first + child.packets as usize] {
                packet.show(&ray, &mut limit, &mut shown, &mut visit);
            }
        }
    }

    /// A polygon at or beside `polygon` that passes `wanted` and that the ray surely meets inside
    /// with 0 < t <= `limit`.
    pub fn met_beside(
        &self,
        polygon: u32,
        (start, way): (Vec3, Vec3),
        limit: f32,
        wanted: impl Fn(u32) -> bool,
    ) -> Option<u32> {
        let home = self.homes.get(polygon as usize)?;
        let ray = WideRay::new(start, way);
        let first = home.first as usize;
        self.packets[first..first + home.packets as usize].iter().find_map(|packet| {
            let (_, sure) = packet.meet(&ray, limit);
            let met = |&lane: &usize| sure >> lane & 1 == 1 && wanted(packet.polygons[lane]);
            (0..4).find(met).map(|lane| packet.polygons[lane])
        })
    }

    /// Calls `visit` for the packets in boxes that the shaft may reach into, until it says false or
    /// `work` nodes and packets are seen. Whether that was all.
    pub fn gather<'t>(
        &'t self,
        shaft: &Shaft,
        open: &mut Vec<Child>,
        mut work: usize,
        mut visit: impl FnMut(&'t Packet) -> bool,
    ) -> bool {
        open.clear();
        open.extend(self.root);
        while let Some(child) = open.pop() {
            let first = child.first as usize;
            let Some(left) = work.checked_sub(child.packets.max(1) as usize) else { return false };
            work = left;
            if child.packets > 0 {
                for packet in &self.packets[first..first + child.packets as usize] {
                    if !visit(packet) {
                        return false;
                    }
                }
                continue;
            }
            let node = &self.nodes[first];
            let mut met = shaft.meets_boxes(&node.min, &node.max);
            while met != 0 {
                open.push(node.children[met.trailing_zeros() as usize]);
                met &= met - 1;
            }
        }
        true
    }
}

/// Number of triangles in the leafs under each node.
fn triangles_under<'p>(nodes: &[Node], polygon: &impl Fn(u32) -> (&'p [Vec3], u32)) -> Vec<u32> {
    let mut order = Vec::with_capacity(nodes.len());
    let mut open = vec![0_u32];
    while let Some(node) = open.pop() {
        order.push(node);
        let n = &nodes[node as usize];
        if n.count == 0 {
            open.extend([n.first, n.first + 1]);
        }
    }
    let mut triangles = vec![0_u32; nodes.len()];
    for &node in order.iter().rev() {
        let n = &nodes[node as usize];
        triangles[node as usize] = if n.count == 0 {
            triangles[n.first as usize] + triangles[n.first as usize + 1]
        } else {
            (n.first..n.first + n.count).map(|slot| polygon(slot).0.len() as u32 - 2).sum()
        };
    }
    triangles
}

/// By how much boxes are widened at a coordinate: more than the rounding of their tests.
fn margin(coordinate: f32) -> f32 {
    1.0 / 64.0 + 8.0 * f32::EPSILON * coordinate.abs()
}

/// Whether a node becomes a run of packets: where four triangles or fewer are under it.
fn is_leaf(nodes: &[Node], triangles: &[u32], node: u32) -> bool {
    nodes[node as usize].count > 0 || triangles[node as usize] <= 4
}

/// The member with the largest box among the inner nodes of a group that may still grow.
fn widest(nodes: &[Node], triangles: &[u32], group: &[u32]) -> Option<usize> {
    if group.len() == 4 {
        return None;
    }
    let area = |at: usize| {
        let n = &nodes[group[at] as usize];
        let d = n.max - n.min;
        d.x * d.y + d.y * d.z + d.z * d.x
    };
    (0..group.len())
        .filter(|&at| !is_leaf(nodes, triangles, group[at]))
        .max_by(|&a, &b| area(a).total_cmp(&area(b)))
}

impl WideNode {
    /// Puts the children that the ray meets before `limit` on the stack, the nearest on top.
    fn push_met(&self, ray: &WideRay, limit: f32, stack: &mut Vec<(f32, Child)>) {
        let (mut entry, mut exit) = (f32x4::ZERO, f32x4::splat(limit));
        for axis in 0..3 {
            let (near, far) = if ray.backwards[axis] {
                (self.max[axis], self.min[axis])
            } else {
                (self.min[axis], self.max[axis])
            };
            entry = entry.fast_max((near - ray.start[axis]) * ray.inverse[axis]);
            exit = exit.fast_min((far - ray.start[axis]) * ray.inverse[axis]);
        }
        let mut met = entry.cmp_le(exit).move_mask() as u32;
        let entries = entry.to_array();
        let bottom = stack.len();
        while met != 0 {
            let lane = met.trailing_zeros() as usize;
            met &= met - 1;
            let mut at = stack.len();
            stack.push((entries[lane], self.children[lane]));
            while at > bottom && stack[at - 1].0 < stack[at].0 {
                stack.swap(at - 1, at);
                at -= 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::shadow::{Contact, meet};
    use super::super::tracer::{Polygon, Tracer};
    use super::*;
    use proptest::prelude::*;

    fn place() -> impl Strategy<Value = Vec3> {
        // Whole numbers, so that rays meet edges and run along planes.
        [-40_i16..40, -40_i16..40, -40_i16..40].prop_map(|p| Vec3::from(p.map(f32::from)))
    }

    /// Triangles and parallelograms, some of no area.
    fn polygon() -> impl Strategy<Value = Polygon> {
        (place(), place(), place(), any::<bool>()).prop_map(|(a, b, c, four)| {
            let mut vertices = vec![a, b, c];
            if four {
                vertices.push(a + c - b);
            }
            Polygon { normal: (c - a).cross(b - a).normalize_or(Vec3::Z), vertices }
        })
    }

    proptest! {
        #[test]
        fn nothing_that_a_ray_meets_is_left_out(
            polygons in prop::collection::vec(polygon(), 1..60),
            rays in prop::collection::vec((place(), place(), 0.1_f32..1.0), 20),
            far in prop_oneof![Just(Vec3::ZERO), Just(Vec3::new(30000.0, -20000.0, 9000.0))],
        ) {
            let moved = polygons.into_iter().map(|mut p| {
                p.vertices.iter_mut().for_each(|v| *v += far);
                p
            });
            let tracer = Tracer::new(moved.collect());
            for (from, to, limit) in rays {
                let (start, way) = (from + far, to - from);
                let mut shown = Vec::new();
                tracer.wide().walk(start, way, limit, &mut Vec::new(), |polygon, surely| {
                    shown.push((polygon, surely));
                    limit
                });
                for (index, polygon) in tracer.polygons().iter().enumerate() {
                    let (contact, t) = meet(&polygon.vertices, start.as_dvec3(), way.as_dvec3());
                    let times: Vec<_> = shown.iter().filter(|s| s.0 == index as u32).collect();
                    prop_assert!(times.len() <= 1, "polygon {index} is shown {} times", times.len());
                    if contact != Contact::None && t <= f64::from(limit) {
                        prop_assert!(!times.is_empty(), "{contact:?} with {index} at {t} is missed");
                    }
                    if times.first().is_some_and(|s| s.1) {
                        prop_assert!(contact == Contact::Inside && t <= f64::from(limit));
                    }
                }
            }
        }
    }
}
