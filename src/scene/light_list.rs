//! From light entities, as [`super::entity_lights`] reads them, to the list of lights that shine:
//! copies, targets and cones, places out of solid (contract sections 4.3 and 4.5).

use super::entity_lights::Draft;
use super::exact::{length, normalize, radians};
use super::keys;
use super::lights::{Attenuation, Light, Spot};
use super::random::Random;
use super::solid::Solid;
use super::suns::{SkyLight, Source, Sun};
use super::world::WorldSettings;
use crate::bsp::Entity;
use crate::{Error, Result};
use glam::Vec3;
use std::collections::HashMap;

/// The most lights that a scene may have, copies included.
const LIGHT_LIMIT: usize = 1 << 20;
/// How far a light may be moved out of solid, in world units.
const NUDGE: f32 = 2.0;

/// Turns drafts, surface copies already appended, into the lights that shine, and those that add to
/// the sky.
pub(crate) fn finish(
    mut drafts: Vec<Draft>,
    entities: &[Entity],
    world: &WorldSettings,
    solid: &Solid,
    random: &mut Random,
    warnings: &mut Vec<String>,
) -> Result<(Vec<Light>, Vec<Source>)> {
    for draft in drafts.iter_mut().filter(|d| d.template.is_some()) {
        draft.light.brightness = 0.0;
    }
    add_jittered(&mut drafts, random)?;
    let (mut lights, mut sky) = (Vec::new(), Vec::new());
    let mut stuck = Vec::new();
    let targets = Targets::new(entities);
    for mut draft in drafts {
        aim(&mut draft, &targets, world, warnings);
        if draft.light.brightness == 0.0 {
            continue;
        }
        if let Some(source) = sky_source(&draft, &targets, warnings) {
            sky.push(source);
            continue;
        }
        let default_channel = draft.light.channel_mask == 1 && draft.light.shadow_mask == 1;
        if !draft.no_nudge && default_channel {
            match solid.freed(draft.light.origin, NUDGE) {
                Some(origin) => draft.light.origin = origin,
                None => stuck.push(draft.light.origin),
            }
        }
        lights.push(draft.light);
    }
    if let Some(first) = stuck.first() {
        warnings.push(format!(
            "{} lights are inside solid, the first at {} {} {}; move them",
            stuck.len(),
            first.x,
            first.y,
            first.z
        ));
    }
    Ok((lights, sky))
}

/// The light as a source in the sky, if it is one and adds light.
fn sky_source(draft: &Draft, targets: &Targets, warnings: &mut Vec<String>) -> Option<Source> {
    let sky = draft.sky.as_ref()?;
    let light = &draft.light;
    if light.brightness <= 0.0 {
        return None;
    }
    let origin = light.origin;
    let travel = match (targets.of(draft), &light.spot) {
        (Some(target), _) => target - origin,
        (None, Some(spot)) => spot.direction,
        (None, None) => {
            if sky.kind == SkyLight::Sun {
                warnings.push(format!(
                    "sun at {} {} {} has neither target nor mangle: it shines towards 0 0 0",
                    origin.x, origin.y, origin.z
                ));
            }
            -origin
        }
    };
    Some(Source {
        kind: sky.kind,
        travel,
        penumbra: sky.penumbra,
        light: Sun {
            to_sun: Vec3::Z,
            brightness: light.brightness,
            colour: light.colour,
            angle_scale: light.angle_scale,
            style: light.style,
            dirt: sky.dirt,
            bounce_scale: light.bounce_scale,
            sky_texture: sky.texture,
            dome: false,
        },
    })
}

/// Where entities with a name are; of several with one name the first counts, in any case of letters.
struct Targets(HashMap<String, Vec3>);

impl Targets {
    fn new(entities: &[Entity]) -> Self {
        let mut places = HashMap::new();
        for entity in entities {
            if let Some(name) = entity.get("targetname") {
                let origin = entity.get("origin").and_then(keys::vector).unwrap_or(Vec3::ZERO);
                places.entry(name.to_ascii_lowercase()).or_insert(origin);
            }
        }
        Self(places)
    }

    /// Where the entity is that the light targets.
    fn of(&self, draft: &Draft) -> Option<Vec3> {
        if draft.target.is_empty() {
            return None;
        }
        self.0.get(&draft.target.to_ascii_lowercase()).copied()
    }
}

/// Refuses a number of lights that would take too much memory and time.
pub(crate) fn check_light_count(count: usize) -> Result<()> {
    if count <= LIGHT_LIMIT {
        return Ok(());
    }
    Err(Error::Limit {
        what: "number of lights, with the copies that _surface, _samples and skies make".into(),
        value: count as u64,
        limit: LIGHT_LIMIT as u64,
        advice: "lower _samples or _sunsamples, or raise worldspawn _surflight_subdivide",
    })
}

/// Appends the copies of lights with `_deviance`, spread over a cube around each.
fn add_jittered(drafts: &mut Vec<Draft>, random: &mut Random) -> Result<()> {
    let total = drafts.iter().fold(0_usize, |n, d| {
        n.saturating_add(if d.light.brightness == 0.0 || d.sky.is_some() {
            1
        } else {
            d.samples as usize
        })
    });
    check_light_count(total)?;
    for i in 0..drafts.len() {
        if drafts[i].light.brightness == 0.0 || drafts[i].sky.is_some() {
            continue;
        }
        let deviance = drafts[i].deviance;
        for _ in 1..drafts[i].samples {
            let mut offset = || deviance * (2.0 * random.next() - 1.0);
            let (x, y, z) = (offset(), offset(), offset());
            let mut copy = drafts[i].clone();
            copy.light.origin += Vec3::new(x, y, z);
            drafts.push(copy);
        }
    }
    Ok(())
}

/// Points the light at its target and works out its cone.
fn aim(draft: &mut Draft, targets: &Targets, world: &WorldSettings, warnings: &mut Vec<String>) {
    let mut target_distance = 0.0;
    if !draft.target.is_empty() {
        if let Some(at) = targets.of(draft) {
            let towards = at - draft.light.origin;
            target_distance = length(towards);
            draft.is_spot = true;
            draft.light.spot = Some(Spot { direction: normalize(towards), outer: 0.0, inner: 0.0 });
        } else {
            let o = draft.light.origin;
            warnings.push(format!(
                "light at {} {} {}: no entity has the targetname {:?}; it shines in all directions",
                o.x, o.y, o.z, draft.target
            ));
        }
    }
    let (outer, inner) = (draft.outer_angle, draft.inner_angle);
    let inner = if inner <= 0.0 || inner > outer { outer } else { inner };
    if !draft.is_spot {
        return;
    }
    if let Some(spot) = &mut draft.light.spot {
        spot.outer = -(radians(outer / 2.0).cos()) as f32;
        spot.inner = -(radians(inner / 2.0).cos()) as f32;
    }
    if world.spotlight_auto_falloff
        && target_distance > 0.0
        && draft.light.attenuation == Attenuation::Linear
    {
        let radius = f64::from(target_distance) * radians(outer / 2.0).tan();
        draft.light.attenuation =
            Attenuation::Falloff((f64::from(target_distance) + radius) as f32);
    }
}
