//! Several charts in one figure, their frames aligned.

use super::{
    Colour, LineChart,
    canvas::{Canvas, Text},
    csv,
    frame::{LARGE, Margins, Rect},
};
use crate::error::Error;
use std::path::Path;

/// Charts in a grid, row by row.
#[derive(Clone, Debug)]
pub struct Panels {
    /// Over all charts, if not empty.
    pub title: String,
    /// The charts, whose sizes are those of the cells that the first one gives.
    pub charts: Vec<LineChart>,
    /// How many stand side by side.
    pub columns: usize,
}

impl Default for Panels {
    fn default() -> Self {
        Self { title: String::new(), charts: Vec::new(), columns: 1 }
    }
}

/// Room between charts.
const GAP: f64 = 10.0;

impl Panels {
    /// Writes `<stem>.svg`, `<stem>.png` and `<stem>.csv`, the latter in long form.
    pub fn save(&self, stem: &Path) -> Result<(), Error> {
        let columns = self.columns.max(1);
        let rows = self.charts.len().div_ceil(columns).max(1);
        let (width, height) = self.charts.first().map_or((0.0, 0.0), |chart| chart.size);
        let (mut canvas, page) = titled_page(&self.title, (columns as f64 * width, rows as f64 * height));
        let cells: Vec<Rect> = (0..self.charts.len()).map(|index| page.cell(index, columns, rows, GAP)).collect();
        let layouts: Vec<_> = self.charts.iter().zip(&cells).map(|(chart, cell)| chart.layout(*cell)).collect();
        let margins = layouts.iter().fold(Margins::default(), |margins, layout| margins.or(layout.margins));
        for ((chart, cell), layout) in self.charts.iter().zip(&cells).zip(layouts) {
            chart.draw(&mut canvas, cell.inside(margins), layout);
        }
        super::save(stem, &canvas, &self.csv())
    }

    /// All data in long form, a chart without a title being called by its number.
    fn csv(&self) -> String {
        let header = csv::line(["panel", "series", "x", "y"].map(str::to_owned));
        let rows = self.charts.iter().enumerate().map(|(index, chart)| {
            let number = (index + 1).to_string();
            let panel = if chart.title.is_empty() { &number } else { &chart.title };
            csv::long(&chart.columns(), Some(panel))
        });
        std::iter::once(header).chain(rows).collect()
    }
}

/// A page with room for the size below its title, and that room.
pub(super) fn titled_page(title: &str, (width, height): (f64, f64)) -> (Canvas, Rect) {
    const EDGE: f64 = 4.0;
    let head = if title.is_empty() { 0.0 } else { 2.0 * LARGE };
    let mut canvas = Canvas::new(width, height + head);
    canvas.text(Text {
        text: title.to_owned(),
        at: (0.5 * width, 0.5 * head + EDGE),
        size: LARGE + 1.0,
        bold: true,
        colour: Colour::BLACK,
        ..Text::default()
    });
    let page = Rect { left: EDGE, top: EDGE + head, right: width - EDGE, bottom: height + head - EDGE };
    (canvas, page)
}
