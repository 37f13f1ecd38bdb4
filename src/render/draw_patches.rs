//! Flat-shaded drawing of patches with a depth buffer. Translucent patches are laid over the finished
//! picture, the farthest first.
//!
//! A pixel belongs to a patch if the ray through its centre passes inside all edges of the patch,
//! tested on the planes through the eye and each edge in camera space. These tests need no clipping
//! (Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997), and two
//! patches that share an edge compute exactly opposite values for it, so no pixel falls between
//! them.

use super::Camera;
use crate::patch::{Pattern, Quad};
use crate::{Error, Result};
use glam::DVec3;
use image::{Rgb, RgbImage};
use std::ops::Range;

/// Most pixels that a picture of patches may have.
pub const MAX_PIXELS: u64 = 1 << 26;

/// Draws `patches` as `camera` sees them. A patch has the colour of its exitance plus the second
/// triple of its file, times `exposure` (1 shows values as they are), clamped to 0..1 and times 255: the
/// final exitance in a lit scene, full brightness in a raw one. Backs of patches with one side and the background are black; backs hide what
/// lies behind them. Of patches in one plane the first is seen.
///
/// # Errors
/// [`Error::Limit`] if the picture has more than [`MAX_PIXELS`].
pub fn draw_patches(patches: &[Quad], camera: &Camera, exposure: f64) -> Result<RgbImage> {
    let pixels = u64::from(camera.width) * u64::from(camera.height);
    if pixels > MAX_PIXELS {
        return Err(Error::Limit {
            what: format!("the pixel count of a {} x {} picture", camera.width, camera.height),
            value: pixels,
            limit: MAX_PIXELS,
            advice: "draw it smaller with --size",
        });
    }
    let mut image = RgbImage::new(camera.width, camera.height);
    let mut depths = vec![f32::INFINITY; pixels as usize];
    let (translucent, opaque): (Vec<_>, Vec<_>) =
        patches.iter().partition(|quad| quad.effects.is_translucent());
    for quad in opaque {
        draw_quad(quad, camera, exposure, |x, y, depth, colour| {
            let slot = &mut depths[y as usize * camera.width as usize + x as usize];
            if depth < *slot {
                *slot = depth;
                image.put_pixel(x, y, Rgb(colour.map(level)));
            }
        });
    }
    let mut layers = Vec::new();
    for quad in translucent {
        let share = quad.effects.straight.expect("it is translucent");
        draw_quad(quad, camera, exposure, |x, y, depth, colour| {
            if depth < depths[y as usize * camera.width as usize + x as usize] {
                layers.push(((y, x), depth, colour, share));
            }
        });
    }
    layers.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    for ((y, x), _, colour, share) in layers {
        let behind = image.get_pixel(x, y).0;
        let over = |i: usize| level(colour[i] + share[i] * f64::from(behind[i]) / 255.0);
        image.put_pixel(x, y, Rgb(std::array::from_fn(over)));
    }
    Ok(image)
}

/// Calls `draw(x, y, depth, colour)` for every pixel of a patch.
fn draw_quad(
    quad: &Quad,
    camera: &Camera,
    exposure: f64,
    mut draw: impl FnMut(u32, u32, f32, [f64; 3]),
) {
    let mut corners = quad.vertices.map(|v| camera.to_camera(v));
    let mut normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]);
    // (right, up, depth) is a left-handed space, so this normal points away from the lit side.
    let facing = normal.dot(corners[0]);
    let colour = if facing > 0.0 {
        shown(quad.exitance, quad.reflectance, exposure)
    } else if facing < 0.0 {
        corners.reverse();
        normal = -normal;
        match quad.effects.back {
            Some(back) => shown([0.0; 3], back, exposure),
            None if quad.effects.has_two_sides() => {
                shown(quad.exitance, quad.reflectance, exposure)
            }
            None => [0.0; 3],
        }
    } else {
        return; // Seen edge-on, it covers nothing.
    };

    let pattern = quad.effects.shader.map(|s| Pattern::over(s, quad.vertices));
    let edges: [DVec3; 4] = std::array::from_fn(|i| corners[i].cross(corners[(i + 1) % 4]));
    let offset = normal.dot(corners[0]);
    let (columns, rows) = bounds(&corners, camera);
    for y in rows {
        for x in columns.clone() {
            let ray = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
            // A pixel centre on an edge is inside both neighbours; the first one keeps it.
            if edges.iter().any(|edge| edge.dot(ray) < 0.0) {
                continue;
            }
            let distance = offset / normal.dot(ray);
            let depth = distance as f32;
            if depth > 0.0 {
                let colour = pattern.as_ref().map_or(colour, |pattern| {
                    let way = camera.right * ray.x + camera.up * ray.y + camera.forward * ray.z;
                    let factor = pattern.factor(camera.position + way * distance);
                    std::array::from_fn(|i| colour[i] * factor[i])
                });
                draw(x, y, depth, colour);
            }
        }
    }
}

/// Light that a side is drawn with: one formula for raw and lit scenes.
fn shown(exitance: [f64; 3], second: [f64; 3], exposure: f64) -> [f64; 3] {
    std::array::from_fn(|i| (exitance[i] + second[i]) * exposure)
}

/// Level of a channel: 1 is white.
fn level(light: f64) -> u8 {
    (light.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// The pixels that a quad in camera space may cover, as columns and rows.
fn bounds(corners: &[DVec3; 4], camera: &Camera) -> (Range<u32>, Range<u32>) {
    let reach = corners.iter().map(|c| c.abs().max_element()).fold(0.0, f64::max);
    // Far above rounding errors, and too close to the eye to hide anything.
    let near = reach * 1e-13;
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    let mut include = |point: DVec3| {
        for (i, x) in camera.project(point).into_iter().enumerate() {
            low[i] = low[i].min(x);
            high[i] = high[i].max(x);
        }
    };
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % 4];
        if a.z >= near {
            include(a);
        }
        if (a.z < near) != (b.z < near) {
            let crossing = a + (b - a) * ((near - a.z) / (b.z - a.z));
            include(DVec3 { z: near, ..crossing });
        }
    }
    // One pixel of margin against rounding; casts saturate, and an empty range stays empty.
    let range = |i: usize, size: u32| {
        ((low[i] - 1.0).max(0.0) as u32).min(size)
            ..((high[i] + 1.0).max(0.0).ceil() as u32).min(size)
    };
    (range(0, camera.width), range(1, camera.height))
}
