//! Hand-derived derivatives that are right, to be checked as they are and with one mistake made in them.
#![allow(dead_code)]

use hamiltonian_adjoint::element::{Constraint, Cost, CostPoint, KineticEnergy};
use hamiltonian_adjoint::{PotentialEnergy, Scalar};
use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

pub type Six = SVector<f64, 6>;
pub type Square = SMatrix<f64, 6, 6>;

/// r_b + R_b s_b − r_a − R_a s_a.
pub fn between(q: &Six, b: &[f64]) -> Vector2<f64> {
    let ([sa, ca], [sb, cb]) = ([q[2].sin(), q[2].cos()], [q[5].sin(), q[5].cos()]);
    let arm_a = Vector2::new(ca * b[0] - sa * b[1], sa * b[0] + ca * b[1]);
    let arm_b = Vector2::new(cb * b[2] - sb * b[3], sb * b[2] + cb * b[3]);
    Vector2::new(q[3] - q[0], q[4] - q[1]) + arm_b - arm_a
}

/// Its Jacobian: Φ_q of a hinge.
pub fn hinge_q(q: &Six, b: &[f64]) -> SMatrix<f64, 2, 6> {
    let ([sa, ca], [sb, cb]) = ([q[2].sin(), q[2].cos()], [q[5].sin(), q[5].cos()]);
    SMatrix::from([
        [-1.0, 0.0],
        [0.0, -1.0],
        [sa * b[0] + ca * b[1], -ca * b[0] + sa * b[1]],
        [1.0, 0.0],
        [0.0, 1.0],
        [-sb * b[2] - cb * b[3], cb * b[2] - sb * b[3]],
    ])
}

/// (Φ_q v)_q of a hinge.
pub fn hinge_q_v_q(q: &Six, v: &Six, b: &[f64]) -> SMatrix<f64, 2, 6> {
    let ([sa, ca], [sb, cb]) = ([q[2].sin(), q[2].cos()], [q[5].sin(), q[5].cos()]);
    let mut m = SMatrix::zeros();
    m[(0, 2)] = (ca * b[0] - sa * b[1]) * v[2];
    m[(1, 2)] = (sa * b[0] + ca * b[1]) * v[2];
    m[(0, 5)] = (-cb * b[2] + sb * b[3]) * v[5];
    m[(1, 5)] = (-sb * b[2] - cb * b[3]) * v[5];
    m
}

/// (Φ_qᵀσ)_q of a hinge: only the two angles turn anything.
pub fn hinge_t_sigma_q(q: &Six, sigma: &Vector2<f64>, b: &[f64]) -> Square {
    let mut m = Square::zeros();
    let ([sa, ca], [sb, cb]) = ([q[2].sin(), q[2].cos()], [q[5].sin(), q[5].cos()]);
    m[(2, 2)] = sigma[0] * (ca * b[0] - sa * b[1]) + sigma[1] * (sa * b[0] + ca * b[1]);
    m[(5, 5)] = -sigma[0] * (cb * b[2] - sb * b[3]) - sigma[1] * (sb * b[2] + cb * b[3]);
    m
}

/// ((dΦ/dt)_qᵀσ)_q of a hinge.
pub fn hinge_dot_t_sigma_q(q: &Six, v: &Six, sigma: &Vector2<f64>, b: &[f64]) -> Square {
    let mut m = Square::zeros();
    let ([sa, ca], [sb, cb]) = ([q[2].sin(), q[2].cos()], [q[5].sin(), q[5].cos()]);
    m[(2, 2)] = v[2] * (sigma[0] * (-sa * b[0] - ca * b[1]) + sigma[1] * (ca * b[0] - sa * b[1]));
    m[(5, 5)] = v[5] * (sigma[0] * (sb * b[2] + cb * b[3]) + sigma[1] * (-cb * b[2] + sb * b[3]));
    m
}

/// Φ_b of a hinge.
pub fn hinge_b(q: &Six) -> SMatrix<f64, 2, 4> {
    let ([sa, ca], [sb, cb]) = ([q[2].sin(), q[2].cos()], [q[5].sin(), q[5].cos()]);
    SMatrix::from([[-ca, -sa], [sa, -ca], [cb, sb], [-sb, cb]])
}

/// Φ_q of a rod, Φ = (|d|²/l − l)/2.
pub fn rod_q(q: &Six, b: &[f64]) -> SMatrix<f64, 1, 6> {
    between(q, b).transpose() * hinge_q(q, b) / b[4]
}

/// (Φ_q v)_q of a rod.
pub fn rod_q_v_q(q: &Six, v: &Six, b: &[f64]) -> SMatrix<f64, 1, 6> {
    let j = hinge_q(q, b);
    ((j * v).transpose() * j + between(q, b).transpose() * hinge_q_v_q(q, v, b)) / b[4]
}

/// Q_v of a damper between two points: −d g gᵀ with g the gradient of the distance.
pub fn damper_v(q: &Six, b: &[f64]) -> Square {
    let g = distance_q(q, b);
    g * g.transpose() * -b[4]
}

pub fn distance_q(q: &Six, b: &[f64]) -> Six {
    hinge_q(q, b).transpose() * between(q, b).normalize()
}

/// The second derivatives of the distance.
pub fn distance_qq(q: &Six, b: &[f64]) -> Square {
    let (d, j) = (between(q, b), hinge_q(q, b));
    let (length, e) = (d.norm(), d.normalize());
    let across = Matrix2::identity() - e * e.transpose();
    j.transpose() * across * j / length + hinge_t_sigma_q(q, &e, b)
}

/// Q_q of a damper.
pub fn damper_q(q: &Six, v: &Six, b: &[f64]) -> Square {
    let (g, gq) = (distance_q(q, b), distance_qq(q, b));
    (g * (v.transpose() * gq) + gq * g.dot(v)) * -b[4]
}

/// V_q of a spring between two points; b = [s_a, s_b, c, l₀].
pub fn spring_q(q: &Six, b: &[f64]) -> Six {
    distance_q(q, b) * (b[4] * (between(q, b).norm() - b[5]))
}

/// V_qq of the same.
pub fn spring_qq(q: &Six, b: &[f64]) -> Square {
    let g = distance_q(q, b);
    (g * g.transpose() + distance_qq(q, b) * (between(q, b).norm() - b[5])) * b[4]
}

/// A double pendulum in two angles: a mass matrix that depends on q; b = [m₁, m₂, l₁, l₂].
pub struct DoublePendulum;

impl KineticEnergy<2, 4> for DoublePendulum {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, b: &SVector<S, 4>) -> S {
        let (first, second) = (b[2] * v[0], b[3] * v[1]);
        let together = first * first + second * second + first * second * (q[0] - q[1]).cos() * 2.0;
        (b[0] * first * first + b[1] * together) * 0.5
    }
}

impl PotentialEnergy<2, 4> for DoublePendulum {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 4>, _t: S) -> S {
        let first = b[2] * q[0].cos();
        -(b[0] * first + b[1] * (first + b[3] * q[1].cos())) * 9.81
    }
}

pub type Two = Vector2<f64>;
pub type Four = SVector<f64, 4>;

pub fn pendulum_mass(q: &Two, b: &Four) -> Matrix2<f64> {
    let coupling = b[1] * b[2] * b[3] * (q[0] - q[1]).cos();
    Matrix2::new((b[0] + b[1]) * b[2] * b[2], coupling, coupling, b[1] * b[3] * b[3])
}

pub fn pendulum_mass_v_q(q: &Two, v: &Two, b: &Four) -> Matrix2<f64> {
    let c = b[1] * b[2] * b[3] * (q[0] - q[1]).sin();
    Matrix2::new(-c * v[1], c * v[1], -c * v[0], c * v[0])
}

pub fn pendulum_t_q(q: &Two, v: &Two, b: &Four) -> Two {
    let c = b[1] * b[2] * b[3] * (q[0] - q[1]).sin() * v[0] * v[1];
    Two::new(-c, c)
}

pub fn pendulum_t_qq(q: &Two, v: &Two, b: &Four) -> Matrix2<f64> {
    let c = b[1] * b[2] * b[3] * (q[0] - q[1]).cos() * v[0] * v[1];
    Matrix2::new(-c, c, c, -c)
}

pub fn pendulum_v_q(q: &Two, b: &Four) -> Two {
    Two::new((b[0] + b[1]) * b[2] * q[0].sin(), b[1] * b[3] * q[1].sin()) * 9.81
}

/// A wheel pushed along x that must follow a moving profile: Φ = ½ (x² + y²) + x sin ω t, so that Φ_tq ≠ 0; b = [ω].
pub struct Cam;

impl Constraint<2, 1, 1> for Cam {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 1>, t: S) -> SVector<S, 1> {
        SVector::from([(q[0] * q[0] + q[1] * q[1]) * 0.5 + q[0] * (b[0] * t).sin()])
    }
}

/// A cost that uses every part of y; b = four weights.
pub struct Everything;

impl Cost<2, 1, 1, 4> for Everything {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 1, 1>, b: &SVector<S, 4>) -> S {
        let configuration = at.q[0] * at.q[0] * 0.5 + at.q[0] * at.q[1] + at.q[1].sin() * at.p_star_dot[1];
        let motion = at.v[0] * at.v[1] * b[1] + at.u[0] * at.u[0] * b[2] * 0.5;
        configuration * b[0] + motion + b[3] * at.sigma[0] * at.p_star[0]
    }
}
