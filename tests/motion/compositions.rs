//! Compositions of the trapezoidal rule: their orders, and that the adjoint is exact on their grids.

use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::{Composition, Cost, CostPoint, Grid, Inputs, Scalar, Settings, Solver, Sum, System};
use hamiltonian_adjoint::{gradient, scenes::CartPendulum};
use nalgebra::SVector;
use serde_json::Value;

/// The end of the motion, s.
const END: f64 = 2.0;

/// The constant force of 10 N on a composed grid.
fn inputs(system: &System, macro_steps: usize, composition: Composition) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::composed(macro_steps, END / macro_steps as f64, composition));
    inputs.controls.fill(10.0);
    inputs
}

/// x of the cart and the angles of the links at t = 2 s, integrated in minimal coordinates (`tests/data/README.md`).
fn converged() -> Vec<f64> {
    let file: Value = serde_json::from_str(include_str!("../data/converged_t2_const10.json")).expect("JSON");
    let motion = &file[0];
    assert_eq!(motion["cr_joint"], 0);
    let angles = motion["phi"].as_array().expect("angles").iter();
    std::iter::once(&motion["x"]).chain(angles).map(|x| x.as_f64().expect("a number")).collect()
}

/// The largest error of them.
fn error(solver: &mut Solver, macro_steps: usize, composition: Composition) -> f64 {
    let end = solver.simulate(&inputs(solver.system(), macro_steps, composition)).expect("a motion");
    let q = end.q.column(end.q.ncols() - 1);
    let ours = [q[0], q[5], q[8], q[11]];
    ours.iter().zip(converged()).fold(0.0, |largest, (ours, converged)| largest.max((ours - converged).abs()))
}

#[test]
fn the_motion_converges_with_the_order_of_the_composition() {
    let system = CartPendulum::default().scene().compile().expect("scene");
    let mut solver = Solver::new(&system, Settings::default());
    for (composition, coarse, tolerance) in [
        (Composition::Trapezoidal, 400, 0.05),
        (Composition::Suzuki4, 100, 0.1),
        (Composition::Yoshida6, 100, 0.2),
        (Composition::KahanLi6, 50, 0.2),
    ] {
        let [first, second] = [coarse, 2 * coarse].map(|macro_steps| error(&mut solver, macro_steps, composition));
        let order = (first / second).log2();
        println!("{composition:?}: errors {first:.2e}, {second:.2e}, order {order:.3}");
        assert!((order - composition.order() as f64).abs() < tolerance, "{composition:?}: {order}");
    }
}

/// h = ½ x² + u x/100, of the cart.
struct Displacement;

impl Cost<1, 0, 1, 0> for Displacement {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 1>, _: &SVector<S, 0>) -> S {
        at.q[0] * (at.q[0] * 0.5 + at.u[0] * 0.01)
    }
}

/// The cart with links and, besides the terminal cost, an integral of a running cost.
fn system_with_running_cost() -> System {
    let mut scene = CartPendulum::default().mechanism();
    let x = scene.cart.coordinates[0];
    scene.scene.cost("displacement", Displacement, Sum::Trapezoidal, [x], [], [scene.force], []);
    scene.scene.compile().expect("scene")
}

#[test]
fn an_integral_by_the_trapezoidal_rule_has_the_order_of_the_composition() {
    let system = system_with_running_cost();
    let mut solver = Solver::new(&system, Settings::default());
    let mut cost = |macro_steps, composition| {
        solver.simulate(&inputs(&system, macro_steps, composition)).expect("a motion");
        solver.cost().expect("cost")
    };
    let converged = cost(400, Composition::KahanLi6);
    for (composition, coarse, tolerance) in
        [(Composition::Trapezoidal, 200, 0.05), (Composition::Suzuki4, 100, 0.1), (Composition::Yoshida6, 80, 0.3)]
    {
        let [first, second] = [coarse, 2 * coarse].map(|macro_steps| (cost(macro_steps, composition) - converged).abs());
        let order = (first / second).log2();
        println!("{composition:?}: errors {first:.2e}, {second:.2e}, order {order:.3}");
        assert!((order - composition.order() as f64).abs() < tolerance, "{composition:?}: {order}");
    }
}

#[test]
fn the_gradient_on_composed_grids_is_that_of_complex_step() {
    let plain = CartPendulum::default().scene().compile().expect("scene");
    for system in [plain, system_with_running_cost()] {
        for composition in Composition::ALL {
            let inputs = inputs(&system, 20, composition);
            let adjoint = gradient(&system, &inputs, Settings::default()).expect("a gradient");
            let all = Input::all(&inputs);
            let reference = complex_step(&system, &inputs, Settings::default(), &all).expect("complex step");
            // Controls, initial values and step lengths, each kind relative to its own largest.
            for kind in all.chunk_by(|a, b| std::mem::discriminant(a) == std::mem::discriminant(b)) {
                let reference = &reference[all.iter().position(|input| *input == kind[0]).expect("it is one of all")..];
                let largest = kind.iter().zip(reference).fold(0.0f64, |largest, (_, r)| largest.max(r.abs()));
                let differences = kind.iter().zip(reference).map(|(input, r)| (input.in_gradient(&adjoint) - r).abs());
                let worst = differences.fold(0.0, f64::max) / largest;
                println!("{composition:?}, {:?} …: {worst:.1e}", kind[0]);
                assert!(worst <= 1e-12, "{composition:?}, {:?} …: {worst:.1e}", kind[0]);
            }
        }
    }
}
