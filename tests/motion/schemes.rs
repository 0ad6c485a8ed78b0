//! Every scheme has its order, and the exact gradient: for all inputs, and together with all that a motion may meet.

use crate::common::bench::{Bench, Part, number};
use crate::common::{
    assert_gradient_is_exact_to, assert_gradient_is_exact_with, assert_order, assert_says, largest_difference,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Composition, Error, Gradient, Grid, Inputs, KineticEnergy, LongSolver, PotentialEnergy, Scalar, Scene, Scheme, Settings,
    Solver, Start, Sum, System, check, gradient, paper_system::PaperSystem, simulate,
};
use nalgebra::{DVector, SVector};

fn with(scheme: Scheme) -> Settings {
    Settings { scheme, ..Settings::default() }
}

fn five_bar(sum: Sum) -> System {
    let mut bench = Bench::new();
    bench.five_bar();
    bench.compile(sum)
}

/// In motion, with a control that is linear in time, so that it is the same one on every grid.
fn moving(system: &System, grid: Grid) -> Inputs {
    let times = grid.times();
    let mut inputs = Inputs::at_rest(system, grid);
    inputs.controls.iter_mut().zip(times).for_each(|(u, t)| *u = 0.5 - 0.8 * t);
    let p_star = DVector::from_fn(system.n(), |i, _| 0.2 * number(i + 3));
    inputs.start = Start::Momentum { q: system.initial_coordinates(), p_star };
    inputs
}

/// Steps and controls without any pattern.
fn irregular(system: &System, steps: usize, dt: f64) -> Inputs {
    let mut inputs = moving(system, Grid::uniform(steps, dt));
    inputs.grid.steps.iter_mut().enumerate().for_each(|(i, dt)| *dt *= 1.0 + 0.5 * number(i));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 2.0 * number(i + 5));
    inputs
}

#[test]
fn states_multipliers_and_integrals_have_the_order_of_the_table() {
    let (system, end) = (five_bar(Sum::Integral), 0.6);
    let at_end = |scheme, steps: usize| {
        let inputs = moving(&system, Grid::uniform(steps, end / steps as f64));
        let mut solver = Solver::new(&system, with(scheme));
        let motion = solver.simulate(&inputs).expect("motion");
        let last = motion.computed - 1;
        let [q, v, sigma] = [&motion.q, &motion.v, &motion.sigma].map(|x| x.column(last).as_slice().to_vec());
        let cost = solver.gradient().expect("gradient");
        [q, v, sigma, vec![cost.value], cost.start.q().as_slice().to_vec()]
    };
    for (scheme, coarsest) in Scheme::ALL.into_iter().zip([40, 20, 100, 20, 10]) {
        let reference = at_end(Scheme::ESDIRK5, if scheme.order > 3 { 640 } else { 320 });
        let motions: Vec<_> = [1, 2, 4, 8].map(|factor| at_end(scheme, factor * coarsest)).into_iter().collect();
        for (which, name) in ["q", "v", "σ", "J", "dJ/dq₀"].into_iter().enumerate() {
            let errors: Vec<f64> = motions.iter().map(|x| largest_difference(&x[which], &reference[which])).collect();
            assert_order(&format!("{}: {name}", scheme.name), &errors, scheme.order as f64, 0.45);
        }
    }
}

#[test]
fn outside_of_its_class_a_method_loses_its_order() {
    // A sum over nodes by the trapezoidal rule has order 2 whatever the motion has.
    let system = five_bar(Sum::Trapezoidal);
    let cost = |steps: usize| {
        let inputs = moving(&system, Grid::uniform(steps, 0.6 / steps as f64));
        gradient(&system, &inputs, with(Scheme::ESDIRK4)).expect("gradient").value
    };
    let reference = cost(2560);
    let errors: Vec<f64> = [20, 40, 80, 160].map(|steps| (cost(steps) - reference).abs()).into_iter().collect();
    assert_order("Σ by the trapezoidal rule", &errors, 2.0, 0.2);
}

#[test]
fn gradients_are_exact_for_all_inputs() {
    for scheme in Scheme::ALL {
        for sum in [Sum::Plain, Sum::AllNodes, Sum::Rectangle, Sum::Trapezoidal, Sum::Integral] {
            let system = five_bar(sum);
            assert_gradient_is_exact_with(
                &format!("{} {sum:?}", scheme.name),
                &system,
                &irregular(&system, 12, 0.02),
                with(scheme),
            );
        }
    }
}

#[test]
fn gradients_are_exact_through_restarts_and_on_composed_grids() {
    let system = five_bar(Sum::Integral);
    for scheme in Scheme::ALL {
        for (rebase_every, drift_bound) in [(1, f64::INFINITY), (3, 0.0), (0, 1e-12)] {
            let settings = Settings { rebase_every, drift_bound, ..with(scheme) };
            assert_gradient_is_exact_to(1e-11, scheme.name, &system, &irregular(&system, 14, 0.02), settings);
        }
        let settings = Settings { rebase_every: 2, drift_bound: 0.0, ..with(scheme) };
        let inputs = moving(&system, Grid::composed(5, 0.05, Composition::Suzuki4));
        assert_gradient_is_exact_to(1e-11, &format!("{} composed", scheme.name), &system, &inputs, settings);
    }
}

/// A rod on a hinge that is there twice.
fn doubled() -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let (rod, torque) = (scene.body("rod", 1.0, 0.08, [0.5, 0.0, 0.0]), scene.control("torque"));
    for name in ["hinge", "the same"] {
        scene.revolute(name, Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    }
    scene.torque_actuator("motor", Body::GROUND, rod, torque);
    let angle = hamiltonian_adjoint::scenes::AngleError;
    scene.cost("angle", angle, Sum::Integral, [rod.coordinates[2]], [], [], [0.4.into()]);
    scene.compile().expect("scene")
}

#[test]
fn gradients_are_exact_with_dependent_constraints() {
    let system = doubled();
    for scheme in Scheme::ALL {
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
        inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = number(i));
        assert_gradient_is_exact_to(1e-11, scheme.name, &system, &inputs, with(scheme));
    }
}

/// A pendulum in steps that take more iterations than they get.
fn halving() -> (System, Inputs) {
    let mut bench = Bench::new();
    let rod = bench.rod([0.0, 0.0], [1.0, 0.0]);
    bench.hinge(Part::GROUND, rod, [0.0, 0.0]);
    bench.drive(Part::GROUND, rod);
    let system = bench.compile(Sum::Integral);
    let inputs = moving(&system, Grid::uniform(8, 0.25));
    (system, inputs)
}

#[test]
fn gradients_are_exact_where_steps_are_halved() {
    let (system, inputs) = halving();
    for scheme in Scheme::ALL {
        let settings = Settings { max_iterations: 3, ..with(scheme) };
        let motion = simulate(&system, &inputs, settings).expect("motion");
        println!("{}: {} nodes inserted", scheme.name, motion.inserted.len());
        assert!(!motion.inserted.is_empty(), "{}: no step was halved", scheme.name);
        assert_gradient_is_exact_to(1e-11, scheme.name, &system, &inputs, settings);
    }
}

#[test]
fn long_motions_give_the_same_numbers() {
    let system = five_bar(Sum::Integral);
    for scheme in Scheme::ALL {
        let settings = Settings { rebase_every: 7, ..with(scheme) };
        let inputs = irregular(&system, 400, 0.004);
        let stored = gradient(&system, &inputs, settings).expect("gradient");
        let bytes = 400 * system.bytes_per_node(&settings) / 4;
        let mut long = LongSolver::new(&system, settings, bytes);
        let Gradient { value, controls, design, start, steps, .. } = long.gradient(&inputs).expect("gradient");
        assert_eq!((*value, controls, design), (stored.value, &stored.controls, &stored.design), "{}", scheme.name);
        assert_eq!((start, steps), (&stored.start, &stored.steps), "{}", scheme.name);
        assert!(long.report().newton_iterations > 400 * scheme.stages(), "nothing was computed again");
    }
}

#[test]
fn the_checks_agree() {
    let system = five_bar(Sum::Integral);
    for scheme in Scheme::ALL {
        let settings = with(scheme);
        let report = check::gradient(&system, &irregular(&system, 15, 0.02), settings).run().expect("check");
        assert!(report.passed(), "{}:\n{report}", scheme.name);
    }
}

#[test]
fn tables_of_the_reader_are_taken_or_refused() {
    let system = five_bar(Sum::Integral);
    let inputs = irregular(&system, 10, 0.02);
    // Backward Euler, and a table with other diagonal values.
    let euler = Scheme { name: "backward Euler", order: 1, rows: &[&[0.0, 1.0]], ..Scheme::TRAPEZOIDAL };
    let mixed = Scheme { name: "mixed", order: 1, rows: &[&[0.1, 0.3], &[0.2, 0.2, 0.6]], ..Scheme::TRAPEZOIDAL };
    for scheme in [euler, mixed] {
        assert_gradient_is_exact_with(scheme.name, &system, &inputs, with(scheme));
    }
    let explicit = Scheme { name: "Heun", rows: &[&[1.0, 0.0], &[0.5, 0.5, 0.0]], ..Scheme::TRAPEZOIDAL };
    let error = simulate(&system, &inputs, with(explicit)).expect_err("explicit stages").error;
    assert_says(&error, &["`Heun`", "row 1", "implicit"]);
}

#[test]
fn the_paper_s_equations_are_those_of_the_trapezoidal_rule() {
    let system = five_bar(Sum::Plain);
    let inputs = irregular(&system, 3, 0.02);
    let motion = simulate(&system, &inputs, with(Scheme::TR_BDF2)).expect("motion");
    let error = PaperSystem::new(&system, &inputs, &motion).expect_err("another scheme");
    assert_eq!(error, Error::Scheme { found: "TR-BDF2" });
    assert_says(&error, &["TR-BDF2", "trapezoidal rule"]);
}

#[test]
fn what_decays_fast_is_forgotten_by_l_stable_schemes_and_rings_with_the_trapezoidal_rule() {
    let mut scene = Scene::new();
    let [x] = scene.coordinates("mass", ["x"]);
    scene.kinetic_energy("inertia", Quadratic, [x], [1.0.into()]);
    scene.potential_energy("spring", Quadratic, [x], [1e8.into()]);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.1));
    inputs.start.q_mut()[0] = 1.0;
    for scheme in Scheme::ALL {
        let motion = simulate(&system, &inputs, with(scheme)).expect("motion");
        let left = motion.q[(0, 40)].abs();
        println!("{}: {left:.1e}", scheme.name);
        assert_eq!(left < 1e-6, scheme != Scheme::TRAPEZOIDAL, "{}: {left}", scheme.name);
    }
}

/// ½ b x².
struct Quadratic;
impl KineticEnergy<1, 1> for Quadratic {
    fn kinetic_energy<S: Scalar>(&self, _: &SVector<S, 1>, v: &SVector<S, 1>, b: &SVector<S, 1>) -> S {
        b[0] * v[0] * v[0] * 0.5
    }
}
impl PotentialEnergy<1, 1> for Quadratic {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, b: &SVector<S, 1>, _: S) -> S {
        b[0] * q[0] * q[0] * 0.5
    }
}
