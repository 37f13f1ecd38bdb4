//! Settings of bounced light that are worth their cost: points of the measured fronts.

use crate::lightmap::Gather;
use crate::radiosity::hemicube::HemicubeSize;
use crate::settings::Settings;

/// Settings of one cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rung {
    /// Cells along the edge of a hemicube.
    pub cells: u32,
    /// Longest edge of a patch in luxels.
    pub patch_size: u32,
    /// Error that interpolation may make; 0 for a hemicube at every luxel.
    pub gather_error: f64,
    /// How readily patches share a hemicube.
    pub share: f32,
    /// Relative root mean square error on game maps: the largest of those with known light.
    pub error: f64,
    /// Share of the luxels that get hemicubes.
    pub luxels: f64,
}

/// The settings that are chosen from, the roughest first; which of two is cheaper depends on the map.
/// Errors are those of `lqdm2`, the largest among the maps that were swept.
pub fn rungs() -> Vec<Rung> {
    let rung = |cells, patch_size, gather_error, share, error, luxels| Rung {
        cells,
        patch_size,
        gather_error,
        share,
        error,
        luxels,
    };
    vec![
        rung(16, 8, f64::INFINITY, 0.25, 0.1, 0.03),
        rung(16, 4, f64::INFINITY, 0.25, 0.085, 0.03),
        rung(12, 2, 0.14, 0.25, 0.044, 0.04),
        rung(16, 2, 0.2, 0.25, 0.042, 0.06),
        rung(16, 2, 0.1, 0.25, 0.04, 0.1),
        rung(16, 2, 0.05, 0.25, 0.036, 0.2),
        rung(16, 8, 0.0, 0.25, 0.026, 1.0),
        rung(32, 2, 0.02, 0.0, 0.025, 0.4),
        rung(32, 4, 0.0, 0.0, 0.02, 1.0),
        rung(64, 2, 0.0, 0.0, 0.018, 1.0),
    ]
}

impl Rung {
    /// `base` with the settings of this rung.
    pub fn settings(&self, base: &Settings) -> Settings {
        let luxel = self.gather_error == 0.0;
        Settings {
            hemicube: HemicubeSize::new(self.cells, self.cells).expect("even and in range"),
            patch_size: self.patch_size,
            gather: if luxel { Gather::Luxel } else { Gather::Interpolate },
            gather_error: if luxel { f64::INFINITY } else { self.gather_error },
            share: self.share,
            ..base.clone()
        }
    }

    /// The nearest rung to some settings: its shares of luxels and its error tell of theirs.
    pub fn of(settings: &Settings) -> Self {
        let own = Self {
            cells: settings.hemicube.width(),
            patch_size: settings.patch_size,
            gather_error: if settings.gather == Gather::Luxel {
                0.0
            } else {
                settings.gather_error
            },
            share: settings.share,
            error: 0.0,
            luxels: 0.0,
        };
        let log = |e: f64| e.clamp(0.005, 1.0).ln();
        let away = |r: &Self| {
            let cells = (f64::from(r.cells) / f64::from(own.cells)).ln().abs();
            let patch = (f64::from(r.patch_size) / f64::from(own.patch_size)).ln().abs();
            // How light gets to luxels matters most.
            3.0 * (log(r.gather_error) - log(own.gather_error)).abs() + patch + 0.5 * cells
        };
        let all = rungs();
        let near = all.iter().min_by(|a, b| away(a).total_cmp(&away(b))).expect("there are rungs");
        Self { error: near.error, luxels: near.luxels, ..own }
    }

    /// The settings in words.
    pub fn text(&self) -> String {
        let gather = if self.gather_error == 0.0 {
            "a hemicube at every luxel".to_owned()
        } else if self.gather_error.is_infinite() {
            "light between patches interpolated".to_owned()
        } else {
            format!("interpolation that errs by {:.0} %", 100.0 * self.gather_error)
        };
        format!(
            "patches of {} luxels, hemicubes of {} cells, {gather}",
            self.patch_size, self.cells
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Quality;

    #[test]
    fn finer_rungs_err_less() {
        let rungs = rungs();
        assert!(rungs.windows(2).all(|r| r[0].error > r[1].error));
        for rung in &rungs {
            assert!(rung.settings(&Settings::default()).checked().is_ok());
            assert_eq!(Rung::of(&rung.settings(&Settings::default())), *rung);
        }
    }

    #[test]
    fn presets_are_in_order() {
        use Quality::{Draft, Final, High, Normal};
        let of = |q| Rung::of(&Settings::of_quality(q)).error;
        let errors = [Draft, Normal, High, Final].map(of);
        assert!(errors.windows(2).all(|e| e[0] > e[1]), "{errors:?}");
    }
}
