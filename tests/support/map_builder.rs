//! Small maps without qbsp: a box room seen from inside, with free-standing boxes in it.

use glam::{Vec3, Vec4};
use qrad::bsp::{Bsp, BspxLump, Face, Format, Leaf, MipTex, Model, Node, Plane, TexInfo};
use std::collections::HashMap;

const EMPTY: i32 = -1;
const SOLID: i32 = -2;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Box3 {
    mins: Vec3,
    maxs: Vec3,
}

/// Builds a map: textures first, then what uses them by index.
///
/// Texture placement is axial with one texel a unit and no shift, so luxels lie on multiples of 16.
pub struct MapBuilder {
    room: Box3,
    room_textures: [usize; 6],
    pillars: Vec<(Box3, usize)>,
    /// Pillars with solid leafs of their own.
    fences: Vec<Box3>,
    liquids: Vec<(Box3, usize)>,
    /// Brush models: their box and, unless they are all `skip`, its texture.
    models: Vec<(Box3, Option<usize>)>,
    textures: Vec<(MipTex, i32)>,
    cell: Option<f32>,
    entities: Vec<u8>,
    bspx: Vec<BspxLump>,
}

impl MapBuilder {
    /// A room between two corners. Its sides have the first texture.
    pub fn room(mins: [f32; 3], maxs: [f32; 3]) -> Self {
        Self {
            room: Box3 { mins: mins.into(), maxs: maxs.into() },
            room_textures: [0; 6],
            pillars: Vec::new(),
            fences: Vec::new(),
            liquids: Vec::new(),
            models: Vec::new(),
            textures: Vec::new(),
            cell: None,
            entities: b"{\n\"classname\" \"worldspawn\"\n}\n".to_vec(),
            bspx: Vec::new(),
        }
    }

    /// Adds a 16 x 16 texture of one palette index.
    pub fn solid_texture(self, name: &str, index: u8) -> Self {
        self.texture(name, 16, 16, vec![index; 256])
    }

    /// Adds a 32 x 16 texture of random palette indices, the same for the same seed.
    pub fn random_texture(self, name: &str, seed: u64) -> Self {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        let mut next = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 32) as u8
        };
        let pixels = (0..512).map(|_| next()).collect();
        self.texture(name, 32, 16, pixels)
    }

    /// Adds a texture of given palette indices.
    pub fn texture(mut self, name: &str, width: u32, height: u32, pixels: Vec<u8>) -> Self {
        let texture = MipTex { name: name.to_owned(), width, height, pixels: Some(pixels) };
        self.textures.push((texture, 0));
        self
    }

    /// Sets the texinfo flags of the texture added last; 1 is `TEX_SPECIAL` (no lightmap).
    pub fn flags(mut self, flags: i32) -> Self {
        self.textures.last_mut().expect("a texture was added").1 = flags;
        self
    }

    /// Textures of the room's sides: low x, high x, low y, high y, floor, ceiling.
    pub fn room_textures(mut self, textures: [usize; 6]) -> Self {
        self.room_textures = textures;
        self
    }

    /// Adds a solid box inside the room; it may touch the room's sides, but no other box.
    pub fn pillar(mut self, mins: [f32; 3], maxs: [f32; 3], texture: usize) -> Self {
        self.pillars.push((Box3 { mins: mins.into(), maxs: maxs.into() }, texture));
        self
    }

    /// Adds a pillar whose inside is a leaf of its own, natively solid, as those of detail fences are.
    pub fn fence(mut self, mins: [f32; 3], maxs: [f32; 3], texture: usize) -> Self {
        self.fences.push(Box3 { mins: mins.into(), maxs: maxs.into() });
        self.pillar(mins, maxs, texture)
    }

    /// Adds a box of faces of the world that look outwards, with nothing solid inside.
    pub fn liquid(mut self, mins: [f32; 3], maxs: [f32; 3], texture: usize) -> Self {
        self.liquids.push((Box3 { mins: mins.into(), maxs: maxs.into() }, texture));
        self
    }

    /// Adds a brush model, a solid box; the first is `*1`. Without a texture it has no faces, as if it
    /// were made of `skip`.
    pub fn model(mut self, mins: [f32; 3], maxs: [f32; 3], texture: Option<usize>) -> Self {
        self.models.push((Box3 { mins: mins.into(), maxs: maxs.into() }, texture));
        self
    }

    /// Splits every face into quads of at most this side.
    pub fn subdivide(mut self, cell: f32) -> Self {
        self.cell = Some(cell);
        self
    }

    /// Replaces the entity text (without the final NUL).
    pub fn entities(mut self, text: impl AsRef<[u8]>) -> Self {
        self.entities = text.as_ref().to_vec();
        self
    }

    /// Adds a BSPX lump.
    pub fn bspx(mut self, name: &str, data: &[u8]) -> Self {
        self.bspx.push(BspxLump { name: name.to_owned(), data: data.to_vec() });
        self
    }

    /// The map.
    pub fn build(&self, format: Format) -> Bsp {
        let mut work = Work {
            bsp: Bsp::empty(format),
            vertices: HashMap::new(),
            edges: HashMap::new(),
            texinfos: HashMap::new(),
            flags: self.textures.iter().map(|&(_, flags)| flags).collect(),
            rects: Vec::new(),
            fences: self.fences.clone(),
        };
        let bsp = &mut work.bsp;
        bsp.textures = self.textures.iter().map(|(texture, _)| Some(texture.clone())).collect();
        bsp.entities = [&self.entities[..], &[0]].concat();
        bsp.bspx = self.bspx.clone();
        bsp.edges.push([0, 0]);
        bsp.leafs.push(Leaf { contents: SOLID, vis_offset: -1, first_mark: 0, mark_count: 0 });

        for side in 0..6 {
            // The room's low sides look up, its high sides down.
            work.side(self.room, side, side % 2 == 0, self.room_textures[side], self.cell);
        }
        for &(pillar, texture) in &self.pillars {
            for side in (0..6).filter(|&side| !on_side(self.room, pillar, side)) {
                work.side(pillar, side, side % 2 == 1, texture, self.cell);
            }
        }
        for &(area, texture) in &self.liquids {
            for side in 0..6 {
                work.side(area, side, side % 2 == 1, texture, self.cell);
            }
        }
        let boxes: Vec<Box3> = self.pillars.iter().map(|&(pillar, _)| pillar).collect();
        let root = work.outside_in(self.room, 0, self.room, &boxes);
        work.model(self.room, root, 0);
        for &(area, texture) in &self.models {
            let first = work.bsp.faces.len();
            for side in 0..6 {
                if let Some(texture) = texture {
                    work.side(area, side, side % 2 == 1, texture, self.cell);
                }
            }
            let root = work.inside_out(area, 0);
            work.model(area, root, first);
        }
        work.bsp.assemble().expect("the builder makes valid maps")
    }
}

/// Coordinate of a box's side: low x, high x, low y, ...
fn coordinate(of: Box3, side: usize) -> f32 {
    if side.is_multiple_of(2) { of.mins[side / 2] } else { of.maxs[side / 2] }
}

fn on_side(outer: Box3, inner: Box3, side: usize) -> bool {
    coordinate(outer, side) == coordinate(inner, side)
}

/// A face before it becomes records: flat box, axis, looking up the axis or down.
#[derive(Clone, Copy)]
struct Rect {
    area: Box3,
    axis: usize,
    up: bool,
}

struct Work {
    bsp: Bsp,
    vertices: HashMap<[u32; 3], u32>,
    edges: HashMap<(u32, u32), i32>,
    texinfos: HashMap<(usize, usize), i32>,
    flags: Vec<i32>,
    rects: Vec<Rect>,
    fences: Vec<Box3>,
}

impl Work {
    fn side(&mut self, of: Box3, side: usize, up: bool, texture: usize, cell: Option<f32>) {
        let axis = side / 2;
        let mut flat = of;
        flat.mins[axis] = coordinate(of, side);
        flat.maxs[axis] = coordinate(of, side);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for (u0, u1) in cuts(of.mins[u], of.maxs[u], cell) {
            for (v0, v1) in cuts(of.mins[v], of.maxs[v], cell) {
                let mut area = flat;
                (area.mins[u], area.maxs[u]) = (u0, u1);
                (area.mins[v], area.maxs[v]) = (v0, v1);
                self.face(Rect { area, axis, up }, texture);
            }
        }
    }

    fn face(&mut self, rect: Rect, texture: usize) {
        let Rect { area, axis, up } = rect;
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let corner = |high_u: bool, high_v: bool| {
            let mut p = area.mins;
            p[u] = if high_u { area.maxs[u] } else { p[u] };
            p[v] = if high_v { area.maxs[v] } else { p[v] };
            p
        };
        let mut corners = [(false, false), (true, false), (true, true), (false, true)];
        if up {
            // u x v is the axis: the order above is counter-clockwise seen from up the axis.
            corners.reverse();
        }
        let indices = corners.map(|(high_u, high_v)| self.vertex(corner(high_u, high_v)));
        let first_edge = self.bsp.surfedges.len() as u32;
        for corner in 0..4 {
            self.surfedge(indices[corner], indices[(corner + 1) % 4]);
        }
        let plane = self.plane(axis, area.mins[axis]);
        let texinfo = self.texinfo(axis, texture);
        self.bsp.faces.push(Face {
            plane,
            side: i32::from(!up),
            first_edge,
            edge_count: 4,
            texinfo,
            styles: [255; 4],
            light_offset: -1,
        });
        self.rects.push(rect);
    }

    fn vertex(&mut self, p: Vec3) -> u32 {
        let vertices = &mut self.bsp.vertices;
        *self.vertices.entry(p.to_array().map(f32::to_bits)).or_insert_with(|| {
            vertices.push(p);
            vertices.len() as u32 - 1
        })
    }

    /// Uses the edge of an earlier face backwards where there is one, as compilers do.
    fn surfedge(&mut self, from: u32, to: u32) {
        let surfedge = self.edges.remove(&(to, from)).map_or_else(
            || {
                self.bsp.edges.push([from, to]);
                let edge = self.bsp.edges.len() as i32 - 1;
                self.edges.insert((from, to), edge);
                edge
            },
            |edge| -edge,
        );
        self.bsp.surfedges.push(surfedge);
    }

    fn plane(&mut self, axis: usize, dist: f32) -> u32 {
        let plane = Plane { normal: Vec3::AXES[axis], dist, kind: axis as i32 };
        let planes = &mut self.bsp.planes;
        let place = planes.iter().position(|&known| known == plane).unwrap_or_else(|| {
            planes.push(plane);
            planes.len() - 1
        });
        place as u32
    }

    fn texinfo(&mut self, axis: usize, texture: usize) -> i32 {
        let (s, t) = [(Vec4::Y, -Vec4::Z), (Vec4::X, -Vec4::Z), (Vec4::X, -Vec4::Y)][axis];
        let texinfos = &mut self.bsp.texinfos;
        let flags = self.flags[texture];
        *self.texinfos.entry((axis, texture)).or_insert_with(|| {
            texinfos.push(TexInfo { s, t, miptex: texture as i32, flags });
            texinfos.len() as i32 - 1
        })
    }

    /// A model whose faces are those from `first` on.
    fn model(&mut self, area: Box3, head_node: i32, first: usize) {
        let bsp = &mut self.bsp;
        let vis_leafs = bsp.models.first().map_or(bsp.leafs.len() as u32 - 1, |_| 0);
        bsp.models.push(Model {
            mins: area.mins,
            maxs: area.maxs,
            head_node,
            vis_leafs,
            first_face: first as u32,
            face_count: (bsp.faces.len() - first) as u32,
        });
    }

    /// Tree of a solid box in empty space.
    fn inside_out(&mut self, area: Box3, side: usize) -> i32 {
        if side == 6 {
            return -1;
        }
        let node = self.node(side / 2, coordinate(area, side));
        let inner = self.inside_out(area, side + 1);
        self.bsp.leafs.push(Leaf { contents: EMPTY, vis_offset: -1, first_mark: 0, mark_count: 0 });
        let outside = -(self.bsp.leafs.len() as i32);
        let front_is_inner = side.is_multiple_of(2);
        let children = if front_is_inner { [inner, outside] } else { [outside, inner] };
        self.bsp.nodes[node].children = children;
        node as i32
    }

    /// Tree that cuts away what is outside of `room`, side by side; the rest is [`Self::inside`].
    fn outside_in(&mut self, room: Box3, side: usize, region: Box3, pillars: &[Box3]) -> i32 {
        if side == 6 {
            return self.inside(region, pillars);
        }
        let node = self.node(side / 2, coordinate(room, side));
        let inner = self.outside_in(room, side + 1, region, pillars);
        let front_is_inner = side.is_multiple_of(2);
        self.bsp.nodes[node].children = if front_is_inner { [inner, -1] } else { [-1, inner] };
        node as i32
    }

    /// Tree of a part of the room with the pillars that reach into it.
    fn inside(&mut self, region: Box3, pillars: &[Box3]) -> i32 {
        let pillars: Vec<Box3> = pillars
            .iter()
            .copied()
            .filter(|p| p.mins.cmplt(region.maxs).all() && region.mins.cmplt(p.maxs).all())
            .collect();
        let Some(&first) = pillars.first() else { return self.empty_leaf(region) };
        for side in 0..6 {
            let (axis, at) = (side / 2, coordinate(first, side));
            if region.mins[axis] < at && at < region.maxs[axis] {
                let (mut front, mut back) = (region, region);
                front.mins[axis] = at;
                back.maxs[axis] = at;
                let node = self.node(axis, at);
                let children = [self.inside(front, &pillars), self.inside(back, &pillars)];
                self.bsp.nodes[node].children = children;
                return node as i32;
            }
        }
        if self.fences.contains(&first) {
            let (contents, vis_offset, first_mark, mark_count) = (SOLID, -1, 0, 0);
            self.bsp.leafs.push(Leaf { contents, vis_offset, first_mark, mark_count });
            return -(self.bsp.leafs.len() as i32);
        }
        -1
    }

    fn node(&mut self, axis: usize, at: f32) -> usize {
        let plane = self.plane(axis, at);
        self.bsp.nodes.push(Node { plane, children: [-1, -1] });
        self.bsp.nodes.len() - 1
    }

    fn empty_leaf(&mut self, region: Box3) -> i32 {
        let first_mark = self.bsp.marksurfaces.len() as u32;
        for (index, rect) in self.rects.iter().enumerate() {
            let (axis, at) = (rect.axis, rect.area.mins[rect.axis]);
            let touches = at == if rect.up { region.mins[axis] } else { region.maxs[axis] };
            let overlaps = (0..3).filter(|&other| other != axis).all(|other| {
                rect.area.mins[other] < region.maxs[other]
                    && region.mins[other] < rect.area.maxs[other]
            });
            if touches && overlaps {
                self.bsp.marksurfaces.push(index as u32);
            }
        }
        let mark_count = self.bsp.marksurfaces.len() as u32 - first_mark;
        self.bsp.leafs.push(Leaf { contents: EMPTY, vis_offset: -1, first_mark, mark_count });
        -(self.bsp.leafs.len() as i32)
    }
}

/// Splits `low..high` into stretches of at most `cell`.
fn cuts(low: f32, high: f32, cell: Option<f32>) -> Vec<(f32, f32)> {
    let Some(cell) = cell else { return vec![(low, high)] };
    let count = ((high - low) / cell).ceil().max(1.0) as u32;
    let at = |i: u32| if i == count { high } else { low + cell * i as f32 };
    (0..count).map(|i| (at(i), at(i + 1))).collect()
}
