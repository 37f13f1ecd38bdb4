//! The plan of a run on a text scene: which effects its patches call for, why, and what they take.

use crate::aim::{TextLadder, estimate_text};
use crate::patch::{Passage, PatchEffects, Quad, Shader, TextPatches, TextScene};
use crate::radiosity::hemicube::{DeltaFormFactors, HemicubeSize, View};
use crate::radiosity::solve::Solution;
use crate::radiosity::transfers::{Gatherer, OVERLAY_ENTRY, Transfers};
use crate::scene::effects::{Cost, Effect, Entry, Plan, Switches};
use crate::settings::Quality;
use crate::{Result, plan_costs};
use glam::DVec3;
use std::time::Duration;

/// The effects that text scenes may call for, in the order of [`Effect`].
pub const EFFECTS: [Effect; 7] = [
    Effect::Colour,
    Effect::SurfaceLights,
    Effect::Glass,
    Effect::Curtains,
    Effect::Shaders,
    Effect::Bounces,
    Effect::NearField,
];

/// Hemicubes that tell what glass and patterns will take.
const SAMPLED: usize = 64;

/// The plan of a run on `scene`, of which `switches` are applied already; `near` tells whether near pairs get
/// closed forms.
pub fn plan(scene: &TextScene, near: bool, switches: &Switches) -> Plan {
    let of = |effect| {
        let (on, mut reason) = finding(scene, near, effect);
        // Glass that lets all light pass is still there.
        let on = on && !switches.off(effect);
        if !on && switches.off(effect) {
            reason = format!("switched off with -{}", effect.name());
        }
        Entry { effect, on, reason, predicted: None, measured: None }
    };
    Plan { entries: EFFECTS.into_iter().map(of).collect() }
}

/// Takes out of a scene what is switched off. Glass then lets all light pass, and curtains none.
pub fn apply(switches: &Switches, scene: &mut TextScene) {
    if switches.off(Effect::Bounces) {
        scene.passes = 0;
    }
    for quad in &mut scene.patches {
        let Quad { exitance, reflectance, effects, .. } = quad;
        if switches.off(Effect::SurfaceLights) {
            *exitance = [0.0; 3];
        }
        if switches.off(Effect::Glass) && effects.is_translucent() {
            (effects.straight, effects.diffuse) = (Some([1.0; 3]), None);
            *reflectance = [0.0; 3];
        }
        if switches.off(Effect::Curtains) && effects.diffuse.take().is_some() {
            effects.two_sided = true;
        }
        if switches.off(Effect::Shaders) {
            effects.shader = None;
        }
        if switches.off(Effect::Colour) {
            make_grey(quad);
        }
    }
}

/// The means of the channels instead of each.
fn make_grey(quad: &mut Quad) {
    let grey = |c: &mut [f64; 3]| *c = [c.iter().sum::<f64>() / 3.0; 3];
    grey(&mut quad.exitance);
    grey(&mut quad.reflectance);
    let PatchEffects { straight, diffuse, shader, .. } = &mut quad.effects;
    straight.iter_mut().chain(diffuse).for_each(grey);
    shader.iter_mut().map(Shader::colour_mut).for_each(grey);
}

/// Adds what effects are expected to take at a preset, from samples of the scene's rows.
///
/// # Errors
/// When the scene's hemicube size is out of range.
pub fn predict(plan: &mut Plan, scene: &TextScene, quality: Quality) -> Result<()> {
    let [width, height] = scene.hemicube;
    let predicted = estimate_text(scene, &TextLadder::default(), |q| q == quality)?;
    let bounces = predicted.first().map(|predicted| Cost {
        cells: cells(scene),
        bytes: predicted.memory as u64,
        seconds: predicted.seconds,
        rays: 0,
    });
    let [glass, shaders] = look_around(&TextPatches::new(scene), HemicubeSize::new(width, height)?);
    let costs = [
        (Effect::Bounces, bounces),
        (Effect::Glass, Some(glass)),
        (Effect::Curtains, Some(curtains(scene))),
        (Effect::Shaders, Some(shaders)),
    ];
    for (effect, cost) in costs {
        let entry = plan.entry_mut(effect).expect("among those of text scenes");
        entry.predicted = cost.filter(|_| entry.on);
    }
    Ok(())
}

/// What translucent patches and patterns are expected to take in hemicubes, from some of them.
fn look_around(patches: &TextPatches, size: HemicubeSize) -> [Cost; 2] {
    let set = &patches.set;
    let Some(overlay) = &set.overlay else { return Default::default() };
    let delta = DeltaFormFactors::new(size);
    let mut gatherer = Gatherer::new(&patches.tracer, set, &delta, size);
    let all = set.patches.len();
    let chosen = (0..all).step_by(all.div_ceil(SAMPLED).max(1));
    let share = all as f64 / chosen.len().max(1) as f64;
    let mut entries = 0;
    for i in chosen {
        let patch = &set.patches[i];
        gatherer.look(&View::turned(patch.eye, patch.normal, i as u64));
        entries += gatherer.overlay().len();
    }
    overlay.costs((entries * OVERLAY_ENTRY) as u64).map(|cost| Cost {
        cells: (cost.cells as f64 * share) as u64,
        bytes: (cost.bytes as f64 * share) as u64,
        seconds: cost.seconds * share,
        ..cost
    })
}

/// Memory of what comes through, both ways.
fn curtains(scene: &TextScene) -> Cost {
    let count = scene.patches.iter().filter(|q| q.effects.diffuse.is_some()).count();
    Cost { bytes: (2 * count * size_of::<Passage>()) as u64, ..Cost::default() }
}

/// Adds what effects took in a run.
pub fn measure(
    plan: &mut Plan,
    scene: &TextScene,
    (transfers, solution): (&Transfers, &Solution),
    stages: &[(&'static str, Duration)],
) {
    let seconds = |names: &[&str]| plan_costs::seconds_of(stages, names);
    let bounces = Cost {
        cells: transfers.drawn() * cells(scene) / transfers.rows().max(1) as u64,
        bytes: transfers.bytes(),
        seconds: seconds(&["form factors", "passes"]),
        rays: 0,
    };
    let near = Cost { seconds: seconds(&["near pairs"]), ..Cost::default() };
    let [glass, shaders] = transfers.overlay_costs();
    let costs = [
        (Effect::Bounces, bounces),
        (Effect::NearField, near),
        (Effect::Glass, glass),
        (Effect::Curtains, curtains(scene)),
        (Effect::Shaders, shaders),
    ];
    for (effect, cost) in costs {
        plan.entry_mut(effect).expect("among those of text scenes").measured = Some(cost);
    }
    let colour = plan.entry_mut(Effect::Colour).expect("among those of text scenes");
    colour.reason += &format!("; solved in {}", solution.channels.count());
}

/// Cells of all hemicubes.
fn cells(scene: &TextScene) -> u64 {
    let [width, height] = scene.hemicube;
    let each = HemicubeSize::new(width, height).map_or(0, |size| size.cells() as u64);
    let backs = scene.patches.iter().filter(|q| q.effects.has_two_sides()).count();
    (scene.patches.len() + backs) as u64 * each
}

fn finding(scene: &TextScene, near: bool, effect: Effect) -> (bool, String) {
    let any = |c: [f64; 3]| c.iter().any(|&c| c > 0.0);
    let shines = |q: &Quad| any(q.exitance);
    let reflects = |q: &Quad| any(q.reflectance) || q.effects.diffuse.is_some_and(any);
    let dark = !scene.patches.iter().any(shines);
    match effect {
        Effect::Colour => {
            let (on, text) = counted(scene, is_coloured, "coloured patches", "no patch has colour");
            (on, format!("{}: {text}", if on { "three channels" } else { "one channel" }))
        }
        Effect::SurfaceLights => counted(scene, shines, "patches that shine", "no patch shines"),
        Effect::Glass => {
            let own = |q: &Quad| q.effects.is_translucent();
            counted(scene, own, "patches seen through", "no patch is straight")
        }
        Effect::Curtains => {
            let own = |q: &Quad| q.effects.diffuse.is_some_and(any);
            counted(scene, own, "patches that light comes through", "no patch is diffuse")
        }
        Effect::Shaders => {
            let own = |q: &Quad| q.effects.shader.is_some();
            counted(scene, own, "patches with patterns", "no checker, no gradient")
        }
        Effect::Bounces if scene.passes == 0 => (false, "asked for no passes".into()),
        Effect::Bounces if dark => (false, "nothing is lit".into()),
        Effect::Bounces => {
            let (on, text) =
                counted(scene, reflects, "patches that send light on", "nothing reflects");
            (on, if on { format!("{text}; at most {} passes", scene.passes) } else { text })
        }
        _ if !near => (false, "not asked for".into()),
        _ => (true, "closed forms where one hemicube at the middle of a patch may err".into()),
    }
}

fn is_coloured(quad: &Quad) -> bool {
    let coloured = |c: &[f64; 3]| c[0] != c[1] || c[1] != c[2];
    let PatchEffects { straight, diffuse, shader, .. } = &quad.effects;
    let shader = shader.map(|mut s| *s.colour_mut());
    let own = [Some(quad.exitance), Some(quad.reflectance), *straight, *diffuse, shader];
    own.iter().flatten().any(coloured)
}

/// On if there is any such patch, with the number and the place of the first.
fn counted(
    scene: &TextScene,
    which: impl Fn(&Quad) -> bool,
    what: &str,
    none: &str,
) -> (bool, String) {
    let mut found = scene.patches.iter().filter(|q| which(q));
    let Some(first) = found.next() else { return (false, none.into()) };
    let at = first.vertices.iter().sum::<DVec3>() / 4.0;
    // Scenes have any size: as many digits as tell places apart.
    let at = at.to_array().map(|x| format!("{}", (x * 1e4).round() / 1e4)).join(" ");
    (true, format!("{what}: {}, first at ({at})", 1 + found.count()))
}
