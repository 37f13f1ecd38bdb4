//! From patches back to luxels: indirect light, the stored levels, packing and pictures of them.

mod ambient;
mod atlas;
mod debug;
mod directions;
mod faces;
mod finish;
mod indirect;
mod interpolate;
mod light_grid;
mod overlooked;
mod pack;
mod probes;
mod refine;
mod vanilla;

pub(crate) use ambient::ambient;
pub use atlas::{atlas_of_light, atlases, dump};
pub use debug::{DebugSources, DebugView, debug_faces};
pub use directions::add_bounced_directions;
pub use faces::finish_faces;
pub use finish::{
    FinishSettings, FinishedFace, FinishedStyle, LAST_BYTE_STYLE, Smoothing, StyleChoice, finish,
};
pub(crate) use indirect::indirect_while;
pub use indirect::{Gather, GatherSettings, Sources, indirect};
pub use light_grid::{GridSources, light_grid};
pub use pack::{Block, Packed, Vanilla, hdr_colour, pack};
pub use probes::{probe_hemicubes, probes};
pub use refine::refine;
pub use vanilla::vanilla_copies;
