//! An element of a compiled scene, independent of its type: its connections and the properties of its formula.

use std::sync::Arc;

use super::block::{Block, BlockEntry};
use super::connections::Connections;
use super::differentiated::Formula;
use super::kind::ElementKind;
use super::shape::Place;
use super::vectors::Entry;
use super::view::NodeView;

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

    /// The second derivatives that are not zero, computed by the programs; `None` if the formula has no graph. Slow.
    pub fn second_derivatives(&self, parameters: &[f64], input: impl Fn(usize) -> f64) -> Option<Vec<(BlockEntry, f64)>> {
        let Formula { fixed, varying, kernels, .. } = &*self.formula;
        let kernels = kernels.as_ref()?;
        let fixed = fixed.iter().copied().zip(kernels.fixed.evaluate(parameters, &input));
        let (_, values) = kernels.at_state(parameters, &input);
        let varying = varying.iter().zip(values);
        let parts = varying.flat_map(|(entry, value)| entry.signed_parts().map(move |(sign, part)| (part, sign * value)));
        Some(fixed.chain(parts).collect())
    }

    /// The entries of one block in the numbering of [`row_and_col`](Self::row_and_col), as [`second_derivatives`](Self::second_derivatives).
    pub fn block(&self, block: Block, at: &NodeView<f64>) -> Option<Vec<Entry>> {
        let input = |which: usize| match self.formula.shape.place(which) {
            Place::Of(slot) => self.to.read(at, slot),
            _ => 0.0,
        };
        let all = self.second_derivatives(&self.parameters(at.design), input)?;
        let of_block = all.into_iter().filter(|(entry, _)| entry.block == block);
        let entries = of_block.flat_map(|(entry, value)| {
            let [row, col] = self.row_and_col(&entry);
            let mirrored = entry.mirrored.then_some(Entry { row: col, col: row, value });
            [Some(Entry { row, col, value }), mirrored].into_iter().flatten()
        });
        Some(entries.collect())
    }
}
