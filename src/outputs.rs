//! Which files and lumps a map run writes: checked once, and followed by the `store` stage.

use crate::lightmap::StyleChoice;
use crate::scene::LuxelSettings;
use crate::scene::effects::{Effect, Switches};
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
    /// Written in version 2, with sizes, offsets and directions of its own: the map stays as it is.
    Version2,
    /// Not written.
    Never,
}

/// What becomes of the file beside the map that says where light comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DirectionFile {
    /// There is none.
    #[default]
    No,
    /// `.lux`, as light compilers call it.
    Lux,
    /// `.dlit`, as DarkPlaces calls it; it holds the same.
    Dlit,
}

impl DirectionFile {
    /// The extensions that such a file may have.
    pub const EXTENSIONS: [&str; 2] = ["lux", "dlit"];

    /// The extension of this one, if there is to be one.
    pub fn extension(self) -> Option<&'static str> {
        match self {
            Self::No => None,
            Self::Lux => Some(Self::EXTENSIONS[0]),
            Self::Dlit => Some(Self::EXTENSIONS[1]),
        }
    }
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
    /// The file that says where light comes from.
    pub lux: DirectionFile,
    /// Where light comes from in the map, as `LIGHTINGDIR`.
    pub bspx_lux: bool,
    /// Normals at the corners of faces in the map, as `FACENORMALS`.
    pub face_normals: bool,
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
            lux: DirectionFile::default(),
            bspx_lux: false,
            face_normals: false,
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

    /// Follows what the user says of effects.
    pub(crate) fn switch(&mut self, switches: &Switches) {
        let of = |effect| switches.of(effect);
        match of(Effect::Lit) {
            Some(true) if self.lit == LitFile::Auto => self.lit = LitFile::Always,
            Some(false) => self.lit = LitFile::Never,
            _ => {}
        }
        match of(Effect::Hdr) {
            Some(true) => self.lit = LitFile::Hdr,
            Some(false) => {
                self.bspx_hdr = false;
                if self.lit == LitFile::Hdr {
                    self.lit = LitFile::Auto;
                }
            }
            None => {}
        }
        self.bspx_lit = of(Effect::BspxLight).unwrap_or(self.bspx_lit);
        match of(Effect::Directions) {
            Some(true) if !self.directions() => self.lux = DirectionFile::Lux,
            Some(false) => (self.lux, self.bspx_lux) = (DirectionFile::No, false),
            _ => {}
        }
        self.face_normals = of(Effect::FaceNormals).unwrap_or(self.face_normals);
        if switches.off(Effect::FaceStyles) {
            self.face_styles = RECORD_STYLES;
        }
        if switches.off(Effect::LuxelSizes) {
            self.luxels = LuxelSettings::default();
        }
    }

    /// Whether light that bytes cannot hold is written.
    pub fn hdr(&self) -> bool {
        self.lit == LitFile::Hdr || self.bspx_hdr
    }

    /// Whether it must be known where light comes from.
    pub fn directions(&self) -> bool {
        let file = self.lux != DirectionFile::No || self.lit == LitFile::Version2;
        file || self.bspx_lux && self.scope == Scope::All
    }

    /// Whether the map itself is written; if not, only files beside it.
    pub fn writes_map(&self) -> bool {
        self.scope != Scope::LitOnly && self.lit != LitFile::Version2
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
            LitFile::Hdr | LitFile::Version2 | LitFile::Never => false,
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
    fn directions_are_known_where_something_holds_them() {
        let directions = |o: Outputs| o.directions();
        assert!(!directions(Outputs::default()));
        assert!(directions(Outputs { lux: DirectionFile::Dlit, ..Outputs::default() }));
        assert!(directions(Outputs { bspx_lux: true, ..Outputs::default() }));
        assert!(directions(Outputs { lit: LitFile::Version2, ..Outputs::default() }));
        let unwritten = Outputs { bspx_lux: true, scope: Scope::LitOnly, ..Outputs::default() };
        assert!(!directions(unwritten));
    }

    #[test]
    fn numbers_of_styles_are_checked() {
        let with = |face_styles| Outputs { face_styles, ..Outputs::default() }.checked();
        assert!(with(1).is_ok() && with(16).is_ok());
        assert!(with(0).is_err() && with(17).is_err());
    }
}
