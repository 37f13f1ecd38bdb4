//! How much memory transfers will take, from a few of their rows.

use super::{Gatherer, OVERLAY_ENTRY, Sharing, Transfers};
use crate::patch::PatchSet;
use crate::radiosity::hemicube::{DeltaFormFactors, HemicubeSize, View};
use crate::scene::Tracer;

/// Rows drawn for an estimate.
const ROWS: usize = 64;
/// The most bytes of a stored form factor and its column; rows of many patches beside each other take fewer.
const ENTRY: f64 = 4.0;
/// Bytes that a row takes besides.
const ROW: f64 = 12.0;

impl Transfers {
    /// Bytes that [`shared`](Self::shared) transfers will take, from the rows of some leaders: how many
    /// patches those see, and how many of their group may share them.
    pub fn expected_bytes(
        tracer: &Tracer,
        patches: &PatchSet,
        Sharing { leaders, share, .. }: Sharing<'_>,
        size: HemicubeSize,
    ) -> u64 {
        let all: Vec<u32> =
            (0..leaders.len() as u32).filter(|&i| leaders[i as usize] == i).collect();
        let delta = DeltaFormFactors::new(size);
        let mut gatherer = Gatherer::new(tracer, patches, &delta, size);
        let followers = Followers::of(leaders);
        let (mut drawn, mut bytes, mut led, mut alone) = (0.0, 0.0, 0.0, 0.0);
        for &leader in all.iter().step_by(all.len().div_ceil(ROWS).max(1)) {
            let patch = &patches.patches[leader as usize];
            gatherer.look(&View::turned(patch.eye, patch.normal, leader.into()));
            drawn += 1.0;
            bytes += ENTRY * gatherer.row().len() as f64;
            bytes += (OVERLAY_ENTRY * gatherer.overlay().len()) as f64;
            let reach = share * gatherer.distances().openness;
            for &i in followers.of_leader(leader) {
                led += 1.0;
                let near = patches.patches[i as usize].eye.distance(patch.eye) < reach;
                alone += f64::from(u8::from(!near));
            }
        }
        let rest = (leaders.len() - all.len()) as f64;
        let rows = all.len() as f64 + rest * alone / f64::max(led, 1.0);
        let row = bytes / f64::max(drawn, 1.0) + ROW;
        (rows * row) as u64 + 8 * leaders.len() as u64
    }
}

/// The patches that do not lead, by their leader.
struct Followers(Vec<(u32, u32)>, Vec<u32>);

impl Followers {
    fn of(leaders: &[u32]) -> Self {
        let mut pairs: Vec<(u32, u32)> = leaders.iter().copied().zip(0..).collect();
        pairs.retain(|(leader, i)| leader != i);
        pairs.sort_unstable();
        let members = pairs.iter().map(|p| p.1).collect();
        Self(pairs, members)
    }

    fn of_leader(&self, leader: u32) -> &[u32] {
        let from = self.0.partition_point(|p| p.0 < leader);
        let to = self.0.partition_point(|p| p.0 <= leader);
        &self.1[from..to]
    }
}
