//! Direct, indirect and negative light of every face, put together.

use super::finish::{FinishSettings, FinishedFace, finish};
use crate::light::{self, DirectLight, Probe, StyleLight};
use crate::scene::{Sample, Scene, Surface};
use rayon::prelude::*;

/// Adds up the light of each surface and makes its lightmaps. Each argument has one entry a surface,
/// but `probes` has one a brush model: see [`probes`](super::probes()).
pub fn finish_faces(
    scene: &Scene,
    samples: &[Vec<Sample>],
    direct: Vec<DirectLight>,
    indirect: Vec<Vec<StyleLight>>,
    probes: &[Option<Probe>],
) -> Vec<FinishedFace> {
    scene
        .surfaces
        .par_iter()
        .zip(samples)
        .zip(direct)
        .zip(indirect)
        .map(|(((surface, samples), mut direct), indirect)| {
            let Some(grid) = &surface.luxels else { return FinishedFace::default() };
            let mut maps = light::with_local_minimum(scene, &mut direct);
            for more in &indirect {
                light::accumulate(&mut maps, more);
            }
            let probe = surface.model.and_then(|m| probes.get(m as usize)?.as_ref());
            let free = light::post(scene, surface, samples, &direct, probe, &mut maps);
            let occluded: Vec<bool> = samples.iter().map(|s| s.occluded && !free).collect();
            finish(maps, &occluded, grid.width as usize, settings_of(scene, surface))
        })
        .collect()
}

fn settings_of(scene: &Scene, surface: &Surface) -> FinishSettings {
    let world = &scene.world;
    FinishSettings {
        range: world.range,
        gamma: world.gamma,
        max_light: if surface.max_light != 0.0 { surface.max_light } else { world.max_light },
        colour_scale: surface.colour_scale,
    }
}
