//! Form factors kept from one run to the next: a relight skips them and gives the same bytes.

mod support;

use assert_cmd::Command;
use qrad::bsp::Bsp;
use std::path::{Path, PathBuf};

struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::copy(support::maps_dir().join("styles.bsp"), folder.path().join("map.bsp"))
            .unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Lights the map into another file; returns that and what was printed.
    fn light(&self, options: &[&str]) -> (Vec<u8>, String) {
        let out = self.path("out.bsp");
        let mut command = Command::cargo_bin("qrad").unwrap();
        command.arg(self.path("map.bsp")).arg("-o").arg(&out).args(options);
        let run = command.assert().success();
        let output = run.get_output();
        let said = [&output.stdout[..], &output.stderr[..]].concat();
        (std::fs::read(&out).unwrap(), String::from_utf8(said).unwrap())
    }

    fn cached(&self, more: &[&str]) -> (Vec<u8>, String) {
        let cache = self.path("cache");
        self.light(&[&["--cache", cache.to_str().unwrap()], more].concat())
    }

    fn files(&self) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(self.path("cache")).unwrap();
        let mut files: Vec<_> = entries.map(|e| e.unwrap().path()).collect();
        files.sort();
        files
    }

    fn edit(&self, from: &str, to: &str) {
        let path = self.path("map.bsp");
        let mut bsp = Bsp::read(&std::fs::read(&path).unwrap()).unwrap();
        let text = String::from_utf8(bsp.entities.clone()).unwrap();
        assert!(text.contains(from), "{text}");
        bsp.entities = text.replace(from, to).into_bytes();
        std::fs::write(&path, bsp.write().unwrap()).unwrap();
    }
}

/// Hemicubes drawn at patches, from the table.
fn drawn(said: &str) -> u64 {
    let line = said.lines().find(|l| l.starts_with("patch hemicubes")).unwrap();
    line["patch hemicubes".len()..].replace(' ', "").parse().unwrap()
}

fn first_origin(map: &Path) -> String {
    let bsp = Bsp::read(&std::fs::read(map).unwrap()).unwrap();
    let text = String::from_utf8(bsp.entities).unwrap();
    let entity =
        text.split('{').find(|e| e.contains("\"light\"") && e.contains("\"origin\"")).unwrap();
    entity.lines().find(|l| l.starts_with("\"origin\"")).unwrap().to_owned()
}

#[test]
fn a_relight_draws_no_hemicube_and_gives_the_bytes_of_a_cold_run() {
    let place = Place::new();
    let (first, said) = place.cached(&[]);
    assert!(drawn(&said) > 100, "{said}");
    assert_eq!(place.files().len(), 1);
    assert!(place.light(&[]).0 == first);

    let origin = first_origin(&place.path("map.bsp"));
    place.edit(&origin, "\"origin\" \"11 -7 70\"\n\"_color\" \"1 0.2 0.1\"");
    let (cold, said) = place.light(&[]);
    assert!(drawn(&said) > 100 && cold != first);
    for threads in ["1", "2"] {
        let (again, said) = place.cached(&["--threads", threads]);
        assert_eq!(drawn(&said), 0, "{said}");
        assert!(again == cold);
    }
    assert_eq!(place.files().len(), 1);
}

#[test]
fn other_hemicubes_and_patches_are_kept_apart() {
    let place = Place::new();
    place.cached(&[]);
    for (n, option) in [["--hemicube", "20"], ["--patch-size", "3"]].iter().enumerate() {
        let (lit, said) = place.cached(option);
        assert!(drawn(&said) > 100, "{said}");
        assert_eq!(place.files().len(), n + 2);
        let (again, said) = place.cached(option);
        assert!(drawn(&said) == 0 && lit == again && lit == place.light(option).0);
    }
}

#[test]
fn other_geometry_is_not_mixed_up() {
    let place = Place::new();
    let (before, _) = place.cached(&[]);
    let path = place.path("map.bsp");
    let mut bytes = std::fs::read(&path).unwrap();
    // Lump 3 are the vertices, three numbers each.
    let number =
        |bytes: &[u8], at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let [from, size] = [28, 32].map(|at| number(&bytes, at) as usize);
    for at in (from..from + size).step_by(12) {
        let x = f32::from_bits(number(&bytes, at)) * 1.01;
        bytes[at..at + 4].copy_from_slice(&x.to_le_bytes());
    }
    std::fs::write(&path, bytes).unwrap();
    let (after, said) = place.cached(&[]);
    assert!(drawn(&said) > 100, "{said}");
    assert!(before != after && after == place.light(&[]).0);
}

#[test]
fn damaged_files_are_noticed_and_replaced() {
    let place = Place::new();
    let (want, _) = place.cached(&[]);
    let file = place.files().remove(0);
    let whole = std::fs::read(&file).unwrap();
    let flipped = |at: usize| {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        bytes
    };
    let cases = [
        Vec::new(),
        whole[..whole.len() - 1].to_vec(),
        [&whole[..], b"x"].concat(),
        flipped(3),
        flipped(20),
        flipped(60),
        flipped(whole.len() - 2),
        flipped(whole.len() / 2),
    ];
    for (n, damaged) in cases.into_iter().enumerate() {
        std::fs::write(&file, damaged).unwrap();
        let (lit, said) = place.cached(&[]);
        assert!(said.contains("damaged; its transfers are made again"), "{n}: {said}");
        assert!(drawn(&said) > 100 && lit == want, "{n}");
        assert!(std::fs::read(&file).unwrap() == whole, "{n}");
    }
}

#[test]
fn a_cache_that_cannot_be_written_is_refused_at_once() {
    let place = Place::new();
    let map = place.path("map.bsp");
    let run = Command::cargo_bin("qrad")
        .unwrap()
        .args([map.as_os_str(), "--cache".as_ref(), map.as_os_str()])
        .assert()
        .failure();
    let said = String::from_utf8(run.get_output().stderr.clone()).unwrap();
    assert!(said.contains("make folder") && said.lines().count() == 1, "{said}");
}
