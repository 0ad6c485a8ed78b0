//! Accelerations and reactions as arguments of costs: exact derivatives, whatever the element, the scheme and what happens on the way.

use super::{elements, error, list, ready_parts, seven_bodies, varying};
use crate::common::{assert_says, largest};
use hamiltonian_adjoint::check::{self, Input, Part};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Cost, CostPoint, Force, ForcePoint, Grid, Hyper, Inputs, KineticEnergy, LiftedSolver, LongSolver, Mechanics,
    PotentialEnergy, Scalar, Scene, Scheme, Settings, Solver, Start, Sum, System, gradient, simulate,
};
use nalgebra::{DVector, SVector};

/// ½ |v̇|² + λ₀² + λ₁ q₀, times b.
struct Felt;

impl<const N: usize> Cost<N, 2, 0, 1> for Felt {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, N, 2, 0>, b: &SVector<S, 1>) -> S {
        (at.v_dot.dot(&at.v_dot) * 0.5 + at.lambda[0] * at.lambda[0] + at.lambda[1] * at.q[0]) * b[0]
    }
}

/// The same of accelerations alone; a formula that looks at values.
struct Looking;

impl Cost<2> for Looking {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, _b: &SVector<S, 0>) -> S {
        if at.v[0].re() > 0.1 { at.v_dot[0] * at.v_dot[1] } else { at.v_dot[0] * at.q[1] }
    }
}

fn lively(system: &System) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(6, 0.02));
    inputs.start = Start::assembled(system);
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 1.5 * (0.9 * i as f64).cos());
    inputs
}

fn ways() -> [Settings; 4] {
    let plain = Settings::default();
    [
        plain,
        Settings { scheme: Scheme::ESDIRK4, ..plain },
        Settings { drift_bound: 0.0, ..plain },
        Settings { rebase_every: 3, ..plain },
    ]
}

#[test]
fn costs_on_them_have_exact_gradients_whatever_the_element() {
    let mut worst = 0.0f64;
    for kind in elements::kinds().into_iter().chain(ready_parts::kinds()) {
        for with_programs in [true, false] {
            let scene = elements::with(kind, |arms| {
                let [x, _, phi] = arms.lower.coordinates;
                let scale = arms.scene.design("scale", 0.1);
                arms.scene.cost("felt", Felt, Sum::Trapezoidal, [x, phi], arms.shoulder, [], [scale.into()]);
            });
            let system = if with_programs { scene.compile() } else { scene.compile_without_programs() }.expect("a scene");
            let error = error(&system, &lively(&system), Settings::default());
            worst = worst.max(error);
            assert!(error < 1e-11, "{} with programs {with_programs}: {error:e}", kind.0);
        }
    }
    println!("largest error {worst:.1e}");
}

/// A product of the Hessian with a direction against extrapolated differences of gradients, and its asymmetry, both relative to the terms.
fn error_of_product(system: &System, inputs: &Inputs, settings: Settings) -> [f64; 2] {
    let direction = |seed: usize| {
        let mut direction = inputs.no_change();
        for (k, input) in Input::all(inputs).into_iter().enumerate() {
            let size = if matches!(input, Input::Step(_)) { 2e-3 } else { 0.1 };
            *input.of(&mut direction) = size * ((seed + 3 * k) as f64).sin();
        }
        direction
    };
    let (a, b) = (direction(1), direction(500));
    let along = |gradient: &hamiltonian_adjoint::Gradient, direction: &Inputs| {
        let mut own = direction.clone();
        let terms = Input::all(inputs).into_iter().map(|input| input.in_gradient(gradient) * *input.of(&mut own));
        terms.fold([0.0, 0.0], |[sum, size], term: f64| [sum + term, size + term.abs()])
    };
    let mut solver = Solver::new(system, settings);
    solver.simulate(inputs).expect("a motion");
    let of_a = solver.hessian_product(&a).expect("a product").clone();
    let of_b = solver.hessian_product(&b).expect("a product").clone();
    let ([ab, size], [ba, _]) = (along(&of_a, &b), along(&of_b, &a));
    let mut slope = |step: f64| {
        let mut moved = inputs.clone();
        let mut a = a.clone();
        Input::all(inputs).into_iter().for_each(|input| *input.of(&mut moved) += step * *input.of(&mut a));
        solver.simulate(&moved).expect("a motion");
        along(solver.gradient().expect("a gradient"), &b)[0]
    };
    let [far, near] = [8e-3, 4e-3].map(|step| (slope(step) - slope(-step)) / (2.0 * step));
    let expected = near + (near - far) / 3.0;
    [(ab - expected).abs() / size, (ab - ba).abs() / size]
}

#[test]
fn products_of_costs_on_them_are_exact_whatever_the_element() {
    let mut worst = [0.0f64; 2];
    for kind in elements::kinds().into_iter().chain(ready_parts::kinds()) {
        let build = || {
            elements::with(kind, |arms| {
                let [x, _, phi] = arms.lower.coordinates;
                let scale = arms.scene.design("scale", 0.1);
                arms.scene.cost("felt", Felt, Sum::Integral, [x, phi], arms.shoulder, [], [scale * scale]);
                arms.scene.cost("end", Felt, Sum::Terminal, [phi], arms.shoulder, [], [scale.into()]);
            })
        };
        for with_programs in [true, false] {
            let scene = build();
            let system = if with_programs { scene.compile() } else { scene.compile_without_programs() }.expect("a scene");
            let inputs = lively(&system);
            for settings in ways().into_iter().take(if with_programs { 4 } else { 1 }) {
                let errors = error_of_product(&system, &inputs, settings);
                let name = settings.scheme.name;
                assert!(errors[0] < 1e-6 && errors[1] < 1e-11, "{}, {name}, programs {with_programs}: {errors:?}", kind.0);
                worst = [0, 1].map(|k| worst[k].max(errors[k]));
            }
        }
    }
    println!("against differences {:.1e}, asymmetry {:.1e}", worst[0], worst[1]);
}

/// A formula that branches: one energy beyond a place, another one before it.
struct Buffer;

impl PotentialEnergy<1, 2> for Buffer {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, b: &SVector<S, 2>, _t: S) -> S {
        let gap = q[0] + 0.72;
        if gap.re() < 0.0 { gap.powi(4) * b[0] * 37.3 + gap.cos() * b[1] } else { gap.powi(2).exp() * b[0] + gap * 0.7 }
    }
}

#[test]
fn products_know_every_branch_of_a_formula() {
    let kind = elements::kinds().into_iter().next().expect("an element");
    let scene = elements::with(kind, |arms| {
        let [x, _, phi] = arms.lower.coordinates;
        let (scale, stiffness) = (arms.scene.design("scale", 0.1), arms.scene.design("stiffness", 0.8));
        arms.scene.potential_energy("buffer", Buffer, [phi], [stiffness * 2.0, scale.into()]);
        arms.scene.cost("felt", Felt, Sum::Integral, [x, phi], arms.shoulder, [], [scale.into()]);
    });
    let system = scene.compile().expect("a scene");
    assert!(system.without_programs().any(|(name, _)| name == "buffer"));
    let inputs = lively(&system);
    let trajectory = simulate(&system, &inputs, Settings::default()).expect("a motion");
    let turns = trajectory.q.row(trajectory.q.nrows() - 1);
    assert!(turns.min() < -0.72 && turns.max() > -0.72, "the motion stays on one branch: {turns}");
    for settings in ways() {
        let errors = error_of_product(&system, &inputs, settings);
        assert!(errors[0] < 1e-6 && errors[1] < 1e-11, "{}: {errors:?}", settings.scheme.name);
    }
}

/// A double pendulum with design variables, of whose reactions there is an integral, a sum and an end.
fn double_pendulum() -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let (m, l) = (scene.design("mass", 0.8), scene.design("length", 0.9));
    let upper = scene.body("upper", m, m * l * l / 12.0, [0.45, 0.0, 0.0]);
    let lower = scene.body("lower", 0.7, 0.05, [1.0, -0.4, -1.2]);
    scene.revolute("shoulder", Body::GROUND.at(0.0, 0.0), upper.at(l * -0.5, 0.0));
    let elbow = scene.revolute("elbow", upper.at(l * 0.5, 0.0), lower.at(-0.45, 0.0));
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, upper, torque);
    let q = lower.coordinates;
    for (name, sum) in [("integral", Sum::Integral), ("sum", Sum::Plain), ("end", Sum::Terminal), ("steps", Sum::Rectangle)]
    {
        scene.cost(name, Felt, sum, q, elbow, [], [l * 0.1]);
    }
    scene.compile().expect("a scene")
}

#[test]
fn they_go_with_schemes_restarts_and_projections() {
    let mut bead = varying::bead();
    let [x, y] = bead.1;
    bead.0.cost("looking", Looking, Sum::Trapezoidal, [x, y], [], [], []);
    let system = bead.0.compile().expect("a scene");
    for settings in ways() {
        // Energy that is linear in the velocities goes with neither restarts nor projections.
        let is_plain = settings.rebase_every == Settings::default().rebase_every && settings.drift_bound != 0.0;
        for (name, system) in
            [("double pendulum", &double_pendulum()), ("bead", &system)].into_iter().take(1 + usize::from(is_plain))
        {
            let error = error(system, &lively(system), settings);
            assert!(error < 1e-11, "{name} by {}: {error:e}", settings.scheme.name);
        }
    }
}

#[test]
fn hyper_dual_numbers_say_that_they_know_none_of_them() {
    let (mut scene, [x, y]) = varying::bead();
    scene.cost("looking", Looking, Sum::Trapezoidal, [x, y], [], [], []);
    let system = scene.compile().expect("a scene");
    let inputs = lively(&system);
    let mut solver = LiftedSolver::<Hyper>::new(&system, &inputs, Settings::default()).expect("a motion");
    let done = solver.simulate(&inputs.lift()).map(|_| ());
    let refused = done.and_then(|()| solver.cost()).expect_err("no such numbers");
    assert_says(&refused, &["hyper-dual", "accelerations or reactions", "`Solver::hessian_product`", "`check::hessian`"]);
}

/// A product that is wrong in the eighth digit is told.
#[test]
fn products_of_costs_on_them_are_held_to_differences_of_gradients() {
    let (mut scene, [x, y]) = varying::bead();
    scene.cost("looking", Looking, Sum::Trapezoidal, [x, y], [], [], []);
    for system in [scene.compile().expect("a scene"), double_pendulum()] {
        let inputs = lively(&system);
        let mut along = inputs.no_change();
        along.start.q_mut()[0] = 1.0;
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&inputs).expect("a motion");
        let product = solver.hessian_product(&along).expect("a product").start.q().clone();
        let check = |factor: f64| {
            let check = check::hessian(&system, &inputs, Settings::default());
            let values = product.iter().map(|x| factor * x).collect::<Vec<f64>>();
            check.own("mine", Part::Coordinates, along.clone(), values).run().expect("a report")
        };
        let report = check(1.0);
        println!("{report}");
        report.assert_passed();
        assert!(report.by_differences && report.to_string().contains("by differences"));
        let most = report.rows.iter().map(|row| row.error()).fold(0.0, f64::max);
        assert!(most < 1e-10 && report.rows.iter().all(|row| row.uncertainty > 0.0), "{most:e}");
        assert!(!check(1.0 + 1e-8).passed());
    }
}

#[test]
fn a_long_motion_gives_the_same_gradient() {
    let system = double_pendulum();
    let inputs = lively(&system);
    let ours = gradient(&system, &inputs, Settings::default()).expect("a gradient");
    let mut long = LongSolver::new(&system, Settings::default(), 20_000);
    assert_eq!(long.gradient(&inputs).expect("a gradient"), &ours);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("a motion");
    assert!((solver.cost().expect("a cost") - ours.value).abs() < 1e-13 * ours.value.abs());
}

/// λ and ẍ of a particle on a rod: as they are given, or by hand, b = [m, l].
struct Rod {
    by_hand: bool,
}

impl Cost<2, 1, 0, 2> for Rod {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 1, 0>, b: &SVector<S, 2>) -> S {
        let (q, v) = (&at.q, &at.v);
        let by_hand = (q[1] * -9.81 + v.dot(v)) * b[0] * b[1] / q.dot(q);
        let lambda = if self.by_hand { by_hand } else { at.lambda[0] };
        let x_dot_dot = if self.by_hand { -(q[0] * by_hand / (b[0] * b[1])) } else { at.v_dot[0] };
        lambda * lambda + x_dot_dot * x_dot_dot * x_dot_dot
    }
}

#[test]
fn a_cost_on_them_is_that_of_their_closed_form() {
    let of = |by_hand: bool| {
        let mut scene = Scene::new();
        scene.gravity(0.0, -9.81);
        let (m, l) = (scene.design("mass", 1.3), scene.design("length", 0.7));
        let bob = scene.particle("bob", m, [0.3, -0.6]);
        let rod = scene.distance("rod", Body::GROUND.at(0.0, 0.0), bob.point(), l);
        scene.cost("pull", Rod { by_hand }, Sum::Integral, bob.coordinates, rod, [], [m.into(), l.into()]);
        let system = scene.compile().expect("a scene");
        let mut inputs = lively(&system);
        inputs.start.set_rate(bob.coordinates[0], 1.4);
        let all = Input::all(&inputs);
        let gradient = gradient(&system, &inputs, Settings::default()).expect("a gradient");
        (gradient.value, list(&all, &gradient))
    };
    let ((value, ours), (expected, by_hand)) = (of(false), of(true));
    assert!((value - expected).abs() < 1e-13 * expected.abs());
    let differences: Vec<f64> = ours.iter().zip(&by_hand).map(|(a, b)| a - b).collect();
    assert!(largest(&differences) < 1e-12 * largest(&by_hand), "{differences:?}");
}

#[test]
fn reactions_of_seven_bodies_converge_with_the_order_of_the_scheme() {
    let system = seven_bodies::whole().compile().expect("a scene");
    let end = 0.004;
    let reactions = |scheme: Scheme, steps: usize| -> DVector<f64> {
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, end / steps as f64));
        inputs.controls.fill(0.033);
        let motion = simulate(&system, &inputs, Settings { scheme, ..Settings::default() }).expect("a motion");
        let at = Mechanics::at_node(&system, &inputs, &motion, steps).expect("a node");
        at.accelerations().expect("reactions").1
    };
    let exact = reactions(Scheme::ESDIRK5, 640);
    for (scheme, order) in [(Scheme::TRAPEZOIDAL, 2.0), (Scheme::ESDIRK3, 3.0), (Scheme::ESDIRK4, 4.0)] {
        let error = |steps| (reactions(scheme, steps) - &exact).amax();
        let observed = (error(40) / error(80)).log2();
        assert!((observed - order).abs() < 0.35, "{}: {observed}", scheme.name);
    }
}

#[test]
fn reactions_that_others_may_take_over_are_refused_and_accelerations_are_not() {
    let of = |hinges: usize, on_reaction: bool| {
        let mut scene = Scene::new();
        scene.gravity(0.0, -9.81);
        let arm = scene.body("arm", 1.0, 0.1, [0.5, 0.0, 0.0]);
        let all: Vec<_> = (0..hinges)
            .map(|k| scene.revolute(&format!("hinge {k}"), Body::GROUND.at(0.0, 0.0), arm.at(-0.5, 0.0)))
            .collect();
        let [x, y, _] = arm.coordinates;
        if on_reaction {
            scene.cost("felt", Felt, Sum::Plain, [x, y], all[0], [], [1.0.into()]);
        } else {
            scene.cost("felt", Looking, Sum::Plain, [x, y], [], [], []);
        }
        let system = scene.compile().expect("a scene");
        gradient(&system, &Inputs::at_rest(&system, Grid::uniform(5, 0.02)), Settings::default())
    };
    let (one, two) = (of(1, false).expect("a gradient"), of(2, false).expect("a gradient"));
    assert!((one.value - two.value).abs() < 1e-7 * one.value.abs());
    assert!((one.start.q() - two.start.q()).amax() < 1e-6 * one.start.q().amax());
    of(1, true).expect("a gradient");
    assert_says(&of(2, true).expect_err("a reaction of two hinges"), &["λ", "hinge", "not unique"]);
}

/// T = ½ (ẋ² + x² ẏ²), without mass along y where x = 0, and a brake.
struct Vanishing;

impl KineticEnergy<2> for Vanishing {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, _b: &SVector<S, 0>) -> S {
        (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]) * 0.5
    }
}

struct Brake;

impl Force<2> for Brake {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, _b: &SVector<S, 0>) -> SVector<S, 2> {
        SVector::from([S::zero(), -at.v[1]])
    }
}

#[test]
fn a_gradient_says_why_they_are_missing_as_the_cost_does() {
    let mut scene = Scene::new();
    let q = scene.coordinates("bead", ["x", "y"]);
    scene.kinetic_energy("mass", Vanishing, q, []);
    scene.force("brake", Brake, q, [], []);
    scene.cost("looking", Looking, Sum::Trapezoidal, q, [], [], []);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.25));
    inputs.start = Start::Velocity { q: DVector::from_vec(vec![-0.5, 0.0]), v: DVector::from_vec(vec![1.0, 0.0]) };
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("a motion");
    let reason = solver.cost().expect_err("no mass");
    assert_says(&reason, &["t = 0.5 s", "mass matrix", "bead.y"]);
    assert_eq!(solver.gradient().map(|gradient| gradient.value).expect_err("no mass"), reason);
}
