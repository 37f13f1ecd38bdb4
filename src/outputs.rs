//! Which files and lumps a map run writes: checked once, and followed by the `store` stage.

use crate::lightmap::StyleChoice;
use crate::scene::LuxelSettings;
use crate::{Error, Result};

/// Styles that the record of a face holds, and so what every engine reads.
const RECORD_STYLES: u32 = 4;

/// What becomes of the `.lit` file beside the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LitFile {
    /// Written when the light has colour and nothing else is to hold the colours.
    #[default]
    Auto,
    /// Written in any case.
    Always,
    /// Written in HDR: light that is neither limited nor cut to whole levels.
    Hdr,
}

/// How much of the map is replaced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scope {
    /// Lighting and entities.
    #[default]
    All,
    /// Only the `.lit` file, for the lightmaps that the map has.
    LitOnly,
    /// Only the entities.
    EntitiesOnly,
}

/// The outputs of a map run.
#[derive(Clone, Debug, PartialEq)]
pub struct Outputs {
    /// What is replaced.
    pub scope: Scope,
    /// The `.lit` file.
    pub lit: LitFile,
    /// Colours in the map, as `RGBLIGHTING`.
    pub bspx_lit: bool,
    /// HDR colours in the map, as `LIGHTING_E5BGR9`.
    pub bspx_hdr: bool,
    /// Lightmaps as the original engine reads them; without them only lumps and files that hold
    /// colours are written.
    pub vanilla: bool,
    /// The most light styles of a face, 1 to 16. Above 4, styles above 254 are stored too. Those after
    /// the fourth need an engine that reads `LMSTYLE`, and those above 254 one that reads `LMSTYLE16`.
    pub face_styles: u32,
    /// Luxel sizes.
    pub luxels: LuxelSettings,
}

impl Default for Outputs {
    fn default() -> Self {
        Self {
            scope: Scope::default(),
            lit: LitFile::default(),
            bspx_lit: false,
            bspx_hdr: false,
            vanilla: true,
            face_styles: RECORD_STYLES,
            luxels: LuxelSettings::default(),
        }
    }
}

impl Outputs {
    /// The outputs, if every value is in its range.
    ///
    /// # Errors
    /// Names the option and its range.
    pub fn checked(self) -> Result<Self> {
        if !(1..=16).contains(&self.face_styles) {
            let problem = format!("{}: use 1 to 16", self.face_styles);
            return Err(Error::setting("--facestyles", problem));
        }
        self.luxels.clone().checked()?;
        Ok(self)
    }

    /// Whether light that bytes cannot hold is written.
    pub fn hdr(&self) -> bool {
        self.lit == LitFile::Hdr || self.bspx_hdr
    }

    /// Whether the map holds colours, given that it may need them.
    pub fn bspx_rgb(&self, coloured: bool) -> bool {
        self.bspx_lit || coloured && !self.vanilla && self.lit == LitFile::Auto && !self.bspx_hdr
    }

    /// Whether a `.lit` file with bytes is written.
    pub fn rgb_file(&self, coloured: bool) -> bool {
        match self.lit {
            LitFile::Always => true,
            LitFile::Auto => coloured && self.vanilla && !self.bspx_lit && !self.bspx_hdr,
            LitFile::Hdr => false,
        }
    }

    /// Which maps of a face are stored.
    pub(crate) fn style_choice(&self) -> StyleChoice {
        match self.scope {
            // The map says which.
            Scope::LitOnly => StyleChoice { most: usize::MAX, dim: true, wide: false },
            _ => StyleChoice {
                most: self.face_styles as usize,
                dim: self.hdr(),
                wide: self.face_styles > RECORD_STYLES,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_go_to_one_place_unless_more_are_asked_for() {
        let places = |o: &Outputs, coloured| [o.rgb_file(coloured), o.bspx_rgb(coloured)];
        let auto = Outputs::default();
        assert_eq!(places(&auto, true), [true, false]);
        assert_eq!(places(&auto, false), [false, false]);
        let no_vanilla = Outputs { vanilla: false, ..Outputs::default() };
        assert_eq!(places(&no_vanilla, true), [false, true]);
        assert_eq!(places(&no_vanilla, false), [false, false]);
        let bspx = Outputs { bspx_lit: true, ..Outputs::default() };
        assert_eq!(places(&bspx, true), [false, true]);
        assert_eq!(places(&bspx, false), [false, true]);
        let both = Outputs { lit: LitFile::Always, ..bspx };
        assert_eq!(places(&both, false), [true, true]);
        let hdr = Outputs { bspx_hdr: true, ..Outputs::default() };
        assert_eq!(places(&hdr, true), [false, false]);
        assert!(hdr.hdr() && hdr.style_choice().dim);
    }

    #[test]
    fn numbers_of_styles_are_checked() {
        let with = |face_styles| Outputs { face_styles, ..Outputs::default() }.checked();
        assert!(with(1).is_ok() && with(16).is_ok());
        assert!(with(0).is_err() && with(17).is_err());
    }
}
