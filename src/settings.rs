//! What the user can set, checked once and passed down from there.

use crate::aim::{Aim, Ladder};
use crate::bsp::{Bsp, MipTex, StyleRange};
use crate::cache::Cache;
use crate::check;
use crate::lightmap::{DebugView, Gather, GatherSettings, Smoothing};
use crate::memory::MemoryLimit;
use crate::outputs::Outputs;
use crate::radiosity::hemicube::HemicubeSize;
use crate::radiosity::near_pairs::NearLimits;
use crate::scene::effects::{Effect, Switches};
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

/// How much work goes into bounced light: a name for a set of values that single options change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Quality {
    /// A quick look
    Draft,
    /// Errors of a few hundredths on maps, below 0.5 % in text scenes
    #[default]
    Normal,
    /// Half the error or less, a hemicube at every luxel
    High,
    /// Finer hemicubes and smaller errors still; about 0.1 % in text scenes
    Final,
}

impl Quality {
    /// For text scenes: which pairs of patches get closed forms, in rows whose error would be larger
    /// than a share of the light, and how many hemicubes patches get that others stand on.
    pub fn near(self) -> NearLimits {
        let limits = |row, rays, points, crowded| NearLimits { row, rays, points, crowded };
        match self {
            Self::Draft => limits(1e-2, 128, 8, 8),
            Self::Normal => limits(3e-3, 1024, 64, 48),
            Self::High => limits(1.5e-3, 4096, 128, 64),
            Self::Final => limits(7e-4, 8192, 256, 128),
        }
    }

    /// Cells along the edge of a hemicube, on maps.
    pub fn hemicube(self) -> u32 {
        match self {
            Self::Draft | Self::Normal | Self::High => 16,
            Self::Final => 64,
        }
    }

    /// Longest edge of a patch in luxels.
    pub fn patch_size(self) -> u32 {
        if self == Self::Draft { 4 } else { 2 }
    }

    /// How indirect light gets to luxels.
    pub fn gather(self) -> Gather {
        match self {
            Self::Draft | Self::Normal => Gather::Interpolate,
            Self::High | Self::Final => Gather::Luxel,
        }
    }

    /// Error that interpolation may make, if there is any: see [`GatherSettings::error`].
    pub fn gather_error(self) -> f64 {
        match self {
            Self::Draft => f64::INFINITY,
            Self::Normal => 0.1,
            Self::High | Self::Final => 0.02,
        }
    }

    /// How readily neighbouring patches share a hemicube: see [`Settings::share`].
    pub fn share(self) -> f32 {
        match self {
            Self::Draft | Self::Normal | Self::High => 0.2,
            Self::Final => 0.0,
        }
    }
}

/// Whether coarser hemicubes do for luxels where interpolation may err as much, above 0: where it may err
/// less, they are what errs most.
pub(crate) fn coarse_luxels_do(gather_error: f64) -> bool {
    gather_error >= 0.05
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
    /// Every sample of direct light is traced, also where that makes little difference.
    pub exact_extra: bool,
    /// How indirect light gets to luxels.
    pub gather: Gather,
    /// Error that interpolation may make, above 0: see [`GatherSettings::error`].
    pub gather_error: f64,
    /// Patches beside each other share the hemicube in their middle if that is nearer than this share of the
    /// harmonic mean distance of what it sees; 0 for none. Above 0, hemicubes of patches that are cut off,
    /// and of single luxels where interpolation may err by 0.05 or more, have half as many cells along an
    /// edge.
    pub share: f32,
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
    /// Some luxels are lit again to tell how far off bounced light is.
    pub check: bool,
    /// Share of the run's time that this may take, in (0, 1).
    pub check_share: f64,
    /// What the run is to reach. Other than by settings, it chooses those of bounced light.
    pub aim: Aim,
    /// What settings are known to reach, to choose from.
    pub ladder: Ladder,
    /// Light that is whole but may get better is kept: see [`light_bsp_in_steps`](crate::light_bsp_in_steps).
    pub keep_partial: bool,
    /// Effects switched on or off by hand.
    pub switches: Switches,
    /// Most memory that the run is to take.
    pub memory: MemoryLimit,
    /// Where form factors are kept from one run to the next.
    pub cache: Option<Cache>,
}

impl Default for Settings {
    fn default() -> Self {
        Self::of_quality(Quality::default())
    }
}

impl Settings {
    /// The settings of a quality; all else is as by default.
    pub fn of_quality(quality: Quality) -> Self {
        let cells = quality.hemicube();
        Self {
            hemicube: HemicubeSize::new(cells, cells).expect("even and in range"),
            patch_size: quality.patch_size(),
            bounces: None,
            residual: 1e-5,
            smoothing: Smoothing { extra: 1, soft: 0 },
            exact_extra: false,
            gather: quality.gather(),
            gather_error: quality.gather_error(),
            share: quality.share(),
            reflectance_scale: 1.0,
            grey: false,
            compat_bounce: false,
            surface_lights: SurfaceLights::default(),
            overrides: Vec::new(),
            debug: None,
            outputs: Outputs::default(),
            check: true,
            check_share: check::SHARE,
            aim: Aim::Settings,
            ladder: Ladder::default(),
            keep_partial: false,
            switches: Switches::default(),
            memory: MemoryLimit::of_system(),
            cache: None,
        }
    }

    /// Makes of the switches what is no matter of the scene.
    pub fn switched(mut self) -> Self {
        let of = |effect| self.switches.of(effect);
        match of(Effect::Supersampling) {
            Some(true) if self.smoothing.extra == 1 => self.smoothing.extra = 4,
            Some(false) => self.smoothing = Smoothing { extra: 1, soft: 0 },
            _ => {}
        }
        match of(Effect::NearField) {
            Some(true) => self.gather_error = self.gather_error.min(Quality::Normal.gather_error()),
            Some(false) => self.gather_error = f64::INFINITY,
            None => {}
        }
        if of(Effect::Bounces) == Some(true) && self.bounces == Some(0) {
            self.bounces = None;
        }
        if of(Effect::Dirt) == Some(true) {
            self.overrides.push(("dirt".into(), "1".into()));
        }
        self.outputs.switch(&self.switches);
        self
    }

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
        match self.aim {
            Aim::Error(e) if !(e > 0.0 && e < 1.0) => {
                return Err(Error::setting(
                    "--target-error",
                    "use more than 0 % and less than 100 %",
                ));
            }
            Aim::Time(t) if !(t > 0.0 && t <= 1e7) => {
                return Err(Error::setting("--time-budget", "use more than 0 s"));
            }
            _ => {}
        }
        self.outputs.clone().checked()?;
        Ok(self)
    }

    /// Names and values of what a run is lit with, for reports.
    pub fn describe(&self) -> Vec<(String, String)> {
        let gather = match self.gather {
            Gather::Luxel => "a hemicube at every luxel".to_owned(),
            Gather::Interpolate => format!("interpolate, error {}", self.gather_error),
        };
        let bounces = self.bounces.map_or("by the map".to_owned(), |n| n.to_string());
        let mut all = vec![
            ("hemicube", self.hemicube.width().to_string()),
            ("patch size", self.patch_size.to_string()),
            ("gather", gather),
            ("shared hemicubes", self.share.to_string()),
            ("bounces", bounces),
            ("residual", format!("{:e}", self.residual)),
            ("samples a luxel", self.smoothing.extra.pow(2).to_string()),
            ("blur", self.smoothing.soft.to_string()),
            ("surface lights", format!("{:?}", self.surface_lights)),
            ("reflectance scale", self.reflectance_scale.to_string()),
            ("grey", self.grey.to_string()),
            ("outputs", format!("{:?}", self.outputs)),
        ];
        all.extend(self.overrides.iter().map(|(k, v)| (&**k, v.clone())));
        all.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
    }

    /// The styles that switchable lights get.
    ///
    /// # Errors
    /// When the entity text is damaged.
    pub fn styles(&self, bsp: &Bsp) -> Result<StyleRange> {
        style_range(&bsp.entities, &self.overrides)
    }

    /// How indirect light gets to luxels.
    pub fn gathering(&self) -> GatherSettings {
        let coarse = self.coarse_where_small()
            && self.gather == Gather::Interpolate
            && coarse_luxels_do(self.gather_error);
        let hemicube = if coarse { self.hemicube.halved() } else { self.hemicube };
        GatherSettings { gather: self.gather, error: self.gather_error, hemicube }
    }

    /// Whether coarser hemicubes do for what is small. Lamps that shine as areas must not be missed.
    pub fn coarse_where_small(&self) -> bool {
        self.share > 0.0 && self.surface_lights == SurfaceLights::Points
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
            switches: self.switches.clone(),
        }
    }
}
