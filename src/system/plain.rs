//! The plain formulas of elements and costs, evaluated on any number type.
//!
//! Dual numbers are represented by [`Slope`]s, with which formulas are verified, or, in costs, by hyper-dual numbers, which accelerations need in any
//! case. So every formula is compiled for one number type fewer.

use nalgebra::DMatrix;
use num_dual::Dual64;

use super::System;
use super::batch::{Batch, Sums};
use super::cost_factors::CostFactors;
use super::costs::Costs;
use super::item::PlacedElement;
use super::jet::Number;
use super::plain_cost::{AnyCost, PlainCost};
use super::typed::{AnyElement, OnNumbers, Values};
use super::view::{NodeValues, NodeView};
use super::weights::Weights;
use crate::number::{Family, Hyper, Real, Slope, hyper, hyper_parts, slope, with_slope};
use crate::program::Symbol;
use crate::{Cx, Scalar};

/// The formula of an element for one number type.
enum Plain<'a, R: Real> {
    Direct(&'a dyn OnNumbers<R>),
    BySlope(&'a dyn OnNumbers<Slope>),
}

struct OfElement<'a>(&'a dyn AnyElement);

impl<'a> Family for OfElement<'a> {
    type Of<R: Real> = Plain<'a, R>;

    fn real(self) -> Plain<'a, f64> {
        Plain::Direct(self.0)
    }
    fn complex(self) -> Plain<'a, Cx> {
        Plain::Direct(self.0)
    }
    fn dual(self) -> Plain<'a, Dual64> {
        Plain::BySlope(self.0)
    }
    fn hyper(self) -> Plain<'a, Hyper> {
        Plain::Direct(self.0)
    }
}

/// The formula of a cost for one number type.
enum PlainOfCost<'a, R: Real> {
    Direct(&'a dyn PlainCost<R>),
    ByHyper(&'a dyn PlainCost<Hyper>),
}

struct OfCost<'a>(&'a dyn AnyCost);

impl<'a> Family for OfCost<'a> {
    type Of<R: Real> = PlainOfCost<'a, R>;

    fn real(self) -> PlainOfCost<'a, f64> {
        PlainOfCost::Direct(self.0)
    }
    fn complex(self) -> PlainOfCost<'a, Cx> {
        PlainOfCost::Direct(self.0)
    }
    fn dual(self) -> PlainOfCost<'a, Dual64> {
        PlainOfCost::ByHyper(self.0)
    }
    fn hyper(self) -> PlainOfCost<'a, Hyper> {
        PlainOfCost::Direct(self.0)
    }
}

/// Adds every cost at one node, multiplied by its weight and factor, to J (0) or to the output that it belongs to.
pub(super) fn add_costs<R: Real>(
    costs: &Costs,
    (at, weights): (&NodeView<R>, &Weights<R>),
    factors: &CostFactors,
    add: &mut dyn FnMut(usize, R),
) {
    let mut lifted: Option<NodeValues<Hyper>> = None;
    for item in costs.items_here(weights.node(), factors.some()) {
        let factor = factors.of(item.output);
        let Some(weight) = weights.of(item.sum).filter(|_| factor != 0.0) else { continue };
        if (0..R::PARTS).all(|part| weight.part(part) == 0.0) {
            continue;
        }
        let value = match R::of(OfCost(&*item.cost)) {
            PlainOfCost::Direct(cost) => item.value(cost, at),
            PlainOfCost::ByHyper(cost) => {
                let point = lifted.get_or_insert_with(|| NodeValues::of_costs(at, lift));
                lower(item.value(cost, &point.view()))
            }
        };
        add(item.output, value * weight * factor);
    }
}

fn lift<R: Real>(x: R) -> Hyper {
    hyper(x.part(0), x.part(1), 0.0, 0.0)
}

fn lower<R: Real>(x: Hyper) -> R {
    let mut lowered = R::from(x.re());
    lowered.add_to_part(1, hyper_parts(&x)[1]);
    lowered
}

fn lift_to_slope<R: Real>(x: R) -> Slope {
    with_slope(x.part(0), x.part(1))
}

fn add_back<R: Real, S: Number>(to: &mut [R], from: &[S], along: fn(&S) -> f64) {
    for (to, from) in to.iter_mut().zip(from) {
        to.add_to_part(0, Scalar::re(from));
        to.add_to_part(1, along(from));
    }
}

/// Adds the contributions of all elements of some batches to 𝓛_v, 𝓛_q + Q and dΦ/dt.
pub(super) fn add_sums<'a, R: Real>(batches: impl Iterator<Item = &'a Batch>, at: &NodeView<R>, sums: &mut Sums<R>) {
    let mut lifted: Option<(NodeValues<Slope>, Sums<Slope>)> = None;
    for item in batches.flat_map(|batch| &batch.items) {
        match R::of(OfElement(&*item.formula)) {
            Plain::Direct(formula) => item.add(formula, at, sums),
            Plain::BySlope(formula) => {
                let start = || (NodeValues::of_equations(at, lift_to_slope), Sums::new(at.q.len(), at.sigma.len()));
                let (point, own) = lifted.get_or_insert_with(start);
                item.add(formula, &point.view(), own);
            }
        }
    }
    if let Some((_, own)) = lifted {
        add_back(&mut sums.all, &own.all, slope);
    }
}

/// Writes Φ of all constraints.
pub(super) fn write_phi<'a, R: Real>(batches: impl Iterator<Item = &'a Batch>, at: &NodeView<R>, phi: &mut [R]) {
    let mut lifted: Option<(NodeValues<Slope>, Vec<Slope>)> = None;
    let is_constraint = |item: &&PlacedElement| !item.sigma.is_empty();
    for item in batches.flat_map(|batch| &batch.items).filter(is_constraint) {
        match R::of(OfElement(&*item.formula)) {
            Plain::Direct(formula) => item.write_phi(formula, at, phi),
            Plain::BySlope(formula) => {
                let start = || (NodeValues::of_equations(at, lift_to_slope), vec![with_slope(0.0, 0.0); phi.len()]);
                let (point, own) = lifted.get_or_insert_with(start);
                item.write_phi(formula, &point.view(), own);
            }
        }
    }
    if let Some((_, own)) = lifted {
        phi.fill(R::zero());
        add_back(phi, &own, slope);
    }
}

/// A function that adds the contributions of some elements.
pub type ElementSums = fn(&System, &NodeView<Dual64>, &mut Sums<Dual64>);

impl System {
    /// T, V, Q and Φ of all elements, for recording.
    pub(crate) fn symbols(&self, at: &NodeView<Symbol>) -> Vec<Symbol> {
        let mut all = Vec::new();
        for item in self.batches.iter().flat_map(|batch| &batch.items) {
            Values::<Symbol>::values(&*item.formula, &|slot| item.read(at, slot), &mut |value| all.push(value));
        }
        all
    }

    /// 𝓛_v, 𝓛_q + Q and dΦ/dt of some elements, differentiated with respect to one kind of arguments by dual numbers; one column per argument.
    pub(crate) fn columns(
        &self,
        of: ElementSums,
        at: &mut NodeValues<Dual64>,
        by: fn(&mut NodeValues<Dual64>) -> &mut Vec<Dual64>,
    ) -> [DMatrix<f64>; 3] {
        let count = by(at).len();
        let mut found = [self.n(), self.n(), self.m()].map(|rows| DMatrix::zeros(rows, count));
        let mut sums = Sums::new(self.n(), self.m());
        for k in 0..count {
            by(at)[k].eps = 1.0;
            of(self, &at.view(), &mut sums);
            by(at)[k].eps = 0.0;
            for (matrix, values) in found.iter_mut().zip([sums.l_v(), sums.force(), sums.phi_dot()]) {
                matrix.column_mut(k).iter_mut().zip(values).for_each(|(entry, value)| *entry = value.eps);
            }
        }
        found
    }
}
