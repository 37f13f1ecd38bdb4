//! Reflectance of surfaces, from the textures (contract section 8.2, but not truncated).

use super::bounce_keys::BounceSettings;
use super::build::SceneSettings;
use super::material_file::{Material, MaterialReflectance};
use crate::bsp::{Bsp, MipTex, average_colour};
use crate::photometry::Reflectance;
use glam::Vec3;
use std::collections::BTreeSet;

/// Reflectance where the texture is unknown.
const GREY: f32 = 0.5;
/// What is mixed with the colour of a texture, and all that the reference has by default.
const COMPAT_GREY: f32 = 127.0 / 255.0;
/// The most that a surface may reflect: at 1 light in a closed room would never die away.
pub(super) const LIMIT: f32 = 0.99;

/// Reflectance of every slot of the texture lump, by its index, and one for faces without texture.
pub(crate) struct Materials {
    slots: Vec<Reflectance>,
    none: Reflectance,
    colours: Vec<Vec3>,
    lacking: Vec<Option<String>>,
    too_bright: Vec<bool>,
}

impl Materials {
    /// Averages the textures of the BSP, or their replacements of the same name.
    pub fn new(bsp: &Bsp, settings: &SceneSettings, bounce: &BounceSettings) -> Self {
        let share = bounce.colour_share.unwrap_or(if settings.compat_bounce { 0.0 } else { 1.0 });
        let scaled = |colour: Vec3| {
            let mixed = Vec3::splat(COMPAT_GREY).lerp(colour, share);
            let colour = if settings.grey { Vec3::splat(GREY) } else { mixed };
            colour * settings.reflectance_scale
        };
        let limited = |scaled: Vec3| Reflectance(scaled.clamp(Vec3::ZERO, Vec3::splat(LIMIT)));
        let none = limited(scaled(Vec3::splat(GREY)));
        let (mut lacking, mut too_bright) = (Vec::new(), Vec::new());
        let mut colours = Vec::new();
        let slots = bsp
            .textures
            .iter()
            .map(|slot| {
                let colour = slot.as_ref().and_then(|t| average(t, &settings.textures));
                lacking.push(match (&colour, slot) {
                    (Some(_), _) => None,
                    (None, Some(t)) => Some(t.name.clone()),
                    (None, None) => Some("(absent from the BSP)".to_owned()),
                });
                let colour = colour.map_or(Vec3::splat(GREY), |c| saturated(c, bounce.saturation));
                colours.push(colour);
                let scaled = scaled(colour);
                too_bright.push(scaled.max_element() > LIMIT);
                limited(scaled)
            })
            .collect();
        Self { slots, none, colours, lacking, too_bright }
    }

    /// Reflectance of the texture in a slot of the texture lump.
    pub fn of(&self, texture: Option<u32>) -> Reflectance {
        texture.and_then(|t| self.slots.get(t as usize)).copied().unwrap_or(self.none)
    }

    /// Reflectance of the texture in a slot as a material file has it. What passes through takes its part.
    pub fn given(&self, texture: Option<u32>, material: &Material) -> Reflectance {
        let own = match material.reflectance {
            None => self.of(texture).0,
            Some(MaterialReflectance::Colour(colour)) => colour,
            Some(MaterialReflectance::Scale(scale)) => self.colour(texture) * scale,
        };
        let through = material.diffuse_transmission.unwrap_or(Vec3::ZERO);
        Reflectance(own.min(Vec3::splat(LIMIT) - through).max(Vec3::ZERO))
    }

    /// Mean colour of the texture in a slot, 0 to 1, whatever the settings make of its reflectance.
    pub fn colour(&self, texture: Option<u32>) -> Vec3 {
        let slot = texture.and_then(|t| self.colours.get(t as usize));
        slot.copied().unwrap_or(Vec3::splat(GREY))
    }

    /// Warns about the textures of reflecting surfaces: once about those whose pixels are not known,
    /// and once about those that would reflect too much.
    pub fn warn(&self, used: impl Iterator<Item = u32>, warnings: &mut Vec<String>) {
        let used: BTreeSet<usize> = used.map(|t| t as usize).collect();
        let names: BTreeSet<&str> =
            used.iter().filter_map(|&t| self.lacking.get(t)?.as_deref()).collect();
        if !names.is_empty() {
            let names: Vec<&str> = names.into_iter().collect();
            warnings.push(format!(
                "no pixels for the textures {}: reflectance 0.5 is used; give a WAD with --wad",
                names.join(", ")
            ));
        }
        let count = used.iter().filter(|&&t| self.too_bright.get(t) == Some(&true)).count();
        if count > 0 {
            warnings.push(format!(
                "{count} textures reflect more than {LIMIT} and are lowered to it; \
                 lower --reflectance-scale"
            ));
        }
    }
}

/// A colour pushed away from grey: mixed with twice its square, which is dimmed to at most 1.
fn saturated(colour: Vec3, share: f32) -> Vec3 {
    let square = colour * colour * 2.0;
    colour.lerp(square / square.max_element().max(1.0), share)
}

/// Mean colour of a texture in 0 to 1, from its own pixels or those of its replacement.
fn average(texture: &MipTex, replacements: &[MipTex]) -> Option<Vec3> {
    let own = texture.pixels.as_deref();
    let pixels = own.or_else(|| {
        let same = replacements.iter().find(|r| r.name.eq_ignore_ascii_case(&texture.name))?;
        same.pixels.as_deref()
    })?;
    average_colour(pixels)
}
