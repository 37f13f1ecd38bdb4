//! Polygons that stop some rays and let others pass: fences, glass, and the faces of models that cast
//! shadow in special ways (contract sections 7.2 and 7.4 to 7.6).

use super::Scene;
use super::build::SceneSettings;
use super::effects::COMPILED;
use super::hull;
use super::models::Model;
use super::pane::{Pane, PaneColour};
use super::surface::{Role, Surface};
use super::texels::Texels;
use super::tracer::{Polygon, Tracer};
use crate::bsp::{Bsp, TexInfo};
use glam::{Vec3, Vec4};
use std::collections::HashMap;
use std::sync::Arc;

/// The polygons that filter light, apart from those that always block it.
pub struct Filters {
    tracer: Tracer,
    /// By polygon of `tracer`.
    casters: Vec<Caster>,
    textures: Vec<Arc<Texels>>,
}

/// How one polygon filters.
struct Caster {
    model: u32,
    /// Channels whose rays it meets.
    mask: i32,
    normal: Vec3,
    /// Opacity, 1 for anything but glass.
    opacity: f32,
    /// Glass of this colour instead of its texture's.
    transmission: Option<Vec3>,
    fence: bool,
    picture: Option<Picture>,
}

/// The texture on a polygon.
struct Picture {
    s: Vec4,
    t: Vec4,
    /// Index in [`Filters::textures`].
    texels: usize,
    /// World offset of the brush model.
    offset: Vec3,
}

/// A ray that arrives at a filter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    /// World point where it meets the polygon.
    pub point: Vec3,
    /// Direction from the lit point to the light.
    pub direction: Vec3,
    /// Channels of light.
    pub mask: i32,
    /// Brush model that the lit point belongs to.
    pub receiver: Option<u32>,
}

/// What a filter does to a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Effect {
    Block,
    Pass,
    /// The light goes to this style if it was of style 0.
    Style(u16),
    /// The light takes on a colour, channels 0 to 1, to this share.
    Tint(Vec3, f32),
}

impl Filters {
    /// The filters of a scene.
    pub(crate) fn new(
        bsp: &Bsp,
        surfaces: &[Surface],
        models: &[Model],
        settings: &SceneSettings,
        warnings: &mut Vec<String>,
    ) -> Self {
        let mut builder = Builder {
            bsp,
            settings,
            polygons: Vec::new(),
            casters: Vec::new(),
            textures: Vec::new(),
            by_slot: HashMap::new(),
        };
        for (face, surface) in surfaces.iter().enumerate() {
            if surface.role == Role::Filter {
                builder.add_surface(face, surface);
            }
        }
        for (index, model) in models.iter().enumerate().skip(1) {
            if model.casts() && bsp.models[index].face_count == 0 {
                builder.add_hull(index, model, warnings);
            }
        }
        let Builder { polygons, casters, textures, .. } = builder;
        Self { tracer: Tracer::new(polygons), casters, textures }
    }

    /// The polygons.
    pub(crate) fn tracer(&self) -> &Tracer {
        &self.tracer
    }

    /// What polygon `polygon` does to a ray.
    pub(crate) fn effect(&self, polygon: u32, ray: &Ray, models: &[Model]) -> Effect {
        let caster = &self.casters[polygon as usize];
        let model = &models[caster.model as usize];
        if caster.mask & ray.mask == 0
            || model.shadow_world_only && ray.receiver != Some(0)
            || model.shadow_self && ray.receiver != Some(caster.model)
        {
            return Effect::Pass;
        }
        if let Some(style) = model.switchable() {
            let own = ray.receiver.map(|r| models[r as usize].switch_style);
            if own != Some(style) {
                return Effect::Style(style);
            }
        }
        if caster.opacity < 1.0 {
            return self.tint(caster, ray);
        }
        // A fence whose pixels nobody has is taken for opaque.
        let seen_through = caster.fence
            && caster.picture.as_ref().is_some_and(|p| self.texel(p, ray.point).is_none());
        if seen_through { Effect::Pass } else { Effect::Block }
    }

    /// Glass tints rays that leave through its front.
    fn tint(&self, caster: &Caster, ray: &Ray) -> Effect {
        if ray.direction.dot(caster.normal) <= 0.0 {
            return Effect::Pass;
        }
        if let Some(share) = caster.transmission {
            return Effect::Tint(share, 1.0);
        }
        let colour = caster.picture.as_ref().and_then(|p| self.texel(p, ray.point));
        colour.map_or(Effect::Pass, |c| Effect::Tint(c / 255.0, caster.opacity))
    }

    fn texel(&self, picture: &Picture, point: Vec3) -> Option<Vec3> {
        // The texture moves with the model (the reference leaves it behind: Q16).
        let p = point - picture.offset;
        let along = |axis: Vec4| p.x * axis.x + p.y * axis.y + p.z * axis.z + axis.w;
        self.textures[picture.texels].colour_at(along(picture.s), along(picture.t))
    }
}

struct Builder<'a> {
    bsp: &'a Bsp,
    settings: &'a SceneSettings,
    polygons: Vec<Polygon>,
    casters: Vec<Caster>,
    textures: Vec<Arc<Texels>>,
    /// Index in `textures` of a slot of the texture lump.
    by_slot: HashMap<u32, Option<usize>>,
}

impl Builder<'_> {
    fn add_surface(&mut self, face: usize, surface: &Surface) {
        let Some(polygon) = surface.polygon() else { return };
        let texinfo = usize::try_from(self.bsp.faces[face].texinfo)
            .ok()
            .and_then(|i| self.bsp.texinfos.get(i).copied());
        let wants_texture =
            surface.fence || surface.opacity < 1.0 && surface.transmission.is_none();
        let picture =
            texinfo.filter(|_| wants_texture).and_then(|texinfo| self.picture(&texinfo, surface));
        self.polygons.push(polygon);
        self.casters.push(Caster {
            model: surface.model.unwrap_or(0),
            mask: surface.channel_mask,
            normal: surface.normal,
            opacity: surface.opacity,
            transmission: surface.transmission,
            fence: surface.fence,
            picture,
        });
    }

    fn picture(&mut self, texinfo: &TexInfo, surface: &Surface) -> Option<Picture> {
        let slot = surface.texture?;
        let texels = match self.by_slot.get(&slot) {
            Some(known) => *known,
            None => {
                let found = Texels::find(self.bsp, slot, &self.settings.textures);
                let place = found.map(|texels| {
                    self.textures.push(Arc::new(texels));
                    self.textures.len() - 1
                });
                self.by_slot.insert(slot, place);
                place
            }
        };
        Some(Picture { s: texinfo.s, t: texinfo.t, texels: texels?, offset: surface.offset })
    }

    fn add_hull(&mut self, index: usize, model: &Model, warnings: &mut Vec<String>) {
        let Some(hull) = hull::polygons(self.bsp, &self.bsp.models[index]) else {
            warnings.push(format!(
                "brush model *{index} has no faces and a tree too large to cast a shadow"
            ));
            return;
        };
        for mut polygon in hull {
            polygon.vertices.iter_mut().for_each(|v| *v += model.offset);
            self.casters.push(Caster {
                model: index as u32,
                mask: model.channel_mask,
                normal: polygon.normal,
                opacity: 1.0,
                transmission: None,
                fence: false,
                picture: None,
            });
            self.polygons.push(polygon);
        }
    }
}

impl Scene {
    /// The glass that all light meets alike, and so bounced light too: polygons and what each does.
    pub fn panes(&self) -> (Vec<Polygon>, Vec<Pane>) {
        let is_pane = |c: &(&Polygon, &Caster)| {
            let model = &self.models[c.1.model as usize];
            c.1.opacity < 1.0
                && c.1.mask & 1 != 0
                && model.switchable().is_none()
                && !model.shadow_self
                && !model.shadow_world_only
        };
        let casters = self.filters.tracer.polygons().iter().zip(&self.filters.casters);
        casters
            .filter(is_pane)
            .map(|(polygon, caster)| {
                let texture = |p: &Picture| {
                    let texels = Arc::clone(&self.filters.textures[p.texels]);
                    PaneColour::Texture(texels, [p.s, p.t], p.offset)
                };
                let (opacity, colour) = match caster.transmission {
                    Some(share) => (1.0, Some(PaneColour::Even(share))),
                    None => (caster.opacity, caster.picture.as_ref().map(texture)),
                };
                let pane = Pane { normal: caster.normal, opacity, colour };
                (polygon.clone(), pane)
            })
            .unzip()
    }

    /// Whether some light is filtered on its way.
    pub fn has_filters(&self) -> bool {
        COMPILED && !self.filters.casters.is_empty()
    }
}
