//! Generalized forces Q(q, v, u, t) of lists and their tangents Q_q, Q_v.

use super::differentiated::Component;
use super::kind::{ElementKind, Number};
use super::on_numbers::{AnyElement, OnNumbers, Read, SEEDS, Values, Wide, seeded, with_lists, with_memory};
use super::shape::{Shape, Slot};
use crate::Scalar;
use crate::model::element::{ListForce, ListForcePoint};

/// An applied force on n coordinates with k controls and p constants: adds Q to the right-hand side of Eq. (1b).
pub struct ListApplied<E> {
    pub force: E,
    pub n: usize,
    pub k: usize,
    pub p: usize,
}

impl<E: ListForce, S: Scalar> Values<S> for ListApplied<E> {
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S)) {
        let lists: [(fn(usize) -> Slot, usize); 4] =
            [(Slot::Q, self.n), (Slot::V, self.n), (Slot::U, self.k), (Slot::B, self.p)];
        with_lists(read, lists, &mut |[q, v, u, b]| {
            with_memory(self.n, &mut |force: &mut [S]| {
                self.force.force(&ListForcePoint { q, v, u, t: read(Slot::T) }, b, force);
                force.iter().for_each(|component| put(*component));
            });
        });
    }
}

impl<E: ListForce, R: Number> OnNumbers<R> for ListApplied<E> {
    fn first(&self, read: Read<R>, add: &mut dyn FnMut(Component, R)) {
        let mut components = (0..).map(Component::Force);
        self.values(read, &mut |x| components.next().into_iter().for_each(|of| add(of, x)));
    }
}

impl<E: ListForce> AnyElement for ListApplied<E> {
    fn kind(&self) -> ElementKind {
        ElementKind::Applied
    }

    fn shape(&self) -> Shape {
        Shape { n: self.n, m: 0, k: self.k, p: self.p }
    }

    fn blocks(&self, read: Read<f64>, add: &mut dyn FnMut(Component, f64), blocks: &mut [f64]) {
        tangents(self, self.n, read, add, blocks);
    }
}

/// Adds Q, and writes Q_v and Q_q by rows, a few columns at a time: first derivatives alone, and the only ones of forces that branch.
fn tangents(
    formula: &dyn Values<Wide<f64>>,
    n: usize,
    read: Read<f64>,
    add: &mut dyn FnMut(Component, f64),
    blocks: &mut [f64],
) {
    blocks.fill(0.0);
    let slot = |column: usize| if column < n { Slot::V(column) } else { Slot::Q(column - n) };
    for first in (0..2 * n).step_by(SEEDS) {
        let columns = || (first..2 * n).take(SEEDS);
        let mut row = 0;
        let seeded = |of| seeded(Wide::from_re(read(of)), columns().position(|column| slot(column) == of));
        formula.values(&seeded, &mut |force| {
            if first == 0 {
                add(Component::Force(row), force.re);
            }
            if let Some(slopes) = force.eps.0 {
                for (column, slope) in columns().zip(&slopes) {
                    blocks[column / n * n * n + row * n + column % n] = *slope;
                }
            }
            row += 1;
        });
    }
}
