//! The other side of thin brushes: where light that meets one face leaves another.

use super::subdivide::MapPatches;
use super::{Passage, PatchGrid, PatchId, Pattern, PolygonPatches};
use crate::scene::{Scene, Surface};
use glam::Vec3;

/// Faces farther apart than this are not two sides of one curtain, in world units.
const THICKEST: f32 = 32.0;
/// Slack for points and planes that are rounded, in world units.
const SLACK: f32 = 0.1;

impl MapPatches {
    /// Light that passes diffusely through brushes whose faces say so (`diffuse` of their surfaces): from
    /// each patch to the one opposite on the nearest face of the same model that looks the other way. Faces
    /// without such a partner let nothing through. Where the face that light leaves has `patterns`, as much
    /// comes through as those let on average.
    pub(super) fn passages(&self, scene: &Scene, patterns: &[Option<Pattern>]) -> Vec<Passage> {
        let sheets: Vec<usize> =
            (0..scene.surfaces.len()).filter(|&s| scene.surfaces[s].diffuse.is_some()).collect();
        let mut passages = Vec::new();
        for &s in &sheets {
            let surface = &scene.surfaces[s];
            for i in self.first[s]..self.first[s + 1] {
                let eye = self.set.patches[i as usize].eye;
                let point = eye - surface.normal * (surface.normal.dot(eye) - surface.dist);
                let opposite = sheets
                    .iter()
                    .filter(|&&other| other != s)
                    .filter_map(|&other| {
                        let gap = gap(surface, &scene.surfaces[other], point)?;
                        Some((gap, self.at(other, point - surface.normal * gap)?))
                    })
                    .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                if let Some((_, from)) = opposite {
                    let pattern = patterns.get(i as usize).and_then(Option::as_ref);
                    let transmittance = match pattern {
                        Some(p) => p.mean.as_vec3() * (Vec3::ONE - surface.reflected_share()),
                        None => surface.diffuse.expect("it is a sheet"),
                    };
                    passages.push(Passage { from, to: PatchId(i), transmittance });
                }
            }
        }
        passages
    }

    /// The patch of a surface at a world point on it.
    pub fn at(&self, surface: usize, point: Vec3) -> Option<PatchId> {
        Some(self.grid(surface)?.at_point(point))
    }

    /// The patches of a surface, along its luxels.
    pub fn grid(&self, surface: usize) -> Option<&PatchGrid> {
        match self.set.lookup.polygon((*self.intervals.polygons.get(surface)?)?) {
            PolygonPatches::Grid(grid) => Some(grid),
            _ => None,
        }
    }
}

/// Distance from a point of a face to another face that looks the other way, straight behind it.
fn gap(face: &Surface, other: &Surface, point: Vec3) -> Option<f32> {
    if face.model != other.model || face.normal.dot(other.normal) > -0.999 {
        return None;
    }
    let gap = face.normal.dot(point - *other.vertices.first()?);
    if !(-SLACK..=THICKEST).contains(&gap) {
        return None;
    }
    let at = point - face.normal * gap;
    // Clockwise from the front.
    let edges = other.vertices.iter().zip(other.vertices.iter().cycle().skip(1));
    let inside = edges.into_iter().all(|(&a, &b)| {
        let outwards = other.normal.cross(b - a).normalize_or_zero();
        outwards.dot(at - a) <= SLACK
    });
    inside.then_some(gap)
}
