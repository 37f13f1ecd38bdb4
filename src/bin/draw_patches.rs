//! Command line of `draw_patches`.

use clap::Parser;
use qrad::output::write_png;
use qrad::patch::{MAX_IMAGE, TextScene, decode};
use qrad::render::{Camera, draw_patches};
use qrad::{Error, Result};
use std::path::PathBuf;
use std::process::ExitCode;

/// Draws a patch scene, lit or not, in flat colours from the camera in its header.
///
/// A lit scene (the output of `qrad --patches`) shows its final light, a scene that is not lit yet
/// shows its own colours at full brightness. Without -o the picture opens in a window; Escape
/// closes it.
#[derive(Parser)]
#[command(name = "draw_patches", version)]
#[command(after_help = "Examples:\n  draw_patches cornell-lit.txt\n  \
    draw_patches cornell-lit.txt -o cornell.png --size 512x512")]
struct Arguments {
    /// The scene, a text file (see docs/cornell-format.md)
    #[arg(value_name = "SCENE.txt")]
    scene: PathBuf,

    /// Write the picture to this PNG file instead of opening a window
    #[arg(short, long, value_name = "OUT.png")]
    output: Option<PathBuf>,

    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEG", default_value_t = Camera::TEXT_SCENE_FOV)]
    fov: f64,

    /// Multiply all light by this before it is drawn; a box lit by a small light wants 20 or so
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = parse_exposure)]
    exposure: f64,

    /// Picture size in pixels [default: as in the scene's header]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
}

fn parse_size(text: &str) -> std::result::Result<[u32; 2], String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=MAX_IMAGE).contains(side));
    text.split_once('x')
        .and_then(|(w, h)| Some([side(w)?, side(h)?]))
        .ok_or_else(|| format!("write it as 640x480, each side from 1 to {MAX_IMAGE}"))
}

fn parse_exposure(text: &str) -> std::result::Result<f64, String> {
    let factor = text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0);
    factor.ok_or_else(|| "write a number above 0".into())
}

fn main() -> ExitCode {
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("warn"))
        .format_timestamp(None)
        .format_target(false)
        .init();
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("draw_patches: {e}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let path = &arguments.scene;
    let name = path.display().to_string();
    let bytes = std::fs::read(path).map_err(Error::io("read", path))?;
    let scene = TextScene::parse_lit(decode(&bytes, &name)?, &name)?;
    let size = arguments.size.unwrap_or(scene.image);
    let camera = Camera::look_at(&scene.camera, arguments.fov, size)?;
    let image = draw_patches(&scene.patches, &camera, arguments.exposure)?;
    match &arguments.output {
        Some(output) => write_png(output, &image),
        None => show(&image, &name),
    }
}

#[cfg(feature = "window")]
use qrad::render::show;

#[cfg(not(feature = "window"))]
fn show(_: &image::RgbImage, _: &str) -> Result<()> {
    Err(Error::Unsupported(
        "this build opens no window: use -o picture.png to write a picture instead".into(),
    ))
}
