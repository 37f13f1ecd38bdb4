//! Sums over the patches of a map: reciprocity, energy and the residual, worked out from the rows.

use super::lit_map::{Lit, Prepared};
use glam::DVec3;
use qrad::light::bounce_source;
use qrad::radiosity::bounce::PatchLight;
use qrad::scene::Role;

/// What the sums of a map come to.
#[derive(Clone, Copy, Debug, Default)]
pub struct MapSums {
    /// |A_a F_ab - A_b F_ba| over all pairs of planes with faces, as share of the sum of A_a F_ab.
    pub asymmetry: f64,
    /// First reflected less absorbed and escaped light, as share of the first; the worst channel and
    /// style.
    pub imbalance: f64,
    /// Largest change of one more pass, as share of the largest exitance.
    pub residual: f64,
}

impl MapSums {
    /// The sums of `lit`, in a map whose patches reflect point lights and emit nothing themselves.
    pub fn new(map: &Prepared, lit: &Lit) -> Self {
        assert!(map.patches.emission(&map.scene.emitters).is_empty(), "patches emit");
        let mut sums = Self { asymmetry: asymmetry(map), ..Self::default() };
        for light in &lit.bounced.styles {
            let (imbalance, residual) = style(map, lit, light);
            sums.imbalance = sums.imbalance.max(imbalance);
            sums.residual = sums.residual.max(residual);
        }
        sums
    }
}

/// Area of a patch as far as it takes light out of the map: liquids receive light, but all of it passes on.
fn area(map: &Prepared, i: usize) -> f64 {
    let surface = &map.scene.surfaces[map.patches.surface[i] as usize];
    if surface.role == Role::Ghost { 0.0 } else { map.patches.set.patches[i].area.into() }
}

/// Between the planes of the map's surfaces: the errors of single pairs of patches, a few cells each,
/// are mostly those of neighbours.
fn asymmetry(map: &Prepared) -> f64 {
    let surfaces = &map.scene.surfaces;
    let same = |a: usize, b: usize| {
        surfaces[a].normal == surfaces[b].normal && surfaces[a].dist == surfaces[b].dist
    };
    let count = surfaces.len();
    let plane: Vec<usize> = (0..count).map(|a| (0..a).find(|&b| same(a, b)).unwrap_or(a)).collect();
    let mut flow = vec![0.0; count * count];
    for i in 0..map.transfers.rows() {
        let (columns, factors) = map.transfers.row(i);
        for (&j, &f) in columns.iter().zip(&factors) {
            let [from, to] = [i, j as usize].map(|p| plane[map.patches.surface[p] as usize]);
            flow[from * count + to] += area(map, i) * f64::from(f);
        }
    }
    let all: f64 = flow.iter().sum();
    let pairs = (0..count).flat_map(|i| (0..i).map(move |j| (i, j)));
    let off: f64 = pairs.map(|(i, j)| (flow[i * count + j] - flow[j * count + i]).abs()).sum();
    if all > 0.0 { off / all } else { 0.0 }
}

/// Imbalance and residual of one style.
fn style(map: &Prepared, lit: &Lit, light: &PatchLight) -> (f64, f64) {
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
    let (mut first, mut spent) = (DVec3::ZERO, DVec3::ZERO);
    let (mut change, mut most) = (0.0_f64, 0.0_f64);
    for (i, patch) in map.patches.set.patches.iter().enumerate() {
        let rho = patch.reflectance.0.as_dvec3();
        let (columns, factors) = map.transfers.row(i);
        let (mut arrives, mut row) = (DVec3::ZERO, DVec3::ZERO);
        let opaque = columns.iter().zip(&factors).map(|(&j, &f)| (j, DVec3::splat(f64::from(f))));
        // What glass takes from the light that passes it.
        let panes = map.transfers.overlay_row(i).iter().map(|&(j, f)| (j, f.as_dvec3()));
        for (j, f) in opaque.chain(panes) {
            arrives += m[j as usize] * f;
            row += f;
        }
        let reflected = rho * direct[i].0.as_dvec3();
        first += reflected * area(map, i);
        spent += (arrives * (DVec3::ONE - rho) + m[i] * (DVec3::ONE - row)) * area(map, i);
        change = change.max((reflected + rho * arrives - m[i]).abs().max_element());
        most = most.max(m[i].abs().max_element());
    }
    let channels = first.to_array().into_iter().zip(spent.to_array()).filter(|c| c.0 != 0.0);
    let imbalance = channels.map(|(f, s)| (s / f - 1.0).abs()).fold(0.0, f64::max);
    (imbalance, if most > 0.0 { change / most } else { 0.0 })
}
