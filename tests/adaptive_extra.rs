//! Supersampling where it matters against all samples traced.

mod support;

use glam::Vec3;
use qrad::bsp::Bsp;
use qrad::light::{Blockers, DirectLight, Directions, bounce_source, direct_adaptive, direct_from};
use qrad::photometry::Irradiance;
use qrad::scene::{Sample, Scene, SceneSettings, Sidecar, luxels};
use std::path::{Path, PathBuf};
use support::shared_dir;

/// How the luxels of the two compare.
#[derive(Debug, Default)]
struct Comparison {
    luxels: usize,
    /// More than two levels apart in some channel.
    off: usize,
    /// More than sixteen.
    far_off: usize,
    /// Sum of the differences in levels, first channel.
    bias: f64,
    rays: [u64; 2],
}

impl Comparison {
    fn add(&mut self, other: &Self) {
        self.luxels += other.luxels;
        self.off += other.off;
        self.far_off += other.far_off;
        self.bias += other.bias;
        (0..2).for_each(|i| self.rays[i] += other.rays[i]);
    }
}

fn own_map(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("maps").join(name).with_extension("bsp")
}

/// What is stored of light: limited to 255 with its hue, and cut off.
fn stored(level: Vec3) -> Vec3 {
    (level * (255.0 / level.max_element().max(255.0))).trunc()
}

/// Levels of each luxel as floats, not limited, of the style whose light is `style`.
fn levels(light: &DirectLight, style: u16, samples: &[Sample], grid: (u32, u32)) -> Vec<Vec3> {
    let maps = bounce_source(light, samples, grid.0, grid.1);
    let luxels = samples.len() / (grid.1 * grid.1) as usize;
    let map = maps.iter().find(|m| m.style == style).map(|m| &m.irradiance);
    map.map_or(vec![Vec3::ZERO; luxels], |m| m.iter().map(|Irradiance(e)| *e * 0.5).collect())
}

/// Lights every `step`-th face of a map both ways.
fn compare(path: &Path, extra: u32, step: usize, keys: &[(&str, &str)]) -> Comparison {
    let bsp = Bsp::read(&std::fs::read(path).unwrap()).unwrap();
    let texinfo = std::fs::read_to_string(path.with_extension("texinfo.json")).ok();
    let content = std::fs::read_to_string(path.with_extension("content.json")).ok();
    let sidecar =
        Sidecar { texinfo: texinfo.as_deref(), content: content.as_deref(), ..Sidecar::default() };
    let overrides = keys.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    let settings = SceneSettings { overrides, extra, ..SceneSettings::default() };
    let scene = Scene::build(&bsp, sidecar, &settings).unwrap();
    let mut blockers = [Blockers::new(&scene), Blockers::new(&scene)];
    let mut sum = Comparison::default();
    for face in (0..scene.surfaces.len()).step_by(step) {
        let Some(grid) = &scene.surfaces[face].luxels else { continue };
        let samples = luxels::place(&scene, face, extra);
        let none = Directions::default;
        let all = direct_from(&scene, face, &samples, none(), &mut blockers[0]);
        let some = direct_adaptive(&scene, face, (&samples, extra), none(), &mut blockers[1]);
        let mut styles: Vec<u16> = all.styles.iter().chain(&some.styles).map(|s| s.style).collect();
        styles.sort_unstable();
        styles.dedup();
        sum.rays[0] += all.rays.total();
        sum.rays[1] += some.rays.total();
        for style in styles {
            let [a, b] = [&all, &some].map(|l| levels(l, style, &samples, (grid.width, extra)));
            for (a, b) in a.iter().zip(&b) {
                let [a, b] = [a, b].map(|v| stored(*v));
                let apart = (a - b).abs().max_element();
                sum.luxels += 1;
                sum.off += usize::from(apart > 2.0);
                sum.far_off += usize::from(apart > 16.0);
                sum.bias += f64::from(b.x - a.x);
            }
        }
    }
    println!("{} x{extra} {keys:?}: {sum:?}", path.display());
    sum
}

/// At most `share` of the luxels of each are off, and on average they are neither darker nor brighter.
fn agrees(found: &Comparison, least: usize, share: f64) {
    assert!(found.luxels > least, "{found:?}");
    assert!(found.off as f64 <= share * found.luxels as f64, "{found:?}");
    assert!(found.far_off as f64 <= 0.001 * found.luxels as f64, "{found:?}");
    assert!(found.bias.abs() <= 0.1 * found.luxels as f64, "{found:?}");
}

#[test]
fn few_luxels_differ_and_most_rays_are_saved() {
    // A sun with penumbra, a dome, grates; then every effect; lights of many styles; narrow shadows.
    let mut sum = Comparison::default();
    for (map, step) in [("atrium", 6), ("effects_all", 1), ("styles", 3), ("slit", 4)] {
        let found = compare(&own_map(map), 4, step, &[]);
        agrees(&found, 2000, 0.005);
        sum.add(&found);
    }
    // Walls spare the exact way many rays as well: before them it was three times.
    assert!(sum.rays[1] * 5 < sum.rays[0] * 2, "{sum:?}");
}

#[test]
fn four_samples_a_luxel_and_dirt_agree_too() {
    agrees(&compare(&own_map("atrium"), 2, 5, &[]), 5000, 0.005);
    // A dome of suns, all of whose light dirt bends alike.
    agrees(&compare(&own_map("atrium"), 4, 6, &[("_dirt", "1")]), 2000, 0.005);
    agrees(&compare(&own_map("effects_all"), 4, 1, &[("_dirt", "1")]), 5000, 0.005);
}

#[test]
fn maps_of_others_agree() {
    let Some(shared) = shared_dir() else { return };
    for (map, step) in
        [("librequake/lqdm2", 6), ("librequake/lq_e2m3", 24), ("demo/city_quarter", 12)]
    {
        let path = shared.join("maps").join(map).with_extension("bsp");
        agrees(&compare(&path, 4, step, &[]), 2000, 0.005);
    }
}

#[test]
fn one_sample_a_luxel_is_always_traced() {
    let found = compare(&own_map("effects_all"), 1, 2, &[]);
    assert!(found.luxels > 2000 && found.off == 0 && found.bias == 0.0, "{found:?}");
    assert_eq!(found.rays[0], found.rays[1]);
}
