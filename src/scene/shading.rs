//! What a material file makes of single surfaces: values that vary over them.

use super::Scene;
use super::effects::COMPILED;
use super::exact::brightness;
use super::material_file::{Emitting, Material, MaterialEmission, Modifier};
use super::materials::LIMIT;
use super::texels::Texels;
use crate::bsp::FULLBRIGHTS;
use glam::{Vec3, Vec4};
use std::sync::Arc;

/// How a surface varies.
#[derive(Clone, Debug)]
pub struct Shading {
    modifier: Option<Modifier>,
    emission: Option<MaterialEmission>,
    /// Pixels, the coefficients of the texture's axes, and the offset of the brush model.
    texels: Option<Arc<Texels>>,
    axes: [Vec4; 2],
    offset: Vec3,
    /// Mean colour of the texture, 0 to 1.
    mean: Vec3,
    /// Colours are left out: switched off.
    grey: bool,
    /// What shines does so alike all over a patch: switched off.
    even: bool,
}

impl Shading {
    /// The parts of a material that vary; `None` if there are none.
    pub(super) fn of(
        material: &Material,
        texels: impl FnOnce() -> Option<Arc<Texels>>,
        (axes, offset, mean): ([Vec4; 2], Vec3, Vec3),
    ) -> Option<Self> {
        let emission = material.emission.filter(|e| e.parts != Emitting::Face);
        let modifier = material.modifier;
        (emission.is_some() || modifier.is_some()).then(|| Self {
            modifier,
            emission,
            texels: texels(),
            axes,
            offset,
            mean,
            grey: false,
            even: false,
        })
    }

    /// The albedo is the same all over, and what shines is so over each patch.
    pub(super) fn make_even(&mut self) {
        self.modifier = None;
        self.even = true;
    }

    /// All channels vary alike.
    pub(super) fn make_grey(&mut self) {
        self.grey = true;
    }

    /// Whether the albedo varies.
    pub fn is_uneven(&self) -> bool {
        self.modifier.is_some()
    }

    /// Whether what shines varies.
    pub fn glows_unevenly(&self) -> bool {
        self.emission.is_some() && !self.even
    }

    /// Whether it may bring colour to surfaces without.
    pub fn is_coloured(&self) -> bool {
        if self.grey {
            return false;
        }
        let is_grey = |c: Vec3| c == Vec3::splat(c.x);
        let texels = |e: &MaterialEmission| e.parts != Emitting::Face;
        self.emission.as_ref().is_some_and(texels)
            || match self.modifier {
                None => false,
                Some(Modifier::Texel) => true,
                Some(Modifier::Checker(_, colour) | Modifier::Gradient(_, colour)) => {
                    !is_grey(colour)
                }
            }
    }

    /// Texture coordinates of a world point.
    fn texture_at(&self, point: Vec3) -> [f32; 2] {
        let p = (point - self.offset).extend(1.0);
        self.axes.map(|axis| axis.dot(p))
    }

    /// The colour, or its brightness where all channels vary alike.
    fn seen(&self, colour: Vec3) -> Vec3 {
        if self.grey { Vec3::splat(brightness(colour)) } else { colour }
    }

    /// Albedo at a world point of a surface whose albedo is `base` where the factor is 1. What it reflects and
    /// what comes through it vary alike.
    #[inline]
    pub fn albedo(&self, base: Vec3, point: Vec3) -> Vec3 {
        (base * self.seen(self.factor(point))).min(Vec3::splat(LIMIT))
    }

    /// Factor on the albedo at a world point.
    fn factor(&self, point: Vec3) -> Vec3 {
        let [s, t] = self.texture_at(point);
        match self.modifier {
            None => Vec3::ONE,
            Some(Modifier::Texel) => {
                let texel = self.texels.as_ref().and_then(|texels| texels.colour_at(s, t));
                texel.map_or(Vec3::ONE, |c| c / 255.0 / self.mean.max(Vec3::splat(1e-3)))
            }
            Some(Modifier::Checker(size, colour)) => {
                let [s, t] = [s, t].map(|x| floor(x / size));
                let odd = s.wrapping_add(t) & 1 == 1;
                if odd { colour } else { Vec3::ONE }
            }
            Some(Modifier::Gradient([from, to], colour)) => {
                let along = if from == to { 1.0 } else { (point.z - from) / (to - from) };
                Vec3::ONE.lerp(colour, along.clamp(0.0, 1.0))
            }
        }
    }

    /// Share of the emission at a world point, with the colour of the texel.
    pub fn glow(&self, point: Vec3) -> Vec3 {
        let Some(emission) = &self.emission else { return Vec3::ZERO };
        let [s, t] = self.texture_at(point);
        let Some(texels) = &self.texels else { return Vec3::ZERO };
        let shines =
            emission.parts == Emitting::Texture || FULLBRIGHTS.contains(&texels.index_at(s, t));
        let colour = texels.colour_at(s, t).filter(|_| shines);
        let own = emission.colour.unwrap_or(Vec3::ONE);
        colour.map_or(Vec3::ZERO, |c| self.seen(c / 255.0 * own))
    }
}

impl Scene {
    /// How a surface varies; `None` where it does not.
    pub fn shading(&self, surface: usize) -> Option<&Arc<Shading>> {
        self.shadings.get(surface)?.as_ref().filter(|_| COMPILED)
    }

    /// Whether a surface sends light on or emits unevenly.
    pub fn varies(&self, surface: usize) -> bool {
        self.shading(surface).is_some()
    }

    /// How the albedo of a surface varies; `None` where it is the same all over.
    pub fn uneven(&self, surface: usize) -> Option<&Arc<Shading>> {
        self.shading(surface).filter(|s| s.is_uneven())
    }

    /// Albedo of a surface at each of some world points, the mean; `None` where it is the same all over.
    pub fn mean_albedo(&self, surface: usize, points: impl Iterator<Item = Vec3>) -> Option<Vec3> {
        let shading = self.uneven(surface)?;
        let base = self.surfaces[surface].albedo();
        Some(mean(points, |p| shading.albedo(base, p)))
    }

    /// Share and colour of what a surface emits, the mean over some world points; `None` where it is the
    /// same all over.
    pub fn mean_glow(&self, surface: usize, points: impl Iterator<Item = Vec3>) -> Option<Vec3> {
        let shading = self.shading(surface).filter(|s| s.emission.is_some())?;
        Some(mean(points, |p| shading.glow(p)))
    }
}

/// The whole number at or below. Processors that any build runs on have no instruction for it.
fn floor(x: f32) -> i64 {
    let n = x as i64;
    n.saturating_sub(i64::from((n as f32) > x))
}

/// Mean over points; 0 without any.
fn mean(points: impl Iterator<Item = Vec3>, value: impl Fn(Vec3) -> Vec3) -> Vec3 {
    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
    for point in points {
        sum += value(point);
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { Vec3::ZERO }
}
