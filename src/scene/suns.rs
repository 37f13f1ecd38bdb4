//! Suns and sky domes: light from far away that comes through sky (contract sections 5.1 and 5.2).

use super::exact::normalize;
use super::keys;
use super::light_list::check_light_count;
use super::random::Random;
use super::world::WorldSettings;
use crate::Result;
use crate::bsp::{Bsp, Entity};
use glam::Vec3;
use std::f32::consts::PI;

/// Suns that a dome or a sun with penumbra is made of, unless the map says otherwise.
const SAMPLES: i32 = 64;

/// Parallel light that reaches the surfaces whose ray towards it meets sky first.
#[derive(Clone, Debug, PartialEq)]
pub struct Sun {
    /// Unit direction from a surface to the sun.
    pub to_sun: Vec3,
    /// Brightness in light units, never 0; a negative sun takes light away.
    pub brightness: f32,
    /// Colour, 0 to 255 a channel (not limited).
    pub colour: Vec3,
    /// Share of the cosine law, 0 (no angle dependence) to 1.
    pub angle_scale: f32,
    /// Light style the light belongs to.
    pub style: u16,
    /// Whether dirt darkens its light; `None` follows worldspawn `_dirt`.
    pub dirt: Option<bool>,
    /// Factor on its light where it bounces (`bouncescale`), 0 and up.
    pub bounce_scale: f32,
    /// Index of the only sky texture that lets its light through; `None` is any sky.
    pub sky_texture: Option<u32>,
    /// Part of a sky dome.
    pub dome: bool,
}

/// What a light entity with `_sun`, `_sunlight2` or `_sunlight3` adds to the sky.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SkyLight {
    Sun,
    Dome { upper: bool },
}

/// A sky light before it is spread over suns.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub kind: SkyLight,
    /// Direction of travel, of any length.
    pub travel: Vec3,
    /// Half-width of the sun in degrees.
    pub penumbra: f32,
    /// What the suns have in common; `brightness` is that of them all, `to_sun` is not used.
    pub light: Sun,
}

/// The `_suntexture` of an entity as an index of the texture lump; `None` if it names no texture.
pub(crate) fn sky_texture(entity: &Entity, bsp: &Bsp) -> Option<u32> {
    let name = entity.setting("suntexture")?;
    let known = |t: &Option<crate::bsp::MipTex>| {
        t.as_ref().is_some_and(|t| t.name.eq_ignore_ascii_case(name))
    };
    bsp.textures.iter().position(known).map(|i| i as u32)
}

/// A dirt key: 1 is on, -1 is off, anything else follows the world.
pub(crate) fn dirt(entity: &Entity, name: &str) -> Option<bool> {
    match entity.setting(name).and_then(keys::number) {
        Some(1.0) => Some(true),
        Some(-1.0) => Some(false),
        _ => None,
    }
}

/// The suns of a map in the order in which they are added up: suns of entities, of worldspawn, domes
/// of worldspawn, of entities.
///
/// # Errors
/// If there are more suns than lights may be.
pub(crate) fn make(
    worldspawn: &Entity,
    world: &WorldSettings,
    entities: &[Source],
    random: &mut Random,
) -> Result<Vec<Sun>> {
    // Each source makes at most one sun a sample, and one more in the zenith.
    let samples = worldspawn.setting("sunsamples").map_or(SAMPLES, keys::integer).clamp(8, 2048);
    check_light_count(entities.len().saturating_mul(samples as usize + 1))?;
    let sky = WorldSky { entity: worldspawn, world };
    let mut suns = Vec::new();
    for source in entities.iter().filter(|s| s.kind == SkyLight::Sun) {
        add_sun(&mut suns, source, samples, random);
    }
    for source in [sky.sun(&["sun_light", "sunlight"], "sunlight"), sky.sun(&["sun2"], "sun2")] {
        add_sun(&mut suns, &source, samples, random);
    }
    let upper =
        sky.light(&["sunlight2"], &["sunlight_color2", "sunlight2_color"], "sunlight2_dirt");
    let lower =
        sky.light(&["sunlight3"], &["sunlight_color3", "sunlight3_color"], "sunlight2_dirt");
    add_dome(&mut suns, Some(&upper), Some(&lower), samples);
    for source in entities {
        match source.kind {
            SkyLight::Sun => {}
            SkyLight::Dome { upper: true } => {
                add_dome(&mut suns, Some(&source.light), None, samples);
            }
            SkyLight::Dome { upper: false } => {
                add_dome(&mut suns, None, Some(&source.light), samples);
            }
        }
    }
    Ok(suns)
}

/// The sky that worldspawn asks for.
struct WorldSky<'a> {
    entity: &'a Entity,
    world: &'a WorldSettings,
}

impl WorldSky<'_> {
    /// The last of several spellings of a key that can be read.
    fn read<T>(&self, names: &[&str], parse: impl Fn(&str) -> Option<T>) -> Option<T> {
        names.iter().rev().find_map(|name| self.entity.setting(name).and_then(&parse))
    }

    fn light(&self, names: &[&str], colours: &[&str], dirt_key: &str) -> Sun {
        Sun {
            to_sun: Vec3::Z,
            brightness: self.read(names, keys::number).unwrap_or(0.0),
            colour: self.read(colours, keys::colour).unwrap_or(Vec3::splat(255.0)),
            angle_scale: self.world.angle_scale,
            style: 0,
            dirt: dirt(self.entity, dirt_key),
            bounce_scale: 1.0,
            sky_texture: None,
            dome: false,
        }
    }

    fn sun(&self, names: &[&str], main: &str) -> Source {
        let (colours, mangles): (&[&str], &[&str]) = if main == "sun2" {
            (&["sun2_color"], &["sun2_mangle"])
        } else {
            (&["sun_color", "sunlight_color"], &["sun_angle", "sun_mangle", "sunlight_mangle"])
        };
        let travel = self.read(mangles, |text| Some(keys::direction(keys::angles(text))));
        let penumbra = self.read(&["sunlight_penumbra"], keys::number).unwrap_or(0.0);
        Source {
            kind: SkyLight::Sun,
            travel: travel.unwrap_or(Vec3::NEG_Z),
            penumbra: penumbra.clamp(0.0, 180.0),
            light: self.light(names, colours, "sunlight_dirt"),
        }
    }
}

/// Adds one sun, or many around the exact direction if it has a penumbra. As in the reference the
/// offsets fill a square of azimuths and elevations, and are drawn even for a dark sun.
fn add_sun(suns: &mut Vec<Sun>, source: &Source, samples: i32, random: &mut Random) {
    let count = if source.penumbra > 0.0 { samples } else { 1 };
    let travel = normalize(source.travel);
    let width = super::exact::radians(source.penumbra) as f32;
    for i in 0..count {
        let mut travel = travel;
        if i > 0 {
            let flat = (travel.x * travel.x + travel.y * travel.y).sqrt();
            let azimuth = travel.y.atan2(travel.x) + (random.next() * 2.0 - 1.0) * width;
            let elevation = travel.z.atan2(flat) + (random.next() * 2.0 - 1.0) * width;
            travel = Vec3::new(
                azimuth.cos() * elevation.cos(),
                azimuth.sin() * elevation.cos(),
                elevation.sin(),
            );
        }
        add(suns, &source.light, travel, count as f32);
    }
}

/// Adds a share of a light that travels in a direction.
fn add(suns: &mut Vec<Sun>, light: &Sun, travel: Vec3, shares: f32) {
    let brightness = light.brightness / shares;
    if brightness != 0.0 {
        suns.push(Sun { to_sun: -normalize(travel), brightness, ..light.clone() });
    }
}

/// Adds rings of suns around the zenith, and one in it; a lower half mirrors the upper one.
fn add_dome(suns: &mut Vec<Sun>, upper: Option<&Sun>, lower: Option<&Sun>, samples: i32) {
    let quarter = ((samples - 1) / 4) as f32;
    let rings = (quarter.sqrt().round_ties_even() as u32 + 1).max(2) - 1;
    let azimuths = 4 * rings;
    let of_dome = |light: &Sun| Sun { dome: true, ..light.clone() };
    let (upper, lower) = (upper.map(of_dome), lower.map(of_dome));
    let count = (azimuths * rings + 1) as f32;
    let mut both = |travel: Vec3| {
        if let Some(light) = &upper {
            add(suns, light, travel, count);
        }
        if let Some(light) = &lower {
            add(suns, light, travel * Vec3::new(1.0, 1.0, -1.0), count);
        }
    };
    let elevation_step = PI / 2.0 / (rings + 1) as f32;
    let azimuth_step = PI * 2.0 / azimuths as f32;
    let (mut elevation, mut azimuth) = (elevation_step * 0.5, 0.0_f32);
    for _ in 0..rings {
        for _ in 0..azimuths {
            both(Vec3::new(
                azimuth.cos() * elevation.cos(),
                azimuth.sin() * elevation.cos(),
                -elevation.sin(),
            ));
            azimuth += azimuth_step;
        }
        elevation += elevation_step;
        azimuth += azimuth_step / rings as f32;
    }
    both(Vec3::NEG_Z);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn suns(keys: &str) -> Vec<Sun> {
        let world = crate::bsp::parse_entities(format!("{{ {keys} }}").as_bytes()).unwrap();
        make(&world[0], &WorldSettings::default(), &[], &mut Random::new()).unwrap()
    }

    #[test]
    fn a_plain_sun_shines_from_straight_above() {
        let suns = suns("_sunlight 100 _sunlight_color \"1 0.5 0\"");
        assert_eq!(suns.len(), 1);
        assert_eq!(suns[0].to_sun, Vec3::Z);
        assert_eq!((suns[0].brightness, suns[0].colour), (100.0, Vec3::new(255.0, 127.5, 0.0)));
    }

    #[test]
    fn mangles_may_be_short_and_have_aliases() {
        let down = 50_f32.to_radians();
        for keys in
            ["_sun_mangle \"0 -50\"", "sunlight_mangle \"0 -50 9\"", "_sun_angle \"0 -50 0\""]
        {
            let suns = suns(&format!("_sunlight 1 {keys} _sun2 2"));
            assert!((suns[0].to_sun - Vec3::new(-down.cos(), 0.0, down.sin())).length() < 1e-6);
            assert_eq!(suns[1].to_sun, Vec3::Z);
        }
        assert_eq!(suns("_sunlight 1 _sun_mangle 180")[0].to_sun.x, 1.0);
    }

    #[test]
    fn penumbra_spreads_the_light_around_the_exact_direction_and_always_alike() {
        let keys = "_sunlight 64 _sun_mangle \"30 -40\" _sunlight_penumbra 4 _sunlight2 0";
        let a = suns(keys);
        assert_eq!(a, suns(keys));
        assert_eq!(a.len(), 64);
        assert_eq!(a[0].to_sun, suns("_sunlight 1 _sun_mangle \"30 -40\"")[0].to_sun);
        assert!((a.iter().map(|s| s.brightness).sum::<f32>() - 64.0).abs() < 1e-4);
        let apart = |s: &Sun| s.to_sun.dot(a[0].to_sun).clamp(-1.0, 1.0).acos().to_degrees();
        assert!(a.iter().all(|s| apart(s) <= 32_f32.sqrt()));
        assert!(a.iter().filter(|s| apart(s) > 2.0).count() > 32);
        assert_eq!(suns(&format!("{keys} _sunsamples 8")).len(), 8);
    }

    #[test]
    fn domes_have_four_rings_of_sixteen_suns_and_one_in_the_zenith() {
        let dome = suns("_sunlight2 65");
        assert_eq!(dome.len(), 65);
        assert!(dome.iter().all(|s| s.brightness == 1.0 && (s.to_sun.length() - 1.0).abs() < 1e-6));
        assert_eq!(dome[64].to_sun, Vec3::Z);
        for (i, sun) in dome[..64].iter().enumerate() {
            let (ring, step) = (i / 16, i % 16);
            let elevation = (9.0 + 18.0 * ring as f32).to_radians();
            let azimuth = (22.5 * step as f32 + (360.0 + 22.5 / 4.0) * ring as f32).to_radians();
            let want = -Vec3::new(
                azimuth.cos() * elevation.cos(),
                azimuth.sin() * elevation.cos(),
                -elevation.sin(),
            );
            assert!((sun.to_sun - want).length() < 1e-5, "{i}: {} {want}", sun.to_sun);
        }
        let both = suns("_sunlight2 65 _sunlight3 130");
        assert_eq!(both.len(), 130);
        assert_eq!((both[1].to_sun.z, both[1].brightness), (-both[0].to_sun.z, 2.0));
        assert_eq!(both[129].to_sun, Vec3::NEG_Z);
    }
}
