//! Curves and markers over one horizontal and one or two vertical axes, by plotters' charts, meshes and legends.

use std::path::Path;

use plotters::backend::SVGBackend;
use plotters::chart::{ChartBuilder, SeriesAnno, SeriesLabelPosition};
use plotters::element::{Circle, Cross, DashedPathElement, DynElement, EmptyElement, IntoDynElement, PathElement, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{BLACK, Color, FontStyle, IntoTextStyle, RGBColor, ShapeStyle, WHITE};

use super::page::{self, Area, LARGE, SMALL, font, pen, units};
use super::ruler::Ruler;
use super::{Axis, Colour, Point, csv};
use crate::error::Error;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    Line,
    Dashed,
    Circles,
    Crosses,
    /// A line with open circles, thinned where they would touch.
    LineAndCircles,
}

/// A curve or a cloud of points.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Its points; those not finite interrupt the line.
    pub points: Vec<Point>,
    pub colour: Colour,
    pub style: Style,
    /// Whether its y is that of the right axis.
    pub right_axis: bool,
    /// Whether the legend has it.
    pub listed: bool,
}

/// A chart of series.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Over the chart, if not empty.
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    /// A second vertical axis on the right.
    pub right: Option<Axis>,
    /// Where the names are, if there are several; at the top they stand above the data, the axis being longer by their height.
    pub legend: SeriesLabelPosition,
    pub series: Vec<Series>,
    /// Words on the right of a point of the left axis.
    pub note: Option<(Point, &'static str)>,
    /// Width and height in points.
    pub size: (f64, f64),
}

impl Default for Chart {
    fn default() -> Self {
        Self {
            title: String::new(),
            x: Axis::default(),
            y: Axis::default(),
            right: None,
            legend: SeriesLabelPosition::UpperRight,
            series: Vec::new(),
            note: None,
            size: (700.0, 450.0),
        }
    }
}

/// Charts of one size in a grid, row by row.
pub struct Panels {
    pub charts: Vec<Chart>,
    pub columns: usize,
}

/// The light grey of grids.
const GRID: RGBColor = RGBColor(228, 228, 228);
/// Room for the labels of a vertical and of the horizontal axis, in points.
const LABELS: (f64, f64) = (58.0, 40.0);
/// Room outside of the labels.
const EDGE: f64 = 8.0;
/// Room on the right if there is no axis, and above, where a title needs more.
const MARGIN: f64 = 14.0;
const TITLE: f64 = 20.0;
/// Height of a line of the legend.
const LEGEND_LINE: f64 = 13.5;
/// Room around the legend.
const LEGEND_MARGIN: f64 = 5.0;
/// Length of a sample in the legend.
const SAMPLE: f64 = 22.0;
/// Radius of markers.
const RADIUS: f64 = 3.25;

impl Chart {
    /// Writes `<stem>.svg`, `<stem>.png` and `<stem>.csv`.
    pub fn save(&self, stem: &Path) -> Result<(), Error> {
        page::save(stem, self.size, &csv::series([&self.x.label, &self.y.label], &self.columns()), |area| self.draw(area))
    }

    /// The data of each series, under its name and the label of its axis.
    fn columns(&self) -> Vec<(String, &[Point])> {
        let named = |series: &Series| {
            let right = self.right.as_ref().filter(|_| series.right_axis);
            format!("{}: {}", series.name, right.unwrap_or(&self.y).label)
        };
        let with_data = self.series.iter().filter(|series| !series.points.is_empty());
        with_data.map(|series| (named(series), series.points.as_slice())).collect()
    }

    fn draw(&self, area: &Area) -> Result<(), Error> {
        let [x, y, right] = self.rulers();
        let mut builder = ChartBuilder::on(area);
        builder.margin_top(units(MARGIN)).margin_left(units(EDGE));
        builder.x_label_area_size(units(LABELS.1)).y_label_area_size(units(LABELS.0));
        match &self.right {
            Some(_) => builder.margin_right(units(EDGE)).right_y_label_area_size(units(LABELS.0)),
            None => builder.margin_right(units(MARGIN)),
        };
        if !self.title.is_empty() {
            builder.caption(&self.title, font(LARGE, FontStyle::Bold));
        }
        let mut chart = builder.build_cartesian_2d(x, y)?.set_secondary_coord(x, right);
        let [width, height] = self.frame();
        let small = font(SMALL, FontStyle::Normal);
        chart
            .configure_mesh()
            .x_labels((width / 55.0) as usize)
            .y_labels((height / 30.0) as usize)
            .max_light_lines(0)
            .bold_line_style(pen(GRID, 0.5))
            .axis_style(pen(BLACK, 0.75))
            .set_all_tick_mark_size(units(4.0))
            .label_style(small.clone())
            .axis_desc_style(font(SMALL + 1.0, FontStyle::Normal))
            .x_desc(&self.x.label)
            .y_desc(&self.y.label)
            .draw()?;
        if let Some(axis) = &self.right {
            let colour = self.series.iter().find(|series| series.right_axis).map_or(BLACK, |series| series.colour);
            chart
                .configure_secondary_axes()
                .axis_style(pen(BLACK, 0.75))
                .set_all_tick_mark_size(units(4.0))
                .label_style(small.clone().color(&colour))
                .axis_desc_style(font(SMALL + 1.0, FontStyle::Normal).color(&colour))
                .y_desc(&axis.label)
                .draw()?;
        }
        for series in &self.series {
            let (area, y) = match series.right_axis {
                true => (chart.secondary_plotting_area(), right),
                false => (chart.plotting_area(), y),
            };
            series.elements([x, y], [width, height]).iter().try_for_each(|element| area.draw(element))?;
            if series.listed {
                series.name(chart.draw_series([PathElement::new(Vec::new(), BLACK)])?);
            }
        }
        if let Some((at, words)) = self.note {
            let style = small.clone().into_text_style(area).pos(Pos::new(HPos::Left, VPos::Center));
            let note = EmptyElement::at(at) + Text::new(words, (units(9.0), 0), style);
            chart.plotting_area().draw(&note)?;
        }
        if self.names() > 1 {
            chart
                .configure_series_labels()
                .position(self.legend.clone())
                .legend_area_size(units(SAMPLE + 6.0))
                .margin(units(LEGEND_MARGIN))
                .background_style(WHITE.filled())
                .border_style(pen(GRID, 0.75))
                .label_font(small)
                .draw()?;
        }
        Ok(())
    }

    /// Of x, y on the left and y on the right.
    fn rulers(&self) -> [Ruler; 3] {
        use SeriesLabelPosition::{UpperLeft, UpperMiddle, UpperRight};
        let of = |right: bool| self.series.iter().filter(move |series| series.right_axis == right);
        let above = matches!(self.legend, UpperLeft | UpperMiddle | UpperRight) && self.names() > 1;
        let legend = LEGEND_LINE * self.names() as f64 + 2.0 * LEGEND_MARGIN + 4.0;
        let share = if above { (legend / self.frame()[1]).min(0.6) } else { 0.0 };
        let vertical = |axis: &Axis, right: bool| {
            let values = of(right).flat_map(|series| series.points.iter().map(|point| point.1));
            axis.fit(values, 0.06).with_free(share)
        };
        let x = self.x.fit(self.series.iter().flat_map(|series| series.points.iter().map(|point| point.0)), 0.0);
        [x, vertical(&self.y, false), vertical(self.right.as_ref().unwrap_or(&self.y), true)]
    }

    /// Width and height of the frame in points.
    fn frame(&self) -> [f64; 2] {
        let beside = if self.right.is_some() { LABELS.0 + EDGE } else { MARGIN };
        let above = MARGIN + if self.title.is_empty() { 0.0 } else { TITLE };
        [self.size.0 - EDGE - LABELS.0 - beside, self.size.1 - LABELS.1 - above]
    }

    fn names(&self) -> usize {
        self.series.iter().filter(|series| series.listed).count()
    }
}

impl Panels {
    /// Writes `<stem>.svg`, `<stem>.png` and, in long form, `<stem>.csv`.
    pub fn save(&self, stem: &Path) -> Result<(), Error> {
        let (columns, rows) = (self.columns.max(1), self.charts.len().div_ceil(self.columns.max(1)).max(1));
        let (width, height) = self.charts.first().map_or((0.0, 0.0), |chart| chart.size);
        page::save(stem, (columns as f64 * width, rows as f64 * height), &self.csv(), |area| {
            let cells = area.split_evenly((rows, columns));
            self.charts.iter().zip(&cells).try_for_each(|(chart, cell)| chart.draw(cell))
        })
    }

    /// All data, a chart without a title being called by its number.
    fn csv(&self) -> String {
        // Panels above others have no label of their own.
        let label = self.charts.iter().map(|chart| chart.x.label.as_str()).rfind(|label| !label.is_empty());
        let header = csv::line(["panel", "series", label.unwrap_or("x"), "y"].map(str::to_owned));
        let rows = self.charts.iter().enumerate().map(|(index, chart)| {
            let panel = if chart.title.is_empty() { (index + 1).to_string() } else { chart.title.clone() };
            csv::long(&chart.columns(), Some(&panel))
        });
        std::iter::once(header).chain(rows).collect()
    }
}

/// Something to draw at coordinates C.
type Element<'a, C> = DynElement<'a, SVGBackend<'a>, C>;

impl Series {
    /// A series of the left axis.
    pub fn new(name: impl Into<String>, points: Vec<Point>, colour: Colour, style: Style) -> Self {
        Series { name: name.into(), points, colour, style, right_axis: false, listed: true }
    }

    /// Values over their times.
    pub fn over(times: &[f64], values: &[f64], name: impl Into<String>, colour: Colour, style: Style) -> Self {
        Self::new(name, times.iter().copied().zip(values.iter().copied()).collect(), colour, style)
    }

    /// The line, in pieces where points are missing, and the markers, in a frame of this size in points.
    fn elements<'a>(&self, [x, y]: [Ruler; 2], [width, height]: [f64; 2]) -> Vec<Element<'a, Point>> {
        let place = |point: &Point| Some((width * x.fraction(point.0)?, height * y.fraction(point.1)?));
        let pieces = self.points.split(|point| place(point).is_none());
        let mut elements: Vec<_> = pieces.map(|piece| self.stroke(piece.to_vec())).collect();
        let spacing = if self.style == Style::LineAndCircles { 9.0 } else { 0.0 };
        let mut last: Option<Point> = None;
        for (point, at) in self.points.iter().filter_map(|point| Some((point, place(point)?))) {
            if last.is_none_or(|last| (at.0 - last.0).hypot(at.1 - last.1) >= spacing) {
                elements.push(self.mark(*point));
                last = Some(at);
            }
        }
        elements
    }

    /// Enters the name into the legend, with a sample of the line and the marker.
    fn name<'a>(&self, legend: &mut SeriesAnno<'a, SVGBackend<'a>>) {
        let (line, pen, dashes) = (pen(self.colour, 1.5), pen(self.colour, 1.25), [units(6.0), units(4.0)]);
        let half = units(0.5 * SAMPLE);
        let middle = move |(x, y): (i32, i32)| EmptyElement::at((x + half, y));
        let legend = legend.label(&self.name);
        match self.style {
            Style::Line => legend.legend(move |(x, y)| PathElement::new([(x, y), (x + 2 * half, y)], line)),
            Style::Dashed => {
                legend.legend(move |(x, y)| DashedPathElement::new([(x, y), (x + 2 * half, y)], dashes[0], dashes[1], line))
            }
            Style::Circles => legend.legend(move |at| middle(at) + circle(WHITE.filled()) + circle(pen)),
            Style::Crosses => legend.legend(move |(x, y)| Cross::new((x + half, y), units(RADIUS), pen)),
            Style::LineAndCircles => legend.legend(move |at| {
                middle(at) + PathElement::new([(-half, 0), (half, 0)], line) + circle(WHITE.filled()) + circle(pen)
            }),
        };
    }

    /// The line, if the style has one.
    fn stroke<'a, C: Clone + 'static>(&self, line: Vec<C>) -> Element<'a, C> {
        let style = pen(self.colour, 1.5);
        match self.style {
            Style::Line | Style::LineAndCircles => PathElement::new(line, style).into_dyn(),
            Style::Dashed => DashedPathElement::new(line, units(6.0), units(4.0), style).into_dyn(),
            Style::Circles | Style::Crosses => PathElement::new(Vec::new(), style).into_dyn(),
        }
    }

    /// The marker, if the style has one.
    fn mark<'a, C: Clone + 'static>(&self, at: C) -> Element<'a, C> {
        let pen = pen(self.colour, 1.25);
        match self.style {
            Style::Line | Style::Dashed => EmptyElement::at(at).into_dyn(),
            Style::Circles | Style::LineAndCircles => {
                (EmptyElement::at(at) + circle(WHITE.filled()) + circle(pen)).into_dyn()
            }
            Style::Crosses => Cross::new(at, units(RADIUS), pen).into_dyn(),
        }
    }
}

/// A marker beside which nothing is.
fn circle(style: ShapeStyle) -> Circle<(i32, i32), i32> {
    Circle::new((0, 0), units(RADIUS), style)
}
