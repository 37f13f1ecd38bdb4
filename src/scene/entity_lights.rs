//! From light entities to [`Light`]s (contract sections 4.1 to 4.3): reading the keys, then
//! surface copies, jitter copies, targets, cones and nudging, in the reference's order.

use super::dirt::DirtKeys;
use super::keys;
use super::lights::{Attenuation, Light, Spot};
use super::projection::Projection;
use super::suns::{self, SkyLight};
use super::world::WorldSettings;
use crate::bsp::{Bsp, Entity, MipTex};
use glam::Vec3;
use std::sync::Arc;

/// A light entity while the list of lights is being made.
#[derive(Clone, Debug)]
pub(crate) struct Draft {
    /// The light so far; brightness 0 means that it does not shine.
    pub light: Light,
    /// The texture whose faces this is a template for.
    pub template: Option<Template>,
    /// Half-width of the cube of jittered copies.
    pub deviance: f32,
    /// Number of jittered copies, itself included.
    pub samples: u32,
    /// Shines in a cone.
    pub is_spot: bool,
    /// Diameter of the cone in degrees.
    pub outer_angle: f32,
    /// Diameter of the cone of full light in degrees.
    pub inner_angle: f32,
    /// Name of the entity to shine at.
    pub target: String,
    /// Keep the origin even inside solid.
    pub no_nudge: bool,
    /// It shines from the sky instead of from its origin.
    pub sky: Option<Sky>,
}

/// What makes a light shine from the sky.
#[derive(Clone, Debug)]
pub(crate) struct Sky {
    pub kind: SkyLight,
    pub penumbra: f32,
    pub dirt: Option<bool>,
    pub texture: Option<u32>,
}

/// What makes a light a template for surface lights.
#[derive(Clone, Debug)]
pub(crate) struct Template {
    /// Name of the texture.
    pub texture: String,
    /// Height above the surface, in world units.
    pub offset: f32,
    /// Copies are spots along the normal of their face.
    pub spotlight: bool,
    /// Applies to faces of the same group.
    pub group: i32,
    /// The faces shine in the manner of radiosity; no copies are placed.
    pub radiosity: bool,
    /// The light has a colour of its own, which replaces that of the texture.
    pub has_colour: bool,
    /// Takes the colour of worldspawn's `sky_surface` rather than that of the texture.
    pub is_sky: bool,
    /// The faces shine alike in all directions.
    pub all_around: bool,
    /// Share of the brightness that the faces glow with.
    pub minlight_scale: f32,
}

impl Draft {
    /// A copy of the template at a point of a face with unit normal `normal`.
    pub fn copy_at(&self, origin: Vec3, normal: Vec3) -> Self {
        let mut copy = self.clone();
        let spotlight = copy.template.take().is_some_and(|t| t.spotlight);
        copy.light.origin = origin;
        if spotlight {
            copy.is_spot = true;
            copy.light.spot = Some(Spot { direction: normal, outer: 0.0, inner: 0.0 });
        }
        copy
    }
}

fn is_light(entity: &Entity) -> bool {
    entity.classname().starts_with("light")
}

/// Reads the light entities, whose switchable styles are already set.
pub(crate) fn read(
    entities: &[Entity],
    bsp: &Bsp,
    textures: &[MipTex],
    world: &WorldSettings,
    warnings: &mut Vec<String>,
) -> Vec<Draft> {
    let mut drafts = Vec::new();
    if world.no_lights {
        return drafts;
    }
    let shines = |e: &Entity| {
        let styled = || ["style", "switchshadstyle"].iter().any(|k| e.setting(k).is_some());
        is_light(e) && (!world.no_lighting || styled())
    };
    for (index, entity) in entities.iter().enumerate().filter(|(_, e)| shines(e)) {
        let mut reader = Reader { entity, bsp, textures, place: String::new(), warnings };
        let origin = entity.setting("origin").and_then(keys::vector).unwrap_or(Vec3::ZERO);
        reader.place = format!("light at {} {} {}", origin.x, origin.y, origin.z);
        drafts.push(reader.read(index as u32, origin, world));
    }
    drafts
}

/// One light entity being read.
struct Reader<'a> {
    entity: &'a Entity,
    bsp: &'a Bsp,
    textures: &'a [MipTex],
    place: String,
    warnings: &'a mut Vec<String>,
}

impl Reader<'_> {
    fn number(&self, name: &str) -> Option<f32> {
        self.entity.setting(name).and_then(keys::number)
    }

    fn flag(&self, name: &str) -> bool {
        self.entity.setting(name).is_some_and(keys::boolean)
    }

    fn warn(&mut self, what: &str) {
        self.warnings.push(format!("{}: {what}", self.place));
    }

    fn read(&mut self, index: u32, origin: Vec3, world: &WorldSettings) -> Draft {
        let (brightness, implied_colour) =
            self.entity.setting("light").map_or((None, None), keys::light);
        let colour = self.entity.setting("color").and_then(keys::colour).or(implied_colour);
        let mut brightness = brightness.unwrap_or(300.0);
        let wait = self.number("wait").filter(|w| *w > 0.0).unwrap_or(1.0);
        let angle_scale = self.number("anglescale").or_else(|| self.number("anglesense"));
        let angle_scale =
            angle_scale.filter(|a| (0.0..=1.0).contains(a)).unwrap_or(world.angle_scale);
        let mangle = self.entity.setting("mangle").and_then(keys::vector);
        let delay = self.entity.setting("delay").map_or(0, delay);

        let (mut deviance, mut samples) = (
            self.number("deviance").unwrap_or(0.0),
            self.entity.setting("samples").map_or(16, keys::integer),
        );
        let sky = self.sky(deviance);
        let is_dome = sky.as_ref().is_some_and(|s| s.kind != SkyLight::Sun);
        // A dome has no place to jitter about (the reference makes a dome of each copy: Q40).
        if deviance <= 0.0 || samples <= 1 || is_dome {
            (deviance, samples) = (0.0, 1);
        }
        // Delay 0 and 6 are not divided: the contract's Q21.
        if matches!(delay, 1 | 2 | 3 | 5) || delay == 4 && world.add_min {
            brightness /= samples as f32;
        }
        let attenuation = self.attenuation(delay);
        if attenuation.is_none() || self.is_off() {
            brightness = 0.0;
        }
        let channel_mask = self.entity.setting("light_channel_mask").map_or(1, keys::integer);
        let outer_angle = self
            .number("cone")
            .map(|radius| radius * 2.0)
            .or_else(|| self.number("angle"))
            .filter(|a| *a > 0.0)
            .unwrap_or(40.0);
        Draft {
            light: Light {
                piece_radius: 0.0,
                origin,
                brightness,
                colour: colour.unwrap_or(Vec3::splat(255.0)),
                wait,
                attenuation: attenuation.unwrap_or(Attenuation::Linear),
                angle_scale,
                bleed: self.flag("bleed"),
                style: self
                    .entity
                    .setting("style")
                    .map_or(0, |s| keys::integer(s).clamp(0, 65534) as u16),
                spot: mangle.map(|m| Spot {
                    direction: keys::direction(m),
                    outer: 0.0,
                    inner: 0.0,
                }),
                projection: self.projection(),
                channel_mask,
                shadow_mask: self
                    .entity
                    .setting("shadow_channel_mask")
                    .map_or(channel_mask, keys::integer),
                dirt: DirtKeys::read(self.entity, &world.dirt),
                bounce_scale: self.number("bouncescale").unwrap_or(1.0).max(0.0),
                entity: index,
            },
            template: self.template(world, colour.is_some()),
            deviance,
            samples: samples as u32,
            is_spot: mangle.is_some(),
            outer_angle,
            inner_angle: self.number("softangle").unwrap_or(0.0),
            target: self.entity.get("target").unwrap_or("").to_owned(),
            no_nudge: self.flag("nonudge"),
            sky,
        }
    }

    /// What the light adds to the sky, if that is what it does. `deviance` is in degrees then.
    fn sky(&self, deviance: f32) -> Option<Sky> {
        let kind = if self.flag("sun") {
            SkyLight::Sun
        } else if self.flag("sunlight2") || self.flag("sunlight3") {
            SkyLight::Dome { upper: self.flag("sunlight2") }
        } else {
            return None;
        };
        Some(Sky {
            kind,
            penumbra: deviance.max(0.0),
            dirt: suns::dirt(self.entity, "dirt"),
            texture: suns::sky_texture(self.entity, self.bsp),
        })
    }

    /// The formula for a delay; `None` for a light that does not shine.
    fn attenuation(&mut self, delay: i32) -> Option<Attenuation> {
        let falloff = self.number("falloff").filter(|f| *f > 0.0);
        if falloff.is_some() && delay != 0 {
            self.warn("falloff works with delay 0 only and is ignored");
        }
        Some(match delay {
            0 => falloff.map_or(Attenuation::Linear, Attenuation::Falloff),
            1 => Attenuation::Inverse,
            2 => Attenuation::InverseSquare,
            3 => Attenuation::Infinite,
            4 => Attenuation::LocalMinimum,
            5 => Attenuation::InverseSquareOffset,
            6 => Attenuation::InverseSquareClamped,
            _ => {
                self.warn(&format!("delay {delay} is not known, the light is off; use 0 to 5"));
                return None;
            }
        })
    }

    /// The picture that the light projects.
    fn projection(&mut self) -> Option<Arc<Projection>> {
        match Projection::read(self.entity, self.bsp, self.textures) {
            Ok(picture) => picture.map(Arc::new),
            Err(problem) => {
                self.warn(&format!("{problem}; it shines without a picture"));
                None
            }
        }
    }

    /// Whether the light does not shine by itself.
    fn is_off(&self) -> bool {
        // Such a light only names the shadow that its style switches.
        self.flag("nostaticlight")
            || self.entity.setting("switchableshadow_target").is_some_and(|t| !t.is_empty())
    }

    fn template(&mut self, world: &WorldSettings, has_colour: bool) -> Option<Template> {
        let texture = self.entity.get("_surface").filter(|t| !t.is_empty())?;
        let mode =
            self.entity.get("_surface_radiosity").map_or(world.surface_light_mode, keys::integer);
        let raw = |name: &str| self.entity.get(name).and_then(keys::number).unwrap_or(0.0);
        let offset = raw("_surface_offset");
        Some(Template {
            texture: texture.to_owned(),
            offset: if offset == 0.0 { 2.0 } else { offset },
            spotlight: raw("_surface_spotlight") != 0.0,
            group: self.entity.setting("surflight_group").map_or(0, keys::integer),
            radiosity: mode != 0,
            has_colour,
            is_sky: raw("_surface_is_sky") != 0.0,
            all_around: self
                .entity
                .get("_surface_spotlight")
                .is_some_and(|v| !v.is_empty() && keys::integer(v) == 0),
            minlight_scale: self
                .number("surflight_minlight_scale")
                .unwrap_or(world.surflight.minlight_scale),
        })
    }
}

/// The `delay` key: a name in any case, else an integer.
fn delay(text: &str) -> i32 {
    let names = ["linear", "inverse", "inverse2", "infinite", "localmin", "inverse2a"];
    let token = text.split_ascii_whitespace().next().unwrap_or("");
    names
        .iter()
        .position(|n| token.eq_ignore_ascii_case(n))
        .map_or_else(|| keys::integer(token), |i| i as i32)
}
