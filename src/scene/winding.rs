//! The corner loop of a light surface, and the pieces that it is cut into.

use super::exact::{dot, normalize};
use glam::Vec3;

/// Drops the corners at which a polygon does not turn.
pub(super) fn without_colinear(v: &[Vec3]) -> Vec<Vec3> {
    const STRAIGHT: f32 = 1.0 - 0.0001;
    let n = v.len();
    let turns = |i: usize| {
        let (a, b, c) = (v[(i + n - 1) % n], v[i], v[(i + 1) % n]);
        dot(normalize(b - a), normalize(c - b)) < STRAIGHT
    };
    (0..n).filter(|&i| turns(i)).map(|i| v[i]).collect()
}

/// Plain mean of the corners.
pub(super) fn mean(v: &[Vec3]) -> Vec3 {
    v.iter().fold(Vec3::ZERO, |a, b| a + *b) / v.len() as f32
}

/// The most pieces of one face.
const PIECE_LIMIT: usize = 1 << 14;

/// Cuts a polygon along multiples of `size` on the axes; `None` if there would be too many pieces.
pub(super) fn dice(winding: &[Vec3], size: f32) -> Option<Vec<Vec<Vec3>>> {
    let (mut open, mut done) = (vec![winding.to_vec()], Vec::new());
    while let Some(piece) = open.pop() {
        if open.len() + done.len() > PIECE_LIMIT {
            return None;
        }
        let min = piece.iter().copied().reduce(Vec3::min)?;
        let max = piece.iter().copied().reduce(Vec3::max)?;
        let cut = (0..3).find_map(|axis| {
            let low = ((min[axis] + 1.0) / size).floor();
            let high = ((max[axis] - 1.0) / size).floor();
            (low < high).then_some((axis, size * (1.0 + low)))
        });
        match cut {
            Some((axis, at)) => {
                let (front, back) = clip(&piece, axis, at);
                if front.len() < 3 || back.len() < 3 {
                    done.push(piece);
                } else {
                    open.extend([back, front]);
                }
            }
            None => done.push(piece),
        }
    }
    Some(done)
}

/// The parts of a polygon above and below a plane across an axis. Corners at most 0.1 from it are
/// on it.
fn clip(piece: &[Vec3], axis: usize, at: f32) -> (Vec<Vec3>, Vec<Vec3>) {
    const ON: f32 = 0.1;
    let (mut front, mut back) = (Vec::new(), Vec::new());
    for (i, &a) in piece.iter().enumerate() {
        let b = piece[(i + 1) % piece.len()];
        let (da, db) = (a[axis] - at, b[axis] - at);
        if da >= -ON {
            front.push(a);
        }
        if da <= ON {
            back.push(a);
        }
        if da > ON && db < -ON || da < -ON && db > ON {
            let mut crossing = a + (b - a) * (da / (da - db));
            crossing[axis] = at;
            front.push(crossing);
            back.push(crossing);
        }
    }
    (front, back)
}

#[cfg(test)]
mod tests {
    use super::super::shape::area_and_centre;
    use super::*;

    fn rectangle(x: f32, y: f32) -> Vec<Vec3> {
        [[0.0, 0.0], [0.0, y], [x, y], [x, 0.0]].map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec()
    }

    #[test]
    fn colinear_corners_go() {
        let mut v = rectangle(8.0, 8.0);
        v.insert(1, Vec3::new(0.0, 4.0, 0.0));
        assert_eq!(without_colinear(&v), rectangle(8.0, 8.0));
    }

    #[test]
    fn a_plane_in_the_middle_makes_two_halves() {
        let (front, back) = clip(&rectangle(64.0, 64.0), 0, 32.0);
        for (half, low, high) in [(front, 32.0, 64.0), (back, 0.0, 32.0)] {
            assert_eq!(half.iter().copied().reduce(Vec3::min), Some(Vec3::new(low, 0.0, 0.0)));
            assert_eq!(half.iter().copied().reduce(Vec3::max), Some(Vec3::new(high, 64.0, 0.0)));
            assert_eq!(area_and_centre(&half).0, 2048.0);
        }
        let (front, back) = clip(&rectangle(64.0, 64.0), 0, 64.05);
        assert!(front.len() < 3 && area_and_centre(&back).0 == 4096.0, "as good as beside it");
    }

    #[test]
    fn dice_cover_the_polygon_and_keep_slivers() {
        let pieces = dice(&rectangle(48.0, 33.0), 16.0).unwrap();
        // The last unit is too thin to be cut off: 33 - 1 is not more than 32.
        assert_eq!(pieces.len(), 3 * 3);
        let area: f32 = pieces.iter().map(|p| area_and_centre(p).0).sum();
        assert!((area - 48.0 * 33.0).abs() < 0.01);
        assert!(dice(&rectangle(1e7, 1e7), 1.0).is_none());
    }
}
