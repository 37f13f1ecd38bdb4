//! `sweep.csv`: the memory of a sweep. Rows whose key is not known stay as they are.

use super::bench::{Knobs, Measured};
use crate::{Error, Result};
use std::fmt::Write;
use std::path::Path;

const HEAD: &str = "key,preset,settings,seconds,memory_mib,error,max_error,against,luxels,\
                    processor_seconds,expected_seconds,expected_error,half_seconds,half_settings";

/// One line of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the preset, or empty.
    pub preset: String,
    /// The settings as `name=value` with spaces between.
    pub settings: String,
    /// Seconds.
    pub seconds: f64,
    /// Mebibytes, 0 where that is not known.
    pub memory: f64,
    /// Relative root mean square error.
    pub error: f64,
    /// Largest error relative to the mean light.
    pub worst: f64,
    /// What the errors are against: `truth` or `finest`.
    pub against: String,
    /// Share of the luxels that got hemicubes.
    pub luxels: f64,
    /// Seconds of processors, 0 where they are not known.
    pub processor: f64,
    /// Seconds and error that were expected where an error was asked for, else 0.
    pub expected: [f64; 2],
    /// Seconds that half the error was said to take, 0 if that was not told.
    pub half: f64,
    /// The settings for it.
    pub half_settings: String,
}

impl Row {
    /// A row of what was measured.
    pub fn new(knobs: &Knobs, measured: &Measured, errors: [f64; 2], against: &str) -> Self {
        let (half, half_settings) = measured.half.clone().unwrap_or_default();
        Self {
            preset: knobs.name.clone(),
            settings: knobs.text(),
            seconds: measured.seconds,
            memory: measured.memory.map_or(0.0, |m| m as f64 / 1_048_576.0),
            error: errors[0],
            worst: errors[1],
            against: against.to_owned(),
            luxels: measured.luxels,
            processor: measured.processor,
            expected: measured.expected.unwrap_or_default(),
            half,
            half_settings,
        }
    }

    /// Seconds of processors where these are known and not too few to be told apart.
    pub fn work(&self) -> Option<f64> {
        /// As they are told in hundredths.
        const LEAST: f64 = 0.2;
        Some(self.processor).filter(|&s| s >= LEAST)
    }

    fn parse(line: &str) -> Option<(u64, Self)> {
        let fields: Vec<&str> = line.split(',').collect();
        let [key, preset, settings, seconds, memory, error, worst, against, luxels, rest @ ..] =
            &fields[..]
        else {
            return None;
        };
        let [processor, expected_seconds, expected_error, half, half_settings] = rest else {
            return None;
        };
        let number = |text: &&str| text.parse::<f64>().ok().filter(|v| v.is_finite());
        let row = Self {
            preset: (*preset).to_owned(),
            settings: (*settings).to_owned(),
            seconds: number(seconds)?,
            memory: number(memory)?,
            error: number(error)?,
            worst: number(worst)?,
            against: (*against).to_owned(),
            luxels: number(luxels)?,
            processor: number(processor)?,
            expected: [number(expected_seconds)?, number(expected_error)?],
            half: number(half)?,
            half_settings: (*half_settings).to_owned(),
        };
        Some((u64::from_str_radix(key, 16).ok()?, row))
    }
}

/// All lines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    rows: Vec<(u64, Row)>,
}

impl Table {
    /// The table in a file; an empty one if there is none. Lines that make no sense, such as the last
    /// of a full disk, are left out.
    ///
    /// # Errors
    /// When the file cannot be read or is of another kind.
    pub fn read(path: &Path) -> Result<Self> {
        let text = match std::fs::read_to_string(path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Self::default()),
            other => other.map_err(Error::io("read", path))?,
        };
        let mut lines = text.lines();
        if lines.next() != Some(HEAD) {
            let problem = "it is no table of a sweep; choose another folder or remove it";
            return Err(Error::format(path.display().to_string(), problem));
        }
        Ok(Self { rows: lines.filter_map(Row::parse).collect() })
    }

    /// The row with a key.
    pub fn row(&self, key: u64) -> Option<&Row> {
        self.rows.iter().find(|r| r.0 == key).map(|r| &r.1)
    }

    /// Adds a row, in the place of one with the same key.
    pub fn insert(&mut self, key: u64, row: Row) {
        self.rows.retain(|r| r.0 != key);
        self.rows.push((key, row));
    }

    /// Leaves out rows with other keys.
    pub fn retain(&mut self, keys: &[u64]) {
        self.rows.retain(|r| keys.contains(&r.0));
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The file.
    pub fn text(&self) -> String {
        let mut text = format!("{HEAD}\n");
        for (key, r) in &self.rows {
            let _ = writeln!(
                text,
                "{key:016x},{},{},{:.4},{:.2},{:.6},{:.6},{},{:.4},{:.2},{:.4},{:.6},{:.4},{}",
                r.preset,
                r.settings,
                r.seconds,
                r.memory,
                r.error,
                r.worst,
                r.against,
                r.luxels,
                r.processor,
                r.expected[0],
                r.expected[1],
                r.half,
                r.half_settings
            );
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_reads_back_and_survives_a_cut_line() {
        let knobs = Knobs { name: "draft".into(), values: vec![("a", "1".into())], picture: false };
        let measured = Measured { seconds: 1.5, memory: Some(3 << 20), ..Measured::default() };
        let mut table = Table::default();
        table.insert(7, Row::new(&knobs, &measured, [0.25, 0.5], "truth"));
        table.insert(9, Row::new(&Knobs::default(), &measured, [0.125, 2.0], "finest"));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sweep.csv");
        std::fs::write(&path, table.text() + "00000000000000ff,x,y,1.").unwrap();
        assert_eq!(Table::read(&path).unwrap(), table);
        table.retain(&[9, 11]);
        assert_eq!((table.len(), table.row(7)), (1, None));
        std::fs::write(&path, "something else\n").unwrap();
        assert!(Table::read(&path).is_err());
    }
}
