//! The text scene format: what it keeps, repairs and refuses.

mod support;

use glam::DVec3;
use proptest::prelude::*;
use qrad::patch::{
    CameraSpec, MAX_REFLECTANCE, PatchEffects, Quad, Reading, Repair, TextScene, decode,
};
use std::path::{Path, PathBuf};

const CAMERA: &str = "278 273 -800 278 273 0 0 1 0";
const SIZES: &str = "256 128 64 32 100";
const QUAD: &str = "0 0 0 2 0 0 2 1 0 0 1 0 0 0 1";
const LIGHT: &str = "0 0.25 1 0.8 0.1 0";

fn scene_of(lines: &[&str]) -> String {
    lines.join("\n") + "\n"
}

fn repaired(lines: &[&str]) -> (TextScene, Vec<Repair>) {
    TextScene::parse_repaired(&scene_of(lines), "s.txt", Reading::Raw).unwrap()
}

#[track_caller]
fn refused(lines: &[&str], line: usize, words: &str) {
    let message = TextScene::parse(&scene_of(lines), "s.txt").unwrap_err().to_string();
    assert!(message.starts_with(&format!("s.txt: line {line}: ")), "{message}");
    assert!(message.contains(words), "{message}");
    assert!(!message.contains('\n'), "{message}");
}

#[track_caller]
fn quad_refused(quad: &str, words: &str) {
    refused(&[CAMERA, SIZES, QUAD, LIGHT, quad, LIGHT], 5, words);
}

/// The shared test scenes, or nothing (said once) where they are absent.
fn shared_scenes() -> Vec<PathBuf> {
    let Some(shared) = support::shared_dir() else { return Vec::new() };
    let paths = std::fs::read_dir(shared.join("scenes")).unwrap().map(|e| e.unwrap().path());
    paths.filter(|p| p.extension().is_some_and(|e| e == "txt")).collect()
}

#[test]
fn every_value_lands_in_its_place() {
    let (scene, repairs) = repaired(&[CAMERA, SIZES, QUAD, LIGHT]);
    assert_eq!(repairs, []);
    assert_eq!(scene.camera.position, DVec3::new(278.0, 273.0, -800.0));
    assert_eq!(scene.camera.look_at, DVec3::new(278.0, 273.0, 0.0));
    assert_eq!(scene.camera.up, DVec3::Y);
    assert_eq!((scene.image, scene.hemicube, scene.passes), ([256, 128], [64, 32], 100));
    let [quad] = scene.patches[..] else { panic!("one patch") };
    assert_eq!(quad.vertices[2], DVec3::new(2.0, 1.0, 0.0));
    assert_eq!((quad.normal, quad.unit_normal()), (DVec3::Z, DVec3::Z));
    assert_eq!((quad.exitance, quad.reflectance), ([0.0, 0.25, 1.0], [0.8, 0.1, 0.0]));
}

#[test]
fn blank_lines_comments_and_line_ends_of_any_kind_are_tolerated() {
    let plain = scene_of(&[CAMERA, SIZES, QUAD, LIGHT]);
    let loose =
        format!("\u{feff}# a scene\r\n\r\n\t{CAMERA} # eye\r\n{SIZES}\r\n \r\n{QUAD}\r\n{LIGHT}");
    let read = |text: &str| TextScene::parse(decode(text.as_bytes(), "s").unwrap(), "s").unwrap();
    assert_eq!(read(&plain), read(&loose));
    // Lines are counted as an editor does.
    refused(&["# a scene", "", CAMERA, "", "1 2"], 5, "2 numbers where 5 are expected");
}

#[test]
fn what_is_safe_to_repair_is_repaired_and_named() {
    let long = "0 0 0 2 0 0 2 1 0 0 1 0 0 0 5";
    let clockwise = "0 0 0 0 1 0 2 1 0 2 0 0 0 0 1";
    let (scene, repairs) = repaired(&[CAMERA, SIZES, long, LIGHT, clockwise, LIGHT, QUAD, LIGHT]);
    assert_eq!(repairs.iter().map(|r| r.line).collect::<Vec<_>>(), [3, 5]);
    assert!(repairs[0].what.contains("length is 5"), "{repairs:?}");
    assert!(repairs[1].what.contains("clockwise"), "{repairs:?}");
    for quad in &scene.patches {
        assert_eq!(quad.normal, DVec3::Z);
        assert_eq!(quad.unit_normal(), DVec3::Z, "the winding follows the normal");
    }
}

#[test]
fn light_that_nothing_absorbs_is_made_to_settle() {
    let (scene, repairs) =
        repaired(&[CAMERA, SIZES, QUAD, "0 0 0 1 1 0.99995", QUAD, "1 1 1 1 0 1"]);
    assert_eq!(scene.patches[0].reflectance, [MAX_REFLECTANCE, 1.0, MAX_REFLECTANCE]);
    assert_eq!(scene.patches[1].reflectance, [MAX_REFLECTANCE, 0.0, MAX_REFLECTANCE]);
    let [repair] = &repairs[..] else { panic!("one repair: {repairs:?}") };
    assert!(repair.what.contains("absorbs red, blue light"), "{repair:?}");
    // A perfect reflector is fine where something absorbs.
    let (scene, repairs) = repaired(&[CAMERA, SIZES, QUAD, "0 0 0 1 1 1", QUAD, "1 1 1 0 0 0"]);
    assert_eq!((scene.patches[0].reflectance, repairs), ([1.0; 3], vec![]));
}

#[test]
fn headers_that_cannot_be_used_are_refused() {
    refused(&[], 2, "the file ends where the camera's");
    refused(&["1 2 3", SIZES, QUAD, LIGHT], 1, "3 numbers where 9 are expected");
    refused(&["1 2 3 1 2 3 0 1 0", SIZES, QUAD, LIGHT], 1, "looks at its own position");
    refused(&["0 0 0 0 5 0 0 1 0", SIZES, QUAD, LIGHT], 1, "lies along its view");
    refused(&["0 0 0 0 5 0 0 0 0", SIZES, QUAD, LIGHT], 1, "is zero or lies along");
    refused(&["0 0 nan 0 5 0 0 0 1", SIZES, QUAD, LIGHT], 1, "\"nan\" is not a finite number");
    refused(&[CAMERA], 2, "the file ends where image size");
    refused(&[CAMERA, "256 256 256 256", QUAD, LIGHT], 2, "4 numbers where 5 are expected");
    refused(&[CAMERA, "0 256 256 256 1", QUAD, LIGHT], 2, "image size 0 x 256");
    refused(&[CAMERA, "256 16385 256 256 1", QUAD, LIGHT], 2, "from 1 to 16384");
    refused(&[CAMERA, "256 256 255 256 1", QUAD, LIGHT], 2, "hemicube size 255 x 256");
    refused(&[CAMERA, "256 256 256 0 1", QUAD, LIGHT], 2, "even, from 2 to 4096");
    refused(&[CAMERA, "256 256 4098 256 1", QUAD, LIGHT], 2, "even, from 2 to 4096");
    refused(&[CAMERA, "256 256 256 256 -1", QUAD, LIGHT], 2, "\"-1\" is not a whole number");
    refused(&[CAMERA, "256 256 256 256 1.5", QUAD, LIGHT], 2, "\"1.5\" is not a whole number");
    assert_eq!(repaired(&[CAMERA, "1 1 2 2 0", QUAD, LIGHT]).0.passes, 0);
}

#[test]
fn patch_lines_must_be_complete_and_alone() {
    refused(&[CAMERA, SIZES], 3, "the first patch");
    refused(&[CAMERA, SIZES, QUAD], 4, "exitance and reflectance of patch 0");
    refused(&[CAMERA, SIZES, QUAD, LIGHT, QUAD], 6, "exitance and reflectance of patch 1");
    refused(&[CAMERA, SIZES, LIGHT, QUAD], 3, "6 numbers where 15 are expected");
    refused(&[CAMERA, SIZES, QUAD, QUAD], 4, "15 numbers where 6 are expected");
    refused(&[CAMERA, SIZES, QUAD, "0 0 0 1 1 1 1"], 4, "7 numbers where 6 are expected");
    refused(&[CAMERA, SIZES, QUAD, LIGHT, "end"], 5, "\"end\" is not a number");
    refused(&[CAMERA, SIZES, QUAD, "0 0 0 0,5 0 0"], 4, "\"0,5\" is not a number");
}

#[test]
fn light_values_out_of_range_are_refused() {
    for bad in ["-0.1 0 0 0 0 0", "0 1.5 0 0 0 0"] {
        refused(&[CAMERA, SIZES, QUAD, bad], 4, "initial exitance");
    }
    refused(&[CAMERA, SIZES, QUAD, "0 0 0 0 -0.1 0"], 4, "reflectance -0.1 is out of range");
    refused(&[CAMERA, SIZES, QUAD, "0 0 0 0 7 0"], 4, "lit already?");
    refused(&[CAMERA, SIZES, QUAD, "0 0 0 inf 0 0"], 4, "\"inf\" is not a finite number");
    refused(&[CAMERA, SIZES, QUAD, "0 0 0 1e999 0 0"], 4, "\"1e999\" is not a finite number");
}

#[test]
fn quads_without_area_are_refused() {
    quad_refused("1 1 1 1 1 1 1 1 1 1 1 1 0 0 1", "has no area");
    quad_refused("0 0 0 1 0 0 2 0 0 3 0 0 0 0 1", "has no area");
    quad_refused("0 0 0 1 1 0 0 0 0 1 1 0 0 0 1", "has no area");
    quad_refused("1e-200 0 0 0 0 0 0 0 0 0 1e-200 0 0 0 1", "has no area");
}

#[test]
fn quads_of_unusable_shape_are_refused() {
    quad_refused("0 0 0 2 0 0 2 1 0.1 0 1 0 0 0 1", "not planar");
    quad_refused("0 0 0 2 0 0 0.5 0.5 0 0 2 0 0 0 1", "not convex");
    quad_refused("0 0 0 2 0 0 0 1 0 2 1 0 0 0 1", "crosses itself");
    quad_refused("0 0 0 4 0 0 1 1 0 3 1.5 0 0 0 1", "crosses itself");
    quad_refused("0 0 0 2 0 0 0 0 0 0 1 0 0 0 1", "crosses itself or folds back");
    quad_refused("0 0 0 2e12 0 0 2e12 1 0 0 1 0 0 0 1", "out of range");
}

#[test]
fn normals_must_match_the_vertices() {
    quad_refused("0 0 0 2 0 0 2 1 0 0 1 0 0 0 0", "normal is zero");
    quad_refused("0 0 0 2 0 0 2 1 0 0 1 0 0 0.6 0.8", "leans 36.9 degrees");
    quad_refused("0 0 0 2 0 0 2 1 0 0 1 0 1 0 0", "leans 90.0 degrees");
    quad_refused("0 0 0 2 0 0 2 1 0 0 1 0 0 0.6 -0.8", "leans 36.9 degrees");
}

#[test]
fn odd_but_usable_quads_pass_unchanged() {
    let triangle = "0 0 0 2 0 0 2 0 0 0 1 0 0 0 1";
    let straight_corner = "0 0 0 1 0 0 2 0 0 0 1 0 0 0 1";
    let sliver = "0 0 0 1000 0 0 1000 1e-3 0 0 1e-3 0 0 0 1";
    let far = "1000000 1000000 7 1000000.5 1000000 7 1000000.5 1000001 7 1000000 1000001 7 0 0 1";
    let rounded_normal = "0 0 0 1 1 0 1 1 1 0 0 1 0.707 -0.707 0";
    for quad in [triangle, straight_corner, sliver, far, rounded_normal] {
        let (scene, repairs) = repaired(&[CAMERA, SIZES, quad, LIGHT]);
        assert_eq!(repairs, [], "{quad}");
        let out = scene.to_text();
        let values = |s: &str| s.split(' ').map(|x| x.parse::<f64>().unwrap()).collect::<Vec<_>>();
        assert_eq!(values(out.lines().nth(2).unwrap()), values(quad));
    }
}

#[test]
fn lit_scenes_carry_exitance_instead_of_reflectance() {
    let (scene, _) = repaired(&[CAMERA, SIZES, QUAD, LIGHT, QUAD, LIGHT]);
    let exitance = [[1.75, 0.1, 3e-9], [0.0, 1e20, 1.0]];
    let lit = scene.lit(&exitance);
    assert_eq!(lit.to_text().lines().nth(3), Some("0 0 0 1.75 0.1 3e-9"));
    for ((patch, original), expected) in lit.patches.iter().zip(&scene.patches).zip(exitance) {
        assert_eq!((patch.exitance, patch.reflectance), ([0.0; 3], expected));
        assert_eq!((patch.vertices, patch.normal), (original.vertices, original.normal));
    }
    assert_eq!(TextScene::parse_lit(&lit.to_text(), "lit").unwrap(), lit);
    // Drawing takes raw scenes too.
    assert_eq!(TextScene::parse_lit(&scene.to_text(), "raw").unwrap(), scene);
    // To be lit again, it is the wrong file.
    assert!(TextScene::parse(&lit.to_text(), "lit").is_err());
    let negative = scene_of(&[CAMERA, SIZES, QUAD, "0 0 0 0 -1 0"]);
    let message = TextScene::parse_lit(&negative, "lit").unwrap_err().to_string();
    assert_eq!(message, "lit: line 4: final exitance -1 is negative");
}

#[test]
#[should_panic(expected = "one exitance a patch")]
fn lit_wants_one_exitance_a_patch() {
    repaired(&[CAMERA, SIZES, QUAD, LIGHT]).0.lit(&[]);
}

#[test]
fn bytes_that_are_no_text_are_refused_with_their_line() {
    let message = decode(b"1 2\n3\xff 4", "s.txt").unwrap_err().to_string();
    assert!(message.starts_with("s.txt: line 2: not text"), "{message}");
}

#[test]
fn scenes_of_the_project_keep_every_value() {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/cornell");
    let own = ["cornell.txt", "cornell_fine.txt", "two_patches.txt"].map(|name| own.join(name));
    for path in own.into_iter().chain(shared_scenes()) {
        let text = std::fs::read_to_string(&path).unwrap();
        let (scene, repairs) = TextScene::parse_repaired(&text, "s", Reading::Raw).unwrap();
        assert_eq!(repairs, [], "{}", path.display());
        let out = scene.to_text();
        let values = |s: &str| {
            s.lines()
                .map(|line| line.split_whitespace().map(|x| x.parse().unwrap()).collect())
                .collect::<Vec<Vec<f64>>>()
        };
        assert_eq!(values(&out), values(&text), "{}", path.display());
        assert_eq!(TextScene::parse(&out, "s").unwrap(), scene);
    }
}

fn direction() -> impl Strategy<Value = DVec3> {
    let component = || -1.0..1.0f64;
    (component(), component(), component())
        .prop_map(|(x, y, z)| DVec3::new(x, y, z))
        .prop_filter("a direction", |v| v.length() > 0.1)
        .prop_map(DVec3::normalize)
}

fn point() -> impl Strategy<Value = DVec3> {
    let component = || -1e5..1e5f64;
    (component(), component(), component()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

fn triple(high: f64) -> impl Strategy<Value = [f64; 3]> {
    [0.0..=high, 0.0..=high, 0.0..=high]
}

/// A trapezoid anywhere, with the normal that its axes give.
fn quad(second_high: f64) -> impl Strategy<Value = Quad> {
    let shape = (direction(), direction(), 0.5..300.0f64, 0.5..300.0f64, 0.2..1.0f64);
    (point(), shape, triple(1.0), triple(second_high))
        .prop_filter("axes apart", |(_, (u, v, ..), ..)| u.cross(*v).length() > 0.1)
        .prop_map(|(origin, (u, v, width, height, top), exitance, reflectance)| {
            let (u_edge, v_edge) = (u * width, v * height);
            let vertices =
                [origin, origin + u_edge, origin + v_edge + u_edge * top, origin + v_edge];
            Quad {
                vertices,
                normal: u.cross(v).normalize(),
                exitance,
                reflectance,
                effects: PatchEffects::default(),
            }
        })
}

fn scene(second_high: f64) -> impl Strategy<Value = TextScene> {
    let camera = (point(), direction(), direction())
        .prop_filter("up off the view", |(_, view, up)| view.cross(*up).length() > 0.1)
        .prop_map(|(position, view, up)| CameraSpec { position, look_at: position + view, up });
    let sizes = ([1..=16384u32, 1..=16384], [1..=2048u32, 1..=2048], any::<u32>());
    (camera, sizes, prop::collection::vec(quad(second_high), 1..6)).prop_map(
        |(camera, (image, half_cube, passes), patches)| TextScene {
            camera,
            image,
            hemicube: half_cube.map(|n| 2 * n),
            passes,
            patches,
        },
    )
}

proptest! {
    #[test]
    fn scenes_round_trip(scene in scene(MAX_REFLECTANCE)) {
        let (back, repairs) =
            TextScene::parse_repaired(&scene.to_text(), "s", Reading::Raw).unwrap();
        prop_assert_eq!(back, scene);
        prop_assert_eq!(repairs, vec![]);
    }

    #[test]
    fn lit_scenes_round_trip(scene in scene(1e9)) {
        prop_assert_eq!(&TextScene::parse_lit(&scene.to_text(), "s").unwrap(), &scene);
    }

    #[test]
    fn any_bytes_give_a_scene_or_one_line(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        if let Err(e) = decode(&bytes, "s").and_then(|text| TextScene::parse(text, "s")) {
            prop_assert!(!e.to_string().contains('\n'));
        }
    }

    /// Numbers of every size in the right places: reaches the geometry checks.
    #[test]
    fn any_numbers_give_a_scene_or_one_line(
        corners in prop::array::uniform15(prop_oneof![
            prop_oneof![Just(0.0), Just(1.0), Just(-1.0), Just(1e-300), Just(1e12)],
            any::<f64>(),
            -2.0..2.0f64,
        ]),
        light in prop::array::uniform6(prop_oneof![any::<f64>(), 0.0..1.0f64]),
    ) {
        let line = |numbers: &[f64]| {
            numbers.iter().map(|x| format!("{x:e}")).collect::<Vec<_>>().join(" ")
        };
        let text = scene_of(&[CAMERA, SIZES, &line(&corners), &line(&light)]);
        match TextScene::parse(&text, "s") {
            Ok(scene) => {
                let quad = scene.patches[0];
                prop_assert!(quad.unit_normal().is_finite());
                prop_assert!(quad.unit_normal().dot(quad.normal) > 0.99);
                prop_assert_eq!(TextScene::parse(&scene.to_text(), "s").unwrap(), scene);
            }
            Err(e) => prop_assert!(!e.to_string().contains('\n')),
        }
    }
}
