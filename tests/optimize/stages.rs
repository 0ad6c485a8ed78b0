//! Multiple shooting solved stage by stage: the optimum and the multipliers of the dense method, at a cost that grows linearly with the stages.

use super::shooting::push;
use super::{Effort, Speed};
use hamiltonian_adjoint::optimize::{
    Free, Interval, MultipleShooting, Options, Outcome, Quantity, Reason, interior_point, silent, stages,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Control, EndState, Grid, Inputs, Output, Scene, Settings, Sum, System};
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;

const OPTIONS: Options =
    Options { iterations: 300, target: None, stationarity: 1e-8, violation: 1e-9, memory: 30, first_step: None };

/// Solves twice, and compares; for optima that are not unique, only values and multipliers.
fn assert_same(what: &str, build: impl Fn() -> MultipleShooting) -> Outcome {
    let is_unique = !what.ends_with("sum");
    let (mut one, mut other) = (build(), build());
    let start = one.start();
    let dense = interior_point(&mut one, &start, &OPTIONS, &mut silent).expect("fits");
    let found = stages(&mut other, &start, &OPTIONS, &mut silent).expect("fits");
    println!("{what}: {dense}\n  stage by stage: {found}");
    if !found.reason.is_converged() {
        found.history.iter().take(40).for_each(|it| println!("{it:?}"));
    }
    assert!(dense.reason.is_converged() && found.reason == Reason::Stationary, "{what}: {} {}", dense.reason, found.reason);
    assert!((dense.value - found.value).abs() < 1e-6 * dense.value.abs(), "{what}: {} {}", dense.value, found.value);
    let far = |a: &[f64], b: &[f64]| {
        let size = a.iter().fold(1.0f64, |most, x| most.max(x.abs()));
        a.iter().zip(b).fold(0.0f64, |most, (a, b)| most.max((a - b).abs())) / size
    };
    let [x, w] = [far(&dense.x, &found.x), far(&dense.multipliers, &found.multipliers)];
    assert!((x < 1e-4 || !is_unique) && w < 1e-4, "{what}: x differs by {x:.1e}, multipliers by {w:.1e}");
    // The problem has the motion of the solution.
    assert_eq!(other.start(), found.x);
    found
}

/// The cart on a spring in a number of segments.
fn pushed(
    (system, force, energy, states): &(System, Control, Output, Vec<EndState>),
    segments: usize,
    free: impl Fn(Vec<Free>) -> Vec<Free>,
    and: impl Fn(&mut MultipleShooting),
) -> MultipleShooting {
    let inputs = Inputs::at_rest(system, Grid::new(0.0, (0..30).map(|i| 0.05 + 0.02 * (i as f64).sin()).collect()));
    let mut problem =
        MultipleShooting::new(system, Settings::default(), inputs, free(vec![Free::control(*force)]), states, segments)
            .expect("a problem");
    problem.constrain(*energy, Interval::FREE);
    and(&mut problem);
    problem
}

#[test]
fn optima_and_multipliers_are_those_of_the_dense_method() {
    let all = push();
    let (energy, states) = (all.2, &all.3);
    let same = |free: Vec<Free>| free;
    for segments in [1, 4, 30] {
        assert_same("equalities", || pushed(&all, segments, same, |_| ()));
    }
    let bounded = |of: Vec<Free>| of.into_iter().map(|free| free.within(-4.0, 4.0)).collect::<Vec<_>>();
    let found = assert_same("bounds", || pushed(&all, 5, bounded, |_| ()));
    let most = found.x[..31].iter().fold(0.0f64, |most, u| most.max(u.abs()));
    assert!((most - 4.0).abs() < 1e-5, "no bound is active: {most}");
    let used = assert_same("equalities", || pushed(&all, 4, same, |_| ())).constraints[energy.index()];
    let limit = |problem: &mut MultipleShooting| problem.constrain(energy, Interval::at_least(1.1 * used));
    let found = assert_same("a limited sum", || pushed(&all, 4, same, limit));
    assert!((found.constraints[energy.index()] - 1.1 * used).abs() < 1e-6);
    let equal = |problem: &mut MultipleShooting| problem.constrain(energy, Interval::equal(1.05 * used));
    assert_same("a given sum", || pushed(&all, 4, same, equal));
    let place = |problem: &mut MultipleShooting| problem.constrain(states[1].position, Interval::new(-0.3, -0.01));
    assert_same("an end within an interval", || pushed(&all, 4, same, place));
    let minimised = |problem: &mut MultipleShooting| problem.minimise(energy);
    assert_same("a minimised sum", || pushed(&all, 4, same, minimised));
    let timed = |of: Vec<Free>| of.into_iter().chain([Free::duration().within(0.5, 1.2)]).collect::<Vec<_>>();
    assert_same("the duration", || pushed(&all, 4, timed, |_| ()));
    let moving = |of: Vec<Free>| {
        let rate = Free::new(Quantity::Rate(states[0].coordinate)).within(-0.5, 0.2);
        of.into_iter().chain([rate]).collect::<Vec<_>>()
    };
    assert_same("an initial velocity", || pushed(&all, 4, moving, |_| ()));
}

/// Limits of the speed at all nodes, each an output that one segment determines.
#[test]
fn limits_at_all_nodes_belong_to_their_segments() {
    let mut scene = Scene::new();
    let cart = scene.body("cart", 2.0, 0.1, [0.0, 0.0, 0.0]);
    let force = scene.control("force");
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
    scene.cost("effort", Effort, Sum::Integral, [], [], [force], [1.0.into()]);
    let x = cart.coordinates[0];
    let limits: Vec<Output> = (0..=40)
        .map(|node| {
            let limit = scene.output(&format!("speed at node {node}"));
            scene.term(limit, &format!("speed at node {node}"), Speed, Sum::Node(node), [x], [], [], []);
            limit
        })
        .collect();
    let states: Vec<EndState> = cart.coordinates.map(|q| scene.end_state(q)).to_vec();
    let system = scene.compile().expect("a system");
    let build = |segments: usize| {
        let inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.025));
        let free = vec![Free::control(force)];
        let mut problem =
            MultipleShooting::new(&system, Settings::default(), inputs, free, &states, segments).expect("fits");
        limits.iter().for_each(|limit| problem.constrain(*limit, Interval::at_most(1.2)));
        problem.constrain(states[0].position, Interval::equal(1.0));
        problem.constrain(states[0].rate, Interval::ZERO);
        problem
    };
    for segments in [1, 7, 20] {
        let found = assert_same("limits", || build(segments));
        let active = limits.iter().filter(|limit| (found.constraints[limit.index()] - 1.2).abs() < 1e-6).count();
        assert!(active > 3, "{active} limits are active");
    }
}

/// The cart with links, which turn up and are at rest at the end.
fn swing(links: usize, segments: usize) -> MultipleShooting {
    let mut cart = CartPendulum::with_links(links).mechanism();
    let (force, rail) = (cart.force, cart.cart.coordinates[0]);
    let angles: Vec<_> = cart.links.iter().map(|link| link.coordinates[2]).collect();
    cart.scene.effort("effort", force, 1e-4);
    let states: Vec<EndState> = [rail].iter().chain(&angles).map(|q| cart.scene.end_state(*q)).collect();
    let system: System = cart.scene.compile().expect("a system");
    let inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
    let free = vec![Free::control(force).scaled(10.0)];
    let mut problem = MultipleShooting::new(&system, Settings::default(), inputs, free, &states, segments).expect("fits");
    for (j, state) in states.iter().enumerate() {
        problem.constrain(state.rate, Interval::ZERO);
        if j > 0 {
            problem.constrain(state.position, Interval::equal(FRAC_PI_2));
        }
    }
    let guess = |node: usize, q: &mut nalgebra::DVector<f64>, v: &mut nalgebra::DVector<f64>| {
        for angle in &angles {
            (q[angle.index()], v[angle.index()]) = (PI * node as f64 / 100.0 - FRAC_PI_2, FRAC_PI_2);
        }
    };
    problem.guess(guess).expect("finite");
    problem
}

#[test]
fn three_links_turn_up_from_a_straight_guess() {
    let mut problem = swing(3, 10);
    let start = problem.start();
    let options = Options { stationarity: 1e-6, ..OPTIONS };
    let found = stages(&mut problem, &start, &options, &mut silent).expect("fits");
    println!("{found}");
    assert!(found.reason == Reason::Stationary && found.iterations < 40 && found.violation < 1e-9, "{found}");
    assert!((found.value - 0.446240).abs() < 1e-5, "{}", found.value);
}

/// One right-hand side for each row of one segment, and one product for each of its variables.
#[test]
fn the_work_of_an_iteration_does_not_depend_on_the_number_of_segments() {
    let work = |segments: usize| {
        let mut problem = swing(1, segments);
        let start = problem.start();
        let options = Options { iterations: 1, ..OPTIONS };
        let found = stages(&mut problem, &start, &options, &mut silent).expect("fits");
        assert_eq!(found.reason, Reason::Iterations);
        [found.gradients, found.products]
    };
    let [gradients, products] = work(10);
    assert_eq!(gradients, 2 * (1 + 4), "J and four states, at two points");
    assert_eq!(products, 11, "eleven controls of the first segment");
    assert_eq!(work(50), [gradients, 3]);
}

#[test]
fn ends_of_runs_have_their_reasons() {
    let mut problem = pushed(&push(), 4, |free| free, |_| ());
    let start = problem.start();
    let few = Options { iterations: 2, ..OPTIONS };
    let found = stages(&mut problem, &start, &few, &mut silent).expect("fits");
    assert_eq!((found.reason, found.iterations, found.history.len()), (Reason::Iterations, 2, 3));
    let mut seen = 0;
    let mut twice = |_: &hamiltonian_adjoint::optimize::Iterate, _: &[f64]| {
        seen += 1;
        if seen == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let found = stages(&mut problem, &start, &OPTIONS, &mut twice).expect("fits");
    assert_eq!(found.reason, Reason::Interrupted);
    problem.watch(|_| ControlFlow::Break(()));
    let found = stages(&mut problem, &start, &OPTIONS, &mut silent).expect("fits");
    assert_eq!(found.reason, Reason::Interrupted, "{found}");
    let mut problem = pushed(&push(), 4, |free| free, |_| ());
    let mut wrong = start.clone();
    wrong[0] = f64::NAN;
    assert!(stages(&mut problem, &wrong, &OPTIONS, &mut silent).is_err());
    wrong[0] = 1e200;
    let found = stages(&mut problem, &wrong, &OPTIONS, &mut silent).expect("fits");
    assert_eq!((found.reason, found.value), (Reason::NoStart, f64::INFINITY), "{found}");
}
