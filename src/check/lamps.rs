//! Rays from where a path is to patches that give off light.

use super::walk::Lit;
use crate::patch::PatchSet;
use crate::scene::random::SplitMix;
use glam::{DVec3, Vec3};

/// Patches that give off light, to send rays to, and how likely each is chosen.
#[derive(Clone, Debug, Default)]
pub struct Lamps {
    /// Patch, corners, light, likeliness by area, and sum of likeliness up to it.
    lamps: Vec<Lamp>,
    /// Likeliness by area of each patch; empty if there are no lamps.
    by_area: Vec<f32>,
}

#[derive(Clone, Debug)]
struct Lamp {
    patch: usize,
    corners: Vec<DVec3>,
    normal: Vec3,
    light: Vec3,
    by_area: f32,
    until: f64,
}

impl Lamps {
    /// The patches with `emission`, as likely as the light that they give off.
    pub fn new(patches: &PatchSet, emission: &[Vec3]) -> Self {
        let area = |c: &[DVec3]| 0.5 * (c[2] - c[0]).cross(c[3] - c[1]).length();
        let power = |i: usize| area(&patches.outlines[i]) * f64::from(emission[i].element_sum());
        let all: f64 = (0..emission.len()).map(power).sum();
        let mut found = Self { lamps: Vec::new(), by_area: vec![0.0; emission.len()] };
        let mut until = 0.0;
        for (i, &light) in emission.iter().enumerate().filter(|(i, _)| power(*i) > 0.0) {
            let corners = patches.outlines[i].clone();
            until += power(i) / all;
            let by_area = (power(i) / all / area(&corners)) as f32;
            found.by_area[i] = by_area;
            let normal = patches.patches[i].normal;
            found.lamps.push(Lamp { patch: i, corners, normal, light, by_area, until });
        }
        found
    }

    /// Light of one lamp that arrives at a point, by one ray. What it counts for, against rays that meet
    /// the lamp by chance, is the balance heuristic (E. Veach and L. Guibas, 1995).
    pub(super) fn arriving(
        &self,
        lit: &Lit<'_>,
        from: Vec3,
        normal: Vec3,
        random: &mut SplitMix,
    ) -> Vec3 {
        let chosen = random.next();
        let Some(lamp) = self.lamps.get(self.lamps.partition_point(|l| l.until < chosen)) else {
            return Vec3::ZERO;
        };
        let at = within(&lamp.corners, [random.next() as f32, random.next() as f32]).as_vec3();
        let (way, distance) = (at - from, at.distance(from));
        let chance = by_chance(way, distance, normal, lamp.normal);
        let before = 1.0 - 1e-4;
        if chance <= 0.0 || lit.tracer.first_hit(from, way, before).is_some() {
            return Vec3::ZERO;
        }
        let through = lit.overlay().map_or(Vec3::ONE, |overlay| {
            overlay.through(from.as_dvec3(), (from + way * before).as_dvec3()).as_vec3()
        });
        let light = lamp.light * lit.pattern(lamp.patch, at) * through;
        light * (chance / (chance + lamp.by_area))
    }

    /// What emission counts for that a ray meets by chance.
    pub(super) fn share(&self, patch: usize, chance: f32) -> f32 {
        self.by_area.get(patch).map_or(1.0, |&by_area| chance / (chance + by_area))
    }
}

/// Likeliness by area that a ray, distributed as the cosine to `normal`, meets a point of a surface.
pub(super) fn by_chance(way: Vec3, distance: f32, normal: Vec3, of_surface: Vec3) -> f32 {
    let cosines = way.dot(normal).max(0.0) * (-way).dot(of_surface).max(0.0);
    cosines / (std::f32::consts::PI * distance.powi(4))
}

/// A point of a convex quad, every part of it as likely as its area says.
pub(super) fn within(corners: &[DVec3], [u, v]: [f32; 2]) -> DVec3 {
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| corners[i]);
    let one = (b - a).cross(c - a).length();
    let two = (c - a).cross(d - a).length();
    let share = one / (one + two);
    let (mut u, mut v) = (f64::from(u), f64::from(v));
    let [p, q, r] = if u < share {
        u /= share;
        [a, b, c]
    } else {
        u = (u - share) / (1.0 - share);
        [a, c, d]
    };
    // The square folded to a triangle.
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    p + (q - p) * u + (r - p) * v
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_kite_have_its_centroid() {
        let corners =
            [[0.0, 0.0], [2.0, -1.0], [5.0, 0.0], [2.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 3.0));
        let n = 200;
        let at = |k: usize| (k as f32 + 0.5) / n as f32;
        let mean = (0..n * n).map(|k| within(&corners, [at(k % n), at(k / n)])).sum::<DVec3>();
        let mean = mean / (n * n) as f64;
        assert!((mean - DVec3::new(7.0 / 3.0, 0.0, 3.0)).length() < 1e-2, "{mean}");
    }
}
