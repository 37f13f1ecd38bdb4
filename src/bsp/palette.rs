//! The default Quake palette.

use glam::{DVec3, Vec3};

/// Palette index that is see-through in fences, and left out of averages everywhere.
pub const TRANSPARENT: u8 = 255;
/// Palette indices that engines show at full brightness, whatever the light.
pub const FULLBRIGHTS: std::ops::Range<u8> = 224..TRANSPARENT;

const fn rgb(hex: u32) -> [u8; 3] {
    let [_, r, g, b] = hex.to_be_bytes();
    [r, g, b]
}

/// Red, green and blue of each palette index, 0 to 255 (the table of `gfx/palette.lmp`).
#[rustfmt::skip]
pub const PALETTE: [[u8; 3]; 256] = [
    rgb(0x000000), rgb(0x0F0F0F), rgb(0x1F1F1F), rgb(0x2F2F2F), rgb(0x3F3F3F), rgb(0x4B4B4B), rgb(0x5B5B5B), rgb(0x6B6B6B),
    rgb(0x7B7B7B), rgb(0x8B8B8B), rgb(0x9B9B9B), rgb(0xABABAB), rgb(0xBBBBBB), rgb(0xCBCBCB), rgb(0xDBDBDB), rgb(0xEBEBEB),
    rgb(0x0F0B07), rgb(0x170F0B), rgb(0x1F170B), rgb(0x271B0F), rgb(0x2F2313), rgb(0x372B17), rgb(0x3F2F17), rgb(0x4B371B),
    rgb(0x533B1B), rgb(0x5B431F), rgb(0x634B1F), rgb(0x6B531F), rgb(0x73571F), rgb(0x7B5F23), rgb(0x836723), rgb(0x8F6F23),
    rgb(0x0B0B0F), rgb(0x13131B), rgb(0x1B1B27), rgb(0x272733), rgb(0x2F2F3F), rgb(0x37374B), rgb(0x3F3F57), rgb(0x474767),
    rgb(0x4F4F73), rgb(0x5B5B7F), rgb(0x63638B), rgb(0x6B6B97), rgb(0x7373A3), rgb(0x7B7BAF), rgb(0x8383BB), rgb(0x8B8BCB),
    rgb(0x000000), rgb(0x070700), rgb(0x0B0B00), rgb(0x131300), rgb(0x1B1B00), rgb(0x232300), rgb(0x2B2B07), rgb(0x2F2F07),
    rgb(0x373707), rgb(0x3F3F07), rgb(0x474707), rgb(0x4B4B0B), rgb(0x53530B), rgb(0x5B5B0B), rgb(0x63630B), rgb(0x6B6B0F),
    rgb(0x070000), rgb(0x0F0000), rgb(0x170000), rgb(0x1F0000), rgb(0x270000), rgb(0x2F0000), rgb(0x370000), rgb(0x3F0000),
    rgb(0x470000), rgb(0x4F0000), rgb(0x570000), rgb(0x5F0000), rgb(0x670000), rgb(0x6F0000), rgb(0x770000), rgb(0x7F0000),
    rgb(0x131300), rgb(0x1B1B00), rgb(0x232300), rgb(0x2F2B00), rgb(0x372F00), rgb(0x433700), rgb(0x4B3B07), rgb(0x574307),
    rgb(0x5F4707), rgb(0x6B4B0B), rgb(0x77530F), rgb(0x835713), rgb(0x8B5B13), rgb(0x975F1B), rgb(0xA3631F), rgb(0xAF6723),
    rgb(0x231307), rgb(0x2F170B), rgb(0x3B1F0F), rgb(0x4B2313), rgb(0x572B17), rgb(0x632F1F), rgb(0x733723), rgb(0x7F3B2B),
    rgb(0x8F4333), rgb(0x9F4F33), rgb(0xAF632F), rgb(0xBF772F), rgb(0xCF8F2B), rgb(0xDFAB27), rgb(0xEFCB1F), rgb(0xFFF31B),
    rgb(0x0B0700), rgb(0x1B1300), rgb(0x2B230F), rgb(0x372B13), rgb(0x47331B), rgb(0x533723), rgb(0x633F2B), rgb(0x6F4733),
    rgb(0x7F533F), rgb(0x8B5F47), rgb(0x9B6B53), rgb(0xA77B5F), rgb(0xB7876B), rgb(0xC3937B), rgb(0xD3A38B), rgb(0xE3B397),
    rgb(0xAB8BA3), rgb(0x9F7F97), rgb(0x937387), rgb(0x8B677B), rgb(0x7F5B6F), rgb(0x775363), rgb(0x6B4B57), rgb(0x5F3F4B),
    rgb(0x573743), rgb(0x4B2F37), rgb(0x43272F), rgb(0x371F23), rgb(0x2B171B), rgb(0x231313), rgb(0x170B0B), rgb(0x0F0707),
    rgb(0xBB739F), rgb(0xAF6B8F), rgb(0xA35F83), rgb(0x975777), rgb(0x8B4F6B), rgb(0x7F4B5F), rgb(0x734353), rgb(0x6B3B4B),
    rgb(0x5F333F), rgb(0x532B37), rgb(0x47232B), rgb(0x3B1F23), rgb(0x2F171B), rgb(0x231313), rgb(0x170B0B), rgb(0x0F0707),
    rgb(0xDBC3BB), rgb(0xCBB3A7), rgb(0xBFA39B), rgb(0xAF978B), rgb(0xA3877B), rgb(0x977B6F), rgb(0x876F5F), rgb(0x7B6353),
    rgb(0x6B5747), rgb(0x5F4B3B), rgb(0x533F33), rgb(0x433327), rgb(0x372B1F), rgb(0x271F17), rgb(0x1B130F), rgb(0x0F0B07),
    rgb(0x6F837B), rgb(0x677B6F), rgb(0x5F7367), rgb(0x576B5F), rgb(0x4F6357), rgb(0x475B4F), rgb(0x3F5347), rgb(0x374B3F),
    rgb(0x2F4337), rgb(0x2B3B2F), rgb(0x233327), rgb(0x1F2B1F), rgb(0x172317), rgb(0x0F1B13), rgb(0x0B130B), rgb(0x070B07),
    rgb(0xFFF31B), rgb(0xEFDF17), rgb(0xDBCB13), rgb(0xCBB70F), rgb(0xBBA70F), rgb(0xAB970B), rgb(0x9B8307), rgb(0x8B7307),
    rgb(0x7B6307), rgb(0x6B5300), rgb(0x5B4700), rgb(0x4B3700), rgb(0x3B2B00), rgb(0x2B1F00), rgb(0x1B0F00), rgb(0x0B0700),
    rgb(0x0000FF), rgb(0x0B0BEF), rgb(0x1313DF), rgb(0x1B1BCF), rgb(0x2323BF), rgb(0x2B2BAF), rgb(0x2F2F9F), rgb(0x2F2F8F),
    rgb(0x2F2F7F), rgb(0x2F2F6F), rgb(0x2F2F5F), rgb(0x2B2B4F), rgb(0x23233F), rgb(0x1B1B2F), rgb(0x13131F), rgb(0x0B0B0F),
    rgb(0x2B0000), rgb(0x3B0000), rgb(0x4B0700), rgb(0x5F0700), rgb(0x6F0F00), rgb(0x7F1707), rgb(0x931F07), rgb(0xA3270B),
    rgb(0xB7330F), rgb(0xC34B1B), rgb(0xCF632B), rgb(0xDB7F3B), rgb(0xE3974F), rgb(0xE7AB5F), rgb(0xEFBF77), rgb(0xF7D38B),
    rgb(0xA77B3B), rgb(0xB79B37), rgb(0xC7C337), rgb(0xE7E357), rgb(0x7FBFFF), rgb(0xABE7FF), rgb(0xD7FFFF), rgb(0x670000),
    rgb(0x8B0000), rgb(0xB30000), rgb(0xD70000), rgb(0xFF0000), rgb(0xFFF393), rgb(0xFFF7C7), rgb(0xFFFFFF), rgb(0x9F5B53),
];

/// Mean colour of texels (palette indices) per channel, in [0, 1] linear units: the arithmetic mean of
/// the palette's values / 255, without gamma, over all texels except [`TRANSPARENT`]. `None` if there
/// are no such texels.
pub fn average_colour(pixels: &[u8]) -> Option<Vec3> {
    let mut count = [0_u64; 256];
    for &pixel in pixels {
        count[usize::from(pixel)] += 1;
    }
    count[usize::from(TRANSPARENT)] = 0;
    let total: u64 = count.iter().sum();
    if total == 0 {
        return None;
    }
    let colours = PALETTE.iter().zip(count);
    let sum: DVec3 =
        colours.map(|(&[r, g, b], n)| DVec3::new(r.into(), g.into(), b.into()) * n as f64).sum();
    Some((sum / (total as f64 * 255.0)).as_vec3())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn palette_has_the_published_check_values() {
        let sum: u32 = PALETTE.iter().flatten().map(|&byte| u32::from(byte)).sum();
        assert_eq!(sum, 60061);
        assert_eq!(PALETTE[0], [0, 0, 0]);
        assert_eq!(PALETTE[15], [0xEB; 3]);
        assert_eq!(PALETTE[208], [0, 0, 255]);
        assert_eq!(PALETTE[251], [255, 0, 0]);
        assert_eq!(PALETTE[254], [255; 3]);
        assert_eq!(PALETTE[255], [0x9F, 0x5B, 0x53]);
    }

    #[test]
    fn average_leaves_out_index_255_and_does_not_truncate() {
        assert_eq!(average_colour(&[]), None);
        assert_eq!(average_colour(&[255, 255]), None);
        assert_eq!(average_colour(&[254, 255]), Some(Vec3::ONE));
        // One third of 255 / 255, one third of 15 / 255: neither is a whole byte.
        let mean = average_colour(&[251, 1, 0]).unwrap();
        assert_eq!(
            mean,
            Vec3::new((270.0 / 765.0) as f32, (15.0 / 765.0) as f32, (15.0 / 765.0) as f32)
        );
    }
}
