//! The rays from the samples of a surface to a point or spot light.

use super::reach::may_shine_on;
use super::source::Source;
use super::sums::Given;
use super::tiles::{Tile, Tiles};
use super::wanted::Wanted;
use super::{Blockers, BoundingSphere, FEW_RAYS, FaceDirt, MANY_RAYS, attenuation, point};
use crate::scene::effects::COMPILED;
use crate::scene::exact::{brightness, length};
use crate::scene::{Arrival, DirtKeys, Hidden, LightRays, Reach, Sample, Scene, Surface};
use glam::Vec3;

/// A light as one surface sees it.
pub(super) struct Beam<'a, 's> {
    pub scene: &'s Scene,
    /// Index of the light.
    pub light: usize,
    pub surface: &'a Surface,
    pub samples: &'a [Sample],
    pub dirt: &'a FaceDirt,
    /// Leaf of each sample, where it is known, and those that the light reaches.
    pub leafs: (&'a [Option<u32>], Reach<'a>),
    pub blockers: &'a mut Blockers,
    pub rays: &'a mut LightRays<'s>,
}

impl Beam<'_, '_> {
    /// Whether the light can shine on any sample at all.
    pub fn reaches(&self, sphere: &BoundingSphere) -> bool {
        let light = &self.scene.lights[self.light];
        may_shine_on(&self.scene.world, light, self.surface, sphere)
    }

    /// Whether all of a tile is surely in the dark. Only light of channel 1 is held back by the world.
    pub fn is_covered(&self, tile: &Tile) -> bool {
        let shadowed = self.scene.lights[self.light].shadow_mask & 1 != 0;
        shadowed && self.blockers.cover(self.light, &tile.bounds)
    }

    /// Whether neither the light nor the surface is anything but plain: shines a picture, takes light from
    /// behind or has dirt.
    fn is_plain(&self) -> bool {
        let light = &self.scene.lights[self.light];
        let either_side = light.bleed || self.surface.two_sided;
        !COMPILED || !either_side && light.projection.is_none() && self.dirt.is_none()
    }

    /// See [`Source::sent`]; without `ANY`, all must be plain.
    #[inline]
    fn sent_as<const ANY: bool>(&self, i: usize) -> Option<Vec3> {
        let (light, sample, world) =
            (&self.scene.lights[self.light], &self.samples[i], &self.scene.world);
        if !self.leafs.1.includes(self.leafs.0[i]) {
            return None;
        }
        let (at, normal) = (sample.position, sample.normal);
        let two_sided = self.surface.two_sided;
        let mut colour = point::unshadowed::<ANY>(light, world.dist, at, normal, two_sided)?;
        if ANY {
            colour *= self.dirt.factor(i, &light.dirt, length(light.origin - at));
        }
        (brightness(colour).abs() > world.gate).then_some(colour)
    }

    /// Whether all of a tile is surely in the dark, behind what blocked the last ray that was blocked
    /// and what is joined to that.
    fn is_walled_off(&mut self, tile: &Tile) -> bool {
        let light = self.scene.lights[self.light].origin;
        let Some(blocker) = self.rays.blocker() else { return false };
        self.rays.look_at(&tile.bounds, light)
            && matches!(self.rays.hidden_by(blocker), Hidden::All(_))
    }

    /// Remembers what blocked the last ray that was blocked.
    fn remember(&mut self) {
        if let Some(polygon) = self.rays.blocker() {
            self.blockers.remember(self.scene, self.light, polygon);
        }
    }

    /// Traces the rays to some samples; whether light arrives at the last of them.
    fn look(&mut self, members: &[u32], wanted: &mut Wanted) -> bool {
        let light = &self.scene.lights[self.light];
        let (origin, mask) = (light.origin, light.shadow_mask);
        if !self.scene.has_filters() {
            return wanted.look(members, |i, colour, _| {
                let arrives = self.rays.is_open(self.samples[i].position, origin, mask);
                arrives.then_some(Arrival { colour, style: None })
            });
        }
        wanted.look(members, |i, colour, filtered| {
            let arrival = self.rays.between(self.samples[i].position, origin, mask, colour);
            filtered.extend(self.rays.met_filter().then_some(i as u32));
            arrival
        })
    }
}

impl Source for Beam<'_, '_> {
    fn sent(&self, i: usize) -> Option<Vec3> {
        self.sent_as::<COMPILED>(i)
    }

    fn want(&self, samples: &[u32], wanted: &mut Wanted) -> bool {
        if self.is_plain() {
            wanted.want(samples, |i| self.sent_as::<false>(i))
        } else {
            wanted.want(samples, |i| self.sent_as::<true>(i))
        }
    }

    fn may_change_style(&self) -> bool {
        self.scene.has_filters()
    }

    fn trace(&mut self, tiles: &Tiles, tile: &Tile, wanted: &mut Wanted) {
        let members = tiles.members(tile);
        let count = wanted.rays(members);
        if count == 0 || self.is_covered(tile) {
            return;
        }
        let light = &self.scene.lights[self.light];
        let shadowed = light.shadow_mask & 1 != 0;
        self.rays.suppose(self.blockers.of(self.light));
        let lit = count < FEW_RAYS || self.look(wanted.one(members), wanted);
        if !lit && shadowed {
            self.remember();
            if self.is_covered(tile) || self.is_walled_off(tile) {
                return;
            }
        }
        let many = count >= MANY_RAYS;
        if many || lit && count >= FEW_RAYS {
            let floor = tiles.floor_with(tile, std::iter::once(light.origin));
            let narrow = self.rays.towards(&tile.bounds, floor, light.origin, count);
            let parts = tiles.parts(tile);
            if !narrow && many && !parts.is_empty() {
                parts.iter().for_each(|part| self.trace(tiles, part, wanted));
                return;
            }
            if narrow && self.rays.meet_nothing() {
                wanted.open.extend_from_slice(members);
            }
        }
        self.look(members, wanted);
        self.rays.anywhere();
        if shadowed {
            self.remember();
        }
    }

    #[inline(always)]
    fn given(&self, i: usize, arrival: Arrival) -> Given {
        let light = &self.scene.lights[self.light];
        let way = light.origin - self.samples[i].position;
        let share = (1.0 - attenuation::excess(light, self.scene.world.dist, length(way)))
            * light.bounce_scale;
        let colour = arrival.colour;
        Given { style: arrival.style_of(light.style), colour, excess: colour * (1.0 - share), way }
    }

    fn is_even(&self) -> bool {
        false
    }

    fn dirt(&self) -> Option<DirtKeys> {
        let keys = self.scene.lights[self.light].dirt;
        (keys.radii.is_none() || self.dirt.is_none()).then_some(keys)
    }

    fn share_left(&self, i: usize) -> f32 {
        self.dirt.factor(i, &self.scene.lights[self.light].dirt, 0.0)
    }
}
