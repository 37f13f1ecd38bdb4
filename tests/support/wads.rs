//! Texture files of our own making.

/// A WAD with one texture, "outer", of `width` x `height` texels of index 7.
pub fn wad(width: u32, height: u32) -> Vec<u8> {
    let mut file = b"WAD2\x01\0\0\0".to_vec();
    let size = 40 + width * height;
    file.extend((12 + size).to_le_bytes());
    file.extend(b"inner\0\0\0\0\0\0\0\0\0\0\0");
    for number in [width, height, 40, 0, 0, 0] {
        file.extend(number.to_le_bytes());
    }
    file.resize(12 + size as usize, 7);
    for number in [12, size, size, 0x44] {
        file.extend(number.to_le_bytes());
    }
    file.extend(b"Outer\0\0\0\0\0\0\0\0\0\0\0");
    file
}
