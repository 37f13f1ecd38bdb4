//! Maps: direct light once for each number of samples, bounced light at every point.

use super::bench::{Bench, Knobs, Measured, Taken, build, errors, fnv};
use super::truth::MapTruth;
use crate::aim::{self, Aim, Ladder};
use crate::bsp::{Bsp, MipTex};
use crate::lightmap::{Gather, Smoothing, atlas_of_light};
use crate::map_stages::DirectLit;
use crate::memory;
use crate::progress::Progress;
use crate::radiosity::hemicube::HemicubeSize;
use crate::scene::Sidecar;
use crate::settings::{Quality, Settings};
use crate::{Error, Result};
use std::collections::BTreeMap;

/// Points of comparison where there is no truth.
const POINTS: usize = 4000;

/// A map and what is known of its light.
pub struct MapBench<'a> {
    name: String,
    bsp: Bsp,
    sidecar: Sidecar<'a>,
    textures: Vec<MipTex>,
    base: Settings,
    truth: Option<MapTruth>,
    identity: u64,
    /// Direct light by samples a luxel, and the seconds that it took, also of processors.
    direct: BTreeMap<u32, (DirectLit, [f64; 2])>,
}

impl<'a> MapBench<'a> {
    /// `base` has the settings that are not varied. `bytes` are all files that the map is read from, and
    /// the truth.
    pub fn new(
        name: &str,
        bsp: Bsp,
        (sidecar, textures): (Sidecar<'a>, Vec<MipTex>),
        base: Settings,
        truth: Option<MapTruth>,
        bytes: &[&[u8]],
    ) -> Self {
        let mut identity = build();
        for bytes in bytes {
            identity = fnv(identity, bytes);
            identity = fnv(identity, &bytes.len().to_le_bytes());
        }
        let fixed = Settings { hemicube: Settings::default().hemicube, ..base.clone() };
        identity =
            fnv(identity, format!("{:?}", (&fixed.overrides, fixed.reflectance_scale)).as_bytes());
        identity = fnv(identity, format!("{:?}", (fixed.grey, fixed.compat_bounce)).as_bytes());
        // What is known of this map itself is no ground for expectations.
        let base = Settings { ladder: Ladder::without(name), ..base };
        let name = name.to_owned();
        Self { name, bsp, sidecar, textures, base, truth, identity, direct: BTreeMap::new() }
    }

    /// The settings of a point.
    fn settings(&self, knobs: &Knobs) -> Result<Settings> {
        let value = |name: &str| knobs.get(name).unwrap_or_default();
        let bad = |name: &str| Error::setting(name, "it is no number".to_owned());
        let number = |name: &str| value(name).parse::<f64>().map_err(|_| bad(name));
        let cells = number("hemicube")? as u32;
        Settings {
            aim: Aim::Settings,
            hemicube: HemicubeSize::new(cells, cells)?,
            patch_size: number("patch")? as u32,
            gather: if value("gather") == "luxel" { Gather::Luxel } else { Gather::Interpolate },
            gather_error: value("gather").parse().unwrap_or(1.0),
            share: number("share")? as f32,
            bounces: value("bounces").parse().ok(),
            smoothing: Smoothing { extra: number("samples")? as u32, soft: 0 },
            check: false,
            cache: None,
            ..self.base.clone()
        }
        .checked()
    }
}

/// The point of an error that is asked for.
pub(super) fn target_knobs(target: f64) -> Knobs {
    let values = vec![("target", target.to_string())];
    Knobs { name: String::new(), values, picture: false }
}

/// The point of some settings.
fn knobs(name: &str, s: &Settings) -> Knobs {
    let gather = match s.gather {
        Gather::Luxel => "luxel".to_owned(),
        Gather::Interpolate => s.gather_error.to_string(),
    };
    let values = vec![
        ("hemicube", s.hemicube.width().to_string()),
        ("patch", s.patch_size.to_string()),
        ("gather", gather),
        ("share", s.share.to_string()),
        ("bounces", s.bounces.map_or("all".to_owned(), |n| n.to_string())),
        ("samples", s.smoothing.extra.to_string()),
    ];
    let picture = ["draft", "normal", "final"].contains(&name);
    Knobs { name: name.to_owned(), values, picture }
}

impl Bench for MapBench<'_> {
    fn title(&self) -> String {
        self.name.clone()
    }

    fn identity(&self) -> u64 {
        self.identity
    }

    fn points(&self) -> Vec<Knobs> {
        if let Aim::Error(target) = self.base.aim {
            return vec![target_knobs(target)];
        }
        let mut points = Vec::new();
        let mut add = |k: Knobs| {
            if !points.iter().any(|p: &Knobs| p.values == k.values) {
                points.push(k);
            }
        };
        for (name, quality) in QUALITIES {
            add(knobs(name, &Settings::of_quality(quality)));
        }
        let normal = || Settings::of_quality(Quality::Normal);
        for bounces in [1, 2, 4] {
            add(knobs("", &Settings { bounces: Some(bounces), ..normal() }));
        }
        let usual = normal().share;
        let mut with = |patch_size, cells, gather_error: f64, share| {
            let hemicube = HemicubeSize::new(cells, cells).expect("even and in range");
            let gather = if gather_error == 0.0 { Gather::Luxel } else { Gather::Interpolate };
            let settings =
                Settings { patch_size, hemicube, gather, gather_error, share, ..normal() };
            add(knobs("", &settings));
        };
        for patch in [8, 4, 2] {
            for error in [f64::INFINITY, 0.2, 0.1, 0.05, 0.02] {
                with(patch, 16, error, usual);
            }
            with(patch, 16, 0.0, usual);
            with(patch, 32, 0.05, 0.0);
            with(patch, 32, 0.0, 0.0);
        }
        for cells in [8, 16, 24, 32, 48] {
            with(2, cells, 0.1, usual);
        }
        for share in [0.0, 0.1, 0.5, 1.0] {
            with(2, 16, 0.1, share);
        }
        with(1, 16, 0.1, usual);
        with(2, 16, 0.02, 0.0);
        with(1, 32, 0.02, 0.0);
        with(2, 32, 0.02, 0.0);
        // These take the most memory, which the system may not give back at once.
        for extra in [2, 4] {
            let smoothing = Smoothing { extra, soft: 0 };
            add(knobs("", &Settings { smoothing, ..normal() }));
        }
        // The finest last.
        let last = points.iter().position(|p| p.name == "final").expect("it is a preset");
        let last = points.remove(last);
        points.push(last);
        points
    }

    fn truth(&self) -> Option<Vec<f32>> {
        self.truth.as_ref().map(|t| t.light.clone())
    }

    fn measure(&mut self, knobs: &Knobs) -> Result<Measured> {
        let settings = match knobs.get("target") {
            Some(_) => Settings { check: true, cache: None, ..self.base.clone() },
            None => Settings { bounces: None, ..self.settings(knobs)? },
        };
        let extra = settings.smoothing.extra;
        let progress = Progress::new(false);
        if !self.direct.contains_key(&extra) {
            let start = Taken::now();
            let textures = self.textures.clone();
            let direct = DirectLit::new(
                &mut self.bsp.clone(),
                self.sidecar,
                textures,
                &settings,
                &progress,
            )?;
            self.direct.insert(extra, (direct, start.seconds()));
        }
        let (direct, direct_seconds) = self.direct.get_mut(&extra).expect("just put there");
        memory::forget_peak();
        let start = Taken::now();
        let most = direct.scene.world.bounce.most;
        if let Some(bounces) = knobs.get("bounces").and_then(|b| b.parse().ok()) {
            direct.scene.world.bounce.most = Some(bounces);
        }
        let (light, chosen) = aim::bounced(direct, &settings, &progress, &mut |_| {});
        direct.scene.world.bounce.most = most;
        let [bounced, work] = start.seconds();
        let [of_direct, work_of_direct] = *direct_seconds;
        let memory = memory::peak();
        let found = &light.gathered.maps;
        let values = match &self.truth {
            Some(truth) => truth
                .luxels
                .iter()
                .map(|&[face, s, t]| {
                    let (face, s, t) = (face as usize, s as usize, t as usize);
                    let grid = direct.scene.surfaces.get(face).and_then(|f| f.luxels.as_ref());
                    let width = grid.map_or(0, |g| g.width as usize);
                    let mut maps = found.get(face).into_iter().flatten();
                    let style = maps.find(|m| m.style == 0);
                    let light = style.and_then(|m| m.irradiance.get(t * width + s));
                    light.map_or(0.0, |e| e.0.element_sum() / 3.0)
                })
                .collect(),
            None => {
                let free = direct.points.luxels.iter().enumerate().flat_map(|(face, samples)| {
                    let free = samples.iter().enumerate().filter(|(_, s)| !s.occluded);
                    free.map(move |(luxel, _)| (face, luxel))
                });
                let free: Vec<_> = free.collect();
                let step = free.len().div_ceil(POINTS).max(1);
                let of = |&(face, luxel): &(usize, usize)| {
                    let styles = found[face].iter().map(|m| m.irradiance[luxel].0.element_sum());
                    styles.sum::<f32>() / 3.0
                };
                free.iter().step_by(step).map(of).collect()
            }
        };
        let sizes = direct.scene.surfaces.iter().map(|s| s.luxels.as_ref());
        let sizes: Vec<[u32; 2]> =
            sizes.map(|g| g.map_or([0; 2], |g| [g.width, g.height])).collect();
        let picture = knobs.picture.then(|| atlas_of_light(found, &sizes));
        let half = aim::half_error(&settings, &light.counts, &progress.stages(), bounced);
        let half = half.filter(|_| !knobs.name.is_empty()).map(|(of_bounced, rung)| {
            (of_bounced + of_direct, self::knobs("", &rung.settings(&settings)).text())
        });
        Ok(Measured {
            seconds: bounced + of_direct,
            processor: work + work_of_direct,
            memory,
            values,
            picture,
            luxels: light.counts.hemicubes[1] as f64 / light.counts.luxels.max(1) as f64,
            expected: chosen.predicted.map(|p| [p.seconds + of_direct, p.error]),
            half,
        })
    }

    fn errors(&self, got: &[f32], truth: &[f32]) -> [f64; 2] {
        errors(got, truth, |_| 1.0)
    }
}

/// The presets by name.
pub(super) const QUALITIES: [(&str, Quality); 4] = [
    ("draft", Quality::Draft),
    ("normal", Quality::Normal),
    ("high", Quality::High),
    ("final", Quality::Final),
];
