//! [`AccelerationKernels`]: the programs of one formula for accelerations and reactions.
//!
//! Let D denote the time derivative along (v, v̇) of (q, v) and 1 of t, and let λ = dσ/dt at σ = 0. The kinds of elements contribute
//!
//! ```text
//!   kinetic    f = T_q − D T_v        applied     f = Q
//!   potential  f = −V_q               constraint  f = −Φ_qᵀ λ,   g = −D (dΦ/dt)
//! ```

use super::derivatives::{Derivatives, components, sum_of_products};
use super::differentiated::{Component, Formula};
use super::kind::ElementKind;
use super::labelled::{Labelled, changes, gradient, tangents};
use super::shape::{Shape, Slot, bound_constants};
use crate::program::{Graph, Node, Template};

/// Programs of one formula for f and g and for the derivatives of c·f + e·g.
pub struct AccelerationKernels {
    /// f and g at v̇ = 0 and λ = 0, by component: momenta for f, equations for g.
    pub right: Labelled<Component>,
    /// The derivatives of c·f + e·g.
    pub rows: Labelled<Slot>,
}

impl AccelerationKernels {
    /// Builds the programs if the formula has a graph; `bound` marks the constants that are design variables.
    pub fn new(formula: &Formula, bound: &[bool]) -> Option<Self> {
        let template = &formula.kernels.as_ref()?.template;
        let (mut graph, derivatives) = Derivatives::new(formula.kind, formula.shape, template);
        let right = equations(&mut graph, &derivatives, false);
        let rows = slopes(&mut graph, &derivatives, bound);
        let right = Labelled::new(&mut graph, template.parameters, right)?;
        Some(AccelerationKernels { right, rows: Labelled::new(&mut graph, template.parameters, rows)? })
    }
}

/// The program for the directional derivative of the gradient of c·f + e·g, along q, v, u, t and constants at fixed v̇ and λ.
///
/// The parameters are those of the formula, followed by the factors of the constants.
pub fn rows_along(formula: &Formula, bound: &[bool]) -> Option<Labelled<Slot>> {
    let (template, shape) = (&formula.kernels.as_ref()?.template, formula.shape);
    let (mut graph, changes) = changes_along(formula.kind, shape, template, bound);
    Labelled::new(&mut graph, template.parameters + shape.p, changes)
}

/// As [`rows_along`], but as nodes of a graph.
pub fn changes_along(kind: ElementKind, shape: Shape, template: &Template, bound: &[bool]) -> (Graph, Vec<(Slot, Node)>) {
    let (mut graph, derivatives) = Derivatives::new(kind, shape, template);
    let slopes = slopes(&mut graph, &derivatives, bound);
    let directions = directions(&mut graph, (shape, bound), template.parameters);
    let changes = changes(&mut graph, slopes, &directions);
    (graph, changes)
}

/// The program for the directional derivatives of f and g, with the arguments of [`rows_along`].
pub fn equations_along(formula: &Formula, bound: &[bool]) -> Option<Labelled<Component>> {
    let (template, shape) = (&formula.kernels.as_ref()?.template, formula.shape);
    let (mut graph, derivatives) = Derivatives::new(formula.kind, shape, template);
    let directions = directions(&mut graph, (shape, bound), template.parameters);
    let equations = equations(&mut graph, &derivatives, true);
    let changes = changes(&mut graph, equations, &directions);
    Labelled::new(&mut graph, template.parameters + shape.p, changes)
}

/// The arguments that vary along a direction of q, v, u, t and constants, each with its rate.
fn directions(graph: &mut Graph, (shape, bound): (Shape, &[bool]), parameters: usize) -> Vec<(Node, Node)> {
    let state = (0..shape.n).map(Slot::V).chain((0..shape.n).map(Slot::Q));
    let moved = bound_constants(bound).into_iter().chain(state).chain((0..shape.k).map(Slot::U)).chain([Slot::T]);
    tangents(graph, (shape, parameters), &moved.collect::<Vec<Slot>>())
}

/// The derivatives of c·f + e·g.
fn slopes(graph: &mut Graph, derivatives: &Derivatives, bound: &[bool]) -> Vec<(Slot, Node)> {
    let shape = derivatives.shape;
    let all = equations(graph, derivatives, true);
    let weighted: Vec<(Node, Node)> = Vec::from_iter(all.into_iter().map(|(of, node)| match of {
        Component::Momentum(i) | Component::Force(i) => (node, graph.input(shape.c() + i)),
        Component::Equation(j) => (node, graph.input(shape.e() + j)),
    }));
    let state = (0..shape.n).map(Slot::Q).chain((0..shape.n).map(Slot::V));
    let of: Vec<Slot> = state.chain((0..shape.k).map(Slot::U)).chain(bound_constants(bound)).chain([Slot::T]).collect();
    gradient(graph, shape, &weighted, &of)
}

/// f and g, with the given v̇ and λ or with both set to zero.
fn equations(graph: &mut Graph, derivatives: &Derivatives, with_accelerations: bool) -> Vec<(Component, Node)> {
    let Derivatives { kind, shape, l_v, force, phi_dot, phi_q, .. } = derivatives;
    let (n, one, zero, minus) = (shape.n, graph.constant(1.0), graph.constant(0.0), graph.constant(-1.0));
    let mut along: Vec<(Node, Node)> = (0..n).map(|i| (graph.input(i), graph.input(shape.number(Slot::V(i))))).collect();
    along.push((graph.input(shape.number(Slot::T)), one));
    if with_accelerations {
        along.extend((0..n).map(|i| (graph.input(shape.number(Slot::V(i))), graph.input(shape.number(Slot::VDot(i))))));
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
                let lambda = graph.input(shape.number(Slot::Lambda(j)));
                graph.multiply(minus, lambda)
            }));
            let column = |i: usize| (0..reactions.len()).map(|j| phi_q[j * n + i]).collect::<Vec<Node>>();
            let f: Vec<Node> = (0..n).map(|i| sum_of_products(graph, &column(i), &reactions, zero)).collect();
            components([&f, &[], &g])
        }
    }
}
