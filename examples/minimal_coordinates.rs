//! A mechanism as one element in minimal coordinates: a double pendulum with M(q) in its two angles.
//!
//! There are no bodies and no constraints: T and V are written as on paper, and all other terms follow from them, including
//! T_q for M(q). The control is a torque at the shoulder.
//!
//! `cargo run --release --example minimal_coordinates`

use std::error::Error;

use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::{
    Cost, CostPoint, Force, ForcePoint, Grid, Inputs, KineticEnergy, PotentialEnergy, Scalar, Scene, Settings, Solver, Sum,
};
use nalgebra::{SVector, Vector2, Vector4};

/// Point masses m₁, m₂ on massless rods l₁, l₂; q = absolute angles from below; b = [m₁, l₁, m₂, l₂].
#[derive(Clone, Copy)]
struct DoublePendulum;

impl KineticEnergy<2, 4> for DoublePendulum {
    fn kinetic_energy<S: Scalar>(&self, q: &Vector2<S>, v: &Vector2<S>, b: &Vector4<S>) -> S {
        let [m1, l1, m2, l2] = [b[0], b[1], b[2], b[3]];
        let (v1, v2) = (l1 * v[0], l2 * v[1]);
        // ½ vᵀ M(q) v
        (m1 * v1 * v1 + m2 * (v1 * v1 + v2 * v2 + v1 * v2 * (q[0] - q[1]).cos() * 2.0)) * 0.5
    }
}

impl PotentialEnergy<2, 4> for DoublePendulum {
    fn potential_energy<S: Scalar>(&self, q: &Vector2<S>, b: &Vector4<S>, _t: S) -> S {
        let [m1, l1, m2, l2] = [b[0], b[1], b[2], b[3]];
        let (y1, y2) = (-(l1 * q[0].cos()), -(l2 * q[1].cos()));
        (m1 * y1 + m2 * (y1 + y2)) * 9.81
    }
}

/// A torque u on the first angle.
struct Shoulder;

impl Force<1, 1> for Shoulder {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        at.u
    }
}

/// S = ½ |q|²: hang straight down at the end.
struct Hanging;

impl Cost<2> for Hanging {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q.dot(&at.q) * 0.5
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let q = scene.coordinates("pendulum", ["upper", "lower"]);
    scene.place(q[0], 1.5);
    scene.place(q[1], 2.0);
    let b = [1.0.into(), 0.5.into(), scene.design("lower mass", 0.8).into(), scene.design("lower length", 0.6).into()];
    scene.kinetic_energy("motion", DoublePendulum, q, b);
    scene.potential_energy("weight", DoublePendulum, q, b);
    let torque = scene.control("shoulder torque");
    scene.force("shoulder", Shoulder, [q[0]], [torque], []);
    scene.cost("hanging", Hanging, Sum::Terminal, q, [], [], []);
    let system = scene.compile()?;

    let steps = 400;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 0.005));
    let settings = Settings::default();
    let mut solver = Solver::new(&system, settings);

    // Without a torque the energy is conserved up to the error of the trapezoidal rule, which falls like Δt².
    let motion = solver.simulate(&inputs)?;
    let b = Vector4::new(1.0, 0.5, 0.8, 0.6);
    let energy = |i: usize| {
        let [q, v] = [&motion.q, &motion.v].map(|x| Vector2::new(x[(0, i)], x[(1, i)]));
        DoublePendulum.kinetic_energy(&q, &v, &b) + DoublePendulum.potential_energy(&q, &b, 0.0)
    };
    for i in (0..=steps).step_by(80) {
        let (t, upper, lower) = (motion.times[i], motion.q[(0, i)], motion.q[(1, i)]);
        println!("t = {t:.1} s: angles {upper:+.4} {lower:+.4}, energy {:+.6} J", energy(i));
    }

    for (i, u) in inputs.controls.iter_mut().enumerate() {
        *u = (0.05 * i as f64).sin();
    }
    solver.simulate(&inputs)?;
    let gradient = solver.gradient()?;
    println!("J = {:.12}", gradient.value);
    let torque_at = |node| Input::Control { channel: 0, node };
    let with = [torque_at(0), torque_at(200), Input::Design(0), Input::Design(1)];
    for (input, reference) in with.iter().zip(complex_step(&system, &inputs, settings, &with)?) {
        let ours = input.in_gradient(gradient);
        println!("dJ/d({}) = {ours:+.10e}, by complex step {reference:+.10e}", input.name(&system));
        assert!((ours - reference).abs() <= 1e-10 * reference.abs(), "the derivatives differ");
    }
    Ok(())
}
