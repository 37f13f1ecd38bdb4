//! Normals and texture directions at the corners of faces, for light that engines compute themselves.

use super::Scene;
use glam::Vec3;

impl Scene {
    /// Normal, tangent and bitangent at each corner of a face, in the order of its vertices. Normals are
    /// those of smooth shading; the others are how the texture runs, along s and against t, turned into
    /// the plane across the normal, as FTE makes them where a map does not tell.
    pub fn corner_frames(&self, face: usize) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        let surface = &self.surfaces[face];
        let smooth =
            Some(self.smoothing.corner_normals(face)).filter(|n| !n.is_empty() && self.world.phong);
        let frame = |normal: Vec3| {
            let [s, t] = surface.texture_axes;
            let across = |axis: Vec3| {
                (axis - normal * axis.dot(normal)).try_normalize().unwrap_or(Vec3::ZERO)
            };
            [normal, across(s), across(-t)]
        };
        (0..surface.vertices.len())
            .map(move |corner| frame(smooth.map_or(surface.normal, |normals| normals[corner])))
    }

    /// The surfaces that continue a surface across its edges, in its plane or smoothly.
    pub(crate) fn continuations(&self, surface: usize) -> impl Iterator<Item = usize> + '_ {
        let edges = 0..self.shapes[surface].vertices.len();
        edges.filter_map(move |e| self.neighbours.across(surface, e)).map(|other| other as usize)
    }
}
