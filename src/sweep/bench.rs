//! What a sweep measures.

use crate::Result;
use crate::progress::processor_seconds;
use image::RgbImage;
use std::time::Instant;

/// One point of a sweep: the settings that it is about.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Knobs {
    /// Name of the preset that has these settings, or an empty text.
    pub name: String,
    /// Names and values of the settings.
    pub values: Vec<(&'static str, String)>,
    /// The page shows lightmaps of this point.
    pub picture: bool,
}

impl Knobs {
    /// A number that stands for these settings of what `identity` stands for.
    pub fn key(&self, identity: u64) -> u64 {
        let mut hash = identity;
        for (name, value) in &self.values {
            hash = fnv(hash, name.as_bytes());
            hash = fnv(hash, b"=");
            hash = fnv(hash, value.as_bytes());
            hash = fnv(hash, b";");
        }
        hash
    }

    /// The settings as `name=value` with spaces between.
    pub fn text(&self) -> String {
        let pairs: Vec<String> = self.values.iter().map(|(n, v)| format!("{n}={v}")).collect();
        pairs.join(" ")
    }

    /// The value of a setting.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.values.iter().find(|v| v.0 == name).map(|v| &*v.1)
    }
}

/// What was measured at one point.
#[derive(Clone, Debug, Default)]
pub struct Measured {
    /// Seconds from the parsed file to the lightmaps.
    pub seconds: f64,
    /// Of processors, on all threads; 0 where the system does not tell.
    pub processor: f64,
    /// Most memory in bytes, where the system tells it.
    pub memory: Option<u64>,
    /// Bounced light at the points of comparison.
    pub values: Vec<f32>,
    /// The lightmaps.
    pub picture: Option<RgbImage>,
    /// Share of the luxels that got hemicubes, on maps.
    pub luxels: f64,
    /// Seconds and error that were expected, if an error was asked for.
    pub expected: Option<[f64; 2]>,
    /// Seconds that half the error was said to take, and the settings for it, as in the table.
    pub half: Option<(f64, String)>,
}

/// When something began.
pub(super) struct Taken(Instant, Option<f64>);

impl Taken {
    /// Now.
    pub fn now() -> Self {
        Self(Instant::now(), processor_seconds())
    }

    /// Seconds since then, and those of processors; 0 where these are not known.
    pub fn seconds(&self) -> [f64; 2] {
        let work = self.1.zip(processor_seconds()).map_or(0.0, |(begun, now)| now - begun);
        [self.0.elapsed().as_secs_f64(), work]
    }
}

/// A map or a scene that can be lit again and again.
pub trait Bench {
    /// What it is, for people.
    fn title(&self) -> String;
    /// A hash of all that counts besides the knobs, the build of the program included.
    fn identity(&self) -> u64;
    /// The points, the finest last.
    fn points(&self) -> Vec<Knobs>;
    /// The light that should be at the points of comparison, if that is known.
    fn truth(&self) -> Option<Vec<f32>>;
    /// Lights it.
    ///
    /// # Errors
    /// When that fails.
    fn measure(&mut self, knobs: &Knobs) -> Result<Measured>;
    /// Relative root mean square error, and the largest error relative to the mean light.
    fn errors(&self, got: &[f32], truth: &[f32]) -> [f64; 2];
}

/// FNV-1a, continued from `hash`: short, and the same on every machine and in every version.
pub(super) fn fnv(hash: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(hash, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0000_0100_0000_01B3))
}

/// A hash of the program that runs: another build may find other light. Of its version where its file
/// cannot be read.
pub(super) fn build() -> u64 {
    /// Where FNV-1a begins.
    const BASIS: u64 = 0xCBF2_9CE4_8422_2325;
    let file = std::env::current_exe().and_then(std::fs::read);
    match file {
        Ok(program) => fnv(BASIS, blake3::hash(&program).as_bytes()),
        Err(_) => fnv(BASIS, env!("CARGO_PKG_VERSION").as_bytes()),
    }
}

/// Errors of values that count `weight(k)` each.
pub(super) fn errors(got: &[f32], truth: &[f32], weight: impl Fn(usize) -> f64) -> [f64; 2] {
    let (mut error, mut light, mut sum, mut weights, mut worst) = (0.0, 0.0, 0.0, 0.0, 0.0_f64);
    for (k, (&g, &t)) in got.iter().zip(truth).enumerate() {
        let (w, t) = (weight(k), f64::from(t));
        let off = f64::from(g) - t;
        error += w * off * off;
        light += w * t * t;
        sum += w * t;
        weights += w;
        worst = worst.max(off.abs());
    }
    let mean = sum / weights;
    let share = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
    [share(error, light).sqrt(), share(worst, mean)]
}
