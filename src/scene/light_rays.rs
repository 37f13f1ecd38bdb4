//! Rays between lit points and lights, with everything that blocks, tints or re-routes light on the
//! way (contract sections 6.5 and 7.3 to 7.6).

use super::Scene;
use super::effects::COMPILED;
use super::exact::length;
use super::filter::{Effect, Ray};
use super::narrow::{Limits, Narrow};
use super::shadow::{Contact, ShadowRays};
use super::shaft::{Floor, Shaft};
use super::sky_rays::View;
use super::tie;
use super::umbra::Bounds;
use super::walls::{Cover, Hidden, Origin};
use glam::Vec3;

/// Length of rays to the sky, in world units.
const SKY_DISTANCE: f32 = 1_000_000.0;
/// Most triangles in the way of the rays of a shaft.
const MOST_BLOCKERS: usize = 32;
/// Steps that finding them may take for each ray that is then quicker.
const STEPS_A_RAY: usize = 4;
/// Most triangles around the samples of a tile.
const MOST_NEAR: usize = 1024;

/// Light that gets through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Its colour after the glass on its way.
    pub colour: Vec3,
    /// Where light of style 0 belongs instead, because it crossed a switchable shadow caster.
    pub style: Option<u16>,
}

impl Arrival {
    /// The style of light that was of style `style`.
    pub fn style_of(&self, style: u16) -> u16 {
        if COMPILED && style == 0 { self.style.unwrap_or(0) } else { style }
    }
}

/// Traces rays from points of one brush model.
pub struct LightRays<'a> {
    scene: &'a Scene,
    opaque: ShadowRays<'a>,
    filters: ShadowRays<'a>,
    receiver: Option<u32>,
    /// What rays of dirt may meet.
    near: Narrow,
    near_filters: Narrow,
    /// Filters that the last ray crosses: where, which and how.
    crossed: Vec<(f64, u32, Contact)>,
    /// Rays tested against filters.
    tested: u64,
    /// Whether the last ray of light met a filter.
    met_filter: bool,
    cover: Cover,
    /// The sky in a shaft.
    sky: Narrow,
}

/// A straight way of light.
#[derive(Clone, Copy)]
struct Way {
    from: Vec3,
    /// Unit direction.
    direction: Vec3,
    reach: f32,
}

impl<'a> LightRays<'a> {
    /// Rays for points of brush model `receiver`; `None` for points in free space.
    pub fn new(scene: &'a Scene, receiver: Option<u32>) -> Self {
        Self {
            scene,
            opaque: ShadowRays::new(&scene.tracer),
            filters: ShadowRays::new(scene.filters.tracer()),
            receiver,
            near: Narrow::default(),
            near_filters: Narrow::default(),
            crossed: Vec::new(),
            tested: 0,
            met_filter: false,
            cover: Cover::default(),
            sky: Narrow::default(),
        }
    }

    /// Rays traced so far.
    pub fn rays(&self) -> u64 {
        self.opaque.rays()
    }

    /// Rays so far that were tested against what filters light.
    pub fn filtered_rays(&self) -> u64 {
        self.tested
    }

    /// Whether the last ray of light, to a point or the sky, met a filter where nothing else stopped it.
    pub(crate) fn met_filter(&self) -> bool {
        self.met_filter
    }

    /// Supposes that a polygon of the scene's tracer blocks the next rays, which makes them faster
    /// if it is so.
    pub fn suppose(&mut self, blocker: Option<u32>) {
        self.opaque.last_blocker = blocker;
    }

    /// The polygon that blocked the last ray between two points that was blocked.
    pub fn blocker(&self) -> Option<u32> {
        self.opaque.last_blocker
    }

    /// The polygon that hid the sky from the last ray that did not get there.
    pub(crate) fn blocker_of_sky(&self) -> Option<u32> {
        self.opaque.last_before_sky
    }

    /// A polygon between two points, near the first; `None` if there is none.
    pub(crate) fn first_blocker(&mut self, from: Vec3, to: Vec3) -> Option<u32> {
        self.opaque.last_blocker = None;
        if self.opaque.blocked(from, to) { self.opaque.last_blocker } else { None }
    }

    /// From now on [`Self::hidden_by`] speaks of a box and the light of a point. False if the box is too
    /// wide for answers.
    pub(crate) fn look_at(&mut self, bounds: &Bounds, light: Vec3) -> bool {
        self.cover.look_at(bounds, Origin::Point(light))
    }

    /// How much of the box surely gets no light because of `polygon` and those joined to it.
    pub(crate) fn hidden_by(&mut self, polygon: u32) -> Hidden {
        self.cover.hidden_by(self.opaque.tracer, polygon, |_| true)
    }

    /// Whether all rays of a box in the unit direction `direction` surely meet something other than sky
    /// first: `polygon` and those joined to it, or what is before them.
    pub(crate) fn see_no_sky(&mut self, bounds: &Bounds, direction: Vec3, polygon: u32) -> bool {
        let sky = &self.scene.sky;
        let is_other = |p: u32| !sky.is_sky[p as usize];
        if !is_other(polygon) || !self.cover.look_at(bounds, Origin::Far(direction)) {
            return false;
        }
        let hidden = self.cover.hidden_by(self.opaque.tracer, polygon, is_other);
        let Hidden::All(far) = hidden else { return false };
        let end = bounds.moved(direction.as_dvec3() * far);
        let nothing = Limits { triangles: 0, steps: usize::MAX };
        let shaft = Shaft::new(bounds, &end, None);
        self.sky.enter(sky.tracer.wide(), &shaft, nothing, |_| true)
    }

    /// Rays between two points run from `from` to `light` from now on, in front of `floor`, and are
    /// quick. Where too much is in the way for that number of rays to gain by it, they run anywhere,
    /// and the answer is false.
    pub(crate) fn towards(
        &mut self,
        from: &Bounds,
        floor: Floor,
        light: Vec3,
        rays: usize,
    ) -> bool {
        let Some(light) = Bounds::around(std::iter::once(light)) else { return false };
        let shaft = Shaft::new(from, &light, Some(floor));
        let (opaque, filters) = (self.opaque.tracer.wide(), self.filters.tracer.wide());
        let limits = Limits { triangles: MOST_BLOCKERS, steps: STEPS_A_RAY * rays };
        let entered = self.opaque.narrow.enter(opaque, &shaft, limits, |_| true)
            && (!COMPILED || self.filters.narrow.enter(filters, &shaft, limits, |_| true));
        if !entered {
            self.anywhere();
        }
        entered
    }

    /// Rays to the sky run from `from` in the unit direction `direction` from now on, as
    /// [`Self::towards`] says.
    pub(crate) fn skywards(
        &mut self,
        from: &Bounds,
        floor: Option<Floor>,
        direction: Vec3,
        rays: usize,
    ) -> bool {
        let far = from.moved(direction.as_dvec3() * f64::from(SKY_DISTANCE));
        let shaft = Shaft::new(from, &far, floor);
        let (opaque, filters) = (self.opaque.tracer.wide(), self.filters.tracer.wide());
        let limits = Limits { triangles: MOST_BLOCKERS, steps: STEPS_A_RAY * rays };
        let sky = &self.scene.sky;
        let entered = self.opaque.narrow_sky.enter(sky.tracer.wide(), &shaft, limits, |_| true)
            && (self.opaque.narrow_sky.is_empty()
                || self.opaque.narrow.enter(opaque, &shaft, limits, |p| !sky.is_sky[p as usize])
                    && self.filters.narrow.enter(filters, &shaft, limits, |_| true));
        if !entered {
            self.anywhere();
        }
        entered
    }

    /// Rays of dirt run from `from` to `to` in front of `floor` from the next call of
    /// [`Self::within`] on. The answer is false where too many polygons are there.
    pub(crate) fn around(&mut self, from: &Bounds, to: &Bounds, floor: Floor) -> bool {
        let shaft = Shaft::new(from, to, Some(floor));
        let (opaque, filters) = (self.opaque.tracer.wide(), self.filters.tracer.wide());
        let limits = Limits { triangles: MOST_NEAR, steps: usize::MAX };
        self.near.enter(opaque, &shaft, limits, |_| true)
            && self.near_filters.enter(filters, &shaft, limits, |_| true)
    }

    /// Of the rays that [`Self::around`] speaks of, only those to `to` are asked for from now on.
    pub(crate) fn within(&mut self, from: &Bounds, to: &Bounds, floor: Floor) {
        let shaft = Shaft::new(from, to, Some(floor));
        self.opaque.narrow.enter_part(&self.near, &shaft);
        self.filters.narrow.enter_part(&self.near_filters, &shaft);
    }

    /// Whether no ray of [`Self::skywards`] gets to the sky.
    pub(crate) fn sees_no_sky(&self) -> bool {
        self.opaque.narrow_sky.is_empty()
    }

    /// Whether surely nothing but the sky is in the way of the rays asked for.
    pub(crate) fn meet_nothing(&self) -> bool {
        self.opaque.narrow.is_empty()
            && self.filters.narrow.is_empty()
            && !self.opaque.narrow_sky.is_empty()
    }

    /// Rays run anywhere.
    pub(crate) fn anywhere(&mut self) {
        for rays in [&mut self.opaque, &mut self.filters] {
            rays.narrow.leave();
            rays.narrow_sky.leave();
        }
    }

    /// What arrives at `at` of light of `colour` that sets out from `light` in the channels `mask`;
    /// `None` if something opaque is between. The ends count as in [`ShadowRays::blocked`].
    pub fn between(&mut self, at: Vec3, light: Vec3, mask: i32, colour: Vec3) -> Option<Arrival> {
        self.met_filter = false;
        if !self.is_open(at, light, mask) {
            return None;
        }
        if !self.scene.has_filters() {
            return Some(Arrival { colour, style: None });
        }
        let to_light = light - at;
        let reach = length(to_light);
        self.filtered(Way { from: at, direction: to_light / reach, reach }, mask, colour)
    }

    /// Whether nothing opaque is between a point and a light, as in [`Self::between`].
    #[inline]
    pub(crate) fn is_open(&mut self, at: Vec3, light: Vec3, mask: i32) -> bool {
        // What always blocks is of channel 1.
        if mask & 1 == 0 {
            self.opaque.rays += 1;
            return true;
        }
        !self.opaque.blocked(at, light)
    }

    /// What arrives at `at` of light of `colour` from far away in the unit direction `direction`,
    /// and through which sky surface; `None` if the first thing on the way is no sky.
    pub fn from_sky(&mut self, at: Vec3, direction: Vec3, colour: Vec3) -> Option<(u32, Arrival)> {
        self.met_filter = false;
        let hit = match self.opaque.view(&self.scene.sky, at, direction, SKY_DISTANCE) {
            View::Sky(hit) => hit,
            View::NoSky => return None,
            View::Unsure => self.opaque.first_hit(at, direction, SKY_DISTANCE)?,
        };
        let surface = self.scene.tracer_surface[hit.polygon as usize];
        if self.scene.surfaces[surface as usize].role != super::Role::Sky {
            return None;
        }
        if !self.scene.has_filters() {
            return Some((surface, Arrival { colour, style: None }));
        }
        let way = Way { from: at, direction, reach: hit.distance };
        Some((surface, self.filtered(way, 1, colour)?))
    }

    /// Distance to the first thing other than sky that blocks light in the channels `mask`, at most
    /// `reach`, for dirt.
    pub fn room(&mut self, at: Vec3, direction: Vec3, reach: f32, mask: i32) -> f32 {
        let hit = if mask & 1 == 0 {
            None
        } else {
            self.opaque.first_hit_as_reference(at, direction, reach)
        };
        let end = hit.map_or(reach, |h| h.distance.min(reach));
        let is_sky = hit.is_some_and(|h| {
            let surface = self.scene.tracer_surface[h.polygon as usize];
            self.scene.surfaces[surface as usize].role == super::Role::Sky
        });
        let open = if is_sky { reach } else { end };
        if !self.scene.has_filters() || self.filters.narrow.is_empty() {
            return open;
        }
        let mut crossed = std::mem::take(&mut self.crossed);
        self.find_crossed(Way { from: at, direction, reach: end }, &mut crossed);
        let first = crossed.iter().map(|&(t, polygon, _)| (end * t as f32, polygon)).find(
            |&(distance, polygon)| {
                let point = at + direction * distance;
                let ray = Ray { point, direction, mask, receiver: self.receiver };
                self.scene.filters.effect(polygon, &ray, &self.scene.models) == Effect::Block
            },
        );
        self.crossed = crossed;
        first.map_or(open, |f| f.0)
    }

    /// What the filters on a way leave of light, in order along it.
    fn filtered(&mut self, way: Way, mask: i32, colour: Vec3) -> Option<Arrival> {
        let mut arrival = Arrival { colour, style: None };
        if self.filters.narrow.is_empty() {
            return Some(arrival);
        }
        let mut crossed = std::mem::take(&mut self.crossed);
        self.find_crossed(way, &mut crossed);
        self.met_filter = !crossed.is_empty();
        let mut passes = true;
        for &(t, polygon, _) in &crossed {
            let ray = Ray {
                point: way.from + way.direction * (f64::from(way.reach) * t) as f32,
                direction: way.direction,
                mask,
                receiver: self.receiver,
            };
            match self.scene.filters.effect(polygon, &ray, &self.scene.models) {
                Effect::Block => {
                    passes = false;
                    break;
                }
                Effect::Pass => {}
                Effect::Style(style) => arrival.style = Some(style),
                Effect::Tint(tint, opacity) => {
                    let tinted = arrival.colour * tint;
                    arrival.colour = arrival.colour * (1.0 - opacity) + tinted * opacity;
                }
            }
        }
        self.crossed = crossed;
        passes.then_some(arrival)
    }

    /// The filters on a way, nearest first. One that the ray meets at its very edge counts where the
    /// reference has it, or where the rays a hair beside are in a filter too.
    fn find_crossed(&mut self, way: Way, crossed: &mut Vec<(f64, u32, Contact)>) {
        self.tested += 1;
        let start = way.from.as_dvec3();
        let whole = way.direction.as_dvec3() * f64::from(way.reach);
        self.filters.crossings(start, whole, crossed);
        crossed.retain(|&(t, polygon, contact)| {
            contact.is_inside()
                || tie::blocked_along(
                    self.filters.corners(polygon),
                    way.from,
                    way.direction,
                    way.reach,
                )
                || self.filters.seam(start, whole, &mut std::iter::once(t)).is_some()
        });
        crossed.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }
}
