//! Files of known light.

use crate::{Error, Result};

/// Known bounced light of a map.
#[derive(Clone, Debug, Default)]
pub struct MapTruth {
    /// Face, luxel column and luxel row.
    pub luxels: Vec<[u32; 3]>,
    /// Indirect irradiance of style 0, mean of the channels.
    pub light: Vec<f32>,
}

/// Known light of a text scene, one entry a patch.
#[derive(Clone, Debug, Default)]
pub struct TextTruth {
    /// Final exitance less what the patch gives off by itself, per channel.
    pub reflected: Vec<[f32; 3]>,
}

/// Columns of a CSV text, by their names; lines that begin with `#` are left out.
fn columns<const N: usize>(text: &str, name: &str, wanted: [&str; N]) -> Result<Vec<[f64; N]>> {
    let mut lines = text.lines().enumerate().filter(|(_, l)| !l.starts_with('#') && !l.is_empty());
    let head: Vec<&str> = lines.next().map(|l| l.1.split(',').collect()).unwrap_or_default();
    let place = |column: &str| {
        head.iter().position(|h| h.trim() == column).ok_or_else(|| {
            Error::format(
                name,
                format!("no column {column}; is it the truth of this kind of file?"),
            )
        })
    };
    let mut places = [0; N];
    for (place_of, column) in places.iter_mut().zip(wanted) {
        *place_of = place(column)?;
    }
    lines
        .map(|(number, line)| {
            let fields: Vec<&str> = line.split(',').collect();
            let mut values = [0.0; N];
            for (value, &place) in values.iter_mut().zip(&places) {
                let field = fields.get(place).and_then(|f| f.trim().parse::<f64>().ok());
                *value = field.filter(|v| v.is_finite()).ok_or_else(|| {
                    let problem = format!("line {}: column {} is no number", number + 1, place + 1);
                    Error::format(name, problem)
                })?;
            }
            Ok(values)
        })
        .collect()
}

/// Reads the truth of a map: columns `face`, `s`, `t`, `I_r`, `I_g`, `I_b`. `name` is for errors.
///
/// # Errors
/// When a column or a number is missing.
pub fn map_truth(text: &str, name: &str) -> Result<MapTruth> {
    let mut truth = MapTruth::default();
    for [face, s, t, r, g, b] in columns(text, name, ["face", "s", "t", "I_r", "I_g", "I_b"])? {
        truth.luxels.push([face as u32, s as u32, t as u32]);
        truth.light.push(((r + g + b) / 3.0) as f32);
    }
    Ok(truth)
}

/// Reads the truth of a text scene: columns `B_r`, `B_g`, `B_b`, `E_r`, `E_g`, `E_b`.
///
/// # Errors
/// When a column or a number is missing.
pub fn text_truth(text: &str, name: &str) -> Result<TextTruth> {
    let rows = columns(text, name, ["B_r", "B_g", "B_b", "E_r", "E_g", "E_b"])?;
    let reflected = |[r, g, b, er, eg, eb]: [f64; 6]| {
        [(r, er), (g, eg), (b, eb)].map(|(b, e)| (b - e.min(b)) as f32)
    };
    Ok(TextTruth { reflected: rows.into_iter().map(reflected).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name() {
        let text = "# made\npatch,B_r,B_g,B_b,se,buried,E_r,E_g,E_b\n0,3,2,1,0,0,1,0.5,2\n";
        assert_eq!(text_truth(text, "t").unwrap().reflected, [[2.0, 1.5, 0.0]]);
        let text = "t,s,face,I_r,I_g,I_b\n3,2,1,4,5,9\n";
        let truth = map_truth(text, "t").unwrap();
        assert_eq!((truth.luxels, truth.light), (vec![[1, 2, 3]], vec![6.0]));
        assert!(map_truth("a,b\n1,2\n", "t").is_err());
        assert!(map_truth("t,s,face,I_r,I_g,I_b\n3,2,1,4,5\n", "t").is_err());
        assert!(map_truth("", "t").is_err());
    }
}
