//! The file formats: BSP29, BSP2 and 2PSB, BSPX, light grids, `.lit`, entity text, miptextures, WAD2,
//! the palette and face extents. Nothing here knows about lighting.
//!
//! Reading never panics: every index is checked once, here, so that the rest may index freely.
//! Writing keeps every lump that was not changed byte for byte.

mod assemble;
mod bspx;
mod cursor;
mod decode;
mod direction;
mod e5bgr9;
mod encode;
mod entities;
mod extents;
mod face_normals;
mod file;
mod header;
mod light_grid;
mod lit;
mod lit2;
mod miptex;
mod palette;
mod records;
mod switchable;
mod validate;
mod wad;

pub use bspx::{BspxLump, LIGHTING_LUMPS};
pub use direction::pack_direction;
pub use e5bgr9::{E5BGR9_MAX, pack_e5bgr9, unpack_e5bgr9};
pub use entities::{Entity, parse_entities, write_entities};
pub use extents::{Extents, MAX_LUXELS, extents};
pub use face_normals::write_face_normals;
pub use file::Bsp;
pub use light_grid::{GridPlace, GridPoint, GridStyle, octree_lump, sides_lump};
pub use lit::{read_hdr_lit, read_lit, write_hdr_lit, write_lit};
pub use lit2::{LitFace, write_lit2};
pub use miptex::MipTex;
pub use palette::{FULLBRIGHTS, PALETTE, TRANSPARENT, average_colour};
pub use records::{Face, Format, Leaf, Model, Node, Plane, TexInfo};
pub use switchable::{StyleRange, normalise, rewrite_entities};
pub use wad::{find_texture, load_wad};
