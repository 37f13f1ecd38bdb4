//! A map run in three parts: direct light, bounced light, which may be found more than once with other
//! settings, and what is made of both.

use crate::bsp::{Bsp, MipTex};
use crate::check::{Energy, Findings};
use crate::light::DirectLight;
use crate::lightmap::{self, FinishedFace, Sources};
use crate::patch::MapPatches;
use crate::progress::Progress;
use crate::radiosity::bounce::Bounced;
use crate::radiosity::transfers::Transfers;
use crate::report::Counts;
use crate::scene::{Scene, Sidecar};
use crate::settings::Settings;
use crate::stage::{self, Gathered, Points};
use crate::store;
use crate::{MapLight, Result};

/// A map with its direct light.
pub(crate) struct DirectLit {
    /// The map as light sees it.
    pub scene: Scene,
    /// Where light is sampled.
    pub points: Points,
    /// Direct light of each face.
    pub direct: Vec<DirectLight>,
}

/// Bounced light of a map.
pub(crate) struct BouncedLight {
    patches: MapPatches,
    transfers: Transfers,
    bounced: Bounced,
    /// Bounced light at luxels.
    pub gathered: Gathered,
    /// What was counted.
    pub counts: Counts,
    /// How far off it is.
    pub checked: (Option<Findings>, Option<Energy>),
}

/// All light of a map, as lightmaps.
pub(crate) struct Finished {
    scene: Scene,
    faces: Vec<FinishedFace>,
    light: BouncedLight,
}

impl DirectLit {
    /// Empties the lighting of `bsp` and lights it directly.
    pub fn new(
        bsp: &mut Bsp,
        sidecar: Sidecar<'_>,
        textures: Vec<MipTex>,
        settings: &Settings,
        progress: &Progress,
    ) -> Result<Self> {
        bsp.clear_lighting();
        bsp.rewrite_entities(settings.styles(bsp)?)?;
        let scene = Scene::build(bsp, sidecar, &settings.scene(textures))?;
        let points = stage::place(&scene, settings, progress);
        let direct = stage::direct(&scene, points.samples(), settings, progress);
        Ok(Self { scene, points, direct })
    }

    /// Lets the light bounce.
    pub fn bounce(&self, settings: &Settings, progress: &Progress) -> BouncedLight {
        let Self { scene, points, direct } = self;
        let patches = stage::patches(scene, &points.luxels, settings, progress);
        let transfers = stage::transfers(scene, &patches, settings, progress);
        let shining = stage::shining(scene, &patches, (points, direct), settings);
        let bounced = stage::bounce(scene, &patches, &transfers, &shining, settings, progress);
        let light = &bounced.styles;
        let sources = Sources { scene, patches: &patches, transfers: &transfers, light };
        let gathered = stage::gather(sources, &points.luxels, settings, progress);
        let checked =
            stage::check(sources, &shining, &points.luxels, &gathered, settings, progress);
        let counts = Counts::new(scene, direct, &patches, &transfers, &bounced, &gathered);
        BouncedLight { patches, transfers, bounced, gathered, counts, checked }
    }

    /// Makes lightmaps of both.
    pub fn finish(
        mut self,
        mut light: BouncedLight,
        settings: &Settings,
        progress: &Progress,
    ) -> Finished {
        let BouncedLight { patches, transfers, bounced, gathered, .. } = &mut light;
        let Self { scene, points, direct } = &mut self;
        let _stage = progress.stage("lightmaps", 1);
        let sources = Sources { scene, patches, transfers, light: &bounced.styles };
        stage::directions(sources, &points.luxels, gathered, direct, settings);
        let faces = if let Some(view) = settings.debug {
            let sources = lightmap::DebugSources {
                scene,
                samples: points.samples(),
                direct,
                indirect: &gathered.maps,
                patches,
                light: &bounced.styles,
            };
            stage::debug(view, sources, settings)
        } else {
            let probes = stage::probes(scene, patches, points.samples(), bounced, settings);
            let (direct, indirect) = (std::mem::take(direct), std::mem::take(&mut gathered.maps));
            stage::finish(scene, points, direct, indirect, &probes, settings)
        };
        Finished { scene: self.scene, faces, light }
    }
}

impl Finished {
    /// Puts the lightmaps into `bsp`, or into a `.lit` file for it as it was, `unchanged`.
    pub fn store(
        self,
        bsp: &mut Bsp,
        unchanged: Option<Bsp>,
        choices: Vec<String>,
        settings: &Settings,
        progress: &Progress,
    ) -> Result<MapLight> {
        let Self { scene, faces, light } = self;
        let BouncedLight { patches, bounced, counts, checked, .. } = light;
        let outputs = &settings.outputs;
        let (rgb, files) = if let Some(unchanged) = unchanged {
            *bsp = unchanged;
            let store::LitOnly { rgb, files } = store::lit_only(bsp, &scene, &faces, outputs)?;
            (Some(rgb), files)
        } else {
            let copies = outputs.vanilla && outputs.writes_map();
            let vanilla = lightmap::vanilla_copies(&scene, &faces, copies);
            let packed = lightmap::pack(&faces, &vanilla)?;
            bsp.bspx.extend(stage::light_grid(&scene, &patches, &bounced, progress)?);
            let files = store::store(bsp, &packed, &scene, outputs)?;
            (packed.coloured.then_some(packed.rgb), files)
        };
        Ok(MapLight { scene, faces, rgb, files, counts, checked, choices })
    }
}
