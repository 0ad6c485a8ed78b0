//! Elements written by hand that several scenes share.
#![allow(dead_code)]

use hamiltonian_adjoint::{Constraint, Cost, CostPoint, Force, ForcePoint, KineticEnergy, PotentialEnergy, Scalar};
use nalgebra::SVector;

/// Gravity, m/s².
pub const GRAVITY: f64 = 9.81;

/// A double pendulum in its two absolute angles from the vertical, links of 1 kg and 1 m, point masses at the ends.
pub struct DoublePendulum;

impl KineticEnergy<2> for DoublePendulum {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, _: &SVector<S, 0>) -> S {
        v[0] * v[0] + v[1] * v[1] * 0.5 + v[0] * v[1] * (q[0] - q[1]).cos()
    }
}

impl PotentialEnergy<2> for DoublePendulum {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, _: &SVector<S, 0>, _: S) -> S {
        -(q[0].cos() * 2.0 + q[1].cos()) * GRAVITY
    }
}

impl DoublePendulum {
    /// T + V.
    pub fn energy(q: &[f64], v: &[f64]) -> f64 {
        let ([q, v], b) = ([q, v].map(SVector::<f64, 2>::from_column_slice), SVector::from([]));
        DoublePendulum.kinetic_energy(&q, &v, &b) + DoublePendulum.potential_energy(&q, &b, 0.0)
    }
}

/// Half of a hinge: the abscissas of the points (along, across) of two bodies are the same.
pub struct SameAbscissa;

impl Constraint<6, 1, 4> for SameAbscissa {
    fn phi<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 4>, _: S) -> SVector<S, 1> {
        let abscissa = |k: usize, along: S, across: S| q[k] + q[k + 2].cos() * along - q[k + 2].sin() * across;
        SVector::from([abscissa(0, b[0], b[1]) - abscissa(3, b[2], b[3])])
    }
}

/// V = ½ c (x − 1)², `b = [c]`.
pub struct Quadratic;

impl PotentialEnergy<1, 1> for Quadratic {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, b: &SVector<S, 1>, _: S) -> S {
        let stretch = q[0] - 1.0;
        b[0] * stretch * stretch * 0.5
    }
}

/// A mass that is driven by b v² + u: without a control its speed is v₀/(1 − b v₀ t), and long steps have no solution.
pub struct Runaway;

impl KineticEnergy<1> for Runaway {
    fn kinetic_energy<S: Scalar>(&self, _: &SVector<S, 1>, v: &SVector<S, 1>, _: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}

impl Force<1, 1, 1> for Runaway {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, b: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([b[0] * at.v[0] * at.v[0] + at.u[0]])
    }
}

impl Cost<1, 0, 1> for Runaway {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 1>, _: &SVector<S, 0>) -> S {
        at.q[0] * at.v[0] + at.v[0] * at.u[0] * at.t + at.u[0] * at.u[0]
    }
}

/// T = ½ v₁² + ½ v₃²: the middle coordinate has none.
pub struct Ends;

impl KineticEnergy<3> for Ends {
    fn kinetic_energy<S: Scalar>(&self, _: &SVector<S, 3>, v: &SVector<S, 3>, _: &SVector<S, 0>) -> S {
        (v[0] * v[0] + v[2] * v[2]) * 0.5
    }
}

/// q₂ = 2 q₁.
pub struct Gears;

impl Constraint<3, 1> for Gears {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, _: &SVector<S, 0>, _: S) -> SVector<S, 1> {
        SVector::from([q[1] - q[0] * 2.0])
    }
}
