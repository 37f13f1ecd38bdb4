//! Light without colour in one channel, and styles side by side: the same bytes as three channels and
//! as each style alone.

mod support;

use glam::{DVec3, Vec3};
use qrad::light::bounce_source;
use qrad::light_patches;
use qrad::patch::{Shader, TextPatches, TextScene};
use qrad::photometry::{Exitance, Irradiance, Reflectance};
use qrad::progress::Progress;
use qrad::radiosity::channels::Channels;
use qrad::radiosity::solve::{Limits, Solution, Sources, Surfaces, solve_styles};
use qrad::radiosity::transfers::Transfers;
use qrad::scene::effects::Effect;
use support::lit_map::Prepared;
use support::quads::{BLACK, cuboid, transfers};

const LIMITS: Limits = Limits { passes: None, residual: 1e-9 };

fn bytes(solution: &Solution) -> Vec<u32> {
    solution.exitance.iter().flat_map(|m| m.0.to_array()).map(f32::to_bits).collect()
}

/// A room with a box, and reflectances that vary; coloured or not.
fn room(coloured: bool) -> (TextPatches, Transfers, Vec<Reflectance>) {
    let mut quads = cuboid(DVec3::ZERO, DVec3::new(3.0, 2.0, 2.5), 4, true, BLACK);
    quads.extend(cuboid(DVec3::splat(0.6), DVec3::splat(1.3), 2, false, BLACK));
    let (patches, transfers) = transfers(&quads, 32);
    let wave = |k: usize| 0.45 + 0.45 * (k as f32 * 1.7).sin();
    let of = |i: usize| match coloured {
        true => Vec3::new(wave(i), wave(i + 7), wave(3 * i)),
        false => Vec3::splat(wave(i)),
    };
    let rho = (0..quads.len()).map(|i| Reflectance(of(i))).collect();
    (patches, transfers, rho)
}

/// Emission and direct light of seven styles, which settle after different numbers of passes.
fn styles(count: usize, colour: Vec3) -> Vec<(Vec<Exitance>, Vec<Irradiance>)> {
    (0..7)
        .map(|k| {
            let mut emission = vec![Exitance::ZERO; count];
            let mut direct = vec![Irradiance::ZERO; count];
            // The first is dark, and some have only one kind of light.
            if k % 3 > 0 {
                emission[11 * k] = Exitance(colour * (0.3 + k as f32));
            }
            if k % 2 > 0 {
                direct.iter_mut().skip(k).step_by(k).for_each(|e| *e = Irradiance(colour * 0.7));
            }
            (emission, direct)
        })
        .collect()
}

#[test]
fn styles_side_by_side_are_as_each_alone() {
    for (coloured, colour) in [(true, Vec3::new(1.0, 0.4, 0.7)), (false, Vec3::ONE)] {
        let (_, transfers, rho) = room(coloured);
        let surfaces = Surfaces { transfers: &transfers, reflectance: &rho, passages: &[] };
        let styles = styles(rho.len(), colour);
        let sources: Vec<Sources<'_>> =
            styles.iter().map(|(emission, direct)| Sources { emission, direct }).collect();
        let expected = if coloured { Channels::Three } else { Channels::One };
        assert_eq!(Channels::of(surfaces, sources.iter().copied()), expected);
        let together = solve_styles(surfaces, &sources, LIMITS, expected);
        let mut passes: Vec<u32> = together.iter().map(|s| s.passes).collect();
        for (k, (solution, source)) in together.iter().zip(&sources).enumerate() {
            let alone = &solve_styles(surfaces, &[*source], LIMITS, Channels::Three)[0];
            assert_eq!(bytes(solution), bytes(alone), "style {k}");
            assert_eq!((solution.passes, solution.residual), (alone.passes, alone.residual));
        }
        passes.dedup();
        assert!(passes.len() > 2, "styles end together: {passes:?}");
    }
}

#[test]
fn any_colour_takes_three_channels() {
    let (patches, transfers, mut rho) = room(false);
    let count = rho.len();
    let (grey, red) = (vec![Exitance(Vec3::ONE); count], Exitance(Vec3::X));
    let of = |rho: &[Reflectance], emission: &[Exitance], direct: &[Irradiance]| {
        let surfaces = Surfaces { transfers: &transfers, reflectance: rho, passages: &[] };
        Channels::of(surfaces, [Sources { emission, direct }])
    };
    assert_eq!(patches.set.patches.len(), count);
    assert_eq!(of(&rho, &grey, &[]), Channels::One);
    let mut one_red = grey.clone();
    one_red[count - 1] = red;
    assert_eq!(of(&rho, &one_red, &[]), Channels::Three);
    let mut direct = vec![Irradiance::ZERO; count];
    direct[7].0.y = 1e-9;
    assert_eq!(of(&rho, &grey, &direct), Channels::Three);
    rho[3].0.z += 1e-6;
    assert_eq!(of(&rho, &grey, &[]), Channels::Three);
}

/// Takes all colour out of a scene.
fn make_grey(scene: &mut TextScene) {
    let grey = |c: &mut [f64; 3]| *c = [c.iter().sum::<f64>() / 3.0; 3];
    for quad in &mut scene.patches {
        grey(&mut quad.exitance);
        grey(&mut quad.reflectance);
        quad.effects.straight.iter_mut().for_each(grey);
        quad.effects.diffuse.iter_mut().for_each(grey);
        match &mut quad.effects.shader {
            Some(Shader::Checker(_, colour) | Shader::Gradient(colour)) => grey(colour),
            None => {}
        }
    }
}

#[test]
fn grey_text_scenes_take_one_channel_and_come_out_the_same() {
    for name in ["cornell", "curtain"] {
        let path = support::maps_dir().join(format!("cornell/{name}.txt"));
        let text = std::fs::read_to_string(path).unwrap();
        let mut scene = TextScene::parse(&text, name).unwrap();
        scene.hemicube = [16, 16];
        let quiet = Progress::new(false);
        make_grey(&mut scene);
        let (transfers, one) = light_patches(&scene, &quiet).unwrap();
        assert_eq!(one.channels, Channels::One, "{name}");
        let patches = TextPatches::new(&scene);
        let (reflectance, passages) = (patches.reflectance(), &patches.set.passages[..]);
        let surfaces = Surfaces { transfers: &transfers, reflectance: &reflectance, passages };
        let sources = Sources { emission: &patches.emission, direct: &[] };
        let limits = Limits { passes: Some(scene.passes), residual: 1e-9 };
        let three = &solve_styles(surfaces, &[sources], limits, Channels::Three)[0];
        assert_eq!(bytes(&one), bytes(three), "{name}");
        assert_eq!(one.passes, three.passes);
    }
}

#[test]
fn grey_maps_take_one_channel_and_come_out_the_same() {
    for name in ["effects_none.bsp", "furnace.bsp"] {
        let map = Prepared::project_map(name, false);
        assert!(!qrad::plan(&map.scene, &map.settings).is_on(Effect::Colour), "{name}");
        let direct = map.direct();
        let bounced = map.bounce(&direct);
        assert_eq!(bounced.channels, Some(Channels::One), "{name}");
        let set = &map.patches.set;
        let rho: Vec<Reflectance> = set.patches.iter().map(|p| p.reflectance).collect();
        let surfaces =
            Surfaces { transfers: &map.transfers, reflectance: &rho, passages: &set.passages };
        let limits = Limits { passes: map.settings.bounces, residual: map.settings.residual };
        let emission = map.patches.emission(&map.scene.emitters);
        assert!(!bounced.styles.is_empty());
        for style in &bounced.styles {
            let bouncing: Vec<_> = direct
                .iter()
                .zip(&map.samples)
                .map(|(direct, samples)| bounce_source(direct, samples, 1, 1))
                .collect();
            let luxels: Vec<&[Irradiance]> = bouncing
                .iter()
                .map(|d| d.iter().find(|s| s.style == style.style))
                .map(|s| s.map_or(&[][..], |s| &s.irradiance))
                .collect();
            let direct = map.patches.mean_irradiance(&luxels);
            let own = emission.iter().find(|e| e.style == style.style);
            let own = own.map_or_else(|| vec![Exitance::ZERO; rho.len()], |e| e.exitance.clone());
            let sources = Sources { emission: &own, direct: &direct };
            let three = &solve_styles(surfaces, &[sources], limits, Channels::Three)[0];
            assert!(style.exitance == three.exitance, "{name}, style {}", style.style);
            let exitance: Vec<DVec3> = three.exitance.iter().map(|m| m.0.as_dvec3()).collect();
            let received = map.transfers.gather(&exitance);
            assert!(style.irradiance.iter().zip(received).all(|(e, r)| e.0 == r.as_vec3()));
        }
    }
    let coloured = Prepared::project_map("cornell.bsp", false);
    assert!(qrad::plan(&coloured.scene, &coloured.settings).is_on(Effect::Colour));
    assert_eq!(coloured.bounce(&coloured.direct()).channels, Some(Channels::Three));
}
