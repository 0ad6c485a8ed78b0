//! Which formula is no number, and for which of its arguments.

use super::view::NodeView;

use super::names::Names;
use super::parameters::Parameters;
use crate::Error;
use crate::error::quoted;

/// An argument of a formula, in the scene's numbering.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Argument {
    Coordinate(usize),
    Velocity(usize),
    Momentum(usize),
    Force(usize),
    Acceleration(usize),
    Reaction(usize),
    Multiplier(usize),
    Control(usize),
    ControlRate(usize),
    Design(usize),
    Time,
}

/// The element at fault, and the arguments by which its derivatives are no numbers.
pub struct Suspect<'a> {
    pub element: &'a str,
    pub arguments: Vec<Argument>,
}

/// More arguments than these are not listed.
const MOST: usize = 4;

impl<'a> Suspect<'a> {
    pub(super) fn new(element: &'a str, arguments: Vec<Argument>) -> Option<Self> {
        Some(Suspect { element, arguments })
    }

    /// The error that says so; a value that `at` does not have is left out.
    pub(super) fn explain(&self, (names, parameters): (&Names, &Parameters), at: &NodeView<f64>, node: usize) -> Error {
        let mut list: Vec<String> =
            self.arguments.iter().take(MOST).map(|argument| argument.describe((names, parameters), at)).collect();
        if self.arguments.len() > MOST {
            list.push("…".into());
        }
        Error::Model { element: quoted(self.element), arguments: list.join(", "), node, time: at.t }
    }
}

impl Argument {
    fn describe(self, (names, parameters): (&Names, &Parameters), at: &NodeView<f64>) -> String {
        let (what, list, i): (String, &[f64], usize) = match self {
            Argument::Coordinate(i) => (quoted(&names.coordinates[i]), at.q, i),
            Argument::Velocity(i) => (format!("the velocity of {}", quoted(&names.coordinates[i])), at.v, i),
            Argument::Momentum(i) => (format!("p* of {}", quoted(&names.coordinates[i])), at.p_star, i),
            Argument::Force(i) => (format!("dp*/dt of {}", quoted(&names.coordinates[i])), at.p_star_dot, i),
            Argument::Acceleration(i) => (format!("the acceleration of {}", quoted(&names.coordinates[i])), at.v_dot, i),
            Argument::Reaction(j) => (format!("λ of {}", names.equations[j]), at.lambda, j),
            Argument::Multiplier(j) => (format!("σ of {}", names.equations[j]), at.sigma, j),
            Argument::Control(k) => (quoted(&names.controls[k]), at.u, k),
            Argument::ControlRate(k) => (format!("du/dt of {}", quoted(&names.controls[k])), at.u_dot, k),
            Argument::Design(p) => (parameters.name(p, &names.designs), at.design, p),
            Argument::Time => ("t".into(), std::slice::from_ref(&at.t), 0),
        };
        list.get(i).map_or(what.clone(), |value| format!("{what} = {}", number(*value)))
    }
}

/// A number to six digits.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}
