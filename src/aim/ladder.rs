//! Settings of bounced light that are worth their cost, and what they reached on maps with known light.

use crate::lightmap::Gather;
use crate::radiosity::hemicube::HemicubeSize;
use crate::settings::Settings;

/// What the rungs reached: written by `docs/accuracy.sh` from sweeps.
const MEASURED: &str = include_str!("measured.csv");

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
    /// Share of the luxels that get hemicubes: the mean of those maps.
    pub luxels: f64,
}

/// The settings that are chosen from, the roughest first; which of two is cheaper depends on the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Ladder {
    rungs: Vec<Rung>,
}

impl Default for Ladder {
    /// By all maps with known light.
    fn default() -> Self {
        Self::without("")
    }
}

impl Ladder {
    /// What is known without one map, by its name: so that predictions for that map can be judged.
    pub fn without(map: &str) -> Self {
        let mut rungs: Vec<(Rung, f64)> = Vec::new();
        for line in MEASURED.lines().skip(1) {
            let Some(rung) = line.split_once(',').filter(|l| l.0 != map).and_then(|l| rung(l.1))
            else {
                continue;
            };
            match rungs.iter_mut().find(|r| r.0.same_settings(&rung)) {
                Some((known, maps)) => {
                    known.error = known.error.max(rung.error);
                    known.luxels = (known.luxels * *maps + rung.luxels) / (*maps + 1.0);
                    *maps += 1.0;
                }
                None => rungs.push((rung, 1.0)),
            }
        }
        let mut rungs: Vec<Rung> = rungs.into_iter().map(|r| r.0).collect();
        rungs.sort_by(|a, b| b.error.total_cmp(&a.error));
        Self { rungs }
    }

    /// Without those that err less than `error`, save the roughest.
    pub fn down_to(mut self, error: f64) -> Self {
        let few = self.rungs.iter().filter(|r| r.error >= error).count();
        self.rungs.truncate(few.max(1));
        self
    }

    /// The rungs, the roughest first; at least one.
    pub fn rungs(&self) -> &[Rung] {
        &self.rungs
    }

    /// The rung of some settings: the nearest one tells of their error and their share of luxels.
    pub fn nearest(&self, settings: &Settings) -> Rung {
        let luxel = settings.gather == Gather::Luxel;
        let own = Rung {
            cells: settings.hemicube.width(),
            patch_size: settings.patch_size,
            gather_error: if luxel { 0.0 } else { settings.gather_error },
            share: settings.share,
            error: 0.0,
            luxels: 0.0,
        };
        let log = |e: f64| e.clamp(0.005, 1.0).ln();
        let away = |r: &Rung| {
            let cells = (f64::from(r.cells) / f64::from(own.cells)).ln().abs();
            let patch = (f64::from(r.patch_size) / f64::from(own.patch_size)).ln().abs();
            // How light gets to luxels matters most.
            3.0 * (log(r.gather_error) - log(own.gather_error)).abs() + patch + 0.5 * cells
        };
        let near = self.rungs.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        let near = near.expect("there are rungs");
        Rung { error: near.error, luxels: near.luxels, ..own }
    }
}

/// Reads a line of the table, after the name of the map.
fn rung(line: &str) -> Option<Rung> {
    let fields: Vec<&str> = line.split(',').collect();
    let [cells, patch_size, gather, share, error, luxels] = fields[..] else { return None };
    Some(Rung {
        cells: cells.parse().ok()?,
        patch_size: patch_size.parse().ok()?,
        gather_error: if gather == "luxel" { 0.0 } else { gather.parse().ok()? },
        share: share.parse().ok()?,
        error: error.parse().ok()?,
        luxels: luxels.parse().ok()?,
    })
}

impl Rung {
    fn same_settings(&self, other: &Self) -> bool {
        Self { error: 0.0, luxels: 0.0, ..*self } == Self { error: 0.0, luxels: 0.0, ..*other }
    }

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
    fn every_line_is_read_and_rungs_are_settings() {
        assert!(
            MEASURED.lines().skip(1).all(|l| l.split_once(',').and_then(|l| rung(l.1)).is_some())
        );
        let ladder = Ladder::default();
        assert!(ladder.rungs().len() >= 5);
        for rung in ladder.rungs() {
            assert!(rung.settings(&Settings::default()).checked().is_ok());
            assert_eq!(ladder.nearest(&rung.settings(&Settings::default())), *rung);
            assert!(rung.error > 0.0 && rung.error < 1.0 && rung.luxels <= 1.0, "{rung:?}");
        }
    }

    #[test]
    fn a_map_is_left_out() {
        let name = MEASURED.lines().nth(1).unwrap().split(',').next().unwrap();
        let maps = |list: &Ladder| list.rungs().iter().map(|r| r.luxels).sum::<f64>();
        let (all, without) = (Ladder::default(), Ladder::without(name));
        assert!(!without.rungs().is_empty() && maps(&all) != maps(&without));
        for rung in without.rungs() {
            let known = all.rungs().iter().find(|r| r.same_settings(rung)).unwrap();
            assert!(known.error >= rung.error);
        }
    }

    #[test]
    fn presets_are_in_order() {
        use Quality::{Draft, Final, High, Normal};
        let of = |q| Ladder::default().nearest(&Settings::of_quality(q)).error;
        let errors = [Draft, Normal, High, Final].map(of);
        assert!(errors.windows(2).all(|e| e[0] > e[1]), "{errors:?}");
    }
}
