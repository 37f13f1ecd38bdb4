//! The plain way to fill a hemicube: one ray a cell. Slow, simple, and the oracle that the item
//! buffer is compared with.

use super::hemicube::{HemicubeSize, SIDES, SideId, View};
use crate::scene::Tracer;

/// World direction through the centre of a cell, with depth 1 along the side's axis.
pub fn direction(view: &View, size: HemicubeSize, side: SideId, x: u32, y: u32) -> glam::Vec3 {
    let [a, b, c] = view.axes(side);
    let at = size.cell_centre(side, x, y);
    c + a * at.x + b * at.y
}

/// Polygon seen through each cell, `None` for nothing: side by side in the order of
/// [`SIDES`], row by row.
pub fn trace(tracer: &Tracer, view: &View, size: HemicubeSize) -> Vec<Option<u32>> {
    let mut cells = Vec::with_capacity(size.cells());
    for side in SIDES {
        let rows = if side == SideId::Top { size.height() } else { size.height() / 2 };
        for y in 0..rows {
            for x in 0..size.width() {
                let direction = direction(view, size, side, x, y);
                let hit = tracer.first_hit(view.position, direction, f32::INFINITY);
                cells.push(hit.map(|h| h.polygon));
            }
        }
    }
    cells
}
