//! What the user can set, checked once and passed down from there.

use crate::bsp::{Bsp, MipTex, StyleRange};
use crate::lightmap::{DebugView, Gather, Smoothing};
use crate::outputs::Outputs;
use crate::radiosity::hemicube::HemicubeSize;
use crate::radiosity::near_pairs::NearLimits;
use crate::scene::{SceneSettings, style_range};
use crate::{Error, Result};

/// How emitting textures (`_surface` lights) shine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SurfaceLights {
    /// As point lights in front of the surface, as the reference compiler places them.
    #[default]
    Points,
    /// As area light: the patches of the surface emit.
    Area,
}

/// How exact the form factors of a text scene are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// One hemicube a patch and nothing else.
    Plain,
    /// Closed forms where one hemicube a patch is off by more than about 1 % of the light.
    Draft,
    /// Off by about 0.3 %, and more hemicubes where things stand on a patch.
    #[default]
    Normal,
    /// Between normal and final.
    High,
    /// Off by less than 0.1 %.
    Final,
}

impl Quality {
    /// What it means for pairs of patches that are near; `None` leaves them as the hemicube has them.
    pub fn near(self) -> Option<NearLimits> {
        let limits = |row, rays, points, crowded| Some(NearLimits { row, rays, points, crowded });
        match self {
            Self::Plain => None,
            Self::Draft => limits(1e-2, 128, 8, 8),
            Self::Normal => limits(3e-3, 1024, 64, 48),
            Self::High => limits(1.5e-3, 4096, 128, 64),
            Self::Final => limits(7e-4, 8192, 256, 128),
        }
    }
}

/// Settings of a map run.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Cells of a hemicube.
    pub hemicube: HemicubeSize,
    /// Longest edge of a patch in luxels, from 1 to 256.
    pub patch_size: u32,
    /// Most bounces; `None` is what worldspawn says (`bounce`), and without that until the residual is
    /// reached.
    pub bounces: Option<u32>,
    /// Bouncing ends when this share of the light is left, in (0, 1).
    pub residual: f64,
    /// Samples a luxel and blur.
    pub smoothing: Smoothing,
    /// How indirect light gets to luxels.
    pub gather: Gather,
    /// Factor on the reflectance of textures, 0 and up.
    pub reflectance_scale: f32,
    /// Ignore the colour of textures: everything reflects half the light.
    pub grey: bool,
    /// Where worldspawn has no `bouncecolorscale`, it is 0 as in the reference: everything reflects the
    /// same grey.
    pub compat_bounce: bool,
    /// How surface lights shine.
    pub surface_lights: SurfaceLights,
    /// Worldspawn keys and values that win over those of the map.
    pub overrides: Vec<(String, String)>,
    /// What the lightmaps show instead of light.
    pub debug: Option<DebugView>,
    /// What is written.
    pub outputs: Outputs,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            hemicube: HemicubeSize::new(64, 64).expect("64 is even and in range"),
            patch_size: 4,
            bounces: None,
            residual: 1e-5,
            smoothing: Smoothing { extra: 1, soft: 0 },
            gather: Gather::default(),
            reflectance_scale: 1.0,
            grey: false,
            compat_bounce: false,
            surface_lights: SurfaceLights::default(),
            overrides: Vec::new(),
            debug: None,
            outputs: Outputs::default(),
        }
    }
}

impl Settings {
    /// The settings, if every value is in its range.
    ///
    /// # Errors
    /// Names the option and its range.
    pub fn checked(self) -> Result<Self> {
        if !(1..=256).contains(&self.patch_size) {
            let problem = format!("{} luxels: use 1 to 256", self.patch_size);
            return Err(Error::setting("--patch-size", problem));
        }
        if ![1, 2, 4].contains(&self.smoothing.extra) || self.smoothing.soft > 64 {
            let problem =
                format!("{:?}: use 1, 2 or 4 samples and a blur up to 64", self.smoothing);
            return Err(Error::setting("supersampling", problem));
        }
        if !(self.residual > 0.0 && self.residual < 1.0) {
            let problem = format!("{}: use a number between 0 and 1", self.residual);
            return Err(Error::setting("--residual", problem));
        }
        if !(self.reflectance_scale >= 0.0 && self.reflectance_scale.is_finite()) {
            let problem = format!("{}: use 0 or more", self.reflectance_scale);
            return Err(Error::setting("--reflectance-scale", problem));
        }
        self.outputs.clone().checked()?;
        Ok(self)
    }

    /// The styles that switchable lights get.
    ///
    /// # Errors
    /// When the entity text is damaged.
    pub fn styles(&self, bsp: &Bsp) -> Result<StyleRange> {
        style_range(&bsp.entities, &self.overrides)
    }

    /// The part that concerns the scene. `textures` are those that the map may lack.
    pub fn scene(&self, textures: Vec<MipTex>) -> SceneSettings {
        let mut overrides = self.overrides.clone();
        overrides.extend(self.bounces.map(|n| ("bounce".to_owned(), n.to_string())));
        let mut set = |key: &str, value: &str| overrides.push((key.to_owned(), value.to_owned()));
        if self.debug.is_some_and(|view| !view.shows_bounces()) {
            set("bounce", "0");
        }
        if self.debug == Some(DebugView::Dirt) {
            set("dirt", "1");
        }
        SceneSettings {
            reflectance_scale: self.reflectance_scale,
            grey: self.grey,
            compat_bounce: self.compat_bounce,
            textures,
            area_lights: self.surface_lights == SurfaceLights::Area,
            overrides,
            luxels: self.outputs.luxels.clone(),
            extra: self.smoothing.extra,
        }
    }
}
