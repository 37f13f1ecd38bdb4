//! Light of surfaces that shine in the manner of radiosity (contract section 4.7, mode 1).

use super::dirt::FaceDirt;
use super::{BoundingSphere, Directions, StyleLight, add};
use crate::scene::exact::{dot, length};
use crate::scene::{
    DirtKeys, EmissiveQuality, LightRays, RadiosityLight, Sample, Scene, Surface, SurflightSettings,
};
use glam::Vec3;

/// Light does not get stronger nearer than this, in scaled units.
const NEAREST: f32 = 16.0;
/// Light is dropped if no channel is brighter than this, in light units, except at high quality.
const LEAST: f32 = 0.01;
/// Directions this little behind a surface still count.
const SLACK: f32 = 0.01;

/// Adds what one light surface sends to the samples of a surface.
pub(super) fn light_surface(
    scene: &Scene,
    light: &RadiosityLight,
    (surface, sphere): (&Surface, &BoundingSphere),
    (samples, dirt): (&[Sample], &FaceDirt),
    rays: &mut LightRays<'_>,
    (styles, excess, directions): (&mut Vec<StyleLight>, &mut Vec<StyleLight>, &mut Directions),
) {
    let (settings, dist) = (&scene.world.surflight, scene.world.dist);
    let least = if settings.quality == EmissiveQuality::High { 0.0 } else { LEAST };
    if surface.channel_mask & 1 == 0
        || least > 0.0 && is_out_of_reach(light, sphere, settings, dist)
    {
        return;
    }
    let keys = DirtKeys::plain(true);
    for point in &light.points {
        for (i, sample) in samples.iter().enumerate().filter(|(_, s)| !s.occluded) {
            let normal = (!surface.two_sided).then_some(sample.normal);
            let colour = unshadowed(light, settings, dist, *point, sample.position, normal);
            let Some(colour) = colour.filter(|c| c.max_element() > least) else { continue };
            let Some(arrival) = rays.between(*point, sample.position, 1, colour) else { continue };
            let colour = arrival.colour * dirt.factor(i, &keys, 0.0);
            directions.add(light.style, (i, samples.len()), *point - sample.position, colour);
            add(styles, light.style, samples.len(), i, colour);
            if light.bounce_scale != 1.0 {
                let unsent = colour * (1.0 - light.bounce_scale);
                add(excess, light.style, samples.len(), i, unsent);
            }
        }
    }
}

/// Light that one point of a light surface sends to `to`, shadows aside; `normal` is that of the
/// receiver, if the angle there matters.
pub(super) fn unshadowed(
    light: &RadiosityLight,
    settings: &SurflightSettings,
    dist: f32,
    from: Vec3,
    to: Vec3,
    normal: Option<Vec3>,
) -> Option<Vec3> {
    let way = to - from;
    let mut d = length(way).max(0.01);
    let direction = way / d;
    let mut sent = dot(light.normal, direction);
    let mut received = normal.map_or(1.0, |n| dot(-direction, n));
    let share = if light.all_around {
        d += settings.sky_distance;
        0.5 * received
    } else {
        if sent < -SLACK || received < -SLACK {
            return None;
        }
        if light.rescale {
            sent = 0.5 + 0.5 * sent;
            received = 0.5 + 0.5 * received;
        }
        sent * received
    };
    (share > 0.0).then(|| {
        let h = (dist * light.attenuation * d).max(NEAREST);
        light.colour * (light.intensity / (h * h) * (scale(light, settings) * share))
    })
}

fn scale(light: &RadiosityLight, settings: &SurflightSettings) -> f32 {
    if light.all_around { settings.sky_scale } else { settings.scale }
}

/// Whether the light is too weak for the *farthest* point of the sphere: the contract's Q13.
fn is_out_of_reach(
    light: &RadiosityLight,
    sphere: &BoundingSphere,
    settings: &SurflightSettings,
    dist: f32,
) -> bool {
    let d = length(sphere.centre - light.middle) + sphere.radius;
    let h = (dist * light.attenuation * d).max(NEAREST);
    let colour = light.colour * (light.total / (h * h)) * scale(light, settings);
    colour.max_element() <= LEAST
}
