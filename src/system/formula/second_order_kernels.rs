//! [`SecondOrderKernels`]: the programs of one formula for second-order sweeps.
//!
//! Let D denote the derivative along a direction of all arguments and constants, and let ψ = c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt:
//!
//! ```text
//!   changes   D (𝓛_v, 𝓛_q + Q, dΦ/dt) along the inputs u, b and t alone
//!   rows      the derivatives of D ψ with respect to every argument and constant
//! ```
//!
//! Parts that do not need a program are left out: changes along controls of a constant element, and rows of the states of a sinusoidal element.

use super::derivatives::{Derivatives, components};
use super::differentiated::{Component, Formula};
use super::labelled::{Labelled, changes, gradient, tangents};
use super::shape::{Slot, bound_constants};
use crate::program::Graph;

/// Programs of one formula for second-order sweeps. Their parameters are those of the formula, followed by the factors of the constants.
pub struct SecondOrderKernels {
    pub changes: Labelled<Component>,
    pub rows: Labelled<Slot>,
}

impl SecondOrderKernels {
    /// Builds the programs if the formula has a graph; `bound` marks the constants that are design variables.
    pub fn new(formula: &Formula, bound: &[bool]) -> Option<Self> {
        let (template, shape) = (&formula.kernels.as_ref()?.template, formula.shape);
        let (mut graph, derivatives) = Derivatives::new(formula.kind, shape, template);
        let (of, states, constants) = ((shape, template.parameters), shape.states(), bound_constants(bound));
        let controls = (0..shape.k).map(Slot::U);
        let inputs: Vec<Slot> = controls.chain(constants.iter().copied()).chain(formula.timed.then_some(Slot::T)).collect();

        let without_program = if formula.constant { shape.k } else { 0 };
        let along = tangents(&mut graph, of, &inputs[without_program..]);
        let all = components([&derivatives.l_v, &derivatives.force, &derivatives.phi_dot]);
        let of_components = changes(&mut graph, all, &along);

        let (psi, one) = (derivatives.weighted_sum(&mut graph), graph.constant(1.0));
        let change_along = |graph: &mut Graph, slots: &[Slot]| {
            let along = tangents(graph, of, slots);
            [(graph.forward(&[psi], &along)[0], one)]
        };
        let change = change_along(&mut graph, &[&states[..], &inputs].concat());
        let by_inputs = gradient(&mut graph, shape, &change, &inputs);
        let change = if formula.sinusoidal { change_along(&mut graph, &constants) } else { change };
        let by_states = gradient(&mut graph, shape, &change, &states);
        let (parameters, rows) = (template.parameters + shape.p, by_states.into_iter().chain(by_inputs));
        let changes = Labelled::new(&mut graph, parameters, of_components)?;
        Some(SecondOrderKernels { changes, rows: Labelled::new(&mut graph, parameters, rows)? })
    }
}
