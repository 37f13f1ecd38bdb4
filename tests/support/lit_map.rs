//! The stages of a map run one by one, with everything that they make.

use qrad::bsp::Bsp;
use qrad::light::{DirectLight, StyleLight, bounce_source, direct};
use qrad::lightmap::{Gather, Sources, indirect};
use qrad::patch::{MapPatches, PatchSet};
use qrad::radiosity::bounce::{Bounced, bounce};
use qrad::radiosity::solve::Limits;
use qrad::radiosity::transfers::{Sharing, Transfers};
use qrad::scene::material_file::MaterialFile;
use qrad::scene::{Sample, Scene, SceneSettings, Sidecar, luxels};
use qrad::settings::{Settings, SurfaceLights};

/// A map up to its transfers, as runs with the same settings make them.
pub struct Prepared {
    pub scene: Scene,
    pub samples: Vec<Vec<Sample>>,
    pub patches: MapPatches,
    pub transfers: Transfers,
    pub settings: Settings,
}

/// The light of a map, before it becomes levels.
pub struct Lit {
    pub direct: Vec<DirectLight>,
    pub bounced: Bounced,
    /// Indirect light at the luxels of each surface.
    pub indirect: Vec<Vec<StyleLight>>,
}

impl Prepared {
    pub fn new(bsp: &Bsp, settings: Settings, area_lights: bool) -> Self {
        Self::with(bsp, settings, area_lights, Sidecar::default())
    }

    /// With what stands beside the map.
    pub fn with(
        bsp: &Bsp,
        mut settings: Settings,
        area_lights: bool,
        sidecar: Sidecar<'_>,
    ) -> Self {
        if area_lights {
            settings.surface_lights = SurfaceLights::Area;
        }
        let scene_settings = SceneSettings {
            area_lights,
            grey: settings.grey,
            switches: settings.switches.clone(),
            ..SceneSettings::default()
        };
        let scene = Scene::build(bsp, sidecar, &scene_settings).unwrap();
        let samples: Vec<_> =
            (0..scene.surfaces.len()).map(|face| luxels::place(&scene, face, 1)).collect();
        let patches = MapPatches::new(&scene, &samples, settings.patch_size);
        let transfers = Transfers::default();
        let map = Self { scene, samples, patches, transfers, settings };
        Self { transfers: map.transfers_of(&map.patches.set), ..map }
    }

    /// The transfers of the patches of the map, `set`, as a run makes them.
    pub fn transfers_of(&self, set: &PatchSet) -> Transfers {
        let Self { scene, patches, settings, .. } = self;
        let (groups, mut small) = (patches.groups(), patches.small());
        small.iter_mut().for_each(|small| *small &= settings.coarse_where_small());
        let sharing = Sharing { groups: &groups, share: settings.share, small: &small };
        let (tracer, size) = (scene.bounce_tracer(), settings.hemicube);
        Transfers::shared(tracer, set, sharing, size, |_| {})
    }

    /// A map of the project, with default settings and the material file beside it, if there is one.
    pub fn project_map(name: &str, area_lights: bool) -> Self {
        let path = super::maps_dir().join(name);
        let bsp = Bsp::read(&std::fs::read(&path).unwrap()).unwrap();
        let text = std::fs::read_to_string(path.with_extension("materials.toml"));
        let materials = text.map(|text| MaterialFile::parse(&text, name).unwrap()).ok();
        let sidecar = Sidecar { materials: materials.as_ref(), ..Sidecar::default() };
        Self::with(&bsp, Settings::default(), area_lights, sidecar)
    }

    pub fn light(&self, gather: Gather) -> Lit {
        let direct = self.direct();
        let bounced = self.bounce(&direct);
        let indirect = self.gather(&bounced, gather);
        Lit { direct, bounced, indirect }
    }

    /// Direct light of each surface.
    pub fn direct(&self) -> Vec<DirectLight> {
        let samples = self.samples.iter().enumerate();
        samples.map(|(face, s)| direct(&self.scene, face, s)).collect()
    }

    pub fn bounce(&self, direct: &[DirectLight]) -> Bounced {
        let Self { scene, samples, patches, transfers, settings } = self;
        let emission = patches.emission(&scene.emitters);
        let limits = Limits { passes: settings.bounces, residual: settings.residual };
        let arriving: Vec<_> = direct
            .iter()
            .zip(samples)
            .map(|(direct, samples)| bounce_source(direct, samples, 1, 1))
            .collect();
        bounce(scene, patches, transfers, &arriving, &emission, limits, |_| {})
    }

    /// Indirect light at the luxels of each surface.
    pub fn gather(&self, bounced: &Bounced, gather: Gather) -> Vec<Vec<StyleLight>> {
        let Self { scene, samples, patches, transfers, settings } = self;
        let how = Settings { gather, ..settings.clone() }.gathering();
        let sources = Sources { scene, patches, transfers, light: &bounced.styles };
        indirect(sources, samples, how, |_| {}).0
    }
}
