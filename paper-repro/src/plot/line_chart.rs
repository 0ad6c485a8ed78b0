//! Curves and markers over one horizontal and one or two vertical axes.

use super::{
    Axis, Colour, Legend, Point,
    axis::{Ruler, Tick},
    canvas::Canvas,
    csv,
    frame::{self, Frame, Margins, Rect},
    legend::Entry,
};
use crate::error::Error;
use std::path::Path;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// A continuous line.
    #[default]
    Line,
    /// A dashed line.
    Dashed,
    /// An open circle at each point.
    Circles,
    /// A cross at each point.
    Crosses,
    /// A line with open circles, thinned where they would touch.
    LineAndCircles,
}

/// A curve or a cloud of points.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// Its name in the legend, which an unnamed series does not enter.
    pub name: String,
    /// Its points; those not finite interrupt the line.
    pub points: Vec<Point>,
    /// Its colour.
    pub colour: Colour,
    /// How it is drawn.
    pub style: Style,
    /// Whether its y is that of the right axis.
    pub right_axis: bool,
}

/// A chart of series.
#[derive(Clone, Debug)]
pub struct LineChart {
    /// Over the chart, if not empty.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis on the left.
    pub y: Axis,
    /// A second vertical axis on the right.
    pub right: Option<Axis>,
    /// Where the names are.
    pub legend: Legend,
    /// The series, later over earlier.
    pub series: Vec<Series>,
    /// Width and height in points; the PNG has two pixels to the point.
    pub size: (f64, f64),
}

impl Default for LineChart {
    fn default() -> Self {
        Self {
            title: String::new(),
            x: Axis::default(),
            y: Axis::default(),
            right: None,
            legend: Legend::Auto,
            series: Vec::new(),
            size: (700.0, 450.0),
        }
    }
}

/// What a chart needs around its frame, and where its legend is.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    /// Room around the frame.
    pub(super) margins: Margins,
    legend: Legend,
}

impl LineChart {
    /// Writes `<stem>.svg`, `<stem>.png` and `<stem>.csv`.
    pub fn save(&self, stem: &Path) -> Result<(), Error> {
        let mut canvas = Canvas::new(self.size.0, self.size.1);
        let page = Rect { left: 4.0, top: 4.0, right: self.size.0 - 4.0, bottom: self.size.1 - 4.0 };
        let layout = self.layout(page);
        self.draw(&mut canvas, page.inside(layout.margins), layout);
        super::save(stem, &canvas, &csv::series(&self.x.label, &self.columns()))
    }

    /// The named points.
    pub(super) fn columns(&self) -> Vec<(&str, &[Point])> {
        self.series.iter().map(|series| (series.name.as_str(), series.points.as_slice())).collect()
    }

    /// The room to leave around the frame within the cell.
    pub(super) fn layout(&self, cell: Rect) -> Layout {
        let top = frame::above(&self.title);
        let bottom = frame::below(&self.x.label);
        let height = cell.height() - top - bottom;
        let left = frame::beside(&vertical_ticks(&self.y_ruler(false), height), &self.y.label);
        let right = self
            .right
            .as_ref()
            .map_or(16.0, |axis| frame::beside(&vertical_ticks(&self.y_ruler(true), height), &axis.label));
        let mut margins = Margins { left, top, right, bottom };
        let entries = self.entries();
        let rect = cell.inside(margins);
        let legend = self.legend.settled(&entries, rect, |region| self.covers(rect, region));
        margins.top += legend.height_above(&entries, rect.width());
        Layout { margins, legend }
    }

    /// Draws the chart with its frame at the rectangle.
    pub(super) fn draw(&self, canvas: &mut Canvas, rect: Rect, layout: Layout) {
        let left = Frame { rect, x: self.x_ruler(), y: self.y_ruler(false) };
        let right = Frame { y: self.y_ruler(true), ..left };
        let x_ticks = left.x.ticks(frame::ticks_along(rect.width(), 65.0));
        let y_ticks = vertical_ticks(&left.y, rect.height());
        left.grid(canvas, &x_ticks, &y_ticks);
        let entries = self.entries();
        let title_rise = 0.8 * frame::LARGE + layout.legend.height_above(&entries, rect.width());
        left.outline(canvas);
        left.title(canvas, &self.title, title_rise);
        left.x_axis(canvas, &x_ticks, &self.x.label);
        left.y_axis(canvas, &y_ticks, &self.y.label, Colour::BLACK, false);
        if let Some(axis) = &self.right {
            let colour = self.series.iter().find(|series| series.right_axis).map_or(Colour::BLACK, |it| it.colour);
            right.y_axis(canvas, &vertical_ticks(&right.y, rect.height()), &axis.label, colour, true);
        }
        for series in &self.series {
            series.draw(canvas, if series.right_axis { &right } else { &left });
        }
        layout.legend.draw(canvas, &entries, rect);
    }

    /// The ruler of the horizontal axis, without margins.
    fn x_ruler(&self) -> Ruler {
        Ruler::fit(&self.x, self.series.iter().flat_map(|series| series.points.iter().map(|point| point.0)), 0.0)
    }

    /// The ruler of the left or right vertical axis.
    fn y_ruler(&self, on_right: bool) -> Ruler {
        let axis = if on_right { self.right.as_ref().unwrap_or(&self.y) } else { &self.y };
        let series = self.series.iter().filter(|series| series.right_axis == on_right);
        Ruler::fit(axis, series.flat_map(|series| series.points.iter().map(|point| point.1)), 0.06)
    }

    /// The names for the legend.
    fn entries(&self) -> Vec<Entry<'_>> {
        let named = self.series.iter().filter(|series| !series.name.is_empty());
        named
            .map(|series| Entry { name: &series.name, sample: Box::new(|canvas, a, b| series.sample(canvas, a, b)) })
            .collect()
    }

    /// Whether a series passes through the region of the page, the frame being at the rectangle.
    fn covers(&self, rect: Rect, region: Rect) -> bool {
        self.series.iter().any(|series| {
            let frame = Frame { rect, x: self.x_ruler(), y: self.y_ruler(series.right_axis) };
            let runs = runs(&series.points, &frame);
            runs.iter().any(|run| match series.style {
                Style::Circles | Style::Crosses => run.iter().any(|point| region.holds(*point)),
                _ => run.windows(2).any(|pair| region.clip(pair[0], pair[1]).is_some()),
            })
        })
    }
}

impl Series {
    /// Line width in points.
    const WIDTH: f64 = 1.5;

    /// Draws the series in the frame.
    fn draw(&self, canvas: &mut Canvas, frame: &Frame) {
        let runs = runs(&self.points, frame);
        for line in runs.iter().flat_map(|run| frame.rect.clip_line(run)) {
            self.stroke(canvas, line);
        }
        let spacing = if self.style == Style::LineAndCircles { 9.0 } else { 0.0 };
        let mut last: Option<Point> = None;
        for &point in runs.iter().flatten().filter(|point| frame.rect.holds(**point)) {
            if last.is_none_or(|(x, y)| (point.0 - x).hypot(point.1 - y) >= spacing) {
                self.mark(canvas, point);
                last = Some(point);
            }
        }
    }

    /// Draws a sample of the series from the one point to the other.
    fn sample(&self, canvas: &mut Canvas, from: Point, to: Point) {
        self.stroke(canvas, vec![from, to]);
        self.mark(canvas, (0.5 * (from.0 + to.0), from.1));
    }

    /// Draws the line, if the style has one.
    fn stroke(&self, canvas: &mut Canvas, line: Vec<Point>) {
        match self.style {
            Style::Line | Style::LineAndCircles => canvas.line(line, self.colour, Self::WIDTH),
            Style::Dashed => canvas.dashes(line, self.colour, Self::WIDTH),
            Style::Circles | Style::Crosses => {}
        }
    }

    /// Draws the marker, if the style has one.
    fn mark(&self, canvas: &mut Canvas, (x, y): Point) {
        const RADIUS: f64 = 3.25;
        match self.style {
            Style::Line | Style::Dashed => {}
            Style::Circles | Style::LineAndCircles => {
                canvas.disc((x, y), RADIUS, self.colour);
                canvas.disc((x, y), RADIUS - 1.25, Colour::WHITE);
            }
            Style::Crosses => {
                for tilt in [-RADIUS, RADIUS] {
                    canvas.line(vec![(x - RADIUS, y - tilt), (x + RADIUS, y + tilt)], self.colour, 1.25);
                }
            }
        }
    }
}

/// Ticks of a vertical ruler of the length.
fn vertical_ticks(ruler: &Ruler, length: f64) -> Vec<Tick> {
    ruler.ticks(frame::ticks_along(length, 34.0))
}

/// The places of the points on the page, broken where one has none.
fn runs(points: &[Point], frame: &Frame) -> Vec<Vec<Point>> {
    let placed: Vec<Option<Point>> = points.iter().map(|point| frame.at(*point)).collect();
    placed.split(Option::is_none).map(|run| run.iter().copied().flatten().collect()).collect()
}
