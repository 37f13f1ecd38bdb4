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
            if self.count.is_multiple_of(4) {
                self.packets.push(Packet::new(&[]));
            }
            let last = self.packets.len() - 1;
            self.packets[last].copy_lane(self.count % 4, packet, lane);
            self.count += 1;
        }
    }

    /// As [`WideTree::walk`], in the shaft if rays run in one, and there in no order.
    #[inline(never)] // Whether callers take it in would change with what else they do.
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

#[cfg(test)]
mod tests {
    use super::super::shadow::{Contact, meet};
    use super::super::shaft::Floor;
    use super::super::tracer::{Polygon, Tracer};
    use super::super::umbra::Bounds;
    use super::*;
    use proptest::prelude::*;

    const ALL: Limits = Limits { triangles: usize::MAX, steps: usize::MAX };

    fn place(size: i16) -> impl Strategy<Value = Vec3> {
        // Whole numbers, so that rays meet edges and run along planes.
        prop::array::uniform3(-size..size).prop_map(|p| Vec3::from(p.map(f32::from)))
    }

    /// Triangles and parallelograms, some of no area.
    fn polygon() -> impl Strategy<Value = Polygon> {
        (place(40), place(12), place(12), any::<bool>()).prop_map(|(a, ab, ac, four)| {
            let mut vertices = vec![a, a + ab, a + ac];
            if four {
                vertices = vec![a, a + ab, a + ab + ac, a + ac];
            }
            Polygon { normal: ac.cross(ab).normalize_or(Vec3::Z), vertices }
        })
    }

    /// A few points near each other, sometimes all one.
    fn points() -> impl Strategy<Value = Vec<Vec3>> {
        (place(40), prop::collection::vec(place(9), 1..5))
            .prop_map(|(middle, around)| around.into_iter().map(|p| middle + p).collect())
    }

    /// What a ray is shown.
    fn shown(narrow: &Narrow, tracer: &Tracer, start: Vec3, way: Vec3) -> Vec<u32> {
        let mut shown = Vec::new();
        narrow.walk(tracer.wide(), (start, way), 1.0, &mut Vec::new(), |polygon, _| {
            shown.push(polygon);
            1.0
        });
        shown
    }

    proptest! {
        #[test]
        fn shafts_leave_out_nothing_that_their_rays_meet(
            polygons in prop::collection::vec(polygon(), 1..60),
            starts in points(),
            ends in points(),
            axis in 0..3_usize,
            far in prop_oneof![
                Just((Vec3::ZERO, 1.0)),
                Just((Vec3::new(30000.0, -20000.0, 9000.0), 1.0)),
                Just((Vec3::ZERO, 20000.0)),
            ],
        ) {
            let (place, length) = far;
            let moved = polygons.into_iter().map(|mut p| {
                p.vertices.iter_mut().for_each(|v| *v += place);
                p
            });
            let tracer = Tracer::new(moved.collect());
            let starts: Vec<Vec3> = starts.into_iter().map(|p| p + place).collect();
            let ends: Vec<Vec3> = ends.into_iter().map(|p| p * length + place).collect();
            let around = |points: &[Vec3]| Bounds::around(points.iter().copied()).unwrap();
            let lowest = |points: &[Vec3]| {
                points.iter().map(|p| f64::from(p[axis])).fold(f64::INFINITY, f64::min)
            };
            let floor = Floor {
                normal: Vec3::AXES[axis],
                least: lowest(&starts).min(lowest(&ends)),
            };
            let (mut narrow, mut part) = (Narrow::default(), Narrow::default());
            let shaft = Shaft::new(&around(&starts), &around(&ends), Some(floor));
            prop_assert!(narrow.enter(tracer.wide(), &shaft, ALL, |_| true));
            for &end in &ends {
                let shaft = Shaft::new(&around(&starts), &around(&[end]), None);
                part.enter_part(&narrow, &shaft);
                for &start in &starts {
                    let way = end - start;
                    for shown in [&narrow, &part].map(|n| shown(n, &tracer, start, way)) {
                        for (index, polygon) in tracer.polygons().iter().enumerate() {
                            let (v, index) = (&polygon.vertices, index as u32);
                            let met = meet(v, start.as_dvec3(), way.as_dvec3()).0;
                            let times = shown.iter().filter(|&&s| s == index).count();
                            prop_assert!(times <= 1, "polygon {index} is shown {times} times");
                            prop_assert!(
                                times == 1 || met == Contact::None,
                                "{met:?} with {index} is missed from {start} to {end}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn shafts_hold_only_what_is_between_their_ends() {
        // Squares across x at 0, 10, ..., 90, and one beside each.
        let square = |x: f32, y: f32| Polygon {
            vertices: [(-2.0, -2.0), (-2.0, 2.0), (2.0, 2.0), (2.0, -2.0)]
                .map(|(s, t)| Vec3::new(x, y + s, t))
                .to_vec(),
            normal: Vec3::X,
        };
        let polygons = (0..10_u8).flat_map(|i| {
            let x = 10.0 * f32::from(i);
            [square(x, 0.0), square(x, 9.0)]
        });
        let tracer = Tracer::new(polygons.collect());
        let around = |x: f32| {
            Bounds::around([Vec3::new(x, -1.0, -1.0), Vec3::new(x, 1.0, 1.0)].into_iter()).unwrap()
        };
        let mut narrow = Narrow::default();
        let shaft = Shaft::new(&around(15.0), &around(45.0), None);
        assert!(narrow.enter(tracer.wide(), &shaft, ALL, |_| true));
        assert_eq!(narrow.count, 6, "two triangles at 20, 30 and 40");
        let few = Limits { triangles: 5, ..ALL };
        assert!(!narrow.enter(tracer.wide(), &shaft, few, |_| true) && !narrow.is_on());
        let short = Limits { steps: 2, ..ALL };
        assert!(!narrow.enter(tracer.wide(), &shaft, short, |_| true) && !narrow.is_on());
        let shaft = Shaft::new(&around(11.0), &around(19.0), None);
        assert!(narrow.enter(tracer.wide(), &shaft, ALL, |_| true) && narrow.is_empty());
    }
}
