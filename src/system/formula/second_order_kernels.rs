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

use super::derivatives::{Derivatives, components, without_zeros};
use super::differentiated::{Component, Formula};
use super::shape::{Shape, Slot};
use crate::program::{Graph, Kernel, Node};

/// Programs of one formula for second-order sweeps. Their parameters are those of the formula, followed by the factors of the constants.
pub struct SecondOrderKernels {
    pub changes: Kernel,
    pub components: Vec<Component>,
    pub rows: Kernel,
    pub of: Vec<Slot>,
}

impl SecondOrderKernels {
    /// Builds the programs if the formula has a graph; `bound` marks the constants that are design variables.
    pub fn new(formula: &Formula, bound: &[bool]) -> Option<Self> {
        let (template, shape) = (&formula.kernels.as_ref()?.template, formula.shape);
        let (mut graph, derivatives) = Derivatives::new(formula.kind, shape, template);
        let one = graph.constant(1.0);
        let of_constants = constants(&mut graph, (shape, bound), template.parameters);
        let controls = (0..shape.k).map(|k| (Slot::U(k), moving(&mut graph, shape, shape.u() + k)));
        let mut of_inputs: Vec<(Slot, Tangent)> = Vec::from_iter(controls);
        of_inputs.extend(of_constants.iter().copied());
        if formula.timed {
            of_inputs.push((Slot::T, moving(&mut graph, shape, shape.t())));
        }
        let tangents = |list: &[(Slot, Tangent)]| list.iter().map(|(_, tangent)| *tangent).collect::<Vec<Tangent>>();

        let all = components([&derivatives.l_v, &derivatives.force, &derivatives.phi_dot]);
        let (of, nodes): (Vec<_>, Vec<_>) = all.into_iter().unzip();
        let without_program = if formula.constant { shape.k } else { 0 };
        let changes = graph.forward(&nodes, &tangents(&of_inputs[without_program..]));
        let (components, changes) = without_zeros(&graph, of.into_iter().zip(changes));

        let psi = derivatives.weighted_sum(&mut graph);
        let state = states(shape);
        let mut directions: Vec<Tangent> = state.iter().map(|&slot| moving(&mut graph, shape, shape.number(slot))).collect();
        directions.extend(tangents(&of_inputs));
        let along = graph.forward(&[psi], &directions)[0];
        let inputs: Vec<Node> = of_inputs.iter().map(|(slot, _)| shape.node(&mut graph, *slot)).collect();
        let by_inputs = graph.reverse(&[(along, one)], &inputs);
        let along = if formula.sinusoidal { graph.forward(&[psi], &tangents(&of_constants))[0] } else { along };
        let arguments: Vec<Node> = state.iter().map(|slot| shape.node(&mut graph, *slot)).collect();
        let by_state = graph.reverse(&[(along, one)], &arguments);
        let of = state.into_iter().chain(of_inputs.into_iter().map(|(slot, _)| slot));
        let (of, rows) = without_zeros(&graph, of.zip([by_state, by_inputs].concat()));
        let mut kernel = |results: &[Node]| Kernel::new(&mut graph, template.parameters + shape.p, results);
        Some(SecondOrderKernels { changes: kernel(&changes)?, components, rows: kernel(&rows)?, of })
    }
}

/// A node and its tangent.
pub(in crate::system) type Tangent = (Node, Node);

/// An argument and its rate.
///
/// The initial time is fixed, so terms with a zero rate of t are dropped: a load may have an infinite slope there, such as √t at t = 0.
pub(in crate::system) fn moving(graph: &mut Graph, shape: Shape, which: usize) -> Tangent {
    let place = shape.moving().position(|moving| moving == which).unwrap_or_default();
    let rate = graph.input(shape.rates() + place);
    (graph.input(which), if which == shape.t() { graph.unless_zero(rate) } else { rate })
}

/// The bound constants with their rates: the rate of the design variable or expression, times the factor of the constant.
pub(in crate::system) fn constants(
    graph: &mut Graph,
    (shape, bound): (Shape, &[bool]),
    parameters: usize,
) -> Vec<(Slot, Tangent)> {
    let bound = (0..shape.p).filter(|&p| bound[p]);
    Vec::from_iter(bound.map(|p| {
        let (factor, rate) = (graph.parameter(parameters + p), graph.input(shape.constant_rates() + p));
        (Slot::B(p), (graph.parameter(p), graph.multiply(factor, rate)))
    }))
}

/// The slots of q, v and σ.
fn states(shape: Shape) -> Vec<Slot> {
    (0..shape.n).map(Slot::Q).chain((0..shape.n).map(Slot::V)).chain((0..shape.m).map(Slot::Sigma)).collect()
}
