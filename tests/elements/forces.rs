//! What forces and joints between two bodies must obey whatever their formula: action and reaction, and the power that a hand formula gives.

use crate::common::bench::number;
use hamiltonian_adjoint::planar::{
    Actuator, Body, Damper, Distance, JointFriction, LinearSpring, Prismatic, Revolute, SlidingFriction, TorqueActuator,
    TorsionalSpring, Weld, ZeroLengthSpring,
};
use hamiltonian_adjoint::{Constraint, Force, ForcePoint, Grid, Inputs, PotentialEnergy, Scene, Settings, Solver};
use nalgebra::SVector;
use num_dual::{Dual64, DualVec64, gradient};

type Coordinates = SVector<f64, 6>;

/// Two bodies somewhere in motion, and a force u.
fn somewhere(seed: usize) -> ForcePoint<f64, 6, 1> {
    let q = SVector::from_fn(|i, _| number(seed + i));
    let v = SVector::from_fn(|i, _| 2.0 * number(seed + 10 + i));
    ForcePoint { q, v, u: SVector::from([1.7]), t: 0.0 }
}

fn without_control(at: &ForcePoint<f64, 6, 1>) -> ForcePoint<f64, 6, 0> {
    ForcePoint { q: at.q, v: at.v, u: SVector::zeros(), t: at.t }
}

/// s_a, s_b, then what an element needs besides.
const POINTS: [f64; 4] = [0.3, -0.2, 0.5, 0.4];
const AXIS: f64 = 0.6;

fn with<const P: usize>(more: &[f64]) -> SVector<f64, P> {
    SVector::from_fn(|i, _| if i < 4 { POINTS[i] } else { more[i - 4] })
}

/// The vector between the points, by complex numbers: z_b + e^{iφ_b} s_b − z_a − e^{iφ_a} s_a.
fn between(q: &Coordinates) -> num_complex::Complex64 {
    use num_complex::Complex64 as C;
    let point = |x: f64, y: f64, phi: f64, s: &[f64]| C::new(x, y) + C::cis(phi) * C::new(s[0], s[1]);
    point(q[3], q[4], q[5], &POINTS[2..]) - point(q[0], q[1], q[2], &POINTS[..2])
}

/// The rate of a function of the coordinates, by central differences.
fn rate(at: &ForcePoint<f64, 6, 1>, f: impl Fn(&Coordinates) -> f64) -> f64 {
    let step = 1e-5;
    (f(&(at.q + at.v * step)) - f(&(at.q - at.v * step))) / (2.0 * step)
}

fn distance(q: &Coordinates) -> f64 {
    between(q).norm()
}

/// The position of b's point along the axis of a.
fn along(q: &Coordinates) -> f64 {
    (between(q) * num_complex::Complex64::cis(-(q[2] + AXIS))).re
}

fn twist(q: &Coordinates) -> f64 {
    q[5] - q[2]
}

/// Q, −V_q or Φ_qᵀσ of every element between two bodies, with the power that it should give (none for joints).
fn all(at: &ForcePoint<f64, 6, 1>) -> Vec<(&'static str, Coordinates, Option<f64>)> {
    let (free, u) = (without_control(at), at.u[0]);
    let (approach, slide, turn) = (rate(at, distance), rate(at, along), rate(at, twist));
    let stretch = |c: f64, rest: f64| -c * (distance(&at.q) - rest) * approach;
    let wind = |c: f64, rest: f64| -c * (twist(&at.q) - rest) * turn;
    vec![
        ("spring", force_of(&LinearSpring, at, with::<6>(&[30.0, 0.5])), Some(stretch(30.0, 0.5))),
        ("spring without length", force_of(&ZeroLengthSpring, at, with::<5>(&[30.0])), Some(stretch(30.0, 0.0))),
        ("damper", Damper.force(&free, &with::<5>(&[2.0])), Some(-2.0 * approach * approach)),
        ("torsional spring", force_of(&TorsionalSpring, at, SVector::from([3.0, 0.4])), Some(wind(3.0, 0.4))),
        ("joint friction", JointFriction.force(&free, &SVector::from([0.3])), Some(-0.3 * turn * turn)),
        ("sliding friction", SlidingFriction.force(&free, &with::<6>(&[AXIS, 1.5])), Some(-1.5 * slide * slide)),
        ("actuator", Actuator.force(at, &with::<5>(&[AXIS])), Some(u * slide)),
        ("torque actuator", TorqueActuator.force(at, &SVector::zeros()), Some(u * turn)),
        ("prismatic", reaction_of(&Prismatic, at, with::<6>(&[AXIS, 0.2])), None),
        ("distance", reaction_of(&Distance, at, with::<5>(&[0.9])), None),
    ]
}

/// −V_q.
fn force_of<E, const P: usize>(element: &E, at: &ForcePoint<f64, 6, 1>, b: SVector<f64, P>) -> Coordinates
where
    E: PotentialEnergy<6, P>,
{
    let (_, slope) = gradient(|q| element.potential_energy(&q, &b.map(DualVec64::from_re), DualVec64::from_re(at.t)), &at.q);
    -slope
}

/// Φ_qᵀσ with some σ.
fn reaction_of<E, const M: usize, const P: usize>(element: &E, at: &ForcePoint<f64, 6, 1>, b: SVector<f64, P>) -> Coordinates
where
    E: Constraint<6, M, P>,
{
    SVector::from_fn(|i, _| {
        let mut q = at.q.map(Dual64::from_re);
        q[i].eps = 1.0;
        let phi = element.phi(&q, &b.map(Dual64::from_re), Dual64::from_re(at.t));
        phi.iter().enumerate().map(|(j, phi)| phi.eps * (0.7 + j as f64)).sum()
    })
}

#[test]
fn forces_and_reactions_on_two_bodies_cancel_and_so_do_their_moments() {
    for at in [somewhere(0), somewhere(50)] {
        for (name, f, _) in all(&at) {
            assert_cancels(name, &at.q, &f);
        }
        // A hinge's and a weld's forces meet in one point only where the points coincide.
        let (mut closed, gap) = (at, between(&at.q));
        closed.q[3] -= gap.re;
        closed.q[4] -= gap.im;
        assert_cancels("revolute", &closed.q, &reaction_of(&Revolute, &closed, with::<4>(&[])));
        assert_cancels("weld", &closed.q, &reaction_of(&Weld, &closed, with::<5>(&[0.2])));
    }
}

fn assert_cancels(name: &str, q: &Coordinates, f: &Coordinates) {
    let moment = |k: usize| q[k] * f[k + 1] - q[k + 1] * f[k] + f[k + 2];
    let sums = [f[0] + f[3], f[1] + f[4], moment(0) + moment(3)];
    assert!(sums.iter().all(|sum| sum.abs() < 1e-13 * f.amax()), "{name}: {sums:?} of {f:?}");
}

#[test]
fn forces_deliver_the_power_that_their_hand_formulas_give() {
    for at in [somewhere(0), somewhere(50)] {
        for (name, f, power) in all(&at).into_iter().filter_map(|(name, f, power)| Some((name, f, power?))) {
            // Central differences have some 1e-9 of error.
            let error = (f.dot(&at.v) - power).abs() / power.abs();
            assert!(error < 1e-7, "{name}: Qᵀv is {} W instead of {power} W", f.dot(&at.v));
        }
    }
}

/// A spring without free length is smooth where its points coincide: from there a particle swings as v₀/ω sin ωt.
#[test]
fn points_of_a_spring_without_length_may_coincide() {
    let mut scene = Scene::new();
    let mass = scene.particle("mass", 2.0, [0.0; 2]);
    scene.spring_damper("spring", Body::GROUND.at(0.0, 0.0), mass.point(), 8.0, 0.0, 0.0);
    scene.end_state(mass.coordinates[0]);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(1000, 1e-3));
    inputs.start.rate_mut()[0] = 3.0;
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("a motion");
    // ω² = 8/2, v₀ = 3 m/s.
    let (position, rate) = (1.5 * 2f64.sin(), 3.0 * 2f64.cos());
    let outputs = solver.outputs().expect("outputs");
    assert!((outputs[0] - position).abs() < 1e-5 && (outputs[1] - rate).abs() < 1e-5, "{outputs}");
    let gradients = solver.jacobian().expect("gradients of the outputs");
    let slope = gradients[0].start.rate()[0];
    assert!((slope - position / 3.0).abs() < 1e-5, "{slope}");
}
