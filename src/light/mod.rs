//! Direct light: the irradiance that lights send straight to points of surfaces, in light units
//! before range scaling (contract sections 4.4 to 4.6). One file an effect.

mod adaptive;
mod attenuation;
mod beam;
mod blockers;
mod bounce_source;
mod candidates;
mod cells;
mod directions;
mod dirt;
mod in_time;
mod lattice;
mod minlight;
mod point;
mod probe;
mod radiosity;
mod ray_counts;
mod reach;
mod source;
mod spot;
mod spread;
mod sums;
mod sun;
mod tiles;
mod totals;
mod wanted;

pub use blockers::Blockers;
pub use bounce_source::bounce_source;
pub use candidates::Candidates;
pub use directions::{Directions, StyleDirections, strength};
pub use dirt::FaceDirt;
pub use in_time::{InTime, Receivers, direct_in_time};
pub use minlight::Probe;
pub(crate) use minlight::{mottle, wants_probe};
pub(crate) use probe::{SIDES, place as probe_place, probe, probe_sides};
pub use ray_counts::RayCounts;
pub use reach::{Reaches, reaches};

use crate::photometry::Irradiance;
use crate::scene::effects::COMPILED;
use crate::scene::exact::{brightness, dot, length};
use crate::scene::{Light, LightRays, Sample, Scene, Surface};
use beam::Beam;
use glam::Vec3;
use ray_counts::Since;
use sums::add;
use sun::SunBeam;
use totals::{LitPoints, Totals};
use wanted::Wanted;

/// Fewer rays than this from a tile to a light are not worth a look at what is between.
const FEW_RAYS: usize = 8;
/// This many are worth a look even where the first of them arrives at no light.
const MANY_RAYS: usize = 64;

/// Irradiance of one light style at a list of samples.
#[derive(Clone, Debug, PartialEq)]
pub struct StyleLight {
    /// The light style.
    pub style: u16,
    /// Irradiance in light units, in the order of the samples; zero where none arrives.
    pub irradiance: Vec<Irradiance>,
}

/// Direct light on one surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DirectLight {
    /// Light by style, in the order in which the styles first lit the surface; never all zero.
    pub styles: Vec<StyleLight>,
    /// What negative lights take away, as negative irradiance. It bounces like other light, and is to
    /// be added last, after bounced and minimum light, and the sum then limited to 0 and up.
    pub negative: Vec<StyleLight>,
    /// Part of `styles` and `negative` that does not bounce, below zero where more bounces than
    /// arrives: see [`bounce_source`].
    pub excess: Vec<StyleLight>,
    /// Minimum light of local lights, which does not bounce. It is to be joined with the
    /// other direct light before bounced light is added.
    pub local_minimum: Vec<StyleLight>,
    /// Where `styles` and `negative` come from, if that is wanted.
    pub directions: Directions,
    /// Dirt at the samples.
    pub dirt: FaceDirt,
    /// Rays traced.
    pub rays: RayCounts,
}

/// Lights the samples of a surface.
pub fn direct(scene: &Scene, surface: usize, samples: &[Sample]) -> DirectLight {
    direct_from(scene, surface, samples, Directions::default(), &mut Blockers::new(scene))
}

/// Lights the samples of a surface and adds to `directions` where the light comes from. `blockers`
/// are best kept from one surface to the next.
pub fn direct_from(
    scene: &Scene,
    surface: usize,
    samples: &[Sample],
    directions: Directions,
    blockers: &mut Blockers,
) -> DirectLight {
    light(scene, surface, (samples, 1), directions, blockers)
}

/// As [`direct_from`], for `extra` x `extra` samples a luxel, of which not all are traced where that
/// makes little difference to the luxel.
pub fn direct_adaptive(
    scene: &Scene,
    surface: usize,
    (samples, extra): (&[Sample], u32),
    directions: Directions,
    blockers: &mut Blockers,
) -> DirectLight {
    light(scene, surface, (samples, extra), directions, blockers)
}

fn light(
    scene: &Scene,
    index: usize,
    (samples, extra): (&[Sample], u32),
    directions: Directions,
    blockers: &mut Blockers,
) -> DirectLight {
    let mut result = DirectLight { directions, ..DirectLight::default() };
    if samples.is_empty() {
        return result;
    }
    let surface = &scene.surfaces[index];
    let mut rays = LightRays::new(scene, surface.model);
    let points = LitPoints::new(surface, samples, extra);
    let (mut since, mut counts) = (Since::now(&rays), RayCounts::default());
    result.dirt = FaceDirt::trace(scene, index, (samples, &points), &mut rays);
    since.count(&rays, &mut counts.dirt);
    if surface.light_ignore {
        result.rays = counts;
        return result;
    }
    let dirt = std::mem::take(&mut result.dirt);
    let sphere = BoundingSphere::of(surface);
    let leafs = Leafs::of(scene, samples, points.first());
    let mut wanted = Wanted::new(samples.len());
    let mut totals = Totals::new(scene, &points, samples.len(), &mut result);
    for index in blockers.lights_of(index) {
        let index = index as usize;
        let light = &scene.lights[index];
        let reach = scene.visibility.of_light(index);
        if !leafs.distinct.iter().any(|l| reach.includes(*l)) {
            continue;
        }
        let mut beam = Beam {
            scene,
            light: index,
            surface,
            samples,
            dirt: &dirt,
            leafs: (&leafs.of_samples, reach),
            blockers,
            rays: &mut rays,
        };
        if points.whole().is_none_or(|whole| beam.is_covered(whole)) || !beam.reaches(&sphere) {
            continue;
        }
        totals.add(&mut beam, light.brightness > 0.0, &points, &mut wanted);
        let is_copy = light.piece_radius > 0.0;
        let count = if is_copy { &mut counts.surface_lights } else { &mut counts.lights };
        since.count(&rays, count);
    }
    for sun in scene.suns.iter().filter(|_| COMPILED) {
        let beam = SunBeam::new((scene, sun), surface, (samples, &dirt), &mut rays);
        let Some(mut beam) = beam else { continue };
        totals.add(&mut beam, sun.brightness > 0.0, &points, &mut wanted);
        since.count(&rays, if sun.dome { &mut counts.sky_domes } else { &mut counts.suns });
    }
    totals.spread(&points, &dirt);
    for light in scene.radiosity_lights.iter().filter(|_| COMPILED) {
        let receiver = (surface, &sphere);
        let sums = (&mut result.styles, &mut result.excess, &mut result.directions);
        radiosity::light_surface(scene, light, receiver, (samples, &dirt), &mut rays, sums);
        since.count(&rays, &mut counts.surface_lights);
    }
    result.local_minimum =
        minlight::local(scene, surface, (samples, &dirt), &result.styles, &mut rays);
    since.count(&rays, &mut counts.minlight);
    counts.filtered = rays.filtered_rays();
    (result.dirt, result.rays) = (dirt, counts);
    result
}

/// What comes after bounced light, on the sum of all light of a surface: minimum light and then what
/// negative lights take away. `probe` is the light at the middle of the surface's brush model. Tells
/// whether all samples count as free, even those inside solid.
pub(crate) fn post(
    scene: &Scene,
    surface: &Surface,
    samples: &[Sample],
    direct: &DirectLight,
    probe: Option<&Probe>,
    maps: &mut Vec<StyleLight>,
) -> bool {
    if scene.world.no_lighting {
        return false;
    }
    minlight::global(scene, surface, (samples, &direct.dirt), maps);
    let free = minlight::automatic(surface, samples, probe, maps);
    for negative in &direct.negative {
        accumulate(maps, negative);
    }
    free
}

/// The direct light of a surface with the minimum light of local lights.
pub(crate) fn with_local_minimum(scene: &Scene, direct: &mut DirectLight) -> Vec<StyleLight> {
    let mut maps = std::mem::take(&mut direct.styles);
    minlight::join_local(&scene.world, &mut maps, &direct.local_minimum);
    maps
}

/// Adds `more` to the map of its style, which is made if it is not there.
pub(crate) fn accumulate(maps: &mut Vec<StyleLight>, more: &StyleLight) {
    match maps.iter_mut().find(|m| m.style == more.style) {
        Some(map) => {
            for (sum, e) in map.irradiance.iter_mut().zip(&more.irradiance) {
                *sum += *e;
            }
        }
        None => maps.push(more.clone()),
    }
}

/// Direct light at a point with a unit normal that belongs to no surface: style and irradiance,
/// negative lights included, in the order of the lights, then of the suns.
pub fn at(scene: &Scene, position: Vec3, normal: Vec3) -> Vec<(u16, Irradiance)> {
    let mut rays = LightRays::new(scene, None);
    let mut styles: Vec<(u16, Irradiance)> = Vec::new();
    let mut add = |style: u16, colour: Vec3| match styles.iter_mut().find(|s| s.0 == style) {
        Some(style) => style.1 += Irradiance(colour),
        None => styles.push((style, Irradiance(colour))),
    };
    for light in &scene.lights {
        let Some(colour) =
            point::unshadowed::<COMPILED>(light, scene.world.dist, position, normal, false)
        else {
            continue;
        };
        if brightness(colour).abs() <= scene.world.gate {
            continue;
        }
        if let Some(arrival) = rays.between(position, light.origin, light.shadow_mask, colour) {
            add(arrival.style_of(light.style), arrival.colour);
        }
    }
    for sun in &scene.suns {
        let colour = sun::unshadowed(sun, normal, false);
        if brightness(colour).abs() <= scene.world.gate {
            continue;
        }
        if let Some(arrival) = sun::seen(scene, sun, position, colour, &mut rays) {
            add(arrival.style_of(sun.style), arrival.colour);
        }
    }
    styles
}

/// Where some samples of a surface are; nothing is known of the others.
struct Leafs {
    of_samples: Vec<Option<u32>>,
    distinct: Vec<Option<u32>>,
}

impl Leafs {
    fn of(scene: &Scene, samples: &[Sample], wanted: &[u32]) -> Self {
        let mut of_samples = vec![None; samples.len()];
        let mut distinct = Vec::new();
        for &i in wanted {
            let leaf = scene.visibility.leaf(&scene.solid, samples[i as usize].position);
            of_samples[i as usize] = leaf;
            distinct.push(leaf);
        }
        distinct.sort_unstable();
        distinct.dedup();
        Self { of_samples, distinct }
    }
}

/// A sphere around a surface.
struct BoundingSphere {
    centre: Vec3,
    radius: f32,
}

impl BoundingSphere {
    /// The sphere around the bounding box of the surface.
    fn of(surface: &Surface) -> Self {
        let corners = || surface.vertices.iter().copied();
        let min = corners().fold(Vec3::INFINITY, Vec3::min);
        let max = corners().fold(Vec3::NEG_INFINITY, Vec3::max);
        Self { centre: (min + max) * 0.5, radius: length((max - min) * 0.5) }
    }

    /// Whether the light is too weak for the nearest point of the sphere.
    fn is_out_of_reach(&self, light: &Light, dist: f32, gate: f32) -> bool {
        let to_light = light.origin - self.centre;
        let d = dot(to_light, to_light).sqrt() - self.radius;
        d >= 0.0 && attenuation::value(light, dist, d).abs() <= gate
    }
}
