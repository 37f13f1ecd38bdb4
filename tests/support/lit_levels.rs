//! Maps lit by the whole program, luxel by luxel.

use super::map_builder::MapBuilder;
use glam::Vec3;
use qrad::bsp::{Bsp, Format};
use qrad::lightmap::FinishedFace;
use qrad::progress::Progress;
use qrad::scene::{Scene, Sidecar};
use qrad::settings::Settings;
use qrad::{MapLight, light_bsp};

/// A lit map.
pub struct LitMap {
    /// The map with its lighting.
    pub bsp: Bsp,
    pub scene: Scene,
    pub faces: Vec<FinishedFace>,
}

impl LitMap {
    /// Direct light only.
    pub fn new(map: &MapBuilder) -> Self {
        Self::with(map, |_| None, Some(0))
    }

    /// With the members that `keys` gives for textures, by name, in texinfo.json, and with at most
    /// `bounces` bounces.
    pub fn with(
        map: &MapBuilder,
        keys: impl Fn(&str) -> Option<&'static str>,
        bounces: Option<u32>,
    ) -> Self {
        let mut bsp = map.build(Format::Bsp29);
        let texinfo = texinfo(&bsp, keys);
        let sidecar = Sidecar { texinfo: Some(&texinfo), ..Sidecar::default() };
        let settings = Settings { bounces, ..Settings::default() };
        let lit = light_bsp(&mut bsp, sidecar, Vec::new(), &settings, &Progress::new(false));
        let MapLight { scene, faces, .. } = lit.unwrap();
        let unexpected = |w: &&String| !w.contains("reflect more than");
        assert_eq!(scene.warnings.iter().find(unexpected), None);
        Self { bsp, scene, faces }
    }

    /// Index of the face through a point that looks along `normal`; the last of several, so that brush
    /// models win over the world.
    pub fn face(&self, point: [f32; 3], normal: Vec3) -> usize {
        let point = Vec3::from(point);
        self.scene
            .surfaces
            .iter()
            .rposition(|s| {
                let min = s.vertices.iter().copied().reduce(Vec3::min).unwrap();
                let max = s.vertices.iter().copied().reduce(Vec3::max).unwrap();
                s.normal.dot(normal) > 0.999 && point.cmpge(min).all() && point.cmple(max).all()
            })
            .expect("a face at the point")
    }

    /// Stored level of a style at the luxel nearest to a point; black if the face lacks the style.
    pub fn level(&self, style: u16, point: [f32; 3], normal: Vec3) -> [u8; 3] {
        let face = self.face(point, normal);
        let grid = self.scene.surfaces[face].luxels.as_ref().expect("a lightmapped face");
        let l = grid.luxel_of(point.into()).round();
        let index = l.y as usize * grid.width as usize + l.x as usize;
        self.levels(face, style).map_or([0; 3], |levels| levels[index])
    }

    /// All stored levels of a style of a face.
    pub fn levels(&self, face: usize, style: u16) -> Option<&[[u8; 3]]> {
        self.faces[face].styles.iter().find(|s| s.style == style).map(|s| &s.levels[..])
    }
}

/// A texinfo.json with the members that `keys` gives for textures, by name.
pub fn texinfo(bsp: &Bsp, keys: impl Fn(&str) -> Option<&'static str>) -> String {
    let members: Vec<String> = bsp
        .texinfos
        .iter()
        .enumerate()
        .filter_map(|(i, t)| {
            let name = &bsp.textures[t.miptex as usize].as_ref().unwrap().name;
            Some(format!("\"{i}\": {}", keys(name)?))
        })
        .collect();
    format!("{{{}}}", members.join(","))
}
