//! An element behind a trait that hides its type, and the memory in which formulas of lists find their arguments.
//!
//! Formulas of fixed lengths are evaluated on numbers that carry the derivatives with respect to all coordinates of the element. For lists their number is
//! unknown to the compiler: the numbers carry [`SEEDS`] derivatives at once, and the formula is evaluated several times.

use num_dual::{DualSVec, HyperDualSVec64};

use super::differentiated::Component;
use super::kind::{ElementKind, Number};
use super::shape::{Shape, Slot};
use crate::number::{Fingerprint, Hyper, Slope, hyper, hyper_parts};
use crate::program::Symbol;
use crate::{Cx, Scalar};

/// Number of derivatives that are computed at once for formulas of lists.
pub const SEEDS: usize = 4;

/// The second derivatives of elements with more coordinates are computed column by column: all at once, they would fill the stack.
pub const WIDE: usize = 24;

/// A number with derivatives with respect to [`SEEDS`] arguments.
pub type Wide<R> = DualSVec<R, SEEDS>;

/// Returns the value of an argument.
pub type Read<'a, R> = &'a dyn Fn(Slot) -> R;

/// An element's contributions on numbers of type R.
pub trait OnNumbers<R> {
    /// Adds 𝓛_v, 𝓛_q + Q and dΦ/dt; a component may be added in several parts.
    fn first(&self, read: Read<R>, add: &mut dyn FnMut(Component, R));
    /// Writes Φ.
    fn phi(&self, _read: Read<R>, _put: &mut dyn FnMut(usize, R)) {}
}

/// The formula itself, T, V, Q, Φ or a cost, on numbers of type S.
pub trait Values<S> {
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S));
}

/// A formula on the numbers by which it is recorded.
pub trait Recordable: Values<f64> + Values<Symbol> + Values<Fingerprint> + Send + Sync {}

impl<F: Values<f64> + Values<Symbol> + Values<Fingerprint> + Send + Sync + ?Sized> Recordable for F {}

/// An element whose type is hidden.
pub trait AnyElement: OnNumbers<Cx> + OnNumbers<Slope> + OnNumbers<Hyper> + Recordable {
    fn kind(&self) -> ElementKind;

    fn shape(&self) -> Shape;

    /// Adds first derivatives, and writes the second ones to `blocks`.
    ///
    /// Order: vv, vq, qq (kinetic); qq (potential); Q_v, Q_q (applied); σᵀΦ_qq, σᵀ(dΦ/dt)_qq, Φ_q, (dΦ/dt)_q (holonomic), each by rows.
    fn blocks(&self, read: Read<f64>, add: &mut dyn FnMut(Component, f64), blocks: &mut [f64]);

    /// Writes M = 𝓛_vv.
    fn mass(&self, _read: Read<f64>, _block: &mut [f64]) {}

    /// Passes on the entries of Φ_q: row, column, value.
    fn phi_q(&self, _read: Read<f64>, _put: &mut dyn FnMut(usize, usize, f64)) {}
}

/// A list of arguments.
pub type List = (fn(usize) -> Slot, usize);

/// The arguments by which formulas are differentiated: coordinates or velocities.
#[derive(Clone, Copy)]
pub enum By {
    Q,
    V,
}

/// The place of an argument among the `WIDTH` coordinates or velocities that begin with number `first`.
#[inline]
pub fn place<const WIDTH: usize>(slot: Slot, by: By, first: usize) -> Option<usize> {
    match (by, slot) {
        (By::Q, Slot::Q(i)) | (By::V, Slot::V(i)) => i.checked_sub(first).filter(|place| *place < WIDTH),
        _ => None,
    }
}

/// The numbers with which parts of `WIDTH` arguments of a list begin; one part if the list is empty.
pub fn parts<const WIDTH: usize>(len: usize) -> impl Iterator<Item = usize> {
    (0..len.max(1)).step_by(WIDTH.max(1))
}

/// Each value of a formula, passed to `put_value` with its number, and its derivatives with respect to n coordinates or velocities.
pub fn gradient<R: Number, const WIDTH: usize>(
    formula: &dyn Values<DualSVec<R, WIDTH>>,
    (by, n): (By, usize),
    read: Read<R>,
    put_value: &mut dyn FnMut(usize, R),
    put: &mut dyn FnMut(usize, usize, R),
) {
    for first in parts::<WIDTH>(n) {
        let seeded = |slot| {
            let x = DualSVec::from_re(read(slot));
            place::<WIDTH>(slot, by, first).map_or(x, |k| x.derivative(k))
        };
        let mut rows = 0..;
        formula.values(&seeded, &mut |value| {
            let Some(row) = rows.next() else { return };
            if first == 0 {
                put_value(row, value.re);
            }
            if let Some(slopes) = value.eps.0 {
                (first..n).zip(&slopes).for_each(|(i, slope)| put(row, i, *slope));
            }
        });
    }
}

/// The second derivatives of a single value with respect to n coordinates or velocities and n others, row by row, and the first ones with respect to the
/// former.
pub fn hessian<const WIDTH: usize>(
    formula: &dyn Values<HyperDualSVec64<WIDTH, WIDTH>>,
    ([row, column], n): ([By; 2], usize),
    read: Read<f64>,
    put_first: &mut dyn FnMut(usize, f64),
    block: &mut [f64],
) {
    for (first, first_column) in parts::<WIDTH>(n).flat_map(|i| parts::<WIDTH>(n).map(move |j| (i, j))) {
        let seeded = |slot| {
            let x = HyperDualSVec64::from_re(read(slot));
            let x = place::<WIDTH>(slot, row, first).map_or(x, |k| x.derivative1(k));
            place::<WIDTH>(slot, column, first_column).map_or(x, |k| x.derivative2(k))
        };
        formula.values(&seeded, &mut |value| {
            if let Some(slopes) = value.eps1.0.filter(|_| first_column == 0) {
                (first..n).zip(&slopes).for_each(|(i, slope)| put_first(i, *slope));
            }
            let Some(second) = value.eps1eps2.0 else { return };
            for (i, row) in (first..n).zip(second.row_iter()) {
                (first_column..n).zip(&row).for_each(|(j, x)| block[i * n + j] = *x);
            }
        });
    }
}

/// The blocks one coordinate after the other: along the coordinate by one direction of hyper-dual numbers, along its velocity by the other.
pub fn by_columns(
    element: &(impl AnyElement + ?Sized),
    read: Read<f64>,
    add: &mut dyn FnMut(Component, f64),
    blocks: &mut [f64],
) {
    let (kind, Shape { n, m, .. }) = (element.kind(), element.shape());
    let (square, column) = (n * n, m * n);
    blocks.fill(0.0);
    for j in 0..n.max(1) {
        let seeded = |slot: Slot| {
            let [by_q, by_v] = [Slot::Q(j), Slot::V(j)].map(|moved| f64::from(slot == moved));
            hyper(read(slot), by_q, by_v, 0.0)
        };
        OnNumbers::<Hyper>::first(element, &seeded, &mut |of, x| {
            let [value, by_q, by_v, _] = hyper_parts(&x);
            if j == 0 {
                add(of, value);
            }
            let mut column_of = |first: usize, row: usize, slope: f64| {
                if j < n {
                    blocks[first + row * n + j] += slope;
                }
            };
            match (kind, of) {
                (ElementKind::Kinetic, Component::Momentum(i)) => {
                    column_of(0, i, by_v);
                    column_of(square, i, by_q);
                }
                (ElementKind::Kinetic, Component::Force(i)) => column_of(2 * square, i, by_q),
                (ElementKind::Potential, Component::Force(i)) => column_of(0, i, by_q),
                (ElementKind::Applied, Component::Force(i)) => {
                    column_of(0, i, by_v);
                    column_of(square, i, by_q);
                }
                (ElementKind::Holonomic, Component::Momentum(i)) => column_of(0, i, by_q),
                (ElementKind::Holonomic, Component::Force(i)) => column_of(square, i, by_q),
                (ElementKind::Holonomic, Component::Equation(e)) => {
                    column_of(2 * square, e, by_v);
                    column_of(2 * square + column, e, by_q);
                }
                _ => {}
            }
        });
    }
}

/// Reads lists of arguments and calls a formula with them.
pub fn with_lists<S: Scalar, const L: usize>(read: Read<S>, lists: [List; L], formula: &mut dyn FnMut([&[S]; L])) {
    with_memory(lists.iter().map(|(_, len)| len).sum(), &mut |all: &mut [S]| {
        let slots = lists.iter().flat_map(|&(of, len)| (0..len).map(of));
        all.iter_mut().zip(slots).for_each(|(x, slot)| *x = read(slot));
        let mut rest = &*all;
        formula(lists.map(|(_, len)| {
            let (own, after) = rest.split_at(len);
            rest = after;
            own
        }));
    });
}

/// Calls a function with `len` zeros.
pub fn with_memory<S: Scalar>(len: usize, f: &mut dyn FnMut(&mut [S])) {
    with_copies(S::zero(), len, f);
}

/// Calls a function with `len` copies of a number. Few of them need no memory of the heap: formulas without programs are evaluated at every point of a
/// run.
pub fn with_copies<S: Scalar>(of: S, len: usize, f: &mut dyn FnMut(&mut [S])) {
    match len {
        0..=8 => f(&mut [of; 8][..len]),
        9..=16 => f(&mut [of; 16][..len]),
        17..=32 => f(&mut [of; 32][..len]),
        33..=128 => f(&mut [of; 128][..len]),
        _ => f(&mut vec![of; len]),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::SVector;

    use super::*;
    use crate::system::formula::{Applied, Fixed, Holonomic, Kinetic, Potential};
    use crate::{Constraint, Force, ForcePoint, KineticEnergy, PotentialEnergy};

    struct Sample;

    impl KineticEnergy<3, 1> for Sample {
        fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 3>, v: &SVector<S, 3>, b: &SVector<S, 1>) -> S {
            v[0] * v[1] * q[2].sin() + v[2] * v[2] * q[0] * q[1] * b[0] + v[0] * v[0]
        }
    }

    impl PotentialEnergy<3, 1> for Sample {
        fn potential_energy<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 1>, t: S) -> S {
            q[0] * q[1] * q[2].cos() * t + b[0] * q[0] * q[0]
        }
    }

    impl Force<3, 1, 1> for Sample {
        fn force<S: Scalar>(&self, at: &ForcePoint<S, 3, 1>, b: &SVector<S, 1>) -> SVector<S, 3> {
            SVector::from([at.u[0] * at.q[1], at.v[0] * at.v[2] * at.q[0], b[0] * at.v[1] * at.t])
        }
    }

    impl Constraint<3, 2, 1> for Sample {
        fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 1>, t: S) -> SVector<S, 2> {
            SVector::from([q[0] * q[1].sin() * b[0], q[1] * q[2] * q[2] + t * q[0]])
        }
    }

    /// The elements with `WIDTH` derivatives at once.
    fn elements<const WIDTH: usize>() -> [Box<dyn AnyElement>; 4] {
        [
            Box::new(Kinetic::<_, WIDTH> { energy: Fixed::<_, 3, 0, 0, 1>(Sample), n: 3, p: 1 }),
            Box::new(Potential::<_, WIDTH> { energy: Fixed::<_, 3, 0, 0, 1>(Sample), n: 3, p: 1 }),
            Box::new(Applied::<_, WIDTH> { force: Fixed::<_, 3, 0, 1, 1>(Sample), n: 3, k: 1, p: 1 }),
            Box::new(Holonomic::<_, WIDTH> { constraint: Fixed::<_, 3, 2, 0, 1>(Sample), n: 3, m: 2, p: 1 }),
        ]
    }

    #[test]
    fn blocks_do_not_depend_on_the_number_of_derivatives_at_once() {
        let read = |slot: Slot| match slot {
            Slot::Q(i) => 0.3 + 0.5 * i as f64,
            Slot::V(i) => 1.1 - 0.7 * i as f64,
            Slot::Sigma(j) => 0.8 - 1.9 * j as f64,
            _ => 1.7,
        };
        type Blocks<'a> = &'a dyn Fn(&dyn AnyElement, &mut dyn FnMut(Component, f64), &mut [f64]);
        let of = |element: &dyn AnyElement, compute: Blocks| {
            let (kind, shape) = (element.kind(), element.shape());
            let (mut sums, mut blocks) = ([0.0; 8], vec![f64::NAN; kind.length(shape.n, shape.m)]);
            let place = |of| match of {
                Component::Momentum(i) => i,
                Component::Force(i) => 3 + i,
                Component::Equation(j) => 6 + j,
            };
            compute(element, &mut |of, x| sums[place(of)] += x, &mut blocks);
            blocks.extend(sums);
            blocks
        };
        let all = |element: &dyn AnyElement, add: &mut dyn FnMut(Component, f64), blocks: &mut [f64]| {
            element.blocks(&read, add, blocks);
        };
        let columns = |element: &dyn AnyElement, add: &mut dyn FnMut(Component, f64), blocks: &mut [f64]| {
            by_columns(element, &read, add, blocks);
        };
        for (k, element) in elements::<3>().iter().enumerate() {
            let expected = of(&**element, &all);
            assert!(expected.iter().any(|x| *x != 0.0));
            let others = [
                of(&**element, &columns),
                of(&*elements::<1>()[k], &all),
                of(&*elements::<2>()[k], &all),
                of(&*elements::<5>()[k], &all),
            ];
            for (which, found) in others.iter().enumerate() {
                let is_close = expected.iter().zip(found).all(|(a, b)| (a - b).abs() < 1e-14);
                assert!(is_close, "{:?} {which}: {expected:?} {found:?}", element.kind());
            }
        }
    }
}
