//! Light grids, read and written by code of their own.

use glam::{DVec3, Vec3};
use qrad::bsp::Bsp;
use std::collections::HashSet;

/// Style and its colours: six of them, or one.
pub type Light = (u8, Vec<[u8; 3]>);

/// A leaf of the tree.
pub struct Leaf {
    pub mins: [u32; 3],
    pub size: [u32; 3],
    pub points: Vec<Option<Vec<Light>>>,
}

/// A light grid.
pub struct Grid {
    /// Whether points tell a colour for each side of a cube.
    pub sides: bool,
    pub step: [f32; 3],
    pub size: [u32; 3],
    pub mins: [f32; 3],
    pub most_styles: u8,
    pub root: u32,
    pub nodes: Vec<([u32; 3], [u32; 8])>,
    pub leafs: Vec<Leaf>,
}

/// What is still to be read.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let (head, tail) = self.0.split_at(N);
        self.0 = tail;
        head.try_into().unwrap()
    }

    fn byte(&mut self) -> u8 {
        self.bytes::<1>()[0]
    }

    fn word(&mut self) -> u32 {
        u32::from_le_bytes(self.bytes())
    }

    fn words<const N: usize>(&mut self) -> [u32; N] {
        std::array::from_fn(|_| self.word())
    }

    fn floats(&mut self) -> [f32; 3] {
        self.words().map(f32::from_bits)
    }

    fn light(&mut self, sides: bool) -> Light {
        let style = self.byte();
        if !sides {
            return (style, vec![self.bytes()]);
        }
        let mask = self.byte();
        assert!(mask != 0 && mask < 64);
        let side = |side: u8| if mask & (1 << side) != 0 { self.bytes() } else { [0; 3] };
        (style, (0..6).map(side).collect())
    }

    fn leaf(&mut self, sides: bool) -> Leaf {
        let (mins, size) = (self.words(), self.words::<3>());
        let most = if sides { self.byte() } else { 4 };
        let points = (0..size.iter().product()).map(|_| match self.byte() {
            255 => None,
            count => {
                assert!(count <= most);
                Some((0..count).map(|_| self.light(sides)).collect())
            }
        });
        Leaf { mins, size, points: points.collect() }
    }
}

impl Grid {
    /// The grid of a map with one of the two lumps.
    pub fn of(bsp: &Bsp) -> Self {
        let lumps = ["LIGHTGRID_OCTREE", "LIGHTGRIDS"]
            .map(|name| bsp.bspx.iter().find(|lump| lump.name == name));
        match lumps {
            [Some(lump), None] => Self::read(&lump.data, false),
            [None, Some(lump)] => {
                let (size, grid) = lump.data.split_at(4);
                assert_eq!(u32::from_le_bytes(size.try_into().unwrap()) as usize, grid.len());
                Self::read(grid, true)
            }
            _ => panic!("one of the two lumps"),
        }
    }

    /// From the bytes of a lump, or of a part of it, which the tree is checked by.
    pub fn read(data: &[u8], sides: bool) -> Self {
        let mut r = Reader(data);
        let (step, size, mins) = (r.floats(), r.words(), r.floats());
        let (most_styles, root) = (r.byte(), r.word());
        let nodes = (0..r.word()).map(|_| (r.words(), r.words())).collect();
        let leafs = (0..r.word()).map(|_| r.leaf(sides)).collect();
        assert!(r.0.is_empty(), "nothing is left over");
        let grid = Self { sides, step, size, mins, most_styles, root, nodes, leafs };
        grid.check();
        grid
    }

    /// Leaf and place in it of a point, `None` where the tree says that all is solid, and the number of
    /// nodes on the way.
    pub fn find(&self, at: [u32; 3]) -> (Option<(usize, usize)>, u32) {
        let (mut word, mut depth, mut parent) = (self.root, 0, self.nodes.len());
        loop {
            if word >> 30 == 1 {
                return (None, depth);
            }
            if word >> 31 == 1 {
                let index = (word & 0x7fff_ffff) as usize;
                let Leaf { mins, size, .. } = &self.leafs[index];
                let [x, y, z] = [0, 1, 2].map(|i| at[i].checked_sub(mins[i]).unwrap());
                assert!(x < size[0] && y < size[1] && z < size[2]);
                return (Some((index, ((z * size[1] + y) * size[0] + x) as usize)), depth);
            }
            assert!((word as usize) < parent, "children come before their parents");
            parent = word as usize;
            let (middle, children) = &self.nodes[parent];
            let bit = |axis: usize| usize::from(at[axis] >= middle[axis]) << (2 - axis);
            word = children[bit(0) | bit(1) | bit(2)];
            depth += 1;
        }
    }

    /// Places of all points.
    pub fn all(&self) -> impl Iterator<Item = [u32; 3]> {
        let [w, d, h] = self.size;
        (0..h).flat_map(move |z| (0..d).flat_map(move |y| (0..w).map(move |x| [x, y, z])))
    }

    /// Every point is in one place, every place is that of one point, and no leaf is nothing but solid.
    fn check(&self) {
        let places: Vec<_> = self.all().map(|at| self.find(at)).collect();
        assert!(places.iter().all(|&(_, depth)| depth <= 5));
        let found: Vec<_> = places.iter().filter_map(|p| p.0).collect();
        assert_eq!(found.iter().collect::<HashSet<_>>().len(), found.len());
        assert_eq!(self.leafs.iter().map(|l| l.points.len()).sum::<usize>(), found.len());
        assert!(self.leafs.iter().all(|l| l.points.iter().any(Option::is_some)));
        let most = self.leafs.iter().flat_map(|l| &l.points).flatten().map(Vec::len).max();
        assert_eq!(most.unwrap_or(0).max(1), usize::from(self.most_styles));
    }

    /// Light at a point; `None` in solid.
    pub fn light(&self, at: [u32; 3]) -> Option<&[Light]> {
        let (leaf, place) = self.find(at).0?;
        self.leafs[leaf].points[place].as_deref()
    }

    /// Where a point is.
    pub fn position(&self, at: [u32; 3]) -> DVec3 {
        let along = |i: usize| self.mins[i] + self.step[i] * at[i] as f32;
        Vec3::new(along(0), along(1), along(2)).as_dvec3()
    }

    /// The bytes that the grid is read from.
    pub fn write(&self) -> Vec<u8> {
        let mut out = Vec::new();
        let words = |out: &mut Vec<u8>, words: &[u32]| {
            out.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        };
        words(&mut out, &self.step.map(f32::to_bits));
        words(&mut out, &self.size);
        words(&mut out, &self.mins.map(f32::to_bits));
        out.push(self.most_styles);
        words(&mut out, &[self.root, self.nodes.len() as u32]);
        for (middle, children) in &self.nodes {
            words(&mut out, middle);
            words(&mut out, children);
        }
        words(&mut out, &[self.leafs.len() as u32]);
        for leaf in &self.leafs {
            words(&mut out, &leaf.mins);
            words(&mut out, &leaf.size);
            if self.sides {
                let most = leaf.points.iter().flatten().map(Vec::len).max();
                out.push(most.unwrap_or(0) as u8);
            }
            for point in &leaf.points {
                let Some(styles) = point else {
                    out.push(255);
                    continue;
                };
                out.push(styles.len() as u8);
                for (style, colours) in styles {
                    out.push(*style);
                    let lit = |side: &usize| !self.sides || colours[*side] != [0; 3];
                    let sides: Vec<usize> = (0..colours.len()).filter(lit).collect();
                    if self.sides {
                        out.push(sides.iter().map(|side| 1 << side).sum());
                    }
                    out.extend(sides.iter().flat_map(|&side| colours[side]));
                }
            }
        }
        out
    }
}
