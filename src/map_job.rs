//! One run on a map: files in, files out.

use anyhow::Context;
use glam::Vec3;
use qrad::bsp::{Bsp, MipTex, load_wad, parse_entities, read_hdr_lit, read_lit};
use qrad::cli::Cli;
use qrad::outputs::Scope;
use qrad::progress::Progress;
use qrad::render::{Camera, LitMap, start_camera};
use qrad::report::Report;
use qrad::scene::Sidecar;
use qrad::{MapLight, light_bsp, lightmap, output};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

/// Lights the map in `path` and writes what the command line asks for, files of the map with `writing`
/// locked.
pub fn run(cli: &Cli, path: &Path, visible: bool, writing: &Mutex<()>) -> anyhow::Result<()> {
    let start = Instant::now();
    let settings = cli.settings()?;
    let mut bsp = Bsp::read(&read(path)?).with_context(|| path.display().to_string())?;
    let target = cli.output.as_deref().unwrap_or(path);
    if settings.outputs.scope == Scope::EntitiesOnly {
        bsp.rewrite_entities().with_context(|| path.display().to_string())?;
        let map = bsp.write()?;
        let _whole = writing.lock();
        output::write(target, &map)?;
        return Ok(());
    }
    let camera = cli.camera()?;
    let size = cli.preview_size()?;
    let textures = textures(cli, path, &bsp)?;
    let texinfo = sidecar(path, "texinfo.json")?;
    let content = sidecar(path, "content.json")?;
    let rad = rad_files(path)?;
    let sidecar =
        Sidecar { texinfo: texinfo.as_deref(), content: content.as_deref(), rad: Some(&rad) };
    let progress = Progress::new(visible);
    let lit = light_bsp(&mut bsp, sidecar, textures.clone(), &settings, &progress)
        .with_context(|| path.display().to_string())?;
    for sentence in &lit.scene.warnings {
        log::warn!("{sentence}");
    }
    note_damaged_lit(&target.with_extension("lit"));
    let whole = writing.lock();
    let mut written = match (settings.outputs.scope, &lit.lit) {
        (Scope::LitOnly, Some(file)) => {
            let path = target.with_extension("lit");
            output::write(&path, file)?;
            vec![path]
        }
        (_, file) => write_map(target, &bsp, file.as_deref())?,
    };
    if let Some(folder) = &cli.dump_lightmaps {
        written.extend(dump(folder, &lit)?);
    }
    drop(whole);
    if let Some(picture) = &cli.preview {
        let _stage = progress.stage("preview", 1);
        let map = LitMap::new(&bsp, lit.rgb.as_deref(), &textures)?;
        let camera = preview_camera(&bsp, &map, camera, size)?;
        let drawn = map.draw(&camera);
        let _whole = writing.lock();
        output::write_png(picture, &drawn)?;
        written.push(picture.clone());
    }
    if let Some(engine) = cli.outputs.engine {
        for sentence in engine.unread(&settings.outputs, lit.scene.decoupled) {
            log::warn!("{sentence}");
        }
    }
    if !cli.quiet {
        if let Some(engine) = cli.outputs.engine {
            println!("{}", engine.choice());
        }
        let mut report = Report::new();
        lit.counts.print(&mut report);
        report.resources(&progress.stages(), start.elapsed());
        for file in written {
            report.row("written", file.display());
        }
        print!("{report}");
    }
    Ok(())
}

/// Says so when the `.lit` file that is about to be replaced is none.
fn note_damaged_lit(path: &Path) {
    let Ok(bytes) = std::fs::read(path) else { return };
    if let (Err(error), Err(_)) = (read_lit(&bytes), read_hdr_lit(&bytes)) {
        log::warn!("{}: {error}; it is replaced", path.display());
    }
}

fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))
}

/// A file that qbsp may have written beside the map.
fn sidecar(map: &Path, extension: &str) -> anyhow::Result<Option<String>> {
    let path = map.with_extension(extension);
    match std::fs::read_to_string(&path) {
        Ok(text) => Ok(Some(text)),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(e).with_context(|| format!("cannot read {}", path.display())),
    }
}

/// Texture lights: `lights.rad` in the current folder or else beside the map, then `<map>.rad`.
fn rad_files(map: &Path) -> anyhow::Result<String> {
    let common = [PathBuf::from("lights.rad"), map.with_file_name("lights.rad")];
    let common = common.into_iter().find(|p| p.is_file());
    let mut text = String::new();
    for path in common.into_iter().chain(Some(map.with_extension("rad")).filter(|p| p.is_file())) {
        text.push_str(&String::from_utf8_lossy(&read(&path)?));
        text.push('\n');
    }
    Ok(text)
}

/// Textures of the WAD files given as options, and of those that worldspawn names if the map lacks
/// pixels. A WAD that worldspawn names need not be there.
fn textures(cli: &Cli, map: &Path, bsp: &Bsp) -> anyhow::Result<Vec<MipTex>> {
    let mut textures = Vec::new();
    for path in &cli.wad {
        textures.extend(load_wad(&read(path)?).with_context(|| path.display().to_string())?);
    }
    if bsp.textures.iter().flatten().all(|t| t.pixels.is_some()) {
        return Ok(textures);
    }
    let entities = parse_entities(&bsp.entities)?;
    let names = entities.first().and_then(|e| e.get("wad").or(e.get("_wad"))).unwrap_or("");
    for name in names.split(';').map(str::trim).filter(|n| !n.is_empty()) {
        // Maps carry the paths of the machine that they were made on.
        let name = name.replace('\\', "/");
        let beside = map.with_file_name(Path::new(&name).file_name().unwrap_or_default());
        let found = [map.with_file_name(&name), beside].into_iter().find(|p| p.is_file());
        match found.map(|p| Ok::<_, anyhow::Error>((load_wad(&read(&p)?), p))).transpose()? {
            Some((Ok(more), _)) => textures.extend(more),
            Some((Err(e), path)) => log::warn!("{}: {e}", path.display()),
            None => log::warn!("{name}: the WAD file that worldspawn names is not here"),
        }
    }
    Ok(textures)
}

/// Replaces the map and its `.lit`; a stale `.lit` goes when there is to be none.
fn write_map(path: &Path, bsp: &Bsp, lit: Option<&[u8]>) -> qrad::Result<Vec<PathBuf>> {
    let lit_path = path.with_extension("lit");
    let map = bsp.write()?;
    if let Some(lit) = lit {
        output::write_all(&[(&lit_path, lit), (path, &map)])?;
        Ok(vec![path.to_path_buf(), lit_path])
    } else {
        output::check_replaceable(&lit_path)?;
        output::write(path, &map)?;
        output::remove(&lit_path)?;
        Ok(vec![path.to_path_buf()])
    }
}

/// The camera asked for, else that of the player's start, else the middle of the map.
fn preview_camera(
    bsp: &Bsp,
    map: &LitMap,
    asked: Option<[f32; 5]>,
    size: [u32; 2],
) -> anyhow::Result<Camera> {
    let entities = parse_entities(&bsp.entities)?;
    let (eye, pitch, yaw) = match asked {
        Some([x, y, z, pitch, yaw]) => (Vec3::new(x, y, z), pitch.into(), yaw.into()),
        None => start_camera(&entities).unwrap_or((map.middle(), 0.0, 0.0)),
    };
    Ok(Camera::quake(eye.as_dvec3(), pitch, yaw, Camera::QUAKE_FOV, size)?)
}

fn dump(folder: &Path, lit: &MapLight) -> qrad::Result<Vec<PathBuf>> {
    let grids = lit.scene.surfaces.iter().map(|s| s.luxels.as_ref());
    let sizes: Vec<[u32; 2]> = grids.map(|g| g.map_or([0; 2], |g| [g.width, g.height])).collect();
    lightmap::dump(folder, &lit.faces, &sizes)
}
