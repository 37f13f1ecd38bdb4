//! What a run tells about itself while it goes on and when it is done.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Shows the stages of a run, with the time left, and keeps how long each took.
pub struct Progress {
    visible: bool,
    stages: Mutex<Vec<(&'static str, Duration)>>,
    start: Instant,
}

impl Progress {
    /// Bars are drawn on standard error when `visible`, and only if that is a terminal.
    pub fn new(visible: bool) -> Self {
        Self { visible, stages: Mutex::new(Vec::new()), start: Instant::now() }
    }

    /// Begins a stage of `total` steps; it ends when the value returned is dropped.
    pub fn stage(&self, name: &'static str, total: usize) -> Stage<'_> {
        let target =
            if self.visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let template = "{msg:18} [{bar:32}] {percent:>3} %, {elapsed} so far, {eta} left";
        let style = ProgressStyle::with_template(template).expect("the template is valid");
        let bar = ProgressBar::with_draw_target(Some(total as u64), target)
            .with_style(style.progress_chars("=> "))
            .with_message(name);
        Stage { progress: self, name, start: Instant::now(), bar }
    }

    /// Prints a sentence where bars are shown.
    pub fn say(&self, sentence: &str) {
        if self.visible {
            eprintln!("{sentence}");
        }
    }

    /// Time since the beginning.
    pub fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    /// Name and duration of the stages ended so far, in order.
    pub fn stages(&self) -> Vec<(&'static str, Duration)> {
        self.stages.lock().map_or_else(|e| e.into_inner().clone(), |s| s.clone())
    }
}

/// A stage under way.
pub struct Stage<'a> {
    progress: &'a Progress,
    name: &'static str,
    start: Instant,
    bar: ProgressBar,
}

impl Stage<'_> {
    /// `steps` more are done.
    pub fn advance(&self, steps: u64) {
        self.bar.inc(steps);
    }
}

impl Drop for Stage<'_> {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
        if let Ok(mut stages) = self.progress.stages.lock() {
            stages.push((self.name, self.start.elapsed()));
        }
    }
}
