//! Grids that are refined where the errors are.

use super::Effort;
use super::accurate::{deviation, divided};
use super::solve::OPTIONS;
use hamiltonian_adjoint::optimize::{Free, Guess, Interval, MotionProblem, Variables, silent, solve};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Grid, Inputs, Scene, Scheme, Settings, Solver, Start, Sum};

/// A cart that cannot stop before a stiff spring at 0.5 m, bounces from it within a tenth of a second, and comes to rest where it started after 2 s.
fn bouncing(stiffness: f64, width: f64, steps: usize) -> MotionProblem {
    let mut scene = Scene::new();
    let cart = scene.body("cart", 2.0, 0.1, [0.0, 0.0, 0.0]);
    let [origin, centre] = [Body::GROUND.at(0.0, 0.0), cart.at(0.0, 0.0)];
    scene.prismatic("rail", origin, 0.0, centre, 0.0);
    let force = scene.control("force");
    scene.actuator("motor", origin, 0.0, centre, force);
    scene.sliding_end_stop(
        "buffer",
        origin,
        0.0,
        centre,
        [(-10.0).into(), 0.5.into()],
        [stiffness.into(), 0.0.into(), width.into()],
    );
    scene.cost("effort", Effort, Sum::Integral, [], [], [force], [1.0.into()]);
    let end = scene.end_state(cart.coordinates[0]);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 2.0 / steps as f64));
    let Start::Velocity { v, .. } = &mut inputs.start else { panic!("velocities") };
    v[0] = 1.0;
    let variables = Variables::new(&system, &inputs, vec![Free::control(force).within(-2.0, 2.0)]).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    problem.constrain(end.position, Interval::equal(0.0));
    problem.constrain(end.rate, Interval::ZERO);
    problem
}

#[test]
fn steps_are_halved_at_a_contact() {
    let mut problem = bouncing(2000.0, 0.02, 100);
    let solved = solve(&mut problem, Guess::Straight.accurate_to(1e-5), &OPTIONS, &mut silent).expect("fits");
    println!("{solved}");
    assert!(solved.outcome.reason.is_converged() && solved.outcome.warnings.is_empty(), "{solved}");
    let (far, steps) = (deviation(&problem, &solved.outcome), problem.inputs_at(&solved.outcome.x).grid.steps);
    assert!(far < 2e-5, "{far:.1e}");
    // The buffer is compressed between 0.57 and 0.68 s; steps as short everywhere would be 400.
    let shortest = steps.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(shortest < 0.006 && (105..150).contains(&steps.len()), "{shortest} {}", steps.len());
    let times = &problem.solver.trajectory().times;
    let is_short = |k: &usize| steps[*k] < 0.019;
    let mut short = (0..steps.len()).filter(is_short).map(|k| times[k + 1]);
    assert!(short.all(|t| (0.5..0.75).contains(&t)), "{steps:?}");
}

#[test]
fn the_errors_of_sharp_contacts_are_seen() {
    for (stiffness, width, steps) in [(1000.0, 1e-3, 50), (1000.0, 1e-3, 40), (3000.0, 1e-3, 60)] {
        let mut problem = bouncing(stiffness, width, steps);
        let solved = solve(&mut problem, Guess::Inputs.accurate_to(1e-4), &OPTIONS, &mut silent).expect("fits");
        let found = &solved.outcome;
        let inputs = divided(&problem.inputs_at(&found.x), 32);
        let mut solver = Solver::new(problem.solver.system(), Settings { scheme: Scheme::ESDIRK5, ..Settings::default() });
        solver.simulate(&inputs).expect("a motion");
        let end = solver.outputs().expect("outputs").amax();
        println!("{solved}{end:.1e}");
        assert!(found.reason.is_converged(), "{solved}");
        let is_warned =
            found.warnings.iter().any(|warning| warning.to_string().contains("the accuracy of 1e-4 is not reached"));
        assert!(end < 3e-4 || is_warned, "{end:.1e} {solved}");
    }
}
