//! Light of suns and sky domes (contract section 5.3).

use super::source::Source;
use super::sums::Given;
use super::tiles::{Tile, Tiles};
use super::wanted::Wanted;
use super::{FEW_RAYS, FaceDirt, MANY_RAYS};
use crate::scene::exact::{brightness, dot};
use crate::scene::{Arrival, DirtKeys, LightRays, Sample, Scene, Sun, Surface};
use glam::Vec3;

/// Faces turned away from a sun by this much, as a cosine, are still lit by it.
const BEHIND: f32 = -0.01;

/// Colour that arrives on a surface with unit normal `normal`, in light units, shadows aside.
pub(crate) fn unshadowed(sun: &Sun, normal: Vec3, two_sided: bool) -> Vec3 {
    let cosine = dot(sun.to_sun, normal);
    let cosine = if two_sided { cosine.abs() } else { cosine.max(0.0) };
    let angle = (1.0 - sun.angle_scale) + sun.angle_scale * cosine;
    sun.colour * (angle * sun.brightness / 255.0)
}

/// What arrives at a point of a sun's light of `colour`: none unless the ray towards it meets sky
/// first, and of the right texture.
pub(crate) fn seen(
    scene: &Scene,
    sun: &Sun,
    position: Vec3,
    colour: Vec3,
    rays: &mut LightRays<'_>,
) -> Option<Arrival> {
    let (sky, arrival) = rays.from_sky(position, sun.to_sun, colour)?;
    let texture = scene.surfaces[sky as usize].texture;
    sun.sky_texture.is_none_or(|t| texture == Some(t)).then_some(arrival)
}

/// A sun as one surface sees it.
pub(super) struct SunBeam<'a, 's> {
    scene: &'s Scene,
    sun: &'s Sun,
    surface: &'a Surface,
    samples: &'a [Sample],
    dirt: &'a FaceDirt,
    keys: DirtKeys,
    rays: &'a mut LightRays<'s>,
}

impl<'a, 's> SunBeam<'a, 's> {
    /// `None` if the sun cannot shine on the surface.
    pub fn new(
        (scene, sun): (&'s Scene, &'s Sun),
        surface: &'a Surface,
        (samples, dirt): (&'a [Sample], &'a FaceDirt),
        rays: &'a mut LightRays<'s>,
    ) -> Option<Self> {
        let behind = dot(sun.to_sun, surface.normal) < BEHIND;
        if behind && !surface.curved && !surface.two_sided || surface.channel_mask & 1 == 0 {
            return None;
        }
        let keys = DirtKeys::plain(sun.dirt.unwrap_or(scene.world.dirt.lights));
        Some(Self { scene, sun, surface, samples, dirt, keys, rays })
    }

    /// Whether the sky is surely hidden from all of a tile, by what hid it from the last ray that did not
    /// get there and what is joined to that.
    fn is_walled_off(&mut self, tile: &Tile) -> bool {
        let (blocker, direction) = (self.rays.blocker_of_sky(), self.sun.to_sun);
        blocker.is_some_and(|polygon| self.rays.see_no_sky(&tile.bounds, direction, polygon))
    }

    /// Traces the rays from some samples; whether light arrives at the last of them.
    fn look(&mut self, members: &[u32], wanted: &mut Wanted) -> bool {
        wanted.look(members, |i, colour, filtered| {
            let arrival = seen(self.scene, self.sun, self.samples[i].position, colour, self.rays);
            filtered.extend(self.rays.met_filter().then_some(i as u32));
            arrival
        })
    }
}

impl Source for SunBeam<'_, '_> {
    fn sent(&self, i: usize) -> Option<Vec3> {
        let colour = unshadowed(self.sun, self.samples[i].normal, self.surface.two_sided)
            * self.dirt.factor(i, &self.keys, 0.0);
        (brightness(colour).abs() > self.scene.world.gate).then_some(colour)
    }

    fn may_change_style(&self) -> bool {
        self.scene.has_filters()
    }

    fn trace(&mut self, tiles: &Tiles, tile: &Tile, wanted: &mut Wanted) {
        let members = tiles.members(tile);
        let count = wanted.rays(members);
        if count == 0 {
            return;
        }
        let lit = count < FEW_RAYS || self.look(wanted.one(members), wanted);
        if !lit && self.is_walled_off(tile) {
            return;
        }
        if count >= MANY_RAYS || lit && count >= FEW_RAYS {
            let floor = tiles.floor_along(tile, self.sun.to_sun);
            let narrow = self.rays.skywards(&tile.bounds, floor, self.sun.to_sun, count);
            let parts = tiles.parts(tile);
            if !narrow && count >= MANY_RAYS && !parts.is_empty() {
                parts.iter().for_each(|part| self.trace(tiles, part, wanted));
                return;
            }
            if narrow && self.rays.meet_nothing() {
                wanted.open.extend_from_slice(members);
            }
        }
        if !self.rays.sees_no_sky() {
            self.look(members, wanted);
        }
        self.rays.anywhere();
    }

    fn given(&self, _: usize, arrival: Arrival) -> Given {
        let (sun, colour) = (self.sun, arrival.colour);
        let excess = colour * (1.0 - sun.bounce_scale);
        Given { style: arrival.style_of(sun.style), colour, excess, way: sun.to_sun }
    }

    fn is_even(&self) -> bool {
        !self.surface.curved
    }

    fn dirt(&self) -> Option<DirtKeys> {
        Some(self.keys)
    }

    fn share_left(&self, i: usize) -> f32 {
        self.dirt.factor(i, &self.keys, 0.0)
    }
}
