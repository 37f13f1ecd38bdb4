//! Light that a material file lets textures give off.

use super::material_file::{Emitting, MaterialFile};
use super::materials::Materials;
use super::surface::Surface;
use super::surface_lights::Emitter;
use crate::bsp::{Bsp, Entity};
use crate::photometry::Exitance;
use glam::Vec3;
use std::f32::consts::PI;

/// Appends a light for each texture whose faces shine all over: the one that a line of a `.rad` file would
/// make.
pub(super) fn add_lights(
    entities: &mut Vec<Entity>,
    (file, bsp): (&MaterialFile, &Bsp),
    materials: &Materials,
) {
    if file.is_empty() {
        return;
    }
    let mut done = Vec::new();
    for (slot, texture) in bsp.textures.iter().enumerate() {
        let Some(texture) = texture else { continue };
        let name = texture.name.to_ascii_lowercase();
        let emission = file.of(&name).emission.filter(|e| e.parts == Emitting::Face);
        let Some(emission) = emission.filter(|_| !done.contains(&name)) else { continue };
        let colour = emission.colour.unwrap_or_else(|| materials.colour(Some(slot as u32)));
        let Vec3 { x, y, z } = colour * 255.0;
        let mut entity = Entity::default();
        entity.set("classname", "light");
        entity.set("_surface", &name);
        entity.set("_color", format!("{x} {y} {z}"));
        entity.set("light", emission.intensity.to_string());
        entities.push(entity);
        done.push(name);
    }
}

/// The faces of which only some texels shine, as area light.
pub(super) fn emitters<'a>(
    names: &'a [String],
    file: &'a MaterialFile,
    surfaces: &'a [Surface],
) -> impl Iterator<Item = Emitter> + 'a {
    let faces = names.iter().zip(surfaces).enumerate().filter(|_| !file.is_empty());
    faces.filter(|(_, (_, surface))| surface.luxels.is_some()).filter_map(|(surface, (name, _))| {
        let emission = file.of(name).emission.filter(|e| e.parts != Emitting::Face)?;
        Some(Emitter {
            surface: surface as u32,
            style: 0,
            exitance: Exitance(Vec3::splat(emission.intensity * PI)),
            bounce_scale: 1.0,
            varied: true,
        })
    })
}
