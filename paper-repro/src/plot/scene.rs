//! Pictures of a planar mechanism, with one scale for both directions.

use std::f64::consts::TAU;
use std::path::Path;

use nalgebra::Vector2;
use plotters::chart::ChartBuilder;
use plotters::element::{Circle, DashedPathElement, PathElement, Polygon, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{BLACK, Color, FontStyle, IntoTextStyle, WHITE};

use super::page::{self, Area, LARGE, SMALL, font, pen, units};
use super::ruler::Ruler;
use super::{Colour, Point, colour, csv};
use crate::error::Error;
use crate::statistics::range;

/// A place on the page.
type Pixel = (i32, i32);

/// A thing in the plane of the mechanism: lengths are those of the data, widths of lines are in points.
#[derive(Clone)]
pub struct Shape {
    /// What it is called in the data.
    kind: &'static str,
    /// Its outline, closed if it is.
    points: Vec<Point>,
    colour: Colour,
    look: Look,
    label: Option<Label>,
}

#[derive(Clone, Copy)]
enum Look {
    Line(f64),
    Dashes,
    Area,
    /// An open dot that has the same size at every scale.
    Dot,
    /// Hatched on the right of its direction.
    Hatched,
    /// A line of this width with one head or two.
    Arrow(f64, usize),
    Nothing,
}

/// Words beside a point of the data: so many points to the right and up from it, with this side of them.
#[derive(Clone)]
struct Label {
    words: String,
    at: Point,
    away: Point,
    side: HPos,
}

impl Shape {
    fn new(kind: &'static str, points: Vec<Point>, colour: Colour, look: Look) -> Self {
        Shape { kind, points, colour, look, label: None }
    }

    /// A line through the points, such as a link.
    pub fn line(points: Vec<Point>, colour: Colour, width: f64) -> Self {
        Self::new("polyline", points, colour, Look::Line(width))
    }

    /// The thin dashed line that a point has traced.
    pub fn trail(points: Vec<Point>, colour: Colour) -> Self {
        Self::new("trail", points, colour, Look::Dashes)
    }

    /// An upright rectangle, such as a cart, filled or outlined.
    pub fn rectangle((x, y): Point, (width, height): (f64, f64), colour: Colour, filled: bool) -> Self {
        let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5)];
        let points = corners.map(|(right, up)| (x + right * width, y + up * height)).to_vec();
        Self::new("rectangle", points, colour, if filled { Look::Area } else { Look::Line(1.25) })
    }

    pub fn disc(centre: Point, radius: f64, colour: Colour) -> Self {
        Self::new("circle", arc(centre, radius, TAU), colour, Look::Area)
    }

    pub fn hinge(at: Point, colour: Colour) -> Self {
        Self::new("hinge", vec![at], colour, Look::Dot)
    }

    /// A line hatched on its right-hand side.
    pub fn ground(from: Point, to: Point) -> Self {
        Self::new("ground", vec![from, to], BLACK, Look::Hatched)
    }

    /// An arrow, such as a force, with its label above the middle, or to the right if it is upright.
    pub fn arrow(from: Point, to: Point, colour: Colour, words: &str) -> Self {
        let upright = (to.0 - from.0).abs() < (to.1 - from.1).abs();
        let (away, side) = if upright { ((10.0, 0.0), HPos::Left) } else { ((0.0, 9.5), HPos::Center) };
        let at = (0.5 * (from.0 + to.0), 0.5 * (from.1 + to.1));
        let label = Some(Label { words: words.to_owned(), at, away, side });
        Shape { label, ..Self::new("arrow", vec![from, to], colour, Look::Arrow(1.5, 1)) }
    }

    /// A thin line with an arrow at both ends.
    pub fn dimension(from: Point, to: Point) -> Self {
        Self::new("dimension", vec![from, to], BLACK, Look::Arrow(0.75, 2))
    }

    pub fn text(at: Point, words: &str) -> Self {
        let label = Some(Label { words: words.to_owned(), at, away: (0.0, 0.0), side: HPos::Center });
        Shape { label, ..Self::new("text", vec![at], BLACK, Look::Nothing) }
    }

    /// The arc from the x axis to an angle, with its label outside the middle.
    pub fn angle(centre: Point, radius: f64, angle: f64, words: &str) -> Self {
        let (sin, cos) = (0.5 * angle).sin_cos();
        let at = (centre.0 + radius * cos, centre.1 + radius * sin);
        let label = Some(Label { words: words.to_owned(), at, away: (9.0 * cos, 9.0 * sin), side: HPos::Left });
        Shape { label, ..Self::new("arc", arc(centre, radius, angle), BLACK, Look::Line(0.75)) }
    }

    /// Draws the shape; `place` says where on the page a point of the data is.
    fn draw(&self, page: &Area, place: impl Fn(&Point) -> Pixel) -> Result<(), Error> {
        let outline: Vec<Pixel> = self.points.iter().map(&place).collect();
        let pen = |width: f64| pen(self.colour, width);
        match self.look {
            Look::Line(width) => page.draw(&PathElement::new(outline, pen(width)))?,
            Look::Dashes => page.draw(&DashedPathElement::new(outline, units(4.0), units(3.0), pen(0.75)))?,
            Look::Area => page.draw(&Polygon::new(outline, self.colour.filled()))?,
            Look::Dot => {
                page.draw(&Circle::new(outline[0], units(2.4), WHITE.filled()))?;
                page.draw(&Circle::new(outline[0], units(2.4), pen(1.25)))?;
            }
            Look::Hatched => hatched(page, outline[0], outline[1])?,
            Look::Arrow(width, heads) => {
                let (from, to) = (outline[0], outline[1]);
                page.draw(&PathElement::new(outline, pen(width)))?;
                for (tail, tip) in [(from, to), (to, from)].into_iter().take(heads) {
                    page.draw(&Polygon::new(head(tail, tip), self.colour.filled()))?;
                }
            }
            Look::Nothing => {}
        }
        let Some(Label { words, at, away, side }) = &self.label else { return Ok(()) };
        let (x, y) = place(at);
        let style = font(SMALL + 1.0, FontStyle::Normal).color(&self.colour);
        let style = style.into_text_style(page).pos(Pos::new(*side, VPos::Center));
        Ok(page.draw(&Text::new(words.as_str(), (x + units(away.0), y - units(away.1)), style))?)
    }
}

/// An arc of a circle that begins on the x axis.
fn arc((x, y): Point, radius: f64, to: f64) -> Vec<Point> {
    let angle = |piece: i32| to * f64::from(piece) / 48.0;
    (0..=48).map(|piece| (x + radius * angle(piece).cos(), y + radius * angle(piece).sin())).collect()
}

/// The line of the ground with its hatching.
fn hatched(page: &Area, from: Pixel, to: Pixel) -> Result<(), Error> {
    let (ahead, right, length) = directions(from, to);
    let spacing = f64::from(units(7.0));
    for stroke in 1..=(length / spacing) as i32 {
        let start = moved(from, ahead * (f64::from(stroke) * spacing));
        let end = moved(moved(start, ahead * -spacing), right * spacing);
        page.draw(&PathElement::new([start, end], pen(colour::GREY, 0.75)))?;
    }
    Ok(page.draw(&PathElement::new([from, to], pen(BLACK, 1.0)))?)
}

/// The head of an arrow.
fn head(tail: Pixel, tip: Pixel) -> Vec<Pixel> {
    let ((ahead, right, _), length) = (directions(tail, tip), f64::from(units(7.0)));
    let back = moved(tip, ahead * -length);
    vec![tip, moved(back, right * (0.4 * length)), moved(back, right * (-0.4 * length))]
}

/// The unit vectors along the segment and to its right on the page, and its length.
fn directions(from: Pixel, to: Pixel) -> (Vector2<f64>, Vector2<f64>, f64) {
    let along = Vector2::new(to.0 - from.0, to.1 - from.1).cast::<f64>();
    let length = along.x.hypot(along.y).max(1e-9);
    let ahead = along / length;
    (ahead, Vector2::new(-ahead.y, ahead.x), length)
}

fn moved((x, y): Pixel, by: Vector2<f64>) -> Pixel {
    (x + by.x.round() as i32, y + by.y.round() as i32)
}

/// One picture.
#[derive(Clone, Default)]
pub struct Scene {
    /// Over the picture, such as its time.
    pub title: String,
    /// What is drawn, later over earlier.
    pub shapes: Vec<Shape>,
}

/// Pictures of a mechanism in a grid, all of the same stretch of the plane.
#[derive(Clone)]
pub struct SceneChart {
    /// Of the axes; without any the pictures have no frame.
    pub labels: Option<[&'static str; 2]>,
    /// What the colours mean, in a row above the pictures.
    pub key: Vec<(&'static str, Colour)>,
    pub scenes: Vec<Scene>,
    pub columns: usize,
    /// The least and the greatest corner shown, found from the shapes if not given.
    pub range: Option<(Point, Point)>,
    /// Width in points; the height follows from the pictures.
    pub width: f64,
}

impl Default for SceneChart {
    fn default() -> Self {
        Self { labels: None, key: Vec::new(), scenes: Vec::new(), columns: 1, range: None, width: 700.0 }
    }
}

/// Room in points for the labels of the axes, and for a title.
const LABELS: (f64, f64) = (42.0, 40.0);
const TITLE: f64 = 26.0;
/// Height of the key.
const KEY: f64 = 26.0;
/// Room on the left of the labels and on the right.
const MARGIN: f64 = 8.0;

impl SceneChart {
    /// Writes `<stem>.svg`, `<stem>.png` and `<stem>.csv`.
    pub fn save(&self, stem: &Path) -> Result<(), Error> {
        let rows = self.scenes.len().div_ceil(self.columns).max(1);
        let ((left, low), (right, high)) = self.range.unwrap_or_else(|| self.stretch());
        let beside = if self.labels.is_some() { LABELS.0 + 2.0 * MARGIN } else { 0.0 };
        let picture = self.width / self.columns as f64 - beside;
        let around = TITLE + if self.labels.is_some() { LABELS.1 } else { 0.0 };
        let key = if self.key.is_empty() { 0.0 } else { KEY };
        let height = key + rows as f64 * (picture * (high - low) / (right - left) + around);
        page::save(stem, (self.width, height), &self.csv(), |page| {
            let (top, pictures) = page.split_vertically(units(key));
            self.draw_key(&top)?;
            let (x, y) = (Ruler::linear(left, right), Ruler::linear(low, high));
            let cells = pictures.split_evenly((rows, self.columns));
            self.scenes.iter().zip(&cells).try_for_each(|(scene, cell)| self.draw(scene, page, cell, [x, y]))
        })
    }

    fn draw(&self, scene: &Scene, page: &Area, cell: &Area, [x, y]: [Ruler; 2]) -> Result<(), Error> {
        let mut builder = ChartBuilder::on(cell);
        let title = font(LARGE, FontStyle::Bold).into_text_style(cell).pos(Pos::new(HPos::Center, VPos::Center));
        let (middle, _) = cell.dim_in_pixel();
        cell.draw(&Text::new(scene.title.as_str(), (middle as i32 / 2, units(0.6 * TITLE)), title))?;
        builder.margin_top(units(TITLE));
        if self.labels.is_some() {
            builder.margin_left(units(MARGIN)).margin_right(units(MARGIN));
            builder.x_label_area_size(units(LABELS.1)).y_label_area_size(units(LABELS.0));
        }
        let mut chart = builder.build_cartesian_2d(x, y)?;
        scene.shapes.iter().try_for_each(|shape| shape.draw(page, |point| chart.backend_coord(point)))?;
        let Some([x_label, y_label]) = self.labels else { return Ok(()) };
        Ok(chart
            .configure_mesh()
            .disable_mesh()
            .axis_style(pen(BLACK, 0.75))
            .set_all_tick_mark_size(units(4.0))
            .label_style(font(SMALL, FontStyle::Normal))
            .axis_desc_style(font(SMALL + 1.0, FontStyle::Normal))
            .x_desc(x_label)
            .y_desc(y_label)
            .draw()?)
    }

    /// Draws a sample and a name for each colour.
    fn draw_key(&self, area: &Area) -> Result<(), Error> {
        let (mut left, middle, sample) = (units(LABELS.0), units(0.5 * KEY), units(22.0));
        let style = font(SMALL, FontStyle::Normal).into_text_style(area).pos(Pos::new(HPos::Left, VPos::Center));
        for (name, colour) in &self.key {
            let line = [(left, middle), (left + sample, middle)];
            area.draw(&PathElement::new(line, pen(*colour, 3.0)))?;
            area.draw(&Text::new(*name, (left + sample + units(5.0), middle), style.clone()))?;
            left += sample + units(25.0) + area.estimate_text_size(name, &style)?.0 as i32;
        }
        Ok(())
    }

    /// The corners of all shapes, with some room around them.
    fn stretch(&self) -> (Point, Point) {
        let points = || self.scenes.iter().flat_map(|scene| &scene.shapes).flat_map(|shape| &shape.points);
        let extent = |of: fn(&Point) -> f64| {
            let (low, high) = range(points().map(of).filter(|value| value.is_finite()));
            if low > high { (0.0, 1.0) } else { (low, high) }
        };
        let ((left, right), (low, high)) = (extent(|point| point.0), extent(|point| point.1));
        let room = match (right - left).max(high - low) {
            0.0 => 1.0,
            size => 0.06 * size,
        };
        ((left - room, low - room), (right + room, high + room))
    }

    /// The outlines of all shapes.
    fn csv(&self) -> String {
        let [x, y] = self.labels.unwrap_or(["x [link lengths]", "y [link lengths]"]);
        let mut out = csv::line(["panel", "shape", "kind", x, y].map(str::to_owned));
        for (panel, scene) in self.scenes.iter().enumerate() {
            let panel = if scene.title.is_empty() { (panel + 1).to_string() } else { scene.title.clone() };
            for (id, shape) in scene.shapes.iter().enumerate() {
                for (x, y) in &shape.points {
                    let place = [panel.clone(), (id + 1).to_string(), shape.kind.to_owned()];
                    out += &csv::line(place.into_iter().chain([csv::number(*x), csv::number(*y)]));
                }
            }
        }
        out
    }
}
