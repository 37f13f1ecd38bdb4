//! Maps lit by the whole program under given settings, as light that is not cut to levels.

use super::map_builder::MapBuilder;
use glam::Vec3;
use qrad::bsp::Format;
use qrad::lightmap::{DebugView, Gather};
use qrad::outputs::{LitFile, Outputs};
use qrad::progress::Progress;
use qrad::scene::{LuxelGrid, Scene, Sidecar};
use qrad::settings::Settings;
use qrad::{MapLight, light_bsp};

/// A lit map.
pub struct LitLight {
    pub scene: Scene,
    /// Light by surface and style, in light units, floored at zero.
    light: Vec<Vec<(u16, Vec<Vec3>)>>,
}

/// Settings that keep dim styles, and show bounced light alone if asked to.
pub fn settings(debug: Option<DebugView>) -> Settings {
    let outputs = Outputs { lit: LitFile::Hdr, ..Outputs::default() };
    // Where light is interpolated, what one light gives depends on the others.
    Settings { debug, outputs, gather: Gather::Luxel, ..Settings::default() }
}

impl LitLight {
    pub fn new(map: &MapBuilder, settings: &Settings) -> Self {
        Self::with_texinfo(map, settings, "{}")
    }

    /// With the text of a texinfo.json.
    pub fn with_texinfo(map: &MapBuilder, settings: &Settings, texinfo: &str) -> Self {
        let sidecar = Sidecar { texinfo: Some(texinfo), ..Sidecar::default() };
        Self::with(map, settings, sidecar)
    }

    /// With all that may lie beside a map.
    pub fn with(map: &MapBuilder, settings: &Settings, sidecar: Sidecar<'_>) -> Self {
        let mut bsp = map.build(Format::Bsp29);
        let lit = light_bsp(&mut bsp, sidecar, Vec::new(), settings, &Progress::new(false));
        let MapLight { scene, faces, .. } = lit.unwrap();
        let units = |light: &[Vec3]| light.iter().map(|c| *c / scene.world.range).collect();
        let light = faces
            .iter()
            .map(|face| face.styles.iter().map(|s| (s.style, units(&s.light))).collect())
            .collect();
        Self { scene, light }
    }

    /// Bounced light alone.
    pub fn bounced(map: &MapBuilder) -> Self {
        Self::new(map, &settings(Some(DebugView::Bounce)))
    }

    /// Light of a style at the luxels of a surface, zeros where it has none.
    pub fn of(&self, surface: usize, style: u16) -> Vec<Vec3> {
        let count = self.scene.surfaces[surface].luxels.as_ref().map_or(0, LuxelGrid::len);
        let known = self.light[surface].iter().find(|(s, _)| *s == style);
        known.map_or_else(|| vec![Vec3::ZERO; count], |(_, light)| light.clone())
    }

    /// Light of a style at all luxels of the map.
    pub fn all(&self, style: u16) -> Vec<Vec3> {
        (0..self.light.len()).flat_map(|surface| self.of(surface, style)).collect()
    }

    /// Mean of a style over all luxels and channels.
    pub fn mean(&self, style: u16) -> f32 {
        let all = self.all(style);
        all.iter().map(|c| c.element_sum() / 3.0).sum::<f32>() / all.len() as f32
    }
}

/// Largest difference of any channel.
pub fn difference(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max)
}
