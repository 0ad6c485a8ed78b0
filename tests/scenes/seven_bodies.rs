//! Seven bodies in the plane on 7 angles with 6 loop equations: "Andrews' squeezing mechanism", with the data of E. Hairer and G. Wanner, Solving
//! Ordinary Differential Equations II (1996), section VII.7. One control: u = 1 is the motor's torque of 0.033 N m.
//!
//! q = (β, Θ, γ, Φ, δ, Ω, ε). Written twice: each formula whole, on all angles, and by parts on those that occur.

use hamiltonian_adjoint::{
    Constraint, Coordinate, Cost, CostPoint, Force, ForcePoint, KineticEnergy, PotentialEnergy, Scalar, Scene, Sum,
};
use nalgebra::{SVector, vector};

/// Masses in kg and moments of inertia in kg m².
const M: [f64; 7] = [0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498];
const J: [f64; 7] = [2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5];
/// Fixed points in m, and the spring.
const A: [f64; 2] = [-0.06934, -0.00227];
const B: [f64; 2] = [-0.03635, 0.03273];
const C: [f64; 2] = [0.014, 0.072];
const STIFFNESS: f64 = 4530.0;
const SLACK: f64 = 0.07785;
/// Lengths in m, by their names there.
const D: f64 = 0.028;
const DA: f64 = 0.0115;
const E: f64 = 0.02;
const EA: f64 = 0.01421;
const RR: f64 = 0.007;
const RA: f64 = 0.00092;
const SS: f64 = 0.035;
const SA: f64 = 0.01874;
const SB: f64 = 0.01043;
const SC: f64 = 0.018;
const SD: f64 = 0.02;
const TA: f64 = 0.02308;
const TB: f64 = 0.00916;
const U: f64 = 0.04;
const UA: f64 = 0.01228;
const UB: f64 = 0.00449;
const ZF: f64 = 0.02;
const ZT: f64 = 0.04;
const FA: f64 = 0.01421;
const TORQUE: f64 = 0.033;

const START: [f64; 7] = [
    -0.061_713_890_014_276_45,
    0.0,
    0.455_279_819_163_070_4,
    0.222_668_390_165_885_9,
    0.487_364_979_543_842_55,
    -0.222_668_390_165_885_9,
    1.230_547_444_549_821_2,
];

/// ½ vᵀ M v of crank and coupler, by (Θ; β̇, Θ̇).
fn crank<S: Scalar>(theta: S, [v, w]: [S; 2]) -> S {
    let cos = theta.cos();
    let both = -(cos * (DA * RR)) + DA * DA;
    let own = -(cos * (2.0 * DA * RR)) + (RR * RR + DA * DA);
    let turn = v * v * (M[0] * RA * RA + J[0] + J[1]) + own * v * v * M[1];
    (turn + (both * M[1] + J[1]) * v * w * 2.0 + w * w * (M[1] * DA * DA + J[1])) * 0.5
}

/// Of the lever on the spring, by γ̇.
fn lever<S: Scalar>(v: S) -> S {
    v * v * (0.5 * (M[2] * (SA * SA + SB * SB) + J[2]))
}

/// Of the next two bodies, by (Φ; Φ̇, δ̇).
fn upper<S: Scalar>(phi: S, [v, w]: [S; 2]) -> S {
    let (arm, sin) = (E - EA, phi.sin());
    let both = sin * (ZT * arm) + arm * arm;
    let own = sin * (2.0 * ZT * arm) + (ZT * ZT + arm * arm);
    let turn = own * w * w * M[3] + w * w * (M[4] * (TA * TA + TB * TB) + J[3] + J[4]);
    (v * v * (M[3] * arm * arm + J[3]) + (both * M[3] + J[3]) * v * w * 2.0 + turn) * 0.5
}

/// Of the last two, by (Ω; Ω̇, ε̇).
fn lower<S: Scalar>(omega: S, [v, w]: [S; 2]) -> S {
    let (arm, sin) = (ZF - FA, omega.sin());
    let both = -(sin * (U * arm)) + arm * arm;
    let own = -(sin * (2.0 * U * arm)) + (U * U + arm * arm);
    let turn = own * w * w * M[5] + w * w * (M[6] * (UA * UA + UB * UB) + J[5] + J[6]);
    (v * v * (M[5] * arm * arm + J[5]) + (both * M[5] + J[5]) * v * w * 2.0 + turn) * 0.5
}

/// ½ c (l − l₀)² of the spring, by γ.
fn spring<S: Scalar>(gamma: S) -> S {
    let (sin, cos) = gamma.sin_cos();
    let x = cos * SD + sin * SC + (B[0] - C[0]);
    let y = sin * SD - cos * SC + (B[1] - C[1]);
    let strain = x.hypot(y) - SLACK;
    strain * strain * (0.5 * STIFFNESS)
}

/// The end of the coupler, by β and Θ.
fn coupler<S: Scalar>(beta: S, theta: S) -> [S; 2] {
    let ((sin, cos), (sin_sum, cos_sum)) = (beta.sin_cos(), (beta + theta).sin_cos());
    [cos * RR - cos_sum * D, sin * RR - sin_sum * D]
}

/// The loops of the coupler with the lever (γ), with the upper (Φ, δ) and the lower (Ω, ε) bodies.
fn loop_of_lever<S: Scalar>([beta, theta, gamma]: [S; 3]) -> [S; 2] {
    let ([x, y], (sin, cos)) = (coupler(beta, theta), gamma.sin_cos());
    [x - sin * SS - B[0], y + cos * SS - B[1]]
}

fn loop_of_upper<S: Scalar>([beta, theta, phi, delta]: [S; 4]) -> [S; 2] {
    let ([x, y], (sin, cos), (sin_sum, cos_sum)) = (coupler(beta, theta), delta.sin_cos(), (phi + delta).sin_cos());
    [x - sin_sum * E - cos * ZT - A[0], y + cos_sum * E - sin * ZT - A[1]]
}

fn loop_of_lower<S: Scalar>([beta, theta, omega, epsilon]: [S; 4]) -> [S; 2] {
    let ([x, y], (sin, cos), (sin_sum, cos_sum)) = (coupler(beta, theta), epsilon.sin_cos(), (omega + epsilon).sin_cos());
    [x - cos_sum * ZF - sin * U - A[0], y - sin_sum * ZF + cos * U - A[1]]
}

struct Whole;

impl KineticEnergy<7> for Whole {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 7>, v: &SVector<S, 7>, _b: &SVector<S, 0>) -> S {
        crank(q[1], [v[0], v[1]]) + lever(v[2]) + upper(q[3], [v[3], v[4]]) + lower(q[5], [v[5], v[6]])
    }
}

impl PotentialEnergy<7> for Whole {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 7>, _b: &SVector<S, 0>, _t: S) -> S {
        spring(q[2])
    }
}

impl Constraint<7, 6> for Whole {
    fn phi<S: Scalar>(&self, q: &SVector<S, 7>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 6> {
        let [a, b] = loop_of_lever([q[0], q[1], q[2]]);
        let [c, d] = loop_of_upper([q[0], q[1], q[3], q[4]]);
        let [e, f] = loop_of_lower([q[0], q[1], q[5], q[6]]);
        vector![a, b, c, d, e, f]
    }
}

struct Crank;
struct Lever;
struct Upper;
struct Lower;

impl KineticEnergy<2> for Crank {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, _b: &SVector<S, 0>) -> S {
        crank(q[1], [v[0], v[1]])
    }
}

impl KineticEnergy<1> for Lever {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        lever(v[0])
    }
}

impl KineticEnergy<2> for Upper {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, _b: &SVector<S, 0>) -> S {
        upper(q[0], [v[0], v[1]])
    }
}

impl KineticEnergy<2> for Lower {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, _b: &SVector<S, 0>) -> S {
        lower(q[0], [v[0], v[1]])
    }
}

impl PotentialEnergy<1> for Lever {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, _b: &SVector<S, 0>, _t: S) -> S {
        spring(q[0])
    }
}

impl Constraint<3, 2> for Lever {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 2> {
        loop_of_lever((*q).into()).into()
    }
}

impl Constraint<4, 2> for Upper {
    fn phi<S: Scalar>(&self, q: &SVector<S, 4>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 2> {
        loop_of_upper((*q).into()).into()
    }
}

impl Constraint<4, 2> for Lower {
    fn phi<S: Scalar>(&self, q: &SVector<S, 4>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 2> {
        loop_of_lower((*q).into()).into()
    }
}

struct Motor;

impl Force<1, 1> for Motor {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        vector![at.u[0] * TORQUE]
    }
}

/// ½ (γ − 0.5)² at the end.
struct Aim;

impl Cost<1> for Aim {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        let error = at.q[0] - 0.5;
        error * error * 0.5
    }
}

fn scene() -> (Scene, [Coordinate; 7]) {
    let mut scene = Scene::new();
    let q = scene.coordinates("angle", ["beta", "theta", "gamma", "phi", "delta", "omega", "epsilon"]);
    q.iter().zip(START).for_each(|(q, value)| scene.place(*q, value));
    let torque = scene.control("torque");
    scene.force("motor", Motor, [q[0]], [torque], []);
    scene.cost("aim", Aim, Sum::Terminal, [q[2]], [], [], []);
    (scene, q)
}

/// One kinetic energy, one potential energy and one constraint of all angles.
pub fn whole() -> Scene {
    let (mut scene, q) = scene();
    scene.kinetic_energy("bodies", Whole, q, []);
    scene.potential_energy("spring", Whole, q, []);
    scene.constraint("loops", Whole, q, []);
    scene
}

/// Four kinetic energies, one potential energy of one angle, three constraints.
pub fn by_parts() -> Scene {
    let (mut scene, [beta, theta, gamma, phi, delta, omega, epsilon]) = scene();
    scene.kinetic_energy("crank", Crank, [beta, theta], []);
    scene.kinetic_energy("lever", Lever, [gamma], []);
    scene.kinetic_energy("upper", Upper, [phi, delta], []);
    scene.kinetic_energy("lower", Lower, [omega, epsilon], []);
    scene.potential_energy("spring", Lever, [gamma], []);
    scene.constraint("loop of the lever", Lever, [beta, theta, gamma], []);
    scene.constraint("upper loop", Upper, [beta, theta, phi, delta], []);
    scene.constraint("lower loop", Lower, [beta, theta, omega, epsilon], []);
    scene
}
