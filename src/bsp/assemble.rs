//! Making a BSP from records: for maps that a program generates, such as those of the tests.

use super::decode::record_size;
use super::encode::Record;
use super::file::Bsp;
use super::header::{LUMP_COUNT, Lump};
use super::miptex::{MIPTEX_HEADER, MipTex};
use super::records::{Format, Model, TexInfo};
use crate::{Error, Result};
use glam::Vec3;

impl Bsp {
    /// A BSP without any content, to be filled and then [assembled](Bsp::assemble).
    pub fn empty(format: Format) -> Self {
        Self {
            format,
            planes: Vec::new(),
            vertices: Vec::new(),
            nodes: Vec::new(),
            texinfos: Vec::new(),
            faces: Vec::new(),
            leafs: Vec::new(),
            marksurfaces: Vec::new(),
            edges: Vec::new(),
            surfedges: Vec::new(),
            models: Vec::new(),
            textures: Vec::new(),
            lighting: Vec::new(),
            visibility: Vec::new(),
            entities: Vec::new(),
            bspx: Vec::new(),
            kept: Default::default(),
        }
    }

    /// Encodes every lump from the fields, so that [`Bsp::write`] writes them, and checks them as
    /// [`Bsp::read`] does.
    ///
    /// What the fields do not hold is filled in: nodes and leafs get the bounding box of model 0 and
    /// name no faces of their own, leafs are silent, textures get mips by dropping texels, and there
    /// are no clip hulls.
    ///
    /// # Errors
    /// If an index is invalid, a number does not fit the format or a texture name is too long.
    pub fn assemble(mut self) -> Result<Self> {
        let mut kept: [Vec<u8>; LUMP_COUNT] = Default::default();
        for lump in [
            Lump::Planes,
            Lump::Vertices,
            Lump::Nodes,
            Lump::TexInfos,
            Lump::Leafs,
            Lump::MarkSurfaces,
            Lump::Edges,
            Lump::SurfEdges,
            Lump::Models,
        ] {
            kept[lump as usize] = self.encode(lump)?;
        }
        kept[Lump::Textures as usize] = texture_lump(&self.textures)?;
        self.kept = kept;
        Self::read(&self.write()?)
    }

    fn encode(&self, lump: Lump) -> Result<Vec<u8>> {
        let format = self.format;
        let mut out = Vec::new();
        let count = match lump {
            Lump::Planes => self.planes.len(),
            Lump::Vertices => self.vertices.len(),
            Lump::Nodes => self.nodes.len(),
            Lump::TexInfos => self.texinfos.len(),
            Lump::Leafs => self.leafs.len(),
            Lump::MarkSurfaces => self.marksurfaces.len(),
            Lump::Edges => self.edges.len(),
            Lump::SurfEdges => self.surfedges.len(),
            _ => self.models.len(),
        };
        for index in 0..count {
            let mut record = Record::new(&mut out, lump, index);
            match lump {
                Lump::Planes => {
                    let plane = &self.planes[index];
                    record.vec3(plane.normal);
                    record.f32(plane.dist);
                    record.i32(plane.kind);
                }
                Lump::Vertices => record.vec3(self.vertices[index]),
                Lump::Nodes => self.encode_node(&mut record, index)?,
                Lump::TexInfos => encode_texinfo(&mut record, &self.texinfos[index]),
                Lump::Leafs => {
                    let leaf = &self.leafs[index];
                    record.i32(leaf.contents);
                    record.i32(leaf.vis_offset);
                    self.encode_bounds(&mut record);
                    record.index(format, "first marksurface", leaf.first_mark.into())?;
                    record.index(format, "marksurface count", leaf.mark_count.into())?;
                    record.bytes(&[0; 4]);
                }
                Lump::MarkSurfaces => {
                    record.index(format, "face", self.marksurfaces[index].into())?;
                }
                Lump::Edges => {
                    for vertex in self.edges[index] {
                        record.index(format, "vertex", vertex.into())?;
                    }
                }
                Lump::SurfEdges => record.i32(self.surfedges[index]),
                _ => encode_model(&mut record, &self.models[index])?,
            }
        }
        assert_eq!(Some(out.len()), record_size(format, lump).map(|size| size * count));
        Ok(out)
    }

    fn encode_node(&self, record: &mut Record<'_>, index: usize) -> Result<()> {
        let node = &self.nodes[index];
        record.wide("plane", node.plane)?;
        for child in node.children {
            if self.format != Format::Bsp29 {
                record.i32(child);
            } else if let Ok(child) = i16::try_from(child) {
                record.bytes(&child.to_le_bytes());
            } else {
                return Err(record.too_large("child", child.into(), i16::MAX.into()));
            }
        }
        self.encode_bounds(record);
        record.index(self.format, "first face", 0)?;
        record.index(self.format, "face count", 0)
    }

    /// The bounding box of model 0, or zeros where there is none.
    fn encode_bounds(&self, record: &mut Record<'_>) {
        let (mins, maxs) =
            self.models.first().map_or((Vec3::ZERO, Vec3::ZERO), |m| (m.mins, m.maxs));
        if self.format == Format::Bsp2 {
            record.vec3(mins);
            record.vec3(maxs);
        } else {
            for bound in [mins.floor(), maxs.ceil()].iter().flat_map(Vec3::to_array) {
                record.bytes(&(bound as i16).to_le_bytes());
            }
        }
    }
}

fn encode_texinfo(record: &mut Record<'_>, texinfo: &TexInfo) {
    for axis in [texinfo.s, texinfo.t] {
        record.vec3(axis.truncate());
        record.f32(axis.w);
    }
    record.i32(texinfo.miptex);
    record.i32(texinfo.flags);
}

fn encode_model(record: &mut Record<'_>, model: &Model) -> Result<()> {
    record.vec3(model.mins);
    record.vec3(model.maxs);
    record.vec3(Vec3::ZERO);
    record.i32(model.head_node);
    // Clip hulls: all empty.
    for _ in 0..3 {
        record.i32(-1);
    }
    record.wide("vis leaf count", model.vis_leafs)?;
    record.wide("first face", model.first_face)?;
    record.wide("face count", model.face_count)
}

fn texture_lump(textures: &[Option<MipTex>]) -> Result<Vec<u8>> {
    let table = 4 + 4 * textures.len();
    let mut lump = vec![0; table];
    lump[..4].copy_from_slice(&(textures.len() as u32).to_le_bytes());
    for (index, texture) in textures.iter().enumerate() {
        let mut offset = -1;
        if let Some(texture) = texture {
            lump.resize(lump.len().next_multiple_of(4), 0);
            offset = i32::try_from(lump.len()).map_err(|_| {
                Error::format("textures lump", "the textures pass 2 GiB: use fewer or smaller ones")
            })?;
            push_texture(&mut lump, texture)?;
        }
        lump[4 + 4 * index..8 + 4 * index].copy_from_slice(&offset.to_le_bytes());
    }
    Ok(lump)
}

fn push_texture(lump: &mut Vec<u8>, texture: &MipTex) -> Result<()> {
    let MipTex { name, width, height, pixels } = texture;
    let (columns, rows) = (*width as usize, *height as usize);
    let fits = |pixels: &Vec<u8>| columns.checked_mul(rows) == Some(pixels.len());
    if name.len() > 15 || pixels.as_ref().is_some_and(|pixels| !fits(pixels)) {
        let problem = "a name has at most 15 bytes, and pixels are width times height";
        return Err(Error::format(format!("texture {name}"), problem));
    }
    let mut header = name.clone().into_bytes();
    header.resize(16, 0);
    header.extend_from_slice(&width.to_le_bytes());
    header.extend_from_slice(&height.to_le_bytes());
    let mut mips = Vec::new();
    for level in 0..4 {
        let offset = pixels.as_ref().map_or(0, |_| MIPTEX_HEADER + mips.len());
        header.extend_from_slice(&(offset as u32).to_le_bytes());
        let Some(pixels) = pixels.as_ref().filter(|pixels| !pixels.is_empty()) else { continue };
        for row in pixels.chunks_exact(columns).step_by(1 << level).take(rows >> level) {
            mips.extend(row.iter().step_by(1 << level).take(columns >> level));
        }
    }
    lump.extend_from_slice(&header);
    lump.extend_from_slice(&mips);
    Ok(())
}
