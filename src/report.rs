//! The table at the end of a run.

use crate::check::{Energy, Findings};
use crate::light::{DirectLight, RayCounts};
use crate::lightmap;
use crate::memory;
use crate::patch::MapPatches;
use crate::radiosity::bounce::Bounced;
use crate::radiosity::channels::Channels;
use crate::radiosity::transfers::Transfers;
use crate::scene::effects::Cost;
use crate::scene::{LuxelGrid, Scene};
use crate::stage::{Gathered, Points};
use std::collections::BTreeSet;
use std::fmt::{self, Display};
use std::time::Duration;

/// What a map run counted.
#[derive(Clone, Debug, PartialEq)]
pub struct Counts {
    /// Faces with a lightmap, of all.
    pub faces: [usize; 2],
    /// Luxels of those.
    pub luxels: usize,
    /// Patches.
    pub patches: usize,
    /// Lights, copies of surface lights included.
    pub lights: usize,
    /// Light styles that light anything.
    pub styles: usize,
    /// Shadow rays for direct light.
    pub rays: RayCounts,
    /// Hemicubes drawn, for patches and for luxels.
    pub hemicubes: [u64; 2],
    /// Form factors stored.
    pub transfers: usize,
    /// Bytes that they take, without what an overlay adds.
    pub transfer_bytes: u64,
    /// Patches that light comes through diffusely.
    pub passages: usize,
    /// Patches whose reflectance varies within their face.
    pub patterned: usize,
    /// What bounced light took to look through glass, and to look at what varies.
    pub overlay: [Cost; 2],
    /// Bytes of smoothed normals.
    pub smoothed: u64,
    /// Hemicubes for the least light of brush models.
    pub probes: u64,
    /// Most passes in any style.
    pub passes: u32,
    /// Whether each of these was a bounce, as their number was limited.
    pub limited: bool,
    /// Channels of light that bounced; `None` without bounces.
    pub channels: Option<Channels>,
    /// Largest share of light left unsent in any style.
    pub residual: f64,
}

impl Counts {
    pub(crate) fn new(
        scene: &Scene,
        (points, direct): (&Points, &[DirectLight]),
        patches: &MapPatches,
        transfers: &Transfers,
        bounced: &Bounced,
        gathered: &Gathered,
    ) -> Self {
        let lit = || scene.surfaces.iter().filter_map(|s| s.luxels.as_ref());
        let styles: BTreeSet<u16> = direct
            .iter()
            .flat_map(|d| d.styles.iter().chain(&d.negative))
            .chain(gathered.maps.iter().flatten())
            .map(|s| s.style)
            .collect();
        let mut rays = RayCounts::default();
        direct.iter().for_each(|d| rays += d.rays);
        Self {
            faces: [lit().count(), scene.surfaces.len()],
            luxels: lit().map(LuxelGrid::len).sum(),
            patches: patches.set.patches.len(),
            lights: scene.lights.len(),
            styles: styles.len(),
            rays,
            hemicubes: [transfers.drawn(), gathered.hemicubes],
            transfers: transfers.len(),
            transfer_bytes: transfers.bytes(),
            passages: patches.set.passages.len(),
            patterned: patches.patterned,
            overlay: transfers.overlay_costs(),
            smoothed: scene.smoothed_bytes(),
            probes: match bounced.styles.is_empty() {
                true => 0,
                false => lightmap::probe_hemicubes(scene, points.samples()),
            },
            passes: bounced.passes,
            limited: scene.world.bounce.most.is_some(),
            channels: bounced.channels,
            residual: bounced.residual,
        }
    }

    /// Adds these numbers to a table.
    pub fn print(&self, report: &mut Report) {
        report.count("faces with lightmap", self.faces[0] as u64);
        report.count("faces", self.faces[1] as u64);
        report.count("luxels", self.luxels as u64);
        report.count("patches", self.patches as u64);
        report.count("lights", self.lights as u64);
        report.count("light styles", self.styles as u64);
        report.count("shadow rays", self.rays.total());
        report.count("patch hemicubes", self.hemicubes[0]);
        report.count("luxel hemicubes", self.hemicubes[1]);
        report.count("transfers", self.transfers as u64);
        let passes = self.passes;
        let all = format!("all, in {passes} passes");
        report.row("bounces", if self.limited { passes.to_string() } else { all });
        report.count("channels", self.channels.map_or(0, Channels::count));
        report.row("residual", format!("{:.1e}", self.residual));
    }
}

/// Rows of text and numbers, printed as two aligned columns.
#[derive(Clone, Debug, Default)]
pub struct Report {
    rows: Vec<(String, String)>,
}

impl Report {
    /// An empty table.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a row.
    pub fn row(&mut self, name: impl Into<String>, value: impl Display) {
        self.rows.push((name.into(), value.to_string()));
    }

    /// Adds a row with a count, its digits in groups of three.
    pub fn count(&mut self, name: impl Into<String>, value: u64) {
        let digits = value.to_string();
        let mut grouped = String::new();
        for (i, d) in digits.chars().enumerate() {
            if i > 0 && (digits.len() - i).is_multiple_of(3) {
                grouped.push(' ');
            }
            grouped.push(d);
        }
        self.row(name, grouped);
    }

    /// Adds what a check found out, if there was one.
    pub fn accuracy(&mut self, (findings, energy): &(Option<Findings>, Option<Energy>)) {
        if let Some(f) = findings {
            self.row("estimated error", f.text());
            self.row(
                "  bias",
                format!(
                    "{:+.2} %, {:+.1} % by rays alone",
                    100.0 * (f.bias - 1.0),
                    100.0 * (f.bias_by_rays - 1.0)
                ),
            );
            self.row("  checked", format!("{} of {}", f.points, f.of));
            if let Some(odd) = f.odd_text() {
                self.row("  far off", odd);
            }
        }
        if let Some(e) = energy {
            self.row(
                "energy balance",
                format!("{:.2} % of the light sent to patches arrives", 100.0 * e.balance),
            );
            self.row("  meets none", format!("{:.2} %", 100.0 * e.lost));
            if let Some(first) = e.first_dead {
                let row = format!("{} patches that others see, the first is {first}", e.dead);
                self.row("  see nothing", row);
            }
        }
    }

    /// Adds what half the error would take, in seconds.
    pub fn half_error(&mut self, seconds: Option<f64>) {
        let text = match seconds {
            Some(seconds) => format!("would take about {seconds:.1} s"),
            None => "is out of reach of the settings".to_owned(),
        };
        self.row("half the error", text);
    }

    /// Adds a row a stage, in seconds, their sum, and the peak memory.
    pub fn resources(&mut self, stages: &[(&'static str, Duration)], total: Duration) {
        for (name, time) in stages {
            self.row(format!("  {name}"), format!("{:.2} s", time.as_secs_f64()));
        }
        self.row("time", format!("{:.2} s", total.as_secs_f64()));
        let memory = memory::peak();
        let text = memory.map_or("not known here".into(), |m| format!("{} MiB", m >> 20));
        self.row("peak memory", text);
    }
}

impl Report {
    /// Names and values of the rows.
    pub fn rows(&self) -> &[(String, String)] {
        &self.rows
    }
}

impl Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
        for (name, value) in &self.rows {
            writeln!(f, "{name:width$}  {value}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let mut report = Report::new();
        report.count("faces", 1234567);
        report.row("longer name", "x");
        assert_eq!(report.to_string(), "faces        1 234 567\nlonger name  x\n");
    }
}
