//! Choosing the work: by settings, for an error, or for a time.

use crate::map_stages::{BouncedLight, DirectLit};
use crate::progress::Progress;
use crate::settings::Settings;

/// Bounced light of a map as the settings want it, and how the work was chosen if they leave that open.
pub(crate) fn bounced(
    direct: &DirectLit,
    settings: &Settings,
    progress: &Progress,
) -> (BouncedLight, Vec<String>) {
    (direct.bounce(settings, progress), Vec::new())
}
