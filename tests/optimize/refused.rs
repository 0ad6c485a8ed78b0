//! What is refused, and by which name.

use super::common::assert_says;
use super::{Function, Given, everything_free, problem, push, shooting};
use hamiltonian_adjoint::optimize::{
    Free, Interval, MotionProblem, MultipleShooting, Options, Problem, Quantity, Reason, Trials, Variables, interior_point,
    lbfgs, levenberg_marquardt, silent,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Constraint, Cost, CostPoint, EndState, Error, Grid, Inputs, Scalar, Scene, Settings, Start, Warning,
};
use nalgebra::{DMatrix, DVector, SVector};

/// Every method of a problem, with one entry too few or too many of each argument.
fn assert_refuses_lengths(problem: &mut dyn Problem, x: &[f64]) {
    let (n, m) = (x.len(), problem.constraints().len());
    let (mut all, mut c) = (vec![0.0; n], vec![0.0; m]);
    problem.evaluate(x, &mut c).expect("a value");
    let wrong =
        |length: usize| [length - 1, length + 1].map(|wrong| (vec![0.1; wrong], format!("expected {length}"), wrong));
    for (mut other, expected, found) in wrong(n) {
        let (expected, found) = (&*expected, &*format!("found {found}"));
        assert_says(&problem.evaluate(&other, &mut c).expect_err("x"), &[expected, found]);
        assert_says(&problem.gradient(1.0, &c, &mut other).expect_err("gradient"), &["gradient", expected, found]);
        assert_says(&problem.push_forward(&other, &mut c).expect_err("direction"), &["direction", expected, found]);
        assert_says(&problem.product(&other, &mut all).expect_err("direction"), &["direction", expected, found]);
        assert_says(&problem.product(x, &mut other).expect_err("product"), &["product", expected, found]);
        let mut jacobian = DMatrix::zeros(1, other.len());
        assert_says(&problem.jacobian(&[0], &mut jacobian).expect_err("columns"), &["columns", expected, found]);
    }
    for (mut other, expected, found) in wrong(m) {
        let (expected, found) = (&*expected, &*format!("found {found}"));
        // A motion's cost alone may be asked for, with no room for values of constraints.
        if !other.is_empty() {
            assert_says(&problem.evaluate(x, &mut other).expect_err("c"), &["constraints", expected, found]);
        }
        assert_says(&problem.gradient(1.0, &other, &mut all).expect_err("weights"), &["weights", expected, found]);
        assert_says(&problem.push_forward(x, &mut other).expect_err("changes"), &["changes", expected, found]);
    }
    let mut jacobian = DMatrix::zeros(2, n);
    assert_says(&problem.jacobian(&[0], &mut jacobian).expect_err("rows"), &["rows", "expected 1", "found 2"]);
    assert_says(&problem.jacobian(&[0, m], &mut jacobian).expect_err("row"), &["row", &format!("is {m}"), "less than"]);
    assert!(problem.evaluate(x, &mut c).is_ok());
}

#[test]
fn what_has_another_length_is_refused() {
    let (system, force) = push(false);
    let motion = || problem(&system, force, Inputs::at_rest(&system, Grid::uniform(6, 0.1)));
    let start = motion().start();
    assert_refuses_lengths(&mut motion(), &start);
    assert_refuses_lengths(&mut Trials::new(vec![motion(), motion()]).expect("trials"), &start);
    let (system, force, _, states) = shooting::push();
    let inputs = Inputs::at_rest(&system, Grid::uniform(6, 0.1));
    let mut segments =
        MultipleShooting::new(&system, Settings::default(), inputs, vec![Free::control(force)], &states, 2).expect("fits");
    let start = segments.start();
    assert_refuses_lengths(&mut segments, &start);
}

#[test]
fn variables_are_applied_to_inputs_that_they_fit() {
    let (system, inputs, free) = everything_free();
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let (x, n) = (variables.of(&inputs), variables.len());
    for length in [0, n - 1, n + 1] {
        let mut to = inputs.clone();
        let error = variables.apply(&vec![0.1; length], &mut to).expect_err("another length");
        assert_says(&error, &["variables", &format!("expected {n}"), &format!("found {length}")]);
        assert_eq!(to, inputs, "nothing is set");
    }
    let mut short = inputs.clone();
    short.controls = short.controls.columns(0, 2).into_owned();
    assert_says(&variables.apply(&x, &mut short).expect_err("few controls"), &["controls", "found 2"]);
    let mut short = Inputs::at_rest(&system, Grid::uniform(2, 0.1));
    assert_says(&variables.apply(&x, &mut short).expect_err("few nodes"), &["nodes", "found 3"]);
}

#[test]
fn squares_beyond_the_range_of_numbers_are_no_minimum() {
    // w (x − 3) and w (x − 4).
    fn weighted(x: &[f64], c: &mut [f64], g: &mut [f64], weight: f64) -> f64 {
        c.copy_from_slice(&[weight * (x[0] - 3.0), weight * (x[0] - 4.0)]);
        g.copy_from_slice(&[0.0, weight, weight]);
        0.0
    }
    let heavy: Function = |x, c, g| weighted(x, c, g, 1e160);
    // Residuals whose squares are numbers, and slopes whose are not.
    let steep: Function = |x, c, g| {
        c.copy_from_slice(&[1e150, 1e160 * x[0]]);
        g.copy_from_slice(&[0.0, 1e160, 1e160]);
        0.0
    };
    for (function, words) in [(heavy, ["½‖r‖²", "inf"]), (steep, ["`x0`", "inf"])] {
        let mut problem = Given::new(function, vec![Interval::FREE], vec![Interval::ZERO; 2]);
        let found = levenberg_marquardt(&mut problem, &[0.0], &Options::default(), &mut silent);
        let outcome = found.expect("an outcome").outcome;
        assert_eq!(outcome.reason, Reason::NoStart, "{outcome:?}");
        assert_says(&outcome.first_failure.expect("nothing to compare"), &words);
    }
    let less: Function = |x, c, g| weighted(x, c, g, 1e150);
    let mut problem = Given::new(less, vec![Interval::FREE], vec![Interval::ZERO; 2]);
    let fit = levenberg_marquardt(&mut problem, &[0.0], &Options::default(), &mut silent).expect("numbers");
    assert!(fit.outcome.reason.is_converged() && (fit.outcome.x[0] - 3.5).abs() < 1e-6, "{:?}", fit.outcome);
}

#[test]
fn constraints_are_called_by_the_names_of_outputs() {
    let (system, force, energy, _) = shooting::push();
    let motion = || problem(&system, force, Inputs::at_rest(&system, Grid::uniform(6, 0.1)));
    let mut problem = motion();
    let start = problem.start();
    // One of three, of which nothing is asked, is no constraint.
    problem.constrain(energy, Interval::FREE);
    let error = lbfgs(&mut problem, &start, &Options::default(), &mut silent).expect_err("constraints");
    let named = "(output `place`, output `speed`) is 2;";
    assert_says(&error, &[named, "`Interval::FREE`", "augmented_lagrangian"]);
    problem.constrain(energy, Interval::new(f64::NAN, 1.0));
    let error = Options::default().fit(&problem, &start).expect_err("no number");
    assert_says(&error, &["lower bound of output `energy` is NaN"]);
    problem.constrain(energy, Interval::new(2.0, 1.0));
    let error = Options::default().fit(&problem, &start).expect_err("no room");
    assert_says(&error, &["upper bound of output `energy`, whose lower bound is 2, is 1;"]);
    let trials = Trials::new(vec![motion(), motion()]).expect("trials");
    assert_eq!(trials.constraint_name(system.outputs() + 1), "output `speed` of trial 1");
}

#[test]
fn joints_of_segments_have_names() {
    let (system, force, _, states) = shooting::push();
    let inputs = Inputs::at_rest(&system, Grid::uniform(6, 0.1));
    let segments =
        MultipleShooting::new(&system, Settings::default(), inputs, vec![Free::control(force)], &states, 2).expect("fits");
    let names: Vec<String> = (0..segments.constraints().len()).map(|j| segments.constraint_name(j)).collect();
    assert_eq!(names[0], "output `place`");
    let first = system.coordinate_name(states[0].coordinate.index());
    assert_eq!(names[names.len() - 6], format!("the continuity of `{first} at node 3`"));
    assert!(names[names.len() - 1].contains("rate of"), "{names:?}");
}

#[test]
fn the_bound_that_is_wrong_is_named() {
    let (infinite, nan) = (f64::INFINITY, f64::NAN);
    let wrong = [
        (nan, 1.0, "lower bound of `x0` is NaN"),
        (infinite, infinite, "lower bound of `x0` is inf"),
        (0.0, nan, "upper bound of `x0` is NaN"),
        (-infinite, -infinite, "upper bound of `x0` is -inf"),
        (1.0, 0.0, "upper bound of `x0`, whose lower bound is 1, is 0"),
    ];
    let flat: Function = |_, _, g| {
        g.fill(0.0);
        0.0
    };
    for (least, most, said) in wrong {
        let mut problem = Given::new(flat, vec![Interval::new(least, most)], vec![]);
        let error = lbfgs(&mut problem, &[0.5], &Options::default(), &mut silent).expect_err("no interval");
        assert_says(&error, &[said]);
    }
}

#[test]
fn what_residuals_do_not_determine_is_listed() {
    // x + y, of z nothing, and w.
    let lost: Function = |x, c, g| {
        g.fill(0.0);
        for (k, of) in [1.0, 2.0, 3.0, 4.0, 5.0].into_iter().enumerate() {
            c[k] = of * (x[0] + x[1]) + x[3] - of * of;
            let row = 4 * (k + 1);
            (g[row], g[row + 1], g[row + 3]) = (of, of, 1.0);
        }
        0.0
    };
    let mut problem = Given::new(lost, vec![Interval::FREE; 4], vec![Interval::ZERO; 5]);
    let fit = levenberg_marquardt(&mut problem, &[0.0; 4], &Options::default(), &mut silent).expect("fits");
    assert_eq!((fit.standard_errors(), fit.undetermined()), (None, vec![0, 1, 2]));
    // Of what is determined nothing is listed.
    let line: Function = |x, c, g| {
        g.fill(0.0);
        for k in 0..3 {
            c[k] = k as f64 * x[0] + 1e6 * x[1] - (k * k) as f64;
            (g[2 * (k + 1)], g[2 * (k + 1) + 1]) = (k as f64, 1e6);
        }
        0.0
    };
    let mut problem = Given::new(line, vec![Interval::FREE; 2], vec![Interval::ZERO; 3]);
    let fit = levenberg_marquardt(&mut problem, &[0.0; 2], &Options::default(), &mut silent).expect("fits");
    assert!(fit.standard_errors().is_some() && fit.undetermined().is_empty());
}

#[test]
fn handles_of_another_scene_are_refused() {
    let ((system, force, ..), (_, other, output, states)) = (shooting::push(), shooting::push());
    let inputs = Inputs::at_rest(&system, Grid::uniform(6, 0.1));
    let other_is_named = |error: Error| assert_says(&error, &["control 0", "another scene"]);
    other_is_named(Variables::new(&system, &inputs, vec![Free::control(other)]).expect_err("another's control"));
    let variables = Variables::new(&system, &inputs, vec![Free::control(force)]).expect("free");
    let (foreign, ..) = shooting::push();
    let found = MotionProblem::new(&foreign, Settings::default(), inputs.clone(), variables.clone());
    other_is_named(found.expect_err("another's variables"));
    let shoot =
        |states| MultipleShooting::new(&system, Settings::default(), inputs.clone(), vec![Free::control(force)], states, 2);
    assert_says(&shoot(&states).expect_err("another's states"), &["state of coordinate 0", "another scene"]);
    let constrain = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        let mut problem = MotionProblem::new(&system, Settings::default(), inputs.clone(), variables.clone()).expect("fits");
        problem.constrain(output, Interval::FREE);
    }));
    let message = constrain.expect_err("another's output");
    assert!(message.downcast_ref::<String>().is_some_and(|message| message.contains("another scene")));
}

#[test]
fn what_constraints_hold_is_not_free_by_itself() {
    let mut scene = Scene::new();
    let rod = scene.body("rod", 1.0, 0.1, [0.5, 0.0, 0.0]);
    scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    let system = scene.compile().expect("a scene");
    let of = |start: Start, free: &[Quantity], settings: Settings| {
        let inputs = Inputs { start, ..Inputs::at_rest(&system, Grid::uniform(10, 0.02)) };
        let free = free.iter().map(|of| Free::new(of.clone())).collect();
        let variables = Variables::new(&system, &inputs, free)?;
        MotionProblem::new(&system, settings, inputs, variables).map(drop)
    };
    let [_, _, phi] = rod.coordinates;
    let (q, zeros) = (system.initial_coordinates(), DVector::zeros(system.n()));
    let velocity = || Start::Velocity { q: q.clone(), v: zeros.clone() };
    let momentum = || Start::Momentum { q: q.clone(), p_star: zeros.clone() };
    let (angle, rate, plain) = (Quantity::Coordinate(phi), Quantity::Rate(phi), Settings::default());
    for start in [velocity(), momentum()] {
        let error = of(start, std::slice::from_ref(&angle), plain).expect_err("an angle alone");
        assert_says(&error, &["`initial rod.φ`", "`hinge`", "`Start::assembled`", "hold"]);
    }
    let error = of(velocity(), std::slice::from_ref(&rate), plain).expect_err("a rate alone");
    assert_says(&error, &["`initial rate of rod.φ`", "the rate of `hinge`", "`Start::assembled`"]);
    // Momenta are projected, assembled starts follow, and what tolerances let pass is nobody's business.
    of(momentum(), std::slice::from_ref(&rate), plain).expect("a momentum");
    of(Start::assembled(&system).hold(&[phi]), &[angle.clone(), rate.clone()], plain).expect("a start that follows");
    let (position_tolerance, velocity_tolerance) = (f64::INFINITY, f64::INFINITY);
    let loose = Settings { position_tolerance, velocity_tolerance, ..plain };
    of(velocity(), &[angle.clone(), rate.clone()], loose).expect("any start passes");
    of(velocity(), &[angle], Settings { position_tolerance: 0.5, ..loose }).expect("a small change passes");
    // What moves together may be free together: x and the place of the wall that it stands at.
    let mut scene = Scene::new();
    let wall = scene.design("wall", 0.5);
    let block = scene.body("block", 1.0, 0.1, [0.5, 0.0, 0.0]);
    let [x, y, _] = block.coordinates;
    scene.constraint("at the wall", At, [x], [wall.into()]);
    let system = scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.02));
    let of = |free: Vec<Free>| {
        let variables = Variables::new(&system, &inputs, free).expect("free");
        MotionProblem::new(&system, Settings::default(), inputs.clone(), variables).map(drop)
    };
    let [x, y] = [x, y].map(|q| Free::new(Quantity::Coordinate(q)));
    assert_says(&of(vec![x.clone(), y.clone()]).expect_err("x alone"), &["initial block.x", "`at the wall`"]);
    of(vec![y.clone(), Free::design(wall), x]).expect("both");
    assert_says(
        &of(vec![Free::design(wall), y]).expect_err("the wall alone"),
        &["`wall`", "`at the wall`", "`Start::assembled`"],
    );
}

/// Without cost and outputs every point is a minimum: J = 0, stationary, and nothing said that a cost was forgotten.
#[test]
fn a_problem_that_asks_for_nothing_says_so() {
    let mut scene = Scene::new();
    let block = scene.body("block", 1.0, 0.1, [0.0; 3]);
    let push = scene.control("push");
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, block.at(0.0, 0.0), push);
    let states @ [end, ..] = block.coordinates.map(|coordinate| scene.end_state(coordinate));
    let system = scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.1));
    // Segments want to meet, each by itself wants nothing.
    let free = vec![Free::control(push)];
    let mut segments =
        MultipleShooting::new(&system, Settings::default(), inputs.clone(), free, &states, 2).expect("segments");
    let (at, mut joints) = (segments.start(), vec![0.0; segments.constraints().len()]);
    segments.evaluate(&at, &mut joints).expect("a value");
    assert!(segments.warnings().is_empty(), "{:?}", segments.warnings());
    let variables = Variables::new(&system, &inputs, vec![Free::control(push)]).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    let start = problem.start();
    let says = |problem: &mut MotionProblem| {
        let outcome = interior_point(problem, &start, &Options::default(), &mut silent).expect("fits");
        outcome.warnings.contains(&Warning::NothingAsked)
    };
    assert!(says(&mut problem));
    problem.constrain(end.position, Interval::equal(0.1));
    assert!(!says(&mut problem));
}

/// x = b.
struct At;
impl Constraint<1, 1, 1> for At {
    fn phi<S: Scalar>(&self, q: &SVector<S, 1>, b: &SVector<S, 1>, _t: S) -> SVector<S, 1> {
        SVector::from([q[0] - b[0]])
    }
}

#[test]
fn states_of_segments_determine_their_starts() {
    // A pendulum on two hinges where one would do: as many equations as coordinates and more, and one freedom.
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let (rod, torque) = (scene.body("rod", 1.0, 0.1, [0.5, 0.0, 0.0]), scene.control("torque"));
    for name in ["hinge", "the same"] {
        scene.revolute(name, Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    }
    scene.torque_actuator("motor", Body::GROUND, rod, torque);
    let states = [scene.end_state(rod.coordinates[2])];
    let system = scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
    let shoot = |states: &[_]| {
        let free = vec![Free::control(torque)];
        MultipleShooting::new(&system, Settings::default(), inputs.clone(), free, states, 2)
    };
    assert_says(&shoot(&states[..0]).expect_err("no states"), &["states", "0", "degrees of freedom"]);
    assert_says(&shoot(&[states[0], states[0]]).expect_err("one twice"), &["states", "`rod.φ`", "2", "1"]);
    assert!(shoot(&states).is_ok());
    // A parallelogram that lies flat could leave its branch there, and has one freedom all the same.
    let mut scene = Scene::new();
    let [left, right] = [0.0, 1.0].map(|x| {
        let crank = scene.body(&format!("crank at {x}"), 1.0, 0.1, [x + 0.3, 0.0, 0.0]);
        scene.revolute(&format!("foot at {x}"), Body::GROUND.at(x, 0.0), crank.at(-0.3, 0.0));
        crank
    });
    let coupler = scene.body("coupler", 1.0, 0.1, [1.1, 0.0, 0.0]);
    scene.revolute("left", left.at(0.3, 0.0), coupler.at(-0.5, 0.0));
    scene.revolute("right", right.at(0.3, 0.0), coupler.at(0.5, 0.0));
    let (torque, states) = (scene.control("torque"), [scene.end_state(left.coordinates[2])]);
    scene.torque_actuator("motor", Body::GROUND, left, torque);
    let system = scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
    let free = vec![Free::control(torque)];
    assert!(MultipleShooting::new(&system, Settings::default(), inputs, free, &states, 2).is_ok());
}

#[test]
fn a_change_leaves_no_motion_and_a_refused_guess_nothing() {
    let (system, inputs, free) = everything_free();
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("fits");
    let (x, m) = (problem.start(), problem.constraints().len());
    let (mut c, mut gradient) = (vec![0.0; m], vec![0.0; x.len()]);
    problem.evaluate(&x, &mut c).expect("a motion");
    problem.change(|inputs| inputs.design[0] *= 1.1).expect("fits");
    problem.gradient(1.0, &vec![0.0; m], &mut gradient).expect_err("of no point");
    let (system, force, _, states) = shooting::push();
    let inputs = Inputs::at_rest(&system, Grid::uniform(12, 0.05));
    let free = vec![Free::control(force)];
    let mut problem = MultipleShooting::new(&system, Settings::default(), inputs, free, &states, 3).expect("a problem");
    let before = problem.start();
    problem.guess(|node, q, _| q[0] = if node > 4 { f64::NAN } else { 1.0 }).expect_err("no number");
    assert_eq!(problem.start(), before);
}

#[test]
fn variables_of_trials_are_within_the_bounds_of_all() {
    let (system, force, ..) = shooting::push();
    let inputs = Inputs::at_rest(&system, Grid::uniform(6, 0.1));
    let within = |least, most| {
        let variables = Variables::new(&system, &inputs, vec![Free::control(force).within(least, most)]).expect("free");
        MotionProblem::new(&system, Settings::default(), inputs.clone(), variables).expect("fits")
    };
    let trials = Trials::new(vec![within(-1.0, 4.0), within(-3.0, 2.0)]).expect("something in common");
    assert!(trials.bounds().iter().all(|of| *of == Interval::new(-1.0, 2.0)));
    let error = Trials::new(vec![within(-1.0, 1.0), within(2.0, 3.0)]).expect_err("nothing in common");
    assert_says(&error, &["`force [0]` in all trials", "lower bound is 2", "is 1"]);
}

/// A mass whose place is read at 0.3 s, node 3, with a free force and an end state.
fn read_at_a_time() -> (Scene, Free, Vec<EndState>) {
    let mut scene = Scene::new();
    let block = scene.particle("block", 1.0, [0.0, 0.0]);
    let force = scene.control("force");
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, block.point(), force);
    scene.reading("place", block.coordinates[0], 3, 0.1, 1.0);
    scene.reading_time("place", 3, 0.3);
    let states = block.coordinates.map(|q| scene.end_state(q)).to_vec();
    (scene, Free::control(force), states)
}

#[test]
fn readings_at_other_times_are_refused() {
    let (scene, force, states) = read_at_a_time();
    let event = {
        let mut scene = scene.clone();
        scene.event("never", Early, [], [], [], []);
        scene.compile().expect("a system")
    };
    let system = scene.compile().expect("a system");
    let made = |grid: Grid, free: Vec<Free>| {
        let inputs = Inputs::at_rest(&system, grid);
        let variables = Variables::new(&system, &inputs, free.clone()).expect("variables");
        let one = MotionProblem::new(&system, Settings::default(), inputs.clone(), variables).map(drop);
        let parts = MultipleShooting::new(&system, Settings::default(), inputs, free, &states, 3).map(drop);
        [one, parts]
    };
    // The tolerance is a thousandth of the steps beside the node.
    let shifted = |start: f64| Grid { start, ..Grid::uniform(9, 0.1) };
    for grid in [Grid::uniform(9, 0.1), shifted(0.9e-4), Grid::through(&[0.0, 0.2, 0.3, 0.8], 0.1).expect("a grid")] {
        made(grid, vec![force.clone()]).into_iter().for_each(|made| made.expect("the time of the reading"));
    }
    for (grid, found) in [(Grid::uniform(9, 0.2), "node 3 is at 0.6"), (shifted(1.1e-4), "node 3 is at 0.30011")] {
        for made in made(grid.clone(), vec![force.clone()]) {
            assert_says(&made.expect_err("another time"), &["`place` belongs to 0.3 s", found, "use the steps"]);
        }
        let moving = vec![force.clone(), Free::new(Quantity::Duration)];
        made(grid, moving).into_iter().for_each(|made| made.expect("the optimiser moves the node"));
    }
    let short = Inputs::at_rest(&system, Grid::uniform(2, 0.1)).check_reading_times(&system);
    assert_says(&short.expect_err("two steps"), &["the grid has no node 3"]);
    // Nodes of parts have the numbers of the whole, and those after an event move.
    let part = |first, last| Inputs::at_rest(&system, Grid::uniform(9, 0.2).part(first, last)).check_reading_times(&system);
    assert_says(&part(2, 5).expect_err("node 3"), &["node 3 is at 0.6"]);
    part(4, 9).expect("without node 3");
    part(0, 2).expect("without node 3");
    let at = |node| {
        let inputs = Inputs::at_rest(&event, Grid::uniform(9, 0.2));
        Inputs { events: vec![event.event(0).at(node)], ..inputs }.check_reading_times(&event)
    };
    at(2).expect("after the event");
    assert_says(&at(3).expect_err("at the event"), &["node 3 is at 0.6"]);
}

#[test]
fn times_of_readings_are_finite() {
    let (mut scene, ..) = read_at_a_time();
    scene.reading_time("never", 1, f64::NAN);
    assert_says(&scene.compile().expect_err("NaN"), &["the time of reading `never`", "NaN"]);
}

/// t − 1.
struct Early;

impl Cost<0, 0, 0, 0> for Early {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.t - 1.0
    }
}
