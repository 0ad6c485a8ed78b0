//! Elements of charts: curves, clouds of points, and shapes of sketches.

use plotters::backend::SVGBackend;
use plotters::chart::SeriesAnno;
use plotters::element::{
    Circle, Cross, DashedPathElement, DynElement, EmptyElement, IntoDynElement, PathElement, Polygon, Text,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, IntoTextStyle, ShapeStyle, WHITE};

use super::page::{Area, SMALL, font, pen, units};
use super::ruler::Ruler;
use super::{Colour, Point, colour};

/// Style of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    Line,
    Dashed,
    Circles,
    Crosses,
    /// A line with open circles, fewer of them if they would touch.
    LineAndCircles,
    /// The area within a closed line.
    Filled,
    /// A line with arrows at the given number of its ends.
    Arrow(usize),
    /// A line hatched on the right of its direction.
    Hatched,
}

/// A curve, a cloud of points or a shape.
#[derive(Clone)]
pub struct Series {
    /// Name in the legend, or kind of shape.
    pub name: String,
    /// The points; points that are not finite interrupt the line.
    pub points: Vec<Point>,
    pub colour: Colour,
    pub style: Style,
    /// Width of the line in points.
    pub width: f64,
    /// True if y refers to the right axis.
    pub right_axis: bool,
    /// True if the legend contains the series.
    pub listed: bool,
    pub note: Option<Note>,
}

/// A note beside a point of the data: its offset to the right and up in points, and the side of the text at that position.
#[derive(Clone)]
pub struct Note {
    pub words: String,
    pub at: Point,
    pub away: Point,
    pub side: HPos,
}

/// Length of a sample in the legend.
pub(super) const SAMPLE: f64 = 22.0;
/// Radius of markers, and the width of their lines.
const RADIUS: f64 = 3.25;
const RIM: f64 = 1.25;
/// Length of the head of an arrow, and distance between the lines of a hatching.
const HEAD: f64 = 7.0;

/// A drawing element at points of the data.
type Element<'a> = DynElement<'a, SVGBackend<'a>, Point>;

impl Series {
    /// A series of the left axis.
    pub fn new(name: impl Into<String>, points: Vec<Point>, colour: Colour, style: Style) -> Self {
        Series { name: name.into(), points, colour, style, width: 1.5, right_axis: false, listed: true, note: None }
    }

    /// A series of values over times.
    pub fn over(times: &[f64], values: &[f64], name: impl Into<String>, colour: Colour, style: Style) -> Self {
        Self::new(name, times.iter().copied().zip(values.iter().copied()).collect(), colour, style)
    }

    /// A shape of a sketch, which does not appear in a legend.
    pub fn shape(kind: &str, points: Vec<Point>, colour: Colour, style: Style, width: f64) -> Self {
        Series { width, listed: false, ..Self::new(kind, points, colour, style) }
    }

    /// The series with a note beside a point.
    pub fn noted(self, words: impl Into<String>, at: Point, away: Point, side: HPos) -> Self {
        Series { note: Some(Note { words: words.into(), at, away, side }), ..self }
    }

    /// The line (interrupted at missing points), markers, and arrows or hatching, in a frame of this size in points.
    pub(super) fn elements<'a>(&self, [x, y]: [Ruler; 2], [width, height]: [f64; 2]) -> Vec<Element<'a>> {
        let place = |point: &Point| Some((width * x.fraction(point.0)?, height * y.fraction(point.1)?));
        let pieces = self.points.split(|point| place(point).is_none());
        let mut elements: Vec<_> = pieces.map(|piece| self.stroke(piece.to_vec())).collect();
        let spacing = if self.style == Style::LineAndCircles { 9.0 } else { 0.0 };
        let mut last: Option<Point> = None;
        let placed: Vec<(Point, Point)> = self.points.iter().filter_map(|point| Some((*point, place(point)?))).collect();
        for &(point, at) in &placed {
            if last.is_none_or(|last| (at.0 - last.0).hypot(at.1 - last.1) >= spacing) {
                elements.push(self.mark(point));
                last = Some(at);
            }
        }
        match (self.style, &placed[..]) {
            (Style::Arrow(heads), [first, .., last]) => {
                let ends = [(first, last), (last, first)].into_iter().take(heads);
                elements.extend(ends.map(|(tail, tip)| self.head(tail.1, *tip)));
            }
            (Style::Hatched, [first, .., last]) => elements.extend(hatching(*first, last.1)),
            _ => {}
        }
        elements
    }

    /// The note beside a point.
    pub(super) fn words<'a>(&self, area: &Area<'a>) -> Option<Element<'a>> {
        let Note { words, at, away, side } = self.note.as_ref()?;
        let style = font(SMALL + 1.0, FontStyle::Normal).color(&self.colour).into_text_style(area);
        let style = style.pos(Pos::new(*side, VPos::Center));
        Some((EmptyElement::at(*at) + Text::new(words.clone(), (units(away.0), -units(away.1)), style)).into_dyn())
    }

    /// Adds the name to the legend, with a sample of the line and the marker.
    pub(super) fn name<'a>(&self, legend: &mut SeriesAnno<'a, SVGBackend<'a>>) {
        let (line, rim, half) = (pen(self.colour, self.width), pen(self.colour, RIM), units(0.5 * SAMPLE));
        let middle = move |(x, y): (i32, i32)| EmptyElement::at((x + half, y));
        let ends = move |(x, y): (i32, i32)| [(x, y), (x + 2 * half, y)];
        let legend = legend.label(&self.name);
        match self.style {
            Style::Circles => legend.legend(move |at| middle(at) + circle(WHITE.filled()) + circle(rim)),
            Style::Crosses => legend.legend(move |(x, y)| Cross::new((x + half, y), units(RADIUS), rim)),
            Style::LineAndCircles => legend.legend(move |at| {
                middle(at) + PathElement::new([(-half, 0), (half, 0)], line) + circle(WHITE.filled()) + circle(rim)
            }),
            Style::Dashed => legend.legend(move |at| DashedPathElement::new(ends(at), units(6.0), units(4.0), line)),
            _ => legend.legend(move |at| PathElement::new(ends(at), line)),
        };
    }

    /// A sample with the name beside it, at the given distances from the left and from below in points.
    pub(super) fn sample(&self, (left, above): Point) -> [Series; 2] {
        let right = left + SAMPLE;
        let points = match self.style {
            Style::Circles | Style::Crosses => vec![(0.5 * (left + right), above)],
            _ => vec![(left, above), (right, above)],
        };
        let words = Series::shape("text", Vec::new(), colour::BLACK, Style::Line, 0.0);
        let words = words.noted(&self.name, (right, above), (6.0, 0.0), HPos::Left);
        [Series { points, listed: false, ..self.clone() }, words]
    }

    /// True if a legend shows another series in the same way.
    pub(super) fn looks_like(&self, other: &Series) -> bool {
        (&self.name, self.colour, self.style) == (&other.name, other.colour, other.style)
    }

    /// The line, if the style has one.
    fn stroke<'a>(&self, line: Vec<Point>) -> Element<'a> {
        let style = pen(self.colour, self.width);
        match self.style {
            Style::Dashed => DashedPathElement::new(line, units(6.0), units(4.0), style).into_dyn(),
            Style::Circles | Style::Crosses => PathElement::new(Vec::new(), style).into_dyn(),
            Style::Filled => Polygon::new(line, self.colour.filled()).into_dyn(),
            _ => PathElement::new(line, style).into_dyn(),
        }
    }

    /// The marker, if the style has one.
    fn mark<'a>(&self, at: Point) -> Element<'a> {
        match self.style {
            Style::Circles | Style::LineAndCircles => {
                (EmptyElement::at(at) + circle(WHITE.filled()) + circle(pen(self.colour, RIM))).into_dyn()
            }
            Style::Crosses => Cross::new(at, units(RADIUS), pen(self.colour, RIM)).into_dyn(),
            _ => EmptyElement::at(at).into_dyn(),
        }
    }

    /// The head of an arrow, whose tip is at a point of the data; tail and tip also as positions in points.
    fn head<'a>(&self, tail: Point, (tip, there): (Point, Point)) -> Element<'a> {
        let (beside, _) = along(tail, there);
        let corners = vec![(0, 0), beside(-HEAD, 0.4 * HEAD), beside(-HEAD, -0.4 * HEAD)];
        (EmptyElement::at(tip) + Polygon::new(corners, self.colour.filled())).into_dyn()
    }
}

/// A circular marker.
fn circle(style: ShapeStyle) -> Circle<(i32, i32), i32> {
    Circle::new((0, 0), units(RADIUS), style)
}

/// The hatching of a line from a point of the data, given also as a position in points, to another position.
fn hatching<'a>((from, there): (Point, Point), to: Point) -> impl Iterator<Item = Element<'a>> {
    let (beside, length) = along(there, to);
    (1..=(length / HEAD) as u32).map(move |stroke| {
        let start = HEAD * f64::from(stroke);
        let line = [beside(start, 0.0), beside(start - HEAD, HEAD)];
        (EmptyElement::at(from) + PathElement::new(line, pen(colour::GREY, 0.75))).into_dyn()
    })
}

/// Converts offsets ahead and to the right of the line between two positions to units of the page; also returns the line's length.
fn along(from: Point, to: Point) -> (impl Fn(f64, f64) -> (i32, i32), f64) {
    let (right, up) = (to.0 - from.0, to.1 - from.1);
    let length = right.hypot(up).max(1e-9);
    let (x, y) = (right / length, up / length);
    (move |ahead, beside| (units(ahead * x + beside * y), units(beside * x - ahead * y)), length)
}
