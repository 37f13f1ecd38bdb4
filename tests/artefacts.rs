//! What bounced light must not look like: light behind closed walls and under doors, black luxels where
//! brushes nearly touch, rings at the borders of patches.

mod support;

use glam::Vec3;
use qrad::bsp::{Bsp, Format};
use qrad::lightmap::Gather;
use qrad::settings::{Quality, Settings};
use std::collections::HashMap;
use support::lit_map::Prepared;
use support::map_builder::MapBuilder;

/// The entity of brush model `*1` as a door that casts shadow.
const DOOR: &str = "{\n\"classname\" \"func_door\"\n\"model\" \"*1\"\n\"_shadow\" \"1\"\n}\n";

/// A room of 384 x 384 x 192 units, grey all over.
fn room() -> MapBuilder {
    MapBuilder::room([-192.0, -192.0, 0.0], [192.0, 192.0, 192.0]).solid_texture("grey", 12)
}

/// Worldspawn and a light at `origin`, and then `more`.
fn lit_from(origin: &str, more: &str) -> String {
    format!(
        "{{\n\"classname\" \"worldspawn\"\n}}\n\
         {{\n\"classname\" \"light\"\n\"origin\" \"{origin}\"\n\"light\" \"500\"\n}}\n{more}"
    )
}

/// A luxel that is not in solid: where it takes its light, and its bounced light in light units.
struct Luxel {
    face: usize,
    at: [usize; 2],
    position: Vec3,
    light: f32,
}

/// All free luxels of a map.
fn luxels(map: &Prepared, gather: Gather) -> Vec<Luxel> {
    let lit = map.light(gather);
    let mut all = Vec::new();
    for (face, samples) in map.samples.iter().enumerate() {
        let width = map.scene.surfaces[face].luxels.as_ref().map_or(1, |g| g.width as usize);
        for (i, sample) in samples.iter().enumerate().filter(|(_, s)| !s.occluded) {
            let light = lit.indirect[face].first().map_or(Vec3::ZERO, |m| m.irradiance[i].0);
            assert!(light.is_finite() && light.min_element() >= 0.0, "face {face}: {light}");
            let (position, at) = (sample.position, [i % width, i / width]);
            all.push(Luxel { face, at, position, light: light.x });
        }
    }
    all
}

/// Largest light of the luxels that `dark` picks, and mean light of the others.
fn leak(map: &Prepared, gather: Gather, dark: impl Fn(Vec3) -> bool) -> (f32, f32) {
    let (beyond, lit): (Vec<_>, Vec<_>) =
        luxels(map, gather).into_iter().partition(|l| dark(l.position));
    assert!(beyond.len() > 500 && lit.len() > 500, "{} {}", beyond.len(), lit.len());
    let mean = lit.iter().map(|l| l.light).sum::<f32>() / lit.len() as f32;
    (beyond.iter().map(|l| l.light).fold(0.0, f32::max), mean)
}

/// Settings under which bounced light must be free of artefacts; `draft` has larger patches and no
/// hemicubes at luxels.
fn qualities() -> [(Quality, Gather); 3] {
    [Quality::Draft, Quality::Normal, Quality::Final].map(|q| (q, q.gather()))
}

/// Checks that `dark` picks places that get no more than `limit` of the mean light of the others.
fn check_dark(name: &str, bsp: &Bsp, limit: f32, dark: impl Fn(Vec3) -> bool) {
    for (quality, gather) in qualities() {
        let map = Prepared::new(bsp, Settings::of_quality(quality), false);
        let (most, mean) = leak(&map, gather, &dark);
        println!("{name}, {quality:?}: at most {:.6} of {mean}", most / mean);
        assert!(mean > 5.0 && most <= limit * mean, "{name}, {quality:?}: {most} of {mean}");
    }
}

/// A wall of two brushes on a floor that runs on under it: thicker than a luxel, or so thin that it stands
/// between two rows of luxels, over one, or right beside one.
#[test]
fn no_light_gets_through_a_wall_or_the_joint_of_its_brushes() {
    for [low, high] in [[-16.0, 16.0], [3.0, 13.0], [-2.0, 2.0], [17.0, 19.0], [0.125, 1.125]] {
        let bsp = room()
            .pillar([low, -192.0, 0.0], [high, 40.0, 192.0], 0)
            .pillar([low, 40.0, 0.0], [high, 192.0, 192.0], 0)
            .entities(lit_from("-90 30 80", ""))
            .build(Format::Bsp2);
        check_dark(&format!("wall {low} to {high}"), &bsp, 1e-4, |p| p.x > high - 0.6);
    }
}

/// A door thinner than a luxel, on a floor that runs on under it: over a row of luxels (of the even ones
/// and of the odd ones), between two in the middle, or right beside one.
#[test]
fn no_light_gets_under_a_closed_door() {
    for [low, high] in
        [[-4.0, 4.0], [12.0, 20.0], [4.0, 12.0], [22.0, 23.0], [1.0, 5.0], [9.0, 15.9]]
    {
        let bsp = room()
            .model([low, -192.0, 0.0], [high, 192.0, 192.0], Some(0))
            .entities(lit_from("-90 30 80", DOOR))
            .build(Format::Bsp2);
        check_dark(&format!("door {low} to {high}"), &bsp, 1e-4, |p| p.x > high - 0.6);
    }
}

/// The same of `skip`: it casts shadow but has no faces.
#[test]
fn no_light_gets_under_an_unseen_door() {
    for [low, high] in [[-4.0, 4.0], [22.0, 23.0]] {
        let bsp = room()
            .model([low, -192.0, 0.0], [high, 192.0, 192.0], None)
            .entities(lit_from("-90 30 80", DOOR))
            .build(Format::Bsp2);
        check_dark(&format!("unseen door {low} to {high}"), &bsp, 1e-4, |p| p.x > high - 0.6);
    }
}

/// A door in a doorway 64 units wide and 112 high, half a unit above the floor, between two places along the
/// depth of the frame; lit from low x.
fn framed_door([low, high]: [f32; 2]) -> Bsp {
    room()
        .pillar([-8.0, -192.0, 0.0], [8.0, -32.0, 192.0], 0)
        .pillar([-8.0, 32.0, 0.0], [8.0, 192.0, 192.0], 0)
        .pillar([-8.0, -32.0, 112.0], [8.0, 32.0, 192.0], 0)
        .model([low, -32.0, 0.5], [high, 32.0, 112.0], Some(0))
        .entities(lit_from("-90 30 80", DOOR))
        .build(Format::Bsp2)
}

/// A little light may get through below.
#[test]
fn hardly_any_light_gets_under_a_door_in_its_frame() {
    check_dark("framed door", &framed_door([-4.0, 4.0]), 0.02, |p| p.x > 3.4);
}

/// The same off the middle of the frame. Within the frame luxels see through the gap; behind it they do not.
#[test]
fn hardly_any_light_gets_under_a_door_off_the_middle_of_its_frame() {
    for [low, high] in [[-8.0, 0.0], [0.0, 8.0], [-6.0, 2.0], [3.0, 5.0], [-8.0, -6.0]] {
        let name = format!("framed door {low} to {high}");
        check_dark(&name, &framed_door([low, high]), 0.01, |p| p.x > 9.0);
    }
}

/// A wall right above a lit ledge, where light gathers within two units: no luxel is left with the light
/// of those farther up.
#[test]
fn no_luxel_over_a_ledge_misses_its_light() {
    let bsp = room()
        .pillar([-192.0, 160.0, 0.0], [192.0, 192.0, 94.0], 0)
        .entities(lit_from("0 60 170", ""))
        .build(Format::Bsp2);
    for (quality, gather) in qualities() {
        let map = Prepared::new(&bsp, Settings::of_quality(quality), false);
        let mut row: Vec<(f32, f32)> = luxels(&map, gather)
            .into_iter()
            .filter(|l| l.position.y > 190.5 && (94.0..100.0).contains(&l.position.z))
            .filter(|l| l.position.x.abs() < 150.0)
            .map(|l| (l.position.x, l.light))
            .collect();
        row.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert!(row.len() > 15, "{}", row.len());
        let ratio = |w: &[(f32, f32)]| (w[0].1 / w[1].1).min(w[1].1 / w[0].1);
        let least = row.windows(2).map(ratio).fold(1.0, f32::min);
        println!("{quality:?}: neighbours over the ledge differ by a factor of {least} at most");
        assert!(least > 0.8, "{quality:?}: {least} {row:?}");
    }
}

/// The same where the wall's lowest face is a strip, so that little is left of its patches: as far apart as
/// others, they once did not reach each other, and every other luxel between them took its light from the
/// face above.
#[test]
fn no_luxel_over_a_cornice_misses_its_light() {
    let bsp = MapBuilder::room([-384.0, -384.0, 0.0], [384.0, 384.0, 320.0])
        .solid_texture("dark", 4)
        .solid_texture("bright", 15)
        .pillar([-384.0, 352.0, 0.0], [384.0, 384.0, 94.0], 1)
        .pillar([-384.0, 368.0, 94.0], [384.0, 384.0, 104.0], 0)
        .pillar([-384.0, 368.0, 104.0], [384.0, 384.0, 320.0], 0)
        .entities(lit_from("0 180 250", ""))
        .build(Format::Bsp2);
    for quality in [Quality::Normal, Quality::High] {
        let map = Prepared::new(&bsp, Settings::of_quality(quality), false);
        let [got, exact] = [quality.gather(), Gather::Luxel].map(|g| luxels(&map, g));
        let over = |p: Vec3| p.y > 365.0 && (94.0..100.0).contains(&p.z) && p.x.abs() < 330.0;
        let pairs = got.iter().zip(&exact).filter(|(l, _)| over(l.position));
        let ratios: Vec<f32> = pairs.map(|(a, b)| a.light / b.light).collect();
        let least = ratios.iter().copied().fold(f32::INFINITY, f32::min);
        println!("{quality:?}: {} luxels get at least {least} of their light", ratios.len());
        assert!(ratios.len() > 15 && least > 0.95, "{quality:?}: {least}");
    }
}

/// Water in a trench, above its floor: what arrives at the water does not tell what arrives below.
#[test]
fn water_over_a_floor_leaves_its_light_alone() {
    let trench = || {
        room()
            .solid_texture("*water", 8)
            .pillar([-192.0, -192.0, 0.0], [192.0, -32.0, 24.0], 0)
            .pillar([-192.0, 32.0, 0.0], [192.0, 192.0, 24.0], 0)
            .entities(lit_from("-90 30 80", ""))
    };
    let water = trench().liquid([-160.0, -31.0, 0.5], [160.0, 31.0, 20.0], 1);
    let [dry, wet] = [trench(), water].map(|m| m.build(Format::Bsp2));
    for (quality, gather) in qualities() {
        let floor = |bsp: &Bsp| -> Vec<f32> {
            let map = Prepared::new(bsp, Settings::of_quality(quality), false);
            let low = |l: &Luxel| l.face == 4 && l.position.y.abs() < 31.5;
            luxels(&map, gather).into_iter().filter(low).map(|l| l.light).collect()
        };
        let (dry, wet) = (floor(&dry), floor(&wet));
        assert!(dry.len() > 60 && wet.len() == dry.len(), "{} {}", dry.len(), wet.len());
        let changes = wet.iter().zip(&dry).map(|(wet, dry)| (wet / dry - 1.0).abs());
        let most = changes.fold(0.0, f32::max);
        println!("{quality:?}: the floor's light differs by {most} at most under water");
        assert!(most < 0.01, "{quality:?}: {most}");
    }
}

/// Two pillars and a slit between them, and one as far from the wall.
#[test]
fn no_luxel_is_black_where_brushes_nearly_touch() {
    for gap in [2.0, 1.0, 0.5, 0.125] {
        let half = gap * 0.5;
        let bsp = room()
            .pillar([-65.0, -32.0, 0.0], [-half, 32.0, 96.0], 0)
            .pillar([half, -32.0, 0.0], [65.0, 32.0, 96.0], 0)
            .pillar([-32.0, 128.0 - gap, 0.0], [32.0, 192.0 - gap, 128.0], 0)
            .entities(lit_from("100 -110 120", ""))
            .build(Format::Bsp2);
        for (quality, gather) in qualities() {
            let map = Prepared::new(&bsp, Settings::of_quality(quality), false);
            let (seen, least) = least_of_those_around(&luxels(&map, gather), |p| {
                p.x.abs() < 1.5 && p.y.abs() < 32.0 || p.y > 190.0 && p.x.abs() < 32.0
            });
            println!("{gap} apart, {quality:?}: {seen} luxels, at least {least} of those around");
            assert!(seen > 2000 && least > 0.4, "{gap} apart, {quality:?}: {least}");
        }
    }
}

/// How many luxels have at least three neighbours and are not `left_out`, and the least ratio of the light
/// of one to the mean of its neighbours.
fn least_of_those_around(all: &[Luxel], left_out: impl Fn(Vec3) -> bool) -> (usize, f32) {
    let light: HashMap<(usize, [usize; 2]), f32> =
        all.iter().map(|l| ((l.face, l.at), l.light)).collect();
    let (mut least, mut seen) = (f32::INFINITY, 0);
    for luxel in all.iter().filter(|l| !left_out(l.position)) {
        let [s, t] = luxel.at;
        let around = [[s.wrapping_sub(1), t], [s + 1, t], [s, t.wrapping_sub(1)], [s, t + 1]];
        let near: Vec<f32> =
            around.iter().filter_map(|&at| light.get(&(luxel.face, at)).copied()).collect();
        if near.len() >= 3 {
            seen += 1;
            least = least.min(luxel.light / (near.iter().sum::<f32>() / near.len() as f32));
        }
    }
    (seen, least)
}

/// Interpolation may not be dimmer or brighter at the borders of patches than in their middles, nor
/// uneven: it follows the light that a hemicube at each luxel finds.
#[test]
fn no_rings_at_the_borders_of_patches() {
    for quality in [Quality::Draft, Quality::Normal] {
        let bsp = room().entities(lit_from("60 -40 90", "")).build(Format::Bsp2);
        let map = Prepared::new(&bsp, Settings::of_quality(quality), false);
        let size = map.settings.patch_size as usize;
        let [smooth, exact] = [quality.gather(), Gather::Luxel].map(|g| luxels(&map, g));
        // Ratio of the sums at luxels on a border of patches, and at the others.
        let mut sums = [[0.0_f64; 2]; 2];
        let (mut squares, mut inner_luxels) = (0.0, 0.0);
        for (a, b) in smooth.iter().zip(&exact) {
            let grid = map.scene.surfaces[a.face].luxels.as_ref().unwrap();
            let intervals = [grid.width as usize - 1, grid.height as usize - 1];
            assert!((0..2).all(|k| intervals[k].is_multiple_of(size)));
            if (0..2).all(|k| a.at[k] > 1 && a.at[k] + 1 < intervals[k]) {
                let on_border = (0..2).any(|k| a.at[k].is_multiple_of(size));
                let sum = &mut sums[usize::from(on_border)];
                sum[0] += f64::from(a.light);
                sum[1] += f64::from(b.light);
                squares += f64::from(a.light / b.light - 1.0).powi(2);
                inner_luxels += 1.0;
            }
        }
        let [middle, border] = sums.map(|s| s[0] / s[1]);
        let rms = (squares / inner_luxels).sqrt();
        println!("{quality:?}: {middle:.5} in the middle, {border:.5} at borders, rms {rms:.5}");
        assert!((border / middle - 1.0).abs() < 0.005, "{middle} {border}");
        assert!((middle - 1.0).abs() < 0.01 && (border - 1.0).abs() < 0.01, "{middle} {border}");
        assert!(rms < 0.0045, "{rms}");
    }
}
