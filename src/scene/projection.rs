//! Textures that lights project like a slide (contract section 4.8).

use super::exact::{dot, radians};
use super::keys;
use super::texels::Texels;
use crate::bsp::{Bsp, Entity, MipTex};
use glam::Vec3;

/// Nothing is projected nearer than this, in world units.
const NEAREST: f32 = 16.0;
/// Brightness of the picture, relative to the light's own.
const GAIN: f32 = 2.0;

/// A picture in front of a light. Texels wrap at its edges.
#[derive(Clone, Debug, PartialEq)]
pub struct Projection {
    texels: Texels,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    /// Tangents of half the field of view, across and up.
    tangents: [f32; 2],
}

impl Projection {
    /// What a light entity projects; `None` without a picture. A texture that nobody has gives a
    /// sentence about it.
    pub(crate) fn read(
        entity: &Entity,
        bsp: &Bsp,
        replacements: &[MipTex],
    ) -> Result<Option<Self>, String> {
        let name = entity.setting("project_texture").unwrap_or("");
        if name.is_empty() {
            return Ok(None);
        }
        let known =
            |t: &Option<MipTex>| t.as_ref().is_some_and(|t| t.name.eq_ignore_ascii_case(name));
        let slot = bsp.textures.iter().position(known);
        let texels = slot.and_then(|slot| Texels::find(bsp, slot as u32, replacements));
        let Some(texels) = texels else {
            return Err(format!("its _project_texture {name:?} is not in the map's textures"));
        };
        let given = |name: &str| entity.setting(name).and_then(keys::vector);
        // `angles` is pitch, yaw, roll with pitch downwards.
        let angles = || entity.get("angles").and_then(keys::vector);
        let angles = given("project_mangle")
            .or_else(|| given("mangle"))
            .or_else(|| angles().map(|a| Vec3::new(a.y, -a.x, a.z)))
            .unwrap_or(Vec3::new(20.0, 0.0, 0.0));
        let fov = entity.setting("project_fov").and_then(keys::number).unwrap_or(90.0);
        Ok(Some(Self::new(texels, angles, fov)))
    }

    /// A picture seen along the angles yaw, pitch (up) and roll, `fov` degrees along its longer side.
    fn new(texels: Texels, angles: Vec3, fov: f32) -> Self {
        let (sy, cy) = radians(angles.x).sin_cos();
        let (sp, cp) = radians(-angles.y).sin_cos();
        let (sr, cr) = radians(angles.z).sin_cos();
        let vector = |x: f64, y: f64, z: f64| Vec3::new(x as f32, y as f32, z as f32);
        let [width, height] = texels.size().map(|v| v as f32);
        let tangent = radians(fov / 2.0).tan() as f32;
        Self {
            texels,
            forward: vector(cp * cy, cp * sy, -sp),
            right: vector(-sr * sp * cy + cr * sy, -sr * sp * sy - cr * cy, -sr * cp),
            up: vector(cr * sp * cy + sr * sy, cr * sp * sy - sr * cy, cr * cp),
            tangents: if width > height {
                [tangent, tangent * height / width]
            } else {
                [tangent * width / height, tangent]
            },
        }
    }

    /// Factor on the light at the point `way` from the light, per channel; `None` outside the
    /// picture.
    pub fn factor(&self, way: Vec3) -> Option<Vec3> {
        let z = dot(way, self.forward);
        let u = (1.0 + dot(way, self.right) / (z * self.tangents[0])) * 0.5;
        let v = (1.0 + dot(way, self.up) / (z * self.tangents[1])) * 0.5;
        if !(z >= NEAREST && u > 0.0 && u < 1.0 && v > 0.0 && v < 1.0) {
            return None;
        }
        let [width, height] = self.texels.size().map(|v| (v - 1) as f32);
        let (column, row) = (u * width, (1.0 - v) * height);
        let (x, y) = (column.floor(), row.floor());
        let pixel = |dx: usize, dy: usize| self.texels.pixel(x as usize + dx, y as usize + dy);
        let upper = pixel(0, 0).lerp(pixel(1, 0), column - x);
        let lower = pixel(0, 1).lerp(pixel(1, 1), column - x);
        Some(upper.lerp(lower, row - y) * (GAIN / 255.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsp::{Format, parse_entities};

    /// A picture of 3 x 2 pixels, dark but for a white one at the top right.
    fn projection(keys: &str) -> Projection {
        let mut bsp = Bsp::empty(Format::Bsp29);
        let pixels = Some(vec![0, 0, 254, 0, 0, 0]);
        bsp.textures = vec![Some(MipTex { name: "Slide".into(), width: 3, height: 2, pixels })];
        let entity = parse_entities(format!("{{ {keys} }}").as_bytes()).unwrap().remove(0);
        Projection::read(&entity, &bsp, &[]).unwrap().unwrap()
    }

    #[test]
    fn the_picture_stands_upright_before_the_light() {
        let slide = projection("_project_texture slide _project_mangle \"90 0 0\"");
        // Looking along +y, right is +x. The wider side spans 90 degrees.
        let at = |x: f32, z: f32| slide.factor(Vec3::new(x, 100.0, z)).map(|f| f.x);
        assert!((at(99.9, 66.5).unwrap() - 2.0).abs() < 0.02);
        assert!(at(-99.9, 66.5).unwrap() < 0.01 && at(99.9, -66.5).unwrap() < 0.01);
        assert_eq!(at(0.0, 0.0), Some(0.0));
        assert!((at(50.0, 0.0).unwrap() - 0.5).abs() < 1e-3, "half way in both directions");
        assert_eq!((at(100.1, 0.0), at(0.0, 67.0)), (None, None));
        assert_eq!(slide.factor(Vec3::new(0.0, -100.0, 0.0)), None, "behind");
        assert_eq!(slide.factor(Vec3::new(0.0, 15.0, 0.0)), None, "too near");
    }

    #[test]
    fn angles_come_from_the_first_key_that_has_them() {
        let forward = |keys: &str| projection(&format!("_project_texture SLIDE {keys}")).forward;
        assert!((forward("_project_mangle \"0 90 0\" mangle \"0 0 0\"") - Vec3::Z).length() < 1e-6);
        assert!((forward("mangle \"0 -90 0\"") - Vec3::NEG_Z).length() < 1e-6);
        assert!((forward("angles \"90 0 0\"") - Vec3::NEG_Z).length() < 1e-6);
        assert!(forward("").z.abs() < 1e-6);
    }
}
