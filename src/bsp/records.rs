//! The records of a BSP file, widened to what the largest format holds.

use glam::{Vec3, Vec4};

/// Which of the three Quake containers a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// The original format, version 29: 16-bit indices.
    Bsp29,
    /// `BSP2`: 32-bit indices, float bounds.
    Bsp2,
    /// `2PSB`, also called RMQ: 32-bit indices, 16-bit bounds.
    TwoPsb,
}

/// A plane: points with `normal . p = dist`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal.
    pub normal: Vec3,
    /// Distance from the origin, in world units.
    pub dist: f32,
    /// 0, 1, 2: the normal is that axis; 3 and up: it is not axial.
    pub kind: i32,
}

/// A BSP node. Child `c >= 0` is node `c`; `c < 0` is leaf `-1 - c`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Index of the splitting plane.
    pub plane: u32,
    /// Front and back child.
    pub children: [i32; 2],
}

/// How a texture lies on faces, and which texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexInfo {
    /// Texel column = `s.xyz . p + s.w`.
    pub s: Vec4,
    /// Texel row = `t.xyz . p + t.w`.
    pub t: Vec4,
    /// Index into the texture lump; out of range means "no texture".
    pub miptex: i32,
    /// Bit 0 is `TEX_SPECIAL`: no lightmap.
    pub flags: i32,
}

/// A face. Vertices run clockwise seen from the front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Index of the plane.
    pub plane: u32,
    /// Nonzero: the face looks against its plane's normal.
    pub side: i32,
    /// First surfedge.
    pub first_edge: u32,
    /// Number of surfedges.
    pub edge_count: u32,
    /// Index of the texinfo; out of range means an unlit face.
    pub texinfo: i32,
    /// Light style of each stored lightmap; 255 ends the list.
    pub styles: [u8; 4],
    /// Byte offset of the first lightmap in the lighting lump; -1 is none.
    pub light_offset: i32,
}

/// A leaf of the BSP tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    /// -1 empty, -2 solid, -3 water, -4 slime, -5 lava, -6 sky.
    pub contents: i32,
    /// Offset of the visibility row, -1 is none.
    pub vis_offset: i32,
    /// First entry in the marksurface list.
    pub first_mark: u32,
    /// Number of marksurfaces.
    pub mark_count: u32,
}

/// A brush model; 0 is the world, `*N` names model N in entities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Bounding box.
    pub mins: Vec3,
    /// Bounding box.
    pub maxs: Vec3,
    /// Root of hull 0 (a node, or a leaf when negative as in [`Node`]).
    pub head_node: i32,
    /// Number of leafs that the visibility rows cover.
    pub vis_leafs: u32,
    /// First face.
    pub first_face: u32,
    /// Number of faces.
    pub face_count: u32,
}
