//! Whole text scenes: against known solutions, and through the program.

mod support;

use glam::DVec3;
use qrad::light_patches_with;
use qrad::patch::{Quad, TextScene};
use qrad::progress::Progress;
use qrad::radiosity::near_pairs::NearLimits;
use qrad::radiosity::solve::Solution;
use qrad::settings::Quality;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use support::program::{arg, fail, qrad};

/// What is known of a patch.
struct Truth {
    exitance: DVec3,
    emission: DVec3,
}

/// The known solution in a CSV file with the columns patch, B_r, B_g, B_b, se, buried, E_r, E_g, E_b.
fn read_truth(path: &Path) -> Vec<Truth> {
    let text = std::fs::read_to_string(path).unwrap();
    let lines = text.lines().filter(|l| !l.starts_with('#') && !l.starts_with("patch,"));
    lines
        .map(|line| {
            let v: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
            assert_eq!(v.len(), 9, "{line}");
            let (exitance, emission) = (DVec3::new(v[1], v[2], v[3]), DVec3::from_slice(&v[6..]));
            Truth { exitance, emission: emission.min(exitance) }
        })
        .collect()
}

fn area(quad: &Quad) -> f64 {
    let [a, b, c, d] = quad.vertices;
    0.5 * (c - a).cross(d - b).length()
}

/// How far a solution is from the truth, relative to the light that was reflected.
struct Score {
    /// Root mean square by area, over all patches.
    rms: f64,
    /// Largest error of a channel of a patch, relative to the scene's mean.
    worst: f64,
}

fn score(scene: &TextScene, truth: &[Truth], got: &[DVec3]) -> Score {
    assert_eq!(truth.len(), got.len());
    let (mut error, mut square, mut light, mut areas) = (0.0, 0.0, DVec3::ZERO, 0.0);
    let mut worst = DVec3::ZERO;
    for ((quad, truth), got) in scene.patches.iter().zip(truth).zip(got) {
        let (area, off) = (area(quad), *got - truth.exitance);
        let reflected = truth.exitance - truth.emission;
        error += area * off.length_squared();
        square += area * reflected.length_squared();
        light += area * reflected;
        areas += area;
        worst = worst.max(off.abs());
    }
    let mean = (light / areas).max(DVec3::splat(1e-300));
    let lit = DVec3::select(light.cmpgt(DVec3::ZERO), worst / mean, DVec3::ZERO);
    Score { rms: (error / square).sqrt(), worst: lit.max_element() }
}

/// The shared scenes whose truth is known, by name.
fn known_scenes(shared: &Path) -> Vec<(String, TextScene, Vec<Truth>)> {
    let mut scenes: Vec<PathBuf> = std::fs::read_dir(shared.join("scenes"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "txt"))
        .collect();
    scenes.sort();
    let known = scenes.into_iter().filter_map(|path| {
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let truth = shared.join(format!("scenes/truth/{name}.csv"));
        let scene = TextScene::parse(&std::fs::read_to_string(&path).unwrap(), &name).unwrap();
        truth.exists().then(|| (name, scene, read_truth(&truth)))
    });
    known.collect()
}

/// The scene with so many patches that it takes longer than all others together.
const LARGE: &str = "cornell_8000";

fn solve(scene: &TextScene, near: Option<NearLimits>) -> (Vec<DVec3>, Solution) {
    let (_, solution) = light_patches_with(scene, near, &Progress::new(false)).unwrap();
    (solution.exitance.iter().map(|m| m.0.as_dvec3()).collect(), solution)
}

#[test]
fn known_scenes_have_the_known_light() {
    let Some(shared) = support::shared_dir() else { return };
    let mut solved = 0;
    for (name, scene, truth) in known_scenes(&shared) {
        if name == LARGE {
            continue;
        }
        let (got, solution) = solve(&scene, Some(Quality::Normal.near()));
        assert!(got.iter().all(|m| m.is_finite() && m.min_element() >= 0.0), "{name}");
        assert!(solution.settled || solution.passes == scene.passes, "{name}");
        let Score { rms, worst } = score(&scene, &truth, &got);
        println!("{name}: refl_rms {:.4} %, worst {:.2} %", 100.0 * rms, 100.0 * worst);
        assert!(rms <= 0.005 && worst <= 0.05, "{name}: {rms} {worst}");
        solved += 1;
    }
    assert!(solved >= 30, "{solved} scenes");
}

#[test]
fn plain_hemicubes_match_exact_form_factors_from_centres() {
    let Some(shared) = support::shared_dir() else { return };
    for (name, scene, _) in known_scenes(&shared) {
        if name == LARGE {
            continue;
        }
        let centre = read_truth(&shared.join(format!("scenes/truth/centre/{name}.csv")));
        let Score { rms, .. } = score(&scene, &centre, &solve(&scene, None).0);
        println!("{name}: {:.4} % from exact form factors from centres", 100.0 * rms);
        // What is left is how fine the cells are.
        assert!(rms <= 0.02, "{name}: {rms}");
    }
}

/// Processor seconds that this process has used, as Linux counts them (in hundredths).
fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    // User time is the 14th field; the name in brackets is the second.
    fields.skip(11).take(1).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// Prints the table of docs/accuracy.md; `QRAD_SCENES`, if set, is the names that are wanted and
/// `QRAD_QUALITIES` the columns. With `QRAD_WRITE_DOCS` set, scenes of which all columns are wanted renew
/// what `--target-error` knows.
#[test]
#[ignore = "takes minutes; run it to renew docs/accuracy.md"]
fn accuracy_table() {
    let Some(shared) = support::shared_dir() else { return };
    let left_out = |variable: &str, name: &str| {
        std::env::var(variable).is_ok_and(|list| list.split(',').all(|n| n != name))
    };
    let columns = [
        ("plain", None),
        ("draft", Some(Quality::Draft.near())),
        ("normal", Some(Quality::Normal.near())),
        ("high", Some(Quality::High.near())),
        ("final", Some(Quality::Final.near())),
    ];
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/aim/measured_text.csv");
    let known = std::fs::read_to_string(&file).unwrap();
    let lines = known.lines().skip(1).filter_map(|l| l.split_once(','));
    let mut known: BTreeMap<String, String> =
        lines.map(|(name, errors)| (name.to_owned(), errors.to_owned())).collect();
    println!("| scene | plain: rms, worst, s | draft | normal | high | final |");
    println!("|---|---|---|---|---|---|");
    for (name, scene, truth) in known_scenes(&shared) {
        if left_out("QRAD_SCENES", &name) {
            continue;
        }
        let mut line = format!("| {name} |");
        let mut errors = Vec::new();
        for (quality, near) in columns {
            if left_out("QRAD_QUALITIES", quality) {
                line += " - |";
                continue;
            }
            let start = processor_seconds();
            let (got, _) = solve(&scene, near);
            let time = processor_seconds() - start;
            let Score { rms, worst } = score(&scene, &truth, &got);
            line += &format!(" {:.3}, {:.2}, {time:.2} |", 100.0 * rms, 100.0 * worst);
            errors.extend(near.map(|_| format!("{:.3}", 100.0 * rms)));
        }
        println!("{line}");
        if errors.len() + 1 == columns.len() {
            known.insert(name, errors.join(","));
        }
    }
    if std::env::var_os("QRAD_WRITE_DOCS").is_some() {
        let lines: Vec<String> = known.iter().map(|(n, e)| format!("{n},{e}\n")).collect();
        std::fs::write(file, format!("scene,draft,normal,high,final\n{}", lines.concat())).unwrap();
    }
}

fn project_scene(name: &str) -> PathBuf {
    support::maps_dir().join("cornell").join(name)
}

#[test]
fn the_program_changes_light_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let input = project_scene("cornell.txt");
    let before = std::fs::read(&input).unwrap();
    let lit = |threads: &str| {
        let output = folder.path().join(format!("{threads}.txt"));
        qrad()
            .args(["--patches", arg(&input), "-o", arg(&output), "--threads", threads])
            .assert()
            .success();
        std::fs::read_to_string(output).unwrap()
    };
    let text = lit("1");
    assert!(text == lit("2"), "the bytes depend on the number of threads");
    assert!(std::fs::read(&input).unwrap() == before, "the input is as it was");
    let raw = TextScene::parse(std::str::from_utf8(&before).unwrap(), "raw").unwrap();
    let lit = TextScene::parse_lit(&text, "lit").unwrap();
    assert_eq!(raw.camera, lit.camera);
    let header = |s: &TextScene| (s.image, s.hemicube, s.passes);
    assert_eq!(header(&raw), header(&lit));
    let shape =
        |s: &TextScene| s.patches.iter().map(|q| (q.vertices, q.normal)).collect::<Vec<_>>();
    assert_eq!(shape(&raw), shape(&lit));
    assert!(lit.patches.iter().all(|q| q.exitance == [0.0; 3]));
    // Emitters shine at least as they did; everything that reflects is lit.
    for (raw, lit) in raw.patches.iter().zip(&lit.patches) {
        assert!((0..3).all(|c| lit.reflectance[c] >= raw.exitance[c] * 0.999_999));
    }
    let bright = lit.patches.iter().filter(|q| q.reflectance.iter().sum::<f64>() > 0.0).count();
    assert!(bright * 10 > 9 * lit.patches.len(), "{bright} of {} are lit", lit.patches.len());
}

#[test]
fn the_scene_goes_where_it_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("two.patches.txt");
    std::fs::copy(project_scene("two_patches.txt"), &input).unwrap();
    let report = qrad().arg("--patches").arg(&input).assert().success().get_output().clone();
    let default = std::fs::read(folder.path().join("two.patches-lit.txt")).unwrap();
    let report = String::from_utf8(report.stdout).unwrap();
    assert!(report.contains("passes") && report.contains("two.patches-lit.txt"), "{report}");

    let dash = qrad().args(["--patches", arg(&input), "-o", "-"]).assert().success();
    assert!(dash.get_output().stdout == default, "standard output holds the scene and no more");
    let quiet = qrad().args(["--patches", arg(&input), "-o", "-", "-q"]).assert().success();
    assert!(quiet.get_output().stdout == default && quiet.get_output().stderr.is_empty());

    let named = folder.path().join("named");
    qrad().args(["--patches", arg(&input), "-o", arg(&named)]).assert().success();
    assert!(std::fs::read(&named).unwrap() == default);
    let files = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(files, 3, "the scene, two results and no temporary file");
}

#[test]
fn the_report_says_why_the_passes_ended() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(project_scene("cornell.txt")).unwrap();
    let mut lines = text.lines();
    let (camera, _) = (lines.next().unwrap(), lines.next());
    let rest: Vec<&str> = lines.collect();
    let ended = |passes: u32| {
        let path = folder.path().join(format!("{passes}.txt"));
        let scene = format!("{camera}\n64 64 16 16 {passes}\n{}\n", rest.join("\n"));
        std::fs::write(&path, scene).unwrap();
        let run = qrad().arg("--patches").arg(&path).assert().success().get_output().clone();
        String::from_utf8(run.stdout).unwrap()
    };
    assert!(ended(3).contains("passes used up"), "{}", ended(3));
    assert!(ended(3).contains("3 of at most 3"));
    assert!(ended(500).contains("nothing left to send"));
}

#[test]
fn failures_are_one_line_and_leave_files_alone() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing.txt");
    let line = fail(Path::new("--patches"), &[arg(&missing)]);
    assert!(line.contains("missing.txt"), "{line}");
    let broken = folder.path().join("broken.txt");
    std::fs::write(&broken, "0 0 -1 0 0 0 0 1 0\n8 8 63 64 10\n").unwrap();
    let line = fail(Path::new("--patches"), &[arg(&broken)]);
    assert!(line.contains("broken.txt") && line.contains("line 2"), "{line}");
    let good = project_scene("two_patches.txt");
    let line = fail(Path::new("--patches"), &[arg(&good), "-o", arg(folder.path())]);
    assert!(line.contains(arg(folder.path())), "{line}");
    let nowhere = folder.path().join("no/such/out.txt");
    let line = fail(Path::new("--patches"), &[arg(&good), "-o", arg(&nowhere)]);
    assert!(line.contains("out.txt"), "{line}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "only the broken scene");
    let line = fail(&good, &[]);
    assert!(line.contains("two_patches.txt"), "a scene is not a map: {line}");
}
