//! Puts finished lightmaps into the map and into a `.lit` file, as the outputs ask.

use crate::bsp::{Bsp, BspxLump, write_hdr_lit, write_lit};
use crate::lightmap::{Block, Packed};
use crate::outputs::{LitFile, Outputs};

/// What ends a list of styles.
const NO_STYLE: u8 = 255;
/// Styles that the record of a face holds.
const RECORD_STYLES: usize = 4;

/// Replaces the lighting of `bsp`. Returns the bytes of the `.lit` file, if there is to be one.
pub(crate) fn store(bsp: &mut Bsp, packed: &Packed, outputs: &Outputs) -> Option<Vec<u8>> {
    let Packed { mono, rgb, hdr, faces, blocks, coloured } = packed;
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
    store_blocks(bsp, blocks);
    match outputs.lit {
        LitFile::Hdr => Some(write_hdr_lit(hdr)),
        _ => outputs.rgb_file(*coloured).then(|| write_lit(rgb)),
    }
}

/// Writes what the face records cannot tell of their lightmaps.
fn store_blocks(bsp: &mut Bsp, blocks: &[Block]) {
    let most = blocks.iter().map(|b| b.styles.len()).max().unwrap_or(0);
    if most > RECORD_STYLES {
        let styles = blocks.iter().flat_map(|block| {
            block.styles.iter().copied().chain(std::iter::repeat(NO_STYLE)).take(most)
        });
        let styles = styles.collect();
        put(bsp, "LMSTYLE", styles);
    }
    if blocks.iter().zip(&bsp.faces).any(|(block, face)| block.offset != face.light_offset) {
        let offsets = blocks.iter().flat_map(|b| b.offset.to_le_bytes()).collect();
        put(bsp, "LMOFFSET", offsets);
    }
}

/// Adds or replaces a lump.
fn put(bsp: &mut Bsp, name: &str, data: Vec<u8>) {
    match bsp.bspx.iter_mut().find(|lump| lump.name == name) {
        Some(lump) => lump.data = data,
        None => bsp.bspx.push(BspxLump { name: name.into(), data }),
    }
}
