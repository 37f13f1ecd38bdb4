//! Hemicubes at single luxels for as long as there is time, those first where light varies most.

use super::indirect::{Drawn, seed};
use super::{GatherSettings, Sources};
use crate::light::StyleLight;
use crate::photometry::Irradiance;
use crate::progress::Deadline;
use crate::radiosity::hemicube::View;
use crate::scene::Sample;
use glam::DVec3;
use rayon::prelude::*;

/// Luxels between two looks at the clock, for each thread.
const BATCH: usize = 32;

/// Replaces bounced light in `maps` by that of hemicubes at luxels until `deadline`. `samples` holds the
/// luxels of each surface. Returns how many luxels were done. The time decides how many and nothing
/// else.
pub fn refine(
    sources: Sources<'_>,
    samples: &[Vec<Sample>],
    maps: &mut [Vec<StyleLight>],
    settings: GatherSettings,
    deadline: Deadline<'_>,
) -> u64 {
    let order = most_varied(sources, samples, maps);
    let size = settings.hemicube;
    let drawn = Drawn::new(sources, size);
    let mut done = 0;
    for batch in order.chunks(BATCH * rayon::current_num_threads()) {
        if deadline.passed() {
            break;
        }
        let light: Vec<Vec<DVec3>> = batch
            .par_iter()
            .map_init(
                || drawn.looks(),
                |looks, &(face, luxel)| {
                    let sample = &samples[face][luxel];
                    let flat = sources.scene.surfaces[face].normal;
                    let normal = sample.normal.normalize_or(flat);
                    let view = View::turned(sample.position, normal, seed(sample.position));
                    drawn.arriving(looks, &view)
                },
            )
            .collect();
        for (&(face, luxel), light) in batch.iter().zip(light) {
            for (style, e) in sources.light.iter().zip(light) {
                put(
                    &mut maps[face],
                    style.style,
                    samples[face].len(),
                    luxel,
                    Irradiance(e.as_vec3()),
                );
            }
        }
        done += batch.len() as u64;
    }
    done
}

/// Sets the light of one luxel in one style, which the face may not have had.
fn put(maps: &mut Vec<StyleLight>, style: u16, luxels: usize, luxel: usize, light: Irradiance) {
    if let Some(map) = maps.iter_mut().find(|m| m.style == style) {
        map.irradiance[luxel] = light;
    } else if light != Irradiance::ZERO {
        let mut irradiance = vec![Irradiance::ZERO; luxels];
        irradiance[luxel] = light;
        maps.push(StyleLight { style, irradiance });
    }
}

/// Luxels by how much their light differs from the mean of their neighbours, most first.
fn most_varied(
    sources: Sources<'_>,
    samples: &[Vec<Sample>],
    maps: &[Vec<StyleLight>],
) -> Vec<(usize, usize)> {
    let mut found: Vec<(f32, usize, usize)> = samples
        .par_iter()
        .enumerate()
        .flat_map_iter(|(face, samples)| {
            let surface = &sources.scene.surfaces[face];
            let width = surface.luxels.as_ref().map_or(1, |g| g.width as usize);
            let level = |i: usize| -> f32 {
                maps[face].iter().map(|m| m.irradiance[i].0.element_sum()).sum()
            };
            // Luxels of sheets have light of their other side too.
            let wanted = !surface.light_ignore && surface.diffuse.is_none();
            let free = (0..samples.len()).filter(move |&i| wanted && !samples[i].occluded);
            free.map(move |i| {
                let (x, y) = (i % width, i / width);
                let around = [
                    (x > 0).then(|| i - 1),
                    (x + 1 < width).then_some(i + 1),
                    (y > 0).then(|| i - width),
                    Some(i + width).filter(|&j| j < samples.len()),
                ];
                let around = around.into_iter().flatten().filter(|&j| !samples[j].occluded);
                let (sum, count) = around.fold((0.0, 0), |(s, n), j| (s + level(j), n + 1));
                let varied = (level(i) - sum / count.max(1) as f32).abs();
                (varied, face, i)
            })
            .collect::<Vec<_>>()
        })
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    found.into_iter().map(|(_, face, luxel)| (face, luxel)).collect()
}
