//! Direct, indirect and negative light of every face, put together.

use super::finish::{
    FinishSettings, FinishedFace, Smoothing, StyleChoice, finish, finish_directions,
};
use crate::light::{self, DirectLight, Directions, Probe, StyleLight};
use crate::photometry::Irradiance;
use crate::scene::{Sample, Scene, Surface};
use glam::Vec3;
use rayon::prelude::*;

/// Adds up the light of each surface and makes its lightmaps. `samples` and `direct` are for the
/// samples of each surface, `indirect` is for its luxels. Each argument has one entry a surface, but
/// `probes` has one a brush model: see [`probes`](super::probes()).
pub fn finish_faces(
    scene: &Scene,
    samples: &[Vec<Sample>],
    direct: Vec<DirectLight>,
    indirect: Vec<Vec<StyleLight>>,
    probes: &[Option<Probe>],
    (smoothing, choice): (Smoothing, StyleChoice),
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
                let at_samples = spread(&more.irradiance, grid.width, smoothing.extra);
                light::accumulate(
                    &mut maps,
                    &StyleLight { style: more.style, irradiance: at_samples },
                );
            }
            let probe = surface.model.and_then(|m| probes.get(m as usize)?.as_ref());
            let free = light::post(scene, surface, samples, &direct, probe, &mut maps);
            let occluded: Vec<bool> = samples.iter().map(|s| s.occluded && !free).collect();
            let width = (grid.width * smoothing.extra) as usize;
            let settings = settings_of(scene, surface, choice);
            let mut face = finish(maps, &occluded, width, settings, smoothing);
            if direct.directions.are_wanted() {
                let samples = (&occluded[..], width);
                add_directions(&mut face, &direct.directions, surface, samples, smoothing);
            }
            face
        })
        .collect()
}

/// Gives the maps of a face the directions of their light.
fn add_directions(
    face: &mut FinishedFace,
    directions: &Directions,
    surface: &Surface,
    (occluded, width): (&[bool], usize),
    smoothing: Smoothing,
) {
    let [s, t] = surface.texture_axes.map(|axis| axis.try_normalize().unwrap_or(Vec3::ZERO));
    for map in &mut face.styles {
        let known = directions.styles().iter().find(|d| d.style == map.style);
        let to_tangent = |v: &Vec3| Vec3::new(v.dot(s), -v.dot(t), v.dot(surface.normal));
        let vectors = match known {
            Some(known) => known.vectors.iter().map(to_tangent).collect(),
            None => vec![Vec3::ZERO; occluded.len()],
        };
        map.directions = finish_directions(vectors, occluded, width, smoothing);
    }
}

pub(super) fn settings_of(scene: &Scene, surface: &Surface, choice: StyleChoice) -> FinishSettings {
    let world = &scene.world;
    FinishSettings {
        range: world.range,
        gamma: world.gamma,
        max_light: if surface.max_light != 0.0 { surface.max_light } else { world.max_light },
        colour_scale: surface.colour_scale,
        choice,
    }
}

/// Gives each luxel's light to all its samples: bounced light varies little within a luxel.
pub(super) fn spread(light: &[Irradiance], width: u32, extra: u32) -> Vec<Irradiance> {
    let (width, extra) = (width as usize, extra as usize);
    let height = light.len() / width;
    (0..height * extra)
        .flat_map(|y| (0..width * extra).map(move |x| light[y / extra * width + x / extra]))
        .collect()
}
