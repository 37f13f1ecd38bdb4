//! `draw_patches`, run as a program, and the drawing it is made of.

use assert_cmd::Command;
use glam::DVec3;
use image::{Rgb, RgbImage};
use proptest::prelude::*;
use qrad::patch::{CameraSpec, PatchEffects, Quad, TextScene};
use qrad::render::{Camera, draw_patches};
use std::path::Path;

/// Two unit squares side by side at z = 0, facing the camera that stands 1 before them; with a
/// field of view of 90 degrees the picture spans x and y from -1 to 1. Seen along +z with y up, +x
/// is to the left.
const HEADER: &str = "0 0 -1 0 0 0 0 1 0\n8 8 64 64 10\n";
const LEFT: &str = "0 0 0 0 1 0 1 1 0 1 0 0 0 0 -1\n";
const RIGHT: &str = "-1 0 0 -1 1 0 0 1 0 0 0 0 0 0 -1\n";

fn program() -> Command {
    let mut command = Command::cargo_bin("draw_patches").unwrap();
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("RUST_LOG");
    command
}

/// Runs the program on `scene` with `-o` and reads the picture back.
fn drawn(scene: &str, options: &[&str]) -> RgbImage {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("s.txt"), folder.path().join("s.png"));
    std::fs::write(&input, scene).unwrap();
    let run = program().arg(&input).arg("-o").arg(&output).args(options).assert().success();
    assert!(run.get_output().stdout.is_empty() && run.get_output().stderr.is_empty());
    let files = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(files, 2, "no temporary file stays behind");
    image::open(output).unwrap().into_rgb8()
}

#[track_caller]
fn halves(picture: &RgbImage, left: [u8; 3], right: [u8; 3]) {
    let (w, h) = picture.dimensions();
    for (x, y, pixel) in picture.enumerate_pixels() {
        let expected = match (y < h / 2, x < w / 2) {
            (false, _) => [0; 3],
            (true, true) => left,
            (true, false) => right,
        };
        assert_eq!(*pixel, Rgb(expected), "pixel {x}, {y}");
    }
}

#[test]
fn raw_scenes_are_drawn_at_full_brightness() {
    let scene = format!("{HEADER}{LEFT}0 0 0 1 0.5 0\n{RIGHT}0.5 0.2 0 0.8 0.2 0.001\n");
    let picture = drawn(&scene, &["--fov", "90"]);
    assert_eq!(picture.dimensions(), (8, 8));
    halves(&picture, [255, 128, 0], [255, 102, 0]);
    let smaller = drawn(&scene, &["--fov", "90", "--size", "6x4"]);
    assert_eq!(smaller.dimensions(), (6, 4));
}

#[test]
fn lit_scenes_are_drawn_as_they_are_lit() {
    let scene = format!("{HEADER}{LEFT}0 0 0 0.8 0.8 0.8\n{RIGHT}0 0 0 0.8 0.8 0.8\n");
    let scene = TextScene::parse(&scene, "s").unwrap();
    let lit = scene.lit(&[[2.5, 0.4, 0.0], [0.0, 0.2, 1.0]]);
    halves(&drawn(&lit.to_text(), &["--fov", "90"]), [255, 102, 0], [0, 51, 255]);
    let brighter = drawn(&lit.to_text(), &["--fov", "90", "--exposure", "2"]);
    halves(&brighter, [255, 204, 0], [0, 102, 255]);
}

#[test]
fn backs_are_black_and_hide_what_is_behind() {
    // In front of the left square, one that shows its back.
    let back = "0 0 -0.1 1 0 -0.1 1 1 -0.1 0 1 -0.1 0 0 1\n";
    for order in [[LEFT, back], [back, LEFT]] {
        let scene = format!(
            "{HEADER}{}0 0 0 1 1 1\n{}0 0 0 1 1 1\n{RIGHT}0 0 0 0 1 0\n",
            order[0], order[1]
        );
        let picture = drawn(&scene, &["--fov", "90"]);
        halves(&picture, [0, 0, 0], [0, 255, 0]);
    }
}

#[test]
fn the_cornell_box_has_red_on_the_left_and_no_gaps() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/cornell/cornell.txt");
    let scene = TextScene::parse_lit(&std::fs::read_to_string(path).unwrap(), "c").unwrap();
    let camera = Camera::look_at(&scene.camera, Camera::TEXT_SCENE_FOV, [200, 200]).unwrap();
    let picture = draw_patches(&scene.patches, &camera, 1.0).unwrap();
    let [left, right] = [picture.get_pixel(12, 100).0, picture.get_pixel(187, 100).0];
    assert!(left[0] > 2 * left[1], "red: {left:?}");
    assert!(right[1] > 2 * right[0], "green: {right:?}");
    assert_eq!(picture.get_pixel(1, 100).0, [0; 3], "the box ends before the picture does");
    // Every pixel within the box's front opening meets one of its patches.
    for (x, y, pixel) in picture.enumerate_pixels() {
        if (10..190).contains(&x) && (10..190).contains(&y) {
            assert_ne!(pixel.0, [0; 3], "gap at {x}, {y}");
        }
    }
}

#[test]
fn failures_are_one_line_and_exit_code_1() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.txt");
    let fails = |arguments: &[&str], words: &str| {
        let run = program().current_dir(folder.path()).args(arguments).assert().code(1);
        let error = String::from_utf8(run.get_output().stderr.clone()).unwrap();
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(error.starts_with("draw_patches: ") && error.contains(words), "{error}");
    };
    fails(&["absent.txt"], "cannot read absent.txt");
    std::fs::write(&scene, "1 2 3\n").unwrap();
    fails(&["scene.txt", "-o", "a.png"], "scene.txt: line 1: 3 numbers");
    std::fs::write(&scene, format!("{HEADER}{LEFT}0 0 0 1 1 1\n")).unwrap();
    fails(&["scene.txt"], "use -o picture.png to write a picture instead");
    fails(&["scene.txt", "-o", "no/such/folder.png"], "the folder does not exist");
    fails(&["scene.txt", "-o", "."], "cannot write");
    fails(&["scene.txt", "-o", "a.png", "--fov", "180"], "fov");
    fails(&["scene.txt", "-o", "a.png", "--size", "16384x16384"], "--size");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left behind");
}

#[test]
fn repairs_are_named_on_standard_error() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("s.txt"),
        format!("{HEADER}{LEFT}0 0 0 1 1 1\n0 0 0 1 0 0 1 1 0 0 1 0 0 0 -2\n0 0 0 1 1 1\n"),
    )
    .unwrap();
    let run =
        program().current_dir(folder.path()).args(["s.txt", "-o", "s.png"]).assert().success();
    let said = String::from_utf8(run.get_output().stderr.clone()).unwrap();
    assert_eq!(said.matches("s.txt: line 5: ").count(), 2, "{said}");
}

#[cfg(unix)]
#[test]
fn pictures_are_readable_by_others() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.png");
    qrad::output::write_png(&path, &RgbImage::new(2, 2)).unwrap();
    assert_eq!(std::fs::metadata(path).unwrap().permissions().mode() & 0o777, 0o644);
}

/// The first point that a ray from the eye meets, found without drawing.
fn hit(quads: &[Quad], eye: DVec3, direction: DVec3) -> Option<usize> {
    let distance = |quad: &Quad| {
        let v = quad.vertices;
        let n = quad.unit_normal();
        let t = n.dot(v[0] - eye) / n.dot(direction);
        let point = eye + direction * t;
        let inside = (0..4).all(|i| n.dot((v[(i + 1) % 4] - v[i]).cross(point - v[i])) >= 0.0);
        (t > 0.0 && inside).then_some(t)
    };
    (0..quads.len())
        .filter_map(|i| distance(&quads[i]).map(|t| (i, t)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(i, _)| i)
}

proptest! {
    /// Quads around, behind and across the eye's plane: each pixel shows what its ray meets.
    #[test]
    fn pictures_agree_with_rays(
        shapes in prop::collection::vec(
            (prop::array::uniform3(-3.0..3.0f64), prop::array::uniform3(-4.0..4.0f64),
             prop::array::uniform3(-4.0..4.0f64)),
            1..6,
        ),
        yaw in -180.0..180.0f64,
    ) {
        let quads: Vec<Quad> = shapes
            .into_iter()
            .map(|(origin, u, v)| {
                let [origin, u, v] = [origin, u, v].map(DVec3::from_array);
                let vertices = [origin, origin + u, origin + u + v, origin + v];
                Quad { vertices, normal: DVec3::ZERO, exitance: [0.0; 3], reflectance: [0.0; 3], effects: PatchEffects::default() }
            })
            .filter(|quad| {
                let v = quad.vertices;
                (v[1] - v[0]).cross(v[3] - v[0]).length() > 0.1
            })
            .enumerate()
            .map(|(i, quad)| Quad {
                normal: quad.unit_normal(),
                reflectance: [(i + 1) as f64 * 20.0 / 255.0, 0.0, 0.0],
                ..quad
            })
            .collect();
        let eye = DVec3::new(0.1, 0.2, 0.3);
        let camera = Camera::quake(eye, 10.0, yaw, 90.0, [16, 12]).unwrap();
        let picture = draw_patches(&quads, &camera, 1.0).unwrap();
        let mut wrong = 0;
        for (x, y, pixel) in picture.enumerate_pixels() {
            let ray = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let direction = camera.right * ray.x + camera.up * ray.y + camera.forward * ray.z;
            let expected = hit(&quads, eye, direction).map_or(0, |i| {
                let lit_side = quads[i].unit_normal().dot(direction) < 0.0;
                if lit_side { (i as u8 + 1) * 20 } else { 0 }
            });
            wrong += usize::from(pixel.0[0] != expected);
        }
        prop_assert_eq!(wrong, 0);
    }

    /// Whatever the reader lets through can be drawn.
    #[test]
    fn drawing_never_panics(numbers in prop::array::uniform12(prop_oneof![
        -1e12..1e12f64, -1.0..1.0f64, Just(0.0), Just(1e-300)])) {
        let vertices = std::array::from_fn(|i| DVec3::from_slice(&numbers[3 * i..]));
        let quad = Quad { vertices, normal: DVec3::Z, exitance: [0.0; 3], reflectance: [1.0; 3], effects: PatchEffects::default() };
        let spec = CameraSpec { position: DVec3::ZERO, look_at: DVec3::X, up: DVec3::Z };
        let camera = Camera::look_at(&spec, 40.0, [9, 7]).unwrap();
        prop_assert!(draw_patches(&[quad], &camera, 1.0).is_ok());
    }
}
