//! Block LU factorisation, node by node.

use super::factorization::{Breakdown, Factorization};
use super::kernel::RightSide;
use super::lu::{self, Cancelled};
use super::node::Node;
use super::node_kernel::State;
use super::symbolic::Symbolic;

/// The values of a matrix, overwritten by their factors.
#[derive(Debug, Clone)]
pub(crate) struct BlockLu {
    values: Vec<f64>,
    swaps: Vec<usize>,
    scale: Vec<f64>,
    worst: f64,
}

impl Factorization for BlockLu {
    fn new(symbolic: &Symbolic) -> Self {
        Self {
            values: vec![0.0; symbolic.values_len()],
            swaps: vec![0; symbolic.size()],
            scale: vec![0.0; symbolic.size()],
            worst: 1.0,
        }
    }

    fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    #[inline]
    fn factor(&mut self, symbolic: &Symbolic, magnitudes: &[f64], mut with: RightSide<'_>) -> Result<(), Breakdown> {
        self.scale.copy_from_slice(magnitudes);
        self.worst = 1.0;
        let mut state = State { values: &mut self.values, swaps: &mut self.swaps, scale: &mut self.scale };
        for (kernel, nodes) in symbolic.runs() {
            let eliminated = kernel.eliminate(nodes, &mut state, &mut with);
            self.worst = self.worst.max(eliminated.map_err(|cancelled| breakdown(symbolic, cancelled))?);
        }
        match with {
            RightSide::None => {}
            RightSide::Of(x) => self.backward(symbolic, x),
            RightSide::OfTransposed(x) => self.backward_transposed(symbolic, x),
        }
        Ok(())
    }

    fn solve(&self, symbolic: &Symbolic, x: &mut [f64]) {
        for (kernel, nodes) in symbolic.runs() {
            kernel.forward(nodes, &self.values, &self.swaps, x);
        }
        self.backward(symbolic, x);
    }

    fn solve_transposed(&self, symbolic: &Symbolic, x: &mut [f64]) {
        for (kernel, nodes) in symbolic.runs() {
            kernel.forward_transposed(nodes, &self.values, &self.swaps, x);
        }
        self.backward_transposed(symbolic, x);
    }

    fn worst_loss(&self) -> f64 {
        self.worst
    }

    fn magnitudes(&self) -> &[f64] {
        &self.scale
    }

    fn reciprocal_pivots<'a>(&'a self, symbolic: &'a Symbolic) -> impl Iterator<Item = f64> + 'a {
        let diagonal = |node: &'a Node| (0..node.size).map(|k| self.values[node.start + k * (node.size + 1)]);
        symbolic.runs().flat_map(|(_, nodes)| nodes).flat_map(diagonal)
    }
}

impl BlockLu {
    /// The number of negative eigenvalues if the values were symmetric: by Sylvester's law of inertia, the sum of those of D over all nodes.
    pub(super) fn negative_eigenvalues(&self, symbolic: &Symbolic) -> usize {
        let of_node = |node: &Node| {
            let factors = &self.values[node.start..][..node.size * node.size];
            lu::negative_eigenvalues(factors, &self.swaps[node.first..node.end()])
        };
        symbolic.runs().flat_map(|(_, nodes)| nodes).map(of_node).sum()
    }

    fn backward(&self, symbolic: &Symbolic, x: &mut [f64]) {
        for (kernel, nodes) in symbolic.runs().rev() {
            kernel.backward(nodes, &self.values, &self.swaps, x);
        }
    }

    fn backward_transposed(&self, symbolic: &Symbolic, x: &mut [f64]) {
        for (kernel, nodes) in symbolic.runs().rev() {
            kernel.backward_transposed(nodes, &self.values, &self.swaps, x);
        }
    }
}

fn breakdown(symbolic: &Symbolic, cancelled: Cancelled) -> Breakdown {
    Breakdown { unknown: symbolic.unknown(cancelled.column), pivot: cancelled.pivot, scale: cancelled.scale }
}
