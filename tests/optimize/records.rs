//! Records of several experiments: common parameters, own starts, readings of points and angles, and guesses far from the truth.

use hamiltonian_adjoint::axis::Axis;
use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::optimize::{
    Fit, Free, MotionProblem, Options, Problem, Quantity, Reason, Trials, Variables, identify, levenberg_marquardt, silent,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Design, Grid, Inputs, Scene, Settings, Trajectory, Warning, simulate};
use nalgebra::DMatrix;
use std::f64::consts::FRAC_PI_2;

use super::common::assert_says;
use super::shooting::assert_rows;

const OPTIONS: Options =
    Options { iterations: 200, target: None, stationarity: 1e-8, violation: 1e-9, memory: 30, first_step: None };
/// The standard deviation of a reading, m or rad.
const NOISE: f64 = 2e-3;

/// Nearly normal: sums of 12 uniform numbers.
fn normal(random: &mut Random) -> f64 {
    (0..12).map(|_| random.uniform(-0.5, 0.5)).sum()
}

/// A cart on a spring with damping, in a scene that may have several of them.
fn cart(scene: &mut Scene, name: &str, [stiffness, damping]: [Design; 2]) -> Body {
    let cart = scene.body(name, 1.0, 0.1, [1.0, 0.0, 0.0]);
    scene.prismatic(&format!("rail of {name}"), Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), 0.0);
    scene.spring_damper(
        &format!("spring of {name}"),
        Body::GROUND.at(-1.0, 0.0),
        cart.at(0.0, 0.0),
        stiffness,
        2.0,
        damping,
    );
    cart
}

/// x − 1 m of a cart with the mass 1 kg that starts at rest.
fn position([stiffness, damping]: [f64; 2], start: f64, t: f64) -> f64 {
    let (decay, pace) = (0.5 * damping, (stiffness - 0.25 * damping * damping).sqrt());
    (-decay * t).exp() * start * ((pace * t).cos() + decay / pace * (pace * t).sin())
}

const TRUTH: [f64; 2] = [9.0, 0.4];

/// Noisy readings of a cart that starts at a distance from its place of rest, every tenth node.
fn read(start: f64, grid: &Grid, random: &mut Random) -> Vec<(usize, f64)> {
    let times = grid.times().into_iter().enumerate().skip(10).step_by(10);
    times.map(|(node, t)| (node, 1.0 + position(TRUTH, start, t) + NOISE * normal(random))).collect()
}

/// A record of a cart whose parameters and start are free.
fn record(readings: &[(usize, f64)], grid: &Grid, deviation: f64) -> MotionProblem {
    let mut scene = Scene::new();
    let designs = [scene.design("stiffness", 7.0), scene.design("damping", 0.2)];
    let cart = cart(&mut scene, "cart", designs);
    scene.axis_readings("position", cart.coordinates[0], readings, deviation);
    let system = scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, grid.clone());
    let mut free = designs.map(Free::design).to_vec();
    free.push(Free::new(Quantity::Coordinate(cart.coordinates[0])));
    let variables = Variables::new(&system, &inputs, free).expect("free");
    MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a record")
}

fn fit(problem: &mut dyn Problem, start: &[f64]) -> Fit {
    let fit = levenberg_marquardt(problem, start, &OPTIONS, &mut silent).expect("fits");
    assert!(fit.outcome.reason.is_converged(), "{fit}");
    fit
}

fn misfit(fit: &Fit) -> Option<(f64, f64)> {
    fit.outcome.warnings.iter().find_map(|warning| match warning {
        Warning::Misfit { chi_squared, probability, .. } => Some((*chi_squared, *probability)),
        _ => None,
    })
}

fn is_shifted(fit: &Fit) -> bool {
    fit.outcome.warnings.iter().any(|warning| matches!(warning, Warning::GridShift { .. }))
}

#[test]
fn records_with_common_parameters_are_one_problem_with_all_motions() {
    let (grid, mut random) = (Grid::uniform(150, 0.01), Random::new(3));
    let starts = [0.3, -0.2, 0.45];
    let readings = starts.map(|start| read(start, &grid, &mut random));
    let mut trials =
        Trials::sharing_designs(readings.iter().map(|of| record(of, &grid, NOISE)).collect()).expect("three records");
    assert_eq!(trials.variables(), 2 + 3);
    let names: Vec<String> = (0..5).map(|i| trials.variable_name(i)).collect();
    assert_eq!(names[..3], ["stiffness", "damping", "initial cart.x of trial 0"].map(String::from), "{names:?}");
    let start = trials.start();
    let found = fit(&mut trials, &start);

    // All carts in one scene.
    let mut scene = Scene::new();
    let designs = [scene.design("stiffness", 7.0), scene.design("damping", 0.2)];
    let mut free = designs.map(Free::design).to_vec();
    for (k, readings) in readings.iter().enumerate() {
        let cart = cart(&mut scene, &format!("cart {k}"), designs);
        scene.axis_readings(&format!("position of {k}"), cart.coordinates[0], readings, NOISE);
        free.push(Free::new(Quantity::Coordinate(cart.coordinates[0])));
    }
    let system = scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, grid);
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let mut long = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("one motion");
    let start = long.start();
    let one = fit(&mut long, &start);
    for (a, b) in found.outcome.x.iter().zip(&one.outcome.x) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
    let [ours, theirs] = [&found, &one].map(|fit| fit.standard_errors().expect("determined"));
    assert!(ours.iter().zip(&theirs).all(|(a, b)| (a - b).abs() < 1e-6 * b), "{ours:?} {theirs:?}");
    assert!((found.chi_squared() - one.chi_squared()).abs() < 1e-9 && found.degrees_of_freedom() == 3 * 15 - 5);
    // The inputs of each record have the common parameters and its own start.
    let inputs = trials.inputs_at(&found.outcome.x);
    for (k, inputs) in inputs.iter().enumerate() {
        assert_eq!((inputs.design[0], inputs.start.q()[0]), (found.outcome.x[0], found.outcome.x[2 + k]));
    }
}

#[test]
fn derivatives_of_records_are_those_of_differences() {
    let (grid, mut random) = (Grid::uniform(40, 0.02), Random::new(8));
    let records = [0.3, -0.2].map(|start| record(&read(start, &grid, &mut random), &grid, NOISE));
    let mut trials = Trials::sharing_designs(records.into()).expect("two records");
    let x = [8.0, 0.3, 1.25, 0.85];
    assert_rows(&mut trials, &x);
    let count = trials.constraints().len();
    let mut values = |x: &[f64]| {
        let mut c = vec![0.0; count];
        trials.evaluate(x, &mut c).expect("motions");
        c
    };
    let step = 1e-4;
    let columns: Vec<Vec<f64>> = (0..4)
        .map(|i| {
            let at = |by: f64| {
                let mut x = x;
                x[i] += by;
                x
            };
            let [a, b] = [values(&at(step)), values(&at(-step))];
            a.iter().zip(b).map(|(a, b)| (a - b) / (2.0 * step)).collect()
        })
        .collect();
    values(&x);
    let mut jacobian = DMatrix::zeros(count, 4);
    trials.jacobian(&Vec::from_iter(0..count), &mut jacobian).expect("a Jacobian");
    let mut change = vec![0.0; count];
    for (i, column) in columns.iter().enumerate() {
        let size = column.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        let mut direction = [0.0; 4];
        direction[i] = 1.0;
        trials.push_forward(&direction, &mut change).expect("a change");
        for (j, difference) in column.iter().enumerate() {
            assert!((jacobian[(j, i)] - difference).abs() < 1e-6 * size, "row {j}, column {i}");
            assert!((jacobian[(j, i)] - change[j]).abs() < 1e-10 * size, "row {j}, column {i}");
        }
    }
    // The start of a record affects its own readings alone.
    assert!(
        (0..count).all(|j| (jacobian[(j, 2)] == 0.0) == (j >= count / 2) && (jacobian[(j, 3)] == 0.0) == (j < count / 2))
    );
}

#[test]
fn the_truth_is_within_two_standard_errors_as_often_as_it_should_be() {
    let (grid, mut random) = (Grid::uniform(300, 0.005), Random::new(17));
    let (mut all, mut within, mut warned) = (0, 0, 0);
    for _ in 0..60 {
        let starts = [0; 3].map(|_| random.uniform(0.2, 0.5));
        let records = starts.map(|start| record(&read(start, &grid, &mut random), &grid, NOISE));
        let mut trials = Trials::sharing_designs(records.into()).expect("three records");
        let start = trials.start();
        let fit = fit(&mut trials, &start);
        warned += usize::from(misfit(&fit).is_some() || is_shifted(&fit));
        let errors = fit.absolute_errors().expect("determined");
        let truth = TRUTH.into_iter().chain(starts.map(|start| 1.0 + start));
        for ((x, truth), error) in fit.outcome.x.iter().zip(truth).zip(errors) {
            all += 1;
            within += usize::from((x - truth).abs() <= 2.0 * error);
        }
    }
    println!("{within} of {all} variables within two standard errors; {warned} of 60 fits warn");
    // 95.4 %, with a standard deviation of 3.6.
    assert!((276..=297).contains(&within) && warned == 0, "{within} of {all}, {warned} warn");
}

#[test]
fn long_steps_warn_and_short_ones_do_not() {
    for (steps, warns) in [(300, false), (30, true)] {
        let (grid, mut random) = (Grid::uniform(steps, 1.5 / steps as f64), Random::new(5));
        let records = [0.4, -0.3].map(|start| {
            let every: Vec<(usize, f64)> = (1..=30)
                .map(|k| {
                    let node = k * steps / 30;
                    (node, 1.0 + position(TRUTH, start, grid.times()[node]) + NOISE * normal(&mut random))
                })
                .collect();
            record(&every, &grid, NOISE)
        });
        let mut trials = Trials::sharing_designs(records.into()).expect("two records");
        let start = trials.start();
        let fit = fit(&mut trials, &start);
        assert_eq!(is_shifted(&fit), warns, "{steps} steps: {fit}");
        // Errors of the grid do not count as a misfit of the model.
        assert!(misfit(&fit).is_none(), "{steps} steps: {:?}", misfit(&fit));
    }
}

#[test]
fn a_chi_squared_that_is_too_large_or_too_small_warns() {
    let (grid, mut random) = (Grid::uniform(600, 0.005), Random::new(9));
    let readings = read(0.4, &grid, &mut random);
    let of = |readings: &[(usize, f64)], deviation: f64| {
        let mut problem = record(readings, &grid, deviation);
        let start = problem.start();
        fit(&mut problem, &start)
    };
    assert_eq!(misfit(&of(&readings, NOISE)), None);
    // An effect that the model lacks: the place of rest drifts by 1 cm.
    let drifting: Vec<_> = readings.iter().map(|(node, x)| (*node, x + 1e-2 * *node as f64 / 600.0)).collect();
    let fit = of(&drifting, NOISE);
    let (chi, probability) = misfit(&fit).expect("a warning");
    assert!(chi > 100.0 && probability < 1e-6, "{chi} {probability}");
    let text = |fit: &Fit| fit.outcome.warnings.iter().map(Warning::to_string).collect::<String>();
    assert!(text(&fit).contains("larger than the errors of the readings explain"), "{}", text(&fit));
    let fit = of(&readings, 5.0 * NOISE);
    let (chi, probability) = misfit(&fit).expect("a warning");
    assert!(chi < 10.0 && probability < 1e-6, "{chi} {probability}");
    assert!(text(&fit).contains("too large by a factor of 5"), "{}", text(&fit));

    // Weights that state no standard deviation.
    for (weight, warns) in [(1.0, false), (1.0 / (5.0 * NOISE), true)] {
        let mut scene = Scene::new();
        let designs = [scene.design("stiffness", 7.0), scene.design("damping", 0.2)];
        let cart = cart(&mut scene, "cart", designs);
        for (node, x) in &readings {
            scene.reading(&format!("x {node}"), cart.coordinates[0], *node, *x, weight);
        }
        let system = scene.compile().expect("a scene");
        let mut inputs = Inputs::at_rest(&system, grid.clone());
        inputs.start.q_mut()[0] = 1.4;
        let variables = Variables::new(&system, &inputs, designs.map(Free::design).to_vec()).expect("free");
        let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a record");
        let start = problem.start();
        let fit = levenberg_marquardt(&mut problem, &start, &OPTIONS, &mut silent).expect("fits");
        assert_eq!(misfit(&fit).is_some(), warns, "{weight}");
    }
}

/// Two links that hang from the ground, with friction in the joints, and their parameters.
struct Arm {
    scene: Scene,
    designs: [Design; 3],
    links: [Body; 2],
}

const ARM: [f64; 3] = [0.8, 0.05, 0.03];

/// An arm whose links begin at these angles, rad from the horizontal.
fn arm(guess: [f64; 3], [first, second]: [f64; 2]) -> Arm {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let names = ["lower mass", "shoulder friction", "elbow friction"];
    let mut guess = guess.iter();
    let designs = names.map(|name| scene.design(name, *guess.next().expect("three")));
    let elbow = [first.cos(), first.sin()];
    let upper = scene.body("upper", 1.0, 1.0 / 12.0, [0.5 * elbow[0], 0.5 * elbow[1], first]);
    let place = [elbow[0] + 0.5 * second.cos(), elbow[1] + 0.5 * second.sin(), second];
    let lower = scene.body("lower", designs[0], designs[0] * (1.0 / 12.0), place);
    scene.revolute("shoulder", Body::GROUND.at(0.0, 0.0), upper.at(-0.5, 0.0));
    scene.revolute("elbow", upper.at(0.5, 0.0), lower.at(-0.5, 0.0));
    scene.joint_friction("shoulder friction", Body::GROUND, upper, designs[1]);
    scene.joint_friction("elbow friction", upper, lower, designs[2]);
    Arm { scene, designs, links: [upper, lower] }
}

/// The motion of the true arm.
fn arm_motion(begin: [f64; 2], grid: &Grid) -> Trajectory {
    let system = arm(ARM, begin).scene.compile().expect("an arm");
    simulate(&system, &Inputs::at_rest(&system, grid.clone()), Settings::default()).expect("a motion")
}

/// A record of the position of the tip and of the angle between the links, every fifth node.
fn arm_record(begin: [f64; 2], guess: [f64; 3], grid: &Grid, random: &mut Random) -> MotionProblem {
    let motion = arm_motion(begin, grid);
    let Arm { mut scene, designs, links: [upper, lower] } = arm(guess, begin);
    let nodes = (5..grid.nodes()).step_by(5);
    let mut noisy = |of: &dyn Fn(usize) -> f64| -> Vec<(usize, f64)> {
        nodes.clone().map(|node| (node, of(node) + NOISE * normal(random))).collect()
    };
    let [x, y, phi] = lower.coordinates.map(|q| q.index());
    let q = |i: usize, node: usize| motion.q[(i, node)];
    let tip_x = noisy(&|node| q(x, node) + 0.5 * q(phi, node).cos());
    let tip_y = noisy(&|node| q(y, node) + 0.5 * q(phi, node).sin());
    let bend = noisy(&|node| q(phi, node) - q(upper.coordinates[2].index(), node));
    scene.point_readings("tip x", lower.at(0.5, 0.0), [1.0, 0.0], &tip_x, NOISE);
    scene.point_readings("tip y", lower.at(0.5, 0.0), [0.0, 1.0], &tip_y, NOISE);
    scene.axis_readings("bend", Axis::difference(upper.coordinates[2], 1.0, lower.coordinates[2]), &bend, NOISE);
    let system = scene.compile().expect("an arm with readings");
    let inputs = Inputs::at_rest(&system, grid.clone());
    let free = designs.map(|design| Free::design(design).logarithmic()).to_vec();
    let variables = Variables::new(&system, &inputs, free).expect("free");
    MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a record")
}

#[test]
fn points_and_angles_between_bodies_are_read() {
    let (grid, mut random) = (Grid::uniform(100, 0.01), Random::new(21));
    let begins = [[-1.0, -0.6], [-2.2, -1.3]];
    let records = begins.map(|begin| arm_record(begin, [0.6, 0.1, 0.1], &grid, &mut random));
    let mut trials = Trials::sharing_designs(records.into()).expect("two records");
    assert_rows(&mut trials, &[-0.4, -2.0, -2.5]);
    let start = trials.start();
    let fit = fit(&mut trials, &start);
    let errors = fit.absolute_errors().expect("determined");
    for ((x, truth), error) in fit.outcome.x.iter().zip(ARM).zip(&errors) {
        assert!((x - truth.ln()).abs() < 3.5 * error && *error < 0.1, "{fit}: {x} {} {error}", truth.ln());
    }
    assert!(misfit(&fit).is_none(), "{fit}");
}

#[test]
fn bad_readings_are_refused_by_name() {
    let compile = |add: &dyn Fn(&mut Scene, Body)| {
        let mut scene = Scene::new();
        let rod = scene.body("rod", 1.0, 0.1, [0.0; 3]);
        add(&mut scene, rod);
        scene.compile().expect_err("a bad reading")
    };
    let axis = |deviation: f64, value: f64| {
        compile(&move |scene, rod| {
            scene.axis_readings("encoder", rod.coordinates[2], &[(1, 0.0), (2, value)], deviation);
        })
    };
    assert_says(&axis(0.0, 1.0), &["standard deviation of reading `encoder.0`", "0", "positive"]);
    assert_says(&axis(-1.0, 1.0), &["encoder.0", "-1"]);
    assert_says(&axis(f64::NAN, 1.0), &["encoder.0", "NaN"]);
    assert_says(&axis(1.0, f64::INFINITY), &["encoder.1"]);
    let ground = compile(&|scene, _| {
        scene.point_readings("camera", Body::GROUND.at(0.0, 0.0), [1.0, 0.0], &[(1, 0.0)], 1.0);
    });
    assert_says(&ground, &["camera"]);
    assert_says(&Trials::sharing_designs(Vec::new()).expect_err("no records"), &["trials", "at least 1"]);
    // A parameter that is a logarithm in one record cannot be shared.
    let grid = Grid::uniform(20, 0.01);
    let as_logarithm = {
        let mut scene = Scene::new();
        let designs = [scene.design("stiffness", 7.0), scene.design("damping", 0.2)];
        cart(&mut scene, "cart", designs);
        let system = scene.compile().expect("a scene");
        let inputs = Inputs::at_rest(&system, grid.clone());
        let free = vec![Free::design(designs[0]).logarithmic()];
        let variables = Variables::new(&system, &inputs, free).expect("free");
        MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a record")
    };
    let error = Trials::sharing_designs(vec![record(&[(10, 1.0)], &grid, NOISE), as_logarithm]).expect_err("two forms");
    assert_says(&error, &["variable 0 of trial 1", "`stiffness`", "same scale and form"]);
}

/// A rod that is balanced near its upright position by a torque, of which only the values are known, and readings of its angle. Without the law of the
/// torque the motion is unstable: deviations grow by a factor of 40 in each second.
fn balanced(truth: [f64; 3], guess: [f64; 3], begin: f64, random: &mut Random) -> MotionProblem {
    let of = |[mass, friction, stiffness]: [f64; 3], gains: Option<[f64; 2]>| {
        let mut scene = Scene::new();
        scene.gravity(0.0, -9.81);
        let designs = [scene.design("mass", mass), scene.design("friction", friction), scene.design("stiffness", stiffness)];
        let rod = scene.body("rod", designs[0], designs[0] * (1.0 / 12.0), [0.5 * begin.cos(), 0.5 * begin.sin(), begin]);
        scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
        scene.joint_friction("bearing", Body::GROUND, rod, designs[1]);
        scene.torsional_spring_damper("coil", Body::GROUND, rod, designs[2], FRAC_PI_2, 0.0);
        let torque = scene.control("torque");
        scene.torque_actuator("motor", Body::GROUND, rod, torque);
        if let Some([k, d]) = gains {
            scene.torsional_spring_damper("balance", Body::GROUND, rod, k, FRAC_PI_2, d);
        }
        (scene, designs, rod.coordinates[2])
    };
    let (grid, gains) = (Grid::uniform(400, 0.01), [12.0, 1.5]);
    let (scene, _, phi) = of(truth, Some(gains));
    let system = scene.compile().expect("a rod");
    let mut inputs = Inputs::at_rest(&system, grid.clone());
    let (strength, pace) = (random.uniform(0.5, 1.5), random.uniform(3.0, 6.0));
    inputs.controls.iter_mut().zip(grid.times()).for_each(|(u, t)| *u = strength * (pace * t).sin());
    let motion = simulate(&system, &inputs, Settings::default()).expect("a motion");
    let state = |node: usize| [motion.q[(phi.index(), node)] - FRAC_PI_2, motion.v[(phi.index(), node)]];
    for (node, u) in inputs.controls.iter_mut().enumerate() {
        let [angle, rate] = state(node);
        *u -= gains[0] * angle + gains[1] * rate;
    }
    let (mut scene, designs, phi) = of(guess, None);
    let nodes = (2..grid.nodes()).step_by(2);
    let readings: Vec<_> = nodes.map(|node| (node, state(node)[0] + FRAC_PI_2 + NOISE * normal(random))).collect();
    scene.axis_readings("angle", phi, &readings, NOISE);
    let system = scene.compile().expect("a rod with readings");
    let inputs = Inputs { controls: inputs.controls, ..Inputs::at_rest(&system, grid) };
    let free = designs.map(|design| Free::design(design).logarithmic()).to_vec();
    let variables = Variables::new(&system, &inputs, free).expect("free");
    MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a record")
}

/// True if the variables are the truth within five standard errors, and the residuals are explained.
fn is_found(fit: &Fit, truth: [f64; 3]) -> bool {
    let Some(errors) = fit.absolute_errors() else { return false };
    let x = fit.outcome.x.iter().zip(truth).zip(errors);
    misfit(fit).is_none() && x.into_iter().all(|((x, truth), error)| (x - truth.ln()).abs() < 5.0 * error)
}

/// Counts records that are fitted by the motions as they are, and by [`identify`].
fn counted(records: impl Iterator<Item = (Vec<MotionProblem>, [f64; 3])>) -> [usize; 2] {
    let mut counts = [0; 2];
    for (records, truth) in records {
        let mut trials = Trials::sharing_designs(records).expect("records");
        let start = trials.start();
        let one = levenberg_marquardt(&mut trials, &start, &OPTIONS, &mut silent).expect("fits");
        counts[0] += usize::from(is_found(&one, truth));
        trials.evaluate(&start, &mut vec![0.0; trials.constraints().len()]).ok();
        let found = identify(&mut trials, &OPTIONS, &mut silent).expect("fits");
        println!("{found}");
        counts[1] += usize::from(is_found(&found.fit, truth));
        assert_eq!(trials.start(), found.fit.outcome.x, "the problem is left elsewhere");
        let [iterations, least] = [found.attempts.iter().map(|of| of.iterations).sum(), found.fit.outcome.iterations];
        assert_eq!(iterations, least);
    }
    counts
}

#[test]
fn parameters_of_unstable_motions_are_found_from_far() {
    let mut random = Random::new(5);
    let records = (0..4).map(|_| {
        let truth = [random.uniform(0.8, 1.2), random.uniform(0.05, 0.2), random.uniform(0.5, 2.0)];
        let guess = truth.map(|of| of * random.uniform(-1.0, 1.0).exp());
        let begins = [0; 2].map(|_| FRAC_PI_2 + random.uniform(-0.3, 0.3));
        (begins.map(|begin| balanced(truth, guess, begin, &mut random)).into(), truth)
    });
    let [by_motion, found] = counted(records);
    println!("of 4 pairs of records, {by_motion} are fitted by the motions as they are, {found} with segments");
    assert_eq!([by_motion, found], [0, 4]);
}

#[test]
fn parameters_of_long_motions_of_an_arm_are_found_from_far() {
    let (mut random, grid) = (Random::new(77), Grid::uniform(500, 0.01));
    let records = (0..2).map(|_| {
        let guess = ARM.map(|of| of * random.uniform(-1.0, 1.0).exp());
        let begins = [0; 2].map(|_| [random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5)]);
        (begins.map(|begin| arm_record(begin, guess, &grid, &mut random)).into(), ARM)
    });
    let [by_motion, found] = counted(records);
    println!("of 2 pairs of records of an arm, {by_motion} are fitted by the motions as they are, {found} with segments");
    assert!(by_motion < 2 && found == 2);
}

#[test]
fn a_model_that_explains_no_readings_is_confirmed_in_another_way() {
    let (grid, mut random) = (Grid::uniform(300, 0.01), Random::new(9));
    // The place of rest drifts.
    let drifting = |start: f64, random: &mut Random| -> Vec<(usize, f64)> {
        read(start, &grid, random).into_iter().map(|(node, x)| (node, x + 1e-2 * node as f64 / 300.0)).collect()
    };
    let records = [0.4, -0.3].map(|start| record(&drifting(start, &mut random), &grid, NOISE));
    let mut trials = Trials::sharing_designs(records.into()).expect("two records");
    let found = identify(&mut trials, &OPTIONS, &mut silent).expect("fits");
    assert!(found.attempts.len() > 1 && misfit(&found.fit).is_some(), "{found}");
    assert!(found.attempts.iter().all(|of| of.value >= found.fit.outcome.value), "{found}");

    // A single record, and readings whose deviations are not known: a second way confirms the first.
    let mut scene = Scene::new();
    let designs = [scene.design("stiffness", 7.0), scene.design("damping", 0.2)];
    let cart = cart(&mut scene, "cart", designs);
    for (node, x) in read(0.0, &grid, &mut random) {
        scene.reading(&format!("x {node}"), cart.coordinates[0], node, x + 0.1 * (0.02 * node as f64).sin(), 1.0);
    }
    let system = scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, grid.clone());
    let free = vec![Free::design(designs[0]), Free::new(Quantity::Coordinate(cart.coordinates[0]))];
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let single = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a record");
    let mut trials = Trials::sharing_designs(vec![single]).expect("a record");
    let found = identify(&mut trials, &OPTIONS, &mut silent).expect("fits");
    assert!(found.attempts.len() >= 2 && misfit(&found.fit).is_none(), "{found}");

    // Too few readings for segments; and a callback that stops.
    let mut few = Trials::sharing_designs(vec![record(&[(50, 1.3), (100, 0.8)], &grid, NOISE)]).expect("a record");
    assert_eq!(identify(&mut few, &OPTIONS, &mut silent).expect("fits").attempts.len(), 1);
    let mut stop = |_: &_, _: &[f64]| std::ops::ControlFlow::Break(());
    let stopped = identify(&mut trials, &OPTIONS, &mut stop).expect("fits");
    assert_eq!((stopped.attempts.len(), stopped.fit.outcome.reason), (1, Reason::Interrupted));
}
