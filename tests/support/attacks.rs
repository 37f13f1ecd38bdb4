//! What each reader must survive, whatever the bytes: no panic, no hang, no more memory than the
//! input can account for. The fuzz targets in `fuzz/` and the property tests call the same functions.

use qrad::bsp::{
    Bsp, StyleRange, load_wad, normalise, parse_entities, read_hdr_lit, read_lit, write_entities,
    write_hdr_lit, write_lit,
};
use qrad::patch::{Reading, TextScene, decode};
use qrad::progress::Progress;
use qrad::radiosity::hemicube::HemicubeSize;
use qrad::scene::{LuxelGrid, Scene, SceneSettings, Sidecar};
use qrad::settings::Settings;

/// Luxels of a map that is lit here; larger ones are only read.
const MOST_LUXELS: usize = 4_000;
/// Pairs of luxels and lights of a map that is lit here.
const MOST_PAIRS: usize = 100_000;
/// Patches of a text scene that is lit here.
const MOST_PATCHES: usize = 200;

/// A BSP that is read is written, and reads back as the same.
pub fn bsp(bytes: &[u8]) {
    let Ok(bsp) = Bsp::read(bytes) else { return };
    let written = bsp.write().expect("what was read can be written");
    let again = Bsp::read(&written).expect("what was written can be read");
    assert!(again.write().expect("and written again") == written, "writing is settled");
}

/// A BSP that is read becomes a scene, and if that is small it is lit and still a whole BSP.
pub fn light(bytes: &[u8]) {
    let Ok(bsp) = Bsp::read(bytes) else { return };
    light_with(bsp, Sidecar::default());
}

/// Lights a map with what lies beside it, if there is not too much to do.
pub fn light_with(mut bsp: Bsp, sidecar: Sidecar<'_>) {
    let Ok(scene) = Scene::build(&bsp, sidecar, &SceneSettings::default()) else { return };
    let luxels: usize =
        scene.surfaces.iter().filter_map(|s| s.luxels.as_ref()).map(LuxelGrid::len).sum();
    let lights = scene.lights.len() + scene.radiosity_lights.len() + scene.suns.len();
    if luxels > MOST_LUXELS || luxels * lights > MOST_PAIRS {
        return;
    }
    let hemicube = HemicubeSize::new(8, 8).expect("a size in range");
    let settings = Settings { hemicube, patch_size: 16, ..Settings::default() };
    let lit = qrad::light_bsp(&mut bsp, sidecar, Vec::new(), &settings, &Progress::new(false));
    if let Ok(lit) = lit {
        assert!(lit.counts.residual.is_finite());
        let written = bsp.write().expect("a lit map can be written");
        Bsp::read(&written).expect("a lit map can be read");
    }
}

/// Entity text that is read is written so that it reads back as the same, once what cannot be quoted
/// is gone; what lighting changes in it is changed once.
pub fn entities(bytes: &[u8]) {
    let Ok(mut entities) = parse_entities(bytes) else { return };
    let _ = parse_entities(&write_entities(&entities));
    if normalise(&mut entities, StyleRange::default()).is_ok() {
        let again =
            normalise(&mut entities, StyleRange::default()).expect("what was normal stays so");
        assert!(!again, "a second run changes nothing");
    }
}

/// Textures of a WAD hold the pixels that they claim.
pub fn wad(bytes: &[u8]) {
    let Ok(textures) = load_wad(bytes) else { return };
    let mut total = 0;
    for texture in textures {
        let Some(pixels) = texture.pixels else { continue };
        assert_eq!(pixels.len() as u64, u64::from(texture.width) * u64::from(texture.height));
        total += pixels.len();
    }
    assert!(total <= 4 * bytes.len(), "{total} texels from {} bytes", bytes.len());
}

/// A `.lit` file that is read is written as it was.
pub fn lit(bytes: &[u8]) {
    if let Ok(rgb) = read_lit(bytes) {
        assert!(write_lit(&rgb) == bytes);
    }
    if let Ok(colours) = read_hdr_lit(bytes) {
        assert!(write_hdr_lit(&colours) == bytes);
    }
}

/// A text scene that is read comes back from its own text, and if it is small it is lit.
pub fn text(bytes: &[u8]) {
    let Ok(text) = decode(bytes, "scene") else { return };
    let _ = TextScene::parse_repaired(text, "scene", Reading::Lit);
    let Ok((scene, _)) = TextScene::parse_repaired(text, "scene", Reading::Raw) else { return };
    let (again, repairs) = TextScene::parse_repaired(&scene.to_text(), "scene", Reading::Raw)
        .expect("what was written can be read");
    assert!(again == scene && repairs.is_empty(), "{repairs:?}");
    if scene.patches.len() > MOST_PATCHES {
        return;
    }
    let scene = TextScene { hemicube: [8, 8], passes: scene.passes.min(50), ..scene };
    let (_, solution) =
        qrad::light_patches(&scene, &Progress::new(false)).expect("a size in range");
    assert!(solution.exitance.iter().all(|m| m.0.is_finite() && m.0.min_element() >= 0.0));
}

/// The files beside a map, three after each other with a NUL between: texinfo.json, content.json and
/// `.rad`.
pub fn sidecar(bytes: &[u8], map: &Bsp) {
    let text = String::from_utf8_lossy(bytes);
    let mut parts = text.splitn(3, '\0');
    let [texinfo, content, rad] = [parts.next(), parts.next(), parts.next()];
    let rad: Vec<(String, String)> =
        rad.into_iter().map(|text| ("lights.rad".to_owned(), text.to_owned())).collect();
    light_with(map.clone(), Sidecar { texinfo, content, rad: &rad, ..Sidecar::default() });
}
