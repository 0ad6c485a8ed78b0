//! Segments as parts of a whole: watched and stopped as one motion.

use super::shooting::push;
use hamiltonian_adjoint::optimize::{Free, MultipleShooting, Options, Problem, Reason, interior_point, silent};
use hamiltonian_adjoint::{Error, Grid, Inputs, Progress, Settings, Task};
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
                assert_eq!(outcome.reason, Reason::Asked, "{until}");
                assert!(matches!(outcome.first_failure, Some(Error::Interrupted { of: 31, .. })), "{outcome:?}");
            }
            // The start has no value, or no derivatives.
            Err(error) => assert!(matches!(error, Error::Interrupted { of: 31, .. }) && until <= 100, "{error}"),
        }
        let behind = told.load(Ordering::Relaxed) - until;
        assert!((1..=3).contains(&behind), "{until}: {behind}");
    }
}
