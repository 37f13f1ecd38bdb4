//! Choosing the work: by settings, for an error, or for a time.

mod costs;
mod half;
mod ladder;
mod pilot;
mod text;
mod text_ladder;
mod time;

pub use costs::{Costs, Predicted};
pub use half::{half_error, half_error_text};
pub use ladder::{Ladder, Rung};
pub(crate) use pilot::sample_direct;
pub use pilot::{Estimated, estimate};
pub use text::{TextPredicted, estimate_text};
pub use text_ladder::TextLadder;
pub(crate) use time::end_of_direct;

use crate::map_stages::{BouncedLight, DirectLit};
use crate::progress::Progress;
use crate::settings::Settings;

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
/// A target counts as missed where the check says so by this factor.
const MISSED: f64 = 1.5;

/// How the work was chosen.
#[derive(Clone, Debug, Default)]
pub struct Chosen {
    /// One sentence each.
    pub said: Vec<String>,
    /// What was expected of the first choice: the time of the whole run.
    pub predicted: Option<Predicted>,
}

/// What has been reached so far, for those who keep parts.
pub(crate) type Keep<'a> = dyn FnMut(&BouncedLight) + 'a;

/// Bounced light of a map as the settings want it, and how the work was chosen if they leave that open.
/// `keep` is told of light that is whole but may get better yet.
pub(crate) fn bounced(
    direct: &DirectLit,
    settings: &Settings,
    progress: &Progress,
    keep: &mut Keep<'_>,
) -> (BouncedLight, Chosen) {
    match settings.aim {
        Aim::Settings => (direct.bounce(settings, progress), Chosen::default()),
        Aim::Error(target) => for_error(direct, settings, target, progress),
        Aim::Time(seconds) => {
            let (light, said) = time::for_time(direct, settings, seconds, progress, keep);
            (light, Chosen { said, predicted: None })
        }
    }
}

/// The cheapest settings that are expected to reach the target.
fn for_error(
    direct: &DirectLit,
    settings: &Settings,
    target: f64,
    progress: &Progress,
) -> (BouncedLight, Chosen) {
    let costs = Costs::measure(&direct.scene, &direct.points.luxels);
    let rungs = settings.ladder.rungs();
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
    let (mut said, mut first) = (Vec::new(), None);
    loop {
        let rung = &rungs[choice];
        let here = progress.elapsed().as_secs_f64();
        let of_rung = costs.predict(rung);
        let (predicted, error) = (here + of_rung.seconds, rung.error * scale);
        first.get_or_insert(Predicted { seconds: predicted, error, ..of_rung });
        said.push(format!(
            "for an error of {:.2} %: {}, with an error of about {:.2} % expected, in {predicted:.1} s \
             as a whole",
            100.0 * target,
            rung.text(),
            100.0 * error
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
            return (light, Chosen { said, predicted: first });
        }
        said.push("the check finds a larger error, so finer settings follow".into());
        let before = rungs[choice].error;
        choice = cheapest(&|r| r.error < before).unwrap_or(rungs.len() - 1);
    }
}
