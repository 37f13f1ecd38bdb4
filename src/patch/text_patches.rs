//! From the quads of a text scene to patches: each quad is one.

use super::{Patch, PatchId, PatchLookup, PatchSet, PolygonPatches, Quad, TextScene};
use crate::photometry::{Exitance, Reflectance};
use crate::scene::{Polygon, Tracer};
use glam::DVec3;

/// Distance of a patch's eye from its plane, relative to the size of the scene: enough that rounding
/// to single precision cannot put the eye behind its own patch.
const LIFT: f64 = 1e-6;

/// A text scene made ready for light exchange.
pub struct TextPatches {
    /// What blocks light: every patch, from both sides.
    pub tracer: Tracer,
    /// The patches, in file order.
    pub set: PatchSet,
    /// Light that each patch gives off by itself.
    pub emission: Vec<Exitance>,
}

impl TextPatches {
    /// Moves the scene's middle to the origin, since single precision is finest there, and scales it by a
    /// power of two to a size of about 1, since products of tiny or huge lengths leave its range. Form
    /// factors do not depend on scale; areas of patches stay as they are.
    pub fn new(scene: &TextScene) -> Self {
        let corners = || scene.patches.iter().flat_map(|q| q.vertices);
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        let middle = (low + high) * 0.5;
        let extent = (high - low).max_element();
        let scale = if extent > 0.0 { (-extent.log2().round()).exp2() } else { 1.0 };
        let place = |v: DVec3| (v - middle) * scale;
        let lift = LIFT * extent * scale;
        let vec3 = |c: [f64; 3]| DVec3::from_array(c).as_vec3();
        let polygons = scene
            .patches
            .iter()
            .map(|q| Polygon {
                vertices: q.vertices.map(|v| place(v).as_vec3()).to_vec(),
                normal: q.unit_normal().as_vec3(),
            })
            .collect();
        let patches = scene
            .patches
            .iter()
            .map(|q| {
                let (area, centroid) = moments(q);
                let normal = q.unit_normal();
                Patch {
                    eye: (place(centroid) + normal * lift).as_vec3(),
                    normal: normal.as_vec3(),
                    area: area as f32,
                    reflectance: Reflectance(vec3(q.reflectance)),
                }
            })
            .collect();
        let outlines = scene.patches.iter().map(|q| q.vertices.map(place).to_vec()).collect();
        let whole = (0..scene.patches.len()).map(|i| PolygonPatches::Whole(PatchId(i as u32)));
        Self {
            tracer: Tracer::new(polygons),
            set: PatchSet { patches, outlines, lookup: PatchLookup::new(whole.collect()) },
            emission: scene.patches.iter().map(|q| Exitance(vec3(q.exitance))).collect(),
        }
    }

    /// Reflectance of every patch.
    pub fn reflectance(&self) -> Vec<Reflectance> {
        self.set.patches.iter().map(|p| p.reflectance).collect()
    }
}

/// Area and centroid of a flat convex quad.
fn moments(quad: &Quad) -> (f64, DVec3) {
    let [a, b, c, d] = quad.vertices;
    let one = 0.5 * (b - a).cross(c - a).length();
    let two = 0.5 * (c - a).cross(d - a).length();
    let sum = (a + b + c) / 3.0 * one + (a + c + d) / 3.0 * two;
    (one + two, sum / (one + two))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centroid_of_a_kite() {
        let at = |x, y| DVec3::new(x, y, 3.0);
        let quad = Quad {
            vertices: [at(0.0, 0.0), at(2.0, -1.0), at(5.0, 0.0), at(2.0, 1.0)],
            normal: DVec3::Z,
            exitance: [0.0; 3],
            reflectance: [0.5; 3],
        };
        let (area, centroid) = moments(&quad);
        assert!((area - 5.0).abs() < 1e-12);
        assert!((centroid - at(7.0 / 3.0, 0.0)).length() < 1e-12);
    }
}
