//! Pictures of lightmaps: one PNG a light style, and a table of where each face is.

use super::{FinishedFace, FinishedStyle};
use crate::light::StyleLight;
use crate::{Error, Result, output};
use etagere::{AtlasAllocator, size2};
use glam::Vec3;
use image::{Rgb, RgbImage};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Luxels of space around each lightmap, so that pictures can be told apart.
const GAP: u32 = 1;

/// Writes `style_N.png` for each style and `index.csv` (`face,style,x,y,width,height`, in luxels)
/// into `folder`, which is made if needed. `sizes` holds width and height of each face's lightmap.
/// Returns the files written.
///
/// # Errors
/// When the folder or a file cannot be written.
pub fn dump(folder: &Path, faces: &[FinishedFace], sizes: &[[u32; 2]]) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(folder).map_err(Error::io("make folder", folder))?;
    let (pictures, index) = atlases(faces, sizes);
    let mut written = Vec::new();
    for (style, picture) in &pictures {
        let path = folder.join(format!("style_{style}.png"));
        output::write_png(&path, picture)?;
        written.push(path);
    }
    let path = folder.join("index.csv");
    output::write(&path, index.as_bytes())?;
    written.push(path);
    Ok(written)
}

/// The lightmaps as pictures, one a style, and a table of where each face is in them: the lines of
/// `index.csv` that [`dump`] writes. `sizes` holds width and height of each face's lightmap.
pub fn atlases(faces: &[FinishedFace], sizes: &[[u32; 2]]) -> (Vec<(u16, RgbImage)>, String) {
    let mut styles: BTreeMap<u16, Vec<(usize, &FinishedStyle)>> = BTreeMap::new();
    for (face, finished) in faces.iter().enumerate() {
        for map in &finished.styles {
            styles.entry(map.style).or_default().push((face, map));
        }
    }
    let mut index = String::from("face,style,x,y,width,height\n");
    let picture = |(style, maps): (u16, Vec<(usize, &FinishedStyle)>)| {
        let rects: Vec<[u32; 2]> = maps.iter().map(|&(face, _)| sizes[face]).collect();
        let (places, size) = arrange(&rects);
        let mut picture = RgbImage::new(size[0], size[1]);
        for ((&(face, map), [w, h]), [x, y]) in maps.iter().zip(rects).zip(places) {
            for (i, level) in map.levels.iter().enumerate() {
                picture.put_pixel(x + i as u32 % w, y + i as u32 / w, Rgb(*level));
            }
            let _ = writeln!(index, "{face},{style},{x},{y},{w},{h}");
        }
        (style, picture)
    };
    (styles.into_iter().map(picture).collect(), index)
}

/// Light at the luxels of each face, all styles added up, as a picture: levels as bright as they are
/// stored, four times over, since bounced light is dim. Faces have the same place for the same `sizes`.
pub fn atlas_of_light(maps: &[Vec<StyleLight>], sizes: &[[u32; 2]]) -> RgbImage {
    let (places, size) = arrange(sizes);
    let mut picture = RgbImage::new(size[0], size[1]);
    for ((maps, &[w, h]), [x, y]) in maps.iter().zip(sizes).zip(places) {
        for i in 0..w * h {
            let light: Vec3 = maps.iter().map(|m| m.irradiance[i as usize].0).sum();
            let level = (light * 2.0).to_array().map(|v| v as u8);
            picture.put_pixel(x + i % w, y + i / w, Rgb(level));
        }
    }
    picture
}

/// Places rectangles in a picture of about square shape; returns their corners and its size.
fn arrange(rects: &[[u32; 2]]) -> (Vec<[u32; 2]>, [u32; 2]) {
    let area: u64 = rects.iter().map(|[w, h]| u64::from(w + GAP) * u64::from(h + GAP)).sum();
    let widest = rects.iter().flatten().copied().max().unwrap_or(1) + GAP;
    let mut edge = ((area as f64).sqrt() as u32).max(widest).next_multiple_of(64);
    // Tall ones first: shelves waste less.
    let mut order: Vec<usize> = (0..rects.len()).collect();
    order.sort_by_key(|&i| std::cmp::Reverse(rects[i][1]));
    loop {
        let mut atlas = AtlasAllocator::new(size2(edge as i32, edge as i32));
        let mut places = vec![[0; 2]; rects.len()];
        let fits = order.iter().all(|&i| {
            let size = size2((rects[i][0] + GAP) as i32, (rects[i][1] + GAP) as i32);
            atlas.allocate(size).is_some_and(|a| {
                places[i] = [a.rectangle.min.x as u32, a.rectangle.min.y as u32];
                true
            })
        });
        if fits {
            return (places, [edge, edge]);
        }
        edge += (edge / 8).max(64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_do_not_overlap_and_stay_inside() {
        let rects: Vec<[u32; 2]> = (0..300).map(|i| [1 + i * 7 % 18, 1 + i * 5 % 17]).collect();
        let (places, [w, h]) = arrange(&rects);
        let mut taken = vec![false; (w * h) as usize];
        for ([rw, rh], [x, y]) in rects.iter().zip(&places) {
            for v in *y..y + rh {
                for u in *x..x + rw {
                    assert!(u < w && v < h);
                    let cell = &mut taken[(v * w + u) as usize];
                    assert!(!*cell);
                    *cell = true;
                }
            }
        }
    }
}
