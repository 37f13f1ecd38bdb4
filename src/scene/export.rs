//! A scene as text for other programs: its faces as Wavefront OBJ, its surface lights as map entities.

use super::Scene;
use glam::Vec3;
use std::fmt::Write;

/// Colours of surface lights are written on this scale.
const FULL: f32 = 255.0;

/// The faces as Wavefront OBJ, one object a brush model: corners in world space and their smoothed unit
/// normals, anticlockwise from the front as the format has it. Faces with fewer than three corners are
/// left out.
pub fn obj(scene: &Scene) -> String {
    let mut text = String::from("# faces of a Quake map, in its units; z is up\n");
    let mut corners = 0;
    let mut model = None;
    for (index, surface) in scene.surfaces.iter().enumerate() {
        let count = surface.vertices.len();
        if count < 3 || !surface.vertices.iter().all(|v| v.is_finite()) {
            continue;
        }
        if model != Some(surface.model) {
            model = Some(surface.model);
            let name = surface.model.map_or_else(|| "none".into(), |m| m.to_string());
            let _ = writeln!(text, "o model_{name}");
        }
        let normals = scene.corner_normals(index);
        for (i, v) in surface.vertices.iter().enumerate() {
            let n: Vec3 = normals.get(i).copied().unwrap_or(surface.normal);
            let _ = writeln!(text, "v {} {} {}\nvn {} {} {}", v.x, v.y, v.z, n.x, n.y, n.z);
        }
        let _ = write!(text, "f");
        for corner in (1..=count).rev().map(|i| corners + i) {
            let _ = write!(text, " {corner}//{corner}");
        }
        text.push('\n');
        corners += count;
    }
    text
}

/// The points that surface lights shine from, as a map of `light` entities: the copies of mode 0 with
/// their `delay` left out, and the points of mode 1 with the light of one point.
pub fn surface_lights(scene: &Scene) -> String {
    let mut text = String::from("{\n\"classname\" \"worldspawn\"\n}\n");
    let mut light = |p: Vec3, brightness: f32, c: Vec3, style: u16| {
        let _ = write!(
            text,
            "{{\n\"classname\" \"light\"\n\"origin\" \"{} {} {}\"\n\"light\" \"{brightness}\"\n\
             \"_color\" \"{} {} {}\"\n\"style\" \"{style}\"\n}}\n",
            p.x, p.y, p.z, c.x, c.y, c.z
        );
    };
    for copy in scene.lights.iter().filter(|l| l.piece_radius > 0.0) {
        light(copy.origin, copy.brightness, copy.colour, copy.style);
    }
    for source in &scene.radiosity_lights {
        for point in &source.points {
            light(*point, source.intensity, source.colour * FULL, source.style);
        }
    }
    text
}
