//! Scenes as plain text: a camera, sizes and a list of flat one-sided quads. The grammar is in
//! `docs/cornell-format.md`.
//!
//! Numbers stay in double precision and are written with the fewest digits that read back to the
//! same value, so what a program does not change comes out with the value it came in with.

use super::Pattern;
use super::text_check::{check_camera, check_light, check_quad, check_sizes, let_light_settle};
use super::text_effects::PatchEffects;
use super::text_lines::{Line, lines, place};
use crate::{Error, Result};
use glam::DVec3;
use std::fmt::Write as _;

/// A scene as its text file says it.
#[derive(Clone, Debug, PartialEq)]
pub struct TextScene {
    /// Where the picture is taken from.
    pub camera: CameraSpec,
    /// Width and height of the picture in pixels, each from 1 to [`super::MAX_IMAGE`].
    pub image: [u32; 2],
    /// Width and height of the hemicube's top in cells: even, from 2 to [`super::MAX_HEMICUBE`].
    pub hemicube: [u32; 2],
    /// Lighting passes (gathers) to run at most. None are run for 0.
    pub passes: u32,
    /// The patches in file order; a patch's id is its place in this list.
    pub patches: Vec<Quad>,
}

/// The camera line of a scene. View direction and `up` are not zero and not parallel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraSpec {
    /// Eye point.
    pub position: DVec3,
    /// A point in the middle of the picture.
    pub look_at: DVec3,
    /// A direction that points up in the picture; of any length.
    pub up: DVec3,
}

impl CameraSpec {
    /// Unit forward, right and up directions, at right angles to each other (right-handed:
    /// right = forward x up). `None` if the camera looks nowhere or along its up direction.
    pub fn basis(&self) -> Option<[DVec3; 3]> {
        let forward = (self.look_at - self.position).try_normalize()?;
        let right = forward.cross(self.up.try_normalize()?);
        if right.length() < 1e-6 {
            return None;
        }
        let right = right.normalize();
        Some([forward, right, right.cross(forward)])
    }
}

/// A flat convex diffuse patch. Light meets it and leaves it on the side of its normal; its back
/// only blocks, unless its [`PatchEffects`] say otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    /// Corners, counter-clockwise seen from the side of the normal. Two may coincide.
    pub vertices: [DVec3; 4],
    /// Normal as in the file: of unit length within 0.001. See [`Quad::unit_normal`].
    pub normal: DVec3,
    /// Light that the patch gives off by itself, per unit area; RGB, from 0 to 1. Zero in a lit
    /// scene.
    pub exitance: [f64; 3],
    /// Share of the incident light that is sent back, RGB, from 0 to 1; in each channel at least
    /// one patch of a scene stays at or below [`super::MAX_REFLECTANCE`].
    /// In a lit scene the final exitance is here instead: from 0 up, not clamped.
    pub reflectance: [f64; 3],
    /// What else it does to light; nothing by default.
    pub effects: PatchEffects,
}

impl Quad {
    /// Unit normal of the vertices' plane on the lit side, from the diagonals' cross product: more
    /// exact than the digits of [`Quad::normal`].
    pub fn unit_normal(&self) -> DVec3 {
        let [a, b, c, d] = self.vertices;
        (c - a).cross(d - b).normalize()
    }
}

/// How the second triple of a patch is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// As reflectance: from 0 to 1.
    Raw,
    /// As final exitance: from 0 up, taken as it is.
    Lit,
}

/// Something of the file that was set right while reading.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Repair {
    /// Line of the file, counted from 1.
    pub line: usize,
    /// What was wrong and what it became.
    pub what: String,
}

/// Repairs that are logged one by one; the rest is counted.
const REPAIRS_SHOWN: usize = 10;

impl TextScene {
    /// Reads a scene to be lit. `name` is the file as messages should call it. Repairs are logged
    /// as warnings.
    ///
    /// # Errors
    /// [`Error::Format`] with the line for everything that breaks the format.
    pub fn parse(text: &str, name: &str) -> Result<Self> {
        Self::parse_logged(text, name, Reading::Raw)
    }

    /// Reads a scene to be drawn, lit or not: as [`TextScene::parse`], but the second triple of a
    /// patch may exceed 1.
    ///
    /// # Errors
    /// [`Error::Format`] with the line for everything that breaks the format.
    pub fn parse_lit(text: &str, name: &str) -> Result<Self> {
        Self::parse_logged(text, name, Reading::Lit)
    }

    fn parse_logged(text: &str, name: &str, reading: Reading) -> Result<Self> {
        let (scene, repairs) = Self::parse_repaired(text, name, reading)?;
        for repair in repairs.iter().take(REPAIRS_SHOWN) {
            log::warn!("{}: {}", place(name, repair.line), repair.what);
        }
        if repairs.len() > REPAIRS_SHOWN {
            log::warn!("{name}: {} more repairs of this kind", repairs.len() - REPAIRS_SHOWN);
        }
        Ok(scene)
    }

    /// Reads a scene and hands back what was repaired, in file order, logging nothing.
    ///
    /// # Errors
    /// [`Error::Format`] with the line for everything that breaks the format.
    pub fn parse_repaired(text: &str, name: &str, reading: Reading) -> Result<(Self, Vec<Repair>)> {
        let end = text.lines().count() + 1;
        let mut lines = lines(text);
        let mut next = |what: &str| {
            lines.next().ok_or_else(|| {
                Error::format(place(name, end), format!("the file ends where {what} should be"))
            })
        };
        let at = |line: Line<'_>| {
            let number = line.number;
            move |problem: String| Error::format(place(name, number), problem)
        };

        let line = next("the camera's position, look-at point and up direction")?;
        let camera = read_camera(line).map_err(at(line))?;
        let line = next("image size, hemicube size and passes")?;
        let [image_w, image_h, cube_w, cube_h, passes] =
            line.counts("image size, hemicube size, passes").map_err(at(line))?;
        let (image, hemicube) = ([image_w, image_h], [cube_w, cube_h]);
        check_sizes(image, hemicube).map_err(at(line))?;

        let mut patches = Vec::new();
        let mut repairs = Vec::new();
        let mut line = next("the vertices and normal of the first patch")?;
        loop {
            let numbers: [_; 15] = line.floats("four vertices and a normal").map_err(at(line))?;
            let [a, b, c, d, normal] = triples(numbers);
            let quad = check_quad([a, b, c, d], normal).map_err(at(line))?;
            let vertices_line = line.number;
            repairs
                .extend(quad.repairs.into_iter().map(|what| Repair { line: vertices_line, what }));

            let missing = format!("exitance and reflectance of patch {}", patches.len());
            line = next(&missing)?;
            let (numbers, words) = line.words_after(6);
            let [r, g, b, second_r, second_g, second_b] =
                numbers.floats("exitance and reflectance").map_err(at(line))?;
            let (exitance, reflectance) = ([r, g, b], [second_r, second_g, second_b]);
            check_light(exitance, reflectance, reading).map_err(at(line))?;
            let effects = PatchEffects::read(words, reading).map_err(at(line))?;
            if reading == Reading::Raw {
                effects.check(reflectance).map_err(at(line))?;
            }
            let (vertices, normal) = (quad.vertices, quad.normal);
            patches.push(Quad { vertices, normal, exitance, reflectance, effects });
            match next("another patch") {
                Ok(another) => line = another,
                Err(_) => break,
            }
        }
        if reading == Reading::Raw {
            let repair = let_light_settle(&mut patches);
            repairs.extend(repair.map(|what| Repair { line: line.number, what }));
        }
        Ok((Self { camera, image, hemicube, passes, patches }, repairs))
    }

    /// The lit scene: each patch's final exitance in place of its reflectance, and zeros in place
    /// of its initial exitance. Values are kept as they are, above 1 too. `exitance` has one entry a
    /// patch and then one for the back of each patch with two sides, in file order: means over the patch,
    /// of which the file has the value where the shader's factor is 1.
    ///
    /// # Panics
    /// If there is not one exitance a side.
    pub fn lit(&self, exitance: &[[f64; 3]]) -> Self {
        assert!(exitance.len() >= self.patches.len(), "one exitance a patch");
        let (fronts, backs) = exitance.split_at(self.patches.len());
        let mut backs = backs.iter().copied();
        let patches = self
            .patches
            .iter()
            .zip(fronts)
            .map(|(quad, &mean)| {
                let pattern = quad.effects.shader.map(|s| Pattern::over(s, quad.vertices));
                let shown = |mean: [f64; 3]| match &pattern {
                    None => mean,
                    Some(pattern) => pattern.over_mean(mean.into()).to_array(),
                };
                let back = quad.effects.has_two_sides().then(|| backs.next().expect("a back"));
                let effects = quad.effects.lit(back.map(shown));
                Quad { exitance: [0.0; 3], reflectance: shown(mean), effects, ..*quad }
            })
            .collect();
        assert_eq!(backs.next(), None, "one exitance a patch, and one a back");
        Self { patches, ..self.clone() }
    }

    /// The scene as text. Every number has the fewest digits that read back to the same value.
    pub fn to_text(&self) -> String {
        let mut text = String::with_capacity(128 + 192 * self.patches.len());
        let CameraSpec { position, look_at, up } = self.camera;
        write_floats(&mut text, [position, look_at, up].iter().flat_map(DVec3::to_array));
        let ([w, h], [cube_w, cube_h]) = (self.image, self.hemicube);
        text.push_str(&format!("{w} {h} {cube_w} {cube_h} {}\n", self.passes));
        for quad in &self.patches {
            let points = quad.vertices.iter().chain([&quad.normal]);
            write_floats(&mut text, points.flat_map(DVec3::to_array));
            write_floats(&mut text, quad.exitance.into_iter().chain(quad.reflectance));
            if quad.effects != PatchEffects::default() {
                text.pop();
                quad.effects.write(&mut text);
                text.push('\n');
            }
        }
        text
    }
}

fn read_camera(line: Line<'_>) -> std::result::Result<CameraSpec, String> {
    let numbers: [_; 9] = line.floats("camera position, look-at point, up direction")?;
    let [position, look_at, up] = triples(numbers);
    let camera = CameraSpec { position, look_at, up };
    check_camera(&camera)?;
    Ok(camera)
}

/// Regroups 3 x `N` numbers as `N` points.
fn triples<const N: usize, const M: usize>(numbers: [f64; M]) -> [DVec3; N] {
    std::array::from_fn(|i| DVec3::from_slice(&numbers[3 * i..]))
}

/// Appends one line.
fn write_floats(text: &mut String, numbers: impl Iterator<Item = f64>) {
    for (i, x) in numbers.enumerate() {
        if i > 0 {
            text.push(' ');
        }
        write_number(text, x);
    }
    text.push('\n');
}

/// Appends a number. Very small and very large ones get an exponent instead of zeros.
pub(super) fn write_number(text: &mut String, x: f64) {
    let plain = x == 0.0 || (1e-5..1e16).contains(&x.abs());
    // Writing to a String cannot fail.
    let _ = if plain { write!(text, "{x}") } else { write!(text, "{x:e}") };
}
