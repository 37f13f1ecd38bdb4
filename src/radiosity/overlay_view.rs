//! What an overlay changes of a hemicube: translucent polygons in front of what its cells show, and
//! patterns on what they show. The hemicube itself is drawn as if there were none.

use super::hemicube::{Cells, DeltaFormFactors, HemicubeSize, ItemBuffer, SIDES, SideId, View};
use crate::patch::{Overlay, PatchId, PatchSet, PolygonPatches, in_cone};
use crate::scene::Tracer;
use glam::{DVec2, DVec3, Vec3};
use std::time::Instant;

/// A translucent polygon in a cell.
#[derive(Clone, Copy)]
struct Fragment {
    /// Number of the side, row and column.
    cell: (u32, u32, u32),
    polygon: u32,
    /// 1 / depth.
    nearness: f32,
}

/// Form factors that an overlay adds to those of a hemicube, channel by channel. Buffers are reused.
pub(super) struct OverlayView<'a> {
    overlay: &'a Overlay,
    fragments: Vec<Fragment>,
    sums: Vec<DVec3>,
    touched: Vec<bool>,
    row: Vec<(PatchId, DVec3)>,
    /// Whether patches of a polygon have patterns; empty if none has.
    varied: Vec<bool>,
}

/// What a hemicube showed.
#[derive(Clone, Copy)]
pub(super) struct Shown<'a> {
    pub buffer: &'a ItemBuffer,
    pub tracer: &'a Tracer,
    pub patches: &'a PatchSet,
    pub delta: &'a DeltaFormFactors,
}

impl<'a> OverlayView<'a> {
    /// `None` where the patches have no overlay.
    pub fn new(patches: &'a PatchSet) -> Option<Self> {
        let count = patches.columns();
        let varied = |overlay: &Overlay| {
            let all = patches.lookup.polygons().iter().filter(|_| overlay.has_patterns());
            all.map(|polygon| overlay.may_vary(polygon)).collect()
        };
        patches.overlay.as_deref().map(|overlay| Self {
            overlay,
            fragments: Vec::new(),
            sums: vec![DVec3::ZERO; count],
            touched: vec![false; count],
            row: Vec::new(),
            varied: varied(overlay),
        })
    }

    /// To be added to the form factors from the point last looked from, by ascending patch: positive for
    /// translucent patches, negative for those behind them. Glows come after the patches.
    pub fn row(&self) -> &[(PatchId, DVec3)] {
        &self.row
    }

    /// Works the row out for what is `shown` from `view`.
    pub fn look(&mut self, shown: Shown<'_>, view: &View) {
        self.row.clear();
        if self.overlay.has_patterns() {
            let start = Instant::now();
            let cells = self.add_patterns(shown, view);
            self.overlay.pattern_work.add_cells(cells, start.elapsed());
        }
        let start = Instant::now();
        let size = shown.buffer.size();
        for (number, side) in SIDES.into_iter().enumerate() {
            draw(self.overlay.layers(), view, (number as u32, side), size, &mut self.fragments);
        }
        // The nearest first in every cell.
        self.fragments.sort_unstable_by(|a, b| {
            let order = a.cell.cmp(&b.cell).then(b.nearness.total_cmp(&a.nearness));
            order.then(a.polygon.cmp(&b.polygon))
        });
        let fragments = std::mem::take(&mut self.fragments);
        for cell in fragments.chunk_by(|a, b| a.cell == b.cell) {
            self.add_layers(shown, view, cell);
        }
        let cells = fragments.len() as u64;
        if !self.overlay.layers().nodes().is_empty() {
            self.overlay.layer_work.add_cells(cells, start.elapsed());
        }
        self.fragments = fragments;
        self.fragments.clear();
        self.row.sort_unstable_by_key(|&(patch, _)| patch);
        for (patch, f) in &mut self.row {
            *f = std::mem::take(&mut self.sums[patch.0 as usize]);
            self.touched[patch.0 as usize] = false;
        }
    }

    fn add(&mut self, patch: PatchId, f: DVec3) {
        let i = patch.0 as usize;
        if !std::mem::replace(&mut self.touched[i], true) {
            self.row.push((patch, DVec3::ZERO));
        }
        self.sums[i] += f;
    }

    /// Cells that show patches with patterns. Returns how many.
    fn add_patterns(&mut self, shown: Shown<'_>, view: &View) -> u64 {
        let (overlay, size, mut found) = (self.overlay, shown.buffer.size(), 0);
        shown.buffer.for_each_row(|cells| {
            for (k, (&item, &nearness)) in cells.items.iter().zip(cells.nearness).enumerate() {
                if item == Cells::NOTHING || !self.varied[item as usize] {
                    continue;
                }
                let x = cells.x + k as u32;
                let point = eye_point(view, size, (cells.side, x, cells.y), nearness);
                let Some(patch) = patch_at(shown, view, item, point) else { continue };
                let (points, count) = points_of_cell(shown, view, (cells.side, x, cells.y), item);
                let points = || points[..count].iter().copied();
                let f = || {
                    let at = (cells.y * size.width() + x) as usize;
                    f64::from(shown.delta.of(cells.side)[at])
                };
                let share = overlay.pattern_over(patch, points());
                if let Some(share) = share {
                    self.add(patch, (share - DVec3::ONE) * f());
                }
                let share = share.unwrap_or(DVec3::ONE);
                for (column, glow) in overlay.glows_of(patch) {
                    self.add(column, (glow.over(points()) - share) * f());
                }
                found += 1;
            }
        });
        found
    }

    /// The polygons in one cell, in order of depth, and what is behind them.
    fn add_layers(&mut self, shown: Shown<'_>, view: &View, fragments: &[Fragment]) {
        let (number, y, x) = fragments[0].cell;
        let size = shown.buffer.size();
        let side = SIDES[number as usize];
        let (item, behind) = shown.buffer.cell(side, x, y);
        let f = f64::from(shown.delta.of(side)[(y * size.width() + x) as usize]);
        let mut share = DVec3::ONE;
        for fragment in fragments.iter().take_while(|fragment| fragment.nearness > behind) {
            let point = eye_point(view, size, (side, x, y), fragment.nearness);
            let way = point - view.position.as_dvec3();
            if let Some(patch) = self.overlay.side(fragment.polygon, way) {
                let pattern = self.overlay.pattern(patch, point).unwrap_or(DVec3::ONE);
                self.add(patch, share * pattern * f);
            }
            share *= self.overlay.tint(fragment.polygon, point, way);
        }
        if item == Cells::NOTHING || share == DVec3::ONE {
            return;
        }
        let point = eye_point(view, size, (side, x, y), behind);
        if let Some(patch) = patch_at(shown, view, item, point) {
            let pattern = self.overlay.pattern(patch, point).unwrap_or(DVec3::ONE);
            self.add(patch, (share - DVec3::ONE) * pattern * f);
            let overlay = self.overlay;
            for (column, glow) in overlay.glows_of(patch) {
                let own = glow.over(std::iter::once(point));
                self.add(column, (share - DVec3::ONE) * (own - pattern) * f);
            }
        }
    }
}

/// World point in the middle of a cell.
fn eye_point(
    view: &View,
    size: HemicubeSize,
    (side, x, y): (SideId, u32, u32),
    nearness: f32,
) -> DVec3 {
    let [a, b, c] = view.axes(side).map(Vec3::as_dvec3);
    let at = size.cell_centre(side, x, y).as_dvec2();
    view.position.as_dvec3() + (c + a * at.x + b * at.y) / f64::from(nearness)
}

/// Points along each axis of a cell at which patterns are looked at: one would alias.
const ACROSS: u32 = 2;

/// World points where rays spread evenly over a cell meet the plane of a polygon, and how many do.
fn points_of_cell(
    shown: Shown<'_>,
    view: &View,
    (side, x, y): (SideId, u32, u32),
    item: u32,
) -> ([DVec3; (ACROSS * ACROSS) as usize], usize) {
    let size = shown.buffer.size();
    let [a, b, c] = view.axes(side).map(Vec3::as_dvec3);
    let polygon = &shown.tracer.polygons()[item as usize];
    let (eye, normal) = (view.position.as_dvec3(), polygon.normal.as_dvec3());
    let above = normal.dot(polygon.vertices[0].as_dvec3() - eye);
    let middle = size.cell_centre(side, x, y).as_dvec2();
    let width = 2.0 / f64::from(size.width());
    let off = move |k: u32| ((f64::from(k) + 0.5) / f64::from(ACROSS) - 0.5) * width;
    let (mut points, mut count) = (<[DVec3; (ACROSS * ACROSS) as usize]>::default(), 0);
    for k in 0..ACROSS * ACROSS {
        let at = middle + DVec2::new(off(k % ACROSS), off(k / ACROSS));
        let way = c + a * at.x + b * at.y;
        let far = above / normal.dot(way);
        if far > 0.0 && far.is_finite() {
            points[count] = eye + way * far;
            count += 1;
        }
    }
    (points, count)
}

/// The patch whose front is seen at a point of a polygon.
fn patch_at(shown: Shown<'_>, view: &View, item: u32, point: DVec3) -> Option<PatchId> {
    let polygon = &shown.tracer.polygons()[item as usize];
    if polygon.normal.dot(view.position - polygon.vertices[0]) <= 0.0 {
        return None;
    }
    match shown.patches.lookup.polygon(item) {
        PolygonPatches::None => None,
        PolygonPatches::Whole(patch) => Some(*patch),
        PolygonPatches::Grid(grid) => Some(grid.at_point(point.as_vec3())),
    }
}

/// Finds the cells of one side that polygons are in. Tests against planes through the eye need no
/// clipping (Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997).
fn draw(
    layers: &Tracer,
    view: &View,
    (number, side): (u32, SideId),
    size: HemicubeSize,
    fragments: &mut Vec<Fragment>,
) {
    let axes = view.axes(side);
    // Planes of the view's pyramid; the sides end at the horizon.
    let [a, b, c] = axes;
    let low = if side == SideId::Top { b + c } else { b };
    let planes = [c + a, c - a, low, c - b, c];
    let mut stack = if layers.nodes().is_empty() { vec![] } else { vec![0u32] };
    while let Some(index) = stack.pop() {
        let node = &layers.nodes()[index as usize];
        let centre = (node.min + node.max) * 0.5 - view.position;
        let half = (node.max - node.min) * 0.5;
        if planes.iter().any(|p| p.dot(centre) + p.abs().dot(half) < 0.0) {
            continue;
        }
        if node.count == 0 {
            stack.extend([node.first, node.first + 1]);
            continue;
        }
        for slot in node.first..node.first + node.count {
            let (corners, normal, polygon) = layers.polygon(slot);
            let corners: Vec<DVec3> = corners
                .iter()
                .map(|&p| p.as_dvec3() - view.position.as_dvec3())
                .map(|p| axes.map(|axis| axis.as_dvec3().dot(p)).into())
                .collect();
            let normal = axes.map(|axis| f64::from(axis.dot(normal))).into();
            cover(&corners, normal, side, size, |x, y, nearness| {
                fragments.push(Fragment { cell: (number, y, x), polygon, nearness });
            });
        }
    }
}

/// Calls `visit(column, row, nearness)` for each cell whose middle is in a polygon, given in the axes of
/// the side.
fn cover(
    corners: &[DVec3],
    normal: DVec3,
    side: SideId,
    size: HemicubeSize,
    mut visit: impl FnMut(u32, u32, f32),
) {
    let next = corners.iter().cycle().skip(1);
    let edges: Vec<DVec3> = corners.iter().zip(next).map(|(a, b)| a.cross(*b)).collect();
    let offset = normal.dot(corners[0]);
    let Some((low, high)) = bounds(corners) else { return };
    let (width, rows) = (size.width(), size.rows(side));
    let lowest = if side == SideId::Top { -1.0 } else { 0.0 };
    // `as` saturates. One cell of margin against rounding.
    let range = |low: f64, high: f64, from: f64, count: u32| {
        let cells = f64::from(count) / (1.0 - from);
        let cell = |v: f64| (v - from) * cells;
        (cell(low) - 1.0) as u32..((cell(high) + 2.0) as u32).min(count)
    };
    for y in range(low[1], high[1], lowest, rows) {
        for x in range(low[0], high[0], -1.0, width) {
            let at = size.cell_centre(side, x, y).as_dvec2();
            let way = at.extend(1.0);
            let nearness = normal.dot(way) / offset;
            if nearness > 0.0 && nearness.is_finite() && in_cone(edges.iter().copied(), way) {
                visit(x, y, nearness as f32);
            }
        }
    }
}

/// Bounds of a polygon on the plane at depth 1; `None` if all of it is behind the eye.
fn bounds(corners: &[DVec3]) -> Option<([f64; 2], [f64; 2])> {
    let reach = corners.iter().map(|c| c.abs().max_element()).fold(0.0, f64::max);
    let near = reach * 1e-9;
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut include = |p: DVec3| {
        for k in 0..2 {
            low[k] = low[k].min(p[k] / p.z);
            high[k] = high[k].max(p[k] / p.z);
        }
    };
    for (&a, &b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        if a.z >= near {
            include(a);
        }
        if (a.z < near) != (b.z < near) {
            let cut = a + (b - a) * ((near - a.z) / (b.z - a.z));
            include(DVec3 { z: near, ..cut });
        }
    }
    (low[0] <= high[0]).then_some((low, high))
}
