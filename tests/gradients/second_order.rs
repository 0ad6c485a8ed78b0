//! Products of the Hessian: symmetric, and those of hyper-dual numbers through the whole simulation.

use crate::common::bench::{Bench, Part, from_velocity, lively, number};
use crate::common::{assert_gradient_is_exact_with, assert_says};
use crate::scenes::pieces::Piece;
use crate::scenes::points::Net;
use crate::scenes::{elements, pieces, points, ready_parts};
use hamiltonian_adjoint::check::{self, Input};
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{
    Composition, Cost, CostPoint, Force, ForcePoint, Gradient, Grid, Hyper, Inputs, KineticEnergy, LiftedSolver, Real,
    Scalar, Scene, Scheme, Settings, Solver, Start, Sum, System, simulate,
};
use nalgebra::SVector;

/// A direction in which every input moves, as far as it is large.
fn direction(inputs: &Inputs, seed: usize) -> Inputs {
    let mut direction = inputs.no_change();
    for (k, input) in Input::all(inputs).into_iter().enumerate() {
        let size = match input {
            Input::Step(i) => 0.3 * inputs.grid.steps[i - 1],
            Input::Design(p) => 0.3 * inputs.design[p],
            _ => 0.3,
        };
        *input.of(&mut direction) = size * number(seed + 7 * k);
    }
    direction
}

/// All inputs with their values.
fn values(inputs: &Inputs) -> Vec<(Input, f64)> {
    let mut own = inputs.clone();
    Input::all(inputs).into_iter().map(|input| (input, *input.of(&mut own))).collect()
}

fn along(gradient: &Gradient, direction: &Inputs) -> f64 {
    values(direction).into_iter().map(|(input, d)| input.in_gradient(gradient) * d).sum()
}

fn size_along(gradient: &Gradient, direction: &Inputs) -> f64 {
    values(direction).into_iter().map(|(input, d)| (input.in_gradient(gradient) * d).abs()).sum()
}

/// The second derivative of J along two directions, and the first along one, by hyper-dual numbers.
fn by_hyper(system: &System, inputs: &Inputs, settings: Settings, [first, second]: [&Inputs; 2]) -> [f64; 2] {
    let mut solver = LiftedSolver::<Hyper>::new(system, inputs, settings).expect("a motion");
    let mut lifted = inputs.lift::<Hyper>();
    for (part, direction) in [(1, first), (2, second)] {
        for (input, d) in values(direction) {
            input.of(&mut lifted).add_to_part(part, d);
        }
    }
    lifted.grid.start.add_to_part(1, first.grid.start);
    solver.simulate(&lifted).expect("the same motion");
    let cost = solver.cost().expect("a cost");
    [cost.part(3), cost.part(1)]
}

/// Symmetric, and equal to hyper-dual numbers; returns the larger error, relative to the terms.
fn error(what: &str, system: &System, inputs: &Inputs, settings: Settings) -> f64 {
    let (a, b) = (direction(inputs, 1), direction(inputs, 1001));
    let mut solver = Solver::new(system, settings);
    solver.simulate(inputs).unwrap_or_else(|error| panic!("{what}: {error}"));
    let of_a = solver.hessian_product(&a).unwrap_or_else(|error| panic!("{what}: {error}")).clone();
    let of_b = solver.hessian_product(&b).unwrap_or_else(|error| panic!("{what}: {error}")).clone();
    let (ab, ba) = (along(&of_a, &b), along(&of_b, &a));
    let size = size_along(&of_a, &b).max(size_along(&of_b, &a));
    let [reference, slope] = by_hyper(system, inputs, settings, [&a, &b]);
    let (asymmetry, error) = ((ab - ba).abs() / size, (ab - reference).abs() / size);
    let of_value = (of_a.value - slope).abs() / slope.abs();
    println!("{what:40} asymmetry {asymmetry:.1e}, error {error:.1e}, of the value {of_value:.1e}");
    assert!(asymmetry < 1e-12, "{what}: {ab} {ba}");
    assert!(error < 1e-10, "{what}: {ab} {reference}");
    assert!(of_value < 1e-10, "{what}: {} {slope}", of_a.value);
    asymmetry.max(error)
}

#[test]
fn products_of_the_cart_are_exact() {
    let system = CartPendulum::default().scene().compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
    inputs.controls.fill(10.0);
    error("cart", &system, &inputs, Settings::default());
}

#[test]
fn products_are_exact_for_loops_and_design_variables() {
    for sum in [Sum::Plain, Sum::AllNodes, Sum::Rectangle, Sum::Trapezoidal, Sum::Integral, Sum::Node(3)] {
        for (name, build) in [("four bar", Bench::four_bar as fn(&mut Bench)), ("five bar", Bench::five_bar)] {
            let mut bench = Bench::new();
            build(&mut bench);
            let system = bench.compile(sum);
            let inputs = lively(&system, 12, 0.02);
            for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK4] {
                let settings = Settings { scheme, ..Settings::default() };
                let what = format!("{name}, {sum:?}, {}", scheme.name);
                error(&what, &system, &inputs, settings);
                error(&format!("{what}, from velocities"), &system, &from_velocity(&system, &inputs), settings);
            }
        }
    }
}

/// A cost with M(q)-like products of everything that both arms have.
struct Mixed;

impl<const N: usize> Cost<N, 0, 1, 1> for Mixed {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, N, 0, 1>, b: &SVector<S, 1>) -> S {
        let terms = (0..N).map(|i| (at.q[i] * (at.v[i] + at.t)).sin() + at.u[0] * at.v[i] * at.q[i]);
        terms.fold(at.u_dot[0] * at.u_dot[0] * 0.01 + at.u[0] * at.u[0], |sum, term| sum + term) * b[0]
    }
}

/// v̇².
struct Felt;

impl Cost<3> for Felt {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.v_dot.dot(&at.v_dot)
    }
}

#[test]
fn products_are_exact_whatever_the_element_with_and_without_its_program() {
    let mut worst = 0.0f64;
    for kind in elements::kinds().into_iter().chain(ready_parts::kinds()) {
        for with_programs in [true, false] {
            let scene = elements::with(kind, |arms| {
                let scale = arms.scene.design("scale", 0.4);
                let motor = arms.scene.control("unused but in the cost");
                let q = arms.lower.coordinates;
                arms.scene.cost("mixed", Mixed, Sum::Integral, q, [], [motor], [scale * scale]);
                arms.scene.cost("end", Mixed, Sum::Terminal, arms.upper.coordinates, [], [motor], [scale.into()]);
            });
            let system = if with_programs { scene.compile() } else { scene.compile_without_programs() }.expect("a scene");
            let inputs = lively(&system, 6, 0.02);
            let what = format!("{}, programs: {with_programs}", kind.0);
            worst = worst.max(error(&what, &system, &inputs, Settings::default()));
        }
    }
    println!("largest error {worst:.1e}");
}

#[test]
fn products_are_exact_for_points_that_are_tied_together() {
    for (count, net) in [(3, Net::Chain), (7, Net::Chain), (7, Net::Tangled)] {
        let system = points::points::<2, 4>(count, net).compile().expect("a scene");
        error(&format!("{net:?} of {count}"), &system, &lively(&system, 4, 0.01), Settings::default());
    }
}

#[test]
fn products_are_exact_with_dependent_constraints_halved_steps_and_composed_grids() {
    // Three parallel cranks.
    let mut bench = Bench::new();
    let feet = [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]];
    let head = |[x, y]: [f64; 2]| [x + 0.2, y + 0.4];
    let coupler = bench.rod(head(feet[0]), head(feet[2]));
    for (k, foot) in feet.into_iter().enumerate() {
        let crank = bench.rod(foot, head(foot));
        bench.hinge(Part::GROUND, crank, foot);
        bench.hinge(crank, coupler, head(foot));
        if k == 0 {
            bench.drive(Part::GROUND, crank);
        }
    }
    // Not of σ, which dependent constraints share by their compliances.
    let (b, control, q) = (bench.bound(0.7), bench.control, coupler.body.coordinates().expect("a body"));
    bench.scene.cost("mixed", Mixed, Sum::Trapezoidal, q, [], [control], [b.into()]);
    let system = bench.scene.compile().expect("a scene");
    let inputs = from_velocity(&system, &lively(&system, 8, 0.02));
    for rebase_every in [0, 2] {
        let settings = Settings { rebase_every, ..Settings::default() };
        let mut solver = Solver::new(&system, settings);
        let motion = solver.simulate(&inputs).expect("a motion");
        assert!(!motion.compliance.is_empty() && motion.restarted.is_empty() == (rebase_every == 0));
        // Design variables and initial coordinates would contradict dependent constraints.
        let mut a = direction(&inputs, 1);
        a.design.fill(0.0);
        a.start.q_mut().fill(0.0);
        a.start.rate_mut().fill(0.0);
        let b = Inputs { controls: direction(&inputs, 501).controls, ..a.clone() };
        let of_a = solver.hessian_product(&a).expect("a product").clone();
        let of_b = solver.hessian_product(&b).expect("a product").clone();
        let [reference, _] = by_hyper(&system, &inputs, settings, [&a, &b]);
        let (ab, ba, size) = (along(&of_a, &b), along(&of_b, &a), size_along(&of_a, &b));
        let (asymmetry, error) = ((ab - ba).abs() / size, (ab - reference).abs() / size);
        println!("dependent constraints: asymmetry {asymmetry:.1e}, error {error:.1e}");
        assert!(asymmetry < 1e-9 && error < 1e-8, "{ab} {ba} {reference}");
    }

    // A pendulum that falls through in steps that are too long for it.
    let mut bench = Bench::new();
    let rod = bench.rod([0.0, 0.0], [0.3, 0.0]);
    bench.hinge(Part::GROUND, rod, [0.0, 0.0]);
    bench.drive(Part::GROUND, rod);
    let system = bench.compile(Sum::Rectangle);
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(3, 0.5));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 2.0 * number(i));
    for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK4] {
        let settings = Settings { scheme, max_iterations: 4, ..Settings::default() };
        let halved = simulate(&system, &inputs, settings).expect("a motion").inserted.len();
        println!("{halved} nodes inserted");
        assert!(scheme != Scheme::TRAPEZOIDAL || halved > 0);
        error(&format!("halved steps, {}", scheme.name), &system, &inputs, settings);
    }
    let inputs =
        Inputs { grid: Grid::composed(4, 0.1, Composition::Suzuki4), ..Inputs::at_rest(&system, Grid::uniform(20, 0.02)) };
    error("a composed grid with steps back", &system, &inputs, Settings::default());
}

#[test]
fn products_go_through_the_assembly_of_a_start() {
    for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK4] {
        let mut bench = Bench::new();
        bench.four_bar();
        let crank = bench.parts[0].body.coordinates().expect("a body")[2];
        let system = bench.compile(Sum::Trapezoidal);
        let mut inputs = lively(&system, 8, 0.02);
        for held in [false, true] {
            inputs.start = Start::assembled(&system);
            inputs.start.set_rate(crank, 0.8);
            if held {
                inputs.start = inputs.start.hold(&[crank]);
            }
            // A guess that is none of the mechanism's positions.
            inputs.start.q_mut().iter_mut().enumerate().for_each(|(i, q)| *q += 0.01 * number(i));
            let settings = Settings { scheme, ..Settings::default() };
            error(&format!("assembled, {}, held: {held}", scheme.name), &system, &inputs, settings);
        }
    }
}

/// T = ½ b (1 + q²) q̇².
struct Growing;
impl KineticEnergy<1, 1> for Growing {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 1>, v: &SVector<S, 1>, b: &SVector<S, 1>) -> S {
        b[0] * (q[0] * q[0] + 1.0) * v[0] * v[0] * 0.5
    }
}

/// p*₀ = T_v(q₀, v₀) is that of the given velocities, whatever v is at node 0.
#[test]
fn velocities_that_violate_constraints_within_the_tolerance_have_exact_derivatives() {
    for (name, build) in [("four bar", Bench::four_bar as fn(&mut Bench)), ("five bar", Bench::five_bar)] {
        let mut bench = Bench::new();
        build(&mut bench);
        let [x, _, angle] = bench.parts[1].body.coordinates().expect("a body");
        for (of, q) in [("x", x), ("the angle", angle)] {
            let b = bench.bound(0.3);
            bench.scene.kinetic_energy(&format!("growing with {of}"), Growing, [q], [b.into()]);
        }
        let system = bench.compile(Sum::Trapezoidal);
        let mut inputs = from_velocity(&system, &lively(&system, 8, 0.02));
        let Start::Velocity { v, .. } = &mut inputs.start else { panic!("velocities") };
        v.iter_mut().enumerate().for_each(|(i, v)| *v += 0.1 * number(i));
        for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK4] {
            let settings = Settings { scheme, velocity_tolerance: 1.0, ..Settings::default() };
            let mut solver = Solver::new(&system, settings);
            let motion = solver.simulate(&inputs).expect("a motion");
            assert!(motion.sigma.column(0).amax() > 1e-3);
            let what = format!("{name}, {}", scheme.name);
            assert_gradient_is_exact_with(&what, &system, &inputs, settings);
            error(&what, &system, &inputs, settings);
        }
    }
}

#[test]
fn the_time_at_which_an_assembled_start_is_assembled_is_a_direction_too() {
    let mut bench = Bench::new();
    bench.five_bar();
    let system = bench.compile(Sum::Trapezoidal);
    let mut inputs = lively(&system, 8, 0.02);
    inputs.grid.start = 0.4;
    inputs.start = Start::assembled(&system);
    let (mut a, b) = (direction(&inputs, 1), direction(&inputs, 1001));
    let mut solver = Solver::new(&system, Settings::default());
    for alone in [false, true] {
        if alone {
            a = inputs.no_change();
        }
        a.grid.start = 0.7;
        solver.simulate(&inputs).expect("a motion");
        let of_a = solver.hessian_product(&a).expect("a product").clone();
        let [reference, slope] = by_hyper(&system, &inputs, Settings::default(), [&a, &b]);
        let (of_both, size) = (along(&of_a, &b), size_along(&of_a, &b));
        println!("{} {slope}, {of_both} {reference}", of_a.value);
        assert!((of_a.value - slope).abs() < 1e-11 * slope.abs());
        assert!((of_both - reference).abs() < 1e-11 * size);
    }
}

#[test]
fn hyper_dual_numbers_go_through_motions_that_are_started_anew() {
    let mut bench = Bench::new();
    bench.four_bar();
    let system = bench.compile(Sum::Trapezoidal);
    let inputs = from_velocity(&system, &lively(&system, 12, 0.02));
    for settings in
        [Settings { rebase_every: 3, ..Settings::default() }, Settings { drift_bound: 0.0, ..Settings::default() }]
    {
        let (mut a, b) = (direction(&inputs, 1), direction(&inputs, 1001));
        // Moved coordinates and lengths would leave the constraints in a real motion.
        a.start = inputs.no_change().start;
        a.design.fill(0.0);
        let mut solver = Solver::new(&system, settings);
        let mut slope = |step: f64| {
            let mut moved = inputs.clone();
            values(&a).into_iter().for_each(|(input, d)| *input.of(&mut moved) += step * d);
            assert!(!solver.simulate(&moved).expect("a motion").restarted.is_empty());
            along(solver.gradient().expect("a gradient"), &b)
        };
        let [far, near] = [2e-3, 1e-3].map(|step| (slope(step) - slope(-step)) / (2.0 * step));
        let expected = near + (near - far) / 3.0;
        let [mixed, _] = by_hyper(&system, &inputs, settings, [&a, &b]);
        println!("{mixed} {expected}");
        assert!((mixed - expected).abs() < 1e-7 * expected.abs(), "{mixed} {expected}");
    }
}

#[test]
fn products_go_through_restarts() {
    let rebase = |rebase_every| Settings { rebase_every, ..Settings::default() };
    let drift = |drift_bound| Settings { drift_bound, ..Settings::default() };
    let both = Settings { rebase_every: 2, ..drift(1e-6) };
    for sum in [Sum::Plain, Sum::Integral] {
        for (name, build) in [("four bar", Bench::four_bar as fn(&mut Bench)), ("five bar", Bench::five_bar)] {
            let mut bench = Bench::new();
            build(&mut bench);
            let system = bench.compile(sum);
            let inputs = from_velocity(&system, &lively(&system, 12, 0.02));
            for (how, settings) in
                [("rebased", rebase(3)), ("at every step", rebase(1)), ("projected", drift(0.0)), ("both", both)]
            {
                for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK4] {
                    let settings = Settings { scheme, ..settings };
                    let restarts = simulate(&system, &inputs, settings).expect("a motion").restarted.len();
                    // A scheme that hardly drifts is rebased alone.
                    assert!(restarts > 2, "{name}, {how}: {restarts}");
                    error(&format!("{name}, {sum:?}, {how}, {}", scheme.name), &system, &inputs, settings);
                }
            }
            let mut assembled = inputs.clone();
            assembled.start = Start::assembled(&system);
            error(&format!("{name}, {sum:?}, assembled, both"), &system, &assembled, both);
            let grid = Grid::composed(3, 0.08, Composition::Suzuki4);
            let mut composed = Inputs { grid, ..Inputs::at_rest(&system, Grid::uniform(15, 0.02)) };
            composed.start = Start::assembled(&system);
            error(&format!("{name}, {sum:?}, composed, both"), &system, &composed, both);
        }
    }
}

/// ½ (q − b)² where q ends at b: the gradient is zero, and so are all adjoint variables.
#[test]
fn a_product_is_there_where_the_gradient_vanishes() {
    let mut cart = CartPendulum::with_links(2).mechanism();
    let aim = cart.scene.design("aim", 0.0);
    let angle = cart.links[1].coordinates[2];
    cart.scene.cost("end", AngleError, Sum::Terminal, [angle], [], [], [aim.into()]);
    let system = cart.scene.compile().expect("a scene");
    let mut inputs = lively(&system, 12, 0.03);
    let plain = Settings::default();
    for settings in [
        plain,
        Settings { scheme: Scheme::ESDIRK4, ..plain },
        Settings { rebase_every: 3, ..plain },
        Settings { drift_bound: 0.0, ..plain },
    ] {
        inputs.design[0] = simulate(&system, &inputs, settings).expect("a motion").q[(angle.index(), 12)];
        let mut solver = Solver::new(&system, settings);
        solver.simulate(&inputs).expect("a motion");
        assert_eq!(solver.gradient().expect("a gradient").controls.amax(), 0.0);
        let (a, b) = (direction(&inputs, 1), direction(&inputs, 1001));
        let product = along(solver.hessian_product(&a).expect("a product"), &b);
        let [reference, _] = by_hyper(&system, &inputs, settings, [&a, &b]);
        assert!(reference.abs() > 1e-3 && (product - reference).abs() < 1e-11 * reference.abs(), "{product} {reference}");
        // Also of the motion that comes next, when there is a record already.
        solver.simulate(&inputs).expect("a motion");
        assert_eq!(along(solver.hessian_product(&a).expect("a product"), &b), product);
    }
}

#[test]
fn what_has_no_second_derivatives_is_said() {
    let mut bench = Bench::new();
    bench.four_bar();
    let system = bench.compile(Sum::Plain);
    let inputs = lively(&system, 12, 0.02);
    let change = inputs.no_change();
    let mut solver = Solver::new(&system, Settings::default());
    assert_says(&solver.hessian_product(&change).expect_err("no motion"), &["no motion", "simulate"]);
    solver.simulate(&inputs).expect("a motion");
    let short = Inputs::at_rest(&system, Grid::uniform(3, 0.1)).no_change();
    assert_says(&solver.hessian_product(&short).expect_err("too short"), &["direction", "expected 12", "found 3"]);
    let mut bad = change.clone();
    bad.design[0] = f64::NAN;
    assert_says(&solver.hessian_product(&bad).expect_err("NaN"), &["direction", "NaN"]);
    assert_eq!(solver.hessian_product(&change).expect("nothing").controls.amax(), 0.0);
    let mut cart = CartPendulum::with_links(1).mechanism();
    cart.scene.cost("felt", Felt, Sum::Terminal, cart.links[0].coordinates, [], [], []);
    let system = cart.scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.1));
    let mut lifted = LiftedSolver::<Hyper>::new(&system, &inputs, Settings::default()).expect("a motion");
    lifted.simulate(&inputs.lift()).expect("the same motion");
    assert_says(&lifted.cost().expect_err("accelerations"), &["hyper-dual numbers", "accelerations", "hessian_product"]);
}

#[test]
fn changes_of_outputs_are_those_of_their_gradients() {
    let mut cart = CartPendulum::with_links(2).mechanism();
    for (k, sum) in [Sum::Terminal, Sum::Integral, Sum::Node(4), Sum::Rectangle].into_iter().enumerate() {
        let (q, force) = (cart.links[k % 2].coordinates, cart.force);
        let of = cart.scene.output(&format!("output {k}"));
        let b = cart.scene.design(&format!("b{k}"), 0.7);
        cart.scene.term(of, &format!("term {k}"), Mixed, sum, q, [], [force], [b * b]);
    }
    let system = cart.scene.compile().expect("a scene");
    let inputs = lively(&system, 10, 0.04);
    let push = direction(&inputs, 3);
    for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK5] {
        let mut solver = Solver::new(&system, Settings { scheme, ..Settings::default() });
        solver.simulate(&inputs).expect("a motion");
        let changes = solver.push_forward(&push).expect("changes");
        for (change, gradient) in changes.iter().zip(solver.jacobian().expect("gradients")) {
            let (expected, size) = (along(&gradient, &push), size_along(&gradient, &push));
            assert!((change - expected).abs() < 1e-12 * size, "{}: {change} {expected}", scheme.name);
        }
    }
}

#[test]
fn a_product_belongs_to_what_was_differentiated_last() {
    let mut cart = CartPendulum::with_links(2).mechanism();
    let (a, b) = (cart.scene.output("a"), cart.scene.output("b"));
    for (k, of) in [a, b].into_iter().enumerate() {
        let q = cart.links[k].coordinates;
        let force = cart.force;
        cart.scene.term(of, &format!("end {k}"), Mixed, Sum::Terminal, q, [], [force], [1.0.into()]);
    }
    let system = cart.scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.05));
    inputs.controls.fill(4.0);
    let push = direction(&inputs, 3);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("a motion");
    let mut product = |weights: Option<[f64; 3]>| {
        match weights {
            Some([of_cost, a, b]) => solver.weighted_gradient(of_cost, &[a, b]).map(|_| ()),
            None => solver.gradient().map(|_| ()),
        }
        .expect("a gradient");
        solver.hessian_product(&push).expect("a product").controls.clone()
    };
    let (of_cost, of_a, of_b) = (product(None), product(Some([0.0, 1.0, 0.0])), product(Some([0.0, 0.0, 1.0])));
    let together = product(Some([2.0, -3.0, 0.5]));
    let sum = of_cost * 2.0 - of_a * 3.0 + of_b * 0.5;
    assert!((&together - sum).amax() < 1e-12 * together.amax());
    // After another motion J is meant, and nothing that was kept.
    inputs.controls.fill(-4.0);
    solver.simulate(&inputs).expect("a motion");
    let fresh = solver.hessian_product(&push).expect("a product").clone();
    let mut other = Solver::new(&system, Settings::default());
    other.simulate(&inputs).expect("a motion");
    assert_eq!(&fresh, other.hessian_product(&push).expect("a product"));
}

#[test]
fn products_of_ones_own_are_checked() {
    let mut bench = Bench::new();
    bench.four_bar();
    let system = bench.compile(Sum::Trapezoidal);
    let inputs = lively(&system, 10, 0.02);
    let push = direction(&inputs, 5);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("a motion");
    let right = solver.hessian_product(&push).expect("a product").clone();
    let check = |design: Vec<f64>| {
        let check = check::hessian(&system, &inputs, Settings::default());
        check.own("mine", check::Part::Design, push.clone(), design).run().expect("a report")
    };
    let report = check(right.design.as_slice().to_vec());
    println!("{report}");
    report.assert_passed();
    assert!(report.rows.len() == 5 && report.rows.iter().all(|row| row.error() < 1e-12));
    let mut design = right.design.as_slice().to_vec();
    design[2] *= 1.0 + 1e-6;
    let report = check(design);
    assert!(!report.passed() && report.to_string().contains("`b3`"), "{report}");
}

/// T = ½ b v², and the force b u: linear in the state, in the control and in the constant.
struct Motor;

impl KineticEnergy<1, 1> for Motor {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, b: &SVector<S, 1>) -> S {
        b[0] * v[0] * v[0] * 0.5
    }
}

impl Force<1, 1, 1> for Motor {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, b: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([at.u[0] * b[0] - at.v[0] * b[0] * 0.1])
    }
}

/// u √t.
struct Ramp;

impl Force<1, 1> for Ramp {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([at.u[0] * at.t.sqrt()])
    }
}

/// The time of a start is no input: that the load begins with an infinite slope is felt by nothing.
#[test]
fn a_load_that_begins_with_an_infinite_slope_has_products() {
    for with_programs in [true, false] {
        let mut scene = Scene::new();
        let [q] = scene.coordinates("mass", ["x"]);
        let (u, mass) = (scene.control("u"), scene.design("mass", 2.0));
        scene.kinetic_energy("mass", Motor, [q], [mass.into()]);
        scene.force("ramp", Ramp, [q], [u], []);
        scene.cost("x", AngleError, Sum::Trapezoidal, [q], [], [], [0.2.into()]);
        let place = scene.output("place");
        scene.term(place, "x at the end", AngleError, Sum::Terminal, [q], [], [], [0.1.into()]);
        let system = if with_programs { scene.compile() } else { scene.compile_without_programs() }.expect("a scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(6, 0.1));
        inputs.controls.fill(3.0);
        for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK3] {
            let settings = Settings { scheme, ..Settings::default() };
            check::hessian(&system, &inputs, settings).run().expect("a report").assert_passed();
            let mut solver = Solver::new(&system, settings);
            solver.simulate(&inputs).expect("a motion");
            let gradient = solver.jacobian().expect("gradients").swap_remove(0);
            let along = direction(&inputs, 3);
            let sum = |all: &[Input]| all.iter().map(|i| i.in_gradient(&gradient) * *i.of(&mut along.clone())).sum::<f64>();
            let change = solver.push_forward(&along).expect("changes")[0];
            assert!((change - sum(&Input::all(&inputs))).abs() < 1e-13 * change.abs());
        }
    }
}

/// A mass that nothing pulls moves as it began, whatever it is: what is left of its derivatives is rounding, and not wrong.
#[test]
fn what_rounding_leaves_of_a_product_is_not_wrong() {
    for k in 0..10 {
        let mut scene = Scene::new();
        let [q] = scene.coordinates("mass", ["x"]);
        let mass = scene.design("mass", 1.9 + 0.07 * f64::from(k));
        scene.kinetic_energy("mass", Motor, [q], [mass.into()]);
        scene.cost("x", AngleError, Sum::Trapezoidal, [q], [], [], [0.2.into()]);
        let system = scene.compile().expect("a scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(6, 0.04));
        inputs.start.set_coordinate(q, 0.3);
        inputs.start.set_rate(q, 0.7);
        let report = check::hessian(&system, &inputs, Settings::default()).run().expect("a report");
        report.assert_passed();
        assert!(report.rows.iter().all(|row| row.error() < 1e-12), "{report}");
        let sizes: Vec<bool> = report.rows.iter().map(|row| row.size > 0.0).collect();
        assert_eq!(sizes, [false, true, true, true], "{report}");
    }
}

#[test]
fn products_are_exact_where_nothing_bends_and_where_it_bends_in_pieces() {
    for with_programs in [true, false] {
        let compile = |scene: Scene| if with_programs { scene.compile() } else { scene.compile_without_programs() };
        for (name, factor) in [("constant", None), ("bound", Some(1.7)), ("bound by a factor", Some(-0.6))] {
            let mut scene = Scene::new();
            let [q] = scene.coordinates("motor", ["angle"]);
            let (u, mass) = (scene.control("u"), scene.design("mass", 2.0));
            let b = factor.map_or(0.8.into(), |factor| scene.design("motor constant", 0.8) * factor);
            scene.kinetic_energy("mass", Motor, [q], [mass.into()]);
            scene.force("motor", Motor, [q], [u], [b]);
            scene.cost("angle", AngleError, Sum::Trapezoidal, [q], [], [], [0.2.into()]);
            let system = compile(scene).expect("a scene");
            for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK5] {
                let settings = Settings { scheme, ..Settings::default() };
                let what = format!("motor, {name}, programs: {with_programs}, {}", scheme.name);
                error(&what, &system, &lively(&system, 8, 0.02), settings);
            }
        }
        for piece in Piece::ALL.into_iter().filter(|piece| !matches!(piece, Piece::Root)) {
            let system = compile(pieces::scene(piece)).expect("a scene");
            let what = format!("{piece:?}, programs: {with_programs}");
            error(&what, &system, &lively(&system, 8, 0.01), Settings::default());
        }
    }
}

/// Hyper-dual numbers take 0 · ∞ there.
#[test]
fn products_are_there_where_slopes_of_what_is_cut_off_are_infinite() {
    let products = [true, false].map(|with_programs| {
        let scene = pieces::scene(Piece::Root);
        let system = if with_programs { scene.compile() } else { scene.compile_without_programs() }.expect("a scene");
        let inputs = lively(&system, 8, 0.01);
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&inputs).expect("a motion");
        let product = solver.hessian_product(&direction(&inputs, 1)).expect("a product");
        Input::all(&inputs).iter().map(|input| input.in_gradient(product)).collect::<Vec<f64>>()
    });
    let size = products[1].iter().fold(0.0f64, |size, x| size.max(x.abs()));
    for (ours, plain) in products[0].iter().zip(&products[1]) {
        assert!((ours - plain).abs() <= 1e-11 * size, "{ours} and {plain}");
    }
}

/// Q = u √(1 − t), whose slope by time is infinite where t = 1.
struct Fading;
impl Force<1, 1> for Fading {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        at.u * (-at.t + 1.0).sqrt()
    }
}

/// u², or u² + (q + v)² where there is a coordinate.
struct Spent;
impl<const N: usize> Cost<N, 0, 1> for Spent {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, N, 0, 1>, _b: &SVector<S, 0>) -> S {
        (0..N).fold(at.u[0].powi(2), |sum, i| sum + (at.q[i] + at.v[i]).powi(2))
    }
}

/// Behind the last cost on the state nothing is felt, infinite slopes neither; nor does a gradient that comes after a product feel them.
#[test]
fn what_no_cost_feels_may_have_infinite_slopes_before_and_after_a_product() {
    for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK4] {
        for rebase_every in [0, 1] {
            for is_effort in [false, true] {
                let mut scene = Scene::new();
                let [q] = scene.coordinates("cart", ["x"]);
                let (u, mass) = (scene.control("u"), scene.design("mass", 2.0));
                scene.kinetic_energy("mass", Motor, [q], [mass.into()]);
                scene.force("fading", Fading, [q], [u], []);
                scene.cost("seen", Spent, Sum::Node(2), [q], [], [u], []);
                if is_effort {
                    scene.cost("effort", Spent, Sum::Plain, [], [], [u], []);
                }
                let system = scene.compile().expect("a scene");
                let mut whole = Inputs::at_rest(&system, Grid::uniform(4, 0.25));
                whole.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 1.0 + number(i));
                let settings = Settings { scheme, rebase_every, ..Settings::default() };
                // The same until t = 0.75 s, where all slopes are finite.
                let mut part = Inputs { grid: Grid::uniform(3, 0.25), ..whole.clone() };
                part.controls = whole.controls.columns(0, 4).into_owned();
                let of = |inputs: &Inputs| {
                    let mut along = inputs.no_change();
                    along.controls.iter_mut().enumerate().for_each(|(i, u)| *u = number(i + 3));
                    along.grid.steps[..3].copy_from_slice(&[0.02, -0.03, 0.01]);
                    let mut solver = Solver::new(&system, settings);
                    solver.simulate(inputs).expect("a motion");
                    let before = solver.gradient().expect("a gradient").clone();
                    let product = solver.hessian_product(&along).expect("a product").clone();
                    assert_eq!(*solver.gradient().expect("a gradient after a product"), before);
                    solver.simulate(inputs).expect("the motion again");
                    assert_eq!(*solver.gradient().expect("a gradient of the next motion"), before);
                    product
                };
                let (of_whole, of_part) = (of(&whole), of(&part));
                let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-13 * b.abs().max(1.0), "{a} {b}");
                of_whole.steps.iter().zip(&of_part.steps).for_each(|(a, b)| close(*a, *b));
                // The effort counts at a node more.
                of_whole.controls.iter().zip(&of_part.controls).take(3).for_each(|(a, b)| close(*a, *b));
                close(of_whole.design[0], of_part.design[0]);
                assert_eq!(of_whole.steps[3], 0.0);
            }
        }
    }
}
