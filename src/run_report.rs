//! `--report`: all that a run tells about itself, as a page or as JSON.

use crate::check::{Energy, Findings};
use crate::plot::{Page, bars};
use crate::report::Report;
use crate::{Error, Result, output};
use image::RgbImage;
use serde::Serialize;
use std::path::Path;
use std::time::Duration;

/// Everything about a run.
#[derive(Clone, Debug, Serialize)]
pub struct RunReport {
    /// Version of the program.
    pub version: &'static str,
    /// The file that was lit.
    pub input: String,
    /// The settings, by their names.
    pub settings: Vec<(String, String)>,
    /// How the work was chosen, one sentence each.
    pub choices: Vec<String>,
    /// What the map calls for.
    pub plan: String,
    /// The table at the end of the run.
    pub table: Vec<(String, String)>,
    /// Seconds of each stage.
    pub stages: Vec<(String, f64)>,
    /// Seconds of the whole run.
    pub seconds: f64,
    /// Most memory in bytes, where the system tells it.
    pub memory: Option<u64>,
    /// How far off the light is.
    pub findings: Option<Findings>,
    /// Where it goes.
    pub energy: Option<Energy>,
    /// Pictures of the lightmaps; not part of JSON.
    #[serde(skip)]
    pub pictures: Vec<(String, RgbImage)>,
}

/// Whether a report can have this name.
///
/// # Errors
/// When it ends in neither `.html` nor `.json`.
pub fn check_name(path: &Path) -> Result<()> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    if ["html", "json"].contains(&extension) {
        return Ok(());
    }
    let problem = format!("{}: give a name that ends in .html or .json", path.display());
    Err(Error::setting("--report", problem))
}

impl RunReport {
    /// An account of the stages and the table of a run.
    pub fn new(
        input: &Path,
        table: &Report,
        stages: &[(&'static str, Duration)],
        seconds: Duration,
        (findings, energy): (Option<Findings>, Option<Energy>),
    ) -> Self {
        let stage = |(name, time): &(&str, Duration)| ((*name).to_owned(), time.as_secs_f64());
        Self {
            version: env!("CARGO_PKG_VERSION"),
            input: input.display().to_string(),
            settings: Vec::new(),
            choices: Vec::new(),
            plan: String::new(),
            table: table.rows().to_vec(),
            stages: stages.iter().map(stage).collect(),
            seconds: seconds.as_secs_f64(),
            memory: crate::memory::peak(),
            findings,
            energy,
            pictures: Vec::new(),
        }
    }

    /// Writes the report, of the kind that the name of the file says.
    ///
    /// # Errors
    /// When that cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = if path.extension().is_some_and(|e| e == "json") {
            serde_json::to_string_pretty(self)
                .map_err(|e| Error::format(path.display().to_string(), e.to_string()))?
        } else {
            self.page()
        };
        output::write(path, text.as_bytes())
    }

    fn page(&self) -> String {
        let mut page = Page::new(&format!("qrad {}: {}", self.version, self.input));
        self.choices.iter().for_each(|sentence| page.text(sentence));
        let pairs = |list: &[(String, String)]| -> Vec<Vec<String>> {
            list.iter().map(|(name, value)| vec![name.trim().to_owned(), value.clone()]).collect()
        };
        page.heading("Result");
        page.table(&[], &pairs(&self.table), &[]);
        page.heading("Time");
        page.svg(&bars(&self.stages, "s"));
        page.heading("Settings");
        page.table(&[], &pairs(&self.settings), &[]);
        if !self.plan.is_empty() {
            page.heading("Plan");
            page.lines(&self.plan);
        }
        for (name, picture) in &self.pictures {
            page.heading(name);
            page.picture(picture, name);
        }
        page.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_have_what_the_run_told() {
        let mut table = Report::new();
        table.row("patches", 12);
        let stages = [("gather", Duration::from_millis(1500))];
        let run = Duration::from_secs(2);
        let mut report = RunReport::new(Path::new("a.bsp"), &table, &stages, run, (None, None));
        report.pictures.push(("style 0".into(), RgbImage::new(4, 4)));
        let folder = tempfile::tempdir().unwrap();
        let [page, json] = ["r.html", "r.json"].map(|name| folder.path().join(name));
        report.write(&page).unwrap();
        let html = std::fs::read_to_string(page).unwrap();
        assert!(["patches", "gather", "1.50 s", "data:image/png"].iter().all(|s| html.contains(s)));
        report.write(&json).unwrap();
        let json: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(json).unwrap()).unwrap();
        assert_eq!(json["table"][0][1], "12");
        assert_eq!(json["stages"][0][1], 1.5);
        assert!(check_name(Path::new("x.txt")).is_err() && check_name(Path::new("x.json")).is_ok());
    }
}
