//! How the values of entity keys are read (contract section 4.1): leading parts as C reads them,
//! never an error, because a map with a typing mistake in one key must still light.

use glam::Vec3;

/// Leading decimal number of the first token, like C `strtod`; `None` if there is none or it is
/// not finite.
pub(crate) fn number(text: &str) -> Option<f32> {
    let token = text.split_ascii_whitespace().next()?;
    let end = number_length(token.as_bytes());
    let value = token[..end].parse::<f64>().ok()? as f32;
    value.is_finite().then_some(value)
}

/// Bytes of the longest prefix that is a decimal floating point number.
pub(crate) fn number_length(b: &[u8]) -> usize {
    let digits = |from: usize| b[from..].iter().take_while(|c| c.is_ascii_digit()).count();
    let mut i = usize::from(matches!(b.first(), Some(b'+' | b'-')));
    let whole = digits(i);
    i += whole;
    let mut fraction = 0;
    if b.get(i) == Some(&b'.') {
        fraction = digits(i + 1);
        if whole + fraction > 0 {
            i += 1 + fraction;
        }
    }
    if whole + fraction == 0 {
        return 0;
    }
    if matches!(b.get(i), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(b.get(i + 1), Some(b'+' | b'-')));
        let exponent = digits((i + 1 + sign).min(b.len()));
        if exponent > 0 {
            i += 1 + sign + exponent;
        }
    }
    i
}

/// Every leading token that is a number, up to `N`.
fn numbers(text: &str) -> Vec<f32> {
    text.split_ascii_whitespace().map_while(number).collect()
}

/// First token as a decimal integer prefix, saturated to `i32`; 0 when there are no digits.
pub(crate) fn integer(text: &str) -> i32 {
    let token = text.split_ascii_whitespace().next().unwrap_or("");
    let sign = usize::from(token.starts_with(['+', '-']));
    let digits = token[sign..].bytes().take_while(u8::is_ascii_digit).count();
    if digits == 0 {
        return 0;
    }
    match token[..sign + digits].parse::<i64>() {
        Ok(v) => v.clamp(i32::MIN.into(), i32::MAX.into()) as i32,
        Err(_) if token.starts_with('-') => i32::MIN,
        Err(_) => i32::MAX,
    }
}

/// `0` and `-1` are false, anything else, even nothing, is true.
pub(crate) fn boolean(text: &str) -> bool {
    !matches!(text, "0" | "-1")
}

/// Three numbers.
pub(crate) fn vector(text: &str) -> Option<Vec3> {
    match numbers(text)[..] {
        [x, y, z, ..] => Some(Vec3::new(x, y, z)),
        _ => None,
    }
}

/// A colour in 0 to 255; a colour whose channels all lie in 0 to 1 is meant as a fraction.
pub(crate) fn colour(text: &str) -> Option<Vec3> {
    vector(text).map(scale_colour)
}

fn scale_colour(c: Vec3) -> Vec3 {
    let fraction = c.to_array().iter().all(|v| (0.0..=1.0).contains(v));
    if fraction { c * 255.0 } else { c }
}

/// Brightness and colour of a `light` key: one number is brightness, three are a colour, four both.
pub(crate) fn light(text: &str) -> (Option<f32>, Option<Vec3>) {
    match numbers(text)[..] {
        [l] => (Some(l), None),
        [r, g, b] => (None, Some(scale_colour(Vec3::new(r, g, b)))),
        [r, g, b, l, ..] => (Some(l), Some(scale_colour(Vec3::new(r, g, b)))),
        _ => (None, None),
    }
}

/// The angles of a sun: up to three numbers, the missing ones 0.
pub(crate) fn angles(text: &str) -> Vec3 {
    let given = numbers(text);
    Vec3::from_array(std::array::from_fn(|i| given.get(i).copied().unwrap_or(0.0)))
}

/// Direction of a `mangle` (yaw, pitch, roll in degrees): positive pitch is up, roll is ignored.
pub(crate) fn direction(mangle: Vec3) -> Vec3 {
    let (sin_yaw, cos_yaw) = super::exact::radians(mangle.x).sin_cos();
    let (sin_pitch, cos_pitch) = super::exact::radians(mangle.y).sin_cos();
    Vec3::new((cos_yaw * cos_pitch) as f32, (sin_yaw * cos_pitch) as f32, sin_pitch as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_like_strtod() {
        for (text, want) in [
            ("300", Some(300.0)),
            (" -4.5e1x", Some(-45.0)),
            (".75", Some(0.75)),
            ("5.", Some(5.0)),
            ("1e", Some(1.0)),
            ("1e+", Some(1.0)),
            ("2 3", Some(2.0)),
            ("x", None),
            ("", None),
            (".", None),
            ("-", None),
            ("inf", None),
            ("1e99", None),
        ] {
            assert_eq!(number(text), want, "{text:?}");
        }
    }

    #[test]
    fn integers_and_booleans() {
        assert_eq!(
            [integer("1.9"), integer("-1"), integer("x"), integer("99999999999")],
            [1, -1, 0, i32::MAX]
        );
        assert_eq!(["0", "-1", "2", "0.0", ""].map(boolean), [false, false, true, true, true]);
    }

    #[test]
    fn light_and_colour_forms() {
        assert_eq!(light("200"), (Some(200.0), None));
        assert_eq!(light("255 127 0"), (None, Some(Vec3::new(255.0, 127.0, 0.0))));
        assert_eq!(light("1 0.5 0 100"), (Some(100.0), Some(Vec3::new(255.0, 127.5, 0.0))));
        assert_eq!(light("1 2"), (None, None));
        assert_eq!(light(""), (None, None));
        assert_eq!(colour("1 1 2"), Some(Vec3::new(1.0, 1.0, 2.0)));
        assert_eq!(colour("1 1"), None);
    }

    #[test]
    fn mangles_point_where_the_contract_says() {
        for (mangle, want) in [
            (Vec3::ZERO, Vec3::X),
            (Vec3::new(180.0, 0.0, 0.0), -Vec3::X),
            (Vec3::new(0.0, 90.0, 0.0), Vec3::Z),
            (Vec3::new(0.0, -90.0, 50.0), -Vec3::Z),
        ] {
            assert!((direction(mangle) - want).length() < 1e-6, "{mangle}");
        }
        for (yaw, pitch) in (-179..180_i16).flat_map(|y| (-89..90_i16).map(move |p| (y, p))) {
            let (yaw, pitch) = (f32::from(yaw), f32::from(pitch));
            let d = direction(Vec3::new(yaw, pitch, 0.0));
            let (back, up) = (d.y.atan2(d.x), d.z.atan2(d.x.hypot(d.y)));
            assert!((back.to_degrees() - yaw).abs() < 0.1 && (up.to_degrees() - pitch).abs() < 0.1);
        }
    }
}
