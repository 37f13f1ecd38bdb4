//! Where a picture of a map is taken from if the user names no camera.

use crate::bsp::Entity;
use glam::Vec3;

/// Height of a player's eye over the origin of the place where it starts.
const EYE_HEIGHT: f32 = 22.0;
/// Places where players start, the first kind that the map has is taken.
const STARTS: [&str; 3] = ["info_player_start", "info_player_deathmatch", "info_player_coop"];

/// Eye, pitch and yaw (degrees, pitch positive looks down) of the map's first `info_player_start`,
/// else of another player start, else of its first `info_intermission`. `None` if there are none, or
/// their origins cannot be read.
pub fn start_camera(entities: &[Entity]) -> Option<(Vec3, f64, f64)> {
    let first = |class: &str| entities.iter().find(|entity| entity.classname() == class);
    for class in STARTS {
        let found = first(class).and_then(|start| {
            let (pitch, yaw) = direction(start);
            Some((origin(start)? + Vec3::Z * EYE_HEIGHT, pitch, yaw))
        });
        if found.is_some() {
            return found;
        }
    }
    let view = first("info_intermission")?;
    let (pitch, yaw) = direction(view);
    Some((origin(view)?, pitch, yaw))
}

/// The `origin` of an entity; `None` if there is none or it is not three finite numbers.
pub(super) fn origin(entity: &Entity) -> Option<Vec3> {
    vector(entity.get("origin")?)
}

/// Pitch and yaw: `mangle` unless it is zero, else `angles` or `angle`.
fn direction(entity: &Entity) -> (f64, f64) {
    let angles = |key: &str| {
        let angles = vector(entity.get(key)?).filter(|&angles| angles != Vec3::ZERO)?;
        Some((angles.x.into(), angles.y.into()))
    };
    let yaw = || entity.get("angle")?.trim().parse().ok().filter(|yaw: &f64| yaw.is_finite());
    angles("mangle").or_else(|| angles("angles")).unwrap_or_else(|| (0.0, yaw().unwrap_or(0.0)))
}

fn vector(text: &str) -> Option<Vec3> {
    let mut numbers = text.split_ascii_whitespace().map(|word| word.parse::<f32>().ok());
    let vector = Vec3::new(numbers.next()??, numbers.next()??, numbers.next()??);
    vector.is_finite().then_some(vector)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsp::parse_entities;

    fn camera(text: &str) -> Option<(Vec3, f64, f64)> {
        start_camera(&parse_entities(text.as_bytes()).unwrap())
    }

    #[test]
    fn player_starts_come_before_intermissions() {
        let view = r#"{ "classname" "info_intermission" "origin" "1 2 3" "mangle" "20 45 5" }"#;
        let arena = r#"{ "classname" "info_player_deathmatch" "origin" "4 5 6" "angle" "90" }"#;
        let start = r#"{ "classname" "info_player_start" "origin" "7 8 9" }"#;
        assert_eq!(camera(""), None);
        assert_eq!(camera(view), Some((Vec3::new(1.0, 2.0, 3.0), 20.0, 45.0)));
        let both = [view, arena].concat();
        assert_eq!(camera(&both), Some((Vec3::new(4.0, 5.0, 28.0), 0.0, 90.0)));
        let all = [view, arena, start, start].concat();
        assert_eq!(camera(&all), Some((Vec3::new(7.0, 8.0, 31.0), 0.0, 0.0)));
    }

    #[test]
    fn unreadable_numbers_are_passed_over() {
        for origin in ["", "1 2", "a b c", "1 2 nan", "1e999 0 0"] {
            let text = format!(r#"{{ "classname" "info_player_start" "origin" "{origin}" }}"#);
            assert_eq!(camera(&text), None, "{origin}");
        }
        let angle = r#"{ "classname" "info_player_coop" "origin" "0 0 0" "angle" "inf" }"#;
        assert_eq!(camera(angle), Some((Vec3::Z * 22.0, 0.0, 0.0)));
    }
}
