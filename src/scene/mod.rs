//! What light needs of a map: surfaces with materials, the ray tracer, the lights and the luxels.

mod surface;
mod tracer;

pub use surface::{LuxelGrid, Role, Surface};
pub use tracer::{Hit, Node, Polygon, Tracer};
