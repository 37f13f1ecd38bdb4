//! Patches that share their rows: one is drawn in the middle of some neighbours.

use super::weights::Precision;
use super::{CHUNK, Eye, Transfers};
use crate::patch::{Groups, PatchSet};
use crate::radiosity::hemicube::HemicubeSize;
use crate::scene::{ShadowRays, Tracer};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::TAU;

/// Rays that tell whether it is worth drawing a row in the middle of a group: so many by so many.
const RAYS: u32 = 5;
/// As many tell whether one of its patches is in a much narrower place than its middle.
const FEW_RAYS: u32 = 4;
/// In a place so many times as narrow a patch does not share the row.
const NARROWER: f32 = 2.0;

/// Which patches of a map do without a fine hemicube of their own.
#[derive(Clone, Copy, Debug)]
pub struct Sharing<'a> {
    /// Patches on a face for which one row may do, drawn in their middle.
    pub groups: &'a Groups,
    /// It does for those that see the middle and are nearer to it than this share of the harmonic mean
    /// distance of what is seen from there, if that holds for two at least. With 0 all patches have a row.
    pub share: f32,
    /// Whether half as many cells along an edge do for a patch.
    pub small: &'a [bool],
}

impl Transfers {
    /// As [`compute`](Self::compute), but some patches share their rows, and for some a coarser hemicube
    /// does. `advance(n)` is told of every n rows done.
    pub fn shared(
        tracer: &Tracer,
        patches: &PatchSet,
        sharing: Sharing<'_>,
        size: HemicubeSize,
        advance: impl Fn(u64) + Sync,
    ) -> Self {
        let goes_on = |n| {
            advance(n);
            true
        };
        Self::shared_while(tracer, patches, sharing, size, goes_on).expect("not stopped")
    }

    /// The same for as long as `goes_on(n)`, which is told of every n rows done, is true; `None` if it
    /// is not.
    pub fn shared_while(
        tracer: &Tracer,
        patches: &PatchSet,
        Sharing { groups, share, small }: Sharing<'_>,
        size: HemicubeSize,
        goes_on: impl Fn(u64) -> bool + Sync,
    ) -> Option<Self> {
        let eye = |i: u32| patches.patches[i as usize].eye;
        let normal = |i: u32| patches.patches[i as usize].normal;
        let members = groups.members();
        let is_tried =
            |&g: &usize| is_promising(tracer, patches, (groups.eyes[g], &members[g]), share);
        let tried: Vec<usize> = (0..members.len()).into_par_iter().filter(is_tried).collect();
        let mut transfers = Self::undrawn(groups.of.len(), Precision::Short);
        let draw = |transfers: &mut Self, eyes: Vec<Eye>, is_coarse: &dyn Fn(u32) -> bool| {
            let (coarse, fine): (Vec<_>, Vec<_>) =
                eyes.into_iter().partition(|e| is_coarse(e.patch));
            for (eyes, size) in [(fine, size), (coarse, size.halved())] {
                transfers.draw(tracer, patches, size, &eyes, &goes_on)?;
            }
            Some(())
        };
        let middles = tried.iter().map(|&g| Eye { at: groups.eyes[g], patch: members[g][0] });
        let all_small =
            |i: u32| members[groups.of[i as usize] as usize].iter().all(|&k| small[k as usize]);
        draw(&mut transfers, middles.collect(), &all_small)?;
        transfers.shared = transfers.chunks.len() * CHUNK;
        let shared: Vec<Vec<u32>> = tried
            .par_iter()
            .map_init(
                || ShadowRays::new(tracer),
                |shadows, &g| {
                    let (middle, first) = (groups.eyes[g], members[g][0] as usize);
                    let reach = share * transfers.distances(first).openness;
                    let near = members[g].iter().copied().filter(|&i| {
                        let (at, away) = (eye(i), eye(i).distance(middle));
                        let least = away / (NARROWER * share);
                        away < reach
                            && !shadows.blocked(at, middle)
                            && is_open(tracer, (at, normal(i)), least, FEW_RAYS)
                    });
                    Some(near.collect::<Vec<_>>()).filter(|near| near.len() > 1).unwrap_or_default()
                },
            )
            .collect();
        let mut alone = vec![true; groups.of.len()];
        for (&g, sharing) in tried.iter().zip(&shared) {
            let row = transfers.row_of[members[g][0] as usize];
            for &i in sharing {
                transfers.row_of[i as usize] = row;
                transfers.first_of[i as usize] = sharing[0];
                alone[i as usize] = false;
            }
        }
        let saved = shared.iter().map(Vec::len).sum::<usize>().saturating_sub(tried.len());
        goes_on(saved as u64);
        let alone = (0..groups.of.len() as u32).filter(|&i| alone[i as usize]);
        let alone = alone.map(|i| Eye { at: eye(i), patch: i }).collect();
        draw(&mut transfers, alone, &|i| small[i as usize])?;
        Some(transfers)
    }
}

/// Whether a row in the middle of some patches, `members` of one group, is likely to do for all of them:
/// how far away what is seen is, is found by some rays.
pub(super) fn is_promising(
    tracer: &Tracer,
    patches: &PatchSet,
    (middle, members): (Vec3, &[u32]),
    share: f32,
) -> bool {
    let patch = |i: u32| &patches.patches[i as usize];
    let apart = members.iter().map(|&i| patch(i).eye.distance(middle)).fold(0.0, f32::max);
    share > 0.0
        && members.len() > 1
        && is_open(tracer, (middle, patch(members[0]).normal), apart / share, RAYS)
}

/// Whether the harmonic mean distance of what is seen, weighted by form factor, is above `least` by
/// `rays` times `rays` rays.
fn is_open(tracer: &Tracer, (eye, normal): (Vec3, Vec3), least: f32, rays: u32) -> bool {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let mut left = (rays * rays) as f32 / least;
    for k in 0..rays * rays {
        let stratum = Vec2::new((k % rays) as f32, (k / rays) as f32);
        // In the middle of an equal share of the disc that is below the hemisphere.
        let Vec2 { x, y } = (stratum + 0.5) / rays as f32;
        let (radius, angle) = (x.sqrt(), TAU * y);
        let [u, v] = [angle.cos(), angle.sin()].map(|side| radius * side);
        let way = tangent * u + bitangent * v + normal * (1.0 - x).sqrt();
        left -= tracer.first_hit(eye, way, f32::INFINITY).map_or(0.0, |hit| 1.0 / hit.distance);
        if left <= 0.0 {
            return false;
        }
    }
    true
}
