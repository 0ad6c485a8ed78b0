//! Curves and markers over one horizontal and one or two vertical axes, by plotters' charts, meshes and legends.

use std::path::Path;

use plotters::backend::SVGBackend;
use plotters::chart::{ChartBuilder, DualCoordChartContext, SeriesLabelPosition};
use plotters::coord::cartesian::Cartesian2d;
use plotters::element::PathElement;
use plotters::style::{BLACK, Color, FontStyle, IntoTextStyle, RGBColor, WHITE};

use super::page::{self, Area, LARGE, SMALL, font, pen, points, units};
use super::ruler::Ruler;
use super::series::{SAMPLE, Series};
use super::{Axis, Caption, Point, csv};
use crate::error::Error;

/// A chart of series.
#[derive(Clone)]
pub struct Chart {
    /// Title above the chart, if not empty.
    pub title: String,
    /// Of several panels, only that of the first is used.
    pub caption: Caption,
    pub x: Axis,
    pub y: Axis,
    /// A second vertical axis on the right.
    pub right: Option<Axis>,
    /// Place of the legend, if there are several series; at the top it is above the data, and the axis is extended by its height.
    pub legend: SeriesLabelPosition,
    pub series: Vec<Series>,
    /// True if axes are drawn.
    pub framed: bool,
    /// Width and height in points.
    pub size: (f64, f64),
}

impl Default for Chart {
    fn default() -> Self {
        Self {
            title: String::new(),
            caption: Caption::default(),
            x: Axis::default(),
            y: Axis::default(),
            right: None,
            legend: SeriesLabelPosition::UpperRight,
            series: Vec::new(),
            framed: true,
            size: (700.0, 450.0),
        }
    }
}

/// Charts of one size in a grid, row by row.
pub struct Panels {
    pub charts: Vec<Chart>,
    columns: usize,
    /// The legend above the grid.
    legend: Vec<Series>,
}

/// The coordinate systems of the frame: one with the left and one with the right vertical axis.
type Plane<'a> = DualCoordChartContext<'a, SVGBackend<'a>, Cartesian2d<Ruler, Ruler>, Cartesian2d<Ruler, Ruler>>;

/// The light grey of grids.
const GRID: RGBColor = RGBColor(228, 228, 228);
/// Space for the labels of a vertical and of the horizontal axis, in points.
const LABELS: (f64, f64) = (58.0, 40.0);
/// Margin outside the labels.
const EDGE: f64 = 8.0;
/// Space on the right without an axis, and above; a title needs more.
const MARGIN: f64 = 14.0;
const TITLE: f64 = 20.0;
/// Height of a line of the legend.
const LEGEND_LINE: f64 = 13.5;
/// Margin around the legend.
const LEGEND_MARGIN: f64 = 5.0;

impl Chart {
    /// Writes `<stem>.svg`, `<stem>.png` and `<stem>.csv`.
    pub fn save(&self, stem: &Path) -> Result<(), Error> {
        let csv = csv::series([&self.x.label, &self.y.label], &self.columns());
        page::save(stem, self.size, &self.caption, &csv, |area| self.draw(area))
    }

    /// The chart with this width and the height at which both axes have equal scales.
    pub fn equally_scaled(mut self, width: f64) -> Self {
        self.size = (width, 0.0);
        let [across, rest] = self.frame();
        let lengths = [&self.x, &self.y].map(|axis| axis.range.map_or(1.0, |(low, high)| high - low));
        self.size.1 = across * lengths[1] / lengths[0] + self.legend_room() - rest;
        self
    }

    /// The data of each series under its name and unit.
    fn columns(&self) -> Vec<(String, &[Point])> {
        let named = |series: &Series| {
            let right = self.right.as_ref().filter(|_| series.right_axis);
            heading(&series.name, &right.unwrap_or(&self.y).label)
        };
        let with_data = self.series.iter().filter(|series| !series.points.is_empty());
        with_data.map(|series| (named(series), series.points.as_slice())).collect()
    }

    fn draw(&self, area: &Area) -> Result<(), Error> {
        let ([x, y, right], frame) = (self.rulers(), self.frame());
        let mut chart = self.builder(area).build_cartesian_2d(x, y)?.set_secondary_coord(x, right);
        if self.framed {
            self.draw_axes(&mut chart, frame)?;
        }
        for series in &self.series {
            let (area, y) = match series.right_axis {
                true => (chart.secondary_plotting_area(), right),
                false => (chart.plotting_area(), y),
            };
            series.elements([x, y], frame).iter().try_for_each(|element| area.draw(element))?;
            if series.listed {
                series.name(chart.draw_series([PathElement::new(Vec::new(), BLACK)])?);
            }
        }
        for words in self.series.iter().filter_map(|series| series.words(area)) {
            chart.plotting_area().draw(&words)?;
        }
        if self.names() > 1 {
            chart
                .configure_series_labels()
                .position(self.legend.clone())
                .legend_area_size(units(SAMPLE + 6.0))
                .margin(units(LEGEND_MARGIN))
                .background_style(WHITE.filled())
                .border_style(pen(GRID, 0.75))
                .label_font(font(SMALL, FontStyle::Normal))
                .draw()?;
        }
        Ok(())
    }

    /// The title and the margins around the frame.
    fn builder<'a, 'b>(&self, area: &'b Area<'a>) -> ChartBuilder<'b, 'b, SVGBackend<'a>> {
        let mut builder = ChartBuilder::on(area);
        builder.margin_top(units(MARGIN)).margin_left(units(EDGE)).margin_right(units(MARGIN));
        if self.framed {
            builder.x_label_area_size(units(LABELS.1)).y_label_area_size(units(LABELS.0));
        }
        if self.right.is_some() {
            builder.margin_right(units(EDGE)).right_y_label_area_size(units(LABELS.0));
        }
        if !self.title.is_empty() {
            builder.caption(&self.title, font(LARGE, FontStyle::Bold));
        }
        builder
    }

    /// Draws axes, ticks and the grid.
    fn draw_axes(&self, chart: &mut Plane, [width, height]: [f64; 2]) -> Result<(), Error> {
        let (small, medium) = (font(SMALL, FontStyle::Normal), font(SMALL + 1.0, FontStyle::Normal));
        chart
            .configure_mesh()
            .x_labels((width / 55.0) as usize)
            .y_labels((height / 30.0) as usize)
            .max_light_lines(0)
            .bold_line_style(pen(GRID, 0.5))
            .axis_style(pen(BLACK, 0.75))
            .set_all_tick_mark_size(units(4.0))
            .label_style(small.clone())
            .axis_desc_style(medium.clone())
            .x_desc(&self.x.label)
            .y_desc(&self.y.label)
            .draw()?;
        let Some(axis) = &self.right else { return Ok(()) };
        let colour = self.series.iter().find(|series| series.right_axis).map_or(BLACK, |series| series.colour);
        chart
            .configure_secondary_axes()
            .axis_style(pen(BLACK, 0.75))
            .set_all_tick_mark_size(units(4.0))
            .label_style(small.color(&colour))
            .axis_desc_style(medium.color(&colour))
            .y_desc(&axis.label)
            .draw()?;
        Ok(())
    }

    /// Ranges of x, y on the left and y on the right.
    fn rulers(&self) -> [Ruler; 3] {
        let share = (self.legend_room() / self.frame()[1]).min(0.6);
        let vertical = |axis: &Axis, right: bool| {
            let series = self.series.iter().filter(move |series| series.right_axis == right);
            axis.fit(series.flat_map(|series| series.points.iter().map(|point| point.1)), 0.06).with_free(share)
        };
        let x = self.x.fit(self.series.iter().flat_map(|series| series.points.iter().map(|point| point.0)), 0.0);
        [x, vertical(&self.y, false), vertical(self.right.as_ref().unwrap_or(&self.y), true)]
    }

    /// Height of a legend above the data, in points.
    fn legend_room(&self) -> f64 {
        use SeriesLabelPosition::{UpperLeft, UpperMiddle, UpperRight};
        let above = matches!(self.legend, UpperLeft | UpperMiddle | UpperRight) && self.names() > 1;
        if above { LEGEND_LINE * self.names() as f64 + 2.0 * LEGEND_MARGIN + 4.0 } else { 0.0 }
    }

    /// Width and height of the frame in points.
    fn frame(&self) -> [f64; 2] {
        let labels = if self.framed { LABELS } else { (0.0, 0.0) };
        let beside = if self.right.is_some() { LABELS.0 + EDGE } else { MARGIN };
        let above = MARGIN + if self.title.is_empty() { 0.0 } else { TITLE };
        [self.size.0 - EDGE - labels.0 - beside, self.size.1 - labels.1 - above]
    }

    fn names(&self) -> usize {
        self.listed().count()
    }

    fn listed(&self) -> impl Iterator<Item = &Series> {
        self.series.iter().filter(|series| series.listed)
    }
}

/// Heading of a column: the name of the series, and the label of its axis unless it repeats the name or the name contains a unit.
fn heading(name: &str, label: &str) -> String {
    let name = name.trim_end_matches(" (left axis)").trim_end_matches(" (right axis)");
    let label = label.split_inclusive(']').next().unwrap_or(label);
    if name.contains('[') {
        name.to_owned()
    } else if label.starts_with(name) {
        label.to_owned()
    } else {
        format!("{name}: {label}")
    }
}

impl Panels {
    /// Charts in the given number of columns; a legend common to all of them is drawn once, above them.
    pub fn new(mut charts: Vec<Chart>, columns: usize) -> Self {
        let mut legend: Vec<Series> = charts.first().into_iter().flat_map(Chart::listed).cloned().collect();
        let same =
            |chart: &Chart| chart.names() == legend.len() && chart.listed().zip(&legend).all(|(a, b)| a.looks_like(b));
        if charts.len() < 2 || legend.len() < 2 || !charts.iter().all(same) {
            legend.clear();
        } else {
            charts.iter_mut().flat_map(|chart| &mut chart.series).for_each(|series| series.listed = false);
        }
        Panels { charts, columns: columns.max(1), legend }
    }

    /// Writes `<stem>.svg`, `<stem>.png` and, in long form, `<stem>.csv`.
    pub fn save(&self, stem: &Path) -> Result<(), Error> {
        // Only the lowest panels have a label on the horizontal axis.
        let label = self.charts.iter().map(|chart| chart.x.label.as_str()).rfind(|label| !label.is_empty());
        let data = self.named().flat_map(|(panel, chart)| {
            let row = move |(name, points): (String, &[Point])| csv::points(&[&panel, &name], points);
            chart.columns().into_iter().map(row)
        });
        self.save_with(stem, &["panel", "series", label.unwrap_or("x"), "y"], data)
    }

    /// Writes the files of sketches; the data are in long form with numbered shapes.
    pub fn save_shapes(&self, stem: &Path) -> Result<(), Error> {
        let [x, y] = self.charts.first().map_or(["x", "y"], |chart| [&chart.x.label, &chart.y.label]);
        let data = self.named().flat_map(|(panel, chart)| {
            let row = move |(number, shape): (usize, &Series)| {
                csv::points(&[&panel, &number.to_string(), &shape.name], &shape.points)
            };
            (1..).zip(&chart.series).map(row)
        });
        self.save_with(stem, &["panel", "shape", "kind", x, y], data)
    }

    fn save_with(&self, stem: &Path, header: &[&str], data: impl Iterator<Item = String>) -> Result<(), Error> {
        let (columns, rows) = (self.columns, self.charts.len().div_ceil(self.columns).max(1));
        let (width, height) = self.charts.first().map_or((0.0, 0.0), |chart| chart.size);
        let csv: String = std::iter::once(csv::line(header)).chain(data).collect();
        let caption = self.charts.first().map_or_else(Caption::default, |chart| chart.caption.clone());
        let above = if self.legend.is_empty() { 0.0 } else { 2.0 * MARGIN };
        let size = (columns as f64 * width, above + rows as f64 * height);
        page::save(stem, size, &caption, &csv, |area| {
            let (strip, grid) = area.split_vertically(units(above));
            self.draw_legend(&strip, [size.0, above])?;
            let cells = grid.split_evenly((rows, columns));
            self.charts.iter().zip(&cells).try_for_each(|(chart, cell)| chart.draw(cell))
        })
    }

    /// The common legend in one centred line: a chart without axes whose unit is the point.
    fn draw_legend(&self, strip: &Area, [width, height]: [f64; 2]) -> Result<(), Error> {
        let style = font(SMALL + 1.0, FontStyle::Normal).into_text_style(strip);
        let length = |series: &Series| Ok(SAMPLE + 6.0 + points(strip.estimate_text_size(&series.name, &style)?.0));
        let lengths = self.legend.iter().map(length).collect::<Result<Vec<f64>, Error>>()?;
        let gaps = SAMPLE * lengths.len().saturating_sub(1) as f64;
        let mut left = 0.5 * (width - lengths.iter().sum::<f64>() - gaps);
        let series = self.legend.iter().zip(&lengths).flat_map(|(series, length)| {
            let sample = series.sample((left, 0.5 * height));
            left += length + SAMPLE;
            sample
        });
        let axis = |length| Axis { range: Some((0.0, length)), ..Axis::default() };
        Chart { series: series.collect(), framed: false, x: axis(width), y: axis(height), ..Chart::default() }.draw(strip)
    }

    /// The charts with their titles, or their numbers if they have no title.
    fn named(&self) -> impl Iterator<Item = (String, &Chart)> {
        (1..).zip(&self.charts).map(|(number, chart)| {
            let name = if chart.title.is_empty() { number.to_string() } else { chart.title.clone() };
            (name, chart)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::heading;

    #[test]
    fn columns_repeat_neither_names_nor_labels() {
        for (name, label, expected) in [
            ("cost J (left axis)", "cost J [rad²], linear scale", "cost J [rad²]"),
            ("position ‖Φ‖∞ [m, rad]", "largest violation of any constraint equation", "position ‖Φ‖∞ [m, rad]"),
            ("iteration 5", "force on the cart F [N]", "iteration 5: force on the cart F [N]"),
            ("order 2", "relative error", "order 2: relative error"),
        ] {
            assert_eq!(heading(name, label), expected);
        }
    }
}
