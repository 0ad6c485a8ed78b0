//! Restarts on grids of macro steps: they take place at the ends of these, keep their order, and the gradient goes through them.

use crate::common::bench::{Bench, Part, number};
use crate::common::{
    assert_gradient_is_exact_to, assert_gradient_is_exact_with, assert_order, assert_says, largest_difference,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Composition, Error, Gradient, Grid, Inputs, LongSolver, Scene, Settings, Start, Sum, System, Trajectory, check,
    gradient,
    scenes::{AngleError, CartPendulum},
    simulate,
};
use nalgebra::{DMatrix, DVector};

const NEVER: f64 = f64::INFINITY;

/// `rebase_every` and `drift_bound`.
const WAYS: [(usize, f64); 7] = [(1, NEVER), (5, NEVER), (9, NEVER), (0, 0.0), (0, 1e-9), (1, 0.0), (5, 1e-9)];

fn settings((rebase_every, drift_bound): (usize, f64)) -> Settings {
    Settings { rebase_every, drift_bound, ..Settings::default() }
}

fn pendulum() -> System {
    let mut bench = Bench::new();
    let rod = bench.rod([0.0, 0.0], [1.0, 0.0]);
    bench.hinge(Part::GROUND, rod, [0.0, 0.0]);
    bench.drive(Part::GROUND, rod);
    bench.compile(Sum::Trapezoidal)
}

/// A rod on a hinge that is there twice, with a cost on nothing but its place.
fn doubled() -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let (rod, torque) = (scene.body("rod", 1.0, 0.08, [0.5, 0.0, 0.0]), scene.control("torque"));
    for name in ["hinge", "the same"] {
        scene.revolute(name, Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    }
    scene.torque_actuator("motor", Body::GROUND, rod, torque);
    scene.cost("angle", AngleError, Sum::Trapezoidal, [rod.coordinates[2]], [], [], [0.4.into()]);
    scene.compile().expect("scene")
}

fn five_bar() -> System {
    let mut bench = Bench::new();
    bench.five_bar();
    bench.compile(Sum::Trapezoidal)
}

/// In motion on a grid, with a control that is smooth in time.
fn inputs(system: &System, grid: Grid) -> Inputs {
    let times = grid.times();
    let mut inputs = Inputs::at_rest(system, grid);
    inputs.controls.iter_mut().zip(times).for_each(|(u, t)| *u = 0.5 * (2.0 * t).cos());
    let p_star = DVector::from_fn(system.n(), |i, _| 0.2 * number(i + 3));
    inputs.start = Start::Momentum { q: system.initial_coordinates(), p_star };
    inputs
}

#[test]
fn the_order_of_the_composition_is_kept() {
    // Macro steps of the coarsest grid, by composition.
    let mechanisms = [("pendulum", pendulum(), 1.5, [90, 45, 60, 45]), ("five-bar", five_bar(), 0.6, [90, 45, 20, 15])];
    for (name, system, end, coarsest) in mechanisms {
        let at_end = |composition, steps: usize, settings| {
            let inputs = inputs(&system, Grid::composed(steps, end / steps as f64, composition));
            let motion = simulate(&system, &inputs, settings).expect("motion");
            let last = motion.computed - 1;
            [motion.q.column(last).as_slice(), motion.v.column(last).as_slice()].concat()
        };
        let exact = at_end(Composition::KahanLi6, 800, Settings::default());
        for (composition, coarse) in Composition::ALL.into_iter().zip(coarsest) {
            let errors = |way| {
                let error = |steps| largest_difference(&at_end(composition, steps, settings(way)), &exact);
                [coarse, 2 * coarse, 4 * coarse].map(error)
            };
            for way in WAYS {
                let what = format!("{name}, {composition:?}, {way:?}");
                let order = composition.order() as f64;
                if way.1 == 0.0 || way.1 == NEVER {
                    assert_order(&what, &errors(way), order, 0.12 * order);
                    continue;
                }
                // How often the bound is reached changes with the step, and with it the constant of the error, which is about between that
                // of no projection and that of one at every end.
                let (without, with) = (errors((way.0, NEVER)), errors((way.0, 0.0)));
                let most: Vec<f64> = without.iter().zip(with).map(|(a, b)| a.max(b)).collect();
                println!("{what}: {:?}, at most {most:?}", errors(way));
                assert!(errors(way).iter().zip(&most).all(|(error, most)| *error <= 2.0 * most), "{what}");
            }
        }
    }
}

#[test]
fn restarts_count_macro_steps_and_take_place_at_their_ends() {
    let system = pendulum();
    for composition in Composition::ALL {
        let stages = composition.stages();
        for every in [1, 5, 9] {
            let inputs = inputs(&system, Grid::composed(20, 0.02, composition));
            let motion = simulate(&system, &inputs, settings((every, NEVER))).expect("motion");
            let ends: Vec<usize> = (1..=20 / every).map(|j| j * every * stages).collect();
            assert_eq!(motion.restarted, ends, "{composition:?}, every {every}");
        }
        let inputs = inputs(&system, Grid::composed(20, 0.02, composition));
        for way in [(0, 0.0), (7, 0.0)] {
            let motion = simulate(&system, &inputs, settings(way)).expect("motion");
            assert!(motion.restarted.iter().copied().eq((1..=20).map(|j| j * stages)), "{composition:?}");
        }
    }
}

#[test]
fn steps_left_over_end_no_macro_step_and_one_of_no_stages_is_refused() {
    let system = pendulum();
    let mut given = inputs(&system, Grid { stages: 3, ..Grid::uniform(11, 0.02) });
    let motion = simulate(&system, &given, settings((1, 0.0))).expect("motion");
    assert_eq!(motion.restarted, [3, 6, 9]);
    assert_gradient_is_exact_with("left over", &system, &given, settings((1, 0.0)));
    given.grid.stages = 0;
    let error = simulate(&system, &given, Settings::default()).expect_err("no stages").error;
    assert!(matches!(error, Error::Parameter { .. }), "{error:?}");
    assert_says(&error, &["`Grid::stages` is 0", "1 or more"]);
}

#[test]
fn multipliers_run_through_the_middle_of_their_range_over_a_macro_step() {
    // Hanging at rest, the rail carries the weight.
    let system = CartPendulum::with_links(1).scene().compile().expect("scene");
    for (composition, every) in [(Composition::Suzuki4, 1), (Composition::KahanLi6, 1), (Composition::Yoshida6, 4)] {
        let dt = 0.01;
        let inputs = Inputs::at_rest(&system, Grid::composed(12, dt, composition));
        let motion = simulate(&system, &inputs, settings((every, NEVER))).expect("motion");
        let plain = simulate(&system, &inputs, Settings::default()).expect("motion");
        let per_step = plain.sigma.column(composition.stages()).into_owned();
        for &node in &motion.restarted {
            let expected = -0.5 * every as f64 * &per_step;
            let error = (motion.sigma.column(node) - &expected).amax() / expected.amax();
            assert!(error <= 1e-10, "{composition:?}: node {node}: {error:.1e}");
        }
    }
}

#[test]
fn the_gradient_is_that_of_complex_step() {
    for (name, system) in [("pendulum", pendulum()), ("five-bar", five_bar())] {
        for composition in [Composition::Suzuki4, Composition::Yoshida6, Composition::KahanLi6] {
            // A bound that is reached now and then, and at all ends.
            for way in [(1, NEVER), (3, NEVER), (0, 0.0), (0, 1e-11), (1, 0.0), (2, 1e-9)] {
                let inputs = inputs(&system, Grid::composed(6, 0.04, composition));
                let what = format!("{name}, {composition:?}, {way:?}");
                assert!(!simulate(&system, &inputs, settings(way)).expect("motion").restarted.is_empty(), "{what}");
                assert_gradient_is_exact_with(&what, &system, &inputs, settings(way));
            }
        }
    }
}

/// Macro steps of which some stages are too long for so few iterations.
fn divided(system: &System, composition: Composition) -> (Inputs, Settings) {
    let mut inputs = inputs(system, Grid::composed(12, 0.02, composition));
    let stages = composition.stages();
    for step in [2 * stages + 1, 3 * stages - 1, 7 * stages + 2] {
        inputs.grid.steps[step] = 0.5 * inputs.grid.steps[step].signum();
    }
    (inputs, Settings { max_iterations: 3, ..Settings::default() })
}

#[test]
fn halved_stages_are_restarted_at_the_end_of_the_given_macro_step_only() {
    for (name, system) in [("pendulum", pendulum()), ("five-bar", five_bar())] {
        for composition in [Composition::Trapezoidal, Composition::Suzuki4, Composition::Yoshida6] {
            let (inputs, limits) = divided(&system, composition);
            for (rebase_every, drift_bound) in [(1, NEVER), (2, NEVER), (0, 0.0), (2, 0.0)] {
                let settings = Settings { rebase_every, drift_bound, ..limits };
                let what = format!("{name}, {composition:?}, {rebase_every}, {drift_bound}");
                let motion = simulate(&system, &inputs, settings).expect("motion");
                assert!(motion.inserted.len() >= 3, "{what}: {:?}", motion.inserted);
                let given: Vec<usize> = (0..motion.computed).filter(|node| !motion.inserted.contains(node)).collect();
                let every = if drift_bound == 0.0 { 1 } else { rebase_every };
                let ends = given.iter().copied().step_by(every * composition.stages()).skip(1);
                assert!(motion.restarted.iter().copied().eq(ends), "{what}: {:?}", motion.restarted);
                // Steps of half a second amplify rounding.
                assert_gradient_is_exact_to(1e-11, &what, &system, &inputs, settings);
            }
        }
    }
}

fn assert_same(what: &str, one: &Gradient, other: &Gradient) {
    assert_eq!((one.value, &one.controls, &one.design), (other.value, &other.controls, &other.design), "{what}");
    assert_eq!((&one.start, &one.steps), (&other.start, &other.steps), "{what}");
}

#[test]
fn the_gradient_from_checkpoints_is_the_stored_one() {
    for (name, system) in [("pendulum", pendulum()), ("doubled hinge", doubled()), ("five-bar", five_bar())] {
        for composition in [Composition::Suzuki4, Composition::KahanLi6] {
            let inputs = inputs(&system, Grid::composed(60, 0.005, composition));
            for way in [(1, NEVER), (7, NEVER), (0, 0.0), (4, 1e-12)] {
                let stored = gradient(&system, &inputs, settings(way)).expect("gradient");
                let Err(Error::Memory { needed, .. }) =
                    LongSolver::new(&system, settings(way), 1000).gradient(&inputs).cloned()
                else {
                    panic!("too little memory")
                };
                for bytes in [needed, 2 * needed, 8 * needed] {
                    let mut long = LongSolver::new(&system, settings(way), bytes);
                    let what = format!("{name}, {composition:?}, {way:?}, {bytes} bytes");
                    assert_same(&what, long.gradient(&inputs).expect("gradient"), &stored);
                }
            }
        }
    }
}

#[test]
fn a_check_of_the_gradient_follows_the_multipliers_over_a_macro_step() {
    for system in [pendulum(), five_bar()] {
        let mut given = inputs(&system, Grid::composed(5, 0.05, Composition::Suzuki4));
        for way in [(1, NEVER), (2, NEVER), (0, 0.0)] {
            let report = check::gradient(&system, &given, settings(way)).run().expect("motion");
            println!("{way:?}: {:?}", report.identity);
            report.assert_passed();
        }
        given.grid = Grid { stages: 4, ..given.grid };
        check::gradient(&system, &given, settings((1, 0.0))).run().expect("motion").assert_passed();
    }
}

/// The part of inputs between two nodes, which begins with the q and p* that their motion has there.
fn part(whole: &Inputs, motion: &Trajectory, first: usize, last: usize) -> Inputs {
    let node = (0..motion.computed).filter(|node| !motion.inserted.contains(node)).nth(first).expect("a given node");
    let state = |of: &DMatrix<f64>| of.column(node).into_owned();
    Inputs {
        grid: whole.grid.part(first, last),
        start: Start::Momentum { q: state(&motion.q), p_star: state(&motion.p_star) },
        controls: whole.controls.columns(first, last - first + 1).into_owned(),
        ..whole.clone()
    }
}

/// The given nodes at which a motion was restarted.
fn restarted(motion: &Trajectory) -> Vec<usize> {
    let given = |node: &usize| node - motion.inserted.iter().filter(|inserted| *inserted < node).count();
    motion.restarted.iter().map(given).collect()
}

#[test]
fn parts_are_restarted_where_the_whole_is() {
    let mut count = 0;
    for (name, system) in [("pendulum", pendulum()), ("five-bar", five_bar())] {
        for composition in [Composition::Trapezoidal, Composition::Suzuki4] {
            let plain = (inputs(&system, Grid::composed(8, 0.02, composition)), Settings::default());
            for (whole, limits) in [plain, divided(&system, composition)] {
                let nodes = whole.grid.steps.len();
                for (rebase_every, drift_bound) in [(1, NEVER), (3, NEVER), (0, 0.0)] {
                    let settings = Settings { rebase_every, drift_bound, position_tolerance: 1.0, ..limits };
                    let motion = simulate(&system, &whole, settings).expect("motion");
                    for (first, last) in [(1, nodes), (3, nodes - 1), (4, nodes), (7, nodes)] {
                        let what = format!("{name}, {composition:?}, {rebase_every}, {drift_bound}, from {first} to {last}");
                        let given = part(&whole, &motion, first, last);
                        let of_part = simulate(&system, &given, settings).expect("motion");
                        let there = restarted(&motion).into_iter().filter(|node| (first + 1..=last).contains(node));
                        let there: Vec<usize> = there.map(|node| node - first).collect();
                        assert_eq!(restarted(&of_part), there, "{what}");
                        count += there.len();
                    }
                }
            }
        }
    }
    assert!(count > 100, "{count}");
}

#[test]
fn parts_that_begin_inside_of_a_macro_step_keep_its_order() {
    let system = pendulum();
    for (composition, coarse) in [(Composition::Suzuki4, 60), (Composition::Yoshida6, 60)] {
        let at_end = |steps: usize, cut: usize, settings| {
            let whole = inputs(&system, Grid::composed(steps, 1.5 / steps as f64, composition));
            let motion = simulate(&system, &whole, settings).expect("motion");
            let given = part(&whole, &motion, cut, whole.grid.steps.len());
            let motion = simulate(&system, &given, Settings { position_tolerance: 1.0, ..settings }).expect("motion");
            [motion.q.column(motion.computed - 1).as_slice(), motion.v.column(motion.computed - 1).as_slice()].concat()
        };
        let exact = at_end(800, 0, Settings::default());
        for way in [(1, NEVER), (5, NEVER), (0, 0.0)] {
            for cut in [composition.stages() + 2, 3 * composition.stages() - 1] {
                let error = |steps| largest_difference(&at_end(steps, cut, settings(way)), &exact);
                let order = composition.order() as f64;
                let what = format!("{composition:?}, {way:?}, from node {cut}");
                assert_order(&what, &[coarse, 2 * coarse, 4 * coarse].map(error), order, 0.12 * order);
            }
        }
    }
}

#[test]
fn gradients_of_parts_that_begin_inside_of_a_macro_step_are_exact() {
    for (name, system) in [("pendulum", pendulum()), ("five-bar", five_bar())] {
        for (whole, limits) in [
            (inputs(&system, Grid::composed(6, 0.04, Composition::Suzuki4)), Settings::default()),
            divided(&system, Composition::Suzuki4),
        ] {
            for (rebase_every, drift_bound) in [(1, NEVER), (2, NEVER), (0, 0.0)] {
                let settings = Settings { rebase_every, drift_bound, position_tolerance: 1.0, ..limits };
                let motion = simulate(&system, &whole, settings).expect("motion");
                let given = part(&whole, &motion, 7, 28);
                let what = format!("{name}, {rebase_every}, {drift_bound}");
                assert_gradient_is_exact_to(1e-11, &what, &system, &given, settings);
                check::gradient(&system, &given, settings).run().expect("motion").assert_passed();
                let stored = gradient(&system, &given, settings).expect("gradient");
                let mut long = LongSolver::new(&system, settings, 120_000);
                assert_same(&what, long.gradient(&given).expect("gradient"), &stored);
            }
        }
    }
}
