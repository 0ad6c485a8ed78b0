//! The numerical factorisation.

use super::constant::Constant;
use super::kernel::{RightSide, State};
use super::lu::Cancelled;
use super::node::Node;
use super::symbolic::Symbolic;

/// A pivot that vanishes: the matrix is singular, or nearly so, where `unknown` is eliminated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Breakdown {
    /// The unknown, in the caller's numbering.
    pub(crate) unknown: usize,
    /// The pivot found.
    pub(crate) pivot: f64,
    /// The magnitude it had to be compared with.
    pub(crate) scale: f64,
}

/// The values of one matrix and their factors.
///
/// All calls take the `Symbolic` that `new` was given.
#[derive(Debug, Clone)]
pub(crate) struct BlockLu {
    /// Constant parts, of which one is in use.
    constants: Vec<Constant>,
    current: usize,
    values: Vec<f64>,
    swaps: Vec<usize>,
    scale: Vec<f64>,
    worst: f64,
}

impl BlockLu {
    /// The zero matrix; nothing is allocated after this.
    pub(crate) fn new(symbolic: &Symbolic) -> Self {
        Self {
            constants: vec![Constant::new(symbolic)],
            current: 0,
            values: vec![0.0; symbolic.values_len()],
            swaps: vec![0; symbolic.size()],
            scale: vec![0.0; symbolic.size()],
            worst: 1.0,
        }
    }

    /// Makes constant part number `which` the one in use.
    pub(crate) fn select(&mut self, which: usize) {
        self.current = which.min(self.constants.len() - 1);
    }

    fn constant(&self) -> &Constant {
        &self.constants[self.current]
    }

    /// Sets constant part number `which` from triplets (row, column, value), duplicates summed, condenses, and selects it.
    ///
    /// A number not used before adds a part. Every triplet lies in the pattern, on condensed or other unknowns.
    ///
    /// # Errors
    /// A condensed unknown whose pivot is below 1e-13 of the magnitudes that were added up in it.
    pub(crate) fn set_constant(
        &mut self,
        symbolic: &Symbolic,
        which: usize,
        triplets: &[(usize, usize, f64)],
    ) -> Result<(), Breakdown> {
        if which >= self.constants.len() {
            self.constants.push(Constant::new(symbolic));
        }
        self.select(which);
        self.constants[self.current].set(symbolic, triplets)
    }

    /// Starts an assembly: the values become the constant part.
    pub(crate) fn reset(&mut self) {
        self.values.copy_from_slice(self.constants[self.current].image());
    }

    /// The values by slot, to add varying entries to between `reset` and `factor`.
    pub(crate) fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// Factors the assembled values in place.
    ///
    /// # Errors
    /// A pivot that is not finite or below 1e-13 of the magnitudes that were added up in it.
    pub(crate) fn factor(&mut self, symbolic: &Symbolic) -> Result<(), Breakdown> {
        self.factor_with(symbolic, RightSide::None)
    }

    /// y −= S x for the unknowns that are not condensed, S being what condensation makes of their constant part.
    pub(crate) fn subtract_constant_product(&self, x: &[f64], y: &mut [f64]) {
        self.constant().subtract_reduced_product(x, y);
    }

    /// The largest |S_ij x_j|, times the weight of row i (counted without the condensed unknowns).
    pub(crate) fn largest_constant_product(&self, x: &[f64], weight: impl Fn(usize) -> f64) -> f64 {
        self.constant().largest_reduced_product(x, weight)
    }

    /// Eliminates the condensed unknowns from a right-hand side.
    pub(crate) fn reduce(&self, x: &mut [f64]) {
        self.constant().forward(x);
    }

    /// Factors the assembled values and solves for the unknowns that are not condensed, from a reduced right-hand side.
    ///
    /// # Errors
    /// As `factor`; `x` is then lost.
    pub(crate) fn factor_and_solve_reduced(&mut self, symbolic: &Symbolic, x: &mut [f64]) -> Result<(), Breakdown> {
        self.factor_with(symbolic, RightSide::Of(x))?;
        self.backward_nodes(symbolic, x);
        Ok(())
    }

    /// Solves for the unknowns that are not condensed with the factors, from a reduced right-hand side.
    pub(crate) fn solve_reduced(&self, symbolic: &Symbolic, x: &mut [f64]) {
        for (kernel, nodes) in symbolic.runs() {
            kernel.forward(nodes, &self.values, &self.swaps, x);
        }
        self.backward_nodes(symbolic, x);
    }

    /// The condensed unknowns from their reduced right-hand sides and the others' values.
    pub(crate) fn expand(&self, x: &mut [f64]) {
        self.constant().backward(x);
    }

    /// Eliminates the nodes, in a right-hand side too.
    fn factor_with(&mut self, symbolic: &Symbolic, mut with: RightSide<'_>) -> Result<(), Breakdown> {
        self.scale.copy_from_slice(self.constants[self.current].scale());
        self.worst = self.constant().worst();
        let mut state = State { values: &mut self.values, swaps: &mut self.swaps, scale: &mut self.scale };
        for (kernel, nodes) in symbolic.runs() {
            let eliminated = kernel.eliminate(nodes, &mut state, &mut with);
            self.worst = self.worst.max(eliminated.map_err(|cancelled| breakdown(symbolic, cancelled))?);
        }
        Ok(())
    }

    /// Smallest ratio, in (0, 1], of a pivot to the magnitudes added up in it, over the last `factor` and the condensation.
    pub(crate) fn worst_pivot(&self) -> f64 {
        self.worst.recip()
    }

    /// The unknown whose pivot lost most, as far as the factors still tell.
    pub(crate) fn worst_unknown(&self, symbolic: &Symbolic) -> usize {
        let losses = self.reciprocal_pivots(symbolic).zip(&self.scale).map(|(reciprocal, scale)| scale * reciprocal.abs());
        let worst = losses.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(position, _)| position);
        symbolic.unknown(worst)
    }

    /// The reciprocal pivots by positions.
    pub(crate) fn reciprocal_pivots<'a>(&'a self, symbolic: &'a Symbolic) -> impl Iterator<Item = f64> + 'a {
        let diagonal = |node: &'a Node| (0..node.size).map(|k| self.values[node.start + k * (node.size + 1)]);
        self.constant().reciprocal_pivots().chain(symbolic.runs().flat_map(|(_, nodes)| nodes).flat_map(diagonal))
    }

    /// Solves K x = r with the factors, for r in `x` by positions.
    pub(crate) fn solve(&self, symbolic: &Symbolic, x: &mut [f64]) {
        self.reduce(x);
        self.solve_reduced(symbolic, x);
        self.expand(x);
    }

    fn backward_nodes(&self, symbolic: &Symbolic, x: &mut [f64]) {
        for (kernel, nodes) in symbolic.runs().rev() {
            kernel.backward(nodes, &self.values, &self.swaps, x);
        }
    }

    /// Factors the assembled values and solves Kᵀ x = r, for r in `x` by positions.
    ///
    /// # Errors
    /// As `factor`; `x` is then lost.
    pub(crate) fn factor_and_solve_transposed(&mut self, symbolic: &Symbolic, x: &mut [f64]) -> Result<(), Breakdown> {
        self.constant().forward_transposed(x);
        self.factor_with(symbolic, RightSide::OfTransposed(x))?;
        for (kernel, nodes) in symbolic.runs().rev() {
            kernel.backward_transposed(nodes, &self.values, &self.swaps, x);
        }
        self.constant().backward_transposed(x);
        Ok(())
    }
}

fn breakdown(symbolic: &Symbolic, cancelled: Cancelled) -> Breakdown {
    Breakdown { unknown: symbolic.unknown(cancelled.column), pivot: cancelled.pivot, scale: cancelled.scale }
}
