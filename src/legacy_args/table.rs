//! The options of ericw-tools `light` (contract sections 9.2 and 9.3), one row each.

use Effect::{Bounces, Help, Ignored, Key, Off, Own, Search, Threads, View};
use Values::{Number, OptionalNumber, Switch, Text, UpToThree, Vector, Word};

/// What may or must follow an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Values {
    /// Nothing, or `0` or `-1` for off, or `1` for on.
    Switch,
    /// A number.
    Number,
    /// Perhaps a number.
    OptionalNumber,
    /// Three numbers, as three arguments or as one.
    Vector,
    /// One to three numbers, as so many arguments or as one.
    UpToThree,
    /// One of these words in any case, or an integer that stands for it.
    Word(&'static [&'static str]),
    /// Any text.
    Text,
}

/// What an option does here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Sets the worldspawn key of its name.
    Key,
    /// Stands for this long option, if `qrad` has it; if not, the sentence says what is missing.
    Own(&'static str, &'static str),
    /// Nothing, for this reason.
    Ignored(&'static str),
    /// Sets the worldspawn key of this name to 0.
    Off(&'static str),
    /// This view: `--debug`.
    View(&'static str),
    /// The most bounces: `--bounces`.
    Bounces,
    /// `--wad` for WAD files, `--path` for folders.
    Search,
    /// `--threads`, where 0 is all cores.
    Threads,
    /// `--help`.
    Help,
}

/// An option of the reference.
#[derive(Clone, Copy, Debug)]
pub struct LegacyOption {
    /// Its name and other names for it, without dashes.
    pub names: &'static [&'static str],
    /// What follows it.
    pub values: Values,
    /// What it does here.
    pub effect: Effect,
}

const fn row(names: &'static [&'static str], values: Values, effect: Effect) -> LegacyOption {
    LegacyOption { names, values, effect }
}

const SUPERSAMPLING: &str = "supersampling is not built yet";
const NO_DUMP: &str =
    "single faces are not printed; --dump-lightmaps shows every face by its number";
const LOG_FILE: &str = "qrad writes no log file";
const GAME: &str = "qrad needs no game folder; --wad and --path name textures";

/// Every option, in the order of the contract.
pub const OPTIONS: &[LegacyOption] = &[
    // Worldspawn settings.
    row(&["dist"], Number, Key),
    row(&["range"], Number, Key),
    row(&["anglescale", "anglesense"], Number, Key),
    row(&["gamma"], Number, Key),
    row(&["addmin"], Switch, Key),
    row(&["light", "minlight"], Number, Key),
    row(&["minlight_color", "mincolor"], Vector, Key),
    row(&["minlight_mottle", "minlightMottle"], OptionalNumber, Key),
    row(&["maxlight"], Number, Key),
    row(&["spotlightautofalloff"], Switch, Key),
    row(&["compilerstyle_start"], Number, Key),
    row(&["compilerstyle_max"], Number, Key),
    row(&["dirt", "dirty"], Switch, Key),
    row(&["dirtmode"], Number, Key),
    row(&["dirtdepth"], Number, Key),
    row(&["dirtscale"], Number, Key),
    row(&["dirtgain"], Number, Key),
    row(&["dirtangle"], Number, Key),
    row(&["minlight_dirt"], Switch, Key),
    row(&["sunlight_dirt"], Switch, Key),
    row(&["sunlight2_dirt"], Switch, Key),
    row(&["phong"], Switch, Key),
    row(&["phong_angle"], Number, Key),
    row(&["bounce"], OptionalNumber, Bounces),
    row(&["bouncestyled"], Switch, Key),
    row(&["nobouncestyled"], Switch, Off("bouncestyled")),
    row(&["bouncescale"], Number, Key),
    row(&["bouncecolorscale"], Number, Key),
    row(&["bouncelightsubdivision"], Number, Ignored("--patch-size says how finely light bounces")),
    row(&["surflightscale"], Number, Key),
    row(&["surflightskyscale"], Number, Key),
    row(&["surflightskydist"], Number, Key),
    row(&["surflightsubdivision", "choplight"], Number, Key),
    row(&["surflight_minlight_scale"], Number, Key),
    row(&["surflight_atten"], Number, Ignored("it acts only through the file that qbsp writes")),
    row(&["surflight_radiosity"], Number, Key),
    row(&["sky_surface", "sun_surface"], Vector, Key),
    row(&["sunlight", "sun_light"], Number, Key),
    row(&["sunlight_color", "sun_color"], Vector, Key),
    row(&["sunlight_mangle", "sun_mangle", "sun_angle"], UpToThree, Key),
    row(&["sun2"], Number, Key),
    row(&["sun2_color"], Vector, Key),
    row(&["sun2_mangle"], UpToThree, Key),
    row(&["sunlight2"], Number, Key),
    row(&["sunlight2_color", "sunlight_color2"], Vector, Key),
    row(&["sunlight3"], Number, Key),
    row(&["sunlight3_color", "sunlight_color3"], Vector, Key),
    row(&["sunlight_penumbra"], Number, Key),
    // Quality and speed.
    row(&["extra"], Switch, Own("extra", SUPERSAMPLING)),
    row(&["extra4"], Switch, Own("extra4", SUPERSAMPLING)),
    row(&["soft"], OptionalNumber, Own("soft", "blur is not built yet")),
    row(&["gate"], Number, Key),
    row(&["sunsamples"], Number, Key),
    row(&["surflight_subdivide"], Number, Key),
    row(&["emissivequality"], Word(&["low", "medium", "high"]), Key),
    row(
        &["visapprox"],
        Word(&["auto", "none", "vis", "rays"]),
        Ignored("qrad needs no culling hints"),
    ),
    row(&["novisapprox"], Switch, Ignored("qrad needs no culling hints")),
    row(&["threads"], Number, Threads),
    row(&["lowpriority"], Switch, Ignored("qrad leaves its priority to the system")),
    // Outputs.
    row(&["lit"], Switch, Own("lit", "a .lit file is written whenever light has colour")),
    row(&["lit2"], Switch, Own("lit2", "")),
    row(&["hdr"], Switch, Own("hdr", "")),
    row(&["lux"], Switch, Own("lux", "")),
    row(&["bspxlit"], Switch, Own("bspxlit", "")),
    row(&["bspxlux"], Switch, Own("bspxlux", "")),
    row(&["bspxhdr"], Switch, Own("bspxhdr", "")),
    row(&["bspx"], Switch, Own("bspx", "")),
    row(&["bspxonly"], Switch, Own("bspxonly", "")),
    row(&["novanilla"], Switch, Own("novanilla", "the map always gets plain lightmaps so far")),
    row(&["litonly"], Switch, Own("litonly", "the map itself is always lit so far")),
    row(&["onlyents"], Switch, Own("onlyents", "the map is always lit as a whole so far")),
    row(&["nolights"], Switch, Key),
    row(&["nolighting"], Switch, Key),
    row(&["facestyles"], Number, Own("facestyles", "more than 4 styles a face are not built yet")),
    row(&["lightmap_scale", "lmscale"], Number, Key),
    row(&["lmshift"], Number, Own("lmshift", "a luxel size for single faces is not built yet")),
    row(
        &["world_units_per_luxel"],
        Number,
        Own("world-units-per-luxel", "decoupled lightmaps are not built yet"),
    ),
    row(&["lightgrid"], Switch, Key),
    row(&["lightgrid_dist"], Vector, Key),
    row(&["lightgrid_format"], Word(&["octree", "lightgrids"]), Key),
    row(&["lightgrid_force"], Switch, Key),
    row(&["wrnormals"], Switch, Own("wrnormals", "")),
    row(&["exportobj"], Switch, Own("exportobj", "")),
    row(&["surflight_dump"], Switch, Own("surflight-dump", "")),
    row(&["radlights"], Text, Own("radlights", "")),
    row(&["arghradcompat"], Switch, Ignored("it is for Quake II")),
    row(&["q2rtx"], Switch, Ignored("it is for Quake II")),
    // Debug pictures.
    row(&["dirtdebug", "debugdirt"], Switch, View("dirt")),
    row(&["phongdebug"], Switch, View("phong")),
    row(&["phongdebug_obj"], Switch, Own("phongdebug-obj", "")),
    row(&["bouncedebug"], Switch, View("bounce")),
    row(&["bouncelightsdebug"], Switch, View("bounce-lights")),
    row(&["debugoccluded"], Switch, View("occluded")),
    row(
        &["debugneighbours"],
        Switch,
        Ignored(
            "luxels that lie on other faces are not marked; -debugoccluded marks those in solid",
        ),
    ),
    row(&["debugmottle"], Switch, View("mottle")),
    row(
        &["debug_lightgrid_octree"],
        Switch,
        Own("debug-lightgrid-octree", "the tree of a light grid is not printed"),
    ),
    row(&["debugface"], Vector, Ignored(NO_DUMP)),
    row(&["debugvert"], Vector, Ignored(NO_DUMP)),
    row(&["highlightseams"], Switch, Ignored("seams are not marked; --dump-lightmaps shows them")),
    // Messages.
    row(&["log"], Switch, Ignored(LOG_FILE)),
    row(&["nolog"], Switch, Ignored(LOG_FILE)),
    row(&["logfile"], Text, Ignored(LOG_FILE)),
    row(&["logappend"], Switch, Ignored(LOG_FILE)),
    row(&["verbose", "v"], Switch, Own("verbose", "")),
    row(&["nopercent"], Switch, Ignored("progress is shown on terminals only")),
    row(&["nostat"], Switch, Ignored("--quiet hides the table at the end")),
    row(&["noprogress"], Switch, Ignored("progress is shown on terminals only")),
    row(&["nocolor"], Switch, Ignored("messages have no colour")),
    row(&["quiet", "noverbose"], Switch, Own("quiet", "")),
    row(&["help", "h", "?"], Switch, Help),
    // Where to look for files.
    row(&["path"], Text, Search),
    row(&["gamedir"], Text, Ignored(GAME)),
    row(&["basedir"], Text, Ignored(GAME)),
    row(&["filepriority"], Word(&["loose", "archive"]), Ignored(GAME)),
    row(&["defaultpaths"], Switch, Ignored(GAME)),
    row(&["nodefaultpaths"], Switch, Ignored(GAME)),
    row(&["tex_saturation_boost"], Number, Key),
];
