//! Checking text scenes: light that patches reflect, as means over their areas.

use super::lamps::{Lamps, within};
use super::walk::{Bundle, Direct, Lit, Met, passages};
use super::{Again, Energy, Findings, Points, check};
use crate::patch::{MAX_REFLECTANCE, TextPatches, TextScene};
use crate::progress::Deadline;
use crate::radiosity::solve::Solution;
use crate::radiosity::transfers::Transfers;
use crate::radiosity::trapped;
use glam::{DVec3, Vec3};

/// Distance of points from their patch, relative to the scene.
const LIFT: f32 = 1e-6;

/// There is no light but that of patches.
struct NoLight;

impl Direct for NoLight {
    fn at(&self, _: &Met) -> Vec3 {
        Vec3::ZERO
    }
}

/// The patches of a text scene that reflect light.
pub struct TextQuads<'a> {
    patches: &'a TextPatches,
    /// The patches that are checked.
    chosen: Vec<usize>,
    exitance: &'a [Vec3],
    lit: &'a Lit<'a>,
}

impl Points for TextQuads<'_> {
    fn count(&self) -> usize {
        self.chosen.len()
    }

    fn found(&self, point: usize) -> Vec3 {
        let i = self.chosen[point];
        self.exitance[i] - self.patches.emission[i].0
    }

    fn weight(&self, point: usize) -> f64 {
        self.patches.set.patches[self.chosen[point]].area.into()
    }

    fn name(&self, point: usize) -> String {
        format!("patch {}", self.chosen[point])
    }

    fn channels_count(&self) -> bool {
        true
    }

    fn by_paths(&self) -> bool {
        true
    }

    fn again(&self) -> Box<dyn FnMut(usize, u32) -> Again + '_> {
        Box::new(|point, paths| {
            let i = self.chosen[point];
            let patch = &self.patches.set.patches[i];
            let half = |half: u64| {
                let seed = (i as u64) << 1 | half;
                let bundle = Bundle { seed, paths, starts: true };
                let of_side = |normal: Vec3, share: Vec3| {
                    self.lit.light(bundle, |u| {
                        let on = within(&self.patches.set.outlines[i], u).as_vec3();
                        (on + normal * LIFT, normal, share * self.lit.pattern(i, on))
                    })
                };
                let back = self.lit.passages.get(i).filter(|p| p.1 != Vec3::ZERO);
                let back = back.map_or(Vec3::ZERO, |p| of_side(-patch.normal, p.1));
                of_side(patch.normal, patch.reflectance.0) + back
            };
            let halves = [half(0), half(1)];
            Again { halves, rays: (halves[0] + halves[1]) * 0.5 }
        })
    }
}

/// Checks the solution of a text scene, until `end`.
pub fn check_patches(
    scene: &TextScene,
    transfers: &Transfers,
    solution: &Solution,
    end: Deadline<'_>,
) -> (Option<Findings>, Option<Energy>) {
    let mut patches = TextPatches::new(scene);
    let mut reflectance = patches.reflectance();
    let limit = MAX_REFLECTANCE as f32;
    trapped::let_out(transfers, &mut reflectance, &mut patches.set.passages, limit);
    let passages = passages(&patches.set);
    for (patch, rho) in patches.set.patches.iter_mut().zip(reflectance) {
        patch.reflectance = rho;
    }
    let exitance: Vec<Vec3> = solution.exitance.iter().map(|m| m.0).collect();
    let emission: Vec<Vec3> = patches.emission.iter().map(|m| m.0).collect();
    let lit = Lit {
        tracer: &patches.tracer,
        patches: &patches.set,
        emission: &emission,
        bouncing: &emission,
        exitance: &exitance,
        passages: &passages,
        lamps: Lamps::new(&patches.set, &emission),
        direct: &NoLight,
        bounces: (!solution.settled).then_some(solution.passes),
        lift: LIFT,
    };
    let albedo = patches.set.albedo();
    let chosen = (0..exitance.len()).filter(|&i| albedo[i] != Vec3::ZERO).collect();
    let points = TextQuads { patches: &patches, chosen, exitance: &exitance, lit: &lit };
    let sent: Vec<DVec3> = exitance.iter().map(|m| m.as_dvec3()).collect();
    let energy = Energy::new(&patches.set, transfers, &sent);
    (check(&points, end), energy)
}
