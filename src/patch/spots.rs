//! Points spread over the faces whose light varies within patches.

use super::{PatchGrid, PatchId};
use crate::scene::{LuxelGrid, Surface};
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;

/// Points along each axis of a luxel interval at which what varies is looked up.
const ACROSS: u32 = 8;

/// Points spread evenly over a face, by luxel interval, row by row: in luxel coordinates. Intervals
/// outside the face, by less than those points tell, have their middle.
pub(super) struct Spots(Vec<Vec<Vec2>>);

impl Spots {
    /// Those of a surface.
    pub fn of(surface: &Surface, luxels: &LuxelGrid) -> Self {
        let outline: Vec<Vec2> = surface.vertices.iter().map(|&v| luxels.luxel_of(v)).collect();
        let columns = luxels.width.saturating_sub(1);
        let count = columns * luxels.height.saturating_sub(1);
        let at = |k: u32| (k as f32 + 0.5) / ACROSS as f32;
        let of = |k: u32| {
            let corner = Vec2::new((k % columns) as f32, (k / columns) as f32);
            let all =
                (0..ACROSS * ACROSS).map(|i| corner + Vec2::new(at(i % ACROSS), at(i / ACROSS)));
            let inside: Vec<Vec2> = all.filter(|&p| holds(&outline, p)).collect();
            if inside.is_empty() { vec![corner + 0.5] } else { inside }
        };
        Self((0..count).map(of).collect())
    }

    /// World points of each interval.
    pub fn of_intervals<'a>(
        &'a self,
        luxels: &'a LuxelGrid,
    ) -> impl Iterator<Item = impl Iterator<Item = Vec3> + 'a> {
        self.0.iter().map(|points| points.iter().map(|&p| luxels.world_of(p)))
    }

    /// World points of each patch of the face that has any.
    pub fn of_patches(&self, luxels: &LuxelGrid, grid: &PatchGrid) -> BTreeMap<PatchId, Vec<Vec3>> {
        let mut found = BTreeMap::<PatchId, Vec<Vec3>>::new();
        for p in self.0.iter().flatten() {
            found.entry(grid.at(p.x, p.y)).or_default().push(luxels.world_of(*p));
        }
        found
    }
}

/// Whether a convex polygon holds a point.
fn holds(outline: &[Vec2], p: Vec2) -> bool {
    let next = outline.iter().cycle().skip(1);
    let (mut low, mut high) = (0.0f32, 0.0f32);
    for (&a, &b) in outline.iter().zip(next) {
        let side = (b - a).perp_dot(p - a);
        low = low.min(side);
        high = high.max(side);
    }
    low == 0.0 || high == 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_hold_points_whichever_way_round() {
        let mut outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]].map(Vec2::from).to_vec();
        for _ in 0..2 {
            assert!(holds(&outline, Vec2::new(1.5, 0.5)));
            assert!(
                !holds(&outline, Vec2::new(2.5, 0.5)) && !holds(&outline, Vec2::new(1.5, -0.1))
            );
            outline.reverse();
        }
    }
}
