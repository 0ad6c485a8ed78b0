//! Steps without a solution: they are halved, and the gradient is that of the motion on the grid that was taken.

mod common;

use common::{assert_gradient_is_exact, assert_says};
use hamiltonian_adjoint::{
    Cost, CostPoint, Error, Force, ForcePoint, Grid, Inputs, KineticEnergy, Scalar, Scene, Settings, Solver, Sum, System,
    Warning, scenes::CartPendulum,
};
use nalgebra::SVector;

/// A mass that is driven by b v² + u: without a control its speed is v₀/(1 − b v₀ t), and long steps have no solution.
struct Runaway;
impl KineticEnergy<1> for Runaway {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}
impl Force<1, 1, 1> for Runaway {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, b: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([b[0] * at.v[0] * at.v[0] + at.u[0]])
    }
}
impl Cost<1, 0, 1> for Runaway {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 1>, _b: &SVector<S, 0>) -> S {
        at.q[0] * at.v[0] + at.v[0] * at.u[0] * at.t + at.u[0] * at.u[0]
    }
}

/// Six easy steps, two that must be divided, and one more.
fn runaway(sum: Sum) -> (System, Inputs) {
    let mut scene = Scene::new();
    let q = scene.coordinates("sled", ["x"]);
    let (u, b) = (scene.control("push"), scene.design("gain", 1.0));
    scene.kinetic_energy("mass", Runaway, q, []);
    scene.force("drive", Runaway, q, [u], [b.into()]);
    scene.cost("end", Runaway, Sum::Terminal, q, [], [u], []);
    scene.cost("on the way", Runaway, sum, q, [], [u], []);
    let system = scene.compile().expect("scene");
    let steps = vec![0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.5, 0.15, 0.01];
    let mut inputs = Inputs::at_rest(&system, Grid { start: 0.0, steps });
    inputs.start.rate_mut()[0] = 1.0;
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 0.01 * (i as f64).sin());
    (system, inputs)
}

#[test]
fn the_gradient_on_halved_steps_is_exact_for_every_way_to_sum_a_cost() {
    for sum in [Sum::Plain, Sum::Rectangle, Sum::Trapezoidal, Sum::Terminal] {
        let (system, inputs) = runaway(sum);
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&inputs).expect("motion");
        let inserted = solver.trajectory().inserted.clone();
        assert!(inserted.len() >= 2, "{inserted:?}");
        let [Warning::HalvedSteps { step: 7, inserted: count, shortest, .. }] = solver.report().warnings[..] else {
            panic!("{:?}", solver.report().warnings)
        };
        println!("{}", solver.report().warnings[0]);
        assert!(count == inserted.len() && shortest <= 0.25);
        assert_gradient_is_exact(&format!("{sum:?}"), &system, &inputs);
    }
}

#[test]
fn a_cost_is_summed_over_the_given_nodes() {
    let (system, inputs) = runaway(Sum::Trapezoidal);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("motion");
    let (motion, taken) = (solver.trajectory(), solver.inputs());
    let given: Vec<usize> = (0..motion.computed).filter(|i| !motion.inserted.contains(i)).collect();
    assert_eq!(given.len(), inputs.grid.nodes());
    let h = |k: usize| {
        let (q, v, u, t) =
            (motion.q[(0, given[k])], motion.v[(0, given[k])], inputs.controls[(0, k)], motion.times[given[k]]);
        assert!((u - taken.controls[(0, given[k])]).abs() <= 1e-18);
        q * v + v * u * t + u * u
    };
    let on_the_way: f64 = (1..given.len()).map(|k| 0.5 * inputs.grid.steps[k - 1] * (h(k - 1) + h(k))).sum();
    let by_hand = on_the_way + h(given.len() - 1);
    assert!((solver.cost().expect("cost") - by_hand).abs() <= 1e-14 * by_hand);
    assert!((motion.times[motion.computed - 1] - inputs.grid.times()[9]).abs() <= 1e-15);
}

#[test]
fn the_limit_of_halving_is_kept_and_then_it_is_an_error() {
    let (system, mut inputs) = runaway(Sum::Plain);
    // The speed is infinite at t = 1 s.
    inputs.grid.steps[7] = 0.6;
    let mut solver = Solver::new(&system, Settings { max_halvings: 6, ..Settings::default() });
    let error = solver.simulate(&inputs).expect_err("beyond infinity").clone();
    let Error::Newton { step: 8, length, .. } = error else { panic!("{error:?}") };
    assert_eq!(length, 0.6 / 64.0);
    assert_says(&error, &["step 8", "max_halvings"]);
    // What was computed is there, up to close to t = 1 s.
    let motion = solver.trajectory();
    let last = motion.times[motion.computed - 1];
    assert!(last > 0.85 && last < 1.0, "{last}");
}

#[test]
fn hard_starts_of_the_cart_have_a_motion_and_an_exact_gradient() {
    // Few long steps, as large as the swing-up's grid can be made; and controls that jump by 2e4 N.
    let jumping = |i: usize| if (i / 3).is_multiple_of(2) { 1e4 } else { -1e4 };
    let constant = |_: usize| 10.0;
    type Control = fn(usize) -> f64;
    let cases: [(&str, usize, f64, Control); 2] = [("long steps", 10, 0.2, constant), ("jumps", 60, 0.001, jumping)];
    for (what, steps, dt, control) in cases {
        let system = CartPendulum::default().scene().compile().expect("scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, dt));
        inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = control(i));
        let mut solver = Solver::new(&system, Settings::default());
        let result = solver.simulate(&inputs).map(|_| ());
        println!("{what}: {result:?}, {} nodes, {:?}", solver.trajectory().computed, solver.report().warnings);
        result.unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_gradient_is_exact(what, &system, &inputs);
    }
}

#[test]
fn a_step_is_tried_from_the_last_node_before_it_is_halved() {
    // Extrapolated through the jump of the controls the guess is too far away; what was before it is near enough.
    let system = CartPendulum::default().scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(32, 0.02));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = if i < 20 { 10.0 } else { -700.0 });
    let mut solver = Solver::new(&system, Settings { max_iterations: 6, ..Settings::default() });
    let motion = solver.simulate(&inputs).expect("motion");
    assert!(motion.inserted.is_empty(), "{:?}", motion.inserted);
}
