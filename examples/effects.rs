//! Makes the scenes and the map of docs/effects.md: `effects FOLDER` writes `cornell/stained_glass.txt`,
//! `cornell/lantern.txt`, `cornell/curtain.txt`, `through.bsp` and `through.materials.toml` there.

#[allow(dead_code)]
#[path = "../tests/support/map_builder.rs"]
mod map_builder;

use glam::DVec3;
use map_builder::MapBuilder;
use qrad::bsp::{Format, PALETTE};
use qrad::patch::{CameraSpec, PatchEffects, Quad, Shader, TextScene};
use std::path::Path;

const GREY: [f64; 3] = [0.7, 0.69, 0.66];
const WARM: [f64; 3] = [1.0, 0.82, 0.55];
const DARK: [f64; 3] = [0.0; 3];

fn main() -> anyhow::Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "maps".into());
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder.join("cornell"))?;
    for (name, scene) in
        [("stained_glass", stained_glass()), ("lantern", lantern()), ("curtain", curtain())]
    {
        std::fs::write(folder.join("cornell").join(name).with_extension("txt"), scene.to_text())?;
    }
    std::fs::write(folder.join("through.bsp"), map().build(Format::Bsp29).write()?)?;
    std::fs::write(folder.join("through.materials.toml"), MATERIALS)?;
    Ok(())
}

/// A list of quads that grows by rectangles.
#[derive(Default)]
struct Quads(Vec<Quad>);

impl Quads {
    /// The rectangle `origin + s u + t v` as n x m patches that face u x v.
    fn add(
        &mut self,
        [origin, u, v]: [[f64; 3]; 3],
        [n, m]: [usize; 2],
        (exitance, reflectance): ([f64; 3], [f64; 3]),
        effects: PatchEffects,
    ) {
        let [origin, u, v] = [origin, u, v].map(DVec3::from_array);
        let at =
            |i: usize, j: usize| origin + u * (i as f64 / n as f64) + v * (j as f64 / m as f64);
        for k in 0..n * m {
            let (i, j) = (k % n, k / n);
            let vertices = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let normal = u.cross(v).normalize();
            self.0.push(Quad { vertices, normal, exitance, reflectance, effects });
        }
    }

    fn plain(&mut self, at: [[f64; 3]; 3], counts: [usize; 2], reflectance: [f64; 3]) {
        self.add(at, counts, (DARK, reflectance), PatchEffects::default());
    }

    /// A room from 0 0 0 without its wall at z = 0, so that the camera sees in.
    fn room(
        &mut self,
        [x, y, z]: [f64; 3],
        [nx, ny, nz]: [usize; 3],
        [left, right]: [[f64; 3]; 2],
    ) {
        self.plain([[0.0; 3], [0.0, 0.0, z], [x, 0.0, 0.0]], [nz, nx], GREY);
        self.plain([[0.0, y, 0.0], [x, 0.0, 0.0], [0.0, 0.0, z]], [nx, nz], GREY);
        self.plain([[0.0, 0.0, z], [0.0, y, 0.0], [x, 0.0, 0.0]], [ny, nx], GREY);
        self.plain([[0.0; 3], [0.0, y, 0.0], [0.0, 0.0, z]], [ny, nz], right);
        self.plain([[x, 0.0, 0.0], [0.0, 0.0, z], [0.0, y, 0.0]], [nz, ny], left);
    }

    fn scene(self, position: [f64; 3], look_at: [f64; 3]) -> TextScene {
        let [position, look_at] = [position, look_at].map(DVec3::from_array);
        let camera = CameraSpec { position, look_at, up: DVec3::Y };
        TextScene { camera, image: [360, 300], hemicube: [64; 2], passes: 200, patches: self.0 }
    }
}

/// A window of coloured panes between a lamp and a room.
fn stained_glass() -> TextScene {
    // Where patches of the walls meet.
    const WINDOW: f64 = 5.0 * 10.0 / 15.0;
    let mut quads = Quads::default();
    quads.room([4.0, 3.0, 5.0], [12, 9, 15], [GREY; 2]);
    // The wall with the window, seen from both rooms.
    let wall = PatchEffects { two_sided: true, ..PatchEffects::default() };
    let mut piece = |x: [f64; 2], y: [f64; 2], counts: [usize; 2]| {
        let at = [[x[0], y[0], WINDOW], [0.0, y[1] - y[0], 0.0], [x[1] - x[0], 0.0, 0.0]];
        quads.add(at, counts, (DARK, GREY), wall);
    };
    piece([0.0, 1.0], [0.0, 3.0], [6, 2]);
    piece([3.0, 4.0], [0.0, 3.0], [6, 2]);
    piece([1.0, 3.0], [0.0, 0.5], [1, 4]);
    piece([1.0, 3.0], [2.5, 3.0], [1, 4]);
    const COLOURS: [[f64; 3]; 5] =
        [[0.9, 0.08, 0.06], [0.1, 0.25, 0.9], [0.95, 0.75, 0.1], [0.1, 0.65, 0.2], [0.6, 0.1, 0.6]];
    for i in 0..4 {
        for j in 0..4 {
            let colour = COLOURS[(3 * i + 2 * j) % 5];
            let effects = PatchEffects { straight: Some(colour), ..PatchEffects::default() };
            let at = [
                [1.0 + 0.5 * i as f64, 0.5 + 0.5 * j as f64, WINDOW],
                [0.0, 0.5, 0.0],
                [0.5, 0.0, 0.0],
            ];
            quads.add(at, [1, 1], (DARK, [0.02; 3]), effects);
        }
    }
    let lamp = [[1.75, 2.5, 4.99], [0.0, 0.4, 0.0], [0.5, 0.0, 0.0]];
    quads.add(lamp, [1, 1], ([1.0; 3], DARK), PatchEffects::default());
    quads.scene([2.0, 1.5, -4.6], [2.0, 1.45, 2.0])
}

/// A paper lantern in a dark room.
fn lantern() -> TextScene {
    let mut quads = Quads::default();
    quads.room([4.0, 3.0, 4.0], [8, 6, 8], [[0.5, 0.2, 0.15], [0.2, 0.35, 0.5]]);
    let paper = PatchEffects {
        diffuse: Some([0.5, 0.45, 0.35]),
        shader: Some(Shader::Checker([1, 2], [0.75, 0.6, 0.5])),
        ..PatchEffects::default()
    };
    let sides = 8;
    let corner = |k: usize| {
        let angle = std::f64::consts::TAU * (k % sides) as f64 / sides as f64;
        (2.0 + 0.55 * angle.cos(), 2.2 + 0.55 * angle.sin())
    };
    for k in 0..sides {
        let ((x0, z0), (x1, z1)) = (corner(k), corner(k + 1));
        let at = [[x0, 1.1, z0], [0.0, 1.0, 0.0], [x1 - x0, 0.0, z1 - z0]];
        quads.add(at, [3, 1], (DARK, [0.45, 0.4, 0.35]), paper);
    }
    // The flame, a small box.
    let (low, high, s) = (1.45, 1.75, 0.1);
    let flame = |quads: &mut Quads, at| {
        quads.add(at, [1, 1], (WARM, DARK), PatchEffects::default());
    };
    for [x0, z0, x1, z1] in [[-s, -s, s, -s], [s, -s, s, s], [s, s, -s, s], [-s, s, -s, -s]] {
        let up = [0.0, high - low, 0.0];
        flame(&mut quads, [[2.0 + x0, low, 2.2 + z0], up, [x1 - x0, 0.0, z1 - z0]]);
    }
    let (x, z) = (2.0 - s, 2.2 - s);
    flame(&mut quads, [[x, high, z], [0.0, 0.0, 2.0 * s], [2.0 * s, 0.0, 0.0]]);
    flame(&mut quads, [[x, low, z], [2.0 * s, 0.0, 0.0], [0.0, 0.0, 2.0 * s]]);
    quads.scene([2.0, 1.5, -4.8], [2.0, 1.4, 2.0])
}

/// A lit and a dark room with a red curtain between.
fn curtain() -> TextScene {
    let mut quads = Quads::default();
    quads.room([6.0, 3.0, 4.0], [12, 6, 8], [GREY; 2]);
    let cloth = PatchEffects { diffuse: Some([0.6, 0.1, 0.08]), ..PatchEffects::default() };
    // In folds, with a gap at the open side.
    let fold = |k: usize| 3.0 + if k.is_multiple_of(2) { 0.0 } else { 0.25 };
    for k in 0..12 {
        let (z0, z1) = (0.4 + 0.3 * k as f64, 0.7 + 0.3 * k as f64);
        let at = [[fold(k), 0.0, z0], [0.0, 3.0, 0.0], [fold(k + 1) - fold(k), 0.0, z1 - z0]];
        quads.add(at, [6, 1], (DARK, [0.3, 0.08, 0.06]), cloth);
    }
    let lamp = [[4.4, 2.99, 1.5], [0.6, 0.0, 0.0], [0.0, 0.0, 0.6]];
    quads.add(lamp, [1, 1], ([1.0, 0.95, 0.85], DARK), PatchEffects::default());
    quads.scene([3.0, 1.5, -5.6], [3.0, 1.45, 2.0])
}

/// Palette index of the nearest colour.
fn colour(rgb: [u8; 3]) -> u8 {
    let distance = |c: &[u8; 3]| -> i32 {
        c.iter().zip(rgb).map(|(a, b)| (i32::from(*a) - i32::from(b)).pow(2)).sum()
    };
    // Fullbright colours are for what shines.
    (0..224u8).min_by_key(|&i| distance(&PALETTE[usize::from(i)])).expect("colours")
}

const MATERIALS: &str = "\
# What the textures of through.bsp do to light; see docs/materials.md.

[[material]]
texture = \"cloth\"
reflectance = [0.35, 0.06, 0.05]
diffuse_transmission = [0.5, 0.07, 0.06]

[[material]]
texture = \"paper\"
reflectance = [0.5, 0.45, 0.35]
diffuse_transmission = [0.45, 0.4, 0.3]

[[material]]
texture = \"stars\"
emission = { intensity = 60, parts = \"fullbright\" }

[[material]]
texture = \"floor\"
modifier = { kind = \"checker\", size = 64, colour = 0.3 }
";

/// Three rooms in a row: behind stained glass, with a lantern, behind a curtain.
fn map() -> MapBuilder {
    let panes: Vec<u8> = (0..64 * 64)
        .map(|k| {
            let (column, row) = (k % 64 / 16, k / 64 / 16);
            let colours = [[200, 30, 20], [40, 60, 200], [230, 180, 40], [60, 140, 50]];
            colour(colours[(column + 3 * row) % 4])
        })
        .collect();
    // A fullbright square on a dark ceiling.
    let stars: Vec<u8> = (0..64 * 64)
        .map(|k| {
            let near = |x: usize| (26..38).contains(&x);
            if near(k % 64) && near(k / 64) { 253 } else { colour([60, 60, 70]) }
        })
        .collect();
    let entity = |keys: &[(&str, &str)]| {
        let keys: String = keys.iter().map(|(k, v)| format!("\"{k}\" \"{v}\"\n")).collect();
        format!("{{\n{keys}}}\n")
    };
    let light = |origin: &str, light: &str| {
        entity(&[("classname", "light"), ("origin", origin), ("light", light)])
    };
    let entities = [
        entity(&[("classname", "worldspawn"), ("message", "Light that comes through")]),
        entity(&[("classname", "info_player_start"), ("origin", "100 -60 24"), ("angle", "150")]),
        entity(&[("classname", "func_wall"), ("model", "*1"), ("alpha", "0.9"), ("_shadow", "1")]),
        light("-150 0 100", "450"),
        light("120 60 60", "120"),
        light("300 20 90", "230"),
    ]
    .concat();
    let mut map = MapBuilder::room([-256.0, -128.0, 0.0], [384.0, 128.0, 128.0])
        .solid_texture("wall", colour([150, 145, 135]))
        .solid_texture("floor", colour([140, 120, 90]))
        .texture("stars", 64, 64, stars)
        .solid_texture("cloth", colour([140, 40, 30]))
        .solid_texture("paper", colour([190, 170, 130]))
        .texture("panes", 64, 64, panes)
        .room_textures([0, 0, 0, 0, 1, 2])
        .subdivide(128.0)
        // The wall with the window.
        .pillar([0.0, -128.0, 0.0], [8.0, -48.0, 128.0], 0)
        .pillar([0.0, 48.0, 0.0], [8.0, 128.0, 128.0], 0)
        .model([2.0, -48.0, 0.0], [6.0, 48.0, 128.0], Some(5))
        // The curtain.
        .pillar([220.0, -96.0, 0.0], [224.0, 128.0, 128.0], 3)
        .entities(entities);
    // The lantern: four sheets that leave the corners open.
    let (x, y, size, low, high) = (120.0, 60.0, 16.0, 40.0, 84.0);
    for side in [-1.0, 1.0] {
        let near = |c: f32| [c + side * size - 1.0, c + side * size + 1.0];
        let ([x0, x1], [y0, y1]) = (near(x), near(y));
        let inner = size - 2.0;
        map = map.pillar([x0, y - inner, low], [x1, y + inner, high], 4).pillar(
            [x - inner, y0, low],
            [x + inner, y1, high],
            4,
        );
    }
    map
}
