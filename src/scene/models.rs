//! Brush models as light sees them (contract sections 6.6 and 7.1).

use super::keys;
use super::phong::DEFAULT_ANGLE;
use crate::bsp::{self, Bsp, Entity};
use glam::Vec3;

/// Which rays the faces of a model block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShadowClass {
    /// The world: all rays.
    World,
    /// `_switchableshadow`: rays of style 0 move to another style.
    Switchable,
    /// `_shadow`: all rays.
    Shadow,
    /// `_shadowself`: rays to the same model.
    ShadowSelf,
    /// `_shadowworldonly`: rays to the world.
    ShadowWorldOnly,
    /// None.
    None,
}

/// A brush model; index 0 is the world.
#[derive(Clone, Debug)]
pub struct Model {
    /// World position of the model's own origin.
    pub offset: Vec3,
    /// Which rays its faces block.
    pub shadow: ShadowClass,
    /// Rays to other models pass, whatever the class (`_shadowself`).
    pub shadow_self: bool,
    /// Rays to anything but the world pass, whatever the class (`_shadowworldonly`).
    pub shadow_world_only: bool,
    /// Light style of its switchable shadow, 0 without.
    pub switch_style: u16,
    /// Opacity, 0 to 1, if the entity gives one.
    pub alpha: Option<f32>,
    /// Channels of light that its faces receive.
    pub channel_mask: i32,
    /// Its faces receive no light.
    pub light_ignore: bool,
    /// Cap on luxels in levels, if the entity gives one.
    pub max_light: Option<f32>,
    /// Saturation of light received, if the entity gives one.
    pub colour_scale: Option<f32>,
    /// Whether its faces get no dirt, if the entity says so.
    pub no_dirt: Option<bool>,
    /// Its faces send no light back (`_bounce -1`).
    pub no_bounce: bool,
    /// Smoothing angle in degrees for all its faces; 0 leaves them as they are.
    pub phong_angle: f32,
    /// Minimum light of its faces, in light units, if the entity gives it.
    pub minlight: Option<f32>,
    /// Colour of that light, 0 to 255 a channel.
    pub minlight_colour: Option<Vec3>,
    /// Whether minimum light is mottled.
    pub minlight_mottle: Option<bool>,
    /// Automatic minimum light.
    pub auto_minlight: AutoMinlight,
    /// Point that automatic minimum light is taken from, unless an entity gives it: the middle of
    /// the model's box, without its offset.
    pub centre: Vec3,
}

/// When the luxels of a brush model take on the light at its middle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AutoMinlight {
    /// Luxels inside solid, which nothing else lights.
    #[default]
    Occluded,
    /// All luxels.
    All,
    /// Never.
    Off,
}

impl Model {
    fn world() -> Self {
        Self {
            offset: Vec3::ZERO,
            shadow: ShadowClass::World,
            shadow_self: false,
            shadow_world_only: false,
            switch_style: 0,
            alpha: None,
            channel_mask: 1,
            light_ignore: false,
            max_light: None,
            colour_scale: None,
            no_dirt: None,
            no_bounce: false,
            phong_angle: 0.0,
            minlight: None,
            minlight_colour: None,
            minlight_mottle: None,
            auto_minlight: AutoMinlight::Off,
            centre: Vec3::ZERO,
        }
    }

    /// Whether the model casts a shadow of any kind. One in other channels always does.
    pub fn casts(&self) -> bool {
        self.shadow != ShadowClass::None || self.channel_mask != 1
    }

    /// Style that light of style 0 moves to when it crosses the model, if the shadow is switchable.
    pub(crate) fn switchable(&self) -> Option<u16> {
        (self.shadow == ShadowClass::Switchable).then_some(self.switch_style)
    }
}

/// The models of a map, from the entities that own them.
pub(crate) fn read(bsp: &Bsp, entities: &[Entity], warnings: &mut Vec<String>) -> Vec<Model> {
    // Lights that only switch the shadow of the models that they name.
    let switches: Vec<(&str, u16)> = entities
        .iter()
        .filter(|e| e.classname().starts_with("light"))
        .filter_map(|e| Some((e.setting("switchableshadow_target")?, style(e, "style"))))
        .filter(|(target, _)| !target.is_empty())
        .collect();
    let mut owners = vec![None; bsp.models.len()];
    for entity in entities {
        let number = entity.get("model").and_then(|m| m.strip_prefix('*'));
        let Some(owner) = number.and_then(|n| n.parse::<usize>().ok()) else { continue };
        if let Some(slot @ None) = owners.get_mut(owner) {
            *slot = Some(entity);
        }
    }
    let mut orphans = Vec::new();
    let mut models = Vec::with_capacity(owners.len());
    for (index, owner) in owners.into_iter().enumerate() {
        models.push(match owner {
            _ if index == 0 => {
                let world = entities.first();
                let angle = world.and_then(|w| w.setting("phong_angle")).and_then(keys::number);
                Model { phong_angle: whole_angle(angle.unwrap_or(0.0)), ..Model::world() }
            }
            Some(entity) => brush_model(entity, entities, &switches, &bsp.models[index]),
            None => {
                orphans.push(format!("*{index}"));
                Model { shadow: ShadowClass::None, ..Model::world() }
            }
        });
    }
    if !orphans.is_empty() {
        warnings.push(format!(
            "no entity has the brush models {}; they are lit where they were built",
            orphans.join(", ")
        ));
    }
    models
}

/// A light style in a key, 0 without.
fn style(entity: &Entity, name: &str) -> u16 {
    entity.setting(name).map_or(0, |s| keys::integer(s).clamp(0, 65534) as u16)
}

/// An angle as the reference keeps it: a whole number of degrees in a byte.
fn whole_angle(degrees: f32) -> f32 {
    degrees.round_ties_even().clamp(0.0, 255.0)
}

fn brush_model(
    entity: &Entity,
    entities: &[Entity],
    switches: &[(&str, u16)],
    record: &bsp::Model,
) -> Model {
    let number = |name: &str| entity.setting(name).and_then(keys::number);
    let on = |name: &str| number(name).is_some_and(|v| v > 0.0);
    let name = entity.get("targetname").unwrap_or("");
    let target = entity.setting("autominlight_target").filter(|t| !t.is_empty());
    let probe = target
        .and_then(|t| entities.iter().find(|e| e.get("targetname") == Some(t)))
        .map(|e| e.setting("origin").and_then(keys::vector).unwrap_or(Vec3::ZERO));
    let switch = switches.iter().find(|(target, _)| *target == name);
    let shadow_self = on("shadowself") || on("selfshadow");
    let shadow = if on("switchableshadow") || switch.is_some() {
        ShadowClass::Switchable
    } else if on("shadow") {
        ShadowClass::Shadow
    } else if shadow_self {
        ShadowClass::ShadowSelf
    } else if on("shadowworldonly") {
        ShadowClass::ShadowWorldOnly
    } else {
        ShadowClass::None
    };
    Model {
        offset: entity.setting("origin").and_then(keys::vector).unwrap_or(Vec3::ZERO),
        shadow,
        shadow_self,
        shadow_world_only: on("shadowworldonly"),
        switch_style: switch.map_or_else(|| style(entity, "switchshadstyle"), |s| s.1),
        alpha: number("alpha").map(|a| a.clamp(0.0, 1.0)),
        channel_mask: entity.setting("object_channel_mask").map_or(1, keys::integer),
        light_ignore: entity.setting("lightignore").is_some_and(keys::boolean),
        max_light: number("maxlight"),
        colour_scale: number("lightcolorscale"),
        no_dirt: number("dirt").map(|v| v == -1.0),
        no_bounce: number("bounce") == Some(-1.0),
        phong_angle: whole_angle(match number("phong_angle") {
            Some(angle) if angle != 0.0 => angle,
            _ if on("phong") => DEFAULT_ANGLE,
            _ => 0.0,
        }),
        minlight: number("minlight"),
        minlight_colour: ["minlight_color", "mincolor"]
            .iter()
            .find_map(|k| entity.setting(k).and_then(keys::colour)),
        minlight_mottle: ["minlight_mottle", "minlightMottle"]
            .iter()
            .find_map(|k| entity.setting(k).map(keys::boolean)),
        auto_minlight: match entity.setting("autominlight").map(keys::boolean) {
            None => AutoMinlight::Occluded,
            Some(true) => AutoMinlight::All,
            Some(false) => AutoMinlight::Off,
        },
        centre: probe.unwrap_or((record.mins + record.maxs) * 0.5),
    }
}
