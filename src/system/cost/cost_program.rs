//! [`CostProgram`]: the program for the value and the gradient of a recorded cost, shared by all costs with this formula.

use std::collections::HashMap;
use std::sync::Arc;

use crate::program::{Graph, Kernel, Node, Obstacle, Template};
use crate::system::formula::{Place, Shape, Slot, without_zeros};

/// The program of a cost.
#[derive(Debug)]
pub struct CostProgram {
    pub template: Template,
    pub kernel: Kernel,
    /// The arguments of the program.
    pub inputs: Vec<Slot>,
    /// The variables of the partial derivatives, which are the results after the first one (the value).
    pub partials: Vec<Slot>,
    pub quadratic: Option<Quadratic>,
}

/// A polynomial c + gᵀx + ½ xᵀH x of degree two in many arguments.
#[derive(Debug)]
pub struct Quadratic {
    /// The program for H, which is constant; stored by columns.
    pub second: Kernel,
    /// Whether digits may cancel in this form that the original formula keeps.
    pub may_cancel: bool,
}

/// With fewer arguments, a program is at least as fast as a matrix.
const FEW: usize = 6;

/// The time of one instruction in units of the time per matrix entry; a sum of squares exceeds this ratio, a full quadratic form does not.
const ENTRIES: usize = 8;

impl CostProgram {
    /// Compiles a recorded cost with derivatives with respect to these variables.
    fn new(template: &Template, shape: Shape, variables: Vec<Slot>) -> Result<Self, Obstacle> {
        let (mut graph, values) = template.graph();
        let (partials, slopes) = gradient(&mut graph, shape, values[0], variables);
        let results = [&values[..1], &slopes].concat();
        let kernel = Kernel::new(&mut graph, template.parameters, &results).ok_or(Obstacle::IsTooLong)?;
        let is_worth_it = partials.len() >= FEW && partials.len().pow(2) <= ENTRIES * kernel.main().len();
        let quadratic =
            is_worth_it.then(|| quadratic(&mut graph, (shape, &partials), &results, template.parameters)).flatten();
        let inputs = kernel.inputs().iter().map(|&which| plain(shape, which)).collect();
        Ok(CostProgram { template: template.clone(), kernel, inputs, partials, quadratic })
    }
}

/// What makes programs differ: the shape, the variables of the derivatives, and the recorded formula.
type Key = (Shape, Vec<Slot>, Template);

/// The programs of all costs of a scene; every formula is compiled once.
#[derive(Default)]
pub struct CostPrograms {
    known: HashMap<Key, Result<Arc<CostProgram>, Obstacle>>,
}

impl CostPrograms {
    /// The program of a recorded cost with derivatives with respect to these variables.
    pub fn of(&mut self, template: &Template, shape: Shape, variables: Vec<Slot>) -> Result<Arc<CostProgram>, Obstacle> {
        let program = self.known.entry((shape, variables, template.clone()));
        let compile =
            |(shape, variables, template): &Key| CostProgram::new(template, *shape, variables.clone()).map(Arc::new);
        program.or_insert_with_key(compile).clone()
    }
}

/// The quadratic form of a cost if it is a polynomial of degree two in arguments alone; derived from its value and slopes.
fn quadratic(
    graph: &mut Graph,
    (shape, partials): (Shape, &[Slot]),
    results: &[Node],
    parameters: usize,
) -> Option<Quadratic> {
    let one = graph.constant(1.0);
    let mut second = Vec::new();
    for slot in partials {
        if matches!(slot, Slot::B(_)) {
            return None;
        }
        let x = shape.node(graph, *slot);
        second.extend(graph.forward(&results[1..], &[(x, one)]));
    }
    let is_quadratic = !second.is_empty() && second.iter().all(|node| graph.is_fixed(*node));
    if !is_quadratic || graph.is_piecewise(results.iter().copied()) {
        return None;
    }
    let may_cancel = graph.multiplies_sums([results[0]]);
    Some(Quadratic { second: Kernel::new(graph, parameters, &second)?, may_cancel })
}

/// The partial derivatives of a node that do not vanish.
pub(in crate::system) fn gradient(graph: &mut Graph, shape: Shape, value: Node, of: Vec<Slot>) -> (Vec<Slot>, Vec<Node>) {
    let one = graph.constant(1.0);
    let arguments: Vec<Node> = of.iter().map(|slot| shape.node(graph, *slot)).collect();
    let slopes = graph.reverse(&[(value, one)], &arguments);
    without_zeros(graph, of.into_iter().zip(slopes))
}

/// The argument of the formula with this number.
pub(in crate::system) fn plain(shape: Shape, which: usize) -> Slot {
    match shape.place(which) {
        Place::Of(slot) => slot,
        _ => Slot::T,
    }
}
