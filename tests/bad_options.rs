//! Every option of the command line, from clap's own list and from the table of the reference's
//! options, with values that it cannot use: one clear line and exit code 1 or 2, and no file changes.

mod support;

use clap::{Arg, Command, CommandFactory};
use qrad::bsp::Format;
use qrad::cli::Cli;
use qrad::legacy_args::{OPTIONS, Values};
use std::ffi::{OsStr, OsString};
use std::os::unix::ffi::OsStringExt;
use std::path::{Path, PathBuf};
use std::time::Duration;
use support::program::qrad;
use support::tiny;
use tempfile::TempDir;

/// No number, name or pair that any option takes, but for [`TAKEN`].
const BAD: [&str; 13] = [
    "",
    " ",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "-1",
    "1e300",
    "-1e300",
    "99999999999999999999",
    "0x10",
    "1;2",
    "\u{2603}",
];
/// What is in range nevertheless: 1e20 is a factor.
const TAKEN: [(&str, &str); 1] = [("reflectance-scale", "99999999999999999999")];

fn own() -> Command {
    let mut command = Cli::command();
    command.build();
    command
}

/// A folder with a small map, a scene, and things that are no files.
struct Place {
    folder: TempDir,
    map: PathBuf,
    scene: PathBuf,
}

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (map, scene) = (folder.path().join("map.bsp"), folder.path().join("scene.txt"));
        std::fs::write(&map, tiny::map(Format::Bsp29).write().unwrap()).unwrap();
        std::fs::write(
            &scene,
            "0 0 0 0 5 0 0 0 1\n64 64 8 8 9\n0 0 0 1 0 0 1 1 0 0 1 0 0 0 1\n1 1 1 0 0 0\n",
        )
        .unwrap();
        std::fs::create_dir(folder.path().join("folder")).unwrap();
        Self { folder, map, scene }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Names and bytes of all files, and names of folders.
    fn contents(&self) -> Vec<(PathBuf, Option<Vec<u8>>)> {
        let mut found = Vec::new();
        let mut folders = vec![self.folder.path().to_path_buf()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path.clone());
                }
                found.push((path.clone(), std::fs::read(path).ok()));
            }
        }
        found.sort();
        found
    }

    /// Runs with these arguments; the exit code and what standard error says.
    #[track_caller]
    fn run(&self, args: &[OsString]) -> (i32, String) {
        let mut command = qrad();
        command.args(args).args(["--hemicube", "8"]).timeout(Duration::from_secs(60));
        let output = command.current_dir(self.folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let code = output.status.code().unwrap_or_else(|| panic!("{args:?}: killed or too slow"));
        assert!(!said.contains("panicked"), "{args:?}: {said}");
        (code, said)
    }

    /// The run is refused with a line that contains `word`, and changes nothing.
    #[track_caller]
    fn refused(&self, args: &[OsString], word: &str) {
        let before = self.contents();
        let (code, said) = self.run(args);
        assert!(code == 1 || code == 2, "{args:?}: exit code {code}: {said}");
        let line = said.lines().next().unwrap_or("");
        assert!(
            line.starts_with("error: ") || line.starts_with("qrad: error: "),
            "{args:?}: {said}"
        );
        assert!(said.contains(word), "{args:?}: {word:?} is not in {said}");
        assert!(self.contents() == before, "{args:?}: files changed");
    }

    /// The arguments that an option needs around it, with its value.
    fn args(&self, arg: &Arg, option: OsString) -> Vec<OsString> {
        let name = arg.get_long().unwrap_or("");
        let mut args = match name {
            "patches" | "completions" => Vec::new(),
            "near-field" => vec!["--patches".into(), self.scene.clone().into()],
            _ => vec![self.map.clone().into()],
        };
        if ["camera", "preview-size"].contains(&name) {
            args.extend(["--preview".into(), self.path("preview.png").into()]);
        }
        args.push(option);
        args
    }
}

fn is_path(arg: &Arg) -> bool {
    arg.get_value_parser().type_id() == std::any::TypeId::of::<PathBuf>()
}

fn joined(name: &str, value: impl AsRef<OsStr>) -> OsString {
    let mut option = OsString::from(format!("--{name}="));
    option.push(value);
    option
}

/// Options that take a value.
fn with_value(paths: bool) -> Vec<Arg> {
    let own = own();
    let wanted =
        |a: &&Arg| a.get_long().is_some() && a.get_action().takes_values() && is_path(a) == paths;
    own.get_arguments().filter(wanted).cloned().collect()
}

#[test]
fn every_value_that_an_option_cannot_use_is_refused_with_its_name() {
    let place = Place::new();
    let options = with_value(false);
    assert!(options.len() >= 18, "{} options", options.len());
    for arg in &options {
        let name = arg.get_long().unwrap();
        for value in BAD.iter().filter(|v| !TAKEN.contains(&(name, **v))) {
            place.refused(&place.args(arg, joined(name, value)), name);
        }
        let garbage = OsString::from_vec(vec![b'1', 0xff, b'2']);
        place.refused(&place.args(arg, joined(name, garbage)), "");
    }
}

#[test]
fn options_without_their_value_and_switches_with_one_are_refused() {
    let place = Place::new();
    let own = own();
    for arg in own.get_arguments().filter(|a| a.get_long().is_some()) {
        let name = arg.get_long().unwrap();
        let optional = arg.get_num_args().is_some_and(|n| n.min_values() == 0);
        if !arg.get_action().takes_values() {
            place.refused(&place.args(arg, joined(name, "1")), name);
        } else if !optional {
            // The last argument: nothing follows.
            let args = place.args(arg, format!("--{name}").into());
            let before = place.contents();
            let output = qrad().args(&args).current_dir(place.folder.path()).output().unwrap();
            assert_eq!(output.status.code(), Some(2), "--{name}");
            assert!(String::from_utf8_lossy(&output.stderr).contains(name), "--{name}");
            assert!(place.contents() == before, "--{name}");
        }
    }
}

#[test]
fn every_path_that_cannot_be_used_is_refused() {
    let place = Place::new();
    let options = with_value(true);
    assert!(options.len() >= 6, "{} options", options.len());
    for arg in &options {
        let name = arg.get_long().unwrap();
        let mut bad: Vec<PathBuf> =
            vec!["".into(), place.path("folder"), place.path("map.bsp/in-a-file")];
        match name {
            // A folder that is searched need not be there.
            "path" => continue,
            "dump-lightmaps" | "cache" | "sweep" => {
                bad = vec![place.map.clone(), bad[2].clone(), "/proc/nowhere".into()];
            }
            "output" | "preview" => {
                bad.extend([place.path("no/folder/file"), "/proc/nowhere".into()]);
            }
            _ => bad.push(place.path("missing")),
        }
        for path in bad {
            place.refused(&place.args(arg, joined(name, &path)), "");
        }
    }
}

#[test]
fn outputs_that_are_inputs_of_the_run_are_refused() {
    let place = Place::new();
    let wad = place.path("some.wad");
    std::fs::write(&wad, b"WAD2\0\0\0\0\x0c\0\0\0").unwrap();
    let rad = place.path("some.rad");
    std::fs::write(&rad, "lamp 255 255 255 300\n").unwrap();
    let map = || OsString::from(&place.map);
    let opt = |name: &str, path: &Path| joined(name, path);
    let other = place.path("other.bsp");
    std::fs::copy(&place.map, &other).unwrap();
    for args in [
        vec![map(), opt("wad", &wad), opt("output", &wad)],
        vec![map(), opt("radlights", &rad), opt("output", &rad)],
        vec![map(), opt("wad", &wad), opt("preview", &wad)],
        vec![map(), opt("preview", &place.map)],
        vec![map(), opt("output", &other), opt("preview", &other)],
        vec![map(), opt("preview", &place.map.with_extension("lit"))],
        vec![map(), opt("output", &place.map.with_extension("lit"))],
        vec![map(), opt("output", &place.map.with_extension("lux")), "--lux".into()],
        vec![opt("patches", &place.scene), opt("output", &place.scene)],
    ] {
        place.refused(&args, "");
    }
}

#[test]
fn paths_that_are_no_text_work() {
    let place = Place::new();
    let name = |end: &[u8]| PathBuf::from(OsString::from_vec([b"m\xff\xfe", end].concat()));
    let map = place.path("").join(name(b".bsp"));
    std::fs::copy(&place.map, &map).unwrap();
    let picture = place.path("").join(name(b".png"));
    let lit = place.path("").join(name(b"-lit.bsp"));
    // Without `.bsp`, too.
    let args = [
        place.path("").join(name(b"")).into(),
        joined("preview", &picture),
        joined("output", &lit),
        "--surflight-dump".into(),
    ];
    let (code, said) = place.run(&args);
    assert!(code == 0 && picture.is_file() && lit.is_file(), "{said}");
    assert!(place.path("").join(name(b"-lit-surflights.map")).is_file());
    let scene = place.path("").join(name(b".txt"));
    std::fs::copy(&place.scene, &scene).unwrap();
    let (code, said) = place.run(&[joined("patches", &scene)]);
    assert!(code == 0, "{said}");
    assert!(place.path("").join(name(b"-lit.txt")).is_file());
}

#[test]
fn values_that_the_reference_s_options_cannot_use_are_refused_or_the_map_is_lit() {
    let place = Place::new();
    let before = std::fs::read(&place.map).unwrap();
    let target = || joined("output", place.path("out.bsp"));
    for option in OPTIONS {
        let name = option.names[0];
        for value in ["", "nan", "inf", "-inf", "1e300", "-1e300", "1e38", "-1e38", "x"] {
            let values = match option.values {
                Values::Vector => vec![value; 3],
                _ => vec![value],
            };
            let given =
                std::iter::once(format!("-{name}")).chain(values.iter().map(|v| (*v).into()));
            let args: Vec<OsString> = [place.map.clone().into(), target()]
                .into_iter()
                .chain(given.map(Into::into))
                .collect();
            let (code, said) = place.run(&args);
            assert!((0..=2).contains(&code), "{args:?}: exit code {code}");
            let told =
                said.lines().any(|l| l.starts_with("error: ") || l.starts_with("qrad: error: "));
            assert!(told == (code != 0), "{args:?}: exit code {code} with {said}");
            let number = matches!(option.values, Values::Number | Values::Vector);
            let none = number && ["", "nan", "inf", "-inf", "1e999", "x"].contains(&value);
            assert!(!none || code != 0, "{args:?} must be refused");
        }
    }
    assert!(std::fs::read(&place.map).unwrap() == before);
}
