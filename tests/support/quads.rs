//! Text scenes of rectangles cut into equal patches.

use glam::DVec3;
use qrad::patch::{CameraSpec, PatchEffects, Quad, TextPatches, TextScene};
use qrad::radiosity::hemicube::HemicubeSize;
use qrad::radiosity::transfers::Transfers;

/// Exitance and reflectance of a surface, the same in every channel.
#[derive(Clone, Copy, Debug)]
pub struct Light {
    pub exitance: f64,
    pub reflectance: f64,
}

pub const BLACK: Light = Light { exitance: 0.0, reflectance: 0.0 };

/// The parallelogram `origin + s u + t v`, s and t from 0 to 1, as `counts[0]` x `counts[1]` patches
/// that face u x v.
pub fn grid(origin: DVec3, u: DVec3, v: DVec3, counts: [usize; 2], light: Light) -> Vec<Quad> {
    let at = |i: usize, j: usize| {
        origin + u * (i as f64 / counts[0] as f64) + v * (j as f64 / counts[1] as f64)
    };
    let cell = |i, j| Quad {
        vertices: [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)],
        normal: u.cross(v).normalize(),
        exitance: [light.exitance; 3],
        reflectance: [light.reflectance; 3],
        effects: PatchEffects::default(),
    };
    (0..counts[0] * counts[1]).map(|k| cell(k % counts[0], k / counts[0])).collect()
}

/// The six sides of a box as n x n patches each, seen from inside or from outside.
pub fn cuboid(low: DVec3, high: DVec3, n: usize, inside: bool, light: Light) -> Vec<Quad> {
    let size = high - low;
    (0..6)
        .flat_map(|side| {
            let axis = side / 2;
            let along = |k: usize| DVec3::AXES[(axis + k) % 3] * size[(axis + k) % 3];
            let upper = side % 2 == 1;
            let origin = if upper { low + along(0) } else { low };
            let (u, v) = if upper == inside { (along(2), along(1)) } else { (along(1), along(2)) };
            grid(origin, u, v, [n, n], light)
        })
        .collect()
}

/// A scene with a camera that nobody looks through.
pub fn scene(patches: Vec<Quad>, hemicube: u32, passes: u32) -> TextScene {
    let camera = CameraSpec { position: DVec3::ZERO, look_at: DVec3::X, up: DVec3::Z };
    TextScene { camera, image: [8, 8], hemicube: [hemicube; 2], passes, patches }
}

/// The form factors between patches, with hemicubes of `hemicube` cells.
pub fn transfers(patches: &[Quad], hemicube: u32) -> (TextPatches, Transfers) {
    let patches = TextPatches::new(&scene(patches.to_vec(), hemicube, 0));
    let size = HemicubeSize::new(hemicube, hemicube).unwrap();
    let transfers = Transfers::compute(&patches.tracer, &patches.set, size, |_| {});
    (patches, transfers)
}
