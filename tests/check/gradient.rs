//! The gradient four ways, on scenes that use every kind of input; and gradients of the user's own.

use hamiltonian_adjoint::check::{self, Mistake, Part, Verdict};
use hamiltonian_adjoint::element::CostPoint;
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{Cost, Grid, Inputs, Scalar, Scene, Settings, Solver, Start, Sum, System, gradient, simulate};
use nalgebra::SVector;

fn cart(links: usize) -> (System, Inputs) {
    let system = CartPendulum::with_links(links).scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, if links > 5 { 0.01 } else { 0.02 }));
    inputs.controls.fill(10.0);
    (system, inputs)
}

/// ½ b (u² + v² + 0.01 σ²).
struct Running;

impl Cost<1, 1, 1, 1> for Running {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 1, 1>, b: &SVector<S, 1>) -> S {
        (at.u[0] * at.u[0] + at.v[0] * at.v[0] + at.sigma[0] * at.sigma[0] * 0.01) * b[0] * 0.5
    }
}

/// A pendulum with a spring, design variables everywhere, a running and a terminal cost.
fn pendulum() -> (System, Inputs) {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let [mass, length, stiffness] =
        [("mass", 1.2), ("half length", 0.5), ("stiffness", 30.0)].map(|(n, v)| scene.design(n, v));
    let torque = scene.control("torque");
    let rod = scene.body("rod", mass, 0.1, [0.0, -0.5, -std::f64::consts::FRAC_PI_2]);
    let pivot = scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    scene.spring_damper("spring", Body::GROUND.at(1.0, 0.0), rod.at(length, 0.0), stiffness, 0.8, 0.3);
    scene.torque_actuator("motor", Body::GROUND, rod, torque);
    let [_, _, angle] = rod.coordinates;
    scene.cost("running", Running, Sum::Trapezoidal, [angle], [pivot[0]], [torque], [length.into()]);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(60, 0.02));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = (0.3 * i as f64).sin());
    (system, inputs)
}

#[test]
fn the_papers_example_passes_in_every_direction_and_input() {
    let (system, inputs) = cart(3);
    let before = gradient(&system, &inputs, Settings::default()).expect("gradient");
    let copy = inputs.clone();
    let report = check::gradient(&system, &inputs, Settings::default()).complete().run().expect("motion");
    println!("{report}");
    report.assert_passed();
    assert_eq!(report.singles, 101 + 12 + 12 + 100);
    assert_eq!(inputs, copy);
    assert_eq!(gradient(&system, &inputs, Settings::default()).expect("gradient"), before);
}

#[test]
fn the_users_solver_is_not_touched() {
    let (system, inputs) = cart(2);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("motion");
    let motion = solver.trajectory().clone();
    check::gradient(&system, solver.inputs(), Settings::default()).run().expect("motion").assert_passed();
    assert_eq!(solver.trajectory(), &motion);
    assert!(solver.gradient().is_ok());
}

#[test]
fn design_variables_running_costs_and_given_momenta_pass() {
    let (system, mut inputs) = pendulum();
    let report = check::gradient(&system, &inputs, Settings::default()).directions(3, 5).complete().run().expect("motion");
    println!("{report}");
    report.assert_passed();
    assert!(report.directions.iter().all(|row| row.size > 0.0));
    let q = inputs.start.q().clone();
    let p_star = SVector::<f64, 3>::from([0.3, 0.1, 0.2]);
    inputs.start = Start::Momentum { q, p_star: nalgebra::DVector::from_column_slice(p_star.as_slice()) };
    check::gradient(&system, &inputs, Settings::default()).run().expect("motion").assert_passed();
}

#[test]
fn a_gradient_of_the_users_own_is_compared_number_by_number() {
    let (system, inputs) = pendulum();
    let right = gradient(&system, &inputs, Settings::default()).expect("gradient");
    let u: Vec<f64> = right.controls.iter().copied().collect();
    let last = u.len() - 1;
    let largest = u.iter().fold(0.0f64, |m, g| m.max(g.abs()));
    let cases: [(&str, Vec<f64>, Option<Mistake>); 9] = [
        ("right", u.clone(), None),
        ("with Δt, as Eq. (11) is printed", u.iter().map(|g| g * 0.02).collect(), Some(Mistake::Factor)),
        ("sign", u.iter().map(|g| -g).collect(), Some(Mistake::SignFlipped)),
        ("moved", (0..=last).map(|i| u[i.saturating_sub(1)]).collect(), Some(Mistake::OtherArgument)),
        ("u_0 forgotten", (0..=last).map(|i| if i == 0 { 0.0 } else { u[i] }).collect(), Some(Mistake::Zero)),
        ("continuous adjoint", u.iter().map(|g| g * (1.0 + 1e-4 * g.abs())).collect(), Some(Mistake::FewDigits)),
        ("not a number", (0..=last).map(|i| if i == 5 { f64::NAN } else { u[i] }).collect(), Some(Mistake::NotFinite)),
        ("one", (0..=last).map(|i| if i == 5 { u[i] + 1e-8 * largest } else { u[i] }).collect(), Some(Mistake::Unexplained)),
        ("one too few", u[1..].to_vec(), Some(Mistake::Shape)),
    ];
    for (name, values, mistake) in cases {
        let check = check::gradient(&system, &inputs, Settings::default()).own(name, Part::Controls, values);
        let report = check.run().expect("motion");
        let own = &report.own[0];
        println!("{own}");
        assert_eq!(own.verdict == Verdict::Right, mistake.is_none());
        assert!(!["not a number", "one"].contains(&name) || own.wrong_entries == 1);
        assert_eq!(own.diagnoses.first().map(|d| d.mistake), mistake, "{name}");
        assert_eq!(report.passed(), mistake.is_none());
    }
}

#[test]
fn a_cost_of_nothing_is_no_success() {
    let system = CartPendulum::with_links(1).mechanism().scene.compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.02));
    let report = check::gradient(&system, &inputs, Settings::default()).run().expect("motion");
    println!("{report}");
    assert_eq!(report.verdict(), Verdict::NothingCompared);
}

#[test]
fn a_derivative_that_is_zero_is_no_reason_for_alarm() {
    /// q + v σ².
    struct Reaction;
    impl Cost<1, 1> for Reaction {
        fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 1, 0>, _b: &SVector<S, 0>) -> S {
            at.q[0] + at.v[0] * at.sigma[0] * at.sigma[0]
        }
    }
    let mut scene = Scene::new();
    let rod = scene.body("rod", 1.3, 0.1, [0.3, -0.4, -0.9]);
    let pivot = scene.revolute(
        "pivot",
        Body::GROUND.at(0.0, 0.0),
        rod.at(-0.3 * 0.9f64.cos() - 0.4 * 0.9f64.sin(), -0.3 * 0.9f64.sin() + 0.4 * 0.9f64.cos()),
    );
    scene.cost("reaction", Reaction, Sum::Terminal, [rod.coordinates[2]], [pivot[0]], [], []);
    let system = scene.compile().expect("scene");
    // σ₀ = 0, and complex step leaves the square of its step.
    check::gradient(&system, &Inputs::at_rest(&system, Grid::uniform(0, 0.1)), Settings::default())
        .run()
        .expect("motion")
        .assert_passed();
}

/// ½ b₁ (φ − b₀)².
struct Aim;
impl Cost<1, 0, 0, 2> for Aim {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 2>) -> S {
        b[1] * (at.q[0] - b[0]).powi(2) * 0.5
    }
}

/// A rod on a hinge, started at rest at an angle, and its end angle aimed at: ½ b₁ (φ − b₀)².
fn aimed(at: f64, aim: impl Fn(f64) -> f64) -> (System, Inputs) {
    let build = |aim: f64| {
        let mut scene = Scene::new();
        scene.gravity(0.0, -9.81);
        let (mass, torque) = (scene.design("mass", 1.3), scene.control("torque"));
        let rod = scene.body("rod", mass, 0.1, [0.5 * at.cos(), 0.5 * at.sin(), at]);
        scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
        scene.torque_actuator("motor", Body::GROUND, rod, torque);
        scene.cost("aim", Aim, Sum::Terminal, [rod.coordinates[2]], [], [], [aim.into(), 1.0.into()]);
        scene.compile().expect("scene")
    };
    let inputs = Inputs::at_rest(&build(0.0), Grid::uniform(40, 0.02));
    let end = simulate(&build(0.0), &inputs, Settings::default()).expect("motion").q[(2, 40)];
    (build(aim(end)), inputs)
}

#[test]
fn a_motion_at_rest_has_a_right_gradient() {
    for links in 1..=3 {
        let system = CartPendulum::with_links(links).scene().compile().expect("scene");
        let inputs = Inputs::at_rest(&system, Grid::uniform(50, 0.02));
        let report = check::gradient(&system, &inputs, Settings::default()).run().expect("motion");
        println!("{report}");
        report.assert_passed();
    }
    // Hanging, with its target reached or not.
    for aim in [0.0, 1.0] {
        let (system, inputs) = aimed(-std::f64::consts::FRAC_PI_2, |end| end + aim);
        let report = check::gradient(&system, &inputs, Settings::default()).run().expect("motion");
        println!("{report}");
        assert!(matches!((report.verdict(), aim), (Verdict::Right, 1.0) | (Verdict::NothingCompared, 0.0)), "{aim}");
    }
}

/// The mass scales inertia and weight alike, so that the motion does not depend on it.
#[test]
fn a_design_variable_without_effect_has_a_right_gradient() {
    for length in [0.3, 1.0, 2.0] {
        for angle in [-0.4, 0.7, 2.0] {
            let mut scene = Scene::new();
            scene.gravity(0.0, -9.81);
            let mass = scene.design("mass", 0.8);
            let start = [0.5 * length * f64::cos(angle), 0.5 * length * f64::sin(angle), angle];
            let rod = scene.body("rod", mass, mass * (length * length / 12.0), start);
            scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(-0.5 * length, 0.0));
            scene.cost("aim", Aim, Sum::Terminal, [rod.coordinates[2]], [], [], [0.1.into(), 1.0.into()]);
            let system = scene.compile().expect("scene");
            let inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.01));
            let report = check::gradient(&system, &inputs, Settings::default()).directions(3, 1).complete().run();
            let report = report.expect("motion");
            println!("{length} {angle}: {report}");
            report.assert_passed();
            let products = check::hessian(&system, &inputs, Settings::default()).run().expect("motion");
            println!("{products}");
            products.assert_passed();
        }
    }
}

#[test]
fn a_gradient_that_vanishes_at_an_optimum_is_right() {
    for off in [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3] {
        let (system, inputs) = aimed(-1.0, |end| end + off);
        let report = check::gradient(&system, &inputs, Settings::default()).complete().run().expect("motion");
        println!("{off:e}: {report}");
        assert_eq!(report.verdict(), Verdict::Right, "{off:e}");
    }
}

/// x of a rod that hangs is zero but for rounding, and so is what most inputs do to it.
#[test]
fn a_cost_that_is_zero_by_cancellation_has_a_right_gradient() {
    struct Place;
    impl Cost<1> for Place {
        fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _: &SVector<S, 0>) -> S {
            at.q[0]
        }
    }
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let down = -std::f64::consts::FRAC_PI_2;
    let (mass, force) = (scene.design("mass", 1.3), scene.control("force"));
    let rod = scene.body("rod", mass, 0.1, [0.5 * down.cos(), 0.5 * down.sin(), down]);
    scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    scene.actuator("motor", Body::GROUND.at(0.0, -0.5), down, rod.at(0.0, 0.0), force);
    scene.cost("place", Place, Sum::Terminal, [rod.coordinates[0]], [], [], []);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.02));
    inputs.controls.fill(1.0);
    let report = check::gradient(&system, &inputs, Settings::default()).run().expect("motion");
    println!("{report}");
    report.assert_passed();
}

/// In kg, µN m and nN m, and one that is nearly zero.
#[test]
fn a_wrong_derivative_by_a_design_variable_is_found_in_any_units() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let [mass, coarse, fine, offset] =
        [("mass", 1.2), ("µN m", 2e6), ("nN m", 3e9), ("offset", 1e-12)].map(|(name, x)| scene.design(name, x));
    let rod = scene.body("rod", mass, 0.1, [0.5, 0.0, 0.0]);
    scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    scene.torsional_spring_damper("coarse", Body::GROUND, rod, coarse * 1e-6, offset, 0.0);
    scene.torsional_spring_damper("fine", Body::GROUND, rod, fine * 1e-9, 0.1, 0.0);
    scene.cost("angle", AngleError, Sum::Terminal, [rod.coordinates[2]], [], [], [0.3.into()]);
    let system = scene.compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(30, 0.02));
    let right = gradient(&system, &inputs, Settings::default()).expect("gradient").design;
    let verdict = |wrong: usize, factor: f64| {
        let mut own = right.clone();
        own[wrong] *= factor;
        let check = check::gradient(&system, &inputs, Settings::default());
        let report = check.own("mine", Part::Design, own.iter().copied()).run().expect("motion");
        println!("{}", report.own[0]);
        report.own[0].verdict
    };
    for wrong in 0..4 {
        assert_eq!(verdict(wrong, 1.0), Verdict::Right);
        assert_eq!(verdict(wrong, -1.0), Verdict::Wrong);
        assert_eq!(verdict(wrong, 1.0 + 1e-6), Verdict::Wrong);
    }
}

#[test]
fn a_right_gradient_of_ones_own_is_right_at_rest_and_at_an_optimum() {
    let hanging = |links| {
        let system = CartPendulum::with_links(links).scene().compile().expect("scene");
        let inputs = Inputs::at_rest(&system, Grid::uniform(50, 0.02));
        (system, inputs)
    };
    // At the target itself J and its gradient are zero, and nothing is compared.
    let aims = [1e-15, 1e-12, 1e-9, 1e-6].map(|off| aimed(-1.0, |end| end + off));
    for (system, inputs) in [1, 2, 3].map(hanging).into_iter().chain(aims) {
        let all = check::Input::all(&inputs);
        let own = check::complex_step(&system, &inputs, Settings::default(), &all).expect("motion");
        let (controls, n) = (inputs.controls.len(), system.n());
        let start = controls + inputs.design.len();
        let parts = [
            (Part::Controls, 0..controls),
            (Part::Design, controls..start),
            (Part::Coordinates, start..start + n),
            (Part::Rates, start + n..start + 2 * n),
            (Part::Steps, start + 2 * n..all.len()),
        ];
        for (part, range) in parts.into_iter().filter(|(_, range)| !range.is_empty()) {
            let check = check::gradient(&system, &inputs, Settings::default());
            let report = check.own("complex step", part, own[range].iter().copied()).run().expect("motion");
            println!("{report}");
            report.assert_passed();
        }
    }
}

#[test]
fn what_looks_moved_because_neighbours_are_alike_is_called_what_it_is() {
    /// x² + y at every node.
    struct Both;
    impl Cost<2> for Both {
        fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, _: &SVector<S, 0>) -> S {
            at.q[0] * at.q[0] + at.q[1]
        }
    }
    let mut scene = Scene::new();
    let body = scene.body("body", 1.0, 0.1, [0.0; 3]);
    for (name, angle) in [("f", 0.0), ("g", 1.5)] {
        let force = scene.control(name);
        scene.actuator(name, Body::GROUND.at(0.0, 0.0), angle, body.at(0.0, 0.0), force);
    }
    scene.cost("both", Both, Sum::Plain, [body.coordinates[0], body.coordinates[1]], [], [], []);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.05));
    inputs.controls.fill(1.0);
    let right = gradient(&system, &inputs, Settings::default()).expect("gradient");
    let says = |part, own: &[f64]| {
        let check = check::gradient(&system, &inputs, Settings::default());
        let report = check.own("mine", part, own.iter().copied()).run().expect("motion");
        println!("{}", report.own[0]);
        report.own[0].diagnoses[0].text.clone()
    };
    let [x, y, _] = [0, 1, 2].map(|i| right.start.rate()[i]);
    assert!(says(Part::Rates, &[0.0, y, 0.0]).starts_with("zero where it should not be: the initial rate of `body.x`"));
    assert!(says(Part::Rates, &[x, 0.0, 0.0]).starts_with("zero where it should not be: the initial rate of `body.y`"));
    assert!(says(Part::Rates, &[0.0; 3]).starts_with("zero where it should not be"));
    let moved = nalgebra::DMatrix::from_fn(2, 21, |k, node: usize| right.controls[(k, node.saturating_sub(1))]);
    assert_eq!(says(Part::Controls, moved.as_slice()), "moved by a node: node i has the derivatives of node i − 1");
}

#[test]
fn a_mechanism_at_rest_for_long_has_no_derivative_by_step_lengths_and_no_wrong_one() {
    let system = CartPendulum::with_links(2).scene().compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(2000, 0.015));
    let report = check::gradient(&system, &inputs, Settings::default()).run().expect("motion");
    println!("{report}");
    report.assert_passed();
}

/// ½ (φ − 0.3)² + b.
struct Raised;

impl Cost<1, 0, 0, 1> for Raised {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        (at.q[0] - 0.3).powi(2) * 0.5 + b[0]
    }
}

#[test]
fn what_is_hidden_by_the_rounding_of_a_large_cost_is_told() {
    for (raised, told) in [(0.0, false), (1e12, true)] {
        let mut cart = CartPendulum::with_links(1).mechanism();
        let angle = cart.links[0].coordinates[2];
        let output = cart.scene.output("raised");
        cart.scene.term(output, "raised", Raised, Sum::Terminal, [angle], [], [], [raised.into()]);
        let system = cart.scene.compile().expect("scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(30, 0.02));
        inputs.controls.fill(5.0);
        let report = check::gradient(&system, &inputs, Settings::default()).output(output).run().expect("motion");
        println!("{report}");
        report.assert_passed();
        assert_eq!(report.to_string().contains("its rounding hides dJ"), told);
    }
}
