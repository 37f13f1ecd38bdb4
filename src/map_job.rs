//! One run on a map: files in, files out.

use anyhow::Context;
use clap::{CommandFactory, Parser};
use glam::Vec3;
use qrad::bsp::{Bsp, Entity, MipTex, load_wad, parse_entities, read_hdr_lit, read_lit};
use qrad::cache::Cache;
use qrad::cli::Cli;
use qrad::outputs::{DirectionFile, Outputs, Scope};
use qrad::progress::Progress;
use qrad::render::{Camera, LitMap, start_camera};
use qrad::report::Report;
use qrad::run_report::{self, RunReport};
use qrad::scene::material_file::MaterialFile;
use qrad::scene::{Scene, Sidecar, export};
use qrad::settings::Settings;
use qrad::{
    Files, MapLight, aim, legacy_args, light_bsp_in_steps, lightmap, output, plan_costs, sweep,
};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

/// Lights the map in `path` and writes what the command line `args`, parsed as `cli`, asks for, files of
/// the map with `writing` locked.
pub fn run(
    (cli, args): (&Cli, &[OsString]),
    path: &Path,
    visible: bool,
    writing: &Mutex<()>,
) -> anyhow::Result<()> {
    let start = Instant::now();
    cli.settings()?;
    let mut bsp = Bsp::read(&read(path)?).with_context(|| path.display().to_string())?;
    let entities = parse_entities(&bsp.entities).with_context(|| path.display().to_string())?;
    let with_map = entities.first().and_then(|world| with_options_of_map(world, args));
    let cli = with_map.as_ref().unwrap_or(cli);
    let settings = cli.settings()?;
    let target = cli.output.as_deref().unwrap_or(path);
    check_outputs(cli, path, target, &settings)?;
    if settings.outputs.scope == Scope::EntitiesOnly {
        bsp.rewrite_entities(settings.styles(&bsp)?).with_context(|| path.display().to_string())?;
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
    let TextureLights { rad, lights } = TextureLights::read(cli, path)?;
    let materials = materials(cli, path)?;
    let sidecar = Sidecar {
        materials: materials.as_ref(),
        texinfo: texinfo.as_deref(),
        content: content.as_deref(),
        rad: &rad,
        lights: Some(&lights),
    };
    let obj = target.with_extension("obj");
    if cli.phongdebug_obj {
        let scene = Scene::build(&bsp, sidecar, &settings.scene(textures))
            .with_context(|| path.display().to_string())?;
        output::write(&obj, export::obj(&scene).as_bytes())?;
        return Ok(());
    }
    if cli.effects.explain {
        let plan = plan_costs::explained(&mut bsp, sidecar, textures, &settings)
            .with_context(|| path.display().to_string())?;
        print!("{plan}");
        return Ok(());
    }
    if cli.accuracy.estimate {
        let estimated = aim::estimate(&mut bsp, sidecar, textures, &settings)
            .with_context(|| path.display().to_string())?;
        print!("{}", crate::estimate_table::of_map(&estimated));
        return Ok(());
    }
    if let Some(folder) = &cli.accuracy.sweep {
        let bytes = [read(path)?, read_optional(cli.accuracy.truth.as_deref())?];
        let truth = match &cli.accuracy.truth {
            Some(path) => Some(sweep::map_truth(
                &String::from_utf8_lossy(&bytes[1]),
                &path.display().to_string(),
            )?),
            None => None,
        };
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let bytes: Vec<&[u8]> = bytes
            .iter()
            .map(Vec::as_slice)
            .chain(
                [texinfo.as_deref(), content.as_deref()].iter().map(|t| t.unwrap_or("").as_bytes()),
            )
            .collect();
        let mut bench =
            sweep::MapBench::new(&name, bsp, (sidecar, textures), settings, truth, &bytes);
        return crate::sweep_job::run(folder, &mut bench, cli.quiet, visible);
    }
    // A map that goes elsewhere has nothing to do with what lies there.
    let luxels = if target == path { bsp.lighting.len() } else { 0 };
    let progress = Progress::new(visible);
    let mut keep = |bsp: &Bsp, files: &Files| {
        if settings.keep_partial {
            let _whole = writing.lock();
            if let Err(error) = write_files(target, bsp, files, &settings.outputs) {
                log::warn!("{error}");
            }
        }
    };
    let lit =
        light_bsp_in_steps(&mut bsp, sidecar, textures.clone(), &settings, &progress, &mut keep)
            .with_context(|| path.display().to_string())?;
    for sentence in &lit.scene.warnings {
        log::warn!("{sentence}");
    }
    note_damaged_lit(&target.with_extension("lit"), luxels);
    let whole = writing.lock();
    let mut written = write_files(target, &bsp, &lit.files, &settings.outputs)?;
    if cli.exportobj {
        output::write(&obj, export::obj(&lit.scene).as_bytes())?;
        written.push(obj);
    }
    if cli.surflight_dump {
        let path = surface_light_path(target);
        output::write(&path, export::surface_lights(&lit.scene).as_bytes())?;
        written.push(path);
    }
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
        let (decoupled, grid) = (lit.scene.decoupled, lit.scene.light_grid.is_some());
        for sentence in engine.unread(&settings.outputs, decoupled, grid) {
            log::warn!("{sentence}");
        }
    }
    let mut report = Report::new();
    for sentence in &lit.choices {
        report.row("chosen", sentence);
    }
    lit.counts.print(&mut report);
    report.accuracy(&lit.checked);
    let stages = progress.stages();
    if lit.checked.0.is_some() && settings.aim == aim::Aim::Settings {
        let seconds = progress.elapsed().as_secs_f64();
        let half = aim::half_error(&settings, &lit.counts, &stages, seconds);
        report.half_error(half.map(|h| h.0));
    }
    report.resources(&stages, start.elapsed());
    for file in written {
        report.row("written", file.display());
    }
    if let Some(file) = &cli.accuracy.report {
        let mut all = RunReport::new(path, &report, &stages, start.elapsed(), lit.checked.clone());
        all.settings = settings.describe();
        all.choices = lit.choices.clone();
        let mut plan = qrad::plan(&lit.scene, &settings);
        plan_costs::measured(&mut plan, &lit.counts, &stages, &settings);
        all.plan = plan.to_string();
        let (pictures, _) = lightmap::atlases(&lit.faces, &sizes(&lit));
        let named = |(style, picture)| (format!("Lightmaps of style {style}"), picture);
        all.pictures = pictures.into_iter().map(named).collect();
        let _whole = writing.lock();
        all.write(file)?;
        report.row("written", file.display());
    }
    if !cli.quiet {
        if let Some(engine) = cli.outputs.engine {
            println!("{}", engine.choice());
        }
        print!("{report}");
    }
    Ok(())
}

/// The command line with what worldspawn asks for before it, so that the command line wins; `None` if the
/// map asks for nothing, or for what does not go with the command line.
fn with_options_of_map(world: &Entity, args: &[OsString]) -> Option<Cli> {
    let own = legacy_args::of_worldspawn(world, &Cli::command());
    let (name, rest) = args.split_first()?;
    let all = std::iter::once(name).chain(&own).chain(rest);
    match Cli::try_parse_from(all) {
        _ if own.is_empty() => None,
        Ok(cli) => Some(cli),
        Err(_) => {
            log::warn!(
                "options in worldspawn do not go with those given, and are ignored: {own:?}"
            );
            None
        }
    }
}

/// Says so when the `.lit` file that is about to be replaced is none, or not that of a lighting lump of
/// `luxels` bytes; 0 if that is not known.
fn note_damaged_lit(path: &Path, luxels: usize) {
    let Ok(bytes) = std::fs::read(path) else { return };
    let colours = match (read_lit(&bytes), read_hdr_lit(&bytes)) {
        (Ok(rgb), _) => rgb.len() / 3,
        (_, Ok(hdr)) => hdr.len(),
        (Err(error), Err(_)) => {
            log::warn!("{}: {error}; it is replaced", path.display());
            return;
        }
    };
    if luxels != 0 && colours != luxels {
        let path = path.display();
        log::warn!("{path}: {colours} colours for {luxels} luxels of the map; it is replaced");
    }
}

fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))
}

/// A file, or nothing for no path.
pub(crate) fn read_optional(path: Option<&Path>) -> anyhow::Result<Vec<u8>> {
    path.map_or(Ok(Vec::new()), read)
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

/// Finds out what cannot be written before the long work, and before anything has been written.
fn check_outputs(cli: &Cli, map: &Path, target: &Path, settings: &Settings) -> qrad::Result<()> {
    let outputs = &settings.outputs;
    let entities_only = outputs.scope == Scope::EntitiesOnly;
    let lit = target.with_extension("lit");
    let lux = target.with_extension(outputs.lux.extension().unwrap_or("lux"));
    let obj = target.with_extension("obj");
    let lights = surface_light_path(target);
    let files = [
        (outputs.writes_map(), target),
        (!outputs.writes_map() && !entities_only, &lit),
        (outputs.lux.extension().is_some(), &lux),
        (cli.exportobj || cli.phongdebug_obj, &obj),
        (cli.surflight_dump, &lights),
    ];
    let files = files.into_iter().filter_map(|(wanted, path)| wanted.then_some(path));
    let files: Vec<&Path> = files.chain(cli.preview.as_deref()).collect();
    let files: Vec<&Path> = files.into_iter().chain(cli.accuracy.report.as_deref()).collect();
    cli.accuracy.report.as_deref().map_or(Ok(()), run_report::check_name)?;
    files.iter().try_for_each(|path| output::check_writable(path))?;
    // The map may be replaced by itself. A `.lit` file may come or go.
    let lit = (outputs.writes_map() && !entities_only).then_some(lit.as_path());
    let inputs = cli.wad.iter().chain(&cli.radlights).chain(&cli.materials);
    let inputs = inputs.map(PathBuf::as_path);
    let inputs: Vec<&Path> = inputs.chain((target != map).then_some(map)).collect();
    output::check_distinct(&files.iter().copied().chain(lit).collect::<Vec<_>>(), &inputs)?;
    settings.cache.as_ref().map_or(Ok(()), Cache::check)?;
    cli.dump_lightmaps.as_deref().map_or(Ok(()), output::check_folder)
}

/// `<map>-surflights.map`.
fn surface_light_path(map: &Path) -> PathBuf {
    let mut name = map.file_stem().unwrap_or_default().to_owned();
    name.push("-surflights.map");
    map.with_file_name(name)
}

/// Lights of textures from files beside the map and from those that the command line names.
#[derive(Default)]
struct TextureLights {
    /// Names and texts of `.rad` files.
    rad: Vec<(String, String)>,
    /// Text of `.ent` files.
    lights: String,
}

impl TextureLights {
    /// Reads `lights.rad` in the current folder or else beside the map, then `<map>.rad`, then the files
    /// that the command line names.
    fn read(cli: &Cli, map: &Path) -> anyhow::Result<Self> {
        let common = [PathBuf::from("lights.rad"), map.with_file_name("lights.rad")];
        let common = common.into_iter().find(|p| p.is_file());
        let own = Some(map.with_extension("rad")).filter(|p| p.is_file());
        let mut files = Self::default();
        for path in common.into_iter().chain(own).chain(cli.radlights.iter().cloned()) {
            let is_entities = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ent"));
            let bytes = read(&path)?;
            let text = String::from_utf8_lossy(&bytes);
            if is_entities {
                files.lights.push_str(&text);
                files.lights.push('\n');
            } else {
                files.rad.push((path.display().to_string(), text.into_owned()));
            }
        }
        Ok(files)
    }
}

/// The material file that the command line names, or else `<map>.materials.toml`.
fn materials(cli: &Cli, map: &Path) -> anyhow::Result<Option<MaterialFile>> {
    let named = cli
        .materials
        .clone()
        .or_else(|| Some(map.with_extension("materials.toml")).filter(|p| p.is_file()));
    let Some(path) = named else { return Ok(None) };
    let text = String::from_utf8(read(&path)?)
        .with_context(|| format!("{}: not UTF-8 text", path.display()))?;
    Ok(Some(MaterialFile::parse(&text, &path.display().to_string())?))
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
        let folders = cli.path.iter().flat_map(|folder| {
            [folder.join(&name), folder.join(beside.file_name().unwrap_or_default())]
        });
        let found = [map.with_file_name(&name), beside.clone()].into_iter().chain(folders);
        let found = found.into_iter().find(|p| p.is_file());
        match found.map(|p| Ok::<_, anyhow::Error>((load_wad(&read(&p)?), p))).transpose()? {
            Some((Ok(more), _)) => textures.extend(more),
            Some((Err(e), path)) => log::warn!("{}: {e}", path.display()),
            None => log::warn!("{name}: the WAD file that worldspawn names is not here"),
        }
    }
    Ok(textures)
}

/// Replaces the map and the files beside it. With a new map, stale files of the kinds that there are
/// not to be go. A device or a pipe gets the map alone.
fn write_files(
    path: &Path,
    bsp: &Bsp,
    files: &Files,
    outputs: &Outputs,
) -> qrad::Result<Vec<PathBuf>> {
    let map = if outputs.writes_map() { Some(bsp.write()?) } else { None };
    if let Some(map) = map.as_ref().filter(|_| output::is_special(path)) {
        output::write(path, map)?;
        return Ok(vec![path.to_path_buf()]);
    }
    let lux = |name| files.lux.as_ref().filter(|_| outputs.lux.extension() == Some(name));
    let kinds = DirectionFile::EXTENSIONS.map(|name| (name, lux(name)));
    let (mut written, mut stale) = (Vec::new(), Vec::new());
    for (extension, file) in std::iter::once(("lit", files.lit.as_ref())).chain(kinds) {
        let path = path.with_extension(extension);
        match file {
            Some(file) => written.push((path, file)),
            None if map.is_some() => stale.push(path),
            None => {}
        }
    }
    if let Some(map) = &map {
        written.push((path.to_path_buf(), map));
    }
    stale.iter().try_for_each(|path| output::check_replaceable(path))?;
    let borrowed: Vec<_> = written.iter().map(|(path, file)| (&**path, &file[..])).collect();
    output::write_all(&borrowed)?;
    stale.iter().try_for_each(|path| output::remove(path))?;
    // The map first.
    Ok(written.into_iter().rev().map(|(path, _)| path).collect())
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
    lightmap::dump(folder, &lit.faces, &sizes(lit))
}

/// Width and height of each face's lightmap.
fn sizes(lit: &MapLight) -> Vec<[u32; 2]> {
    let grids = lit.scene.surfaces.iter().map(|s| s.luxels.as_ref());
    grids.map(|g| g.map_or([0; 2], |g| [g.width, g.height])).collect()
}
