//! Lightmaps that show something else than light, each checked by number.

mod support;

use glam::Vec3;
use qrad::bsp::Format;
use qrad::lightmap::DebugView;
use qrad::scene::luxels;
use support::lit_levels::texinfo;
use support::lit_light::{LitLight, settings};
use support::lit_room::{entity, surface_at};
use support::map_builder::MapBuilder;

const LAMP: &[(&str, &str)] = &[("origin", "-100 -60 120")];

fn room() -> MapBuilder {
    MapBuilder::room([-256.0, -256.0, 0.0], [256.0, 256.0, 256.0])
        .solid_texture("wall", 8)
        .solid_texture("block", 8)
        .pillar([-32.0, -32.0, 64.0], [32.0, 32.0, 128.0], 1)
        .entities(entity("worldspawn", &[]) + &entity("light", LAMP))
}

fn view(map: &MapBuilder, view: DebugView) -> LitLight {
    LitLight::new(map, &settings(Some(view)))
}

/// The luxel nearest to a point of the surface there that looks along `normal`.
fn at(lit: &LitLight, point: Vec3, normal: Vec3) -> Vec3 {
    let surface = surface_at(&lit.scene, point, normal);
    let grid = lit.scene.surfaces[surface].luxels.as_ref().unwrap();
    let l = grid.luxel_of(point).round();
    lit.of(surface, 0)[l.y as usize * grid.width as usize + l.x as usize]
}

fn floor(lit: &LitLight, x: f32, y: f32) -> Vec3 {
    at(lit, Vec3::new(x, y, 0.0), Vec3::Z)
}

#[test]
fn dirt_is_white_in_the_open_and_as_dark_in_corners_as_its_rays_say() {
    // Without a key of the map: the view asks for dirt.
    let lit = view(&room(), DebugView::Dirt);
    assert_eq!(floor(&lit, 100.0, 100.0), Vec3::splat(255.0));
    let mut room_left = 0.0;
    for azimuth in (0..16).map(|i| (f64::from(i) * 22.5).to_radians()) {
        for elevation in [0.5, 1.5, 2.5].map(|e| (e * 88.0 / 3.0_f64).to_radians()) {
            let along = elevation.sin() * azimuth.cos();
            room_left +=
                if along > 1e-9 { (16.0 / along).min(128.0) } else { 128.0 } / 128.0 / 48.0;
        }
    }
    let edge = floor(&lit, 240.0, 0.0);
    assert!((edge - Vec3::splat(255.0 * room_left as f32)).length() < 0.01, "{edge} {room_left}");
    assert!(floor(&lit, 240.0, 240.0).x < edge.x);
    let scaled = room().entities(entity("worldspawn", &[("_dirtscale", "2")]));
    let darker = floor(&view(&scaled, DebugView::Dirt), 240.0, 0.0);
    assert!((255.0 - darker.x - 2.0 * (255.0 - edge.x)).abs() < 0.01, "{darker}");
}

#[test]
fn normals_are_colours() {
    let flat = view(&room(), DebugView::Phong);
    assert_eq!(floor(&flat, 100.0, 100.0), Vec3::new(0.0, 0.0, 255.0));
    let top = Vec3::new(-32.0, -32.0, 128.0);
    assert_eq!(at(&flat, top, Vec3::Z), Vec3::new(0.0, 0.0, 255.0));
    assert_eq!(at(&flat, Vec3::new(-256.0, 0.0, 100.0), Vec3::X), Vec3::new(255.0, 0.0, 0.0));
    let keys = texinfo(&room().build(Format::Bsp29), |name| {
        (name == "block").then_some(r#"{"phong_angle": 91}"#)
    });
    let smooth = LitLight::with_texinfo(&room(), &settings(Some(DebugView::Phong)), &keys);
    let corner = at(&smooth, top, Vec3::Z);
    assert!((corner - Vec3::splat(255.0 / 3_f32.sqrt())).length() < 0.2, "{corner}");
    assert_eq!(floor(&smooth, 100.0, 100.0), Vec3::new(0.0, 0.0, 255.0));
}

#[test]
fn samples_in_solid_are_red_and_others_green() {
    let map = room().pillar([64.0, 64.0, 0.0], [192.0, 192.0, 64.0], 0);
    let lit = view(&map, DebugView::Occluded);
    let mut seen = [0, 0];
    for surface in 0..lit.scene.surfaces.len() {
        let samples = luxels::place(&lit.scene, surface, 1);
        for (sample, colour) in samples.iter().zip(lit.of(surface, 0)) {
            assert_eq!(colour, if sample.occluded { Vec3::X } else { Vec3::Y } * 255.0);
            seen[usize::from(sample.occluded)] += 1;
        }
    }
    assert!(seen[0] > 1000 && seen[1] > 10, "{seen:?}");
    assert_eq!(floor(&lit, 128.0, 128.0), Vec3::X * 255.0, "under the pillar");
}

#[test]
fn mottling_is_grey_noise_from_0_to_48() {
    let lit = view(&room(), DebugView::Mottle);
    let all = lit.all(0);
    let values: Vec<f32> = all.iter().map(|c| c.x).collect();
    assert!(all.iter().all(|c| c.x == c.y && c.y == c.z));
    let (min, max) = values.iter().fold((f32::MAX, 0.0_f32), |(a, b), v| (a.min(*v), b.max(*v)));
    assert!((0.0..12.0).contains(&min) && max > 36.0 && max <= 48.0, "{min} {max}");
}

#[test]
fn the_bounce_view_is_light_where_the_lamp_does_not_shine() {
    // The floor under a shelf from wall to wall gets bounced light only.
    let map = room().pillar([-256.0, 64.0, 32.0], [256.0, 256.0, 48.0], 0);
    let none = qrad::settings::Settings { bounces: Some(0), ..settings(None) };
    let direct = LitLight::new(&map, &none);
    let bounced = view(&map, DebugView::Bounce);
    let whole = LitLight::new(&map, &settings(None));
    assert_eq!(floor(&direct, 0.0, 240.0), Vec3::ZERO);
    let under = floor(&bounced, 0.0, 240.0);
    assert!(under.min_element() > 0.0 && under == floor(&whole, 0.0, 240.0), "{under}");
    let open = floor(&bounced, -100.0, -60.0);
    assert!(open.x > 2.0 && open.x < 0.5 * floor(&direct, -100.0, -60.0).x, "{open}");
}

#[test]
fn patches_show_what_they_send_back() {
    let lit = view(&room(), DebugView::BounceLights);
    let whole = LitLight::new(&room(), &settings(None));
    for (index, surface) in lit.scene.surfaces.iter().enumerate() {
        let grid = surface.luxels.as_ref().unwrap();
        let (sent, got) = (lit.of(index, 0), whole.of(index, 0));
        // Luxels at the edges of a face count half in its patches.
        let mean = |light: &[Vec3]| {
            let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
            for (i, c) in light.iter().enumerate() {
                let (x, y) = (i as u32 % grid.width, i as u32 / grid.width);
                let half = |at: u32, size: u32| if at == 0 || at + 1 == size { 0.5 } else { 1.0 };
                let weight = half(x, grid.width) * half(y, grid.height);
                sum += *c * weight;
                weights += weight;
            }
            sum / weights
        };
        let want = mean(&got) * surface.reflectance.0;
        let off = (mean(&sent) / want - 1.0).abs().max_element();
        assert!(off < 0.1, "face {index}: {} {want}", mean(&sent));
    }
}
