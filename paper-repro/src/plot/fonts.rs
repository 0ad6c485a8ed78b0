//! DejaVu Sans, compiled in, as the sans-serif family of the bitmaps and the measure of all text.

use crate::error::Error;
use plotters::style::{FontDesc, FontFamily, FontStyle, register_font};
use std::sync::OnceLock;

/// Makes the fonts known to the drawing library, once.
pub(super) fn register() -> Result<(), Error> {
    static DONE: OnceLock<bool> = OnceLock::new();
    let known = DONE.get_or_init(|| {
        let add = |bold| register_font("sans-serif", style(bold), bytes(bold)).is_ok();
        add(false) && add(true)
    });
    known.then_some(()).ok_or_else(|| Error::drawing("the font is not readable"))
}

/// The width of the text, in the unit of the em.
pub(super) fn width(text: &str, em: f64, bold: bool) -> f64 {
    const FINE: f64 = 200.0;
    let font = FontDesc::new(FontFamily::SansSerif, FINE * LINE, style(bold));
    let measured = register().ok().and_then(|()| font.box_size(text).ok());
    match measured {
        Some((width, _)) => f64::from(width) / FINE * em,
        None => 0.62 * em * text.chars().count() as f64,
    }
}

/// The letters of the text, each with the place of its left edge in the unit of the em.
pub(super) fn letters(text: &str, em: f64, bold: bool) -> impl Iterator<Item = (&str, f64)> {
    text.char_indices().map(move |(start, letter)| {
        let end = start + letter.len_utf8();
        let pen = width(&text[..end], em, bold) - width(&text[start..end], em, bold);
        (&text[start..end], pen + em * Face(bytes(bold)).bearing(letter).unwrap_or(0.0))
    })
}

/// The upright or bold cut.
pub(super) fn style(bold: bool) -> FontStyle {
    if bold { FontStyle::Bold } else { FontStyle::Normal }
}

/// The line height of DejaVu Sans in ems, by which the bitmap backend sizes a font.
pub(super) const LINE: f64 = 1.164;

/// The font file of the upright or bold cut.
fn bytes(bold: bool) -> &'static [u8] {
    if bold { dejavu::sans::bold() } else { dejavu::sans::regular() }
}

/// A TrueType file, read for the left side bearings that plotters' bitmap text leaves out.
struct Face(&'static [u8]);

impl Face {
    /// From the pen to the left edge of the letter, in ems.
    fn bearing(&self, letter: char) -> Option<f64> {
        let glyph = self.glyph(letter)?;
        let full = self.short(self.table(b"hhea")? + 34)?;
        let place = if glyph < full { 4 * glyph + 2 } else { 4 * full + 2 * (glyph - full) };
        let units = self.short(self.table(b"hmtx")? + place)? as u16 as i16;
        let em = self.short(self.table(b"head")? + 18)?;
        Some(f64::from(units) / em as f64)
    }

    /// The glyph of the letter by the segmented coverage of all Unicode (format 12).
    fn glyph(&self, letter: char) -> Option<usize> {
        let map = self.table(b"cmap")?;
        let subtables = (0..self.short(map + 2)?).filter_map(|index| Some(map + self.long(map + 8 + 8 * index)?));
        let coverage = subtables.into_iter().find(|at| self.short(*at) == Some(12))?;
        let code = letter as usize;
        (0..self.long(coverage + 12)?).map(|group| coverage + 16 + 12 * group).find_map(|group| {
            let (first, last) = (self.long(group)?, self.long(group + 4)?);
            (first..=last).contains(&code).then(|| Some(self.long(group + 8)? + code - first))?
        })
    }

    /// Where the table of the name starts.
    fn table(&self, name: &[u8; 4]) -> Option<usize> {
        let mut records = (0..self.short(4)?).map(|index| 12 + 16 * index);
        records.find(|at| self.0.get(*at..at + 4) == Some(name)).and_then(|at| self.long(at + 8))
    }

    /// The two bytes there as a number.
    fn short(&self, at: usize) -> Option<usize> {
        Some(usize::from(u16::from_be_bytes(*self.0.get(at..)?.first_chunk()?)))
    }

    /// The four bytes there as a number.
    fn long(&self, at: usize) -> Option<usize> {
        Some(u32::from_be_bytes(*self.0.get(at..)?.first_chunk()?) as usize)
    }
}
