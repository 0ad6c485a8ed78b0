//! The figures of the paper; each module draws its files and returns the rows that compare it with the paper.

pub mod fig1;
pub mod fig2;
pub mod fig3;
pub mod fig4;
pub mod fig5;
pub mod fig6;

use nalgebra::DVectorView;

use crate::plot::{Colour, Point, Series, Side, Style};

/// Width and height of the cart in link lengths; the paper states neither.
const CART: (f64, f64) = (0.5, 0.25);

/// A rounded cost for figures and the table; summary.json contains all digits.
fn rounded(cost: f64) -> String {
    if cost < 1e-3 { format!("{cost:.1e}") } else { format!("{cost:.3}") }
}

/// A series over the nodes with a note beside one of its points that explains the deviation of the first one.
fn with_kink(series: Series, beside: usize) -> Series {
    let at = series.points[beside];
    series.noted("u₀ acts over half a step", at, (9.0, 0.0), Side::Left)
}

/// The cart and the links at the coordinates (x, y, φ) of the bodies.
fn pose(q: DVectorView<f64>, length: f64, colour: Colour, width: f64) -> Vec<Series> {
    let mut shapes = vec![cart((q[0], q[1]), length, colour, Style::Line)];
    let links: Vec<[Point; 2]> = (3..q.len()).step_by(3).map(|at| link((q[at], q[at + 1], q[at + 2]), length)).collect();
    shapes.extend(links.iter().map(|ends| line(ends.to_vec(), colour, width)));
    shapes.extend(links.iter().map(|ends| hinge(ends[0], colour)));
    shapes
}

/// Both ends of a link with its centre at (x, y).
fn link((x, y, angle): (f64, f64, f64), length: f64) -> [Point; 2] {
    let (dx, dy) = (0.5 * length * angle.cos(), 0.5 * length * angle.sin());
    [(x - dx, y - dy), (x + dx, y + dy)]
}

fn line(points: Vec<Point>, colour: Colour, width: f64) -> Series {
    Series::shape("polyline", points, colour, Style::Line, width)
}

fn hinge(at: Point, colour: Colour) -> Series {
    Series::shape("hinge", vec![at], colour, Style::Circles, 1.25)
}

/// The path of a point, or an auxiliary line for dimensions.
fn trail(points: Vec<Point>, colour: Colour) -> Series {
    Series::shape("trail", points, colour, Style::Dashed, 0.75)
}

fn cart((x, y): Point, length: f64, colour: Colour, style: Style) -> Series {
    let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5)];
    let (width, height) = (CART.0 * length, CART.1 * length);
    let points = corners.map(|(right, up)| (x + right * width, y + up * height)).to_vec();
    Series::shape("rectangle", points, colour, style, 1.25)
}

/// An arc of a circle that begins on the x axis.
fn arc((x, y): Point, radius: f64, to: f64) -> Vec<Point> {
    let angle = |piece: i32| to * f64::from(piece) / 48.0;
    (0..=48).map(|piece| (x + radius * angle(piece).cos(), y + radius * angle(piece).sin())).collect()
}
