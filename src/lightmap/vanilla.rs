//! Lightmaps at the luxel size that a texture gives, for engines that know no other, made from those
//! at the size that the map asks for.

use super::{FinishedFace, FinishedStyle, Vanilla};
use crate::scene::{LuxelGrid, Scene, Surface};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// What the record of each face is to tell of its lightmaps. Without `wanted`, nothing is made for
/// faces whose luxels differ.
pub fn vanilla_copies(scene: &Scene, faces: &[FinishedFace], wanted: bool) -> Vec<Vanilla> {
    let copy = |(surface, face): (&Surface, &FinishedFace)| match (
        &surface.luxels,
        &surface.vanilla_luxels,
    ) {
        (Some(from), Some(to)) if wanted => {
            let copy = |map: &FinishedStyle| {
                let mut copy = FinishedStyle::new(map.style, resample(&map.light, from, to));
                if !map.directions.is_empty() {
                    copy.directions = resample(&map.directions, from, to);
                }
                copy
            };
            Vanilla::Copy(face.styles.iter().map(copy).collect())
        }
        (_, None) if !scene.decoupled => Vanilla::Same,
        _ => Vanilla::Absent,
    };
    scene.surfaces.par_iter().zip(faces).map(copy).collect()
}

/// The light at the luxels `to`, between those of `from` that lie around them.
fn resample(light: &[Vec3], from: &LuxelGrid, to: &LuxelGrid) -> Vec<Vec3> {
    let last = [from.width - 1, from.height - 1];
    let mut result = Vec::with_capacity(to.len());
    for t in 0..to.height {
        for s in 0..to.width {
            let place = from.luxel_of(to.world_of(Vec2::new(s as f32, t as f32)));
            let along = |side: usize| {
                let at = place[side].clamp(0.0, last[side] as f32);
                let low = at.floor() as u32;
                (low, (low + 1).min(last[side]), at - low as f32)
            };
            let ((x0, x1, fx), (y0, y1, fy)) = (along(0), along(1));
            let luxel = |x: u32, y: u32| light[(y * from.width + x) as usize];
            let row = |y: u32| luxel(x0, y).lerp(luxel(x1, y), fx);
            result.push(row(y0).lerp(row(y1), fy));
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4;

    fn grid(step: f32, size: [u32; 2]) -> LuxelGrid {
        LuxelGrid {
            width: size[0],
            height: size[1],
            s_row: Vec4::new(1.0 / step, 0.0, 0.0, 0.0),
            t_row: Vec4::new(0.0, 1.0 / step, 0.0, 0.0),
            origin: Vec3::ZERO,
            s_step: Vec3::X * step,
            t_step: Vec3::Y * step,
        }
    }

    #[test]
    fn linear_light_survives_every_change_of_size() {
        let light = |grid: &LuxelGrid| -> Vec<Vec3> {
            (0..grid.len() as u32)
                .map(|i| {
                    let luxel = Vec2::new((i % grid.width) as f32, (i / grid.width) as f32);
                    Vec3::splat(grid.world_of(luxel).dot(Vec3::new(1.0, 3.0, 0.0)) + 7.0)
                })
                .collect()
        };
        let sizes = [grid(4.0, [17, 9]), grid(16.0, [5, 3]), grid(32.0, [3, 2])];
        for (from, to) in sizes.iter().flat_map(|from| sizes.iter().map(move |to| (from, to))) {
            assert_eq!(resample(&light(from), from, to), light(to));
        }
    }

    #[test]
    fn luxels_beyond_the_others_take_the_nearest() {
        let (from, to) = (grid(4.0, [2, 2]), grid(16.0, [2, 2]));
        let light = [1.0, 2.0, 3.0, 4.0].map(Vec3::splat);
        assert_eq!(resample(&light, &from, &to), light);
    }
}
