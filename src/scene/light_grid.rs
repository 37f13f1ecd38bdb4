//! Where the points of the light grid are (contract sections 6.8 and 9.3).

use super::keys;
use super::surface::Surface;
use crate::bsp::{Entity, GridPlace};
use crate::{Error, Result};
use glam::{UVec3, Vec3};

/// World units between points, unless the map or the user says another number.
const STEP: f32 = 32.0;
/// The range of those.
const STEPS: std::ops::RangeInclusive<f32> = 1.0..=65536.0;
/// The most points, unless `lightgrid_force` is given: minutes of work, some hundred megabytes.
const MOST_POINTS: u64 = 1 << 21;
/// The most points at all: a gigabyte.
const POINT_LIMIT: u64 = 1 << 24;
/// The world that engines can hold, in units from its middle.
const WORLD_EDGE: f32 = 65536.0;

/// What a point of the grid tells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GridFormat {
    /// One colour.
    #[default]
    Octree,
    /// A colour on each side of a cube.
    Sides,
}

/// The light grid that is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightGrid {
    /// Its points.
    pub place: GridPlace,
    /// What they tell.
    pub format: GridFormat,
}

impl LightGrid {
    /// World units between points, from one number or three; `None` unless each is 1 to 65536.
    pub fn parse_step(text: &str) -> Option<Vec3> {
        let numbers: Option<Vec<f32>> =
            text.split_ascii_whitespace().map(|number| number.parse().ok()).collect();
        let step = match numbers?[..] {
            [all] => Vec3::splat(all),
            [x, y, z] => Vec3::new(x, y, z),
            _ => return None,
        };
        step.to_array().iter().all(|n| STEPS.contains(n)).then_some(step)
    }

    /// The grid that worldspawn asks for, if it does; there is none without room for points. It fills the
    /// box of the entities with `lightgrid_hint`, or else that of the world's faces.
    ///
    /// # Errors
    /// If there are more than 16 million points.
    pub(crate) fn read(
        worldspawn: &Entity,
        entities: &[Entity],
        surfaces: &[Surface],
        warnings: &mut Vec<String>,
    ) -> Result<Option<Self>> {
        let flag = |name: &str| worldspawn.setting(name).is_some_and(keys::boolean);
        let force = flag("lightgrid_force");
        if !flag("lightgrid") && !force {
            return Ok(None);
        }
        let world = surfaces.iter().filter(|s| s.model == Some(0));
        let Some((mins, maxs)) = hinted(entities)
            .or_else(|| bounds(world.flat_map(|s| &s.vertices).copied()))
            .filter(|(mins, maxs)| mins.abs().max(maxs.abs()).max_element() <= WORLD_EDGE)
        else {
            warnings
                .push("the light grid is left out: the world has no faces to enclose it".into());
            return Ok(None);
        };
        let mut step = step(worldspawn, warnings);
        let asked = step;
        while !force && points(maxs - mins, step) > MOST_POINTS {
            step *= 2.0;
        }
        if step != asked {
            warnings.push(format!(
                "the light grid would have {} points, so they are {} units apart: give a larger \
                 lightgrid_dist, lightgrid_hint entities around a part of the map, or lightgrid_force",
                points(maxs - mins, asked),
                text(step)
            ));
        }
        let count = points(maxs - mins, step);
        if count > POINT_LIMIT {
            return Err(Error::Limit {
                what: "number of points of the light grid".into(),
                value: count,
                limit: POINT_LIMIT,
                advice: "give a larger lightgrid_dist",
            });
        }
        let place = GridPlace { mins, step, size: size(maxs - mins, step) };
        Ok(Some(Self { place, format: format(worldspawn, warnings) }))
    }
}

/// The box of the entities that outline the grid, if it has volume.
fn hinted(entities: &[Entity]) -> Option<(Vec3, Vec3)> {
    let hints = entities
        .iter()
        .filter(|e| e.setting("lightgrid_hint").is_some_and(|hint| keys::integer(hint) != 0));
    let origins = hints.filter_map(|e| e.get("origin").and_then(keys::vector));
    bounds(origins).filter(|(mins, maxs)| mins.cmplt(*maxs).all())
}

fn bounds(points: impl Iterator<Item = Vec3>) -> Option<(Vec3, Vec3)> {
    points.fold(None, |bounds, p| {
        let (mins, maxs) = bounds.unwrap_or((p, p));
        Some((mins.min(p), maxs.max(p)))
    })
}

/// Points along each axis.
fn size(extent: Vec3, step: Vec3) -> UVec3 {
    (extent / step).ceil().max(Vec3::ONE).as_uvec3()
}

fn points(extent: Vec3, step: Vec3) -> u64 {
    size(extent, step).to_array().iter().map(|&n| u64::from(n)).product()
}

fn text(step: Vec3) -> String {
    format!("{} {} {}", step.x, step.y, step.z)
}

/// `lightgrid_dist`: three numbers, or one for all axes.
fn step(worldspawn: &Entity, warnings: &mut Vec<String>) -> Vec3 {
    let Some(text) = worldspawn.setting("lightgrid_dist") else { return Vec3::splat(STEP) };
    LightGrid::parse_step(text).unwrap_or_else(|| {
        let (low, high) = (STEPS.start(), STEPS.end());
        warnings.push(format!(
            "worldspawn lightgrid_dist: {text:?} is not three numbers from {low} to {high}, {STEP} is \
             used"
        ));
        Vec3::splat(STEP)
    })
}

/// `lightgrid_format`: a name, or its number.
fn format(worldspawn: &Entity, warnings: &mut Vec<String>) -> GridFormat {
    match worldspawn.setting("lightgrid_format").map(str::to_ascii_lowercase).as_deref() {
        None | Some("octree" | "0") => GridFormat::Octree,
        Some("lightgrids" | "1") => GridFormat::Sides,
        Some(other) => {
            warnings.push(format!(
                "worldspawn lightgrid_format: {other:?} is neither octree nor lightgrids, octree is used"
            ));
            GridFormat::Octree
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsp::parse_entities;

    /// The grid of the box of two hints, and the warnings.
    fn read(worldspawn: &str, corner: &str) -> (Result<Option<LightGrid>>, Vec<String>) {
        let text = format!(
            "{{ {worldspawn} }} {{ _lightgrid_hint 1 origin \"-8 -16 0\" }} \
             {{ lightgrid_hint 1 origin \"{corner}\" }} {{ _lightgrid_hint 0 origin \"9 9 9999\" }}"
        );
        let entities = parse_entities(text.as_bytes()).unwrap();
        let mut warnings = Vec::new();
        (LightGrid::read(&entities[0], &entities, &[], &mut warnings), warnings)
    }

    fn size_of(worldspawn: &str, corner: &str) -> [u32; 3] {
        let (grid, warnings) = read(worldspawn, corner);
        assert!(warnings.is_empty(), "{warnings:?}");
        grid.unwrap().unwrap().place.size.to_array()
    }

    #[test]
    fn points_fill_the_box_from_its_low_corner() {
        assert!(read("a b", "100 100 100").0.unwrap().is_none());
        assert!(read("_lightgrid 0", "100 100 100").0.unwrap().is_none());
        let (grid, _) = read("_lightgrid 1", "88 17 33");
        let place = grid.unwrap().unwrap().place;
        assert_eq!(place.mins, Vec3::new(-8.0, -16.0, 0.0));
        assert_eq!(place.size.to_array(), [3, 2, 2]);
        assert_eq!(place.position(place.index(UVec3::new(2, 1, 1))), Vec3::new(56.0, 16.0, 32.0));
        assert_eq!(size_of("lightgrid 1 _lightgrid_dist \"8 16 64\"", "88 17 33"), [12, 3, 1]);
        assert_eq!(size_of("lightgrid 1 _lightgrid_dist 8", "88 17 33"), [12, 5, 5]);
    }

    #[test]
    fn a_flat_box_of_hints_is_none_and_no_room_is_told() {
        let (grid, warnings) = read("lightgrid 1", "88 -16 33");
        assert!(grid.unwrap().is_none());
        assert!(warnings[0].contains("left out"));
    }

    #[test]
    fn unusable_values_keep_the_default_with_a_warning() {
        for dist in ["0", "-1 2 3", "x", "1 2", "1e9", "32 32 nan", "inf"] {
            let (grid, warnings) =
                read(&format!("lightgrid 1 lightgrid_dist \"{dist}\""), "88 17 33");
            let step = grid.unwrap().unwrap().place.step;
            assert_eq!(step, Vec3::splat(32.0), "{dist}");
            assert!(warnings[0].contains("lightgrid_dist"), "{dist}");
        }
        let (grid, warnings) = read("lightgrid 1 lightgrid_format cube", "88 17 33");
        assert_eq!(grid.unwrap().unwrap().format, GridFormat::Octree);
        assert!(warnings[0].contains("cube"));
        let (grid, _) = read("lightgrid 1 lightgrid_format LightGrids", "88 17 33");
        assert_eq!(grid.unwrap().unwrap().format, GridFormat::Sides);
    }

    #[test]
    fn too_many_points_are_spread_out_unless_forced_and_never_without_limit() {
        let (grid, warnings) = read("lightgrid 1 lightgrid_dist 16", "4088 4080 4096");
        assert_eq!(grid.unwrap().unwrap().place.size.to_array(), [128; 3]);
        let told = warnings[0].contains("16777216 points, so they are 32 32 32 units apart");
        assert!(told, "{warnings:?}");
        assert_eq!(size_of("lightgrid_force 1 lightgrid_dist 16", "4088 4080 4096"), [256; 3]);
        let error = read("lightgrid_force 1 lightgrid_dist 1", "4088 4080 4096").0.unwrap_err();
        assert!(matches!(error, Error::Limit { .. }), "{error}");
        // No further apart than the largest map is wide.
        let (grid, warnings) = read("lightgrid 1 lightgrid_dist 1", "65000 65000 65000");
        assert!(grid.unwrap().unwrap().place.len() <= MOST_POINTS as usize && warnings.len() == 1);
        assert!(read("lightgrid 1", "1e30 9 9").0.unwrap().is_none());
    }
}
