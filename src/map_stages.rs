//! A map run in three parts: direct light, bounced light, which may be found more than once with other
//! settings, and what is made of both.

use crate::aim;
use crate::bsp::{Bsp, MipTex};
use crate::check::{Energy, Findings};
use crate::light::DirectLight;
use crate::lightmap::{self, FinishedFace, Sources};
use crate::outputs::Scope;
use crate::patch::MapPatches;
use crate::progress::{Deadline, Progress};
use crate::radiosity::bounce::Bounced;
use crate::radiosity::transfers::Transfers;
use crate::report::Counts;
use crate::scene::effects::check_switches;
use crate::scene::{Scene, Sidecar};
use crate::settings::Settings;
use crate::stage::{self, Gathered, Points};
use crate::store;
use crate::{Files, Result};

/// A map with its direct light.
pub(crate) struct DirectLit {
    /// The map as light sees it.
    pub scene: Scene,
    /// Where light is sampled.
    pub points: Points,
    /// Direct light of each face.
    pub direct: Vec<DirectLight>,
    /// How far it got where time is short.
    pub partly: Option<String>,
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
        check_switches(&scene, settings)?;
        let points = stage::place(&scene, settings, progress)?;
        let samples = points.samples();
        let (direct, partly) = if let Some(end) = aim::end_of_direct(settings.aim) {
            let end = progress.deadline(end);
            let done = stage::direct_in_time(&scene, samples, settings, end, progress);
            let partly = done.text();
            (done.light, partly)
        } else {
            (stage::direct(&scene, samples, settings, progress), None)
        };
        Ok(Self { scene, points, direct, partly })
    }

    /// Lets the light bounce.
    pub fn bounce(&self, settings: &Settings, progress: &Progress) -> BouncedLight {
        self.bounce_until(settings, progress.no_deadline(), progress).expect("there is time")
    }

    /// The same if form factors are there by `end`; hemicubes at luxels are drawn until then.
    pub fn bounce_until(
        &self,
        settings: &Settings,
        end: Deadline<'_>,
        progress: &Progress,
    ) -> Option<BouncedLight> {
        let Self { scene, points, direct, .. } = self;
        let patches = stage::patches(scene, &points.luxels, settings, progress);
        let transfers = stage::transfers(scene, &patches, settings, end, progress)?;
        let shining = stage::shining(scene, &patches, (points, direct), settings);
        let bounced = stage::bounce(scene, &patches, &transfers, &shining, settings, progress);
        let light = &bounced.styles;
        let sources = Sources { scene, patches: &patches, transfers: &transfers, light };
        let gathered = stage::gather(sources, &points.luxels, settings, end, progress);
        let lit = (points, &direct[..]);
        let counts = Counts::new(scene, lit, &patches, &transfers, &bounced, &gathered);
        let checked =
            stage::check(sources, &shining, &points.luxels, &gathered, settings, progress);
        Some(BouncedLight { patches, transfers, bounced, gathered, counts, checked })
    }

    /// Guesses what bounces, all but at once.
    pub fn ambient(&self, settings: &Settings, progress: &Progress) -> BouncedLight {
        let Self { scene, points, direct, .. } = self;
        let _stage = progress.stage("gather", 1);
        let gathered = stage::ambient(scene, (points, direct), settings);
        let (patches, transfers) = (MapPatches::default(), Transfers::default());
        let bounced = Bounced::default();
        let lit = (points, &direct[..]);
        let counts = Counts::new(scene, lit, &patches, &transfers, &bounced, &gathered);
        BouncedLight { patches, transfers, bounced, gathered, counts, checked: (None, None) }
    }

    /// Gives hemicubes of their own to single luxels of `light` until `end`. Returns how many.
    pub fn refine(
        &self,
        light: &mut BouncedLight,
        settings: &Settings,
        end: Deadline<'_>,
        progress: &Progress,
    ) -> u64 {
        let _stage = progress.stage("refine", 1);
        let BouncedLight { patches, transfers, bounced, gathered, counts, .. } = light;
        let sources = Sources { scene: &self.scene, patches, transfers, light: &bounced.styles };
        let how = settings.gathering();
        let done = lightmap::refine(sources, &self.points.luxels, &mut gathered.maps, how, end);
        counts.hemicubes[1] += done;
        counts.overlay = transfers.overlay_costs();
        done
    }

    /// Finds out how far off `light` is.
    pub fn check(&self, light: &mut BouncedLight, settings: &Settings, progress: &Progress) {
        let Self { scene, points, direct, .. } = self;
        let BouncedLight { patches, transfers, bounced, gathered, .. } = &*light;
        let shining = stage::shining(scene, patches, (points, direct), settings);
        let sources = Sources { scene, patches, transfers, light: &bounced.styles };
        light.checked =
            stage::check(sources, &shining, &points.luxels, gathered, settings, progress);
    }

    /// Makes lightmaps of both.
    pub fn finish(
        &self,
        light: &BouncedLight,
        settings: &Settings,
        progress: &Progress,
    ) -> Vec<FinishedFace> {
        let Self { scene, points, direct, .. } = self;
        let BouncedLight { patches, transfers, bounced, gathered, .. } = light;
        let _stage = progress.stage("lightmaps", 1);
        let mut direct = direct.clone();
        let sources = Sources { scene, patches, transfers, light: &bounced.styles };
        stage::directions(sources, &points.luxels, gathered, &mut direct, settings);
        if let Some(view) = settings.debug {
            let sources = lightmap::DebugSources {
                scene,
                samples: points.samples(),
                direct: &direct,
                indirect: &gathered.maps,
                patches,
                light: &bounced.styles,
            };
            return stage::debug(view, sources, settings);
        }
        let probes = stage::probes(scene, patches, points.samples(), bounced, settings);
        stage::finish(scene, points, direct, gathered.maps.clone(), &probes, settings)
    }

    /// Puts lightmaps into `bsp`, or into a `.lit` file for it as it was, `unlit`. Returns three levels
    /// for each byte of the lighting lump when the light has colour, and what stands beside the map.
    pub fn store(
        &self,
        bsp: &mut Bsp,
        unlit: &Bsp,
        (faces, light): (&[FinishedFace], &BouncedLight),
        settings: &Settings,
        progress: &Progress,
    ) -> Result<(Option<Vec<u8>>, Files)> {
        let Self { scene, .. } = self;
        let outputs = &settings.outputs;
        if outputs.scope == Scope::LitOnly {
            bsp.clone_from(unlit);
            let store::LitOnly { rgb, files } = store::lit_only(bsp, scene, faces, outputs)?;
            return Ok((Some(rgb), files));
        }
        let copies = outputs.vanilla && outputs.writes_map();
        let vanilla = lightmap::vanilla_copies(scene, faces, copies);
        let packed = lightmap::pack(faces, &vanilla)?;
        bsp.bspx.extend(stage::light_grid(scene, &light.patches, &light.bounced, progress)?);
        let files = store::store(bsp, &packed, scene, outputs)?;
        Ok((packed.coloured.then_some(packed.rgb), files))
    }
}
