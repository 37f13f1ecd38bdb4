//! A map as a player sees it: textured and lit, one ray a pixel.
//!
//! Brightness follows GLQuake with overbright light, as QuakeSpasm draws it: texel x lightmap x 2 / 255
//! with the lightmap cut at 255, so that light at most doubles a texture.

use super::Camera;
use super::MAX_PIXELS;
use super::drawn_faces::{DrawnFace, Material, drawn_faces, materials};
use super::fog::Fog;
use super::lightmaps::Lightmaps;
use super::texture::Texture;
use crate::Result;
use crate::bsp::{Bsp, Entity, MipTex, parse_entities};
use crate::scene::Tracer;
use glam::{DVec3, Vec3};
use image::RgbImage;
use rayon::prelude::*;

/// Coverage of a fence from which it is drawn.
const FENCE_THRESHOLD: f32 = 0.666;
/// Most see-through faces along a ray.
const MAX_LAYERS: usize = 64;
/// A ray that less light than this passes is complete.
const FAINT: f32 = 1.0 / 512.0;
/// How far a ray goes on behind a see-through face, in world units.
const STEP: f64 = 0.02;
/// Where to look again if a ray meets nothing, in pixels.
const BESIDE: f64 = 1.0 / 32.0;

/// A map ready to be drawn.
pub struct LitMap {
    faces: Vec<DrawnFace>,
    materials: Vec<Material>,
    nowhere: Texture,
    lightmaps: Lightmaps,
    fog: Option<Fog>,
    middle: Vec3,
}

impl LitMap {
    /// Takes the lightmaps of `bsp`, or their colours `rgb` (the content of a `.lit`, three bytes for
    /// each byte of the lighting lump). `missing` replaces textures that the map names but does not
    /// hold, by name without regard to case; what is not found either is drawn in grey squares.
    ///
    /// Faces whose lightmaps are not inside the lighting lump are drawn black, with a warning.
    ///
    /// # Errors
    /// If the entity text cannot be parsed or `rgb` does not fit the lighting lump.
    pub fn new(bsp: &Bsp, rgb: Option<&[u8]>, missing: &[MipTex]) -> Result<Self> {
        let entities = parse_entities(&bsp.entities)?;
        let lightmaps = Lightmaps::new(bsp, rgb)?;
        let nothing = Entity::default();
        let world = entities.first().unwrap_or(&nothing);
        let materials = materials(bsp, world, missing);
        let faces = drawn_faces(bsp, &entities, &materials, &lightmaps);
        let model = &bsp.models[0];
        let middle = model.mins.midpoint(model.maxs);
        Ok(Self {
            faces,
            materials,
            nowhere: Texture::checker(0, 0),
            lightmaps,
            fog: Fog::of(world),
            middle: if middle.is_finite() { middle } else { Vec3::ZERO },
        })
    }

    /// Middle of the world's bounds: a place for the eye in a map where
    /// [`start_camera`](super::start_camera) finds none.
    pub fn middle(&self) -> Vec3 {
        self.middle
    }

    /// The map as `camera` sees it. Where there is nothing, the picture is black.
    ///
    /// # Panics
    /// If the picture has more than [`MAX_PIXELS`].
    pub fn draw(&self, camera: &Camera) -> RgbImage {
        let pixels = u64::from(camera.width) * u64::from(camera.height);
        assert!(pixels <= MAX_PIXELS, "callers limit the size of pictures");
        let view = View::new(self, camera);
        let mut image = RgbImage::new(camera.width, camera.height);
        let row_bytes = 3 * camera.width as usize;
        image.par_chunks_exact_mut(row_bytes).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
                // A ray can slip between two faces that share an edge: look beside it then.
                let colour = view.colour(x, y).or_else(|| view.colour(x + BESIDE, y + BESIDE));
                let colour = colour.unwrap_or_default();
                pixel.copy_from_slice(&colour.map(|c| c.round() as u8));
            }
        });
        image
    }
}

/// What one camera sees.
struct View<'a> {
    map: &'a LitMap,
    camera: &'a Camera,
    /// The faces that turn their front to the eye.
    faces: Vec<&'a DrawnFace>,
    tracer: Tracer,
}

impl<'a> View<'a> {
    fn new(map: &'a LitMap, camera: &'a Camera) -> Self {
        // Backs are left out here once: both sides of a water surface lie in one plane, and a ray
        // cannot tell which it meets.
        let faces: Vec<&DrawnFace> =
            map.faces.iter().filter(|face| face.normal.dot(camera.position) > face.dist).collect();
        let tracer = Tracer::new(faces.iter().map(|face| face.polygon.clone()).collect());
        Self { map, camera, faces, tracer }
    }

    /// World direction through a picture point; its length along the view is 1.
    fn direction(&self, x: f64, y: f64) -> DVec3 {
        let ray = self.camera.ray(x, y);
        self.camera.right * ray.x + self.camera.up * ray.y + self.camera.forward * ray.z
    }

    /// Colour of the picture point (`x`, `y`), 0 to 255; `None` if there is nothing.
    fn colour(&self, x: f64, y: f64) -> Option<[f32; 3]> {
        let direction = self.direction(x, y);
        let neighbours = [self.direction(x + 1.0, y), self.direction(x, y + 1.0)];
        let step = STEP / direction.length();
        let mut colour = [0.0; 3];
        let mut passing = 1.0;
        let mut from = 0.0;
        for _ in 0..MAX_LAYERS {
            let origin = self.camera.position + direction * from;
            let hit = self.tracer.first_hit(origin.as_vec3(), direction.as_vec3(), f32::INFINITY);
            let Some(hit) = hit else { break };
            let face = self.faces[hit.polygon as usize];
            let near = from + f64::from(hit.distance);
            let seen = match face.material.map(|slot| &self.map.materials[slot]) {
                Some(Material::Sky(sky)) => {
                    let colour = sky.colour(direction);
                    Some(self.map.fog.map_or(colour, |fog| fog.sky(colour)))
                }
                Some(Material::Wall(texture) | Material::Liquid(texture, _)) => {
                    self.surface(face, texture, direction, neighbours, near)
                }
                Some(Material::Hidden) => None,
                None => self.surface(face, &self.map.nowhere, direction, neighbours, near),
            };
            if let Some(seen) = seen {
                let part = passing * face.alpha;
                colour = std::array::from_fn(|i| colour[i] + seen[i] * part);
                passing -= part;
                if passing < FAINT {
                    break;
                }
            }
            // Far away, single precision is coarser than the step.
            from = near + step.max(near * 2e-6);
        }
        (passing < 1.0).then_some(colour)
    }

    /// Colour of a face along a ray that meets it at `near`, in lengths of `direction`; `None` in a
    /// hole.
    fn surface(
        &self,
        face: &DrawnFace,
        texture: &Texture,
        direction: DVec3,
        neighbours: [DVec3; 2],
        near: f64,
    ) -> Option<[f32; 3]> {
        let eye = self.camera.position;
        // Where a ray meets the plane, which neighbouring rays may miss.
        let height = face.dist - face.normal.dot(eye);
        let meet = |ray: DVec3| {
            let distance = height / face.normal.dot(ray);
            (distance > 0.0).then_some(distance)
        };
        let depth = meet(direction).unwrap_or(near);
        let at = face.texture_at(eye + direction * depth);
        let [right, below] = neighbours.map(|ray| {
            meet(ray).map_or([f64::INFINITY; 2], |distance| face.texture_at(eye + ray * distance))
        });
        let sample = texture.sample(at, right, below);
        if sample.coverage < FENCE_THRESHOLD {
            return None;
        }
        let light = self.map.lightmaps.at(&face.light, at[0], at[1]);
        let colour = std::array::from_fn(|i| {
            (sample.lit[i] * light[i] * (2.0 / 255.0) + sample.glow[i]).min(255.0)
        });
        Some(self.map.fog.map_or(colour, |fog| fog.surface(colour, depth)))
    }
}
