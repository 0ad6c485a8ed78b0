//! [`TextFunction`]: a vector function as text.

use super::fields::wrong;
use super::formula::{Formula, FormulaError};
use crate::check::Function;
use crate::system::{GraphFormula, Shape, Slot, Values};
use crate::text::Name;
use crate::{Error, Scalar};

/// A vector function as text, with the grammar of formulas in scene files and the arguments `x[0]`, `x[1]`, …, for
/// [`check::function`](crate::check::function).
///
/// ```
/// use hamiltonian_adjoint::{TextFunction, check};
///
/// let polar = TextFunction::read(&["cos(x[1])", "sin(x[1])"], &["x[0] * $1", "x[0] * $2"], 2)?;
/// let hand = |x: &[f64]| [[x[1].cos(), -x[0] * x[1].sin()], [x[1].sin(), x[0] * x[1].cos()]];
/// check::function(&polar, ["r", "φ"], ["x", "y"]).jacobian(hand).run().assert_passed();
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub struct TextFunction(GraphFormula);

impl TextFunction {
    /// Reads a function of `arguments` numbers: parts that precede its results, and the results.
    ///
    /// # Errors
    /// A mistake in a text, with its column.
    pub fn read(parts: &[&str], results: &[&str], arguments: usize) -> Result<Self, Error> {
        let formula = Formula { parts: parts.to_vec(), results: results.to_vec(), arguments: None };
        let slot = |name: Name| match name {
            Name::Entry { list: "x", key } => key.parse().ok().filter(|i| *i < arguments).map(Slot::Q),
            _ => None,
        };
        let slot =
            |name: Name| slot(name).ok_or_else(|| format!("arguments are x[0] to x[{}]", arguments.saturating_sub(1)));
        let graph = formula.graph(Shape { n: arguments, ..Shape::default() }, &[], &slot);
        graph.map(TextFunction).map_err(|FormulaError(problem)| wrong("the function", &problem))
    }
}

impl Function for TextFunction {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let mut results = Vec::new();
        let read = |slot: Slot| if let Slot::Q(i) = slot { x[i] } else { S::zero() };
        self.0.values(&read, &mut |y| results.push(y));
        results
    }
}
