//! Products of the Hessian: symmetric, and those of hyper-dual numbers through the whole simulation.

#[path = "common/bench.rs"]
#[allow(dead_code)]
mod bench;
#[allow(dead_code)]
mod common;
#[path = "scenes/varying.rs"]
#[allow(dead_code)]
mod varying;

use bench::{Bench, from_velocity, lively, number};
use hamiltonian_adjoint::check::Input;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Gradient, Grid, Hyper, Inputs, LiftedSolver, Real, Scheme, Settings, Solver, Sum, System};

/// A direction in which every input moves, as far as it is large.
fn direction(inputs: &Inputs, seed: usize) -> Inputs {
    let mut direction = inputs.no_change();
    for (k, input) in Input::all(inputs).into_iter().enumerate() {
        let size = match input {
            Input::Step(i) => 0.3 * inputs.grid.steps[i - 1],
            Input::Design(p) => 0.3 * inputs.design[p],
            _ => 0.3,
        };
        *input.of(&mut direction) = size * number(seed + 7 * k);
    }
    direction
}

/// All inputs with their values.
fn values(inputs: &Inputs) -> Vec<(Input, f64)> {
    let mut own = inputs.clone();
    Input::all(inputs).into_iter().map(|input| (input, *input.of(&mut own))).collect()
}

fn along(gradient: &Gradient, direction: &Inputs) -> f64 {
    values(direction).into_iter().map(|(input, d)| input.in_gradient(gradient) * d).sum()
}

fn size_along(gradient: &Gradient, direction: &Inputs) -> f64 {
    values(direction).into_iter().map(|(input, d)| (input.in_gradient(gradient) * d).abs()).sum()
}

/// The second derivative of J along two directions, and the first along one, by hyper-dual numbers.
fn by_hyper(system: &System, inputs: &Inputs, settings: Settings, [first, second]: [&Inputs; 2]) -> [f64; 2] {
    let mut solver = LiftedSolver::<Hyper>::new(system, inputs, settings).expect("a motion");
    let mut lifted = inputs.lift::<Hyper>();
    for (part, direction) in [(1, first), (2, second)] {
        for (input, d) in values(direction) {
            input.of(&mut lifted).add_to_part(part, d);
        }
    }
    solver.simulate(&lifted).expect("the same motion");
    let cost = solver.cost().expect("a cost");
    [cost.part(3), cost.part(1)]
}

/// Symmetric, and equal to hyper-dual numbers; returns the larger error, relative to the terms.
fn error(what: &str, system: &System, inputs: &Inputs, settings: Settings) -> f64 {
    let (a, b) = (direction(inputs, 1), direction(inputs, 1001));
    let mut solver = Solver::new(system, settings);
    solver.simulate(inputs).unwrap_or_else(|error| panic!("{what}: {error}"));
    let of_a = solver.hessian_product(&a).unwrap_or_else(|error| panic!("{what}: {error}")).clone();
    let of_b = solver.hessian_product(&b).unwrap_or_else(|error| panic!("{what}: {error}")).clone();
    let (ab, ba) = (along(&of_a, &b), along(&of_b, &a));
    let size = size_along(&of_a, &b).max(size_along(&of_b, &a));
    let [reference, slope] = by_hyper(system, inputs, settings, [&a, &b]);
    let (asymmetry, error) = ((ab - ba).abs() / size, (ab - reference).abs() / size);
    let of_value = (of_a.value - slope).abs() / slope.abs();
    println!("{what:40} asymmetry {asymmetry:.1e}, error {error:.1e}, of the value {of_value:.1e}");
    assert!(asymmetry < 1e-12, "{what}: {ab} {ba}");
    assert!(error < 1e-10, "{what}: {ab} {reference}");
    assert!(of_value < 1e-10, "{what}: {} {slope}", of_a.value);
    asymmetry.max(error)
}

#[test]
fn products_of_the_cart_are_exact() {
    let system = CartPendulum::default().scene().compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
    inputs.controls.fill(10.0);
    error("cart", &system, &inputs, Settings::default());
}

#[test]
fn products_are_exact_for_loops_and_design_variables() {
    for sum in [Sum::Plain, Sum::Rectangle, Sum::Trapezoidal, Sum::Integral, Sum::Node(3)] {
        for (name, build) in [("four bar", Bench::four_bar as fn(&mut Bench)), ("five bar", Bench::five_bar)] {
            let mut bench = Bench::new();
            build(&mut bench);
            let system = bench.compile(sum);
            let inputs = lively(&system, 12, 0.02);
            for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK4] {
                let settings = Settings { scheme, ..Settings::default() };
                let what = format!("{name}, {sum:?}, {}", scheme.name);
                error(&what, &system, &inputs, settings);
                error(&format!("{what}, from velocities"), &system, &from_velocity(&system, &inputs), settings);
            }
        }
    }
}
