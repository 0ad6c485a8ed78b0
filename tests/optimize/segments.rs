//! Segments as parts of a whole: watched and stopped as one motion, named by its nodes, joined from its end to its beginning.

use super::shooting::push;
use hamiltonian_adjoint::optimize::{Free, Interval, MultipleShooting, Options, Problem, Reason, interior_point, silent};
use hamiltonian_adjoint::{
    Control, Cost, CostPoint, EndState, Error, Force, ForcePoint, Grid, Inputs, KineticEnergy, Progress, Scalar, Scene,
    Settings, Solver, Start, Sum, System, Task, Warning,
};
use nalgebra::{DVector, SVector};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

#[test]
fn segments_tell_of_their_progress_as_one_motion() {
    let (system, force, _, states) = push();
    let inputs = Inputs::at_rest(&system, Grid::uniform(30, 0.05));
    let free = vec![Free::control(force)];
    let mut problem = MultipleShooting::new(&system, Settings::default(), inputs, free, &states, 4).expect("fits");
    let told = Arc::new(Mutex::new(Vec::new()));
    let noted = Arc::clone(&told);
    problem.watch(move |progress| {
        noted.lock().expect("nobody panics").push(progress);
        ControlFlow::Continue(())
    });
    let (x, mut c) = (problem.start(), vec![0.0; problem.constraints().len()]);
    problem.evaluate(&x, &mut c).expect("motions");
    problem.gradient(1.0, &vec![1.0; c.len()], &mut vec![0.0; x.len()]).expect("a gradient");
    let told: Vec<Progress> = told.lock().expect("nobody panics").clone();
    for task in [Task::Simulation, Task::Gradient] {
        let done: Vec<usize> = told.iter().filter(|told| told.task == task).map(|told| told.done).collect();
        assert!(done.len() > 20 && done.is_sorted() && done.last() == Some(&31), "{task:?}: {done:?}");
    }
    assert!(told.iter().all(|told| told.of == 31), "{told:?}");
}

#[test]
fn whoever_stops_a_segment_stops_the_method() {
    let (system, force, _, states) = push();
    let inputs = Inputs::at_rest(&system, Grid::uniform(30, 0.05));
    let free = vec![Free::control(force)];
    let mut problem = MultipleShooting::new(&system, Settings::default(), inputs, free, &states, 4).expect("fits");
    let start = problem.start();
    for until in [1, 20, 45, 100, 300, 500] {
        let told = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&told);
        problem.watch(move |_| match counted.fetch_add(1, Ordering::Relaxed) < until {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        });
        match interior_point(&mut problem, &start, &Options { stationarity: 0.0, ..Options::default() }, &mut silent) {
            Ok(outcome) => {
                assert_eq!(outcome.reason, Reason::Interrupted, "{until}");
                assert!(matches!(outcome.first_failure, Some(Error::Interrupted { of: 31, .. })), "{outcome:?}");
            }
            // The start has no value, or no derivatives.
            Err(error) => assert!(matches!(error, Error::Interrupted { of: 31, .. }) && until <= 100, "{error}"),
        }
        let behind = told.load(Ordering::Relaxed) - until;
        assert!((1..=3).contains(&behind), "{until}: {behind}");
    }
}

/// T = ½ v², a force v² + 1/q, a cost ln u.
struct Sled;
impl KineticEnergy<1> for Sled {
    fn kinetic_energy<S: Scalar>(&self, _: &SVector<S, 1>, v: &SVector<S, 1>, _: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}
impl Force<1> for Sled {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([at.v[0] * at.v[0] + at.q[0].recip()])
    }
}
impl Cost<0, 0, 1> for Sled {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 1>, _: &SVector<S, 0>) -> S {
        at.u[0].ln()
    }
}

/// b q.
struct Share;
impl Cost<1, 0, 0, 1> for Share {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        at.q[0] * b[0]
    }
}

const DT: f64 = 0.1;

/// A sled far from 0, of which it is asked that it returns in 40 steps.
fn sled() -> (System, Control, [EndState; 1], Inputs) {
    let mut scene = Scene::new();
    let [x] = scene.coordinates("sled", ["x"]);
    scene.place(x, 1e6);
    let u = scene.control("push");
    scene.kinetic_energy("mass", Sled, [x], []);
    scene.force("wind", Sled, [x], [], []);
    scene.cost("log", Sled, Sum::Trapezoidal, [], [], [u], []);
    let back = scene.output("back");
    for (name, node, share) in [("end", 40, 1.0), ("beginning", 0, -1.0)] {
        scene.term(back, name, Share, Sum::Node(node), [x], [], [], [share.into()]);
    }
    let states = [scene.end_state(x)];
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(40, DT));
    inputs.controls.fill(1.0);
    (system, u, states, inputs)
}

/// The value of the problem in segments where a guess is changed at node 30, and the warnings of the segment that begins there.
fn evaluate(
    settings: Settings,
    segments: usize,
    change: impl Fn(&mut Inputs),
    guess: impl Fn(&mut DVector<f64>, &mut DVector<f64>),
) -> (Result<Vec<f64>, Error>, Vec<Warning>) {
    let (system, u, states, mut inputs) = sled();
    change(&mut inputs);
    let mut problem =
        MultipleShooting::new(&system, settings, inputs, vec![Free::control(u)], &states, segments).expect("fits");
    problem
        .guess(|node, q, v| {
            if node == 30 {
                guess(q, v)
            }
        })
        .expect("finite");
    let (x, mut c) = (problem.start(), vec![0.0; problem.constraints().len()]);
    let value = problem.evaluate(&x, &mut c).map(|_| c);
    let of = problem.segments().nth(30 * segments / 40).expect("a segment");
    (value, of.solver.report().warnings.clone())
}

#[test]
fn what_is_wrong_in_a_segment_is_named_by_the_nodes_and_steps_of_the_whole() {
    let still = Settings { max_halvings: 0, ..Settings::default() };
    for segments in [1, 4, 40] {
        for wrong in [0, 5, 10, 30, 40] {
            let change = |inputs: &mut Inputs| inputs.controls[(0, wrong)] = 0.0;
            let error = evaluate(still, segments, change, |_, _| ()).0.expect_err("no value");
            let Error::Model { node, time, .. } = &error else { panic!("{error}") };
            assert!(*node == wrong && (time - DT * wrong as f64).abs() < 1e-12, "{segments}: {error}");
        }
    }
    for segments in [4, 40] {
        let start = evaluate(still, segments, |_| (), |q, _| q[0] = 0.0).0.expect_err("1/0");
        assert!(matches!(start, Error::Model { node: 30, .. }), "{start}");
        let newton = evaluate(still, segments, |_| (), |_, v| v[0] = 100.0).0.expect_err("it runs away");
        assert!(matches!(newton, Error::Newton { step: 31, .. }), "{newton}");
    }
    let (value, warnings) = evaluate(Settings::default(), 40, |_| (), |_, v| v[0] = 6.0);
    value.expect("values");
    assert!(matches!(warnings[0], Warning::HalvedSteps { step: 31, .. }), "{warnings:?}");
}

#[test]
fn what_is_wrong_in_a_part_of_a_grid_is_named_by_the_nodes_and_steps_of_the_whole() {
    let (system, _, _, mut inputs) = sled();
    (inputs.grid, inputs.controls) = (inputs.grid.part(30, 40), inputs.controls.columns(30, 11).into_owned());
    let simulate = |inputs: &Inputs| {
        let mut solver = Solver::new(&system, Settings { max_halvings: 0, ..Settings::default() });
        solver.simulate(inputs)?;
        solver.cost().and_then(|_| Ok(solver.gradient()?.value)).expect_err("wrong");
        solver.gradient().map(|_| ())
    };
    let wrong = |change: &dyn Fn(&mut Inputs)| {
        let mut inputs = inputs.clone();
        change(&mut inputs);
        simulate(&inputs).expect_err("wrong")
    };
    assert!(matches!(wrong(&|inputs| inputs.controls[(0, 4)] = 0.0), Error::Model { node: 34, .. }));
    assert!(matches!(wrong(&|inputs| inputs.start.rate_mut()[0] = 100.0), Error::Newton { step: 31, .. }));
    assert!(matches!(wrong(&|inputs| inputs.grid.steps[2] = f64::NAN), Error::TimeStep { step: 33, .. }));
    let error = wrong(&|inputs| inputs.controls[(0, 3)] = f64::NAN);
    assert!(matches!(&error, Error::NotFinite { what, .. } if what.ends_with("at node 33")), "{error}");
    let assembled = wrong(&|inputs| {
        inputs.start = Start::assembled(&system);
        inputs.start.q_mut()[0] = 0.0;
    });
    assert!(matches!(assembled, Error::Model { node: 30, .. }), "{assembled}");
}

#[test]
fn an_output_joins_the_end_of_the_last_segment_with_the_beginning_of_the_first() {
    let (system, u, states, inputs) = sled();
    for segments in [1, 4, 40] {
        let free = vec![Free::control(u)];
        let mut problem =
            MultipleShooting::new(&system, Settings::default(), inputs.clone(), free, &states, segments).expect("fits");
        problem.guess(|node, q, _| q[0] = 2.0 + node as f64).expect("finite");
        let (x, mut c) = (problem.start(), vec![0.0; problem.constraints().len()]);
        problem.evaluate(&x, &mut c).expect("motions");
        let motions: Vec<_> = problem.segments().map(|motion| motion.solver.trajectory()).collect();
        let (first, last) = (motions[0], motions[segments - 1]);
        assert_eq!(c[0], last.q[(0, last.last())] - first.q[(0, 0)], "{segments}");
        assert_eq!(problem.constraints()[0], Interval::ZERO);
    }
}
