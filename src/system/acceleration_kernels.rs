//! [`AccelerationKernels`]: the programs that accelerations and reactions take from one formula.
//!
//! With D the derivative in time along (v, v̇) of (q, v) and 1 of t, and λ = dσ/dt at σ = 0,
//!
//! ```text
//!   kinetic    f = T_q − D T_v        applied     f = Q
//!   potential  f = −V_q               constraint  f = −Φ_qᵀ λ,   g = −D (dΦ/dt)
//! ```

use super::derivatives::{Derivatives, input_node, sum_of_products};
use super::formula::{ArgumentOf, Component, Formula, InputOf};
use super::jet::ElementKind;
use super::second_order_kernels::{constants, moving};
use super::shape::Shape;
use crate::program::{Graph, Kernel, Node, Template};

/// The programs.
pub struct AccelerationKernels {
    /// f and g where v̇ = 0 and λ = 0, and which component each result is.
    pub right: Kernel,
    pub components: Vec<Component>,
    /// The derivatives of c·f + e·g.
    pub rows: Kernel,
    pub of: Vec<ArgumentOf>,
}

impl AccelerationKernels {
    /// Of a formula that has a graph; `bound` says which constants are design variables.
    pub fn new(formula: &Formula, bound: &[bool]) -> Option<Self> {
        formula.kernels.as_ref()?;
        let (template, shape) = (formula.template.as_ref()?, formula.shape);
        let (mut graph, values) = template.graph();
        let derivatives = Derivatives::new(&mut graph, formula.kind, shape, &values);
        let right = equations(&mut graph, formula.kind, shape, &derivatives, false);
        let (components, right): (Vec<_>, Vec<_>) = right.into_iter().filter(|(_, node)| !graph.is_zero(*node)).unzip();
        let (of, slopes) = slopes(&mut graph, formula.kind, (shape, bound), &derivatives);
        let (of, slopes): (Vec<_>, Vec<_>) = of.into_iter().zip(slopes).filter(|(_, slope)| !graph.is_zero(*slope)).unzip();
        let mut kernel = |results: &[Node]| Kernel::new(&mut graph, template.parameters, results);
        Some(AccelerationKernels { right: kernel(&right)?, components, rows: kernel(&slopes)?, of })
    }
}

/// The program for what those rows change by along a direction of q, v, u, t and constants, at fixed v̇ and λ, and with respect to what they are.
///
/// The direction of v stands in the place of d, which has no part in c·f + e·g; the others are rates, beside v̇ and λ. Parameters are those of the
/// formula, then the factors of the constants.
pub fn rows_along(formula: &Formula, bound: &[bool]) -> Option<(Kernel, Vec<ArgumentOf>)> {
    formula.kernels.as_ref()?;
    let (template, shape) = (formula.template.as_ref()?, formula.shape);
    let (mut graph, of, changes) = changes_along(formula.kind, shape, template, bound);
    Some((Kernel::new(&mut graph, template.parameters + shape.p, &changes)?, of))
}

/// The same as nodes of a graph.
pub fn changes_along(
    kind: ElementKind,
    shape: Shape,
    template: &Template,
    bound: &[bool],
) -> (Graph, Vec<ArgumentOf>, Vec<Node>) {
    let (mut graph, values) = template.graph();
    let derivatives = Derivatives::new(&mut graph, kind, shape, &values);
    let (of, slopes) = slopes(&mut graph, kind, (shape, bound), &derivatives);
    let mut directions: Vec<(Node, Node)> =
        constants(&mut graph, (shape, bound), template.parameters).into_iter().map(|(_, of)| of).collect();
    directions.extend((0..shape.n).map(|i| (graph.input(shape.v() + i), graph.input(shape.d() + i))));
    let moved = (0..shape.n).chain((0..shape.k).map(|k| shape.u() + k)).chain([shape.t()]);
    directions.extend(moved.map(|which| moving(&mut graph, shape, which)));
    let changes = graph.forward(&slopes, &directions);
    let (of, changes) = of.into_iter().zip(changes).filter(|(_, change)| !graph.is_zero(*change)).unzip();
    (graph, of, changes)
}

/// The derivatives of c·f + e·g, and with respect to what.
fn slopes(
    graph: &mut Graph,
    kind: ElementKind,
    (shape, bound): (Shape, &[bool]),
    derivatives: &Derivatives,
) -> (Vec<ArgumentOf>, Vec<Node>) {
    let all = equations(graph, kind, shape, derivatives, true);
    let weighted: Vec<(Node, Node)> = Vec::from_iter(all.into_iter().map(|(of, node)| match of {
        Component::Momentum(i) | Component::Force(i) => (node, graph.input(shape.c() + i)),
        Component::Equation(j) => (node, graph.input(shape.e() + j)),
    }));
    let (of, arguments) = arguments(graph, shape, bound);
    let slopes = graph.reverse(&weighted, &arguments);
    (of, slopes)
}

/// f and g, with v̇ and λ or with zeros in their place.
fn equations(
    graph: &mut Graph,
    kind: ElementKind,
    shape: Shape,
    derivatives: &Derivatives,
    with_accelerations: bool,
) -> Vec<(Component, Node)> {
    let (f, g) = parts(graph, kind, shape, derivatives, with_accelerations);
    let f = f.into_iter().enumerate().map(|(i, node)| (Component::Momentum(i), node));
    let g = g.into_iter().enumerate().map(|(j, node)| (Component::Equation(j), node));
    f.chain(g).collect()
}

fn parts(
    graph: &mut Graph,
    kind: ElementKind,
    shape: Shape,
    derivatives: &Derivatives,
    with_accelerations: bool,
) -> (Vec<Node>, Vec<Node>) {
    let (n, m, one, zero) = (shape.n, shape.m, graph.constant(1.0), graph.constant(0.0));
    let minus = graph.constant(-1.0);
    let mut along: Vec<(Node, Node)> = (0..n).map(|i| (graph.input(i), graph.input(shape.v() + i))).collect();
    along.push((graph.input(shape.t()), one));
    if with_accelerations {
        along.extend((0..n).map(|i| (graph.input(shape.v() + i), graph.input(shape.rates() + n + i))));
    }
    match kind {
        ElementKind::Kinetic => {
            let rates = graph.forward(&derivatives.l_v, &along);
            let f = derivatives.force.iter().zip(rates).map(|(force, rate)| graph.subtract(*force, rate)).collect();
            (f, Vec::new())
        }
        ElementKind::Potential | ElementKind::Applied => (derivatives.force.clone(), Vec::new()),
        ElementKind::Holonomic => {
            let rates = graph.forward(&derivatives.phi_dot, &along);
            let g = rates.into_iter().map(|rate| graph.multiply(minus, rate)).collect();
            let equations = if with_accelerations { 0..m } else { 0..0 };
            let reactions: Vec<Node> = Vec::from_iter(equations.map(|j| {
                let lambda = graph.input(shape.rates() + 2 * n + j);
                graph.multiply(minus, lambda)
            }));
            let column = |i: usize| (0..reactions.len()).map(|j| derivatives.phi_q[j * n + i]).collect::<Vec<Node>>();
            (Vec::from_iter((0..n).map(|i| sum_of_products(graph, &column(i), &reactions, zero))), g)
        }
    }
}

fn arguments(graph: &mut Graph, shape: Shape, bound: &[bool]) -> (Vec<ArgumentOf>, Vec<Node>) {
    let mut all: Vec<(ArgumentOf, Node)> = (0..shape.n).map(|i| (ArgumentOf::Coordinate(i), graph.input(i))).collect();
    all.extend((0..shape.n).map(|i| (ArgumentOf::Velocity(i), graph.input(shape.v() + i))));
    let constants = (0..shape.p).filter(|&p| bound[p]).map(InputOf::Constant);
    let inputs = (0..shape.k).map(InputOf::Control).chain(constants).chain([InputOf::Time]);
    all.extend(inputs.map(|of| (ArgumentOf::Input(of), input_node(graph, shape, of))));
    all.into_iter().unzip()
}
