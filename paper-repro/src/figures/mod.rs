//! The figures of the paper; each draws its files and returns what it has to say beside the paper.

pub mod fig1;
pub mod fig2;
pub mod fig3;
pub mod fig4;
pub mod fig5;
pub mod fig6;

use nalgebra::DVectorView;

use crate::plot::{Colour, Point, Shape};

/// Width and height of the cart in link lengths; the paper gives neither.
const CART: (f64, f64) = (0.5, 0.25);

/// Why the first component of a gradient in nodal forces stands apart.
const KINK: &str = "u₀ acts over half a step";

/// The cart and the links at the coordinates (x, y, φ) of the bodies.
fn shapes(q: DVectorView<f64>, length: f64, colour: Colour, width: f64) -> Vec<Shape> {
    let size = (CART.0 * length, CART.1 * length);
    let mut shapes = vec![Shape::rectangle((q[0], q[1]), size, colour, false)];
    let links = (3..q.len()).step_by(3).map(|at| link((q[at], q[at + 1], q[at + 2]), length));
    let links: Vec<[Point; 2]> = links.collect();
    shapes.extend(links.iter().map(|ends| Shape::line(ends.to_vec(), colour, width)));
    shapes.extend(links.iter().map(|ends| Shape::hinge(ends[0], colour)));
    shapes
}

/// Both ends of a link with its centre at (x, y).
fn link((x, y, angle): (f64, f64, f64), length: f64) -> [Point; 2] {
    let (dx, dy) = (0.5 * length * angle.cos(), 0.5 * length * angle.sin());
    [(x - dx, y - dy), (x + dx, y + dy)]
}
