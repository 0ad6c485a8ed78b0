//! Holonomic constraints: from Φ(q, t) alone to σᵀ dΦ/dt and all its derivatives.
//!
//! Seed q with v and t with 1 in a dual number, q + ε v, t + ε: then Φ's ε-part is dΦ/dt = Φ_q v + Φ_t. Make these numbers the
//! inner numbers of a second-order dual number in q, and one evaluation of Φ gives
//!
//! ```text
//!   real part:  Φ, Φ_q, Φ_qq          ε-part:  dΦ/dt, (dΦ/dt)_q, (dΦ/dt)_qq
//! ```

use nalgebra::Const;
use num_dual::{Derivative, Dual, Dual64, DualSVec, HyperDualVec};

use super::differentiated::Component;
use super::kind::{ElementKind, Number};
use super::on_numbers::{AnyElement, By, OnNumbers, Read, Values, WIDE, by_columns, gradient, parts, place};
use super::shape::{Shape, Slot};
use crate::Scalar;

/// The formula Φ(q, t; b), which reads its arguments itself.
pub trait ConstraintFormula: Send + Sync + 'static {
    fn phi<S: Scalar>(&self, shape: Shape, read: Read<S>, put: &mut dyn FnMut(S));
}

/// A holonomic constraint of m equations on n coordinates with p constants: 𝓛_v = Φ_qᵀσ, 𝓛_q = (dΦ/dt)_qᵀσ. `WIDTH` derivatives
/// are computed at once.
pub struct Holonomic<E, const WIDTH: usize> {
    pub constraint: E,
    pub n: usize,
    pub m: usize,
    pub p: usize,
}

impl<E: ConstraintFormula, S: Scalar, const WIDTH: usize> Values<S> for Holonomic<E, WIDTH> {
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S)) {
        self.constraint.phi(self.shape(), read, put);
    }
}

impl<E: ConstraintFormula, R: Number, const WIDTH: usize> OnNumbers<R> for Holonomic<E, WIDTH> {
    fn first(&self, read: Read<R>, add: &mut dyn FnMut(Component, R)) {
        first::<R, WIDTH>(self, self.n, read, add);
    }

    fn phi(&self, read: Read<R>, put: &mut dyn FnMut(usize, R)) {
        phi::<R, WIDTH>(self, read, put);
    }
}

impl<E: ConstraintFormula, const WIDTH: usize> AnyElement for Holonomic<E, WIDTH> {
    fn kind(&self) -> ElementKind {
        ElementKind::Holonomic
    }

    fn blocks(&self, read: Read<f64>, add: &mut dyn FnMut(Component, f64), blocks: &mut [f64]) {
        if WIDTH > WIDE {
            return by_columns(self, read, add, blocks);
        }
        second::<WIDTH>(self, (self.n, self.m), read, add, blocks);
    }

    fn phi_q(&self, read: Read<f64>, put: &mut dyn FnMut(usize, usize, f64)) {
        gradient::<f64, WIDTH>(self, (By::Q, self.n), read, &mut |_, _| (), put);
    }

    fn shape(&self) -> Shape {
        Shape { n: self.n, m: self.m, k: 0, p: self.p }
    }
}

/// Adds dΦ/dt, Φ_qᵀσ and (dΦ/dt)_qᵀσ.
fn first<R: Number, const WIDTH: usize>(
    formula: &dyn Values<Dual<DualSVec<R, WIDTH>>>,
    n: usize,
    read: Read<R>,
    add: &mut dyn FnMut(Component, R),
) {
    for first in parts::<WIDTH>(n) {
        let moving = |slot| {
            let x = DualSVec::from_re(read(slot));
            match slot {
                Slot::Q(i) => {
                    let x = place::<WIDTH>(slot, By::Q, first).map_or(x, |k| x.derivative(k));
                    Dual::new(x, DualSVec::from_re(read(Slot::V(i))))
                }
                Slot::T => Dual::new(x, DualSVec::from_re(R::one())),
                _ => Dual::from_re(x),
            }
        };
        let mut equations = 0..;
        formula.values(&moving, &mut |phi| {
            let Some(j) = equations.next() else { return };
            if first == 0 {
                add(Component::Equation(j), phi.eps.re);
            }
            let sigma = read(Slot::Sigma(j));
            let mut add_all = |of: fn(usize) -> Component, slopes: Derivative<R, _, _>| {
                if let Some(slopes) = slopes.0 {
                    (first..n).zip(&slopes).for_each(|(i, slope)| add(of(i), *slope * sigma));
                }
            };
            add_all(Component::Momentum, phi.re.eps);
            add_all(Component::Force, phi.eps.eps);
        });
    }
}

/// Writes Φ, on the numbers for which the formula is compiled anyway.
fn phi<R: Number, const WIDTH: usize>(
    formula: &dyn Values<Dual<DualSVec<R, WIDTH>>>,
    read: Read<R>,
    put: &mut dyn FnMut(usize, R),
) {
    let mut equations = 0..;
    formula.values(&|slot| Dual::from_re(DualSVec::from_re(read(slot))), &mut |phi| {
        equations.next().into_iter().for_each(|j| put(j, phi.re.re));
    });
}

/// As [`first`], with σᵀΦ_qq, σᵀ(dΦ/dt)_qq, Φ_q and (dΦ/dt)_q.
fn second<const WIDTH: usize>(
    formula: &dyn Values<HyperDualVec<Dual64, Const<WIDTH>, Const<WIDTH>>>,
    (n, m): (usize, usize),
    read: Read<f64>,
    add: &mut dyn FnMut(Component, f64),
    blocks: &mut [f64],
) {
    blocks.fill(0.0);
    let (phi_qq, rest) = blocks.split_at_mut(n * n);
    let (phi_dot_qq, rest) = rest.split_at_mut(n * n);
    let (phi_q, phi_dot_q) = rest.split_at_mut(m * n);
    for (first, column) in parts::<WIDTH>(n).flat_map(|i| parts::<WIDTH>(n).map(move |j| (i, j))) {
        let moving = |slot| {
            let rate = match slot {
                Slot::Q(i) => read(Slot::V(i)),
                Slot::T => 1.0,
                _ => 0.0,
            };
            let x = HyperDualVec::<_, Const<WIDTH>, Const<WIDTH>>::from_re(Dual64::new(read(slot), rate));
            let x = place::<WIDTH>(slot, By::Q, first).map_or(x, |k| x.derivative1(k));
            place::<WIDTH>(slot, By::Q, column).map_or(x, |k| x.derivative2(k))
        };
        let mut equations = 0..;
        formula.values(&moving, &mut |phi| {
            let Some(j) = equations.next() else { return };
            let sigma = read(Slot::Sigma(j));
            if (first, column) == (0, 0) {
                add(Component::Equation(j), phi.re.eps);
            }
            if let Some(slopes) = phi.eps1.0.filter(|_| column == 0) {
                for (i, slope) in (first..n).zip(&slopes) {
                    add(Component::Momentum(i), slope.re * sigma);
                    add(Component::Force(i), slope.eps * sigma);
                    (phi_q[j * n + i], phi_dot_q[j * n + i]) = (slope.re, slope.eps);
                }
            }
            let Some(second) = phi.eps1eps2.0 else { return };
            for (i, row) in (first..n).zip(second.row_iter()) {
                for (k, x) in (column..n).zip(&row) {
                    phi_qq[i * n + k] += x.re * sigma;
                    phi_dot_qq[i * n + k] += x.eps * sigma;
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::SVector;

    use super::*;
    use crate::Constraint;
    use crate::number::{Slope, slope, with_slope};
    use crate::system::formula::Fixed;

    /// Φ = (x sin y, y² + t x): every derivative by hand.
    struct Sample;
    impl Constraint<2, 2> for Sample {
        fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _: &SVector<S, 0>, t: S) -> SVector<S, 2> {
            SVector::from([q[0] * q[1].sin(), q[1] * q[1] + t * q[0]])
        }
    }

    #[test]
    fn blocks_are_the_hand_derived_ones_for_any_number_of_derivatives_at_once() {
        let (x, y, dx, dy, t) = (0.7, 0.4, -1.3, 2.1, 0.9);
        let sigma = [1.5, -0.25];
        let read = |slot: Slot| match slot {
            Slot::Q(i) => [x, y][i],
            Slot::V(i) => [dx, dy][i],
            Slot::Sigma(j) => sigma[j],
            _ => t,
        };
        let (s, c) = f64::sin_cos(y);
        let expected = [
            [0.0, c * sigma[0], c * sigma[0], -x * s * sigma[0] + 2.0 * sigma[1]],
            [0.0, -s * dy * sigma[0], -s * dy * sigma[0], (-dx * s - x * c * dy) * sigma[0]],
            [s, x * c, t, 2.0 * y],
            [c * dy, dx * c - x * s * dy, 1.0, 2.0 * dy],
        ];
        let of_sums = |element: &dyn AnyElement| {
            let (mut sums, mut plain, mut blocks) = ([0.0; 6], [0.0; 6], [f64::NAN; 16]);
            let place = |of| match of {
                Component::Momentum(i) => i,
                Component::Force(i) => 2 + i,
                Component::Equation(j) => 4 + j,
            };
            element.blocks(&read, &mut |of, x| sums[place(of)] += x, &mut blocks);
            let lifted = |slot| with_slope(read(slot), 0.0);
            OnNumbers::<Slope>::first(element, &lifted, &mut |of, x| plain[place(of)] += x.re + slope(&x));
            (sums, plain, blocks)
        };
        let constraint = || Fixed::<Sample, 2, 2, 0, 0>(Sample);
        let one = Holonomic::<_, 1> { constraint: constraint(), n: 2, m: 2, p: 0 };
        let two = Holonomic::<_, 2> { constraint: constraint(), n: 2, m: 2, p: 0 };
        let four = Holonomic::<_, 4> { constraint: constraint(), n: 2, m: 2, p: 0 };
        for element in [&one as &dyn AnyElement, &two, &four] {
            let (sums, plain, blocks) = of_sums(element);
            let by_hand = [
                s * sigma[0] + t * sigma[1],
                x * c * sigma[0] + 2.0 * y * sigma[1],
                c * dy * sigma[0] + sigma[1],
                (dx * c - x * s * dy) * sigma[0] + 2.0 * dy * sigma[1],
                s * dx + x * c * dy,
                2.0 * y * dy + t * dx + x,
            ];
            for ((sum, plain), by_hand) in sums.iter().zip(plain).zip(by_hand) {
                assert!((sum - by_hand).abs() < 1e-15 && (plain - by_hand).abs() < 1e-15, "{sums:?} {plain:?}");
            }
            for (got, expected) in blocks.iter().zip(expected.as_flattened()) {
                assert!((got - expected).abs() < 1e-15, "{blocks:?}");
            }
        }
    }
}
