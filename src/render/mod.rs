//! Pictures: the camera, flat-shaded drawing of patches, lit maps and the window.

mod camera;
mod draw_patches;
mod drawn_faces;
mod fog;
mod lightmaps;
mod lit_map;
mod mipmap;
mod sky;
mod start_camera;
mod styles;
mod texture;
#[cfg(feature = "window")]
mod window;

pub use camera::Camera;
pub use draw_patches::{MAX_PIXELS, draw_patches};
pub use lit_map::LitMap;
pub use start_camera::start_camera;
#[cfg(feature = "window")]
pub use window::show;
