//! Elements of your own: a bead with air drag on a wire y = a x² that is shaken up and down.
//!
//! The wire is a `Constraint` driven in time, the drag a `Force`, the bead's inertia a `KineticEnergy`; the shape a is a design
//! variable. Each is one formula; its Jacobians, dΦ/dt and all derivatives for the adjoint are computed from it.
//!
//! `cargo run --release --example own_element`

use std::error::Error;

use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::planar::Weight;
use hamiltonian_adjoint::{
    Constraint, Cost, CostPoint, Force, ForcePoint, Grid, Inputs, KineticEnergy, Scalar, Scene, Settings, Solver, Sum,
};
use nalgebra::{SVector, Vector1, Vector2, Vector3};

/// T = ½ m (ẋ² + ẏ²), b = [m].
struct PointMass;

impl KineticEnergy<2, 1> for PointMass {
    fn kinetic_energy<S: Scalar>(&self, _q: &Vector2<S>, v: &Vector2<S>, b: &Vector1<S>) -> S {
        b[0] * v.dot(v) * 0.5
    }
}

/// Φ = y − a x² − A (1 − cos ω t), b = [a, A, ω].
struct ShakenParabola;

impl Constraint<2, 1, 3> for ShakenParabola {
    fn phi<S: Scalar>(&self, q: &Vector2<S>, b: &Vector3<S>, t: S) -> Vector1<S> {
        let lift = b[1] * (-(b[2] * t).cos() + 1.0);
        Vector1::new(q[1] - b[0] * q[0] * q[0] - lift)
    }
}

/// Q = u in x, and −c |v| v in both directions, b = [c].
struct PushAndDrag;

impl Force<2, 1, 1> for PushAndDrag {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 1>, b: &Vector1<S>) -> Vector2<S> {
        // The small constant keeps the root differentiable at rest.
        let speed = (at.v.dot(&at.v) + 1e-12).sqrt();
        at.v * -(b[0] * speed) + Vector2::new(at.u[0], S::zero())
    }
}

/// S = ½ x² + ½ (0.1 s · ẋ)²: deviation from rest at the bottom.
struct AtBottom;

impl Cost<1> for AtBottom {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        (at.q[0].powi(2) + (at.v[0] * 0.1).powi(2)) * 0.5
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let (a, mass, amplitude, frequency) = (0.8, 0.2, 0.02, 25.0);
    let mut scene = Scene::new();
    let [x, y] = scene.coordinates("bead", ["x", "y"]);
    scene.place(x, 0.5);
    scene.place(y, a * 0.5f64.powi(2));
    let shape = scene.design("shape", a);
    let push = scene.control("push");
    scene.kinetic_energy("inertia", PointMass, [x, y], [mass.into()]);
    scene.potential_energy("weight", Weight, [x, y], [mass.into(), 0.0.into(), (-9.81).into()]);
    scene.constraint("wire", ShakenParabola, [x, y], [shape.into(), amplitude.into(), frequency.into()]);
    scene.force("push and drag", PushAndDrag, [x, y], [push], [0.05.into()]);
    scene.cost("at the bottom", AtBottom, Sum::Terminal, [x], [], [], []);
    let system = scene.compile()?;

    let steps = 300;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 0.005));
    inputs.controls.fill(0.1);
    let settings = Settings::default();
    let mut solver = Solver::new(&system, settings);
    solver.simulate(&inputs)?;
    let motion = solver.trajectory();
    let phi = motion.phi(&system, solver.inputs())?;
    for i in (0..=steps).step_by(50) {
        println!(
            "t = {:.2} s: x {:+.4} m, y {:.4} m, Φ {:+.1e} m",
            motion.times[i],
            motion.q[(0, i)],
            motion.q[(1, i)],
            phi[(0, i)]
        );
    }

    // dJ/d(shape) is the derivative with q₀ held constant; for a q₀ that depends on design variables see the example design_parameters.
    let gradient = solver.gradient()?;
    println!("J = {:.12}", gradient.value);
    let with =
        [Input::Design(shape.index()), Input::Control { channel: 0, node: 0 }, Input::Control { channel: 0, node: 150 }];
    for (input, reference) in with.iter().zip(complex_step(&system, &inputs, settings, &with)?) {
        let ours = input.in_gradient(gradient);
        println!("dJ/d({}) = {ours:+.10e}, by complex step {reference:+.10e}", input.name(&system));
        assert!((ours - reference).abs() <= 1e-10 * reference.abs(), "the derivatives differ");
    }
    Ok(())
}
