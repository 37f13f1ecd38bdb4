//! The table at the end of a run.

use std::fmt::{self, Display};
use std::time::Duration;

/// Rows of text and numbers, printed as two aligned columns.
#[derive(Clone, Debug, Default)]
pub struct Report {
    rows: Vec<(String, String)>,
}

impl Report {
    /// An empty table.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a row.
    pub fn row(&mut self, name: impl Into<String>, value: impl Display) {
        self.rows.push((name.into(), value.to_string()));
    }

    /// Adds a row with a count, its digits in groups of three.
    pub fn count(&mut self, name: impl Into<String>, value: u64) {
        let digits = value.to_string();
        let mut grouped = String::new();
        for (i, d) in digits.chars().enumerate() {
            if i > 0 && (digits.len() - i).is_multiple_of(3) {
                grouped.push(' ');
            }
            grouped.push(d);
        }
        self.row(name, grouped);
    }

    /// Adds a row a stage, in seconds, their sum, and the peak memory.
    pub fn resources(&mut self, stages: &[(&'static str, Duration)], total: Duration) {
        for (name, time) in stages {
            self.row(format!("  {name}"), format!("{:.2} s", time.as_secs_f64()));
        }
        self.row("time", format!("{:.2} s", total.as_secs_f64()));
        let memory = peak_memory();
        let text = memory.map_or("not known here".into(), |m| format!("{} MiB", m >> 20));
        self.row("peak memory", text);
    }
}

impl Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
        for (name, value) in &self.rows {
            writeln!(f, "{name:width$}  {value}")?;
        }
        Ok(())
    }
}

/// Largest resident size of this process so far in bytes, where the system tells it.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok().map(|kib| kib << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let mut report = Report::new();
        report.count("faces", 1234567);
        report.row("longer name", "x");
        assert_eq!(report.to_string(), "faces        1 234 567\nlonger name  x\n");
    }
}
