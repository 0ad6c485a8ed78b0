//! A page in points that plotters draws as SVG; the PNG is that SVG, rendered with DejaVu Sans, which is compiled in.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use plotters::backend::SVGBackend;
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::Text;
use plotters::style::{Color as _, FontDesc, FontFamily, FontStyle, ShapeStyle, WHITE, register_font};
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use super::Colour;
use crate::error::Error;
use crate::files;

/// Units of the SVG to the point: plotters places marks on whole units.
const UNITS: f64 = 8.0;
/// Pixels of the PNG to the point.
const PIXELS: f32 = 2.0;
/// The em of labels, in points.
pub const SMALL: f64 = 10.0;
/// The em of titles, in points.
pub const LARGE: f64 = 12.0;

/// What is drawn on.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A length in points in the units of the page.
pub fn units(points: f64) -> i32 {
    (points * UNITS).round() as i32
}

/// A font with this em in points.
pub fn font(em: f64, style: FontStyle) -> FontDesc<'static> {
    // plotters writes a font into an SVG by this factor smaller.
    FontDesc::new(FontFamily::SansSerif, 1.24 * em * UNITS, style)
}

/// A line of this width in points.
pub fn pen(colour: Colour, width: f64) -> ShapeStyle {
    colour.stroke_width(units(width) as u32)
}

/// Height of a line of the caption, and room around it.
const CAPTION_LINE: f64 = 14.0;
const CAPTION_EDGE: f64 = 8.0;

/// Writes the three files of the stem; the picture is as large as these points, whatever is drawn on it, with its caption, if there is one, below.
pub fn save(
    stem: &Path,
    size: (f64, f64),
    caption: &str,
    csv: &str,
    draw: impl FnOnce(&Area) -> Result<(), Error>,
) -> Result<(), Error> {
    let (width, height) = (size.0.clamp(10.0, 5000.0).round(), size.1.clamp(10.0, 5000.0).round());
    let below = if caption.is_empty() { 0.0 } else { caption.lines().count() as f64 * CAPTION_LINE + 2.0 * CAPTION_EDGE };
    let svg = svg((width, height + below), |page| {
        let (picture, words) = page.split_vertically(units(height));
        draw(&picture)?;
        for (k, line) in caption.lines().enumerate() {
            let at = (units(CAPTION_EDGE), units(CAPTION_EDGE + k as f64 * CAPTION_LINE));
            words.draw(&Text::new(line, at, font(SMALL, FontStyle::Normal)))?;
        }
        Ok(())
    })?;
    // The stem may itself have a dot (`fig5.a`).
    files::write(&stem.with_added_extension("csv"), csv)?;
    files::write(&stem.with_added_extension("png"), png(&svg)?)?;
    files::write(&stem.with_added_extension("svg"), svg)
}

fn svg((width, height): (f64, f64), draw: impl FnOnce(&Area) -> Result<(), Error>) -> Result<String, Error> {
    // By these fonts plotters measures text.
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

fn png(svg: &str) -> Result<Vec<u8>, Error> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    let fonts = FONTS.get_or_init(|| {
        let mut fonts = fontdb::Database::new();
        [dejavu::sans::regular(), dejavu::sans::bold()].into_iter().for_each(|bytes| fonts.load_font_data(bytes.to_vec()));
        fonts.set_sans_serif_family("DejaVu Sans");
        Arc::new(fonts)
    });
    let options = Options { fontdb: fonts.clone(), ..Options::default() };
    let tree = Tree::from_str(svg, &options).map_err(Error::drawing)?;
    let pixels = |points: f32| (points * PIXELS) as u32;
    let (width, height) = (pixels(tree.size().width()), pixels(tree.size().height()));
    let mut pixmap = Pixmap::new(width, height).ok_or_else(|| Error::drawing("a page without size"))?;
    pixmap.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(PIXELS, PIXELS), &mut pixmap.as_mut());
    pixmap.encode_png().map_err(Error::drawing)
}

impl<E: std::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for Error {
    fn from(reason: DrawingAreaErrorKind<E>) -> Self {
        Error::drawing(reason)
    }
}
