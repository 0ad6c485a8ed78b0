//! Starts that are assembled from a guess: consistent, with what is held, and with exact derivatives through the assembly.

use crate::common::{assert_gradient_is_exact_to, assert_gradient_is_exact_with, assert_says, largest};
use crate::scenes::varying;
use hamiltonian_adjoint::check;
use hamiltonian_adjoint::planar::{Body, ConstantSpeed, Harmonic};
use hamiltonian_adjoint::scenes::AngleError;
use hamiltonian_adjoint::{
    Constraint, Coordinate, Cost, CostPoint, Design, Error, Grid, Inputs, KineticEnergy, LongSolver, Param, Scalar, Scene,
    Scheme, Settings, Solver, Start, Sum, System, Warning, gradient, simulate,
};
use nalgebra::SVector;

struct FourBar {
    scene: Scene,
    crank: Body,
    rocker: Body,
    lengths: [Design; 4],
}

/// Crank, coupler, rocker and the distance of the pivots are design variables, and so are the bars' centres; a motor at the crank.
///
/// The bodies stand roughly where they belong.
fn four_bar(cranks: usize) -> FourBar {
    four_bar_with(cranks, 1.0)
}

/// With a coupler of so many times its mass and inertia.
fn four_bar_with(cranks: usize, heavy: f64) -> FourBar {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let lengths @ [a, b, c, d] =
        [("crank", 0.4), ("coupler", 1.1), ("rocker", 0.9), ("ground", 1.2)].map(|(name, value)| scene.design(name, value));
    let crank = scene.body("crank", 0.5, a * a * 0.04, [0.1, 0.2, 1.2]);
    let coupler = scene.body("coupler", b * (0.8 * heavy), 0.1 * heavy, [0.6, 0.6, 0.4]);
    let rocker = scene.body("rocker", 0.7, 0.05, [1.1, 0.5, 1.9]);
    scene.revolute("pivot of the crank", Body::GROUND.at(0.0, 0.0), crank.at(a * -0.5, 0.0));
    scene.revolute("pivot of the rocker", Body::GROUND.at(d, 0.0), rocker.at(c * -0.5, 0.0));
    scene.revolute("crank and coupler", crank.at(a * 0.5, 0.0), coupler.at(b * -0.5, 0.0));
    for k in 0..cranks {
        scene.revolute(&format!("coupler and rocker {k}"), coupler.at(b * 0.5, 0.0), rocker.at(c * 0.5, 0.0));
    }
    let u = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, crank, u);
    let [.., angle] = rocker.coordinates;
    scene.cost("angle", AngleError, Sum::Trapezoidal, [angle], [], [], [1.0.into()]);
    FourBar { scene, crank, rocker, lengths }
}

fn inputs(system: &System, hold: &[Coordinate], rate: f64) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(12, 0.02));
    inputs.start = Start::assembled(system).hold(hold);
    hold.iter().for_each(|&q| inputs.start.set_rate(q, rate));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = (0.3 * i as f64).sin());
    inputs
}

#[test]
fn a_start_satisfies_the_constraints_and_keeps_what_is_held() {
    let FourBar { scene, crank, .. } = four_bar(1);
    let system = scene.compile().expect("a scene");
    let [.., angle] = crank.coordinates;
    for hold in [&[][..], &[angle]] {
        let inputs = inputs(&system, hold, 1.5);
        let mut solver = Solver::new(&system, Settings::default());
        let motion = solver.simulate(&inputs).expect("a motion").clone();
        let (phi, phi_dot) = (motion.phi(&system, solver.inputs()), motion.phi_dot(&system, solver.inputs()));
        assert!(largest(phi.expect("Φ").column(0).as_slice()) < 1e-14);
        assert!(largest(phi_dot.expect("dΦ/dt").column(0).as_slice()) < 1e-14);
        if !hold.is_empty() {
            let i = angle.index();
            assert_eq!(motion.q[(i, 0)], 1.2);
            assert!((motion.v[(i, 0)] - 1.5).abs() < 1e-14);
        }
        assert!(largest(motion.sigma.column(0).as_slice()) < 1e-13, "σ₀ = 0");
    }
}

#[test]
fn what_is_consistent_stays_as_it_is() {
    let FourBar { scene, crank, .. } = four_bar(1);
    let system = scene.compile().expect("a scene");
    let mut solver = Solver::new(&system, Settings::default());
    let mut inputs = inputs(&system, &[crank.coordinates[2]], 1.5);
    solver.simulate(&inputs).expect("a motion");
    let first = solver.inputs().start.clone();
    let Start::Velocity { q, v } = &first else { panic!("{first:?}") };
    inputs.start = Start::Assembled { q: q.clone(), v: v.clone(), held: Default::default() };
    solver.simulate(&inputs).expect("a motion");
    let again = &solver.inputs().start;
    assert!((again.q() - first.q()).amax() < 1e-15 && (again.rate() - first.rate()).amax() < 1e-14);
}

#[test]
fn the_change_is_the_least_one() {
    // A bob on a rod of 1 m from a guess beside it: along the radius, the mass being the same in both directions.
    let mut scene = Scene::new();
    let bob = scene.body("bob", 2.0, 0.1, [1.2, -0.9, 0.3]);
    scene.distance("rod", Body::GROUND.at(0.0, 0.0), bob.at(0.0, 0.0), 1.0);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(1, 0.01));
    inputs.start = Start::assembled(&system);
    let [x, y, _] = bob.coordinates;
    inputs.start.set_rate(x, 1.0);
    inputs.start.set_rate(y, 1.0);
    let motion = simulate(&system, &inputs, Settings::default()).expect("a motion");
    let [q, v] = [&motion.q, &motion.v].map(|x| x.column(0).into_owned());
    let radius = 1.5;
    assert!((q[0] - 1.2 / radius).abs() < 1e-14 && (q[1] + 0.9 / radius).abs() < 1e-14 && q[2] == 0.3, "{q}");
    let across = 0.6 + 0.8;
    assert!((v[0] - 0.6 * across).abs() < 1e-14 && (v[1] - 0.8 * across).abs() < 1e-14, "{v}");
}

#[test]
fn derivatives_through_the_assembly_are_exact() {
    let plain = Settings::default();
    let ways = [
        ("trapezoidal rule", plain),
        ("ESDIRK3", Settings { scheme: Scheme::ESDIRK3, ..plain }),
        ("projected", Settings { drift_bound: 0.0, ..plain }),
        ("rebased", Settings { rebase_every: 3, ..plain }),
    ];
    for cranks in [1, 2] {
        let FourBar { scene, crank, rocker, .. } = four_bar(cranks);
        let system = scene.compile().expect("a scene");
        for (name, hold) in [("free", &[][..]), ("crank", &crank.coordinates[2..]), ("rocker", &rocker.coordinates[2..])] {
            for (what, settings) in ways {
                let what = format!("{cranks} hinges, {name} held, {what}");
                assert_gradient_is_exact_with(&what, &system, &inputs(&system, hold, 1.5), settings);
            }
        }
    }
}

#[test]
fn a_mass_matrix_that_varies_and_a_linear_part_are_no_exception() {
    let (scene, q) = varying::bead();
    let system = scene.compile().expect("a scene");
    let mut inputs = inputs(&system, &[], 0.0);
    inputs.start.set_rate(q[0], 0.7);
    assert_gradient_is_exact_with("free", &system, &inputs, Settings::default());
    inputs.start = inputs.start.clone().hold(&q[..1]);
    assert_gradient_is_exact_with("x held", &system, &inputs, Settings::default());
}

/// T = ½ m (|v|² + (x ẋ + sin y ẏ)²); b = [m].
struct Uneven;

impl KineticEnergy<2, 1> for Uneven {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, b: &SVector<S, 1>) -> S {
        let along = q[0] * v[0] + q[1].sin() * v[1];
        b[0] * (v.dot(v) + along * along) * 0.5
    }
}

/// The real part of complex velocities is but products of perturbations then, which rounding never lets settle.
#[test]
fn a_start_at_rest_is_no_exception() {
    for k in 0..20 {
        let mut scene = Scene::new();
        let q = scene.coordinates("bob", ["x", "y"]);
        let mass = scene.design("mass", 1.1);
        scene.place(q[0], 0.9 + 0.01 * f64::from(k));
        scene.place(q[1], 0.3);
        scene.kinetic_energy("bob", Uneven, q, [mass.into()]);
        scene.cost("x", AngleError, Sum::Trapezoidal, [q[0]], [], [], [0.2.into()]);
        let system = scene.compile().expect("a scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(3, 0.02));
        inputs.start = Start::assembled(&system);
        let report = check::gradient(&system, &inputs, Settings::default()).run().expect("a report");
        assert!(report.passed(), "{report}");
    }
}

#[test]
fn a_gradient_asked_for_twice_is_the_same() {
    let FourBar { scene, crank, .. } = four_bar(2);
    let system = scene.compile().expect("a scene");
    let inputs = inputs(&system, &crank.coordinates[2..], 1.5);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("a motion");
    let first = solver.gradient().expect("a gradient").clone();
    assert_eq!(solver.gradient().expect("a gradient"), &first);
    solver.simulate(&inputs).expect("a motion");
    assert_eq!(solver.gradient().expect("a gradient"), &first);
    let mut long = LongSolver::new(&system, Settings::default(), 30_000);
    assert_eq!(long.gradient(&inputs).expect("a gradient").start, first.start);
}

#[test]
fn lengths_may_change_without_a_word_about_the_start() {
    let FourBar { scene, crank, lengths: [_, coupler, ..], .. } = four_bar(1);
    let system = scene.compile().expect("a scene");
    let mut inputs = inputs(&system, &crank.coordinates[2..], 0.0);
    let cost = |inputs: &Inputs| gradient(&system, inputs, Settings::default()).expect("a gradient");
    let p = coupler.index();
    let slope = cost(&inputs).design[p];
    let mut by_difference = 0.0;
    for (step, sign) in [(1e-5, 1.0), (-2e-5, -1.0)] {
        inputs.design[p] += step;
        by_difference += sign * cost(&inputs).value / 2e-5;
    }
    assert!((slope - by_difference).abs() < 1e-7 * slope.abs(), "{slope} and {by_difference}");
}

#[test]
fn what_cannot_be_assembled_is_named() {
    let FourBar { scene, crank, lengths: [.., ground], .. } = four_bar(1);
    let system = scene.compile().expect("a scene");
    let fails = |inputs: &Inputs| simulate(&system, inputs, Settings::default()).expect_err("no start").error;
    let mut open = inputs(&system, &[], 0.0);
    open.design[ground.index()] = 4.0;
    let error = fails(&open);
    assert!(matches!(error, Error::Assembly { violation, .. } if violation > 0.1), "{error}");
    assert_says(&error, &["cannot be assembled", "violated", "better guess"]);
    assert!(!error.to_string().contains("hold fewer"), "nothing is held: {error}");
    let mut open = inputs(&system, &crank.coordinates[2..], 0.0);
    open.design[ground.index()] = 4.0;
    assert_says(&fails(&open), &["cannot be assembled", "hold fewer coordinates"]);
    let error = fails(&inputs(&system, &[crank.coordinates[2], crank.coordinates[0]], 0.0));
    assert_says(&error, &["crank.x", "cannot be held"]);
}

#[test]
fn what_is_held_belongs_to_the_scene() {
    let FourBar { scene, crank, .. } = four_bar(1);
    let (system, other) = (scene.compile().expect("scene"), four_bar(1).crank.coordinates[2]);
    let mut given = inputs(&system, &crank.coordinates[2..], 0.0);
    assert!(simulate(&system, &given, Settings::default()).is_ok());
    given.start = Start::assembled(&system).hold(&[other]);
    let error = Solver::new(&system, Settings::default()).assemble(&given).map(drop).expect_err("another's coordinate");
    assert_says(&error, &["held coordinate 2", "another scene"]);
    if let Start::Assembled { held, .. } = &mut given.start {
        held.coordinates.clear();
    }
    assert_says(&gradient(&system, &given, Settings::default()).map(drop).expect_err("held velocity"), &["another scene"]);
}

#[test]
fn driven_joints_and_grids_by_tolerance_go_together_with_it() {
    let FourBar { mut scene, crank, rocker, lengths: [a, _, c, _] } = four_bar(1);
    // A bob that the motion of the others does not determine, with a motor.
    let bob = scene.body("bob", 0.3, 0.01, [1.0, 0.5, 0.0]);
    scene.revolute("hook of the bob", rocker.at(c * 0.5, 0.0), bob.at(0.0, 0.3));
    let push = scene.control("push");
    scene.torque_actuator("motor of the bob", rocker, bob, push);
    scene.cost("bob", AngleError, Sum::Terminal, [bob.coordinates[2]], [], [], [0.3.into()]);
    // Turns with the crank's length as an angle and a speed that depends on it too.
    scene.driven_angle("drive", Body::GROUND, crank, ConstantSpeed, [a + 0.8, 2.0 / a]);
    let system = scene.compile().expect("a scene");
    let inputs = inputs(&system, &[], 0.0);
    assert_gradient_is_exact_with("driven", &system, &inputs, Settings::default());
    let settings = Settings { scheme: Scheme::ESDIRK3, ..Settings::default() };
    let mut solver = Solver::new(&system, settings);
    let adapted = solver.adapt(&inputs, 1e-4).expect("a grid");
    assert_eq!(adapted.start, inputs.start, "the guess is that of the user");
    assert_gradient_is_exact_with("adapted", &system, &adapted, settings);
}

#[test]
fn the_checks_know_it() {
    let FourBar { scene, crank, .. } = four_bar(1);
    let system = scene.compile().expect("a scene");
    let inputs = inputs(&system, &crank.coordinates[2..], 1.5);
    let report = check::gradient(&system, &inputs, Settings::default()).run().expect("a report");
    assert!(report.passed(), "{report}");
}

/// The compliance of dependent constraints leaves some mobility to what they determine, more beside a light body: starts were assembled that violate them.
#[test]
fn what_dependent_constraints_determine_cannot_be_held() {
    for heavy in [1.0, 1e-2, 1e-4] {
        let FourBar { scene, crank, rocker, .. } = four_bar_with(2, heavy);
        let system = scene.compile().expect("a scene");
        let angles = [crank, rocker].map(|body| body.coordinates[2]);
        let mut solver = Solver::new(&system, Settings::default());
        let closed = solver.assemble(&inputs(&system, &angles[..1], 1.5)).expect("a start").start;
        // Where the loop closes, and with rates that it does not allow.
        let mut inputs = inputs(&system, &angles, 1.5);
        inputs.start.q_mut().copy_from(closed.q());
        let error = solver.assemble(&inputs).expect_err("a start that violates constraints");
        assert_says(&error, &["cannot be held", "φ"]);
    }
}

/// Held is x, and the body moves nearly along y: all else is far more in motion than what is held, and rounding with it.
#[test]
fn what_is_held_may_hardly_be_free() {
    for freedom in [1e-1, 1e-2, 1.6e-3, 1e-4] {
        let mut scene = Scene::new();
        scene.gravity(0.0, -9.81);
        let (arm, u) = (scene.design("arm", 0.3), scene.control("torque"));
        let carriage = scene.body("carriage", 1.9, 0.26, [0.2, 0.73, -0.42]);
        let pendulum = scene.body("pendulum", 0.7, 0.05, [0.6, 0.9, 0.3]);
        let axis = std::f64::consts::FRAC_PI_2 - freedom;
        scene.prismatic("rail", Body::GROUND.at(0.2 - freedom, -0.71), axis, carriage.at(0.0, 0.0), -0.42);
        scene.revolute("hinge", carriage.at(0.1, 0.0), pendulum.at(arm * -1.0, 0.1));
        scene.torque_actuator("motor", carriage, pendulum, u);
        let [x, y, _] = carriage.coordinates;
        for seen in [y, pendulum.coordinates[2]] {
            scene.cost(&format!("place {}", seen.index()), AngleError, Sum::Trapezoidal, [seen], [], [], [0.4.into()]);
        }
        let system = scene.compile().expect("a scene");
        let inputs = inputs(&system, &[x], 0.5 * freedom);
        // The rest of the mechanism moves as many times farther.
        let within = f64::max(1e-12, 1e-15 / freedom);
        assert_gradient_is_exact_to(within, &format!("{freedom}"), &system, &inputs, Settings::default());
    }
}

/// A rocker whose place follows from a held crank, close to the end of its reach: its second derivative grows with the third power of the distance.
#[test]
fn products_near_the_end_of_a_reach_are_there_whatever_the_length_of_their_direction() {
    let (base, crank, coupler, rocker) = (1.0f64, 0.5f64, 0.7f64, 0.6f64);
    let limit = ((base * base + crank * crank - (coupler + rocker).powi(2)) / (2.0 * base * crank)).acos();
    for distance in [1e-2, 1e-4, 1e-6, 1e-7] {
        let pin = [(limit - distance).cos(), (limit - distance).sin()].map(|x| crank * x);
        let to = [base - pin[0], -pin[1]];
        let far = to[0].hypot(to[1]);
        let cosine = (rocker * rocker + far * far - coupler * coupler) / (2.0 * rocker * far);
        let (sine, by_coupler) = ((1.0 - cosine * cosine).sqrt(), coupler / (rocker * far));
        let expected = -1.0 / (rocker * far * sine) + by_coupler.powi(2) * cosine / sine.powi(3);
        let (bend, heading) = (coupler.powi(2) + far * far - rocker * rocker, to[1].atan2(to[0]));
        let angle = heading + (bend / (2.0 * coupler * far)).acos();
        let joint = [pin[0] + coupler * angle.cos(), pin[1] + coupler * angle.sin()];
        let mut scene = Scene::new();
        let length = scene.design("coupler", coupler);
        let half = |a: [f64; 2], b: [f64; 2], angle| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), angle];
        let bodies = [
            scene.body("crank", 1.0, 0.01, half([0.0; 2], pin, limit - distance)),
            scene.body("coupler", 1.0, 0.01, half(pin, joint, angle)),
            scene.body("rocker", 1.0, 0.01, half([base, 0.0], joint, joint[1].atan2(joint[0] - base))),
        ];
        scene.revolute("A", Body::GROUND.at(0.0, 0.0), bodies[0].at(-0.5 * crank, 0.0));
        scene.revolute("B", bodies[0].at(0.5 * crank, 0.0), bodies[1].at(length * -0.5, 0.0));
        scene.revolute("C", bodies[1].at(length * 0.5, 0.0), bodies[2].at(0.5 * rocker, 0.0));
        scene.revolute("D", Body::GROUND.at(base, 0.0), bodies[2].at(-0.5 * rocker, 0.0));
        scene.cost("angle", Angle, Sum::Node(0), [bodies[2].coordinates[2]], [], [], []);
        let system = scene.compile().expect("a scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(1, 1e-3));
        inputs.start = Start::assembled(&system).hold(&bodies[0].coordinates[2..]);
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&inputs).expect("a motion");
        for size in [1.0, 1e-2, 1e-6, 1e4] {
            let mut direction = inputs.no_change();
            direction.design[0] = size;
            let product = solver.hessian_product(&direction).expect("a product").design[0] / size;
            // The place of the joint is rounded, too.
            let within = 1e-9 + 1e-14 / distance;
            assert!(
                (product - expected).abs() <= within * expected.abs(),
                "{distance}, {size}: {product:e} for {expected:e}"
            );
        }
    }
}

/// q.
struct Angle;

impl Cost<1, 0, 0, 0> for Angle {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _: &SVector<S, 0>) -> S {
        at.q[0]
    }
}

/// Three cranks of one length, a design variable, carry a coupler, on which one of them would do nothing but for its weight. The bodies stand aside of where
/// they belong by these numbers.
fn three_cranks(aside: impl FnMut() -> f64) -> (System, Coordinate) {
    cranks(aside, 3)
}

/// So many of the cranks are as long as the design variable says.
fn cranks(mut aside: impl FnMut() -> f64, bound: usize) -> (System, Coordinate) {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let (length, u) = (scene.design("length", 0.7), scene.control("torque"));
    let coupler = scene.body("coupler", 1.5, 0.2, [0.9, 0.6, 0.0].map(|x| x + aside()));
    let cranks = [0.0, 0.5, 1.0].map(|x| {
        let length = if x < 0.5 * bound as f64 { Param::from(length) } else { 0.7.into() };
        let crank = scene.body(&format!("crank at {x}"), 0.4, 0.02, [x + 0.2, 0.3, 0.9].map(|x| x + aside()));
        scene.revolute(&format!("foot at {x}"), Body::GROUND.at(x, 0.0), crank.at(length * -0.5, 0.0));
        scene.revolute(&format!("head at {x}"), crank.at(length * 0.5, 0.0), coupler.at(x - 0.5, 0.0));
        crank
    });
    scene.torque_actuator("motor", Body::GROUND, cranks[0], u);
    let [.., angle] = cranks[2].coordinates;
    scene.cost("angle", AngleError, Sum::Trapezoidal, [angle], [], [], [1.0.into()]);
    (scene.compile().expect("a scene"), cranks[0].coordinates[2])
}

#[test]
fn dependent_constraints_are_assembled_from_rough_guesses() {
    // Away from where they hold they contradict each other.
    for k in 0..20 {
        let mut draw = k as f64;
        let (system, angle) = three_cranks(|| {
            draw += 1.0;
            0.4 * (12.9898 * draw * draw).sin()
        });
        for hold in [&[][..], &[angle]] {
            let inputs = inputs(&system, hold, 1.5);
            let assembled = Solver::new(&system, Settings::default()).assemble(&inputs);
            let q = assembled.unwrap_or_else(|error| panic!("guess {k}, {} held: {error}", hold.len())).start.q().clone();
            let kept = q[angle.index()] - inputs.start.q()[angle.index()];
            assert!(hold.is_empty() || kept == 0.0, "{kept}");
        }
    }
}

#[test]
fn second_derivatives_pass_through_the_assembly_of_dependent_constraints() {
    let (system, angle) = three_cranks(|| 0.1);
    for hold in [&[][..], &[angle]] {
        let inputs = inputs(&system, hold, 1.5);
        check::hessian(&system, &inputs, Settings::default()).run().expect("a report").assert_passed();
    }
}

#[test]
fn a_length_that_others_have_to_follow_is_named() {
    for bound in 1..=3 {
        let (system, angle) = cranks(|| 0.1, bound);
        let assembled = inputs(&system, &[angle], 1.5);
        let mut solver = Solver::new(&system, Settings::default());
        let mut given = assembled.clone();
        given.start = solver.assemble(&assembled).expect("a start").start;
        for inputs in [assembled, given] {
            solver.simulate(&inputs).expect("a motion");
            assert_eq!(named(&solver).join(", "), if bound < 3 { "length" } else { "" }, "{bound} cranks");
        }
    }
}

/// The design variables that are named as breaking a dependence.
fn named(solver: &Solver) -> Vec<String> {
    let designs = |warning: &Warning| match warning {
        Warning::BrokenDependence { designs, .. } => Some(designs.clone()),
        _ => None,
    };
    solver.report().warnings.iter().find_map(designs).unwrap_or_default()
}

/// Those of a scene where constraints depend on each other.
fn breaking(scene: Scene, held: &[Coordinate]) -> Vec<String> {
    let system = scene.compile().expect("a scene");
    let inputs = inputs(&system, held, 1.0);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("a motion");
    let dependent = |warning: &Warning| matches!(warning, Warning::DependentConstraints { .. });
    assert!(solver.report().warnings.iter().any(dependent), "nothing depends on anything");
    named(&solver)
}

/// Two motors of one bar agree at the start whatever their speeds are, and one of two rails may be turned about the point where the slider starts.
#[test]
fn what_breaks_a_dependence_in_motion_alone_is_named() {
    for bound in 1..=2 {
        let value = |k: usize, design: Design, value: f64| if k < bound { Param::from(design) } else { value.into() };
        let named = |name: &str| if bound < 2 { vec![name.to_string()] } else { Vec::new() };

        let mut scene = Scene::new();
        let speed = scene.design("speed", 1.3);
        let bar = scene.body("bar", 1.0, 0.1, [0.5, 0.0, 0.0]);
        scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), bar.at(-0.5, 0.0));
        for k in 0..2 {
            let motion = [0.0.into(), value(k, speed, 1.3)];
            scene.driven_angle(&format!("motor {k}"), Body::GROUND, bar, ConstantSpeed, motion);
        }
        assert_eq!(breaking(scene, &[]), named("speed"));

        // Two cranks of a parallelogram, both driven.
        let mut scene = Scene::new();
        let frequency = scene.design("frequency", 3.0);
        let coupler = scene.body("coupler", 1.5, 0.2, [0.7, 0.6, 0.0]);
        for k in 0..2 {
            let x = 0.5 * k as f64;
            let crank = scene.body(&format!("crank {k}"), 0.4, 0.02, [x + 0.2, 0.3, 0.9]);
            scene.revolute(&format!("foot {k}"), Body::GROUND.at(x, 0.0), crank.at(-0.35, 0.0));
            scene.revolute(&format!("head {k}"), crank.at(0.35, 0.0), coupler.at(x - 0.5, 0.0));
            let motion = [0.9.into(), 0.3.into(), value(k, frequency, 3.0), 0.0.into()];
            scene.driven_angle(&format!("motor {k}"), Body::GROUND, crank, Harmonic, motion);
        }
        assert_eq!(breaking(scene, &[]), named("frequency"));

        let mut scene = Scene::new();
        let direction = scene.design("direction", 0.4);
        let slider = scene.body("slider", 1.0, 0.1, [0.0, 0.0, 0.4]);
        for k in 0..2 {
            let axis = value(k, direction, 0.4);
            scene.prismatic(&format!("rail {k}"), Body::GROUND.at(0.0, 0.0), axis, slider.at(0.0, 0.0), 0.4);
        }
        assert_eq!(breaking(scene, &slider.coordinates[..1]), named("direction"));
    }
}

/// A bar is welded to a coupler twice, and where it is welded it is the same on both sides: what one side adds the other one takes away, but for rounding.
#[test]
fn rounding_breaks_no_dependence() {
    for mass in [1.0, 3.0, 10.0, 100.0, 1000.0] {
        let mut scene = Scene::new();
        scene.gravity(0.0, -9.81);
        let (length, place) = (scene.design("length", 0.7), scene.design("place", 0.3));
        let coupler = scene.body("coupler", 1.5, 0.2, [0.9, 0.6, 0.0]);
        let angles = [0.0, 0.5, 1.0].map(|x| {
            let crank = scene.body(&format!("crank at {x}"), 0.4 * mass, 0.02 * mass, [x + 0.2, 0.3, 0.9]);
            scene.revolute(&format!("foot at {x}"), Body::GROUND.at(x, 0.0), crank.at(length * -0.5, 0.0));
            scene.revolute(&format!("head at {x}"), crank.at(length * 0.5, 0.0), coupler.at(x - 0.5, 0.0));
            crank.coordinates[2]
        });
        let bar = scene.body("bar", 1.0, 0.1, [0.9, 1.6, 0.0]);
        scene.weld("weld", coupler.at(place, 1.0), bar.at(place, 0.0), 0.0);
        scene.weld("weld again", coupler.at(-0.3, 1.0), bar.at(-0.3, 0.0), 0.0);
        assert_eq!(breaking(scene, &angles[2..]), Vec::<String>::new(), "{mass}");
    }
}

/// Half the length of the cranks is an expression of two design variables.
#[test]
fn expressions_break_a_dependence_by_the_variables_in_them() {
    for bound in 1..=3 {
        let mut scene = Scene::new();
        let (length, share) = (scene.design("length", 0.7), scene.design("share", 0.5));
        let coupler = scene.body("coupler", 1.5, 0.2, [0.9, 0.6, 0.0]);
        for (k, x) in [0.0, 0.5, 1.0].into_iter().enumerate() {
            let half = || if k < bound { length * share } else { 0.35.into() };
            let crank = scene.body(&format!("crank at {x}"), 0.4, 0.02, [x + 0.2, 0.3, 0.9]);
            scene.revolute(&format!("foot at {x}"), Body::GROUND.at(x, 0.0), crank.at(half() * -1.0, 0.0));
            scene.revolute(&format!("head at {x}"), crank.at(half(), 0.0), coupler.at(x - 0.5, 0.0));
        }
        let both = vec!["length".to_string(), "share".to_string()];
        assert_eq!(breaking(scene, &[]), if bound < 3 { both } else { Vec::new() }, "{bound} cranks");
    }
}

#[test]
fn a_start_that_the_motion_forgets_has_a_gradient() {
    let mut scene = Scene::new();
    let torque = scene.control("torque");
    let rod = scene.body("rod", 1.0, 0.1, [0.5, 0.0, 0.0]);
    scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    scene.torque_actuator("motor", Body::GROUND, rod, torque);
    scene.torsional_spring_damper("spring", Body::GROUND, rod, 1.0, 0.3, 2.0);
    scene.cost("angle", AngleError, Sum::Terminal, [rod.coordinates[2]], [], [], [0.4.into()]);
    let system = scene.compile().expect("a scene");
    let settings = Settings { scheme: Scheme::TR_BDF2, rebase_every: 1, drift_bound: 0.0, ..Settings::default() };
    let mut least = f64::INFINITY;
    for steps in (1000..1500).step_by(5) {
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 1.0));
        inputs.start = Start::assembled(&system).hold(&[rod.coordinates[2]]);
        let gradient = gradient(&system, &inputs, settings).expect("a gradient");
        least = least.min(largest(gradient.start.rate().as_slice()));
    }
    assert!(least < f64::MIN_POSITIVE, "{least:e}");
}

/// Φ = ln x + 1.2, and T = ½ (√x + 2) v².
struct Logarithm;
impl Constraint<1, 1> for Logarithm {
    fn phi<S: Scalar>(&self, q: &SVector<S, 1>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 1> {
        SVector::from([q[0].ln() + 1.2])
    }
}
struct Root;
impl KineticEnergy<1> for Root {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * (q[0].sqrt() + 2.0) * 0.5
    }
}

#[test]
fn elements_without_a_number_at_the_guess_are_named() {
    for (x, programs) in [(0.0, true), (0.0, false), (-0.5, true), (-0.5, false)] {
        let mut scene = Scene::new();
        let [near, far] = scene.coordinates("slide", ["near", "far"]);
        scene.place(near, 0.3);
        scene.place(far, x);
        scene.kinetic_energy("first mass", Root, [near], []);
        match x {
            0.0 => scene.kinetic_energy("guilty", Root, [far], []),
            _ => {
                scene.kinetic_energy("second mass", Line, [far], []);
                scene.constraint("guilty", Logarithm, [far], []);
            }
        }
        let system = if programs { scene.compile() } else { scene.compile_without_programs() }.expect("a scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.01));
        inputs.start = Start::assembled(&system);
        let error = Solver::new(&system, Settings::default()).simulate(&inputs).map(|_| ()).expect_err("no number");
        assert!(matches!(&error, Error::Model { element, node: 0, .. } if element == "`guilty`"), "{error:?}");
    }
}

/// T = ½ v².
struct Line;
impl KineticEnergy<1> for Line {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}

/// x² + y² = R².
struct Ring;
impl Constraint<2, 1, 1> for Ring {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 1>, _t: S) -> SVector<S, 1> {
        SVector::from([q[0].powi(2) + q[1].powi(2) - b[0].powi(2)])
    }
}

/// A bead on a ring, given far from it.
fn bead(radius: f64) -> System {
    let mut scene = Scene::new();
    let bead = scene.particle("bead", 1.0, [1.9 * radius, 0.7 * radius]);
    scene.constraint("ring", Ring, bead.coordinates, [radius.into()]);
    scene.compile().expect("scene")
}

#[test]
fn what_is_left_of_large_lengths_is_rounding() {
    for radius in [1e3, 3e3, 1e4, 3e4, 1e5, 1e7, 1e9] {
        let system = bead(radius);
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.1));
        inputs.start = Start::assembled(&system);
        if let Start::Assembled { v, .. } = &mut inputs.start {
            (v[0], v[1]) = (0.3 * radius, radius);
        }
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&inputs).expect("motion");
        // The start that was found may be given as well.
        let found = solver.inputs().clone();
        assert!(matches!(found.start, Start::Velocity { .. }));
        simulate(&system, &found, Settings::default()).expect("motion");
        // A part in 10¹² too long is no rounding.
        let mut off = found.clone();
        off.start.q_mut().iter_mut().for_each(|q| *q *= 1.0 + 1e-12);
        let refused = simulate(&system, &off, Settings::default());
        assert_eq!(refused.is_err(), 2e-12 * radius * radius > 1e-9, "{radius}");
    }
}

/// The derivative by the length of a link that starts where it is told is that of no mechanism that stays together: −0.27 here, where it is −1.31.
#[test]
fn a_length_in_a_joint_wants_a_start_that_follows() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let (l, speed, mass) = (scene.design("l", 1.0), scene.design("speed", 0.5), scene.design("mass", 1.0));
    let rod = scene.body("rod", mass, 0.1, [0.5, 0.0, 0.0]);
    scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(l * -0.5, 0.0));
    // Its speed is a matter of velocities: at the start φ = 0 for any.
    let wheel = scene.body("wheel", 1.0, 0.1, [2.0, 0.0, 0.0]);
    scene.revolute("axle", Body::GROUND.at(2.0, 0.0), wheel.at(0.0, 0.0));
    scene.driven_angle("drive", Body::GROUND, wheel, ConstantSpeed, [0.0.into(), speed.into()]);
    scene.cost("end", AngleError, Sum::Terminal, [rod.coordinates[0]], [], [], [0.0.into()]);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
    let Start::Velocity { v, .. } = &mut inputs.start else { panic!("velocities are given") };
    v[5] = 0.5;
    let lengths = |inputs: &Inputs| {
        let found = gradient(&system, inputs, Settings::default()).expect("a gradient");
        let given = found.warnings.iter().filter_map(|warning| match warning {
            Warning::GivenStart { designs, elements } => Some((designs.clone(), elements.clone())),
            _ => None,
        });
        (given.collect::<Vec<_>>(), found.design[0])
    };
    let (given, of_given) = lengths(&inputs);
    assert_eq!(given, [(vec!["l".to_string()], vec!["hinge".to_string()])]);
    let mut long = LongSolver::new(&system, Settings::default(), 1 << 20);
    let again = long.gradient(&inputs).expect("a gradient").warnings.clone();
    assert!(again.iter().any(|warning| matches!(warning, Warning::GivenStart { .. })), "{again:?}");
    inputs.start = Start::assembled(&system).hold(&[rod.coordinates[2]]);
    let (given, of_assembled) = lengths(&inputs);
    assert!(given.is_empty() && (of_given - of_assembled).abs() > 0.1, "{given:?} {of_given} {of_assembled}");
}

/// So many rods of equal length between (0, 1) and (1, 3), √5 m apart, guessed along an arc that sags by so much; the whole length is a design variable.
fn arc(rods: usize, whole: f64, sag: f64) -> System {
    let (mut scene, part) = (Scene::new(), 1.0 / rods as f64);
    let length = scene.design("whole length", whole);
    let place = |i: usize| {
        let a = i as f64 * part;
        [a, 1.0 + 2.0 * a - sag * a * (1.0 - a)]
    };
    let mut end = Body::GROUND.at(0.0, 1.0);
    for i in 0..rods {
        let ([x, y], [u, v]) = (place(i), place(i + 1));
        let l = length * part;
        let middle = [(x + u) / 2.0, (y + v) / 2.0, (v - y).atan2(u - x)];
        let rod = scene.body(&format!("rod {i}"), l, l * l * l / 12.0, middle);
        scene.revolute(&format!("hinge {i}"), end, rod.at(l * -0.5, 0.0));
        end = rod.at(l * 0.5, 0.0);
        if i == rods / 3 {
            scene.cost("angle", AngleError, Sum::AllNodes, [rod.coordinates[2]], [], [], [0.4.into()]);
        }
    }
    scene.revolute("last", end, Body::GROUND.at(1.0, 3.0));
    scene.gravity(0.0, -9.81);
    scene.compile().expect("a scene")
}

/// Sags of arcs of 2.5, 3.4, 4.3 and 4.8 m.
const SAGS: [f64; 4] = [2.9653, 5.5708, 7.6606, 8.7625];

#[test]
fn chains_of_many_rods_are_assembled_from_arcs_that_are_too_short_or_too_long() {
    for rods in [5, 8, 10, 20, 50, 100] {
        for sag in SAGS {
            let system = arc(rods, 4.0, sag);
            let mut inputs = Inputs::at_rest(&system, Grid::uniform(1, 1e-3));
            inputs.start = Start::assembled(&system);
            let mut solver = Solver::new(&system, Settings::default());
            let found = solver.assemble(&inputs).unwrap_or_else(|error| panic!("{rods} rods, {sag}: {error}")).start;
            let given = Inputs { start: found, ..inputs };
            solver.simulate(&given).unwrap_or_else(|error| panic!("{rods} rods, {sag}: {error}"));
        }
    }
}

#[test]
fn derivatives_through_an_assembly_from_far_away_are_exact() {
    for rods in [5, 10] {
        for sag in SAGS {
            let system = arc(rods, 4.0, sag);
            let mut inputs = Inputs::at_rest(&system, Grid::uniform(2, 1e-3));
            inputs.start = Start::assembled(&system);
            let report = check::gradient(&system, &inputs, Settings::default()).run().expect("a report");
            assert!(report.passed(), "{rods} rods, {sag}: {report}");
        }
        let system = arc(rods, 4.0, SAGS[2]);
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(2, 1e-3));
        inputs.start = Start::assembled(&system);
        check::hessian(&system, &inputs, Settings::default()).run().expect("a report").assert_passed();
    }
}

#[test]
fn what_is_too_short_is_refused_with_the_distance_that_is_missing() {
    for (rods, whole) in [(5, 2.0), (10, 1.5), (50, 2.0)] {
        for sag in SAGS {
            let system = arc(rods, whole, sag);
            let mut inputs = Inputs::at_rest(&system, Grid::uniform(1, 1e-3));
            inputs.start = Start::assembled(&system);
            let error = Solver::new(&system, Settings::default()).assemble(&inputs).map(drop).expect_err("too short");
            let Error::Assembly { equation, violation, .. } = &error else { panic!("{error}") };
            let missing = 5f64.sqrt() - whole;
            assert!((violation - missing).abs() < 1e-3 * missing, "{rods} rods, {sag}: {violation} for {missing}");
            assert!(equation.contains("hinge"), "{equation}");
        }
    }
}

#[test]
fn a_coordinate_may_be_held_twice() {
    let FourBar { scene, crank, .. } = four_bar(1);
    let system = scene.compile().expect("a scene");
    let [.., angle] = crank.coordinates;
    let [once, twice] = [&[angle][..], &[angle, angle]].map(|hold| {
        let inputs = inputs(&system, hold, 1.5);
        assert_gradient_is_exact_with("held", &system, &inputs, Settings::default());
        simulate(&system, &inputs, Settings::default()).expect("a motion").nodes.q
    });
    assert_eq!(once, twice);
}
