//! Plots and the page of a sweep.

use super::bench::Knobs;
use super::frontier::{exponent, pareto};
use super::table::Row;
use crate::plot::{Chart, Mark, Page, Series};
use crate::{Result, output};
use image::RgbImage;
use std::collections::BTreeMap;
use std::path::Path;

/// Points whose memory or seconds are 0 are not known.
type Cost = fn(&Row) -> f64;

/// Seconds: those of processors if all rows tell them, since other programs do not change these much.
fn time(rows: &[(Knobs, Row)]) -> (&'static str, Cost) {
    if rows.iter().all(|r| r.1.work().is_some()) {
        ("processor seconds", |r| r.processor)
    } else {
        ("seconds", |r| r.seconds)
    }
}

/// A chart of error against a cost, with the front and the presets.
fn chart(title: &str, rows: &[(Knobs, Row)], axis: &str, cost: Cost) -> Chart {
    let points: Vec<(f64, f64)> = rows.iter().map(|r| (cost(&r.1), 100.0 * r.1.error)).collect();
    let front: Vec<_> = pareto(&points).into_iter().map(|i| points[i]).collect();
    let presets: Vec<usize> = (0..rows.len()).filter(|&i| !rows[i].0.name.is_empty()).collect();
    let series = |name: &str, colour, mark, points| Series {
        name: name.to_owned(),
        colour,
        mark,
        points,
        labels: Vec::new(),
    };
    let mut named =
        series("presets", [200, 40, 30], Mark::Rings, presets.iter().map(|&i| points[i]).collect());
    named.labels = presets.iter().map(|&i| rows[i].0.name.clone()).collect();
    Chart {
        title: title.to_owned(),
        x: axis.to_owned(),
        y: "error, % rms".to_owned(),
        series: vec![
            series("all points", [120, 120, 120], Mark::Dots, points),
            series("Pareto front", [40, 90, 170], Mark::Line, front),
            named,
        ],
    }
}

/// Each setting alone, around the preset `normal`: name, values, and exponent of error against seconds.
pub(super) fn exponents(rows: &[(Knobs, Row)]) -> Vec<(String, Vec<String>, Option<f64>)> {
    let (_, time) = time(rows);
    let Some((normal, _)) = rows.iter().find(|r| r.0.name == "normal") else { return Vec::new() };
    let mut found = Vec::new();
    for (place, (name, _)) in normal.values.iter().enumerate() {
        let others_same = |k: &Knobs| {
            let differ = |i: usize| k.values.get(i) != normal.values.get(i);
            (0..normal.values.len()).all(|i| i == place || !differ(i))
        };
        let line: Vec<&(Knobs, Row)> = rows.iter().filter(|r| others_same(&r.0)).collect();
        if line.len() < 2 {
            continue;
        }
        let of = |r: &&(Knobs, Row)| {
            let (value, row) = (&r.0.values[place].1, &r.1);
            format!("{value}: {:.2} % in {:.2} s", 100.0 * row.error, time(row))
        };
        let points: Vec<(f64, f64)> = line.iter().map(|r| (time(&r.1), r.1.error)).collect();
        found.push(((*name).to_owned(), line.iter().map(of).collect(), exponent(&points)));
    }
    found
}

/// What is left of the error of the finest settings, if errors are against these: the line through the
/// front, in logarithms, prolonged to their time.
fn left_at_finest(rows: &[(Knobs, Row)]) -> Option<f64> {
    let (_, time) = time(rows);
    let finest = time(&rows.last()?.1);
    let points: Vec<(f64, f64)> = rows
        .iter()
        .filter(|r| r.1.error > 0.0 && time(&r.1) < finest)
        .map(|r| (time(&r.1), r.1.error))
        .collect();
    let front: Vec<(f64, f64)> = pareto(&points).into_iter().map(|i| points[i]).collect();
    let p = exponent(&front)?;
    let mean = |f: fn(&(f64, f64)) -> f64| {
        (front.iter().map(|v| f(v).ln()).sum::<f64>() / front.len() as f64).exp()
    };
    Some(mean(|v| v.1) * (finest / mean(|v| v.0)).powf(-p))
}

/// Writes `error-seconds` and `error-memory` as SVG and PNG, and `sweep.html`.
///
/// # Errors
/// When a file cannot be written.
pub(super) fn write(
    folder: &Path,
    title: &str,
    rows: &[(Knobs, Row)],
    pictures: &BTreeMap<String, RgbImage>,
) -> Result<()> {
    let (seconds_name, time) = time(rows);
    let charts = [
        ("error-seconds", chart(&format!("{title}: error and time"), rows, seconds_name, time)),
        ("error-memory", chart(&format!("{title}: error and memory"), rows, "MiB", |r| r.memory)),
    ];
    let mut page = Page::new(&format!("{title}: what accuracy costs"));
    let against = rows.first().map_or("", |r| &*r.1.against);
    page.text(&match (against, left_at_finest(rows)) {
        ("truth", _) => "Errors are against the truth that was given.".to_owned(),
        (_, Some(left)) => format!(
            "Errors are against the finest settings. Their own error is about {:.2} %, if the front \
             goes on as it does.",
            100.0 * left
        ),
        _ => "Errors are against the finest settings.".to_owned(),
    });
    for (name, chart) in &charts {
        let svg = chart.svg();
        output::write(&folder.join(format!("{name}.svg")), svg.as_bytes())?;
        output::write_png(&folder.join(format!("{name}.png")), &chart.picture())?;
        page.svg(&svg);
    }
    page.heading("One setting at a time, around normal");
    let lines: Vec<Vec<String>> = exponents(rows)
        .into_iter()
        .map(|(name, values, p)| {
            let halved = p.filter(|p| *p > 0.0).map(|p| (1.0 / p).exp2());
            let number = |v: Option<f64>| v.map_or("-".to_owned(), |v| format!("{v:.2}"));
            let halved = halved.filter(|h| *h < 1e4);
            vec![name, number(p), number(halved), values.join("; ")]
        })
        .collect();
    page.table(&["setting", "exponent", "half the error: times", "points"], &lines, &[]);
    page.heading("All points");
    let seconds: Vec<(f64, f64)> = rows.iter().map(|r| (time(&r.1), r.1.error)).collect();
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by(|&a, &b| seconds[a].0.total_cmp(&seconds[b].0));
    let front = pareto(&seconds);
    let on_front = |i: usize| front.contains(&order[i]);
    let marked: Vec<usize> = (0..order.len()).filter(|&i| on_front(i)).collect();
    let cells: Vec<Vec<String>> = order.iter().map(|&i| line(&rows[i].1)).collect();
    page.text("Those on the front are marked.");
    page.table(
        &["settings", "preset", "seconds", "of processors", "MiB", "rms", "largest"],
        &cells,
        &marked,
    );
    if pictures.len() > 1 {
        page.heading("Bounced light");
        let shown = ["draft", "normal", "final"].iter();
        let shown = shown.filter_map(|n| Some(((*n).to_owned(), pictures.get(*n)?.clone())));
        page.compare(&shown.collect::<Vec<_>>());
    }
    output::write(&folder.join("sweep.html"), page.finish().as_bytes())
}

fn line(row: &Row) -> Vec<String> {
    let memory = if row.memory > 0.0 { format!("{:.0}", row.memory) } else { "-".to_owned() };
    vec![
        row.settings.clone(),
        row.preset.clone(),
        format!("{:.2}", row.seconds),
        format!("{:.2}", row.processor),
        memory,
        format!("{:.3} %", 100.0 * row.error),
        format!("{:.1} %", 100.0 * row.worst),
    ]
}
