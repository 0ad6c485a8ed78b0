//! An element behind a trait that hides its type, and the memory in which formulas of lists find their arguments.
//!
//! Formulas of fixed lengths carry all derivatives of an element at once (`typed.rs`). For formulas of lists these lengths are unknown to the compiler:
//! their numbers carry [`SEEDS`] derivatives at once, and an element is evaluated several times.

use num_dual::DualSVec;

use super::differentiated::Component;
use super::kind::{ElementKind, Number};
use super::shape::{Shape, Slot};
use crate::number::{Fingerprint, Hyper, Slope, hyper, hyper_parts};
use crate::program::Symbol;
use crate::{Cx, Scalar};

/// Number of derivatives that a [`Wide`] number carries.
pub const SEEDS: usize = 4;

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
}

/// The derivatives of a single value with respect to the arguments `of(0)`, …, `of(count − 1)`.
pub fn gradient<R: Number>(
    formula: &dyn Values<Wide<R>>,
    (of, count): (fn(usize) -> Slot, usize),
    read: Read<R>,
    put: &mut dyn FnMut(usize, R),
) {
    for first in (0..count).step_by(SEEDS) {
        let seeded = |slot| seeded(Wide::from_re(read(slot)), (first..count).take(SEEDS).position(|i| of(i) == slot));
        formula.values(&seeded, &mut |value| {
            if let Some(slopes) = value.eps.0 {
                (first..count).zip(&slopes).for_each(|(i, slope)| put(i, *slope));
            }
        });
    }
}

/// A number that is differentiated by itself, if it is one of those.
pub fn seeded<R: Number>(x: Wide<R>, which: Option<usize>) -> Wide<R> {
    which.map_or(x, |k| x.derivative(k))
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
pub fn with_lists<S: Scalar, const L: usize>(
    read: Read<S>,
    lists: [(fn(usize) -> Slot, usize); L],
    formula: &mut dyn FnMut([&[S]; L]),
) {
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

/// Calls a function with `len` zeros. Few of them need no memory of the heap: formulas without programs are evaluated at every point of a run.
pub fn with_memory<S: Scalar>(len: usize, f: &mut dyn FnMut(&mut [S])) {
    match len {
        0..=8 => f(&mut [S::zero(); 8][..len]),
        9..=16 => f(&mut [S::zero(); 16][..len]),
        17..=32 => f(&mut [S::zero(); 32][..len]),
        _ => f(&mut vec![S::zero(); len]),
    }
}
