//! Pictures of small rooms with known textures and lightmaps set by hand.

mod support;

use glam::{DVec3, Vec3};
use image::RgbImage;
use qrad::bsp::{Bsp, Face, Format, MipTex, Model, PALETTE, parse_entities};
use qrad::render::{Camera, LitMap, start_camera};
use support::map_builder::MapBuilder;

/// Palette index of a dark grey, and its level.
const GREY: u8 = 5;
const GREY_LEVEL: f64 = 75.0;
const SIZE: [u32; 2] = [32, 24];

fn room() -> MapBuilder {
    MapBuilder::room([-64.0; 3], [64.0; 3]).solid_texture("wall", GREY)
}

/// Gives every face lightmaps of these styles; `level` is asked for each style, s and t in luxels.
fn light(bsp: &mut Bsp, styles: &[u8], level: impl Fn(u8, i32, i32) -> u8) {
    for face in 0..bsp.faces.len() {
        let extents = bsp.face_extents(face, 16.0).unwrap();
        bsp.faces[face].light_offset = bsp.lighting.len() as i32;
        bsp.faces[face].styles = [255; 4];
        bsp.faces[face].styles[..styles.len()].copy_from_slice(styles);
        for &style in styles {
            for t in 0..extents.size[1] as i32 {
                for s in 0..extents.size[0] as i32 {
                    let byte = level(style, extents.mins[0] + s, extents.mins[1] + t);
                    bsp.lighting.push(byte);
                }
            }
        }
    }
}

fn lit(builder: &MapBuilder, level: u8) -> Bsp {
    let mut bsp = builder.build(Format::Bsp29);
    light(&mut bsp, &[0], |_, _, _| level);
    bsp
}

fn camera(eye: [f64; 3], pitch: f64, yaw: f64) -> Camera {
    Camera::quake(eye.into(), pitch, yaw, 90.0, SIZE).unwrap()
}

fn draw(bsp: &Bsp, camera: &Camera) -> RgbImage {
    LitMap::new(bsp, None, &[]).unwrap().draw(camera)
}

/// Level in the middle of a picture of greys, seen from the middle of the room along +x.
fn grey(bsp: &Bsp) -> u8 {
    middle(&draw(bsp, &camera([0.0; 3], 0.0, 0.0)))
}

fn middle(image: &RgbImage) -> u8 {
    let [r, g, b] = image.get_pixel(SIZE[0] / 2, SIZE[1] / 2).0;
    assert!(r == g && g == b, "not grey: {r} {g} {b}");
    r
}

#[test]
fn brightness_is_texel_times_light_and_at_most_doubles() {
    for level in [0_u8, 1, 20, 64, 100, 123] {
        let engine = GREY_LEVEL * f64::from(level) * 264.0 / 256.0 / 128.0;
        let seen = f64::from(grey(&lit(&room(), level)));
        assert!((seen - engine).abs() <= 1.0, "level {level}: {seen} instead of {engine}");
    }
    // 247 x 264 / 256 is 254.7: the last below the cap.
    assert_eq!([247, 248, 255].map(|level| grey(&lit(&room(), level))), [149, 150, 150]);
    let white = MapBuilder::room([-64.0; 3], [64.0; 3]).solid_texture("wall", 15);
    assert_eq!(grey(&lit(&white, 200)), 255);
}

#[test]
fn styles_add_up() {
    let seen = |styles: &[u8]| {
        let mut bsp = room().build(Format::Bsp2);
        light(&mut bsp, styles, |style, _, _| if style == 0 { 40 } else { 30 });
        grey(&bsp)
    };
    // (40 + 30) x 264 / 256 = 72 and 41, times 75 x 2 / 255.
    assert_eq!((seen(&[0, 32]), seen(&[0])), (42, 24));
    // Style 4 is half as bright as a steady light on average, style 63 always dark.
    assert_eq!((seen(&[4]), seen(&[63])), (9, 0));
}

#[test]
fn light_is_linear_between_luxels_at_multiples_of_16() {
    let mut bsp = room().build(Format::Bsp29);
    // On the wall at x = 64, s is y and t is -z.
    light(&mut bsp, &[32], |_, s, t| (100 + 10 * s + 5 * t) as u8);
    let camera = camera([0.0; 3], 0.0, 0.0);
    let image = draw(&bsp, &camera);
    for (x, y) in [(16, 12), (3, 2), (30, 20), (5, 21)] {
        let ray = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let (s, t) = (-ray.x * 64.0 / 16.0, -ray.y * 64.0 / 16.0);
        let engine = GREY_LEVEL * (100.0 + 10.0 * s + 5.0 * t) * 264.0 / 256.0 / 128.0;
        let seen = f64::from(image.get_pixel(x, y).0[0]);
        assert!((seen - engine).abs() <= 1.0, "pixel {x} {y}: {seen} instead of {engine}");
    }
}

#[test]
fn colours_come_from_the_lit_file() {
    let bsp = lit(&room(), 77);
    let rgb: Vec<u8> = bsp.lighting.iter().flat_map(|_| [100, 50, 0]).collect();
    let map = LitMap::new(&bsp, Some(&rgb), &[]).unwrap();
    let image = map.draw(&camera([0.0; 3], 0.0, 0.0));
    assert_eq!(image.get_pixel(16, 12).0, [61, 30, 0]);
    let problem = LitMap::new(&bsp, Some(&rgb[3..]), &[]).err().unwrap().to_string();
    assert!(problem.contains(".lit") && !problem.contains('\n'), "{problem}");
}

#[test]
fn fences_have_holes() {
    let behind = |name: &str, index: u8| {
        let pillar = room().texture(name, 16, 16, vec![index; 256]);
        let pillar = pillar.pillar([32.0, -16.0, -16.0], [48.0, 16.0, 16.0], 1);
        draw(&lit(&pillar, 62), &camera([0.0; 3], 0.0, 0.0)).get_pixel(16, 12).0
    };
    // Light 63 of 127.5.
    let wall = [37; 3];
    assert_eq!(behind("{grate", 255), wall);
    assert_eq!(behind("{grate", 15), [116; 3]);
    assert_eq!(behind("grate", 255), PALETTE[255], "index 255 glows in what is no fence");
    assert_eq!(behind("skip", 15), wall);
    assert_eq!(behind("HINTskip", 15), wall);
}

#[test]
fn backs_are_not_drawn() {
    let builder = room().solid_texture("far", 15).room_textures([0, 1, 0, 0, 0, 0]);
    let from = |x: f64| middle(&draw(&lit(&builder, 62), &camera([x, 0.0, 0.0], 0.0, 0.0)));
    let far = from(0.0);
    assert_eq!(far, 116);
    assert_eq!(from(-200.0), far, "through the back of the near wall");
    assert_eq!(from(200.0), 0, "nothing out there");
}

#[test]
fn special_faces_are_unlit_and_faces_without_lightmaps_dark() {
    let unlit = |builder: MapBuilder| {
        let mut bsp = lit(&builder, 62);
        for face in &mut bsp.faces {
            (face.light_offset, face.styles) = (-1, [255; 4]);
        }
        grey(&bsp)
    };
    assert_eq!(unlit(room()), 0);
    assert_eq!(unlit(room().flags(1)), 75);
    let liquid = || MapBuilder::room([-64.0; 3], [64.0; 3]).solid_texture("*water", GREY);
    assert_eq!(unlit(liquid()), 75);
    assert_eq!(grey(&lit(&liquid(), 62)), 37);
    // Engines show maps that were never lit in full light.
    assert_eq!(grey(&room().build(Format::Bsp29)), 150);
}

/// A room with a brush model of white texture between the eye and the wall.
fn with_model(entity: &str) -> Bsp {
    let builder =
        room().solid_texture("white", 15).pillar([32.0, -16.0, -16.0], [48.0, 16.0, 16.0], 1);
    let text = format!("{{ \"classname\" \"worldspawn\" }}\n{{ \"model\" \"*1\" {entity} }}");
    let mut bsp = lit(&builder.entities(text), 62);
    let world = &mut bsp.models[0];
    let model = Model { first_face: 6, face_count: world.face_count - 6, ..*world };
    world.face_count = 6;
    bsp.models.push(model);
    bsp
}

#[test]
fn brush_models_follow_their_entities() {
    let (wall, white) = (37, 116);
    let seen = |entity: &str| grey(&with_model(entity));
    assert_eq!(seen(r#""classname" "func_wall""#), white);
    assert_eq!(seen(r#""classname" "trigger_once""#), wall);
    assert_eq!(seen(r#""classname" "func_wall" "origin" "0 40 0""#), wall);
    assert_eq!(seen(r#""classname" "func_door" "origin" "8 2 0""#), white);
    assert_eq!(seen(r#""classname" "func_wall" "spawnflags" "1792""#), wall);
    // A quarter of the white and three quarters of the wall behind.
    assert_eq!(seen(r#""classname" "func_wall" "alpha" "0.25""#), 57);
    assert_eq!(seen(r#""classname" "func_wall" "alpha" "x" "origin" "nan 0 0""#), white);
}

#[test]
fn absent_textures_are_replaced_whatever_the_case() {
    let mut bsp = lit(&room(), 62);
    bsp.textures[0].as_mut().unwrap().pixels = None;
    let missing = MipTex { name: "WALL".into(), width: 8, height: 8, pixels: Some(vec![15; 64]) };
    let camera = camera([0.0; 3], 0.0, 0.0);
    let draw = |missing: &[MipTex]| LitMap::new(&bsp, None, missing).unwrap().draw(&camera);
    assert_eq!(middle(&draw(std::slice::from_ref(&missing))), 116);
    let checker = middle(&draw(&[]));
    assert!((40..70).contains(&checker), "{checker}");
    bsp.textures[0] = None;
    assert!((40..70).contains(&grey(&bsp)));
}

#[test]
fn damaged_lighting_is_black_and_never_panics() {
    let good = lit(&room(), 62);
    let wall = (0..6).find(|&face| good.face_plane(face).normal == -Vec3::X).unwrap();
    let with = |change: &dyn Fn(&mut Face)| {
        let mut bsp = good.clone();
        change(&mut bsp.faces[wall]);
        grey(&bsp)
    };
    let held = good.lighting.len() as i32;
    let last = held - 81; // 9 x 9 luxels.
    assert_eq!(with(&|face| face.light_offset = last), 37);
    for offset in [last + 1, held - 1, held, i32::MAX, i32::MIN, -2] {
        assert_eq!(with(&|face| face.light_offset = offset), 0, "{offset}");
    }
    assert_eq!(
        with(&|face| {
            face.light_offset = last;
            face.styles = [0, 1, 2, 3];
        }),
        0
    );
    let mut bsp = good.clone();
    for scale in [f32::NAN, f32::INFINITY, 1e30, 0.0] {
        for texinfo in &mut bsp.texinfos {
            texinfo.s *= scale;
        }
        grey(&bsp);
    }
    bsp.texinfos.clear();
    assert_eq!(grey(&bsp), 0);
}

#[test]
fn fog_of_the_worldspawn_hides_what_is_far() {
    let builder = room().entities(r#"{ "classname" "worldspawn" "fog" "1 1 1 1" }"#);
    // exp(-1) of 37 at 64 units, the rest is white.
    assert_eq!(grey(&lit(&builder, 62)), 175);
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads() {
    let builder = MapBuilder::room([-64.0; 3], [64.0; 3])
        .random_texture("wall", 3)
        .solid_texture("{bars", 255)
        .pillar([20.0, -30.0, -40.0], [30.0, 30.0, 10.0], 1);
    let map = LitMap::new(&lit(&builder, 90), None, &[]).unwrap();
    let camera = camera([-30.0, 5.0, 2.0], 10.0, 20.0);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| map.draw(&camera))
    };
    assert_eq!(with(1), with(5));
}

#[test]
fn the_default_camera_is_the_players() {
    let text = r#"{ "classname" "worldspawn" }
        { "classname" "info_player_start" "origin" "-32 0 -22" "angle" "0" }"#;
    let bsp = lit(&room().entities(text), 62);
    let (eye, pitch, yaw) = start_camera(&parse_entities(&bsp.entities).unwrap()).unwrap();
    assert_eq!((eye, pitch, yaw), (Vec3::new(-32.0, 0.0, 0.0), 0.0, 0.0));
    let lifted = MapBuilder::room([0.0; 3], [64.0, 128.0, 32.0]).solid_texture("wall", GREY);
    let map = LitMap::new(&lit(&lifted, 62), None, &[]).unwrap();
    assert_eq!(map.middle().as_dvec3(), DVec3::new(32.0, 64.0, 16.0));
}
