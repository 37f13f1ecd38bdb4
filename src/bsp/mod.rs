//! The file formats: BSP29, BSP2 and 2PSB, BSPX, `.lit`, entity text, miptextures, WAD2, the palette
//! and face extents. Nothing here knows about lighting.
//!
//! Reading never panics: every index is checked once, here, so that the rest may index freely.
//! Writing keeps every lump that was not changed byte for byte.

mod bspx;
mod cursor;
mod decode;
mod encode;
mod file;
mod header;
mod miptex;
mod records;
mod validate;

pub use bspx::{BspxLump, LIGHTING_LUMPS};
pub use file::Bsp;
pub use miptex::MipTex;
pub use records::{Face, Format, Leaf, Model, Node, Plane, TexInfo};
