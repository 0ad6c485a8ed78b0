//! Functions whose Jacobians are wanted: [`Function`] for the user's, and the derived ones that mechanics is made of.

use num_dual::{Dual, Dual64, DualNum};
use std::ops::Range;

use crate::number::Real;
use crate::{Cx, Scalar};

/// A vector function y = f(x), written once for all numbers.
pub trait Function {
    /// f(x).
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S>;
}

/// A vector function on the numbers of the oracles; it may contain derivatives itself.
pub(crate) trait Formula {
    fn value<R: Real>(&self, x: &[R]) -> Vec<R>;
}

/// A formula with its number types hidden: values, and derivatives along a direction by two of the oracles.
pub(crate) trait Differentiable {
    fn real(&self, x: &[f64]) -> Vec<f64>;
    /// The values, and their derivatives along a direction.
    fn with_slope(&self, x: &[f64], direction: &[f64]) -> (Vec<f64>, Vec<f64>);
    fn by_dual(&self, x: &[f64], direction: &[f64]) -> Vec<f64> {
        self.with_slope(x, direction).1
    }
    fn by_complex_step(&self, x: &[f64], direction: &[f64]) -> Vec<f64>;
}

impl<F: Formula> Differentiable for F {
    fn real(&self, x: &[f64]) -> Vec<f64> {
        self.value(x)
    }

    fn with_slope(&self, x: &[f64], direction: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let x: Vec<Dual64> = x.iter().zip(direction).map(|(&x, &d)| Dual64::new(x, d)).collect();
        self.value(&x).iter().map(|y| (y.re, y.eps)).unzip()
    }

    fn by_complex_step(&self, x: &[f64], direction: &[f64]) -> Vec<f64> {
        // Far below rounding, far above underflow, even relative to coordinates of size 1e±6.
        const STEP: f64 = 1e-40;
        let x: Vec<Cx> = x.iter().zip(direction).map(|(&x, &d)| Cx::new(x, d * STEP)).collect();
        self.value(&x).iter().map(|y| y.0.im / STEP).collect()
    }
}

/// What is made of a function before its Jacobian is taken.
#[derive(Clone, Debug)]
pub(crate) enum Derived {
    /// f itself.
    Value,
    /// f_q v, and + f_t if the place of t is given.
    Along { q: Range<usize>, v: Range<usize>, t: Option<usize> },
    /// (σᵀ f)_q as a column; without σ, for a scalar f, its gradient.
    Gradient { q: Range<usize>, sigma: Option<Range<usize>> },
    /// (σᵀ (f_q v + f_t))_q as a column.
    GradientAlong { q: Range<usize>, v: Range<usize>, t: usize, sigma: Range<usize> },
}

impl Derived {
    /// The arguments by which the function itself is differentiated.
    pub(crate) fn inner(&self) -> Option<Range<usize>> {
        match self {
            Derived::Value => None,
            Derived::Along { q, .. } | Derived::Gradient { q, .. } | Derived::GradientAlong { q, .. } => Some(q.clone()),
        }
    }
}

/// A formula's values as a block of one column: the derivative of s f(x) by s = 1, which stands behind all arguments.
pub(crate) struct Values<F>(pub F);

impl<F: Formula> Formula for Values<F> {
    fn value<R: Real>(&self, x: &[R]) -> Vec<R> {
        let Some((&s, x)) = x.split_last() else { return Vec::new() };
        self.0.value(x).into_iter().map(|y| y * s).collect()
    }
}

/// A function and what is made of it.
pub(crate) struct Of<F>(pub F, pub Derived);

impl<F: Function> Formula for Of<F> {
    fn value<R: Real>(&self, x: &[R]) -> Vec<R> {
        match &self.1 {
            Derived::Value => self.0.value(x),
            Derived::Along { q, v, t } => along(&self.0, x, q, v, *t),
            Derived::Gradient { q, sigma } => {
                let column = |i| pulled(&unit(&self.0, x, i), x, sigma.as_ref());
                q.clone().map(column).collect()
            }
            Derived::GradientAlong { q, v, t, sigma } => {
                let column = |i: usize| {
                    let lifted: Vec<Dual<R>> = x.iter().enumerate().map(|(j, &x)| seeded(x, i == j)).collect();
                    let rate: Vec<R> = along(&self.0, &lifted, q, v, Some(*t)).iter().map(|y| y.eps).collect();
                    pulled(&rate, x, Some(sigma))
                };
                q.clone().map(column).collect()
            }
        }
    }
}

fn seeded<D: DualNum<Primitive = f64> + Copy>(x: D, seed: bool) -> Dual<D> {
    Dual::new(x, if seed { D::one() } else { D::zero() })
}

/// ∂f/∂x_i.
fn unit<F: Function, D: DualNum<Primitive = f64> + Copy>(f: &F, x: &[D], i: usize) -> Vec<D> {
    let x: Vec<Dual<D>> = x.iter().enumerate().map(|(j, &x)| seeded(x, i == j)).collect();
    f.value(&x).iter().map(|y| y.eps).collect()
}

/// f_q v (+ f_t): the ε-part of f(q + ε v, t + ε).
fn along<F, D>(f: &F, x: &[D], q: &Range<usize>, v: &Range<usize>, t: Option<usize>) -> Vec<D>
where
    F: Function,
    D: DualNum<Primitive = f64> + Copy,
{
    let mut lifted: Vec<Dual<D>> = x.iter().map(|&x| Dual::new(x, D::zero())).collect();
    for (i, j) in q.clone().zip(v.clone()) {
        lifted[i].eps = x[j];
    }
    if let Some(t) = t {
        lifted[t].eps = D::one();
    }
    f.value(&lifted).iter().map(|y| y.eps).collect()
}

/// σᵀ y.
fn pulled<R: Real>(y: &[R], x: &[R], sigma: Option<&Range<usize>>) -> R {
    match sigma {
        Some(sigma) => y.iter().zip(&x[sigma.clone()]).fold(R::zero(), |sum, (&y, &s)| sum + y * s),
        None => y.iter().fold(R::zero(), |sum, &y| sum + y),
    }
}
