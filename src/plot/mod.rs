//! Plots and pages: charts as SVG or pixels, and HTML that stands alone.

mod bars;
mod chart;
mod page;
mod pixels;

pub use bars::bars;
pub use chart::{Chart, Mark, Series};
pub use page::{Page, escape};
