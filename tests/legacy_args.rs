//! The command line of ericw-tools `light`, as `qrad` takes it.

mod support;

use clap::{Command, CommandFactory};
use qrad::bsp::Format;
use qrad::cli::{BounceCount, Cli};
use qrad::legacy_args::{Effect, LegacyOption, OPTIONS, Values, describe, rewrite};
use std::collections::{BTreeSet, HashSet};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use support::map_builder::MapBuilder;
use support::program::{arg, qrad};
use tempfile::TempDir;

/// Options that other versions of the reference have, or that its documentation names.
const OTHERS: &str = "nobouncestyled novisapprox lmscale lightgrid_force";

/// Every option of the contract's sections 9.2 and 9.3.
const CONTRACT: &str = "dist range anglescale anglesense gamma addmin light minlight \
    minlight_color mincolor minlight_mottle minlightMottle maxlight spotlightautofalloff \
    compilerstyle_start compilerstyle_max dirt dirty dirtmode dirtdepth dirtscale dirtgain \
    dirtangle minlight_dirt sunlight_dirt sunlight2_dirt phong phong_angle bounce bouncestyled \
    bouncescale bouncecolorscale bouncelightsubdivision surflightscale surflightskyscale \
    surflightskydist surflightsubdivision choplight surflight_minlight_scale surflight_atten \
    surflight_radiosity sky_surface sun_surface sunlight sun_light sunlight_color sun_color \
    sunlight_mangle sun_mangle sun_angle sun2 sun2_color sun2_mangle sunlight2 sunlight2_color \
    sunlight_color2 sunlight3 sunlight3_color sunlight_color3 sunlight_penumbra \
    extra extra4 soft gate sunsamples surflight_subdivide emissivequality visapprox threads \
    lowpriority lit lit2 hdr lux bspxlit bspxlux bspxhdr bspx bspxonly novanilla litonly onlyents \
    nolights nolighting facestyles lightmap_scale lmshift world_units_per_luxel lightgrid \
    lightgrid_dist lightgrid_format wrnormals exportobj surflight_dump radlights arghradcompat \
    q2rtx dirtdebug debugdirt phongdebug phongdebug_obj bouncedebug bouncelightsdebug \
    debugoccluded debugneighbours debugmottle debug_lightgrid_octree debugface debugvert \
    highlightseams log nolog logfile logappend verbose v nopercent nostat noprogress nocolor quiet \
    noverbose path gamedir basedir filepriority defaultpaths nodefaultpaths tex_saturation_boost \
    help h ?";

fn own() -> Command {
    let mut command = Cli::command();
    command.build();
    command
}

fn rewritten(line: &str) -> qrad::Result<(Vec<OsString>, Vec<String>)> {
    let args = ["qrad"].into_iter().chain(line.split_whitespace()).map(OsString::from).collect();
    rewrite(args, &Cli::command())
}

/// The arguments after the program's name, and the notes.
#[track_caller]
fn pass(line: &str) -> (Vec<String>, Vec<String>) {
    let (args, notes) = rewritten(line).unwrap_or_else(|e| panic!("{line}: {e}"));
    (args.into_iter().skip(1).map(|a| a.into_string().unwrap()).collect(), notes)
}

/// Arguments without notes.
#[track_caller]
fn args(line: &str) -> Vec<String> {
    let (args, notes) = pass(line);
    assert!(notes.is_empty(), "{line}: {notes:?}");
    args
}

#[track_caller]
fn error(line: &str) -> String {
    rewritten(line).expect_err(line).to_string()
}

fn sample(values: Values) -> &'static str {
    match values {
        Values::Switch | Values::OptionalNumber => "",
        Values::Number => "3",
        Values::Vector => "1 2 3",
        Values::UpToThree => "45 -60",
        Values::Word(words) => words[0],
        Values::Text => "textures",
    }
}

#[test]
fn the_table_has_the_options_of_the_contract_once_each() {
    let ours: Vec<&str> = OPTIONS.iter().flat_map(|o| o.names).copied().collect();
    let set: BTreeSet<&str> = ours.iter().copied().collect();
    assert_eq!(set.len(), ours.len(), "a name occurs twice");
    assert_eq!(set, CONTRACT.split_whitespace().chain(OTHERS.split_whitespace()).collect());
}

#[test]
fn the_list_above_is_that_of_the_contract() {
    let Some(shared) = support::shared_dir() else { return };
    let contract = std::fs::read_to_string(shared.join("design/quake-lighting.md")).unwrap();
    let part = contract.split("### 9.2").nth(1).unwrap().split("### 9.4").next().unwrap();
    let rows = part.lines().filter(|l| l.starts_with("| `"));
    let cells = rows.map(|row| row.replace("\\|", " or ").split('|').nth(1).unwrap().to_owned());
    let named: BTreeSet<String> = cells
        .flat_map(|cell| cell.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>())
        .map(|code| code.split(' ').next().unwrap().trim_start_matches('-').to_owned())
        .collect();
    let listed: BTreeSet<String> = CONTRACT
        .split_whitespace()
        .filter(|n| !["help", "h", "?"].contains(n))
        .map(str::to_owned)
        .collect();
    assert_eq!(named, listed);
}

#[test]
fn every_option_maps_or_has_its_one_line() {
    let own = own();
    for option in OPTIONS {
        for (name, dashes) in option.names.iter().zip(["-", "---", "-", "-"]) {
            if ["v", "h"].contains(name) {
                continue;
            }
            let (args, notes) = pass(&format!("{dashes}{name} {} map.bsp", sample(option.values)));
            assert_eq!(args.last().unwrap(), "map.bsp", "{name} takes no file name");
            let words = if matches!(option.effect, Effect::Search) { 2 } else { 1 };
            assert_eq!(args.len() - 1 + notes.len(), words, "{name}: {args:?} {notes:?}");
            for note in &notes {
                assert!(note.starts_with(&format!("{dashes}{name}: ")), "{note}");
                assert!(note.len() > name.len() + 20 && !note.contains('\n'), "{note}");
            }
            if name != &"help" && name != &"?" {
                let parsed = own.clone().try_get_matches_from([vec!["qrad".into()], args].concat());
                assert!(parsed.is_ok(), "{name}: {}", parsed.unwrap_err());
            }
        }
    }
}

#[test]
fn options_that_set_a_key_set_one_that_the_scene_reads() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/scene");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let source: String = files
        .filter(|path| path.is_file() && !path.ends_with("overrides.rs"))
        .map(|path| std::fs::read_to_string(path).unwrap())
        .collect();
    for option in OPTIONS.iter().filter(|o| o.effect == Effect::Key) {
        let name = option.names[0];
        let read = source.contains(&format!("\"{name}\""));
        assert!(read, "nothing reads {name}");
    }
}

#[test]
fn later_options_win_and_lists_grow() {
    let line = "-bounce 3 --bounces 2 -path a.wad --wad b.wad -dist 2 --set range=1 -lit -lit map";
    let matches = own().try_get_matches_from([vec!["qrad".into()], pass(line).0].concat()).unwrap();
    assert_eq!(matches.get_one::<BounceCount>("bounces"), Some(&BounceCount::Most(2)));
    assert_eq!(matches.get_many::<PathBuf>("wad").unwrap().count(), 2);
    assert_eq!(matches.get_many::<(String, String)>("set").unwrap().count(), 2);
}

#[test]
fn options_that_stand_for_one_of_ours_want_as_many_values() {
    let own = own();
    for option in OPTIONS {
        let Effect::Own(long, missing) = option.effect else { continue };
        let Some(ours) = own.get_arguments().find(|a| a.get_long() == Some(long)) else {
            assert!(!missing.is_empty(), "--{long} is gone, and nothing says what is missing");
            continue;
        };
        let takes = ours.get_action().takes_values();
        assert_eq!(takes, option.values != Values::Switch, "--{long}");
    }
}

#[test]
fn file_names_that_begin_with_digits_are_file_names() {
    assert_eq!(args("-bounce 2fort.bsp"), ["--bounces=all", "2fort.bsp"]);
    assert_eq!(args("-bounce 2 2fort.bsp"), ["--bounces=2", "2fort.bsp"]);
    assert_eq!(args("-dirt 1.bsp"), ["--set=dirt=1", "1.bsp"]);
    assert_eq!(args("-sun_angle 45 2fort.bsp"), ["--set=sunlight_mangle=45", "2fort.bsp"]);
    assert_eq!(pass("-soft 1e1m1.bsp").0.last().unwrap(), "1e1m1.bsp");
    assert_eq!(pass("-bounce nan").0, ["--bounces=all", "nan"]);
    assert_eq!(pass("-bounce inf").0, ["--bounces=all", "inf"]);
}

#[test]
fn values_become_values() {
    for (line, want) in [
        ("-bounce", "--bounces=all"),
        ("-bounce 0", "--bounces=0"),
        ("-bounce 3.9", "--bounces=3"),
        ("-bounce -5", "--bounces=0"),
        ("-bounce 1e9", "--bounces=100"),
        ("--bounce 4", "--bounces=4"),
        ("-threads 2.0", "--threads=2"),
        ("-bouncescale 0.5", "--set=bouncescale=0.5"),
        ("-bouncecolorscale 0", "--set=bouncecolorscale=0"),
        ("-bouncestyled 0", "--set=bouncestyled=0"),
        ("-nobouncestyled", "--set=bouncestyled=0"),
        ("-nobouncestyled 0", "--set=bouncestyled=1"),
        ("-lmscale 2", "--set=lightmap_scale=2"),
        ("-debugdirt", "--debug=dirt"),
        ("-phongdebug -bouncedebug 1", "--debug=bounce"),
        ("-path id1", "--path id1"),
        ("-dirt", "--set=dirt=1"),
        ("-dirty -1", "--set=dirt=-1"),
        ("-phong 0", "--set=phong=0"),
        ("-minlight -20", "--set=light=-20"),
        ("-minlightMottle", "--set=minlight_mottle=1"),
        ("-sunlight_color2 255 128 0", "--set=sunlight2_color=255 128 0"),
        ("-sun_mangle 45 -60", "--set=sunlight_mangle=45 -60"),
        ("-nolights", "--set=nolights=1"),
        ("-nolights 0", "--set=nolights=0"),
        ("-emissivequality HIGH", "--set=emissivequality=HIGH"),
        ("-noverbose", "--quiet"),
        ("-?", "--help"),
    ] {
        assert_eq!(args(line).join(" "), want, "{line}");
    }
    for nothing in ["-threads 0", "-dirtdebug 0", "-quiet 0", "-lux 0", "-q2rtx -1"] {
        assert!(args(nothing).is_empty(), "{nothing}");
    }
    let quoted = ["qrad", "-sunlight_color", "1 0.5 0", "-sun2_mangle", "0 -90"];
    let (args, _) = rewrite(quoted.map(OsString::from).to_vec(), &own()).unwrap();
    assert_eq!(args[1..], ["--set=sunlight_color=1 0.5 0", "--set=sun2_mangle=0 -90"]);
    let both = ["--wad", "a/gfx.WAD", "--path", "id1"];
    assert_eq!(pass("-path a/gfx.WAD -path id1").0, both);
}

#[test]
fn our_own_options_stay_as_they_are() {
    for line in [
        "-o -dirt map.bsp",
        "-q -v -h -V map",
        "--camera -1,2,3,-4,5 --output=-x --set _light=4 --grey",
        "--threads 2 --bounces 0 --quiet -- -dirt -nosuch",
        "- map",
        "",
    ] {
        assert_eq!(args(line), line.split_whitespace().collect::<Vec<_>>());
    }
    assert_eq!(args("--quiet -quiet 0"), [""; 0], "a later option wins");
}

#[cfg(unix)]
#[test]
fn file_names_need_not_be_text() {
    use std::os::unix::ffi::OsStringExt;
    let odd = |bytes: &[u8]| OsString::from_vec(bytes.to_vec());
    let given = vec!["qrad".into(), "-dirt".into(), odd(b"-\xff"), odd(b"\xfe.bsp")];
    let (args, _) = rewrite(given, &own()).unwrap();
    assert_eq!(args[1..], ["--set=dirt=1".into(), odd(b"-\xff"), odd(b"\xfe.bsp")]);
    assert_eq!(rewrite(Vec::new(), &own()).unwrap().0.len(), 0);
}

#[test]
fn unknown_options_name_the_nearest() {
    for (line, near) in [
        ("-bonce 3", "did you mean -bounce?"),
        ("-extra5", "did you mean -extra?"),
        ("-Dirt", "did you mean -dirt?"),
        ("-onlyent", "did you mean -onlyents?"),
        ("--hemicub=16", "did you mean --hemicube?"),
        ("-bounces 3", "did you mean --bounces?"),
        ("-overture", "qrad --help lists the options"),
        ("-7", "there is no such option"),
    ] {
        let message = error(line);
        assert!(message.contains(near), "{line}: {message}");
        assert!(message.contains(line.split(' ').next().unwrap()), "{message}");
    }
}

#[test]
fn missing_values_are_asked_for() {
    for option in OPTIONS {
        if matches!(option.values, Values::Switch | Values::OptionalNumber) {
            continue;
        }
        let name = option.names[0];
        for line in [format!("-{name}"), format!("-{name} -quiet")] {
            let message = error(&line);
            assert!(message.contains(name) && message.contains("give "), "{message}");
        }
    }
    assert!(error("-sunlight_color 1 2 map.bsp").contains("three numbers"));
    assert!(error("-visapprox often").contains("auto or none or vis or rays"));
    assert!(error("-gate 1x").contains("a number"));
}

proptest::proptest! {
    #[test]
    fn any_line_is_rewritten_or_refused(line in "(-{0,3}(dirt|bounce|sun2_color|path|visapprox|set|o|x|[a-z?=]{0,6}|-?[0-9.e]{1,4}) ){0,8}") {
        if let Ok((args, notes)) = rewritten(&line) {
            let given = line.split_whitespace().count();
            proptest::prop_assert!(args.len() <= given + 2 && notes.len() <= given);
        }
    }
}

/// A small room with a sky, a lamp and a surface in the sun.
fn map() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("2room.bsp");
    let bsp = MapBuilder::room([0.0; 3], [256.0, 192.0, 160.0])
        .solid_texture("wall", 9)
        .solid_texture("sky1", 0)
        .flags(1)
        .room_textures([0, 0, 0, 0, 0, 1])
        .pillar([64.0, 64.0, 0.0], [96.0, 96.0, 64.0], 0)
        .entities(
            "{\n\"classname\" \"worldspawn\"\n\"_sunlight\" \"80\"\n\"_sunlight_penumbra\" \"20\"\n}\n\
             {\n\"classname\" \"light\"\n\"origin\" \"160 96 100\"\n\"light\" \"200\"\n}\n",
        )
        .build(Format::Bsp29);
    std::fs::write(&path, bsp.write().unwrap()).unwrap();
    (folder, path)
}

/// The map as a command line lights it, and what the run said.
#[track_caller]
fn light(map: &Path, line: &str) -> (Vec<u8>, String) {
    let out = map.with_file_name("out.bsp");
    let words = line.split_whitespace();
    let run = qrad().args(words).args(["-o", arg(&out), arg(map)]).assert().success();
    let said = String::from_utf8(run.get_output().stderr.clone()).unwrap();
    (std::fs::read(&out).unwrap(), said)
}

#[test]
fn the_command_lines_of_librequake_light_a_map() {
    let (_folder, map) = map();
    let before = std::fs::read(&map).unwrap();
    let words: Vec<&str> = "-extra4 -bounce -soft -dirt".split(' ').collect();
    let run = qrad().args(&words).arg(&map).assert().success();
    let said = String::from_utf8(run.get_output().stderr.clone()).unwrap();
    assert!(!said.contains("error"), "{said}");
    let after = qrad::bsp::Bsp::read(&std::fs::read(&map).unwrap()).unwrap();
    assert!(qrad::bsp::Bsp::read(&before).unwrap().lighting.is_empty());
    assert!(after.lighting.iter().any(|&level| level > 20), "the map is lit in place");
}

#[test]
fn notes_are_one_line_each_and_quiet_hides_them() {
    let (_folder, map) = map();
    let (_, said) = light(&map, "-bounce 0 -visapprox none -lowpriority -visapprox none");
    let about = |name: &str| said.lines().filter(|l| l.contains(name)).count();
    assert_eq!((about("-visapprox"), about("-lowpriority")), (1, 1), "{said}");
    let (_, said) = light(&map, "-bounce 0 -gate 30");
    assert_eq!(said.matches("gate: 30 drops").count(), 1, "{said}");
    let (_, said) = light(&map, "-bounce 0 -visapprox none -quiet");
    assert_eq!(said, "");
}

#[test]
fn options_do_what_their_translation_does() {
    let (_folder, map) = map();
    let plain = light(&map, "--bounces 0").0;
    for (legacy, ours, changes) in [
        ("-bounce 0", "--bounces 0", false),
        ("-bounce", "--bounces all", true),
        ("-bounce 3 -bounce 0", "--bounces 0", false),
        ("-bounce 0 -threads 1", "--bounces 0", false),
        ("-bounce 0 -sunlight_penumbra 0", "--bounces 0 --set _sunlight_penumbra=0", true),
        ("-bounce 0 -sunsamples 8", "--bounces 0 --set _sunsamples=8", true),
        ("-bounce 0 -sun_light 200", "--bounces 0 --set _sunlight=200", true),
        ("-bounce 0 -range 1", "--bounces 0 --set _range=1", true),
        ("-bounce 0 -gate 30", "--bounces 0 --set gate=30", true),
        ("-bounce 0 -nolights", "--bounces 0 --set nolights=1", true),
        ("-bounce 0 -nolights 0", "--bounces 0", false),
        ("-bounce 2 -bouncescale 0.5", "--bounces 2 --set _bouncescale=0.5", true),
    ] {
        let (a, b) = (light(&map, legacy).0, light(&map, ours).0);
        assert!(a == b, "{legacy} is not {ours}");
        assert_eq!(a != plain, changes, "{legacy} against --bounces 0");
    }
}

#[test]
fn without_lights_the_sun_still_shines() {
    let (_folder, map) = map();
    let lit = |line: &str| {
        let bsp = qrad::bsp::Bsp::read(&light(&map, line).0).unwrap();
        bsp.lighting.iter().map(|&level| u64::from(level)).sum::<u64>()
    };
    let [both, sun] = ["-bounce 0", "-bounce 0 -nolights"].map(lit);
    let (lamp, neither) = (lit("-bounce 0 -sunlight 0"), lit("-bounce 0 -nolights -sunlight 0"));
    assert!(sun > 0 && lamp > 0 && neither == 0 && both > sun.max(lamp), "{both} {sun} {lamp}");
}

#[test]
fn mistakes_end_the_run_with_a_line_and_change_nothing() {
    let (_folder, map) = map();
    let before = std::fs::read(&map).unwrap();
    for (line, word) in [("-bonce 3", "did you mean -bounce?"), ("-gate", "give a number")] {
        let output = qrad().arg(&map).args(line.split(' ')).assert().code(2).get_output().clone();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.starts_with("qrad: error: ") && said.contains(word), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
    assert!(std::fs::read(&map).unwrap() == before);
}

/// One row of the table in `docs/options.md`.
fn documented(option: &LegacyOption, own: &Command) -> String {
    let names: Vec<String> = option.names.iter().map(|n| format!("`-{n}`")).collect();
    let values = match option.values {
        Values::Switch => "[0\\|1]".into(),
        Values::Number => "n".into(),
        Values::OptionalNumber => "[n]".into(),
        Values::Vector => "x y z".into(),
        Values::UpToThree => "yaw [pitch [roll]]".into(),
        Values::Word(words) => words.join("\\|"),
        Values::Text => "path".into(),
    };
    format!("| {} | {values} | {} |", names.join(", "), describe(option, own))
}

#[test]
fn the_table_of_the_documentation_is_up_to_date() {
    let own = own();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/options.md");
    let text = std::fs::read_to_string(&path).unwrap();
    let rows: Vec<String> = OPTIONS.iter().map(|o| documented(o, &own)).collect();
    let table = format!("| option | value | here |\n|---|---|---|\n{}\n", rows.join("\n"));
    let start = text.find("| option |").expect("a table");
    let end = text[start..].find("\n\n").map_or(text.len(), |n| start + n + 1);
    if std::env::var_os("QRAD_WRITE_DOCS").is_some() {
        std::fs::write(&path, [&text[..start], &table, &text[end..]].concat()).unwrap();
        return;
    }
    let known: HashSet<&str> = text[start..end].lines().collect();
    for row in table.lines() {
        assert!(known.contains(row), "missing (QRAD_WRITE_DOCS=1 writes the table): {row}");
    }
    assert_eq!(&text[start..end], table);
}

#[test]
fn options_may_stand_in_worldspawn_and_the_command_line_wins() {
    let (folder, map) = map();
    let mut bsp = qrad::bsp::Bsp::read(&std::fs::read(&map).unwrap()).unwrap();
    let text = String::from_utf8(bsp.entities.clone()).unwrap();
    bsp.entities =
        text.replacen('}', "\"_extra4\" \"1\"\n\"_facestyles\" \"2\"\n}", 1).into_bytes();
    let keyed = folder.path().join("keyed.bsp");
    std::fs::write(&keyed, bsp.write().unwrap()).unwrap();
    let lighting = |map: &Path, line: &str| {
        let (bytes, said) = light(map, line);
        (qrad::bsp::Bsp::read(&bytes).unwrap().lighting, said)
    };
    let plain = lighting(&map, "-bounce 0").0;
    let (fine, said) = lighting(&keyed, "-bounce 0");
    assert_eq!(fine, lighting(&map, "-bounce 0 -extra4").0);
    assert!(fine != plain && said.is_empty(), "{said}");
    let (other, said) = lighting(&keyed, "-bounce 0 -extra");
    assert_eq!(other, lighting(&map, "-bounce 0 -extra").0);
    assert!(said.contains("extra4"), "{said}");
}
