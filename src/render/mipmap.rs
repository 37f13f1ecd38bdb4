//! Mipmapped pictures and how they are filtered.

/// Channels of a texel: red, green, blue and coverage.
pub(super) type Texel = [u8; 4];

struct Level {
    width: usize,
    height: usize,
    texels: Vec<Texel>,
}

/// A picture that repeats in both directions, with its mips.
pub(super) struct Mipmap {
    levels: Vec<Level>,
}

impl Mipmap {
    /// A picture without mips: it is always filtered from its own texels. Needs `width * height`
    /// texels and at least one.
    pub fn flat(width: usize, height: usize, texels: Vec<Texel>) -> Self {
        assert!(!texels.is_empty() && texels.len() == width * height, "a whole picture");
        Self { levels: vec![Level { width, height, texels }] }
    }

    /// A picture with all its mips, down to one texel. Each is the mean of texel pairs along rows,
    /// then along columns, cut to whole numbers each time as QuakeSpasm does: small mips are a little
    /// darker than the mean.
    pub fn new(width: usize, height: usize, texels: Vec<Texel>) -> Self {
        let mut mipmap = Self::flat(width, height, texels);
        loop {
            let last = &mipmap.levels[mipmap.levels.len() - 1];
            if last.width == 1 && last.height == 1 {
                return mipmap;
            }
            let next = last.halved();
            mipmap.levels.push(next);
        }
    }

    /// Filtered value at (`u`, `v`), where the picture goes from 0 to 1, for a pixel that covers
    /// `footprint` texels of the full picture: bilinear in the two nearest mips and linear between
    /// them. Channels go from 0 to 255.
    pub fn sample(&self, u: f64, v: f64, footprint: f64) -> [f32; 4] {
        let last = self.levels.len() - 1;
        // A footprint that is not a number counts as the largest.
        let level = if footprint <= 1.0 { 0.0 } else { footprint.log2().min(last as f64) };
        let fine = (level.floor() as usize).min(last);
        let part = (level - fine as f64) as f32;
        let near = self.levels[fine].bilinear(u, v);
        if part <= 0.0 || fine == last {
            return near;
        }
        let far = self.levels[fine + 1].bilinear(u, v);
        std::array::from_fn(|i| near[i] + (far[i] - near[i]) * part)
    }

    /// Texels along u and v.
    pub fn size(&self) -> [f64; 2] {
        [self.levels[0].width as f64, self.levels[0].height as f64]
    }
}

impl Level {
    fn halved(&self) -> Self {
        let columns = (self.width / 2).max(1);
        let rows = (self.height / 2).max(1);
        let along_row = |x: usize, y: usize| {
            let at = y * self.width;
            if self.width == 1 {
                return self.texels[at];
            }
            mean(self.texels[at + 2 * x], self.texels[at + 2 * x + 1])
        };
        let mut texels = Vec::with_capacity(columns * rows);
        for y in 0..rows {
            for x in 0..columns {
                texels.push(if self.height == 1 {
                    along_row(x, 0)
                } else {
                    mean(along_row(x, 2 * y), along_row(x, 2 * y + 1))
                });
            }
        }
        Self { width: columns, height: rows, texels }
    }

    fn bilinear(&self, u: f64, v: f64) -> [f32; 4] {
        let (x, fx) = split(u, self.width);
        let (y, fy) = split(v, self.height);
        let (x1, y1) = ((x + 1) % self.width, (y + 1) % self.height);
        let at = |x: usize, y: usize| self.texels[y * self.width + x].map(f32::from);
        let (a, b, c, d) = (at(x, y), at(x1, y), at(x, y1), at(x1, y1));
        std::array::from_fn(|i| {
            let top = a[i] + (b[i] - a[i]) * fx;
            let bottom = c[i] + (d[i] - c[i]) * fx;
            top + (bottom - top) * fy
        })
    }
}

fn mean(a: Texel, b: Texel) -> Texel {
    std::array::from_fn(|i| u16::midpoint(a[i].into(), b[i].into()) as u8)
}

/// The texel before a coordinate, whose middle is at half a texel, and the part of the way to the
/// next. Any number gives a valid texel.
fn split(coordinate: f64, size: usize) -> (usize, f32) {
    let texels = (coordinate - coordinate.floor()) * size as f64 - 0.5;
    let floor = texels.floor();
    ((floor as i64).rem_euclid(size as i64) as usize, (texels - floor) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(level: u8) -> Texel {
        [level, level, level, 255]
    }

    #[test]
    fn texel_middles_are_exact_and_edges_wrap() {
        let map = Mipmap::new(2, 1, vec![grey(0), grey(100)]);
        assert_eq!(map.sample(0.25, 0.5, 1.0), [0.0, 0.0, 0.0, 255.0]);
        assert_eq!(map.sample(-1.25, 7.5, 1.0)[0], 100.0);
        assert_eq!(map.sample(0.5, 0.0, 1.0)[0], 50.0);
        assert_eq!(map.sample(0.0, 0.0, 0.5)[0], 50.0);
    }

    #[test]
    fn footprints_blend_the_mips() {
        let texels = [0, 40, 80, 121].map(grey);
        let map = Mipmap::new(4, 1, texels.to_vec());
        // Mips: (20, 100) with 100.5 cut, then 60.
        assert_eq!(map.sample(0.25, 0.5, 2.0)[0], 20.0);
        assert_eq!(map.sample(0.25, 0.5, 4.0)[0], 60.0);
        assert_eq!(map.sample(0.25, 0.5, 8.0_f64.sqrt())[0], 40.0);
        assert_eq!(map.sample(0.25, 0.5, f64::INFINITY)[0], 60.0);
        assert_eq!(map.sample(0.25, 0.5, f64::NAN)[0], 60.0);
    }

    #[test]
    fn odd_sizes_and_odd_numbers_do_not_panic() {
        let map = Mipmap::new(5, 3, vec![grey(9); 15]);
        for x in [f64::NAN, f64::INFINITY, -1e300, -1e-300, 1.0, 0.999_999_999_999_999_9] {
            for footprint in [0.0, 3.0, 1e9] {
                map.sample(x, x, footprint);
                map.sample(0.5, x, footprint);
            }
        }
        assert_eq!(map.sample(0.3, 0.7, 2.5)[0], 9.0);
    }
}
