//! The pinhole camera.

use crate::patch::CameraSpec;
use crate::{Error, Result};
use glam::DVec3;

/// A pinhole camera with a picture of `width` x `height` square pixels. Camera space is
/// (right, up, depth); pixel (0, 0) is the top left one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Eye point, in double precision because scenes may lie far from the origin.
    pub position: DVec3,
    /// Unit direction of view.
    pub forward: DVec3,
    /// Unit direction to the right of the picture, forward x up.
    pub right: DVec3,
    /// Unit direction to the top of the picture.
    pub up: DVec3,
    /// Tangent of half the horizontal field of view.
    pub tan_x: f64,
    /// Tangent of half the vertical field of view.
    pub tan_y: f64,
    /// Picture width in pixels, at least 1.
    pub width: u32,
    /// Picture height in pixels, at least 1.
    pub height: u32,
}

impl Camera {
    /// Vertical field of view for text scenes, which have none of their own, in degrees: it frames
    /// the Cornell box from where its camera stands.
    pub const TEXT_SCENE_FOV: f64 = 40.0;
    /// Horizontal field of view of Quake engines, in degrees.
    pub const QUAKE_FOV: f64 = 90.0;

    /// The camera of a text scene, with a vertical field of view of `fov` degrees.
    ///
    /// # Errors
    /// [`Error::Setting`] if the field of view is not between 0 and 180 degrees, a picture side is
    /// 0 or the camera has no direction (a scene that was read from a file always has one).
    pub fn look_at(spec: &CameraSpec, fov: f64, [width, height]: [u32; 2]) -> Result<Self> {
        let [forward, right, up] = spec.basis().ok_or_else(|| {
            Error::setting("camera", "looks nowhere, or its up direction lies along its view")
        })?;
        check_size(width, height)?;
        let tan_y = half_tangent(fov)?;
        let tan_x = tan_y * f64::from(width) / f64::from(height);
        Ok(Self { position: spec.position, forward, right, up, tan_x, tan_y, width, height })
    }

    /// A camera as Quake places it: `pitch` and `yaw` in degrees, pitch positive looks down, yaw 0
    /// looks along +x and 90 along +y, z is up. `fov` is horizontal, in degrees
    /// ([`Camera::QUAKE_FOV`]).
    ///
    /// # Errors
    /// [`Error::Setting`] if the field of view is not between 0 and 180 degrees, a picture side is
    /// 0 or a number is not finite.
    pub fn quake(
        position: DVec3,
        pitch: f64,
        yaw: f64,
        fov: f64,
        [width, height]: [u32; 2],
    ) -> Result<Self> {
        if !(position.is_finite() && pitch.is_finite() && yaw.is_finite()) {
            return Err(Error::setting("camera", "position, pitch and yaw must be finite numbers"));
        }
        check_size(width, height)?;
        let (sin_pitch, cos_pitch) = pitch.to_radians().sin_cos();
        let (sin_yaw, cos_yaw) = yaw.to_radians().sin_cos();
        let forward = DVec3::new(cos_pitch * cos_yaw, cos_pitch * sin_yaw, -sin_pitch);
        // From yaw alone, so that looking straight up or down keeps a direction.
        let right = DVec3::new(sin_yaw, -cos_yaw, 0.0);
        let up = right.cross(forward);
        let tan_x = half_tangent(fov)?;
        let tan_y = tan_x * f64::from(height) / f64::from(width);
        Ok(Self { position, forward, right, up, tan_x, tan_y, width, height })
    }

    /// The ray through picture point (`x`, `y`) in pixels, in camera space with depth 1. Pixel
    /// centres are at halves.
    pub fn ray(&self, x: f64, y: f64) -> DVec3 {
        DVec3::new(
            (2.0 * x / f64::from(self.width) - 1.0) * self.tan_x,
            (1.0 - 2.0 * y / f64::from(self.height)) * self.tan_y,
            1.0,
        )
    }

    /// A world point in camera space: (right, up, depth) in world units.
    pub fn to_camera(&self, point: DVec3) -> DVec3 {
        let p = point - self.position;
        DVec3::new(p.dot(self.right), p.dot(self.up), p.dot(self.forward))
    }

    /// The picture point, in pixels, of a camera-space point of positive depth.
    pub fn project(&self, point: DVec3) -> [f64; 2] {
        [
            (point.x / (point.z * self.tan_x) + 1.0) * 0.5 * f64::from(self.width),
            (1.0 - point.y / (point.z * self.tan_y)) * 0.5 * f64::from(self.height),
        ]
    }
}

fn check_size(width: u32, height: u32) -> Result<()> {
    if width == 0 || height == 0 {
        return Err(Error::setting("picture size", "width and height must be at least 1"));
    }
    Ok(())
}

fn half_tangent(fov: f64) -> Result<f64> {
    if !(0.01..=179.0).contains(&fov) {
        return Err(Error::setting(
            "fov",
            format!("{fov} is out of range: the field of view goes from 0.01 to 179 degrees"),
        ));
    }
    Ok((fov.to_radians() / 2.0).tan())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: DVec3, b: DVec3) -> bool {
        a.distance(b) < 1e-12
    }

    #[test]
    fn quake_angles_follow_the_engine() {
        let camera = |pitch, yaw| Camera::quake(DVec3::ZERO, pitch, yaw, 90.0, [640, 480]).unwrap();
        let level = camera(0.0, 0.0);
        assert!(near(level.forward, DVec3::X) && near(level.right, -DVec3::Y));
        assert!(near(level.up, DVec3::Z));
        assert!(near(camera(0.0, 90.0).forward, DVec3::Y));
        let down = camera(90.0, 0.0);
        assert!(near(down.forward, -DVec3::Z) && near(down.up, DVec3::X));
        assert!((level.tan_x - 1.0).abs() < 1e-12 && (level.tan_y - 0.75).abs() < 1e-12);
    }

    #[test]
    fn rays_and_projection_agree() {
        let spec = CameraSpec {
            position: DVec3::new(1e5, -1e5, 40.0),
            look_at: DVec3::new(1e5 + 3.0, -1e5 + 1.0, 42.0),
            up: DVec3::new(0.0, 0.2, 5.0),
        };
        let camera = Camera::look_at(&spec, 40.0, [320, 200]).unwrap();
        for (x, y) in [(0.5, 0.5), (319.5, 0.5), (160.0, 100.0), (12.25, 187.0)] {
            let [px, py] = camera.project(camera.ray(x, y) * 7.5);
            assert!((px - x).abs() < 1e-9 && (py - y).abs() < 1e-9);
        }
        let middle = camera.to_camera(spec.look_at);
        assert!(middle.x.abs() < 1e-9 && middle.y.abs() < 1e-9);
        assert!((middle.z - spec.look_at.distance(spec.position)).abs() < 1e-9);
    }

    #[test]
    fn impossible_cameras_are_refused() {
        for fov in [0.0, -40.0, 180.0, f64::NAN, f64::INFINITY] {
            assert!(Camera::quake(DVec3::ZERO, 0.0, 0.0, fov, [4, 4]).is_err(), "{fov}");
        }
        assert!(Camera::quake(DVec3::NAN, 0.0, 0.0, 90.0, [4, 4]).is_err());
        assert!(Camera::quake(DVec3::ZERO, 0.0, 0.0, 90.0, [4, 0]).is_err());
    }
}
