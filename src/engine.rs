//! What the engines that people play Quake with read of a map's lighting; docs/outputs.md says how we
//! know.

use crate::outputs::{DirectionFile, LitFile, Outputs};
use clap::ValueEnum;

/// An engine to write for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Engine {
    /// QuakeSpasm
    Quakespasm,
    /// Ironwail
    Ironwail,
    /// vkQuake
    Vkquake,
    /// QuakeSpasm-Spiked and QSS-M
    Qss,
    /// FTE QuakeWorld
    Fte,
    /// ezQuake
    Ezquake,
    /// DarkPlaces
    Darkplaces,
}

impl Engine {
    /// The outputs of which this engine makes the most.
    pub fn outputs(self) -> Outputs {
        match self {
            Self::Quakespasm | Self::Ironwail | Self::Vkquake | Self::Darkplaces => {
                Outputs::default()
            }
            Self::Qss | Self::Ezquake => Outputs { bspx_lit: true, ..Outputs::default() },
            Self::Fte => Outputs { bspx_hdr: true, ..Outputs::default() },
        }
    }

    /// That choice in words.
    pub fn choice(self) -> &'static str {
        match self {
            Self::Quakespasm => "QuakeSpasm: lighting lump, and a .lit file if there is colour",
            Self::Ironwail => "Ironwail: lighting lump, and a .lit file if there is colour",
            Self::Vkquake => "vkQuake: lighting lump, and a .lit file if there is colour",
            Self::Darkplaces => "DarkPlaces: lighting lump, and a .lit file if there is colour",
            Self::Qss => "QuakeSpasm-Spiked: lighting lump, and colours in RGBLIGHTING",
            Self::Ezquake => "ezQuake: lighting lump, and colours in RGBLIGHTING",
            Self::Fte => "FTE: lighting lump, and HDR colours in LIGHTING_E5BGR9",
        }
    }

    /// Which of the outputs asked for this engine does not read, one sentence each.
    /// `decoupled` and `light_grid` tell whether the map gets such lumps.
    pub fn unread(self, outputs: &Outputs, decoupled: bool, light_grid: bool) -> Vec<String> {
        let reads_lumps = matches!(self, Self::Qss | Self::Fte | Self::Ezquake);
        let reads_hdr = matches!(self, Self::Qss | Self::Fte);
        let fte = self == Self::Fte;
        let reads_lux = fte || self == Self::Darkplaces;
        let told = [
            (outputs.lit == LitFile::Version2, ".lit version 2"),
            (outputs.lux != DirectionFile::No && !reads_lux, ".lux files"),
            (outputs.bspx_lux && !fte, "LIGHTINGDIR"),
            (outputs.face_normals && !fte, "FACENORMALS"),
            (outputs.lit == LitFile::Hdr && !reads_hdr, "HDR .lit files"),
            (outputs.bspx_hdr && !reads_hdr, "LIGHTING_E5BGR9"),
            (outputs.bspx_lit && !reads_lumps, "RGBLIGHTING"),
            (!outputs.vanilla && !reads_lumps, "anything in place of the lighting lump"),
            (outputs.luxels.shift.is_some() && !reads_hdr, "LMSHIFT"),
            (outputs.face_styles > 4 && !reads_hdr, "LMSTYLE and LMSTYLE16"),
            (decoupled && !reads_lumps, "DECOUPLED_LM"),
            (light_grid && self != Self::Fte, "light grids"),
        ];
        let name = self.choice().split(':').next().unwrap_or_default();
        let unread = told.into_iter().filter(|(unread, _)| *unread);
        unread.map(|(_, what)| format!("{name} is not known to read {what}")).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_engine_is_given_what_it_does_not_read() {
        for engine in Engine::value_variants() {
            let outputs = engine.outputs().checked().unwrap();
            assert!(engine.unread(&outputs, false, false).is_empty(), "{engine:?}");
            assert!(!engine.choice().contains('\n'));
        }
        let outputs = Outputs { bspx_hdr: true, vanilla: false, ..Outputs::default() };
        assert_eq!(Engine::Ironwail.unread(&outputs, true, true).len(), 4);
    }
}
