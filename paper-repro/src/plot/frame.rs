//! The rectangle that data are drawn in: its place on the page, its ticks, its labels, and what lies within it.

use super::{
    Colour, Point,
    axis::{Ruler, Tick},
    canvas::{Anchor, Canvas, Text},
    fonts,
};

/// The em of tick labels and legends.
pub(super) const SMALL: f64 = 10.0;
/// The em of axis labels.
pub(super) const MEDIUM: f64 = 11.0;
/// The em of the title.
pub(super) const LARGE: f64 = 12.0;
/// Length of a tick.
const TICK: f64 = 4.0;
/// From the frame to the tick labels.
const GAP: f64 = 7.0;

/// A rectangle of the page, in points, y down.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Rect {
    /// Left side.
    pub(super) left: f64,
    /// Top side.
    pub(super) top: f64,
    /// Right side.
    pub(super) right: f64,
    /// Bottom side.
    pub(super) bottom: f64,
}

impl Rect {
    /// From left to right.
    pub(super) fn width(&self) -> f64 {
        self.right - self.left
    }

    /// From top to bottom.
    pub(super) fn height(&self) -> f64 {
        self.bottom - self.top
    }

    /// What is left inside of the margins.
    pub(super) fn inside(&self, margins: Margins) -> Self {
        Self {
            left: self.left + margins.left,
            top: self.top + margins.top,
            right: self.right - margins.right,
            bottom: self.bottom - margins.bottom,
        }
    }

    /// Whether the point is in it or on its border.
    pub(super) fn holds(&self, (x, y): Point) -> bool {
        (self.left..=self.right).contains(&x) && (self.top..=self.bottom).contains(&y)
    }

    /// The four corners.
    pub(super) fn corners(&self) -> Vec<Point> {
        vec![(self.left, self.top), (self.right, self.top), (self.right, self.bottom), (self.left, self.bottom)]
    }

    /// The cell of a grid with the columns and rows and a gap between cells, counted row by row.
    pub(super) fn cell(&self, index: usize, columns: usize, rows: usize, gap: f64) -> Self {
        let width = (self.width() + gap) / columns as f64;
        let height = (self.height() + gap) / rows as f64;
        let left = self.left + (index % columns) as f64 * width;
        let top = self.top + (index / columns) as f64 * height;
        Self { left, top, right: left + width - gap, bottom: top + height - gap }
    }

    /// The part of the segment within, if any (Liang and Barsky).
    pub(super) fn clip(&self, from: Point, to: Point) -> Option<(Point, Point)> {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let sides =
            [(-dx, from.0 - self.left), (dx, self.right - from.0), (-dy, from.1 - self.top), (dy, self.bottom - from.1)];
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for (speed, room) in sides {
            if speed < 0.0 {
                enter = enter.max(room / speed);
            } else if speed > 0.0 {
                leave = leave.min(room / speed);
            } else if room < 0.0 {
                return None;
            }
        }
        let at = |share: f64| (from.0 + share * dx, from.1 + share * dy);
        let start = if enter > 0.0 { at(enter) } else { from };
        let end = if leave < 1.0 { at(leave) } else { to };
        (enter <= leave).then_some((start, end))
    }

    /// The pieces of the line within, without points too near the last to be told apart.
    pub(super) fn clip_line(&self, line: &[Point]) -> Vec<Vec<Point>> {
        const NEAR: f64 = 0.2;
        let mut pieces: Vec<Vec<Point>> = Vec::new();
        let mut inside = false;
        for pair in line.windows(2) {
            let Some((from, to)) = self.clip(pair[0], pair[1]) else {
                inside = false;
                continue;
            };
            match pieces.last_mut() {
                Some(piece) if inside => {
                    let last = piece.last().copied().unwrap_or(from);
                    if (to.0 - last.0).hypot(to.1 - last.1) >= NEAR {
                        piece.push(to);
                    }
                }
                _ => pieces.push(vec![from, to]),
            }
            inside = to == pair[1];
        }
        pieces
    }
}

/// Room left around a frame for its labels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Margins {
    /// On the left.
    pub(super) left: f64,
    /// Above.
    pub(super) top: f64,
    /// On the right.
    pub(super) right: f64,
    /// Below.
    pub(super) bottom: f64,
}

impl Margins {
    /// The greater of the two on each side.
    pub(super) fn or(self, other: Self) -> Self {
        Self {
            left: self.left.max(other.left),
            top: self.top.max(other.top),
            right: self.right.max(other.right),
            bottom: self.bottom.max(other.bottom),
        }
    }
}

/// Room beside the frame for the tick labels and the label of a vertical axis.
pub(super) fn beside(ticks: &[Tick], label: &str) -> f64 {
    let widest = ticks.iter().map(|tick| fonts::width(&tick.words, SMALL, false)).fold(0.0, f64::max);
    GAP + widest + if label.is_empty() { 4.0 } else { 2.2 * MEDIUM }
}

/// Room below the frame for the tick labels and the label of the horizontal axis.
pub(super) fn below(label: &str) -> f64 {
    GAP + 1.3 * SMALL + if label.is_empty() { 0.0 } else { 1.6 * MEDIUM }
}

/// Room above the frame for the title.
pub(super) fn above(title: &str) -> f64 {
    if title.is_empty() { 8.0 } else { 2.0 * LARGE }
}

/// How many ticks the length has room for.
pub(super) fn ticks_along(length: f64, spacing: f64) -> usize {
    (length / spacing).clamp(2.0, 10.0) as usize
}

/// A rectangle of the page with the rulers along it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// Where it is.
    pub(super) rect: Rect,
    /// Along the bottom.
    pub(super) x: Ruler,
    /// Along the left side, or the right side for a second axis.
    pub(super) y: Ruler,
}

impl Frame {
    /// The place on the page of the data point, perhaps outside the frame; none if it has no place on the axes.
    pub(super) fn at(&self, (x, y): Point) -> Option<Point> {
        let (along, up) = (self.x.place(x)?, self.y.place(y)?);
        let far = |share: f64| share.clamp(-1e3, 1e3);
        Some((self.rect.left + far(along) * self.rect.width(), self.rect.bottom - far(up) * self.rect.height()))
    }

    /// Draws the grid of the ticks.
    pub(super) fn grid(&self, canvas: &mut Canvas, x_ticks: &[Tick], y_ticks: &[Tick]) {
        let Rect { left, top, right, bottom } = self.rect;
        for x in x_ticks.iter().map(|tick| left + tick.place * self.rect.width()) {
            canvas.line(vec![(x, top), (x, bottom)], Colour::LIGHT, 0.5);
        }
        for y in y_ticks.iter().map(|tick| bottom - tick.place * self.rect.height()) {
            canvas.line(vec![(left, y), (right, y)], Colour::LIGHT, 0.5);
        }
    }

    /// Draws the outline.
    pub(super) fn outline(&self, canvas: &mut Canvas) {
        let mut outline = self.rect.corners();
        outline.extend([(self.rect.left, self.rect.top), (self.rect.right, self.rect.top)]);
        canvas.line(outline, Colour::BLACK, 0.75);
    }

    /// Writes the title so far above the frame.
    pub(super) fn title(&self, canvas: &mut Canvas, title: &str, rise: f64) {
        let at = (0.5 * (self.rect.left + self.rect.right), self.rect.top - rise);
        canvas.text(Text { text: title.to_owned(), at, size: LARGE, bold: true, ..Text::default() });
    }

    /// Draws the horizontal axis at the bottom.
    pub(super) fn x_axis(&self, canvas: &mut Canvas, ticks: &[Tick], label: &str) {
        let Rect { left, right, bottom, .. } = self.rect;
        for tick in ticks.iter().chain(&self.x.minor_ticks()) {
            let x = left + tick.place * self.rect.width();
            canvas.line(vec![(x, bottom), (x, bottom - tick_length(tick))], Colour::BLACK, 0.75);
            let at = (x, bottom + GAP + 0.5 * SMALL);
            canvas.text(Text { text: tick.words.clone(), at, size: SMALL, ..Text::default() });
        }
        let at = (0.5 * (left + right), bottom + GAP + 1.3 * SMALL + 0.8 * MEDIUM);
        canvas.text(Text { text: label.to_owned(), at, size: MEDIUM, ..Text::default() });
    }

    /// Draws the vertical axis on the left, or on the right, its words in the colour.
    pub(super) fn y_axis(&self, canvas: &mut Canvas, ticks: &[Tick], label: &str, colour: Colour, on_right: bool) {
        let Rect { left, top, right, bottom } = self.rect;
        let (side, outward, anchor) = if on_right { (right, 1.0, Anchor::Left) } else { (left, -1.0, Anchor::Right) };
        for tick in ticks.iter().chain(&self.y.minor_ticks()) {
            let y = bottom - tick.place * self.rect.height();
            canvas.line(vec![(side, y), (side - outward * tick_length(tick), y)], Colour::BLACK, 0.75);
            let at = (side + outward * GAP, y);
            canvas.text(Text { text: tick.words.clone(), at, anchor, size: SMALL, colour, ..Text::default() });
        }
        let at = (side + outward * (beside(ticks, label) - 0.8 * MEDIUM), 0.5 * (top + bottom));
        canvas.text(Text { text: label.to_owned(), at, size: MEDIUM, colour, upward: true, ..Text::default() });
    }
}

/// Minor ticks, which have no words, are half as long.
fn tick_length(tick: &Tick) -> f64 {
    if tick.words.is_empty() { 0.5 * TICK } else { TICK }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clip_keeps_what_is_within() {
        let unit = Rect { right: 1.0, bottom: 1.0, ..Rect::default() };
        assert_eq!(unit.clip((0.2, 0.3), (0.9, 0.8)), Some(((0.2, 0.3), (0.9, 0.8))));
        assert_eq!(unit.clip((-1.0, 0.5), (3.0, 0.5)), Some(((0.0, 0.5), (1.0, 0.5))));
        assert_eq!(unit.clip((-1.0, 2.0), (3.0, 2.0)), None);
    }
}
