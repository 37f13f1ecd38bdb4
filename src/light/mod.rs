//! Direct light: the irradiance that lights send straight to points of surfaces, in light units
//! before range scaling (contract sections 4.4 to 4.6). One file an effect.

mod attenuation;
mod blockers;
mod bounce_source;
mod directions;
mod dirt;
mod in_time;
mod lattice;
mod minlight;
mod point;
mod probe;
mod radiosity;
mod ray_counts;
mod spot;
mod spread;
mod sun;
mod tiles;

pub use blockers::Blockers;
pub use bounce_source::bounce_source;
pub use directions::{Directions, StyleDirections, strength};
pub use dirt::FaceDirt;
pub use in_time::{InTime, Receivers, direct_in_time};
pub use minlight::Probe;
pub(crate) use minlight::{mottle, wants_probe};
pub(crate) use probe::{SIDES, place as probe_place, probe, probe_sides};
pub use ray_counts::RayCounts;

use crate::photometry::Irradiance;
use crate::scene::effects::COMPILED;
use crate::scene::exact::{brightness, distance, dot, length};
use crate::scene::{Arrival, Light, LightRays, Reach, Sample, Scene, Surface};
use glam::Vec3;
use ray_counts::Since;
use tiles::{Tile, Tiles};

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
    let mut result = DirectLight { directions, ..DirectLight::default() };
    if samples.is_empty() {
        return result;
    }
    let mut rays = LightRays::new(scene, scene.surfaces[surface].model);
    let tiles = Tiles::new(samples, scene.surfaces[surface].normal);
    let (mut since, mut counts) = (Since::now(&rays), RayCounts::default());
    result.dirt = FaceDirt::trace(scene, surface, (samples, &tiles), &mut rays);
    since.count(&rays, &mut counts.dirt);
    let surface = &scene.surfaces[surface];
    if surface.light_ignore {
        result.rays = counts;
        return result;
    }
    let sphere = BoundingSphere::of(surface);
    let points = (samples, &result.dirt);
    let leafs = Leafs::of(scene, samples);
    let whole = tiles.whole();
    let mut wanted = Wanted::new(samples.len());
    for (index, light) in scene.lights.iter().enumerate() {
        let reach = scene.visibility.of_light(index);
        if !leafs.distinct.iter().any(|l| reach.includes(*l)) {
            continue;
        }
        // Only light of channel 1 is held back by the world.
        let shadowed = light.shadow_mask & 1 != 0;
        let Some(whole) = whole.filter(|w| !shadowed || !blockers.cover(index, &w.bounds)) else {
            continue;
        };
        let styles = if light.brightness > 0.0 { &mut result.styles } else { &mut result.negative };
        let sums = (styles, &mut result.excess, &mut result.directions);
        let points = (samples, &result.dirt, &leafs.of_samples[..], reach);
        let receiver = (surface, &sphere);
        if !send(scene, light, receiver, points, &mut wanted) {
            continue;
        }
        let mut beam = Beam { scene, light: index, blockers, rays: &mut rays, tiles: &tiles };
        beam.trace(whole, samples, &mut wanted);
        receive(scene, light, samples, &mut wanted, sums);
        let is_copy = light.piece_radius > 0.0;
        let count = if is_copy { &mut counts.surface_lights } else { &mut counts.lights };
        since.count(&rays, count);
    }
    for sun in scene.suns.iter().filter(|_| COMPILED) {
        let styles = if sun.brightness > 0.0 { &mut result.styles } else { &mut result.negative };
        let sums = (styles, &mut result.excess, &mut result.directions);
        sun::light_surface(scene, sun, surface, points, (&tiles, &mut wanted), &mut rays, sums);
        since.count(&rays, if sun.dome { &mut counts.sky_domes } else { &mut counts.suns });
    }
    for light in scene.radiosity_lights.iter().filter(|_| COMPILED) {
        let receiver = (surface, &sphere);
        let sums = (&mut result.styles, &mut result.excess, &mut result.directions);
        radiosity::light_surface(scene, light, receiver, points, &mut rays, sums);
        since.count(&rays, &mut counts.surface_lights);
    }
    result.local_minimum = minlight::local(scene, surface, points, &result.styles, &mut rays);
    since.count(&rays, &mut counts.minlight);
    counts.filtered = rays.filtered_rays();
    result.rays = counts;
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
        let Some(colour) = point::unshadowed(light, scene.world.dist, position, normal, false)
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

/// What one light sends to each sample of a surface.
struct Wanted {
    /// Colour that arrives if nothing is in the way; `None` where no ray is needed.
    sent: Vec<Option<Vec3>>,
    /// What does arrive.
    arrived: Vec<Option<Arrival>>,
}

impl Wanted {
    fn new(samples: usize) -> Self {
        Self { sent: vec![None; samples], arrived: vec![None; samples] }
    }

    /// Number of samples of a tile that need a ray.
    fn rays(&self, members: &[u32]) -> usize {
        members.iter().filter(|&&i| self.sent[i as usize].is_some()).count()
    }

    /// One of the samples of a tile that need a ray, from the middle of them.
    fn one<'m>(&self, members: &'m [u32]) -> &'m [u32] {
        let needs = |&i: &usize| self.sent[members[i] as usize].is_some();
        let middle = members.len() / 2;
        (middle..members.len()).chain(0..middle).find(needs).map_or(&[], |i| &members[i..=i])
    }

    /// Asks `seen` what arrives of the light that is sent to each of the samples. Whether any
    /// arrives at the last.
    fn look(
        &mut self,
        members: &[u32],
        mut seen: impl FnMut(usize, Vec3) -> Option<Arrival>,
    ) -> bool {
        let mut arrives = false;
        for &i in members {
            let i = i as usize;
            if let Some(colour) = self.sent[i] {
                self.arrived[i] = seen(i, colour);
                arrives = self.arrived[i].is_some();
            }
        }
        arrives
    }

    /// What arrived, sample by sample; afterwards nothing is wanted any more.
    fn take(&mut self) -> impl Iterator<Item = (usize, Arrival)> + '_ {
        self.sent.fill(None);
        self.arrived.iter_mut().enumerate().filter_map(|(i, a)| a.take().map(|a| (i, a)))
    }
}

/// Finds what one light would send to the samples of a surface if nothing were in the way; whether
/// that is anything.
fn send(
    scene: &Scene,
    light: &Light,
    (surface, sphere): (&Surface, &BoundingSphere),
    (samples, dirt, leafs, reach): (&[Sample], &FaceDirt, &[Option<u32>], Reach<'_>),
    wanted: &mut Wanted,
) -> bool {
    let (dist, gate) = (scene.world.dist, scene.world.gate);
    let behind = distance(light.origin, surface.normal, surface.dist) < 0.0;
    if behind && !light.bleed && !surface.two_sided && !surface.curved
        || sphere.is_out_of_reach(light, dist, gate)
        || light.channel_mask & surface.channel_mask == 0
    {
        return false;
    }
    let mut any = false;
    for (i, sample) in samples.iter().enumerate().filter(|(_, s)| !s.occluded) {
        if !reach.includes(leafs[i]) {
            continue;
        }
        let Some(colour) =
            point::unshadowed(light, dist, sample.position, sample.normal, surface.two_sided)
        else {
            continue;
        };
        let away = length(light.origin - sample.position);
        let colour = colour * dirt.factor(i, &light.dirt, away);
        if brightness(colour).abs() > gate {
            wanted.sent[i] = Some(colour);
            any = true;
        }
    }
    any
}

/// The rays from a surface to a light.
struct Beam<'a, 's> {
    scene: &'s Scene,
    light: usize,
    blockers: &'a mut Blockers,
    rays: &'a mut LightRays<'s>,
    tiles: &'a Tiles,
}

impl Beam<'_, '_> {
    /// Finds what arrives at the samples of a tile.
    fn trace(&mut self, tile: &Tile, samples: &[Sample], wanted: &mut Wanted) {
        let members = self.tiles.members(tile);
        let count = wanted.rays(members);
        let light = &self.scene.lights[self.light];
        let shadowed = light.shadow_mask & 1 != 0;
        if count == 0 || shadowed && self.blockers.cover(self.light, &tile.bounds) {
            return;
        }
        self.rays.suppose(self.blockers.of(self.light));
        let lit = count < FEW_RAYS || self.look(wanted.one(members), samples, wanted);
        if !lit && shadowed {
            self.remember();
            if self.blockers.cover(self.light, &tile.bounds) {
                return;
            }
        }
        let many = count >= MANY_RAYS;
        if many || lit && count >= FEW_RAYS {
            let floor = self.tiles.floor_with(tile, std::iter::once(light.origin));
            let narrow = self.rays.towards(&tile.bounds, floor, light.origin, count);
            let parts = self.tiles.parts(tile);
            if !narrow && many && !parts.is_empty() {
                parts.iter().for_each(|part| self.trace(part, samples, wanted));
                return;
            }
        }
        self.look(members, samples, wanted);
        self.rays.anywhere();
        if shadowed {
            self.remember();
        }
    }

    /// Remembers what blocked the last ray that was blocked.
    fn remember(&mut self) {
        if let Some(polygon) = self.rays.blocker() {
            self.blockers.remember(self.scene, self.light, polygon);
        }
    }

    /// Traces the rays to some samples; whether light arrives at the last of them.
    fn look(&mut self, members: &[u32], samples: &[Sample], wanted: &mut Wanted) -> bool {
        let light = &self.scene.lights[self.light];
        wanted.look(members, |i, colour| {
            self.rays.between(samples[i].position, light.origin, light.shadow_mask, colour)
        })
    }
}

/// Adds what arrived of a light to the sums of a surface.
fn receive(
    scene: &Scene,
    light: &Light,
    samples: &[Sample],
    wanted: &mut Wanted,
    (styles, excess, directions): (&mut Vec<StyleLight>, &mut Vec<StyleLight>, &mut Directions),
) {
    for (i, arrival) in wanted.take() {
        let style = arrival.style_of(light.style);
        let way = light.origin - samples[i].position;
        directions.add(style, (i, samples.len()), way, arrival.colour);
        add(styles, style, samples.len(), i, arrival.colour);
        let share =
            (1.0 - attenuation::excess(light, scene.world.dist, length(way))) * light.bounce_scale;
        if share != 1.0 {
            add(excess, style, samples.len(), i, arrival.colour * (1.0 - share));
        }
    }
}

/// Adds light of a style to sample `i` of `count`.
fn add(styles: &mut Vec<StyleLight>, style: u16, count: usize, i: usize, colour: Vec3) {
    let slot = styles.iter().position(|s| s.style == style).unwrap_or_else(|| {
        styles.push(StyleLight { style, irradiance: vec![Irradiance::ZERO; count] });
        styles.len() - 1
    });
    styles[slot].irradiance[i] += Irradiance(colour);
}

/// Where the samples of a surface are.
struct Leafs {
    of_samples: Vec<Option<u32>>,
    distinct: Vec<Option<u32>>,
}

impl Leafs {
    fn of(scene: &Scene, samples: &[Sample]) -> Self {
        let leaf = |s: &Sample| scene.visibility.leaf(&scene.solid, s.position);
        let of_samples: Vec<_> = samples.iter().map(leaf).collect();
        let mut distinct = of_samples.clone();
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
