//! Takes out of a scene what its effects do not need.

use super::{Effect, Switches};
use crate::photometry::{Exitance, Reflectance};
use crate::scene::exact::brightness;
use crate::scene::{
    AutoMinlight, Emitter, Light, Model, RadiosityLight, Role, Shading, Sun, Surface, WorldSettings,
};
use glam::Vec3;
use std::sync::Arc;

/// The parts of a scene that effects are made of, before anything is built on them.
pub(crate) struct Parts<'a> {
    pub surfaces: &'a mut [Surface],
    pub models: &'a mut [Model],
    pub lights: &'a mut Vec<Light>,
    pub local_minlights: &'a mut Vec<Light>,
    pub radiosity_lights: &'a mut Vec<RadiosityLight>,
    pub suns: &'a mut Vec<Sun>,
    pub emitters: &'a mut Vec<Emitter>,
    pub world: &'a mut WorldSettings,
    pub shadings: &'a mut Vec<Option<Arc<Shading>>>,
}

/// Takes out what is switched off, and suns that no sky lets through.
pub(crate) fn apply(switches: &Switches, parts: &mut Parts<'_>) {
    let off = |effect| switches.off(effect);
    if !parts.surfaces.iter().any(|s| s.role == Role::Sky) {
        parts.suns.clear();
    }
    if off(Effect::Suns) {
        parts.suns.retain(|s| s.dome);
    }
    if off(Effect::SkyDomes) {
        parts.suns.retain(|s| !s.dome);
    }
    if off(Effect::Lights) {
        parts.lights.retain(|l| l.piece_radius > 0.0);
        parts.local_minlights.clear();
    }
    if off(Effect::SurfaceLights) {
        parts.lights.retain(|l| l.piece_radius == 0.0);
        parts.radiosity_lights.clear();
        parts.emitters.clear();
    }
    if off(Effect::NegativeLight) {
        parts.lights.retain(|l| l.brightness > 0.0);
        parts.suns.retain(|s| s.brightness > 0.0);
    }
    if off(Effect::Projections) {
        parts.lights.iter_mut().for_each(|l| l.projection = None);
    }
    if off(Effect::Styles) {
        parts.make_steady();
    }
    if off(Effect::Minlight) {
        parts.remove_minlight();
    }
    if off(Effect::Dirt) {
        parts.world.dirt.in_use = false;
        (parts.world.dirt.lights, parts.world.dirt.minlight) = (false, false);
        let lights = parts.lights.iter_mut().chain(parts.local_minlights.iter_mut());
        lights.for_each(|l| l.dirt.wanted = false);
        parts.suns.iter_mut().for_each(|s| s.dirt = Some(false));
    }
    if off(Effect::Phong) {
        parts.world.phong = false;
        parts.surfaces.iter_mut().for_each(|s| s.curved = false);
    }
    if off(Effect::Bounces) {
        parts.world.bounce.most = Some(0);
    }
    parts.remove_filters(switches);
    if off(Effect::Curtains) {
        parts.surfaces.iter_mut().for_each(|s| s.diffuse = None);
    }
    if off(Effect::Shaders) {
        parts.shadings.iter_mut().flatten().for_each(|s| Arc::make_mut(s).make_even());
    }
    if off(Effect::Colour) {
        parts.remove_colour();
    }
}

impl Parts<'_> {
    fn make_steady(&mut self) {
        self.lights.iter_mut().for_each(|l| l.style = 0);
        self.local_minlights.iter_mut().for_each(|l| l.style = 0);
        self.radiosity_lights.iter_mut().for_each(|l| l.style = 0);
        self.suns.iter_mut().for_each(|s| s.style = 0);
        self.emitters.iter_mut().for_each(|e| e.style = 0);
        for glow in self.surfaces.iter_mut().filter_map(|s| s.minlight.glow.as_mut()) {
            glow.style = 0;
        }
        self.models.iter_mut().for_each(|m| m.switch_style = 0);
    }

    fn remove_minlight(&mut self) {
        self.local_minlights.clear();
        self.world.minlight = 0.0;
        for minlight in self.surfaces.iter_mut().map(|s| &mut s.minlight) {
            (minlight.level, minlight.glow, minlight.auto) = (0.0, None, AutoMinlight::Off);
        }
    }

    /// Surfaces that would filter light let all of it pass.
    fn remove_filters(&mut self, switches: &Switches) {
        for surface in self.surfaces.iter_mut() {
            if surface.role == Role::Filter && switches.off(kind_of_filter(surface)) {
                surface.role = Role::Ghost;
            }
        }
    }

    fn remove_colour(&mut self) {
        let grey = |colour: &mut Vec3| *colour = Vec3::splat(brightness(*colour));
        self.lights.iter_mut().for_each(|l| grey(&mut l.colour));
        self.local_minlights.iter_mut().for_each(|l| grey(&mut l.colour));
        self.radiosity_lights.iter_mut().for_each(|l| grey(&mut l.colour));
        self.suns.iter_mut().for_each(|s| grey(&mut s.colour));
        for Emitter { exitance: Exitance(colour), .. } in self.emitters.iter_mut() {
            grey(colour);
        }
        grey(&mut self.world.minlight_colour);
        self.shadings.iter_mut().flatten().for_each(|s| Arc::make_mut(s).make_grey());
        for surface in self.surfaces.iter_mut() {
            let Reflectance(colour) = &mut surface.reflectance;
            grey(colour);
            grey(&mut surface.minlight.colour);
            // Pictures and glass may still colour the light on its way.
            surface.colour_scale = 0.0;
            surface.diffuse.iter_mut().for_each(grey);
            surface.minlight.glow.iter_mut().for_each(|glow| grey(&mut glow.colour));
        }
    }
}

/// The effect that a filtering surface belongs to.
pub(super) fn kind_of_filter(surface: &Surface) -> Effect {
    if surface.opacity < 1.0 {
        Effect::Glass
    } else if surface.fence {
        Effect::Fences
    } else {
        Effect::ModelShadows
    }
}
