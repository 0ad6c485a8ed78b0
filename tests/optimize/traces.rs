//! What a point without a value leaves behind: nothing.

use super::common::assert_says;
use super::{problem, push, shooting};
use hamiltonian_adjoint::optimize::{
    Free, MotionProblem, MultipleShooting, Options, Problem, Reason, Trials, Variables, homotopy, silent,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Design, Grid, Inputs, Settings, System};

/// A cart whose place after 1 s of a constant force tells its mass.
fn weighing() -> (System, Design) {
    let mut scene = hamiltonian_adjoint::Scene::new();
    let mass = scene.design("mass", 1.0);
    let cart = scene.body("cart", mass, 1.0, [0.0; 3]);
    let force = scene.control("force");
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
    scene.reading("x", cart.coordinates[0], 10, 0.5, 1.0);
    (scene.compile().expect("a system"), mass)
}

#[test]
fn a_homotopy_goes_on_after_a_point_without_a_value() {
    let (system, mass) = weighing();
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.1));
    inputs.controls.fill(1.0);
    let variables = Variables::new(&system, &inputs, vec![Free::design(mass)]).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    let start = problem.start();
    let mut last = f64::NAN;
    // An extrapolated mass is negative, and the next problem is made by a change of the force alone.
    let mut set = |problem: &mut MotionProblem, s: f64| {
        last = s;
        problem.change(|inputs| inputs.controls.fill(1.0 / (1.0 + 30.0 * s)))
    };
    let outcome = homotopy(&mut problem, &start, &Options::default(), &mut set, &mut silent).expect("goes on");
    // x = F t²/(2 m), the same of any step.
    assert!((outcome.x[0] - 1.0 / 31.0).abs() < 1e-6, "{outcome:?}");
    assert_eq!((outcome.reason, last), (Reason::Stationary, 1.0));
    assert_says(&outcome.first_failure.expect("the negative mass"), &["mass of `cart`", "-"]);
}

#[test]
fn a_point_without_a_value_leaves_no_trace() {
    let (system, force) = push(false);
    let mut problem = problem(&system, force, Inputs::at_rest(&system, Grid::uniform(20, 0.1)));
    let mut c = vec![0.0; 2];
    for known in [0.0, 1.5] {
        problem.evaluate(&[known; 21], &mut c).expect("a motion");
        problem.evaluate(&[f64::NAN; 21], &mut c).expect_err("no numbers");
        assert_eq!(problem.start(), [known; 21]);
        assert_eq!(problem.inputs_at(&[known; 21]).controls.as_slice(), [known; 21]);
        problem.change(|inputs| inputs.grid.steps.fill(0.2)).expect("nothing is wrong with the steps");
        assert_eq!(problem.start(), [known; 21]);
    }
}

#[test]
fn segments_without_a_value_leave_no_trace() {
    let (system, force, _, states) = shooting::push();
    let inputs = Inputs::at_rest(&system, Grid::uniform(12, 0.05));
    let free = vec![Free::control(force), Free::duration()];
    let mut problem = MultipleShooting::new(&system, Settings::default(), inputs, free, &states, 3).expect("a problem");
    let mut c = vec![0.0; problem.constraints().len()];
    let known: Vec<f64> = problem.start().iter().map(|x| x + 0.1).collect();
    problem.evaluate(&known, &mut c).expect("motions");
    // The control at the end, which only the last segment has; the duration; the state at a cut.
    for i in [12, 13, 14, known.len() - 1] {
        let mut x: Vec<f64> = known.iter().map(|x| 2.0 * x).collect();
        x[i] = f64::NAN;
        problem.evaluate(&x, &mut c).expect_err("no number");
        assert_eq!(problem.start(), known, "{i}");
        problem
            .guess(|_, q, _| assert!((q[0] - known[14]).abs() < 1e-15 || (q[0] - known[20]).abs() < 1e-15))
            .expect("no change");
        assert_eq!(problem.start(), known, "{i}");
    }
    problem.guess(|_, q, _| q[0] = 7.0).expect("a guess");
    assert_eq!((problem.start()[14], &problem.start()[..14]), (7.0, &known[..14]));
}

#[test]
fn trials_of_which_one_has_no_value_leave_no_trace() {
    let (system, mass) = weighing();
    let of = |force: f64, steps: usize| {
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 0.1));
        inputs.controls.fill(force);
        let variables = Variables::new(&system, &inputs, vec![Free::design(mass)]).expect("free");
        MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem")
    };
    // The second one breaks down on its own: a force beyond the range of numbers for a light cart.
    let mut trials = Trials::new(vec![of(1.0, 10), of(1e300, 10)]).expect("trials");
    let mut c = vec![0.0; 2];
    trials.evaluate(&[3.0], &mut c).expect("motions");
    trials.evaluate(&[1e-10], &mut c).expect_err("no motion");
    assert!(trials.motions().iter().all(|motion| motion.start() == [3.0]));
}
