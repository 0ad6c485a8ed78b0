//! What a planar mechanism is drawn with.

use super::{
    Colour, Point,
    canvas::{Anchor, Canvas, Text},
    frame::{Frame, SMALL},
};

/// A thing in the plane of the mechanism; lengths are those of the data, widths and text sizes are in points.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A line through the points, such as a link.
    Polyline {
        /// The points.
        points: Vec<Point>,
        /// Its colour.
        colour: Colour,
        /// Its width in points.
        width: f64,
    },
    /// The thin dashed line that a point has traced.
    Trail {
        /// The points.
        points: Vec<Point>,
        /// Its colour.
        colour: Colour,
    },
    /// An upright rectangle, such as a cart.
    Rectangle {
        /// Its centre.
        centre: Point,
        /// Its width and height.
        size: (f64, f64),
        /// Its colour.
        colour: Colour,
        /// Whether filled or outlined.
        filled: bool,
    },
    /// A circle, such as a wheel.
    Circle {
        /// Its centre.
        centre: Point,
        /// Its radius in the data.
        radius: f64,
        /// Its colour.
        colour: Colour,
        /// Whether filled or outlined.
        filled: bool,
    },
    /// An open dot that stays the same size at every scale.
    Hinge {
        /// Where.
        at: Point,
        /// Its colour.
        colour: Colour,
    },
    /// A line hatched on the right-hand side of its direction, seen from its start.
    Ground {
        /// Its start.
        from: Point,
        /// Its end.
        to: Point,
    },
    /// An arrow, such as a force, with its label beside the middle.
    Arrow {
        /// The tail.
        from: Point,
        /// The tip.
        to: Point,
        /// Its colour.
        colour: Colour,
        /// Its label.
        label: String,
    },
    /// A thin line with an arrow at both ends and its length beside the middle.
    Dimension {
        /// One end.
        from: Point,
        /// The other end.
        to: Point,
        /// Its label.
        label: String,
    },
    /// Words, centred.
    Text {
        /// Where.
        at: Point,
        /// The words.
        text: String,
        /// The em in points.
        size: f64,
    },
    /// An arc of a circle, such as an angle, with its label outside the middle.
    Arc {
        /// The vertex.
        centre: Point,
        /// The radius in the data.
        radius: f64,
        /// The angle at its start, counterclockwise from the x axis in radians.
        from_angle: f64,
        /// The angle at its end.
        to_angle: f64,
        /// Its label.
        label: String,
    },
}

impl Shape {
    /// What it is called in the data.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Polyline { .. } => "polyline",
            Self::Trail { .. } => "trail",
            Self::Rectangle { .. } => "rectangle",
            Self::Circle { .. } => "circle",
            Self::Hinge { .. } => "hinge",
            Self::Ground { .. } => "ground",
            Self::Arrow { .. } => "arrow",
            Self::Dimension { .. } => "dimension",
            Self::Text { .. } => "text",
            Self::Arc { .. } => "arc",
        }
    }

    /// The points that make up its outline, closed if it is.
    pub(super) fn outline(&self) -> Vec<Point> {
        match self {
            Self::Polyline { points, .. } | Self::Trail { points, .. } => points.clone(),
            Self::Rectangle { centre: (x, y), size: (width, height), .. } => {
                let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5)];
                corners.map(|(right, up)| (x + right * width, y + up * height)).to_vec()
            }
            Self::Circle { centre, radius, .. } => arc(*centre, *radius, 0.0, std::f64::consts::TAU),
            Self::Arc { centre, radius, from_angle, to_angle, .. } => arc(*centre, *radius, *from_angle, *to_angle),
            Self::Arrow { from, to, .. } | Self::Ground { from, to } | Self::Dimension { from, to, .. } => {
                vec![*from, *to]
            }
            Self::Text { at, .. } | Self::Hinge { at, .. } => vec![*at],
        }
    }

    /// Draws the shape in the frame.
    pub(super) fn draw(&self, canvas: &mut Canvas, frame: &Frame) {
        let outline: Vec<Point> = self.outline().into_iter().filter_map(|point| frame.at(point)).collect();
        let (Some(&first), Some(&last)) = (outline.first(), outline.last()) else {
            return;
        };
        match self {
            Self::Polyline { colour, width, .. } => {
                for piece in frame.rect.clip_line(&outline) {
                    canvas.line(piece, *colour, *width);
                }
            }
            Self::Trail { colour, .. } => {
                for piece in frame.rect.clip_line(&outline) {
                    canvas.dashes(piece, *colour, 0.75);
                }
            }
            Self::Rectangle { colour, filled: true, .. } | Self::Circle { colour, filled: true, .. } => {
                canvas.area(outline, *colour);
            }
            Self::Rectangle { colour, .. } | Self::Circle { colour, .. } => canvas.line(outline, *colour, 1.25),
            Self::Hinge { colour, .. } => {
                canvas.disc(first, 3.0, *colour);
                canvas.disc(first, 1.75, Colour::WHITE);
            }
            Self::Ground { .. } => ground(canvas, first, last),
            Self::Arrow { colour, label, .. } => {
                canvas.line(vec![first, last], *colour, 1.5);
                head(canvas, first, last, *colour);
                label_beside(canvas, first, last, label, *colour);
            }
            Self::Dimension { label, .. } => {
                canvas.line(vec![first, last], Colour::BLACK, 0.75);
                head(canvas, first, last, Colour::BLACK);
                head(canvas, last, first, Colour::BLACK);
                label_beside(canvas, first, last, label, Colour::BLACK);
            }
            Self::Text { text, size, .. } => {
                canvas.text(Text { text: text.clone(), at: first, size: *size, ..Text::default() });
            }
            Self::Arc { centre, label, .. } => {
                if let (Some(vertex), Some(&middle)) = (frame.at(*centre), outline.get(outline.len() / 2)) {
                    let (ahead, _) = directions(vertex, middle);
                    let at = along(middle, ahead, 0.9 * SMALL);
                    let anchor = side(ahead.0);
                    canvas.text(Text { text: label.clone(), at, anchor, ..Text::default() });
                }
                canvas.line(outline, Colour::BLACK, 0.75);
            }
        }
    }
}

/// An arc as a polyline.
fn arc((x, y): Point, radius: f64, from: f64, to: f64) -> Vec<Point> {
    const PIECES: usize = 48;
    let angle = |piece: usize| from + (to - from) * piece as f64 / PIECES as f64;
    (0..=PIECES).map(|piece| (x + radius * angle(piece).cos(), y + radius * angle(piece).sin())).collect()
}

/// The line of the ground with its hatching.
fn ground(canvas: &mut Canvas, from: Point, to: Point) {
    const SPACING: f64 = 7.0;
    let (ahead, right) = directions(from, to);
    let length = (to.0 - from.0).hypot(to.1 - from.1);
    for stroke in 1..=(length / SPACING) as usize {
        let start = along(from, ahead, stroke as f64 * SPACING);
        let end = along(along(start, ahead, -SPACING), right, SPACING);
        canvas.line(vec![start, end], Colour::GREY, 0.75);
    }
    canvas.line(vec![from, to], Colour::BLACK, 1.0);
}

/// The head of an arrow at its tip.
fn head(canvas: &mut Canvas, from: Point, tip: Point, colour: Colour) {
    const LENGTH: f64 = 7.0;
    let (ahead, right) = directions(from, tip);
    let back = along(tip, ahead, -LENGTH);
    canvas.area(vec![tip, along(back, right, 0.4 * LENGTH), along(back, right, -0.4 * LENGTH)], colour);
}

/// The label above the middle of the segment, or to its right where it is steep.
fn label_beside(canvas: &mut Canvas, from: Point, to: Point, label: &str, colour: Colour) {
    let ((ahead, right), middle) = (directions(from, to), (0.5 * (from.0 + to.0), 0.5 * (from.1 + to.1)));
    let away = if ahead.0.abs() > ahead.1.abs() { -right.1.signum() } else { right.0.signum() };
    let at = along(middle, right, 0.95 * SMALL * away);
    let anchor = side(away * right.0);
    canvas.text(Text { text: label.to_owned(), at, anchor, colour, ..Text::default() });
}

/// The anchor of a text that lies to that horizontal direction of its position.
fn side(rightward: f64) -> Anchor {
    match rightward {
        x if x > 0.5 => Anchor::Left,
        x if x < -0.5 => Anchor::Right,
        _ => Anchor::Centre,
    }
}

/// The unit vectors along the segment and to its right on the page.
fn directions(from: Point, to: Point) -> (Point, Point) {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = dx.hypot(dy).max(1e-9);
    ((dx / length, dy / length), (-dy / length, dx / length))
}

/// The point moved by the distance in the direction.
fn along((x, y): Point, (dx, dy): Point, distance: f64) -> Point {
    (x + distance * dx, y + distance * dy)
}
