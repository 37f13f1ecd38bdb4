//! What a sweep measures.

use crate::Result;
use image::RgbImage;

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

    /// The value of a setting.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.values.iter().find(|v| v.0 == name).map(|v| &*v.1)
    }
}

/// What was measured at one point.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Seconds from the parsed file to the lightmaps.
    pub seconds: f64,
    /// Most memory in bytes, where the system tells it.
    pub memory: Option<u64>,
    /// Bounced light at the points of comparison.
    pub values: Vec<f32>,
    /// The lightmaps.
    pub picture: Option<RgbImage>,
}

/// A map or a scene that can be lit again and again.
pub trait Bench {
    /// What it is, for people.
    fn title(&self) -> String;
    /// A hash of all that counts besides the knobs, the version of the program included.
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

/// Where FNV-1a begins.
pub(super) const FNV_BASIS: u64 = 0xCBF2_9CE4_8422_2325;

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
