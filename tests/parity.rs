//! Whole maps against the reference compiler, luxel by luxel: the program's stored levels with
//! direct light only. Skipped without the reference's output.

mod support;

use qrad::bsp::{Bsp, read_lit};
use qrad::light_bsp;
use qrad::progress::Progress;
use qrad::scene::Sidecar;
use qrad::settings::Settings;
use support::shared_dir;

/// How the luxels of a map compare.
#[derive(Debug, Default)]
struct Agreement {
    luxels: usize,
    equal: usize,
    within_1: usize,
    within_4: usize,
    /// Sum of squares of differences of channels.
    squares: f64,
    /// Faces that only one of the two lights.
    lit_by_one: usize,
    /// Faces with different sets of styles.
    other_styles: usize,
    faces: usize,
}

impl Agreement {
    fn rms(&self) -> f64 {
        (self.squares / (3 * self.luxels) as f64).sqrt()
    }
}

fn compare(map: &str) -> Option<Agreement> {
    let shared = shared_dir()?;
    let path = ["demo", "librequake"]
        .map(|folder| shared.join("maps").join(folder).join(format!("{map}.bsp")))
        .into_iter()
        .find(|p| p.is_file())?;
    let reference = shared.join("reference/light/direct").join(map);
    let mut bsp = Bsp::read(&std::fs::read(&path).unwrap()).unwrap();
    let texinfo = std::fs::read_to_string(path.with_extension("texinfo.json")).ok();
    let content = std::fs::read_to_string(path.with_extension("content.json")).ok();
    let sidecar =
        Sidecar { texinfo: texinfo.as_deref(), content: content.as_deref(), ..Sidecar::default() };
    let settings = Settings {
        bounces: Some(0),
        overrides: vec![("_sunlight_penumbra".to_owned(), "0".to_owned())],
        ..Settings::default()
    };
    let lit = light_bsp(&mut bsp, sidecar, Vec::new(), &settings, &Progress::new(false)).unwrap();
    let other = Bsp::read(&std::fs::read(reference.with_extension("bsp")).unwrap()).unwrap();
    let rgb = read_lit(&std::fs::read(reference.with_extension("lit")).unwrap()).unwrap();

    let mut result = Agreement { faces: lit.faces.len(), ..Agreement::default() };
    for (face, record) in lit.faces.iter().zip(&other.faces) {
        let mut ours: Vec<u8> = face.styles.iter().map(|s| s.style as u8).collect();
        let mut theirs: Vec<u8> = record.styles.iter().copied().filter(|s| *s != 255).collect();
        ours.sort_unstable();
        theirs.sort_unstable();
        result.lit_by_one += usize::from(ours.is_empty() != theirs.is_empty());
        result.other_styles += usize::from(ours != theirs);
        let mut styles = [ours, theirs].concat();
        styles.sort_unstable();
        styles.dedup();
        for style in styles {
            let mine =
                face.styles.iter().find(|s| s.style == u16::from(style)).map(|s| &s.levels[..]);
            let slot = record.styles.iter().position(|s| *s == style);
            let count = match (mine, face.styles.first()) {
                (Some(levels), _) => levels.len(),
                (None, Some(any)) => any.levels.len(),
                (None, None) => continue,
            };
            for i in 0..count {
                let a = mine.map_or([0; 3], |m| m[i]);
                let b = slot.map_or([0; 3], |slot| {
                    let at = 3 * (record.light_offset as usize + slot * count + i);
                    [rgb[at], rgb[at + 1], rgb[at + 2]]
                });
                let off: [u8; 3] = std::array::from_fn(|c| a[c].abs_diff(b[c]));
                let most = off.into_iter().max().unwrap();
                result.luxels += 1;
                result.equal += usize::from(most == 0);
                result.within_1 += usize::from(most <= 1);
                result.within_4 += usize::from(most <= 4);
                result.squares += off.iter().map(|o| f64::from(*o).powi(2)).sum::<f64>();
            }
        }
    }
    println!("{map}: {result:?}, rms {}", result.rms());
    Some(result)
}

#[test]
fn maps_of_points_and_spots_equal_the_reference() {
    for (map, least) in
        [("cornell", 8000), ("styles", 60_000), ("slit", 38_000), ("effects_none", 5000)]
    {
        let Some(result) = compare(map) else { return };
        assert!(result.luxels > least, "{map}: {result:?}");
        assert_eq!(result.equal, result.luxels, "{map}: {result:?}");
        assert_eq!(result.lit_by_one + result.other_styles, 0, "{map}: {result:?}");
    }
}

/// At least `share` of luxels within one level; what is left are rays that meet the very edge of
/// something, which the reference lets through or not by its rounding.
fn agrees(map: &str, least: usize, share: f64) {
    let Some(result) = compare(map) else { return };
    let luxels = result.luxels as f64;
    assert!(result.luxels > least, "{map}: {result:?}");
    assert!(result.within_1 as f64 >= share * luxels, "{map}: {result:?}");
    assert!(result.within_4 as f64 >= 0.998 * luxels, "{map}: {result:?}");
    assert!(result.other_styles * 1000 <= result.faces, "{map}: {result:?}");
    assert!(result.lit_by_one * 1000 <= result.faces, "{map}: {result:?}");
}

#[test]
fn sun_sky_glass_and_fences_agree_with_the_reference() {
    agrees("lqdm1", 110_000, 0.9995);
    agrees("lqdm2", 95_000, 0.9995);
    agrees("atrium", 70_000, 0.999);
}

#[test]
fn smoothed_normals_agree_with_the_reference() {
    agrees("lq_e4m4", 500_000, 0.9995);
}

#[test]
fn minimum_light_and_brush_models_agree_with_the_reference() {
    agrees("start", 43_000, 0.998);
}

#[test]
fn dirt_and_everything_at_once_agree_with_the_reference() {
    agrees("lq_e0m1", 160_000, 0.9945);
    agrees("effects_all", 11_000, 0.995);
}
