//! Motions that are too long to be stored: the same numbers in less memory.

use crate::common::assert_says;
use crate::scenes::structures;
use hamiltonian_adjoint::{
    Composition, Cost, CostPoint, Cx, Error, Force, ForcePoint, Gradient, Grid, Inputs, KineticEnergy, LiftedSolver,
    LongSolver, PotentialEnergy, Scalar, Scene, Scheme, Settings, Solver, Sum, System, Warning, scenes::CartPendulum,
    simulate,
};
use nalgebra::SVector;

fn cart(steps: usize, dt: f64) -> (System, Inputs) {
    let system = CartPendulum::default().scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, dt));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 3.0 * (i as f64 * dt).sin());
    (system, inputs)
}

/// Asserts that the gradient within so many bytes is that of the stored motion to the last bit; returns the steps computed per step.
fn assert_same(system: &System, inputs: &Inputs, settings: Settings, bytes: usize) -> f64 {
    let mut stored = Solver::new(system, settings);
    stored.simulate(inputs).expect("motion");
    let factorisations = stored.report().factorisations;
    let gradient = stored.gradient().expect("gradient").clone();
    let mut long = LongSolver::new(system, settings, bytes);
    for _ in 0..2 {
        assert!(long.gradient(inputs).expect("gradient") == &gradient, "{bytes} bytes");
    }
    assert_eq!(long.inputs().grid, stored.inputs().grid);
    assert_eq!(long.report().warnings, stored.report().warnings);
    let work = long.report().factorisations as f64 / factorisations as f64;
    assert_same_values(&mut long, &stored);
    assert_eq!(long.report().warnings, stored.report().warnings);
    work
}

/// J and the outputs, or why there are none.
fn assert_same_values(long: &mut LongSolver, stored: &Solver) {
    assert_eq!((long.cost(), long.outputs()), (stored.cost(), stored.outputs()));
}

#[test]
fn the_gradient_from_checkpoints_is_the_stored_one_at_every_budget() {
    let (system, inputs) = cart(3000, 0.002);
    let mut work = Vec::new();
    for bytes in [10_000_000, 500_000, 250_000, 190_000, 180_000] {
        work.push(assert_same(&system, &inputs, Settings::default(), bytes));
    }
    println!("work of the forward sweep, in simulations: {work:.2?}");
    // Two levels of checkpoints at most cost two more simulations.
    assert!(work[0] == 1.0 && work[1] <= 2.0 && work.iter().all(|work| *work <= 3.0), "{work:?}");
}

/// T = ½ (v₀² + v₁²).
struct Masses;
impl KineticEnergy<2> for Masses {
    fn kinetic_energy<S: Scalar>(&self, _: &SVector<S, 2>, v: &SVector<S, 2>, _: &SVector<S, 0>) -> S {
        v.dot(v) * 0.5
    }
}

/// V = q₀ q₁: a step of nearly 2 s has no solution along (1, −1).
struct Saddle;
impl PotentialEnergy<2> for Saddle {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, _: &SVector<S, 0>, _: S) -> S {
        q[0] * q[1]
    }
}

impl Cost<2> for Saddle {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, _: &SVector<S, 0>) -> S {
        at.q[0] * at.q[0]
    }
}

#[test]
fn lost_digits_are_told_where_they_were_lost() {
    let mut scene = Scene::new();
    let q = scene.coordinates("masses", ["x", "y"]);
    q.iter().for_each(|q| scene.place(*q, 0.1));
    scene.kinetic_energy("masses", Masses, q, []);
    scene.potential_energy("saddle", Saddle, q, []);
    scene.cost("cost", Saddle, Sum::Terminal, q, [], [], []);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(600, 0.001));
    inputs.grid.steps[400] = 2.0 - 2e-9;
    let mut stored = Solver::new(&system, Settings::default());
    stored.simulate(&inputs).expect("motion");
    let told = &stored.report().warnings;
    assert!(told.iter().any(|warning| matches!(warning, Warning::LostDigits { step: 401, .. })), "{told:?}");
    let error = LongSolver::new(&system, Settings::default(), 1).gradient(&inputs).expect_err("no memory");
    let Error::Memory { needed, .. } = error else { panic!("{error:?}") };
    assert_same(&system, &inputs, Settings::default(), needed);
}

#[test]
fn restarts_and_halved_steps_are_the_same_from_checkpoints() {
    let (system, mut inputs) = cart(600, 0.01);
    let settings = Settings { drift_bound: 1e-7, rebase_every: 7, ..Settings::default() };
    assert_same(&system, &inputs, settings, 160_000);
    // Far too long for one iteration matrix.
    inputs.grid.steps[50] = 1.0;
    inputs.grid.steps[400] = 1.0;
    let settings = Settings { max_iterations: 4, ..settings };
    assert!(!simulate(&system, &inputs, settings).expect("motion").inserted.is_empty());
    assert_same(&system, &inputs, settings, 160_000);
}

/// A long step may be followed from zero in its first stage and fail in another: nothing of that remains when its halves are computed again.
#[test]
fn halved_steps_of_several_stages_are_the_same_from_checkpoints() {
    let mut compared = 0;
    for scheme in Scheme::ALL {
        for (max_iterations, dt) in [(4, 0.1), (6, 0.1), (6, 0.2), (10, 0.2), (10, 0.25), (25, 0.25)] {
            let (system, mut inputs) = cart(20, dt);
            for force in [5.0, 10.0, 20.0, 40.0] {
                inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = force * (1.3 * i as f64).sin());
                let settings = Settings { scheme, max_iterations, ..Settings::default() };
                let Ok(motion) = simulate(&system, &inputs, settings) else { continue };
                if !motion.inserted.is_empty() {
                    assert_same(&system, &inputs, settings, 10_000_000);
                    compared += 1;
                }
            }
        }
    }
    println!("{compared} motions compared");
    assert!(compared > 20, "{compared}");
}

#[test]
fn every_node_is_shown_once_and_in_order() {
    let (system, inputs) = cart(500, 0.01);
    let motion = simulate(&system, &inputs, Settings::default()).expect("motion");
    let mut next = 0;
    LongSolver::new(&system, Settings::default(), 120_000)
        .simulate(&inputs, |state| {
            assert_eq!((state.node, state.time, state.q), (next, motion.times[next], motion.q.column(next).as_slice()));
            next += 1;
        })
        .expect("motion");
    assert_eq!(next, 501);
}

/// ln u.
struct Log;
impl Cost<0, 0, 1> for Log {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 1>, _: &SVector<S, 0>) -> S {
        at.u[0].ln()
    }
}

/// A cart with costs and outputs that are summed in every way.
fn with_outputs() -> System {
    let mut cart = CartPendulum::with_links(1).mechanism();
    let (x, force) = (cart.cart.coordinates[0], cart.force);
    let single = [0, 57, 200].map(Sum::Node);
    let ways = [Sum::Integral, Sum::Plain, Sum::AllNodes, Sum::Rectangle, Sum::Trapezoidal, Sum::Terminal]
        .into_iter()
        .chain(single);
    for (k, sum) in ways.enumerate() {
        let (output, name) = (cart.scene.output(&format!("output {k}")), format!("seen {k}"));
        cart.scene.term(output, &name, Dragged, sum, [x], [], [force], []);
        cart.scene.cost(&format!("cost {k}"), Dragged, sum, [x], [], [force], []);
    }
    cart.scene.compile().expect("a scene")
}

#[test]
fn the_cost_and_the_outputs_are_the_stored_ones_after_a_motion_and_after_a_gradient() {
    let system = with_outputs();
    let mut even = Inputs::at_rest(&system, Grid::uniform(200, 0.01));
    even.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 3.0 * (0.02 * i as f64).cos());
    let mut uneven = even.clone();
    [50, 51, 150].into_iter().for_each(|step| uneven.grid.steps[step] = 1.0);
    let mut halved = 0;
    for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK3] {
        let settings = Settings { scheme, max_iterations: 4, drift_bound: 1e-7, ..Settings::default() };
        for inputs in [&even, &uneven] {
            let mut stored = Solver::new(&system, settings);
            halved += stored.simulate(inputs).expect("a motion").inserted.len();
            let gradient = stored.gradient().expect("a gradient").clone();
            let mut bytes = 500;
            while let Err(Error::Memory { needed, .. }) = LongSolver::new(&system, settings, bytes).gradient(inputs) {
                bytes = needed;
            }
            for bytes in [bytes, 10_000_000] {
                let mut long = LongSolver::new(&system, settings, bytes);
                long.simulate(inputs, |_| ()).expect("a motion");
                assert_same_values(&mut long, &stored);
                assert_eq!(long.gradient(inputs).expect("a gradient"), &gradient);
                assert_same_values(&mut long, &stored);
                assert_same_values(&mut long, &stored);
            }
        }
    }
    assert!(halved >= 5, "{halved}");
}

#[test]
fn there_is_no_cost_without_a_complete_motion_or_a_value() {
    let (system, mut inputs) = cart(300, 0.002);
    let settings = Settings { max_iterations: 1, max_halvings: 0, ..Settings::default() };
    let (mut long, mut stored) = (LongSolver::new(&system, settings, 150_000), Solver::new(&system, settings));
    assert!(matches!(long.cost(), Err(Error::Incomplete { computed: 0, .. })));
    inputs.controls.fill(0.0);
    inputs.controls[(0, 200)] = 1e7;
    for control in [1e7, 0.0, f64::INFINITY, 1e7] {
        inputs.controls[(0, 200)] = control;
        assert_eq!(long.simulate(&inputs, |_| ()), stored.simulate(&inputs).map(|_| ()));
        assert_eq!(long.cost().is_ok(), control == 0.0);
        assert_same_values(&mut long, &stored);
    }
    let mut cart = CartPendulum::default().mechanism();
    let x = cart.cart.coordinates[0];
    let output = cart.scene.output("place");
    cart.scene.term(output, "place", Dragged, Sum::Integral, [x], [], [cart.force], []);
    cart.scene.cost("log", Log, Sum::Trapezoidal, [], [], [cart.force], []);
    let system = cart.scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(300, 0.002));
    inputs.controls.fill(1.0);
    inputs.controls[(0, 70)] = 0.0;
    let settings = Settings::default();
    let (mut long, mut stored) = (LongSolver::new(&system, settings, 150_000), Solver::new(&system, settings));
    long.simulate(&inputs, |_| ()).expect("a motion");
    stored.simulate(&inputs).expect("a motion");
    assert!(matches!(long.cost(), Err(Error::Model { node: 70, .. })) && long.outputs().is_ok());
    assert_same_values(&mut long, &stored);
}

#[test]
fn too_little_memory_is_an_error_and_a_failed_run_leaves_nothing_behind() {
    let (system, mut inputs) = cart(3000, 0.002);
    let error = LongSolver::new(&system, Settings::default(), 50_000).gradient(&inputs).expect_err("too little").clone();
    let Error::Memory { given: 50_000, needed } = error else { panic!("{error:?}") };
    assert_says(&error, &["50000 bytes", &needed.to_string()]);
    assert!(LongSolver::new(&system, Settings::default(), needed).gradient(&inputs).is_ok());

    let mut long = LongSolver::new(&system, Settings { max_iterations: 1, max_halvings: 0, ..Settings::default() }, 500_000);
    inputs.controls[(0, 2000)] = 1e7;
    assert!(matches!(long.gradient(&inputs), Err(Error::Newton { .. })));
    inputs.controls.fill(0.0);
    let still = Settings { max_iterations: 1, max_halvings: 0, ..Settings::default() };
    inputs.grid.steps.truncate(100);
    inputs.controls = nalgebra::DMatrix::zeros(1, 101);
    let expected = hamiltonian_adjoint::gradient(&system, &inputs, still).map(|gradient| gradient.controls);
    assert_eq!(long.gradient(&inputs).map(|gradient| gradient.controls.clone()), expected);
}

/// A mass of 1 kg with a steep drag, pushed by a control.
struct Dragged;
impl KineticEnergy<1> for Dragged {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}
impl Force<1, 1, 1> for Dragged {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, b: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([at.u[0] - b[0] * at.v[0].powi(3) + at.q[0].sin() * 30.0])
    }
}
impl Cost<1, 0, 1> for Dragged {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 1>, _b: &SVector<S, 0>) -> S {
        at.q[0] * at.q[0] * 0.5 + at.v[0] * at.u[0] * at.t
    }
}

fn dragged() -> System {
    let mut scene = Scene::new();
    let q = scene.coordinates("sled", ["x"]);
    let (u, b) = (scene.control("push"), scene.design("drag", 300.0));
    scene.kinetic_energy("mass", Dragged, q, []);
    scene.force("drag", Dragged, q, [u], [b.into()]);
    scene.cost("on the way", Dragged, Sum::Trapezoidal, q, [], [u], []);
    scene.compile().expect("scene")
}

/// So many steps of which every sixth but those of the first third meets a jump that it must be divided for.
fn jumps(system: &System, steps: usize, force: f64) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, 0.5));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = if 3 * i > steps && i % 6 < 3 { force } else { -1.0 });
    inputs
}

/// Asserts that within so many bytes the gradient is the stored one or an error; returns the steps computed per step, if there was room.
fn assert_same_or_too_little(
    system: &System,
    inputs: &Inputs,
    settings: Settings,
    bytes: usize,
    stored: &Stored,
) -> Option<f64> {
    let mut long = LongSolver::new(system, settings, bytes);
    match long.gradient(inputs) {
        Ok(gradient) => assert!(gradient == &stored.gradient, "{bytes} bytes: {gradient:?}"),
        Err(Error::Memory { given, needed }) => {
            assert!(given == bytes && needed > bytes, "{bytes} bytes: {needed}");
            return None;
        }
        Err(error) => panic!("{bytes} bytes: {error}"),
    }
    assert!(long.inputs() == &stored.inputs, "{bytes} bytes");
    assert_eq!(long.report().warnings, stored.warnings, "{bytes} bytes");
    Some(long.report().factorisations as f64 / stored.factorisations as f64)
}

/// What a [`Solver`] says.
struct Stored {
    gradient: Gradient,
    inputs: Inputs,
    inserted: usize,
    warnings: Vec<Warning>,
    factorisations: usize,
}

fn stored(system: &System, inputs: &Inputs, settings: Settings) -> Stored {
    let mut solver = Solver::new(system, settings);
    let inserted = solver.simulate(inputs).expect("motion").inserted.len();
    let gradient = solver.gradient().expect("gradient").clone();
    let report = solver.report();
    let (warnings, factorisations) = (report.warnings.clone(), report.factorisations);
    Stored { gradient, inputs: solver.inputs().clone(), inserted, warnings, factorisations }
}

/// From next to nothing to more than enough, and where each error says.
fn assert_every_budget(what: &str, system: &System, inputs: &Inputs, settings: Settings) -> usize {
    let stored = stored(system, inputs, settings);
    let all = stored.inputs.grid.nodes() * (system.bytes_per_node(&settings) + 16 * (1 + system.k()) + 60);
    let mut works = Vec::new();
    let mut bytes = 500;
    while bytes < 2 * all {
        works.extend(assert_same_or_too_little(system, inputs, settings, bytes, &stored));
        bytes = bytes * 4 / 3;
    }
    println!("{what}: {} inserted nodes; work in simulations, by memory: {works:.2?}", stored.inserted);
    // Four levels of checkpoints and the grid found out before are the most.
    assert!(works.len() >= 3 && works.iter().all(|work| *work <= 6.0), "{what}: {works:?}");
    assert!(works.last() == Some(&1.0) || stored.inserted > 0, "{what}: {works:?}");
    // As much as is asked for is enough in the end.
    let mut bytes = 500;
    let mut errors = 0;
    while let Err(error) = LongSolver::new(system, settings, bytes).gradient(inputs) {
        let Error::Memory { needed, .. } = error else { panic!("{error:?}") };
        assert!(needed > bytes, "{needed} of {bytes}");
        (bytes, errors) = (needed, errors + 1);
    }
    // One for the given grid, and one for each time that the nodes become twice as many.
    let doublings = (stored.inputs.grid.nodes() as f64 / inputs.grid.nodes() as f64).log2().ceil() as usize;
    assert!(errors <= 2 + doublings, "{what}: {errors} errors");
    assert!(bytes < 4 * all, "{bytes} for {all}");
    assert!(assert_same_or_too_little(system, inputs, settings, bytes, &stored).is_some());
    stored.inserted
}

#[test]
fn nodes_that_halved_steps_insert_fit_into_every_budget() {
    let system = dragged();
    let settings = Settings { max_iterations: 5, ..Settings::default() };
    let counts = [(60, 0.0), (60, 1e4), (400, 1e3), (900, 1e5), (40, 1e6)].map(|(steps, force)| {
        assert_every_budget(&format!("{steps} steps, {force} N"), &system, &jumps(&system, steps, force), settings)
    });
    assert!(counts.iter().all(|&count| count > 10), "{counts:?}");
}

/// A wall at x = 0.05 m that long steps do not get past.
struct Wall;
impl Force<1> for Wall {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([-((at.q[0] - 0.05) * 200.0).exp()])
    }
}

#[test]
fn the_memory_that_is_named_is_enough_for_motions_shorter_than_a_window() {
    let mut scene = Scene::new();
    let [x] = scene.coordinates("ball", ["x"]);
    scene.kinetic_energy("mass", Dragged, [x], []);
    scene.force("wall", Wall, [x], [], []);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(3, 0.05));
    inputs.start.rate_mut()[0] = 40.0;
    let inserted = simulate(&system, &inputs, Settings::default()).expect("motion").inserted.len();
    assert!(inserted > 1);
    let mut bytes = 200;
    let mut errors = 0;
    while let Err(error) = LongSolver::new(&system, Settings::default(), bytes).gradient(&inputs) {
        let Error::Memory { needed, .. } = error else { panic!("{error:?}") };
        (bytes, errors) = (needed, errors + 1);
    }
    assert!(errors <= 3, "{errors} errors, {bytes} bytes in the end");
}

#[test]
fn a_jacobian_that_does_not_fit_takes_no_memory_from_the_next_motion() {
    let mut cart = CartPendulum::default().mechanism();
    for k in 0..30 {
        let output = cart.scene.output(&format!("work {k}"));
        let (name, x) = (format!("work {k}"), cart.cart.coordinates[0]);
        cart.scene.term(output, &name, Dragged, Sum::Trapezoidal, [x], [], [cart.force], []);
    }
    let system = cart.scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.01));
    let mut solver = LongSolver::new(&system, Settings::default(), 0);
    let Err(Error::Memory { needed, .. }) = solver.simulate(&inputs, |_| ()) else { panic!("no memory at all") };
    let mut solver = LongSolver::new(&system, Settings::default(), needed);
    assert!(matches!(solver.jacobian(&inputs), Err(Error::Memory { .. })));
    solver.simulate(&inputs, |_| ()).expect("a motion");
}

#[test]
fn ten_thousand_inserted_nodes_are_the_same_from_checkpoints() {
    let system = dragged();
    let settings = Settings { max_iterations: 5, ..Settings::default() };
    let inputs = jumps(&system, 7000, 1e5);
    let stored = stored(&system, &inputs, settings);
    println!("{} inserted nodes", stored.inserted);
    assert!(stored.inserted >= 10_000, "{}", stored.inserted);
    let sizes = [400_000, 1_100_000, 1_200_000, 1_400_000, 4_000_000];
    let works = sizes.map(|bytes| assert_same_or_too_little(&system, &inputs, settings, bytes, &stored));
    println!("work in simulations: {works:.2?}");
    assert!(works[1..].iter().all(|work| work.is_some()), "{works:?}");
}

#[test]
fn halved_steps_of_restarted_composed_and_dependent_motions_fit_into_every_budget() {
    let (cart, mut inputs) = cart(150, 0.01);
    assert_eq!(assert_every_budget("not halved", &cart, &inputs, Settings::default()), 0);
    [50, 51, 90, 149].into_iter().for_each(|step| inputs.grid.steps[step] = 1.0);
    let few = Settings { max_iterations: 4, ..Settings::default() };
    let restarted = Settings { rebase_every: 7, ..few };
    let projected = Settings { drift_bound: 1e-7, rebase_every: 3, ..few };
    for (what, settings) in [("plain", few), ("restarted", restarted), ("projected", projected)] {
        assert!(assert_every_budget(what, &cart, &inputs, settings) > 0, "{what}");
    }

    let mut composed = Inputs::at_rest(&cart, Grid::composed(30, 0.3, Composition::Suzuki4));
    composed.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 20.0 * (0.1 * i as f64).cos());
    assert!(assert_every_budget("composed", &cart, &composed, Settings { rebase_every: 5, ..few }) > 0);

    let doubled = structures::string(3, 2).compile().expect("scene");
    let mut inputs = Inputs::at_rest(&doubled, Grid::uniform(120, 0.01));
    inputs.controls.fill(0.3);
    [40, 41, 100].into_iter().for_each(|step| inputs.grid.steps[step] = 0.8);
    assert!(assert_every_budget("dependent", &doubled, &inputs, few) > 0);
}

/// A mass that nothing pushes: no control, no cost, no output, no design variable.
fn bare() -> System {
    let mut scene = Scene::new();
    let q = scene.coordinates("masses", ["x", "y"]);
    scene.kinetic_energy("masses", Masses, q, []);
    scene.compile().expect("a scene")
}

/// A cart with outputs and without J.
fn without_cost() -> System {
    let mut cart = CartPendulum::default().mechanism();
    for (name, sum) in [("end", Sum::Terminal), ("way", Sum::Trapezoidal), ("start", Sum::Node(0))] {
        let (output, x) = (cart.scene.output(name), cart.cart.coordinates[0]);
        cart.scene.term(output, name, Dragged, sum, [x], [], [cart.force], []);
    }
    cart.scene.compile().expect("a scene")
}

/// Asserts that within so many bytes every method finds what a [`Solver`] finds, or says that there is too little memory.
fn assert_every_method(what: &str, system: &System, inputs: &Inputs, bytes: usize) {
    let settings = Settings::default();
    let mut stored = Solver::new(system, settings);
    let motion = stored.simulate(inputs).map(|_| ());
    let weights = vec![0.5; system.outputs()];
    let what = format!("{what}, {} steps, {bytes} bytes", inputs.grid.steps.len());
    let is_memory = |error: &Error| matches!(error, Error::Memory { given, needed } if *given == bytes && needed > given);
    let mut long = LongSolver::new(system, settings, bytes);
    for _ in 0..2 {
        match long.simulate(inputs, |_| ()) {
            Err(error) if is_memory(&error) => {}
            simulated => {
                assert_eq!(simulated, motion, "{what}");
                assert_same_values(&mut long, &stored);
            }
        }
        match long.gradient(inputs) {
            Err(error) if is_memory(&error) => {}
            gradient => assert_eq!(gradient, stored.gradient(), "{what}"),
        }
        match long.weighted_gradient(inputs, 0.3, &weights) {
            Err(error) if is_memory(&error) => {}
            gradient => assert_eq!(gradient, stored.weighted_gradient(0.3, &weights), "{what}"),
        }
        match long.jacobian(inputs) {
            Err(error) if is_memory(&error) => {}
            jacobian => assert_eq!(jacobian, stored.jacobian(), "{what}"),
        }
        assert!(long.adjoint_report().factorisations <= inputs.grid.nodes() + 1, "{what}");
    }
}

/// Asserts that every derivative of a [`Solver`] and the motion on other numbers have values.
fn assert_every_derivative(what: &str, system: &System, inputs: &Inputs) {
    let (mut solver, direction) = (Solver::new(system, Settings::default()), inputs.no_change());
    solver.simulate(inputs).expect("a motion");
    let errors = [
        solver.gradient().err(),
        solver.pull_back(&vec![0.5; system.outputs()]).err(),
        solver.push_forward(&direction).err(),
        solver.hessian_product(&direction).err(),
    ];
    assert!(errors.iter().all(Option::is_none), "{what}: {errors:?}");
    let mut lifted = LiftedSolver::<Cx>::new(system, inputs, Settings::default()).expect("a motion");
    lifted.simulate(&inputs.lift()).expect("the same motion");
    assert!(lifted.cost().is_ok() && lifted.outputs().is_ok(), "{what}");
}

#[test]
fn no_method_fails_for_what_a_scene_lacks_or_for_how_little_memory_there_is() {
    let (with_cost, without_cost, bare) = (cart(1, 0.01).0, without_cost(), bare());
    for (what, system) in [("without outputs", &with_cost), ("without a cost", &without_cost), ("bare", &bare)] {
        for steps in [0, 1, 2, 17, 1000] {
            let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, 0.001));
            inputs.controls.fill(1.0);
            assert_every_derivative(what, system, &inputs);
            for bytes in [0, 1, 5_000, 10_000, 20_000, 100_000, 200_000, 2_000_000, usize::MAX] {
                assert_every_method(what, system, &inputs, bytes);
            }
        }
    }
}
