//! Impacts and open constraints with other features: adaptive grids, checks, files, batches, animations, accelerations, interruption, optimisation.

use std::ops::ControlFlow;

use hamiltonian_adjoint::optimize::{Free, MotionProblem, Options, Variables, interior_point, silent};
use hamiltonian_adjoint::{
    Animation, Error, Grid, Inputs, LongSolver, Mechanics, Scheme, Settings, Solver, System, check, gradients,
};

use crate::common::assert_says;
use crate::impacts::{Lift, rods, usual};

/// The rods with their motion.
fn moved(system: &System) -> Result<(Solver, Inputs), Error> {
    let mut solver = Solver::new(system, Settings::default());
    let given = usual(system);
    solver.simulate(&given)?;
    Ok((solver, given))
}

#[test]
fn reactions_of_open_equations_are_zero() -> Result<(), Error> {
    let system = rods(1, false, Lift::Time);
    let (solver, given) = moved(&system)?;
    let (motion, [floor, landing]) = (solver.trajectory(), [4, 5]);
    let at = |node: usize| Mechanics::at_node(&system, solver.inputs(), motion, node)?.accelerations();
    let start = Mechanics::at_start(&system, &given)?.accelerations()?.1;
    assert!(start[floor].abs() + start[landing].abs() < 1e-20, "{start}");
    for node in 0..motion.computed {
        let lambda = at(node)?.1;
        // The floor is closed at the end of the compression, the landing until the lift.
        for (equation, is_closed) in [(floor, node == 17), (landing, (27..=37).contains(&node))] {
            let size = lambda[equation].abs();
            assert!(if is_closed { size > 1e-3 } else { size < 1e-20 }, "node {node}: {lambda}");
        }
    }
    let at = Mechanics::at_node(&system, solver.inputs(), motion, 30)?;
    assert_eq!(at.open(), [system.multiplier(floor)]);
    let again = Mechanics::new(&system, at.q(), at.v())?.with_controls(at.controls())?.at_time(at.t())?;
    assert_ne!(again.accelerations()?, at.accelerations()?);
    assert_eq!(again.clone().with_open(&at.open())?.accelerations()?, at.accelerations()?);
    let error = again.with_open(&[system.multiplier(0)]).expect_err("a hinge does not open");
    assert_says(&error, &["`Mechanics::with_open`", "opens, closes or hits"]);
    Ok(())
}

#[test]
fn checks_files_batches_and_pages() -> Result<(), Error> {
    let system = rods(1, false, Lift::Time);
    let (mut solver, given) = moved(&system)?;
    check::gradient(&system, &given, Settings::default()).run()?.assert_passed();
    check::hessian(&system, &given, Settings::default()).run()?.assert_passed();
    #[cfg(feature = "files")]
    for open in [given.open.clone(), Vec::new()] {
        let inputs = Inputs { open, ..given.clone() };
        assert_eq!(Inputs::from_json(&system, &inputs.to_json(&system)?)?, inputs);
    }
    let own = solver.gradient()?.clone();
    let batch = gradients(&system, &[given.clone(), given.clone()], Settings::default());
    assert!(batch.into_iter().all(|gradient| gradient.is_ok_and(|gradient| gradient == own)));
    let animation = Animation::new(&system, solver.inputs(), solver.trajectory())?;
    assert!(!animation.html().contains("NaN") && !animation.animated_svg().contains("NaN"));
    let (found, q) = (solver.inputs().clone(), solver.trajectory().q.clone());
    assert_eq!(solver.simulate(&found)?.q, q);
    Ok(())
}

#[test]
fn adaptive_grids_and_optimisation() -> Result<(), Error> {
    let system = rods(1, false, Lift::Time);
    let given = usual(&system);
    let mut finest: Option<Vec<f64>> = None;
    for (scheme, tolerance) in [(Scheme::ESDIRK4, 1e-7), (Scheme::ESDIRK4, 1e-6), (Scheme::TRAPEZOIDAL, 1e-6)] {
        let settings = Settings { scheme, ..Settings::default() };
        let mut solver = Solver::new(&system, settings);
        let adapted = solver.adapt(&given, tolerance)?;
        solver.simulate(&adapted)?;
        let outputs: Vec<f64> = solver.outputs()?.iter().copied().collect();
        let finest = finest.get_or_insert(outputs.clone());
        assert!(finest.iter().zip(&outputs).all(|(a, b)| (a - b).abs() < 1e-4), "{outputs:?} for {finest:?}");
        check::gradient(&system, &adapted, settings).run()?.assert_passed();
    }
    let variables = Variables::new(&system, &given, vec![Free::control(system.control(0)).within(-3.0, 3.0)])?;
    let mut problem = MotionProblem::new(&system, Settings::default(), given.clone(), variables)?;
    let start = problem.start();
    let options = Options { iterations: 4, ..Options::default() };
    let outcome = interior_point(&mut problem, &start, &options, &mut silent)?;
    assert!(outcome.value < 1.1 * moved(&system)?.0.cost()?, "{}", outcome.value);
    Ok(())
}

#[test]
fn what_is_refused_is_said() -> Result<(), Error> {
    let system = rods(1, false, Lift::Time);
    let (mut solver, given) = moved(&system)?;
    let own = solver.gradient()?.clone();
    for at in [3, 20, 40] {
        let (mut stopped, mut calls) = (Solver::new(&system, Settings::default()), 0);
        stopped.watch(move |_| {
            calls += 1;
            if calls > at { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let error = stopped.simulate(&given).map(|_| ()).expect_err("a stop");
        assert_says(&error, &["stopped by the progress callback"]);
    }
    let error =
        LongSolver::new(&system, Settings::default(), 2_000).gradient(&given).map(|_| ()).expect_err("little memory");
    assert_says(&error, &["2000 bytes are too few"]);
    assert!(*LongSolver::new(&system, Settings::default(), 20_000).gradient(&given)? == own);
    let closed = Inputs { open: Vec::new(), ..given.clone() };
    let error = solver.simulate(&closed).map(|_| ()).expect_err("a start away from the floor");
    assert_says(&error, &["`landing`", "violated by"]);
    // Both events are at the same place.
    let controls = given.controls.columns(0, 46).into_owned();
    let whole = Inputs { grid: Grid::uniform(45, 0.8 / 45.0), controls, events: Vec::new(), ..given };
    let error = solver.find_phases(&whole, 6).map(|_| ()).expect_err("two events at once");
    assert_says(&error, &["`floor` and `landing` both happen at t = 0.3"]);
    Ok(())
}
