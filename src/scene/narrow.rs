//! The few triangles that the rays of a shaft may meet, so that each ray needs no walk through the
//! tree. Which answer a ray gets does not depend on it.

use super::packet::{NOTHING, Packet, WideRay};
use super::shaft::Shaft;
use super::wide_tree::{Child, WideTree};
use glam::Vec3;

/// How much a shaft may hold and cost.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    /// Triangles in it.
    pub triangles: usize,
    /// Nodes and packets of the tree that are looked at.
    pub steps: usize,
}

/// Where rays look for what they meet: everywhere or, while all of them run in one shaft, there.
#[derive(Default)]
pub(super) struct Narrow {
    on: bool,
    packets: Vec<Packet>,
    /// Triangles in `packets`.
    count: usize,
    open: Vec<Child>,
}

impl Narrow {
    /// From now on rays run anywhere.
    pub fn leave(&mut self) {
        self.on = false;
    }

    /// Whether rays run in a shaft.
    pub fn is_on(&self) -> bool {
        self.on
    }

    /// Whether the rays of the shaft meet nothing.
    pub fn is_empty(&self) -> bool {
        self.on && self.count == 0
    }

    /// From now on all rays run in `shaft`, and look in `tree` for polygons that pass `wanted`.
    /// Unless that leaves more triangles, or takes more steps, than `limits` say: then rays run
    /// anywhere, and the answer is false.
    pub fn enter(
        &mut self,
        tree: &WideTree,
        shaft: &Shaft,
        limits: Limits,
        wanted: impl Fn(u32) -> bool,
    ) -> bool {
        self.clear();
        let mut open = std::mem::take(&mut self.open);
        self.on = tree.gather(shaft, &mut open, limits.steps, |packet| {
            self.add(packet, shaft, &wanted);
            self.count <= limits.triangles
        });
        self.open = open;
        self.on
    }

    /// From now on all rays run in `shaft`, which is part of that of `wider`.
    pub fn enter_part(&mut self, wider: &Self, shaft: &Shaft) {
        self.clear();
        for packet in &wider.packets {
            self.add(packet, shaft, |_| true);
        }
        self.on = true;
    }

    fn clear(&mut self) {
        self.packets.clear();
        self.count = 0;
    }

    fn add(&mut self, packet: &Packet, shaft: &Shaft, wanted: impl Fn(u32) -> bool) {
        let mut met = shaft.meets(packet);
        while met != 0 {
            let lane = met.trailing_zeros() as usize;
            met &= met - 1;
            if !wanted(packet.polygons[lane]) {
                continue;
            }
            if self.count % 4 == 0 {
                self.packets.push(Packet::new(&[]));
            }
            let last = self.packets.len() - 1;
            self.packets[last].copy_lane(self.count % 4, packet, lane);
            self.count += 1;
        }
    }

    /// As [`WideTree::walk`], in the shaft if rays run in one, and there in no order.
    pub fn walk(
        &self,
        tree: &WideTree,
        (start, way): (Vec3, Vec3),
        mut limit: f32,
        stack: &mut Vec<(f32, Child)>,
        mut visit: impl FnMut(u32, bool) -> f32,
    ) {
        if !self.on {
            tree.walk(start, way, limit, stack, visit);
            return;
        }
        if self.count == 0 {
            return;
        }
        let ray = WideRay::new(start, way);
        let mut shown = NOTHING;
        for packet in &self.packets {
            packet.show(&ray, &mut limit, &mut shown, &mut visit);
            if limit < 0.0 {
                return;
            }
        }
    }
}
