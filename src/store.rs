//! Puts finished lightmaps into the map and into a `.lit` file, as the outputs ask.

use crate::bsp::{
    Bsp, BspxLump, LitFace, pack_direction, write_face_normals, write_hdr_lit, write_lit,
    write_lit2,
};
use crate::lightmap::{Block, FinishedFace, LAST_BYTE_STYLE, Packed, hdr_colour};
use crate::outputs::{DirectionFile, LitFile, Outputs};
use crate::scene::{Scene, Surface};
use crate::{Error, Result};
use glam::Vec3;

/// What ends a list of styles.
const NO_STYLE: u8 = 255;
/// Styles that the record of a face holds.
const RECORD_STYLES: usize = 4;
/// Bytes a face in `DECOUPLED_LM`.
const DECOUPLED_SIZE: usize = 40;

/// What stands beside the map: bytes of files, if they are to be.
#[derive(Debug, Default)]
pub struct Files {
    /// The `.lit` file.
    pub lit: Option<Vec<u8>>,
    /// The file that says where light comes from, of either name.
    pub lux: Option<Vec<u8>>,
}

/// Replaces the lighting of `bsp`.
///
/// # Errors
/// If version 2 of the `.lit` file is asked for luxels that it cannot describe.
pub(crate) fn store(
    bsp: &mut Bsp,
    packed: &Packed,
    scene: &Scene,
    outputs: &Outputs,
) -> Result<Files> {
    let Packed { mono, rgb, hdr, directions, faces, blocks, coloured } = packed;
    let bspx_rgb = outputs.bspx_rgb(*coloured);
    // Engines take the colours instead where the lump is empty.
    let held_elsewhere = bspx_rgb || outputs.bspx_hdr;
    let mono = if outputs.vanilla || !held_elsewhere { mono.clone() } else { Vec::new() };
    bsp.set_lighting(mono, faces);
    if bspx_rgb {
        put(bsp, "RGBLIGHTING", rgb.clone());
    }
    if outputs.bspx_hdr {
        put(bsp, "LIGHTING_E5BGR9", hdr.iter().flat_map(|c| c.to_le_bytes()).collect());
    }
    if outputs.bspx_lux {
        put(bsp, "LIGHTINGDIR", directions.clone());
    }
    if outputs.face_normals {
        let corners = (0..bsp.faces.len()).flat_map(|face| scene.corner_frames(face));
        let lump = write_face_normals(corners);
        put(bsp, "FACENORMALS", lump);
    }
    store_sizes(bsp, blocks, scene, outputs);
    store_styles(bsp, blocks);
    let lux = lux_file(outputs, directions);
    Ok(match outputs.lit {
        LitFile::Version2 if scene.decoupled => {
            let problem = "it cannot describe luxels that do not follow textures; leave out \
                           _world_units_per_luxel";
            return Err(Error::setting("--lit2", problem));
        }
        LitFile::Version2 => {
            let faces = lit_faces(scene, blocks);
            Files { lit: Some(write_lit2(&faces, rgb, directions)), lux: None }
        }
        LitFile::Hdr => Files { lit: Some(write_hdr_lit(hdr)), lux },
        _ => Files { lit: outputs.rgb_file(*coloured).then(|| write_lit(rgb)), lux },
    })
}

/// The file that says where light comes from: it looks like a `.lit` file.
fn lux_file(outputs: &Outputs, directions: &[u8]) -> Option<Vec<u8>> {
    (outputs.lux != DirectionFile::No).then(|| write_lit(directions))
}

/// What version 2 of a `.lit` file says of each face.
fn lit_faces(scene: &Scene, blocks: &[Block]) -> Vec<LitFace> {
    let face = |(block, surface): (&Block, &Surface)| {
        let Some(grid) = &surface.luxels else {
            return LitFace { offset: -1, ..LitFace::default() };
        };
        // Texels a luxel: how much faster the texture runs than the luxels.
        let texels = surface.texture_axes[0].length() / grid.s_row.truncate().length();
        LitFace {
            offset: block.offset,
            styles: block.styles.clone(),
            size: [grid.width, grid.height].map(side),
            shift: (texels.log2() - 1e-3).ceil() as u8,
        }
    };
    blocks.iter().zip(&scene.surfaces).map(face).collect()
}

/// Columns or rows as the formats count them.
fn side(luxels: u32) -> u16 {
    u16::try_from(luxels).expect("a side has at most MAX_LUXELS luxels")
}

/// Writes which luxels the faces have and where, as far as their records cannot tell.
fn store_sizes(bsp: &mut Bsp, blocks: &[Block], scene: &Scene, outputs: &Outputs) {
    if scene.decoupled {
        bsp.bspx.retain(|lump| lump.name != "LMSHIFT");
        let mut decoupled = Vec::with_capacity(blocks.len() * DECOUPLED_SIZE);
        for (block, surface) in blocks.iter().zip(&scene.surfaces) {
            push_decoupled(&mut decoupled, block.offset, surface);
        }
        put(bsp, "DECOUPLED_LM", decoupled);
        return;
    }
    if let Some(shift) = outputs.luxels.shift {
        put(bsp, "LMSHIFT", vec![shift; blocks.len()]);
    }
    if blocks.iter().zip(&bsp.faces).any(|(block, face)| block.offset != face.light_offset) {
        let offsets = blocks.iter().flat_map(|b| b.offset.to_le_bytes()).collect();
        put(bsp, "LMOFFSET", offsets);
    }
}

/// Appends the entry of a face: columns and rows, the place of its lightmaps, and how points of its
/// model become luxel coordinates.
fn push_decoupled(out: &mut Vec<u8>, offset: i32, surface: &Surface) {
    let Some(grid) = &surface.luxels else {
        // No luxels: nothing but zeros and no place.
        let end = out.len() + DECOUPLED_SIZE;
        out.extend_from_slice(&[0; 4]);
        out.extend_from_slice(&(-1_i32).to_le_bytes());
        out.resize(end, 0);
        return;
    };
    out.extend([grid.width, grid.height].into_iter().flat_map(|n| side(n).to_le_bytes()));
    out.extend_from_slice(&offset.to_le_bytes());
    for row in [grid.s_row, grid.t_row] {
        // The rows of the grid are for the world, where the model is moved.
        let w = row.w + row.truncate().dot(surface.offset);
        for number in [row.x, row.y, row.z, w] {
            out.extend_from_slice(&number.to_le_bytes());
        }
    }
}

/// Writes the styles of the faces, if one has more than its record holds or some that it cannot name.
fn store_styles(bsp: &mut Bsp, blocks: &[Block]) {
    let most = blocks.iter().map(|b| b.styles.len()).max().unwrap_or(0);
    let padded = blocks.iter().flat_map(|block| {
        block.styles.iter().copied().chain(std::iter::repeat(u16::MAX)).take(most)
    });
    if blocks.iter().flat_map(|b| &b.styles).any(|&style| style > LAST_BYTE_STYLE) {
        put(bsp, "LMSTYLE16", padded.flat_map(u16::to_le_bytes).collect());
    } else if most > RECORD_STYLES {
        let bytes = padded.map(|style| u8::try_from(style).unwrap_or(NO_STYLE));
        put(bsp, "LMSTYLE", bytes.collect());
    }
}

/// Adds or replaces a lump.
fn put(bsp: &mut Bsp, name: &str, data: Vec<u8>) {
    match bsp.bspx.iter_mut().find(|lump| lump.name == name) {
        Some(lump) => lump.data = data,
        None => bsp.bspx.push(BspxLump { name: name.into(), data }),
    }
}

/// The lighting of a `.lit` file for the lightmaps that `bsp` has.
pub(crate) struct LitOnly {
    /// Three levels for each byte of the lighting lump.
    pub rgb: Vec<u8>,
    /// The files.
    pub files: Files,
}

/// Colours for the lightmaps that `bsp` has, from new ones: zeros for a style that lights a face no more.
///
/// # Errors
/// If the map has no lightmaps, or not those of the luxel size that its textures give.
pub(crate) fn lit_only(
    bsp: &Bsp,
    scene: &Scene,
    faces: &[FinishedFace],
    outputs: &Outputs,
) -> Result<LitOnly> {
    let wrong = |problem: String| Err(Error::format("lighting lump", problem));
    let samples = bsp.lighting.len();
    if samples == 0 {
        return wrong(
            "it is empty, so --litonly has nothing to colour: light the map first".into(),
        );
    }
    if let Some(lump) = bsp.bspx.iter().find(|l| ["LMOFFSET", "DECOUPLED_LM"].contains(&&*l.name)) {
        return wrong(format!(
            "--litonly cannot follow the {} lump: light the map as a whole",
            lump.name
        ));
    }
    let (mut rgb, mut hdr) = (vec![0; 3 * samples], vec![0; samples]);
    let mut directions = pack_direction(Vec3::ZERO).repeat(samples);
    for (index, (record, face)) in bsp.faces.iter().zip(faces).enumerate() {
        let Some(grid) = &scene.surfaces[index].luxels else { continue };
        let Ok(first) = usize::try_from(record.light_offset) else { continue };
        let styles = record.styles.iter().take_while(|&&style| style != NO_STYLE);
        for (slot, style) in styles.enumerate() {
            let begin = first + slot * grid.len();
            let range = begin..begin + grid.len();
            if range.end > samples {
                return wrong(format!(
                    "face {index} has luxels {begin} to {} of {samples}: was the map lit with \
                     another luxel size? Light it as a whole",
                    range.end
                ));
            }
            let Some(map) = face.styles.iter().find(|map| map.style == u16::from(*style)) else {
                continue;
            };
            for ((at, level), light) in range.clone().zip(&map.levels).zip(&map.light) {
                rgb[3 * at..3 * at + 3].copy_from_slice(level);
                hdr[at] = hdr_colour(*light);
            }
            for (at, &direction) in range.zip(&map.directions) {
                directions[3 * at..3 * at + 3].copy_from_slice(&pack_direction(direction));
            }
        }
    }
    let file = if outputs.lit == LitFile::Hdr { write_hdr_lit(&hdr) } else { write_lit(&rgb) };
    let files = Files { lit: Some(file), lux: lux_file(outputs, &directions) };
    Ok(LitOnly { rgb, files })
}
