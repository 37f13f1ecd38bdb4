//! From the quads of a text scene to patches: each quad is one.

use super::{
    Overlay, Passage, Patch, PatchEffects, PatchId, PatchLookup, PatchSet, Pattern, PolygonPatches,
    Quad, Sheet, TextScene, Tint,
};
use crate::photometry::{Exitance, Reflectance};
use crate::scene::{Polygon, Tracer};
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Distance of a patch's eye from its plane, relative to the size of the scene: enough that rounding
/// to single precision cannot put the eye behind its own patch.
const LIFT: f64 = 1e-6;

/// A text scene made ready for light exchange.
pub struct TextPatches {
    /// What blocks light: every patch that is not translucent, from both sides.
    pub tracer: Tracer,
    /// The patches, in file order, and then the backs of those with two sides, in file order.
    pub set: PatchSet,
    /// Light that each patch gives off by itself.
    pub emission: Vec<Exitance>,
    /// Whether each polygon of `tracer` is one side of a sheet; empty if none is.
    pub sheets: Vec<bool>,
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
        let mut builder = Builder::default();
        let with_backs = || scene.patches.iter().filter(|q| q.effects.has_two_sides());
        for quad in scene.patches.iter().chain(with_backs()) {
            let back = builder.set.patches.len() >= scene.patches.len();
            let pattern = quad.effects.shader.map(|s| Pattern::over(s, quad.vertices.map(place)));
            let mean = pattern.as_ref().map_or(DVec3::ONE, |p| p.mean);
            let (area, centroid) = moments(quad);
            let normal = if back { -quad.unit_normal() } else { quad.unit_normal() };
            let mut outline = quad.vertices.map(place).to_vec();
            if back {
                outline.reverse();
            }
            builder.set.patches.push(Patch {
                eye: (place(centroid) + normal * lift).as_vec3(),
                normal: normal.as_vec3(),
                area: area as f32,
                reflectance: Reflectance(varied(quad.reflectance, mean)),
            });
            builder.emission.push(Exitance(varied(quad.exitance, mean)));
            builder.set.outlines.push(outline);
            builder.patterns.push(pattern);
        }
        let mut backs = scene.patches.len() as u32..;
        for (front, quad) in scene.patches.iter().enumerate() {
            let front = PatchId(front as u32);
            let back = quad.effects.has_two_sides().then(|| PatchId(backs.next().expect("no end")));
            builder.add_polygons(quad, front, back);
        }
        builder.finish()
    }

    /// Reflectance of every patch.
    pub fn reflectance(&self) -> Vec<Reflectance> {
        self.set.patches.iter().map(|p| p.reflectance).collect()
    }
}

/// The parts while quads are added.
#[derive(Default)]
struct Builder {
    set: PatchSet,
    emission: Vec<Exitance>,
    /// One entry a patch.
    patterns: Vec<Option<Pattern>>,
    /// What blocks light, whose patch each is, and whether it is one side of a sheet.
    walls: Vec<Polygon>,
    wall_patches: Vec<PolygonPatches>,
    sheets: Vec<bool>,
    /// What is translucent.
    layers: Vec<Polygon>,
    layer_sheets: Vec<Sheet>,
}

impl Builder {
    /// The polygons of a quad whose patches have been added.
    fn add_polygons(&mut self, quad: &Quad, front: PatchId, back: Option<PatchId>) {
        let polygon = |patch: PatchId, set: &PatchSet| {
            let patch = patch.0 as usize;
            let vertices = set.outlines[patch].iter().map(|v| v.as_vec3()).collect();
            Polygon { vertices, normal: set.patches[patch].normal }
        };
        let PatchEffects { straight, diffuse, .. } = quad.effects;
        if let (Some(back), Some(diffuse)) = (back, diffuse) {
            let pattern = &self.patterns[front.0 as usize];
            let mean = pattern.as_ref().map_or(DVec3::ONE, |p| p.mean);
            let transmittance = varied(diffuse, mean);
            for (from, to) in [(front, back), (back, front)] {
                self.set.passages.push(Passage { from, to, transmittance });
            }
        }
        if quad.effects.is_translucent() {
            let pattern = self.patterns[front.0 as usize].clone();
            let share = DVec3::from(straight.expect("it is translucent"));
            self.layer_sheets
                .push(Sheet { tint: Tint::Even(share, pattern), sides: [Some(front), back] });
            self.layers.push(polygon(front, &self.set));
            return;
        }
        for patch in std::iter::once(front).chain(back) {
            self.walls.push(polygon(patch, &self.set));
            self.wall_patches.push(PolygonPatches::Whole(patch));
            self.sheets.push(back.is_some());
        }
    }

    fn finish(mut self) -> TextPatches {
        if self.patterns.iter().all(Option::is_none) {
            self.patterns.clear();
        }
        if !self.sheets.contains(&true) {
            self.sheets.clear();
        }
        self.set.lookup = PatchLookup::new(self.wall_patches);
        self.set.overlay =
            Overlay::new(self.layers, self.layer_sheets, self.patterns).map(Arc::new);
        let tracer = Tracer::new(self.walls);
        TextPatches { tracer, set: self.set, emission: self.emission, sheets: self.sheets }
    }
}

/// Values of a patch, given where its pattern is 1, as means over it.
fn varied(values: [f64; 3], mean: DVec3) -> Vec3 {
    (DVec3::from_array(values) * mean).as_vec3()
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
            effects: PatchEffects::default(),
        };
        let (area, centroid) = moments(&quad);
        assert!((area - 5.0).abs() < 1e-12);
        assert!((centroid - at(7.0 / 3.0, 0.0)).length() < 1e-12);
    }
}
