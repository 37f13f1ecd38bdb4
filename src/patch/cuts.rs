//! Thin walls and doors that stand between the luxels of a face which runs on under them. What lies on
//! either side of one must not share its light.

use super::polygon2::clip;
use crate::scene::{Barriers, LuxelGrid, Sample, Scene};
use glam::{DVec2, Vec2, Vec3};

/// Share of the way between two luxels at either end that is not looked at: luxels at the rim of a face
/// may lie on a wall.
const RIM: f32 = 1e-3;

/// A line in luxel coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    /// Unit normal.
    pub normal: DVec2,
    /// Where it is along the normal.
    pub at: f64,
}

impl Line {
    /// 1 for points that the normal points to, else 0.
    pub fn side(&self, p: DVec2) -> usize {
        usize::from(self.normal.dot(p) > self.at)
    }

    /// The part of a convex polygon on one side.
    pub fn clip(&self, points: &[DVec2], side: usize) -> Vec<DVec2> {
        let sign = if side == 1 { -1.0 } else { 1.0 };
        clip(points, |p| sign * (self.at - self.normal.dot(p)))
    }

    /// Coefficients of column, row and 1; their sum is above 0 for side 1.
    pub fn coefficients(&self) -> Vec3 {
        self.normal.extend(-self.at).as_vec3()
    }
}

/// One side of a line, or all there is.
pub(super) type Half = Option<(Line, usize)>;

/// The parts of an interval that a line cuts, or not.
pub(super) fn halves(cut: Option<Line>) -> impl Iterator<Item = Half> {
    (0..=usize::from(cut.is_some())).map(move |side| cut.map(|line| (line, side)))
}

/// The luxels of a face, and what stands between them.
pub(super) struct Luxels<'a> {
    grid: &'a LuxelGrid,
    samples: &'a [Sample],
    /// Where each takes its light, in luxel coordinates.
    places: Vec<DVec2>,
}

impl<'a> Luxels<'a> {
    /// The luxels of a face, which take their light `lift` away from it.
    pub fn new(grid: &'a LuxelGrid, samples: &'a [Sample], lift: Vec3) -> Self {
        assert_eq!(grid.len(), samples.len());
        let place = |s: &Sample| grid.luxel_of(s.position - lift).as_dvec2();
        Self { grid, samples, places: samples.iter().map(place).collect() }
    }

    /// Whether no luxel is in solid.
    pub fn all_free(&self) -> bool {
        self.samples.iter().all(|s| !s.occluded)
    }

    /// The luxels around interval number `k`: low, next column, next row, both.
    fn around(&self, k: usize) -> [u32; 4] {
        let intervals = self.grid.width - 1;
        let low = k as u32 / intervals * self.grid.width + k as u32 % intervals;
        [low, low + 1, low + self.grid.width, low + self.grid.width + 1]
    }

    /// Whether a luxel is not in solid and takes its light on this side.
    fn counts(&self, luxel: u32, half: Half) -> bool {
        let there = |(line, side): (Line, usize)| line.side(self.places[luxel as usize]) == side;
        !self.samples[luxel as usize].occluded && half.is_none_or(there)
    }

    /// The corners of interval number `k` that count for one side of it.
    pub fn corners(&self, k: usize, half: Half) -> impl Iterator<Item = u32> + '_ {
        self.around(k).into_iter().filter(move |&l| self.counts(l, half))
    }

    /// The corners of interval number `k` and their bilinear weights at `p`, shared out among those that
    /// count for one side of it: they sum to 1, or to 0 if none does.
    pub fn weights(&self, k: usize, half: Half, p: DVec2) -> [(u32, f32); 4] {
        let around = self.around(k);
        let low = [around[0] % self.grid.width, around[0] / self.grid.width];
        let inside = p.as_vec2() - Vec2::new(low[0] as f32, low[1] as f32);
        let along = |next: bool, x: f32| if next { x } else { 1.0 - x };
        let weighed = [0, 1, 2, 3].map(|c| {
            let weight = along(c % 2 == 1, inside.x) * along(c / 2 == 1, inside.y);
            let counts = self.counts(around[c], half);
            (around[c], if counts { weight.clamp(0.0, 1.0) } else { 0.0 })
        });
        let sum: f32 = weighed.iter().map(|w| w.1).sum();
        weighed.map(|(l, w)| (l, if sum > 0.0 { w / sum } else { 0.0 }))
    }

    /// The line along which an obstacle cuts each luxel interval in two, row by row; none in most. An
    /// obstacle that ends within the interval does not cut it.
    pub fn cuts(&self, scene: &Scene) -> Vec<Option<Line>> {
        let mut barriers = Barriers::new(scene);
        let (width, height) = (self.grid.width, self.grid.height);
        let mut step = |columns: u32, rows: u32, step: u32| -> Vec<Option<DVec2>> {
            let hidden = |l: u32| {
                let inside = l % width < columns && l / width < rows;
                inside.then(|| self.hidden(&mut barriers, l, l + step)).flatten()
            };
            (0..width * height).map(hidden).collect()
        };
        let right = step(width - 1, height, 1);
        let down = step(width, height - 1, width);
        (0..((width - 1) * (height - 1)) as usize)
            .map(|k| {
                let [a, b, c, _] = self.around(k).map(|l| l as usize);
                let sides = [(0, 1, right[a]), (2, 3, right[c]), (0, 2, down[a]), (1, 3, down[b])];
                let hidden = sides.iter().any(|s| s.2.is_some());
                hidden.then(|| self.cut(&mut barriers, k, sides)).flatten()
            })
            .collect()
    }

    /// The line that keeps apart the corners of interval number `k` that do not see each other. `sides`
    /// are pairs of them, and what is hidden between.
    fn cut(
        &self,
        barriers: &mut Barriers<'_>,
        k: usize,
        sides: [(usize, usize, Option<DVec2>); 4],
    ) -> Option<Line> {
        let corners = self.around(k);
        let free: Vec<usize> = (0..4).filter(|&c| self.counts(corners[c], None)).collect();
        let mut group = [0, 1, 2, 3];
        let mut points = Vec::new();
        let mut way = DVec2::ZERO;
        let diagonals = [(0, 3, None), (1, 2, None)];
        for (i, (a, b, known)) in sides.into_iter().chain(diagonals).enumerate() {
            if group[a] == group[b] || !free.contains(&a) || !free.contains(&b) {
                continue;
            }
            let between = |barriers| self.hidden(barriers, corners[a], corners[b]);
            match if i < sides.len() { known } else { between(barriers) } {
                Some(point) => {
                    points.push(point);
                    way = self.places[corners[b] as usize] - self.places[corners[a] as usize];
                }
                None => group = group.map(|g| if g == group[a] { group[b] } else { g }),
            }
        }
        if free.iter().all(|&c| group[c] == group[free[0]]) {
            return None;
        }
        let parts = |line: &Line| halves(Some(*line)).all(|half| self.corners(k, half).count() > 0);
        let lines = [through(&points), Some(across(*points.last()?, way))];
        lines.into_iter().flatten().find(parts)
    }

    /// Middle of what is hidden between two luxels, in luxel coordinates; `None` if they see each other or
    /// one is in solid.
    fn hidden(&self, barriers: &mut Barriers<'_>, a: u32, b: u32) -> Option<DVec2> {
        let [from, to] = [a, b].map(|l| &self.samples[l as usize]);
        let way = to.position - from.position;
        if from.occluded || to.occluded || way.length_squared() < RIM {
            return None;
        }
        let (start, end) = (from.position + way * RIM, to.position - way * RIM);
        if !barriers.blocked(start, end) {
            return None;
        }
        let middle = 0.5 * (barriers.free(start, end) + 1.0 - barriers.free(end, start));
        Some(self.places[a as usize].lerp(self.places[b as usize], middle.into()))
    }
}

/// The line through those two of `points` that are farthest apart.
fn through(points: &[DVec2]) -> Option<Line> {
    let pairs = points.iter().enumerate().flat_map(|(i, p)| points[..i].iter().map(|q| *p - *q));
    let way = pairs.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
    let end = points.iter().max_by(|a, b| a.dot(way).total_cmp(&b.dot(way)))?;
    (way.length() > 1e-3).then(|| across(*end, way.perp()))
}

/// The line through a point, at a right angle to `way`.
fn across(point: DVec2, way: DVec2) -> Line {
    let normal = way.normalize_or_zero();
    Line { normal, at: normal.dot(point) }
}
