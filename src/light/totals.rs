//! All light of a surface's points and suns, by whichever way its samples are looked at.

use super::adaptive::{Leeway, light_cells};
use super::cells::{CellSums, Cells, CornerSums};
use super::source::{Source, light_all};
use super::sums::Sums;
use super::tiles::{Tile, Tiles};
use super::wanted::Wanted;
use super::{DirectLight, Directions, FaceDirt, StyleLight};
use crate::scene::{Sample, Scene, Surface};

/// How the samples of a surface are looked at.
pub(super) enum LitPoints {
    /// Each of the free ones.
    Each(Tiles, Vec<u32>),
    /// Cell by cell.
    Cells(Cells),
}

impl LitPoints {
    /// Cells where there is more than one sample a luxel, `extra` x `extra`.
    pub fn new(surface: &Surface, samples: &[Sample], extra: u32) -> Self {
        match &surface.luxels {
            Some(grid) if extra > 1 => {
                let row = (grid.width * extra) as usize;
                Self::Cells(Cells::new(samples, row, extra as usize, surface.normal))
            }
            _ => {
                let is_free = |i: &u32| !samples[*i as usize].occluded;
                let free = (0..samples.len() as u32).filter(is_free).collect();
                Self::Each(Tiles::new(samples, surface.normal), free)
            }
        }
    }

    /// Those that are looked at first.
    pub fn first(&self) -> &[u32] {
        match self {
            Self::Each(_, free) => free,
            Self::Cells(cells) => &cells.corners,
        }
    }

    /// The tile of all free samples; `None` if there are none.
    pub fn whole(&self) -> Option<&Tile> {
        match self {
            Self::Each(tiles, _) => tiles.whole(),
            Self::Cells(cells) => cells.coarse.whole(),
        }
    }
}

/// The sums of a surface.
pub(super) struct Totals<'a> {
    /// Number of samples.
    count: usize,
    leeway: Leeway,
    /// Light, negative light, and what does not bounce of both.
    sums: [&'a mut Vec<StyleLight>; 3],
    /// The same at the corners of cells.
    corners: [CornerSums; 3],
    directions: &'a mut Directions,
}

impl<'a> Totals<'a> {
    /// Sums that end up in `result`.
    pub fn new(
        scene: &Scene,
        points: &LitPoints,
        count: usize,
        result: &'a mut DirectLight,
    ) -> Self {
        let cells = match points {
            LitPoints::Each(..) => 0,
            LitPoints::Cells(cells) => cells.cells().len(),
        };
        Self {
            count,
            leeway: Leeway::new(cells, scene.world.range, scene.world.gamma != 1.0),
            sums: [&mut result.styles, &mut result.negative, &mut result.excess],
            corners: Default::default(),
            directions: &mut result.directions,
        }
    }

    /// Adds the light of a source, `positive` or not.
    pub fn add(
        &mut self,
        source: &mut impl Source,
        positive: bool,
        points: &LitPoints,
        wanted: &mut Wanted,
    ) {
        let [light, negative, excess] = &mut self.sums;
        let [corners, corners_negative, corners_excess] = &mut self.corners;
        let (styles, corners) =
            if positive { (light, corners) } else { (negative, corners_negative) };
        let mut sums = Sums { count: self.count, styles, excess, directions: self.directions };
        match points {
            LitPoints::Each(tiles, free) => light_all(source, (tiles, free), wanted, &mut sums),
            LitPoints::Cells(cells) => {
                let mut sums = CellSums { sums, styles: corners, excess: corners_excess };
                light_cells(source, cells, &mut self.leeway, wanted, &mut sums);
            }
        }
    }

    /// Gives the samples of cells what their corners got, under some dirt.
    pub fn spread(self, points: &LitPoints, dirt: &FaceDirt) {
        if let LitPoints::Cells(cells) = points {
            for (corners, sums) in self.corners.iter().zip(self.sums) {
                corners.spread(cells, (self.count, dirt), sums);
            }
        }
    }
}
