//! What one point or spot light sends to one point, shadows aside (contract sections 4.4 and 4.5).

use super::{attenuation, spot};
use crate::scene::Light;
use crate::scene::exact::{dot, length};
use glam::Vec3;

/// Nearer lights count as at this distance, straight above.
pub(super) const NEAREST: f32 = 0.1;

/// Colour that arrives at `position` on a surface with unit normal `normal`, in light units; `None`
/// if the light is behind the surface or the point outside the light's cone or picture. `dist` is the world's
/// distance scale.
pub(crate) fn unshadowed<const ANY: bool>(
    light: &Light,
    dist: f32,
    position: Vec3,
    normal: Vec3,
    two_sided: bool,
) -> Option<Vec3> {
    let to_light = light.origin - position;
    let mut d = length(to_light);
    let mut direction = to_light / d;
    if d < NEAREST || d.is_nan() {
        (d, direction) = (NEAREST, Vec3::Z);
    }
    let mut cosine = dot(direction, normal);
    if ANY && (light.bleed || two_sided) {
        cosine = cosine.abs();
    }
    if cosine < 0.0 {
        return None;
    }
    let scale = f64::from(light.angle_scale);
    let angle = ((1.0 - scale) + scale * f64::from(cosine)) as f32;
    let mut add = attenuation::value(light, dist, d) * angle;
    if let Some(spot) = &light.spot {
        add *= spot::share(spot, direction)?;
    }
    let colour = light.colour * add * (1.0 / 255.0);
    match &light.projection {
        Some(picture) if ANY => Some(colour * picture.factor(-to_light)?),
        _ => Some(colour),
    }
}
