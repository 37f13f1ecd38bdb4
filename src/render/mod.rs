//! Pictures: the camera, flat-shaded drawing of patches, lit maps and the window.

mod camera;
mod draw_patches;
#[cfg(feature = "window")]
mod window;

pub use camera::Camera;
pub use draw_patches::{MAX_PIXELS, draw_patches};
#[cfg(feature = "window")]
pub use window::show;
