//! Numbers in entity values that no light can mean: so large that sums and products of them leave
//! single precision, or no numbers at all though they look like some.

use super::keys::number_length;
use crate::bsp::Entity;

/// The largest number of a value, 2^31: every bit mask and place in a map is below it, and products of
/// several stay within single precision.
const MOST: f64 = 2_147_483_648.0;
/// Keys whose values are names or text.
const TEXT: [&str; 8] =
    ["classname", "killtarget", "message", "model", "netname", "target", "targetname", "wad"];
/// Values that are told of one by one; the rest is counted.
const SHOWN: usize = 10;

/// Brings numbers beyond +-2^31 to that, and says so; says which values are `nan` or `inf`, which count
/// as if the key were not there.
pub(crate) fn limit(entities: &mut [Entity], warnings: &mut Vec<String>) {
    let mut told = Vec::new();
    for (index, entity) in entities.iter_mut().enumerate() {
        let class = entity.classname().to_owned();
        for (key, value) in entity.pairs_mut() {
            if TEXT.contains(&key) {
                continue;
            }
            let place = || format!("entity {index} ({class}), {key:?} {value:?}");
            if value.split_ascii_whitespace().any(is_no_number) {
                told.push(format!("{}: this is no number and is ignored", place()));
            } else if let Some(limited) = limited(value) {
                told.push(format!("{}: taken as {limited:?}", place()));
                *value = limited;
            }
        }
    }
    let more = told.len().saturating_sub(SHOWN);
    warnings.extend(told.into_iter().take(SHOWN));
    if more > 0 {
        warnings.push(format!("{more} more values of entities are no numbers or out of range"));
    }
}

/// A number of a file beside the map, in the same range.
pub(crate) fn limited_number(number: f64) -> f32 {
    number.clamp(-MOST, MOST) as f32
}

fn is_no_number(word: &str) -> bool {
    let word = word.trim_start_matches(['+', '-']);
    ["nan", "inf", "infinity"].iter().any(|w| word.eq_ignore_ascii_case(w))
}

/// The value with every number in range; `None` if they all are.
fn limited(value: &str) -> Option<String> {
    let word = |word: &str| {
        let length = number_length(word.as_bytes());
        let number: f64 = word[..length].parse().ok()?;
        (number.abs() > MOST).then(|| MOST.copysign(number).to_string())
    };
    let words = || value.split_ascii_whitespace();
    words().any(|w| word(w).is_some()).then(|| {
        let words: Vec<String> = words().map(|w| word(w).unwrap_or_else(|| w.to_owned())).collect();
        words.join(" ")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsp::parse_entities;

    fn read(text: &str) -> (Vec<String>, Vec<String>) {
        let mut entities = parse_entities(text.as_bytes()).unwrap();
        let mut warnings = Vec::new();
        limit(&mut entities, &mut warnings);
        let values = entities.iter().flat_map(Entity::pairs).map(|(_, v)| v.to_owned());
        (values.collect(), warnings)
    }

    #[test]
    fn values_in_range_stay_as_they_are() {
        let text = "{ a 300 b \" 1  -2e9 x\" c \"\" d 2147483648 message \"1e99\" target inf }";
        let (values, warnings) = read(text);
        assert_eq!(values, ["300", " 1  -2e9 x", "", "2147483648", "1e99", "inf"]);
        assert!(warnings.is_empty(), "{warnings:?}");
    }

    #[test]
    fn values_out_of_range_are_limited_and_told() {
        let (values, warnings) =
            read("{ classname light light 3e38 color \"1 -1e999 9e9x\" wait NaN }");
        assert_eq!(values[1..], ["2147483648", "1 -2147483648 2147483648", "NaN"]);
        assert_eq!(warnings.len(), 3);
        assert_eq!(warnings[0], r#"entity 0 (light), "light" "3e38": taken as "2147483648""#);
        assert!(warnings[2].contains("no number"));
    }

    #[test]
    fn many_are_counted() {
        let (_, warnings) = read(&"{ light -inf }".repeat(30));
        assert_eq!(warnings.len(), SHOWN + 1);
        assert!(warnings[SHOWN].starts_with("20 more"));
    }
}
