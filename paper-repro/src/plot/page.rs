//! A page in points that plotters draws as SVG, its text measured in DejaVu Sans, which is compiled in.

use std::path::Path;

use plotters::backend::SVGBackend;
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::Text;
use plotters::style::{Color as _, FontDesc, FontFamily, FontStyle, ShapeStyle, WHITE, register_font};

use super::{Caption, Colour};
use crate::error::Error;
use crate::files;

/// Units of the SVG per point; plotters places marks on whole units.
const UNITS: f64 = 8.0;
/// The em of labels, in points.
pub const SMALL: f64 = 10.0;
/// The em of titles, in points.
pub const LARGE: f64 = 12.0;

/// The drawing area.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A length in points in the units of the page.
pub fn units(points: f64) -> i32 {
    (points * UNITS).round() as i32
}

/// A length in units of the page in points.
pub fn points(units: u32) -> f64 {
    f64::from(units) / UNITS
}

/// A font with this em in points.
pub fn font(em: f64, style: FontStyle) -> FontDesc<'static> {
    // plotters reduces the size of a font in an SVG by this factor.
    FontDesc::new(FontFamily::SansSerif, 1.24 * em * UNITS, style)
}

/// A line of this width in points.
pub fn pen(colour: Colour, width: f64) -> ShapeStyle {
    colour.stroke_width(units(width) as u32)
}

/// Height of a line of the caption, and its margin.
const CAPTION_LINE: f64 = 14.0;
const CAPTION_EDGE: f64 = 8.0;

/// Writes the files of the stem. The picture has this size in points; a caption that is shown is placed below it.
pub fn save(
    stem: &Path,
    size: (f64, f64),
    caption: &Caption,
    csv: &str,
    draw: impl FnOnce(&Area) -> Result<(), Error>,
) -> Result<(), Error> {
    let (width, height) = (size.0.clamp(10.0, 5000.0).round(), size.1.clamp(10.0, 5000.0).round());
    let shown = if caption.shown { caption.text.as_str() } else { "" };
    let below = if shown.is_empty() { 0.0 } else { shown.lines().count() as f64 * CAPTION_LINE + 2.0 * CAPTION_EDGE };
    let svg = svg((width, height + below), |page| {
        let (picture, words) = page.split_vertically(units(height));
        draw(&picture)?;
        for (k, line) in shown.lines().enumerate() {
            let at = (units(CAPTION_EDGE), units(CAPTION_EDGE + k as f64 * CAPTION_LINE));
            words.draw(&Text::new(line, at, font(SMALL, FontStyle::Normal)))?;
        }
        Ok(())
    })?;
    // The stem may itself contain a dot (`fig5.a`).
    files::write(&stem.with_added_extension("csv"), csv)?;
    if !caption.text.is_empty() {
        files::write(&stem.with_added_extension("txt"), format!("{}\n", caption.text))?;
    }
    #[cfg(feature = "png")]
    files::write(&stem.with_added_extension("png"), super::png::render(&svg)?)?;
    files::write(&stem.with_added_extension("svg"), described(&svg, &caption.text))
}

/// The picture with its caption as title (the first line) and description.
fn described(svg: &str, caption: &str) -> String {
    let (Some(title), Some((head, body))) = (caption.lines().next(), svg.split_once(">\n")) else { return svg.to_owned() };
    let [title, caption] = [title, caption].map(|words| words.replace('&', "&amp;").replace('<', "&lt;"));
    format!("{head}>\n<title>{title}</title>\n<desc>{caption}</desc>\n{body}")
}

fn svg((width, height): (f64, f64), draw: impl FnOnce(&Area) -> Result<(), Error>) -> Result<String, Error> {
    // plotters measures text with these fonts.
    for (style, bytes) in [(FontStyle::Normal, dejavu::sans::regular()), (FontStyle::Bold, dejavu::sans::bold())] {
        register_font("sans-serif", style, bytes).map_err(|_| Error::drawing("the font is not readable"))?;
    }
    let (wide, high) = (units(width), units(height));
    let mut out = String::new();
    {
        let area = SVGBackend::with_string(&mut out, (wide as u32, high as u32)).into_drawing_area();
        area.fill(&WHITE)?;
        draw(&area)?;
        area.present()?;
    }
    let fine = format!("width=\"{wide}\" height=\"{high}\"");
    Ok(out.replacen(&fine, &format!("width=\"{width}\" height=\"{height}\""), 1))
}

impl<E: std::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for Error {
    fn from(reason: DrawingAreaErrorKind<E>) -> Self {
        Error::drawing(reason)
    }
}
