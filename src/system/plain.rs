//! The plain formulas of elements and costs, evaluated on any number type.
//!
//! Real and dual numbers are represented by [`Slope`]s for elements, and dual and hyper-dual numbers by [`Wide`] ones for costs, which other parts of the
//! library need in any case. So every formula is compiled for fewer number types.

use nalgebra::DMatrix;
use num_dual::Dual64;

use super::cost::{CostFactors, Costs, PlacedCost, Weights};
use super::formula::{
    AnyCost, AnyElement, Batch, ElementKind, NodeValues, NodeView, OnNumbers, PlacedElement, Sums, Values, Wide,
};
use crate::number::{Family, Hyper, Real, Slope, slope, with_slope};
use crate::program::Symbol;
use crate::{Cx, Scalar, System};

/// A formula for one number type: evaluated with this type, or with numbers that contain it.
enum Plain<Direct, Lifted> {
    Direct(Direct),
    Lifted(Lifted),
}

type OfElements<'a, R> = Plain<&'a dyn OnNumbers<R>, &'a dyn OnNumbers<Slope>>;
type OfCosts<'a, R> = Plain<&'a dyn Values<R>, &'a dyn Values<Wide<Slope>>>;

struct OfElement<'a>(&'a dyn AnyElement);

impl<'a> Family for OfElement<'a> {
    type Of<R: Real> = OfElements<'a, R>;

    fn real(self) -> OfElements<'a, f64> {
        Plain::Lifted(self.0)
    }
    fn complex(self) -> OfElements<'a, Cx> {
        Plain::Direct(self.0)
    }
    fn dual(self) -> OfElements<'a, Dual64> {
        Plain::Lifted(self.0)
    }
    fn hyper(self) -> OfElements<'a, Hyper> {
        Plain::Direct(self.0)
    }
}

struct OfCost<'a>(&'a dyn AnyCost);

impl<'a> Family for OfCost<'a> {
    type Of<R: Real> = OfCosts<'a, R>;

    fn real(self) -> OfCosts<'a, f64> {
        Plain::Direct(self.0)
    }
    fn complex(self) -> OfCosts<'a, Cx> {
        Plain::Direct(self.0)
    }
    fn dual(self) -> OfCosts<'a, Dual64> {
        Plain::Lifted(self.0)
    }
    fn hyper(self) -> OfCosts<'a, Hyper> {
        Plain::Lifted(self.0)
    }
}

/// Adds every cost at one node, multiplied by its weight and factor, to J (0) or to the output that it belongs to.
pub(super) fn add_costs<R: Real>(
    costs: &Costs,
    (at, weights): (&NodeView<R>, &Weights<R>),
    factors: &CostFactors,
    add: &mut dyn FnMut(usize, R),
) {
    let mut lifted: Option<NodeValues<Wide<Slope>>> = None;
    for item in costs.items_here(weights.node(), factors) {
        let factor = factors.here(item.output, weights.event());
        let Some(weight) = weights.of(item.sum).filter(|_| factor != 0.0) else { continue };
        if (0..R::PARTS).all(|part| weight.part(part) == 0.0) {
            continue;
        }
        let value = match R::of(OfCost(&*item.of.formula)) {
            Plain::Direct(cost) => value(item, cost, at),
            Plain::Lifted(cost) => {
                let point = lifted.get_or_insert_with(|| NodeValues::of_costs(at, lift));
                lower(value(item, cost, &point.view()))
            }
        };
        add(item.output, value * weight * factor);
    }
}

/// The value of the function of an event; 0 if there is none.
pub(super) fn event_value<R: Real>(costs: &Costs, event: usize, at: &NodeView<R>) -> R {
    let Some(item) = costs.of_event(event) else { return R::zero() };
    match R::of(OfCost(&*item.of.formula)) {
        Plain::Direct(cost) => value(item, cost, at),
        Plain::Lifted(cost) => lower(value(item, cost, &NodeValues::of_costs(at, lift).view())),
    }
}

/// The value of a cost.
fn value<R: Scalar>(item: &PlacedCost, cost: &dyn Values<R>, at: &NodeView<R>) -> R {
    let mut result = R::zero();
    cost.values(&|slot| item.of.to.read(at, slot), &mut |value| result = value);
    result
}

fn lift<R: Real>(x: R) -> Wide<Slope> {
    let [re, eps1, eps2, mixed] = std::array::from_fn(|part| if part < R::PARTS { x.part(part) } else { 0.0 });
    let wide = Wide::from_re(with_slope(re, eps1));
    if eps2 == 0.0 && mixed == 0.0 { wide } else { Wide { eps: wide.derivative(0).eps * with_slope(eps2, mixed), ..wide } }
}

fn lower<R: Real>(x: Wide<Slope>) -> R {
    let [re, eps] = [x.re, x.eps.0.map_or(Slope::from(0.0), |eps| eps[0])];
    let mut lowered = R::from(re.re);
    [slope(&re), eps.re, slope(&eps)].into_iter().zip(1..R::PARTS).for_each(|(x, part)| lowered.add_to_part(part, x));
    lowered
}

fn lift_to_slope<R: Real>(x: R) -> Slope {
    with_slope(x.part(0), if R::PARTS > 1 { x.part(1) } else { 0.0 })
}

fn lower_slope<R: Real>(x: &Slope) -> R {
    let mut lowered = R::from(Scalar::re(x));
    if R::PARTS > 1 {
        lowered.add_to_part(1, slope(x));
    }
    lowered
}

/// Adds the contributions of all elements of some batches to 𝓛_v, 𝓛_q + Q and dΦ/dt.
pub(super) fn add_sums<'a, R: Real>(batches: impl Iterator<Item = &'a Batch>, at: &NodeView<R>, sums: &mut Sums<R>) {
    let mut lifted: Option<(NodeValues<Slope>, Sums<Slope>)> = None;
    for item in batches.flat_map(|batch| &batch.items) {
        match R::of(OfElement(&*item.formula)) {
            Plain::Direct(formula) => item.add(formula, at, sums),
            Plain::Lifted(formula) => {
                let start = || (NodeValues::of_equations(at, lift_to_slope), Sums::new(at.q.len(), at.sigma.len()));
                let (point, own) = lifted.get_or_insert_with(start);
                item.add(formula, &point.view(), own);
            }
        }
    }
    if let Some((_, own)) = lifted {
        sums.all.iter_mut().zip(&own.all).for_each(|(sum, own)| *sum += lower_slope::<R>(own));
    }
}

/// Writes Φ of all constraints.
pub(super) fn write_phi<'a, R: Real>(batches: impl Iterator<Item = &'a Batch>, at: &NodeView<R>, phi: &mut [R]) {
    let mut lifted: Option<NodeValues<Slope>> = None;
    let is_constraint = |item: &&PlacedElement| !item.to.sigma.is_empty();
    for item in batches.flat_map(|batch| &batch.items).filter(is_constraint) {
        match R::of(OfElement(&*item.formula)) {
            Plain::Direct(formula) => item.write_phi(formula, at, |j, x| phi[j] = x),
            Plain::Lifted(formula) => {
                let point = lifted.get_or_insert_with(|| NodeValues::of_equations(at, lift_to_slope));
                item.write_phi(formula, &point.view(), |j, x| phi[j] = lower_slope(&x));
            }
        }
    }
}

/// A function that adds the contributions of some elements.
pub type ElementSums = fn(&System, &NodeView<Dual64>, &mut Sums<Dual64>);

impl System {
    /// Evaluates 𝓛_v, 𝓛_q + Q and dΦ/dt by the plain formulas, on any number type.
    pub(crate) fn plain_sums<R: Real>(&self, at: &NodeView<R>, sums: &mut Sums<R>) {
        sums.clear();
        add_sums(self.0.batches.0.iter(), at, sums);
    }

    /// The contributions of the kinetic energies alone: T_v and T_q.
    pub(crate) fn kinetic_sums<R: Real>(&self, at: &NodeView<R>, sums: &mut Sums<R>) {
        sums.clear();
        add_sums(self.0.batches.of_kind(ElementKind::Kinetic), at, sums);
    }

    /// T and V.
    pub(crate) fn energies(&self, at: &NodeView<f64>) -> [f64; 2] {
        let of = |kind| self.0.batches.of_kind(kind).flat_map(|batch| &batch.items).map(|item| item.energy(at)).sum();
        [ElementKind::Kinetic, ElementKind::Potential].map(of)
    }

    /// Φ(q, t).
    pub(crate) fn phi(&self, at: &NodeView<f64>, phi: &mut [f64]) {
        let constraints = self.0.batches.items().filter(|item| !item.to.sigma.is_empty());
        constraints.for_each(|item| item.phi(at, |j, x| phi[j] = x));
    }

    /// Φ(q, t) on any number type.
    pub(crate) fn phi_on<R: Real>(&self, at: &NodeView<R>, phi: &mut [R]) {
        write_phi(self.0.batches.0.iter(), at, phi);
    }

    /// T, V, Q and Φ of all elements, for recording.
    pub(crate) fn symbols(&self, at: &NodeView<Symbol>) -> Vec<Symbol> {
        let mut all = Vec::new();
        for item in self.0.batches.items() {
            Values::<Symbol>::values(&*item.formula, &|slot| item.to.read(at, slot), &mut |value| all.push(value));
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
