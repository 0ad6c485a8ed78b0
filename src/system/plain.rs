//! The plain formulas of a batch, on the numbers that are asked for.
//!
//! Dual numbers are parts of hyper-dual ones, which accelerations need anyway: so every formula is compiled for one number type less.

use num_dual::Dual64;

use super::batch::{AnyBatch, PlainBatch, Sums};
use super::cost::{AnyCosts, PlainCosts};
use super::jet::{Hyper, hyper, hyper_parts};
use super::view::NodeView;
use crate::Cx;
use crate::number::{Family, Real};

/// The formulas of a batch, for numbers of one type.
pub(super) enum Plain<'a, R: Real> {
    Direct(&'a dyn PlainBatch<R>),
    ByHyper(&'a dyn PlainBatch<Hyper>),
}

struct Elements<'a>(&'a dyn AnyBatch);

impl<'a> Family for Elements<'a> {
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
}

struct OfCosts<'a>(&'a dyn AnyCosts);

impl<'a> Family for OfCosts<'a> {
    type Of<R: Real> = &'a dyn PlainCosts<R>;

    fn real(self) -> &'a dyn PlainCosts<f64> {
        self.0
    }
    fn complex(self) -> &'a dyn PlainCosts<Cx> {
        self.0
    }
    fn dual(self) -> &'a dyn PlainCosts<Dual64> {
        self.0
    }
}

pub(super) fn plain_costs<R: Real>(costs: &dyn AnyCosts) -> &dyn PlainCosts<R> {
    R::of(OfCosts(costs))
}

/// A point in hyper-dual numbers.
pub(super) struct HyperPoint {
    pub q: Vec<Hyper>,
    pub v: Vec<Hyper>,
    pub sigma: Vec<Hyper>,
    pub u: Vec<Hyper>,
    pub t: Hyper,
    pub design: Vec<Hyper>,
}

impl HyperPoint {
    /// With the derivative parts along ε₁.
    fn of<R: Real>(at: &NodeView<R>) -> Self {
        let lift = |x: &R| hyper(x.part(0), x.part(1), 0.0, 0.0);
        let list = |x: &[R]| x.iter().map(lift).collect::<Vec<Hyper>>();
        let [q, v, sigma, u, design] = [at.q, at.v, at.sigma, at.u, at.design].map(list);
        HyperPoint { q, v, sigma, u, t: lift(&at.t), design }
    }

    pub fn view(&self) -> NodeView<'_, Hyper> {
        NodeView::of_equations([&self.q, &self.v, &self.sigma], (&self.u, self.t, &self.design))
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
pub(super) fn add_sums<'a, R: Real>(batches: impl Iterator<Item = &'a dyn AnyBatch>, at: &NodeView<R>, sums: &mut Sums<R>) {
    let mut lifted: Option<(HyperPoint, Sums<Hyper>)> = None;
    for batch in batches {
        match R::of(Elements(batch)) {
            Plain::Direct(batch) => batch.add(at, sums),
            Plain::ByHyper(batch) => {
                let start = || (HyperPoint::of(at), Sums::new(at.q.len(), at.sigma.len()));
                let (point, own) = lifted.get_or_insert_with(start);
                batch.add(&point.view(), own);
            }
        }
    }
    if let Some((_, own)) = lifted {
        add_back(&mut sums.all, &own.all);
    }
}

/// Writes Φ of all constraints.
pub(super) fn write_phi<'a, R: Real>(batches: impl Iterator<Item = &'a dyn AnyBatch>, at: &NodeView<R>, phi: &mut [R]) {
    let mut lifted: Option<(HyperPoint, Vec<Hyper>)> = None;
    for batch in batches {
        match R::of(Elements(batch)) {
            Plain::Direct(batch) => batch.phi(at, phi),
            Plain::ByHyper(batch) => {
                let start = || (HyperPoint::of(at), vec![hyper(0.0, 0.0, 0.0, 0.0); phi.len()]);
                let (point, own) = lifted.get_or_insert_with(start);
                batch.phi(&point.view(), own);
            }
        }
    }
    if let Some((_, own)) = lifted {
        phi.fill(R::zero());
        add_back(phi, &own);
    }
}
