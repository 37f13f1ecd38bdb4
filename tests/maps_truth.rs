//! Bounced light of game maps against path-traced truth: `reference/bounce` of the shared material, whose
//! README defines it.

mod support;

use glam::DVec3;
use qrad::bsp::Bsp;
use qrad::light_bsp;
use qrad::progress::Progress;
use qrad::scene::Sidecar;
use qrad::settings::{Quality, Settings};
use std::path::Path;

/// Light units of a level (`_range` is 0.5).
const UNITS: f64 = 2.0;

/// A luxel of a face and its bounced light, the mean of the channels.
struct Luxel {
    face: usize,
    s: usize,
    t: usize,
    light: f64,
}

fn read_truth(path: &Path) -> Vec<Luxel> {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("face,s,t,x,y,z,nx,ny,nz,D_r,D_g,D_b,I_r,I_g,I_b,se"));
    lines
        .map(|line| {
            let v: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
            let light = DVec3::from_slice(&v[12..]).element_sum() / 3.0;
            Luxel { face: v[0] as usize, s: v[1] as usize, t: v[2] as usize, light }
        })
        .collect()
}

/// Light of style 0 at the luxels of `truth`, before it is stored in bytes.
fn lit(map: &Path, truth: &[Luxel], settings: &Settings) -> Vec<f64> {
    let mut bsp = Bsp::read(&std::fs::read(map).unwrap()).unwrap();
    let side = |kind: &str| std::fs::read_to_string(map.with_extension(kind)).ok();
    let (texinfo, content) = (side("texinfo.json"), side("content.json"));
    let sidecar =
        Sidecar { texinfo: texinfo.as_deref(), content: content.as_deref(), ..Sidecar::default() };
    let lit = light_bsp(&mut bsp, sidecar, Vec::new(), settings, &Progress::new(false)).unwrap();
    truth
        .iter()
        .map(|luxel| {
            let width = lit.scene.surfaces[luxel.face].luxels.as_ref().unwrap().width as usize;
            let style = lit.faces[luxel.face].styles.iter().find(|s| s.style == 0);
            let level = style.map_or(0.0, |s| s.light[luxel.t * width + luxel.s].element_sum());
            f64::from(level) / 3.0 * UNITS
        })
        .collect()
}

/// Relative root mean square error, ratio of the sums, and 95th percentile of the error relative to the
/// mean.
fn scores(name: &str, map: &Path, keys: &[(&str, &str)], quality: Quality) -> Option<[f64; 3]> {
    let shared = support::shared_dir()?;
    let truth = read_truth(&shared.join("reference/bounce").join(name).with_extension("csv"));
    let map = shared.join("maps/librequake").join(map);
    let overrides: Vec<_> = keys.iter().map(|&(k, v)| (k.to_owned(), v.to_owned())).collect();
    let settings = Settings { overrides, ..Settings::of_quality(quality) };
    let total = lit(&map, &truth, &settings);
    let direct = lit(&map, &truth, &Settings { bounces: Some(0), ..settings });
    let got: Vec<f64> = total.iter().zip(&direct).map(|(t, d)| t - d).collect();
    let mut errors: Vec<f64> = got.iter().zip(&truth).map(|(g, t)| (g - t.light).abs()).collect();
    errors.sort_by(f64::total_cmp);
    let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
    let sum = truth.iter().map(|t| t.light).sum::<f64>();
    let rms = squares(&mut errors.iter().copied()) / squares(&mut truth.iter().map(|t| t.light));
    let p95 = errors[errors.len() * 95 / 100] / (sum / truth.len() as f64);
    let result = [rms.sqrt(), got.iter().sum::<f64>() / sum, p95];
    println!(
        "{name} {quality:?}: rms {:.4}, bias {:.4}, p95 {:.4}",
        result[0], result[1], result[2]
    );
    Some(result)
}

fn check(name: &str, map: &str, keys: &[(&str, &str)], quality: Quality, rms: f64) {
    let keys = [&[("minlight", "0")], keys].concat();
    if let Some([error, bias, p95]) = scores(name, Path::new(map), &keys, quality) {
        assert!(error <= rms, "{name}: {error}");
        assert!((bias - 1.0).abs() <= 0.01, "{name}: {bias}");
        assert!(p95 <= 0.1, "{name}: {p95}");
    }
}

#[test]
fn start_is_within_five_percent() {
    check("start", "start.bsp", &[], Quality::Normal, 0.05);
}

#[test]
fn start_is_within_two_percent_at_final_quality() {
    check("start", "start.bsp", &[], Quality::Final, 0.02);
}

#[test]
fn lqdm1_is_within_five_percent() {
    check("lqdm1", "lqdm1.bsp", &[], Quality::Normal, 0.05);
}

#[test]
fn lqdm2_is_within_five_percent() {
    check("lqdm2", "lqdm2.bsp", &[], Quality::Normal, 0.05);
}

#[test]
fn lq_e0m1_is_within_five_percent() {
    check("lq_e0m1_nodirt", "lq_e0m1.bsp", &[("dirt", "0")], Quality::Normal, 0.05);
}
