//! What stands in the way of bounced light: fences by the share that they cover, and models of `skip`.

mod support;

use qrad::bsp::Format;
use qrad::settings::Settings;
use support::lit_map::Prepared;
use support::lit_room::entity;
use support::map_builder::MapBuilder;

/// A room that a ceiling one unit thick, a brush model, divides at half its height.
fn room(texture: Option<usize>, keys: &[(&str, &str)]) -> Prepared {
    // One column in four is not see-through.
    let quarter = (0..16 * 16).map(|i| if i % 4 == 0 { 8 } else { 255 }).collect();
    let half = (0..16 * 16).map(|i| if i / 16 % 2 == 0 { 8 } else { 255 }).collect();
    let wall = entity("func_wall", &[&[("model", "*1")], keys].concat());
    let bsp = MapBuilder::room([-128.0, -128.0, 0.0], [128.0, 128.0, 256.0])
        .solid_texture("wall", 8)
        .texture("{quarter", 16, 16, quarter)
        .texture("{half", 16, 16, half)
        .solid_texture("{none", 255)
        .solid_texture("glass", 251)
        .model([-128.0, -128.0, 128.0], [128.0, 128.0, 129.0], texture)
        .entities(entity("worldspawn", &[]) + &wall)
        .build(Format::Bsp29);
    Prepared::new(&bsp, Settings::default(), false)
}

/// Of the light that leaves the floor: what meets the upper half of the room, and what meets the model.
fn shares(map: &Prepared) -> [f64; 2] {
    let patches = &map.patches;
    let surface = |patch: usize| &map.scene.surfaces[patches.surface[patch] as usize];
    let is_floor = |p: &usize| surface(*p).normal.z == 1.0 && surface(*p).dist == 0.0;
    let floor: Vec<usize> = (0..patches.surface.len()).filter(is_floor).collect();
    let mut sums = [0.0; 2];
    for &patch in &floor {
        let (columns, weights) = map.transfers.row(patch);
        for (&to, &f) in columns.iter().zip(&weights) {
            let to = to as usize;
            let model = surface(to).model == Some(1);
            if model || patches.set.patches[to].eye.z > 129.0 {
                sums[usize::from(model)] += f64::from(f) / floor.len() as f64;
            }
        }
    }
    sums
}

const SHADOW: &[(&str, &str)] = &[("_shadow", "1")];

#[test]
fn fences_block_and_reflect_by_the_share_that_they_cover() {
    let [open, nothing] = shares(&room(Some(1), &[]));
    assert!(open > 0.3 && nothing == 0.0, "without shadow there is no fence: {open} {nothing}");
    for (texture, covered) in [(1, 0.25), (2, 0.5)] {
        let map = room(Some(texture), SHADOW);
        let [passes, meets] = shares(&map);
        // Slanting light may meet the slats of both sides.
        let share = passes / open;
        println!("covered {covered}: {share} passes, {} is met", meets / open);
        assert!(share < 1.0 - covered + 0.02 && share > 1.0 - covered - 0.1, "{covered}: {share}");
        assert!((meets / open - covered).abs() < 0.03, "{covered}: {}", meets / open);
        let of_fence = map.scene.surfaces.iter().filter(|s| s.model == Some(1));
        assert!(of_fence.filter(|s| s.luxels.is_some()).all(|s| s.reflects));
    }
}

#[test]
fn direct_light_still_knows_every_texel() {
    let map = room(Some(2), SHADOW);
    let (all, opaque) = (map.scene.bounce_tracer().polygons(), map.scene.tracer.polygons());
    assert!(all.len() > opaque.len() + 16);
    // The polygons of surfaces keep their numbers.
    let same = |i: usize| all[i].vertices == opaque[i].vertices;
    assert!((0..opaque.len()).all(same));
}

#[test]
fn models_of_skip_block_everything_and_reflect_nothing() {
    let [open, _] = shares(&room(None, &[]));
    let [passes, meets] = shares(&room(None, SHADOW));
    assert!(open > 0.3 && passes == 0.0 && meets == 0.0, "{open} {passes} {meets}");
}

#[test]
fn what_blocks_only_some_light_does_not_block_bounced_light() {
    let [open, _] = shares(&room(Some(1), &[]));
    for (texture, keys) in [
        (Some(3), SHADOW),
        (Some(4), &[("_shadow", "1"), ("alpha", "0.5")]),
        (Some(2), &[("_switchableshadow", "1")]),
        (Some(2), &[("_shadowself", "1")]),
        (Some(2), &[("_shadow", "1"), ("_object_channel_mask", "2")]),
        (None, &[("_shadowworldonly", "1")]),
    ] {
        let [passes, _] = shares(&room(texture, keys));
        assert!((passes - open).abs() < 1e-6, "{texture:?} {keys:?}: {passes} {open}");
    }
}
