//! Rays of direct light, by the effect that asked for them.

use crate::scene::LightRays;
use crate::scene::effects::Effect;
use std::ops::AddAssign;

/// Numbers of rays traced. Each is counted for one effect; those tested against things that filter light
/// are counted once more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// For dirt.
    pub dirt: u64,
    /// To point lights and spotlights.
    pub lights: u64,
    /// To shining surfaces.
    pub surface_lights: u64,
    /// To suns.
    pub suns: u64,
    /// To the suns of sky domes.
    pub sky_domes: u64,
    /// To lights of least light.
    pub minlight: u64,
    /// Of all these, those tested against fences, glass and models with shadows of their own.
    pub filtered: u64,
}

impl RayCounts {
    /// All rays.
    pub fn total(&self) -> u64 {
        let sky = self.suns + self.sky_domes;
        self.dirt + self.lights + self.surface_lights + sky + self.minlight
    }

    /// Rays of one effect; `None` for an effect that asks for none of its own.
    pub fn of(&self, effect: Effect) -> Option<u64> {
        match effect {
            Effect::Dirt => Some(self.dirt),
            Effect::Lights => Some(self.lights),
            Effect::SurfaceLights => Some(self.surface_lights),
            Effect::Suns => Some(self.suns),
            Effect::SkyDomes => Some(self.sky_domes),
            Effect::Minlight => Some(self.minlight),
            _ => None,
        }
    }
}

impl RayCounts {
    /// This many times the rays, rounded.
    pub fn scaled(&self, factor: f64) -> Self {
        let scaled = |n: u64| (n as f64 * factor).round() as u64;
        Self {
            dirt: scaled(self.dirt),
            lights: scaled(self.lights),
            surface_lights: scaled(self.surface_lights),
            suns: scaled(self.suns),
            sky_domes: scaled(self.sky_domes),
            minlight: scaled(self.minlight),
            filtered: scaled(self.filtered),
        }
    }
}

impl AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.dirt += other.dirt;
        self.lights += other.lights;
        self.surface_lights += other.surface_lights;
        self.suns += other.suns;
        self.sky_domes += other.sky_domes;
        self.minlight += other.minlight;
        self.filtered += other.filtered;
    }
}

/// Tells what `rays` has traced since the last time.
pub(super) struct Since(u64);

impl Since {
    /// From now on.
    pub fn now(rays: &LightRays<'_>) -> Self {
        Self(rays.rays())
    }

    /// Adds the rays since then to a count.
    pub fn count(&mut self, rays: &LightRays<'_>, count: &mut u64) {
        let traced = rays.rays();
        *count += traced - self.0;
        self.0 = traced;
    }
}
