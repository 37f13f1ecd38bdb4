//! Whether a point is inside solid: descent through hull 0 of the brush models (contract 2.6).

use super::exact::dot64;
use super::umbra::Bounds;
use crate::bsp::Bsp;
use glam::{DVec3, Vec3};

/// Planes nearer than this do not decide: a point so close to one is solid if either side is.
const NEAR_PLANE: f64 = 0.1;
/// By how much a box is widened, for what rounding may do to its points.
const BOX_SLACK: f64 = 1.0 / 128.0;
/// Splits and leafs looked at for one box.
const MOST_BOX_STEPS: usize = 256;

struct Split {
    normal: DVec3,
    dist: f64,
    /// The axis of an axial plane.
    axis: Option<usize>,
    /// Child `c >= 0` is a split, `c < 0` is leaf `-1 - c`; front first.
    children: [i32; 2],
}

impl Split {
    fn distance(&self, p: DVec3) -> f64 {
        match self.axis {
            Some(axis) => p[axis] - self.dist,
            None => dot64(p, self.normal) - self.dist,
        }
    }
}

/// The solid space of every brush model.
pub struct Solid {
    splits: Vec<Split>,
    leaf_solid: Vec<bool>,
    heads: Vec<i32>,
}

impl Solid {
    /// Takes the trees from a BSP; `leaf_solid` has one entry a leaf.
    pub(crate) fn new(bsp: &Bsp, leaf_solid: Vec<bool>) -> Self {
        let splits = bsp
            .nodes
            .iter()
            .map(|node| {
                let plane = bsp.planes[node.plane as usize];
                Split {
                    normal: plane.normal.as_dvec3(),
                    dist: plane.dist.into(),
                    axis: usize::try_from(plane.kind).ok().filter(|k| *k < 3),
                    children: node.children,
                }
            })
            .collect();
        Self { splits, leaf_solid, heads: bsp.models.iter().map(|m| m.head_node).collect() }
    }

    /// Whether a point, in the coordinates of brush model `model`, is inside its solid or within
    /// 0.1 units of it. A model without a tree has no solid.
    pub fn contains(&self, model: usize, point: Vec3) -> bool {
        let Some(&head) = self.heads.get(model) else { return false };
        let p = point.as_dvec3();
        let (mut node, mut open) = (head, Vec::new());
        // A tree reaches each split once; what goes on for longer is no tree.
        let mut steps = 2 * self.splits.len() + 2;
        loop {
            while let Some(split) = usize::try_from(node).ok().and_then(|n| self.splits.get(n)) {
                if steps == 0 {
                    return false;
                }
                steps -= 1;
                let d = split.distance(p);
                node = split.children[usize::from(d < 0.0)];
                if d.abs() <= NEAR_PLANE {
                    open.push(split.children[usize::from(d >= 0.0)]);
                }
            }
            if node < 0 && self.leaf_solid.get(!node as usize).copied().unwrap_or(false) {
                return true;
            }
            match open.pop() {
                Some(other) => node = other,
                None => return false,
            }
        }
    }

    /// Whether surely no point of a box, in the coordinates of brush model `model`, is inside its solid
    /// as [`Self::contains`] has it. Gives up after a number of steps.
    pub(super) fn spares(&self, model: usize, bounds: &Bounds) -> bool {
        let Some(&head) = self.heads.get(model) else { return true };
        let (middle, half) = (bounds.middle(), bounds.half() + BOX_SLACK);
        let mut open = vec![head];
        for _ in 0..MOST_BOX_STEPS {
            let Some(node) = open.pop() else { return true };
            let Some(split) = usize::try_from(node).ok().and_then(|n| self.splits.get(n)) else {
                if node < 0 && self.leaf_solid.get(!node as usize).copied().unwrap_or(false) {
                    return false;
                }
                continue;
            };
            let d = split.distance(middle);
            let reach = match split.axis {
                Some(axis) => half[axis],
                None => dot64(half, split.normal.abs()),
            } + NEAR_PLANE;
            if d >= -reach {
                open.push(split.children[0]);
            }
            if d <= reach {
                open.push(split.children[1]);
            }
        }
        false
    }

    /// The leaf of the world at a point; `None` if the tree is none.
    pub(super) fn world_leaf(&self, point: Vec3) -> Option<u32> {
        let p = point.as_dvec3();
        let mut node = *self.heads.first()?;
        let mut steps = self.splits.len();
        while let Ok(index) = usize::try_from(node) {
            let split = self.splits.get(index)?;
            node = split.children[usize::from(split.distance(p) < 0.0)];
            steps = steps.checked_sub(1)?;
        }
        Some(!node as u32).filter(|&leaf| (leaf as usize) < self.leaf_solid.len())
    }

    /// The point itself if it is not inside the world, else the first of the points `step` units away
    /// along the axes that is not: low x, high x, low y, and so on.
    pub fn freed(&self, point: Vec3, step: f32) -> Option<Vec3> {
        let steps =
            [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [axis * -step, axis * step]);
        std::iter::once(Vec3::ZERO).chain(steps).map(|s| point + s).find(|p| !self.contains(0, *p))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Solid for x < 0, and for z < 0 where x > 0; the second plane is not axial in name.
    fn corner() -> Solid {
        let split = |normal: Vec3, axis, children| Split {
            normal: normal.as_dvec3(),
            dist: 0.0,
            axis,
            children,
        };
        Solid {
            splits: vec![split(Vec3::X, Some(0), [1, -1]), split(Vec3::Z, None, [-2, -1])],
            leaf_solid: vec![true, false],
            heads: vec![0, -2],
        }
    }

    #[test]
    fn both_sides_count_near_a_plane() {
        let solid = corner();
        for (p, inside) in [
            ([1.0, 0.0, 1.0], false),
            ([0.101, 0.0, 0.101], false),
            ([0.099, 0.0, 1.0], true),
            ([1.0, 0.0, 0.099], true),
            ([1.0, 0.0, -1.0], true),
            ([-1.0, 0.0, 1.0], true),
        ] {
            assert_eq!(solid.contains(0, Vec3::from(p)), inside, "{p:?}");
        }
    }

    #[test]
    fn boxes_are_spared_only_if_all_their_points_are() {
        let solid = corner();
        let spares = |low: [f32; 3], high: [f32; 3]| {
            let ends = [Vec3::from(low), Vec3::from(high)];
            solid.spares(0, &Bounds::around(ends.into_iter()).unwrap())
        };
        assert!(spares([0.2, 0.0, 0.2], [5.0, 5.0, 5.0]));
        assert!(!spares([0.05, 0.0, 0.2], [5.0, 5.0, 5.0]));
        assert!(!spares([0.2, 0.0, -3.0], [5.0, 5.0, 5.0]));
        assert!(!spares([0.2, 0.0, 0.105], [5.0, 5.0, 5.0]), "too near to tell");
        assert!(solid.spares(1, &Bounds::around(std::iter::once(Vec3::ZERO)).unwrap()));
    }

    #[test]
    fn leaf_heads_missing_models_and_loops_end() {
        let mut solid = corner();
        assert!(!solid.contains(1, Vec3::ZERO), "model 1 is an empty leaf");
        assert!(!solid.contains(9, Vec3::ZERO));
        solid.splits[1].children = [0, 0];
        assert!(!solid.contains(0, Vec3::new(1.0, 0.0, 0.05)));
    }

    #[test]
    fn a_deep_tree_does_not_exhaust_the_stack() {
        let mut solid = corner();
        let n = 1_000_000;
        solid.splits = (0..n)
            .map(|i| Split {
                normal: DVec3::X,
                dist: 0.0,
                axis: Some(0),
                children: [if i + 1 < n { i + 1 } else { -1 }, -2],
            })
            .collect();
        assert!(solid.contains(0, Vec3::X));
        assert!(solid.contains(0, Vec3::ZERO));
        assert!(!solid.contains(0, -Vec3::X));
    }
}
