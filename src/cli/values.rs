//! Spellings of values that options take.

use crate::scene::ALL_BOUNCES;
use clap::ValueEnum;

/// Spelling of [`Gather`](crate::lightmap::Gather).
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum GatherArg {
    /// Between the patches around a luxel, where they tell it well: fast
    Interpolate,
    /// A hemicube at every luxel: slow, sharpest
    Luxel,
}

/// Whether near pairs get more than a hemicube.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum NearFieldArg {
    /// As far as the quality says
    #[default]
    On,
    /// One hemicube a patch and nothing else: to compare with
    Off,
}

/// Spelling of [`SurfaceLights`](crate::settings::SurfaceLights).
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub enum SurfaceLightsArg {
    /// As point lights in front of the surface, like light does
    #[default]
    Points,
    /// As true area light
    Area,
}

/// Splits `KEY=VALUE`.
pub(super) fn key_value(text: &str) -> std::result::Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim_start_matches('_').is_empty() => {
            Ok((key.to_owned(), value.to_owned()))
        }
        _ => Err("give a worldspawn key and its value with = between".into()),
    }
}

/// Spelling of a number of bounces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BounceCount {
    /// Until the residual is reached, whatever the map says.
    All,
    /// At most so many.
    Most(u32),
}

/// Reads `--bounces`.
pub(super) fn bounce_count(text: &str) -> std::result::Result<BounceCount, String> {
    if text == ALL_BOUNCES {
        return Ok(BounceCount::All);
    }
    text.parse().map(BounceCount::Most).map_err(|_| format!("give a number or {ALL_BOUNCES}"))
}
