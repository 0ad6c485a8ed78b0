//! Several outputs of one motion: values, Jacobian, weighted pull-back and push-forward, beside J.

use crate::common::{assert_says, largest};
use hamiltonian_adjoint::check::{self, Input, Part};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{
    Composition, Cost, CostPoint, Cx, Error, Gradient, Grid, Inputs, LiftedSolver, LongSolver, Scalar, Scene, Scheme,
    Settings, Solver, Start, Sum, System, gradient,
};
use nalgebra::SVector;
use num_dual::Dual64;

/// q₀ − b.
struct Miss;

impl Cost<1, 0, 0, 1> for Miss {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        at.q[0] - b[0]
    }
}

/// v⁸, for a soft peak of a speed.
struct Eighth;

impl Cost<1> for Eighth {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.v[0].powi(8)
    }
}

/// A double pendulum with a motor; J and three outputs, one of them with two terms.
fn scene(with_outputs: bool) -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let (m, l) = (scene.design("mass", 0.8), scene.design("length", 0.9));
    let upper = scene.body("upper", m, m * l * l / 12.0, [0.45, 0.0, 0.0]);
    let lower = scene.body("lower", 0.7, 0.05, [1.0, -0.4, -1.2]);
    scene.revolute("shoulder", Body::GROUND.at(0.0, 0.0), upper.at(l * -0.5, 0.0));
    scene.revolute("elbow", upper.at(l * 0.5, 0.0), lower.at(-0.45, 0.0));
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, upper, torque);
    let ([.., upper], [x, _, lower]) = (upper.coordinates, lower.coordinates);
    scene.cost("J", AngleError, Sum::Terminal, [lower], [], [], [0.3.into()]);
    if with_outputs {
        let [reach, peak, mixed] = ["reach", "peak", "mixed"].map(|name| scene.output(name));
        scene.term(reach, "reach", Miss, Sum::Terminal, [x], [], [], [l.into()]);
        scene.term(peak, "peak", Eighth, Sum::Integral, [upper], [], [], []);
        scene.term(mixed, "angle", AngleError, Sum::Trapezoidal, [upper], [], [], [m * 0.1]);
        scene.term(mixed, "end", Miss, Sum::Plain, [lower], [], [], [0.2.into()]);
    }
    scene.compile().expect("a scene")
}

fn inputs(system: &System) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(12, 0.03));
    inputs.start = Start::assembled(system);
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 2.0 * (0.4 * i as f64).sin());
    inputs
}

fn list(all: &[Input], gradient: &Gradient) -> Vec<f64> {
    all.iter().map(|input| input.in_gradient(gradient)).collect()
}

#[test]
fn the_jacobian_is_that_of_complex_step_for_all_inputs() {
    let system = scene(true);
    let inputs = inputs(&system);
    let plain = Settings::default();
    for settings in [
        plain,
        Settings { scheme: Scheme::ESDIRK4, ..plain },
        Settings { drift_bound: 0.0, ..plain },
        Settings { rebase_every: 4, ..plain },
    ] {
        let mut solver = Solver::new(&system, settings);
        solver.simulate(&inputs).expect("a motion");
        let (values, jacobian) = (solver.outputs().expect("values"), solver.jacobian().expect("a Jacobian"));
        let all = Input::all(&inputs);
        let mut lifted = LiftedSolver::<Cx>::new(&system, &inputs, settings).expect("a motion");
        let mut reference = vec![Vec::new(); 3];
        for input in &all {
            let mut moved = inputs.lift::<Cx>();
            *input.of(&mut moved) += Cx::new(0.0, 1e-30);
            lifted.simulate(&moved).expect("the same motion");
            let outputs = lifted.outputs().expect("outputs");
            reference.iter_mut().zip(outputs.iter()).for_each(|(row, output)| row.push(output.0.im / 1e-30));
        }
        for (k, (row, reference)) in jacobian.iter().zip(&reference).enumerate() {
            assert!((row.value - values[k]).abs() < 1e-13 * values[k].abs());
            let differences: Vec<f64> = list(&all, row).iter().zip(reference).map(|(a, b)| a - b).collect();
            let name = system.output_name(k);
            assert!(
                largest(&differences) < 1e-12 * largest(reference),
                "{name} by {}: {:e}",
                settings.scheme.name,
                largest(&differences)
            );
        }
    }
}

#[test]
fn pulled_back_weights_are_sums_of_rows_and_meet_the_push_forward() {
    let system = scene(true);
    let inputs = inputs(&system);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("a motion");
    let (jacobian, all, w) = (solver.jacobian().expect("a Jacobian"), Input::all(&inputs), [0.7, -1.3, 0.4]);
    let pulled = solver.pull_back(&w).expect("a gradient").clone();
    let rows: Vec<Vec<f64>> = jacobian.iter().map(|row| list(&all, row)).collect();
    let sum: Vec<f64> = (0..all.len()).map(|i| (0..3).map(|k| w[k] * rows[k][i]).sum()).collect();
    let differences: Vec<f64> = list(&all, &pulled).iter().zip(&sum).map(|(a, b)| a - b).collect();
    assert!(largest(&differences) < 1e-13 * largest(&sum));
    let values = solver.outputs().expect("values");
    let terms: Vec<f64> = (0..3).map(|k| w[k] * values[k]).collect();
    assert!((pulled.value - terms.iter().sum::<f64>()).abs() < 1e-14 * largest(&terms), "{} {terms:?}", pulled.value);

    // wᵀ (∂r d) = ((∂r)ᵀ w) d.
    let direction: Vec<f64> = (0..all.len()).map(|i| (1.7 * i as f64).sin()).collect();
    let mut moved = inputs.lift::<Dual64>();
    all.iter().zip(&direction).for_each(|(input, d)| input.of(&mut moved).eps = *d);
    let mut lifted = LiftedSolver::<Dual64>::new(&system, &inputs, Settings::default()).expect("a motion");
    lifted.simulate(&moved).expect("the same motion");
    let pushed: f64 = lifted.outputs().expect("outputs").iter().zip(w).map(|(output, w)| w * output.eps).sum();
    let paired: f64 = sum.iter().zip(&direction).map(|(a, d)| a * d).sum();
    assert!((pushed - paired).abs() < 1e-12 * paired.abs(), "{pushed} and {paired}");
}

/// Rows side by side share the factors of each node with each other, and with nothing else.
#[test]
fn rows_side_by_side_are_those_of_sweeps_alone() {
    let system = scene(true);
    let uniform = inputs(&system);
    let composed = Inputs {
        grid: Grid::composed(4, 0.09, Composition::Suzuki4),
        ..Inputs { start: Start::assembled(&system), ..Inputs::at_rest(&system, Grid::uniform(20, 0.1)) }
    };
    let mut halved = uniform.clone();
    halved.grid.steps[5] = 0.9;
    let plain = Settings::default();
    for (inputs, settings) in [
        (&uniform, plain),
        (&uniform, Settings { scheme: Scheme::ESDIRK4, ..plain }),
        (&uniform, Settings { scheme: Scheme::TR_BDF2, drift_bound: 0.0, ..plain }),
        (&uniform, Settings { drift_bound: 0.0, rebase_every: 3, ..plain }),
        (&composed, plain),
        (&composed, Settings { rebase_every: 1, ..plain }),
        (&halved, Settings { max_iterations: 4, ..plain }),
    ] {
        let mut solver = Solver::new(&system, settings);
        solver.simulate(inputs).expect("a motion");
        assert_eq!(solver.trajectory().inserted.is_empty(), inputs.grid.steps[5] != 0.9);
        let (before, rows) = (solver.gradient().expect("a gradient").clone(), solver.jacobian().expect("a Jacobian"));
        let all = Input::all(inputs);
        for (k, row) in rows.iter().enumerate() {
            let mut weights = [0.0; 3];
            weights[k] = 1.0;
            let alone = solver.pull_back(&weights).expect("a gradient").clone();
            let differences: Vec<f64> = list(&all, row).iter().zip(list(&all, &alone)).map(|(a, b)| a - b).collect();
            assert!(largest(&differences) <= 1e-13 * largest(&list(&all, &alone)), "{k}: {:e}", largest(&differences));
            assert_eq!((row.value, &row.warnings), (alone.value, &alone.warnings));
            let mut long = LongSolver::new(&system, settings, 60_000);
            assert_eq!(long.weighted_gradient(inputs, 0.0, &weights).expect("a gradient"), &alone);
        }
        assert_eq!(&before, solver.gradient().expect("a gradient"));
        let mut long = LongSolver::new(&system, settings, 60_000);
        assert_eq!(long.jacobian(inputs).expect("a Jacobian"), rows);
        assert_eq!(long.gradient(inputs).expect("a gradient"), &before);
        assert_says(&long.weighted_gradient(inputs, f64::NAN, &[0.0; 3]).expect_err("NaN"), &["weight of the cost"]);
    }
}

/// What comes behind the last node that a cost depends on is not gone through.
#[test]
fn a_sweep_begins_where_its_cost_does() {
    let mut cart = CartPendulum::with_links(2).mechanism();
    let q = cart.links[0].coordinates[2];
    let [early, late] = ["early", "late"].map(|name| cart.scene.output(name));
    cart.scene.term(early, "early", AngleError, Sum::Node(4), [q], [], [], [0.3.into()]);
    cart.scene.term(late, "late", AngleError, Sum::Node(15), [q], [], [], [0.3.into()]);
    let system = cart.scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
    inputs.controls.fill(3.0);
    for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK4] {
        let mut solver = Solver::new(&system, Settings { scheme, ..Settings::default() });
        solver.simulate(&inputs).expect("a motion");
        let stages = scheme.rows.len();
        let mut factorisations = |weights: &[f64]| {
            solver.pull_back(weights).expect("a gradient");
            solver.adjoint_report().factorisations
        };
        let each = [factorisations(&[1.0, 0.0]), factorisations(&[0.0, 1.0]), factorisations(&[0.0, 0.0])];
        assert_eq!(each, [4 * stages + 1, 15 * stages + 1, 0]);
        let rows = solver.jacobian().expect("a Jacobian");
        assert_eq!(solver.adjoint_report().factorisations, 15 * stages + 1, "side by side");
        assert!(rows[0].controls.columns(5, 16).amax() == 0.0 && rows[0].controls.columns(0, 5).amin() != 0.0);
        // Their products are those of complete sweeps: a second derivative may be where the first one vanishes.
        let mut direction = inputs.no_change();
        direction.controls.fill(1.0);
        solver.pull_back(&[1.0, 0.0]).expect("a gradient");
        let product = solver.hessian_product(&direction).expect("a product").controls.clone();
        let again = solver.hessian_product(&direction).expect("a product");
        assert!(product == again.controls && product.amax() > 0.0);
    }
}

#[test]
fn their_gradients_and_products_are_checked() {
    let mut cart = CartPendulum::with_links(2).mechanism();
    let b = cart.scene.design("b", 0.4);
    let outputs = [Sum::Terminal, Sum::Integral, Sum::Node(4)].map(|sum| {
        let name = format!("{sum:?}");
        let output = cart.scene.output(&name);
        cart.scene.term(output, &name, AngleError, sum, [cart.links[1].coordinates[2]], [], [], [b * 1.5]);
        output
    });
    let system = cart.scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.04));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 3.0 * (i as f64).cos());
    for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK3] {
        let settings = Settings { scheme, ..Settings::default() };
        for (k, output) in outputs.into_iter().enumerate() {
            let report = check::gradient(&system, &inputs, settings).output(output).complete().run().expect("a report");
            report.assert_passed();
            assert!(report.of == format!("output `{}`", system.output_name(k)) && report.to_string().contains(&report.of));
            check::hessian(&system, &inputs, settings).output(output).run().expect("a report").assert_passed();
            let own = check::gradient(&system, &inputs, settings).output(output).own("none", Part::Design, [0.0]);
            assert!(!own.run().expect("a report").passed(), "a wrong gradient of one's own is seen");
        }
    }
    let (mut push, settings) = (inputs.no_change(), Settings::default());
    push.controls.fill(1.0);
    let sensitivity = check::direct_differentiation(&system, &inputs, settings, &push).expect("derivatives");
    let mut solver = Solver::new(&system, settings);
    solver.simulate(&inputs).expect("a motion");
    for (row, along) in solver.jacobian().expect("a Jacobian").iter().zip(sensitivity.outputs.iter()) {
        assert!((row.controls.sum() - along).abs() < 1e-12 * row.controls.iter().map(|x| x.abs()).sum::<f64>());
    }
    let mut other = Scene::new();
    for (k, foreign) in [(); 4].map(|()| other.output("foreign")).into_iter().enumerate() {
        let error = check::gradient(&system, &inputs, settings).output(foreign).run().expect_err("no such output");
        assert_says(&error, &["output", &k.to_string(), "this system"]);
    }
}

#[test]
fn j_knows_nothing_of_them() {
    let (with, without) = (scene(true), scene(false));
    let inputs = inputs(&with);
    let ours = gradient(&with, &inputs, Settings::default()).expect("a gradient");
    let plain = gradient(&without, &inputs, Settings::default()).expect("a gradient");
    assert_eq!(
        (ours.value, &ours.controls, &ours.design, &ours.steps),
        (plain.value, &plain.controls, &plain.design, &plain.steps)
    );
    let mut solver = Solver::new(&with, Settings::default());
    solver.simulate(&inputs).expect("a motion");
    solver.jacobian().expect("a Jacobian");
    assert_eq!(solver.gradient().expect("a gradient"), &ours, "also after a Jacobian");
    let mut long = LongSolver::new(&with, Settings::default(), 30_000);
    assert_eq!(long.gradient(&inputs).expect("a gradient").value, ours.value);
    assert_eq!(Solver::new(&without, Settings::default()).jacobian().expect("nothing asked").len(), 0);
}

#[test]
fn what_is_wrong_is_named() {
    let system = scene(true);
    let inputs = inputs(&system);
    let mut solver = Solver::new(&system, Settings::default());
    assert!(matches!(solver.outputs(), Err(Error::Incomplete { .. })));
    solver.simulate(&inputs).expect("a motion");
    assert_says(&solver.pull_back(&[1.0]).expect_err("too few"), &["weights of the outputs", "expected 3", "found 1"]);
    assert_says(&solver.pull_back(&[1.0, f64::NAN, 0.0]).expect_err("no number"), &["peak", "NaN"]);
    let (mut scene, mut other) = (Scene::new(), Scene::new());
    let body = scene.body("body", 1.0, 0.1, [0.0; 3]);
    let foreign = other.output("foreign");
    scene.term(foreign, "term", Miss, Sum::Terminal, [body.coordinates[0]], [], [], [0.0.into()]);
    assert_says(&scene.compile().expect_err("a foreign output"), &["term", "output"]);
}
