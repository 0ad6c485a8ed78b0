//! Steps without a solution: they are halved, and the gradient is that of the motion on the grid that was taken.

use crate::common::{assert_gradient_is_exact, assert_says, relative_error};
use crate::scenes::by_hand::Runaway;
use crate::scenes::mechanisms;
use hamiltonian_adjoint::check::{self, Input, complex_step};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Error, Force, ForcePoint, Grid, Inputs, LongSolver, Scalar, Scene, Scheme, Settings, Solver, Start, Sum, System,
    Warning, gradient,
    scenes::{AngleError, CartPendulum},
    simulate,
};
use nalgebra::{DMatrix, SVector};

/// The sled of the stress report with a cost at its end and one on the way.
fn runaway(sum: Sum) -> (System, Inputs) {
    mechanisms::sled(&[Sum::Terminal, sum]).expect("scene")
}

#[test]
fn the_gradient_on_halved_steps_is_exact_for_every_way_to_sum_a_cost() {
    for sum in [Sum::Plain, Sum::AllNodes, Sum::Rectangle, Sum::Trapezoidal, Sum::Terminal] {
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
    assert_eq!((0..given.len()).map(|k| motion.column_of(k)).collect::<Vec<usize>>(), given);
    assert_eq!((given.last(), motion.column_of(given.len())), (Some(&motion.last()), motion.computed));
    let h = |k: usize| {
        let (q, v, u, t) =
            (motion.q[(0, given[k])], motion.v[(0, given[k])], inputs.controls[(0, k)], motion.times[given[k]]);
        assert!((u - taken.controls[(0, given[k])]).abs() <= 1e-18);
        q * v + v * u * t + u * u
    };
    let on_the_way: f64 = (1..given.len()).map(|k| 0.5 * inputs.grid.steps[k - 1] * (h(k - 1) + h(k))).sum();
    let by_hand = on_the_way + h(given.len() - 1);
    assert!((solver.cost().expect("cost") - by_hand).abs() <= 1e-14 * by_hand);
    assert!((motion.times[motion.last()] - inputs.grid.times()[9]).abs() <= 1e-15);
}

#[test]
fn parts_of_a_motion_count_what_is_at_single_nodes_once_on_halved_steps_too() {
    let mut halved = 0;
    for node in 0..=9 {
        let (system, inputs) = mechanisms::sled(&[Sum::Node(node)]).expect("scene");
        let mut solver = Solver::new(&system, Settings::default());
        let motion = solver.simulate(&inputs).expect("motion").clone();
        let whole = solver.cost().expect("cost");
        let given: Vec<usize> = (0..motion.computed).filter(|i| !motion.inserted.contains(i)).collect();
        for cut in 1..9 {
            let mut sum = 0.0;
            for (first, last) in [(0, cut), (cut, 9)] {
                let mut part = inputs.clone();
                part.grid = inputs.grid.part(first, last);
                part.controls = inputs.controls.columns(first, last - first + 1).into_owned();
                if first > 0 {
                    let state = |of: &DMatrix<f64>| of.column(given[first]).into_owned();
                    part.start = Start::Momentum { q: state(&motion.q), p_star: state(&motion.p_star) };
                }
                solver.simulate(&part).expect("motion");
                halved += solver.trajectory().inserted.len();
                sum += solver.cost().expect("cost");
                assert_gradient_is_exact(&format!("{node}, from {first} to {last}"), &system, &part);
                let mut long = LongSolver::new(&system, Settings::default(), 20_000);
                let of_long = long.gradient(&part).expect("a gradient");
                assert_eq!(of_long, solver.gradient().expect("a gradient"));
            }
            assert!((sum - whole).abs() <= 1e-12 * whole.abs(), "{node}, cut at {cut}: {sum} {whole}");
        }
    }
    assert!(halved > 100, "{halved}");
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
fn a_solution_of_another_motion_is_told_from_none() {
    let system = CartPendulum::with_links(1).scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.2));
    inputs.controls.fill(100.0);
    let mut solver = Solver::new(&system, Settings { max_halvings: 0, ..Settings::default() });
    let error = solver.simulate(&inputs).expect_err("a step too long").clone();
    let Error::Newton { step: 2, jump: Some(jump), .. } = error else { panic!("{error:?}") };
    assert!(jump > 10.0, "{error:?}");
    assert_says(&error, &["no solution of step 2 continues the motion", "times the size", "shorter steps"]);
}

/// The same without a control.
impl Force<1, 0, 1> for Runaway {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([b[0] * at.v[0] * at.v[0]])
    }
}

#[test]
fn steps_of_a_motion_without_controls_are_halved() {
    let mut scene = Scene::new();
    let q = scene.coordinates("sled", ["x"]);
    let gain = scene.design("gain", 1.0);
    scene.kinetic_energy("mass", Runaway, q, []);
    scene.force("drive", Runaway, q, [], [gain.into()]);
    scene.cost("way", AngleError, Sum::Terminal, q, [], [], [1.0.into()]);
    let system = scene.compile().expect("scene");
    let (_, mut inputs) = runaway(Sum::Plain);
    inputs.controls = nalgebra::DMatrix::zeros(0, inputs.grid.nodes());
    let mut solver = Solver::new(&system, Settings::default());
    assert!(!solver.simulate(&inputs).expect("motion").inserted.is_empty());
    assert_gradient_is_exact("without controls", &system, &inputs);
}

#[test]
fn a_grid_that_was_left_on_the_way_holds_all_that_was_given() {
    let (system, mut inputs) = runaway(Sum::Plain);
    inputs.grid.steps[7] = 0.6;
    for max_halvings in [0, 1, 2, 6, 20] {
        let mut solver = Solver::new(&system, Settings { max_halvings, ..Settings::default() });
        for _ in 0..2 {
            solver.simulate(&inputs).expect_err("beyond infinity");
            let (motion, taken) = (solver.trajectory(), solver.inputs());
            let nodes = taken.grid.nodes();
            assert_eq!((motion.times.len(), motion.q.ncols(), taken.controls.ncols()), (nodes, nodes, nodes));
            assert!(motion.inserted.is_sorted() && motion.computed < nodes && motion.phi(&system, taken).is_ok());
            let given: Vec<usize> = (0..nodes).filter(|i| !motion.inserted.contains(i)).collect();
            assert_eq!(given.len(), inputs.grid.nodes(), "{max_halvings}: {:?}", motion.inserted);
            let times = taken.grid.times();
            for (k, &node) in given.iter().enumerate() {
                assert_eq!(taken.controls[(0, node)], inputs.controls[(0, k)], "{max_halvings}: node {node}");
                assert!((times[node] - inputs.grid.times()[k]).abs() <= 1e-15, "{max_halvings}: node {node}");
            }
            // Between them controls are linear.
            for &node in &motion.inserted {
                let k = given.partition_point(|&other| other < node);
                let [t0, t1] = [k - 1, k].map(|k| times[given[k]]);
                let [u0, u1] = [k - 1, k].map(|k| inputs.controls[(0, k)]);
                let expected = u0 + (u1 - u0) * (times[node] - t0) / (t1 - t0);
                assert!((taken.controls[(0, node)] - expected).abs() <= 1e-15, "{max_halvings}: node {node}");
            }
        }
    }
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

/// A body of 1 kg on a rail, pulled by a spring to x = 1, that starts 0.1 m beside it: the spring would pull it to x = −1 too.
fn on_a_spring(stiffness: f64) -> System {
    let mut scene = Scene::new();
    let body = scene.body("body", 1.0, 0.1, [1.1, 0.0, 0.0]);
    scene.prismatic("rail", Body::GROUND.at(1.1, 0.0), 0.0, body.at(0.0, 0.0), 0.0);
    scene.spring_damper("spring", Body::GROUND.at(0.0, 0.0), body.at(0.0, 0.0), stiffness, 1.0, 0.0);
    scene.compile().expect("scene")
}

#[test]
fn an_oscillation_that_steps_do_not_resolve_stays_on_its_side_and_keeps_its_energy_and_the_report_says_so() {
    // Steps of 0.5, 5, 16 and 500 of what a radian takes.
    for (stiffness, is_rough) in [(2.5e3, false), (1e6, true), (1e7, true), (1e10, true)] {
        let system = on_a_spring(stiffness);
        let inputs = Inputs::at_rest(&system, Grid::uniform(1000, 0.01));
        let mut solver = Solver::new(&system, Settings::default());
        let motion = solver.simulate(&inputs).unwrap_or_else(|error| panic!("{stiffness}: {error}"));
        let energy = |i: usize| {
            let (x, v) = (motion.q[(0, i)], motion.v[(0, i)]);
            assert!(x > 0.0, "{stiffness}: x = {x} at node {i}");
            0.5 * stiffness * (x - 1.0) * (x - 1.0) + 0.5 * v * v
        };
        let worst = (0..=1000).map(|i| (energy(i) / energy(0) - 1.0).abs()).fold(0.0, f64::max);
        let warnings = without_coarse_steps(&solver);
        println!("{stiffness:e}: energy {worst:.1e}, {} iterations, {warnings:?}", solver.report().newton_iterations);
        assert!(worst <= 1e-9, "{stiffness}: {worst:e}");
        let told = matches!(warnings[..], [Warning::Rough { step: 2.., steps: 500.., .. }]);
        assert!(if is_rough { told } else { warnings.is_empty() }, "{stiffness}: {warnings:?}");
    }
}

#[test]
fn a_force_that_jumps_is_told_once_and_no_more_where_steps_resolve_the_oscillation() {
    // Turns of 36°, 42° and 45° a step.
    for stiffness in [4e3, 6e3, 7e3] {
        let mut scene = Scene::new();
        let push = scene.control("push");
        let body = scene.body("body", 1.0, 0.1, [1.1, 0.0, 0.0]);
        scene.prismatic("rail", Body::GROUND.at(1.1, 0.0), 0.0, body.at(0.0, 0.0), 0.0);
        scene.spring_damper("spring", Body::GROUND.at(0.0, 0.0), body.at(0.0, 0.0), stiffness, 1.0, 0.0);
        scene.force("drive", Runaway, [body.coordinates[0]], [push], [0.0.into()]);
        let system = scene.compile().expect("scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(200, 0.01));
        inputs.controls.columns_mut(20, 181).fill(0.3 * stiffness);
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&inputs).expect("motion");
        let warnings = without_coarse_steps(&solver);
        println!("{stiffness:e}: {warnings:?}");
        assert!(matches!(warnings[..], [Warning::Rough { step: 20, steps: 1..=10, .. }]), "{stiffness}: {warnings:?}");
    }
}

/// The warnings of a motion but that of an oscillation with few steps in a period, as all here are.
fn without_coarse_steps(solver: &Solver) -> Vec<Warning> {
    let warnings = solver.report().warnings.iter();
    warnings.filter(|warning| !matches!(warning, Warning::CoarseSteps { .. })).cloned().collect()
}

/// A rod of 1 kg and 1 m that falls from the side, hung on a spring of 1 m.
fn rod_on_a_spring(stiffness: f64) -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let rod = scene.body("rod", 1.0, 1.0 / 12.0, [1.5, 0.0, 0.0]);
    scene.spring_damper("spring", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0), stiffness, 1.0, 0.0);
    scene.cost("angle", AngleError, Sum::Terminal, [rod.coordinates[2]], [], [], [1.0.into()]);
    scene.compile().expect("scene")
}

#[test]
fn corrections_that_shrink_by_a_thousandth_are_rounding() {
    // The length of 1 m has an ulp, and the force of the spring one of 2e-6 N and more.
    for (stiffness, dt) in [(1e10, 2e-3), (1e11, 1e-4), (1e13, 1e-4)] {
        let system = rod_on_a_spring(stiffness);
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&Inputs::at_rest(&system, Grid::uniform(300, dt))).expect("motion");
        let report = solver.report();
        println!("{stiffness:e}: {} iterations at most, {:?}", report.most_iterations, report.warnings);
        assert!(report.most_iterations <= 8 && report.warnings.is_empty());
    }
}

/// A thousand radians of the spring a step: whole corrections go to and fro, and at their end the residual is rounding that none can make smaller.
#[test]
fn steps_far_too_long_for_a_spring_end_where_residuals_are_rounding() {
    let system = rod_on_a_spring(1e10);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&Inputs::at_rest(&system, Grid::uniform(1000, 0.01))).expect("motion");
    let (iterations, warnings) = (solver.report().newton_iterations, &solver.report().warnings);
    println!("{iterations} iterations, {warnings:?}");
    assert!(iterations < 40_000 && matches!(warnings[..], [Warning::Rough { .. }, ..]));
}

/// Lengths of a kilometre are rounded by 1e-13 m, which coordinates near 0 know nothing of, and forces by 1e-7 N and more.
#[test]
fn long_springs_end_where_their_lengths_are_rounding() {
    let (mut halved, anchor) = ([0, 0], 1e3);
    for (k, stiffness) in [1e6, 1e10].into_iter().enumerate() {
        for (rate, dt) in [(0.0, 1e-2), (1e-3, 1e-2), (1.0, 1e-2), (1e-3, 1e-4)] {
            let mut scene = Scene::new();
            scene.gravity(0.0, -9.81);
            let rod = scene.body("rod", 1.0, 1.0 / 12.0, [0.0; 3]);
            scene.spring_damper("along", Body::GROUND.at(anchor, 0.0), rod.at(0.0, 0.0), stiffness, anchor, 0.0);
            scene.spring_damper("across", Body::GROUND.at(0.0, anchor), rod.at(0.5, 0.0), stiffness, anchor, 0.0);
            let system = scene.compile().expect("scene");
            let mut inputs = Inputs::at_rest(&system, Grid::uniform(200, dt));
            inputs.start.rate_mut()[0] = rate;
            halved[k] += simulate(&system, &inputs, Settings::default()).expect("a motion").inserted.len();
        }
    }
    // Steps of 10,000 radians have no solution near at times.
    println!("{halved:?}");
    assert!(halved[0] == 0 && halved[1] < 400, "{halved:?}");
}

#[test]
fn the_way_from_a_step_of_length_zero_begins_as_late_as_it_can() {
    // At least ten radians of the spring a step.
    let system = rod_on_a_spring(1e6);
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.01));
    inputs.start.rate_mut()[0] = 1.0;
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("motion");
    let (iterations, warnings) = (solver.report().newton_iterations, without_coarse_steps(&solver));
    println!("{iterations} iterations, {warnings:?}");
    assert!(iterations < 2200 && matches!(warnings[..], [Warning::Rough { .. }]));
}

#[test]
fn a_complex_step_ends_where_its_corrections_are_rounding() {
    let system = rod_on_a_spring(1e10);
    let inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.002));
    let adjoint = gradient(&system, &inputs, Settings::default()).expect("gradient");
    let sample: Vec<Input> = Input::all(&inputs).into_iter().filter(|input| matches!(input, Input::Step(_))).collect();
    let ours: Vec<f64> = sample.iter().map(|input| input.in_gradient(&adjoint)).collect();
    let reference = complex_step(&system, &inputs, Settings::default(), &sample).expect("a complex step");
    // The spring is stretched by 1e-9 m under the weight.
    let error = relative_error(&ours, &reference);
    println!("steps: {error:.1e}");
    assert!(error <= 10.0 * f64::EPSILON * 1e10 / 9.81, "{error:e}");
    // Steps that are far too long for the spring: a derivative there is.
    let long = Inputs::at_rest(&system, Grid::uniform(100, 0.01));
    complex_step(&system, &long, Settings::default(), &sample[..20]).expect("a complex step");
}

#[test]
fn a_check_says_what_was_left_to_rounding() {
    let system = rod_on_a_spring(1e10);
    let inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.002));
    let check = check::gradient(&system, &inputs, Settings::default()).own("mine", check::Part::Steps, vec![0.0; 100]);
    let report = check.run().expect("a motion");
    println!("{report}");
    // Nothing is compared with a gradient that is not right.
    assert!(report.own.iter().all(|own| own.verdict == check::Verdict::NothingCompared && own.wrong_entries == 0));
    assert_eq!(report.own.len(), 1);
    assert!(!report.passed() && report.rounding > 1e-11 && report.to_string().contains("rounding error of"));
    assert!(report.directions.iter().all(|row| row.error() <= 1e3 * report.rounding));
    let soft = rod_on_a_spring(1e3);
    let report = check::gradient(&soft, &inputs, Settings::default()).run().expect("a motion");
    assert!(report.passed() && report.rounding < 1e-12 && !report.to_string().contains("rounding error of"), "{report}");
}

/// I dω/dt = u − M tanh(ω/ω_s): whatever the step, each stage has exactly one solution, on the other side of two bends.
#[test]
fn dry_friction_halves_no_step() {
    for scheme in [Scheme::TRAPEZOIDAL, Scheme::TR_BDF2, Scheme::ESDIRK3, Scheme::ESDIRK5] {
        for (torque, slip) in [(50.0, 0.01), (50.0, 0.3), (800.0, 0.01), (800.0, 1.0)] {
            let mut scene = Scene::new();
            let wheel = scene.body("wheel", 20.0, 0.8, [0.0; 3]);
            scene.revolute("axle", Body::GROUND.at(0.0, 0.0), wheel.at(0.0, 0.0));
            scene.coulomb_friction("brake", Body::GROUND, wheel, torque, slip);
            let motor = scene.control("motor");
            scene.torque_actuator("motor", Body::GROUND, wheel, motor);
            let angle = wheel.coordinates[2];
            scene.cost("angle", AngleError, Sum::Terminal, [angle], [], [], [0.3.into()]);
            let system = scene.compile().expect("scene");
            let mut solver = Solver::new(&system, Settings { scheme, ..Settings::default() });
            for (rate, motor, dt) in [(1.0, 0.0, 0.02), (1.0, 30.0, 0.055), (5.0, 0.0, 0.055), (20.0, -180.0, 0.055)] {
                let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, dt));
                inputs.start.set_rate(angle, rate);
                inputs.controls.fill(motor);
                let motion = solver.simulate(&inputs).expect("motion");
                let what = format!("{}, {torque} N m, {slip} rad/s from {rate} rad/s under {motor} N m", scheme.name);
                assert!(motion.inserted.is_empty(), "{what}: {:?}", motion.inserted);
                // Each stage is solved to rounding: I (v − v₋) = Δt (u − M tanh), the torques at both ends counted half.
                if scheme == Scheme::TRAPEZOIDAL {
                    let of_torque = |i: usize| inputs.controls[(0, i)] - torque * (motion.v[(2, i)] / slip).tanh();
                    let left = |i: usize| {
                        let change = 0.8 * (motion.v[(2, i)] - motion.v[(2, i - 1)]);
                        change - 0.5 * dt * (of_torque(i) + of_torque(i - 1))
                    };
                    let worst = (1..=20).map(|i| left(i).abs()).fold(0.0, f64::max);
                    let size = 0.8 * motion.v.row(2).amax() + dt * (torque + motor.abs());
                    assert!(worst <= 1e-13 * size, "{what}: {worst:e}");
                }
            }
        }
    }
}
