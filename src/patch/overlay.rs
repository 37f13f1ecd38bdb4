//! What changes light between two patches channel by channel: translucent polygons on its way, and
//! patterns on the patch that it comes from.

use super::{PatchGrid, PatchId, Pattern, PolygonPatches, Work};
use crate::scene::effects::Cost;
use crate::scene::{Node, Pane, Polygon, Tracer};
use glam::DVec3;

/// The translucent polygons and the patterns of a scene.
pub struct Overlay {
    layers: Tracer,
    sheets: Vec<Sheet>,
    patterns: Vec<Option<Pattern>>,
    /// By patch.
    glows: Vec<Glow>,
    /// Number of patches, if there are glows.
    patches: usize,
    /// What looking through the polygons took so far.
    pub layer_work: Work,
    /// What looking at the patterns took so far.
    pub pattern_work: Work,
}

/// Light that a patch gives off by itself and that does not vary over it as its pattern does. It is counted
/// with the patch as if it did; how it differs from that is counted as light of a column of its own
/// beyond those of the patches.
pub struct Glow {
    /// The patch.
    pub patch: PatchId,
    /// How the light varies; `None` where it is the same all over.
    pub pattern: Option<Pattern>,
}

/// What one translucent polygon does.
pub struct Sheet {
    /// What becomes of light that passes through.
    pub tint: Tint,
    /// Patches of its front and back, if it has any.
    pub sides: [Option<PatchId>; 2],
}

/// The light that a translucent polygon lets through.
pub enum Tint {
    /// Share of each channel, and how that varies.
    Even(DVec3, Option<Pattern>),
    /// Glass of a map.
    Pane(Pane),
}

impl Overlay {
    /// Polygons and what each does; patterns of the patches, in their order; those beyond have none. `None`
    /// if nothing changes any light.
    pub fn new(
        polygons: Vec<Polygon>,
        sheets: Vec<Sheet>,
        patterns: Vec<Option<Pattern>>,
    ) -> Option<Self> {
        Self::with_glows(polygons, sheets, patterns, (Vec::new(), 0))
    }

    /// The same with the light that some of so many patches give off by themselves, in their order.
    pub fn with_glows(
        polygons: Vec<Polygon>,
        sheets: Vec<Sheet>,
        patterns: Vec<Option<Pattern>>,
        (glows, patches): (Vec<Glow>, usize),
    ) -> Option<Self> {
        assert_eq!(polygons.len(), sheets.len(), "one sheet a polygon");
        let varies = !glows.is_empty() || patterns.iter().any(Option::is_some);
        let changes = !polygons.is_empty() || varies;
        changes.then(|| Self {
            layers: Tracer::new(polygons),
            sheets,
            patterns,
            glows,
            patches,
            layer_work: Work::default(),
            pattern_work: Work::default(),
        })
    }

    /// What translucent polygons took so far, and what patterns took: cells and rays that met them, the
    /// time of hemicubes for that, and their part of so many `bytes` of form factors, shared out by
    /// cells and rays.
    pub fn costs(&self, bytes: u64) -> [Cost; 2] {
        let mut costs = [&self.layer_work, &self.pattern_work].map(Work::cost);
        let all: u64 = costs.iter().map(|c| c.cells + c.rays).sum();
        let each = bytes as f64 / all.max(1) as f64;
        for cost in &mut costs {
            cost.bytes = ((cost.cells + cost.rays) as f64 * each) as u64;
        }
        costs
    }

    /// The translucent polygons.
    pub fn layers(&self) -> &Tracer {
        &self.layers
    }

    /// Whether the light of some patch varies over it.
    pub fn has_patterns(&self) -> bool {
        !self.patterns.is_empty() || !self.glows.is_empty()
    }

    /// Columns of light beyond those of the patches.
    pub fn glows(&self) -> &[Glow] {
        &self.glows
    }

    /// The glows of a patch, each with its column.
    pub fn glows_of(&self, patch: PatchId) -> impl Iterator<Item = (PatchId, &Glow)> {
        let first = self.glows.partition_point(|glow| glow.patch < patch);
        let own = self.glows[first..].iter().take_while(move |glow| glow.patch == patch);
        own.enumerate().map(move |(k, glow)| (PatchId((self.patches + first + k) as u32), glow))
    }

    /// The patch that a column of light belongs to.
    pub fn patch_of(&self, column: PatchId) -> PatchId {
        let glow = (column.0 as usize).checked_sub(self.patches).and_then(|k| self.glows.get(k));
        glow.map_or(column, |glow| glow.patch)
    }

    /// Whether patches of a polygon may have patterns: on maps all of a face have or none.
    pub fn may_vary(&self, patches: &PolygonPatches) -> bool {
        match patches {
            PolygonPatches::None => false,
            PolygonPatches::Whole(patch) => self.varies(*patch),
            PolygonPatches::Grid(grid) => {
                let known = |patch: &&PatchId| **patch != PatchGrid::DIVIDED;
                grid.blocks.iter().find(known).is_none_or(|&patch| self.varies(patch))
            }
        }
    }

    /// Whether the light of a patch varies over it.
    pub fn varies(&self, patch: PatchId) -> bool {
        matches!(self.patterns.get(patch.0 as usize), Some(Some(_)))
            || self.glows_of(patch).next().is_some()
    }

    /// Light of `patch` at `point` over its mean, in each channel, but for glows; `None` where it has no
    /// pattern.
    pub fn pattern(&self, patch: PatchId, point: DVec3) -> Option<DVec3> {
        let pattern = self.patterns.get(patch.0 as usize)?.as_ref();
        pattern.map(|pattern| pattern.relative(point))
    }

    /// The mean of [`pattern`](Self::pattern) over some points.
    pub fn pattern_over(
        &self,
        patch: PatchId,
        points: impl Iterator<Item = DVec3>,
    ) -> Option<DVec3> {
        self.patterns.get(patch.0 as usize)?.as_ref()?.relative_over(points)
    }

    /// Share of each channel that passes through a polygon at `point`, looked at along `direction`.
    pub fn tint(&self, polygon: u32, point: DVec3, direction: DVec3) -> DVec3 {
        match &self.sheets[polygon as usize].tint {
            Tint::Even(share, None) => *share,
            Tint::Even(share, Some(pattern)) => *share * pattern.factor(point),
            Tint::Pane(pane) => pane.tint(point.as_vec3(), direction.as_vec3()).as_dvec3(),
        }
    }

    /// The patch that a look along `direction` sees on a polygon.
    pub fn side(&self, polygon: u32, direction: DVec3) -> Option<PatchId> {
        let front = self.layers.polygons()[polygon as usize].normal.as_dvec3().dot(direction) < 0.0;
        self.sheets[polygon as usize].sides[usize::from(!front)]
    }

    /// The patches of all translucent polygons, polygon by polygon, with the share of light that gets
    /// through where it is the same all over.
    pub fn layer_patches(&self) -> impl Iterator<Item = (PatchId, Option<DVec3>)> + '_ {
        self.sheets.iter().flat_map(|sheet| {
            let share = match sheet.tint {
                Tint::Even(share, None) => Some(share),
                _ => None,
            };
            sheet.sides.into_iter().flatten().map(move |side| (side, share))
        })
    }

    /// Share of each channel that gets from one point to another through all that is between.
    pub fn through(&self, from: DVec3, to: DVec3) -> DVec3 {
        let mut share = DVec3::ONE;
        self.cross(from, to, |t, polygon| {
            share *= self.tint(polygon, from + (to - from) * t, to - from);
        });
        share
    }

    /// The polygons between two points, in order, and at which share of the way each is.
    pub fn crossings(&self, from: DVec3, to: DVec3) -> Vec<(f64, u32)> {
        let mut found = Vec::new();
        self.cross(from, to, |t, polygon| found.push((t, polygon)));
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found
    }

    fn cross(&self, from: DVec3, to: DVec3, mut cross: impl FnMut(f64, u32)) {
        let way = to - from;
        let nodes = self.layers.nodes();
        let mut stack = if nodes.is_empty() { vec![] } else { vec![0u32] };
        while let Some(index) = stack.pop() {
            let node = &nodes[index as usize];
            if !meets_box(node, from, way) {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first, node.first + 1]);
                continue;
            }
            for slot in node.first..node.first + node.count {
                let (corners, normal, polygon) = self.layers.polygon(slot);
                let normal = normal.as_dvec3();
                let t = normal.dot(corners[0].as_dvec3() - from) / normal.dot(way);
                if !(t > 0.0 && t < 1.0) {
                    continue;
                }
                let corner = |k: usize| corners[k % corners.len()].as_dvec3() - from;
                if in_cone((0..corners.len()).map(|k| corner(k).cross(corner(k + 1))), way) {
                    cross(t, polygon);
                }
            }
        }
    }
}

/// Whether a line through the eye along `way` is inside all planes through the eye that have these
/// normals, or outside all.
pub fn in_cone(planes: impl Iterator<Item = DVec3>, way: DVec3) -> bool {
    let (mut low, mut high) = (0.0f64, 0.0f64);
    for plane in planes {
        let side = plane.dot(way);
        low = low.min(side);
        high = high.max(side);
    }
    low == 0.0 || high == 0.0
}

fn meets_box(node: &Node, from: DVec3, way: DVec3) -> bool {
    let (low, high) = ((node.min.as_dvec3() - from) / way, (node.max.as_dvec3() - from) / way);
    // A way within a plane of the box gives NaN, which `min` and `max` pass over.
    let (enter, leave) = (low.min(high).max_element(), low.max(high).min_element());
    let slack = 1e-9;
    let misses = enter.max(0.0) - slack > leave.min(1.0) + slack;
    !misses
}

impl Glow {
    /// Light over its mean, over some points, in each channel.
    pub fn over(&self, points: impl Iterator<Item = DVec3>) -> DVec3 {
        self.pattern
            .as_ref()
            .and_then(|pattern| pattern.relative_over(points))
            .unwrap_or(DVec3::ONE)
    }
}

impl std::fmt::Debug for Overlay {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let patterns = self.patterns.iter().flatten().count();
        write!(f, "Overlay({} layers, {patterns} patterns)", self.sheets.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn square(z: f32) -> Polygon {
        let vertices = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        Polygon { vertices: vertices.map(|[x, y]| Vec3::new(x, y, z)).to_vec(), normal: Vec3::Z }
    }

    #[test]
    fn all_layers_between_multiply_and_no_others() {
        let tints = [0.5, 0.25, 0.125];
        let sheets = tints
            .map(|t| Sheet { tint: Tint::Even(DVec3::new(t, 1.0, 0.0), None), sides: [None; 2] });
        let polygons = vec![square(1.0), square(2.0), square(3.0)];
        let overlay = Overlay::new(polygons, sheets.into(), vec![]).unwrap();
        let red = |z: [f64; 2], x: f64| {
            let through = overlay.through(DVec3::new(x, 0.3, z[0]), DVec3::new(x, 0.3, z[1]));
            assert_eq!(through.y, 1.0);
            through.x
        };
        assert_eq!(red([0.0, 5.0], 0.4), 1.0 / 64.0);
        assert_eq!(red([5.0, 0.0], 0.4), 1.0 / 64.0, "the same backwards");
        assert_eq!(red([0.0, 2.5], 0.4), 0.125);
        assert_eq!(red([3.5, 5.0], 0.4), 1.0);
        assert_eq!(red([0.0, 5.0], 1.4), 1.0, "beside");
    }
}
