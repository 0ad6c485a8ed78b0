//! Detection of derivatives that a formula loses by reading the value of an argument with `re()`, for example to look it up in a table, and computing
//! with a plain number. The value of the formula then changes with the argument, but its derivative does not.
//!
//! Recorded at values r of its arguments, a formula is a graph F(x; r), the same for all r nearby if the formula only branches on values. Otherwise,
//! F(x; r) is compared at several r near x. A change as r − x indicates a lost first derivative, a change as its square a lost second derivative
//! (a root found from values and corrected by one Newton step). If only rounding changes, as for √(x² + y²) by ratios to the larger, nothing is lost.

use crate::model::element::Sum;
use crate::number::{Hyper, hyper, hyper_parts};
use crate::program::{Graph, Node, Obstacle, record_branch};
use crate::system::cost::Costs;
use crate::system::formula::{Argument, ElementKind, NodeView, Placed, Recordable, Slot};
use crate::system::tangent::Formulas;
use crate::{System, Warning};

/// Relative displacement of the arguments for comparing graphs; twice this displacement is also used. Steps of a function that are finer than this
/// (few digits) are treated as a slope.
const NEAR: f64 = 5e-7;
/// Largest relative displacements of the arguments for comparing values, for first and for second derivatives: the smallest for functions that
/// change within a small part of an argument, the largest for values that are rounded coarsely.
const FAR: [&[f64]; 2] = [&[1e-6, 1e-3], &[1e-4]];
/// The number of displacements that are compared, each `PART` times the one before.
const DISTANCES: i32 = 4;
const PART: f64 = 0.125;
/// Largest relative deviation from the expected ratio of changes; a larger one indicates rounding or a branch.
const RATIO: f64 = 0.03;
/// Smallest relative loss of a derivative that is reported; a smaller one may be the error of an iteration or of a given slope.
const SHARE: f64 = 1e-5;

/// A recording at given values: a graph, and the nodes of the results.
type Branch = (Graph, Vec<Node>);

/// The order of a lost derivative.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Order {
    First = 1,
    Second = 2,
}

/// A formula that reads values, at a point.
struct Reader<'a> {
    /// The kind of element and its number of coordinates; `None` for a cost.
    kind: Option<(ElementKind, usize)>,
    /// Arguments, then constants; and the scene's argument for each, `None` for a plain number.
    x: Vec<f64>,
    names: Vec<Option<Argument>>,
    /// The number of arguments, and the number in the graph of each argument.
    arguments: usize,
    numbers: &'a [usize],
    record: &'a dyn Fn(&[f64]) -> Option<Branch>,
}

impl Reader<'_> {
    /// The first argument with respect to which a derivative is lost.
    fn find_lost(&self, order: Order) -> Option<Argument> {
        // A direction in which no terms cancel.
        let all = self.direction(|i| 1.0 + 0.3 * (1.7 * i as f64).sin());
        let [one, two] = [NEAR, 2.0 * NEAR].map(|distance| (self.record)(&self.moved(&all, distance)));
        let (one, two) = (one?, two?);
        if one.1 == two.1 && one.0.expressions().eq(two.0.expressions()) || !self.loses(&all, order, 0.0) {
            return None;
        }
        let share = if order == Order::First { SHARE } else { 0.0 };
        let is_lost = |which: usize| self.loses(&self.direction(|i| f64::from(i == which)), order, share);
        self.names.iter().enumerate().find_map(|(i, name)| name.filter(|_| is_lost(i)))
    }

    /// Multiples of the magnitudes of all arguments; zero for plain numbers.
    fn direction(&self, factor: impl Fn(usize) -> f64) -> Vec<f64> {
        let size = |x: f64| if x == 0.0 { 1.0 } else { x.abs() };
        let along = |(i, x): (usize, &f64)| self.names[i].map_or(0.0, |_| factor(i) * size(*x));
        self.x.iter().enumerate().map(along).collect()
    }

    fn moved(&self, along: &[f64], distance: f64) -> Vec<f64> {
        self.x.iter().zip(along).map(|(x, along)| x + distance * along).collect()
    }

    /// True if the values that a formula reads change its result as lost derivatives would, in at least one of the two senses of a direction, and by
    /// more than `share` of the change caused by the arguments themselves.
    fn loses(&self, along: &[f64], order: Order, share: f64) -> bool {
        let is_energy = matches!(self.kind, Some((ElementKind::Kinetic | ElementKind::Potential, _)));
        let moves = |(_, n): (ElementKind, usize)| along[..2 * n].iter().any(|along| *along != 0.0);
        // The equations contain only derivatives of energies with respect to q and v.
        let with_values = !is_energy || self.kind.is_some_and(moves);
        let distances = FAR[order as usize - 1].iter().flat_map(|far| [*far, -far]);
        distances.into_iter().any(|far| {
            let points: Vec<_> = (0..DISTANCES).map(|k| self.moved(along, far * PART.powi(k))).collect();
            let branches = points.iter().map(|read| (self.record)(read)).collect::<Option<Vec<_>>>();
            branches.is_some_and(|branches| {
                let values = |k: usize, x: &[f64]| self.entries(&branches[k], x, with_values);
                let read: Vec<_> = (0..points.len()).map(|k| values(k, &self.x)).collect();
                let [first, second] = [0, 1].map(|k| values(k, &points[k]));
                (0..first.len()).any(|entry| {
                    let change = |k: usize| read[k][entry] - read[k + 1][entry];
                    let expected = |k: usize| PART.powi(order as i32) * change(k);
                    let follows = |k: usize| (change(k + 1) - expected(k)).abs() <= RATIO * change(k + 1).abs();
                    let counts = change(0).abs() > share * (first[entry] - second[entry]).abs();
                    counts && change(2) != 0.0 && follows(0) && follows(1)
                })
            })
        })
    }

    /// The quantities in equations and costs, from the graph of a branch: costs; Q; T, −V and their slopes; Φ, Φ_q, dΦ/dt and (dΦ/dt)_q.
    fn entries(&self, (graph, results): &Branch, x: &[f64], with_values: bool) -> Vec<f64> {
        let n = self.kind.filter(|(kind, _)| *kind != ElementKind::Applied).map_or(0, |(_, n)| n);
        let is_constraint = self.kind.is_some_and(|(kind, _)| kind == ElementKind::Holonomic);
        // For a constraint, ε₁ is along the motion, and t is the last argument.
        let rate = |i: usize| if i < n { x[n + i] } else { f64::from(i + 1 == self.arguments) };
        let along = |i: usize| if is_constraint { rate(i) } else { 0.0 };
        let of_seed = |seed: usize| {
            let number = |(i, x): (usize, &f64)| hyper(*x, along(i), f64::from(n > 0 && i == seed), 0.0);
            let numbers: Vec<Hyper> = x.iter().enumerate().map(number).collect();
            let (arguments, constants) = numbers.split_at(self.arguments);
            let mut inputs = vec![Hyper::from(0.0); self.numbers.iter().max().map_or(0, |last| last + 1)];
            self.numbers.iter().zip(arguments).for_each(|(&which, x)| inputs[which] = *x);
            let values = graph.evaluate(constants, &inputs);
            let parts = results.iter().flat_map(|node| hyper_parts(&values[node.index()])).enumerate();
            parts.map(|(k, part)| if with_values || k % 4 > 0 { part } else { 0.0 }).collect::<Vec<f64>>()
        };
        (0..(2 * n).max(1)).flat_map(of_seed).collect()
    }
}

impl<F: Recordable + ?Sized> Placed<F> {
    /// The first argument with respect to which a derivative is lost; `kind` is that of an element.
    fn find_lost(&self, kind: Option<ElementKind>, at: &NodeView<f64>, order: Order) -> Option<Argument> {
        let slots: Vec<Slot> = self.slots.iter().copied().chain((0..self.shape.p).map(Slot::B)).collect();
        let name = |slot: &Slot| Some(self.to.argument(*slot)).filter(|(_, factor)| *factor != 0.0).map(|(name, _)| name);
        let x: Vec<f64> = slots.iter().map(|slot| self.to.read(at, *slot)).collect();
        let numbers: Vec<usize> = slots.iter().map(|slot| self.shape.number(*slot)).collect();
        let record = |x: &[f64]| {
            let mut values = vec![0.0; self.shape.len()];
            numbers.iter().zip(x).for_each(|(&which, x)| values[which] = *x);
            record_branch(|put| self.put_symbols(&|slot| values[self.shape.number(slot)], put))
        };
        let reader = Reader {
            kind: kind.map(|kind| (kind, self.shape.n)),
            x,
            names: slots.iter().map(name).collect(),
            arguments: self.slots.len(),
            numbers: &numbers,
            record: &record,
        };
        reader.find_lost(order)
    }
}

/// Whether a formula reads values, given the reason why it has no graph.
fn reads(obstacle: Option<Obstacle>) -> bool {
    obstacle == Some(Obstacle::Branches)
}

/// Whether any formula reads values.
pub(in crate::system) fn find_readers(formulas: &Formulas, costs: &Costs) -> bool {
    let mut elements = formulas.elements.iter().map(|element| element.formula.obstacle);
    elements.any(reads) || costs.terms().any(|term| reads(term.obstacle))
}

impl System {
    /// Whether any formula reads values.
    pub(crate) fn reads_values(&self) -> bool {
        self.0.reads_values
    }

    /// Whether a cost at this single node reads values.
    pub(crate) fn reads_values_at(&self, node: usize) -> bool {
        self.0.costs.items().iter().any(|cost| cost.sum == Sum::Node(node) && reads(cost.obstacle))
    }

    /// Warnings for the formulas that lose derivatives at a node, except `known` ones; `counts` selects the costs by how they are summed.
    pub(crate) fn find_lost_derivatives(
        &self,
        at: &NodeView<f64>,
        counts: impl Fn(Sum) -> bool,
        order: Order,
        known: &[Warning],
    ) -> Vec<Warning> {
        let is_known =
            |name: &str| known.iter().any(|w| matches!(w, Warning::LostDerivative { element, .. } if element == name));
        let elements =
            self.0.formulas.elements.iter().filter(|element| reads(element.formula.obstacle) && !is_known(&element.name));
        let of_elements = elements.filter_map(|element| {
            Some((&element.name, self.item(element.place).find_lost(Some(element.kind()), at, order)?))
        });
        let costs =
            self.0.costs.items().iter().filter(|cost| reads(cost.obstacle) && counts(cost.sum) && !is_known(&cost.of.name));
        let of_costs = costs.filter_map(|cost| Some((&cost.of.name, cost.of.find_lost(None, at, order)?)));
        let warning = |(name, argument): (&String, Argument)| Warning::LostDerivative {
            element: name.clone(),
            argument: self.argument_name(argument),
            order: order as usize,
        };
        of_elements.chain(of_costs).map(warning).collect()
    }
}
