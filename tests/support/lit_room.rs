//! Direct light in small rooms, luxel by luxel.

use super::lit_levels::texinfo;
use super::map_builder::MapBuilder;
use glam::Vec3;
use qrad::bsp::Format;
use qrad::light::{DirectLight, direct};
use qrad::scene::{Sample, Scene, SceneSettings, Sidecar, luxels};

/// Text of an entity; the first key is its classname.
pub fn entity(class: &str, keys: &[(&str, &str)]) -> String {
    let keys: String = keys.iter().map(|(k, v)| format!("\"{k}\" \"{v}\"\n")).collect();
    format!("{{\n\"classname\" \"{class}\"\n{keys}}}\n")
}

/// Index of the surface that faces `normal` at `point`.
pub fn surface_at(scene: &Scene, point: Vec3, normal: Vec3) -> usize {
    scene
        .surfaces
        .iter()
        .position(|s| {
            let min = s.vertices.iter().copied().reduce(Vec3::min).unwrap();
            let max = s.vertices.iter().copied().reduce(Vec3::max).unwrap();
            s.normal == normal && point.cmpge(min).all() && point.cmple(max).all()
        })
        .expect("a surface at the point")
}

/// A map made ready for light.
pub struct LitRoom {
    pub scene: Scene,
}

impl LitRoom {
    pub fn new(map: &MapBuilder) -> Self {
        Self::with_texinfo(map, |_| None)
    }

    /// With the members that `keys` gives for textures, by name, in texinfo.json.
    pub fn with_texinfo(map: &MapBuilder, keys: impl Fn(&str) -> Option<&'static str>) -> Self {
        let bsp = map.build(Format::Bsp29);
        let texinfo = texinfo(&bsp, keys);
        let sidecar = Sidecar { texinfo: Some(&texinfo), ..Sidecar::default() };
        let scene = Scene::build(&bsp, sidecar, &SceneSettings::default()).unwrap();
        let unexpected = |w: &&String| !w.contains("reflect more than");
        assert_eq!(scene.warnings.iter().find(unexpected), None);
        Self { scene }
    }

    /// Surfaces that look along `normal`, with their samples and light.
    pub fn facing(&self, normal: Vec3) -> Vec<(usize, Vec<Sample>, DirectLight)> {
        (0..self.scene.surfaces.len())
            .filter(|&s| self.scene.surfaces[s].normal == normal)
            .map(|s| {
                let samples = luxels::place(&self.scene, s, 1);
                let light = direct(&self.scene, s, &samples);
                (s, samples, light)
            })
            .collect()
    }

    /// Irradiance of a style at the luxel nearest to a point of the face there that looks along
    /// `normal`, rounded to 1/1024 light unit to be free of the rounding of single precision.
    pub fn at(&self, style: u16, point: [f32; 3], normal: Vec3) -> Vec3 {
        let point = Vec3::from(point);
        let surfaces = &self.scene.surfaces;
        let surface = surface_at(&self.scene, point, normal);
        let samples = luxels::place(&self.scene, surface, 1);
        let grid = surfaces[surface].luxels.as_ref().unwrap();
        let l = grid.luxel_of(point).round();
        let index = l.y as usize * grid.width as usize + l.x as usize;
        let light = direct(&self.scene, surface, &samples);
        let map = light.styles.iter().find(|s| s.style == style);
        let exact = map.map_or(Vec3::ZERO, |m| m.irradiance[index].0);
        (exact * 1024.0).round() / 1024.0
    }

    /// Irradiance of a style on the floor at z = 0.
    pub fn floor(&self, style: u16, x: f32, y: f32) -> Vec3 {
        self.at(style, [x, y, 0.0], Vec3::Z)
    }
}

/// The level that the irradiance is stored as, without limit.
pub fn level(irradiance: Vec3) -> [u32; 3] {
    (irradiance * 0.5).to_array().map(|v| v as u32)
}
