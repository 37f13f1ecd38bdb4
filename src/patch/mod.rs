//! What exchanges light: patches, and the text format of scenes that are plain lists of them.

mod text_check;
mod text_lines;
mod text_scene;

pub use text_check::{MAX_HEMICUBE, MAX_IMAGE, MAX_REFLECTANCE};
pub use text_lines::decode;
pub use text_scene::{CameraSpec, Quad, Reading, Repair, TextScene};
