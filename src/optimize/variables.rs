//! [`Variables`]: the free inputs of a motion as variables x, with the map x ↔ inputs and its transposed derivative.

use std::collections::HashSet;
use std::mem::{Discriminant, discriminant};
use std::ops::Range;

use super::free::{Free, Quantity};
use super::problem::Interval;
use super::spline::cubic;
use crate::motion::check_size;
use crate::{Error, Gradient, Inputs, System};

/// Smaller weights of knots are rounding errors.
const ROUNDING: f64 = 1e-12;

const NODES: &str = "the nodes of the inputs, which must be those for which the variables were created";

/// The meaning of a variable, independent of the system.
#[derive(PartialEq)]
pub(super) struct Meaning<'a> {
    pub(super) name: &'a str,
    kind: Discriminant<Quantity>,
    pub(super) scale: f64,
    logarithm: bool,
}

/// A free design variable: its variable, its number, and d value / dx.
pub(super) struct FreeDesign {
    pub(super) variable: usize,
    pub(super) design: usize,
    pub(super) slope: f64,
}

/// The free variables in order, and their map to the inputs.
#[derive(Clone, Debug)]
pub struct Variables {
    free: Vec<Free>,
    /// The first variable of each free quantity, and the number of all variables.
    first: Vec<usize>,
    /// The knots of each free quantity: all, except for controls in a part of a motion.
    knots: Vec<Range<usize>>,
    /// The fractions of the duration of the whole motion at the first and at the last node.
    between: [f64; 2],
    /// The fraction of the duration that has passed at each node.
    shares: Vec<f64>,
    /// The length of each step relative to the duration.
    steps: Vec<f64>,
    names: Vec<String>,
}

impl Variables {
    /// The variables for the free quantities of these inputs.
    ///
    /// # Errors
    /// A quantity that is repeated or does not exist; empty bounds; scales that are not positive, or that make bounds overflow; fewer than
    /// two knots, or more knots than nodes; a logarithm of a quantity with bounds or a value that are not positive; a free duration of zero
    /// length.
    pub fn new(system: &System, inputs: &Inputs, free: Vec<Free>) -> Result<Self, Error> {
        inputs.check(system)?;
        let mut known = HashSet::new();
        for of in &free {
            let name = of.quantity.name(system, inputs.grid.steps.len())?;
            of.bounds.check(|| format!("`{name}`"))?;
            require(of.scale > 0.0 && of.scale.is_finite(), || format!("the scale of `{name}`"), of.scale, "positive")?;
            let Interval { least, most } = of.bounds;
            for (which, bound, is_none) in [("lower", least, least == f64::NEG_INFINITY), ("upper", most, false)] {
                let what = || format!("the {which} bound of the logarithmic variable `{name}`");
                require(!of.logarithm || bound > 0.0 || is_none, what, bound, "positive")?;
                let what = || format!("the scale of `{name}`, with which its {which} bound overflows,");
                let is_lost = bound.is_finite() && !of.to_variable(bound).is_finite();
                require(!is_lost, what, of.scale, "closer to the bound")?;
            }
            let (knots, nodes) = (of.knots(inputs.grid.nodes()), inputs.grid.nodes());
            let fewest = match of.quantity {
                Quantity::LinearControl(..) => 2,
                Quantity::SplineControl(..) => 4,
                _ => 1,
            };
            let count = || format!("the number of knots or pieces of `{name}`");
            require(
                (fewest..=nodes).contains(&knots),
                count,
                knots as f64,
                "at least 1 (2 if linear, 4 for a spline) and at most the number of nodes",
            )?;
            let is_new = known.insert(of.quantity.subject());
            require(is_new, || format!("the number of times that `{name}` is free"), 2.0, "1")?;
        }
        let is_single = |of: &&Free| matches!(of.quantity, Quantity::StepLength(_));
        let singles = free.iter().filter(is_single).count() as f64;
        let has_duration = free.iter().any(|of| of.quantity == Quantity::Duration);
        let count = || "the number of free individual step lengths, if the duration is free,".into();
        require(singles == 0.0 || !has_duration, count, singles, "0; free either the duration or single step lengths")?;
        let knots = free.iter().map(|of| 0..of.knots(inputs.grid.nodes())).collect();
        Variables::with_knots(system, inputs, (free, knots), [0.0, 1.0])
    }

    /// The variables of a part of a motion between two fractions of its duration, for free quantities with some of their knots.
    ///
    /// # Errors
    /// A quantity that does not exist; a variable that is not finite.
    pub(super) fn with_knots(
        system: &System,
        inputs: &Inputs,
        (free, knots): (Vec<Free>, Vec<Range<usize>>),
        between: [f64; 2],
    ) -> Result<Self, Error> {
        let (mut first, mut names): (Vec<usize>, Vec<String>) = (vec![0], Vec::new());
        for (of, knots) in free.iter().zip(&knots) {
            let name = of.quantity.name(system, inputs.grid.steps.len())?;
            first.push(names.len() + knots.len());
            match of.knots(inputs.grid.nodes()) {
                1 => names.push(name),
                _ => names.extend(knots.clone().map(|k| format!("{name} [{k}]"))),
            }
        }
        let mut variables = Variables { free, first, knots, between, shares: Vec::new(), steps: Vec::new(), names };
        variables.take(inputs)?;
        Ok(variables)
    }

    /// For parts of the motion, which begin at the end of the part before: the knots of each free quantity that affect a part. Knots that affect no node
    /// belong to the part before them.
    pub(super) fn knots_of(&self, parts: &[Range<usize>]) -> Vec<Vec<Range<usize>>> {
        let mut all = vec![Vec::with_capacity(self.free.len()); parts.len()];
        for (free, knots) in self.free.iter().zip(&self.knots) {
            let used = |nodes: &Range<usize>| {
                let of_nodes = (nodes.start..=nodes.end).flat_map(|node| self.weights((free, knots), node));
                let of_nodes = of_nodes.filter(|(_, weight)| weight.abs() > ROUNDING).map(|(knot, _)| knot);
                let [least, most] = of_nodes.fold([usize::MAX, 0], |[least, most], k| [least.min(k), most.max(k)]);
                least..most + 1
            };
            let is_control = free.quantity.control().is_some();
            let mut next = knots.len();
            for (nodes, into) in parts.iter().zip(&mut all).rev() {
                let used = if is_control { used(nodes) } else { 0..1 };
                let start = if nodes.start == parts[0].start { 0 } else { used.start };
                into.push(start..used.end.max(next));
                next = used.start;
            }
        }
        all
    }

    /// For each variable, the first node at which it changes the inputs; 0 for quantities that are not controls.
    pub(super) fn first_nodes(&self) -> Vec<usize> {
        let mut first = vec![0; self.len()];
        for ((free, range), knots) in self.parts().zip(&self.knots) {
            if free.quantity.control().is_none() {
                continue;
            }
            let last = self.shares.len() - 1;
            first[range.clone()].fill(last);
            for node in (0..=last).rev() {
                self.weights((free, knots), node).for_each(|(knot, _)| first[range.start + knot] = node);
            }
        }
        first
    }

    /// # Errors
    /// Inputs with another number of nodes, or a system that lacks a free quantity.
    pub(super) fn check(&self, system: &System, inputs: &Inputs) -> Result<(), Error> {
        check_size(NODES, self.shares.len(), inputs.grid.nodes())?;
        self.free.iter().try_for_each(|of| of.quantity.name(system, inputs.grid.steps.len()).map(drop))
    }

    /// Stores the relative times of the nodes, and returns the variables of these inputs.
    ///
    /// # Errors
    /// A free duration of zero, or a variable that is not finite.
    pub(super) fn take(&mut self, inputs: &Inputs) -> Result<Vec<f64>, Error> {
        let passed = inputs.grid.passed();
        let duration = passed[passed.len() - 1];
        if self.free.iter().any(|of| of.quantity == Quantity::Duration) {
            require(duration != 0.0, || "the duration of the motion".into(), duration, "not zero if it is free")?;
        }
        self.shares = passed.iter().map(|t| if duration == 0.0 { 0.0 } else { t / duration }).collect();
        self.steps = inputs.grid.steps.iter().map(|dt| dt / duration).collect();
        self.finite(inputs)
    }

    /// The variables of these inputs.
    ///
    /// # Errors
    /// A variable that is not finite, such as the logarithm of a negative value.
    pub(super) fn finite(&self, inputs: &Inputs) -> Result<Vec<f64>, Error> {
        let x = self.of(inputs);
        x.iter().position(|x| !x.is_finite()).map_or(Ok(()), |i| {
            let is_logarithm = self.parts().any(|(free, range)| free.logarithm && range.contains(&i));
            let form = if is_logarithm { "logarithm" } else { "variable" };
            Err(Error::NotFinite { what: format!("the {form} of `{}` at the start", self.names[i]), value: x[i] })
        })?;
        Ok(x)
    }

    /// The number of variables.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// True if nothing is free.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// Name of variable i.
    pub fn name(&self, i: usize) -> &str {
        &self.names[i]
    }

    fn free_of(&self, i: usize) -> &Free {
        &self.free[self.first.partition_point(|first| *first <= i) - 1]
    }

    /// The free quantity that variable i is a part of.
    pub(super) fn quantity(&self, i: usize) -> &Quantity {
        &self.free_of(i).quantity
    }

    /// The meaning of variable i.
    pub(super) fn meaning(&self, i: usize) -> Meaning<'_> {
        let of = self.free_of(i);
        Meaning { name: self.name(i), kind: discriminant(&of.quantity), scale: of.scale, logarithm: of.logarithm }
    }

    /// The bounds of all variables.
    pub fn bounds(&self) -> Vec<Interval> {
        let of = |free: &Free| {
            let bound = |value: f64| if value.is_finite() { free.to_variable(value) } else { value };
            Interval::new(bound(free.bounds.least), bound(free.bounds.most))
        };
        self.parts().flat_map(|(free, range)| range.map(move |_| of(free))).collect()
    }

    /// A copy of these variables in which a free quantity has the given bounds.
    ///
    /// # Errors
    /// A quantity that is not free, or bounds that do not fit it.
    pub(super) fn bounded(
        &self,
        system: &System,
        inputs: &Inputs,
        (quantity, to): (&Quantity, Interval),
    ) -> Result<Self, Error> {
        let mut free = self.free.clone();
        let Some(of) = free.iter_mut().find(|of| of.quantity == *quantity) else {
            let name = quantity.name(system, inputs.grid.steps.len())?;
            let is_other = self.free.iter().any(|of| of.quantity.subject() == quantity.subject());
            let form = if is_other { " in this form (it is free with other knots)" } else { "" };
            return Err(Error::NotAVariable { what: format!("`{name}`{form}"), variables: self.len() });
        };
        of.bounds = to;
        let Variables { free, .. } = Variables::new(system, inputs, free)?;
        Ok(Variables { free, ..self.clone() })
    }

    /// The free quantities, in order.
    pub(super) fn free(&self) -> &[Free] {
        &self.free
    }

    pub(super) fn parts(&self) -> impl Iterator<Item = (&Free, Range<usize>)> {
        self.free.iter().zip(self.first.windows(2).map(|ends| ends[0]..ends[1]))
    }

    /// The free design variables at a point.
    pub(super) fn designs(&self, x: &[f64]) -> Vec<FreeDesign> {
        let of = |(free, range): (&Free, Range<usize>)| match free.quantity {
            Quantity::Design(design) => {
                let variable = range.start;
                Some(FreeDesign { variable, design: design.index(), slope: free.slope(x[variable]) })
            }
            _ => None,
        };
        self.parts().filter_map(of).collect()
    }

    /// The variables of these inputs; controls on coarser knots are sampled at the knots.
    pub fn of(&self, inputs: &Inputs) -> Vec<f64> {
        let mut x = vec![0.0; self.len()];
        for ((free, range), knots) in self.parts().zip(&self.knots) {
            let values = &mut x[range];
            match free.quantity {
                Quantity::Control(control)
                | Quantity::LinearControl(control, _)
                | Quantity::PiecewiseControl(control, _)
                | Quantity::SplineControl(control, _) => {
                    // The first node at which the weight of the knot is largest; if there is none, the value of the previous knot.
                    let mut most = vec![0.0; values.len()];
                    for node in 0..self.shares.len() {
                        for (knot, weight) in self.weights((free, knots), node) {
                            if weight > most[knot] {
                                (most[knot], values[knot]) = (weight, inputs.controls[(control.index(), node)]);
                            }
                        }
                    }
                    for k in (1..values.len()).filter(|&k| most[k] == 0.0) {
                        values[k] = values[k - 1];
                    }
                }
                Quantity::Design(design) => values[0] = inputs.design[design.index()],
                Quantity::Coordinate(q) => values[0] = inputs.start.q()[q.index()],
                Quantity::Rate(q) => values[0] = inputs.start.rate()[q.index()],
                Quantity::Duration => values[0] = inputs.grid.passed()[inputs.grid.steps.len()],
                Quantity::StepLength(node) => values[0] = inputs.grid.steps[node - 1],
            }
            values.iter_mut().for_each(|x| *x = free.to_variable(*x));
        }
        x
    }

    /// Sets the free quantities of the inputs from the variables.
    ///
    /// # Errors
    /// A wrong number of variables, or inputs with another number of nodes; nothing is set in this case.
    pub fn apply(&self, x: &[f64], inputs: &mut Inputs) -> Result<(), Error> {
        check_size("the variables of a point", self.len(), x.len())?;
        check_size(NODES, self.shares.len(), inputs.grid.nodes())?;
        check_size("the nodes of the controls", self.shares.len(), inputs.controls.ncols())?;
        self.write(x, inputs);
        Ok(())
    }

    /// As [`apply`](Self::apply), without checks of sizes.
    pub(super) fn write(&self, x: &[f64], inputs: &mut Inputs) {
        self.set(inputs, |free, i| free.to_value(x[i]));
    }

    /// The change of the inputs along a direction of the variables.
    ///
    /// # Panics
    /// If there are fewer numbers than variables, or inputs with another number of nodes.
    pub fn push_forward(&self, x: &[f64], direction: &[f64], change: &mut Inputs) {
        self.set(change, |free, i| free.slope(x[i]) * direction[i]);
    }

    /// Adds to the product of a Hessian with a direction the part that logarithmic variables contribute: their d²value/dx² equals their slope, so that it is
    /// dJ/dx times the direction.
    ///
    /// # Panics
    /// If there are fewer numbers than variables.
    pub fn add_curvature(&self, direction: &[f64], gradient: &[f64], product: &mut [f64]) {
        for (_, range) in self.parts().filter(|(free, _)| free.logarithm) {
            range.for_each(|i| product[i] += gradient[i] * direction[i]);
        }
    }

    /// Sets the free quantities to the given values or changes.
    fn set(&self, inputs: &mut Inputs, of: impl Fn(&Free, usize) -> f64) {
        for ((free, range), knots) in self.parts().zip(&self.knots) {
            let value = |k: usize| of(free, range.start + k);
            match free.quantity {
                Quantity::Control(control)
                | Quantity::LinearControl(control, _)
                | Quantity::PiecewiseControl(control, _)
                | Quantity::SplineControl(control, _) => {
                    for node in 0..self.shares.len() {
                        let sum = self.weights((free, knots), node).map(|(knot, weight)| weight * value(knot)).sum();
                        inputs.controls[(control.index(), node)] = sum;
                    }
                }
                Quantity::Design(design) => inputs.design[design.index()] = value(0),
                Quantity::Coordinate(q) => inputs.start.set_coordinate(q, value(0)),
                Quantity::Rate(q) => inputs.start.set_rate(q, value(0)),
                Quantity::Duration => {
                    inputs.grid.steps.iter_mut().zip(&self.steps).for_each(|(dt, share)| *dt = share * value(0));
                }
                Quantity::StepLength(node) => inputs.grid.steps[node - 1] = value(0),
            }
        }
    }

    /// dJ/dx from the derivatives with respect to the inputs: the exact transpose of [`apply`](Self::apply).
    ///
    /// # Panics
    /// As [`push_forward`](Self::push_forward).
    pub fn pull_back(&self, x: &[f64], of: &Gradient, gradient: &mut [f64]) {
        gradient.fill(0.0);
        for ((free, range), knots) in self.parts().zip(&self.knots) {
            let g = &mut gradient[range.clone()];
            match free.quantity {
                Quantity::Control(control)
                | Quantity::LinearControl(control, _)
                | Quantity::PiecewiseControl(control, _)
                | Quantity::SplineControl(control, _) => {
                    for node in 0..self.shares.len() {
                        let row = of.controls[(control.index(), node)];
                        self.weights((free, knots), node).for_each(|(knot, weight)| g[knot] += weight * row);
                    }
                }
                Quantity::Design(design) => g[0] = of.design[design.index()],
                Quantity::Coordinate(q) => g[0] = of.start.q()[q.index()],
                Quantity::Rate(q) => g[0] = of.start.rate()[q.index()],
                Quantity::Duration => g[0] = of.steps.iter().zip(&self.steps).map(|(dt, share)| dt * share).sum(),
                Quantity::StepLength(node) => g[0] = of.steps[node - 1],
            }
            g.iter_mut().zip(&x[range]).for_each(|(g, x)| *g *= free.slope(*x));
        }
    }

    /// The knots within a range that determine the control at a node, as positions in the range, with their weights.
    fn weights(&self, (of, knots): (&Free, &Range<usize>), node: usize) -> impl Iterator<Item = (usize, f64)> + use<> {
        let [before, after] = self.between;
        let share = before + (after - before) * self.shares[node];
        let all = match of.quantity {
            Quantity::LinearControl(_, knots) => {
                let place = share.clamp(0.0, 1.0) * (knots - 1) as f64;
                let left = (place as usize).min(knots - 2);
                let right = place - left as f64;
                [(left, 1.0 - right), (left + 1, right), (0, 0.0), (0, 0.0)]
            }
            Quantity::PiecewiseControl(_, pieces) => {
                // A node at the end of a piece, up to rounding, belongs to the next piece.
                let place = share.clamp(0.0, 1.0) * pieces as f64 * (1.0 + 1e-12);
                only((place as usize).min(pieces - 1))
            }
            Quantity::SplineControl(_, coefficients) => {
                let (first, weights) = cubic(share, coefficients);
                [0, 1, 2, 3].map(|k| (first + k, weights[k]))
            }
            _ => only(knots.start + node),
        };
        let Range { start, end } = *knots;
        let is_one = move |(knot, weight): &(usize, f64)| *weight != 0.0 && (start..end).contains(knot);
        all.into_iter().filter(is_one).map(move |(knot, weight)| (knot - start, weight))
    }
}

/// A single knot with weight 1.
fn only(knot: usize) -> [(usize, f64); 4] {
    [(knot, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)]
}

fn require(holds: bool, what: impl Fn() -> String, value: f64, must_be: &'static str) -> Result<(), Error> {
    if holds { Ok(()) } else { Err(Error::Parameter { what: what(), value, must_be }) }
}
