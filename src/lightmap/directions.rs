//! Where bounced light comes from. The light itself is known at every luxel; its mean direction is
//! known at patches, from what they see, and blended between them.

use super::Sources;
use crate::light::{DirectLight, Directions, StyleLight, strength};
use crate::patch::{Patch, PatchId};
use crate::photometry::Exitance;
use crate::scene::Sample;
use glam::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// How far a patch's direction counts, relative to the edge of the largest patch of the face.
const REACH: f32 = 1.5;

/// Adds to the directions of each surface those of its bounced light `indirect`, at luxels that are
/// `extra` x `extra` samples. Nothing is done where they are not wanted.
pub fn add_bounced_directions(
    sources: Sources<'_>,
    luxels: &[Vec<Sample>],
    indirect: &[Vec<StyleLight>],
    extra: u32,
    direct: &mut [DirectLight],
) {
    if !direct.iter().any(|d| d.directions.are_wanted()) {
        return;
    }
    let Sources { patches, transfers, .. } = sources;
    let groups = patches.groups();
    let eye = |i| transfers.eye(i, &patches.set, &groups);
    let eyes: Vec<Vec3> = (0..transfers.rows()).map(eye).collect();
    for light in sources.light {
        let means = mean_directions(sources, &eyes, &light.exitance);
        direct.par_iter_mut().enumerate().for_each(|(surface, direct)| {
            let Some(map) = indirect[surface].iter().find(|map| map.style == light.style) else {
                return;
            };
            let blend = Blend::new(sources, surface, (&means, &eyes));
            let width = sources.scene.surfaces[surface].luxels.as_ref().map_or(1, |g| g.width);
            for (luxel, arriving) in map.irradiance.iter().enumerate() {
                let sample = &luxels[surface][luxel];
                let strength = strength(arriving.0);
                if strength > 0.0 {
                    let towards = blend.at(sample.position).unwrap_or(sample.normal);
                    let place = (luxel, luxels[surface].len());
                    spread(
                        &mut direct.directions,
                        map.style,
                        place,
                        (width, extra),
                        towards * strength,
                    );
                }
            }
        });
    }
}

/// Gives a luxel's vector to all its samples.
fn spread(
    directions: &mut Directions,
    style: u16,
    (luxel, count): (usize, usize),
    (width, extra): (u32, u32),
    vector: Vec3,
) {
    let (width, extra) = (width as usize, extra as usize);
    let (column, row) = (luxel % width * extra, luxel / width * extra);
    for y in row..row + extra {
        for x in column..column + extra {
            directions.add_vector(style, (y * width * extra + x, count * extra * extra), vector);
        }
    }
}

/// Mean direction from each patch to the exitance that it sees, weighted by what arrives: shorter than
/// 1 by as much as the light is spread out, and zero where none arrives or another patch looks for it.
fn mean_directions(sources: Sources<'_>, eyes: &[Vec3], exitance: &[Exitance]) -> Vec<Vec3> {
    let patches = &sources.patches.set.patches;
    let overlay_of = sources.patches.set.overlay.as_deref();
    let strengths: Vec<f32> = exitance.iter().map(|m| strength(m.0)).collect();
    (0..sources.transfers.rows())
        .into_par_iter()
        .with_min_len(64)
        .map(|i| {
            if sources.transfers.first_of(i) != i {
                return Vec3::ZERO;
            }
            let from = Patch { eye: eyes[i], ..patches[i] };
            let (mut vector, mut sum) = (Vec3::ZERO, 0.0);
            let mut add = |j: u32, arriving: f32| {
                let way = way_to(&from, &patches[j as usize]);
                vector += way.normalize_or_zero() * arriving;
                sum += arriving;
            };
            let entries = sources.transfers.entries(i);
            match sources.transfers.overlay_row(i) {
                [] => entries.for_each(|(j, f)| add(j, f * strengths[j as usize])),
                overlay => {
                    // What panes leave of a factor belongs to the same patch.
                    let mut row: Vec<(u32, Vec3)> =
                        entries.map(|(j, f)| (j, Vec3::splat(f))).chain(overlay.to_vec()).collect();
                    row.sort_by_key(|&(j, _)| j);
                    for of_patch in row.chunk_by(|a, b| a.0 == b.0) {
                        let share: Vec3 = of_patch.iter().map(|&(_, f)| f).sum();
                        let column = of_patch[0].0;
                        let patch =
                            overlay_of.map_or(PatchId(column), |o| o.patch_of(PatchId(column)));
                        add(patch.0, strength(exitance[column as usize].0 * share));
                    }
                }
            }
            if sum > 0.0 { vector / sum } else { Vec3::ZERO }
        })
        .collect()
}

/// The way from a patch to the middle of that part of another which is in front of it.
fn way_to(from: &Patch, to: &Patch) -> Vec3 {
    let way = to.eye - from.eye;
    let height = way.dot(from.normal);
    // How far the other reaches up and down from its middle, if it is a square.
    let tilt = (1.0 - from.normal.dot(to.normal).powi(2)).max(0.0).sqrt();
    let reach = 0.5 * to.area.sqrt() * tilt;
    let middle = if height < reach { (0.5 * (height + reach)).max(0.0) } else { height };
    way + from.normal * (middle - height)
}

/// Blends the directions of the patches of a surface and of those that continue it.
struct Blend<'a> {
    means: &'a [Vec3],
    /// Where these are.
    eyes: &'a [Vec3],
    reach: f32,
    cells: HashMap<[i32; 3], Vec<u32>>,
}

impl<'a> Blend<'a> {
    fn new(sources: Sources<'a>, surface: usize, (means, eyes): (&'a [Vec3], &'a [Vec3])) -> Self {
        let first = &sources.patches.first;
        let members = |surface: usize| first[surface]..first[surface + 1];
        let patch = |i: u32| &sources.patches.set.patches[i as usize];
        let largest = members(surface).map(|i| patch(i).area).fold(0.0, f32::max);
        let shared = members(surface).any(|i| sources.transfers.is_shared(i as usize));
        // One in the middle of two by two may look for all.
        let apart = if shared { 2.0 * largest.sqrt() } else { largest.sqrt() };
        let mut blend = Self { means, eyes, reach: REACH * apart, cells: HashMap::new() };
        let mut surfaces: Vec<usize> = sources.scene.continuations(surface).collect();
        surfaces.push(surface);
        surfaces.sort_unstable();
        surfaces.dedup();
        for i in surfaces.into_iter().flat_map(members).filter(|&i| means[i as usize] != Vec3::ZERO)
        {
            blend.cells.entry(blend.cell(eyes[i as usize])).or_default().push(i);
        }
        blend
    }

    fn cell(&self, p: Vec3) -> [i32; 3] {
        (p / self.reach.max(1.0)).floor().as_ivec3().to_array()
    }

    /// The direction at a point; `None` if no patch is near.
    fn at(&self, p: Vec3) -> Option<Vec3> {
        let [x, y, z] = self.cell(p);
        let (mut vector, mut weights) = (Vec3::ZERO, 0.0);
        for near in 0..27 {
            let step = |shift: i32| near / shift % 3 - 1;
            let cell = [step(1), step(3), step(9)];
            let cell =
                [x.saturating_add(cell[0]), y.saturating_add(cell[1]), z.saturating_add(cell[2])];
            for &i in self.cells.get(&cell).into_iter().flatten() {
                let away = p.distance(self.eyes[i as usize]);
                let weight = (1.0 - away / self.reach).max(0.0).powi(2);
                vector += self.means[i as usize] * weight;
                weights += weight;
            }
        }
        (weights > 0.0).then(|| vector / weights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photometry::Reflectance;

    fn patch(eye: Vec3, normal: Vec3) -> Patch {
        Patch { eye, normal, area: 64.0 * 64.0, reflectance: Reflectance::default() }
    }

    #[test]
    fn what_lies_below_the_horizon_sends_nothing() {
        let floor = patch(Vec3::ZERO, Vec3::Z);
        let wall = |height| patch(Vec3::new(100.0, 0.0, height), Vec3::NEG_X);
        let height = |h: f32| way_to(&floor, &wall(h)).z;
        assert_eq!([height(80.0), height(32.0)], [80.0, 32.0], "all of it is above");
        assert_eq!([height(0.0), height(-16.0)], [16.0, 8.0], "the middle of the upper part");
        assert_eq!(height(-50.0), 0.0);
        let ceiling = patch(Vec3::Z * 9.0, Vec3::NEG_Z);
        assert_eq!(way_to(&floor, &ceiling), Vec3::Z * 9.0, "it has no height of its own");
    }
}
