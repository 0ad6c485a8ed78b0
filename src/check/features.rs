//! Branches, saturating functions and narrow sums of a recorded formula, and which of these features a point shows.
//!
//! The formula is compared with variants of itself, in each of which one node of its graph is replaced by something simpler:
//!
//! | node | replaced by | differs where |
//! |---|---|---|
//! | max(x, y), min(x, y) | x; y | x − y has the other sign |
//! | \|x\| | x; −x | x has the other sign |
//! | tanh x, atan x | ±1 | x is about ±1 |
//! | exp x | 0 | x is not far below 0 |
//! | sin x, cos x, powers, … | x, 1 or 0 | x is about 1 |
//! | x + y in 1/(x + y), √(x + y), … | x; y | x and y are of similar size |
//!
//! A point shows a variant if the gradients of variant and formula differ there: a hand-derived block without this piece is wrong there.

use std::ops::Range;

use crate::program::{Expression, Function, Graph, Node, Template};

/// Smallest visible difference of gradients, relative to the entry in which they differ most.
pub(super) const VISIBLE: f64 = 1e-9;
/// Differences below this fraction of their row have less weight.
const FAINT: f64 = 1e-9;
/// Range of |x| in which tanh x is close neither to x nor to ±1.
const CORE: [f64; 2] = [0.1, 2.0];
/// exp x is negligible for smaller x.
const NOTHING: f64 = -30.0;
/// Terms are of similar size if their ratio is below this factor.
const ALIKE: f64 = 30.0;
/// Depth below which an expression is abbreviated.
const DEPTH: usize = 5;
/// Values of smaller magnitude lie on neither side of a switch.
const SIDE: f64 = f64::MIN_POSITIVE;
const INFINITE: f64 = f64::INFINITY;

/// Variants that some point must show before a block is called right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Need {
    /// The variant itself.
    Variant,
    /// At least one variant of the same node.
    OfNode,
    Nothing,
}

/// A formula with one node replaced.
#[derive(Debug)]
pub(super) struct Variant {
    pub node: Node,
    other: Expression,
    /// The node whose value decides where the variant differs from the formula; `window` is the interval of these values, and `goals` are
    /// the values to solve for.
    pub of: Node,
    pub window: [f64; 2],
    pub goals: Vec<f64>,
    pub need: Need,
    /// The terms of a sum, which must be of similar size.
    terms: Option<[Node; 2]>,
    /// The results that depend on the node, and all nodes needed to compute these and `of`.
    results: Vec<Node>,
    order: Vec<Node>,
    /// The inputs by which gradients are compared: those of the block on which the node depends, or all if it depends on none of them.
    columns: Vec<(usize, Node)>,
}

/// The graph of a formula, or of one branch of a formula that compares values.
pub(super) struct Form {
    pub graph: Graph,
    template: (Template, Vec<f64>),
    pub variants: Vec<Variant>,
    /// Nodes whose values the formula compares, and the differences of successive ones.
    pub looks: Vec<Node>,
    /// The inputs on which the formula depends: their indices and their nodes.
    pub inputs: Vec<(usize, Node)>,
}

impl Form {
    /// Creates the form from a graph and its results, for a block differentiated by the inputs `by`; the inputs `free` may be moved.
    pub fn new((mut graph, results): (Graph, Vec<Node>), by: &Range<usize>, free: &[usize]) -> Self {
        let template = Template::new(&graph, &results, 0);
        let nodes: Vec<Node> = graph.reachable(results.iter().chain(graph.looked_at()).copied());
        let input = |&node: &Node| Some((graph.expression(node).input()?, node));
        let inputs: Vec<(usize, Node)> = nodes.iter().filter_map(input).collect();
        let mut form = Form { looks: Vec::new(), variants: Vec::new(), graph: Graph::default(), template, inputs };
        let is_free = |graph: &Graph, node: Node| graph.inputs_of(node).iter().any(|which| free.contains(which));
        let looked: Vec<Node> = graph.looked_at().iter().copied().filter(|&node| is_free(&graph, node)).collect();
        let pairs = looked.windows(2).map(|pair| graph.subtract(pair[0], pair[1])).collect::<Vec<_>>();
        form.looks = looked.iter().copied().chain(pairs).filter(|&node| !graph.is_fixed(node)).collect();
        form.looks.sort_unstable();
        form.looks.dedup();
        let order = graph.reachable(results.iter().copied());
        let is_inside = inside(&graph, &order);
        for &node in &order {
            form.variants.extend(variants(&mut graph, node, is_inside[node.index()]));
        }
        form.variants.retain(|variant| is_free(&graph, variant.of));
        for variant in &mut form.variants {
            variant.results = dependents(&graph, variant.node, &results);
            variant.order = graph.reachable(variant.results.iter().copied().chain([variant.of]));
            let of_node = graph.inputs_of(variant.node);
            let own = |(k, _): &&(usize, Node)| by.contains(k) && of_node.contains(k);
            variant.columns = form.inputs.iter().filter(own).copied().collect();
            if variant.columns.is_empty() {
                variant.columns.clone_from(&form.inputs);
            }
        }
        form.graph = graph;
        form
    }

    /// True if a graph is the graph of this branch.
    pub fn is_of(&self, (graph, results): &(Graph, Vec<Node>)) -> bool {
        let looks = |graph: &Graph| graph.looked_at().len();
        looks(&self.graph) == looks(graph) && self.template == Template::new(graph, results, 0)
    }

    /// Description of the piece of the formula that a variant omits.
    pub fn name(&self, variant: &Variant, arguments: &[String]) -> String {
        let [node, of] = [variant.node, variant.of].map(|node| self.graph.text(node, arguments, DEPTH).replace('`', ""));
        match variant.window {
            [low, _] if low > 0.0 && variant.is_side() => format!("`{node}` where {of} > 0"),
            _ if variant.is_side() => format!("`{node}` where {of} < 0"),
            _ => format!("`{node}` near {of} = {}", variant.goals[0]),
        }
    }

    /// True if the variant may differ from the formula at this point.
    pub fn reaches(&self, variant: &Variant, x: &[f64]) -> bool {
        variant.is_within(&self.graph.values(&variant.order, None, x))
    }

    /// Relative difference between the gradients of a variant and of the formula at a point, divided by the sum of both magnitudes; the largest over
    /// all entries. It is reduced if this difference is small relative to the rest of its row, scaled by the sizes of the arguments. It is almost 0
    /// if the node has an effect but the difference is lost in rounding, and 0 if the point gives no information about the variant.
    pub fn shows(&self, variant: &Variant, x: &[f64], sizes: &[f64]) -> f64 {
        let Variant { node, other, results, order, .. } = variant;
        let values = self.graph.values(order, None, x);
        if !variant.is_within(&values) {
            return 0.0;
        }
        let replaced = Some((*node, *other));
        let others = self.graph.values(order, replaced, x);
        let (mut share, mut counts) = (0.0f64, false);
        for &y in results {
            let slopes = self.graph.slopes(order, None, &values, y);
            let other = self.graph.slopes(order, replaced, &others, y);
            counts |= slopes[node.index()] != 0.0 || other[node.index()] != 0.0;
            let row = self.inputs.iter().fold(0.0f64, |row, (k, input)| row.max((slopes[input.index()] * sizes[*k]).abs()));
            for (k, input) in &variant.columns {
                let (a, b) = (slopes[input.index()], other[input.index()]);
                let difference = (a - b).abs();
                share = share.max(match difference / (a.abs() + b.abs()) {
                    share if share.is_finite() => share * (difference * sizes[*k] / (FAINT * row)).min(1.0),
                    _ if a.is_finite() && !b.is_finite() => 1.0,
                    _ => 0.0,
                });
            }
        }
        if share == 0.0 && counts && variant.need != Need::OfNode { SIDE } else { share }
    }
}

impl Variant {
    /// True if the variant is one side of a branch of the formula.
    pub fn is_side(&self) -> bool {
        self.need == Need::Variant && self.terms.is_none()
    }

    fn is_within(&self, values: &[f64]) -> bool {
        let is_inside = (self.window[0]..=self.window[1]).contains(&values[self.of.index()]);
        is_inside && self.terms.is_none_or(|terms| are_alike(values, terms))
    }
}

/// True if two terms are of similar size.
fn are_alike(values: &[f64], [x, y]: [Node; 2]) -> bool {
    let ratio = (values[x.index()] / values[y.index()]).abs();
    (1.0 / ALIKE..ALIKE).contains(&ratio)
}

/// The results that depend on a node.
fn dependents(graph: &Graph, node: Node, results: &[Node]) -> Vec<Node> {
    let mut depends = vec![false; graph.len()];
    depends[node.index()] = true;
    for y in graph.reachable(results.iter().copied()) {
        depends[y.index()] |= graph.expression(y).arguments().any(|x| depends[x.index()]);
    }
    results.iter().copied().filter(|y| depends[y.index()]).collect()
}

/// For every node, true if it is part of the argument of a root, of a denominator, …, where a sum makes a narrow feature.
fn inside(graph: &Graph, order: &[Node]) -> Vec<bool> {
    use Expression::*;
    let mut inside = vec![false; graph.len()];
    for &node in order.iter().rev() {
        let is_inside = inside[node.index()];
        let mut mark = |x: Node| inside[x.index()] = true;
        match graph.expression(node) {
            Of(Function::Reciprocal | Function::Sqrt | Function::Ln | Function::Ln1p, x) | Power(x, _) | Divide(_, x) => {
                mark(x)
            }
            IntegerPower(x, n) if n < 0 || is_inside => mark(x),
            expression @ (Add(..) | Subtract(..) | Multiply(..) | Of(Function::Negative, _)) if is_inside => {
                expression.arguments().for_each(mark);
            }
            _ => {}
        }
    }
    inside
}

/// The variants of a node.
fn variants(graph: &mut Graph, node: Node, is_inside: bool) -> Vec<Variant> {
    use Expression::*;
    let [above, below] = [[SIDE, INFINITE], [-INFINITE, -SIDE]];
    let all = [-INFINITE, INFINITE];
    let number = |x: f64| Constant(x.to_bits());
    let mut found: Vec<Variant> = Vec::new();
    let mut add = |other: Expression, of: Node, window: [f64; 2], goals: &[f64], need: Need| {
        let (terms, results, order, columns) = (None, Vec::new(), Vec::new(), Vec::new());
        found.push(Variant { node, other, of, window, goals: goals.to_vec(), need, terms, results, order, columns });
    };
    match graph.expression(node) {
        Max(x, y) | Min(x, y) => {
            let is_max = matches!(graph.expression(node), Max(..));
            let (difference, [x, y]) = (graph.subtract(x, y), [x, y].map(|x| graph.expression(x)));
            let [first, second] = if is_max { [above, below] } else { [below, above] };
            add(y, difference, first, &[0.0], Need::Variant);
            add(x, difference, second, &[0.0], Need::Variant);
        }
        Of(Function::Abs, x) => {
            add(Of(Function::Negative, x), x, above, &[0.0], Need::Variant);
            add(graph.expression(x), x, below, &[0.0], Need::Variant);
        }
        Of(Function::Tanh | Function::Atan, x) => {
            add(Of(Function::Sign, x), x, CORE, &[0.7], Need::OfNode);
            add(Of(Function::Sign, x), x, [-CORE[1], -CORE[0]], &[-0.7], Need::OfNode);
            add(graph.expression(x), x, all, &[2.0, -2.0], Need::Nothing);
        }
        Of(Function::Exp, x) => add(number(0.0), x, [NOTHING, INFINITE], &[-2.0, -0.5, 1.0], Need::OfNode),
        Of(Function::Cos | Function::Cosh, x) => add(number(1.0), x, all, &[1.0, -1.0], Need::Nothing),
        Of(Function::Sin | Function::Sinh | Function::ExpM1 | Function::Tan, x) => {
            add(graph.expression(x), x, all, &[1.0, -1.0], Need::Nothing);
        }
        Power(x, _) | IntegerPower(x, _) => add(number(0.0), x, all, &[1.0], Need::Nothing),
        expression @ (Add(x, y) | Subtract(x, y)) if is_inside => {
            let [first, second] = [x, y].map(|x| graph.function(Function::Abs, x));
            let difference = graph.subtract(first, second);
            let is_sum = matches!(expression, Add(..));
            let second = if is_sum { graph.expression(y) } else { Of(Function::Negative, y) };
            add(graph.expression(x), difference, all, &[0.0], Need::Variant);
            add(second, difference, all, &[0.0], Need::Variant);
            found.iter_mut().for_each(|variant| variant.terms = Some([x, y]));
        }
        _ => {}
    }
    found
}
