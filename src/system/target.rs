//! [`Target`]: what a sum of an element's is differentiated by, in the numbering of the scene.

use super::assembly::{Input, input};
use super::cost::CostRows;
use super::element::Element;
use super::formula::ArgumentOf;

#[derive(Clone, Copy)]
pub(super) enum Target {
    Coordinate(usize),
    Velocity(usize),
    Multiplier(usize),
    Input(Input),
}

impl Target {
    /// With the factor by which an element's own argument is a multiple of it.
    pub(super) fn of(element: &Element, of: ArgumentOf) -> (Self, f64) {
        match of {
            ArgumentOf::Coordinate(i) => (Target::Coordinate(element.q[i]), 1.0),
            ArgumentOf::Velocity(i) => (Target::Velocity(element.q[i]), 1.0),
            ArgumentOf::Multiplier(j) => (Target::Multiplier(element.sigma[j]), 1.0),
            ArgumentOf::Input(of) => {
                let (input, factor) = input(element, of);
                (Target::Input(input), factor)
            }
        }
    }

    /// Adds a derivative to where it belongs.
    pub(super) fn add(self, rows: &mut CostRows, x: f64) {
        match self {
            Target::Coordinate(i) => rows.q[i] += x,
            Target::Velocity(i) => rows.v[i] += x,
            Target::Multiplier(j) => rows.sigma[j] += x,
            Target::Input(Input::Control(k)) => rows.u[k] += x,
            Target::Input(Input::Design(p)) => rows.design[p] += x,
            Target::Input(Input::Time) => rows.time += x,
        }
    }
}
