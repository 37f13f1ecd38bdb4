//! Which faces of a map are drawn, where and how.

use super::lightmaps::{Light, Lightmaps};
use super::sky::Sky;
use super::start_camera::origin;
use super::texture::Texture;
use crate::bsp::{Bsp, Entity, MipTex, find_texture};
use crate::scene::Polygon;
use glam::{DVec3, DVec4, Vec3};

/// Textures that only tools see.
const TOOL_TEXTURES: [&str; 3] = ["trigger", "skip", "clip"];
/// Brush entities that games hide or take away when a map starts, besides triggers.
const HIDDEN_CLASSES: [&str; 3] = ["func_episodegate", "func_ladder", "func_shadow"];
/// Spawn flag of entities that are not there at normal skill.
const NOT_AT_NORMAL_SKILL: i64 = 512;
/// `TEX_SPECIAL`: the face has no lightmap.
const SPECIAL: i32 = 1;
/// Points farther out are not drawn, in world units: distances would lose all precision.
const FARTHEST: f32 = 1e7;

/// What a face is made of.
pub(super) enum Material {
    /// Nothing to see.
    Hidden,
    /// Part of the sky.
    Sky(Sky),
    /// A wall with its texture.
    Wall(Texture),
    /// A liquid with its texture and the part of light that it hides.
    Liquid(Texture, f32),
}

/// A face with what is needed to draw it.
pub(super) struct DrawnFace {
    /// Where it is in the world.
    pub polygon: Polygon,
    /// Its plane in the world: `normal . p = dist`.
    pub normal: DVec3,
    /// See `normal`.
    pub dist: f64,
    /// Added to the model's coordinates to give the world's.
    pub offset: DVec3,
    /// Axes of the texture, in the model's coordinates.
    pub axes: [DVec4; 2],
    /// Index of its material; `None`: its texture is not in the map.
    pub material: Option<usize>,
    /// Light on it.
    pub light: Light,
    /// Part of light from behind that it hides, 0 to 1.
    pub alpha: f32,
}

impl DrawnFace {
    /// Texture coordinates of a point of the world, in texels.
    pub fn texture_at(&self, point: DVec3) -> [f64; 2] {
        let point = (point - self.offset).extend(1.0);
        self.axes.map(|axis| axis.dot(point))
    }
}

/// The materials of the map, one for each slot of its texture lump.
pub(super) fn materials(bsp: &Bsp, world: &Entity, missing: &[MipTex]) -> Vec<Material> {
    let of = |texture: &Option<MipTex>| {
        let Some(miptex) = texture else { return Material::Wall(Texture::checker(0, 0)) };
        let name = miptex.name.to_ascii_lowercase();
        if TOOL_TEXTURES.contains(&name.as_str()) || name.starts_with("hint") {
            return Material::Hidden;
        }
        let replacement = find_texture(missing, &miptex.name);
        if name.starts_with("sky") {
            let sky = Sky::new(miptex).or_else(|| replacement.and_then(Sky::new));
            if let Some(sky) = sky {
                return Material::Sky(sky);
            }
        }
        let texture = Texture::new(miptex, replacement);
        if name.starts_with('*') {
            return Material::Liquid(texture, liquid_alpha(world, &name));
        }
        Material::Wall(texture)
    };
    bsp.textures.iter().map(of).collect()
}

/// How opaque a liquid is, from the worldspawn.
fn liquid_alpha(world: &Entity, name: &str) -> f32 {
    let key = match name {
        _ if name.starts_with("*lava") => "lavaalpha",
        _ if name.starts_with("*slime") => "slimealpha",
        _ if name.starts_with("*tele") => "telealpha",
        _ => "wateralpha",
    };
    let alpha = world.setting(key).and_then(|text| text.trim().parse().ok());
    alpha.filter(|alpha| (0.0..=1.0).contains(alpha)).unwrap_or(1.0)
}

/// A brush model, where it is drawn and how opaque it is; 0: as its textures say.
struct Placed {
    model: usize,
    offset: Vec3,
    alpha: f32,
}

/// The world and the brush models of entities that are seen when a map starts.
fn placed_models(bsp: &Bsp, entities: &[Entity]) -> Vec<Placed> {
    let mut placed = vec![Placed { model: 0, offset: Vec3::ZERO, alpha: 0.0 }];
    let mut faces = 0;
    for entity in entities {
        let class = entity.classname();
        let number = entity.get("model").and_then(|model| model.strip_prefix('*')?.parse().ok());
        let Some(model) = number.filter(|model| (1..bsp.models.len()).contains(model)) else {
            continue;
        };
        let flags: f64 =
            entity.get("spawnflags").and_then(|t| t.trim().parse().ok()).unwrap_or(0.0);
        if class.starts_with("trigger_")
            || HIDDEN_CLASSES.contains(&class)
            || flags as i64 & NOT_AT_NORMAL_SKILL != 0
        {
            continue;
        }
        let alpha: f32 = entity.get("alpha").and_then(|t| t.trim().parse().ok()).unwrap_or(0.0);
        if alpha < 0.0 {
            continue; // Engines do not draw these.
        }
        // Entities may share a model, but not so often that a small file stands for a huge scene.
        faces += u64::from(bsp.models[model].face_count);
        if faces > 16 * bsp.faces.len() as u64 {
            log::warn!("preview: brush models are shared again and again, the rest is not drawn");
            break;
        }
        let offset = origin(entity).unwrap_or(Vec3::ZERO);
        placed.push(Placed { model, offset, alpha: alpha.min(1.0) });
    }
    placed
}

/// All faces that are drawn. Faces with damaged lightmaps are dark, with one warning for all.
pub(super) fn drawn_faces(
    bsp: &Bsp,
    entities: &[Entity],
    materials: &[Material],
    lightmaps: &Lightmaps,
) -> Vec<DrawnFace> {
    let mut drawn = Vec::new();
    let mut damaged = Vec::new();
    for Placed { model, offset, alpha } in placed_models(bsp, entities) {
        let first = bsp.models[model].first_face as usize;
        for face in first..first + bsp.models[model].face_count as usize {
            let Some(texinfo) = bsp.texinfo_of(face) else { continue };
            let material =
                usize::try_from(texinfo.miptex).ok().filter(|&slot| slot < materials.len());
            let kind = material.map(|slot| &materials[slot]);
            let vertices: Vec<Vec3> = bsp.face_vertices(face).map(|v| v + offset).collect();
            let too_far = |v: &Vec3| v.is_nan() || v.abs().max_element() > FARTHEST;
            if matches!(kind, Some(Material::Hidden))
                || vertices.len() < 3
                || vertices.iter().any(too_far)
            {
                continue;
            }
            let own_alpha = if let Some(Material::Liquid(_, alpha)) = kind { *alpha } else { 1.0 };
            // Liquids are lit if they have lightmaps.
            let unlit = match kind {
                Some(Material::Sky(_)) => true,
                Some(Material::Liquid(..)) => bsp.faces[face].light_offset < 0,
                _ => false,
            } || texinfo.flags & SPECIAL != 0;
            let light = if unlit {
                // Half of full light leaves a texture as it is.
                Light::Even(Lightmaps::FULL / 2.0)
            } else {
                lightmaps.of_face(bsp, face).unwrap_or_else(|problem| {
                    damaged.push(problem);
                    Light::Even(0.0)
                })
            };
            let plane = bsp.face_plane(face);
            let normal = plane.normal.as_dvec3();
            let offset = offset.as_dvec3();
            drawn.push(DrawnFace {
                polygon: Polygon { vertices, normal: plane.normal },
                normal,
                dist: f64::from(plane.dist) + normal.dot(offset),
                offset,
                axes: [texinfo.s.as_dvec4(), texinfo.t.as_dvec4()],
                material,
                light,
                alpha: if alpha > 0.0 { alpha } else { own_alpha },
            });
        }
    }
    if let Some(problem) = damaged.first() {
        log::warn!("preview: {problem}: drawn black, like {} more faces", damaged.len() - 1);
    }
    drawn
}
