//! Which errors of form factors matter: those that meet bright patches and reflect.

use crate::patch::PatchSet;
use crate::photometry::Exitance;

/// What the light of a scene is about: which rows and columns matter.
pub struct Importance {
    /// Exitance of each patch over the mean that patches reflect, at least 1.
    pub(super) exitance: Vec<f64>,
    /// Largest share of light that each patch sends on, over the channels.
    pub(super) reflectance: Vec<f64>,
}

impl Importance {
    /// From a first solution `exitance`, of which `emission` is not reflected light.
    pub fn new(patches: &PatchSet, emission: &[Exitance], exitance: &[Exitance]) -> Self {
        let (mut light, mut areas) = (0.0, 0.0);
        for ((m, e), p) in exitance.iter().zip(emission).zip(&patches.patches) {
            light += f64::from(p.area) * f64::from((m.0 - e.0).max_element());
            areas += f64::from(p.area);
        }
        let relative = |m: &Exitance| {
            let share = f64::from(m.0.max_element()) * areas / light;
            if share.is_finite() { share.max(1.0) } else { 1.0 }
        };
        Self {
            exitance: exitance.iter().map(relative).collect(),
            reflectance: patches.albedo().iter().map(|a| f64::from(a.max_element())).collect(),
        }
    }
}
