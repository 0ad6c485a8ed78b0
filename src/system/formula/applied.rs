//! Generalized forces Q(q, v, u, t) and their tangents Q_q, Q_v.

use super::differentiated::Component;
use super::kind::{ElementKind, Number};
use super::on_numbers::{AnyElement, By, OnNumbers, Read, Values, gradient};
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
        blocks.fill(0.0);
        let (n, (by_v, by_q)) = (self.n, blocks.split_at_mut(self.n * self.n));
        let mut add_force = |i, force| add(Component::Force(i), force);
        gradient::<f64, WIDTH>(self, (By::V, n), read, &mut add_force, &mut |i, j, slope| by_v[i * n + j] = slope);
        gradient::<f64, WIDTH>(self, (By::Q, n), read, &mut |_, _| (), &mut |i, j, slope| by_q[i * n + j] = slope);
    }
}
