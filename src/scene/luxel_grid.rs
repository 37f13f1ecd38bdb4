//! The luxels of a face, along its texture or along axes of their own (contract section 2.1).

use super::luxel_size::LuxelSize;
use super::shape::LuxelMap;
use super::surface::LuxelGrid;
use crate::bsp::{Bsp, TexInfo, extents};
use glam::{Vec3, Vec4};

/// The luxels of a face whose model is moved by `offset`; `None` if its axes do not span its plane or
/// it would have too many.
pub(crate) fn of_face(
    bsp: &Bsp,
    face: usize,
    texinfo: &TexInfo,
    size: LuxelSize,
    offset: Vec3,
) -> Option<(LuxelGrid, LuxelMap)> {
    let plane = bsp.face_plane(face);
    let (axes, texels) = match size {
        LuxelSize::Texels(texels) => (*texinfo, texels),
        LuxelSize::World(units) => (world_axes(plane.normal, units), 1),
    };
    let extents = extents(bsp.face_vertices(face), &axes, texels as f32).ok()?;
    let map = LuxelMap::new(&axes, plane, extents.mins, texels)?;
    let [s_row, t_row] = map.rows_at(offset);
    let [s_step, t_step] = map.steps();
    let [width, height] = extents.size;
    let origin = map.world_of(0.0, 0.0) + offset;
    Some((LuxelGrid { width, height, s_row, t_row, origin, s_step, t_step }, map))
}

/// Luxel axes in the coordinate plane that a face looks at most directly, `units` a luxel.
fn world_axes(normal: Vec3, units: f32) -> TexInfo {
    let [tangent, bitangent] = frame(normal);
    let row = |axis: Vec3| (axis / units).extend(0.0);
    let (s, t): (Vec4, Vec4) = (row(tangent), row(bitangent));
    TexInfo { s, t, miptex: -1, flags: 0 }
}

/// Tangent and bitangent of the axis nearest to a normal, on its side; the first axis wins ties.
fn frame(normal: Vec3) -> [Vec3; 2] {
    let size = normal.abs();
    let largest = (1..3).fold(0, |best, i| if size[i] > size[best] { i } else { best });
    let axis = Vec3::AXES[largest] * normal[largest].signum();
    let tangent = axis.cross(Vec3::AXES[(largest + 1) % 3]);
    let bitangent = axis.cross(Vec3::AXES[(largest + 2) % 3]);
    if tangent.cross(bitangent).dot(axis) < 0.0 {
        [bitangent, tangent]
    } else {
        [tangent, bitangent]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_right_handed_and_within_the_plane() {
        for normal in [
            Vec3::X,
            -Vec3::Y,
            Vec3::NEG_Z,
            Vec3::new(0.6, -0.8, 0.0),
            Vec3::new(1.0, 1.0, 1.0).normalize(),
        ] {
            let [t, b] = frame(normal);
            let axis = t.cross(b);
            assert!(axis.dot(normal) >= normal.abs().max_element() - 1e-6, "{normal}");
            assert_eq!([t.length(), b.length(), t.dot(b)], [1.0, 1.0, 0.0]);
        }
        assert_eq!(frame(Vec3::Z), [Vec3::Y, -Vec3::X]);
    }
}
