//! The plan of a run says what a map calls for, and switches are obeyed.

mod support;

use assert_cmd::Command;
use clap::ValueEnum;
use qrad::bsp::{Bsp, MipTex};
use qrad::progress::Progress;
use qrad::scene::effects::{Effect, Plan, Switches, plan};
use qrad::scene::{Scene, Sidecar};
use qrad::settings::Settings;
use std::path::PathBuf;

fn map(name: &str) -> PathBuf {
    support::maps_dir().join(name).with_extension("bsp")
}

fn texinfo(name: &str) -> String {
    std::fs::read_to_string(map(name).with_extension("texinfo.json")).unwrap()
}

fn settings(effects: &str) -> Settings {
    let switches = match effects {
        "" => Switches::default(),
        text => Switches::parse(text).unwrap(),
    };
    Settings { switches, ..Settings::default() }.switched().checked().unwrap()
}

fn plan_of(name: &str, effects: &str) -> Plan {
    let bsp = Bsp::read(&std::fs::read(map(name)).unwrap()).unwrap();
    let (texinfo, settings) = (texinfo(name), settings(effects));
    let sidecar = Sidecar { texinfo: Some(&texinfo), ..Sidecar::default() };
    let scene = Scene::build(&bsp, sidecar, &settings.scene(Vec::<MipTex>::new())).unwrap();
    plan(&scene, &settings)
}

/// Effects that the map with all of them has, and that nobody asked for on the command line.
const OF_MAP: [Effect; 15] = [
    Effect::Colour,
    Effect::Styles,
    Effect::Lights,
    Effect::SurfaceLights,
    Effect::Suns,
    Effect::SkyDomes,
    Effect::NegativeLight,
    Effect::Minlight,
    Effect::Dirt,
    Effect::Phong,
    Effect::Fences,
    Effect::Glass,
    Effect::ModelShadows,
    Effect::Bounces,
    Effect::NearField,
];

#[test]
fn a_map_with_every_effect_calls_for_each_and_a_plain_one_for_none() {
    let (all, none) = (plan_of("effects_all", ""), plan_of("effects_none", ""));
    let plain = [Effect::Lights, Effect::Bounces, Effect::NearField];
    for &effect in Effect::value_variants() {
        let wanted = OF_MAP.contains(&effect) || effect == Effect::Lit;
        assert_eq!(all.is_on(effect), wanted, "{effect:?} in effects_all");
        assert_eq!(none.is_on(effect), plain.contains(&effect), "{effect:?} in effects_none");
    }
    let text = all.to_string();
    assert!(text.contains("{grate: 8, first at (192 -200 32)"), "{text}");
}

#[test]
fn each_effect_can_be_switched_off_and_that_changes_the_light() {
    let light = |effects: &str| {
        let mut bsp = Bsp::read(&std::fs::read(map("effects_all")).unwrap()).unwrap();
        let texinfo = texinfo("effects_all");
        let sidecar = Sidecar { texinfo: Some(&texinfo), ..Sidecar::default() };
        let mut settings = settings(effects);
        if !effects.contains("bounces") && !effects.contains("near-field") {
            settings.bounces = Some(0);
        }
        let lit = qrad::light_bsp(&mut bsp, sidecar, Vec::new(), &settings, &Progress::new(false));
        (bsp.lighting, lit.unwrap().rgb)
    };
    let direct = light("");
    for effect in OF_MAP {
        let off = format!("-{}", effect.name());
        let plan = plan_of("effects_all", &off);
        assert!(!plan.is_on(effect), "{off}");
        assert!(plan.to_string().contains(&format!("switched off with {off}")), "{off}");
        match effect {
            // Without it there are bounces.
            Effect::NearField => assert!(light(&off) != light("+near-field"), "{off}"),
            Effect::Bounces => assert!(light(&off) == direct, "{off}"),
            Effect::Colour => assert!(light(&off).1.is_none() && direct.1.is_some()),
            // The only such model is a box that shadows nothing but itself.
            Effect::ModelShadows => assert!(light(&off) == direct, "{off}"),
            _ => assert!(light(&off) != direct, "{off}"),
        }
    }
}

#[test]
fn suns_without_sky_are_off() {
    let bsp = Bsp::read(&std::fs::read(map("effects_none")).unwrap()).unwrap();
    let mut settings = settings("");
    settings.overrides.push(("_sunlight2".into(), "100".into()));
    let scene = Scene::build(&bsp, Sidecar::default(), &settings.scene(Vec::new())).unwrap();
    assert!(scene.suns.is_empty());
    assert!(plan(&scene, &settings).to_string().contains("no sky to see"));
}

#[test]
fn explain_prints_every_effect_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.bsp");
    std::fs::copy(map("effects_none"), &path).unwrap();
    let before = std::fs::read(&path).unwrap();
    let run = Command::cargo_bin("qrad").unwrap().arg(&path).arg("--explain").assert().success();
    let text = String::from_utf8(run.get_output().stdout.clone()).unwrap();
    for effect in Effect::value_variants() {
        let name = effect.name();
        assert!(text.lines().any(|l| l.starts_with(&name)), "{name} is not in {text}");
    }
    assert!(std::fs::read(&path).unwrap() == before);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn effects_that_are_none_are_refused() {
    let run = Command::cargo_bin("qrad")
        .unwrap()
        .arg(map("effects_none"))
        .args(["--explain", "--effects", "-drit"])
        .assert()
        .failure();
    let text = String::from_utf8(run.get_output().stderr.clone()).unwrap();
    assert!(text.contains("drit") && text.contains("dirt") && text.lines().count() == 1, "{text}");
}
