//! Options that tell of errors and times, through the program.

mod support;

use std::path::{Path, PathBuf};
use support::program::{arg, fail, qrad};

/// A map of the project, copied into a folder.
fn copy(folder: &Path, name: &str) -> PathBuf {
    let to = folder.join(name);
    std::fs::copy(support::maps_dir().join(name), &to).unwrap();
    to
}

/// The smallest text scene.
fn scene() -> PathBuf {
    support::maps_dir().join("cornell/two_patches.txt")
}

/// What a run that succeeds prints.
fn printed(args: &[&str]) -> String {
    let output = qrad().args(args).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{args:?}: {error}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn every_run_tells_its_error_unless_told_not_to() {
    let folder = tempfile::tempdir().unwrap();
    let map = copy(folder.path(), "styles.bsp");
    let table = printed(&[arg(&map)]);
    for row in ["estimated error", "energy balance", "half the error", "residual"] {
        assert!(table.contains(row), "{row}: {table}");
    }
    assert!(!printed(&[arg(&map), "--no-check"]).contains("estimated error"));
}

#[test]
fn a_check_changes_no_byte() {
    let folder = tempfile::tempdir().unwrap();
    let map = copy(folder.path(), "styles.bsp");
    let lit = |options: &[&str]| {
        let out = folder.path().join("out.bsp");
        printed(&[&[arg(&map), "-q", "-o", arg(&out)], options].concat());
        std::fs::read(out).unwrap()
    };
    assert!(lit(&[]) == lit(&["--no-check"]));
}

#[test]
fn reports_stand_alone() {
    let scene = scene();
    let folder = tempfile::tempdir().unwrap();
    let map = copy(folder.path(), "styles.bsp");
    let [html, json] = ["r.html", "r.json"].map(|name| folder.path().join(name));
    printed(&["-q", arg(&map), "--report", arg(&html)]);
    let page = std::fs::read_to_string(&html).unwrap();
    assert!(page.contains("data:image/png;base64,") && page.contains("<svg"));
    assert!(!page.contains("src=\"http") && !page.contains("<script"));
    printed(&["-q", arg(&map), "--report", arg(&json)]);
    let report: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    assert!(report["findings"]["points"].as_u64().unwrap() > 0);
    assert!(report["seconds"].as_f64().unwrap() > 0.0);
    assert!(report["settings"].as_array().unwrap().iter().any(|s| s[0] == "patch size"));
    let other = folder.path().join("r.txt");
    let error = fail(&map, &["-q", "--report", arg(&other)]);
    assert!(error.contains(".html or .json"), "{error}");
    let text = folder.path().join("text.json");
    let lit = folder.path().join("lit.txt");
    printed(&["-q", "--patches", arg(&scene), "-o", arg(&lit), "--report", arg(&text)]);
    assert!(std::fs::read_to_string(text).unwrap().contains("near field"));
}

#[test]
fn a_sweep_goes_on_where_it_was_and_repeats_nothing() {
    let scene = scene();
    let folder = tempfile::tempdir().unwrap();
    let sweep = folder.path().join("sweep");
    let args = ["--patches", arg(&scene), "--sweep", arg(&sweep)];
    let first = printed(&args);
    for file in ["sweep.csv", "sweep.html", "error-seconds.svg", "error-memory.png"] {
        assert!(sweep.join(file).exists(), "{file}");
    }
    assert!(!first.contains("points measured  0\n"), "{first}");
    let csv = sweep.join("sweep.csv");
    let whole = std::fs::read_to_string(&csv).unwrap();
    assert!(printed(&args).contains("points measured  0\n"));
    assert_eq!(std::fs::read_to_string(&csv).unwrap(), whole);
    // As an interrupt leaves it.
    let lines: Vec<&str> = whole.lines().collect();
    std::fs::write(&csv, lines[..lines.len() - 2].join("\n") + "\n").unwrap();
    assert!(printed(&args).contains("points measured  2\n"));
    let again = std::fs::read_to_string(&csv).unwrap();
    assert_eq!(again.lines().count(), lines.len());
    assert!(lines[..lines.len() - 2].iter().all(|l| again.contains(l)));
}

#[test]
fn sweeps_of_maps_compare_with_the_finest_and_with_truth() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = folder.path().join("sweep");
    let map = copy(folder.path(), "furnace.bsp");
    let before = std::fs::read(&map).unwrap();
    printed(&["-q", arg(&map), "--sweep", arg(&sweep)]);
    assert!(std::fs::read(&map).unwrap() == before, "a sweep writes no map");
    let csv = std::fs::read_to_string(sweep.join("sweep.csv")).unwrap();
    let error = |line: &str| line.split(',').nth(5).unwrap().parse::<f64>().unwrap();
    let of = |preset: &str| {
        let marked = format!(",{preset},");
        error(csv.lines().find(|l| l.contains(&marked)).unwrap())
    };
    assert_eq!(of("final"), 0.0);
    assert!(of("draft") >= of("high"), "{} {}", of("draft"), of("high"));
    assert!(std::fs::read_to_string(sweep.join("sweep.html")).unwrap().contains("eight times"));
    let truth = folder.path().join("truth.csv");
    std::fs::write(&truth, "face,s,t,I_r,I_g\n0,0,0,1,1\n").unwrap();
    let problem = fail(&map, &["-q", "--sweep", arg(&sweep), "--truth", arg(&truth)]);
    assert!(problem.contains("I_b"), "{problem}");
}

#[test]
fn estimates_write_nothing_and_finer_presets_take_longer() {
    let scene = scene();
    let folder = tempfile::tempdir().unwrap();
    let map = copy(folder.path(), "atrium.bsp");
    let before = std::fs::read(&map).unwrap();
    for args in [vec![arg(&map), "--estimate"], vec!["--patches", arg(&scene), "--estimate"]] {
        let table = printed(&args);
        let [draft, last] = ["draft", "final"].map(|name| {
            let row = table.lines().find(|l| l.starts_with(name)).unwrap();
            row.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap()
        });
        assert!(last >= draft, "{table}");
    }
    assert!(std::fs::read(&map).unwrap() == before);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn errors_can_be_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let map = copy(folder.path(), "styles.bsp");
    let coarse = printed(&[arg(&map), "--target-error", "8%"]);
    let fine = printed(&[arg(&map), "--target-error", "1%"]);
    assert!(coarse.contains("for an error of 8.00 %") && fine.contains("for an error of 1.00 %"));
    let gather = |table: &str| {
        let row = table.lines().find(|l| l.starts_with("luxel hemicubes")).unwrap();
        row.split_whitespace().skip(2).collect::<String>().parse::<u64>().unwrap()
    };
    assert!(gather(&fine) > gather(&coarse));
    let problem = fail(&map, &["--target-error", "0"]);
    assert!(problem.contains("--target-error"), "{problem}");
}

#[test]
fn times_can_be_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let map = copy(folder.path(), "styles.bsp");
    let out = folder.path().join("out.bsp");
    let args = [arg(&map), "-o", arg(&out), "--time-budget"];
    // Enough on any machine, and too few for anything on any. `tests/time_budget.rs` has what is between.
    let table = printed(&[&args[..], &["5s", "--keep-partial"]].concat());
    assert!(table.contains("for a time of 5 s") && out.exists(), "{table}");
    let table = printed(&[&args[..], &["0.0001s"]].concat());
    assert!(table.contains("too few"), "{table}");
}
