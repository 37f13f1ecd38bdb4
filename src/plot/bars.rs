//! Bars beside names: where the time went.

use plotters::prelude::*;

/// Height of a bar and its surroundings in pixels.
const STEP: u32 = 26;

/// An SVG file with one horizontal bar a name; values from 0 up, told in `unit`.
pub fn bars(rows: &[(String, f64)], unit: &str) -> String {
    let mut text = String::new();
    let height = STEP * rows.len() as u32 + 8;
    let most = rows.iter().map(|r| r.1).fold(1e-9, f64::max);
    let area = SVGBackend::with_string(&mut text, (760, height)).into_drawing_area();
    let draw = || -> Result<(), Box<dyn std::error::Error>> {
        for (i, (name, value)) in (0..).zip(rows) {
            let top = i * STEP as i32 + 6;
            let end = 190 + (value / most * 440.0) as i32;
            let bar =
                Rectangle::new([(190, top), (end, top + 16)], RGBColor(70, 110, 160).filled());
            area.draw(&bar).map_err(|e| e.to_string())?;
            let style = ("sans-serif", 14).into_font();
            area.draw(&Text::new(name.clone(), (4, top + 1), style.clone()))
                .map_err(|e| e.to_string())?;
            let value = format!("{value:.2} {unit}");
            area.draw(&Text::new(value, (end + 8, top + 1), style)).map_err(|e| e.to_string())?;
        }
        area.present().map_err(|e| e.to_string())?;
        Ok(())
    };
    if let Err(problem) = draw() {
        log::warn!("cannot draw bars: {problem}");
    }
    drop(area);
    text
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_row_has_its_bar() {
        let rows = [("one".to_owned(), 1.0), ("none".to_owned(), 0.0)];
        let svg = super::bars(&rows, "s");
        assert!(svg.contains("none") && svg.contains("1.00 s"));
        assert!(super::bars(&[], "s").contains("svg"));
    }
}
