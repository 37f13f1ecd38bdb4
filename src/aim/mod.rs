//! Choosing the work: by settings, for an error, or for a time.

mod costs;
mod half;
mod ladder;
mod pilot;
mod text;

pub use costs::{Costs, Predicted};
pub use half::{half_error, half_error_text};
pub use ladder::{Rung, rungs};
pub(crate) use pilot::sample_direct;
pub use pilot::{Estimated, estimate};
pub use text::{TextPredicted, estimate_text, text_quality};

use crate::map_stages::{BouncedLight, DirectLit};
use crate::progress::Progress;
use crate::settings::Settings;
use std::time::{Duration, Instant};

/// What a run is to reach.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Aim {
    /// What the settings say.
    #[default]
    Settings,
    /// A relative root mean square error of bounced light, in (0, 1), whatever the time.
    Error(f64),
    /// An end after so many seconds, above 0, with the least error.
    Time(f64),
}

/// Share of the time that goes into the check of a pilot.
const PILOT_CHECK: f64 = 0.1;
/// Share of the time asked for that the chosen settings may take; what is left goes into single luxels.
const FILLED: f64 = 0.75;
/// Share of the time asked for that is kept for writing.
const ENDING: f64 = 0.04;
/// A target counts as missed where the check says so by this factor.
const MISSED: f64 = 1.5;

/// What has been reached so far, for those who keep parts.
pub(crate) type Keep<'a> = dyn FnMut(&BouncedLight) + 'a;

/// Bounced light of a map as the settings want it, and how the work was chosen if they leave that open.
/// `keep` is told of light that is whole but may get better yet.
pub(crate) fn bounced(
    direct: &DirectLit,
    settings: &Settings,
    progress: &Progress,
    keep: &mut Keep<'_>,
) -> (BouncedLight, Vec<String>) {
    match settings.aim {
        Aim::Settings => (direct.bounce(settings, progress), Vec::new()),
        Aim::Error(target) => for_error(direct, settings, target, progress),
        Aim::Time(seconds) => for_time(direct, settings, seconds, progress, keep),
    }
}

/// The cheapest settings that are expected to reach the target.
fn for_error(
    direct: &DirectLit,
    settings: &Settings,
    target: f64,
    progress: &Progress,
) -> (BouncedLight, Vec<String>) {
    let costs = Costs::measure(&direct.scene, &direct.points.luxels);
    let rungs = rungs();
    let pilot = Settings { check: true, check_share: PILOT_CHECK, ..rungs[0].settings(settings) };
    let rough = direct.bounce(&pilot, progress);
    // A rough check says less than what is known of other maps; both count.
    let scale = rough.checked.0.as_ref().and_then(|f| {
        let sure = (f.square / f.square_deviation).clamp(0.0, 8.0) / 8.0;
        f.error().map(|e| (e / rungs[0].error).powf(sure))
    });
    let scale = scale.unwrap_or(1.0).clamp(0.5, 2.5);
    let cheapest = |enough: &dyn Fn(&Rung) -> bool| {
        let enough = (0..rungs.len()).filter(|&i| enough(&rungs[i]));
        enough.min_by(|&a, &b| costs.seconds(&rungs[a]).total_cmp(&costs.seconds(&rungs[b])))
    };
    let enough = cheapest(&|r| r.error * scale <= target);
    let mut choice = enough.unwrap_or(rungs.len() - 1);
    let mut said = Vec::new();
    loop {
        let rung = &rungs[choice];
        let here = progress.elapsed().as_secs_f64();
        let predicted = here + costs.seconds(rung);
        said.push(format!(
            "for an error of {:.2} %: {}, with an error of about {:.2} % expected, in {predicted:.1} s \
             as a whole",
            100.0 * target,
            rung.text(),
            100.0 * rung.error * scale
        ));
        progress.say(said.last().expect("just pushed"));
        let light = direct.bounce(&rung.settings(settings), progress);
        let missed =
            light.checked.0.as_ref().is_some_and(|f| {
                f.error().is_some_and(|e| e - 2.0 * f.deviation() > MISSED * target)
            });
        if !missed || choice + 1 == rungs.len() {
            if missed || enough.is_none() {
                said.push("the target is out of reach of all settings".into());
            }
            return (light, said);
        }
        said.push("the check finds a larger error, so finer settings follow".into());
        let before = rungs[choice].error;
        choice = cheapest(&|r| r.error < before).unwrap_or(rungs.len() - 1);
    }
}

/// The best settings that fit into the time, and single luxels until it is over.
fn for_time(
    direct: &DirectLit,
    settings: &Settings,
    seconds: f64,
    progress: &Progress,
    keep: &mut Keep<'_>,
) -> (BouncedLight, Vec<String>) {
    let costs = Costs::measure(&direct.scene, &direct.points.luxels);
    let rungs = rungs();
    let mut said = Vec::new();
    let left = || seconds * (1.0 - ENDING) - progress.elapsed().as_secs_f64();
    let fits = |part: f64| rungs.iter().rposition(|r| costs.seconds(r) <= part * left());
    let mut choice = fits(FILLED);
    if let Some(first) = choice
        && settings.keep_partial
        && first > 0
        && costs.seconds(&rungs[0]) < 0.2 * left()
    {
        let unchecked = Settings { check: false, ..rungs[0].settings(settings) };
        keep(&direct.bounce(&unchecked, progress));
        choice = fits(FILLED);
    }
    if choice.is_none() {
        said.push(format!("{seconds} s are too few: the roughest settings take longer"));
    }
    let rung = &rungs[choice.unwrap_or(0)];
    said.push(format!("for a time of {seconds} s: {}", rung.text()));
    progress.say(said.last().expect("just pushed"));
    // The check comes last, when luxels are done.
    let chosen = Settings { check: false, ..rung.settings(settings) };
    let mut light = direct.bounce(&chosen, progress);
    let check = if settings.check { settings.check_share * seconds } else { 0.0 };
    if left() - check > 0.05 * seconds {
        keep(&light);
        let end = Instant::now() + Duration::from_secs_f64(left() - check);
        let refined = direct.refine(&mut light, &chosen, end, progress);
        said.push(format!("{refined} luxels got a hemicube of their own in the time left"));
    }
    if settings.check && left() > 0.0 {
        direct.check(&mut light, settings, progress);
    }
    (light, said)
}
