//! Generalized forces Q(q, v, u, t) and their tangents Q_q, Q_v.

use num_dual::DualSVec64;

use super::differentiated::Component;
use super::kind::{ElementKind, Number};
use super::on_numbers::{AnyElement, By, OnNumbers, Read, Values, parts, place};
use super::shape::Shape;
use crate::Scalar;

/// The formula Q(q, v, u, t; b), which reads its arguments itself.
pub trait ForceFormula: Send + Sync + 'static {
    fn force<S: Scalar>(&self, shape: Shape, read: Read<S>, put: &mut dyn FnMut(S));
}

/// An applied force on n coordinates with k controls and p constants: adds Q to the right-hand side of Eq. (1b). `WIDTH` derivatives are
/// computed at once.
pub struct Applied<E, const WIDTH: usize> {
    pub force: E,
    pub n: usize,
    pub k: usize,
    pub p: usize,
}

impl<E: ForceFormula, S: Scalar, const WIDTH: usize> Values<S> for Applied<E, WIDTH> {
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S)) {
        self.force.force(self.shape(), read, put);
    }
}

impl<E: ForceFormula, R: Number, const WIDTH: usize> OnNumbers<R> for Applied<E, WIDTH> {
    fn first(&self, read: Read<R>, add: &mut dyn FnMut(Component, R)) {
        let mut components = (0..).map(Component::Force);
        self.values(read, &mut |x| components.next().into_iter().for_each(|of| add(of, x)));
    }
}

impl<E: ForceFormula, const WIDTH: usize> AnyElement for Applied<E, WIDTH> {
    fn kind(&self) -> ElementKind {
        ElementKind::Applied
    }

    fn shape(&self) -> Shape {
        Shape { n: self.n, m: 0, k: self.k, p: self.p }
    }

    fn blocks(&self, read: Read<f64>, add: &mut dyn FnMut(Component, f64), blocks: &mut [f64]) {
        tangents::<WIDTH>(self, self.n, read, add, blocks);
    }
}

/// Adds Q, and writes Q_v and Q_q by rows: first derivatives alone, and the only ones of forces that branch.
fn tangents<const WIDTH: usize>(
    formula: &dyn Values<DualSVec64<WIDTH>>,
    n: usize,
    read: Read<f64>,
    add: &mut dyn FnMut(Component, f64),
    blocks: &mut [f64],
) {
    blocks.fill(0.0);
    for (which, by, first) in
        (0..).zip([By::V, By::Q]).flat_map(|(which, by)| parts::<WIDTH>(n).map(move |i| (which, by, i)))
    {
        let block = &mut blocks[which * n * n..];
        let seeded = |slot| {
            let x = DualSVec64::from_re(read(slot));
            place::<WIDTH>(slot, by, first).map_or(x, |k| x.derivative(k))
        };
        let mut rows = 0..;
        formula.values(&seeded, &mut |force| {
            let Some(row) = rows.next() else { return };
            if (which, first) == (0, 0) {
                add(Component::Force(row), force.re);
            }
            if let Some(slopes) = force.eps.0 {
                (first..n).zip(&slopes).for_each(|(column, slope)| block[row * n + column] = *slope);
            }
        });
    }
}
