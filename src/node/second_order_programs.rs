//! [`SecondOrderPrograms`]: the programs for elements and costs in second-order sweeps.

use super::evaluation::Evaluation;
use crate::system::{CostPrograms, CostRows, Covector, NodeView, SecondOrderEquations, Sums};
use crate::{Error, System};

/// Compiled for the first product, and again after formulas have changed.
#[derive(Default)]
pub(crate) struct SecondOrderPrograms {
    /// The fingerprint of the elements.
    fingerprint: Option<u64>,
    /// The values of the parameters for which preludes were run.
    design: Vec<f64>,
    pub(crate) equations: SecondOrderEquations,
    pub(crate) costs: CostPrograms,
}

impl SecondOrderPrograms {
    /// Updates the programs to the current formulas and design variables.
    ///
    /// # Errors
    /// The quantities on which a cost depends have changed.
    pub(crate) fn prepare(&mut self, system: &System, evaluation: &Evaluation, at: &NodeView<f64>) -> Result<(), Error> {
        system.fix_costs(at, 2, &mut self.costs)?;
        let (fingerprint, formulas) = (evaluation.fingerprint(), evaluation.formulas(system));
        if fingerprint.is_none() || self.fingerprint != fingerprint {
            self.equations = formulas.second_order();
            (self.fingerprint, self.design) = (fingerprint, vec![f64::NAN]);
        }
        if self.design == at.design {
            return Ok(());
        }
        self.design.clear();
        self.design.extend_from_slice(at.design);
        self.equations.fix(&formulas.elements, at.design);
        Ok(())
    }

    /// The changes of 𝓛_v, 𝓛_q + Q and dΦ/dt along a direction, at a point with these second derivatives.
    pub(crate) fn changes(
        &mut self,
        (system, evaluation): (&System, &Evaluation),
        (at, blocks): (&NodeView<f64>, &[f64]),
        along: &NodeView<f64>,
        sums: &mut Sums<f64>,
    ) {
        evaluation.push_forward(system, blocks, along, sums);
        self.equations.add_changes(system.batches(), (at, along), sums);
    }

    /// Computes the derivatives of the change of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt along a direction.
    pub(crate) fn rows_along(
        &mut self,
        of: (&System, &Evaluation),
        at: (&NodeView<f64>, &[f64]),
        along: &NodeView<f64>,
        with: &Covector,
        rows: &mut CostRows,
    ) {
        rows.clear();
        self.add_rows_along(of, at, along, with, rows);
    }

    /// Adds the derivatives of the change of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt along a direction.
    pub(crate) fn add_rows_along(
        &mut self,
        (system, evaluation): (&System, &Evaluation),
        (at, blocks): (&NodeView<f64>, &[f64]),
        along: &NodeView<f64>,
        with: &Covector,
        rows: &mut CostRows,
    ) {
        evaluation.pull_back_along(blocks, along, with, rows);
        self.equations.pull_back(system.batches(), (at, along), with, rows);
    }
}
