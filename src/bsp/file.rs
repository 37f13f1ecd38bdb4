//! A BSP file in memory: reading, looking up, writing.

use super::bspx::{self, BspxLump};
use super::header::{self, HEADER_SIZE, Header, LUMP_COUNT, Lump};
use super::miptex::{self, MipTex};
use super::records::{Face, Format, Leaf, Model, Node, Plane, TexInfo};
use super::switchable::{StyleRange, rewrite_entities};
use super::{decode, encode, validate};
use crate::Result;
use glam::Vec3;

/// A BSP file. Every index between its records is valid (see [`Bsp::read`]).
///
/// [`Bsp::write`] writes `faces`, `lighting`, `visibility`, `entities` and `bspx` as they are here, and
/// every other lump as it was read: changes to the other fields are not written.
#[derive(Clone, Debug, PartialEq)]
pub struct Bsp {
    /// Which container the file is, and will be written as.
    pub format: Format,
    /// Planes of faces and nodes. All numbers are finite.
    pub planes: Vec<Plane>,
    /// Points, in world units. All are finite.
    pub vertices: Vec<Vec3>,
    /// Nodes of all models' hull 0. They form trees at most 4096 deep.
    pub nodes: Vec<Node>,
    /// Texture placements.
    pub texinfos: Vec<TexInfo>,
    /// Faces of all models.
    pub faces: Vec<Face>,
    /// Leafs; leaf 0 is the shared solid one.
    pub leafs: Vec<Leaf>,
    /// Face indices, named by the leafs.
    pub marksurfaces: Vec<u32>,
    /// Pairs of vertices.
    pub edges: Vec<[u32; 2]>,
    /// Edges of the faces; negative is edge `-e` walked backwards.
    pub surfedges: Vec<i32>,
    /// Brush models, at least one; model 0 is the world.
    pub models: Vec<Model>,
    /// The texture lump. `None`: the slot says that the texture is absent (offset -1).
    pub textures: Vec<Option<MipTex>>,
    /// Lightmaps, one byte a luxel. Those of `faces` begin inside it when it is read, unless a BSPX
    /// lump says where they are.
    pub lighting: Vec<u8>,
    /// Run-length coded visibility rows. Offsets in `leafs` are not checked against it.
    pub visibility: Vec<u8>,
    /// Entity text with its final NUL.
    pub entities: Vec<u8>,
    /// Lumps of the BSPX extension, in file order.
    pub bspx: Vec<BspxLump>,
    /// Bytes of the lumps that are written back as they were; empty for those with a field above.
    pub(super) kept: [Vec<u8>; LUMP_COUNT],
}

impl Bsp {
    /// Reads a BSP29, BSP2 or 2PSB file and checks all indices between lumps.
    ///
    /// Faces may have a texinfo out of range (they stay unlit), texinfos a miptexture out of range.
    ///
    /// # Errors
    /// `Unsupported` for other games' BSPs; `Format` with lump, index and numbers for a damaged file;
    /// `Limit` for a node tree deeper than 4096.
    pub fn read(file: &[u8]) -> Result<Self> {
        let header = Header::read(file)?;
        let format = header.format;
        let lump = |lump| header.lump(lump);
        let mut kept: [Vec<u8>; LUMP_COUNT] = Default::default();
        for name in Lump::PHYSICAL_ORDER {
            if is_kept(name) {
                kept[name as usize] = lump(name).to_vec();
            }
        }
        let bsp = Self {
            format,
            planes: decode::planes(format, lump(Lump::Planes))?,
            vertices: decode::vertices(format, lump(Lump::Vertices))?,
            nodes: decode::nodes(format, lump(Lump::Nodes))?,
            texinfos: decode::texinfos(format, lump(Lump::TexInfos))?,
            faces: decode::faces(format, lump(Lump::Faces))?,
            leafs: decode::leafs(format, lump(Lump::Leafs))?,
            marksurfaces: decode::mark_surfaces(format, lump(Lump::MarkSurfaces))?,
            edges: decode::edges(format, lump(Lump::Edges))?,
            surfedges: decode::surf_edges(format, lump(Lump::SurfEdges))?,
            models: decode::models(format, lump(Lump::Models))?,
            textures: miptex::read_lump(lump(Lump::Textures))?,
            lighting: lump(Lump::Lighting).to_vec(),
            visibility: lump(Lump::Visibility).to_vec(),
            entities: lump(Lump::Entities).to_vec(),
            bspx: bspx::read(file, header.end),
            kept,
        };
        decode::check_size(format, Lump::ClipNodes, lump(Lump::ClipNodes))?;
        validate::validate(&bsp)?;
        header.check_overlaps()?;
        Ok(bsp)
    }

    /// Bytes of the file: lumps in the order compilers use, each padded to 4 bytes, then BSPX.
    ///
    /// # Errors
    /// If a face field does not fit the format, a BSPX name is unusable or the file would pass 2 GiB.
    pub fn write(&self) -> Result<Vec<u8>> {
        let faces = encode::faces(self.format, &self.faces)?;
        let mut file = vec![0; HEADER_SIZE];
        file[..4].copy_from_slice(&header::ident(self.format));
        for lump in Lump::PHYSICAL_ORDER {
            let bytes = match lump {
                Lump::Faces => &faces,
                Lump::Lighting => &self.lighting,
                Lump::Visibility => &self.visibility,
                Lump::Entities => &self.entities,
                _ => &self.kept[lump as usize],
            };
            let mut entry = Vec::with_capacity(8);
            bspx::push_u32(&mut entry, file.len())?;
            bspx::push_u32(&mut entry, bytes.len())?;
            let at = 4 + 8 * lump as usize;
            file[at..at + 8].copy_from_slice(&entry);
            file.extend_from_slice(bytes);
            file.resize(file.len().next_multiple_of(4), 0);
        }
        bspx::append(&mut file, &self.bspx)?;
        Ok(file)
    }

    /// Vertex indices of a face in order, clockwise seen from its front.
    ///
    /// # Panics
    /// If there is no face `face`.
    pub fn face_vertex_indices(&self, face: usize) -> impl ExactSizeIterator<Item = u32> + '_ {
        let Face { first_edge, edge_count, .. } = self.faces[face];
        let range = first_edge as usize..first_edge as usize + edge_count as usize;
        let surfedges = if edge_count == 0 { &[][..] } else { &self.surfedges[range] };
        surfedges.iter().map(|&edge| {
            let [start, end] = self.edges[edge.unsigned_abs() as usize];
            if edge < 0 { end } else { start }
        })
    }

    /// Vertices of a face in order, clockwise seen from its front, in the model's coordinates.
    ///
    /// # Panics
    /// If there is no face `face`.
    pub fn face_vertices(&self, face: usize) -> impl ExactSizeIterator<Item = Vec3> + '_ {
        self.face_vertex_indices(face).map(|vertex| self.vertices[vertex as usize])
    }

    /// Plane of a face, its normal on the face's front side. A negated plane is never of an axial kind.
    ///
    /// # Panics
    /// If there is no face `face`.
    pub fn face_plane(&self, face: usize) -> Plane {
        let Face { plane, side, .. } = self.faces[face];
        let plane = self.planes[plane as usize];
        if side == 0 {
            return plane;
        }
        let kind = if (0..3).contains(&plane.kind) { plane.kind + 3 } else { plane.kind };
        Plane { normal: -plane.normal, dist: -plane.dist, kind }
    }

    /// Texture placement of a face; `None` if its texinfo is out of range.
    ///
    /// # Panics
    /// If there is no face `face`.
    pub fn texinfo_of(&self, face: usize) -> Option<&TexInfo> {
        self.texinfos.get(usize::try_from(self.faces[face].texinfo).ok()?)
    }

    /// Texture of a face; `None` if it has no valid texinfo or its texture is absent.
    ///
    /// # Panics
    /// If there is no face `face`.
    pub fn texture_of(&self, face: usize) -> Option<&MipTex> {
        let miptex = usize::try_from(self.texinfo_of(face)?.miptex).ok()?;
        self.textures.get(miptex)?.as_ref()
    }

    /// Stores lightmaps: the lighting lump, and for each face its offset there (-1 is none) and styles.
    ///
    /// # Panics
    /// If there is not one entry for each face.
    pub fn set_lighting(&mut self, lighting: Vec<u8>, faces: &[(i32, [u8; 4])]) {
        assert_eq!(faces.len(), self.faces.len(), "one entry a face");
        self.lighting = lighting;
        for (face, &(offset, styles)) in self.faces.iter_mut().zip(faces) {
            face.light_offset = offset;
            face.styles = styles;
        }
    }

    /// Makes the changes to the entity lump that a light compiler makes ([`super::normalise`]). If
    /// there are none, it stays byte for byte.
    ///
    /// # Errors
    /// When the entity text is damaged or needs too many switchable styles.
    pub fn rewrite_entities(&mut self, styles: StyleRange) -> Result<()> {
        if let (_, Some(lump)) = rewrite_entities(&self.entities, styles)? {
            self.entities = lump;
        }
        Ok(())
    }

    /// Removes all lighting, as before the first lighting of the map: no lightmaps, every face unlit,
    /// and no BSPX lump that depends on them.
    pub fn clear_lighting(&mut self) {
        self.lighting.clear();
        for face in &mut self.faces {
            face.styles = [255; 4];
            face.light_offset = -1;
        }
        self.bspx.retain(|lump| !bspx::LIGHTING_LUMPS.contains(&lump.name.as_str()));
    }
}

/// Whether a lump is written back from the bytes read.
fn is_kept(lump: Lump) -> bool {
    !matches!(lump, Lump::Faces | Lump::Lighting | Lump::Visibility | Lump::Entities)
}
