//! J and the outputs of a motion that is not stored: summed node by node, in the order in which a [`Solver`](crate::Solver) sums them.

use nalgebra::DVector;

use super::LongSolver;
use crate::accelerations::{CostSum, check_sums};
use crate::motion::{Motion, Refinement};
use crate::system::CostFactors;
use crate::{Error, System};

/// J and the outputs, or the error of a cost that has no value.
pub(super) struct Values {
    cost: Result<f64, Error>,
    outputs: Result<DVector<f64>, Error>,
}

/// The sums for J and for the outputs, up to the current node.
pub(super) struct Sums<'a>([(CostSum<'a>, Result<Vec<f64>, Error>); 2]);

impl<'a> Sums<'a> {
    pub(super) fn new(system: &System, refinement: &'a Refinement) -> Self {
        let count = system.outputs();
        let factors = [CostFactors::of_cost(count), CostFactors::of_outputs(count)];
        Sums(factors.map(|factors| (CostSum::new(refinement, factors), Ok(vec![0.0; 1 + count]))))
    }

    /// Adds the contribution of a node within the window.
    pub(super) fn add(&mut self, system: &System, motion: &Motion, node: usize) {
        let is_last = node + 1 == motion.nodes();
        for (costs, sums) in &mut self.0 {
            let Ok(so_far) = sums else { continue };
            if is_last || system.has_running_cost(&costs.factors) {
                let (inputs, place) = ((&motion.inputs, &motion.design[..]), (node, node - motion.first));
                let added = motion.trajectory.sum_costs_of_step(system, inputs, costs, place, so_far);
                added.unwrap_or_else(|error| *sums = Err(error));
            }
        }
    }

    /// J and the outputs, after all nodes have been added.
    pub(super) fn values(&self, system: &System) -> Values {
        let checked = |sums: Vec<f64>| check_sums(system, &sums).map(|()| sums);
        let [cost, outputs] = self.0.each_ref().map(|(_, sums)| sums.clone().and_then(checked));
        Values { cost: cost.map(|sums| sums[0]), outputs: outputs.map(|sums| DVector::from_column_slice(&sums[1..])) }
    }
}

impl LongSolver {
    /// J of the last motion, equal to that of a [`Solver`](crate::Solver). If steps were halved, the motion is computed once more for J and
    /// [`outputs`](Self::outputs).
    ///
    /// # Errors
    /// As [`Solver::cost`](crate::Solver::cost).
    pub fn cost(&mut self) -> Result<f64, Error> {
        self.values()?.cost.clone()
    }

    /// The values of all outputs of the last motion, equal to those of a [`Solver`](crate::Solver).
    ///
    /// # Errors
    /// As [`cost`](Self::cost).
    pub fn outputs(&mut self) -> Result<DVector<f64>, Error> {
        self.values()?.outputs.clone()
    }

    fn values(&mut self) -> Result<&Values, Error> {
        let (expected, computed) = (self.forward.motion.nodes(), self.computed);
        let incomplete = Error::Incomplete { expected, computed };
        if computed < expected {
            return Err(incomplete);
        }
        if self.values.is_none() {
            // Recomputed parts are not reported to the progress callback.
            self.forward.watch.turn();
            self.forward.begin_again(&self.system, &self.settings)?;
            let again = self.forward_to_end(usize::MAX, &mut |_| ());
            // An error at the end was returned before, and all nodes are complete.
            again.map(|_| ()).or_else(|error| if self.values.is_some() { Ok(()) } else { Err(error) })?;
        }
        self.values.as_ref().ok_or(incomplete)
    }
}
