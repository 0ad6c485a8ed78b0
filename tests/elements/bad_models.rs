//! Elements of a user's own that go wrong: no mass, NaN at the start or later, roots with infinite derivatives.

use crate::common::assert_says;
use crate::scenes::sled::{Formula, Mass, Own, sled};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Constraint, Coordinate, Cost, CostPoint, Error, Force, ForcePoint, Grid, Inputs, KineticEnergy, Scalar, Scene, Scheme,
    Settings, Solver, Sum, System, Warning, gradient, simulate,
};
use nalgebra::SVector;
use std::f64::consts::FRAC_PI_2;

fn failure(system: &System) -> Error {
    let inputs = Inputs::at_rest(system, Grid::uniform(20, 0.1));
    simulate(system, &inputs, Settings::default()).expect_err("a bad model").error
}

#[test]
fn a_mass_of_zero_is_reported_with_its_coordinate() {
    let error = failure(&sled(0.0, |_, _| ()));
    assert_eq!(error, Error::SingularMass { coordinates: vec!["`sled.x`".into()], time: 0.0 });
    assert_says(&error, &["`sled.x`", "neither inertia", "give each a mass", "a constraint that determines it"]);
}

#[test]
fn a_mass_of_zero_beside_a_sound_mechanism_is_reported_with_its_coordinate() {
    let mut scene = Scene::new();
    let rod = scene.body("rod", 1.0, 0.1, [0.5, 0.0, 0.0]);
    scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    let [x] = scene.coordinates("sled", ["x"]);
    scene.kinetic_energy("mass", Mass, [x], [0.0.into()]);
    assert!(
        matches!(failure(&scene.compile().expect("scene")), Error::SingularMass { coordinates, .. } if coordinates == ["`sled.x`"])
    );
}

/// q − 1 is never 0 at q = 0; used as a constraint that holds at the start only if shifted.
struct Held;
impl Formula for Held {
    fn at<S: Scalar>(&self, q: S, _v: S, _t: S) -> S {
        q
    }
}

#[test]
fn a_mass_of_zero_that_a_constraint_holds_does_no_harm() {
    let system = sled(0.0, |scene, x| _ = scene.constraint("stop", Own(Held), [x], []));
    let inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.1));
    let motion = simulate(&system, &inputs, Settings::default()).expect("motion");
    assert_eq!(motion.q.amax(), 0.0);
}

fn warnings(system: &System, inputs: &Inputs) -> Vec<Warning> {
    let mut solver = Solver::new(system, Settings::default());
    solver.simulate(inputs).expect("motion");
    solver.report().warnings.clone()
}

fn negative(coordinates: &[&str], mass: f64) -> Vec<Warning> {
    let coordinates = coordinates.iter().map(|name| format!("`{name}`")).collect();
    vec![Warning::NegativeMass { coordinates, mass, time: 0.0 }]
}

#[test]
fn a_mass_that_a_design_variable_makes_negative_is_named() {
    let mut scene = Scene::new();
    let [x] = scene.coordinates("sled", ["x"]);
    let mass = scene.design("mass", 1.0);
    scene.kinetic_energy("mass", Mass, [x], [mass.into()]);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(3, 0.1));
    assert_eq!(warnings(&system, &inputs), []);
    inputs.design[0] = -2.0;
    let found = warnings(&system, &inputs);
    assert_eq!(found, negative(&["sled.x"], -2.0));
    let message = found[0].to_string();
    println!("{message}");
    assert!(["t = 0.0 s", "`sled.x`", "-2.000e0", "bound design variables"].iter().all(|word| message.contains(word)));
}

/// Waves of so many different numbers.
struct Waves(usize);
impl Formula for Waves {
    fn at<S: Scalar>(&self, q: S, _v: S, _t: S) -> S {
        (0..self.0).fold(q, |sum, k| sum + (q + (k as f64).sqrt()).sin())
    }
}

#[test]
fn derivatives_that_are_too_long_for_a_program_are_warned_of_by_name() {
    let inputs = |system| Inputs::at_rest(system, Grid::uniform(1, 0.1));
    let system = |waves| {
        sled(1.0, |scene, x| {
            scene.potential_energy("waves", Own(Waves(waves)), [x], []);
            scene.cost("high", Own(Waves(waves)), Sum::Terminal, [x], [], [], []);
        })
    };
    let (short, long) = (system(10), system(66_000));
    assert_eq!(warnings(&short, &inputs(&short)), []);
    let found = warnings(&long, &inputs(&long));
    assert_eq!(found, [Warning::NoProgram { elements: vec!["waves".into(), "high".into()] }]);
    println!("{}", found[0]);
    assert!(found[0].to_string().contains("`waves`, `high`"));
}

/// ½ m (v₀² + v₁²) + c v₀ v₁, b = [m, c].
struct Coupled;
impl KineticEnergy<2, 2> for Coupled {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 2>, v: &SVector<S, 2>, b: &SVector<S, 2>) -> S {
        b[0] * v.dot(v) * 0.5 + b[1] * v[0] * v[1]
    }
}

#[test]
fn masses_that_are_negative_together_are_named() {
    for (coupling, expected) in [(-1.5, negative(&["pair.x", "pair.y"], 1.0)), (0.5, Vec::new())] {
        let mut scene = Scene::new();
        let pair = scene.coordinates("pair", ["x", "y"]);
        scene.kinetic_energy("masses", Coupled, pair, [1.0.into(), coupling.into()]);
        let system = scene.compile().expect("scene");
        assert_eq!(warnings(&system, &Inputs::at_rest(&system, Grid::uniform(3, 0.1))), expected);
    }
}

/// The hinge lets a rod of 1 kg less 2 kg along x turn: what stands upright moves along x, and what lies does not.
#[test]
fn a_negative_mass_that_constraints_hold_does_no_harm() {
    let lying = sled(-1.0, |scene, x| _ = scene.constraint("stop", Own(Held), [x], []));
    assert_eq!(warnings(&lying, &Inputs::at_rest(&lying, Grid::uniform(3, 0.1))), []);
    for (angle, expected) in [(0.0, Vec::new()), (FRAC_PI_2, negative(&["rod.x"], -1.0))] {
        let mut scene = Scene::new();
        let rod = scene.body("rod", 1.0, 0.1, [0.5 * f64::cos(angle), 0.5 * f64::sin(angle), angle]);
        scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
        scene.kinetic_energy("wrong", Mass, [rod.coordinates[0]], [(-2.0).into()]);
        let system = scene.compile().expect("scene");
        assert_eq!(warnings(&system, &Inputs::at_rest(&system, Grid::uniform(3, 0.001))), expected);
    }
}

#[test]
fn a_negative_mass_among_many_is_named() {
    let mut scene = Scene::new();
    for i in 0..450 {
        let x = scene.coordinates(&format!("sled {i}"), ["x"]);
        scene.kinetic_energy(&format!("mass {i}"), Mass, x, [if i == 77 { -1.0 } else { 1.0 }.into()]);
    }
    let system = scene.compile().expect("scene");
    assert_eq!(warnings(&system, &Inputs::at_rest(&system, Grid::uniform(3, 0.1))), negative(&["sled 77.x"], -1.0));
}

/// √(−1 − q²).
struct ImaginaryRoot;
impl Formula for ImaginaryRoot {
    fn at<S: Scalar>(&self, q: S, _v: S, _t: S) -> S {
        (-(q * q) - 1.0).sqrt()
    }
}

fn assert_blames(error: &Error, name: &str, at_node: usize) {
    let Error::Model { element, node, .. } = error else { panic!("{error:?}") };
    assert!(element.contains(name), "{error:?}");
    assert_eq!(*node, at_node, "{error:?}");
    assert_says(error, &[name, "not finite", &format!("node {at_node}"), "check its formula"]);
}

#[test]
fn a_force_that_is_nan_at_the_start_is_blamed() {
    assert_blames(&failure(&sled(1.0, |scene, x| scene.force("drag", Own(ImaginaryRoot), [x], [], []))), "`drag`", 0);
}

#[test]
fn a_potential_that_is_nan_at_the_start_is_blamed() {
    let system = sled(1.0, |scene, x| scene.potential_energy("spring", Own(ImaginaryRoot), [x], []));
    assert_blames(&failure(&system), "`spring`", 0);
}

#[test]
fn a_constraint_that_is_nan_at_the_start_is_blamed() {
    assert_blames(&failure(&sled(1.0, |scene, x| _ = scene.constraint("guide", Own(ImaginaryRoot), [x], []))), "`guide`", 0);
}

#[test]
fn a_spring_between_points_that_coincide_is_blamed() {
    let mut scene = Scene::new();
    let rod = scene.body("rod", 1.0, 0.1, [0.0; 3]);
    scene.spring_damper("strut", Body::GROUND.at(0.0, 0.0), rod.at(0.0, 0.0), 10.0, 0.5, 1.0);
    assert_blames(&failure(&scene.compile().expect("scene")), "`strut", 0);
}

/// √(0.95 − t), NaN after 0.95 s.
struct RunsOut;
impl Formula for RunsOut {
    fn at<S: Scalar>(&self, q: S, v: S, t: S) -> S {
        (-t + 0.95).sqrt() + (q + v) * 0.1
    }
}

#[test]
fn a_force_that_becomes_nan_later_is_blamed_with_its_time_and_the_motion_before_it_is_kept() {
    let system = sled(1.0, |scene, x| scene.force("fuel", Own(RunsOut), [x], [], []));
    let inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.1));
    let stopped = simulate(&system, &inputs, Settings::default()).expect_err("a bad model");
    assert_blames(&stopped.error, "`fuel`", 10);
    assert_says(&stopped.error, &["t = 1.0 s"]);
    assert_eq!(stopped.trajectory.computed, 10);
}

/// √v, with an infinite derivative at rest.
struct InfiniteSlope;
impl Formula for InfiniteSlope {
    fn at<S: Scalar>(&self, _q: S, v: S, _t: S) -> S {
        v.sqrt()
    }
}

#[test]
fn a_force_with_an_infinite_derivative_is_blamed() {
    assert_blames(&failure(&sled(1.0, |scene, x| scene.force("drag", Own(InfiniteSlope), [x], [], []))), "`drag`", 0);
}

/// √q, with an infinite derivative at the origin.
struct Tip;
impl Formula for Tip {
    fn at<S: Scalar>(&self, q: S, _v: S, _t: S) -> S {
        q.sqrt()
    }
}

#[test]
fn a_constraint_with_an_infinite_derivative_is_blamed() {
    assert_blames(&failure(&sled(1.0, |scene, x| _ = scene.constraint("guide", Own(Tip), [x], []))), "`guide`", 0);
}

/// A damper that drives, Q = +v: with Δt = 2 s the tangent matrix 1 − Δt/2 of a mass of 1 kg vanishes.
struct Drives;
impl Formula for Drives {
    fn at<S: Scalar>(&self, _q: S, v: S, _t: S) -> S {
        v
    }
}

#[test]
fn a_singular_tangent_matrix_is_reported_with_its_step_and_unknown() {
    let system = sled(1.0, |scene, x| scene.force("drive", Own(Drives), [x], [], []));
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.5));
    inputs.grid.steps[3] = 2.0;
    let settings = Settings { max_halvings: 0, ..Settings::default() };
    let stopped = simulate(&system, &inputs, settings).expect_err("a singular step");
    assert!(matches!(&stopped.error, Error::SingularStep { step: 4, .. }), "{:?}", stopped.error);
    assert_says(&stopped.error, &["step 4", "t = 3.5 s", "the velocity of `sled.x`", "time step is too long"]);
    assert_eq!(stopped.trajectory.computed, 4);
    // Half of the step has a regular matrix.
    assert_eq!(simulate(&system, &inputs, Settings::default()).expect("a halved step").inserted, [4]);
}

/// (t − 0.5)⁻¹ᐟ², infinite or NaN until 0.5 s.
struct SingularCost;
impl Formula for SingularCost {
    fn at<S: Scalar>(&self, q: S, _v: S, t: S) -> S {
        (t - 0.5).sqrt().recip() + q
    }
}

/// ln((t − 0.45)² − 0.04²), which has no number from 0.41 s to 0.49 s, and ln u̇.
struct Hole;
impl Cost<0> for Hole {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 0>, _b: &SVector<S, 0>) -> S {
        ((at.t - 0.45).powi(2) - 0.04 * 0.04).ln()
    }
}
impl Cost<0, 0, 1> for Hole {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 1>, _b: &SVector<S, 0>) -> S {
        at.u_dot[0].ln()
    }
}

/// Values name the cost and the place that gradients name: a stage between nodes, or the step after a node.
#[test]
fn costs_without_a_number_between_nodes_are_named_by_values_as_by_gradients() {
    let make = |slew: bool, sum: Sum| {
        let mut scene = Scene::new();
        let body = scene.body("body", 1.0, 0.1, [0.3, 0.0, 0.0]);
        let push = scene.control("push");
        scene.actuator("actuator", Body::GROUND.at(0.0, 0.0), 0.0, body.at(0.0, 0.0), push);
        if slew {
            scene.cost("bad", Hole, sum, [], [], [push], []);
        } else {
            scene.cost("bad", Hole, sum, [], [], [], []);
        }
        scene.compile().expect("a scene")
    };
    let sums = [Sum::Plain, Sum::Rectangle, Sum::Trapezoidal, Sum::Integral];
    let cases = sums.map(|sum| (true, sum)).into_iter().chain([(false, Sum::Integral)]);
    for (slew, sum) in cases {
        let system = make(slew, sum);
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(8, 0.1));
        let controls = [0.0, 1.0, 2.0, 3.0, 4.0, 3.5, 5.0, 6.0, 7.0];
        inputs.controls.iter_mut().zip(controls).for_each(|(u, value)| *u = value);
        let mut solver = Solver::new(&system, Settings { scheme: Scheme::ESDIRK4, ..Settings::default() });
        solver.simulate(&inputs).expect("a motion");
        let (of_value, of_gradient) = (solver.cost().expect_err("no number"), solver.gradient().expect_err("no number"));
        let is_named = matches!(&of_value, Error::Model { element, .. } if element == "`bad`");
        assert!(is_named, "{of_value}");
        if !slew {
            assert!(of_value.to_string().contains("t = 0.4") && of_gradient.to_string().contains("t = 0.4"), "{of_value}");
        }
    }
}

#[test]
fn a_cost_that_is_not_finite_is_blamed_instead_of_handed_on() {
    let system = sled(1.0, |scene, x| scene.cost("effort", Own(SingularCost), Sum::Rectangle, [x], [], [], []));
    let inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.1));
    let error = gradient(&system, &inputs, Settings::default()).expect_err("a bad cost");
    assert_blames(&error, "`effort`", 5);
}

/// b ln q, whose derivative by q is finite where ln q is no number.
struct Weighted;
impl Cost<1, 0, 0, 1> for Weighted {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        at.q[0].ln() * b[0]
    }
}

#[test]
fn a_constant_is_not_blamed_for_what_it_multiplies() {
    let system = sled(1.0, |scene, x| {
        let weight = scene.design("weight", 1.1);
        scene.place(x, -0.3);
        scene.cost("effort", Weighted, Sum::Rectangle, [x], [], [], [weight.into()]);
    });
    let inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.1));
    let error = gradient(&system, &inputs, Settings::default()).expect_err("a bad cost");
    let Error::Model { element, arguments, .. } = &error else { panic!("{error}") };
    assert_eq!((element.as_str(), arguments.as_str()), ("`effort`", "`sled.x` = -0.3"));
}

/// 1/(1 − t) + q: at the last node of a rectangle rule, where it is infinite, it counts for nothing.
struct SingularAtTheEnd;
impl Formula for SingularAtTheEnd {
    fn at<S: Scalar>(&self, q: S, _v: S, t: S) -> S {
        (-t + 1.0).recip() + q
    }
}

#[test]
fn a_cost_that_is_infinite_where_it_does_not_count_does_no_harm() {
    let system = sled(1.0, |scene, x| scene.cost("effort", Own(SingularAtTheEnd), Sum::Rectangle, [x], [], [], []));
    let inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.25));
    let gradient = gradient(&system, &inputs, Settings::default()).expect("gradient");
    assert!((gradient.value - (1.0 / 4.0 + 1.0 / 3.0 + 1.0 / 2.0 + 1.0)).abs() < 1e-14);
}

/// A force on nothing.
struct Nothing;
impl Force<0> for Nothing {
    fn force<S: Scalar>(&self, _at: &ForcePoint<S, 0, 0>, _b: &SVector<S, 0>) -> SVector<S, 0> {
        SVector::zeros()
    }
}

#[test]
fn elements_and_groups_without_coordinates_do_no_harm() {
    let system = sled(1.0, |scene, _| {
        scene.force("nothing", Nothing, [], [], []);
        scene.coordinates("nobody", []);
    });
    let inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.25));
    assert_eq!(simulate(&system, &inputs, Settings::default()).expect("motion").q.amax(), 0.0);
}

/// t = 0, whatever the coordinates.
struct Impossible;
impl Constraint<0, 1> for Impossible {
    fn phi<S: Scalar>(&self, _q: &SVector<S, 0>, _b: &SVector<S, 0>, t: S) -> SVector<S, 1> {
        SVector::from([t])
    }
}

#[test]
fn a_constraint_on_no_coordinates_is_reported_as_violated() {
    let error = failure(&sled(1.0, |scene, _| _ = scene.constraint("impossible", Impossible, [], [])));
    let Error::ContradictoryConstraints { equations, .. } = &error else { panic!("{error:?}") };
    assert_eq!(equations, &["`impossible`"]);
}

/// ln q, whose derivative 1/q is a number for q < 0 too.
struct Logarithm;
impl Formula for Logarithm {
    fn at<S: Scalar>(&self, q: S, _v: S, _t: S) -> S {
        q.ln()
    }
}

#[test]
fn a_potential_that_is_not_defined_is_blamed_though_its_force_is() {
    for (start, with_programs) in [(-1.0, true), (-1.0, false), (0.5, true)] {
        let mut scene = Scene::new();
        let [x] = scene.coordinates("sled", ["x"]);
        scene.kinetic_energy("mass", Mass, [x], [1.0.into()]);
        scene.potential_energy("pit", Own(Logarithm), [x], []);
        let system = if with_programs { scene.compile() } else { scene.compile_without_programs() }.expect("scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.1));
        inputs.start.set_coordinate(x, start);
        let Error::Model { element, arguments, node, .. } =
            simulate(&system, &inputs, Settings::default()).expect_err("ln of a negative number").error
        else {
            panic!("an undefined energy")
        };
        assert!(element == "`pit`" && arguments.starts_with("`sled.x` = -"), "{element}: {arguments}");
        assert_eq!(node == 0, start < 0.0);
    }
}

/// Q = (√(q₀ − 1), 0).
struct OfTheFirst;
impl Force<2> for OfTheFirst {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, _b: &SVector<S, 0>) -> SVector<S, 2> {
        SVector::from([(at.q[0] - 1.0).sqrt(), S::zero()])
    }
}

#[test]
fn what_a_formula_does_not_depend_on_is_not_blamed() {
    let mut scene = Scene::new();
    let q = scene.coordinates("sled", ["x", "y"]);
    q.iter().zip(["mass", "other mass"]).for_each(|(q, name)| scene.kinetic_energy(name, Mass, [*q], [1.0.into()]));
    scene.force("root", OfTheFirst, q, [], []);
    let error = failure(&scene.compile().expect("scene"));
    let Error::Model { arguments, .. } = &error else { panic!("{error}") };
    assert_eq!(arguments, "`sled.x` = 0.0");
}

/// Q = √u.
struct RootOfControl;
impl Force<1, 1> for RootOfControl {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([at.u[0].sqrt()])
    }
}

/// v̇.
struct Acceleration;
impl Cost<1> for Acceleration {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.v_dot[0]
    }
}

#[test]
fn an_infinite_slope_that_a_cost_on_accelerations_meets_is_that_of_the_force() {
    let system = sled(1.0, |scene, x| {
        let u = scene.control("valve");
        scene.force("jet", RootOfControl, [x], [u], []);
        scene.cost("felt", Acceleration, Sum::Terminal, [x], [], [], []);
    });
    let inputs = Inputs::at_rest(&system, Grid::uniform(3, 0.1));
    let error = gradient(&system, &inputs, Settings::default()).expect_err("an infinite slope");
    assert_says(&error, &["`jet`", "`valve` = 0.0", "node 3"]);
}

/// q^1.5, whose second derivative at the origin is infinite.
struct Cusp;
impl Formula for Cusp {
    fn at<S: Scalar>(&self, q: S, _v: S, _t: S) -> S {
        q.powf(1.5)
    }
}

#[test]
fn an_infinite_second_derivative_is_blamed_with_its_node() {
    let elements: [fn(&mut Scene, Coordinate); 2] = [
        |scene, x| scene.force("pad", Own(Cusp), [x], [], []),
        |scene, x| scene.cost("pad", Own(Cusp), Sum::Rectangle, [x], [], [], []),
    ];
    for place in elements {
        for with_programs in [true, false] {
            let mut scene = Scene::new();
            let [x] = scene.coordinates("sled", ["x"]);
            scene.kinetic_energy("mass", Mass, [x], [1.0.into()]);
            place(&mut scene, x);
            // So that adjoint variables are not zero.
            scene.cost("push", Own(Held), Sum::Terminal, [x], [], [], []);
            let system = if with_programs { scene.compile() } else { scene.compile_without_programs() }.expect("scene");
            let inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.1));
            let mut solver = Solver::new(&system, Settings::default());
            solver.simulate(&inputs).expect("a motion");
            let mut direction = inputs.no_change();
            direction.start.q_mut()[0] = 1.0;
            let error = solver.hessian_product(&direction).expect_err("an infinite second derivative");
            assert_says(&error, &["`pad`", "not finite for `sled.x` = 0.0", "node "]);
        }
    }
}

/// Both ways to compile a mass on a line with something of the user's own.
fn both(add: impl Fn(&mut Scene, Coordinate)) -> [System; 2] {
    [Scene::compile, Scene::compile_without_programs].map(|compile| {
        let mut scene = Scene::new();
        let [x] = scene.coordinates("sled", ["x"]);
        scene.kinetic_energy("mass", Mass, [x], [1.0.into()]);
        scene.cost("end", Own(Held), Sum::Terminal, [x], [], [], []);
        add(&mut scene, x);
        compile(scene).expect("scene")
    })
}

/// (q^2.5)^0.8, whose slope at the origin is 0 · ∞.
struct PowerOfPower;
impl Formula for PowerOfPower {
    fn at<S: Scalar>(&self, q: S, _v: S, _t: S) -> S {
        q.powf(2.5).powf(0.8)
    }
}

#[test]
fn a_slope_of_zero_times_infinity_is_blamed_with_and_without_programs() {
    let elements: [fn(&mut Scene, Coordinate); 3] = [
        |scene, x| scene.force("pad", Own(PowerOfPower), [x], [], []),
        |scene, x| scene.potential_energy("pad", Own(PowerOfPower), [x], []),
        |scene, x| scene.cost("pad", Own(PowerOfPower), Sum::Rectangle, [x], [], [], []),
    ];
    for add in elements {
        let errors = both(add).map(|system| {
            let inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.1));
            gradient(&system, &inputs, Settings::default()).expect_err("no slope")
        });
        assert_says(&errors[0], &["`pad`", "not finite for `sled.x` = 0.0", "node "]);
        assert_eq!(errors[0], errors[1]);
    }
}

/// (q²)^1.5 = |q|³ and (v²)^1.5, whose second derivatives are 0 where their powers of the slopes are infinite.
struct Cube;
impl Formula for Cube {
    fn at<S: Scalar>(&self, q: S, v: S, _t: S) -> S {
        (q * q).powf(1.5) + (v * v).powf(1.5) + (q - 0.5) * (q - 0.5)
    }
}

#[test]
fn a_cube_of_a_distance_has_second_derivatives_where_the_distance_vanishes() {
    let elements: [fn(&mut Scene, Coordinate); 3] = [
        |scene, x| scene.force("pad", Own(Cube), [x], [], []),
        |scene, x| scene.cost("pad", Own(Cube), Sum::Rectangle, [x], [], [], []),
        // Its third derivatives jump.
        |scene, x| scene.potential_energy("pad", Own(Cube), [x], []),
    ];
    for (k, add) in elements.into_iter().enumerate() {
        let [ours, plain] = both(add).map(|system| {
            let inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.1));
            let mut solver = Solver::new(&system, Settings::default());
            solver.simulate(&inputs).expect("a motion");
            let slope = solver.gradient().expect("a gradient").start.q()[0];
            let mut direction = inputs.no_change();
            direction.start.q_mut()[0] = 1.0;
            let second = (k < 2).then(|| solver.hessian_product(&direction).expect("second derivatives").start.q()[0]);
            [slope, second.unwrap_or_default()]
        });
        assert!(ours.iter().zip(&plain).all(|(x, y)| (x - y).abs() <= 1e-12), "{ours:?} {plain:?}");
    }
}

/// g q + 1/t and g q + ln(−1), in which q is no argument of what is not defined.
struct Began;
impl Formula for Began {
    fn at<S: Scalar>(&self, q: S, _v: S, t: S) -> S {
        q * 9.81 + S::one() / t
    }
}
struct Impossibly;
impl Formula for Impossibly {
    fn at<S: Scalar>(&self, q: S, _v: S, _t: S) -> S {
        q * 9.81 + S::from(-1.0).ln()
    }
}

#[test]
fn a_potential_that_is_not_defined_at_first_or_never_is_blamed_with_and_without_programs() {
    let elements: [fn(&mut Scene, Coordinate); 2] = [
        |scene, x| scene.potential_energy("pit", Own(Began), [x], []),
        |scene, x| scene.potential_energy("pit", Own(Impossibly), [x], []),
    ];
    for add in elements {
        both(add).iter().for_each(|system| assert_blames(&failure(system), "`pit`", 0));
    }
}

/// The larger of q and √(−1 − q²), which is not defined, twice squared.
struct Larger;
impl Formula for Larger {
    fn at<S: Scalar>(&self, q: S, _v: S, _t: S) -> S {
        let larger = (q + 0.3).max((-(q * q) - 1.0).sqrt());
        larger * larger * larger
    }
}

#[test]
fn what_a_maximum_cuts_off_has_no_second_derivatives_either() {
    let products = both(|scene, x| scene.potential_energy("pad", Own(Larger), [x], [])).map(|system| {
        let inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.1));
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&inputs).expect("a motion");
        let mut direction = inputs.no_change();
        direction.start.q_mut()[0] = 1.0;
        solver.hessian_product(&direction).expect("second derivatives").start.q()[0]
    });
    assert!((products[0] - products[1]).abs() <= 1e-12 * products[1].abs(), "{products:?}");
}

/// u ln q, whose derivatives by q are numbers at u = 0, and by u are not.
struct Torque;
impl Cost<1, 0, 1> for Torque {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 1>, _b: &SVector<S, 0>) -> S {
        at.u[0] * at.q[0].ln()
    }
}

/// ½ (5 + ln q) v².
struct Thinning;
impl KineticEnergy<1> for Thinning {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        (q[0].ln() + 5.0) * v[0] * v[0] * 0.5
    }
}

/// ln q₀ − ln q₁.
struct Ratio;
impl Constraint<2, 1> for Ratio {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 1> {
        SVector::from([q[0].ln() - q[1].ln()])
    }
}

#[test]
fn arguments_are_blamed_with_others_in_the_place_of_which_there_is_a_number() {
    let at = |add: &dyn Fn(&mut Scene, Coordinate)| {
        let mut scene = Scene::new();
        let [x] = scene.coordinates("sled", ["x"]);
        scene.place(x, -0.5);
        add(&mut scene, x);
        let system = scene.compile().expect("scene");
        let mut solver = Solver::new(&system, Settings::default());
        let motion = solver.simulate(&Inputs::at_rest(&system, Grid::uniform(2, 0.1))).map(|_| ());
        motion.and_then(|()| solver.cost()).expect_err("no number")
    };
    let cost = at(&|scene, x| {
        let u = scene.control("u");
        scene.kinetic_energy("mass", Mass, [x], [1.0.into()]);
        scene.cost("torque", Torque, Sum::Terminal, [x], [], [u], []);
    });
    let energy = at(&|scene, x| scene.kinetic_energy("thinning", Thinning, [x], []));
    for (error, name) in [(cost, "`torque`"), (energy, "`thinning`")] {
        let Error::Model { element, arguments, .. } = &error else { panic!("{error}") };
        assert_eq!((element.as_str(), arguments.as_str()), (name, "`sled.x` = -0.5"));
    }
    let mut scene = Scene::new();
    let q = scene.coordinates("sled", ["x", "y"]);
    for (coordinate, name) in q.into_iter().zip(["mass", "other mass"]) {
        scene.place(coordinate, -0.5);
        scene.kinetic_energy(name, Mass, [coordinate], [1.0.into()]);
    }
    scene.constraint("ratio", Ratio, q, []);
    let error = failure(&scene.compile().expect("scene"));
    assert_says(&error, &["`ratio`", "`sled.x` = -0.5", "`sled.y` = -0.5"]);
}
