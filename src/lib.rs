//! `qrad` lights Quake maps and plain scenes of quads with hemicube radiosity.

pub mod bsp;
pub mod error;
pub mod light;
pub mod photometry;
pub mod scene;

pub use error::{Error, Result};
