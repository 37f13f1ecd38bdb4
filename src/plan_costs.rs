//! What the effects of a plan are expected to take, from samples, and what they took.

use crate::aim::{Costs, sample_direct};
use crate::bsp::{Bsp, MipTex};
use crate::light::RayCounts;
use crate::lightmap;
use crate::overlay_estimate::{ThroughCosts, curtain_cost};
use crate::progress::Progress;
use crate::report::Counts;
use crate::scene::effects::{Cost, Effect, Plan, check_switches, plan};
use crate::scene::{Scene, Sidecar};
use crate::settings::Settings;
use crate::{Result, stage};
use std::time::Duration;

/// Effects of what light comes through or is sent back by unevenly, while it bounces.
const THROUGH: [Effect; 3] = [Effect::Glass, Effect::Curtains, Effect::Shaders];

/// Bytes of a stored form factor of a map, with its column and its share of what rows take besides.
const FACTOR_BYTES: f64 = 4.1;

/// Seconds of the stages of these names.
pub(crate) fn seconds_of(stages: &[(&'static str, Duration)], names: &[&str]) -> f64 {
    let of = stages.iter().filter(|(name, _)| names.contains(name));
    of.map(|(_, time)| time.as_secs_f64()).sum()
}

/// The plan of a run with what each effect is expected to take. Rays are as many as samples of faces
/// traced, in proportion; seconds are shared out among effects by their rays.
///
/// # Errors
/// When the map cannot be lit.
pub fn explained(
    bsp: &mut Bsp,
    sidecar: Sidecar<'_>,
    textures: Vec<MipTex>,
    settings: &Settings,
) -> Result<Plan> {
    bsp.clear_lighting();
    bsp.rewrite_entities(settings.styles(bsp)?)?;
    let scene = Scene::build(bsp, sidecar, &settings.scene(textures))?;
    check_switches(&scene, settings)?;
    let mut plan = plan(&scene, settings);
    let points = stage::place(&scene, settings, &Progress::new(false))?;
    let (seconds, rays) = sample_direct(&scene, &points);
    let smoothed = scene.smoothed_bytes();
    let mut costs = Took { rays, seconds, smoothed, ..Took::default() };
    if plan.is_on(Effect::Bounces) {
        let rung = settings.ladder.nearest(settings);
        let samples = Costs::measure(&scene, &points.luxels);
        let [_, hemicubes, factors] = samples.counts(&rung);
        let cells = settings.hemicube.cells() as f64;
        let of_luxels = samples.luxels(&rung);
        let whole = samples.seconds(&rung);
        let share = hemicubes / (hemicubes + of_luxels).max(1.0);
        let bounces = Cost {
            cells: (hemicubes * cells) as u64,
            bytes: (factors * FACTOR_BYTES) as u64,
            seconds: whole * share,
            ..Cost::default()
        };
        let cells = (of_luxels * settings.gathering().hemicube.cells() as f64) as u64;
        let near = Cost { cells, seconds: whole * (1.0 - share), ..Cost::default() };
        costs.bounced = Some([bounces, near]);
        if THROUGH.iter().any(|&effect| plan.is_on(effect)) {
            costs.through = ThroughCosts::sample(&scene, &points, settings, [hemicubes, of_luxels]);
        }
        if plan.is_on(Effect::Minlight) {
            let hemicubes = lightmap::probe_hemicubes(&scene, points.samples());
            costs.probes = hemicubes * settings.hemicube.cells() as u64;
        }
    }
    for entry in plan.entries.iter_mut().filter(|e| e.on) {
        entry.predicted = costs.of(entry.effect);
    }
    Ok(plan)
}

/// Adds to a plan what its effects took in a run, those that are off included.
pub fn measured(
    plan: &mut Plan,
    counts: &Counts,
    stages: &[(&'static str, Duration)],
    settings: &Settings,
) {
    let seconds = |names: &[&str]| seconds_of(stages, names);
    let cells = settings.hemicube.cells() as u64;
    let mut bounced = [
        Cost {
            cells: counts.hemicubes[0] * cells,
            bytes: counts.transfer_bytes,
            seconds: seconds(&["patches", "form factors", "bounces"]),
            rays: 0,
        },
        Cost {
            cells: counts.hemicubes[1] * settings.gathering().hemicube.cells() as u64,
            seconds: seconds(&["gather", "refine"]),
            ..Cost::default()
        },
    ];
    // Luxels that all have hemicubes are no refinement.
    if !plan.is_on(Effect::NearField) {
        let [bounces, luxels] = bounced;
        let cells = bounces.cells + luxels.cells;
        let seconds = bounces.seconds + luxels.seconds;
        bounced = [Cost { cells, seconds, ..bounces }, Cost::default()];
    }
    let [glass, shaders] = counts.overlay;
    let curtains = curtain_cost(counts.passages, counts.patches, counts.styles);
    let costs = Took {
        rays: counts.rays,
        seconds: seconds(&["direct light"]),
        bounced: Some(bounced),
        through: ThroughCosts { glass, curtains, shaders },
        smoothed: counts.smoothed,
        probes: counts.probes * cells,
    };
    for entry in &mut plan.entries {
        entry.measured = costs.of(entry.effect);
    }
}

/// What all effects take together, to be told apart.
#[derive(Default)]
struct Took {
    rays: RayCounts,
    /// Of direct light.
    seconds: f64,
    /// What bounces take, and luxels that look for themselves; `None` if nothing bounces.
    bounced: Option<[Cost; 2]>,
    through: ThroughCosts,
    /// Bytes of smoothed normals.
    smoothed: u64,
    /// Cells of the hemicubes for the least light of brush models.
    probes: u64,
}

impl Took {
    /// What an effect takes, if that is told apart.
    fn of(&self, effect: Effect) -> Option<Cost> {
        let rays = &self.rays;
        let of_rays = |n: u64| Cost {
            rays: n,
            seconds: self.seconds * n as f64 / rays.total().max(1) as f64,
            ..Cost::default()
        };
        // Together: a ray may cross all three kinds. The time is that of the light they belong to.
        let filtered = Cost { rays: rays.filtered, ..Cost::default() };
        match effect {
            Effect::Bounces => self.bounced.map(|b| b[0]),
            Effect::NearField => self.bounced.map(|b| b[1]),
            Effect::Fences | Effect::ModelShadows => Some(filtered),
            Effect::Glass => Some(Cost { rays: rays.filtered, ..self.through.glass }),
            Effect::Curtains => Some(self.through.curtains),
            Effect::Shaders => Some(self.through.shaders),
            Effect::Phong => Some(Cost { bytes: self.smoothed, ..Cost::default() }),
            Effect::Minlight => Some(Cost { cells: self.probes, ..of_rays(rays.minlight) }),
            _ => rays.of(effect).map(of_rays),
        }
    }
}
