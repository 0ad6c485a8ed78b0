//! Elements as a new user would write them, and their derivatives by hand, all right.

use hamiltonian_adjoint::element::{Constraint, Cost, CostPoint, Force, ForcePoint, KineticEnergy};
use hamiltonian_adjoint::{PotentialEnergy, Scalar};
use nalgebra::SVector;

pub type Matrix2 = [[f64; 2]; 2];
type Two<S> = SVector<S, 2>;

/// An arm that turns by φ and slides by r: T = ½ (J + m r²) φ̇² + ½ m ṙ²; b = [J, m].
pub struct Arm;

impl KineticEnergy<2, 2> for Arm {
    fn kinetic_energy<S: Scalar>(&self, q: &Two<S>, v: &Two<S>, b: &SVector<S, 2>) -> S {
        ((b[0] + b[1] * q[1] * q[1]) * v[0] * v[0] + b[1] * v[1] * v[1]) * 0.5
    }
}

pub const ARM: [f64; 2] = [0.7, 1.9];

/// A cart at x with a pendulum at θ: T = ½ (M + m) ẋ² + m l ẋ θ̇ cos θ + ½ m l² θ̇²; b = [M, m, l].
pub struct CartPole;

impl KineticEnergy<2, 3> for CartPole {
    fn kinetic_energy<S: Scalar>(&self, q: &Two<S>, v: &Two<S>, b: &SVector<S, 3>) -> S {
        let [cart, m, l] = [b[0], b[1], b[2]];
        (cart + m) * v[0] * v[0] * 0.5 + m * l * v[0] * v[1] * q[1].cos() + m * l * l * v[1] * v[1] * 0.5
    }
}

pub const CART_POLE: [f64; 3] = [2.1, 0.6, 0.8];

pub fn cart_pole_mass(q: &Two<f64>) -> Matrix2 {
    let [cart, m, l] = CART_POLE;
    let coupling = m * l * q[1].cos();
    [[cart + m, coupling], [coupling, m * l * l]]
}

pub fn cart_pole_mass_v_q(q: &Two<f64>, v: &Two<f64>) -> Matrix2 {
    let [_, m, l] = CART_POLE;
    let c = -m * l * q[1].sin();
    [[0.0, c * v[1]], [0.0, c * v[0]]]
}

pub fn cart_pole_t_q(q: &Two<f64>, v: &Two<f64>) -> [f64; 2] {
    let [_, m, l] = CART_POLE;
    [0.0, -m * l * v[0] * v[1] * q[1].sin()]
}

/// A spring across a track, a weight, and a coupling: V = ½ k (s − l₀)² − w cos θ + c x sin θ with s = √(x² + h²); b = [k, h, l₀, w, c].
pub struct Track;

impl PotentialEnergy<2, 5> for Track {
    fn potential_energy<S: Scalar>(&self, q: &Two<S>, b: &SVector<S, 5>, _t: S) -> S {
        let [k, h, free, w, c] = [b[0], b[1], b[2], b[3], b[4]];
        let stretch = (q[0] * q[0] + h * h).sqrt() - free;
        k * stretch * stretch * 0.5 - w * q[1].cos() + c * q[0] * q[1].sin()
    }
}

pub const TRACK: [f64; 5] = [30.0, 0.4, 0.35, 4.2, 1.3];

pub fn track_length(x: f64) -> f64 {
    x.hypot(TRACK[1])
}

pub fn track_q(q: &Two<f64>) -> [f64; 2] {
    let ([k, _, free, w, c], s) = (TRACK, track_length(q[0]));
    [k * (s - free) * q[0] / s + c * q[1].sin(), w * q[1].sin() + c * q[0] * q[1].cos()]
}

pub fn track_qq(q: &Two<f64>) -> Matrix2 {
    let ([k, h, free, w, c], x, s) = (TRACK, q[0], track_length(q[0]));
    let mixed = c * q[1].cos();
    [[k * x * x / (s * s) + k * (s - free) * h * h / (s * s * s), mixed], [mixed, w * q[1].cos() - c * x * q[1].sin()]]
}

/// Drag, friction, and a motor: Q_x = −c v |v| − μ tanh(v/ε), Q_θ = −d (1 + x²) θ̇ + u x cos θ; b = [c, μ, ε, d].
pub struct Drag;

impl Force<2, 1, 4> for Drag {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 1>, b: &SVector<S, 4>) -> Two<S> {
        let ([c, mu, width, d], [x, angle]) = ([b[0], b[1], b[2], b[3]], [at.q[0], at.q[1]]);
        let friction = c * at.v[0] * at.v[0].abs() + mu * (at.v[0] / width).tanh();
        let damping = d * (x * x + 1.0) * at.v[1];
        Two::new(-friction, at.u[0] * x * angle.cos() - damping)
    }
}

pub const DRAG: [f64; 4] = [0.9, 0.4, 0.7, 1.6];

pub fn drag_v(q: &Two<f64>, v: &Two<f64>) -> Matrix2 {
    let [c, mu, width, d] = DRAG;
    let slope = 1.0 - (v[0] / width).tanh().powi(2);
    [[-2.0 * c * v[0].abs() - mu * slope / width, 0.0], [0.0, -d * (1.0 + q[0] * q[0])]]
}

pub fn drag_q(q: &Two<f64>, v: &Two<f64>, u: f64) -> Matrix2 {
    let d = DRAG[3];
    [[0.0, 0.0], [-2.0 * d * q[0] * v[1] + u * q[1].cos(), -u * q[0] * q[1].sin()]]
}

/// A slider at x on a crank at φ: Φ = x − r cos φ − √(l² − r² sin² φ); b = [r, l].
pub struct Crank;

impl Constraint<2, 1, 2> for Crank {
    fn phi<S: Scalar>(&self, q: &Two<S>, b: &SVector<S, 2>, _t: S) -> SVector<S, 1> {
        let [r, l] = [b[0], b[1]];
        let height = r * q[1].sin();
        SVector::from([q[0] - r * q[1].cos() - (l * l - height * height).sqrt()])
    }
}

pub const CRANK: [f64; 2] = [0.5, 1.4];

/// sin φ, cos φ and the root.
pub fn crank_parts(angle: f64) -> [f64; 3] {
    let ([r, l], (s, c)) = (CRANK, angle.sin_cos());
    [s, c, (l * l - r * r * s * s).sqrt()]
}

pub fn crank_q(q: &Two<f64>) -> [f64; 2] {
    let (r, [s, c, root]) = (CRANK[0], crank_parts(q[1]));
    [1.0, r * s + r * r * s * c / root]
}

pub fn crank_q_v_q(q: &Two<f64>, v: &Two<f64>) -> [f64; 2] {
    let (r, [s, c, root]) = (CRANK[0], crank_parts(q[1]));
    [0.0, v[1] * (r * c + r * r * (c * c - s * s) / root + r.powi(4) * s * s * c * c / root.powi(3))]
}

/// A driven slope: Φ = x − a sin(ω t) φ; b = [a, ω].
pub struct Driven;

impl Constraint<2, 1, 2> for Driven {
    fn phi<S: Scalar>(&self, q: &Two<S>, b: &SVector<S, 2>, t: S) -> SVector<S, 1> {
        SVector::from([q[0] - b[0] * (b[1] * t).sin() * q[1]])
    }
}

pub const DRIVEN: [f64; 2] = [0.6, 1.7];

/// A target, an effort, an obstacle and a speed: h = ½ w (x + l sin θ)² + ½ u² x + exp(−k x²) + ẋ θ̇²; b = [w, l, k].
pub struct Reach;

impl Cost<2, 0, 1, 3> for Reach {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 1>, b: &SVector<S, 3>) -> S {
        let ([w, l, k], [x, angle], u) = ([b[0], b[1], b[2]], [at.q[0], at.q[1]], at.u[0]);
        let miss = x + l * angle.sin();
        w * miss * miss * 0.5 + u * u * x * 0.5 + (-k * x * x).exp() + at.v[0] * at.v[1] * at.v[1]
    }
}

pub const REACH: [f64; 3] = [2.5, 0.9, 1.2];

pub fn reach_q(q: &Two<f64>, u: f64) -> [f64; 2] {
    let ([w, l, k], x) = (REACH, q[0]);
    let miss = x + l * q[1].sin();
    [w * miss + 0.5 * u * u - 2.0 * k * x * (-k * x * x).exp(), w * miss * l * q[1].cos()]
}

/// End stops at ±l: V = ½ k max(|x| − l, 0)²; b = [k, l].
pub struct Stops;

impl PotentialEnergy<1, 2> for Stops {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, b: &SVector<S, 2>, _t: S) -> S {
        let depth = (q[0].abs() - b[1]).max(S::from(0.0));
        b[0] * depth * depth * 0.5
    }
}

pub const STOPS: [f64; 2] = [50.0, 0.5];

/// θ follows x: Φ = x − a sin θ; b = [a].
pub struct Guide;

impl Constraint<2, 1, 1> for Guide {
    fn phi<S: Scalar>(&self, q: &Two<S>, b: &SVector<S, 1>, _t: S) -> SVector<S, 1> {
        SVector::from([q[0] - b[0] * q[1].sin()])
    }
}
