//! Constraints that depend on each other, and configurations where they lose rank.

use crate::common::bench::number;
use crate::common::{assert_says, largest, largest_difference, relative_error};
use crate::scenes::by_hand::SameAbscissa;
use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::planar::{Body, Frame, Harmonic, Motion};
use hamiltonian_adjoint::{
    Composition, Constraint, Control, Cost, CostPoint, Error, Grid, Inputs, Multiplier, Param, Scalar, Scene, Settings,
    Solver, Start, Sum, System, Trajectory, Warning, simulate,
};
use nalgebra::SVector;
use std::f64::consts::{FRAC_PI_2, PI};

/// A function of the place and speed of a body and of the control.
struct Place;
impl Cost<3, 0, 1> for Place {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 0, 1>, _b: &SVector<S, 0>) -> S {
        at.q[0].sin() + at.q[1] * at.q[1] + at.q[2].cos() * 0.3 + at.v[2] * at.v[2] * 0.1 + at.u[0] * at.u[0] * 0.05
    }
}

/// b₀ + b₁ t.
struct Ramp;
impl Motion<2> for Ramp {
    fn value<S: Scalar>(&self, t: S, b: &SVector<S, 2>) -> S {
        b[0] + b[1] * t
    }
}

/// A scene under gravity with a torque on its first body.
struct Mechanism {
    scene: Scene,
    torque: Control,
    bodies: Vec<Body>,
    hinges: usize,
}

impl Mechanism {
    fn new() -> Self {
        let mut scene = Scene::new();
        scene.gravity(0.0, -9.81);
        let torque = scene.control("torque");
        Mechanism { scene, torque, bodies: Vec::new(), hinges: 0 }
    }

    fn rod(&mut self, from: [f64; 2], to: [f64; 2]) -> usize {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let place = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]), dy.atan2(dx)];
        let k = self.bodies.len();
        let body = self.scene.body(&format!("rod {k}"), 1.0 + 0.2 * k as f64, 0.08 + 0.02 * k as f64, place);
        self.bodies.push(body);
        k
    }

    fn frame(&self, rod: Option<usize>) -> Frame {
        rod.map_or(Body::GROUND, |k| self.bodies[k].into())
    }

    /// One of the two equations of a hinge.
    fn half_hinge(&mut self, a: usize, b: usize, at: [f64; 2]) {
        let [[xa, ya], [xb, yb]] = [a, b].map(|rod| self.scene.local(self.bodies[rod], at));
        let ([x, y, phi], q) = (self.bodies[a].coordinates, self.bodies[b].coordinates);
        let constants = [xa.into(), ya.into(), xb.into(), yb.into()];
        self.scene.constraint("half a hinge", SameAbscissa, [x, y, phi, q[0], q[1], q[2]], constants);
    }

    fn hinge(&mut self, a: Option<usize>, b: usize, at: [f64; 2]) -> [Multiplier; 2] {
        let [a, b] = [a, Some(b)].map(|rod| self.scene.at_world(self.frame(rod), at[0], at[1]));
        self.hinges += 1;
        self.scene.revolute(&format!("hinge {}", self.hinges), a, b)
    }

    fn compile(mut self) -> System {
        let first = self.bodies[0];
        self.scene.torque_actuator("motor", Body::GROUND, first, self.torque);
        for (k, body) in self.bodies.iter().enumerate() {
            self.scene.cost(&format!("place {k}"), Place, Sum::Trapezoidal, body.coordinates, [], [self.torque], []);
        }
        self.scene.compile().expect("scene")
    }
}

/// A double pendulum; the hinge of its first rod, or its elbow, is there more than once.
fn pendulum(hinges: usize, elbows: usize) -> System {
    let mut mechanism = Mechanism::new();
    let (upper, lower) = (mechanism.rod([0.0, 0.0], [1.0, 0.0]), mechanism.rod([1.0, 0.0], [1.0, 1.0]));
    (0..hinges).for_each(|_| _ = mechanism.hinge(None, upper, [0.0, 0.0]));
    (0..elbows).for_each(|_| _ = mechanism.hinge(Some(upper), lower, [1.0, 0.0]));
    mechanism.compile()
}

/// A platform on parallel cranks of equal length at this angle; the last is joined to it by a hinge or, without redundancy, by half of one.
fn parallelogram(cranks: usize, angle: f64, redundant: bool) -> System {
    on_cranks(cranks, angle, redundant).0.compile()
}

/// The same, to be added to, and a multiplier of the foot of the first crank.
fn on_cranks(cranks: usize, angle: f64, redundant: bool) -> (Mechanism, Multiplier) {
    let mut mechanism = Mechanism::new();
    let (sin, cos) = angle.sin_cos();
    let feet = [0.0, 1.5, 0.6, 1.1];
    let rods: Vec<usize> = feet[..cranks].iter().map(|&x| mechanism.rod([x, 0.0], [x + 0.7 * cos, 0.7 * sin])).collect();
    let platform = mechanism.rod([0.7 * cos, 0.7 * sin], [1.5 + 0.7 * cos, 0.7 * sin]);
    let mut foot = None;
    for (k, (&rod, x)) in rods.iter().zip(feet).enumerate() {
        let sigma = mechanism.hinge(None, rod, [x, 0.0]);
        foot.get_or_insert(sigma[0]);
        let top = [x + 0.7 * cos, 0.7 * sin];
        if k < 2 || redundant {
            mechanism.hinge(Some(rod), platform, top);
        } else {
            mechanism.half_hinge(rod, platform, top);
        }
    }
    (mechanism, foot.expect("a crank"))
}

/// A triangle of two rods and the ground, its upper corner welded as well: it cannot move, but for a pendulum that hangs from it.
fn overclosed(weld: bool) -> System {
    let mut mechanism = Mechanism::new();
    let (left, right) = (mechanism.rod([0.0, 0.0], [0.5, 0.8]), mechanism.rod([1.0, 0.0], [0.5, 0.8]));
    let hanging = mechanism.rod([0.5, 0.8], [1.2, 0.8]);
    mechanism.hinge(None, left, [0.0, 0.0]);
    mechanism.hinge(None, right, [1.0, 0.0]);
    mechanism.hinge(Some(left), hanging, [0.5, 0.8]);
    let [angle_a, angle_b] = [left, right].map(|rod| mechanism.scene.initial(mechanism.bodies[rod].coordinates[2]));
    let half = 0.5 * (0.25f64 + 0.64).sqrt();
    let [a, b] = [left, right].map(|rod| mechanism.bodies[rod].at(half, 0.0));
    if weld {
        mechanism.scene.weld("weld", a, b, angle_b - angle_a);
    } else {
        mechanism.scene.revolute("corner", a, b);
    }
    mechanism.compile()
}

fn inputs(system: &System, steps: usize, dt: f64) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, dt));
    let time = |i: usize| i as f64 * dt;
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 12.0 + 3.0 * (5.0 * time(i)).sin());
    inputs
}

fn run(system: &System, inputs: &Inputs) -> (Trajectory, Vec<f64>, Vec<Warning>) {
    let mut solver = Solver::new(system, Settings::default());
    solver.simulate(inputs).unwrap_or_else(|error| panic!("{error}"));
    let gradient = solver.gradient().unwrap_or_else(|error| panic!("{error}")).controls.as_slice().to_vec();
    (solver.trajectory().clone(), gradient, solver.report().warnings.clone())
}

/// Adjoint against complex step for controls, steps and momenta.
fn assert_exact(what: &str, system: &System, inputs: &Inputs) {
    assert_exact_with(what, system, inputs, Settings::default());
}

fn assert_exact_with(what: &str, system: &System, inputs: &Inputs, settings: Settings) {
    let p_star = nalgebra::DVector::from_fn(system.n(), |i, _| 0.2 * number(i + 3));
    let inputs = Inputs { start: Start::Momentum { q: system.initial_coordinates(), p_star }, ..inputs.clone() };
    let gradient = hamiltonian_adjoint::gradient(system, &inputs, settings).unwrap_or_else(|error| panic!("{error}"));
    // q0 may not leave the constraints.
    let kinds: [fn(&Input) -> bool; 3] =
        [|x| matches!(x, Input::Control { .. }), |x| matches!(x, Input::Rate(_)), |x| matches!(x, Input::Step(_))];
    let errors = kinds.map(|is_kind| {
        let all: Vec<Input> = Input::all(&inputs).into_iter().filter(is_kind).collect();
        let adjoint: Vec<f64> = all.iter().map(|input| input.in_gradient(&gradient)).collect();
        let reference = complex_step(system, &inputs, settings, &all).unwrap_or_else(|error| panic!("{error}"));
        relative_error(&adjoint, &reference)
    });
    println!("{what}: adjoint against complex step: controls, p*0, steps {errors:?}");
    assert!(errors.iter().all(|error| *error <= 1e-9), "{what}: {errors:?}");
}

#[test]
fn a_doubled_hinge_changes_neither_motion_nor_gradient_and_is_named() {
    let single = pendulum(1, 1);
    let given = inputs(&single, 200, 0.01);
    let (motion, gradient, warnings) = run(&single, &given);
    assert!(warnings.is_empty() && motion.compliance.is_empty());
    for (hinges, elbows) in [(2, 1), (1, 2), (3, 2)] {
        let doubled = pendulum(hinges, elbows);
        let (again, its_gradient, warnings) = run(&doubled, &given);
        let errors = [
            largest_difference(again.q.as_slice(), motion.q.as_slice()),
            largest_difference(again.v.as_slice(), motion.v.as_slice()),
            relative_error(&its_gradient, &gradient),
        ];
        let (sigma, its_sigma) = (largest(motion.sigma.as_slice()), largest(again.sigma.as_slice()));
        println!("{hinges} hinges, {elbows} elbows: q, v, gradient {errors:?}, σ {its_sigma:.1} for {sigma:.1}");
        assert!(errors.iter().all(|error| *error <= 1e-9), "{errors:?}");
        assert!(its_sigma <= 2.0 * sigma);
        let [Warning::DependentConstraints { equations, .. }] = warnings.as_slice() else { panic!("{warnings:?}") };
        println!("{}", warnings[0]);
        assert_eq!(equations.len(), if hinges > 1 { 2 * hinges } else { 0 } + if elbows > 1 { 2 * elbows } else { 0 });
        assert_exact("doubled hinge", &doubled, &inputs(&doubled, 20, 0.01));
    }
}

#[test]
fn a_second_motion_from_the_same_start_is_the_same_and_another_start_is_report_only_again() {
    let system = parallelogram(3, 0.9, true);
    let given = inputs(&system, 20, 0.01);
    let mut solver = Solver::new(&system, Settings::default());
    let first = solver.simulate(&given).expect("motion").clone();
    assert_eq!(solver.simulate(&given).expect("motion"), &first);
    assert_eq!(solver.report().warnings.len(), 1);
    let other = parallelogram(3, 0.7, true).initial_coordinates();
    let elsewhere = Inputs { start: Start::Velocity { q: other, v: nalgebra::DVector::zeros(system.n()) }, ..given };
    let moved = solver.simulate(&elsewhere).expect("motion").compliance.clone();
    assert!(moved.len() == first.compliance.len() && moved != first.compliance);
}

/// (1 + t) x.
struct Guide;
impl Constraint<1, 1> for Guide {
    fn phi<S: Scalar>(&self, q: &SVector<S, 1>, _b: &SVector<S, 0>, t: S) -> SVector<S, 1> {
        SVector::from([q[0] * (t + 1.0)])
    }
}

#[test]
fn a_start_at_another_time_or_with_another_design_is_report_only_again() {
    let mut scene = Scene::new();
    let mass = scene.design("mass", 1.0);
    let body = scene.body("body", mass, 0.1, [0.0; 3]);
    ["guide", "the same"].into_iter().for_each(|name| _ = scene.constraint(name, Guide, [body.coordinates[0]], []));
    let system = scene.compile().expect("scene");
    let at_rest = Inputs::at_rest(&system, Grid::uniform(3, 0.01));
    let (mut later, mut heavier) = (at_rest.clone(), at_rest.clone());
    later.grid.start = 1.0;
    heavier.design[0] = 3.0;
    for other in [later, heavier] {
        let mut solver = Solver::new(&system, Settings::default());
        let first = solver.simulate(&at_rest).expect("motion").compliance.clone();
        let again = solver.simulate(&other).expect("motion").compliance.clone();
        assert_eq!(again, simulate(&system, &other, Settings::default()).expect("motion").compliance);
        assert!(first.len() == again.len() && first != again, "{first:?}");
    }
}

#[test]
fn the_gradient_through_restarts_is_exact() {
    let settings = Settings::default();
    let ways = [
        Settings { rebase_every: 3, ..settings },
        Settings { drift_bound: 0.0, ..settings },
        Settings { rebase_every: 4, drift_bound: 1e-9, ..settings },
    ];
    for (what, system) in [("doubled hinge", pendulum(2, 1)), ("third crank", parallelogram(3, 0.9, true))] {
        let given = inputs(&system, 20, 0.01);
        for settings in ways {
            assert_exact_with(what, &system, &given, settings);
            // Of 20 steps too.
            let composed = Inputs { grid: Grid::composed(4, 0.05, Composition::Suzuki4), ..given.clone() };
            assert_exact_with(&format!("{what}, composed"), &system, &composed, settings);
        }
    }
}

/// A multiplier.
struct Reaction;
impl Cost<0, 1, 0> for Reaction {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 1, 0>, _b: &SVector<S, 0>) -> S {
        at.sigma[0]
    }
}

/// An angle, with a multiplier at hand.
struct Angle;
impl Cost<1, 1, 0> for Angle {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 1, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0].sin()
    }
}

#[test]
fn the_gradient_of_a_shared_reaction_through_restarts_is_that_by_complex_step() {
    let (mut mechanism, sigma) = on_cranks(3, 0.9, true);
    mechanism.scene.cost("reaction", Reaction, Sum::Plain, [], [sigma], [], []);
    let system = mechanism.compile();
    let given = inputs(&system, 20, 0.01);
    let controls: Vec<Input> =
        Input::all(&given).into_iter().filter(|input| matches!(input, Input::Control { .. })).collect();
    let ways = [(3, f64::INFINITY), (1, f64::INFINITY), (0, 0.0)];
    for settings in ways.map(|(rebase_every, drift_bound)| Settings { rebase_every, drift_bound, ..Settings::default() }) {
        let gradient = hamiltonian_adjoint::gradient(&system, &given, settings).expect("gradient");
        let reference = complex_step(&system, &given, settings, &controls).expect("a complex step");
        let error = relative_error(gradient.controls.as_slice(), &reference);
        println!("rebased every {}: {error:.1e}", settings.rebase_every);
        // A share of a reaction is known to five digits, see below.
        assert!(error <= 1e-4, "{error:e}");
    }
}

/// σ of the first of two hinges of one rod, or of the only one; or no σ, although it is at hand.
#[test]
fn costs_that_read_a_shared_reaction_are_named_and_the_check_says_so() {
    let of = |hinges: usize, is_read: bool| {
        let mut mechanism = Mechanism::new();
        let rod = mechanism.rod([0.0, 0.0], [1.0, 0.0]);
        let sigma: Vec<_> = (0..hinges).map(|_| mechanism.hinge(None, rod, [0.0, 0.0])).collect();
        let ([first, _], angle) = (sigma[0], mechanism.bodies[rod].coordinates[2]);
        match is_read {
            true => mechanism.scene.cost("reaction", Reaction, Sum::Plain, [], [first], [], []),
            false => mechanism.scene.cost("angle", Angle, Sum::Plain, [angle], [first], [], []),
        }
        let system = mechanism.compile();
        let given = inputs(&system, 20, 0.01);
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&given).expect("motion");
        let report = hamiltonian_adjoint::check::gradient(&system, &given, Settings::default()).run().expect("a check");
        (solver.report().warnings.clone(), report)
    };
    let (warnings, report) = of(2, true);
    let [Warning::DependentConstraints { .. }, Warning::SharedReaction { costs, equations }] = warnings.as_slice() else {
        panic!("{warnings:?}")
    };
    assert_eq!((costs.join(" "), equations.join(" ")), ("reaction".into(), "`hinge 1` (equation 0)".into()));
    println!("{report}");
    assert!(!report.passed() && report.to_string().contains("enters `reaction`"), "{report}");
    for (hinges, is_read, count) in [(1, true, 0), (2, false, 1)] {
        let (warnings, report) = of(hinges, is_read);
        assert!(warnings.len() == count && report.warnings.len() == count, "{warnings:?}");
        report.assert_passed();
    }
}

/// |λ|² of the sum of so many hinges at one place.
struct SquareOfSum;
impl<const M: usize> Cost<0, M> for SquareOfSum {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, M, 0>, _b: &SVector<S, 0>) -> S {
        (0..2).map(|j| (j..M).step_by(2).map(|k| at.lambda[k]).sum::<S>().powi(2)).sum()
    }
}

/// A rod at rest leaves all of its weight to one of two hinges, and the λ of the other are zero.
#[test]
fn a_cost_on_a_share_is_refused_where_its_derivative_happens_to_be_zero_and_one_on_the_sum_is_not() {
    let of = |hinges: usize, on: &[usize]| {
        let mut scene = Scene::new();
        scene.gravity(0.0, -9.81);
        let mass = scene.design("mass", 2.0);
        let rod = scene.body("rod", mass, 0.1, [0.5, 0.0, 0.0]);
        let all: Vec<[Multiplier; 2]> = (0..hinges)
            .map(|k| scene.revolute(&format!("hinge {k}"), Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0)))
            .collect();
        match *on {
            [hinge] => scene.cost("load", SquareOfSum, Sum::Integral, [], all[hinge], [], []),
            _ => scene.cost("load", SquareOfSum, Sum::Integral, [], [all[0][0], all[0][1], all[1][0], all[1][1]], [], []),
        }
        let system = scene.compile().expect("a scene");
        hamiltonian_adjoint::gradient(&system, &Inputs::at_rest(&system, Grid::uniform(10, 0.005)), Settings::default())
    };
    for hinge in [0, 1] {
        let error = of(2, &[hinge]).map(|found| found.value).expect_err("a share of a reaction");
        assert_says(&error, &["λ", "hinge", "not unique"]);
    }
    let (one, both) = (of(1, &[0]).expect("a gradient"), of(2, &[0, 1]).expect("a gradient"));
    assert!(one.value > 0.1 && (one.value - both.value).abs() < 1e-7 * one.value, "{} {}", one.value, both.value);
    assert!((one.design[0] - both.design[0]).abs() < 1e-7 * one.design[0].abs());
}

#[test]
fn the_adjoint_variables_of_shared_reactions_are_those_of_the_paper_system() {
    let mut mechanism = Mechanism::new();
    let rod = mechanism.rod([0.0, 0.0], [1.0, 0.0]);
    mechanism.hinge(None, rod, [0.0, 0.0]);
    let sigma = mechanism.hinge(None, rod, [0.0, 0.0]);
    mechanism.scene.cost("reaction", Reaction, Sum::Plain, [], [sigma[0]], [], []);
    let system = mechanism.compile();
    let given = inputs(&system, 20, 0.01);
    let mut solver = Solver::new(&system, Settings { keep_adjoint: true, ..Settings::default() });
    solver.simulate(&given).expect("motion");
    solver.gradient().expect("gradient");
    let paper = PaperSystem::new(&system, &given, solver.trajectory()).expect("motion").gradient().expect("gradient");
    let e = &solver.adjoint_variables().expect("kept").e;
    let difference = (e - paper.w.rows(4 * system.n(), system.m())).amax() / e.amax();
    // σ is shared by a compliance of 1e-11, so e is large and known to a few digits only.
    // The pivot of what the compliance shares out is 1e-11 of its terms, so five digits are left.
    println!("e up to {:.1e}, difference {difference:.1e}", e.amax());
    assert!(e.amax() > 1e9 && difference <= 1e-4);
}

#[test]
fn a_third_crank_moves_as_one_that_is_held_by_half_a_hinge() {
    let (half, three) = (parallelogram(3, 0.9, false), parallelogram(3, 0.9, true));
    for steps in [50, 100, 200] {
        let given = inputs(&half, steps, 0.6 / steps as f64);
        let ((motion, gradient, _), (again, its_gradient, warnings)) = (run(&half, &given), run(&three, &given));
        assert!(matches!(&warnings[..], [Warning::DependentConstraints { equations, .. }] if equations.len() == 12));
        let errors = [
            largest_difference(again.q.as_slice(), motion.q.as_slice()),
            relative_error(&its_gradient, &gradient),
            largest(again.phi_dot(&three, &given).expect("motion").as_slice()),
        ];
        println!("third crank, {steps} steps: q, gradient, dΦ/dt {errors:?}");
        assert!(errors.iter().all(|error| *error <= 1e-9), "{errors:?}");
        assert!(largest(again.sigma.as_slice()) <= 3.0 * largest(motion.sigma.as_slice()));
    }
    assert_exact("third crank", &three, &inputs(&three, 40, 0.01));
    let four = parallelogram(4, 0.9, true);
    assert_exact("fourth crank", &four, &inputs(&four, 40, 0.01));
}

#[test]
fn a_loop_overclosed_by_a_weld_moves_as_without_it() {
    let (hinged, welded) = (overclosed(false), overclosed(true));
    let given = inputs(&hinged, 200, 0.01);
    let (motion, gradient, _) = run(&hinged, &given);
    let (again, its_gradient, warnings) = run(&welded, &given);
    let errors = [largest_difference(again.q.as_slice(), motion.q.as_slice()), relative_error(&its_gradient, &gradient)];
    println!("weld: q, gradient {errors:?}; {}", warnings[0]);
    assert!(errors.iter().all(|error| *error <= 1e-9), "{errors:?}");
    assert_exact("weld", &welded, &inputs(&welded, 20, 0.01));
}

#[test]
fn constraints_that_contradict_each_other_are_refused_by_name() {
    let two_hinges = |at: [f64; 2]| {
        let mut mechanism = Mechanism::new();
        let rod = mechanism.rod([0.0, 0.0], [1.0, 0.0]);
        mechanism.hinge(None, rod, [0.0, 0.0]);
        let body = mechanism.bodies[0];
        mechanism.scene.revolute("elsewhere", Body::GROUND.at(at[0], at[1]), body.at(-0.5, 0.0));
        mechanism.compile()
    };
    let system = two_hinges([0.0, 0.1]);
    let error = simulate(&system, &inputs(&system, 10, 0.01), Settings::default()).expect_err("contradiction").error;
    assert_says(&error, &["contradict", "1.000e-1", "`hinge 1` (equation 1)", "`elsewhere` (equation 1)"]);
    assert!(matches!(error, Error::ContradictoryConstraints { equations, .. } if equations.len() == 2));
    // It is by as much wherever the rod is.
    let mut given = inputs(&system, 10, 0.01);
    given.start.q_mut()[0] += 0.5;
    let error = simulate(&system, &given, Settings::default()).expect_err("contradiction").error;
    assert_says(&error, &["contradict", "1.000e-1"]);
}

#[test]
fn drives_that_drift_apart_are_refused_when_they_do() {
    let driven = |[first, second]: [[f64; 4]; 2]| {
        let mut mechanism = Mechanism::new();
        let rod = mechanism.rod([0.0, 0.0], [1.0, 0.0]);
        mechanism.hinge(None, rod, [0.0, 0.0]);
        let body = mechanism.bodies[0];
        for (name, b) in [("drive", first), ("another drive", second)] {
            mechanism.scene.driven_angle(name, Body::GROUND, body, Harmonic, b.map(Param::from));
        }
        mechanism.compile()
    };
    // At once, for a start with momenta, whose velocities are not looked at before.
    let system = driven([0.3, 0.301].map(|amplitude| [0.0, amplitude, 3.0, 0.0]));
    let mut given = inputs(&system, 100, 0.01);
    let p_star = nalgebra::DVector::zeros(system.n());
    given.start = Start::Momentum { q: system.initial_coordinates(), p_star };
    let error = simulate(&system, &given, Settings::default()).expect_err("contradiction").error;
    let Error::ContradictoryConstraints { time: 0.0, violation, .. } = error else { panic!("{error:?}") };
    assert!((violation - 0.003).abs() < 1e-9, "0.903 and 0.9 rad/s: {violation}");
    let system = driven([0.3, 0.301].map(|amplitude| [-amplitude, amplitude, 3.0, FRAC_PI_2]));
    let stopped = simulate(&system, &inputs(&system, 100, 0.01), Settings::default()).expect_err("contradiction");
    assert_says(&stopped.error, &["contradict", "`drive`", "`another drive`"]);
}

#[test]
fn a_parallelogram_passes_through_its_flat_position() {
    let system = parallelogram(2, 0.9, true);
    let (coarse, fine) = (inputs(&system, 400, 0.005), inputs(&system, 800, 0.0025));
    let ((motion, ..), (again, ..)) = (run(&system, &coarse), run(&system, &fine));
    // Its cranks stay parallel, several turns long.
    let between = (0..motion.computed).map(|i| (motion.q[(2, i)] - motion.q[(5, i)]).abs()).fold(0.0, f64::max);
    let end = (motion.q[(2, 400)] - again.q[(2, 800)]).abs();
    println!(
        "flat parallelogram: cranks differ by {between:.1e}, Δt and Δt/2 by {end:.1e} after {:.1} rad",
        motion.q[(2, 400)]
    );
    assert!(motion.q[(2, 400)] > 6.0 && between <= 1e-8 && end <= 2e-3);
}

/// The end of a rod of length 1 lies on the axis of abscissas.
struct OnAxis;
impl Constraint<3, 1> for OnAxis {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 1> {
        SVector::from([q[1] + q[2].sin() * 0.5])
    }
}

/// A slider-crank with crank and rod of equal length, its slider on the axis of the crank's foot.
fn slider_crank(angle: f64) -> System {
    let mut mechanism = Mechanism::new();
    let (sin, cos) = angle.sin_cos();
    let (crank, rod) = (mechanism.rod([0.0, 0.0], [cos, sin]), mechanism.rod([cos, sin], [2.0 * cos, 0.0]));
    mechanism.hinge(None, crank, [0.0, 0.0]);
    mechanism.hinge(Some(crank), rod, [cos, sin]);
    let end = mechanism.bodies[rod];
    mechanism.scene.constraint("guide", OnAxis, end.coordinates, []);
    mechanism.compile()
}

#[test]
fn a_slider_crank_of_equal_lengths_passes_its_dead_centre() {
    // At φ = π/2 the slider stands over the crank's foot; rod and crank could turn on together, but do not at this speed.
    let system = slider_crank(1.0);
    let mut given = inputs(&system, 300, 0.005);
    given.controls.fill(30.0);
    let (motion, ..) = run(&system, &given);
    let (crank, rod) = (motion.q[(2, 300)], motion.q[(5, 300)]);
    println!("slider-crank: crank at {crank:.3} rad, rod at {rod:.3}");
    assert!(crank > 4.0 && (crank + rod).abs() <= 1e-9);
}

#[test]
fn a_step_that_fails_close_to_a_singular_configuration_says_so() {
    let once = Settings { max_iterations: 1, max_halvings: 0, ..Settings::default() };
    for (angle, is_close) in [(1e-4, true), (0.9, false)] {
        let system = parallelogram(2, angle, true);
        let error = simulate(&system, &inputs(&system, 10, 0.01), once).expect_err("more iterations").error;
        println!("{error}");
        assert_eq!(matches!(error, Error::SingularConfiguration { step: 1, .. }), is_close, "{error:?}");
    }
}

/// A cylinder that is to become longer than an arm can follow, until 0.5858 s: steps that are halved often enough find the dead centre, others do not.
#[test]
fn a_drive_beyond_what_a_mechanism_can_reach_is_named() {
    let mut scene = Scene::new();
    let arm = scene.body("arm", 1.0, 0.1, [0.5, 0.0, 0.0]);
    scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), arm.at(-0.5, 0.0));
    let length = [2f64.sqrt().into(), 1.0.into()];
    scene.driven_distance("cylinder", Body::GROUND.at(0.0, -1.0), arm.at(0.5, 0.0), Ramp, length);
    let system = scene.compile().expect("scene");
    for max_halvings in [0, 10, 20] {
        let mut given = Inputs::at_rest(&system, Grid::uniform(100, 0.01));
        given.start = Start::assembled(&system);
        let settings = Settings { max_halvings, ..Settings::default() };
        let error = simulate(&system, &given, settings).expect_err("out of reach").error;
        assert_says(&error, &["step 59 (t = 0.5", "`cylinder` depends on time", "dead centre", "the lengths"]);
        let is_close = matches!(error, Error::SingularConfiguration { step: 59, .. });
        assert!(is_close && max_halvings > 10 || matches!(error, Error::Newton { step: 59, .. }), "{error:?}");
    }
}

#[test]
fn constraints_that_lose_digits_are_not_taken_for_dependent_ones() {
    // A four-bar, and beside it two links of which the last is heavy.
    let mut mechanism = Mechanism::new();
    let corners = [[-2.0, 0.0], [-2.0, 0.5], [-1.2, 0.7], [-1.0, 0.0]];
    let rods: Vec<usize> = corners.windows(2).map(|ends| mechanism.rod(ends[0], ends[1])).collect();
    mechanism.hinge(None, rods[0], corners[0]);
    mechanism.hinge(Some(rods[0]), rods[1], corners[1]);
    mechanism.hinge(Some(rods[1]), rods[2], corners[2]);
    mechanism.hinge(None, rods[2], corners[3]);
    let mut last = Body::GROUND.at(0.0, 0.0);
    for (name, mass, x) in [("light", 1.0, 0.5), ("heavy", 1e12, 1.5)] {
        let link = mechanism.scene.body(name, mass, 0.1 * mass, [x, 0.0, 0.0]);
        mechanism.scene.revolute(&format!("hinge of the {name} one"), last, link.at(-0.5, 0.0));
        last = link.at(0.5, 0.0);
    }
    let system = mechanism.compile();
    let (motion, _, warnings) = run(&system, &inputs(&system, 3, 0.001));
    assert!(matches!(warnings[..], [Warning::LostDigits { .. }]) && motion.compliance.is_empty(), "{warnings:?}");
}

#[test]
fn a_mechanism_that_starts_in_a_singular_configuration_is_refused() {
    for system in [parallelogram(2, 0.0, true), slider_crank(FRAC_PI_2), parallelogram(2, PI, true)] {
        let error = simulate(&system, &inputs(&system, 10, 0.01), Settings::default()).expect_err("singular").error;
        assert_says(&error, &["singular configuration at the start", "rank", "hinge"]);
        assert!(matches!(error, Error::SingularConfiguration { step: 0, .. }));
    }
}
