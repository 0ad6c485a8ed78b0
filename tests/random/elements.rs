//! Elements of a user's own: mass matrices that depend on the coordinates, forces and constraints of everything they may depend on.

use hamiltonian_adjoint::{Constraint, Cost, CostPoint, Force, ForcePoint, KineticEnergy, PotentialEnergy, Scalar};
use nalgebra::{SVector, Vector1, Vector2, Vector3};

/// A mass on a turning rail, T = ½ m (ṙ² + (r² + k²) φ̇²); q = (r, φ), b = [m, k].
pub struct Polar;

impl KineticEnergy<2, 2> for Polar {
    fn kinetic_energy<S: Scalar>(&self, q: &Vector2<S>, v: &Vector2<S>, b: &Vector2<S>) -> S {
        b[0] * (v[0] * v[0] + (q[0] * q[0] + b[1] * b[1]) * v[1] * v[1]) * 0.5
    }
}

/// Two arms that hang on each other, T = ½ A v₀² + ½ B v₁² + C √(A B) cos(q₀ − q₁) v₀ v₁; b = [A, B, C], |C| < 1.
pub struct Coupled;

impl KineticEnergy<2, 3> for Coupled {
    fn kinetic_energy<S: Scalar>(&self, q: &Vector2<S>, v: &Vector2<S>, b: &Vector3<S>) -> S {
        let coupling = b[2] * (b[0] * b[1]).sqrt() * (q[0] - q[1]).cos();
        (b[0] * v[0] * v[0] + b[1] * v[1] * v[1]) * 0.5 + coupling * v[0] * v[1]
    }
}

/// A point mass at a point of a body, T = ½ m |ṙ + d(R s)/dt|²; b = [m, s].
pub struct TipMass;

impl KineticEnergy<3, 3> for TipMass {
    fn kinetic_energy<S: Scalar>(&self, q: &Vector3<S>, v: &Vector3<S>, b: &Vector3<S>) -> S {
        let (sin, cos) = q[2].sin_cos();
        let x = v[0] - (sin * b[1] + cos * b[2]) * v[2];
        let y = v[1] + (cos * b[1] - sin * b[2]) * v[2];
        b[0] * (x * x + y * y) * 0.5
    }
}

/// V = a y cos(x + ω t); b = [a, ω].
pub struct Wave;

impl PotentialEnergy<2, 2> for Wave {
    fn potential_energy<S: Scalar>(&self, q: &Vector2<S>, b: &Vector2<S>, t: S) -> S {
        b[0] * q[1] * (q[0] + b[1] * t).cos()
    }
}

/// A force of q, v, u, t and b in which no two of them can stand in for each other.
pub struct Mixed;

impl Force<3, 1, 3> for Mixed {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 3, 1>, b: &Vector3<S>) -> Vector3<S> {
        let (q, v, u) = (&at.q, &at.v, at.u[0]);
        Vector3::new(
            b[0] * (q[1] + at.t).sin() - b[1] * v[0] * v[2],
            u * q[2].cos() - b[1] * v[1],
            b[2] * u * (v[0] + at.t) - b[0] * q[2],
        )
    }
}

/// Φ = q₁ − r q₀ − ¼ sin q₀ − c; b = [r, c].
pub struct Geared;

impl Geared {
    pub const WOBBLE: f64 = 0.25;
}

impl Constraint<2, 1, 2> for Geared {
    fn phi<S: Scalar>(&self, q: &Vector2<S>, b: &Vector2<S>, _t: S) -> Vector1<S> {
        Vector1::new(q[1] - b[0] * q[0] - q[0].sin() * Geared::WOBBLE - b[1])
    }
}

/// h = b u² (1 + t²).
pub struct Effort;

impl Cost<0, 0, 1, 1> for Effort {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 1>, b: &Vector1<S>) -> S {
        b[0] * at.u[0] * at.u[0] * (at.t * at.t + 1.0)
    }
}

/// h = b σ².
pub struct Reaction;

impl Cost<0, 1, 0, 1> for Reaction {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 1, 0>, b: &Vector1<S>) -> S {
        b[0] * at.sigma[0] * at.sigma[0]
    }
}

/// h = p*·v + b sin(p*·q) + ṗ*·q.
pub struct Momentum;

impl Cost<3, 0, 0, 1> for Momentum {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 0, 0>, b: &SVector<S, 1>) -> S {
        at.p_star.dot(&at.v) + b[0] * at.p_star.dot(&at.q).sin() + at.p_star_dot.dot(&at.q)
    }
}
