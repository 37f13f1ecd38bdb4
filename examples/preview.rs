//! Draws a lit map: `preview MAP.bsp OUT.png [x y z pitch yaw]`. The `.lit` beside the map is used if
//! there is one. Without a camera, the view is the player's at the start.

use qrad::bsp::{Bsp, parse_entities, read_lit};
use qrad::render::{Camera, LitMap, start_camera};
use std::path::PathBuf;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (paths, camera) = arguments.split_at(arguments.len().min(2));
    let [map, picture] = paths else {
        anyhow::bail!("usage: preview MAP.bsp OUT.png [x y z pitch yaw]");
    };
    let map = PathBuf::from(map);
    let bsp = Bsp::read(&std::fs::read(&map)?)?;
    let lit = std::fs::read(map.with_extension("lit")).ok();
    let rgb = lit.map(|file| read_lit(&file)).transpose()?;
    let start = std::time::Instant::now();
    let lit_map = LitMap::new(&bsp, rgb.as_deref(), &[])?;
    let camera: Vec<f64> = camera.iter().map(|word| word.parse()).collect::<Result<_, _>>()?;
    let (eye, pitch, yaw) = match camera[..] {
        [x, y, z, pitch, yaw] => (glam::DVec3::new(x, y, z), pitch, yaw),
        _ => start_camera(&parse_entities(&bsp.entities)?)
            .map_or((lit_map.middle().as_dvec3(), 0.0, 0.0), |(eye, pitch, yaw)| {
                (eye.as_dvec3(), pitch, yaw)
            }),
    };
    let camera = Camera::quake(eye, pitch, yaw, Camera::QUAKE_FOV, [1024, 768])?;
    let image = lit_map.draw(&camera);
    eprintln!("{:?}", start.elapsed());
    image.save(picture)?;
    Ok(())
}
