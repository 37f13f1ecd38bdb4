//! From a parsed BSP to a [`Scene`].

use super::Scene;
use super::entity_lights;
use super::extremes;
use super::filter::Filters;
use super::light_grid::LightGrid;
use super::lights::Attenuation;
use super::luxel_grid;
use super::luxel_size::{LuxelSettings, LuxelSize, LuxelSizes};
use super::materials::Materials;
use super::minlight::Minlight;
use super::models::{self, Model, ShadowClass};
use super::neighbours::Neighbours;
use super::obstacles::{Casters, is_fence};
use super::overrides;
use super::phong::{Smoothing, Wish};
use super::rad;
use super::radiosity_lights::{self, Emissive};
use super::random::Random;
use super::shape::{AREA_EPS, LuxelMap, Shape, area_and_centre};
use super::sidecar::{self, Sidecar, SurflightKeys, TexInfoKeys};
use super::sky_rays::Sky;
use super::solid::Solid;
use super::suns;
use super::surface::{LuxelGrid, Role, Surface};
use super::surface_lights::{self, Faces};
use super::tracer::Tracer;
use super::visibility::Visibility;
use super::world::{WorldSettings, style_range};
use crate::bsp::{Bsp, Entity, MipTex, TexInfo, normalise, parse_entities};
use crate::{Error, Result};
use glam::Vec3;

/// Bit of the texinfo flags that says "no lightmap".
const TEX_SPECIAL: i32 = 1;
/// The most samples of luxels that a map may have: some gigabytes of working memory, a hundred large
/// maps.
const SAMPLE_LIMIT: u64 = 1 << 26;

/// What the user chooses about the scene.
#[derive(Clone, Debug)]
pub struct SceneSettings {
    /// Factor on all reflectances, 0 and up.
    pub reflectance_scale: f32,
    /// Every surface reflects 0.5, whatever its texture.
    pub grey: bool,
    /// Where worldspawn has no `bouncecolorscale`, it is 0 as in the reference: all surfaces reflect
    /// the same grey.
    pub compat_bounce: bool,
    /// Pixels for textures that the BSP lacks, found by name in any case.
    pub textures: Vec<MipTex>,
    /// Surface lights are area light: the faces emit, no point lights are placed before them.
    pub area_lights: bool,
    /// Worldspawn keys and values that win over those of the map, in any spelling of the key.
    pub overrides: Vec<(String, String)>,
    /// Luxel sizes other than the texture's.
    pub luxels: LuxelSettings,
    /// Samples along the edge of a luxel: 1, 2 or 4.
    pub extra: u32,
}

impl Default for SceneSettings {
    fn default() -> Self {
        Self {
            reflectance_scale: 1.0,
            grey: false,
            compat_bounce: false,
            textures: Vec::new(),
            area_lights: false,
            overrides: Vec::new(),
            luxels: LuxelSettings::default(),
            extra: 1,
        }
    }
}

impl Scene {
    /// Makes a map ready for light: `sidecar` is what `qbsp` wrote beside the BSP.
    ///
    /// # Errors
    /// If the entity text cannot be read, switchable lights need too many styles, or there would be
    /// more lights or luxels than memory and the format can hold.
    pub fn build(bsp: &Bsp, sidecar: Sidecar<'_>, settings: &SceneSettings) -> Result<Self> {
        let mut warnings = Vec::new();
        let mut entities = parse_entities(&bsp.entities)?;
        let styles = style_range(&bsp.entities, &settings.overrides)?;
        normalise(&mut entities, styles)?;
        if entities.is_empty() {
            entities.push(Entity::default());
        }
        entities.extend(rad::entities(sidecar.rad.unwrap_or(""), &mut warnings));
        entities.extend(parse_entities(sidecar.lights.unwrap_or("").as_bytes())?);
        let worldspawn = overrides::apply(&entities[0], &settings.overrides);
        // The world as a model has keys too.
        entities[0] = worldspawn;
        extremes::limit(&mut entities, &mut warnings);
        let worldspawn = entities[0].clone();
        let mut world = WorldSettings::read(&worldspawn, &mut warnings);
        let mut keys = sidecar::texinfo_keys(sidecar.texinfo, bsp.texinfos.len(), &mut warnings);
        let contents: Vec<i32> = bsp.leafs.iter().map(|l| l.contents).collect();
        let leaf_solid = sidecar::solid_leafs(sidecar.content, &contents, &mut warnings);
        let solid = Solid::new(bsp, leaf_solid);
        let models = models::read(bsp, &entities, &mut warnings);

        let materials = Materials::new(bsp, settings, &world.bounce);
        smooth_models(bsp, &models, &mut keys);
        let wanted = settings.luxels.clone().or_of_map(&worldspawn);
        let sizes = LuxelSizes::new(bsp, world.luxel_size, &wanted, &mut warnings);
        let mut faces = FaceReader::new(bsp, &models, &keys, &materials, (&world, sizes));
        faces.samples_a_luxel = u64::from(settings.extra).pow(2);
        for face in 0..bsp.faces.len() {
            faces.read(face)?;
        }
        faces.warn(&mut warnings);
        let FaceReader {
            mut surfaces, shapes, luxel_maps, names, groups, wishes, emissive, ..
        } = faces;
        // Fences may have no pixels that are seen.
        let walls = surfaces.iter().filter(|s| s.reflects && s.role == Role::Solid);
        materials.warn(walls.filter_map(|s| s.texture), &mut warnings);

        let smoothing = Smoothing::new(bsp, &shapes, &wishes);
        let mut drafts =
            entity_lights::read(&entities, bsp, &settings.textures, &world, &mut warnings);
        let colours: Vec<Vec3> = surfaces.iter().map(|s| materials.colour(s.texture)).collect();
        let light_faces = Faces {
            bsp,
            surfaces: &surfaces,
            shapes: &shapes,
            names: &names,
            groups: &groups,
            piece_size: world.surface_light_size,
            colours: &colours,
            area_lights: settings.area_lights,
        };
        let emitters = surface_lights::add_copies(&mut drafts, &light_faces, &mut warnings)?;
        world.dirt.in_use |= drafts.iter().any(|d| d.light.dirt.wanted);
        let (mut radiosity_lights, glows) = radiosity_lights::build(
            &drafts,
            &light_faces,
            &Emissive { keys: &emissive, world: &world, entities: &entities, solid: &solid },
        );
        if settings.area_lights {
            radiosity_lights.clear();
        }
        for (surface, glow) in surfaces.iter_mut().zip(glows) {
            surface.minlight.glow = glow;
        }
        let mut random = Random::new();
        let (lights, sky) =
            entity_lights::finish(drafts, &entities, &world, &solid, &mut random, &mut warnings)?;
        let (local_minlights, lights): (_, Vec<_>) =
            lights.into_iter().partition(|l| l.attenuation == Attenuation::LocalMinimum);
        let suns = suns::make(&worldspawn, &world, &sky, &mut random)?;

        let light_grid = LightGrid::read(&worldspawn, &entities, &surfaces, &mut warnings)?;

        let (tracer, tracer_surface) = build_tracer(&surfaces);
        let is_sky = |&s: &u32| surfaces[s as usize].role == Role::Sky;
        let sky = Sky::new(tracer.polygons(), tracer_surface.iter().map(is_sky).collect());
        let casters = Casters {
            bsp,
            surfaces: &surfaces,
            names: &names,
            models: &models,
            textures: &settings.textures,
        };
        let obstacles = casters.obstacles(&tracer, &tracer_surface);
        let filters = Filters::new(bsp, &surfaces, &names, &models, settings, &mut warnings);
        Ok(Self {
            surfaces,
            models,
            visibility: Visibility::new(bsp, &solid, &lights),
            lights,
            local_minlights,
            radiosity_lights,
            suns,
            emitters,
            decoupled: wanted.world_units.is_some(),
            light_grid,
            world,
            tracer,
            sky,
            tracer_surface,
            filters,
            solid,
            warnings,
            shapes,
            neighbours: Neighbours::new(bsp, &smoothing),
            obstacles,
            smoothing,
            luxel_maps,
        })
    }
}

/// Brush models that ask for smoothing do so for the texinfos of their faces, and so for other faces
/// with the same texinfo.
fn smooth_models(bsp: &Bsp, models: &[Model], keys: &mut [TexInfoKeys]) {
    for (model, record) in models.iter().zip(&bsp.models).filter(|(m, _)| m.phong_angle != 0.0) {
        let first = record.first_face as usize;
        let range = first..first.saturating_add(record.face_count as usize);
        for face in bsp.faces.get(range).unwrap_or(&[]) {
            let texinfo = usize::try_from(face.texinfo).ok();
            if let Some(keys) = texinfo.and_then(|t| keys.get_mut(t)) {
                keys.phong_angle = model.phong_angle;
            }
        }
    }
}

/// The surfaces that block all light, and which polygon is which surface.
fn build_tracer(surfaces: &[Surface]) -> (Tracer, Vec<u32>) {
    let (mut polygons, mut indices) = (Vec::new(), Vec::new());
    for (index, surface) in surfaces.iter().enumerate() {
        if !matches!(surface.role, Role::Solid | Role::Sky) {
            continue;
        }
        if let Some(polygon) = surface.polygon() {
            polygons.push(polygon);
            indices.push(index as u32);
        }
    }
    (Tracer::new(polygons), indices)
}

/// Reads faces one by one into the columns of the scene.
struct FaceReader<'a> {
    bsp: &'a Bsp,
    models: &'a [Model],
    keys: &'a [TexInfoKeys],
    materials: &'a Materials,
    world: &'a WorldSettings,
    sizes: LuxelSizes<'a>,
    owners: Vec<Option<u32>>,
    surfaces: Vec<Surface>,
    shapes: Vec<Shape>,
    luxel_maps: Vec<Option<LuxelMap>>,
    names: Vec<String>,
    groups: Vec<i32>,
    wishes: Vec<Wish>,
    emissive: Vec<SurflightKeys>,
    samples_a_luxel: u64,
    sample_count: u64,
    degenerate: Problem,
    bad_axes: Problem,
}

impl<'a> FaceReader<'a> {
    fn new(
        bsp: &'a Bsp,
        models: &'a [Model],
        keys: &'a [TexInfoKeys],
        materials: &'a Materials,
        (world, sizes): (&'a WorldSettings, LuxelSizes<'a>),
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
            owners,
            surfaces: Vec::new(),
            shapes: Vec::new(),
            luxel_maps: Vec::new(),
            names: Vec::new(),
            groups: Vec::new(),
            wishes: Vec::new(),
            emissive: Vec::new(),
            samples_a_luxel: 1,
            sample_count: 0,
            degenerate: Problem::default(),
            bad_axes: Problem::default(),
        }
    }

    fn read(&mut self, face: usize) -> Result<()> {
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
        let alpha = keys.light_alpha.or(model.and_then(|m| m.alpha)).unwrap_or(1.0);
        let mask = keys.channel_mask.unwrap_or(model.map_or(1, |m| m.channel_mask));
        let role = if sound { role(&name, owner, model, keys, alpha, mask) } else { Role::Ghost };

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
        let no_bounce = keys.no_bounce || model.is_some_and(|m| m.no_bounce);
        // Fences among the filters: slats stand for them, see `obstacles`.
        let blocks = role == Role::Solid || is_fence(&name, (role, alpha, mask), model);
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
            reflectance: self.materials.of(texture),
            reflects,
            role,
            opacity: alpha,
            two_sided: keys.light_twosided.unwrap_or(name.starts_with('*'))
                || model.and_then(|m| m.alpha).is_some_and(|a| a < 1.0),
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

    fn warn(&self, warnings: &mut Vec<String>) {
        self.degenerate.warn("without area: unlit, and they block no light", warnings);
        self.bad_axes.warn("with unusable texture axes: unlit; realign their textures", warnings);
    }
}

/// What a face does to light (contract section 7.2).
fn role(
    name: &str,
    owner: Option<u32>,
    model: Option<&Model>,
    keys: &TexInfoKeys,
    alpha: f32,
    mask: i32,
) -> Role {
    let Some(model) = model.filter(|m| m.casts() || mask != 1) else { return Role::Ghost };
    let opaque = matches!(model.shadow, ShadowClass::World | ShadowClass::Shadow);
    if keys.no_shadow {
        Role::Ghost
    } else if model.shadow == ShadowClass::Switchable
        || model.channel_mask != 1
        || mask != 1
        || alpha < 1.0
        || name.starts_with('{')
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
