//! The plain formulas of elements and costs, on the numbers that are asked for.
//!
//! Dual numbers are parts of hyper-dual ones, which accelerations need anyway: so every formula is compiled for one number type less.

use num_dual::Dual64;

use super::batch::{Batch, Sums};
use super::cost::{AnyCosts, PlainCosts, Weights};
use super::item::PlacedElement;
use super::typed::{AnyElement, OnNumbers};
use super::view::NodeView;
use crate::Cx;
use crate::number::{Family, Hyper, Real, hyper, hyper_parts};

/// The formula of an element, for numbers of one type.
enum Plain<'a, R: Real> {
    Direct(&'a dyn OnNumbers<R>),
    ByHyper(&'a dyn OnNumbers<Hyper>),
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
        Plain::ByHyper(self.0)
    }
    fn hyper(self) -> Plain<'a, Hyper> {
        Plain::Direct(self.0)
    }
}

struct OfCosts<'a>(&'a dyn AnyCosts);

/// The costs of a batch, for numbers of one type.
enum PlainCost<'a, R: Real> {
    Direct(&'a dyn PlainCosts<R>),
    ByHyper(&'a dyn PlainCosts<Hyper>),
}

impl<'a> Family for OfCosts<'a> {
    type Of<R: Real> = PlainCost<'a, R>;

    fn real(self) -> PlainCost<'a, f64> {
        PlainCost::Direct(self.0)
    }
    fn complex(self) -> PlainCost<'a, Cx> {
        PlainCost::Direct(self.0)
    }
    fn dual(self) -> PlainCost<'a, Dual64> {
        PlainCost::ByHyper(self.0)
    }
    fn hyper(self) -> PlainCost<'a, Hyper> {
        PlainCost::Direct(self.0)
    }
}

/// Adds all costs of some batches at one node to the sums of J and of the outputs.
pub(super) fn add_costs<R: Real>(
    all: &[Box<dyn AnyCosts>],
    (at, weights): (&NodeView<R>, &Weights<R>),
    factors: &[f64],
    sums: &mut [R],
) {
    let mut lifted: Option<(HyperPoint, Weights<Hyper>, Vec<Hyper>)> = None;
    for costs in all {
        match R::of(OfCosts(costs.as_ref())) {
            PlainCost::Direct(costs) => costs.add(at, weights, factors, sums),
            PlainCost::ByHyper(costs) => {
                let start = || (HyperPoint::of_cost(at), weights.map(lift), vec![hyper(0.0, 0.0, 0.0, 0.0); sums.len()]);
                let (point, weights, own) = lifted.get_or_insert_with(start);
                costs.add(&point.view(), weights, factors, own);
            }
        }
    }
    if let Some((_, _, own)) = lifted {
        add_back(sums, &own);
    }
}

fn lift<R: Real>(x: R) -> Hyper {
    hyper(x.part(0), x.part(1), 0.0, 0.0)
}

fn lift_all<R: Real>(x: &[R]) -> Vec<Hyper> {
    x.iter().map(|x| lift(*x)).collect()
}

/// A point in hyper-dual numbers.
pub(super) struct HyperPoint {
    pub q: Vec<Hyper>,
    pub v: Vec<Hyper>,
    pub sigma: Vec<Hyper>,
    pub u: Vec<Hyper>,
    pub t: Hyper,
    pub design: Vec<Hyper>,
    /// p*, ṗ*, v̇, λ and u̇, for costs alone.
    pub of_costs: [Vec<Hyper>; 5],
}

impl HyperPoint {
    /// With the derivative parts along ε₁.
    fn of<R: Real>(at: &NodeView<R>) -> Self {
        let [q, v, sigma, u, design] = [at.q, at.v, at.sigma, at.u, at.design].map(lift_all);
        HyperPoint { q, v, sigma, u, t: lift(at.t), design, of_costs: Default::default() }
    }

    /// With what costs may depend on besides.
    fn of_cost<R: Real>(at: &NodeView<R>) -> Self {
        HyperPoint {
            of_costs: [at.p_star, at.p_star_dot, at.v_dot, at.lambda, at.u_dot].map(lift_all),
            ..HyperPoint::of(at)
        }
    }

    pub fn view(&self) -> NodeView<'_, Hyper> {
        let [p_star, p_star_dot, v_dot, lambda, u_dot] = &self.of_costs;
        let equations = NodeView::of_equations([&self.q, &self.v, &self.sigma], (&self.u, self.t, &self.design));
        NodeView { p_star, p_star_dot, v_dot, lambda, u_dot, ..equations }
    }
}

fn add_back<R: Real>(to: &mut [R], from: &[Hyper]) {
    for (to, from) in to.iter_mut().zip(from) {
        let [value, along, ..] = hyper_parts(from);
        to.add_to_part(0, value);
        to.add_to_part(1, along);
    }
}

/// Adds what all elements of some batches add to 𝓛_v, 𝓛_q + Q and dΦ/dt.
pub(super) fn add_sums<'a, R: Real>(batches: impl Iterator<Item = &'a Batch>, at: &NodeView<R>, sums: &mut Sums<R>) {
    let mut lifted: Option<(HyperPoint, Sums<Hyper>)> = None;
    for item in batches.flat_map(|batch| &batch.items) {
        match R::of(OfElement(&*item.formula)) {
            Plain::Direct(formula) => item.add(formula, at, sums),
            Plain::ByHyper(formula) => {
                let start = || (HyperPoint::of(at), Sums::new(at.q.len(), at.sigma.len()));
                let (point, own) = lifted.get_or_insert_with(start);
                item.add(formula, &point.view(), own);
            }
        }
    }
    if let Some((_, own)) = lifted {
        add_back(&mut sums.all, &own.all);
    }
}

/// Writes Φ of all constraints.
pub(super) fn write_phi<'a, R: Real>(batches: impl Iterator<Item = &'a Batch>, at: &NodeView<R>, phi: &mut [R]) {
    let mut lifted: Option<(HyperPoint, Vec<Hyper>)> = None;
    let is_constraint = |item: &&PlacedElement| !item.sigma.is_empty();
    for item in batches.flat_map(|batch| &batch.items).filter(is_constraint) {
        match R::of(OfElement(&*item.formula)) {
            Plain::Direct(formula) => item.write_phi(formula, at, phi),
            Plain::ByHyper(formula) => {
                let start = || (HyperPoint::of(at), vec![hyper(0.0, 0.0, 0.0, 0.0); phi.len()]);
                let (point, own) = lifted.get_or_insert_with(start);
                item.write_phi(formula, &point.view(), own);
            }
        }
    }
    if let Some((_, own)) = lifted {
        phi.fill(R::zero());
        add_back(phi, &own);
    }
}
