//! The names of the series, where they cover no data if there is such a place.

use super::{
    Colour, Point,
    canvas::{Anchor, Canvas, Text},
    fonts,
    frame::{Rect, SMALL},
};

/// Where the names of the series stand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Legend {
    /// In a corner free of data, else above the frame; nowhere for a single series.
    #[default]
    Auto,
    /// Nowhere.
    None,
    /// In a row above the frame.
    Above,
    /// In the upper left corner.
    UpperLeft,
    /// In the upper right corner.
    UpperRight,
    /// In the lower left corner.
    LowerLeft,
    /// In the lower right corner.
    LowerRight,
}

/// Draws a sample of a series from the one point to the other.
type Sample<'a> = dyn Fn(&mut Canvas, Point, Point) + 'a;

/// A name, and what draws the sample of its series between two points.
pub(super) struct Entry<'a> {
    /// The words.
    pub(super) name: &'a str,
    /// Draws the sample.
    pub(super) sample: Box<Sample<'a>>,
}

/// Height of a row of names.
const ROW: f64 = 1.5 * SMALL;
/// Length of a sample.
const SAMPLE: f64 = 22.0;
/// Room about the words.
const PAD: f64 = 5.0;

impl Legend {
    /// The corner or place where it goes, given what the data cover of the page.
    pub(super) fn settled(self, entries: &[Entry<'_>], rect: Rect, covered: impl Fn(Rect) -> bool) -> Self {
        let corners = [Self::UpperRight, Self::UpperLeft, Self::LowerRight, Self::LowerLeft];
        match self {
            Self::Auto if entries.len() < 2 => Self::None,
            Self::Auto => {
                let free = corners.into_iter().find(|corner| !covered(corner.region(entries, rect)));
                free.unwrap_or(Self::Above)
            }
            settled => settled,
        }
    }

    /// The room that the names take above a frame of the width.
    pub(super) fn height_above(self, entries: &[Entry<'_>], width: f64) -> f64 {
        if self == Self::Above { ROW * rows(entries, width).len() as f64 } else { 0.0 }
    }

    /// Draws the names in or above the frame.
    pub(super) fn draw(self, canvas: &mut Canvas, entries: &[Entry<'_>], rect: Rect) {
        match self {
            Self::Auto | Self::None => {}
            Self::Above => {
                let rows = rows(entries, rect.width());
                for (index, row) in rows.iter().enumerate() {
                    let width: f64 = row.iter().map(entry_width).sum();
                    let y = rect.top - ROW * (rows.len() - index) as f64 + 0.35 * ROW;
                    let mut x = 0.5 * (rect.left + rect.right - width);
                    for entry in *row {
                        entry.draw(canvas, (x + PAD, y));
                        x += entry_width(entry);
                    }
                }
            }
            corner if !entries.is_empty() => {
                let region = corner.region(entries, rect);
                let mut outline = region.corners();
                canvas.area(outline.clone(), Colour::WHITE);
                outline.extend([(region.left, region.top), (region.right, region.top)]);
                canvas.line(outline, Colour::LIGHT, 0.75);
                for (index, entry) in entries.iter().enumerate() {
                    entry.draw(canvas, (region.left + PAD, region.top + ROW * (index as f64 + 0.5) + 2.0));
                }
            }
            _ => {}
        }
    }

    /// The box of the names in the corner.
    fn region(self, entries: &[Entry<'_>], rect: Rect) -> Rect {
        const INSET: f64 = 7.0;
        let width = entries.iter().map(entry_width).fold(0.0, f64::max);
        let height = ROW * entries.len() as f64 + 4.0;
        let left = match self {
            Self::UpperLeft | Self::LowerLeft => rect.left + INSET,
            _ => rect.right - INSET - width,
        };
        let top = match self {
            Self::UpperLeft | Self::UpperRight => rect.top + INSET,
            _ => rect.bottom - INSET - height,
        };
        Rect { left, top, right: left + width, bottom: top + height }
    }
}

impl Entry<'_> {
    /// Draws the sample and the words, from the left at mid height.
    fn draw(&self, canvas: &mut Canvas, (x, y): Point) {
        (self.sample)(canvas, (x, y), (x + SAMPLE, y));
        let at = (x + SAMPLE + PAD, y);
        canvas.text(Text { text: self.name.to_owned(), at, anchor: Anchor::Left, size: SMALL, ..Text::default() });
    }
}

/// Width of the sample, the words and the room about them.
fn entry_width(entry: &Entry<'_>) -> f64 {
    SAMPLE + 3.0 * PAD + fonts::width(entry.name, SMALL, false)
}

/// The entries in rows no wider than the width, unless one alone is.
fn rows<'a, 'b>(entries: &'a [Entry<'b>], width: f64) -> Vec<&'a [Entry<'b>]> {
    let mut rows = Vec::new();
    let (mut start, mut filled) = (0, 0.0);
    for (index, entry) in entries.iter().enumerate() {
        let wide = entry_width(entry);
        if index > start && filled + wide > width {
            rows.push(&entries[start..index]);
            (start, filled) = (index, 0.0);
        }
        filled += wide;
    }
    rows.push(&entries[start..]);
    rows
}
