//! Direct, indirect and negative light of every face, put together.

use super::finish::{FinishSettings, FinishedFace, StyleChoice, finish};
use crate::light::{DirectLight, StyleLight};
use crate::scene::{Sample, Scene, Surface};
use rayon::prelude::*;

/// Adds up the light of each surface and makes its lightmaps. Each list has one entry a surface.
pub fn finish_faces(
    scene: &Scene,
    samples: &[Vec<Sample>],
    direct: Vec<DirectLight>,
    indirect: Vec<Vec<StyleLight>>,
    choice: StyleChoice,
) -> Vec<FinishedFace> {
    scene
        .surfaces
        .par_iter()
        .zip(samples)
        .zip(direct)
        .zip(indirect)
        .map(|(((surface, samples), direct), indirect)| {
            let Some(grid) = &surface.luxels else { return FinishedFace::default() };
            let mut maps = direct.styles;
            for more in indirect.iter().chain(&direct.negative) {
                accumulate(&mut maps, more);
            }
            let occluded: Vec<bool> = samples.iter().map(|s| s.occluded).collect();
            finish(maps, &occluded, grid.width as usize, settings_of(scene, surface, choice))
        })
        .collect()
}

fn settings_of(scene: &Scene, surface: &Surface, choice: StyleChoice) -> FinishSettings {
    let world = &scene.world;
    FinishSettings {
        range: world.range,
        gamma: world.gamma,
        max_light: if surface.max_light != 0.0 { surface.max_light } else { world.max_light },
        colour_scale: surface.colour_scale,
        choice,
    }
}

/// Adds `more` to the map of its style, which is made if it is not there.
fn accumulate(maps: &mut Vec<StyleLight>, more: &StyleLight) {
    match maps.iter_mut().find(|m| m.style == more.style) {
        Some(map) => {
            for (sum, e) in map.irradiance.iter_mut().zip(&more.irradiance) {
                *sum += *e;
            }
        }
        None => maps.push(more.clone()),
    }
}
