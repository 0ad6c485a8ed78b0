//! Products with Hessians and Jacobians, compared with hyper-dual numbers.

use hamiltonian_adjoint::check::Input;
use hamiltonian_adjoint::{Error, Gradient, Hyper, Inputs, LiftedSolver, LongSolver, Real, Settings, Solver, System};

/// A direction of all inputs.
pub fn direction(inputs: &Inputs, seed: usize) -> Inputs {
    let mut direction = inputs.no_change();
    for (k, input) in Input::all(inputs).into_iter().enumerate() {
        let size = if matches!(input, Input::Step(_)) { 0.01 } else { 0.1 };
        *input.of(&mut direction) = size * ((seed + 7 * k) as f64).sin();
    }
    direction
}

pub fn along(gradient: &Gradient, direction: &Inputs) -> f64 {
    let mut own = direction.clone();
    Input::all(direction).into_iter().map(|input| *input.of(&mut own) * input.in_gradient(gradient)).sum()
}

pub fn near(what: &str, own: f64, reference: f64, within: f64) {
    let error = (own - reference).abs() / reference.abs();
    println!("{what}: {error:.1e}");
    assert!(error < within, "{what}: {own} for {reference}");
}

/// The motion in hyper-dual numbers along two directions.
pub fn lifted_along(
    system: &System,
    given: &Inputs,
    settings: Settings,
    directions: [&Inputs; 2],
) -> Result<LiftedSolver<Hyper>, Error> {
    let mut lifted = LiftedSolver::<Hyper>::new(system, given, settings)?;
    let mut moved = given.lift::<Hyper>();
    for (part, direction) in (1..).zip(directions) {
        let mut own = direction.clone();
        Input::all(given).iter().for_each(|input| input.of(&mut moved).add_to_part(part, *input.of(&mut own)));
    }
    lifted.simulate(&moved)?;
    Ok(lifted)
}

/// Asserts that products with the Hessian and Jacobians are those of hyper-dual numbers, and that checkpoints give the same bits.
pub fn assert_products_are_exact(system: &System, given: &Inputs, settings: Settings) -> Result<(), Error> {
    let mut solver = Solver::new(system, settings);
    solver.simulate(given)?;
    let (a, b) = (direction(given, 1), direction(given, 1001));
    // Before any gradient was computed.
    let of_a = solver.hessian_product(&a)?.clone();
    let lifted = lifted_along(system, given, settings, [&a, &b])?;
    let (cost, outputs) = (lifted.cost()?, lifted.outputs()?);
    near("Hessian", along(&of_a, &b), cost.part(3), 1e-9);
    near("slope of the product", of_a.value, cost.part(1), 1e-11);
    near("gradient", along(solver.gradient()?, &b), cost.part(2), 1e-11);
    let (jacobian, forward) = (solver.jacobian()?, solver.push_forward(&a)?);
    for (k, row) in jacobian.iter().enumerate() {
        near("row of the Jacobian", along(row, &a), outputs[k].part(1), 1e-11);
        near("column of the Jacobian", forward[k], outputs[k].part(1), 1e-11);
    }
    let weights = &[0.7, -1.3, 0.4][..system.outputs()];
    let weighted = solver.weighted_gradient(0.4, weights)?.clone();
    let of_outputs = |part: usize| weights.iter().zip(&outputs).map(|(weight, x)| weight * x.part(part)).sum::<f64>();
    let sum = |part: usize| 0.4 * cost.part(part) + of_outputs(part);
    near("weighted gradient", along(&weighted, &a), sum(1), 1e-11);
    near("Hessian of the weighted sum", along(solver.hessian_product(&a)?, &b), sum(3), 1e-9);
    let bytes = 30 * system.bytes_per_node(&settings);
    let mut long = LongSolver::new(system, settings, bytes + 20_000);
    let (own, solver_gradient) = (long.gradient(given)?.clone(), solver.gradient()?.clone());
    assert!(own == solver_gradient, "checkpoints");
    assert!(long.jacobian(given)? == jacobian, "the Jacobian with checkpoints");
    Ok(())
}
