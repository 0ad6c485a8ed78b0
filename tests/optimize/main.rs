//! Optimisation: problems with known solutions, the swing-up, the chain rule of what is free, and what goes wrong.
mod accurate;
mod coarse;
#[path = "../common/mod.rs"]
mod common;
mod degenerate;
mod ends;
mod events;
mod extremes;
mod flat;
mod flying;
mod follow;
mod hanging;
mod identified;
mod interrupted;
mod near;
mod overdetermined;
mod reach;
mod records;
mod refined;
mod refused;
mod segments;
mod shooting;
mod solve;
mod stages;
mod starts;
mod stopping;
mod traces;
mod units;

use common::assert_says;
use hamiltonian_adjoint::optimize::{
    Free, Interval, Iterate, MotionProblem, Options, Outcome, Problem, Quantity, Reason, Trials, Variables, Watcher,
    augmented_lagrangian, homotopy, interior_point, lbfgs, levenberg_marquardt, lowest, multi_start, silent,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{
    Control, Cost, CostPoint, Error, Grid, Inputs, LongSolver, Scalar, Scene, Scheme, Settings, Solver, Start, Sum, System,
    gradient,
};
use nalgebra::SVector;
use std::f64::consts::FRAC_PI_2;
use std::ops::ControlFlow;

/// A method of this module, from a start.
type Method = fn(&mut dyn Problem, &[f64], &Options, &mut Watcher) -> Result<Outcome, Error>;

/// f and c with their gradients, row by row, as functions of x.
type Function = fn(&[f64], &mut [f64], &mut [f64]) -> f64;

/// A problem given by a function that writes c and the gradients of f and of all c.
struct Given {
    function: Function,
    bounds: Vec<Interval>,
    constraints: Vec<Interval>,
    gradients: Vec<f64>,
    x: Vec<f64>,
    weights: Vec<f64>,
}

impl Given {
    fn new(function: Function, bounds: Vec<Interval>, constraints: Vec<Interval>) -> Self {
        let gradients = vec![0.0; (1 + constraints.len()) * bounds.len()];
        Given { function, bounds, constraints, gradients, x: Vec::new(), weights: Vec::new() }
    }

    /// The weighted gradient of what is at hand.
    fn weighted(&self, gradients: &[f64], i: usize) -> f64 {
        self.weights.iter().enumerate().map(|(j, w)| w * gradients[j * self.bounds.len() + i]).sum()
    }
}

impl Problem for Given {
    fn variables(&self) -> usize {
        self.bounds.len()
    }
    fn bounds(&self) -> Vec<Interval> {
        self.bounds.clone()
    }
    fn constraints(&self) -> Vec<Interval> {
        self.constraints.clone()
    }
    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        assert!(x.iter().all(|x| x.is_finite()), "a method asks for {x:?}");
        self.x = x.to_vec();
        Ok((self.function)(x, c, &mut self.gradients))
    }
    fn gradient(&mut self, f: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        self.weights = [&[f], c].concat();
        gradient.iter_mut().enumerate().for_each(|(i, g)| *g = self.weighted(&self.gradients, i));
        Ok(())
    }
    /// By differences of fourth order, as long for any length of the direction.
    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        assert!(direction.iter().all(|x| x.is_finite()), "a method asks along {direction:?}");
        let length = direction.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
        let step = 1e-3 / if length > 0.0 { length } else { 1.0 };
        product.fill(0.0);
        for (steps, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
            let moved: Vec<f64> = self.x.iter().zip(direction).map(|(x, d)| x + steps * step * d).collect();
            let (mut c, mut gradients) = (vec![0.0; self.constraints.len()], self.gradients.clone());
            (self.function)(&moved, &mut c, &mut gradients);
            let sums = product.iter_mut().enumerate();
            sums.for_each(|(i, sum)| *sum += weight * self.weighted(&gradients, i) / (12.0 * step));
        }
        Ok(())
    }
}

fn rosenbrock(x: &[f64], _: &mut [f64], g: &mut [f64]) -> f64 {
    g.fill(0.0);
    (1..x.len()).fold(0.0, |sum, i| {
        let (a, b) = (x[i] - x[i - 1] * x[i - 1], 1.0 - x[i - 1]);
        g[i] += 200.0 * a;
        g[i - 1] -= 400.0 * a * x[i - 1] + 2.0 * b;
        sum + 100.0 * a * a + b * b
    })
}

#[test]
fn a_curved_valley_is_followed_to_its_end() {
    let mut problem = Given::new(rosenbrock, vec![Interval::FREE; 10], vec![]);
    let outcome =
        lbfgs(&mut problem, &[-1.2; 10], &Options { stationarity: 1e-10, ..Options::default() }, &mut silent).expect("fits");
    assert_eq!(outcome.reason, Reason::Stationary);
    let error = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| most.max((x - 1.0).abs()));
    assert!(error(&outcome.x) < 1e-8 && outcome.evaluations < 150, "{outcome:?}");
    assert!(outcome.history.windows(2).all(|two| two[1].value < two[0].value), "it never goes up");
    // The start is steep: a millionth of its gradient would be two thousandths in x.
    let exact = Options { stationarity: 1e-10, ..Options::default() };
    let outcome = interior_point(&mut problem, &[-1.2; 10], &exact, &mut silent).expect("fits");
    println!("{} evaluations, {} products", outcome.evaluations, outcome.products);
    assert_eq!(outcome.reason, Reason::Stationary);
    assert!(error(&outcome.x) < 1e-8 && outcome.evaluations < 80, "{outcome:?}");
}

#[test]
fn bounds_are_kept_and_reached() {
    let bounds = vec![Interval::new(-2.0, 0.5), Interval::at_least(-1.0)];
    let mut problem = Given::new(rosenbrock, bounds, vec![]);
    // The start is moved into the bounds.
    // A derivative of 350 at the start and a curvature of 200: 1e-9 of the former leaves 2e-9.
    let exact = Options { stationarity: 1e-9, ..Options::default() };
    let outcome = lbfgs(&mut problem, &[3.0, 2.0], &exact, &mut silent).expect("fits");
    assert!(outcome.reason.is_converged(), "{:?}", outcome.reason);
    assert!((outcome.x[0] - 0.5).abs() < 1e-12 && (outcome.x[1] - 0.25).abs() < 1e-7, "{:?}", outcome.x);
    let exact = Options { stationarity: 1e-10, ..Options::default() };
    let outcome = interior_point(&mut problem, &[3.0, 2.0], &exact, &mut silent).expect("fits");
    assert!(outcome.reason.is_converged() && outcome.x[0] < 0.5, "{:?}", outcome.reason);
    assert!((outcome.x[0] - 0.5).abs() < 1e-5 && (outcome.x[1] - 0.25).abs() < 1e-5, "{:?}", outcome.x);
    // What has no room between its bounds stays where it is.
    problem.bounds[0] = Interval::new(0.3, 0.3);
    let outcome = interior_point(&mut problem, &[3.0, 2.0], &exact, &mut silent).expect("fits");
    assert!(outcome.x[0] == 0.3 && (outcome.x[1] - 0.09).abs() < 1e-6, "{:?}", outcome.x);
}

/// Problem 71 of Hock and Schittkowski.
fn hs71(x: &[f64], c: &mut [f64], g: &mut [f64]) -> f64 {
    let [a, b, d, e] = [x[0], x[1], x[2], x[3]];
    c[0] = a * b * d * e;
    c[1] = a * a + b * b + d * d + e * e;
    g.copy_from_slice(
        &[
            [e * (2.0 * a + b + d), a * e, a * e + 1.0, a * (a + b + d)],
            [b * d * e, a * d * e, a * b * e, a * b * d],
            [2.0 * a, 2.0 * b, 2.0 * d, 2.0 * e],
        ]
        .concat(),
    );
    a * e * (a + b + d) + d
}

#[test]
fn equalities_inequalities_and_bounds_hold_at_once() {
    let constraints = vec![Interval::at_least(25.0), Interval::new(40.0, 40.0)];
    for method in [augmented_lagrangian, interior_point] {
        let mut problem = Given::new(hs71, vec![Interval::new(1.0, 5.0); 4], constraints.clone());
        let outcome = method(&mut problem, &[1.0, 5.0, 5.0, 1.0], &Options::default(), &mut silent).expect("fits");
        assert_eq!(outcome.reason, Reason::Stationary, "{outcome:?}");
        assert!((outcome.value - 17.0140173).abs() < 1e-6 && outcome.violation < 1e-9, "{outcome:?}");
        // The multipliers are those of the literature: −0.5523 and 0.1615.
        assert!((outcome.multipliers[0] + 0.55229).abs() < 1e-4 && (outcome.multipliers[1] - 0.16147).abs() < 1e-4);
        assert!(outcome.x.iter().all(|x| (1.0..=5.0).contains(x)));
    }
}

/// x e^(y t) at five times less measured values with errors that add up to nothing along both columns.
fn decay(x: &[f64], c: &mut [f64], g: &mut [f64]) -> f64 {
    const MEASURED: [f64; 5] = [2.01, 1.2, 0.74, 0.44, 0.28];
    for (k, measured) in MEASURED.iter().enumerate() {
        let (t, power) = (0.5 * k as f64, (x[1] * 0.5 * k as f64).exp());
        c[k] = x[0] * power - measured;
        (g[2 + 2 * k], g[3 + 2 * k]) = (power, x[0] * t * power);
    }
    0.0
}

#[test]
fn a_fit_says_how_well_its_variables_are_known() {
    let mut problem = Given::new(decay, vec![Interval::FREE; 2], vec![Interval::ZERO; 5]);
    let options = Options { stationarity: 1e-12, ..Options::default() };
    let fit = levenberg_marquardt(&mut problem, &[1.0, 0.0], &options, &mut silent).expect("fits");
    assert!(fit.outcome.reason.is_converged() && fit.outcome.evaluations < 15, "{:?}", fit.outcome);
    // As scipy.optimize.curve_fit has them would be another's word; here from the normal equations.
    let normal = (fit.jacobian.tr_mul(&fit.jacobian)).try_inverse().expect("regular") * (2.0 * fit.outcome.value / 3.0);
    let errors = fit.standard_errors().expect("determined");
    for i in 0..2 {
        assert!((errors[i] - normal[(i, i)].sqrt()).abs() < 1e-10 * errors[i]);
    }
    let absolute = fit.absolute_errors().expect("determined");
    let scatter = (fit.chi_squared() / fit.degrees_of_freedom() as f64).sqrt();
    assert!(errors.iter().zip(&absolute).all(|(error, absolute)| (error - scatter * absolute).abs() < 1e-14 * error));
    assert!((fit.outcome.x[0] - 2.0).abs() < 0.05 && (fit.outcome.x[1] + 1.0).abs() < 0.05, "{:?}", fit.outcome.x);
}

#[test]
fn with_few_residuals_the_step_is_the_shortest() {
    // x + 2 y + 2 z = 9: the nearest point to the origin is (1, 2, 2).
    fn plane(x: &[f64], c: &mut [f64], g: &mut [f64]) -> f64 {
        c[0] = x[0] + 2.0 * x[1] + 2.0 * x[2] - 9.0;
        g[3..].copy_from_slice(&[1.0, 2.0, 2.0]);
        0.0
    }
    let mut problem = Given::new(plane, vec![Interval::FREE; 3], vec![Interval::ZERO]);
    let fit = levenberg_marquardt(&mut problem, &[0.0; 3], &Options::default(), &mut silent).expect("fits");
    let error = fit.outcome.x.iter().zip([1.0, 2.0, 2.0]).fold(0.0, |most: f64, (x, y)| most.max((x - y).abs()));
    assert!(error < 1e-6, "{:?}", fit.outcome.x);
    assert!(fit.covariance().is_none(), "nothing is determined");
    // With x held by a bound the others do it.
    problem.bounds[0] = Interval::at_most(0.5);
    let fit = levenberg_marquardt(&mut problem, &[0.0; 3], &Options::default(), &mut silent).expect("fits");
    assert!(fit.outcome.value < 1e-12 && fit.outcome.x[0] <= 0.5, "{:?}", fit.outcome);
}

/// q − b.
struct Angle;
impl Cost<1, 0, 0, 1> for Angle {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        at.q[0] - b[0]
    }
}

/// u².
struct Effort;
impl Cost<0, 0, 1, 1> for Effort {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 1>, b: &SVector<S, 1>) -> S {
        at.u[0] * at.u[0] * b[0]
    }
}

/// The swing-up: as the paper's cost, or with the angles as outputs and the effort as cost.
fn swing_up(as_outputs: bool) -> (System, Control) {
    let example = CartPendulum::default();
    if !as_outputs {
        let scene = example.scene();
        let force = scene.control_named("force on the cart").expect("a control");
        return (scene.compile().expect("a system"), force);
    }
    let mut cart = example.mechanism();
    for (j, link) in cart.links.iter().enumerate() {
        let angle = cart.scene.output(&format!("angle {j}"));
        cart.scene.term(
            angle,
            &format!("angle {j}"),
            Angle,
            Sum::Terminal,
            [link.coordinates[2]],
            [],
            [],
            [FRAC_PI_2.into()],
        );
    }
    let force = cart.force;
    cart.scene.cost("effort", Effort, Sum::Integral, [], [], [force], [1e-4.into()]);
    (cart.scene.compile().expect("a system"), force)
}

fn constant(system: &System, force: f64) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(100, 0.02));
    inputs.controls.fill(force);
    inputs
}

fn problem(system: &System, force: Control, inputs: Inputs) -> MotionProblem {
    let variables = Variables::new(system, &inputs, vec![Free::control(force)]).expect("free");
    MotionProblem::new(system, Settings::default(), inputs, variables).expect("a problem")
}

#[test]
fn the_cart_swings_up() {
    let (system, force) = swing_up(false);
    let mut problem = problem(&system, force, constant(&system, 10.0));
    let options = Options { target: Some(1e-10), ..Options::default() };
    let start = problem.start();
    let outcome = lbfgs(&mut problem, &start, &options, &mut silent).expect("fits");
    println!("{} simulations, {} gradients: {:.1e}", outcome.evaluations, outcome.gradients, outcome.value);
    assert_eq!(outcome.reason, Reason::Target);
    assert!(outcome.evaluations <= 80 && outcome.gradients <= 60, "{} {}", outcome.evaluations, outcome.gradients);
    // What the problem keeps is the motion of the answer.
    assert_eq!(problem.solver.cost().expect("a motion"), outcome.value);
}

#[test]
fn the_angles_alone_take_few_simulations_from_most_starts() {
    let (system, force) = swing_up(true);
    // Half the sum of squares of the angles is the paper's cost.
    let options = Options { target: Some(1e-10), iterations: 200, ..Options::default() };
    let fit = |inputs: Inputs| {
        let mut problem = problem(&system, force, inputs);
        let start = problem.start();
        levenberg_marquardt(&mut problem, &start, &options, &mut silent).expect("fits").outcome
    };
    let outcome = fit(constant(&system, 10.0));
    println!("{} simulations, {} gradients: {:.1e}", outcome.evaluations, outcome.gradients, outcome.value);
    assert_eq!(outcome.reason, Reason::Target);
    assert!(outcome.evaluations <= 40 && outcome.gradients <= 40, "{} {}", outcome.evaluations, outcome.gradients);
    let reached = (0..20).filter(|start| {
        let mut inputs = constant(&system, 0.0);
        // Sums of sines, other ones for each start.
        inputs.set_control(force, |t| (1..6).map(|k| 6.0 * (f64::from(k) * (t + 1.7 * f64::from(*start))).sin()).sum());
        fit(inputs).reason == Reason::Target
    });
    let reached = reached.count();
    println!("{reached} of 20 starts");
    assert!(reached >= 16, "{reached}");
}

#[test]
fn the_least_effort_brings_the_links_upright() {
    let (system, force) = swing_up(true);
    let mut problem = problem(&system, force, constant(&system, 10.0));
    let start = problem.start();
    let options = Options { stationarity: 1e-5, ..Options::default() };
    let outcome = augmented_lagrangian(&mut problem, &start, &options, &mut silent).expect("fits");
    println!("{:?}: {} simulations: f = {:.6}", outcome.reason, outcome.evaluations, outcome.value);
    assert!(outcome.reason.is_converged() && outcome.violation <= 1e-9);
    assert!((outcome.value - 0.053744).abs() < 1e-5, "{}", outcome.value);
    // A minimum to a method of second derivatives, too.
    let again = interior_point(&mut problem, &outcome.x, &options, &mut silent).expect("fits");
    assert!(again.reason.is_converged() && again.violation <= 1e-9, "{again:?}");
    assert!((again.value - outcome.value).abs() < 1e-6, "{} {}", again.value, outcome.value);
    // By exact second derivatives in fewer, to another one.
    let outcome = interior_point(&mut problem, &start, &options, &mut silent).expect("fits");
    println!(
        "{:?}: {} simulations, {} products: f = {:.6}",
        outcome.reason, outcome.evaluations, outcome.products, outcome.value
    );
    assert!(outcome.reason.is_converged() && outcome.violation <= 1e-9);
    assert!((outcome.value - 0.141123).abs() < 1e-5 && outcome.evaluations <= 60, "{outcome:?}");
    // Close to a solution, where constraints are nearly linear, the method is Newton's.
    let last = outcome.history[outcome.history.len() - 1].stationarity;
    assert!(last < 1e-3 * outcome.history[outcome.history.len() - 2].stationarity);
    assert_eq!(problem.solver.cost().expect("a motion"), outcome.value);
}

/// dq/dt.
struct Speed;
impl Cost<1, 0, 0, 0> for Speed {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _: &SVector<S, 0>) -> S {
        at.v[0]
    }
}

/// 1.
struct One;
impl Cost<0, 0, 0, 0> for One {
    fn cost<S: Scalar>(&self, _: &CostPoint<S, 0, 0, 0>, _: &SVector<S, 0>) -> S {
        S::one()
    }
}

/// A cart of 2 kg that is pushed for 1 m, at rest at the end: by least effort or in the shortest time.
fn push(in_shortest_time: bool) -> (System, Control) {
    let mut scene = Scene::new();
    let cart = scene.body("cart", 2.0, 0.1, [0.0, 0.0, 0.0]);
    let force = scene.control("force");
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
    let (place, speed) = (scene.output("place"), scene.output("speed"));
    scene.term(place, "place", Angle, Sum::Terminal, [cart.coordinates[0]], [], [], [1.0.into()]);
    scene.term(speed, "speed", Speed, Sum::Terminal, [cart.coordinates[0]], [], [], []);
    if in_shortest_time {
        scene.cost("time", One, Sum::Integral, [], [], [], []);
    } else {
        scene.cost("effort", Effort, Sum::Integral, [], [], [force], [1.0.into()]);
    }
    (scene.compile().expect("a system"), force)
}

#[test]
fn the_shortest_time_switches_the_force_once() {
    let (system, force) = push(true);
    let inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.05));
    let free = vec![Free::control(force).within(-8.0, 8.0), Free::duration().within(0.1, 10.0)];
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    let start = problem.start();
    let outcome = interior_point(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
    println!("{:?}: {} simulations, {} products: {}", outcome.reason, outcome.evaluations, outcome.products, outcome.value);
    assert!(outcome.reason.is_converged() && outcome.violation <= 1e-9, "{:?}", outcome.reason);
    // Half of the way at F/m, half at −F/m: T = 2 √(m s/F) = 1 s, and a little more where a force that is linear between nodes switches.
    assert!((1.0..1.001).contains(&outcome.value), "{}", outcome.value);
    let force = problem.inputs_at(&outcome.x).controls;
    assert!(force.columns(0, 20).iter().all(|u| *u > 7.9) && force.columns(21, 20).iter().all(|u| *u < -7.9), "{force}");
}

#[test]
fn a_path_keeps_its_bounds_at_every_node() {
    // A cart with one link that swings up within 0.35 m to either side.
    const NODES: usize = 40;
    let build = |is_bounded: bool| {
        let mut cart = CartPendulum::with_links(1).mechanism();
        let (upright, force) = (cart.scene.output("upright"), cart.force);
        let angle = [cart.links[0].coordinates[2]];
        cart.scene.term(upright, "angle", Angle, Sum::Terminal, angle, [], [], [FRAC_PI_2.into()]);
        cart.scene.cost("effort", Effort, Sum::Integral, [], [], [force], [1e-3.into()]);
        let places = Vec::from_iter((1..=NODES).map(|node| {
            let (name, place) = (format!("place {node}"), [cart.cart.coordinates[0]]);
            let output = cart.scene.output(&name);
            cart.scene.term(output, &name, Angle, Sum::Node(node), place, [], [], [0.0.into()]);
            output
        }));
        let system = cart.scene.compile().expect("a system");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(NODES, 0.03));
        inputs.controls.fill(1.0);
        let variables = Variables::new(&system, &inputs, vec![Free::control(force)]).expect("free");
        let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
        for output in places {
            problem.constrain(output, if is_bounded { Interval::new(-0.35, 0.35) } else { Interval::FREE });
        }
        let start = problem.start();
        let options = Options { stationarity: 1e-5, ..Options::default() };
        let outcome = interior_point(&mut problem, &start, &options, &mut silent).expect("fits");
        println!(
            "{:?}: {} simulations, {} products: {}",
            outcome.reason, outcome.evaluations, outcome.products, outcome.value
        );
        assert!(outcome.reason.is_converged() && outcome.constraints[0].abs() < 1e-9, "{:?}", outcome.reason);
        let places = outcome.constraints[1..].to_vec();
        (outcome.value, places.iter().fold(0.0, |most: f64, x| most.max(x.abs())))
    };
    let ((free, wide), (bounded, narrow)) = (build(false), build(true));
    assert!(wide > 0.4, "it would go farther: {wide}");
    assert!((0.349..=0.35).contains(&narrow) && bounded > free, "{narrow}: {bounded} {free}");
}

#[test]
fn many_starts_give_what_each_gives_alone() {
    let (system, force) = swing_up(false);
    let inputs = constant(&system, 0.0);
    let starts: Vec<Vec<f64>> =
        (0..6).map(|k| (0..101).map(|i| 10.0 * (0.03 * f64::from(i) + f64::from(k)).sin()).collect()).collect();
    let options = Options { target: Some(1e-10), iterations: 60, ..Options::default() };
    let make = || Ok(problem(&system, force, inputs.clone()));
    let solve = |problem: &mut MotionProblem, start: &[f64]| interior_point(problem, start, &options, &mut silent);
    let all = multi_start(&starts, make, solve);
    for (start, outcome) in starts.iter().zip(&all) {
        let alone = solve(&mut make().expect("a problem"), start).expect("fits");
        let together = outcome.as_ref().expect("fits");
        assert_eq!((&alone.x, alone.evaluations, alone.reason), (&together.x, together.evaluations, together.reason));
    }
    let best = lowest(&all, 1e-9).expect("one of them");
    assert!(best.value <= 1e-10, "{:?}", all.iter().flatten().map(|outcome| outcome.value).collect::<Vec<_>>());
    let table = best.history_csv();
    assert_eq!(table.lines().count(), 1 + best.history.len());
    assert!(table.starts_with("iteration,simulations,value"));
    // One that cannot be started does not stop the others.
    let mixed = multi_start(&[vec![0.0; 3], starts[0].clone()], make, solve);
    assert!(mixed[0].is_err() && mixed[1].is_ok());
    let none = multi_start(&starts[..1], || Err::<MotionProblem, _>(Error::EmptyScene), solve);
    assert_eq!(none[0].as_ref().err(), Some(&Error::EmptyScene));
}

#[test]
fn a_problem_is_reached_by_way_of_easier_ones() {
    let (system, force) = push(false);
    let mut problem = problem(&system, force, Inputs::at_rest(&system, Grid::uniform(20, 0.1)));
    let start = problem.start();
    let mut times = Vec::new();
    let mut set = |problem: &mut MotionProblem, s: f64| {
        times.push(2.0 - s);
        problem.change(|inputs| inputs.grid.steps.fill((2.0 - s) / 20.0))
    };
    let outcome = homotopy(&mut problem, &start, &Options::default(), &mut set, &mut silent).expect("fits");
    assert!(outcome.reason.is_converged(), "{:?}", outcome.reason);
    assert!(times.len() > 3 && times[0] == 2.0 && times[times.len() - 1] == 1.0, "{times:?}");
    // ∫F² dt = 12 m² s²/T³ = 48 of a force that falls linearly, but for the error of 20 steps.
    let direct = interior_point(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
    assert!(
        (outcome.value - direct.value).abs() < 1e-8 && (direct.value - 48.0).abs() < 0.01 * 48.0,
        "{} {}",
        outcome.value,
        direct.value
    );
    // Where there is no way it says how far it came.
    let mut wall = |problem: &mut MotionProblem, s: f64| {
        let most = if s > 0.5 { 1.0 } else { 100.0 };
        problem.change(|inputs| inputs.controls.fill(most))?;
        if s > 0.5 { Err(Error::TimeStep { step: 1, length: 0.0 }) } else { Ok(()) }
    };
    let outcome = homotopy(&mut problem, &start, &Options::default(), &mut wall, &mut silent).expect("keeps what it found");
    assert!(outcome.reason == Reason::NoWay && outcome.value > 0.0, "{outcome:?}");
    assert_says(&outcome.first_failure.expect("a wall"), &["step 1"]);
    let error = problem.change(|inputs| inputs.grid.steps.truncate(3)).expect_err("another number of steps");
    assert_says(&error, &["4", "21"]);
    let shorter = |inputs: &mut Inputs| *inputs = Inputs::at_rest(&system, Grid::uniform(3, 0.1));
    assert_says(&problem.change(shorter).expect_err("another number of nodes"), &["nodes of the inputs", "21", "4"]);
}

/// A spring between the ground and a body, with everything free that can be.
fn everything_free() -> (System, Inputs, Vec<Free>) {
    let mut scene = Scene::new();
    let stiffness = scene.design("stiffness", 20.0);
    let (push, pull) = (scene.control("push"), scene.control("pull"));
    let body = scene.body("body", 1.5, 0.2, [0.5, 0.2, 0.1]);
    scene.spring_damper("spring", Body::GROUND.at(0.0, 0.0), body.at(0.1, 0.1), stiffness, 0.3, 0.4);
    scene.actuator("pusher", Body::GROUND.at(0.0, 0.0), 0.0, body.at(0.0, 0.1), push);
    scene.actuator("puller", Body::GROUND.at(0.0, 0.0), 1.2, body.at(0.0, 0.0), pull);
    let spare = scene.control("spare");
    scene.actuator("third", Body::GROUND.at(0.0, 0.0), 0.4, body.at(0.0, 0.0), spare);
    scene.cost("end", Angle, Sum::Terminal, [body.coordinates[0]], [], [], [0.2.into()]);
    scene.cost("effort", Effort, Sum::Integral, [], [], [push], [0.3.into()]);
    let system = scene.compile().expect("a system");
    let mut inputs = Inputs::at_rest(&system, Grid::new(0.1, vec![0.1, 0.05, 0.2, 0.1, 0.15, 0.1, 0.1]));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = (1.3 * i as f64).sin());
    let free = vec![
        Free::control(push).scaled(2.5),
        Free::new(Quantity::LinearControl(pull, 4)),
        Free::new(Quantity::PiecewiseControl(spare, 3)).scaled(0.5),
        Free::design(stiffness).logarithmic().within(1.0, 1000.0).scaled(3.0),
        Free::new(Quantity::Coordinate(body.coordinates[1])),
        Free::new(Quantity::Rate(body.coordinates[2])).scaled(0.1),
        Free::duration(),
    ];
    (system, inputs, free)
}

#[test]
fn the_chain_rule_of_what_is_free_is_exact() {
    let (system, inputs, mut free) = everything_free();
    let variables = Variables::new(&system, &inputs, free.clone()).expect("free");
    assert_eq!(variables.len(), 8 + 4 + 3 + 4);
    let mut x = variables.of(&inputs);
    // Controls on coarser knots are not what they were.
    x.iter_mut().enumerate().for_each(|(i, x)| *x += 0.05 * (i as f64).cos());
    let mut at = inputs.clone();
    variables.apply(&x, &mut at).expect("fits");
    let back = variables.of(&at);
    let knots = 8..15;
    assert!(
        x.iter().zip(&back).enumerate().all(|(i, (x, y))| knots.contains(&i) || (x - y).abs() < 1e-14),
        "{x:?} {back:?}"
    );
    let mut solver = Solver::new(&system, Settings::default());
    let mut value = |x: &[f64]| {
        let mut at = inputs.clone();
        variables.apply(x, &mut at).expect("fits");
        solver.simulate(&at).expect("a motion");
        (solver.cost().expect("a cost"), solver.gradient().expect("a gradient").clone())
    };
    let mut gradient = vec![0.0; x.len()];
    variables.pull_back(&x, &value(&x).1, &mut gradient);
    for i in 0..x.len() {
        // Ridders' extrapolation of central differences.
        let mut difference = |step: f64| {
            let mut moved = x.clone();
            moved[i] = x[i] + step;
            let above = value(&moved).0;
            moved[i] = x[i] - step;
            (above - value(&moved).0) / (2.0 * step)
        };
        let (coarse, fine) = (difference(2e-3), difference(1e-3));
        let expected = fine + (fine - coarse) / 3.0;
        assert!((gradient[i] - expected).abs() < 1e-9, "{}: {} {expected}", variables.name(i), gradient[i]);
    }
    // The second derivatives along a direction, by differences of gradients.
    let direction: Vec<f64> = (0..x.len()).map(|i| (1.7 * i as f64).sin()).collect();
    let mut problem =
        MotionProblem::new(&system, Settings::default(), inputs.clone(), variables.clone()).expect("a problem");
    let mut gradient_at = |step: f64| {
        let moved: Vec<f64> = x.iter().zip(&direction).map(|(x, d)| x + step * d).collect();
        problem.evaluate(&moved, &mut []).expect("a motion");
        let mut gradient = vec![0.0; x.len()];
        problem.gradient(1.0, &[], &mut gradient).expect("a gradient");
        gradient
    };
    let [far, near] = [2e-3, 1e-3].map(|step| {
        let (above, below) = (gradient_at(step), gradient_at(-step));
        above.iter().zip(below).map(|(a, b)| (a - b) / (2.0 * step)).collect::<Vec<f64>>()
    });
    let mut product = vec![0.0; x.len()];
    gradient_at(0.0);
    problem.product(&direction, &mut product).expect("a product");
    for i in 0..x.len() {
        let expected = near[i] + (near[i] - far[i]) / 3.0;
        assert!((product[i] - expected).abs() < 1e-8, "{}: {} {expected}", variables.name(i), product[i]);
    }
    // With splines and single step lengths likewise.
    let Quantity::LinearControl(pull, _) = free[1].quantity else { panic!("it is linear") };
    free[1] = Free::new(Quantity::SplineControl(pull, 5));
    free.pop();
    free.extend([2, 5].map(|node| Free::new(Quantity::StepLength(node)).scaled(0.1)));
    let other = Variables::new(&system, &inputs, free).expect("free");
    let mut x = other.of(&inputs);
    x.iter_mut().enumerate().for_each(|(i, x)| *x += 0.05 * (i as f64).cos());
    let direction: Vec<f64> = (0..x.len()).map(|i| (1.7 * i as f64).sin()).collect();
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs.clone(), other.clone()).expect("a problem");
    let mut along = |step: f64| {
        let moved: Vec<f64> = x.iter().zip(&direction).map(|(x, d)| x + step * d).collect();
        let value = problem.evaluate(&moved, &mut []).expect("a motion");
        let (mut gradient, mut product) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        problem.gradient(1.0, &[], &mut gradient).expect("a gradient");
        problem.product(&direction, &mut product).expect("a product");
        let dot = |y: &[f64]| y.iter().zip(&direction).map(|(y, d)| y * d).sum::<f64>();
        [value, dot(&gradient), dot(&product)]
    };
    let [_, slope, curvature] = along(0.0);
    let [far, near] = [2e-3, 1e-3].map(|step| {
        let (above, below) = (along(step), along(-step));
        [0, 1].map(|k| (above[k] - below[k]) / (2.0 * step))
    });
    for (k, ours) in [slope, curvature].into_iter().enumerate() {
        let expected = near[k] + (near[k] - far[k]) / 3.0;
        assert!((ours - expected).abs() < 1e-8 * expected.abs().max(1.0), "{k}: {ours} {expected}");
    }
    assert_eq!([other.name(8), other.name(x.len() - 1)], ["pull [0]", "length of step 5"]);
    let named: Vec<&str> = [0, 8, 12, 15, 16, 17, 18].map(|i| variables.name(i)).to_vec();
    assert_eq!(
        named,
        ["push [0]", "pull [0]", "spare [0]", "stiffness", "initial body.y", "initial rate of body.φ", "duration"]
    );
    assert_eq!(variables.bounds()[15], Interval::new((1.0f64 / 3.0).ln(), (1000.0f64 / 3.0).ln()));
}

#[test]
fn a_trial_without_a_value_is_no_abort() {
    // √x − x/2, which ends at 0 on the left.
    fn edge(x: &[f64], _: &mut [f64], g: &mut [f64]) -> f64 {
        g[0] = 1.0 - 0.5 / x[0].sqrt();
        x[0] - x[0].sqrt()
    }
    let mut problem = Given::new(edge, vec![Interval::FREE], vec![]);
    let outcome =
        lbfgs(&mut problem, &[4.0], &Options { first_step: Some(100.0), ..Options::default() }, &mut silent).expect("fits");
    assert!(outcome.failures > 0 && outcome.first_failure.is_some());
    assert!((outcome.x[0] - 0.25).abs() < 1e-7 && outcome.reason.is_converged(), "{outcome:?}");
    let outcome = lbfgs(&mut problem, &[-1.0], &Options::default(), &mut silent).expect("no value at the start");
    assert_says(&outcome.first_failure.expect("why"), &["cost", "NaN"]);
}

#[test]
fn what_cannot_be_done_is_said() {
    let any = || Options::default();
    let flat: Function = |_, c, g| {
        c.fill(1.0);
        g.fill(0.0);
        3.0
    };
    let outcome =
        lbfgs(&mut Given::new(flat, vec![Interval::FREE; 3], vec![]), &[0.0; 3], &any(), &mut silent).expect("fits");
    assert_eq!((outcome.reason, outcome.history.len(), outcome.evaluations <= 3), (Reason::Stationary, 1, true));
    let outcome = lbfgs(&mut Given::new(flat, vec![], vec![]), &[], &any(), &mut silent).expect("nothing to do");
    assert_eq!(outcome.reason, Reason::Stationary);
    // c = x, which must be 1 and 2.
    let contradiction: Function = |x, c, g| {
        (c[0], c[1]) = (x[0] - 1.0, x[0] - 2.0);
        g.copy_from_slice(&[2.0 * x[0], 1.0, 1.0]);
        x[0] * x[0]
    };
    let mut problem = Given::new(contradiction, vec![Interval::FREE], vec![Interval::ZERO; 2]);
    let outcome = augmented_lagrangian(&mut problem, &[0.0], &any(), &mut silent).expect("fits");
    assert_eq!(outcome.reason, Reason::Infeasible);
    assert!((outcome.x[0] - 1.5).abs() < 1e-3 && (outcome.violation - 0.5).abs() < 1e-3, "between both: {outcome:?}");
    let outcome = interior_point(&mut problem, &[0.0], &any(), &mut silent).expect("fits");
    assert_eq!(outcome.reason, Reason::Infeasible);
    assert!(outcome.violation > 0.4, "{outcome:?}");
    // Bounds that are too narrow: a cart that cannot be pushed so far.
    let (system, force) = push(false);
    let inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.05));
    let variables = Variables::new(&system, &inputs, vec![Free::control(force).within(-3.0, 3.0)]).expect("free");
    let mut narrow = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    let outcome = interior_point(&mut narrow, &[1.0; 21], &any(), &mut silent).expect("no error but an answer");
    println!("{:?} after {} simulations: {}", outcome.reason, outcome.evaluations, outcome.violation);
    assert_eq!(outcome.reason, Reason::Infeasible);
    assert!(outcome.violation > 0.1 && outcome.x.iter().all(|u| u.abs() < 3.0) && outcome.evaluations < 400);
    let outcome = interior_point(&mut Given::new(flat, vec![], vec![]), &[], &any(), &mut silent).expect("nothing to do");
    assert_eq!(outcome.reason, Reason::Stationary);
    let outcome = interior_point(&mut Given::new(flat, vec![Interval::FREE; 3], vec![]), &[0.0; 3], &any(), &mut silent)
        .expect("fits");
    assert_eq!((outcome.reason, outcome.history.len()), (Reason::Stationary, 1));
    let error = |problem: &mut Given, start: &[f64]| lbfgs(problem, start, &any(), &mut silent).expect_err("wrong");
    let free = || Given::new(flat, vec![Interval::FREE; 2], vec![]);
    assert_says(&error(&mut free(), &[0.0]), &["start", "expected 2", "found 1"]);
    assert_says(&error(&mut free(), &[0.0, f64::NAN]), &["`x1`", "NaN"]);
    assert_says(&error(&mut Given::new(flat, vec![Interval::new(1.0, 0.0)], vec![]), &[0.0]), &["bound", "`x0`", "0"]);
    assert_says(&error(&mut problem, &[0.0]), &["constraints", "augmented_lagrangian"]);
    let mut seen = 0;
    let mut twice = |_: &Iterate, _: &[f64]| {
        seen += 1;
        if seen < 3 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let mut valley = Given::new(rosenbrock, vec![Interval::FREE; 4], vec![]);
    let outcome = lbfgs(&mut valley, &[0.0; 4], &any(), &mut twice).expect("fits");
    assert_eq!((outcome.reason, outcome.history.len()), (Reason::Interrupted, 3));
}

#[test]
fn pieces_begin_at_their_nodes_however_late_or_long_a_motion_is() {
    let (system, _, free) = everything_free();
    let Quantity::PiecewiseControl(spare, _) = free[2].quantity else { panic!("it is piecewise") };
    for (start, steps, dt) in [(0.0, 1000, 0.01), (1.7e9, 1000, 0.01), (0.0, 100_000, 0.001), (-3.0, 1_000_000, 1e-4)] {
        let inputs = Inputs::at_rest(&system, Grid { start, ..Grid::uniform(steps, dt) });
        let free = vec![Free::new(Quantity::PiecewiseControl(spare, 10)), Free::duration()];
        let variables = Variables::new(&system, &inputs, free).expect("free");
        let mut x = variables.of(&inputs);
        assert!((x[10] / (steps as f64 * dt) - 1.0).abs() < 1e-15, "{}", x[10]);
        x[..10].iter_mut().enumerate().for_each(|(k, x)| *x = k as f64);
        let mut at = inputs.clone();
        variables.apply(&x, &mut at).expect("fits");
        let wrong = (0..=steps).find(|&node| at.controls[(spare.index(), node)] != (node * 10 / steps).min(9) as f64);
        assert_eq!(wrong, None, "{steps} steps from {start} s on");
        assert!(at.grid.steps.iter().all(|step| (step / dt - 1.0).abs() < 1e-15), "{}", at.grid.steps[0]);
    }
}

#[test]
fn wrong_variables_are_named() {
    let (system, inputs, free) = everything_free();
    let wrong = |change: &dyn Fn(&mut Vec<Free>)| {
        let mut free = free.clone();
        change(&mut free);
        Variables::new(&system, &inputs, free).expect_err("wrong")
    };
    assert_says(&wrong(&|free| free.push(free[0].clone())), &["times", "push", "is 2", "must be 1"]);
    assert_says(&wrong(&|free| free[3].bounds = Interval::new(-1.0, 2.0)), &["stiffness", "logarithm"]);
    for most in [-1.0, 0.0] {
        let nowhere = Interval::new(f64::NEG_INFINITY, most);
        assert_says(&wrong(&|free| free[3].bounds = nowhere), &["upper bound", "stiffness", "logarithm"]);
    }
    assert_says(&wrong(&|free| free[3].scale = 0.0), &["scale", "stiffness"]);
    assert_says(&wrong(&|free| free[6].bounds = Interval::new(2.0, 1.0)), &["duration", "bound"]);
    let Quantity::LinearControl(pull, _) = free[1].quantity else { panic!("it is linear") };
    assert_says(&wrong(&|free| free[1].quantity = Quantity::LinearControl(pull, 1)), &["knots", "pull"]);
    assert_says(&wrong(&|free| free[1].quantity = Quantity::PiecewiseControl(pull, 99)), &["knots", "pull"]);
    assert_says(&wrong(&|free| free[4] = Free::new(free[4].quantity.clone()).logarithmic().scaled(-1.0)), &["scale"]);
    let Quantity::LinearControl(pull, _) = free[1].quantity else { panic!("it is linear") };
    assert_says(&wrong(&|free| free[1].quantity = Quantity::SplineControl(pull, 3)), &["knots", "4 for a spline"]);
    assert_says(&wrong(&|free| free.push(Free::new(Quantity::StepLength(1)))), &["step lengths", "duration"]);
    assert_says(&wrong(&|free| free[6] = Free::new(Quantity::StepLength(0))), &["step 0"]);
    assert_says(&wrong(&|free| free[6] = Free::new(Quantity::StepLength(8))), &["step 8"]);
    assert_says(&wrong(&|free| free[0] = free[0].clone().logarithmic()), &["logarithm of `push [0]`", "-inf"]);
    let standing = Inputs { grid: Grid::new(0.0, vec![0.1, -0.1]), ..Inputs::at_rest(&system, Grid::uniform(2, 0.1)) };
    let error = Variables::new(&system, &standing, vec![Free::duration()]).expect_err("no duration");
    assert_says(&error, &["duration", "not zero"]);
}

#[test]
fn a_start_that_is_assembled_may_be_free() {
    let mut scene = Scene::new();
    let bob = scene.body("bob", 1.0, 0.1, [0.3, -0.4, 0.0]);
    scene.gravity(0.0, -9.81);
    scene.distance("rod", Body::GROUND.at(0.0, 0.0), bob.at(0.0, 0.0), 0.5);
    let [x, _, _] = bob.coordinates;
    let reach = scene.output("reach");
    scene.term(reach, "reach", Angle, Sum::Terminal, [x], [], [], [0.04.into()]);
    let system = scene.compile().expect("a system");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.01));
    inputs.start = Start::assembled(&system).hold(&[x]);
    let free = vec![Free::new(Quantity::Coordinate(x)).within(-0.45, 0.45)];
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    let start = problem.start();
    let options = Options { target: Some(1e-24), stationarity: 0.0, ..Options::default() };
    let outcome = interior_point(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
    assert!(outcome.reason.is_converged() && outcome.violation < 1e-9, "{:?}", outcome.reason);
    let fit = levenberg_marquardt(&mut problem, &start, &options, &mut silent).expect("fits");
    assert_eq!(fit.outcome.reason, Reason::Target, "{:?}", fit.outcome);
    let motion = problem.solver.trajectory();
    assert!((motion.q[(0, 40)] - 0.04).abs() < 1e-11);
    let (x0, y0) = (motion.q[(0, 0)], motion.q[(1, 0)]);
    assert!((x0 * x0 + y0 * y0 - 0.25).abs() < 1e-12, "it starts on the circle");
}

/// A pendulum with friction and a spring, whose angle is read off every tenth of a second for 2 s.
fn pendulum(readings: &[f64]) -> (System, [Free; 3]) {
    let mut scene = Scene::new();
    let (parameters, angle) = identified::hanging_rod(&mut scene, [0.1, 1.0]);
    for (k, reading) in readings.iter().enumerate() {
        let name = format!("reading {k}");
        let output = scene.output(&name);
        scene.term(output, &name, Angle, Sum::Node(5 * (k + 1)), [angle], [], [], [(*reading).into()]);
    }
    let free = parameters.map(|design| Free::design(design).logarithmic());
    (scene.compile().expect("a system"), free)
}

#[test]
fn parameters_are_found_within_their_standard_errors() {
    const TRUTH: [f64; 3] = [1.3, 0.25, 2.0];
    const NOISE: f64 = 0.01;
    let inputs = |system: &System, trial: usize| {
        let mut inputs = Inputs::at_rest(system, Grid::uniform(100, 0.02));
        let scale = 1.0 + trial as f64;
        inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = scale * (0.02 * scale * i as f64 + 1.0).sin());
        inputs
    };
    let angles = |trial: usize| -> Vec<f64> {
        let (system, _) = pendulum(&[]);
        let mut inputs = inputs(&system, trial);
        inputs.design.copy_from_slice(&TRUTH);
        let mut solver = Solver::new(&system, Settings::default());
        let motion = solver.simulate(&inputs).expect("a motion");
        (1..=20).map(|k| motion.q[(2, 5 * k)]).collect()
    };
    let truth = [angles(0), angles(1)];
    // Nearly normal: sums of 12 uniform numbers of a linear congruential generator.
    let mut state = 12345u64;
    let mut uniform = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut normal = move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
    let (mut within, mut all) = (0, 0);
    for _ in 0..30 {
        let systems = truth.clone().map(|angles| {
            let noisy: Vec<f64> = angles.iter().map(|angle| angle + NOISE * normal()).collect();
            pendulum(&noisy)
        });
        let motions = systems.iter().enumerate().map(|(trial, (system, free))| {
            let inputs = inputs(system, trial);
            let variables = Variables::new(system, &inputs, free.to_vec()).expect("free");
            MotionProblem::new(system, Settings::default(), inputs, variables).expect("a motion")
        });
        let mut trials = Trials::new(motions.collect()).expect("two trials");
        let start = trials.motions()[0].start();
        shooting::assert_rows(&mut trials, &start);
        let fit = levenberg_marquardt(&mut trials, &start, &Options::default(), &mut silent).expect("fits");
        assert!(fit.outcome.reason.is_converged() && fit.outcome.evaluations < 30, "{:?}", fit.outcome.reason);
        // Of logarithms: relative errors.
        let errors = fit.standard_errors().expect("determined");
        for ((x, truth), error) in fit.outcome.x.iter().zip(TRUTH).zip(errors) {
            all += 1;
            within += usize::from((x - truth.ln()).abs() <= 2.0 * error);
        }
        // The size of the noise is found, too: 40 readings less 3 parameters.
        let noise = (2.0 * fit.outcome.value / 37.0).sqrt();
        assert!((0.6 * NOISE..1.5 * NOISE).contains(&noise), "{noise}");
    }
    println!("{within} of {all} parameters within two standard errors");
    assert!((82..=90).contains(&within), "{within} of {all}");
    let error = Trials::new(Vec::new()).expect_err("no trials");
    assert_says(&error, &["trials", "at least 1"]);

    let (system, free) = pendulum(&[]);
    let with = |free: Vec<Free>| {
        let inputs = inputs(&system, 0);
        let variables = Variables::new(&system, &inputs, free).expect("free");
        MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a motion")
    };
    let wrong = |free_of_second: &[Free]| {
        Trials::new(vec![with(free.to_vec()), with(free_of_second.to_vec())]).expect_err("other variables")
    };
    let [first, second, third] = free.clone();
    assert_says(&wrong(&free[..2]), &["variables of a trial", "3", "2"]);
    assert_says(&wrong(&[second.clone(), first.clone(), third.clone()]), &["variable 0 of trial 1", "same quantity"]);
    assert_says(&wrong(&[first.clone(), second.clone(), third.clone().scaled(7.0)]), &["variable 2 of trial 1", "7"]);
    assert_says(&wrong(&[first, second, Free { logarithm: false, ..third }]), &["variable 2 of trial 1", "scale and form"]);
}

#[test]
fn a_cost_at_a_node_is_the_terminal_cost_of_a_shorter_motion() {
    let build = |sum: Sum| {
        let mut cart = CartPendulum::with_links(2).mechanism();
        let b = [cart.scene.design("aim", 0.3).into()];
        cart.scene.cost("angle", Angle, sum, [cart.links[1].coordinates[2]], [], [], b);
        cart.scene.cost("effort", Effort, sum, [], [], [cart.force], [0.01.into()]);
        cart.scene.compile().expect("a system")
    };
    let terminal = build(Sum::Terminal);
    for (node, at_node) in [0, 7].map(|node| (node, build(Sum::Node(node)))) {
        for (scheme, composed) in [(Scheme::TRAPEZOIDAL, false), (Scheme::ESDIRK4, false), (Scheme::TRAPEZOIDAL, true)] {
            let settings = Settings { scheme, ..Settings::default() };
            let steps = (0..12).map(|i| 0.03 + 0.002 * f64::from(i)).collect();
            let mut inputs = Inputs::at_rest(&at_node, Grid::new(0.0, steps));
            if composed {
                inputs.grid.stages = 3;
            }
            inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 5.0 * (i as f64).cos());
            let grid = Grid { steps: inputs.grid.steps[..node].to_vec(), ..inputs.grid.clone() };
            let mut short = Inputs::at_rest(&terminal, grid);
            short.controls.copy_from(&inputs.controls.columns(0, node + 1));
            let whole = gradient(&at_node, &inputs, settings).expect("a gradient");
            let part = gradient(&terminal, &short, settings).expect("a gradient");
            let scale = part.controls.amax();
            assert!((whole.value - part.value).abs() <= 1e-13 * part.value.abs());
            assert!((whole.controls.columns(0, node + 1) - &part.controls).amax() <= 1e-12 * scale, "{scheme:?}");
            assert_eq!(whole.controls.columns(node + 1, 12 - node).amax(), 0.0);
            assert!((whole.start.q() - part.start.q()).amax() <= 1e-12 * part.start.q().amax(), "{scheme:?}");
            assert!((whole.start.rate() - part.start.rate()).amax() <= 1e-12);
            assert!((&whole.design - &part.design).amax() <= 1e-12 && whole.steps[node..].iter().all(|step| *step == 0.0));
            // With a checkpoint now and then it is the same to the last bit.
            let mut checked = 0;
            for bytes in (5_000..100_000).step_by(5_000) {
                // Too little for anything is an error.
                if let Ok(of_long) = LongSolver::new(&at_node, settings, bytes).gradient(&inputs) {
                    assert_eq!((of_long.value, &of_long.controls), (whole.value, &whole.controls));
                    checked += 1;
                }
            }
            assert!(checked > 3, "{checked}");
        }
    }
    let at_node = build(Sum::Node(7));
    let short = Inputs::at_rest(&at_node, Grid::uniform(6, 0.01));
    let error = gradient(&at_node, &short, Settings::default()).expect_err("no such node");
    assert_says(&error, &["`Sum::Node`", "7", "number of steps"]);
}

#[test]
fn programs_of_the_guide_are_short() {
    // Without blank lines, comments and what is hidden.
    let is_counted = |line: &&str| !(line.trim().is_empty() || line.starts_with("# ") || line.trim().starts_with("//"));
    let guide = include_str!("../../docs/optimisation.md");
    let programs: Vec<usize> = (guide.split("```rust\n").skip(1))
        .filter_map(|rest| rest.split("```").next())
        .map(|program| program.lines().filter(is_counted).count())
        .collect();
    println!("{programs:?} lines");
    assert!(programs.len() >= 3 && programs.iter().all(|lines| *lines <= 25), "{programs:?}");
}
