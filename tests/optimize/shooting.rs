//! Multiple shooting: the same optimum as one motion, exact derivatives, and what it refuses.

use super::common::assert_says;
use super::{Angle, Effort, Speed};
use hamiltonian_adjoint::optimize::{
    Free, Interval, MotionProblem, MultipleShooting, Options, Problem, Quantity, Variables, interior_point, silent,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{
    Composition, Constraint, Control, Coordinate, Cost, CostPoint, Design, EndState, Error, Grid, Inputs, Output, Scalar,
    Scene, Scheme, Settings, Solver, Start, Sum, System,
};
use nalgebra::{DMatrix, DVector, SVector};
use std::f64::consts::{FRAC_PI_2, PI};

/// t.
struct Late;
impl Cost<0, 0, 0, 0> for Late {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 0>, _: &SVector<S, 0>) -> S {
        at.t
    }
}

/// p*².
struct Momentum;
impl Cost<1> for Momentum {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _: &SVector<S, 0>) -> S {
        at.p_star[0] * at.p_star[0]
    }
}

/// u̇².
struct Change;
impl Cost<0, 0, 1> for Change {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 1>, _: &SVector<S, 0>) -> S {
        at.u_dot[0] * at.u_dot[0]
    }
}

/// q.
struct Level;
impl Constraint<1, 1> for Level {
    fn phi<S: Scalar>(&self, q: &SVector<S, 1>, _: &SVector<S, 0>, _: S) -> SVector<S, 1> {
        *q
    }
}

/// A cart of 2 kg on a spring that is pushed for 1 m, at rest at the end.
pub fn push() -> (System, Control, Output, Vec<EndState>) {
    let mut scene = Scene::new();
    let cart = scene.body("cart", 2.0, 0.1, [0.0, 0.0, 0.0]);
    let force = scene.control("force");
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
    scene.spring_damper("spring", Body::GROUND.at(-1.0, 0.5), cart.at(0.0, 0.1), 3.0, 1.0, 0.4);
    let (place, speed, energy) = (scene.output("place"), scene.output("speed"), scene.output("energy"));
    scene.term(place, "place", Angle, Sum::Terminal, [cart.coordinates[0]], [], [], [1.0.into()]);
    scene.term(speed, "speed", Speed, Sum::Terminal, [cart.coordinates[0]], [], [], []);
    scene.term(energy, "energy", Effort, Sum::Trapezoidal, [], [], [force], [0.1.into()]);
    scene.cost("effort", Effort, Sum::Integral, [], [], [force], [1.0.into()]);
    let states = cart.coordinates.map(|q| scene.end_state(q)).to_vec();
    (scene.compile().expect("a system"), force, energy, states)
}

#[test]
fn segments_without_constraints_find_what_one_motion_finds() {
    for scheme in Scheme::ALL {
        let (system, force, energy, states) = push();
        let settings = Settings { scheme, ..Settings::default() };
        let inputs = Inputs::at_rest(&system, Grid::new(0.0, (0..30).map(|i| 0.05 + 0.02 * (i as f64).sin()).collect()));
        let free = vec![Free::control(force)];
        let options = Options { stationarity: 1e-9, ..Options::default() };
        let variables = Variables::new(&system, &inputs, free.clone()).expect("free");
        let mut one = MotionProblem::new(&system, settings, inputs.clone(), variables).expect("a problem");
        let start = one.start();
        let mut whole = MultipleShooting::new(&system, settings, inputs, free, &states, 4).expect("a problem");
        assert_eq!((whole.variables(), whole.constraints().len()), (31 + 3 * 6, 9 + 3 * 6));
        // The energy is looked at alone, in both.
        one.constrain(energy, Interval::FREE);
        whole.constrain(energy, Interval::FREE);
        let alone = interior_point(&mut one, &start, &options, &mut silent).expect("fits");
        let start = whole.start();
        let parts = interior_point(&mut whole, &start, &options, &mut silent).expect("fits");
        assert!(alone.reason.is_converged() && parts.reason.is_converged(), "{:?} {:?}", alone.reason, parts.reason);
        assert!((alone.value - parts.value).abs() < 1e-9 * alone.value, "{} {}", alone.value, parts.value);
        assert!((alone.constraints[energy.index()] - parts.constraints[energy.index()]).abs() < 1e-7);
        let difference = (one.inputs_at(&alone.x).controls - whole.inputs_at(&parts.x).controls).amax();
        assert!(difference < 1e-5, "{difference}");
    }
}

#[test]
fn a_swing_up_is_found_from_a_guess_of_the_motion() {
    let (mut cart, mut states) = (CartPendulum::with_links(1).mechanism(), Vec::new());
    let (rail, angle) = (cart.cart.coordinates[0], cart.links[0].coordinates[2]);
    cart.scene.effort("effort", cart.force, 1e-4);
    states.extend([rail, angle].map(|q| cart.scene.end_state(q)));
    let force = cart.force;
    let system = cart.scene.compile().expect("a system");
    let inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.025));
    let free = vec![Free::control(force)];
    let mut problem =
        MultipleShooting::new(&system, Settings::default(), inputs, free.clone(), &states, 5).expect("a problem");
    problem.constrain(states[1].position, Interval::equal(FRAC_PI_2));
    let turn = |node: usize| PI * node as f64 / 40.0;
    problem.guess(|node, q, v| (q[angle.index()], v[angle.index()]) = (turn(node) - FRAC_PI_2, PI)).expect("a guess");
    let start = problem.start();
    assert_eq!(start[41..45], [0.0, 0.0, turn(8) - FRAC_PI_2, PI]);
    assert_eq!(problem.variable_name(43), "link 1.φ at node 8");
    let options = Options { stationarity: 1e-6, ..Options::default() };
    let best = interior_point(&mut problem, &start, &options, &mut silent).expect("fits");
    assert!(best.reason.is_converged() && best.violation <= 1e-9, "{:?}", best.reason);
    // All of the motion is joined: states exactly, what is assembled from them up to the drift of the segment before.
    let motions: Vec<_> = problem.segments().map(|motion| motion.solver.trajectory().clone()).collect();
    for pair in motions.windows(2) {
        let end = pair[0].q.ncols() - 1;
        let [dq, dv] = [pair[0].q.column(end) - pair[1].q.column(0), pair[0].v.column(end) - pair[1].v.column(0)];
        println!("positions to {:.0e}, velocities to {:.0e}", dq.amax(), dv.amax());
        for q in [rail, angle] {
            assert!(dq[q.index()].abs() < 1e-9 && dv[q.index()].abs() < 1e-9);
        }
        assert!(dq.amax() < 3e-3 && dv.amax() < 3e-2);
        assert!((pair[0].times[end] - pair[1].times[0]).abs() < 1e-14);
    }
    // One motion with the same force ends close by, and its own optimum is not far.
    let inputs = problem.inputs_at(&best.x);
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let mut one = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    one.constrain(states[1].position, Interval::equal(FRAC_PI_2));
    let start = one.start();
    let polished = interior_point(&mut one, &start, &options, &mut silent).expect("fits");
    println!("{} in segments, {} as one motion, {} simulations", best.value, polished.value, polished.evaluations);
    assert!(polished.reason.is_converged() && polished.evaluations < 12, "{:?}", polished.reason);
    assert!((polished.value - best.value).abs() < 1e-2 * best.value);
}

#[test]
fn the_start_is_the_point_that_was_evaluated_last() {
    let (system, force, _, states) = push();
    let inputs = Inputs::at_rest(&system, Grid::uniform(12, 0.05));
    let free = vec![Free::control(force).scaled(3.0), Free::duration()];
    let mut problem = MultipleShooting::new(&system, Settings::default(), inputs, free, &states, 3).expect("a problem");
    let x: Vec<f64> = problem.start().iter().enumerate().map(|(i, x)| x + 0.1 * (1.3 * i as f64).sin()).collect();
    problem.evaluate(&x, &mut vec![0.0; problem.constraints().len()]).expect("motions");
    let start = problem.start();
    assert!(start.iter().zip(&x).all(|(found, x)| (found - x).abs() < 1e-15), "{start:?} {x:?}");
}

/// Everything free that may be, cuts at macro steps, with constraints.
fn everything(
    system: &System,
    (settings, grid): (Settings, Grid),
    (force, length): (Control, Design),
    states: &[EndState],
    rail: Coordinate,
) -> MultipleShooting {
    let mut inputs = Inputs::at_rest(system, grid);
    inputs.start = Start::assembled(system);
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 3.0 * (0.9 * i as f64).sin());
    let free = vec![
        Free::new(Quantity::Rate(rail)),
        Free::control(force).scaled(2.0),
        Free::design(length).logarithmic(),
        Free::duration().scaled(0.5).within(0.1, 3.0),
    ];
    let mut problem = MultipleShooting::new(system, settings, inputs, free, states, 3).expect("a problem");
    problem
        .guess(|node, q, v| {
            let [rail, angle] = [states[0], states[1]].map(|state| state.coordinate.index());
            (q[rail], q[angle]) = (0.01 * node as f64, -FRAC_PI_2 + 0.02 * node as f64);
            (v[rail], v[angle]) = (0.3, 0.5);
        })
        .expect("a guess");
    problem
}

/// The rows of the Jacobian are the gradients of single constraints.
pub fn assert_rows(problem: &mut dyn Problem, x: &[f64]) {
    let count = problem.constraints().len();
    problem.evaluate(x, &mut vec![0.0; count]).expect("motions");
    let rows: Vec<usize> = (0..count).rev().filter(|row| row % 3 != 1).collect();
    let mut jacobian = DMatrix::from_element(rows.len(), x.len(), f64::NAN);
    problem.jacobian(&rows, &mut jacobian).expect("a Jacobian");
    for (k, &j) in rows.iter().enumerate() {
        let (mut weights, mut gradient) = (vec![0.0; count], vec![0.0; x.len()]);
        weights[j] = 1.0;
        problem.gradient(0.0, &weights, &mut gradient).expect("a gradient");
        let size = gradient.iter().fold(0.0, |most: f64, g| most.max(g.abs()));
        for (i, g) in gradient.iter().enumerate() {
            assert!((jacobian[(k, i)] - g).abs() <= 1e-13 * size, "row {j}, {i}: {} {g}", jacobian[(k, i)]);
        }
    }
}

#[test]
fn derivatives_of_joined_segments_are_exact() {
    let uneven = || Grid::new(0.0, vec![0.03, 0.05, 0.04, 0.02, 0.06, 0.03, 0.05]);
    let of = |scheme| Settings { scheme, ..Settings::default() };
    // Some cuts are where multipliers begin anew, some are not.
    let anew = Settings { rebase_every: 2, ..Settings::default() };
    for (settings, grid) in [
        (Settings::default(), Grid::composed(7, 0.04, Composition::Suzuki4)),
        (anew, Grid::composed(7, 0.04, Composition::Suzuki4)),
        (anew, uneven()),
        (Settings { drift_bound: 0.0, ..Settings::default() }, uneven()),
        (of(Scheme::TR_BDF2), uneven()),
        (of(Scheme::ESDIRK3), uneven()),
        (Settings { rebase_every: 1, drift_bound: 0.0, ..of(Scheme::ESDIRK4) }, uneven()),
        (of(Scheme::ESDIRK5), uneven()),
    ] {
        println!("{settings:?}");
        assert_exact(settings, grid);
    }
}

/// A pushed cart and a bob that hangs on it, at a distance that is a design variable.
pub fn cart_and_bob(scene: &mut Scene) -> ([Body; 2], Control, Design) {
    let length = scene.design("length", 0.8);
    let cart = scene.body("cart", 1.0, 0.1, [0.0, 0.0, 0.0]);
    let bob = scene.body("bob", 0.5, 0.02, [0.0, -0.8, -FRAC_PI_2]);
    scene.prismatic("rail", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), 0.0);
    scene.revolute("hinge", cart.at(0.0, 0.0), bob.at(-length, 0.0));
    let force = scene.control("force");
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
    ([cart, bob], force, length)
}

/// Gradients, rows of the Jacobian, products and push-forwards beside differences of values and of gradients.
fn assert_exact(settings: Settings, grid: Grid) {
    let nodes = grid.nodes();
    let mut scene = Scene::new();
    let ([cart, bob], force, length) = cart_and_bob(&mut scene);
    let [far, effort] = ["far", "effort"].map(|name| scene.output(name));
    scene.term(far, "place", Angle, Sum::Terminal, [bob.coordinates[0]], [], [], [0.3.into()]);
    scene.term(effort, "push", Effort, Sum::Integral, [], [], [force], [0.2.into()]);
    // Of single nodes: at both ends, at cuts and between them, of motions and of a control's rate.
    let seen = scene.output("seen");
    for node in [0, 2, 3, 4, 7].map(|step| step * grid.stages) {
        let (q, weight) = (bob.coordinates[2], [0.5.into()]);
        scene.term(seen, &format!("angle at {node}"), Angle, Sum::Node(node), [q], [], [], [0.2.into()]);
        scene.cost(&format!("push at {node}"), Effort, Sum::Node(node), [], [], [force], weight);
        scene.cost(&format!("change at {node}"), Change, Sum::Node(node), [], [], [force], []);
    }
    scene.time("time", 1.0);
    scene.cost("change", Change, Sum::Trapezoidal, [], [], [force], []);
    scene.cost("work", Effort, Sum::Rectangle, [], [], [force], [0.1.into()]);
    let (rail, angle) = (cart.coordinates[0], bob.coordinates[2]);
    let states = [rail, angle].map(|q| scene.end_state(q));
    let system = scene.compile().expect("a system");
    let mut problem = everything(&system, (settings, grid), (force, length), &states, rail);
    [far, seen].into_iter().for_each(|output| problem.minimise(output));
    let x: Vec<f64> = problem.start().iter().enumerate().map(|(i, x)| x + 0.01 * (i as f64).cos()).collect();
    let (n, rows) = (problem.variables(), problem.constraints().len());
    assert_eq!((n, rows), (1 + nodes + 1 + 1 + 8, 7 + 8));
    assert_rows(&mut problem, &x);
    let motions = problem.segments().map(|motion| motion.solver.trajectory());
    let found: Vec<f64> = motions.flat_map(|motion| motion.times[1..].to_vec()).collect();
    let times = problem.inputs_at(&x).grid.times();
    assert!(found.len() + 1 == nodes && found.iter().zip(&times[1..]).all(|(found, t)| (found - t).abs() < 1e-14));
    assert_changes(&mut problem, &x);
}

/// Gradients, products and push-forwards beside differences of values and of gradients.
pub fn assert_changes(problem: &mut MultipleShooting, x: &[f64]) {
    let (n, rows) = (problem.variables(), problem.constraints().len());
    let direction: Vec<f64> = (0..n).map(|i| (1.7 * i as f64).sin()).collect();
    let weights: Vec<f64> = (0..rows).map(|j| (2.1 * j as f64).cos()).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut along = |step: f64| {
        let moved: Vec<f64> = x.iter().zip(&direction).map(|(x, d)| x + step * d).collect();
        let mut c = vec![0.0; rows];
        let value = problem.evaluate(&moved, &mut c).expect("motions") + dot(&weights, &c);
        let (mut gradient, mut product, mut change) = (vec![0.0; n], vec![0.0; n], vec![0.0; rows]);
        problem.gradient(1.0, &weights, &mut gradient).expect("a gradient");
        problem.product(&direction, &mut product).expect("a product");
        problem.push_forward(&direction, &mut change).expect("a change");
        let mut gauss_newton = vec![0.0; n];
        problem.gauss_newton_product(&direction, &mut gauss_newton).expect("a product");
        assert!((dot(&gauss_newton, &direction) - dot(&change, &change)).abs() < 1e-11 * dot(&change, &change));
        ([vec![value], c, gradient.clone()].concat(), [vec![dot(&gradient, &direction)], change, product].concat())
    };
    let exact = along(0.0).1;
    let [far, near] = [2e-3, 1e-3].map(|step| {
        let (above, below) = (along(step).0, along(-step).0);
        above.iter().zip(below).map(|(a, b)| (a - b) / (2.0 * step)).collect::<Vec<f64>>()
    });
    for (k, ours) in exact.iter().enumerate() {
        let expected = near[k] + (near[k] - far[k]) / 3.0;
        assert!((ours - expected).abs() < 1e-8 * expected.abs().max(1.0), "{k}: {ours} {expected}");
    }
}

#[test]
fn a_terminal_cost_is_an_output_to_minimise() {
    let build = |ends: bool| {
        let mut scene = Scene::new();
        let cart = scene.body("cart", 2.0, 0.1, [0.0; 3]);
        let force = scene.control("force");
        scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
        scene.effort("effort", force, 1e-3);
        let far = scene.output("far");
        let place = [cart.coordinates[0]];
        match ends {
            true => scene.cost("far", AngleError, Sum::Terminal, place, [], [], [1.5.into()]),
            false => scene.term(far, "far", AngleError, Sum::Terminal, place, [], [], [1.5.into()]),
        }
        let states = cart.coordinates.map(|q| scene.end_state(q));
        (scene.compile().expect("a system"), force, far, states)
    };
    let options = Options { stationarity: 1e-9, ..Options::default() };
    let ((one, own, looked_at, _), (system, force, far, states)) = (build(true), build(false));
    let inputs = Inputs::at_rest(&one, Grid::uniform(12, 0.1));
    let variables = Variables::new(&one, &inputs, vec![Free::control(own)]).expect("variables");
    let mut whole = MotionProblem::new(&one, Settings::default(), inputs.clone(), variables).expect("a problem");
    whole.constrain(looked_at, Interval::FREE);
    let expected = interior_point(&mut whole, &[0.0; 13], &options, &mut silent).expect("an outcome");
    let mut problem =
        MultipleShooting::new(&system, Settings::default(), inputs, vec![Free::control(force)], &states, 4).expect("fits");
    problem.minimise(far);
    let start = problem.start();
    let found = interior_point(&mut problem, &start, &options, &mut silent).expect("an outcome");
    assert!(expected.reason.is_converged() && found.reason.is_converged());
    assert!((found.value - expected.value).abs() < 1e-9 * expected.value, "{} {}", found.value, expected.value);
    for (ours, u) in found.x.iter().zip(&expected.x) {
        assert!((ours - u).abs() < 1e-6 * expected.x[0].abs(), "{ours} {u}");
    }
}

#[test]
fn rates_of_controls_are_those_of_one_motion_at_cuts_too() {
    for sum in [Sum::Plain, Sum::AllNodes, Sum::Rectangle, Sum::Trapezoidal, Sum::Integral] {
        let mut scene = Scene::new();
        let cart = scene.body("cart", 2.0, 0.1, [0.0; 3]);
        let force = scene.control("force");
        scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
        scene.cost("change", Change, sum, [], [], [force], []);
        let states = cart.coordinates.map(|q| scene.end_state(q));
        let system = scene.compile().expect("a system");
        let mut inputs = Inputs::at_rest(&system, Grid::new(0.0, (1..9).map(|i| 0.02 * i as f64).collect()));
        inputs.set_control(force, |t| (7.0 * t).sin());
        let values = [1, 2, 5].map(|segments| {
            let free = vec![Free::control(force)];
            let mut problem =
                MultipleShooting::new(&system, Settings::default(), inputs.clone(), free, &states, segments).expect("fits");
            let (x, mut c) = (problem.start(), vec![0.0; problem.constraints().len()]);
            let (value, mut gradient) = (problem.evaluate(&x, &mut c).expect("motions"), vec![0.0; x.len()]);
            problem.gradient(1.0, &vec![0.0; c.len()], &mut gradient).expect("a gradient");
            (value, gradient[..9].to_vec())
        });
        for (value, gradient) in &values[1..] {
            let largest = values[0].1.iter().fold(0.0, |most: f64, g| most.max(g.abs()));
            let far = gradient.iter().zip(&values[0].1).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
            assert!((value - values[0].0).abs() < 1e-12 * value && far < 1e-12 * largest, "{sum:?}: {value} {far:e}");
        }
    }
}

#[test]
fn sums_and_readings_are_those_of_one_motion() {
    for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK3] {
        let mut scene = Scene::new();
        let cart = scene.body("cart", 2.0, 0.1, [0.0; 3]);
        let [force, rail] = [scene.control("force"), scene.control("another")];
        scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
        let x = cart.coordinates[0];
        let ways = (0..9).map(Sum::Node).chain([Sum::Plain, Sum::AllNodes, Sum::Rectangle, Sum::Trapezoidal, Sum::Integral]);
        for (k, sum) in ways.enumerate() {
            scene.cost(&format!("place {k}"), Angle, sum, [x], [], [], [(0.1 * k as f64).into()]);
            let output = scene.output(&format!("output {k}"));
            scene.term(output, &format!("place seen {k}"), Angle, sum, [x], [], [], [0.3.into()]);
            scene.term(output, &format!("change seen {k}"), Change, sum, [], [], [rail], []);
        }
        let states = cart.coordinates.map(|q| scene.end_state(q));
        let system = scene.compile().expect("a system");
        let mut inputs = Inputs::at_rest(&system, Grid::new(0.3, (1..9).map(|i| 0.02 * i as f64).collect()));
        inputs.set_control(force, |t| 20.0 * (7.0 * t).sin());
        inputs.set_control(rail, |t| (3.0 * t).cos());
        let settings = Settings { scheme, ..Settings::default() };
        let mut one = Solver::new(&system, settings);
        let motion = one.simulate(&inputs).expect("a motion").clone();
        let (cost, outputs) = (one.cost().expect("J"), one.outputs().expect("outputs"));
        for segments in [1, 2, 3, 5, 8] {
            let free = vec![Free::control(force)];
            let mut problem =
                MultipleShooting::new(&system, settings, inputs.clone(), free, &states, segments).expect("fits");
            let at = |node: usize, q: &mut DVector<f64>, v: &mut DVector<f64>| {
                q.copy_from(&motion.q.column(node));
                v.copy_from(&motion.v.column(node));
            };
            problem.guess(at).expect("finite");
            let (x, mut c) = (problem.start(), vec![0.0; problem.constraints().len()]);
            let value = problem.evaluate(&x, &mut c).expect("motions");
            assert!((value - cost).abs() < 1e-13 * cost.abs(), "{segments}: {value} {cost}");
            for (k, found) in c.iter().enumerate() {
                let expected = outputs.get(k).copied().unwrap_or(0.0);
                assert!((found - expected).abs() < 1e-13 * expected.abs().max(1.0), "{segments}, {k}: {found} {expected}");
            }
        }
    }
}

/// A pendulum of 1 m swings for 12 s; its angle is read eight times a second, and its length is guessed a third too long: in one motion the swings of the
/// guess fall out of step with the readings, and no step leads back.
#[test]
fn readings_tell_segments_what_one_motion_does_not_find() {
    const EVERY: usize = 5;
    let angle_at = |t: f64| -FRAC_PI_2 + 1.2 * (2.8 * t).cos();
    let build = |readings: &[f64]| {
        let mut scene = Scene::new();
        scene.gravity(0.0, -9.81);
        let length = scene.design("length", 1.0);
        let bob = scene.body("bob", 1.0, 1e-3, [0.0, -1.0, -FRAC_PI_2]);
        scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), bob.at(-length, 0.0));
        let angle = bob.coordinates[2];
        for (k, reading) in readings.iter().enumerate() {
            let name = format!("reading {k}");
            scene.cost(&name, AngleError, Sum::Node(EVERY * k), [angle], [], [], [(*reading).into()]);
        }
        let states = [scene.end_state(angle)];
        (scene.compile().expect("a system"), length, states)
    };
    let inputs = |system: &System, length: f64| {
        let mut inputs = Inputs::at_rest(system, Grid::uniform(480, 0.025));
        inputs.start = Start::assembled(system);
        let (q, turned) = (inputs.start.q_mut(), angle_at(0.0));
        (q[0], q[1], q[2]) = (length * turned.cos(), length * turned.sin(), turned);
        inputs.design[0] = length;
        inputs
    };
    let (system, ..) = build(&[]);
    let truth = Solver::new(&system, Settings::default()).simulate(&inputs(&system, 1.0)).expect("a motion").clone();
    let readings: Vec<f64> = (0..=96).map(|k| truth.q[(2, EVERY * k)]).collect();
    let (system, length, states) = build(&readings);
    let guess = inputs(&system, 1.3);
    let options = Options { stationarity: 1e-7, iterations: 200, ..Options::default() };
    let free = || vec![Free::design(length).within(0.3, 3.0)];

    let in_one_motion = |inputs: Inputs| {
        let variables = Variables::new(&system, &inputs, free()).expect("variables");
        let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
        let start = problem.start();
        interior_point(&mut problem, &start, &options, &mut silent).expect("an outcome").x[0]
    };
    let stuck = in_one_motion(guess.clone());
    assert!((stuck - 1.0).abs() > 0.05, "{stuck}");

    let mut problem = MultipleShooting::new(&system, Settings::default(), guess, free(), &states, 24).expect("fits");
    let at = |node: usize, q: &mut DVector<f64>, v: &mut DVector<f64>| {
        let k = node / EVERY;
        let turned = readings[k];
        (q[0], q[1], q[2]) = (1.3 * turned.cos(), 1.3 * turned.sin(), turned);
        v[2] = (readings[k + 1] - readings[k - 1]) / (2.0 * EVERY as f64 * 0.025);
    };
    problem.guess(at).expect("finite");
    let start = problem.start();
    let found = interior_point(&mut problem, &start, &options, &mut silent).expect("an outcome");
    // Segments do not drift from their constraints, other than the motion that was read.
    assert!(found.reason.is_converged() && (found.x[0] - 1.0).abs() < 2e-3, "{:?}: {}", found.reason, found.x[0]);
    let length = in_one_motion(problem.inputs_at(&found.x));
    assert!((length - 1.0).abs() < 1e-8, "{length}");
}

#[test]
fn segments_of_a_part_begin_where_macro_steps_of_the_whole_end() {
    let (system, force, _, states) = push();
    // The first macro step lacks its first two stages, the last one its last two.
    let inputs = Inputs::at_rest(&system, Grid::composed(5, 0.1, Composition::Suzuki4).part(2, 23));
    let shooting = |segments| {
        MultipleShooting::new(&system, Settings::default(), inputs.clone(), vec![Free::control(force)], &states, segments)
    };
    for (segments, cuts) in [(1, &[][..]), (2, &[8]), (3, &[3, 8]), (4, &[3, 8, 13])] {
        let problem = shooting(segments).expect("a problem");
        let names: Vec<String> = (0..problem.start().len()).map(|i| problem.variable_name(i)).collect();
        let begin =
            |cut: &usize| names.iter().any(|name| name.starts_with("cart.x at") && name.ends_with(&format!(" {cut}")));
        assert!(cuts.iter().all(begin), "{segments}: {names:?}");
        assert_eq!(names.iter().filter(|name| name.starts_with("cart.x at")).count(), segments - 1);
    }
    assert_says(&shooting(5).expect_err("too many"), &["number of segments is 5", "(macro) steps"]);
}

#[test]
fn what_segments_cannot_do_with_is_named() {
    let build = |add: &dyn Fn(&mut Scene, [Coordinate; 3], Control)| {
        let mut scene = Scene::new();
        let cart = scene.body("cart", 2.0, 0.1, [0.0; 3]);
        let force = scene.control("force");
        scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
        add(&mut scene, cart.coordinates, force);
        let states = cart.coordinates.map(|q| scene.end_state(q));
        (scene.compile().expect("a system"), force, states)
    };
    let wrong = |add: &dyn Fn(&mut Scene, [Coordinate; 3], Control),
                 free: &dyn Fn(Control) -> Free,
                 states: usize,
                 segments: usize| {
        let (system, force, all) = build(add);
        let inputs = Inputs::at_rest(&system, Grid::uniform(8, 0.1));
        MultipleShooting::new(&system, Settings::default(), inputs, vec![free(force)], &all[..states], segments)
            .expect_err("wrong")
    };
    let nothing = |_: &mut Scene, _: [Coordinate; 3], _: Control| {};
    let timed = |scene: &mut Scene, _: [Coordinate; 3], _: Control| {
        scene.cost("late", Late, Sum::Integral, [], [], [], []);
    };
    assert_says(&wrong(&timed, &|_| Free::duration(), 3, 2), &["duration", "time"]);
    // A single segment may.
    let (system, _, states) = build(&timed);
    let inputs = Inputs::at_rest(&system, Grid::uniform(8, 0.1));
    MultipleShooting::new(&system, Settings::default(), inputs, vec![Free::duration()], &states, 1).expect("one motion");
    // Of no constraints either.
    let momentum = |scene: &mut Scene, q: [Coordinate; 3], _: Control| {
        scene.cost("momentum", Momentum, Sum::Integral, [q[0]], [], [], []);
    };
    let (system, force, states) = build(&momentum);
    let inputs = Inputs::at_rest(&system, Grid::uniform(8, 0.1));
    let problem = MultipleShooting::new(&system, Settings::default(), inputs, vec![Free::control(force)], &states, 2);
    problem.expect("p* = M v");
    let held = |scene: &mut Scene, q: [Coordinate; 3], _: Control| {
        scene.constraint("level", Level, [q[1]], []);
        scene.cost("momentum", Momentum, Sum::Integral, [q[0]], [], [], []);
    };
    assert_says(&wrong(&held, &Free::control, 2, 2), &["`momentum`", "σ", "segment"]);
    let single = |_| Free::new(Quantity::StepLength(2));
    assert_says(&wrong(&nothing, &single, 3, 2), &["`length of step 2`", "their sum"]);
    assert_says(&wrong(&nothing, &Free::control, 2, 2), &["states", "2", "degrees of freedom"]);
    for segments in [0, 9] {
        assert_says(&wrong(&nothing, &Free::control, 3, segments), &["segments", &segments.to_string()]);
    }
    let (system, force, states) = build(&nothing);
    let inputs = Inputs::at_rest(&system, Grid::uniform(8, 0.1));
    let mut problem =
        MultipleShooting::new(&system, Settings::default(), inputs, vec![Free::control(force)], &states, 8).expect("fits");
    let error = problem.guess(|_, q, _| q[0] = f64::NAN).expect_err("no number");
    assert!(matches!(error, Error::NotFinite { .. }), "{error}");
}
