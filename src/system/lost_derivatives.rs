//! Derivatives that a formula loses: it takes the value of an argument by `re()`, as to look it up in a table, and computes with a plain number. Its values
//! change with the argument then, its derivatives do not.
//!
//! Recorded at values r of its arguments, a formula is a graph F(x; r). A formula that only branches on values has one graph for all r nearby. Of any other,
//! F(x; r) is compared at several r beside x: what changes as r − x has lost a first derivative, and what changes as its square has lost a second one, as a root does
//! that is found by values and corrected by one step of Newton's method. What does not change but for rounding, as √(x² + y²) by ratios to the larger of the two, has lost nothing.

use super::argument::Argument;
use super::cost_formula::Partial;
use super::element::Element;
use super::item::PlacedElement;
use super::jet::ElementKind;
use super::placed_cost::PlacedCost;
use super::typed::Slot;
use super::view::NodeView;
use crate::model::element::Sum;
use crate::number::{Hyper, hyper, hyper_parts};
use crate::program::{Graph, Node, Obstacle, record_branch};
use crate::{System, Warning};

/// Graphs are compared after moving the arguments by this part of them and by twice as much: finer steps than these, as of numbers with few digits, are slopes.
const NEAR: f64 = 5e-7;
/// Values are compared after moving the arguments by at most one of these parts of them, for first and for second derivatives: the smallest for functions that
/// change within a small part of an argument, the largest for values that are rounded coarsely.
const FAR: [&[f64]; 2] = [&[1e-6, 1e-3], &[1e-4]];
/// The number of distances at which they are compared, each a part of the one before.
const DISTANCES: i32 = 4;
const PART: f64 = 0.125;
/// Changes that differ from the expected ratio by more than this part of them are something else: rounding, or a branch.
const RATIO: f64 = 0.03;
/// A loss of less than this share of a derivative is the error of an iteration or of a slope that was given.
const SHARE: f64 = 1e-5;

/// What was recorded at some values: a graph, and the nodes of the results.
type Branch = (Graph, Vec<Node>);

/// Which derivatives are lost.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Order {
    First = 1,
    Second = 2,
}

/// A formula that reads values, at a point.
struct Reader<'a> {
    /// The kind of element, and its number of coordinates; none of a cost.
    kind: Option<(ElementKind, usize)>,
    /// Arguments, then constants, and what each of them is in the scene; none of a number.
    x: Vec<f64>,
    names: Vec<Option<Argument>>,
    /// The number of arguments.
    arguments: usize,
    record: &'a dyn Fn(&[f64]) -> Option<Branch>,
}

impl Reader<'_> {
    /// The first argument by which a derivative is lost.
    fn find_lost(&self, order: Order) -> Option<Argument> {
        // In this direction nothing cancels.
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

    /// Multiples of the sizes of all arguments that are no numbers.
    fn direction(&self, factor: impl Fn(usize) -> f64) -> Vec<f64> {
        let size = |x: f64| if x == 0.0 { 1.0 } else { x.abs() };
        let along = |(i, x): (usize, &f64)| self.names[i].map_or(0.0, |_| factor(i) * size(*x));
        self.x.iter().enumerate().map(along).collect()
    }

    fn moved(&self, along: &[f64], distance: f64) -> Vec<f64> {
        self.x.iter().zip(along).map(|(x, along)| x + distance * along).collect()
    }

    /// Whether values that are read along a direction, on one of its sides, change the formula as lost derivatives do, by more than a share of its change with the
    /// arguments themselves.
    fn loses(&self, along: &[f64], order: Order, share: f64) -> bool {
        let is_energy = matches!(self.kind, Some((ElementKind::Kinetic | ElementKind::Potential, _)));
        let moves = |(_, n): (ElementKind, usize)| along[..2 * n].iter().any(|along| *along != 0.0);
        // Equations contain derivatives of energies by q and v alone.
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

    /// What equations and costs are made of, by the graph of a branch: costs, Q; T and its slopes, −V and its slopes; Φ, Φ_q, dΦ/dt and (dΦ/dt)_q.
    fn entries(&self, (graph, results): &Branch, x: &[f64], with_values: bool) -> Vec<f64> {
        let n = self.kind.filter(|(kind, _)| *kind != ElementKind::Applied).map_or(0, |(_, n)| n);
        let is_constraint = self.kind.is_some_and(|(kind, _)| kind == ElementKind::Holonomic);
        // Of a constraint ε₁ is along the motion, and t the last argument.
        let rate = |i: usize| if i < n { x[n + i] } else { f64::from(i + 1 == self.arguments) };
        let along = |i: usize| if is_constraint { rate(i) } else { 0.0 };
        let of_seed = |seed: usize| {
            let number = |(i, x): (usize, &f64)| hyper(*x, along(i), f64::from(n > 0 && i == seed), 0.0);
            let numbers: Vec<Hyper> = x.iter().enumerate().map(number).collect();
            let (arguments, constants) = numbers.split_at(self.arguments);
            let values = graph.evaluate(constants, arguments);
            let parts = results.iter().flat_map(|node| hyper_parts(&values[node.index()])).enumerate();
            parts.map(|(k, part)| if with_values || k % 4 > 0 { part } else { 0.0 }).collect::<Vec<f64>>()
        };
        (0..(2 * n).max(1)).flat_map(of_seed).collect()
    }
}

impl PlacedElement {
    fn find_lost(&self, element: &Element, at: &NodeView<f64>, order: Order) -> Option<Argument> {
        let shape = self.formula.shape();
        let of_q = (0..shape.n).map(Slot::Q).chain((0..shape.n).map(Slot::V));
        let arguments = of_q.chain((0..shape.k).map(Slot::U)).chain([Slot::T]);
        let slots: Vec<Slot> = arguments.chain((0..shape.p).map(Slot::B)).collect();
        let name =
            |slot: &Slot| Some(Argument::of(element, *slot)).filter(|(_, factor)| *factor != 0.0).map(|(name, _)| name);
        let record = |x: &[f64]| {
            let value = |slot: Slot| match slot {
                Slot::B(p) => x[shape.sigma() + p],
                Slot::Sigma(_) => 0.0,
                _ => x[shape.number(slot)],
            };
            record_branch(|put| self.put_symbols(&value, put))
        };
        let reader = Reader {
            kind: Some((self.formula.kind(), shape.n)),
            x: slots.iter().map(|slot| self.read(at, *slot)).collect(),
            names: slots.iter().map(name).collect(),
            arguments: shape.sigma(),
            record: &record,
        };
        reader.find_lost(order)
    }
}

impl PlacedCost {
    fn find_lost(&self, at: &NodeView<f64>, order: Order) -> Option<Argument> {
        let arguments = self.shape.len();
        let of_b = self.b.iter().map(|b| b.bound().map(|(p, _)| Argument::Design(p)));
        let record = |x: &[f64]| {
            let value = |of: Partial| match of {
                Partial::Argument(i) => x[i],
                Partial::Constant(p) => x[arguments + p],
            };
            record_branch(|put| put(self.symbol(value)))
        };
        let x = (0..arguments).map(|i| self.argument(at, i)).chain(self.b.iter().map(|b| b.value(at.design)));
        let names = self.shape.places.iter().map(|place| Some(Argument::of_cost(*place))).chain(of_b);
        Reader { kind: None, x: x.collect(), names: names.collect(), arguments, record: &record }.find_lost(order)
    }
}

/// Whether a formula reads values.
fn reads(obstacle: Option<Obstacle>) -> bool {
    obstacle == Some(Obstacle::Branches)
}

impl System {
    /// Whether any formula reads values.
    pub(crate) fn reads_values(&self) -> bool {
        self.reads_values
    }

    pub(super) fn find_readers(&self) -> bool {
        let mut elements = self.formulas.elements.iter().map(|element| element.formula.obstacle);
        elements.any(reads) || self.costs.terms().any(|term| reads(term.obstacle))
    }

    /// Whether a cost at this single node reads values.
    pub(crate) fn reads_values_at(&self, node: usize) -> bool {
        self.costs.items().iter().any(|cost| cost.sum == Sum::Node(node) && reads(cost.obstacle))
    }

    /// The formulas that lose derivatives at a node, which counts costs in these ways, besides those that are known to.
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
            self.formulas.elements.iter().filter(|element| reads(element.formula.obstacle) && !is_known(&element.name));
        let of_elements =
            elements.filter_map(|element| Some((&element.name, self.item(element.place).find_lost(element, at, order)?)));
        let costs =
            self.costs.items().iter().filter(|cost| reads(cost.obstacle) && counts(cost.sum) && !is_known(&cost.name));
        let of_costs = costs.filter_map(|cost| Some((&cost.name, cost.find_lost(at, order)?)));
        let warning = |(name, argument): (&String, Argument)| Warning::LostDerivative {
            element: name.clone(),
            argument: self.argument_name(argument),
            order: order as usize,
        };
        of_elements.chain(of_costs).map(warning).collect()
    }
}
