//! What a text scene may hold: which values are repaired with a warning and which are refused.
//!
//! Complaints here are plain strings; the reader adds the file and the line.

use super::text_effects::PatchEffects;
use super::text_scene::{CameraSpec, Quad, Reading};
use glam::DVec3;

/// Largest image width and height of a scene's header, in pixels.
pub const MAX_IMAGE: u32 = 16384;
/// Largest hemicube width and height of a scene's header, in cells.
pub const MAX_HEMICUBE: u32 = 4096;
/// Where no patch absorbs any light of a channel, reflectances are lowered to this value, because
/// light in a closed room of reflectance 1 never settles.
pub const MAX_REFLECTANCE: f64 = 0.9999;

/// Beyond this, products of coordinates leave the range of single precision.
const MAX_COORDINATE: f64 = 1e12;
/// Vertices may leave their common plane by this share of the quad's diameter.
const PLANARITY: f64 = 1e-4;
/// A corner may be dented by this share of the quad's diameter.
const DENT: f64 = 1e-6;
/// A normal's length may differ from 1 by this much before it is called unnormalised; hand-written
/// normals such as `0.707 0.707 0` pass.
const UNIT_LENGTH: f64 = 1e-3;
/// A normal may lean this far from the plane that the vertices span, in degrees.
const NORMAL_LEAN: f64 = 1.0;

pub(super) type Checked<T> = Result<T, String>;

/// Refuses coordinates too large to compute with.
pub(super) fn check_range(points: &[DVec3]) -> Checked<()> {
    match points.iter().find(|p| p.abs().max_element() > MAX_COORDINATE) {
        Some(p) => Err(format!(
            "the point {p} is out of range: coordinates go up to {MAX_COORDINATE:e}; scale the scene down"
        )),
        None => Ok(()),
    }
}

/// Refuses a camera that looks nowhere or whose up direction lies along its view.
pub(super) fn check_camera(camera: &CameraSpec) -> Checked<()> {
    check_range(&[camera.position, camera.look_at, camera.up])?;
    if camera.basis().is_some() {
        return Ok(());
    }
    Err(if camera.position == camera.look_at {
        format!("the camera at {} looks at its own position; move one of them", camera.position)
    } else {
        format!(
            "the camera's up direction {} is zero or lies along its view; choose another",
            camera.up
        )
    })
}

/// Refuses image sizes that nothing can be drawn on and hemicubes whose sides cannot be halved.
pub(super) fn check_sizes(image: [u32; 2], hemicube: [u32; 2]) -> Checked<()> {
    let [w, h] = image;
    if image.iter().any(|&n| n == 0 || n > MAX_IMAGE) {
        return Err(format!("image size {w} x {h}: width and height go from 1 to {MAX_IMAGE}"));
    }
    let [w, h] = hemicube;
    if hemicube.iter().any(|&n| n == 0 || n % 2 != 0 || n > MAX_HEMICUBE) {
        return Err(format!(
            "hemicube size {w} x {h}: width and height are even, from 2 to {MAX_HEMICUBE}"
        ));
    }
    Ok(())
}

/// A quad's vertices and normal, with what was repaired on them.
pub(super) struct CheckedQuad {
    pub vertices: [DVec3; 4],
    pub normal: DVec3,
    pub repairs: Vec<String>,
}

/// Refuses what is not a flat convex quad with a normal of its own; repairs the normal's length
/// and the winding. The normal says which side is lit, so it wins over the winding.
pub(super) fn check_quad(mut vertices: [DVec3; 4], mut normal: DVec3) -> Checked<CheckedQuad> {
    let mut repairs = Vec::new();
    check_range(&vertices)?;
    check_range(&[normal])?;
    let plane_normal = check_shape(&vertices)?;

    let length = normal.length();
    if length < 1e-30 {
        return Err("the normal is zero: it must point to the lit side".into());
    }
    if (length - 1.0).abs() > UNIT_LENGTH {
        repairs.push(format!("the normal's length is {length:.6}, brought to 1"));
        normal /= length;
    }

    let lean = plane_normal.cross(normal).length().atan2(plane_normal.dot(normal)).to_degrees();
    if lean > 180.0 - NORMAL_LEAN {
        repairs.push(
            "the vertices are clockwise seen from the normal's side; their order is reversed"
                .into(),
        );
        vertices.reverse();
    } else if lean > NORMAL_LEAN {
        return Err(format!(
            "the normal {normal} leans {:.1} degrees from the plane of the vertices; \
             their winding gives {plane_normal:.6}",
            lean.min(180.0 - lean)
        ));
    }
    Ok(CheckedQuad { vertices, normal, repairs })
}

/// The unit normal of the side from which `v` runs counter-clockwise, if `v` is a flat convex quad.
/// Two vertices may coincide (a triangle) and three may lie on one line.
fn check_shape(v: &[DVec3; 4]) -> Checked<DVec3> {
    let diameter =
        (0..4).flat_map(|i| (0..i).map(move |j| v[i].distance(v[j]))).fold(0.0, f64::max);
    let reach = v.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    // Files written from single precision carry its rounding, which counts far from the origin.
    let rounding = reach * f64::from(f32::EPSILON);
    let no_area = diameter * (1e-12 * diameter + 8.0 * f64::EPSILON * reach);

    // Twice the area of each corner's triangle, as a vector.
    let corners: [DVec3; 4] =
        std::array::from_fn(|i| (v[i] - v[(i + 3) % 4]).cross(v[(i + 1) % 4] - v[i]));
    if corners.iter().all(|c| c.length() <= no_area) {
        return Err(format!(
            "the quad at {} has no area: its vertices lie on one line or in one point",
            v[0]
        ));
    }
    // Twice the vector area of the quad (diagonals' cross product).
    let area = (v[2] - v[0]).cross(v[3] - v[1]);
    if area.length() <= no_area {
        return Err(format!("the quad at {} crosses itself or folds back over itself", v[0]));
    }
    let normal = area.normalize();

    // The diagonals lie in two parallel planes; a flat quad has both in one.
    let off_plane = normal.dot(v[1] - v[0]).abs();
    if off_plane > PLANARITY * diameter + rounding {
        return Err(format!(
            "the vertices are not planar: one is {off_plane:.6} off the plane of the others \
             in a quad {diameter:.6} across; split it into triangles"
        ));
    }
    let dent = diameter * (DENT * diameter + rounding);
    match corners.iter().filter(|c| c.dot(normal) < -dent).count() {
        0 => Ok(normal),
        1 => Err(format!("the quad at {} is not convex; split it in two", v[0])),
        _ => Err(format!("the quad at {} crosses itself; reorder its vertices", v[0])),
    }
}

/// Share of the light of a channel that a patch does not absorb.
fn sent_on(quad: &Quad, channel: usize) -> f64 {
    let PatchEffects { straight, diffuse, .. } = quad.effects;
    let of = |share: Option<[f64; 3]>| share.map_or(0.0, |s| s[channel]);
    quad.reflectance[channel] + of(straight) + of(diffuse)
}

/// Refuses light values out of range. `Reading::Lit` lets the second triple grow past 1, because
/// it is a final exitance there.
pub(super) fn check_light(exitance: [f64; 3], second: [f64; 3], reading: Reading) -> Checked<()> {
    check_unit("initial exitance", exitance)?;
    match reading {
        Reading::Lit => match second.iter().find(|&&x| x < 0.0) {
            Some(x) => Err(format!("final exitance {x} is negative")),
            None => Ok(()),
        },
        Reading::Raw => check_unit("reflectance", second).map_err(|problem| {
            if second.iter().all(|&x| x >= 0.0) {
                format!("{problem}; is this a scene that is lit already?")
            } else {
                problem
            }
        }),
    }
}

/// If some channel is absorbed by no patch at all, lowers the reflectances in it to
/// [`MAX_REFLECTANCE`] and says so. A reflectance of 1 is left alone where another patch absorbs.
pub(super) fn let_light_settle(patches: &mut [Quad]) -> Option<String> {
    let channels: Vec<usize> =
        (0..3).filter(|&i| patches.iter().all(|quad| sent_on(quad, i) > MAX_REFLECTANCE)).collect();
    for quad in patches {
        for &i in &channels {
            // Light that passes straight through has not met the patch.
            match quad.effects.diffuse.as_mut().filter(|t| t[i] > 0.0) {
                Some(diffuse) => {
                    diffuse[i] *= MAX_REFLECTANCE;
                    quad.reflectance[i] *= MAX_REFLECTANCE;
                }
                None => quad.reflectance[i] = quad.reflectance[i].min(MAX_REFLECTANCE),
            }
        }
    }
    let names: Vec<&str> = channels.iter().map(|&i| ["red", "green", "blue"][i]).collect();
    (!names.is_empty()).then(|| {
        format!(
            "no patch absorbs {} light, which would never settle; reflectances are lowered to \
             {MAX_REFLECTANCE}",
            names.join(", ")
        )
    })
}

fn check_unit(what: &str, values: [f64; 3]) -> Checked<()> {
    match values.into_iter().find(|x| !(0.0..=1.0).contains(x)) {
        Some(x) => Err(format!("{what} {x} is out of range: values go from 0 to 1")),
        None => Ok(()),
    }
}
