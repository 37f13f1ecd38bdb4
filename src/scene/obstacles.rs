//! What stands in the way of bounced light besides the surfaces that block all light.
//!
//! Bounced light is gathered through thousands of directions a patch, too many to look up a texel for
//! each. A fence is replaced by slats instead: stripes of its plane, as many as it has luxels across,
//! which together cover the same share of it as its texture does. Models of `skip` that cast shadow are
//! their hulls.

use super::Scene;
use super::hull;
use super::models::{Model, ShadowClass};
use super::surface::{Role, Surface};
use super::texels::Texels;
use super::tracer::{Polygon, Tracer};
use crate::bsp::{Bsp, MipTex};
use glam::{Vec3, Vec4};

/// Distance of slats on fences without luxels, in world units.
const SLAT: f32 = 16.0;
/// The most slats of a fence; one that would have more blocks as a whole if it covers more than half.
const SLAT_LIMIT: f32 = 1024.0;
/// For polygons that belong to no surface.
const NO_SURFACE: u32 = u32::MAX;

/// The surfaces that block all light, and what else blocks bounced light.
pub(super) struct Obstacles {
    tracer: Tracer,
    /// Surface of each polygon, or [`NO_SURFACE`].
    surface: Vec<u32>,
    /// The hulls of models of `skip`.
    hulls: Tracer,
}

impl Obstacles {
    /// The hulls of models without faces that cast shadow.
    pub fn hulls(&self) -> &Tracer {
        &self.hulls
    }
}

/// What obstacles are found in.
pub(super) struct Casters<'a> {
    pub bsp: &'a Bsp,
    pub surfaces: &'a [Surface],
    pub models: &'a [Model],
    /// Pixels that the map may lack.
    pub textures: &'a [MipTex],
}

impl Casters<'_> {
    /// The obstacles, after the polygons of `tracer` and their surfaces; `None` if there are no others.
    pub fn obstacles(&self, tracer: &Tracer, of: &[u32]) -> Option<Obstacles> {
        let mut polygons = Vec::new();
        let mut surface = Vec::new();
        for (index, fence) in self.surfaces.iter().enumerate() {
            let model = fence.model.map(|m| &self.models[m as usize]);
            let filter = (fence.role, fence.opacity, fence.channel_mask);
            if !is_fence(fence.fence, filter, model) {
                continue;
            }
            let texels = fence.texture.and_then(|t| Texels::find(self.bsp, t, self.textures));
            let covered = texels.map_or(1.0, |t| t.covered());
            polygons.extend(slats(fence, covered));
            surface.resize(polygons.len(), index as u32);
        }
        let slats = polygons.len();
        for (model, record) in self.models.iter().zip(&self.bsp.models).skip(1) {
            if record.face_count != 0 || !is_plain(model) {
                continue;
            }
            for mut polygon in hull::polygons(self.bsp, record).unwrap_or_default() {
                polygon.vertices.iter_mut().for_each(|v| *v += model.offset);
                polygons.push(polygon);
            }
        }
        surface.resize(polygons.len(), NO_SURFACE);
        if polygons.is_empty() {
            return None;
        }
        let hulls = Tracer::new(polygons[slats..].to_vec());
        let polygons = tracer.polygons().iter().cloned().chain(polygons).collect();
        let surface = of.iter().copied().chain(surface).collect();
        // Slats are seen from both sides.
        let tracer = Tracer::new(polygons).on_solid(of.len());
        Some(Obstacles { tracer, surface, hulls })
    }
}

/// Whether a face with holes or not, of this role, opacity and channels is a fence that is the same to all
/// light.
pub(super) fn is_fence(
    fence: bool,
    (role, opacity, mask): (Role, f32, i32),
    model: Option<&Model>,
) -> bool {
    role == Role::Filter && fence && opacity >= 1.0 && mask == 1 && model.is_some_and(is_plain)
}

/// Whether the faces of a model block all rays that meet them.
fn is_plain(model: &Model) -> bool {
    matches!(model.shadow, ShadowClass::World | ShadowClass::Shadow)
        && !model.shadow_self
        && !model.shadow_world_only
        && model.channel_mask == 1
}

/// Stripes of a surface that cover a share of it: one a luxel, in the middle of its column.
fn slats(surface: &Surface, covered: f32) -> Vec<Polygon> {
    let Some(polygon) = surface.polygon() else { return Vec::new() };
    let row = surface.luxels.as_ref().map_or_else(
        || (surface.normal.any_orthonormal_vector() / SLAT).extend(0.0),
        |grid| grid.s_row,
    );
    let along = |p: Vec3| row.truncate().dot(p) + row.w;
    let (first, last) = polygon
        .vertices
        .iter()
        .map(|v| along(*v))
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), s| (a.min(s), b.max(s)));
    if covered >= 1.0 || last - first >= SLAT_LIMIT {
        return if covered > 0.5 { vec![polygon] } else { Vec::new() };
    }
    if covered <= 0.0 {
        return Vec::new();
    }
    let mut slats = Vec::new();
    // Counted, as coordinates may be so large that adding 1 leaves them as they are.
    for column in 0..=(last - first).ceil() as usize {
        let middle = first.floor() + column as f32 + 0.5;
        let low = half(&polygon.vertices, row, middle - covered * 0.5);
        let vertices = half(&low, -row, -(middle + covered * 0.5));
        if vertices.len() >= 3 {
            slats.push(Polygon { vertices, normal: polygon.normal });
        }
    }
    slats
}

/// The part of a convex polygon where `row` is at least `from`.
fn half(vertices: &[Vec3], row: Vec4, from: f32) -> Vec<Vec3> {
    let inside = |p: Vec3| row.truncate().dot(p) + row.w - from;
    let mut kept = Vec::new();
    for (i, &a) in vertices.iter().enumerate() {
        let b = vertices[(i + 1) % vertices.len()];
        let (da, db) = (inside(a), inside(b));
        if da >= 0.0 {
            kept.push(a);
        }
        if da * db < 0.0 {
            kept.push(a + (b - a) * (da / (da - db)));
        }
    }
    kept
}

impl Scene {
    /// What bounced light is gathered in: the polygons of `tracer` in their order, then slats for fences
    /// and the hulls of models of `skip`.
    pub fn bounce_tracer(&self) -> &Tracer {
        self.obstacles.as_ref().map_or(&self.tracer, |o| &o.tracer)
    }

    /// Surface of each polygon of [`Scene::bounce_tracer`], if it is part of one.
    pub fn bounce_surfaces(&self) -> impl Iterator<Item = Option<u32>> + '_ {
        let surfaces = self.obstacles.as_ref().map_or(&self.tracer_surface, |o| &o.surface);
        surfaces.iter().map(|&s| (s != NO_SURFACE).then_some(s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_of_a_square_meet_in_a_line() {
        let square = [[0.0, 0.0], [0.0, 4.0], [4.0, 4.0], [4.0, 0.0]];
        let square = square.map(|[x, y]| Vec3::new(x, y, 7.0));
        let row = Vec4::new(0.5, 0.0, 0.0, 1.0);
        // From 1 to 3 over the square; 1.5 is at x = 1.
        let right = half(&square, row, 1.5);
        assert!(right.len() == 4 && right.iter().all(|v| v.x >= 1.0 && v.z == 7.0));
        assert_eq!(half(&square, row, 0.0), square);
        assert!(half(&square, row, 4.0).is_empty());
    }
}
