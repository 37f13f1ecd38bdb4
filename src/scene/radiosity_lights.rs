//! Surface lights in the manner of radiosity (mode 1 of the contract's section 4.7): a face gives
//! off light from a few points over it, in proportion to its area.

use super::entity_lights::Draft;
use super::exact::normalize;
use super::keys;
use super::minlight::Glow;
use super::shape::area_and_centre;
use super::sidecar::SurflightKeys;
use super::solid::Solid;
use super::surface_lights::Faces;
use super::winding::{dice, mean, without_colinear};
use super::world::WorldSettings;
use crate::bsp::Entity;
use glam::Vec3;

/// How many points stand for a light surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EmissiveQuality {
    /// One, over its middle.
    #[default]
    Low,
    /// Its middle and its corners.
    Medium,
    /// One every [`SurflightSettings::subdivision`] units.
    High,
}

/// Worldspawn's settings of surface lights in the manner of radiosity.
#[derive(Clone, Debug, PartialEq)]
pub struct SurflightSettings {
    /// `surflightscale`: factor on their light.
    pub scale: f32,
    /// `surflightskyscale`: factor on the light of those that shine in all directions.
    pub sky_scale: f32,
    /// `surflightskydist`: added to the distance of those, in world units.
    pub sky_distance: f32,
    /// `surflightsubdivision`: distance of points at high quality, in world units, 1 to 8192.
    pub subdivision: f32,
    /// `emissivequality`.
    pub quality: EmissiveQuality,
    /// `surflight_minlight_scale`: share of its brightness that a light surface glows with.
    pub minlight_scale: f32,
    /// `sky_surface`: colour of templates with `_surface_is_sky`, 0 to 255 a channel.
    pub sky_colour: Option<Vec3>,
}

impl Default for SurflightSettings {
    fn default() -> Self {
        Self {
            scale: 1.0,
            sky_scale: 1.0,
            sky_distance: 0.0,
            subdivision: 16.0,
            quality: EmissiveQuality::Low,
            minlight_scale: 1.0,
            sky_colour: None,
        }
    }
}

impl SurflightSettings {
    pub(crate) fn read(world: &Entity, set: &mut super::dirt::SetNumber<'_>) -> Self {
        let mut s = Self::default();
        set(&["surflightscale"], 0.0, f32::MAX, &mut s.scale);
        set(&["surflightskyscale"], 0.0, f32::MAX, &mut s.sky_scale);
        set(&["surflightskydist"], 0.0, f32::MAX, &mut s.sky_distance);
        set(&["choplight", "surflightsubdivision"], 1.0, 8192.0, &mut s.subdivision);
        set(&["surflight_minlight_scale"], 0.0, 510.0, &mut s.minlight_scale);
        let quality = world.setting("emissivequality").unwrap_or("").trim().to_ascii_lowercase();
        s.quality = match &*quality {
            "medium" | "1" => EmissiveQuality::Medium,
            "high" | "2" => EmissiveQuality::High,
            _ => EmissiveQuality::Low,
        };
        s.sky_colour =
            ["sky_surface", "sun_surface"].iter().find_map(|k| keys::colour(world.setting(k)?));
        s
    }
}

/// A surface that gives off light from points over it.
#[derive(Clone, Debug, PartialEq)]
pub struct RadiosityLight {
    /// Index of the surface.
    pub surface: u32,
    /// Unit direction in which it shines.
    pub normal: Vec3,
    /// The point over its middle.
    pub middle: Vec3,
    /// Where its light comes from.
    pub points: Vec<Vec3>,
    /// Colour; its largest channel is 1 unless the light is very weak.
    pub colour: Vec3,
    /// Light of all points together: light units times square world units.
    pub total: f32,
    /// Light of one point.
    pub intensity: f32,
    /// Light style.
    pub style: u16,
    /// The cosines at both ends are softened to half of themselves plus a half.
    pub rescale: bool,
    /// Shines alike in all directions.
    pub all_around: bool,
    /// Scale on distances.
    pub attenuation: f32,
    /// Factor on its light where it bounces (`bouncescale`), 0 and up.
    pub bounce_scale: f32,
}

/// What surface lights need of a face besides [`Faces`].
pub(crate) struct Emissive<'a> {
    /// Keys of each face.
    pub keys: &'a [SurflightKeys],
    pub world: &'a WorldSettings,
    pub entities: &'a [Entity],
    pub solid: &'a Solid,
}

/// The light surfaces of the templates, and the glow of each face: face by face, template by template.
pub(crate) fn build(
    drafts: &[Draft],
    faces: &Faces<'_>,
    emissive: &Emissive<'_>,
) -> (Vec<RadiosityLight>, Vec<Option<Glow>>) {
    let mut lights = Vec::new();
    let mut glows = vec![None; faces.surfaces.len()];
    let templates: Vec<(&Draft, String)> = drafts
        .iter()
        .filter_map(|d| Some((d, d.template.as_ref().filter(|t| t.radiosity)?)))
        .map(|(d, t)| (d, t.texture.to_ascii_lowercase()))
        .collect();
    let mut styles = Styles::new(emissive.entities, emissive.world.styles.first);
    for (face, name) in faces.names.iter().enumerate().filter(|(_, n)| *n != "trigger") {
        for (draft, texture) in &templates {
            let template = draft.template.as_ref().expect("only templates are listed");
            if texture != name || template.group != faces.groups[face] {
                continue;
            }
            let colour = colour(draft, face, faces, emissive);
            let keys = &emissive.keys[face];
            let style = keys
                .targetname
                .as_deref()
                .map(|n| styles.of(n))
                .or(keys.style)
                .unwrap_or(draft.light.style);
            let Some(light) = light(draft, face, (colour, style), faces, emissive) else {
                continue;
            };
            let share = template.minlight_scale * keys.minlight_scale.unwrap_or(1.0);
            if glows[face].is_none() && share > 0.0 {
                let own = template.has_colour.then_some(draft.light.colour);
                glows[face] = Some(Glow {
                    level: draft.light.brightness.trunc() * share,
                    colour: own.unwrap_or(faces.colours[face] * 255.0),
                    style: draft.light.style,
                });
            }
            lights.push(light);
        }
    }
    (lights, glows)
}

/// Colour of a light surface, 0 to 255 a channel.
fn colour(draft: &Draft, face: usize, faces: &Faces<'_>, emissive: &Emissive<'_>) -> Vec3 {
    let template = draft.template.as_ref();
    let own = template.is_some_and(|t| t.has_colour).then_some(draft.light.colour);
    let sky = template.is_some_and(|t| t.is_sky).then_some(emissive.world.surflight.sky_colour);
    emissive.keys[face]
        .colour
        .or(own)
        .or(sky.flatten())
        // The reference keeps the means of textures in bytes.
        .unwrap_or_else(|| (faces.colours[face] * 255.0 + 1e-3).floor())
}

fn light(
    draft: &Draft,
    face: usize,
    (colour, style): (Vec3, u16),
    faces: &Faces<'_>,
    emissive: &Emissive<'_>,
) -> Option<RadiosityLight> {
    let template = draft.template.as_ref()?;
    let shape = &faces.shapes[face];
    let (area, _) = area_and_centre(&shape.vertices);
    if !area.is_finite() || area < 1.0 {
        return None;
    }
    let mut colour = colour / 255.0 * draft.light.brightness.trunc();
    let most = colour.max_element();
    if most == 0.0 || !most.is_finite() {
        return None;
    }
    // A weak light keeps its colour and is scaled by its brightness too: the contract's Q33.
    if most > 1.0 {
        colour *= 1.0 / most;
    }
    let keys = &emissive.keys[face];
    let winding = without_colinear(&faces.surfaces[face].vertices);
    let (middle, points, count) = points(&winding, shape.normal, emissive)?;
    let total = most * area;
    Some(RadiosityLight {
        surface: face as u32,
        normal: shape.normal,
        middle,
        points,
        colour,
        total,
        intensity: total / count as f32,
        style,
        rescale: keys.rescale.unwrap_or(!template.is_sky),
        all_around: template.all_around,
        attenuation: keys.attenuation.unwrap_or(1.0),
        bounce_scale: draft.light.bounce_scale,
    })
}

/// The middle point, the points that shine, and how many there were before some were found in solid.
fn points(
    winding: &[Vec3],
    normal: Vec3,
    emissive: &Emissive<'_>,
) -> Option<(Vec3, Vec<Vec3>, usize)> {
    let centre = mean(winding);
    let middle = centre + normal;
    if !middle.is_finite() {
        return None;
    }
    let settings = &emissive.world.surflight;
    let all: Vec<Vec3> = match settings.quality {
        EmissiveQuality::Low => return Some((middle, vec![middle], 1)),
        EmissiveQuality::Medium => {
            let corner = |v: &Vec3| *v + normal + normalize(centre - *v);
            std::iter::once(middle).chain(winding.iter().map(corner)).collect()
        }
        EmissiveQuality::High => {
            dice(winding, settings.subdivision)?.iter().map(|piece| mean(piece) + normal).collect()
        }
    };
    let free = all.iter().filter_map(|p| emissive.solid.freed(*p, 0.5)).collect();
    Some((middle, free, all.len()))
}

/// Switchable styles by name, continuing those of the light entities.
struct Styles {
    known: Vec<(String, u16)>,
    next: u16,
}

impl Styles {
    fn new(entities: &[Entity], first: u16) -> Self {
        let mut known = Vec::new();
        let mut next = first;
        for entity in entities {
            let style = entity.get("style").or(entity.get("switchshadstyle")).map(keys::integer);
            let name = entity.get("targetname").unwrap_or("");
            let style = style.and_then(|s| u16::try_from(s).ok()).filter(|s| *s >= first);
            if let Some(style) = style.filter(|_| !name.is_empty()) {
                known.push((name.to_owned(), style));
                next = next.max(style.saturating_add(1));
            }
        }
        Self { known, next }
    }

    fn of(&mut self, name: &str) -> u16 {
        if let Some((_, style)) = self.known.iter().find(|(n, _)| n == name) {
            return *style;
        }
        let style = self.next;
        self.next = self.next.saturating_add(1);
        self.known.push((name.to_owned(), style));
        style
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_keep_the_styles_of_lights_and_new_ones_follow() {
        let mut entity = Entity::default();
        entity.set("targetname", "a");
        entity.set("style", "33");
        let mut styles = Styles::new(&[entity], 32);
        assert_eq!(
            [styles.of("a"), styles.of("b"), styles.of("b"), styles.of("c")],
            [33, 34, 34, 35]
        );
    }
}
