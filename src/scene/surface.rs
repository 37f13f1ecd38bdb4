//! One surface a BSP face: its polygon, material and luxel grid.

use super::minlight::Minlight;
use super::tracer::Polygon;
use crate::photometry::Reflectance;
use glam::{Vec2, Vec3, Vec4};

/// What a surface does to light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Blocks light, and sends back its reflectance when it is lightmapped.
    Solid,
    /// Blocks light and sends nothing back.
    Sky,
    /// Stops some light and lets some pass (fences, glass, and faces of models that cast shadow in
    /// special ways or channels), and sends nothing back. Bounced light passes through it, through glass
    /// with its tint.
    Filter,
    /// Neither blocks nor reflects (liquids and models without shadow).
    ///
    /// Whatever their role, surfaces receive light when they are lightmapped.
    Ghost,
}

/// The luxels of a lightmapped face: `width` x `height` samples on integer luxel coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct LuxelGrid {
    /// Columns, along the texture's s axis.
    pub width: u32,
    /// Rows, along the texture's t axis.
    pub height: u32,
    /// World to luxel coordinates, `row.xyz . p + row.w`: column.
    pub s_row: Vec4,
    /// World to luxel coordinates: row.
    pub t_row: Vec4,
    /// World position of luxel (0, 0) on the face plane.
    pub origin: Vec3,
    /// World step from one luxel to the next column, within the face plane.
    pub s_step: Vec3,
    /// World step to the next row.
    pub t_step: Vec3,
}

impl LuxelGrid {
    /// Luxel coordinates of a world point; luxel (i, j) is at exactly (i, j).
    pub fn luxel_of(&self, p: Vec3) -> Vec2 {
        Vec2::new(
            self.s_row.truncate().dot(p) + self.s_row.w,
            self.t_row.truncate().dot(p) + self.t_row.w,
        )
    }

    /// World point on the face plane at luxel coordinates `l`.
    pub fn world_of(&self, l: Vec2) -> Vec3 {
        self.origin + self.s_step * l.x + self.t_step * l.y
    }

    /// Number of luxels.
    pub fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether there are none (never, for a grid made from a face).
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A BSP face as light sees it. Surface indices are BSP face indices.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Corner points in world space (the offset of the brush model added), clockwise from the front.
    pub vertices: Vec<Vec3>,
    /// Unit normal of the lit side.
    pub normal: Vec3,
    /// Plane distance in world space: points on the surface have `normal . p = dist`.
    pub dist: f32,
    /// Brush model that owns the face; `None` for a face of no model, which stays unlit.
    pub model: Option<u32>,
    /// World offset of that model (the `origin` key), already part of `vertices` and `dist`.
    pub offset: Vec3,
    /// Index into the texture lump, if the face has a texture.
    pub texture: Option<u32>,
    /// Directions in which texture coordinates s and t grow, as the texture is projected: not of unit
    /// length, nor within the face; zero without texture placement.
    pub texture_axes: [Vec3; 2],
    /// Share of light it sends back, per channel; matters only where `reflects` is set.
    pub reflectance: Reflectance,
    /// Sends light back: opaque or a fence, lightmapped and of a model that casts shadows.
    pub reflects: bool,
    /// What it does to light.
    pub role: Role,
    /// Share of light that takes on the colour of the surface when it passes through glass, 0 to 1;
    /// 1 is no glass.
    pub opacity: f32,
    /// Share of light that passes straight through, per channel, where a material file says so; it
    /// replaces the tint of glass.
    pub transmission: Option<Vec3>,
    /// Share of light that leaves the opposite face of a thin brush diffusely, per channel, where a
    /// material file says so.
    pub diffuse: Option<Vec3>,
    /// Texels of the last palette index are holes.
    pub fence: bool,
    /// Lit from behind as well (liquids).
    pub two_sided: bool,
    /// Receives no light from lights, suns and bounces.
    pub light_ignore: bool,
    /// Channels of light that it receives, 1 by default.
    pub channel_mask: i32,
    /// Wants smoothed normals, so that light may reach it from behind its plane.
    pub curved: bool,
    /// Gets no dirt.
    pub no_dirt: bool,
    /// Minimum light.
    pub minlight: Minlight,
    /// Cap on its luxels in levels at range 0.5; 0 is the world's cap.
    pub max_light: f32,
    /// Saturation of the light it receives, 0 (grey) to 1.
    pub colour_scale: f32,
    /// Luxels, for faces that get a lightmap.
    pub luxels: Option<LuxelGrid>,
    /// The luxels that engines expect which know only the size that the texture gives, where `luxels`
    /// has another.
    pub vanilla_luxels: Option<LuxelGrid>,
}

impl Surface {
    /// Share of light that it sends on, per channel: what it reflects, and what leaves it of the light on its
    /// other side.
    pub fn albedo(&self) -> Vec3 {
        self.reflectance.0 + self.diffuse.unwrap_or(Vec3::ZERO)
    }

    /// Share of its albedo, per channel, that is reflectance; 1 where no light comes through.
    pub fn reflected_share(&self) -> Vec3 {
        let share = |c: usize| {
            let own = self.reflectance.0[c];
            if own > 0.0 { own / self.albedo()[c] } else { 0.0 }
        };
        self.diffuse.map_or(Vec3::ONE, |_| Vec3::from_array(std::array::from_fn(share)))
    }

    /// The surface for the ray tracer, without repeated corners; `None` if too few are left.
    pub(crate) fn polygon(&self) -> Option<Polygon> {
        let mut vertices = self.vertices.clone();
        vertices.dedup();
        while vertices.len() > 1 && vertices.first() == vertices.last() {
            vertices.pop();
        }
        (vertices.len() >= 3).then_some(Polygon { vertices, normal: self.normal })
    }
}
