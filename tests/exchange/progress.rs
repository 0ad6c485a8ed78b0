//! Progress: told some hundred times, in order, and stopped when asked to.

use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Error, Grid, Inputs, LongSolver, Progress, Scheme, Settings, Solver, System, Task, check};
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};

fn cart() -> (System, Inputs) {
    let system = CartPendulum::with_links(1).scene().compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(1000, 0.002));
    (system, inputs)
}

type Told = Arc<Mutex<Vec<Progress>>>;

fn note(told: &Told) -> impl FnMut(Progress) -> ControlFlow<()> + Send + 'static {
    let told = told.clone();
    move |progress| {
        told.lock().expect("nobody panics").push(progress);
        ControlFlow::Continue(())
    }
}

fn of(told: &Told, task: Task) -> Vec<usize> {
    told.lock()
        .expect("nobody panics")
        .iter()
        .filter(|progress| progress.task == task)
        .map(|progress| progress.done)
        .collect()
}

#[test]
fn every_task_is_told_of_in_order_and_to_its_end() {
    let (system, inputs) = cart();
    let told = Told::default();
    let mut solver = Solver::new(&system, Settings::default());
    solver.watch(note(&told));
    for _ in 0..2 {
        told.lock().expect("nobody panics").clear();
        solver.simulate(&inputs).expect("a motion");
        solver.gradient().expect("a gradient");
        for task in [Task::Simulation, Task::Gradient] {
            let done = of(&told, task);
            assert!((80..=120).contains(&done.len()), "{} times", done.len());
            assert!(done.is_sorted() && done.last().is_some_and(|last| *last >= 990), "{done:?}");
        }
        assert_eq!(of(&told, Task::Gradient).last(), Some(&1001));
    }
}

#[test]
fn long_motions_are_told_of_once() {
    let (system, inputs) = cart();
    let told = Told::default();
    let mut solver = LongSolver::new(&system, Settings::default(), 150_000);
    solver.watch(note(&told));
    let ours = solver.gradient(&inputs).expect("a gradient").clone();
    for task in [Task::Simulation, Task::Gradient] {
        let done = of(&told, task);
        assert!(!done.is_empty() && done.is_sorted(), "{task:?}: {done:?}");
    }
    let mut quiet = Solver::new(&system, Settings::default());
    quiet.simulate(&inputs).expect("a motion");
    assert_eq!(quiet.gradient().expect("a gradient"), &ours);
}

#[test]
fn what_is_stopped_keeps_what_was_computed_and_can_go_on() {
    let (system, inputs) = cart();
    let mut solver = Solver::new(&system, Settings::default());
    let mut whole = Solver::new(&system, Settings::default());
    whole.simulate(&inputs).expect("a motion");
    for until in [300, 2000] {
        solver.watch(move |progress| {
            if progress.done >= until || progress.task == Task::Gradient {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        let motion = solver.simulate(&inputs);
        if until == 300 {
            assert!(matches!(motion, Err(Error::Interrupted { done: 300..320, of: 1001 })), "{motion:?}");
            let computed = solver.trajectory().computed;
            assert!((300..330).contains(&computed));
            assert_eq!(solver.trajectory().q.column(computed - 1), whole.trajectory().q.column(computed - 1));
        } else {
            assert!(matches!(solver.gradient(), Err(Error::Interrupted { .. })));
        }
    }
    solver.watch(|_| ControlFlow::Continue(()));
    assert_eq!(solver.gradient().expect("a gradient"), whole.gradient().expect("a gradient"));
}

#[test]
fn what_is_stopped_between_halved_steps_keeps_the_grid_as_far_as_it_is_known() {
    let (system, _) = cart();
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(12, 0.01));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 5.0 * i as f64);
    [3, 11].into_iter().for_each(|step| inputs.grid.steps[step] = 1.0);
    let settings = Settings { max_iterations: 4, ..Settings::default() };
    let mut whole = Solver::new(&system, settings);
    let nodes = whole.simulate(&inputs).expect("a motion").computed;
    let inserted = whole.trajectory().inserted.clone();
    assert!(inserted.contains(&(nodes - 2)), "the last step is halved too: {inserted:?}");
    let stop = |until: usize| {
        move |progress: Progress| {
            if progress.done >= until { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }
    };
    let (mut solver, mut long) = (Solver::new(&system, settings), LongSolver::new(&system, settings, 1_000_000));
    for until in 2..=nodes {
        solver.watch(stop(until));
        let motion = solver.simulate(&inputs).map(|_| ());
        assert!(matches!(motion, Err(Error::Interrupted { done, .. }) if done == until), "{motion:?}");
        let (taken, expected) = (solver.inputs(), whole.inputs());
        assert_eq!(taken.grid.steps[..until - 1], expected.grid.steps[..until - 1]);
        assert_eq!(taken.controls.columns(0, until), expected.controls.columns(0, until));
        let ahead = taken.grid.steps[until - 1..].iter().sum::<f64>();
        assert!((ahead - expected.grid.steps[until - 1..].iter().sum::<f64>()).abs() < 1e-14, "{until}: {:?}", taken.grid);
        assert_eq!(taken.grid.nodes() - solver.trajectory().inserted.len(), inputs.grid.nodes());
        long.watch(stop(until));
        assert!(matches!(long.gradient(&inputs), Err(Error::Interrupted { .. })));
    }
    solver.watch(|_| ControlFlow::Continue(()));
    long.watch(|_| ControlFlow::Continue(()));
    solver.simulate(&inputs).expect("a motion");
    assert_eq!(solver.inputs(), whole.inputs());
    assert_eq!(long.gradient(&inputs).expect("a gradient"), whole.gradient().expect("a gradient"));
}

#[test]
fn steps_by_tolerance_are_told_of_and_stop_when_asked_to() {
    let (system, mut inputs) = cart();
    inputs.controls.fill(10.0);
    let told = Told::default();
    let mut solver = Solver::new(&system, Settings { scheme: Scheme::ESDIRK3, ..Settings::default() });
    solver.watch(note(&told));
    let adapted = solver.adapt(&inputs, 1e-9).expect("a grid");
    let nodes = adapted.grid.nodes();
    let last = told.lock().expect("nobody panics").last().copied();
    assert_eq!(last.map(|last| (last.done, last.of)), Some((nodes, nodes)));
    let done = of(&told, Task::Simulation);
    assert!(done.len() >= 20 && done.is_sorted(), "{done:?}");
    solver.watch(|progress| if progress.done > 40 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) });
    let stopped = solver.adapt(&inputs, 1e-9);
    assert!(matches!(stopped, Err(Error::Interrupted { done: 41..100, .. })), "{stopped:?}");
    solver.watch(|_| ControlFlow::Continue(()));
    assert_eq!(solver.adapt(&inputs, 1e-9).expect("a grid"), adapted);
}

#[test]
fn checks_and_estimates_stop_when_asked_to() {
    let (system, mut inputs) = cart();
    inputs.controls.fill(10.0);
    // The number of calls, of which the last one stops.
    let stop = |after: usize| {
        let calls = Arc::new(Mutex::new(0));
        let counted = calls.clone();
        let stop = move |_: Progress| {
            let mut calls = counted.lock().expect("nobody panics");
            *calls += 1;
            if *calls > after { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        (calls, stop)
    };
    let (calls, never) = stop(usize::MAX);
    check::gradient(&system, &inputs, Settings::default()).watch(never).run().expect("a report").assert_passed();
    let all = *calls.lock().expect("nobody panics");
    assert!(all > 2000, "{all}");
    for part in 0..8 {
        let (calls, stop) = stop(part * all / 8);
        let check = check::gradient(&system, &inputs, Settings::default()).watch(stop);
        let stopped = check.run();
        assert!(matches!(stopped, Err(Error::Interrupted { .. })), "{part}: {stopped:?}");
        assert_eq!(*calls.lock().expect("nobody panics"), 1 + part * all / 8);
    }
    let (_, stops) = stop(500);
    let stopped = check::hessian(&system, &inputs, Settings::default()).watch(stops).run();
    assert!(matches!(stopped, Err(Error::Interrupted { .. })), "{stopped:?}");

    let mut solver = Solver::new(&system, Settings::default());
    let estimate = solver.estimate(&inputs).expect("an estimate");
    assert_eq!(estimate, hamiltonian_adjoint::estimate(&system, &inputs, Settings::default()).expect("an estimate"));
    assert!(estimate.uncertainty.is_some() && solver.adjoint_variables().is_none());
    // In the first motion, its gradient, and the motions on coarser grids.
    for after in [50, 150, 250, 450] {
        solver.watch(stop(after).1);
        let stopped = solver.estimate(&inputs);
        assert!(matches!(stopped, Err(Error::Interrupted { .. })), "{after}: {stopped:?}");
    }
    solver.watch(stop(usize::MAX).1);
    assert_eq!(solver.estimate(&inputs).expect("an estimate"), estimate);
}
