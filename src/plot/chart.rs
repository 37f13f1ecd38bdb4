//! Charts of error against cost: both axes are logarithmic.

use super::pixels::Pixels;
use image::RgbImage;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::ops::Range;

/// Width and height of a chart in pixels.
const SIZE: [u32; 2] = [860, 540];
/// Size of the legend's letters. The library takes them for 0.455 of it wide, those of pictures are 8
/// pixels wide: its box fits both.
const LEGEND: f64 = 17.6;

/// How the points of a series are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Small dots.
    Dots,
    /// A line from point to point.
    Line,
    /// Rings, with the names of the points.
    Rings,
}

/// Points of one kind.
#[derive(Clone, Debug)]
pub struct Series {
    /// What they are.
    pub name: String,
    /// Red, green and blue.
    pub colour: [u8; 3],
    /// How they are drawn.
    pub mark: Mark,
    /// The points: both coordinates above 0, or they are left out.
    pub points: Vec<(f64, f64)>,
    /// Names of the points, for rings.
    pub labels: Vec<String>,
}

/// A chart with two logarithmic axes.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// What the horizontal axis is, with its unit.
    pub x: String,
    /// What the vertical axis is, with its unit.
    pub y: String,
    /// What it shows.
    pub series: Vec<Series>,
}

/// What drawing can fail with.
type Failed<B> = DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>;

impl Chart {
    /// The chart as an SVG file.
    pub fn svg(&self) -> String {
        let mut text = String::new();
        let area = SVGBackend::with_string(&mut text, SIZE.into()).into_drawing_area();
        if let Err(problem) = self.draw(&area) {
            log::warn!("{}: cannot draw it: {problem}", self.title);
        }
        drop(area);
        text
    }

    /// The chart as pixels.
    pub fn picture(&self) -> RgbImage {
        let mut picture = RgbImage::new(SIZE[0], SIZE[1]);
        let area = Pixels(&mut picture).into_drawing_area();
        if let Err(problem) = self.draw(&area) {
            log::warn!("{}: cannot draw it: {problem}", self.title);
        }
        drop(area);
        picture
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), Failed<B>> {
        area.fill(&WHITE)?;
        let shown = || self.series.iter().flat_map(|s| s.points.iter().copied().filter(usable));
        let x = range(shown().map(|p| p.0));
        let y = range(shown().map(|p| p.1));
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d(x.log_scale(), y.log_scale())?;
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .label_style(("sans-serif", 13))
            .axis_desc_style(("sans-serif", 14))
            .x_label_formatter(&|v| short(*v))
            .y_label_formatter(&|v| short(*v))
            .light_line_style(RGBColor(240, 240, 240))
            .draw()?;
        for series in &self.series {
            let [r, g, b] = series.colour;
            let colour = RGBColor(r, g, b);
            let points = series.points.iter().copied().filter(usable);
            let drawn = match series.mark {
                Mark::Dots => {
                    chart.draw_series(points.map(|p| Circle::new(p, 3, colour.filled())))?
                }
                Mark::Line => chart.draw_series(LineSeries::new(points, colour.stroke_width(2)))?,
                Mark::Rings => {
                    for (label, point) in series.labels.iter().zip(&series.points) {
                        if usable(point) {
                            let style = ("sans-serif", 13).into_text_style(area).color(&colour);
                            let text = Text::new(label.clone(), (8, -12), style);
                            let text = EmptyElement::at(*point) + text;
                            chart.draw_series(std::iter::once(text))?;
                        }
                    }
                    chart.draw_series(points.map(|p| Circle::new(p, 6, colour.stroke_width(2))))?
                }
            };
            if !series.name.is_empty() {
                drawn
                    .label(&series.name)
                    .legend(move |(x, y)| Circle::new((x + 10, y), 4, colour.filled()));
            }
        }
        chart
            .configure_series_labels()
            .border_style(BLACK)
            .background_style(WHITE.mix(0.85))
            .label_font(("sans-serif", LEGEND))
            .draw()?;
        area.present()
    }
}

fn usable(p: &(f64, f64)) -> bool {
    [p.0, p.1].iter().all(|v| *v > 0.0 && v.is_finite())
}

/// A range around positive numbers.
fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
    if high > 0.0 { low / 1.4..high * 1.4 } else { 1.0..10.0 }
}

/// A number with as few digits as tell it.
fn short(v: f64) -> String {
    let digits = (1.0 - v.abs().max(1e-9).log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{v:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: Vec<(f64, f64)>) -> Chart {
        let series = Series {
            name: "all".into(),
            colour: [200, 0, 0],
            mark: Mark::Rings,
            labels: points.iter().map(|p| format!("{:.0}", p.0)).collect(),
            points,
        };
        Chart { title: "t".into(), x: "s".into(), y: "%".into(), series: vec![series] }
    }

    #[test]
    fn charts_are_drawn_whatever_their_points() {
        for points in
            [vec![], vec![(1.0, 1.0)], vec![(0.0, -1.0)], vec![(1e-9, 1e9), (3.0, f64::NAN)]]
        {
            let chart = chart(points);
            assert!(chart.svg().ends_with("</svg>\n"));
            assert_eq!(chart.picture().dimensions(), (SIZE[0], SIZE[1]));
        }
    }

    #[test]
    fn points_are_in_the_picture() {
        let picture = chart(vec![(1.0, 2.0), (10.0, 1.0)]).picture();
        assert!(picture.pixels().filter(|p| p.0 == [200, 0, 0]).count() > 40);
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!([0.01, 0.5, 2.0, 150.0].map(short), ["0.01", "0.5", "2", "150"]);
    }
}
