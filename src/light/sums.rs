//! Sums of light at the samples of a surface.

use super::{Directions, StyleLight};
use crate::photometry::Irradiance;
use crate::scene::effects::COMPILED;
use glam::Vec3;

/// Light that one source gives one sample.
#[derive(Clone, Copy)]
pub(super) struct Given {
    /// The light style.
    pub style: u16,
    /// In light units.
    pub colour: Vec3,
    /// Part of it that does not bounce.
    pub excess: Vec3,
    /// Leads to the source.
    pub way: Vec3,
}

/// Sums that the light of a source goes to.
pub(super) struct Sums<'a> {
    /// Number of samples.
    pub count: usize,
    /// Light by style.
    pub styles: &'a mut Vec<StyleLight>,
    /// Part of it that does not bounce.
    pub excess: &'a mut Vec<StyleLight>,
    /// Where it comes from.
    pub directions: &'a mut Directions,
}

impl Sums<'_> {
    /// Adds what a sample is given.
    pub fn add(&mut self, i: usize, given: &Given) {
        self.add_as::<COMPILED>(i, given);
    }

    /// The same, but for directions without `ANY`.
    #[inline]
    pub fn add_as<const ANY: bool>(&mut self, i: usize, given: &Given) {
        if ANY {
            self.directions.add(given.style, (i, self.count), given.way, given.colour);
        }
        add(self.styles, given.style, self.count, i, given.colour);
        if given.excess != Vec3::ZERO {
            add(self.excess, given.style, self.count, i, given.excess);
        }
    }
}

/// Adds light of a style to sample `i` of `count`.
pub(super) fn add(styles: &mut Vec<StyleLight>, style: u16, count: usize, i: usize, colour: Vec3) {
    let slot = slot(styles, style, count);
    styles[slot].irradiance[i] += Irradiance(colour);
}

/// The place of a style, which is made if it is not there.
pub(super) fn slot(styles: &mut Vec<StyleLight>, style: u16, count: usize) -> usize {
    styles.iter().position(|s| s.style == style).unwrap_or_else(|| {
        styles.push(StyleLight { style, irradiance: vec![Irradiance::ZERO; count] });
        styles.len() - 1
    })
}
