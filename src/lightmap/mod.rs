//! From patches back to luxels: indirect light, the stored levels, packing and pictures of them.

mod atlas;
mod faces;
mod finish;
mod indirect;
mod interpolate;
mod pack;
mod probes;
mod vanilla;

pub use atlas::dump;
pub use faces::finish_faces;
pub use finish::{FinishSettings, FinishedFace, FinishedStyle, Smoothing, StyleChoice, finish};
pub use indirect::{Gather, GatherSettings, Sources, indirect};
pub use pack::{Block, Packed, Vanilla, hdr_colour, pack};
pub use probes::probes;
pub use vanilla::vanilla_copies;
