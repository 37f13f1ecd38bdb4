//! The best light that fits into a time.

use super::{Aim, Costs, Keep, Rung};
use crate::lightmap::Gather;
use crate::map_stages::{BouncedLight, DirectLit};
use crate::progress::Progress;
use crate::settings::Settings;
use std::time::Duration;

/// Share of the time asked for in which direct light is to be done, all that is before it included.
const DIRECT: f64 = 0.55;
/// Share of the time left that the chosen settings may take; what remains goes into single luxels.
const FILLED: f64 = 0.7;
/// Share of the time left that a first, rough look may take.
const ROUGH: f64 = 0.15;
/// Share of the time asked for that is kept for what comes last...
const ENDING: f64 = 0.03;
/// ...and so many times what it took to place luxels.
const ENDINGS: f64 = 2.5;
/// With less than so many times that left, patches are not even cut.
const PATCHES: f64 = 4.0;

/// When direct light is to end, if a time is asked for.
pub(crate) fn end_of_direct(aim: Aim) -> Option<Duration> {
    match aim {
        Aim::Time(seconds) => Some(Duration::from_secs_f64(DIRECT * seconds)),
        _ => None,
    }
}

/// Bounced light that is done within `seconds` of the beginning of the run. With the roughest settings
/// first, whose time tells how far off predictions are; these too are left out if they do not fit.
pub(super) fn for_time(
    direct: &DirectLit,
    settings: &Settings,
    seconds: f64,
    progress: &Progress,
    keep: &mut Keep<'_>,
) -> (BouncedLight, Vec<String>) {
    let mut said: Vec<String> = direct.partly.clone().into_iter().collect();
    let say = |said: &mut Vec<String>, sentence: String| {
        progress.say(&sentence);
        said.push(sentence);
    };
    let placing: f64 =
        progress.stages().iter().filter(|s| s.0 == "luxels").map(|s| s.1.as_secs_f64()).sum();
    let end = seconds * (1.0 - ENDING) - ENDINGS * placing;
    let left = || end - progress.elapsed().as_secs_f64();
    let guess = |mut said: Vec<String>| {
        say(&mut said, format!("{seconds} s are too few for patches: bounced light is a guess"));
        (direct.ambient(settings, progress), said)
    };
    if left() <= PATCHES * placing {
        return guess(said);
    }
    if settings.keep_partial {
        keep(&direct.ambient(settings, progress));
    }
    let rungs = settings.ladder.rungs();
    let mut costs = Costs::measure_rough(&direct.scene, &direct.points.luxels);
    // Hemicubes at all luxels come last: they can stop at any of them.
    let run = |rung: &Rung| {
        let gather = Gather::Interpolate;
        let settings = Settings { check: false, gather, ..rung.settings(settings) };
        let end = progress.deadline(Duration::from_secs_f64(end.max(0.0)));
        Some((direct.bounce_until(&settings, end, progress)?, settings))
    };
    let mut best = None;
    // How many times longer it takes than predicted.
    let mut slower = 1.0;
    let rough = costs.seconds(&rungs[0]);
    if rough < ROUGH * left() {
        let begun = progress.elapsed().as_secs_f64();
        best = run(&rungs[0]).map(|light| (0, light));
        let taken = progress.elapsed().as_secs_f64() - begun;
        slower = (taken / rough.max(1e-6)).clamp(0.5, 3.0);
        if let Some((_, light)) = best.as_ref().filter(|_| settings.keep_partial) {
            keep(&light.0);
        }
        costs = Costs::measure(&direct.scene, &direct.points.luxels);
    }
    let fits = |r: &Rung| slower * costs.seconds(r) <= FILLED * left();
    let choice = rungs.iter().rposition(fits).unwrap_or(0);
    // What does not fit by prediction may do so all the same: it is tried until there is no time left.
    if best.as_ref().is_none_or(|b| b.0 < choice)
        && let Some(light) = run(&rungs[choice])
    {
        best = Some((choice, light));
    }
    let Some((choice, (mut light, chosen))) = best else { return guess(said) };
    say(&mut said, format!("for a time of {seconds} s: {}", rungs[choice].text()));
    // The check comes last, when luxels are done.
    let check = if settings.check { settings.check_share * seconds } else { 0.0 };
    if left() - check > 0.02 * seconds {
        if settings.keep_partial {
            keep(&light);
        }
        let end = progress.deadline(Duration::from_secs_f64((end - check).max(0.0)));
        let refined = direct.refine(&mut light, &chosen, end, progress);
        say(&mut said, format!("{refined} luxels got a hemicube of their own in the time left"));
    }
    if settings.check && left() > 0.0 {
        direct.check(&mut light, settings, progress);
    }
    (light, said)
}
