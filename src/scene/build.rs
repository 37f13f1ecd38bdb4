//! From a parsed BSP to a [`Scene`].

use super::Scene;
use super::effects::{self, Parts, Switches};
use super::emission;
use super::entity_lights;
use super::extremes;
use super::face_reader::FaceReader;
use super::filter::Filters;
use super::light_grid::LightGrid;
use super::light_list;
use super::lights::Attenuation;
use super::luxel_size::{LuxelSettings, LuxelSizes};
use super::material_file::MaterialFile;
use super::materials::Materials;
use super::models::{self, Model};
use super::neighbours::Neighbours;
use super::obstacles::Casters;
use super::overrides;
use super::phong::Smoothing;
use super::rad;
use super::radiosity_lights::{self, Emissive};
use super::random::Random;
use super::sidecar::{self, Sidecar, TexInfoKeys};
use super::sky_rays::Sky;
use super::solid::Solid;
use super::suns;
use super::surface::{Role, Surface};
use super::surface_lights::{self, Faces};
use super::tracer::Tracer;
use super::unknown_names::TextureNames;
use super::visibility::Visibility;
use super::world::{WorldSettings, style_range};
use crate::Result;
use crate::bsp::{Bsp, Entity, MipTex, normalise, parse_entities};
use glam::Vec3;

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
    /// Effects switched on or off by hand.
    pub switches: Switches,
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
            switches: Switches::default(),
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
        let nothing = MaterialFile::default();
        let file = sidecar.materials.unwrap_or(&nothing);
        let textures = TextureNames::of(bsp.textures.iter().flatten().map(|t| &*t.name));
        file.warn(&textures, &mut warnings);
        let listed: Vec<Entity> = sidecar
            .rad
            .iter()
            .flat_map(|(name, text)| rad::entities(name, text, &textures, &mut warnings))
            .collect();
        let shines = |e: &Entity| file.of(e.get("_surface").unwrap_or("")).emission.is_some();
        // What a material file says of a texture replaces lines for it.
        entities.extend(listed.into_iter().filter(|e| file.is_empty() || !shines(e)));
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
        let mut models = models::read(bsp, &entities, &mut warnings);

        let materials = Materials::new(bsp, settings, &world.bounce);
        smooth_models(bsp, &models, &mut keys);
        let wanted = settings.luxels.clone().or_of_map(&worldspawn);
        let sizes = LuxelSizes::new(bsp, world.luxel_size, &wanted, &mut warnings);
        let given = (file, &settings.textures[..]);
        let mut faces = FaceReader::new(bsp, &models, &keys, &materials, (&world, sizes), given);
        faces.samples_a_luxel = u64::from(settings.extra).pow(2);
        for face in 0..bsp.faces.len() {
            faces.read(face)?;
        }
        faces.warn(&mut warnings);
        let FaceReader {
            mut surfaces,
            mut shadings,
            shapes,
            luxel_maps,
            names,
            groups,
            wishes,
            emissive,
            ..
        } = faces;
        // Fences may have no pixels that are seen.
        let walls = surfaces.iter().filter(|s| s.reflects && s.role == Role::Solid);
        materials.warn(walls.filter_map(|s| s.texture), &mut warnings);

        emission::add_lights(&mut entities, (file, bsp), &materials);
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
        let mut emitters = surface_lights::add_copies(&mut drafts, &light_faces, &mut warnings)?;
        emitters.extend(emission::emitters(&names, file, &surfaces));
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
            light_list::finish(drafts, &entities, &world, &solid, &mut random, &mut warnings)?;
        let (mut local_minlights, mut lights): (Vec<_>, Vec<_>) =
            lights.into_iter().partition(|l| l.attenuation == Attenuation::LocalMinimum);
        let mut suns = suns::make(&worldspawn, &world, &sky, &mut random)?;
        let mut parts = Parts {
            surfaces: &mut surfaces,
            models: &mut models,
            lights: &mut lights,
            local_minlights: &mut local_minlights,
            radiosity_lights: &mut radiosity_lights,
            suns: &mut suns,
            emitters: &mut emitters,
            world: &mut world,
            shadings: &mut shadings,
        };
        effects::apply(&settings.switches, &mut parts);

        let light_grid = LightGrid::read(&worldspawn, &entities, &surfaces, &mut warnings)?;

        let (tracer, tracer_surface) = build_tracer(&surfaces);
        let is_sky = |&s: &u32| surfaces[s as usize].role == Role::Sky;
        let sky = Sky::new(tracer.polygons(), tracer_surface.iter().map(is_sky).collect());
        let casters =
            Casters { bsp, surfaces: &surfaces, models: &models, textures: &settings.textures };
        let obstacles = casters.obstacles(&tracer, &tracer_surface);
        let filters = Filters::new(bsp, &surfaces, &models, settings, &mut warnings);
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
            names,
            shapes,
            neighbours: Neighbours::new(bsp, &smoothing),
            shadings,
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
    (Tracer::new(polygons).on_solid(indices.len()), indices)
}
