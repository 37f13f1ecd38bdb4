//! The cells of a surface whose light is supersampled: the samples of one luxel each. What varies
//! little within a cell is found at its four corners only, which are samples too.

use super::adaptive::clean_again;
use super::source::Source;
use super::sums::{Given, Sums, slot};
use super::tiles::{Item, Tiles};
use super::{FaceDirt, StyleLight};
use crate::photometry::Irradiance;
use crate::scene::{DirtKeys, Sample};
use glam::Vec3;

/// The cells of a surface.
pub(super) struct Cells {
    cells: Vec<Cell>,
    /// All samples that are corners.
    pub corners: Vec<u32>,
    /// The middles of cells that are no corners.
    pub middles: Vec<u32>,
    /// Whether each sample is a corner.
    pub is_corner: Vec<bool>,
    /// Tiles of corners, as large as the cells that these stand for.
    pub coarse: Tiles,
    /// A tile a cell, with all of its free samples.
    pub fine: Tiles,
}

/// One cell.
pub(super) struct Cell {
    /// The free samples at, or nearest to, its first sample and those an edge further on.
    pub corners: [u32; 4],
    /// The free sample nearest to its middle.
    pub middle: u32,
    /// Column and row of its luxel.
    place: [usize; 2],
    /// First sample, and how many there are in a row.
    first: usize,
    row: usize,
    /// How many samples the corners are apart.
    span: [usize; 2],
}

impl Cells {
    /// The cells of samples, `row` in a row and `edge` x `edge` a luxel.
    pub fn new(samples: &[Sample], row: usize, edge: usize, normal: Vec3) -> Self {
        let rows = samples.len() / row.max(1);
        let mut made = Self {
            cells: Vec::new(),
            corners: Vec::new(),
            middles: Vec::new(),
            is_corner: vec![false; samples.len()],
            coarse: Tiles::none(normal),
            fine: Tiles::none(normal),
        };
        let mut items = Vec::new();
        for y in (0..rows).step_by(edge) {
            for x in (0..row).step_by(edge) {
                let own = |dx: usize, dy: usize| (y + dy) * row + x + dx;
                let inside = || (0..edge * edge).map(|k| own(k % edge, k / edge));
                let is_free = |i: &usize| !samples[*i].occluded;
                if inside().filter(is_free).count() == 0 {
                    continue;
                }
                let nearest = |dx: usize, dy: usize| {
                    let off = |i: &usize| {
                        let (u, v) = (i % row - x, i / row - y);
                        u.abs_diff(dx).pow(2) + v.abs_diff(dy).pow(2)
                    };
                    inside().filter(is_free).min_by_key(off).unwrap_or(own(0, 0))
                };
                let beyond = |dx: usize, dy: usize| {
                    let there = x + dx < row && y + dy < rows;
                    there.then(|| own(dx, dy)).filter(is_free)
                };
                let last = edge - 1;
                let right = beyond(edge, 0);
                let below = beyond(0, edge);
                let corners = [
                    nearest(0, 0),
                    right.unwrap_or_else(|| nearest(last, 0)),
                    below.unwrap_or_else(|| nearest(0, last)),
                    beyond(edge, edge)
                        .filter(|_| right.is_some() && below.is_some())
                        .unwrap_or_else(|| nearest(last, last)),
                ]
                .map(|i| i as u32);
                let span = [right, below].map(|c| if c.is_some() { edge } else { last });
                let members: Vec<u32> = inside().filter(is_free).map(|i| i as u32).collect();
                let item = Item::around(samples, &members, corners[0], normal);
                made.fine.push(&members, &item);
                items.push(item);
                made.is_corner[corners[0] as usize] = true;
                let middle = nearest(edge / 2, edge / 2) as u32;
                let place = [x / edge, y / edge];
                made.cells.push(Cell { corners, middle, place, first: own(0, 0), row, span });
            }
        }
        for cell in &made.cells {
            for &i in &cell.corners {
                if !std::mem::replace(&mut made.is_corner[i as usize], true) {
                    items.push(Item::around(samples, &[i], i, normal));
                }
            }
        }
        made.corners = items.iter().map(|item| item.sample).collect();
        for cell in made.cells.iter().filter(|c| !made.is_corner[c.middle as usize]) {
            items.push(Item::around(samples, &[cell.middle], cell.middle, normal));
            made.middles.push(cell.middle);
        }
        made.coarse = Tiles::of_items(&items, samples, normal);
        made
    }

    /// The cells that have a free sample; the tile of each has the same place in `fine`.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }
}

impl Cells {
    /// The cells that touch one of some cells, themselves included; both are flagged cell by cell.
    pub fn beside(&self, some: &[bool]) -> Vec<bool> {
        let end = |axis: usize| self.cells.iter().map(|c| c.place[axis] + 1).max().unwrap_or(0);
        let (columns, rows) = (end(0), end(1));
        let mut grid = vec![false; columns * rows];
        for (cell, _) in self.cells.iter().zip(some).filter(|(_, is)| **is) {
            let [x, y] = cell.place;
            for v in y.saturating_sub(1)..(y + 2).min(rows) {
                grid[v * columns..][x.saturating_sub(1)..(x + 2).min(columns)].fill(true);
            }
        }
        self.cells.iter().map(|c| grid[c.place[1] * columns + c.place[0]]).collect()
    }
}

impl Cell {
    /// How far a sample is from the first one, in distances of the corners.
    fn along(&self, sample: u32) -> [f32; 2] {
        let off = sample as usize - self.first;
        let along = |d: usize, span: usize| (d as f32 / span.max(1) as f32).min(1.0);
        [along(off % self.row, self.span[0]), along(off / self.row, self.span[1])]
    }

    /// A bump over the cell: 0 at its edges, 1 in the middle.
    pub fn bulge(&self, sample: u32) -> f32 {
        self.along(sample).map(|x| 4.0 * x * (1.0 - x)).iter().product()
    }

    /// Shares of the corners in the light of a sample.
    pub fn weights(&self, sample: u32) -> [f32; 4] {
        let [x, y] = self.along(sample);
        [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y]
    }
}

/// Light of one style that dirt weakens by the same keys.
type Kind = (u16, DirtKeys);

/// Light at the corners of cells, on its way to the sums at samples. Dirt comes last: it would bend
/// what is linear, and the light of all suns alike.
#[derive(Default)]
pub(super) struct CornerSums {
    kinds: Vec<(Kind, Vec<[Vec3; 4]>)>,
}

impl CornerSums {
    fn add(&mut self, kind: Kind, cells: usize, (cell, corner): (usize, usize), colour: Vec3) {
        let slot = self.kinds.iter().position(|k| k.0 == kind).unwrap_or_else(|| {
            self.kinds.push((kind, vec![[Vec3::ZERO; 4]; cells]));
            self.kinds.len() - 1
        });
        self.kinds[slot].1[cell][corner] += colour;
    }

    /// Spreads the light over the free samples of the cells, and takes away what dirt does.
    pub fn spread(
        &self,
        cells: &Cells,
        (count, dirt): (usize, &FaceDirt),
        styles: &mut Vec<StyleLight>,
    ) {
        for ((style, keys), corners) in &self.kinds {
            let slot = slot(styles, *style, count);
            let sums = &mut styles[slot].irradiance;
            for ((cell, tile), corners) in cells.cells.iter().zip(cells.fine.all()).zip(corners) {
                if corners.iter().all(|c| *c == Vec3::ZERO) {
                    continue;
                }
                for &i in cells.fine.members(tile) {
                    let w = cell.weights(i);
                    let light = corners[0] * w[0]
                        + corners[1] * w[1]
                        + corners[2] * w[2]
                        + corners[3] * w[3];
                    sums[i as usize] += Irradiance(light * dirt.factor(i as usize, keys, 0.0));
                }
            }
        }
    }
}

/// The sums of one kind of light at samples and at corners.
pub(super) struct CellSums<'a, 's> {
    pub sums: Sums<'s>,
    pub styles: &'a mut CornerSums,
    pub excess: &'a mut CornerSums,
}

impl CellSums<'_, '_> {
    /// Adds what the corners of a cell are given by a source whose dirt does not depend on distance.
    pub fn add_cell(
        &mut self,
        cells: &Cells,
        cell: usize,
        given: [Option<Given>; 4],
        (source, keys): (&impl Source, DirtKeys),
    ) {
        let (count, all) = (self.sums.count, cells.cells.len());
        for (corner, given) in given.iter().enumerate() {
            let Some(given) = given else { continue };
            let clean = clean_again(source, cells.cells[cell].corners[corner]);
            let kind = (given.style, keys);
            // Styles keep the order in which they come up.
            slot(self.sums.styles, given.style, count);
            self.styles.add(kind, all, (cell, corner), given.colour * clean);
            if given.excess != Vec3::ZERO {
                self.excess.add(kind, all, (cell, corner), given.excess * clean);
            }
            if self.sums.directions.are_wanted() {
                for &i in cells.fine.members(&cells.fine.all()[cell]) {
                    let share = cells.cells[cell].weights(i)[corner];
                    let colour = given.colour * (clean * share * source.share_left(i as usize));
                    let at = (i as usize, count);
                    self.sums.directions.add(given.style, at, given.way, colour);
                }
            }
        }
    }
}
