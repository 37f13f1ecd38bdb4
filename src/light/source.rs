//! What point lights and suns have in common: each sends light to samples, and rays tell what arrives.

use super::sums::{Given, Sums};
use super::tiles::{Tile, Tiles};
use super::wanted::Wanted;
use crate::scene::effects::COMPILED;
use crate::scene::{Arrival, DirtKeys};
use glam::Vec3;

/// A light as one surface sees it.
pub(super) trait Source {
    /// Colour that arrives at a sample if nothing is in the way; `None` if that is too little.
    fn sent(&self, sample: usize) -> Option<Vec3>;

    /// Wants light at some samples; whether any of them may get some.
    fn want(&self, samples: &[u32], wanted: &mut Wanted) -> bool {
        wanted.want(samples, |i| self.sent(i))
    }

    /// Whether what arrives may be of another style than what is sent.
    fn may_change_style(&self) -> bool;

    /// Finds what arrives at the samples of a tile where light is wanted.
    fn trace(&mut self, tiles: &Tiles, tile: &Tile, wanted: &mut Wanted);

    /// What an arrival at a sample adds to the light there.
    fn given(&self, sample: usize, arrival: Arrival) -> Given;

    /// Whether it sends the same to every sample, dirt aside.
    fn is_even(&self) -> bool;

    /// By which keys dirt weakens it, whatever the distance; `None` if the distance matters.
    fn dirt(&self) -> Option<DirtKeys>;

    /// Share of it that dirt leaves at a sample, 0 to 1, where the distance does not matter.
    fn share_left(&self, sample: usize) -> f32;
}

/// Lights all `free` samples.
pub(super) fn light_all(
    source: &mut impl Source,
    (tiles, free): (&Tiles, &[u32]),
    wanted: &mut Wanted,
    sums: &mut Sums<'_>,
) {
    let Some(whole) = tiles.whole() else { return };
    if source.want(free, wanted) {
        source.trace(tiles, whole, wanted);
        if COMPILED && (sums.directions.are_wanted() || source.may_change_style()) {
            add_all::<true>(source, wanted, sums);
        } else {
            add_all::<false>(source, wanted, sums);
        }
    }
}

/// Adds what arrived. Without `ANY`, no directions are wanted and all light keeps its style.
fn add_all<const ANY: bool>(source: &impl Source, wanted: &mut Wanted, sums: &mut Sums<'_>) {
    for (i, arrival) in wanted.take() {
        let arrival = if ANY { arrival } else { Arrival { style: None, ..arrival } };
        sums.add_as::<ANY>(i, &source.given(i, arrival));
    }
}
