//! What the presets reached on text scenes with known light.

use crate::settings::Quality;

/// Errors by scene, in percent: written by the test `accuracy_table` (see docs/accuracy.md).
const MEASURED: &str = include_str!("measured_text.csv");
/// This share of the scenes has at most the error that is expected.
const SHARE: f64 = 0.9;
const PRESETS: [Quality; 4] = [Quality::Draft, Quality::Normal, Quality::High, Quality::Final];

/// The error that is expected of each preset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextLadder {
    errors: [f64; 4],
}

impl Default for TextLadder {
    /// By all scenes with known light.
    fn default() -> Self {
        Self::without("")
    }
}

impl TextLadder {
    /// What is known without one scene, by its name, and those of which that is a part: so that
    /// predictions for that scene can be judged.
    pub fn without(scene: &str) -> Self {
        let lines = MEASURED.lines().skip(1).filter_map(|line| line.split_once(','));
        let related =
            |name: &str| !scene.is_empty() && (name.starts_with(scene) || scene.starts_with(name));
        let others: Vec<Vec<f64>> = lines
            .filter(|line| !related(line.0))
            .map(|line| line.1.split(',').filter_map(|e| e.parse().ok()).collect())
            .collect();
        let of = |preset: usize| {
            let mut errors: Vec<f64> =
                others.iter().filter_map(|e| e.get(preset).copied()).collect();
            errors.sort_by(f64::total_cmp);
            let at = (SHARE * errors.len() as f64).ceil() as usize;
            errors.get(at.max(1) - 1).map_or(1.0, |e| e / 100.0)
        };
        Self { errors: [0, 1, 2, 3].map(of) }
    }

    /// Relative root mean square errors of the presets.
    pub fn errors(&self) -> [(Quality, f64); 4] {
        std::array::from_fn(|i| (PRESETS[i], self.errors[i]))
    }

    /// The cheapest preset that is expected to reach a relative error, or the finest.
    pub fn quality(&self, target: f64) -> Quality {
        let enough = self.errors().into_iter().find(|e| e.1 <= target);
        enough.map_or(Quality::Final, |e| e.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_is_read_and_finer_presets_err_less() {
        assert!(MEASURED.lines().skip(1).all(|l| {
            l.split(',').count() == 5 && l.split(',').skip(1).all(|e| e.parse::<f64>().is_ok())
        }));
        let all = TextLadder::default();
        assert!(all.errors.windows(2).all(|e| e[0] > e[1]), "{all:?}");
        assert_eq!(all.quality(0.5), Quality::Draft);
        assert_eq!(all.quality(1e-6), Quality::Final);
        assert!(TextLadder::without("cornell_small").errors[0] < all.errors[0]);
    }
}
