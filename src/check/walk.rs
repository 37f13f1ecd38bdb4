//! Paths of light backwards: from a point along rays, reflected as diffuse surfaces do.

use super::choice::four;
use super::lamps::{Lamps, by_chance};
use crate::patch::{Overlay, PatchId, PatchSet, PolygonPatches};
use crate::scene::Tracer;
use crate::scene::random::SplitMix;
use glam::{DVec3, Vec3};

/// What may be left of the light of a path when the rest is taken from the solution.
const LEFT: f64 = 0.03;
/// Most surfaces that a path meets.
const DEEPEST: u32 = 12;
/// Rays end after so many units of the tracer.
const FAR: f32 = 1e6;

/// Where a path meets a patch.
#[derive(Clone, Copy, Debug)]
pub struct Met {
    /// Number of the patch.
    pub patch: usize,
    /// The point.
    pub position: Vec3,
}

/// Direct irradiance where paths meet surfaces.
pub trait Direct: Sync {
    /// Irradiance from lights that are no patches, per channel, in light units.
    fn at(&self, met: &Met) -> Vec3;
}

/// A solved scene, all light styles added up. Slices have one entry a patch, and those of light one for
/// each glow of the overlay after them.
pub struct Lit<'a> {
    /// What blocks light.
    pub tracer: &'a Tracer,
    /// The patches.
    pub patches: &'a PatchSet,
    /// Light that patches give off by themselves.
    pub emission: &'a [Vec3],
    /// What counts of it where it bounces.
    pub bouncing: &'a [Vec3],
    /// The solution: final exitance.
    pub exitance: &'a [Vec3],
    /// What passes through patches, from `passages`; empty if nothing does.
    pub passages: &'a [(usize, Vec3)],
    /// Patches that rays are sent to besides: none, or all that give off light.
    pub lamps: Lamps,
    /// Light of other kinds.
    pub direct: &'a dyn Direct,
    /// Most bounces; `None` for no limit.
    pub bounces: Option<u32>,
    /// Distance of starting points from surfaces, in units of the tracer.
    pub lift: f32,
}

/// A bundle of paths from around a point.
#[derive(Clone, Copy)]
pub(super) struct Bundle {
    /// Tells apart points and halves.
    pub seed: u64,
    /// How many.
    pub paths: u32,
    /// Their starts differ.
    pub starts: bool,
}

impl Lit<'_> {
    /// How many surfaces paths meet: as many as it takes until a few hundredths of the light are left,
    /// at most 12. The last one's light is that of the solution, unless bounces are limited to less.
    pub fn depth(&self) -> u32 {
        let (mut sum, mut areas) = (0.0, 0.0);
        for (p, albedo) in self.patches.patches.iter().zip(self.patches.albedo()) {
            sum += f64::from(p.area) * f64::from(albedo.max_element());
            areas += f64::from(p.area);
        }
        let mean: f64 = (sum / areas).clamp(0.01, 0.99);
        let depth = 1 + (LEFT.ln() / mean.ln()).ceil() as u32;
        depth.clamp(2, DEEPEST)
    }

    pub(super) fn overlay(&self) -> Option<&Overlay> {
        self.patches.overlay.as_deref()
    }

    /// Light of a patch at a point over its mean.
    pub(super) fn pattern(&self, patch: usize, point: Vec3) -> Vec3 {
        let of = |o: &Overlay| o.pattern(PatchId(patch as u32), point.as_dvec3());
        self.overlay().and_then(of).map_or(Vec3::ONE, DVec3::as_vec3)
    }

    /// Light that a patch gives off by itself at a point, of a list of such light.
    fn own(&self, list: &[Vec3], met: &Met) -> Vec3 {
        let (mut own, mut apart) = (list[met.patch], Vec3::ZERO);
        let mut glows =
            self.overlay().into_iter().flat_map(|o| o.glows_of(PatchId(met.patch as u32)));
        for (column, glow) in glows.by_ref() {
            let at = std::iter::once(met.position.as_dvec3());
            let light = list[column.0 as usize];
            own -= light;
            apart += light * glow.over(at).as_vec3();
        }
        own * self.pattern(met.patch, met.position) + apart
    }

    /// Light as the mean of a bundle of paths. `start` tells where they begin, the unit normal there and
    /// what their irradiance counts for, given two numbers from 0 to 1.
    pub(super) fn light(
        &self,
        bundle: Bundle,
        start: impl Fn([f32; 2]) -> (Vec3, Vec3, Vec3),
    ) -> Vec3 {
        let depth = self.depth();
        let seed = SplitMix(bundle.seed).next().to_bits();
        let mut sum = DVec3::ZERO;
        for k in 0..bundle.paths {
            let [u, v, x, y] = four(k, seed, bundle.starts);
            let (from, normal, share) = start([x, y]);
            let mut random = SplitMix(seed ^ u64::from(k).wrapping_mul(0xD6E8_FEB8_6659_FD93));
            let direction = cosine(normal, u, v);
            let light = share * self.walk((from, normal), direction, depth, &mut random);
            sum += light.as_dvec3();
        }
        (sum / f64::from(bundle.paths)).as_vec3()
    }

    /// Light that comes along one path.
    fn walk(
        &self,
        (mut from, mut normal): (Vec3, Vec3),
        mut direction: Vec3,
        depth: u32,
        random: &mut SplitMix,
    ) -> Vec3 {
        let (mut sum, mut share) = (Vec3::ZERO, Vec3::ONE);
        // The solution cannot tell what few bounces leave out.
        let limit = self.bounces.filter(|&n| n < DEEPEST);
        let last = limit.map_or(depth, |n| n + 1);
        for met_so_far in 1..=last {
            sum += share * self.lamps.arriving(self, from, normal, random);
            let given_off = |met: &Met| {
                let patch = &self.patches.patches[met.patch];
                let way = met.position - from;
                let chance = by_chance(way, way.length(), normal, patch.normal);
                let list = if met_so_far == 1 { self.emission } else { self.bouncing };
                self.own(list, met) * self.lamps.share(met.patch, chance)
            };
            let meeting = self.meet(from, direction, random, |met, through| {
                sum += share * through * given_off(met);
            });
            let Some((met, through)) = meeting else { break };
            share *= through * self.pattern(met.patch, met.position);
            if met_so_far == last {
                if limit.is_none() {
                    sum += share * (self.exitance[met.patch] - self.emission[met.patch]);
                }
                break;
            }
            let Some((lit, sent)) = self.side(met, random) else { break };
            share *= sent;
            sum += share * self.direct.at(&lit);
            normal = self.patches.patches[lit.patch].normal;
            from = lit.position + normal * self.lift;
            direction = cosine(normal, random.next() as f32, random.next() as f32);
        }
        sum
    }

    /// The patch that a ray meets from its front, and the share of its light that comes back along the
    /// ray. A translucent patch on the way is met as likely as it sends on light of its own and not of
    /// what is behind. `seen` is told of all patches that come into question.
    pub(super) fn meet(
        &self,
        from: Vec3,
        direction: Vec3,
        random: &mut SplitMix,
        mut seen: impl FnMut(&Met, Vec3),
    ) -> Option<(Met, Vec3)> {
        let hit = self.tracer.first_hit(from, direction, FAR);
        let mut share = Vec3::ONE;
        if let Some(overlay) = self.overlay() {
            let end = hit.as_ref().map_or(FAR, |hit| hit.distance);
            let (start, to) = (from.as_dvec3(), (from + direction * end).as_dvec3());
            for (t, polygon) in overlay.crossings(start, to) {
                let position = start + (to - start) * t;
                let tint = overlay.tint(polygon, position, to - start).as_vec3();
                if let Some(side) = overlay.side(polygon, to - start) {
                    let met = Met { patch: side.0 as usize, position: position.as_vec3() };
                    seen(&met, share);
                    let [own, behind] = [self.albedo(met.patch), tint.max_element()];
                    let chance = if own > 0.0 { own / (own + behind) } else { 0.0 };
                    if chance > 0.0 && (random.next() as f32) < chance {
                        return Some((met, share / chance));
                    }
                    share /= 1.0 - chance;
                }
                share *= tint;
                if share == Vec3::ZERO {
                    return None;
                }
            }
        }
        let hit = hit?;
        let sides = [Some(hit.polygon), self.other_side(hit.polygon)];
        let polygon = sides.into_iter().flatten().find(|&side| {
            let polygon = &self.tracer.polygons()[side as usize];
            polygon.normal.dot(from - polygon.vertices[0]) > 0.0
        })?;
        let position = from + direction * hit.distance;
        let patch = match self.patches.lookup.polygon(polygon) {
            PolygonPatches::None => return None,
            PolygonPatches::Whole(patch) => *patch,
            PolygonPatches::Grid(grid) => grid.at_point(position),
        };
        let met = Met { patch: patch.0 as usize, position };
        seen(&met, share);
        Some((met, share))
    }

    /// The other side of a sheet, the polygon before or after with the same corners the other way round:
    /// a ray may meet either.
    fn other_side(&self, polygon: u32) -> Option<u32> {
        let polygons = self.tracer.polygons();
        let own = &polygons[polygon as usize].vertices;
        let beside = [polygon.checked_add(1), polygon.checked_sub(1)].into_iter().flatten();
        beside.into_iter().find(|&other| {
            let other = polygons.get(other as usize);
            other.is_some_and(|o| o.vertices.iter().rev().eq(own))
        })
    }

    /// Largest share of the light on a patch, or on its other side, that it gives off again.
    fn albedo(&self, patch: usize) -> f32 {
        let passes = self.passages.get(patch).map_or(0.0, |p| p.1.max_element());
        self.patches.patches[patch].reflectance.0.max_element() + passes
    }

    /// Where the light fell that a patch gives off at a point, one side of it or the other at random, and
    /// the share of it that is given off. `None` where it gives off none of others.
    pub(super) fn side(&self, met: Met, random: &mut SplitMix) -> Option<(Met, Vec3)> {
        let reflectance = self.patches.patches[met.patch].reflectance.0;
        let Some(&(other, passes)) = self.passages.get(met.patch).filter(|p| p.1 != Vec3::ZERO)
        else {
            return (reflectance != Vec3::ZERO).then_some((met, reflectance));
        };
        let [back, through] = [reflectance, passes].map(Vec3::max_element);
        let chance = back / (back + through);
        if (random.next() as f32) < chance {
            return Some((met, reflectance / chance));
        }
        let patch = &self.patches.patches[other];
        let position = met.position + patch.normal * patch.normal.dot(patch.eye - met.position);
        Some((Met { patch: other, position }, passes / (1.0 - chance)))
    }
}

/// By patch: the one on the other side, whose light passes, and the share of it; empty where none does.
pub(super) fn passages(patches: &PatchSet) -> Vec<(usize, Vec3)> {
    if patches.passages.is_empty() {
        return Vec::new();
    }
    let mut found = vec![(0, Vec3::ZERO); patches.patches.len()];
    for passage in &patches.passages {
        found[passage.to.0 as usize] = (passage.from.0 as usize, passage.transmittance);
    }
    found
}

/// A direction above a surface, as likely as the cosine to its unit normal: two numbers from 0 to 1
/// lifted from the disc to the hemisphere.
pub(super) fn cosine(normal: Vec3, u: f32, v: f32) -> Vec3 {
    let (t, b) = normal.any_orthonormal_pair();
    let (sin, cos) = (v * std::f32::consts::TAU).sin_cos();
    let r = u.sqrt();
    t * (r * cos) + b * (r * sin) + normal * (1.0 - u).max(0.0).sqrt()
}
