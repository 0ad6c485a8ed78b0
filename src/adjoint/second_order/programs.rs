//! What second-order sweeps evaluate of elements and costs.

use crate::System;
use crate::node::Evaluation;
use crate::system::{CostSecondOrder, NodeView, SecondOrderEquations};

/// Made when a product is asked for, and again when formulas change.
pub(super) struct Programs {
    fingerprint: Option<u64>,
    /// The values of parameters that preludes were run for.
    design: Vec<f64>,
    pub(super) equations: SecondOrderEquations,
    /// Of each batch of costs.
    pub(super) costs: Vec<Vec<Option<CostSecondOrder>>>,
}

impl Programs {
    /// Brings them up to date with the formulas that are evaluated, and with the design variables.
    pub(super) fn prepare(this: &mut Option<Programs>, system: &System, evaluation: &Evaluation, at: &NodeView<f64>) {
        let fingerprint = evaluation.fingerprint();
        let elements = &evaluation.formulas(system).elements;
        if this.as_ref().is_none_or(|own| fingerprint.is_none() || own.fingerprint != fingerprint) {
            let costs = system.costs().iter().map(|costs| costs.second_order(at)).collect();
            let equations = SecondOrderEquations::new(system, elements);
            *this = Some(Programs { fingerprint, design: vec![f64::NAN], equations, costs });
        }
        let Some(own) = this.as_mut().filter(|own| own.design != at.design) else { return };
        own.design.clear();
        own.design.extend_from_slice(at.design);
        own.equations.fix(elements, at.design);
        for (costs, programs) in system.costs().iter().zip(&mut own.costs) {
            costs.fix_second_order(at.design, programs);
        }
    }
}
