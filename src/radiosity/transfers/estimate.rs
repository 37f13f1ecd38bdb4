//! How much memory transfers will take, from a few of their rows.

use super::share::is_promising;
use super::{Gatherer, OVERLAY_ENTRY, Sharing, Transfers};
use crate::patch::{Groups, PatchSet};
use crate::radiosity::hemicube::{DeltaFormFactors, HemicubeSize, View};
use crate::scene::Tracer;

/// Rows drawn for an estimate.
const ROWS: usize = 64;
/// Groups that are looked at for an estimate of how many share a row.
const GROUPS: usize = 1024;
/// The most bytes of a stored form factor and its column; rows of many patches beside each other take fewer.
const ENTRY: f64 = 4.0;
/// Bytes that a row takes besides.
const ROW: f64 = 12.0;

impl Transfers {
    /// About how many of the patches have a row drawn for them, as a share of all: 1 without sharing.
    pub fn expected_rows(tracer: &Tracer, patches: &PatchSet, groups: &Groups, share: f32) -> f64 {
        let members = groups.members();
        let (mut rows, mut all) = (0_usize, 0_usize);
        for g in (0..members.len()).step_by(members.len().div_ceil(GROUPS).max(1)) {
            let shares = is_promising(tracer, patches, (groups.eyes[g], &members[g]), share);
            rows += if shares { 1 } else { members[g].len() };
            all += members[g].len();
        }
        rows as f64 / all.max(1) as f64
    }

    /// Bytes that [`shared`](Self::shared) transfers will take, from the rows of some groups: how many
    /// patches those see, and how many share one.
    pub fn expected_bytes(
        tracer: &Tracer,
        patches: &PatchSet,
        Sharing { groups, share, .. }: Sharing<'_>,
        size: HemicubeSize,
    ) -> u64 {
        let members = groups.members();
        let delta = DeltaFormFactors::new(size);
        let mut gatherer = Gatherer::new(tracer, patches, &delta, size);
        let (mut drawn, mut rows, mut bytes) = (0.0, 0.0, 0.0);
        for g in (0..members.len()).step_by(members.len().div_ceil(ROWS).max(1)) {
            let (middle, first) = (groups.eyes[g], members[g][0]);
            let normal = patches.patches[first as usize].normal;
            gatherer.look(&View::turned(middle, normal, first.into()));
            drawn += 1.0;
            bytes += ENTRY * gatherer.row().len() as f64;
            bytes += (OVERLAY_ENTRY * gatherer.overlay().len()) as f64;
            let reach = share * gatherer.distances().openness;
            let near = |&&i: &&u32| patches.patches[i as usize].eye.distance(middle) < reach;
            let shares = is_promising(tracer, patches, (middle, &members[g]), share);
            let near = if shares { members[g].iter().filter(near).count() } else { 0 };
            rows += (members[g].len() - near.saturating_sub(1)) as f64;
        }
        let row = bytes / f64::max(drawn, 1.0) + ROW;
        let all = members.len() as f64 * rows / f64::max(drawn, 1.0);
        (all * row) as u64 + 8 * groups.of.len() as u64
    }
}
