//! Direct light as stored luxels, by the shortest way through contract sections 2.7, 3.3 and 3.6.
//! Only for comparing direct light with the reference; the program's own way is the lightmap room.

use glam::Vec3;
use qrad::light::{DirectLight, direct};
use qrad::scene::{Sample, Scene, luxels};
use rayon::prelude::*;

/// The stored luxels of one style of a face.
pub struct StyleMap {
    pub style: u8,
    pub rgb: Vec<[u8; 3]>,
}

/// Lights every face: its maps in stored order, and which of its luxels are occluded.
pub fn bake(scene: &Scene) -> Vec<(Vec<StyleMap>, Vec<Sample>)> {
    (0..scene.surfaces.len())
        .into_par_iter()
        .map(|surface| {
            let samples = luxels::place(scene, surface, 1);
            let light = direct(scene, surface, &samples);
            (maps(scene, surface, &samples, &light), samples)
        })
        .collect()
}

fn maps(scene: &Scene, surface: usize, samples: &[Sample], light: &DirectLight) -> Vec<StyleMap> {
    let Some(grid) = &scene.surfaces[surface].luxels else { return Vec::new() };
    let width = grid.width as usize;
    let mut kept: Vec<(f32, u8, Vec<Vec3>)> = Vec::new();
    for map in light.styles.iter().filter(|m| m.style <= 255) {
        let negative = light.negative.iter().find(|n| n.style == map.style);
        let colours: Vec<Vec3> = map
            .irradiance
            .iter()
            .enumerate()
            .map(|(i, e)| {
                let total = *e + negative.map_or(Default::default(), |n| n.irradiance[i]);
                total.0.max(Vec3::ZERO) * scene.world.range
            })
            .collect();
        let mean = |c: &Vec3| (c.x + c.y + c.z) / 3.0;
        if colours.iter().map(mean).fold(0.0, f32::max) < 1.0 {
            continue;
        }
        let average = colours.iter().map(mean).sum::<f32>() / colours.len() as f32;
        kept.push((average, map.style as u8, colours));
    }
    kept.reverse();
    kept.sort_by(|a, b| b.0.total_cmp(&a.0));
    kept.truncate(4);
    kept.into_iter()
        .map(|(_, style, mut colours)| {
            let seen = samples.iter().map(|s| !s.occluded).collect();
            fill(&mut colours, seen, width);
            StyleMap { style, rgb: colours.into_iter().map(store).collect() }
        })
        .collect()
}

/// Fills occluded luxels from their neighbours, scan by scan, in place.
fn fill(colours: &mut [Vec3], mut seen: Vec<bool>, width: usize) {
    let height = colours.len() / width;
    while seen.iter().any(|s| *s) && !seen.iter().all(|s| *s) {
        for y in 0..height {
            for x in 0..width {
                if seen[y * width + x] {
                    continue;
                }
                let (mut sum, mut count) = (Vec3::ZERO, 0);
                for v in y.saturating_sub(1)..(y + 2).min(height) {
                    for u in x.saturating_sub(1)..(x + 2).min(width) {
                        if seen[v * width + u] {
                            sum += colours[v * width + u];
                            count += 1;
                        }
                    }
                }
                if count > 0 {
                    colours[y * width + x] = sum / count as f32;
                    seen[y * width + x] = true;
                }
            }
        }
    }
}

fn store(c: Vec3) -> [u8; 3] {
    let most = c.max_element();
    let c = if most > 255.0 { c * (255.0 / most) } else { c };
    c.to_array().map(|v| v as u8)
}
