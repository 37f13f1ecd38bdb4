//! What `--estimate` prints.

use qrad::aim::{Estimated, TextPredicted};
use std::fmt::Write;

/// The presets of a map.
pub fn of_map(estimated: &[Estimated]) -> String {
    let row = |e: &Estimated| {
        let p = e.predicted;
        (format!("{:?}", e.quality), p.seconds, p.memory, p.error)
    };
    table(&mut estimated.iter().map(row))
}

/// The presets of a text scene.
pub fn of_text(estimated: &[TextPredicted]) -> String {
    let row = |e: &TextPredicted| (format!("{:?}", e.quality), e.seconds, e.memory, e.error);
    table(&mut estimated.iter().map(row))
}

fn table(rows: &mut dyn Iterator<Item = (String, f64, f64, f64)>) -> String {
    let mut text = String::from("quality    seconds     MiB   error\n");
    for (name, seconds, memory, error) in rows {
        let (name, memory) = (name.to_lowercase(), memory / 1_048_576.0);
        let _ = writeln!(text, "{name:9} {seconds:8.2} {memory:7.0} {:6.2} %", 100.0 * error);
    }
    text
}
