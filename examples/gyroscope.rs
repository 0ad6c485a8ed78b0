//! A gyroscope in two rings: a weight at the inner ring lets it precess. The angle of precession, and its derivatives with respect to the weight and to the
//! spin of the rotor, beside those of a fast gyroscope, m g l/(J ω).
//!
//! `cargo run --release --example gyroscope`

use hamiltonian_adjoint::spatial::{Body, Inertia};
use hamiltonian_adjoint::{Error, Grid, Inputs, Scene, Settings, Solver, check};

fn main() -> Result<(), Error> {
    let (spin, arm, axial) = (200.0, 0.1, 4e-3);
    let mut scene = Scene::new();
    let weight = scene.design("weight", 0.2); // kg
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let outer = space.body("outer ring", Inertia::principal(0.3, [1e-3, 1e-3, 2e-3]));
    let inner = space.body("inner ring", Inertia::principal(0.2, [6e-4, 1e-3, 6e-4]));
    let rotor = space.body("rotor", Inertia::principal(1.5, [2e-3, axial, 2e-3]));
    let load = space.body("load", Inertia::point(weight));
    let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let precession = space.revolute("outer bearing", Body::GROUND.origin().along(z), outer.origin().along(z));
    let tilt = space.revolute("inner bearing", outer.origin().along(x), inner.origin().along(x));
    let axle = space.revolute("axle", inner.origin().along(y), rotor.origin().along(y));
    space.fixed("hook", inner.at([0.0, arm, 0.0]), load.origin());
    // Without friction the rings would nod for ever.
    scene.axis_spring_damper("grease", tilt.angle, 0.0, 0.0, 0.3);
    let turned = scene.end_state(precession.angle);
    let system = scene.compile()?;

    let mut inputs = Inputs::at_rest(&system, Grid::uniform(2000, 5e-4)); // 1 s
    inputs.start.set_rate(axle.angle, spin);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs)?;
    let jacobian = solver.jacobian()?;
    let of = &jacobian[turned.position.index()];
    let (by_weight, by_spin) = (of.design[weight.index()], of.start.rate()[axle.angle.index()]);
    let fast = 0.2 * 9.81 * arm / (axial * spin);
    println!("precession {:.5} rad in 1 s; of a fast gyroscope {fast:.5} rad", of.value);
    println!("by the weight {by_weight:.5} rad/kg ({:.5}), by the spin {by_spin:.3e} s ({:.3e})", fast / 0.2, -fast / spin);
    assert!((of.value - fast).abs() < 0.02 * fast && (by_weight - fast / 0.2).abs() < 0.03);
    check::gradient(&system, &inputs, Settings::default()).output(turned.position).run()?.assert_passed();
    Ok(())
}
