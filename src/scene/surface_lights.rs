//! Surface lights: point lights spread over the faces of a texture (mode 0 of the contract's section
//! 4.7), or the faces themselves as area light.

use super::entity_lights::Draft;
use super::light_list::check_light_count;
use super::shape::{Shape, area_and_centre};
use super::surface::Surface;
use crate::Result;
use crate::bsp::Bsp;
use crate::photometry::Exitance;
use glam::Vec3;
use std::f32::consts::PI;

/// A surface that gives off light by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// Index of the surface.
    pub surface: u32,
    /// Light style.
    pub style: u16,
    /// Exitance, the same all over the surface.
    pub exitance: Exitance,
    /// Factor on its light where it bounces (`bouncescale`), 0 and up.
    pub bounce_scale: f32,
    /// Only parts of the surface shine: `exitance` is that of a white texel, see
    /// [`Scene::mean_glow`](super::Scene::mean_glow).
    pub varied: bool,
}

/// Pieces are not cut nearer than this to their end, in world units.
const LEAST_PIECE: f32 = 8.0;
/// The most pieces of one face.
const PIECE_LIMIT: usize = 1 << 14;

/// What the copies need of the scene.
pub(crate) struct Faces<'a> {
    pub bsp: &'a Bsp,
    pub surfaces: &'a [Surface],
    pub shapes: &'a [Shape],
    /// Lower-case texture name of each face.
    pub names: &'a [String],
    /// Surface-light group of each face.
    pub groups: &'a [i32],
    /// Largest size of a piece, in world units.
    pub piece_size: f32,
    /// Mean colour of the texture of each face, 0 to 1.
    pub colours: &'a [Vec3],
    /// Every surface light is area light, whatever its template says.
    pub area_lights: bool,
}

/// Appends a light to `drafts` for every piece of every face that a template names, in the order
/// of the leafs that see the faces. Returns the faces that emit themselves instead.
pub(crate) fn add_copies(
    drafts: &mut Vec<Draft>,
    faces: &Faces<'_>,
    warnings: &mut Vec<String>,
) -> Result<Vec<Emitter>> {
    let mut emitters = Vec::new();
    let templates: Vec<(usize, String)> = drafts
        .iter()
        .enumerate()
        .filter_map(|(i, d)| Some((i, d.template.as_ref()?.texture.to_ascii_lowercase())))
        .filter(|(_, texture)| !texture.is_empty())
        .collect();
    if templates.is_empty() {
        return Ok(emitters);
    }
    for (_, texture) in &templates {
        if !faces.names.contains(texture) {
            warnings.push(format!(
                "no face has the texture {texture:?} that a light names in _surface"
            ));
        }
    }
    for face in faces_in_leaf_order(faces) {
        let (area, matching): (Vec<usize>, Vec<usize>) = templates
            .iter()
            .filter(|(i, texture)| {
                let group = drafts[*i].template.as_ref().map_or(0, |t| t.group);
                let radiosity = drafts[*i].template.as_ref().is_some_and(|t| t.radiosity);
                *texture == faces.names[face]
                    && group == faces.groups[face]
                    && (faces.area_lights || !radiosity)
            })
            .map(|(i, _)| *i)
            .partition(|_| faces.area_lights);
        emitters.extend(area.iter().map(|&i| emitter(&drafts[i], face, faces.colours[face])));
        if matching.is_empty() {
            continue;
        }
        let shape = &faces.shapes[face];
        let Some(pieces) = pieces(&shape.vertices, faces.piece_size) else {
            let v = shape.vertices[0];
            warnings.push(format!(
                "the light surface at {} {} {} is too large for surface lights; it does not shine",
                v.x, v.y, v.z
            ));
            continue;
        };
        check_light_count(drafts.len().saturating_add(pieces.len() * matching.len()))?;
        for piece in pieces {
            let (area, centre) = area_and_centre(&piece);
            if centre.is_nan() {
                continue;
            }
            for &template in &matching {
                let offset = drafts[template].template.as_ref().map_or(2.0, |t| t.offset);
                let origin = centre + shape.normal * offset + faces.surfaces[face].offset;
                let mut copy = drafts[template].copy_at(origin, shape.normal);
                copy.light.piece_radius = (area / PI).sqrt();
                drafts.push(copy);
            }
        }
    }
    Ok(emitters)
}

/// A face as area light. From afar, a face of area A must light as the reference's radiosity mode
/// does: L A cos cos / d^2. A diffuse emitter of exitance M gives M A cos cos / (pi d^2), so M = pi L.
fn emitter(draft: &Draft, face: usize, texture_colour: Vec3) -> Emitter {
    let own = draft.template.as_ref().is_some_and(|t| t.has_colour);
    let colour = if own { draft.light.colour / 255.0 } else { texture_colour };
    Emitter {
        surface: face as u32,
        style: draft.light.style,
        exitance: Exitance(colour * (draft.light.brightness * PI)),
        bounce_scale: draft.light.bounce_scale,
        varied: false,
    }
}

/// Every face that a leaf lists, once, leaving out liquids seen from within.
fn faces_in_leaf_order(faces: &Faces<'_>) -> Vec<usize> {
    let bsp = faces.bsp;
    let mut seen = vec![false; bsp.faces.len()];
    let mut order = Vec::new();
    for leaf in &bsp.leafs {
        let marks = leaf.first_mark as usize..leaf.first_mark as usize + leaf.mark_count as usize;
        for &face in bsp.marksurfaces.get(marks).unwrap_or(&[]) {
            let face = face as usize;
            let Some(name) = faces.names.get(face) else { continue };
            if seen[face] || leaf.contents != -1 && name.starts_with('*') {
                continue;
            }
            seen[face] = true;
            if faces.shapes[face].vertices.len() >= 3 {
                order.push(face);
            }
        }
    }
    order
}

/// Cuts a polygon along multiples of `size` until no piece can be cut; `None` if there would be
/// too many pieces or the polygon is not finite.
fn pieces(polygon: &[Vec3], size: f32) -> Option<Vec<Vec<Vec3>>> {
    let mut open = vec![polygon.to_vec()];
    let mut done = Vec::new();
    while let Some(piece) = open.pop() {
        if !piece.iter().all(|v| v.is_finite()) || open.len() + done.len() > PIECE_LIMIT {
            return None;
        }
        match cut(&piece, size) {
            // The upper part comes first.
            Some((upper, lower)) => open.extend([lower, upper]),
            None => done.push(piece),
        }
    }
    Some(done)
}

/// The parts above and below the multiple of `size` nearest the middle of the first axis that is
/// long enough.
fn cut(piece: &[Vec3], size: f32) -> Option<(Vec<Vec3>, Vec<Vec3>)> {
    let min = piece.iter().copied().reduce(Vec3::min)?;
    let max = piece.iter().copied().reduce(Vec3::max)?;
    for axis in 0..3 {
        let middle = (min[axis] + max[axis]) * 0.5;
        let at = size * (middle / size + 0.5).floor();
        if max[axis] - at < LEAST_PIECE || at - min[axis] < LEAST_PIECE {
            continue;
        }
        let (mut upper, mut lower) = (Vec::new(), Vec::new());
        for (i, &a) in piece.iter().enumerate() {
            let b = piece[(i + 1) % piece.len()];
            let (da, db) = (a[axis] - at, b[axis] - at);
            if da >= 0.0 {
                upper.push(a);
            }
            if da <= 0.0 {
                lower.push(a);
            }
            if da * db < 0.0 {
                let crossing = a + (b - a) * (da / (da - db));
                upper.push(crossing);
                lower.push(crossing);
            }
        }
        return Some((upper, lower));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(x: [f32; 2], y: [f32; 2]) -> Vec<Vec3> {
        [[x[0], y[0]], [x[0], y[1]], [x[1], y[1]], [x[1], y[0]]]
            .map(|[x, y]| Vec3::new(x, y, 0.0))
            .to_vec()
    }

    #[test]
    fn small_faces_stay_whole() {
        assert_eq!(pieces(&rectangle([130.0, 250.0], [0.0, 100.0]), 128.0).unwrap().len(), 1);
    }

    #[test]
    fn pieces_cover_the_polygon_and_come_from_above() {
        let pieces = pieces(&rectangle([0.0, 300.0], [-50.0, 50.0]), 128.0).unwrap();
        // x is cut at 128 (nearest to 150) and then at 256; y at 0.
        assert_eq!(pieces.len(), 6);
        let area: f32 = pieces.iter().map(|p| area_and_centre(p).0).sum();
        assert!((area - 30_000.0).abs() < 0.1, "{area}");
        let first = area_and_centre(&pieces[0]).1;
        assert!((first - Vec3::new(278.0, 25.0, 0.0)).length() < 1e-4, "{first}");
    }

    #[test]
    fn huge_faces_are_refused() {
        assert!(pieces(&rectangle([0.0, 1e9], [0.0, 1e9]), 64.0).is_none());
        assert!(pieces(&rectangle([0.0, f32::NAN], [0.0, 1.0]), 64.0).is_none());
    }
}
