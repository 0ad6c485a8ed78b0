//! A page of marks in points, rendered to SVG and to PNG by the same function.

use super::{Colour, Point, fonts};
use crate::error::Error;
use plotters::{
    backend::{BitMapBackend, DrawingBackend, SVGBackend},
    coord::Shift,
    drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea},
    element::{Circle, DashedPathElement, PathElement, Polygon},
    style::{
        Color, FontDesc, FontFamily, FontTransform, IntoTextStyle, RGBColor, WHITE,
        text_anchor::{HPos, Pos, VPos},
    },
};

/// Device pixels to the point of the page: marks land on whole device pixels.
const FINENESS: f64 = 6.0;
/// Device pixels averaged into one pixel of the PNG, in each direction; it has two to the point.
const SMOOTHING: usize = 3;

/// The side of a text that its position names.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Anchor {
    /// The start.
    Left,
    /// The middle.
    #[default]
    Centre,
    /// The end.
    Right,
}

/// A line of text.
#[derive(Clone, Debug)]
pub(super) struct Text {
    /// The words.
    pub(super) text: String,
    /// Where the anchor is, at half the height of a capital.
    pub(super) at: Point,
    /// Which side of the text is there.
    pub(super) anchor: Anchor,
    /// The em in points.
    pub(super) size: f64,
    /// Its colour.
    pub(super) colour: Colour,
    /// Whether in bold.
    pub(super) bold: bool,
    /// Whether turned to read upwards.
    pub(super) upward: bool,
}

impl Default for Text {
    fn default() -> Self {
        Self {
            text: String::new(),
            at: (0.0, 0.0),
            anchor: Anchor::Centre,
            size: 11.0,
            colour: Colour::BLACK,
            bold: false,
            upward: false,
        }
    }
}

/// One thing drawn.
#[derive(Clone, Debug)]
enum Mark {
    Line { points: Vec<Point>, colour: Colour, width: f64, dashed: bool },
    Area { points: Vec<Point>, colour: Colour },
    Disc { centre: Point, radius: f64, colour: Colour },
    Text(Text),
}

/// A white page with marks, later over earlier; lengths in points, y down.
#[derive(Clone, Debug)]
pub(super) struct Canvas {
    width: f64,
    height: f64,
    marks: Vec<Mark>,
}

impl Canvas {
    /// An empty page of whole points.
    pub(super) fn new(width: f64, height: f64) -> Self {
        let whole = |length: f64| if length.is_finite() { length.round().clamp(1.0, 5000.0) } else { 1.0 };
        Self { width: whole(width), height: whole(height), marks: Vec::new() }
    }

    /// Draws a line through the points.
    pub(super) fn line(&mut self, points: Vec<Point>, colour: Colour, width: f64) {
        self.marks.push(Mark::Line { points, colour, width, dashed: false });
    }

    /// Draws a dashed line through the points.
    pub(super) fn dashes(&mut self, points: Vec<Point>, colour: Colour, width: f64) {
        self.marks.push(Mark::Line { points, colour, width, dashed: true });
    }

    /// Fills the polygon.
    pub(super) fn area(&mut self, points: Vec<Point>, colour: Colour) {
        self.marks.push(Mark::Area { points, colour });
    }

    /// Fills the disc.
    pub(super) fn disc(&mut self, centre: Point, radius: f64, colour: Colour) {
        self.marks.push(Mark::Disc { centre, radius, colour });
    }

    /// Writes the text.
    pub(super) fn text(&mut self, text: Text) {
        self.marks.push(Mark::Text(text));
    }

    /// The page as SVG, one user unit to the point.
    pub(super) fn svg(&self) -> Result<String, Error> {
        let (width, height) = self.device_size();
        let mut out = String::new();
        self.render(&SVGBackend::with_string(&mut out, (width, height)).into_drawing_area(), Hand::SVG)?;
        let fine = format!("width=\"{width}\" height=\"{height}\"");
        let points = format!("width=\"{}\" height=\"{}\"", self.width, self.height);
        Ok(out.replacen(&fine, &points, 1))
    }

    /// The page as PNG, two pixels to the point, smoothed from finer ones.
    pub(super) fn png(&self) -> Result<Vec<u8>, Error> {
        let (width, height) = self.device_size();
        let mut fine = vec![0; 3 * width as usize * height as usize];
        self.render(&BitMapBackend::with_buffer(&mut fine, (width, height)).into_drawing_area(), Hand::BITMAP)?;
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, width / SMOOTHING as u32, height / SMOOTHING as u32);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header().map_err(Error::drawing)?;
        writer.write_image_data(&averaged(&fine, width as usize)).map_err(Error::drawing)?;
        writer.finish().map_err(Error::drawing)?;
        Ok(out)
    }

    /// The size in device pixels, a multiple of the smoothing.
    fn device_size(&self) -> (u32, u32) {
        let pixels = |length: f64| (length * FINENESS) as u32;
        (pixels(self.width), pixels(self.height))
    }

    /// Draws all marks on the area of any backend.
    fn render<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, hand: Hand) -> Result<(), Error> {
        fonts::register()?;
        area.fill(&WHITE).map_err(Error::drawing)?;
        for mark in &self.marks {
            match mark {
                Mark::Line { points, colour, width, dashed } => hand.line(area, points, *colour, *width, *dashed),
                Mark::Area { points, colour } => {
                    let points: Vec<_> = points.iter().map(device).collect();
                    area.draw(&Polygon::new(points, RGBColor::from(*colour).filled()))
                }
                Mark::Disc { centre, radius, colour } => {
                    area.draw(&Circle::new(device(centre), radius * FINENESS, RGBColor::from(*colour).filled()))
                }
                Mark::Text(text) => hand.write(area, text),
            }
            .map_err(Error::drawing)?;
        }
        area.present().map_err(Error::drawing)
    }
}

/// How a backend must be led.
#[derive(Clone, Copy)]
struct Hand {
    /// The font size, per em, that makes an em of that length.
    size: f64,
    /// From the top anchor down to the base line, in ems.
    drop: f64,
    /// Whether the backend joins segments and spaces letters well, so that they need not be drawn one by one.
    able: bool,
}

/// What comes of drawing on the backend.
type Drawn<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

impl Hand {
    /// For SVG, whose reader joins and spaces.
    const SVG: Self = Self { size: 1.24, drop: 0.76, able: true };
    /// For bitmaps, where plotters leaves spikes at sharp joints and forgets the bearings of letters.
    const BITMAP: Self = Self { size: fonts::LINE, drop: 0.5 * fonts::LINE, able: false };

    /// Draws the line, with round joints if the backend has no good ones.
    fn line<B: DrawingBackend>(
        self,
        area: &DrawingArea<B, Shift>,
        points: &[Point],
        colour: Colour,
        width: f64,
        dashed: bool,
    ) -> Drawn<B> {
        let (colour, width) = (RGBColor::from(colour), width * FINENESS);
        let style = colour.stroke_width(width.round().max(1.0) as u32);
        let points: Vec<_> = points.iter().map(device).collect();
        if dashed {
            let unit = width.round().max(1.0) as i32;
            return area.draw(&DashedPathElement::new(points, 4 * unit, 3 * unit, style));
        }
        if self.able {
            return area.draw(&PathElement::new(points, style));
        }
        for pair in points.windows(2) {
            area.draw(&PathElement::new(pair, style))?;
        }
        for joint in points.iter().skip(1).rev().skip(1) {
            area.draw(&Circle::new(*joint, 0.5 * width - 0.5, colour.filled()))?;
        }
        Ok(())
    }

    /// Writes the text with the middle of its capitals level with its position.
    fn write<B: DrawingBackend>(self, area: &DrawingArea<B, Shift>, text: &Text) -> Drawn<B> {
        const HALF_CAPITAL: f64 = 0.365;
        let raise = (self.drop - HALF_CAPITAL) * text.size;
        let (turn, ahead) =
            if text.upward { (FontTransform::Rotate270, (0.0, -1.0)) } else { (FontTransform::None, (1.0, 0.0)) };
        let start = (text.at.0 + raise * ahead.1, text.at.1 - raise * ahead.0);
        let side = if self.able { text.anchor.side() } else { HPos::Left };
        let colour = RGBColor::from(text.colour);
        let style = FontDesc::new(FontFamily::SansSerif, text.size * FINENESS * self.size, fonts::style(text.bold))
            .transform(turn)
            .into_text_style(area)
            .color(&colour)
            .pos(Pos::new(side, VPos::Top));
        if self.able {
            return area.draw_text(&text.text, &style, device(&start));
        }
        let before = text.anchor.share() * fonts::width(&text.text, text.size, text.bold);
        for (letter, offset) in fonts::letters(&text.text, text.size, text.bold) {
            let along = offset - before;
            area.draw_text(letter, &style, device(&(start.0 + along * ahead.0, start.1 + along * ahead.1)))?;
        }
        Ok(())
    }
}

impl Anchor {
    /// The same for plotters.
    fn side(self) -> HPos {
        match self {
            Self::Left => HPos::Left,
            Self::Centre => HPos::Center,
            Self::Right => HPos::Right,
        }
    }

    /// The share of the width that lies before the anchor.
    fn share(self) -> f64 {
        match self {
            Self::Left => 0.0,
            Self::Centre => 0.5,
            Self::Right => 1.0,
        }
    }
}

/// A position on the page in device pixels.
fn device(&(x, y): &Point) -> (i32, i32) {
    ((x * FINENESS).round() as i32, (y * FINENESS).round() as i32)
}

/// The image with each square of pixels averaged into one.
fn averaged(fine: &[u8], width: usize) -> Vec<u8> {
    let rows: Vec<&[u8]> = fine.chunks_exact(3 * width).collect();
    let mut coarse = Vec::with_capacity(fine.len() / (SMOOTHING * SMOOTHING));
    for band in rows.chunks_exact(SMOOTHING) {
        for column in 0..width / SMOOTHING {
            for channel in 0..3 {
                let pixels = (0..SMOOTHING).map(|x| 3 * (column * SMOOTHING + x) + channel);
                let sum: usize = pixels.flat_map(|at| band.iter().map(move |row| usize::from(row[at]))).sum();
                coarse.push((sum / (SMOOTHING * SMOOTHING)) as u8);
            }
        }
    }
    coarse
}
