//! An element of a compiled scene, independent of its type: its connections and the properties of its formula.

use std::sync::Arc;

use super::block::BlockEntry;
use super::connections::Connections;
use super::differentiated::Formula;
use super::kind::ElementKind;

/// An element of a compiled scene.
#[derive(Clone, Debug)]
pub struct Element {
    pub name: String,
    /// The batch of the element, and its index in the batch.
    pub place: (usize, usize),
    pub to: Connections,
    pub formula: Arc<Formula>,
    /// The numbers in the formula that may differ between elements of one formula.
    pub numbers: Vec<f64>,
}

impl Element {
    pub fn kind(&self) -> ElementKind {
        self.formula.kind
    }

    /// Whether another formula has the same flags and the same structural nonzeros.
    pub fn has_places_of(&self, other: &Element) -> bool {
        let flags = |formula: &Formula| {
            let Formula { constant, piecewise, sinusoidal, timed, ref kernels, .. } = *formula;
            (constant, piecewise, sinusoidal, timed, kernels.is_some())
        };
        let (own, other) = (&*self.formula, &*other.formula);
        flags(own) == flags(other) && own.varying == other.varying && own.fixed == other.fixed
    }

    /// Row and column of an entry in the scene's numbering; rows of constraints are numbered among the equations.
    pub fn row_and_col(&self, entry: &BlockEntry) -> [usize; 2] {
        let row = if entry.block.has_equations() { self.to.sigma[entry.row] } else { self.to.q[entry.row] };
        [row, self.to.q[entry.col]]
    }

    /// The unknowns (n velocities, then multipliers) of the row and the column of an entry.
    pub fn unknowns(&self, entry: &BlockEntry, n: usize) -> [usize; 2] {
        let [row, col] = self.row_and_col(entry);
        [if entry.block.has_equations() { n + row } else { row }, col]
    }

    /// The values of the constants, followed by the numbers in the formula.
    pub fn parameters(&self, design: &[f64]) -> Vec<f64> {
        self.to.parameters(design, &self.numbers)
    }

    /// [`parameters`](Self::parameters), followed by the factor of each constant (its ratio to the parameter it is bound to).
    pub fn with_factors(&self, design: &[f64]) -> Vec<f64> {
        self.to.with_factors(design, &self.numbers)
    }
}
