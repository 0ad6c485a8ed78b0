//! Holonomic constraints of lists: from Φ(q, t) alone to σᵀ dΦ/dt and all its derivatives.
//!
//! Seed q with v and t with 1 in a dual number, q + ε v, t + ε: then Φ's ε-part is dΦ/dt = Φ_q v + Φ_t. Make these numbers the
//! inner numbers of a dual number in q, and one evaluation of Φ gives
//!
//! ```text
//!   real part:  Φ, Φ_q          ε-part:  dΦ/dt, (dΦ/dt)_q
//! ```

use nalgebra::SVector;
use num_dual::{Derivative, DualSVec};

use super::differentiated::Component;
use super::kind::{ElementKind, Number};
use super::on_numbers::{AnyElement, OnNumbers, Read, SEEDS, Values, Wide, by_columns, seeded, with_lists, with_memory};
use super::shape::{Shape, Slot};
use crate::Scalar;
use crate::model::element::ListConstraint;

/// A number with its rate.
type Moving<R> = DualSVec<R, 1>;

/// A holonomic constraint of m equations on n coordinates with p constants: 𝓛_v = Φ_qᵀσ, 𝓛_q = (dΦ/dt)_qᵀσ.
pub struct ListHolonomic<E> {
    pub constraint: E,
    pub n: usize,
    pub m: usize,
    pub p: usize,
}

impl<E: ListConstraint, S: Scalar> Values<S> for ListHolonomic<E> {
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S)) {
        let lists: [(fn(usize) -> Slot, usize); 2] = [(Slot::Q, self.n), (Slot::B, self.p)];
        with_lists(read, lists, &mut |[q, b]| {
            with_memory(self.m, &mut |phi: &mut [S]| {
                self.constraint.phi(q, b, read(Slot::T), phi);
                phi.iter().for_each(|phi| put(*phi));
            });
        });
    }
}

impl<E: ListConstraint, R: Number> OnNumbers<R> for ListHolonomic<E> {
    fn first(&self, read: Read<R>, add: &mut dyn FnMut(Component, R)) {
        first(self, self.n, read, add);
    }

    fn phi(&self, read: Read<R>, put: &mut dyn FnMut(usize, R)) {
        phi(self, read, put);
    }
}

impl<E: ListConstraint> AnyElement for ListHolonomic<E> {
    fn kind(&self) -> ElementKind {
        ElementKind::Holonomic
    }

    fn blocks(&self, read: Read<f64>, add: &mut dyn FnMut(Component, f64), blocks: &mut [f64]) {
        by_columns(self, read, add, blocks);
    }

    fn shape(&self) -> Shape {
        Shape { n: self.n, m: self.m, k: 0, p: self.p }
    }
}

/// Adds dΦ/dt, Φ_qᵀσ and (dΦ/dt)_qᵀσ.
fn first<R: Number>(formula: &dyn Values<Wide<Moving<R>>>, n: usize, read: Read<R>, add: &mut dyn FnMut(Component, R)) {
    for first in (0..n.max(1)).step_by(SEEDS) {
        let with_rate = |x, rate| Wide::from_re(Moving::new(x, Derivative::some(SVector::from([rate]))));
        let moving = |slot| match slot {
            Slot::Q(i) => seeded(with_rate(read(slot), read(Slot::V(i))), (first..n).take(SEEDS).position(|at| at == i)),
            Slot::T => with_rate(read(slot), R::one()),
            _ => Wide::from_re(Moving::from_re(read(slot))),
        };
        let rate = |x: &Moving<R>| x.eps.0.map_or(R::zero(), |eps| eps[0]);
        let mut equations = 0..;
        formula.values(&moving, &mut |phi| {
            let Some(j) = equations.next() else { return };
            if first == 0 {
                add(Component::Equation(j), rate(&phi.re));
            }
            let Some(slopes) = phi.eps.0 else { return };
            let sigma = read(Slot::Sigma(j));
            for (i, slope) in (first..n).zip(&slopes) {
                add(Component::Momentum(i), slope.re * sigma);
                add(Component::Force(i), rate(slope) * sigma);
            }
        });
    }
}

/// Writes Φ, on the numbers for which the formula is compiled anyway.
fn phi<R: Number>(formula: &dyn Values<Wide<Moving<R>>>, read: Read<R>, put: &mut dyn FnMut(usize, R)) {
    let mut equations = 0..;
    formula.values(&|slot| Wide::from_re(Moving::from_re(read(slot))), &mut |phi| {
        equations.next().into_iter().for_each(|j| put(j, phi.re.re));
    });
}
