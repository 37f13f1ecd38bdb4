//! Where light comes from: what deluxemaps hold (contract sections 1.6 and 4.6).

use super::point::NEAREST;
use crate::scene::effects::COMPILED;
use glam::Vec3;

/// Where the light of one style comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct StyleDirections {
    /// The light style.
    pub style: u16,
    /// For each sample, the sum over all light that arrives of its [`strength`] times the unit vector
    /// towards its source, in world space and light units.
    pub vectors: Vec<Vec3>,
}

/// Where the light at the samples of a surface comes from, by style. Holds nothing unless wanted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Directions {
    wanted: bool,
    styles: Vec<StyleDirections>,
}

impl Directions {
    /// Directions that take up what is added to them; the default ones do not.
    pub fn wanted() -> Self {
        Self { wanted: true, styles: Vec::new() }
    }

    /// Whether anything is taken up.
    pub fn are_wanted(&self) -> bool {
        self.wanted
    }

    /// What was added, in the order in which the styles came up.
    pub fn styles(&self) -> &[StyleDirections] {
        &self.styles
    }

    /// The same, to be changed.
    pub(super) fn styles_mut(&mut self) -> &mut Vec<StyleDirections> {
        &mut self.styles
    }

    /// Adds light of a style to sample `i` of `count`: `way` leads to its source, whose distance does
    /// not matter unless it is next to nothing, when it counts as straight above.
    pub(super) fn add(&mut self, style: u16, (i, count): (usize, usize), way: Vec3, colour: Vec3) {
        if COMPILED && self.wanted {
            let towards = if way.length() < NEAREST { Vec3::Z } else { way.normalize_or_zero() };
            self.add_vector(style, (i, count), towards * strength(colour));
        }
    }

    /// Adds a direction times its strength to sample `i` of `count`.
    pub(crate) fn add_vector(&mut self, style: u16, (i, count): (usize, usize), vector: Vec3) {
        let slot = self.styles.iter().position(|s| s.style == style).unwrap_or_else(|| {
            self.styles.push(StyleDirections { style, vectors: vec![Vec3::ZERO; count] });
            self.styles.len() - 1
        });
        self.styles[slot].vectors[i] += vector;
    }
}

/// How much light of a colour counts: its largest channel, as in the levels of lightmaps without
/// colour; below 0 for light that is taken away.
pub fn strength(colour: Vec3) -> f32 {
    let (low, high) = (colour.min_element(), colour.max_element());
    if high > 0.0 { high } else { low }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_held_unless_wanted() {
        let mut directions = Directions::default();
        directions.add(0, (0, 4), Vec3::X, Vec3::ONE);
        assert_eq!(directions.styles.capacity(), 0);
        let mut directions = Directions::wanted();
        directions.add(3, (1, 2), Vec3::X * 50.0, Vec3::new(1.0, 7.0, 2.0));
        directions.add(3, (1, 2), -Vec3::Y, Vec3::splat(-2.0));
        directions.add(3, (0, 2), Vec3::X * 0.01, Vec3::ONE);
        let vectors = vec![Vec3::Z, Vec3::new(7.0, 2.0, 0.0)];
        assert_eq!(directions.styles(), [StyleDirections { style: 3, vectors }]);
    }
}
