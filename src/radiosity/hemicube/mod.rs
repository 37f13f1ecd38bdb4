//! The hemicube (Cohen and Greenberg, "The hemi-cube: a radiosity solution for complex environments",
//! 1985): half a cube around a point of a surface, its five sides cut into cells. Each cell has a
//! delta form factor and holds the polygon that the point sees through it.

mod clip;
mod frame;
mod item_buffer;
mod lanes;
mod outline;
mod side;

pub use item_buffer::{Cells, ItemBuffer};

use super::form_factor::{parallel_corner, rectangle, sphere_corner, upright_corner};
use crate::{Error, Result};
use glam::{Vec2, Vec3};

/// Number of cells: the top is `width` x `height`, each of the four sides `width` x `height / 2`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HemicubeSize {
    width: u32,
    height: u32,
}

impl HemicubeSize {
    /// Both numbers are even, from 2 to 4096.
    pub fn new(width: u32, height: u32) -> Result<Self> {
        let fits = |n: u32| n.is_multiple_of(2) && (2..=4096).contains(&n);
        if fits(width) && fits(height) {
            Ok(Self { width, height })
        } else {
            let problem = format!("{width} x {height}: use even numbers from 2 to 4096");
            Err(Error::setting("hemicube", problem))
        }
    }

    /// Columns of the top and of each side.
    pub fn width(self) -> u32 {
        self.width
    }

    /// Rows of the top; the sides have half as many.
    pub fn height(self) -> u32 {
        self.height
    }

    /// A quarter as many cells along each edge, but not fewer than 32 where there were more: for
    /// patches with several hemicubes.
    pub(crate) fn coarser(self) -> Self {
        let part = |n: u32| (n / 8 * 2).max(n.min(32));
        Self { width: part(self.width), height: part(self.height) }
    }

    /// Half as many cells along each edge, but not fewer than 8 where there were more: where little
    /// depends on a hemicube.
    pub(crate) fn halved(self) -> Self {
        let part = |n: u32| (n / 4 * 2).max(n.min(8));
        Self { width: part(self.width), height: part(self.height) }
    }

    /// Rows of one side.
    pub(super) fn rows(self, side: SideId) -> u32 {
        if side == SideId::Top { self.height } else { self.height / 2 }
    }

    /// Cells of all five sides.
    pub fn cells(self) -> usize {
        3 * self.width as usize * self.height as usize
    }

    /// Plane coordinates of a cell's centre on its side: horizontal in [-1, 1]; vertical in [-1, 1]
    /// on the top, in [0, 1] on the sides, where it runs along the normal.
    pub(super) fn cell_centre(self, side: SideId, x: u32, y: u32) -> Vec2 {
        let half = 0.5 * self.height as f32;
        let b = (y as f32 + 0.5) / half;
        Vec2::new(
            (x as f32 + 0.5) / (0.5 * self.width as f32) - 1.0,
            if side == SideId::Top { b - 1.0 } else { b },
        )
    }
}

/// One of the five sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SideId {
    /// The side that the normal goes through.
    Top,
    /// The side that `View::right` goes through.
    Right,
    /// The side that `View::up` goes through.
    Up,
    /// Opposite to [`SideId::Right`].
    Left,
    /// Opposite to [`SideId::Up`].
    Down,
}

/// The five sides in the order that cells are counted.
pub const SIDES: [SideId; 5] = [SideId::Top, SideId::Right, SideId::Up, SideId::Left, SideId::Down];

/// Where a hemicube stands: the three directions are orthonormal.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// The point that looks.
    pub position: Vec3,
    /// First tangent.
    pub right: Vec3,
    /// Second tangent.
    pub up: Vec3,
    /// Surface normal: the hemicube covers the half space on its side.
    pub normal: Vec3,
}

impl View {
    /// A hemicube at `position`, turned about the unit `normal` by an angle drawn from `seed`.
    /// Turning every hemicube differently makes the aliasing of neighbours independent, which cuts
    /// its sum about threefold at no cost.
    pub fn turned(position: Vec3, normal: Vec3, seed: u64) -> Self {
        let (t, b) = normal.any_orthonormal_pair();
        let (sin, cos) = (hash(seed) * std::f64::consts::TAU).sin_cos();
        let (sin, cos) = (sin as f32, cos as f32);
        Self { position, right: t * cos + b * sin, up: b * cos - t * sin, normal }
    }

    /// Horizontal, vertical and depth axis of a side.
    pub(super) fn axes(&self, side: SideId) -> [Vec3; 3] {
        match side {
            SideId::Top => [self.right, self.up, self.normal],
            SideId::Right => [self.up, self.normal, self.right],
            SideId::Up => [-self.right, self.normal, self.up],
            SideId::Left => [-self.up, self.normal, -self.right],
            SideId::Down => [self.right, self.normal, -self.up],
        }
    }
}

/// A number in [0, 1) that depends on `seed` only (the finaliser of SplitMix64).
fn hash(seed: u64) -> f64 {
    let mut z = seed.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as f64 / 2f64.powi(64)
}

/// Exact form factors of all cells, from the closed form of a rectangle: they sum to 1.
pub struct DeltaFormFactors {
    top: Table,
    side: Table,
}

/// Cells of one side, row by row.
struct Table {
    factor: Vec<f32>,
    /// 1 / length of the direction to the cell's centre at depth 1.
    inverse_length: Vec<f32>,
}

impl DeltaFormFactors {
    /// The tables of a hemicube of this size.
    pub fn new(size: HemicubeSize) -> Self {
        Self {
            top: Table::new(size, SideId::Top, parallel_corner),
            side: Table::new(size, SideId::Right, upright_corner),
        }
    }

    /// Shares of the whole sphere instead, for points that face no direction: those of a hemicube sum to
    /// one half. The mean of exitance weighted so is the mean irradiance on planes of all directions.
    pub fn of_sphere(size: HemicubeSize) -> Self {
        Self {
            top: Table::new(size, SideId::Top, sphere_corner),
            side: Table::new(size, SideId::Right, sphere_corner),
        }
    }

    /// Form factors of one side, row by row.
    pub fn of(&self, side: SideId) -> &[f32] {
        &self.table(side).factor
    }

    /// Times a cell's nearness this is 1 / distance.
    pub(super) fn inverse_length(&self, side: SideId) -> &[f32] {
        &self.table(side).inverse_length
    }

    fn table(&self, side: SideId) -> &Table {
        if side == SideId::Top { &self.top } else { &self.side }
    }
}

impl Table {
    /// The integrals whose antiderivative is `corner`.
    fn new(size: HemicubeSize, side: SideId, corner: fn(f64, f64) -> f64) -> Self {
        let (w, h) = (size.width, size.height);
        let edge = |i: u32, n: u32| 2.0 * f64::from(i) / f64::from(n);
        let (mut factor, mut inverse_length) = (Vec::new(), Vec::new());
        for y in 0..size.rows(side) {
            for x in 0..w {
                let a = [edge(x, w) - 1.0, edge(x + 1, w) - 1.0];
                let b = [edge(y, h), edge(y + 1, h)];
                let b = if side == SideId::Top { b.map(|b| b - 1.0) } else { b };
                let f = rectangle(corner, a, b) as f32;
                let centre = size.cell_centre(side, x, y);
                factor.push(f);
                inverse_length.push(1.0 / (1.0 + centre.length_squared()).sqrt());
            }
        }
        Self { factor, inverse_length }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delta_form_factors_sum_to_one() {
        for (w, h) in [(2, 2), (2, 64), (64, 64), (130, 34), (512, 512)] {
            let delta = DeltaFormFactors::new(HemicubeSize::new(w, h).unwrap());
            let sum = |delta: &DeltaFormFactors| -> f64 {
                let cells = SIDES.iter().flat_map(|&s| delta.of(s));
                assert!(cells.clone().all(|&f| f > 0.0));
                cells.map(|&f| f64::from(f)).sum()
            };
            assert!((sum(&delta) - 1.0).abs() < 1e-6, "{w}x{h}");
            let sphere = DeltaFormFactors::of_sphere(HemicubeSize::new(w, h).unwrap());
            assert!((sum(&sphere) - 0.5).abs() < 1e-6, "{w}x{h}");
        }
    }

    #[test]
    fn sizes_are_checked() {
        for (w, h) in [(0, 2), (3, 4), (4, 3), (4098, 4), (4, 4098)] {
            assert!(HemicubeSize::new(w, h).is_err(), "{w}x{h}");
        }
    }

    #[test]
    fn turned_views_are_orthonormal_and_right_handed() {
        for seed in 0..100 {
            let n = Vec3::new((seed as f32).sin(), (seed as f32).cos(), 0.3).normalize();
            let v = View::turned(Vec3::ZERO, n, seed);
            assert!((v.right.cross(v.up) - v.normal).length() < 1e-5);
            for side in SIDES {
                let [a, b, c] = v.axes(side);
                assert!((a.cross(b) - c).length() < 1e-5, "{side:?}");
            }
        }
    }
}
