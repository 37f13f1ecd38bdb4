//! What holds for every text scene, whatever its shape: checked from the outside, with sums of our own.

use glam::DVec3;
use qrad::light_patches_with;
use qrad::patch::{Quad, TextPatches, TextScene};
use qrad::progress::Progress;
use qrad::radiosity::near_pairs::NearLimits;
use qrad::radiosity::solve::Solution;
use qrad::radiosity::transfers::Transfers;
use qrad::settings::Quality;

use super::quads::scene;

/// Row sums are exact but for sums of weights in single precision.
const ROW_SUM: f64 = 1e-4;
/// Rounding of exitances to single precision, relative to the largest.
const SINGLE: f64 = 2e-7;
/// Passes that every scene settles in, unless its reflectance is next to 1.
const PASSES: u32 = 1_000_000;

/// What is known about a scene.
#[derive(Clone, Copy, Debug)]
pub struct Expect {
    /// Every direction ends on the front of a patch.
    pub closed: bool,
    /// How far sums over all patches may be off, as share of the sum: energy, order.
    pub noise: f64,
    /// The same for pairs of patches: reciprocity.
    pub asymmetry: f64,
    /// Cells along a hemicube.
    pub hemicube: u32,
}

impl Default for Expect {
    fn default() -> Self {
        Self { closed: true, noise: 0.01, asymmetry: 0.02, hemicube: 128 }
    }
}

/// A solved scene.
pub struct Solved {
    pub scene: TextScene,
    pub patches: TextPatches,
    pub transfers: Transfers,
    pub solution: Solution,
}

impl Solved {
    pub fn new(quads: &[Quad], hemicube: u32, passes: u32) -> Self {
        Self::with(quads, hemicube, passes, Some(Quality::default().near()))
    }

    /// With one hemicube a patch and nothing else.
    pub fn plain(quads: &[Quad], hemicube: u32, passes: u32) -> Self {
        Self::with(quads, hemicube, passes, None)
    }

    fn with(quads: &[Quad], hemicube: u32, passes: u32, near: Option<NearLimits>) -> Self {
        let scene = scene(quads.to_vec(), hemicube, passes);
        let lit = light_patches_with(&scene, near, &Progress::new(false));
        let (transfers, solution) = lit.unwrap();
        Self { patches: TextPatches::new(&scene), scene, transfers, solution }
    }

    /// Final exitance of each patch.
    pub fn exitance(&self) -> Vec<DVec3> {
        self.solution.exitance.iter().map(|m| m.0.as_dvec3()).collect()
    }

    fn area(&self, i: usize) -> f64 {
        self.patches.set.patches[i].area.into()
    }

    /// F_ij M_j summed over j, with M from outside.
    fn arriving(&self, exitance: &[DVec3], i: usize) -> DVec3 {
        let (columns, factors) = self.transfers.row(i);
        let pairs = columns.iter().zip(&factors);
        pairs.fold(DVec3::ZERO, |sum, (&j, &f)| sum + exitance[j as usize] * f64::from(f))
    }

    /// Sum of row i.
    pub fn row_sum(&self, i: usize) -> f64 {
        self.transfers.row(i).1.iter().map(|&f| f64::from(f)).sum()
    }

    /// |A_i F_ij - A_j F_ji| summed over all pairs, as share of the sum of A_i F_ij.
    pub fn asymmetry(&self) -> f64 {
        let n = self.transfers.rows();
        let mut flow = vec![0.0; n * n];
        for i in 0..n {
            let (columns, factors) = self.transfers.row(i);
            for (&j, &f) in columns.iter().zip(&factors) {
                flow[i * n + j as usize] = self.area(i) * f64::from(f);
            }
        }
        let total: f64 = flow.iter().sum();
        let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (i, j)));
        let off: f64 = pairs.map(|(i, j)| (flow[i * n + j] - flow[j * n + i]).abs()).sum();
        if total > 0.0 { off / total } else { 0.0 }
    }

    /// Emitted less absorbed and escaped power, as share of what is emitted; the worst channel.
    pub fn imbalance(&self) -> f64 {
        let m = self.exitance();
        let (mut emitted, mut spent) = (DVec3::ZERO, DVec3::ZERO);
        for (i, quad) in self.scene.patches.iter().enumerate() {
            let area = self.area(i);
            emitted += DVec3::from(quad.exitance) * area;
            let absorbed = self.arriving(&m, i) * (DVec3::ONE - DVec3::from(quad.reflectance));
            let escaped = m[i] * (1.0 - self.row_sum(i));
            spent += (absorbed + escaped) * area;
        }
        let channels = emitted.to_array().into_iter().zip(spent.to_array());
        channels.filter(|c| c.0 > 0.0).map(|(e, s)| (s / e - 1.0).abs()).fold(0.0, f64::max)
    }

    /// Checks what one solution tells.
    #[track_caller]
    pub fn check(&self, case: &str, expect: Expect) {
        let n = self.scene.patches.len();
        assert_eq!(self.transfers.rows(), n, "{case}: a row a patch");
        for i in 0..n {
            let (columns, factors) = self.transfers.row(i);
            assert!(columns.windows(2).all(|c| c[0] < c[1]), "{case}: columns of row {i} ascend");
            assert!(columns.iter().all(|&j| (j as usize) < n), "{case}: row {i} stays inside");
            assert!(factors.iter().all(|f| f.is_finite() && *f >= 0.0), "{case}: row {i}");
            let sum = self.row_sum(i);
            assert!(sum <= 1.0 + ROW_SUM, "{case}: row {i} sums to {sum}");
            assert!(!expect.closed || sum >= 1.0 - ROW_SUM, "{case}: closed, row {i} has {sum}");
        }
        for (i, m) in self.exitance().into_iter().enumerate() {
            assert!(m.is_finite(), "{case}: patch {i} has {m}");
            let least = DVec3::from(self.scene.patches[i].exitance) * (1.0 - SINGLE);
            assert!(m.cmpge(least).all(), "{case}: patch {i} has {m}, less than it emits");
        }
        self.check_residual(case);
        let (asymmetry, imbalance) = (self.asymmetry(), self.imbalance());
        println!(
            "{case}: asymmetry {asymmetry:.4}, imbalance {imbalance:.5}, {} passes, residual {:.1e}",
            self.solution.passes, self.solution.residual
        );
        assert!(imbalance <= expect.noise, "{case}: energy is off by {imbalance}");
        assert!(asymmetry <= expect.asymmetry, "{case}: reciprocity is off by {asymmetry}");
    }

    /// Sends the light on again, pass by pass, and compares what is left and the exitances.
    #[track_caller]
    fn check_residual(&self, case: &str) {
        let quads = &self.scene.patches;
        let mut total: Vec<DVec3> = quads.iter().map(|q| DVec3::from(q.exitance)).collect();
        let mut unsent = total.clone();
        // As the program holds them, in single precision.
        let reflectance = self.patches.reflectance();
        for _ in 0..self.solution.passes {
            unsent = (0..quads.len())
                .map(|i| self.arriving(&unsent, i) * reflectance[i].0.as_dvec3())
                .collect();
            for (total, unsent) in total.iter_mut().zip(&unsent) {
                *total += *unsent;
            }
        }
        let largest = |v: &[DVec3]| v.iter().map(|m| m.max_element()).fold(0.0, f64::max);
        let most = largest(&total);
        let left = if most > 0.0 { largest(&unsent) / most } else { 0.0 };
        let told = self.solution.residual;
        let close = (told - left).abs() <= 1e-3 * left + 1e-12;
        assert!(close, "{case}: the residual is {left}, not {told}");
        for (i, (m, own)) in self.exitance().into_iter().zip(&total).enumerate() {
            let off = (m - *own).abs().max_element();
            assert!(off <= 1e-4 * most, "{case}: patch {i} has {m}, not {own}");
        }
    }
}

/// Checks everything: the scene as it is, at other numbers of threads, in another order, and with
/// more emission. Returns the solved scene.
#[track_caller]
pub fn hold(case: &str, quads: &[Quad], expect: Expect) -> Solved {
    let solved = Solved::new(quads, expect.hemicube, PASSES);
    solved.check(case, expect);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let other = pool.install(|| Solved::new(quads, expect.hemicube, PASSES));
        assert!(bits(&other) == bits(&solved), "{case}: {threads} threads change the bytes");
    }
    check_order(case, quads, expect, &solved);
    check_monotone(case, quads, expect, &solved);
    solved
}

fn bits(solved: &Solved) -> Vec<[u32; 3]> {
    solved.solution.exitance.iter().map(|m| m.0.to_array().map(f32::to_bits)).collect()
}

/// The same patches in the opposite order have the same light, but for the cells they are seen in.
#[track_caller]
fn check_order(case: &str, quads: &[Quad], expect: Expect, solved: &Solved) {
    let reversed: Vec<Quad> = quads.iter().rev().copied().collect();
    let other = Solved::new(&reversed, expect.hemicube, PASSES).exitance();
    let (mut off, mut all, mut emitted) = (0.0, 0.0, 0.0_f64);
    for (i, (m, o)) in solved.exitance().into_iter().zip(other.iter().rev()).enumerate() {
        let reflected = m - DVec3::from(quads[i].exitance);
        off += (m - *o).abs().element_sum() * solved.area(i);
        all += reflected.element_sum() * solved.area(i);
        emitted += DVec3::from(quads[i].exitance).element_sum() * solved.area(i);
    }
    // Where hardly any patch sees another, what is emitted is the measure.
    let all = all.max(0.01 * emitted);
    let share = if all > 0.0 { off / all } else { off };
    println!("{case}: order changes {share:.4} of the reflected light");
    assert!(share <= expect.noise, "{case}: the order of patches changes {share}");
}

/// One patch emits more: no patch has less light.
#[track_caller]
fn check_monotone(case: &str, quads: &[Quad], expect: Expect, solved: &Solved) {
    let mut brighter = quads.to_vec();
    let at = quads.len() / 3;
    brighter[at].exitance = brighter[at].exitance.map(|e| (e + 0.25).min(1.0));
    let more = Solved::new(&brighter, expect.hemicube, PASSES).exitance();
    let before = solved.exitance();
    let most = before.iter().map(|m| m.max_element()).fold(0.0, f64::max);
    for (i, (m, less)) in more.iter().zip(before).enumerate() {
        // Two solutions may both end short of all light by the residual.
        let ends = DVec3::splat(most * 1e-6);
        assert!(m.cmpge(less - ends).all(), "{case}: patch {i} falls from {less} to {m}");
    }
}
