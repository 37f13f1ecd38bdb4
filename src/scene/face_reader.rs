//! What a scene holds of each face: surface, shape, luxels, names (contract sections 2.1, 3.1 and 3.2).

use super::luxel_grid;
use super::luxel_size::{LuxelSize, LuxelSizes};
use super::material_file::MaterialFile;
use super::materials::Materials;
use super::minlight::Minlight;
use super::models::{Model, ShadowClass};
use super::obstacles::is_fence;
use super::phong::Wish;
use super::shading::Shading;
use super::shape::{AREA_EPS, LuxelMap, Shape, area_and_centre};
use super::sidecar::{SurflightKeys, TexInfoKeys};
use super::surface::{LuxelGrid, Role, Surface};
use super::texels::Texels;
use super::world::WorldSettings;
use crate::bsp::{Bsp, MipTex, TexInfo};
use crate::{Error, Result};
use glam::Vec3;
use std::sync::Arc;

/// Bit of the texinfo flags that says "no lightmap".
const TEX_SPECIAL: i32 = 1;
/// The most samples of luxels that a map may have: some gigabytes of working memory, a hundred large
/// maps.
const SAMPLE_LIMIT: u64 = 1 << 26;

/// Reads faces one by one into the columns of the scene.
pub(super) struct FaceReader<'a> {
    bsp: &'a Bsp,
    models: &'a [Model],
    keys: &'a [TexInfoKeys],
    materials: &'a Materials,
    world: &'a WorldSettings,
    sizes: LuxelSizes<'a>,
    /// What a material file says, and the pixels that the map may lack.
    pub file: &'a MaterialFile,
    pub textures: &'a [MipTex],
    owners: Vec<Option<u32>>,
    pub surfaces: Vec<Surface>,
    pub shapes: Vec<Shape>,
    pub luxel_maps: Vec<Option<LuxelMap>>,
    pub names: Vec<String>,
    pub groups: Vec<i32>,
    pub wishes: Vec<Wish>,
    pub emissive: Vec<SurflightKeys>,
    pub shadings: Vec<Option<Arc<Shading>>>,
    pub samples_a_luxel: u64,
    sample_count: u64,
    degenerate: Problem,
    bad_axes: Problem,
}

impl<'a> FaceReader<'a> {
    pub fn new(
        bsp: &'a Bsp,
        models: &'a [Model],
        keys: &'a [TexInfoKeys],
        materials: &'a Materials,
        (world, sizes): (&'a WorldSettings, LuxelSizes<'a>),
        (file, textures): (&'a MaterialFile, &'a [MipTex]),
    ) -> Self {
        let mut owners = vec![None; bsp.faces.len()];
        for (index, model) in bsp.models.iter().enumerate() {
            let first = model.first_face as usize;
            let range = first..first.saturating_add(model.face_count as usize);
            for owner in owners.get_mut(range).unwrap_or(&mut []) {
                *owner = Some(index as u32);
            }
        }
        Self {
            bsp,
            models,
            keys,
            materials,
            world,
            sizes,
            file,
            textures,
            owners,
            surfaces: Vec::new(),
            shapes: Vec::new(),
            luxel_maps: Vec::new(),
            names: Vec::new(),
            groups: Vec::new(),
            wishes: Vec::new(),
            emissive: Vec::new(),
            shadings: Vec::new(),
            samples_a_luxel: 1,
            sample_count: 0,
            degenerate: Problem::default(),
            bad_axes: Problem::default(),
        }
    }

    pub fn read(&mut self, face: usize) -> Result<()> {
        let bsp = self.bsp;
        let owner = self.owners[face];
        let model = owner.map(|m| &self.models[m as usize]);
        let texinfo_index = usize::try_from(bsp.faces[face].texinfo).ok();
        let texinfo = texinfo_index.and_then(|i| bsp.texinfos.get(i));
        let defaults = TexInfoKeys::default();
        let keys = texinfo_index.and_then(|i| self.keys.get(i)).unwrap_or(&defaults);
        let name = bsp.texture_of(face).map_or_else(String::new, |t| t.name.to_ascii_lowercase());
        let plane = bsp.face_plane(face);
        let shape = Shape::new(bsp.face_vertices(face).collect(), plane, owner);
        let offset = model.map_or(Vec3::ZERO, |m| m.offset);
        let vertices: Vec<Vec3> = shape.vertices.iter().map(|v| *v + offset).collect();
        let dist = plane.dist + super::exact::dot(plane.normal, offset);

        let area = area_and_centre(&vertices).0;
        let sound =
            area >= AREA_EPS && area.is_finite() && plane.normal.is_finite() && dist.is_finite();
        if !sound {
            self.degenerate.count(&vertices);
        }
        let material = self.file.of(&name);
        let fence = material.alpha_test.unwrap_or(name.starts_with('{'));
        let alpha = keys.light_alpha.or(model.and_then(|m| m.alpha)).unwrap_or(1.0);
        // Some light passes: glass, whatever share it is.
        let alpha = material
            .transmission
            .map_or(alpha, |t| (1.0 - t.element_sum() / 3.0).clamp(0.0, 1.0 - f32::EPSILON));
        let mask = keys.channel_mask.unwrap_or(model.map_or(1, |m| m.channel_mask));
        let role = if sound {
            role((&name, fence), owner, model, keys, (alpha, mask))
        } else {
            Role::Ghost
        };

        let lightmapped = sound
            && owner.is_some()
            && !matches!(&*name, "skip" | "trigger")
            && texinfo.is_some_and(|t| t.flags & TEX_SPECIAL == 0);
        let luxels = match texinfo.filter(|_| lightmapped) {
            Some(texinfo) => self.luxels(face, texinfo, keys, offset, &vertices),
            None => None,
        };
        let (luxels, map, vanilla_luxels) = match luxels {
            Some((grid, map, vanilla)) => (Some(grid), Some(map), vanilla),
            None => (None, None, None),
        };
        let count = luxels.as_ref().map_or(0, |g| g.len() as u64);
        self.sample_count += count * self.samples_a_luxel;
        if self.sample_count > SAMPLE_LIMIT {
            return Err(Error::Limit {
                what: format!("number of samples of luxels up to face {face}"),
                value: self.sample_count,
                limit: SAMPLE_LIMIT,
                advice: "raise worldspawn _lightmap_scale, or use --extra or neither instead of --extra4",
            });
        }
        let texture = texinfo.and_then(|t| u32::try_from(t.miptex).ok());
        let no_bounce = match material.bounce {
            Some(bounce) => !bounce,
            None => keys.no_bounce || model.is_some_and(|m| m.no_bounce),
        };
        // Fences among the filters: slats stand for them, see `obstacles`.
        let blocks = role == Role::Solid || is_fence(fence, (role, alpha, mask), model);
        let reflects = blocks && luxels.is_some() && !no_bounce && !name.starts_with('*');
        let special = texinfo.is_none_or(|t| t.flags & TEX_SPECIAL != 0);
        let wish = Wish::new(keys, special);
        self.surfaces.push(Surface {
            vertices,
            normal: plane.normal,
            dist,
            model: owner,
            offset,
            texture,
            texture_axes: texinfo.map_or([Vec3::ZERO; 2], |t| [t.s.truncate(), t.t.truncate()]),
            reflectance: if material.reflectance.is_some()
                || material.diffuse_transmission.is_some()
            {
                self.materials.given(texture, &material)
            } else {
                self.materials.of(texture)
            },
            reflects,
            role,
            opacity: alpha,
            transmission: material.transmission,
            diffuse: material.diffuse_transmission.filter(|_| reflects),
            fence,
            two_sided: material.two_sided.unwrap_or_else(|| {
                keys.light_twosided.unwrap_or(name.starts_with('*'))
                    || model.and_then(|m| m.alpha).is_some_and(|a| a < 1.0)
            }),
            light_ignore: keys.light_ignore || model.is_some_and(|m| m.light_ignore),
            channel_mask: mask,
            curved: wish.is_curved(),
            no_dirt: model.and_then(|m| m.no_dirt).unwrap_or(keys.no_dirt) || name.starts_with('*'),
            minlight: Minlight::of(keys, model, self.world),
            max_light: model.and_then(|m| m.max_light).unwrap_or(keys.max_light),
            colour_scale: model.and_then(|m| m.colour_scale).unwrap_or(keys.colour_scale),
            luxels,
            vanilla_luxels,
        });
        if !self.file.is_empty() {
            self.shadings.push(texinfo.and_then(|texinfo| {
                let find = || Texels::find(bsp, texture?, self.textures).map(Arc::new);
                let mean = self.materials.colour(texture);
                Shading::of(&material, find, ([texinfo.s, texinfo.t], offset, mean)).map(Arc::new)
            }));
        }
        self.wishes.push(wish);
        self.emissive.push(keys.surflight.clone());
        self.groups.push(keys.surflight_group);
        self.shapes.push(shape);
        self.luxel_maps.push(map);
        self.names.push(name);
        Ok(())
    }

    /// Luxels of a face, and those that the texture gives if they differ; `None` if its axes are
    /// unusable.
    fn luxels(
        &mut self,
        face: usize,
        texinfo: &TexInfo,
        keys: &TexInfoKeys,
        offset: Vec3,
        vertices: &[Vec3],
    ) -> Option<(LuxelGrid, LuxelMap, Option<LuxelGrid>)> {
        let size = self.sizes.of_face(face, keys.world_units_per_luxel);
        let vanilla = LuxelSize::Texels(self.sizes.vanilla);
        let grid = luxel_grid::of_face(self.bsp, face, texinfo, size, offset);
        let Some((grid, map)) = grid else {
            self.bad_axes.count(vertices);
            return None;
        };
        let vanilla = (size != vanilla)
            .then(|| luxel_grid::of_face(self.bsp, face, texinfo, vanilla, offset))
            .flatten()
            .map(|(grid, _)| grid);
        Some((grid, map, vanilla))
    }

    pub fn warn(&self, warnings: &mut Vec<String>) {
        self.degenerate.warn("without area: unlit, and they block no light", warnings);
        self.bad_axes.warn("with unusable texture axes: unlit; realign their textures", warnings);
    }
}

/// What a face does to light (contract section 7.2).
fn role(
    (name, fence): (&str, bool),
    owner: Option<u32>,
    model: Option<&Model>,
    keys: &TexInfoKeys,
    (alpha, mask): (f32, i32),
) -> Role {
    let Some(model) = model.filter(|m| m.casts() || mask != 1) else { return Role::Ghost };
    let opaque = matches!(model.shadow, ShadowClass::World | ShadowClass::Shadow);
    if keys.no_shadow {
        Role::Ghost
    } else if model.shadow == ShadowClass::Switchable
        || model.channel_mask != 1
        || mask != 1
        || alpha < 1.0
        || fence
    {
        Role::Filter
    } else if name.starts_with("sky") {
        Role::Sky
    } else if name.starts_with('*') && owner == Some(0) {
        Role::Ghost
    } else if opaque {
        Role::Solid
    } else {
        Role::Filter
    }
}

/// Faces with the same fault: how many, and where the first one is.
#[derive(Default)]
struct Problem {
    count: usize,
    place: Option<Vec3>,
}

impl Problem {
    fn count(&mut self, vertices: &[Vec3]) {
        self.count += 1;
        self.place = self.place.or_else(|| vertices.first().copied());
    }

    fn warn(&self, what: &str, warnings: &mut Vec<String>) {
        if self.count > 0 {
            let place = self
                .place
                .map_or_else(String::new, |p| format!(", the first at {} {} {}", p.x, p.y, p.z));
            warnings.push(format!("{} faces {what}{place}", self.count));
        }
    }
}
