//! Costs that couple nodes, and costs on lists: rates of controls, many coordinates, references given by time.

use super::error;
use hamiltonian_adjoint::check;
use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{
    Composition, Cost, CostPoint, Grid, Inputs, ListCost, ListPoint, LongSolver, Scalar, Scheme, Settings, Solver, Start,
    Sum, System, gradient,
};
use nalgebra::SVector;

/// u̇² + u u̇ q, times b.
struct Jerk;

impl Cost<1, 0, 1, 1> for Jerk {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 1>, b: &SVector<S, 1>) -> S {
        (at.u_dot[0] * at.u_dot[0] + at.u[0] * at.u_dot[0] * at.q[0]) * b[0]
    }
}

/// (Σ b v² + Σ sin q)² + Σ λ u̇.
struct Everything;

impl ListCost for Everything {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        let squares: S = at.v.iter().zip(at.b).map(|(v, b)| *v * *v * *b).sum();
        let sines: S = at.q.iter().map(|q| q.sin()).sum();
        let rates: S = at.u_dot.iter().copied().sum();
        let reactions: S = at.lambda.iter().copied().sum();
        (squares + sines).powi(2) + reactions * rates
    }
}

/// The same, by a formula that branches and so has no program.
struct Branching;

impl ListCost for Branching {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        if at.t.re() < 1e3 { Everything.cost(at) } else { S::zero() }
    }
}

fn cart(links: usize, cost: impl FnOnce(&mut hamiltonian_adjoint::scenes::CartScene)) -> System {
    let mut cart = CartPendulum::with_links(links).mechanism();
    cost(&mut cart);
    cart.scene.compile().expect("a scene")
}

fn lively(system: &System, grid: Grid) -> Inputs {
    let mut inputs = Inputs::at_rest(system, grid);
    inputs.start = Start::assembled(system);
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 4.0 * (0.9 * i as f64).cos());
    inputs
}

fn jerk(sums: &[Sum]) -> System {
    cart(2, |cart| {
        let (x, scale) = (cart.cart.coordinates[0], cart.scene.design("scale", 0.3));
        let force = cart.force;
        for sum in sums {
            cart.scene.cost(&format!("{sum:?}"), Jerk, *sum, [x], [], [force], [scale.into()]);
        }
    })
}

#[test]
fn rates_of_controls_have_exact_gradients_on_all_grids() {
    let all = [Sum::Plain, Sum::Rectangle, Sum::Trapezoidal, Sum::Integral, Sum::Terminal, Sum::AllNodes];
    let uneven = Grid::new(0.1, (1..6).map(|k| 0.01 * k as f64).collect());
    let plain = Settings::default();
    for sums in [&all[..], &all[2..3], &all[3..4]] {
        let system = jerk(sums);
        for grid in
            [Grid::uniform(1, 0.02), Grid::uniform(5, 0.02), uneven.clone(), Grid::composed(2, 0.06, Composition::Suzuki4)]
        {
            for settings in [plain, Settings { scheme: Scheme::ESDIRK3, ..plain }, Settings { drift_bound: 0.0, ..plain }] {
                let error = error(&system, &lively(&system, grid.clone()), settings);
                assert!(error < 1e-12, "{sums:?} by {} on {grid:?}: {error:e}", settings.scheme.name);
            }
        }
    }
}

/// u̇².
struct Square;

impl Cost<0, 0, 1> for Square {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 1>, _b: &SVector<S, 0>) -> S {
        at.u_dot[0] * at.u_dot[0]
    }
}

#[test]
fn integrals_over_rates_of_controls_are_those_of_the_linear_pieces() {
    let value = |sum: Sum, scheme: Scheme, grid: &Grid, controls: &[f64]| {
        let system = cart(1, |cart| cart.scene.cost("change", Square, sum, [], [], [cart.force], []));
        let mut inputs = Inputs { start: Start::assembled(&system), ..Inputs::at_rest(&system, grid.clone()) };
        inputs.controls.copy_from_slice(controls);
        let mut solver = Solver::new(&system, Settings { scheme, ..Settings::default() });
        solver.simulate(&inputs).expect("a motion");
        solver.cost().expect("a value") - of_cart(&inputs, scheme)
    };
    // Steps of 0.9 and 0.1 s at rates of 0 and 10: ∫ u̇² dt = 10, and a single node sees the step that ends there.
    let grid = Grid::new(0.0, vec![0.9, 0.1]);
    for scheme in [Scheme::TRAPEZOIDAL, Scheme::TR_BDF2, Scheme::ESDIRK4, Scheme::ESDIRK5] {
        for (sum, exact) in [
            (Sum::Rectangle, 10.0),
            (Sum::Trapezoidal, 10.0),
            (Sum::Integral, 10.0),
            (Sum::Plain, 100.0),
            (Sum::AllNodes, 100.0),
            (Sum::Terminal, 100.0),
            (Sum::Node(0), 0.0),
            (Sum::Node(1), 0.0),
            (Sum::Node(2), 100.0),
        ] {
            let found = value(sum, scheme, &grid, &[2.0, 2.0, 3.0]);
            assert!((found - exact).abs() < 1e-11, "{sum:?} by {}: {found}", scheme.name);
        }
    }
}

/// What the cart's own costs add.
fn of_cart(inputs: &Inputs, scheme: Scheme) -> f64 {
    let plain = cart(1, |_| ());
    let mut solver = Solver::new(&plain, Settings { scheme, ..Settings::default() });
    solver.simulate(inputs).expect("a motion");
    solver.cost().expect("a value")
}

#[test]
fn costs_on_lists_of_any_length_have_exact_gradients() {
    for links in [1, 4] {
        for has_program in [true, false] {
            let system = cart(links, |cart| {
                let q: Vec<_> = cart.links.iter().flat_map(|link| link.coordinates).collect();
                let b: Vec<_> =
                    (0..q.len()).map(|i| cart.scene.design(&format!("weight {i}"), 0.1 + 0.05 * i as f64).into()).collect();
                let (sigma, u) = (cart.hinges[0], [cart.force]);
                if has_program {
                    cart.scene.list_cost("everything", Everything, Sum::Integral, &q, &sigma, &u, &b);
                } else {
                    cart.scene.list_cost("everything", Branching, Sum::Integral, &q, &sigma, &u, &b);
                }
            });
            let branching = [("everything", "its formula depends on a plain value (`re()`, a comparison, a branch)")];
            assert!(system.without_programs().eq(branching.into_iter().filter(|_| !has_program)));
            let inputs = lively(&system, Grid::uniform(5, 0.02));
            for settings in [Settings::default(), Settings { scheme: Scheme::ESDIRK4, ..Settings::default() }] {
                let error = error(&system, &inputs, settings);
                assert!(error < 1e-11, "{links} links, program {has_program}, {}: {error:e}", settings.scheme.name);
            }
        }
    }
}

#[test]
fn halved_steps_and_long_motions_know_the_rates_too() {
    let system = jerk(&[Sum::Integral]);
    let inputs = lively(&system, Grid::uniform(8, 0.02));
    let ours = gradient(&system, &inputs, Settings::default()).expect("a gradient");
    let mut long = LongSolver::new(&system, Settings::default(), 20_000);
    assert_eq!(long.gradient(&inputs).expect("a gradient"), &ours);
    // Few iterations want halved steps; the controls are the same functions of time.
    let few = Settings { max_iterations: 3, ..Settings::default() };
    let mut coarse = lively(&system, Grid::uniform(3, 0.35));
    coarse.controls *= 20.0;
    let mut solver = Solver::new(&system, few);
    solver.simulate(&coarse).expect("a motion");
    assert!(!solver.trajectory().inserted.is_empty(), "no step was halved");
    let error = error(&system, &coarse, few);
    assert!(error < 1e-11, "{error:e}");
}

#[test]
fn the_checks_and_the_papers_equations_agree() {
    let system = jerk(&[Sum::Trapezoidal, Sum::Plain]);
    let inputs = lively(&system, Grid::uniform(6, 0.02));
    let report = check::gradient(&system, &inputs, Settings::default()).run().expect("a report");
    assert!(report.passed(), "{report}");
    let ours = gradient(&system, &inputs, Settings::default()).expect("a gradient");
    let mut solver = Solver::new(&system, Settings::default());
    let motion = solver.simulate(&inputs).expect("a motion").clone();
    let taken = solver.inputs();
    let paper = PaperSystem::new(&system, taken, &motion).expect("a motion").gradient().expect("a gradient");
    assert!((paper.controls - &ours.controls).amax() < 1e-9 * ours.controls.amax());
}

#[test]
fn hand_derived_derivatives_by_rates_are_checked() {
    let right = check::cost(&Jerk, [0.3]).h_u_dot(|at| [at.b[0] * (2.0 * at.u_dot[0] + at.u[0] * at.q[0])]).run();
    assert!(right.passed(), "{right}");
    let wrong = check::cost(&Jerk, [0.3]).h_u_dot(|at| [at.b[0] * (2.0 * at.u_dot[0] - at.u[0] * at.q[0])]).run();
    assert!(!wrong.passed());
}
