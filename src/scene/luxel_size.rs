//! How large the luxels of each face are (contract sections 1.7 and 2.1).

use crate::bsp::{Bsp, Entity};
use crate::{Error, Result};

/// Largest shift in an `LMSHIFT` lump: luxels of 256 texels.
const MOST_SHIFT: u8 = 8;
/// Limits of `world_units_per_luxel` of a face.
const WORLD_UNITS: std::ops::RangeInclusive<f32> = 0.25..=4096.0;

/// The distance from luxel to luxel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LuxelSize {
    /// Texels of the face's texture, along its axes: 16 for engines that know nothing else.
    Texels(u32),
    /// World units, along axes that follow the face and not its texture.
    World(f32),
}

/// Luxel sizes other than those of the map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LuxelSettings {
    /// Luxels of `1 << shift` texels on every face, instead of what `LMSHIFT` says; 0 to 8.
    pub shift: Option<u8>,
    /// Luxels of this many world units on every face whose texinfo does not say another number; they
    /// do not follow textures then.
    pub world_units: Option<f32>,
}

impl LuxelSettings {
    /// The settings, if every number is in its range.
    ///
    /// # Errors
    /// Names the option and its range.
    pub fn checked(self) -> Result<Self> {
        if let Some(shift) = self.shift.filter(|&shift| shift > MOST_SHIFT) {
            let problem = format!("{shift}: use 0 to {MOST_SHIFT}, for luxels of 1 to 256 texels");
            return Err(Error::setting("--lmshift", problem));
        }
        if let Some(units) = self.world_units.filter(|units| !WORLD_UNITS.contains(units)) {
            let (low, high) = (WORLD_UNITS.start(), WORLD_UNITS.end());
            let problem = format!("{units}: use {low} to {high} world units");
            return Err(Error::setting("--world-units-per-luxel", problem));
        }
        Ok(self)
    }

    /// These settings, completed by what worldspawn says.
    pub(crate) fn or_of_map(mut self, worldspawn: &Entity) -> Self {
        let key = || {
            let value = worldspawn.get("_world_units_per_luxel");
            value.or(worldspawn.get("world_units_per_luxel"))?.trim().parse().ok()
        };
        let in_range = |units: &f32| WORLD_UNITS.contains(units);
        self.world_units = self.world_units.or_else(|| key().filter(in_range));
        self
    }
}

/// The sizes of a map's luxels.
pub(crate) struct LuxelSizes<'a> {
    /// Texels a luxel for engines that know nothing else.
    pub vanilla: u32,
    settings: &'a LuxelSettings,
    /// A shift a face.
    shifts: Option<&'a [u8]>,
}

impl<'a> LuxelSizes<'a> {
    /// The sizes for a map whose luxels have `vanilla` texels where no lump says otherwise.
    pub fn new(
        bsp: &'a Bsp,
        vanilla: u32,
        settings: &'a LuxelSettings,
        warnings: &mut Vec<String>,
    ) -> Self {
        let lump = bsp.bspx.iter().find(|lump| lump.name == "LMSHIFT");
        let shifts = lump.map(|lump| &lump.data[..]);
        if let Some(shifts) = shifts {
            let odd = shifts.iter().filter(|&&shift| shift > MOST_SHIFT).count();
            if shifts.len() != bsp.faces.len() {
                warnings.push(format!(
                    "LMSHIFT lump: {} entries for {} faces; it is ignored",
                    shifts.len(),
                    bsp.faces.len()
                ));
            } else if odd > 0 {
                warnings.push(format!(
                    "LMSHIFT lump: {odd} faces have a shift above {MOST_SHIFT}; they get {MOST_SHIFT}"
                ));
            }
        }
        let shifts = shifts.filter(|shifts| shifts.len() == bsp.faces.len());
        Self { vanilla, settings, shifts }
    }

    /// The luxels of a face. `world_units` is what its texinfo asks for; it counts only where
    /// lightmaps do not follow textures.
    pub fn of_face(&self, face: usize, world_units: Option<f32>) -> LuxelSize {
        if let Some(everywhere) = self.settings.world_units {
            let own = world_units.filter(|units| WORLD_UNITS.contains(units));
            return LuxelSize::World(own.unwrap_or(everywhere));
        }
        let shift = self.settings.shift.or_else(|| self.shifts.map(|shifts| shifts[face]));
        LuxelSize::Texels(shift.map_or(self.vanilla, |shift| 1 << shift.min(MOST_SHIFT)))
    }
}
