//! Text scenes: hemicubes, closed forms and passes.

use super::bench::{Bench, Knobs, Measured, Taken, build, errors, fnv};
use super::map_bench::{QUALITIES, target_knobs};
use super::truth::TextTruth;
use crate::aim::{TextLadder, estimate_text, half_error_text};
use crate::memory;
use crate::patch::{TextPatches, TextScene};
use crate::progress::Progress;
use crate::radiosity::near_pairs::NearLimits;
use crate::settings::Quality;
use crate::{Error, Result, light_patches_with};

/// A scene and what is known of its light.
pub struct TextBench {
    name: String,
    scene: TextScene,
    truth: Option<TextTruth>,
    /// The error that is asked for; all points if none is.
    target: Option<f64>,
    identity: u64,
    areas: Vec<f64>,
}

impl TextBench {
    /// `bytes` are the files of the scene and of the truth.
    ///
    /// # Errors
    /// When the truth is of a scene with another number of patches.
    pub fn new(
        name: &str,
        scene: TextScene,
        truth: Option<TextTruth>,
        target: Option<f64>,
        bytes: &[&[u8]],
    ) -> Result<Self> {
        if let Some(truth) = truth.as_ref().filter(|t| t.reflected.len() != scene.patches.len()) {
            let (known, there) = (truth.reflected.len(), scene.patches.len());
            let problem = format!("it knows {known} patches, the scene has {there}");
            return Err(Error::format("truth", problem));
        }
        let mut identity = build();
        for bytes in bytes {
            identity = fnv(fnv(identity, bytes), &bytes.len().to_le_bytes());
        }
        let areas =
            TextPatches::new(&scene).set.patches.iter().map(|p| f64::from(p.area)).collect();
        Ok(Self { name: name.to_owned(), scene, truth, target, identity, areas })
    }
}

/// The point of a hemicube, closed forms and passes.
fn knobs(name: &str, cells: u32, near: Option<NearLimits>, passes: Option<u32>) -> Knobs {
    let of = |value: &dyn Fn(NearLimits) -> String| near.map_or("off".to_owned(), value);
    let values = vec![
        ("hemicube", cells.to_string()),
        ("near", of(&|n| n.row.to_string())),
        ("rays", of(&|n| n.rays.to_string())),
        ("points", of(&|n| n.points.to_string())),
        ("crowded", of(&|n| n.crowded.to_string())),
        ("passes", passes.map_or("all".to_owned(), |p| p.to_string())),
    ];
    Knobs { name: name.to_owned(), values, picture: false }
}

impl Bench for TextBench {
    fn title(&self) -> String {
        self.name.clone()
    }

    fn identity(&self) -> u64 {
        self.identity
    }

    fn points(&self) -> Vec<Knobs> {
        if let Some(target) = self.target {
            return vec![target_knobs(target)];
        }
        let own = self.scene.hemicube[0];
        let mut points = Vec::new();
        let mut add = |k: Knobs| {
            if !points.iter().any(|p: &Knobs| p.values == k.values) {
                points.push(k);
            }
        };
        add(knobs("plain", own, None, None));
        for (name, quality) in QUALITIES {
            add(knobs(name, own, Some(quality.near()), None));
        }
        for cells in [16, 32, 64, 128, 256, 512] {
            add(knobs("", cells, None, None));
            add(knobs("", cells, Some(Quality::Draft.near()), None));
            add(knobs("", cells, Some(Quality::Normal.near()), None));
        }
        let normal = Quality::Normal.near();
        for row in [3e-2, 1e-2, 1e-3] {
            add(knobs("", own, Some(NearLimits { row, ..normal }), None));
        }
        for part in [16, 4] {
            let points = (normal.points / part).max(1);
            let crowded = (normal.crowded / part).max(1);
            add(knobs("", own, Some(NearLimits { points, crowded, ..normal }), None));
        }
        for passes in [1, 2, 4, 8] {
            add(knobs("", own, Some(normal), Some(passes)));
        }
        let last = points.iter().position(|p| p.name == "final").expect("it is a preset");
        let last = points.remove(last);
        points.push(last);
        points
    }

    fn truth(&self) -> Option<Vec<f32>> {
        Some(self.truth.as_ref()?.reflected.iter().flatten().copied().collect())
    }

    fn measure(&mut self, knobs: &Knobs) -> Result<Measured> {
        let number = |name: &str| knobs.get(name).and_then(|v| v.parse::<f64>().ok());
        let mut scene = self.scene.clone();
        let mut expected = None;
        if let Some(cells) = number("hemicube") {
            scene.hemicube = [cells as u32; 2];
        }
        if let Some(passes) = number("passes") {
            scene.passes = passes as u32;
        }
        let mut near = number("near").map(|row| {
            let whole = |name| number(name).unwrap_or(1.0) as u32;
            let (rays, points, crowded) = (whole("rays"), whole("points"), whole("crowded"));
            NearLimits { row, rays, points, crowded }
        });
        memory::forget_peak();
        let start = Taken::now();
        if let Some(target) = number("target") {
            let quality = TextLadder::without(&self.name).quality(target);
            near = Some(quality.near());
            let predicted =
                estimate_text(&scene, &TextLadder::without(&self.name), |q| q == quality)?;
            let [pilot, _] = start.seconds();
            expected = predicted.first().map(|p| [pilot + p.seconds, p.error]);
        }
        let progress = Progress::new(false);
        let (_, solution) = light_patches_with(&scene, near, &progress)?;
        let [seconds, processor] = start.seconds();
        let memory = memory::peak();
        let pairs = solution.exitance.iter().zip(&self.scene.patches);
        let reflected = pairs.flat_map(|(m, quad)| {
            let own = quad.exitance.map(|e| e as f32);
            [m.0.x - own[0], m.0.y - own[1], m.0.z - own[2]]
        });
        let quality = QUALITIES.into_iter().find(|q| q.0 == knobs.name).map(|q| q.1);
        let half = half_error_text(quality, &progress.stages(), seconds);
        let half = half.filter(|_| !knobs.name.is_empty()).map(|(seconds, next)| {
            (seconds, self::knobs("", self.scene.hemicube[0], Some(next.near()), None).text())
        });
        let values = reflected.collect();
        Ok(Measured { seconds, processor, memory, values, expected, half, ..Measured::default() })
    }

    fn errors(&self, got: &[f32], truth: &[f32]) -> [f64; 2] {
        errors(got, truth, |k| self.areas[k / 3])
    }
}
