//! What the effects of a plan are expected to take, from samples, and what they took.

use crate::aim::{Costs, sample_direct};
use crate::bsp::{Bsp, MipTex};
use crate::light::RayCounts;
use crate::progress::Progress;
use crate::report::Counts;
use crate::scene::effects::{Cost, Effect, Plan, plan};
use crate::scene::{Scene, Sidecar};
use crate::settings::Settings;
use crate::{Result, stage};
use std::time::Duration;

/// Bytes of a stored form factor and its share of a run of columns, about.
const FACTOR_BYTES: f64 = 5.0;

/// Bytes that so many form factors take, about.
pub(crate) fn factor_bytes(count: usize) -> u64 {
    (count as f64 * FACTOR_BYTES) as u64
}

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
    let mut plan = plan(&scene, settings);
    let points = stage::place(&scene, settings, &Progress::new(false))?;
    let (seconds, rays) = sample_direct(&scene, &points);
    let bounced = plan.is_on(Effect::Bounces).then(|| {
        let rung = settings.ladder.nearest(settings);
        let costs = Costs::measure(&scene, &points.luxels);
        let [_, hemicubes, factors] = costs.counts(&rung);
        let cells = settings.hemicube.cells() as f64;
        let of_luxels = costs.luxels(&rung);
        let whole = costs.seconds(&rung);
        let share = hemicubes / (hemicubes + of_luxels).max(1.0);
        let bounces = Cost {
            cells: (hemicubes * cells) as u64,
            bytes: (factors * FACTOR_BYTES) as u64,
            seconds: whole * share,
            ..Cost::default()
        };
        let cells = (of_luxels * settings.gathering().hemicube.cells() as f64) as u64;
        [bounces, Cost { cells, seconds: whole * (1.0 - share), ..Cost::default() }]
    });
    for entry in plan.entries.iter_mut().filter(|e| e.on) {
        entry.predicted = cost(entry.effect, &rays, seconds, bounced);
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
            bytes: factor_bytes(counts.transfers),
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
    for entry in &mut plan.entries {
        let direct = seconds(&["direct light"]);
        entry.measured = cost(entry.effect, &counts.rays, direct, Some(bounced));
    }
}

/// What an effect takes, if that is told apart.
fn cost(
    effect: Effect,
    rays: &RayCounts,
    seconds: f64,
    bounced: Option<[Cost; 2]>,
) -> Option<Cost> {
    let of_rays = |n: u64| Cost {
        rays: n,
        seconds: seconds * n as f64 / rays.total().max(1) as f64,
        ..Cost::default()
    };
    match effect {
        Effect::Bounces => bounced.map(|b| b[0]),
        Effect::NearField => bounced.map(|b| b[1]),
        // Together: a ray may cross all three kinds. The time is that of the light they belong to.
        Effect::Fences | Effect::Glass | Effect::ModelShadows => {
            Some(Cost { rays: rays.filtered, ..Cost::default() })
        }
        _ => rays.of(effect).map(of_rays),
    }
}
