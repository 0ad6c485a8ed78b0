//! [`SecondOrderKernels`]: the programs that second-order sweeps take from one formula.
//!
//! With D the derivative along a direction of all arguments and constants, and ψ = c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt:
//!
//! ```text
//!   changes   D (𝓛_v, 𝓛_q + Q, dΦ/dt) along the inputs u, b and t alone
//!   rows      the derivatives of D ψ with respect to every argument and constant
//! ```
//!
//! What is done without a program is left out: changes along controls of an element that is constant, rows of the states of one that is sinusoidal.

use super::derivatives::{Derivatives, input_node, sum_of_products};
use super::formula::{ArgumentOf, Component, Formula, InputOf};
use super::shape::Shape;
use crate::program::{Graph, Kernel, Node};

/// The programs. Their parameters are those of the formula, then the factors of the constants.
pub struct SecondOrderKernels {
    pub changes: Kernel,
    pub components: Vec<Component>,
    pub rows: Kernel,
    pub of: Vec<ArgumentOf>,
}

impl SecondOrderKernels {
    /// Of a formula that has a graph; `bound` says which constants are design variables.
    pub fn new(formula: &Formula, bound: &[bool]) -> Option<Self> {
        formula.kernels.as_ref()?;
        let (template, shape) = (formula.template.as_ref()?, formula.shape);
        let (mut graph, values) = template.graph();
        let derivatives = Derivatives::new(&mut graph, formula.kind, shape, &values);
        let (one, zero) = (graph.constant(1.0), graph.constant(0.0));
        let of_constants = constants(&mut graph, (shape, bound), template.parameters);
        let controls = (0..shape.k).map(|k| (InputOf::Control(k), moving(&mut graph, shape, shape.u() + k)));
        let mut of_inputs: Vec<(InputOf, Tangent)> = Vec::from_iter(controls);
        of_inputs.extend(of_constants.iter().copied());
        if formula.timed {
            of_inputs.push((InputOf::Time, moving(&mut graph, shape, shape.t())));
        }
        let tangents = |list: &[(InputOf, Tangent)]| list.iter().map(|(_, tangent)| *tangent).collect::<Vec<Tangent>>();

        let numbered = |of: fn(usize) -> Component, nodes: &[Node]| {
            nodes.iter().enumerate().map(move |(i, node)| (of(i), *node)).collect::<Vec<_>>()
        };
        let mut all = numbered(Component::Momentum, &derivatives.l_v);
        all.extend(numbered(Component::Force, &derivatives.force));
        all.extend(numbered(Component::Equation, &derivatives.phi_dot));
        let (components, nodes): (Vec<_>, Vec<_>) = all.into_iter().unzip();
        let without_program = if formula.constant { shape.k } else { 0 };
        let changes = graph.forward(&nodes, &tangents(&of_inputs[without_program..]));
        let (components, changes): (Vec<_>, Vec<_>) =
            components.into_iter().zip(changes).filter(|(_, change)| !graph.is_zero(*change)).unzip();

        let (x, w): (Vec<Node>, Vec<Node>) = derivatives.weighted(&mut graph, shape).into_iter().unzip();
        let psi = sum_of_products(&mut graph, &x, &w, zero);
        let state = states(shape);
        let mut directions: Vec<Tangent> = state.iter().map(|&(_, which)| moving(&mut graph, shape, which)).collect();
        directions.extend(tangents(&of_inputs));
        let along = graph.forward(&[psi], &directions)[0];
        let inputs: Vec<Node> = of_inputs.iter().map(|(of, _)| input_node(&mut graph, shape, *of)).collect();
        let by_inputs = graph.reverse(&[(along, one)], &inputs);
        let along = if formula.sinusoidal { graph.forward(&[psi], &tangents(&of_constants))[0] } else { along };
        let arguments: Vec<Node> = state.iter().map(|&(_, which)| graph.input(which)).collect();
        let by_state = graph.reverse(&[(along, one)], &arguments);
        let of_state = state.iter().map(|(of, _)| *of);
        let of = of_state.chain(of_inputs.iter().map(|(of, _)| ArgumentOf::Input(*of)));
        let (of, rows): (Vec<_>, Vec<_>) =
            of.zip([by_state, by_inputs].concat()).filter(|(_, row)| !graph.is_zero(*row)).unzip();
        let mut kernel = |results: &[Node]| Kernel::new(&mut graph, template.parameters + shape.p, results);
        Some(SecondOrderKernels { changes: kernel(&changes)?, components, rows: kernel(&rows)?, of })
    }
}

/// A node and its tangent.
pub(super) type Tangent = (Node, Node);

/// An argument and its rate.
///
/// A start stays at its time, where a load may begin with an infinite slope: √t at t = 0.
pub(super) fn moving(graph: &mut Graph, shape: Shape, which: usize) -> Tangent {
    let place = shape.moving().position(|moving| moving == which).unwrap_or_default();
    let rate = graph.input(shape.rates() + place);
    (graph.input(which), if which == shape.t() { graph.unless_zero(rate) } else { rate })
}

/// The constants that are bound: their rates are those of what they are multiples of, times the factors.
pub(super) fn constants(graph: &mut Graph, (shape, bound): (Shape, &[bool]), parameters: usize) -> Vec<(InputOf, Tangent)> {
    let bound = (0..shape.p).filter(|&p| bound[p]);
    Vec::from_iter(bound.map(|p| {
        let (factor, rate) = (graph.parameter(parameters + p), graph.input(shape.constant_rates() + p));
        (InputOf::Constant(p), (graph.parameter(p), graph.multiply(factor, rate)))
    }))
}

/// q, v and σ.
fn states(shape: Shape) -> Vec<(ArgumentOf, usize)> {
    let q = (0..shape.n).map(|i| (ArgumentOf::Coordinate(i), i));
    let v = (0..shape.n).map(|i| (ArgumentOf::Velocity(i), shape.v() + i));
    let sigma = (0..shape.m).map(|j| (ArgumentOf::Multiplier(j), shape.sigma() + j));
    q.chain(v).chain(sigma).collect()
}
