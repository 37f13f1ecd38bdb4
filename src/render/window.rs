//! A window that shows a picture.

use crate::{Error, Result};
use image::RgbImage;
use minifb::{Key, ScaleMode, Window, WindowOptions};

/// Shows `image` in a window of its size until Escape is pressed or the window is closed. Resizing
/// the window scales the picture.
///
/// # Errors
/// [`Error::Unsupported`] if there is no display to open a window on.
pub fn show(image: &RgbImage, title: &str) -> Result<()> {
    if !display_is_named() {
        return Err(no_display(""));
    }
    let (width, height) = (image.width() as usize, image.height() as usize);
    let pixels: Vec<u32> =
        image.pixels().map(|p| u32::from_be_bytes([0, p.0[0], p.0[1], p.0[2]])).collect();
    let options = WindowOptions {
        resize: true,
        scale_mode: ScaleMode::AspectRatioStretch,
        ..WindowOptions::default()
    };
    let failed = |e: minifb::Error| no_display(&format!(" ({e})"));
    let mut window = Window::new(title, width, height, options).map_err(failed)?;
    window.set_target_fps(30);
    while window.is_open() && !window.is_key_down(Key::Escape) {
        window.update_with_buffer(&pixels, width, height).map_err(failed)?;
    }
    Ok(())
}

/// Windows are opened through X11 on these systems, so there must be an X display (under Wayland,
/// Xwayland names one).
#[cfg(all(unix, not(target_os = "macos")))]
fn display_is_named() -> bool {
    std::env::var_os("DISPLAY").is_some_and(|name| !name.is_empty())
}

#[cfg(not(all(unix, not(target_os = "macos"))))]
fn display_is_named() -> bool {
    true
}

fn no_display(detail: &str) -> Error {
    let detail = detail.replace('\n', " ");
    Error::Unsupported(format!("no display: use -o picture.png to write a picture instead{detail}"))
}
