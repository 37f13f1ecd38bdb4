//! Drawing a hemicube: the hierarchy is walked front to back, once for all five sides, and what lies
//! behind covered tiles is skipped.

use super::clip::{Homogeneous, clip, outside};
use super::frame::{ALL_SIDES, Frame, SideSet};
use super::lanes::{LANES, Lanes, greatest};
use super::outline::{Edges, Outline};
use super::side::{NOTHING, Side};
use super::{HemicubeSize, SIDES, SideId, View};
use crate::scene::{Piece, Pieces, Tracer};
use glam::Vec3;
use std::ops::Range;

/// Backs are looked for that reach farther from their middle than so many cells are wide: what is seen from
/// within solid space has some.
const LARGE: f32 = 1.0;
/// A point shows if its cell's nearness is less than this share of its own.
const HIDDEN: f32 = 0.999;

/// Which polygon a point sees through each cell. Reused from one hemicube to the next.
pub struct ItemBuffer {
    size: HemicubeSize,
    sides: [Side; 5],
    /// Nodes still to be looked at, the nearer child last, with the sides that they may be seen on.
    stack: Vec<(u32, SideSet)>,
    points: Vec<Homogeneous>,
    spare: Vec<Homogeneous>,
    edges: Edges,
    /// The small and the large pieces whose backs were met, by number, and the sides to draw them on.
    backs: [Vec<(usize, SideSet)>; 2],
}

/// Cells of one row that lie beside each other in memory.
pub struct Cells<'a> {
    /// The side they are on.
    pub side: SideId,
    /// Column of the first cell.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// Polygon seen in each cell, `u32::MAX` for none.
    pub items: &'a [u32],
    /// 1 / depth along the side's axis, in 1 / world units.
    pub nearness: &'a [f32],
}

impl Cells<'_> {
    /// Marks a cell through which nothing is seen.
    pub const NOTHING: u32 = NOTHING;
}

impl ItemBuffer {
    /// An empty buffer.
    pub fn new(size: HemicubeSize) -> Self {
        Self {
            size,
            sides: SIDES.map(|s| Side::new(size.width(), size.rows(s))),
            stack: Vec::new(),
            points: Vec::new(),
            spare: Vec::new(),
            edges: Edges::default(),
            backs: [Vec::new(), Vec::new()],
        }
    }

    /// Number of cells.
    pub fn size(&self) -> HemicubeSize {
        self.size
    }

    /// Replaces the contents by what is seen from `view`.
    pub fn draw(&mut self, tracer: &Tracer, view: &View) {
        let (pieces, frame) = (tracer.pieces(), Frame::new(view, self.size));
        self.draw_fronts(pieces, &frame);
        self.draw_backs(pieces, &frame);
    }

    /// Draws what is seen from its front, and lists the backs that were met.
    fn draw_fronts(&mut self, pieces: &Pieces, frame: &Frame) {
        self.sides.iter_mut().for_each(Side::clear);
        self.backs.iter_mut().for_each(Vec::clear);
        let nodes = pieces.nodes();
        self.stack.clear();
        if !nodes.is_empty() {
            self.stack.push((0, ALL_SIDES));
        }
        while let Some((index, sides)) = self.stack.pop() {
            let node = &nodes[index as usize];
            if node.count > 0 {
                // Polygons are tested by themselves, more exactly than by their box.
                let [small, large] = pieces.of(node).clone();
                self.draw_leaf::<_, 0>(pieces.small(), small, frame, sides);
                self.draw_leaf::<_, 1>(pieces.large(), large, frame, sides);
                continue;
            }
            let corners = frame.corners(node);
            let sides = members(sides)
                .filter(|&side| !frame.hidden(&corners, side, &mut self.sides[side]))
                .fold(0, |set, side| set | 1 << side);
            if sides == 0 {
                continue;
            }
            let children = [node.first, node.first + 1];
            let [a, b] = children.map(|child| &nodes[child as usize]);
            let seen = [sides & frame.sides_of_box(a), sides & frame.sides_of_box(b)];
            let nearer = usize::from(frame.distance(b) < frame.distance(a));
            for k in [1 - nearer, nearer] {
                if seen[k] != 0 {
                    self.stack.push((children[k], seen[k]));
                }
            }
        }
    }

    /// Draws pieces of a leaf, or adds them to list `BACKS` of backs.
    #[inline(always)]
    fn draw_leaf<V: Lanes, const BACKS: usize>(
        &mut self,
        pieces: &[Piece<V>],
        places: Range<usize>,
        frame: &Frame,
        sides: SideSet,
    ) {
        for k in places {
            if is_back(&pieces[k], frame) {
                self.backs[BACKS].push((k, sides));
            } else {
                self.draw_piece(&pieces[k], frame, sides);
            }
        }
    }

    /// Polygon seen in a cell, [`Cells::NOTHING`] for none, and 1 / depth.
    pub fn cell(&self, side: SideId, x: u32, y: u32) -> (u32, f32) {
        let place = SIDES.iter().position(|&s| s == side).expect("one of the five");
        self.sides[place].cell(x as usize, y as usize)
    }

    /// Visits all cells, in a fixed order.
    pub fn for_each_row(&self, mut visit: impl FnMut(Cells<'_>)) {
        for (side, id) in self.sides.iter().zip(SIDES) {
            side.for_each_row(|x, y, items, nearness| {
                visit(Cells { side: id, x: x as u32, y: y as u32, items, nearness });
            });
        }
    }

    /// Draws backs too, if any seems to be seen. From open space fronts hide all of them: only if the
    /// middle of a large one shows, and it then fills a cell, are the rest drawn.
    fn draw_backs(&mut self, pieces: &Pieces, frame: &Frame) {
        let backs = std::mem::take(&mut self.backs);
        let (small, large) = (pieces.small(), pieces.large());
        if backs[0].iter().any(|&(k, sides)| self.back_shows(&small[k], frame, sides))
            || backs[1].iter().any(|&(k, sides)| self.back_shows(&large[k], frame, sides))
        {
            backs[0].iter().for_each(|&(k, sides)| _ = self.draw_back(&small[k], frame, sides));
            backs[1].iter().for_each(|&(k, sides)| _ = self.draw_back(&large[k], frame, sides));
        }
        self.backs = backs;
    }

    /// Whether a piece is large and its middle is not hidden, or close, and fills a cell when it is drawn.
    fn back_shows<V: Lanes>(&mut self, piece: &Piece<V>, frame: &Frame, sides: SideSet) -> bool {
        let cell = 2.0 / self.size.width().min(self.size.height()) as f32;
        let distance = frame.eye_from(piece.middle).length();
        let reach = piece.radius_squared.sqrt();
        if reach < cell * LARGE * distance {
            return false;
        }
        // What comes close may be seen though its middle is hidden, or below the horizon.
        let shows = reach > distance
            || frame.place(piece.middle).is_some_and(|(number, [x, y, depth])| {
                self.sides[number].at(x, y).1 * depth < HIDDEN
            });
        shows && self.draw_back(piece, frame, sides)
    }

    /// As `draw_piece`, and apart from it, as that is quick where it is called in one place.
    #[inline(never)]
    fn draw_back<V: Lanes>(&mut self, piece: &Piece<V>, frame: &Frame, sides: SideSet) -> bool {
        self.draw_piece(piece, frame, sides)
    }

    /// Returns whether any cell shows it.
    #[inline(always)]
    fn draw_piece<V: Lanes>(&mut self, piece: &Piece<V>, frame: &Frame, sides: SideSet) -> bool {
        let mut shown = false;
        let local = frame.local(&piece.corners);
        for number in members(sides) {
            let size = self.sides[number].size();
            let points = frame.side(number).project(&local);
            let outside = outside(&points, size);
            // Outside of one of the planes with all corners.
            if outside.contains(&V::EVERY) {
                continue;
            }
            let inverse = V::all(1.0) / points[2];
            let whole = Outline::projected(&points, inverse);
            let before = points[2].cmp_gt(V::all(0.0)).mask() == V::EVERY;
            if before && (outside == [0; 4] || whole.is_near(size)) {
                shown |= self.fill(&whole, greatest(inverse), piece, frame, number);
                continue;
            }
            let mut lanes = [[0.0; LANES]; 3];
            points.iter().zip(&mut lanes).for_each(|(p, lanes)| p.store(lanes));
            let [x, y, z] = &lanes;
            self.points.clear();
            self.points.extend((0..piece.count as usize).map(|k| Vec3::new(x[k], y[k], z[k])));
            if clip(&mut self.points, &mut self.spare, size[0], size[1]) {
                let outline = Outline::clipped(&self.points, size);
                let nearest = 1.0 / self.points.iter().map(|p| p.z).fold(f32::INFINITY, f32::min);
                shown |= self.fill(&outline, nearest, piece, frame, number);
            }
        }
        shown
    }

    /// Draws a piece with this outline on side `number`, unless all of it is hidden. Returns whether any
    /// cell shows it.
    #[inline(always)]
    fn fill<V: Lanes, P>(
        &mut self,
        outline: &Outline<V>,
        nearest: f32,
        piece: &Piece<P>,
        frame: &Frame,
        number: usize,
    ) -> bool {
        let side = &mut self.sides[number];
        let size = side.size();
        let Some(cells) = outline.cells(size) else { return false };
        if side.covered(cells, nearest) {
            return false;
        }
        let Some(slope) = frame.nearness(piece.on, piece.normal) else { return false };
        outline.edges(size[1], &mut self.edges);
        side.fill(&self.edges, cells, frame.side(number).nearness(slope), piece.polygon)
    }
}

/// Whether there is solid space between the eye and a piece, if the eye is not in solid space itself.
#[inline(always)]
fn is_back<V>(piece: &Piece<V>, frame: &Frame) -> bool {
    piece.on_solid && piece.normal.dot(frame.eye_from(piece.on)) < 0.0
}

/// The numbers of the sides in a set.
fn members(set: SideSet) -> impl Iterator<Item = usize> {
    (0..5).filter(move |side| set >> side & 1 == 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Polygon;

    /// The faces of a box; their fronts are inside or outside.
    fn faces(low: Vec3, high: Vec3, inside: bool) -> Vec<Polygon> {
        let ends = [low, high];
        let face = |k: usize| {
            let (axis, end) = (k / 2, k % 2);
            let mut normal = Vec3::ZERO;
            normal[axis] = if (end == 1) == inside { -1.0 } else { 1.0 };
            let corner = |a: usize, b: usize| {
                let mut p = Vec3::splat(ends[end][axis]);
                (p[(axis + 1) % 3], p[(axis + 2) % 3]) =
                    (ends[a][(axis + 1) % 3], ends[b][(axis + 2) % 3]);
                p
            };
            let mut vertices = vec![corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            if normal[axis] < 0.0 {
                vertices.reverse();
            }
            Polygon { vertices, normal }
        };
        (0..6).map(face).collect()
    }

    /// Numbers in 0 to 1 that follow from `k`.
    fn spread(k: usize) -> Vec3 {
        let at = |step: f64| (k as f64 * step + 0.31).fract() as f32;
        Vec3::new(at(0.819_172_5), at(0.671_043_6), at(0.549_700_5))
    }

    /// A room with blocks in it, and their centres.
    fn room() -> (Vec<Polygon>, Vec<Vec3>) {
        let centres: Vec<Vec3> = (0..40).map(|k| spread(k) * 900.0 + Vec3::splat(50.0)).collect();
        let mut polygons = faces(Vec3::ZERO, Vec3::splat(1000.0), true);
        for (k, &centre) in centres.iter().enumerate() {
            let half = Vec3::splat(10.0) + spread(k + 100) * 40.0;
            polygons.extend(faces(centre - half, centre + half, false));
        }
        (polygons, centres)
    }

    /// Cells that show another polygon when all backs are drawn, and whether any were drawn without.
    fn lost(buffer: &mut ItemBuffer, tracer: &Tracer, view: &View) -> (usize, bool) {
        let shown = |buffer: &ItemBuffer| {
            let mut items = Vec::new();
            buffer.for_each_row(|cells| items.extend_from_slice(cells.items));
            items
        };
        let (pieces, frame) = (tracer.pieces(), Frame::new(view, buffer.size()));
        buffer.draw_fronts(pieces, &frame);
        let fronts = shown(buffer);
        buffer.draw(tracer, view);
        let found = shown(buffer);
        let [small, large] = buffer.backs.clone();
        for (k, sides) in small {
            buffer.draw_back(&pieces.small()[k], &frame, sides);
        }
        for (k, sides) in large {
            buffer.draw_back(&pieces.large()[k], &frame, sides);
        }
        let all = shown(buffer);
        (found.iter().zip(&all).filter(|(a, b)| a != b).count(), fronts != found)
    }

    #[test]
    fn backs_are_drawn_where_they_are_seen() {
        let (polygons, centres) = room();
        let count = polygons.len();
        let tracer = Tracer::new(polygons).on_solid(count);
        for cells in [8, 16, 64] {
            let mut buffer = ItemBuffer::new(HemicubeSize::new(cells, cells).unwrap());
            let (mut inside, mut open) = (0, 0);
            for (k, &centre) in centres.iter().enumerate() {
                let view = |at| View::turned(at, (spread(k + 7) - 0.5).normalize(), k as u64);
                let (lost_here, drawn) = lost(&mut buffer, &tracer, &view(centre));
                assert_eq!(lost_here, 0, "block {k}, {cells} cells");
                inside += usize::from(drawn);
                let (lost_here, drawn) = lost(&mut buffer, &tracer, &view(spread(k + 50) * 1000.0));
                assert_eq!(lost_here, 0, "eye {k}, {cells} cells");
                open += usize::from(drawn);
            }
            println!("{cells} cells: backs drawn from {inside} blocks and {open} other eyes");
            assert!(inside >= 38 && open < 10);
        }
    }

    #[test]
    fn backs_without_solid_space_are_drawn_at_once() {
        let (polygons, centres) = room();
        let tracer = Tracer::new(polygons);
        let mut buffer = ItemBuffer::new(HemicubeSize::new(32, 32).unwrap());
        buffer.draw(&tracer, &View::turned(centres[0], Vec3::Z, 0));
        assert!(buffer.backs.iter().all(Vec::is_empty));
        let mut seen = false;
        buffer.for_each_row(|cells| seen |= cells.items.iter().any(|&i| (6..12).contains(&i)));
        assert!(seen, "the block around the eye");
    }
}
