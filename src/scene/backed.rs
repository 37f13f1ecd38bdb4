//! Faces of the world that have nothing but solid behind them: from outside of solid, nobody sees their
//! backs.

use super::solid::Solid;
use super::surface::Surface;
use glam::Vec3;

/// How far behind a face is looked, in world units: it may be the face of a thin wall.
const BEHIND: f32 = 0.5;
/// How far inside its outline, as a share of the way to its middle.
const INSIDE: f32 = 0.05;

/// Whether a surface is of the world, and there is solid behind its middle, its corners and the middles
/// of its edges.
pub(super) fn is_backed(surface: &Surface, solid: &Solid) -> bool {
    let corners = &surface.vertices;
    if surface.model.is_some_and(|m| m != 0) || corners.is_empty() {
        return false;
    }
    let middle = corners.iter().sum::<Vec3>() / corners.len() as f32;
    let is_solid = |p: Vec3| solid.world_solid(p.lerp(middle, INSIDE) - surface.normal * BEHIND);
    is_solid(middle)
        && corners.iter().enumerate().all(|(i, &a)| {
            let b = corners[(i + 1) % corners.len()];
            is_solid(a) && is_solid(a.midpoint(b))
        })
}
