//! Sums over the patches of a map: reciprocity, energy and the residual, worked out from the rows.

use super::lit_map::{Lit, Prepared};
use glam::DVec3;
use qrad::light::bounce_source;
use qrad::patch::{Overlay, Passage, PatchSet, Sheet, Tint};
use qrad::radiosity::bounce::PatchLight;
use qrad::radiosity::transfers::Transfers;
use qrad::scene::Role;
use std::sync::Arc;

/// What the sums of a map come to.
#[derive(Clone, Copy, Debug, Default)]
pub struct MapSums {
    /// |A_a F_ab - A_b F_ba| over all pairs of planes with faces and the channels, as share of the sum of
    /// A_a F_ab. What lies behind glass counts as the glass lets through.
    pub asymmetry: f64,
    /// Light that is emitted or first sent on, less absorbed and escaped light, as share of the first; the
    /// worst channel and style.
    pub imbalance: f64,
    /// Largest change of one more pass, as share of the largest exitance.
    pub residual: f64,
}

impl MapSums {
    pub fn new(map: &Prepared, lit: &Lit) -> Self {
        let apart = without_patterns(map);
        let seen = apart.as_ref().unwrap_or(&map.transfers);
        let mut sums = Self { asymmetry: asymmetry(map, seen), ..Self::default() };
        for light in &lit.bounced.styles {
            let (imbalance, residual) = style(map, seen, lit, light);
            sums.imbalance = sums.imbalance.max(imbalance);
            sums.residual = sums.residual.max(residual);
        }
        sums
    }
}

/// Area of a patch as far as it takes light out of the map: liquids and glass receive light, but no ray of
/// others ends on them.
fn area(map: &Prepared, i: usize) -> f64 {
    let surface = &map.scene.surfaces[map.patches.surface[i] as usize];
    let passes = match surface.role {
        Role::Ghost => true,
        Role::Filter => !surface.reflects,
        _ => false,
    };
    if passes { 0.0 } else { map.patches.set.patches[i].area.into() }
}

/// Form factors of a patch to others, a channel, with what glass takes from the light that passes it.
fn row(transfers: &Transfers, i: usize) -> impl Iterator<Item = (usize, DVec3)> + '_ {
    let opaque = transfers.entries(i).map(|(j, f)| (j, DVec3::splat(f.into())));
    let panes = transfers.overlay_row(i).iter().map(|&(j, f)| (j, f.as_dvec3()));
    opaque.chain(panes).map(|(j, f)| (j as usize, f))
}

/// The transfers without what patterns add, which tells from which parts of a patch light comes, not how
/// much of the patch is seen; `None` where there are none.
fn without_patterns(map: &Prepared) -> Option<Transfers> {
    map.patches.set.overlay.as_deref().filter(|overlay| overlay.has_patterns())?;
    let (polygons, panes) = map.scene.panes();
    let sheet = |pane| Sheet { tint: Tint::Pane(pane), sides: [None; 2] };
    let overlay = Overlay::new(polygons, panes.into_iter().map(sheet).collect(), Vec::new());
    let set = PatchSet { overlay: overlay.map(Arc::new), ..map.patches.set.clone() };
    Some(map.transfers_of(&set))
}

/// Between the planes of the map's surfaces: the errors of single pairs of patches, a few cells each,
/// are mostly those of neighbours.
fn asymmetry(map: &Prepared, seen: &Transfers) -> f64 {
    let surfaces = &map.scene.surfaces;
    let same = |a: usize, b: usize| {
        surfaces[a].normal == surfaces[b].normal && surfaces[a].dist == surfaces[b].dist
    };
    let count = surfaces.len();
    let plane: Vec<usize> = (0..count).map(|a| (0..a).find(|&b| same(a, b)).unwrap_or(a)).collect();
    let mut flow = vec![DVec3::ZERO; count * count];
    for i in 0..seen.rows() {
        for (j, f) in row(seen, i) {
            let [from, to] = [i, j].map(|p| plane[map.patches.surface[p] as usize]);
            flow[from * count + to] += area(map, i) * f;
        }
    }
    let all: f64 = flow.iter().map(|f| f.element_sum()).sum();
    let pairs = (0..count).flat_map(|i| (0..i).map(move |j| (i, j)));
    let off: f64 =
        pairs.map(|(i, j)| (flow[i * count + j] - flow[j * count + i]).abs().element_sum()).sum();
    if all > 0.0 { off / all } else { 0.0 }
}

/// Imbalance and residual of one style.
fn style(map: &Prepared, seen: &Transfers, lit: &Lit, light: &PatchLight) -> (f64, f64) {
    let arriving: Vec<_> = lit
        .direct
        .iter()
        .zip(&map.samples)
        .map(|(direct, samples)| bounce_source(direct, samples, 1, 1))
        .collect();
    let luxels: Vec<&[_]> = arriving
        .iter()
        .map(|d| d.iter().find(|s| s.style == light.style).map_or(&[][..], |s| &s.irradiance))
        .collect();
    let direct = map.patches.mean_irradiance(&luxels);
    let m: Vec<DVec3> = light.exitance.iter().map(|m| m.0.as_dvec3()).collect();
    let set = &map.patches.set;
    let emission = map.patches.emission(&map.scene.emitters);
    let emission = emission.iter().find(|e| e.style == light.style);
    let (mut arriving, mut sums) = (Vec::new(), Vec::new());
    for i in 0..set.patches.len() {
        arriving.push(row(&map.transfers, i).map(|(j, f)| m[j] * f).sum::<DVec3>());
        sums.push(row(seen, i).map(|(_, f)| f).sum::<DVec3>());
    }
    // Of what meets a patch: what it lets through, and what comes through to it.
    let mut tau = vec![DVec3::ZERO; m.len()];
    let (mut first_through, mut through) = (tau.clone(), tau.clone());
    for &Passage { from, to, transmittance } in &set.passages {
        let (from, to, share) = (from.0 as usize, to.0 as usize, transmittance.as_dvec3());
        tau[from] = share;
        first_through[to] += share * direct[from].0.as_dvec3();
        through[to] += share * arriving[from];
    }
    let (mut first, mut spent) = (DVec3::ZERO, DVec3::ZERO);
    let (mut change, mut most) = (0.0_f64, 0.0_f64);
    for (i, patch) in set.patches.iter().enumerate() {
        let rho = patch.reflectance.0.as_dvec3();
        let emitted = emission.map_or(DVec3::ZERO, |e| e.exitance[i].0.as_dvec3());
        let start = emitted + rho * direct[i].0.as_dvec3() + first_through[i];
        first += start * area(map, i);
        let absorbed = arriving[i] * (DVec3::ONE - rho - tau[i]);
        spent += (absorbed + m[i] * (DVec3::ONE - sums[i])) * area(map, i);
        change = change.max((start + rho * arriving[i] + through[i] - m[i]).abs().max_element());
        most = most.max(m[i].abs().max_element());
    }
    let channels = first.to_array().into_iter().zip(spent.to_array()).filter(|c| c.0 != 0.0);
    let imbalance = channels.map(|(f, s)| (s / f - 1.0).abs()).fold(0.0, f64::max);
    (imbalance, if most > 0.0 { change / most } else { 0.0 })
}
