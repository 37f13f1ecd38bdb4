//! Which lights each surface may get light from. Surfaces near each other are looked at together first,
//! so that lights far away or behind walls are left out once for many.

use super::BoundingSphere;
use super::reach::may_shine_on;
use crate::scene::exact::length;
use crate::scene::{Bounds, Hidden, LightRays, Sample, Scene};
use glam::Vec3;
use rayon::prelude::*;

/// Surfaces that one task looks at, at most.
const TASK: usize = 256;
/// Groups of surfaces as wide as this share of their distance from a light are not looked at together.
const WIDE: f32 = 1.0;
/// Groups in more leafs of the map than this are not looked up in its visibility.
const MOST_LEAFS: usize = 32;
/// Entries of all lists together, at most: 128 MiB.
const MOST: usize = 1 << 25;

/// The lights of a scene that each surface may get light from.
pub struct Candidates(Vec<List>);

/// Lights of a surface; `None` for all of the scene.
type List = Option<Box<[u32]>>;

/// A surface.
struct Item {
    surface: u32,
    /// Box around its free samples.
    low: Vec3,
    high: Vec3,
    /// Leafs of those.
    leafs: Vec<Option<u32>>,
}

impl Candidates {
    /// The lights of which each surface may get light at its `samples`; what is left out gives none.
    /// Where a luxel is a cell of more than one sample, `cell` x `cell`, visibility is that of the first
    /// in each, as in [`super::direct_adaptive`].
    pub fn find(scene: &Scene, samples: &[Vec<Sample>], cell: u32) -> Self {
        Self::find_at_most(scene, samples, cell, MOST)
    }

    /// The same with lists of at most `most` entries together. Surfaces near each other whose lists are longer
    /// than their share of that have none.
    pub fn find_at_most(scene: &Scene, samples: &[Vec<Sample>], cell: u32, most: usize) -> Self {
        let item =
            |(surface, samples): (usize, &Vec<Sample>)| Item::of(scene, surface, samples, cell);
        let mut items: Vec<Item> = samples.par_iter().enumerate().filter_map(item).collect();
        let each = most / items.len().max(1);
        let mut tasks = Vec::new();
        divide(&mut items, &mut tasks);
        let found: Vec<Vec<(u32, List)>> = tasks
            .into_par_iter()
            .map(|items| {
                let lights = scene.lights.len();
                let mut search = Search {
                    scene,
                    rays: LightRays::new(scene, None),
                    walls: vec![None; lights],
                    found: Vec::new(),
                    room: each * items.len(),
                };
                let all = (0..lights as u32).collect();
                match search.group(items, all, 0) {
                    Some(()) => search.found,
                    None => items.iter().map(|item| (item.surface, None)).collect(),
                }
            })
            .collect();
        // Surfaces that are no items get no light.
        let mut lists = vec![Some(Box::default()); samples.len()];
        for (surface, list) in found.into_iter().flatten() {
            lists[surface as usize] = list;
        }
        Self(lists)
    }

    /// The lights of a surface, in their order; `None` for all lights of the scene.
    pub fn of(&self, surface: usize) -> Option<&[u32]> {
        self.0[surface].as_deref()
    }
}

impl Item {
    /// `None` for a surface that gets no light.
    fn of(scene: &Scene, surface: usize, samples: &[Sample], cell: u32) -> Option<Self> {
        let face = &scene.surfaces[surface];
        let free = || samples.iter().filter(|s| !s.occluded).map(|s| s.position);
        if face.light_ignore || free().next().is_none() {
            return None;
        }
        let low = free().fold(Vec3::INFINITY, Vec3::min);
        let high = free().fold(Vec3::NEG_INFINITY, Vec3::max);
        let (row, cell) =
            (face.luxels.as_ref().map_or(1, |g| g.width * cell) as usize, cell as usize);
        let is_looked_up = |i: &usize| {
            !samples[*i].occluded
                && (i % row).is_multiple_of(cell)
                && (i / row).is_multiple_of(cell)
        };
        let leaf = |i: usize| scene.visibility.leaf(&scene.solid, samples[i].position);
        let mut leafs: Vec<_> = (0..samples.len()).filter(is_looked_up).map(leaf).collect();
        if leafs.is_empty() {
            leafs.push(None);
        }
        leafs.sort_unstable();
        leafs.dedup();
        Some(Self { surface: surface as u32, low, high, leafs })
    }
}

/// Orders items so that those near each other are in one task.
fn divide<'i>(items: &'i mut [Item], tasks: &mut Vec<&'i mut [Item]>) {
    if items.len() <= TASK {
        tasks.push(items);
    } else {
        let (one, other) = halve(items);
        divide(one, tasks);
        divide(other, tasks);
    }
}

/// Orders items so that each half is near each other.
fn halve(items: &mut [Item]) -> (&mut [Item], &mut [Item]) {
    let (low, high) = around(items);
    let axis = (high - low).max_position();
    let middle = items.len() / 2;
    let place = |i: &Item| i.low[axis] + i.high[axis];
    items.select_nth_unstable_by(middle, |a, b| {
        place(a).total_cmp(&place(b)).then(a.surface.cmp(&b.surface))
    });
    items.split_at_mut(middle)
}

fn around(items: &[Item]) -> (Vec3, Vec3) {
    items.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), i| {
        (low.min(i.low), high.max(i.high))
    })
}

/// Looks at the groups of a task.
struct Search<'a> {
    scene: &'a Scene,
    rays: LightRays<'a>,
    /// What last hid each light from a group.
    walls: Vec<Option<u32>>,
    found: Vec<(u32, List)>,
    /// Entries that further lists may have.
    room: usize,
}

impl Search<'_> {
    /// Finds which of `lights` the surfaces of a group, which is part of others, may get light from. `None`
    /// once there is no room for so many.
    fn group(&mut self, items: &mut [Item], lights: Vec<u32>, others: u32) -> Option<()> {
        if items.is_empty() {
            return Some(());
        }
        let (low, high) = around(items);
        let bounds = Bounds::around([low, high].into_iter())?;
        let sphere = self.sphere(items);
        let leafs = leafs(items);
        let is_worth_a_look = items.len() == 1 || others.is_multiple_of(2);
        let mut left = Vec::with_capacity(lights.len());
        for light in lights {
            let reach = self.scene.visibility.of_light(light as usize);
            let sees = leafs.is_empty() || leafs.iter().any(|l| reach.includes(*l));
            if sees
                && self.may_reach(light, items, &sphere)
                && !(is_worth_a_look && self.is_dark(light, &bounds, items.len() == 1))
            {
                left.push(light);
            }
        }
        if let [item] = items {
            self.room = self.room.checked_sub(left.len())?;
            self.found.push((item.surface, Some(left.into())));
            return Some(());
        }
        let (one, other) = halve(items);
        self.group(one, left.clone(), others + 1)?;
        self.group(other, left, others + 1)
    }

    /// A sphere around those of all surfaces of a group.
    fn sphere(&self, items: &[Item]) -> BoundingSphere {
        let of = |i: &Item| BoundingSphere::of(&self.scene.surfaces[i.surface as usize]);
        if let [item] = items {
            return of(item);
        }
        let (low, high) = around(items);
        let centre = (low + high) * 0.5;
        let reach = |s: BoundingSphere| length(s.centre - centre) + s.radius;
        let radius = items.iter().map(|i| reach(of(i))).fold(0.0, f32::max);
        // For rounding.
        BoundingSphere { centre, radius: radius * 1.0001 + 0.01 }
    }

    /// Whether a light is near enough to a group, and not behind its only surface.
    fn may_reach(&self, light: u32, items: &[Item], sphere: &BoundingSphere) -> bool {
        let (light, world) = (&self.scene.lights[light as usize], &self.scene.world);
        match items {
            [item] => {
                may_shine_on(world, light, &self.scene.surfaces[item.surface as usize], sphere)
            }
            _ => !sphere.is_out_of_reach(light, world.dist, world.gate),
        }
    }

    /// Whether a light is surely hidden from all of a box: by what hid it before, or else by what is met
    /// first on the way to the middle of the box, or back for a single surface.
    fn is_dark(&mut self, light: u32, bounds: &Bounds, single: bool) -> bool {
        let at = light as usize;
        let light = &self.scene.lights[at];
        let middle = bounds.centre();
        let is_wide = 2.0 * bounds.radius() > WIDE * length(light.origin - middle);
        if light.shadow_mask & 1 == 0 || is_wide || !self.rays.look_at(bounds, light.origin) {
            return false;
        }
        let mut last = self.walls[at];
        let mut hidden = last.map_or(Hidden::Unknown, |wall| self.rays.hidden_by(wall));
        let ways = [(light.origin, middle), (middle, light.origin)];
        let (first, end) = (usize::from(hidden == Hidden::Middle), 1 + usize::from(single));
        for &(from, to) in &ways[first..end] {
            if matches!(hidden, Hidden::All(_)) {
                break;
            }
            let Some(wall) = self.rays.first_blocker(from, to) else { return false };
            if last.replace(wall) != Some(wall) {
                hidden = self.rays.hidden_by(wall);
            }
        }
        let is_dark = matches!(hidden, Hidden::All(_));
        if is_dark {
            self.walls[at] = last;
        }
        is_dark
    }
}

/// The leafs of a group; none if there are too many.
fn leafs(items: &[Item]) -> Vec<Option<u32>> {
    if items.iter().map(|i| i.leafs.len()).sum::<usize>() > MOST_LEAFS && items.len() > 1 {
        return Vec::new();
    }
    let mut all: Vec<_> = items.iter().flat_map(|i| &i.leafs).copied().collect();
    all.sort_unstable();
    all.dedup();
    all
}
