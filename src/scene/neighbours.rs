//! Which face joins which across an edge (contract section 2.5).

use super::phong::Smoothing;
use crate::bsp::Bsp;

/// For every edge of every face, the face that continues it smoothly.
pub(crate) struct Neighbours {
    /// Where the edges of each face begin in `across`, one entry more than faces.
    first: Vec<u32>,
    across: Vec<Option<u32>>,
}

impl Neighbours {
    /// Joins faces that share both vertices of an edge, run along it in opposite directions and lie
    /// on the same side of the same plane or are smoothed together. Faces that meet at a T do not
    /// join.
    pub fn new(bsp: &Bsp, smoothing: &Smoothing) -> Self {
        let mut directed = Vec::new();
        let mut first = vec![0];
        for face in 0..bsp.faces.len() {
            let corners: Vec<u32> = bsp.face_vertex_indices(face).collect();
            for (i, &a) in corners.iter().enumerate() {
                directed.push((a, corners[(i + 1) % corners.len()], face as u32));
            }
            first.push(directed.len() as u32);
        }
        let mut table = directed.clone();
        table.retain(|(a, b, _)| a != b);
        table.sort_unstable();
        let across = directed
            .iter()
            .map(|&(a, b, face)| {
                let start = table.partition_point(|e| (e.0, e.1) < (b, a));
                let this = &bsp.faces[face as usize];
                table[start..]
                    .iter()
                    .take_while(|e| (e.0, e.1) == (b, a))
                    .map(|e| e.2)
                    .filter(|&other| other != face)
                    .find(|&index| {
                        let other = &bsp.faces[index as usize];
                        other.plane == this.plane && (other.side != 0) == (this.side != 0)
                            || smoothing.joins(face, index)
                    })
            })
            .collect();
        Self { first, across }
    }

    /// The face that joins `face` across the edge from its corner `edge` to the next.
    pub fn across(&self, face: usize, edge: usize) -> Option<u32> {
        let range = self.first[face] as usize..self.first[face + 1] as usize;
        self.across[range].get(edge).copied().flatten()
    }
}
