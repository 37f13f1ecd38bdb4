//! The files that `qbsp` writes beside a map (contract section 1.5): `<map>.texinfo.json` with the
//! keys of brush entities that the BSP cannot hold, and `<map>.content.json` with exact leaf contents.

use super::extremes::limited_number;
use super::material_file::MaterialFile;
use glam::Vec3;
use serde_json::Value;

/// Text of the files beside a map, as far as they exist.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sidecar<'a> {
    /// `<map>.texinfo.json`.
    pub texinfo: Option<&'a str>,
    /// `<map>.content.json`.
    pub content: Option<&'a str>,
    /// Names and texts of `.rad` files.
    pub rad: &'a [(String, String)],
    /// Light entities that the map does not have itself, in the syntax of the entity lump.
    pub lights: Option<&'a str>,
    /// What textures do to light.
    pub materials: Option<&'a MaterialFile>,
}

/// Keys of one texinfo; the defaults stand for "not given".
#[derive(Clone, Debug, PartialEq)]
pub struct TexInfoKeys {
    /// Faces do not block light.
    pub no_shadow: bool,
    /// Faces do not send light back.
    pub no_bounce: bool,
    /// Faces receive no light from lights, suns and bounces.
    pub light_ignore: bool,
    /// Largest angle in degrees over which normals are smoothed; 0 is flat.
    pub phong_angle: f32,
    /// The same for concave edges; 0 means as `phong_angle`.
    pub phong_angle_concave: f32,
    /// Smoothing group.
    pub phong_group: i32,
    /// Surface-light templates of the same group apply.
    pub surflight_group: i32,
    /// Overrides whether faces are lit from both sides.
    pub light_twosided: Option<bool>,
    /// Opacity, 0 to 1.
    pub light_alpha: Option<f32>,
    /// Cap on luxels in levels; 0 is none.
    pub max_light: f32,
    /// Saturation of the light received, 0 (grey) to 1.
    pub colour_scale: f32,
    /// Channels of light that the faces receive.
    pub channel_mask: Option<i32>,
    /// Faces get no dirt.
    pub no_dirt: bool,
    /// Faces get no minimum light.
    pub no_minlight: bool,
    /// Minimum light in light units, at least 0.
    pub minlight: Option<f32>,
    /// Its colour, 0 to 255 a channel.
    pub minlight_colour: Option<Vec3>,
    /// What the faces say about the surface lights on them.
    pub surflight: SurflightKeys,
    /// World units from luxel to luxel, where lightmaps do not follow the texture.
    pub world_units_per_luxel: Option<f32>,
}

/// What a texinfo says about the surface lights on its faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurflightKeys {
    /// Whether the cosine laws at both ends are softened.
    pub rescale: Option<bool>,
    /// Light style.
    pub style: Option<u16>,
    /// Name whose switchable style is used, before `style`.
    pub targetname: Option<String>,
    /// Colour, 0 to 255 a channel, before that of the light and of the texture.
    pub colour: Option<Vec3>,
    /// Share of the brightness that the face glows with itself.
    pub minlight_scale: Option<f32>,
    /// Scale on distances.
    pub attenuation: Option<f32>,
}

impl Default for TexInfoKeys {
    fn default() -> Self {
        Self {
            no_shadow: false,
            no_bounce: false,
            light_ignore: false,
            phong_angle: 0.0,
            phong_angle_concave: 0.0,
            phong_group: 0,
            surflight_group: 0,
            light_twosided: None,
            light_alpha: None,
            max_light: 0.0,
            colour_scale: 1.0,
            channel_mask: None,
            no_dirt: false,
            no_minlight: false,
            minlight: None,
            minlight_colour: None,
            surflight: SurflightKeys::default(),
            world_units_per_luxel: None,
        }
    }
}

/// Keys per texinfo, `count` of them. An unusable text counts as absent and gives a warning, as in
/// the reference.
pub(crate) fn texinfo_keys(
    text: Option<&str>,
    count: usize,
    warnings: &mut Vec<String>,
) -> Vec<TexInfoKeys> {
    let mut keys = vec![TexInfoKeys::default(); count];
    let Some(text) = text else { return keys };
    let object = match serde_json::from_str::<Value>(text) {
        Ok(Value::Object(object)) => object,
        Ok(_) => {
            warnings.push("texinfo.json: not a JSON object; the file is ignored".into());
            return keys;
        }
        Err(e) => {
            warnings.push(format!("texinfo.json: {e}; the file is ignored"));
            return keys;
        }
    };
    let mut parsed = Vec::with_capacity(object.len());
    for (name, value) in &object {
        match name.parse::<usize>() {
            Ok(index) if index < count => parsed.push((index, value)),
            _ => {
                warnings.push(format!(
                    "texinfo.json: {name:?} is not a texinfo of this map, which has {count}; \
                     the file is ignored (is it from another build?)"
                ));
                return keys;
            }
        }
    }
    for (index, value) in parsed {
        keys[index] = read_keys(value);
    }
    keys
}

fn read_keys(value: &Value) -> TexInfoKeys {
    let flag = |name: &str| value.get(name).and_then(Value::as_bool);
    let number = |name: &str| value.get(name).and_then(Value::as_f64).map(limited_number);
    let integer = |name: &str| value.get(name).and_then(Value::as_i64).map(|v| v as i32);
    let colour = |name: &str| {
        let channels = value.get(name)?.as_array()?;
        let mut c = channels.iter().map(|v| v.as_f64().map(limited_number));
        match [c.next()??, c.next()??, c.next()??] {
            [0.0, 0.0, 0.0] => None,
            c => Some(Vec3::from(c)),
        }
    };
    let name = value.get("surflight_targetname").and_then(Value::as_str).filter(|n| !n.is_empty());
    TexInfoKeys {
        no_shadow: flag("no_shadow").unwrap_or(false),
        no_bounce: flag("no_bounce").unwrap_or(false),
        light_ignore: flag("light_ignore").unwrap_or(false),
        phong_angle: number("phong_angle").unwrap_or(0.0),
        phong_angle_concave: number("phong_angle_concave").unwrap_or(0.0),
        phong_group: integer("phong_group").unwrap_or(0),
        surflight_group: integer("surflight_group").unwrap_or(0),
        light_twosided: flag("light_twosided"),
        light_alpha: number("light_alpha"),
        max_light: number("maxlight").unwrap_or(0.0),
        colour_scale: number("lightcolorscale").unwrap_or(1.0),
        channel_mask: integer("object_channel_mask"),
        no_dirt: flag("no_dirt").unwrap_or(false),
        no_minlight: flag("no_minlight").unwrap_or(false),
        minlight: number("minlight"),
        minlight_colour: colour("minlight_color"),
        surflight: SurflightKeys {
            rescale: flag("surflight_rescale"),
            style: integer("surflight_style").map(|s| s.clamp(0, 65534) as u16),
            targetname: name.map(str::to_owned),
            colour: colour("surflight_color"),
            minlight_scale: number("surflight_minlight_scale"),
            attenuation: number("surflight_atten"),
        },
        world_units_per_luxel: number("world_units_per_luxel"),
    }
}

/// Which leafs are solid for samples and lights: from content.json when it is there and fits,
/// else from the leaf contents of the BSP (-2 solid, -6 sky).
pub(crate) fn solid_leafs(
    text: Option<&str>,
    contents: &[i32],
    warnings: &mut Vec<String>,
) -> Vec<bool> {
    let native = || contents.iter().map(|c| matches!(c, -2 | -6)).collect();
    let Some(text) = text else { return native() };
    match serde_json::from_str::<Vec<Vec<String>>>(text) {
        Ok(leafs) if leafs.len() == contents.len() => leafs
            .iter()
            .map(|names| {
                names.iter().any(|n| {
                    ["SOLID", "DETAIL_WALL", "SKY"].iter().any(|s| n.eq_ignore_ascii_case(s))
                })
            })
            .collect(),
        Ok(leafs) => {
            warnings.push(format!(
                "content.json: {} leafs, the map has {}; the file is ignored",
                leafs.len(),
                contents.len()
            ));
            native()
        }
        Err(e) => {
            warnings.push(format!("content.json: {e}; the file is ignored"));
            native()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(text: &str, count: usize) -> (Vec<TexInfoKeys>, Vec<String>) {
        let mut warnings = Vec::new();
        let keys = texinfo_keys(Some(text), count, &mut warnings);
        (keys, warnings)
    }

    #[test]
    fn members_are_read_and_others_keep_their_defaults() {
        let text = r#"{"0":{},"1":{"no_shadow":true,"phong_angle":89.0,"surflight_group":3,
            "minlight":25,"minlight_color":[10,20,30],"world_units_per_luxel":8}}"#;
        let (keys, warnings) = keys(text, 2);
        assert!(warnings.is_empty());
        assert_eq!(keys[0], TexInfoKeys::default());
        assert!(keys[1].no_shadow && keys[1].phong_angle == 89.0 && keys[1].surflight_group == 3);
        assert_eq!(keys[1].minlight, Some(25.0));
        assert_eq!(keys[1].minlight_colour, Some(Vec3::new(10.0, 20.0, 30.0)));
        assert_eq!(keys[1].world_units_per_luxel, Some(8.0));
    }

    #[test]
    fn unusable_files_are_ignored_whole_with_one_warning() {
        for text in [r#"{"0":{"no_shadow":true},"7":{}}"#, "[]", "{", r#"{"x":{}}"#] {
            let (keys, warnings) = keys(text, 1);
            assert_eq!(keys, [TexInfoKeys::default()], "{text}");
            assert_eq!(warnings.len(), 1, "{text}");
        }
    }

    #[test]
    fn contents_prefer_the_sidecar_when_it_fits() {
        let mut w = Vec::new();
        let native = [-2, -1, -6, -3];
        assert_eq!(solid_leafs(None, &native, &mut w), [true, false, true, false]);
        let text = r#"[["window"],["Solid"],[],["SKY","x"]]"#;
        assert_eq!(solid_leafs(Some(text), &native, &mut w), [false, true, false, true]);
        assert!(w.is_empty());
        assert_eq!(solid_leafs(Some("[[]]"), &native, &mut w), [true, false, true, false]);
        assert_eq!(w.len(), 1);
    }
}
