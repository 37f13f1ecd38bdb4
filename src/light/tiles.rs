//! The free samples of a surface in nested tiles of neighbours: rays from one tile to one light take
//! similar ways, so most of their work is done once a tile.

use crate::scene::{Bounds, Floor, Sample};
use glam::Vec3;
use std::ops::Range;

/// Tiles of this many samples or fewer have no parts.
const LEAST: usize = 16;

/// The tiles of a surface.
pub(super) struct Tiles {
    /// Indices of the free samples; those of a tile are neighbours here.
    order: Vec<u32>,
    /// The whole surface first; none if no sample is free.
    tiles: Vec<Tile>,
    normal: Vec3,
}

/// What a sample stands for: the box around it and others.
pub(super) struct Item {
    /// The sample.
    pub sample: u32,
    low: Vec3,
    high: Vec3,
    /// Least product of the surface's normal with a point.
    least: f64,
}

impl Item {
    /// `sample` stands for `all`, of a surface with the given normal.
    pub fn around(samples: &[Sample], all: &[u32], sample: u32, normal: Vec3) -> Self {
        let none =
            Self { sample, low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, least: f64::INFINITY };
        all.iter().fold(none, |item, &i| {
            let p = samples[i as usize].position;
            let least = item.least.min(normal.as_dvec3().dot(p.as_dvec3()));
            Self { low: item.low.min(p), high: item.high.max(p), least, ..item }
        })
    }

    fn tile(&self, range: Range<usize>) -> Option<Tile> {
        let bounds = Bounds::around([self.low, self.high].into_iter())?;
        Some(Tile { range, parts: 0..0, bounds, least: self.least })
    }
}

/// One tile.
pub(super) struct Tile {
    range: Range<usize>,
    /// Tiles that make up this one; none of the smallest.
    parts: Range<usize>,
    /// The box around its samples.
    pub bounds: Bounds,
    /// Least product of the surface's normal with a sample.
    least: f64,
}

impl Tiles {
    /// The tiles of the free samples of a surface with the given normal.
    pub fn new(samples: &[Sample], normal: Vec3) -> Self {
        let free = (0..samples.len() as u32).filter(|&i| !samples[i as usize].occluded);
        let items: Vec<Item> = free.map(|i| Item::around(samples, &[i], i, normal)).collect();
        Self::of_items(&items, samples, normal)
    }

    /// No tiles yet.
    pub fn none(normal: Vec3) -> Self {
        Self { order: Vec::new(), tiles: Vec::new(), normal }
    }

    /// Tiles of samples that may stand for others.
    pub fn of_items(items: &[Item], samples: &[Sample], normal: Vec3) -> Self {
        let mut made = Self::none(normal);
        made.order.extend(0..items.len() as u32);
        made.tiles.extend(made.tile(items, 0..items.len()));
        let mut next = 0;
        while next < made.tiles.len() {
            let range = made.tiles[next].range.clone();
            if range.len() > LEAST {
                let first = made.tiles.len();
                for half in made.split(items, samples, range) {
                    let quarters = if half.len() > LEAST {
                        made.split(items, samples, half)
                    } else {
                        [half.clone(), half.end..half.end]
                    };
                    for quarter in quarters {
                        made.tiles.extend(made.tile(items, quarter));
                    }
                }
                made.tiles[next].parts = first..made.tiles.len();
            }
            next += 1;
        }
        made.order.iter_mut().for_each(|i| *i = items[*i as usize].sample);
        made
    }

    /// Adds a tile without parts.
    pub fn push(&mut self, members: &[u32], item: &Item) {
        let first = self.order.len();
        self.order.extend_from_slice(members);
        self.tiles.extend(item.tile(first..self.order.len()));
    }

    /// All tiles.
    pub fn all(&self) -> &[Tile] {
        &self.tiles
    }

    /// The tile of a range; `None` if that is empty.
    fn tile(&self, items: &[Item], range: Range<usize>) -> Option<Tile> {
        let members = self.order[range.clone()].iter().map(|&i| &items[i as usize]);
        let around = members.fold(Item::around(&[], &[], 0, self.normal), |sum, item| Item {
            low: sum.low.min(item.low),
            high: sum.high.max(item.high),
            least: sum.least.min(item.least),
            ..sum
        });
        if range.is_empty() { None } else { around.tile(range) }
    }

    /// Orders a range across its longer side and halves it.
    fn split(
        &mut self,
        items: &[Item],
        samples: &[Sample],
        range: Range<usize>,
    ) -> [Range<usize>; 2] {
        let part = &mut self.order[range.clone()];
        let place = |i: u32| samples[items[i as usize].sample as usize].position;
        let (low, high) = part.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), &i| {
            (a.min(place(i)), b.max(place(i)))
        });
        let axis = (high - low).max_position();
        let middle = part.len() / 2;
        part.select_nth_unstable_by(middle, |&a, &b| {
            place(a)[axis].total_cmp(&place(b)[axis]).then(a.cmp(&b))
        });
        [range.start..range.start + middle, range.start + middle..range.end]
    }

    /// The tile of all free samples; `None` if there are none.
    pub fn whole(&self) -> Option<&Tile> {
        self.tiles.first()
    }

    /// The tiles that make up another; none if it is one of the smallest.
    pub fn parts(&self, tile: &Tile) -> &[Tile] {
        &self.tiles[tile.parts.clone()]
    }

    /// Indices of the samples in a tile.
    pub fn members(&self, tile: &Tile) -> &[u32] {
        &self.order[tile.range.clone()]
    }

    /// What the samples of a tile and other points are all in front of.
    pub fn floor_with(&self, tile: &Tile, points: impl Iterator<Item = Vec3>) -> Floor {
        let along = |p: Vec3| self.normal.as_dvec3().dot(p.as_dvec3());
        Floor { normal: self.normal, least: points.map(along).fold(tile.least, f64::min) }
    }

    /// What the samples of a tile are all in front of before and after a move.
    pub fn floor_after(&self, tile: &Tile, way: Vec3) -> Floor {
        let rise = self.normal.as_dvec3().dot(way.as_dvec3());
        Floor { normal: self.normal, least: tile.least + rise.min(0.0) }
    }

    /// What rays from the samples of a tile in a direction are all in front of.
    pub fn floor_along(&self, tile: &Tile, direction: Vec3) -> Option<Floor> {
        let rises = self.normal.dot(direction) > 0.0;
        rises.then_some(Floor { normal: self.normal, least: tile.least })
    }
}
