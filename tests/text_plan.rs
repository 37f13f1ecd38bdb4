//! The plan of text scenes: what `--explain` says of them, what `--effects` switches, what the report tells.

mod support;

use qrad::patch::{PatchEffects, Shader, TextScene};
use qrad::progress::Progress;
use qrad::radiosity::channels::Channels;
use qrad::scene::effects::{Effect, Plan, Switches};
use qrad::text_plan::{self, EFFECTS};
use std::path::{Path, PathBuf};
use support::maps_dir;
use support::program::{arg, fail, run};
use support::quads::{Light, cuboid, scene};

fn file(name: &str) -> PathBuf {
    maps_dir().join("cornell").join(name)
}

/// A grey room that shines a little, and a copy of it with every effect.
fn rooms() -> [TextScene; 2] {
    let light = Light { exitance: 0.5, reflectance: 0.25 };
    let low = glam::DVec3::ZERO;
    let plain = scene(cuboid(low, glam::DVec3::ONE, 2, true, light), 16, 50);
    let mut rich = plain.clone();
    rich.patches[1].exitance = [0.5, 0.4, 0.3];
    rich.patches[0].effects.straight = Some([0.5, 0.25, 0.5]);
    let inner = cuboid(glam::DVec3::splat(0.3), glam::DVec3::splat(0.6), 1, false, light);
    rich.patches.extend(inner);
    let count = rich.patches.len();
    rich.patches[count - 1].effects.diffuse = Some([0.5; 3]);
    rich.patches[count - 2].effects.shader = Some(Shader::Checker([2, 2], [0.5; 3]));
    [plain, rich]
}

fn plan(scene: &TextScene) -> Plan {
    text_plan::plan(scene, true, &Switches::default())
}

#[test]
fn each_effect_is_on_where_a_patch_calls_for_it() {
    let [plain, rich] = rooms();
    for effect in EFFECTS {
        let of_all = [Effect::SurfaceLights, Effect::Bounces, Effect::NearField];
        assert_eq!(plan(&plain).is_on(effect), of_all.contains(&effect), "{effect:?}");
        assert!(plan(&rich).is_on(effect), "{effect:?}");
    }
    let text = plan(&rich).to_string();
    for part in
        ["three channels", "seen through: 1, first at (0", "comes through: 1, first at (0.45"]
    {
        assert!(text.contains(part), "{part:?} is not in {text}");
    }
}

#[test]
fn each_effect_can_be_switched_off_and_that_changes_the_light() {
    let [_, rich] = rooms();
    let quiet = Progress::new(false);
    let light = |scene: &TextScene| qrad::light_patches(scene, &quiet).unwrap().1;
    let before = light(&rich).exitance;
    for effect in EFFECTS.into_iter().filter(|e| *e != Effect::NearField) {
        let switches = Switches::parse(&format!("-{}", effect.name())).unwrap();
        let mut scene = rich.clone();
        text_plan::apply(&switches, &mut scene);
        let plan = text_plan::plan(&scene, true, &switches);
        assert!(!plan.is_on(effect), "{effect:?}: {plan}");
        assert!(plan.to_string().contains(&format!("switched off with -{}", effect.name())));
        let after = light(&scene);
        assert!(after.exitance != before, "{effect:?}");
        assert!(effect != Effect::Colour || after.channels == Channels::One);
        // What is still there is still whole.
        let text = scene.to_text();
        assert!(TextScene::parse(&text, "again").is_ok(), "{effect:?}");
    }
}

#[test]
fn scenes_without_effects_are_left_as_they_are() {
    let [plain, _] = rooms();
    let mut same = plain.clone();
    text_plan::apply(&Switches::default(), &mut same);
    assert!(same.patches == plain.patches && same.passes == plain.passes);
    assert!(plain.patches.iter().all(|q| q.effects == PatchEffects::default()));
}

#[test]
fn explain_prints_the_plan_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.txt");
    std::fs::copy(file("curtain.txt"), &path).unwrap();
    let flag = Path::new("--patches");
    let output = run(flag, &[arg(&path), "--explain"]);
    let text = String::from_utf8(output.stdout).unwrap();
    for effect in EFFECTS {
        assert!(text.lines().any(|l| l.starts_with(&effect.name())), "{effect:?} is not in {text}");
    }
    assert!(text.contains("; about "), "{text}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    let said = fail(flag, &[arg(&path), "--explain", "--effects", "-drit"]);
    assert!(said.contains("drit"), "{said}");
}

#[test]
fn reports_carry_the_plan_with_what_it_took() {
    let folder = tempfile::tempdir().unwrap();
    let [out, report] = ["o.txt", "r.json"].map(|name| folder.path().join(name));
    run(
        Path::new("--patches"),
        &[arg(&file("two_patches.txt")), "-o", arg(&out), "--report", arg(&report)],
    );
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(report).unwrap()).unwrap();
    let plan = json["plan"].as_str().unwrap();
    assert!(plan.contains("; took ") && plan.contains("solved in "), "{plan}");
}
