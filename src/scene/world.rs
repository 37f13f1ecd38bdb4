//! Settings that the map's worldspawn makes for the whole scene (contract section 9.2).

use super::bounce_keys::BounceSettings;
use super::dirt::DirtSettings;
use super::keys;
use super::overrides;
use super::radiosity_lights::SurflightSettings;
use crate::Result;
use crate::bsp::{Entity, StyleRange, parse_entities};
use glam::Vec3;

/// Worldspawn settings. Any of them may be spelled with leading underscores.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldSettings {
    /// `dist`: scale on all light distances, 0 to 100.
    pub dist: f32,
    /// `range`: luxel level per light unit, 0 to 100.
    pub range: f32,
    /// `anglescale`: share of the cosine law for lights without their own, 0 to 1.
    pub angle_scale: f32,
    /// `gamma`: output gamma, 0 to 100.
    pub gamma: f32,
    /// `maxlight`: cap on luxels, 0 is none.
    pub max_light: f32,
    /// `spotlightautofalloff`: targeted linear spots end just behind their target.
    pub spotlight_auto_falloff: bool,
    /// `gate`: contributions up to this brightness are dropped without tracing a ray.
    pub gate: f32,
    /// `surflight_subdivide`: size of the pieces of a light surface, in world units, 1 to 2048.
    pub surface_light_size: f32,
    /// `surflight_radiosity`: mode of surface lights without their own: 0 places point
    /// lights, 1 lights in the manner of radiosity.
    pub surface_light_mode: i32,
    /// `addmin`: minimum light is added to other light instead of being the least.
    pub add_min: bool,
    /// `light`, `minlight`: minimum light everywhere, in light units.
    pub minlight: f32,
    /// `minlight_color`: its colour, 0 to 255 a channel.
    pub minlight_colour: Vec3,
    /// `minlight_mottle`: minimum light is mottled.
    pub minlight_mottle: bool,
    /// Dirt.
    pub dirt: DirtSettings,
    /// `phong`: normals are smoothed at all.
    pub phong: bool,
    /// Surface lights in the manner of radiosity.
    pub surflight: SurflightSettings,
    /// `compilerstyle_start`, `compilerstyle_max`: the styles of switchable lights.
    pub styles: StyleRange,
    /// Bounced light.
    pub bounce: BounceSettings,
    /// `nolights`: light entities do not shine, the suns of worldspawn do.
    pub no_lights: bool,
    /// `nolighting`: of the light entities only those shine that have a `style` or switch a shadow, and
    /// there is no minimum light.
    pub no_lighting: bool,
    /// `_lightmap_scale`: world units (texels) between luxels, 16 by default.
    pub luxel_size: u32,
}

impl Default for WorldSettings {
    fn default() -> Self {
        Self {
            dist: 1.0,
            range: 0.5,
            angle_scale: 0.5,
            gamma: 1.0,
            max_light: 0.0,
            spotlight_auto_falloff: false,
            gate: 0.001,
            surface_light_size: 128.0,
            surface_light_mode: 0,
            add_min: false,
            minlight: 0.0,
            minlight_colour: Vec3::splat(255.0),
            minlight_mottle: false,
            dirt: DirtSettings::default(),
            phong: true,
            surflight: SurflightSettings::default(),
            styles: StyleRange::default(),
            bounce: BounceSettings::default(),
            no_lights: false,
            no_lighting: false,
            luxel_size: 16,
        }
    }
}

impl WorldSettings {
    /// Reads the keys of worldspawn. Unusable values keep the default with a warning.
    pub(crate) fn read(world: &Entity, warnings: &mut Vec<String>) -> Self {
        let mut s = Self::default();
        let mut set = |names: &[&str], low: f32, high: f32, value: &mut f32| {
            for name in names {
                let Some(v) = world.setting(name).and_then(keys::number) else { continue };
                *value = v.clamp(low, high);
                if *value != v {
                    warnings.push(format!(
                        "worldspawn {name}: {v} is outside {low} to {high}, {value} is used"
                    ));
                }
            }
        };
        set(&["dist"], 0.0, 100.0, &mut s.dist);
        set(&["range"], 0.0, 100.0, &mut s.range);
        set(&["anglesense", "anglescale"], 0.0, 1.0, &mut s.angle_scale);
        set(&["gamma"], 0.0, 100.0, &mut s.gamma);
        set(&["maxlight"], 0.0, f32::MAX, &mut s.max_light);
        set(&["gate"], 0.0, f32::MAX, &mut s.gate);
        set(&["surflight_subdivide"], 1.0, 2048.0, &mut s.surface_light_size);
        set(&["minlight", "light"], 0.0, f32::MAX, &mut s.minlight);
        let flag =
            |names: &[&str]| names.iter().any(|n| world.setting(n).is_some_and(keys::boolean));
        s.add_min = flag(&["addmin"]);
        s.minlight_mottle = flag(&["minlight_mottle", "minlightMottle"]);
        s.minlight_colour = ["minlight_color", "mincolor"]
            .iter()
            .find_map(|k| world.setting(k).and_then(keys::colour))
            .unwrap_or(s.minlight_colour);
        s.phong = world.setting("phong").is_none_or(keys::boolean);
        s.dirt = DirtSettings::read(world, &mut set);
        s.surflight = SurflightSettings::read(world, &mut set);
        s.bounce = BounceSettings::read(world, &mut set);
        s.spotlight_auto_falloff = world.setting("spotlightautofalloff").is_some_and(keys::boolean);
        s.surface_light_mode = world.setting("surflight_radiosity").map_or(0, keys::integer);
        s.styles = styles(world);
        s.no_lighting = world.setting("nolighting").is_some_and(keys::boolean);
        s.no_lights = world.setting("nolights").is_some_and(keys::boolean);
        let luxel = world.setting("lightmap_scale").map_or(0, keys::integer);
        match u32::try_from(luxel) {
            Ok(0) => {}
            Ok(size) => s.luxel_size = size,
            Err(_) => warnings.push(format!(
                "worldspawn _lightmap_scale: {luxel} is negative, 16 is used; give 1 or more"
            )),
        }
        if s.gate > 1.0 {
            warnings.push(format!(
                "worldspawn gate: {} drops light that can be seen; use 1 or less",
                s.gate
            ));
        }
        s
    }
}

/// The styles of switchable lights by the keys of worldspawn.
fn styles(world: &Entity) -> StyleRange {
    let style = |name: &str, default: u16| {
        let given = world.setting(name).map(keys::integer);
        given.map_or(default, |style| style.clamp(1, u16::MAX.into()) as u16)
    };
    let default = StyleRange::default();
    StyleRange {
        first: style("compilerstyle_start", default.first),
        limit: style("compilerstyle_max", default.limit),
    }
}

/// The styles that switchable lights get in a map with this entity text, where `overrides` are
/// worldspawn keys and values that win over those of the map.
///
/// # Errors
/// When the entity text is damaged.
pub fn style_range(entities: &[u8], overrides: &[(String, String)]) -> Result<StyleRange> {
    let entities = parse_entities(entities)?;
    let world = entities.first().cloned().unwrap_or_default();
    Ok(styles(&overrides::apply(&world, overrides)))
}
