//! `qrad` lights Quake maps and plain scenes of quads with hemicube radiosity.

pub mod bsp;
pub mod error;
pub mod patch;
pub mod photometry;
pub mod render;
pub mod scene;

pub use error::{Error, Result};
