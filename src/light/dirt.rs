//! Dirt: light is weaker where surfaces are near, as if dirt gathered in corners (contract section
//! 6.3). Rays into the half space over a luxel measure how much room it has.

use super::cells::Cells;
use super::spread::Shares;
use super::tiles::{Tile, Tiles};
use super::totals::LitPoints;
use crate::scene::effects::COMPILED;
use crate::scene::exact::{dot, normalize, radians};
use crate::scene::random::SplitMix;
use crate::scene::{Bounds, DirtKeys, DirtSettings, Floor, LightRays, Sample, Scene};
use glam::Vec3;
use std::f64::consts::TAU;
use std::ops::Range;

/// Most samples of a tile whose rays are looked at together.
const MOST_AT_ONCE: usize = 256;
/// Dirt that varies less between the corners of a cell counts as linear there, as a share of light.
const STEADY: f32 = 0.015;
/// The same where a cell's middle is known too, of how far that is from linear.
const LINEAR: f32 = 0.0125;
/// Azimuths of the fixed directions.
const AZIMUTHS: u32 = 16;
/// Elevations of the fixed directions at each azimuth.
const ELEVATIONS: u32 = 3;

/// Dirt at the samples of one surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaceDirt {
    /// How much of the surroundings is near, 0 to 1, a sample; empty where there is no dirt.
    occlusion: Vec<f32>,
    gain: f32,
    scale: f32,
}

impl FaceDirt {
    /// Traces dirt at the samples of a surface, in cells only where it varies. Samples inside solid have
    /// all of it.
    pub(super) fn trace(
        scene: &Scene,
        index: usize,
        (samples, points): (&[Sample], &LitPoints),
        rays: &mut LightRays<'_>,
    ) -> Self {
        let settings = &scene.world.dirt;
        let surface = &scene.surfaces[index];
        if !COMPILED || !settings.in_use || surface.no_dirt {
            return Self::default();
        }
        let mut room = Room {
            depth: settings.depth,
            scale: settings.scale.max(1.0),
            mask: surface.channel_mask,
            samples,
            sums: vec![0.0; samples.len()],
            rays,
        };
        if settings.random {
            for (i, sample) in samples.iter().enumerate().filter(|(_, s)| !s.occluded) {
                let mut random = sequence(index as u64, i as u64);
                let frame = Frame::of(sample);
                for direction in random_directions(settings, &mut random) {
                    room.look(i, frame.turned(direction));
                }
            }
        } else {
            match points {
                LitPoints::Each(tiles, _) => {
                    let whole = tiles.whole().into_iter();
                    whole.for_each(|w| room.trace((tiles, w), |_| true, &directions(settings)));
                }
                LitPoints::Cells(cells) => room.trace_cells(cells, &directions(settings)),
            }
        }
        let rays = (AZIMUTHS * ELEVATIONS) as usize;
        let occlusion = |(sample, sum): (&Sample, &f32)| {
            if sample.occluded { 1.0 } else { 1.0 - sum / rays as f32 / settings.depth }
        };
        let occlusion = samples.iter().zip(&room.sums).map(occlusion).collect();
        Self { occlusion, gain: settings.gain, scale: settings.scale }
    }

    /// Dirt at other samples, each a sum of shares of those here; all of it where there are none.
    pub(super) fn spread(&self, shares: &[Shares]) -> Self {
        let sum = |s: &Shares| match &s[..] {
            [] => 1.0,
            some => some.iter().map(|&(k, share)| self.occlusion[k] * share).sum(),
        };
        let is_there = !self.occlusion.is_empty();
        let occlusion = if is_there { shares.iter().map(sum).collect() } else { Vec::new() };
        Self { occlusion, ..*self }
    }

    /// Puts the dirt of the samples in `range` into that of `count`.
    pub(super) fn put(&mut self, range: &Range<usize>, part: &Self, count: usize) {
        if !part.occlusion.is_empty() {
            (self.gain, self.scale) = (part.gain, part.scale);
            self.occlusion.resize(count, 0.0);
            self.occlusion[range.clone()].copy_from_slice(&part.occlusion);
        }
    }

    /// Whether there is none on the whole surface.
    pub(super) fn is_none(&self) -> bool {
        self.occlusion.is_empty()
    }

    /// Share of light that dirt leaves at a sample by the settings of the map, 0 to 1.
    pub(crate) fn share_left(&self, sample: usize) -> f32 {
        self.factor(sample, &DirtKeys::plain(true), 0.0)
    }

    /// Share of the light of a consumer that dirt leaves at a sample, 0 to 1. `distance` is that of
    /// the light, in world units; 0 for light without a place.
    pub(crate) fn factor(&self, sample: usize, keys: &DirtKeys, distance: f32) -> f32 {
        let occlusion = if COMPILED { self.occlusion.get(sample) } else { None };
        let Some(&occlusion) = occlusion else { return 1.0 };
        if !keys.wanted || occlusion <= 0.0 {
            return 1.0;
        }
        let or = |own: f32, world: f32| if own == 0.0 { world } else { own };
        let gain = or(keys.gain, self.gain);
        let mut dirt = if gain == 1.0 { occlusion } else { occlusion.powf(gain) }.min(1.0);
        dirt = (dirt * or(keys.scale, self.scale)).min(1.0);
        if let Some([off, on]) = keys.radii {
            if distance < off {
                dirt = 0.0;
            } else if distance < on {
                dirt *= (distance - off) / (on - off);
            }
        }
        1.0 - dirt
    }
}

/// Directions about the z axis, which stands for the normal, evenly spread. Angles are summed in
/// single precision as in the reference, because rays along the axes of a map meet edges.
fn directions(settings: &DirtSettings) -> Vec<Vec3> {
    let azimuth_step = radians(360.0 / AZIMUTHS as f32) as f32;
    let elevation_step = radians(settings.angle / ELEVATIONS as f32) as f32;
    let mut directions = Vec::with_capacity((AZIMUTHS * ELEVATIONS) as usize);
    let mut azimuth = 0.0_f32;
    for _ in 0..AZIMUTHS {
        let mut elevation = elevation_step * 0.5;
        for _ in 0..ELEVATIONS {
            directions.push(direction(azimuth.into(), elevation.into()));
            elevation += elevation_step;
        }
        azimuth += azimuth_step;
    }
    directions
}

/// As many directions at random.
fn random_directions(settings: &DirtSettings, random: &mut SplitMix) -> Vec<Vec3> {
    (0..AZIMUTHS * ELEVATIONS)
        .map(|_| {
            let azimuth = random.next() * TAU;
            direction(azimuth, random.next() * radians(settings.angle))
        })
        .collect()
}

fn direction(azimuth: f64, elevation: f64) -> Vec3 {
    let (sin, cos) = elevation.sin_cos();
    Vec3::new((sin * azimuth.cos()) as f32, (sin * azimuth.sin()) as f32, cos as f32)
}

/// How much room there is over samples.
struct Room<'a, 's> {
    /// How far to look, in world units.
    depth: f32,
    /// Light lost where there is no room at all, at least 1.
    scale: f32,
    /// Channels of the surface.
    mask: i32,
    samples: &'a [Sample],
    /// Sum of the distances to what is around, a sample.
    sums: Vec<f32>,
    rays: &'a mut LightRays<'s>,
}

impl Room<'_, '_> {
    /// Looks from a sample in a direction.
    fn look(&mut self, i: usize, way: Vec3) {
        self.sums[i] += self.rays.room(self.samples[i].position, way, self.depth, self.mask);
    }

    /// Looks from the corners of cells, and from all samples of those where that makes a difference.
    fn trace_cells(&mut self, cells: &Cells, directions: &[Vec3]) {
        let Some(whole) = cells.coarse.whole() else { return };
        self.trace((&cells.coarse, whole), |i| cells.is_corner[i as usize], directions);
        // What is off here is so in all light, however many sources it comes from.
        let light = self.depth * directions.len() as f32 / self.scale;
        let corners = |sums: &[f32], k: usize| {
            let room = cells.cells()[k].corners.map(|i| sums[i as usize]);
            let (low, high) =
                room.iter().fold((f32::INFINITY, 0.0_f32), |(a, b), r| (a.min(*r), b.max(*r)));
            (room, high - low > STEADY * light)
        };
        let varied: Vec<bool> =
            (0..cells.cells().len()).map(|k| corners(&self.sums, k).1).collect();
        let mut is_known = cells.is_corner.clone();
        for (cell, _) in cells.cells().iter().zip(&varied).filter(|(_, varied)| **varied) {
            is_known[cell.middle as usize] = true;
        }
        let is_middle = |i: u32| is_known[i as usize] && !cells.is_corner[i as usize];
        self.trace((&cells.coarse, whole), is_middle, directions);
        for (k, (cell, tile)) in cells.cells().iter().zip(cells.fine.all()).enumerate() {
            let (room, _) = corners(&self.sums, k);
            let linear = |i: u32| -> f32 {
                room.iter().zip(cell.weights(i)).map(|(r, share)| r * share).sum()
            };
            let bulge =
                if varied[k] { self.sums[cell.middle as usize] - linear(cell.middle) } else { 0.0 };
            let is_between = |i: u32| !is_known[i as usize];
            if bulge.abs() > LINEAR * light {
                self.trace((&cells.fine, tile), is_between, directions);
                continue;
            }
            let most = cell.bulge(cell.middle).max(0.25);
            for &i in cells.fine.members(tile).iter().filter(|i| is_between(**i)) {
                self.sums[i as usize] = linear(i) + bulge * (cell.bulge(i) / most).min(1.0);
            }
        }
    }

    /// Looks from those samples of a tile that are `wanted` in each of the directions.
    fn trace(
        &mut self,
        (tiles, tile): (&Tiles, &Tile),
        wanted: impl Fn(u32) -> bool + Copy,
        directions: &[Vec3],
    ) {
        let (samples, depth) = (self.samples, self.depth);
        let members: Vec<u32> =
            tiles.members(tile).iter().copied().filter(|&i| wanted(i)).collect();
        let parts = tiles.parts(tile);
        if members.len() > MOST_AT_ONCE && !parts.is_empty() {
            parts.iter().for_each(|part| self.trace((tiles, part), wanted, directions));
            return;
        }
        if members.is_empty() {
            return;
        }
        let frames: Vec<Frame> = members.iter().map(|&i| Frame::of(&samples[i as usize])).collect();
        let flat = members
            .iter()
            .all(|&i| samples[i as usize].normal == samples[members[0] as usize].normal);
        let reach = |direction: Vec3| {
            if flat {
                let way = frames[0].turned(direction) * depth;
                return (tile.bounds.moved(way.as_dvec3()), tiles.floor_after(tile, way));
            }
            let ends = members
                .iter()
                .zip(&frames)
                .map(|(&i, frame)| samples[i as usize].position + frame.turned(direction) * depth);
            let floor = tiles.floor_with(tile, ends.clone());
            (Bounds::around(ends).unwrap_or(tile.bounds), floor)
        };
        let reaches: Vec<(Bounds, Floor)> = directions.iter().map(|&d| reach(d)).collect();
        let Some(all) = reaches
            .iter()
            .copied()
            .reduce(|a, b| (a.0.with(&b.0), if a.1.least < b.1.least { a.1 } else { b.1 }))
        else {
            return;
        };
        let narrow = self.rays.around(&tile.bounds, &all.0, all.1);
        for (&direction, (end, floor)) in directions.iter().zip(&reaches) {
            if narrow {
                self.rays.within(&tile.bounds, end, *floor);
            }
            for (&i, frame) in members.iter().zip(&frames) {
                self.look(i as usize, frame.turned(direction));
            }
        }
        self.rays.anywhere();
    }
}

/// The directions about a sample.
struct Frame {
    tangent: Vec3,
    bitangent: Vec3,
    normal: Vec3,
}

impl Frame {
    fn of(sample: &Sample) -> Self {
        let (tangent, bitangent) = frame(sample.normal);
        Self { tangent: normalize(tangent), bitangent: normalize(bitangent), normal: sample.normal }
    }

    /// A direction about the z axis turned to that of the sample.
    fn turned(&self, d: Vec3) -> Vec3 {
        self.bitangent * d.x + self.tangent * d.y + self.normal * d.z
    }
}

/// Two directions that span the plane across a normal (contract section 2.1), not of unit length.
fn frame(n: Vec3) -> (Vec3, Vec3) {
    let size = n.abs();
    let axis = (1..3).fold(0, |a, i| if size[i] > size[a] { i } else { a });
    let t = n.cross(Vec3::AXES[(axis + 1) % 3]);
    let b = n.cross(Vec3::AXES[(axis + 2) % 3]);
    if dot(t.cross(b), n) < 0.0 { (b, t) } else { (t, b) }
}

/// Numbers that depend on the surface and the sample alone.
fn sequence(surface: u64, sample: u64) -> SplitMix {
    SplitMix(surface << 32 ^ sample)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_unit_vectors_within_the_angle() {
        let settings = DirtSettings { angle: 60.0, ..DirtSettings::default() };
        let fixed = directions(&settings);
        assert_eq!(fixed.len(), 48);
        let drawn = random_directions(&settings, &mut sequence(3, 4));
        for d in fixed.iter().chain(&drawn) {
            assert!((d.length() - 1.0).abs() < 1e-6 && d.z >= 0.5, "{d}");
        }
        assert!((fixed[1].z - 30_f32.to_radians().cos()).abs() < 1e-6);
        assert_ne!(drawn, random_directions(&settings, &mut sequence(3, 5)));
    }

    #[test]
    fn frames_are_right_handed_and_across_the_normal() {
        for n in [Vec3::X, -Vec3::Y, Vec3::Z, Vec3::new(0.6, 0.0, -0.8)] {
            let (t, b) = frame(n);
            assert!(t.dot(n).abs() < 1e-6 && b.dot(n).abs() < 1e-6 && t.cross(b).dot(n) > 0.0);
        }
    }

    #[test]
    fn factors_follow_gain_scale_and_radii() {
        let dirt = FaceDirt { occlusion: vec![0.25, 0.0], gain: 1.0, scale: 2.0 };
        let plain = DirtKeys::plain(true);
        assert_eq!(dirt.factor(0, &plain, 0.0), 0.5);
        assert_eq!(dirt.factor(1, &plain, 0.0), 1.0);
        assert_eq!(dirt.factor(0, &DirtKeys::plain(false), 0.0), 1.0);
        let own = DirtKeys { gain: 0.5, scale: 1.0, ..plain };
        assert_eq!(dirt.factor(0, &own, 0.0), 0.5);
        let ramp = DirtKeys { radii: Some([10.0, 20.0]), ..plain };
        assert_eq!([5.0, 15.0, 30.0].map(|d| dirt.factor(0, &ramp, d)), [1.0, 0.75, 0.5]);
        assert_eq!(FaceDirt::default().factor(0, &plain, 0.0), 1.0);
    }
}
