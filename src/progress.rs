//! What a run tells about itself while it goes on and when it is done.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Seconds that processors have worked for this process so far, on all threads, to a hundredth; `None`
/// where the system does not tell.
pub fn processor_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The name, in brackets, is the second field; the 14th and 15th are in hundredths of a second.
    let mut fields = stat.rsplit(')').next()?.split_whitespace().skip(11);
    let mut next = || fields.next()?.parse::<f64>().ok();
    Some((next()? + next()?) / 100.0)
}

/// Tells how long a run has taken.
type Clock = Box<dyn Fn() -> Duration + Send + Sync>;

/// Shows the stages of a run, with the time left, and keeps how long each took.
pub struct Progress {
    visible: bool,
    stages: Mutex<Vec<(&'static str, Duration)>>,
    clock: Clock,
}

/// When work is to stop, by the clock of a run.
#[derive(Clone, Copy)]
pub struct Deadline<'a> {
    progress: &'a Progress,
    at: Duration,
}

impl Deadline<'_> {
    /// Time since the beginning of the run.
    pub fn now(&self) -> Duration {
        self.progress.elapsed()
    }

    /// Time left; 0 when it has passed.
    pub fn left(&self) -> Duration {
        self.at.saturating_sub(self.now())
    }

    /// Whether no more work is to be begun.
    pub fn passed(&self) -> bool {
        self.now() >= self.at
    }
}

impl Progress {
    /// Bars are drawn on standard error when `visible`, and only if that is a terminal.
    pub fn new(visible: bool) -> Self {
        let start = Instant::now();
        Self::with_clock(visible, Box::new(move || start.elapsed()))
    }

    /// As [`new`](Self::new), with a clock that tells the time since the beginning in its own way.
    pub fn with_clock(visible: bool, clock: Clock) -> Self {
        Self { visible, stages: Mutex::new(Vec::new()), clock }
    }

    /// A time since the beginning at which something is to stop.
    pub fn deadline(&self, at: Duration) -> Deadline<'_> {
        Deadline { progress: self, at }
    }

    /// No time at which anything is to stop.
    pub fn no_deadline(&self) -> Deadline<'_> {
        self.deadline(Duration::MAX)
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
        (self.clock)()
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
