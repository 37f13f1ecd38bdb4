//! Coplanar faces meet without a seam: luxels that lie in the same place get the same light.

mod support;

use glam::Vec3;
use qrad::bsp::Format;
use qrad::settings::{Quality, Settings};
use support::lit_map::Prepared;
use support::map_builder::MapBuilder;

/// A room with a pillar of two brushes and a light off the middle, its sides cut into faces of at most `cell` units.
fn room(cell: f32, quality: Quality) -> Prepared {
    let light = "{\n\"classname\" \"light\"\n\"origin\" \"90 -70 60\"\n\"light\" \"400\"\n}\n";
    let bsp = MapBuilder::room([-192.0, -192.0, 0.0], [192.0, 192.0, 160.0])
        .solid_texture("grey", 12)
        .solid_texture("red", 0xf7)
        .room_textures([1, 0, 0, 0, 0, 0])
        .pillar([-64.0, -32.0, 0.0], [-32.0, 16.0, 96.0], 1)
        .pillar([-32.0, -32.0, 0.0], [0.0, 16.0, 96.0], 0)
        .subdivide(cell)
        .entities(format!("{{\n\"classname\" \"worldspawn\"\n}}\n{light}"))
        .build(Format::Bsp2);
    Prepared::new(&bsp, Settings::of_quality(quality), false)
}

/// Pairs of luxels of different coplanar faces in the same place: how many there are, how many
/// differ by more than 1 % and by more than one level, and the largest difference in levels.
fn seams(map: &Prepared) -> (usize, usize, f32) {
    let lit = map.light(map.settings.gather);
    let range = map.scene.world.range;
    let mut luxels: Vec<(Vec3, Vec3, usize, Vec3)> = Vec::new();
    for (face, samples) in map.samples.iter().enumerate() {
        for (i, sample) in samples.iter().enumerate().filter(|(_, s)| !s.occluded) {
            let light = lit.indirect[face].first().map_or(Vec3::ZERO, |m| m.irradiance[i].0);
            luxels.push((sample.position, sample.normal, face, light * range));
        }
    }
    let key = |p: Vec3| (p * 8.0).round().to_array().map(|v| v as i32);
    luxels.sort_by_key(|l| (key(l.0), l.2));
    let mean = luxels.iter().map(|l| l.3.x).sum::<f32>() / luxels.len() as f32;
    assert!(mean > 10.0, "one level matters little: the mean is {mean}");
    let (mut pairs, mut differ, mut worst) = (0, 0, 0.0_f32);
    for two in luxels.windows(2) {
        let ((p, n, f, a), (q, m, g, b)) = (two[0], two[1]);
        if f == g || p.distance(q) > 0.05 || n != m {
            continue;
        }
        pairs += 1;
        let apart = (a - b).abs();
        worst = worst.max(apart.max_element());
        let limit = (a.max(b) * 0.01).max(Vec3::ONE);
        differ += usize::from(apart.cmpgt(limit).any());
    }
    (pairs, differ, worst)
}

#[test]
fn coplanar_faces_agree_where_they_meet() {
    for cell in [96.0, 80.0] {
        for quality in [Quality::Draft, Quality::Normal, Quality::Final] {
            let (pairs, differ, worst) = seams(&room(cell, quality));
            println!("faces of {cell}, {quality:?}: {pairs} pairs, worst {worst:.3} levels apart");
            assert!(pairs > 300, "{pairs}");
            assert_eq!(differ, 0, "faces of {cell}, {quality:?}");
        }
    }
}
