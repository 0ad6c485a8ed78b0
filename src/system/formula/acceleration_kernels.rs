//! [`AccelerationKernels`]: the programs of one formula for accelerations and reactions.
//!
//! Let D denote the time derivative along (v, v̇) of (q, v) and 1 of t, and let λ = dσ/dt at σ = 0. The kinds of elements contribute
//!
//! ```text
//!   kinetic    f = T_q − D T_v        applied     f = Q
//!   potential  f = −V_q               constraint  f = −Φ_qᵀ λ,   g = −D (dΦ/dt)
//! ```

use super::derivatives::{Derivatives, components, sum_of_products, without_zeros};
use super::differentiated::{Component, Formula};
use super::kind::ElementKind;
use super::second_order_kernels::{constants, moving};
use super::shape::{Shape, Slot};
use crate::program::{Graph, Kernel, Node, Template};

/// Programs of one formula for f and g and for the derivatives of c·f + e·g.
pub struct AccelerationKernels {
    /// f and g at v̇ = 0 and λ = 0, and the component that each result belongs to: momenta for f, equations for g.
    pub right: Kernel,
    pub components: Vec<Component>,
    /// The derivatives of c·f + e·g.
    pub rows: Kernel,
    pub of: Vec<Slot>,
}

impl AccelerationKernels {
    /// Builds the programs if the formula has a graph; `bound` marks the constants that are design variables.
    pub fn new(formula: &Formula, bound: &[bool]) -> Option<Self> {
        let template = &formula.kernels.as_ref()?.template;
        let (mut graph, derivatives) = Derivatives::new(formula.kind, formula.shape, template);
        let right = equations(&mut graph, &derivatives, false);
        let (components, right) = without_zeros(&graph, right);
        let (of, slopes) = slopes(&mut graph, &derivatives, bound);
        let (of, slopes) = without_zeros(&graph, of.into_iter().zip(slopes));
        let mut kernel = |results: &[Node]| Kernel::new(&mut graph, template.parameters, results);
        Some(AccelerationKernels { right: kernel(&right)?, components, rows: kernel(&slopes)?, of })
    }
}

/// The program for the directional derivative of the gradient of c·f + e·g, along q, v, u, t and constants at fixed v̇ and λ, and the slot of each
/// result.
///
/// The direction of v is stored in the place of d, which does not occur in c·f + e·g; the other directions are stored as rates, next to v̇ and λ. The
/// parameters are those of the formula, followed by the factors of the constants.
pub fn rows_along(formula: &Formula, bound: &[bool]) -> Option<(Kernel, Vec<Slot>)> {
    let (template, shape) = (&formula.kernels.as_ref()?.template, formula.shape);
    let (mut graph, of, changes) = changes_along(formula.kind, shape, template, bound);
    Some((Kernel::new(&mut graph, template.parameters + shape.p, &changes)?, of))
}

/// As [`rows_along`], but as nodes of a graph.
pub fn changes_along(kind: ElementKind, shape: Shape, template: &Template, bound: &[bool]) -> (Graph, Vec<Slot>, Vec<Node>) {
    let (mut graph, derivatives) = Derivatives::new(kind, shape, template);
    let (of, slopes) = slopes(&mut graph, &derivatives, bound);
    let directions = directions(&mut graph, (shape, bound), template.parameters);
    let changes = graph.forward(&slopes, &directions);
    let (of, changes) = without_zeros(&graph, of.into_iter().zip(changes));
    (graph, of, changes)
}

/// The program for the directional derivatives of f and g, with the arguments of [`rows_along`], and the component of each result.
pub fn tangents(formula: &Formula, bound: &[bool]) -> Option<(Kernel, Vec<Component>)> {
    let (template, shape) = (&formula.kernels.as_ref()?.template, formula.shape);
    let (mut graph, derivatives) = Derivatives::new(formula.kind, shape, template);
    let directions = directions(&mut graph, (shape, bound), template.parameters);
    let (components, nodes): (Vec<Component>, Vec<Node>) = equations(&mut graph, &derivatives, true).into_iter().unzip();
    let changes = graph.forward(&nodes, &directions);
    let (components, changes) = without_zeros(&graph, components.into_iter().zip(changes));
    Some((Kernel::new(&mut graph, template.parameters + shape.p, &changes)?, components))
}

/// The arguments that vary along a direction of q, v, u, t and constants, each with its rate.
fn directions(graph: &mut Graph, (shape, bound): (Shape, &[bool]), parameters: usize) -> Vec<(Node, Node)> {
    let mut all: Vec<(Node, Node)> = constants(graph, (shape, bound), parameters).into_iter().map(|(_, of)| of).collect();
    all.extend((0..shape.n).map(|i| (graph.input(shape.v() + i), graph.input(shape.d() + i))));
    let moved = (0..shape.n).chain((0..shape.k).map(|k| shape.u() + k)).chain([shape.t()]);
    all.extend(moved.map(|which| moving(graph, shape, which)));
    all
}

/// The derivatives of c·f + e·g, and the arguments that they belong to.
fn slopes(graph: &mut Graph, derivatives: &Derivatives, bound: &[bool]) -> (Vec<Slot>, Vec<Node>) {
    let shape = derivatives.shape;
    let all = equations(graph, derivatives, true);
    let weighted: Vec<(Node, Node)> = Vec::from_iter(all.into_iter().map(|(of, node)| match of {
        Component::Momentum(i) | Component::Force(i) => (node, graph.input(shape.c() + i)),
        Component::Equation(j) => (node, graph.input(shape.e() + j)),
    }));
    let state = (0..shape.n).map(Slot::Q).chain((0..shape.n).map(Slot::V));
    let constants = (0..shape.p).filter(|&p| bound[p]).map(Slot::B);
    let of: Vec<Slot> = state.chain((0..shape.k).map(Slot::U)).chain(constants).chain([Slot::T]).collect();
    let arguments: Vec<Node> = of.iter().map(|slot| derivatives.shape.node(graph, *slot)).collect();
    (of, graph.reverse(&weighted, &arguments))
}

/// f and g, with the given v̇ and λ or with both set to zero.
fn equations(graph: &mut Graph, derivatives: &Derivatives, with_accelerations: bool) -> Vec<(Component, Node)> {
    let Derivatives { kind, shape, l_v, force, phi_dot, phi_q, .. } = derivatives;
    let (n, one, zero, minus) = (shape.n, graph.constant(1.0), graph.constant(0.0), graph.constant(-1.0));
    let mut along: Vec<(Node, Node)> = (0..n).map(|i| (graph.input(i), graph.input(shape.v() + i))).collect();
    along.push((graph.input(shape.t()), one));
    if with_accelerations {
        along.extend((0..n).map(|i| (graph.input(shape.v() + i), graph.input(shape.rates() + n + i))));
    }
    match kind {
        ElementKind::Kinetic => {
            let rates = graph.forward(l_v, &along);
            let f: Vec<Node> = force.iter().zip(rates).map(|(force, rate)| graph.subtract(*force, rate)).collect();
            components([&f, &[], &[]])
        }
        ElementKind::Potential | ElementKind::Applied => components([force, &[], &[]]),
        ElementKind::Holonomic => {
            let rates = graph.forward(phi_dot, &along);
            let g: Vec<Node> = rates.into_iter().map(|rate| graph.multiply(minus, rate)).collect();
            let equations = if with_accelerations { 0..shape.m } else { 0..0 };
            let reactions: Vec<Node> = Vec::from_iter(equations.map(|j| {
                let lambda = graph.input(shape.rates() + 2 * n + j);
                graph.multiply(minus, lambda)
            }));
            let column = |i: usize| (0..reactions.len()).map(|j| phi_q[j * n + i]).collect::<Vec<Node>>();
            let f: Vec<Node> = (0..n).map(|i| sum_of_products(graph, &column(i), &reactions, zero)).collect();
            components([&f, &[], &g])
        }
    }
}
