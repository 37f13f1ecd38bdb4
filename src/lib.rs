//! `qrad` lights Quake maps and plain scenes of quads with hemicube radiosity.
pub mod bsp;
pub mod error;
pub mod output;
pub mod photometry;
pub mod patch;
pub mod progress;
pub mod radiosity;
pub mod render;
pub mod report;
pub mod scene;
pub use error::{Error, Result};
