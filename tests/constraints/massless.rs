//! Bodies without a moment of inertia, or without mass, that joints determine: motions, exact derivatives, and refusals by name.

use crate::common::{assert_gradient_is_exact_with, assert_says, relative_error};
use hamiltonian_adjoint::check;
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::AngleError;
use hamiltonian_adjoint::{
    Coordinate, Error, Gradient, Grid, Inputs, LongSolver, Mechanics, Scene, Scheme, Settings, Solver, Start, Sum, System,
    gradient, simulate,
};

/// A mechanism of which something has no inertia, compiled; and what may be held.
fn mechanism(kind: &str, inertia: f64) -> (System, Vec<Coordinate>) {
    let (scene, held) = scene(kind, inertia);
    (scene.compile().expect("a scene"), held)
}

/// Its scene: mass m and moment of inertia J of one body are design variables.
fn scene(kind: &str, inertia: f64) -> (Scene, Vec<Coordinate>) {
    let mut scene = Scene::new();
    scene.gravity(0.4, -9.81);
    let (m, j) = (
        scene.design("mass", if kind == "truss" || kind == "link" { inertia } else { 0.8 }),
        scene.design("inertia", inertia),
    );
    let (length, torque) = (scene.design("length", 0.5), scene.control("torque"));
    let ground = |x: f64, y: f64| Body::GROUND.at(x, y);
    let (seen, held) = match kind {
        // A point mass on a rod, and another one on that.
        "pendulum" => {
            let first = scene.body("first", m, j, [0.3, -0.4, -0.9]);
            let second = scene.body("second", 0.5, 0.0, [0.9, -0.5, -0.1]);
            scene.revolute("pivot", ground(0.0, 0.0), first.at(length * -1.0, 0.0));
            scene.revolute("elbow", first.at(0.0, 0.0), second.at(length * -1.2, 0.0));
            scene.torque_actuator("motor", Body::GROUND, first, torque);
            (second, vec![first.coordinates[2], second.coordinates[2]])
        }
        // On a cart whose angle the rail holds.
        "cart" => {
            let cart = scene.body("cart", m, j, [0.1, 0.0, 0.0]);
            let bob = scene.body("bob", 0.3, 0.02, [0.4, -0.4, -0.9]);
            scene.prismatic("rail", ground(0.0, 0.0), 0.1, cart.at(0.0, 0.0), 0.0);
            scene.revolute("hook", cart.at(0.0, 0.0), bob.at(length * -1.0, 0.0));
            scene.torque_actuator("motor", cart, bob, torque);
            (bob, vec![cart.coordinates[0]])
        }
        // Welded to a bar.
        "weld" => {
            let bar = scene.body("bar", 0.7, 0.05, [0.3, -0.2, -0.6]);
            let tip = scene.body("tip", m, j, [0.6, -0.5, -0.4]);
            scene.revolute("pivot", ground(0.0, 0.0), bar.at(length * -0.7, 0.0));
            scene.weld("glue", bar.at(length * 0.8, 0.0), tip.at(0.0, 0.0), 0.2);
            scene.torque_actuator("motor", Body::GROUND, bar, torque);
            (tip, vec![bar.coordinates[2]])
        }
        // A link without mass between two bodies.
        "link" => {
            let link = scene.body("link", m, j, [0.2, -0.2, -0.7]);
            let bob = scene.body("bob", 0.6, 0.03, [0.6, -0.6, -1.0]);
            scene.revolute("pivot", ground(0.0, 0.0), link.at(length * -0.6, 0.0));
            scene.revolute("hook", link.at(length * 0.6, 0.0), bob.at(-0.2, 0.0));
            scene.torque_actuator("motor", Body::GROUND, link, torque);
            (bob, vec![link.coordinates[2]])
        }
        // A wheel on a crank that rolls on another one: a hinge in its centre, and its angle by a gear that closes a loop.
        "wheel" => {
            let crank = scene.body("crank", 0.6, 0.04, [0.2, -0.1, -0.3]);
            let wheel = scene.body("wheel", m, j, [0.4, -0.2, 0.1]);
            scene.revolute("pivot", ground(0.0, 0.0), crank.at(length * -0.5, 0.0));
            scene.revolute("axle", crank.at(length * 0.5, 0.0), wheel.at(0.0, 0.0));
            scene.gear("gear", crank, length * 4.0, wheel, 0.3);
            scene.torque_actuator("motor", Body::GROUND, wheel, torque);
            (wheel, vec![crank.coordinates[2]])
        }
        // A joint of two rods without mass, with a third one from there.
        _ => {
            let tip = scene.particle("tip", m, [0.3, -0.4]);
            let bob = scene.body("bob", 0.6, 0.03, [0.6, -0.8, -1.0]);
            scene.distance("rod", ground(0.0, 0.0), tip.point(), length);
            scene.revolute("hook", tip.point(), bob.at(-0.2, 0.0));
            scene.torque_actuator("motor", Body::GROUND, bob, torque);
            (bob, vec![bob.coordinates[2]])
        }
    };
    let [x, _, angle] = seen.coordinates;
    scene.cost("angle", AngleError, Sum::Trapezoidal, [angle], [], [], [0.6.into()]);
    scene.cost("place", AngleError, Sum::AllNodes, [x], [], [], [0.1.into()]);
    (scene, held)
}

const KINDS: [&str; 6] = ["pendulum", "cart", "weld", "link", "wheel", "truss"];

fn inputs(system: &System, hold: &[Coordinate]) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(8, 0.02));
    inputs.start = Start::assembled(system).hold(hold);
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 0.3 * (0.7 * i as f64).cos());
    inputs
}

#[test]
fn a_motion_is_the_limit_of_those_with_a_little_inertia() {
    for kind in KINDS {
        let of = |inertia: f64| {
            let (system, _) = mechanism(kind, inertia);
            simulate(&system, &inputs(&system, &[]), Settings::default())
                .unwrap_or_else(|error| panic!("{kind}: {error}"))
                .nodes
                .q
        };
        let (none, little) = (of(0.0), of(1e-9));
        assert!((none - little).amax() < 1e-6, "{kind}");
    }
}

#[test]
fn derivatives_are_exact_also_by_the_inertia_that_is_not_there() {
    let plain = Settings::default();
    for kind in KINDS {
        let (system, held) = mechanism(kind, 0.0);
        for hold in [&[][..], &held] {
            for settings in [
                plain,
                Settings { scheme: Scheme::ESDIRK3, ..plain },
                Settings { drift_bound: 0.0, ..plain },
                Settings { rebase_every: 3, ..plain },
            ] {
                assert_gradient_is_exact_with(kind, &system, &inputs(&system, hold), settings);
            }
        }
        let inputs = inputs(&system, &held);
        check::hessian(&system, &inputs, plain).run().expect("a report").assert_passed();
        let mut long = LongSolver::new(&system, plain, 30_000);
        assert!(long.gradient(&inputs).is_ok(), "{kind}");
        assert!(Mechanics::at_start(&system, &inputs).is_ok(), "{kind}");
    }
}

#[test]
fn what_nothing_determines_is_named() {
    let refused = |hinge: Option<f64>| {
        let mut scene = Scene::new();
        let bob = scene.body("bob", 1.0, 0.0, [0.5, 0.0, 0.0]);
        if let Some(at) = hinge {
            scene.revolute("hinge", Body::GROUND.at(0.5 + at, 0.0), bob.at(at, 0.0));
        }
        let system = scene.compile().expect("a scene");
        simulate(&system, &Inputs::at_rest(&system, Grid::uniform(2, 0.01)), Settings::default()).map(drop)
    };
    assert!(refused(Some(-0.5)).is_ok());
    for hinge in [None, Some(0.0)] {
        let error = refused(hinge).expect_err("an angle that nothing determines").error;
        assert!(matches!(&error, Error::SingularMass { coordinates, .. } if coordinates == &["`bob.φ`"]), "{error:?}");
        assert_says(&error, &["`bob.φ`", "neither inertia nor a joint that determines them"]);
    }
}

/// The start that is assembled from these inputs, given by itself.
fn given(system: &System, inputs: &Inputs) -> Inputs {
    let motion = simulate(system, inputs, Settings::default()).expect("a motion");
    let [q, v] = [&motion.q, &motion.v].map(|x| x.column(0).into_owned());
    Inputs { start: Start::Velocity { q, v }, ..inputs.clone() }
}

/// In a short step the inertia that a coordinate without mass has in K is h² times what the constraints bend by.
#[test]
fn steps_may_be_as_short_as_they_like() {
    for kind in KINDS {
        let (system, held) = mechanism(kind, 0.0);
        let mut solver = Solver::new(&system, Settings::default());
        for k in 1..12 {
            let grid = Grid::uniform(8, 0.1_f64.powi(k));
            solver
                .simulate(&Inputs { grid, ..inputs(&system, &held) })
                .unwrap_or_else(|error| panic!("{kind}, {k}: {error}"));
            assert!(solver.report().worst_pivot > 1e-5, "{kind}, {k}: {:e}", solver.report().worst_pivot);
        }
    }
}

#[test]
fn grids_by_tolerance_keep_the_tolerance() {
    for kind in KINDS {
        let (system, held) = mechanism(kind, 0.0);
        for hold in [&[][..], &held] {
            let inputs = given(&system, &inputs(&system, hold));
            let end = |scheme, tolerance: f64| {
                let mut solver = Solver::new(&system, Settings { scheme, ..Settings::default() });
                let adapted = solver.adapt(&inputs, tolerance).unwrap_or_else(|error| panic!("{kind}: {error}"));
                assert_gradient_is_exact_with(kind, &system, &adapted, Settings { scheme, ..Settings::default() });
                let motion = solver.simulate(&adapted).expect("the motion");
                motion.q.column(motion.q.ncols() - 1).into_owned()
            };
            let exact = end(Scheme::ESDIRK5, 1e-12);
            for scheme in Scheme::ALL {
                let error = (end(scheme, 1e-6) - &exact).amax();
                assert!(error < 1e-4, "{kind}, {}: {error:e}", scheme.name);
            }
        }
    }
}

#[test]
fn inertia_may_vanish_after_compilation_where_it_is_not_eliminated_ahead() {
    let settings = Settings::default();
    for kind in KINDS {
        let (heavy, held) = mechanism(kind, 0.2);
        let (system, held_without) = mechanism(kind, 0.0);
        for (hold, hold_without) in [(&[][..], &[][..]), (&held, &held_without)] {
            let without = inputs(&system, hold_without);
            let taken = Inputs { design: without.design.clone(), ..inputs(&heavy, hold) };
            if kind == "pendulum" {
                let [taken, none] =
                    [(&heavy, &taken), (&system, &without)].map(|(system, inputs)| simulate(system, inputs, settings));
                assert!((&taken.expect("a motion").q - &none.expect("a motion").q).amax() < 1e-12);
                assert_gradient_is_exact_with(kind, &heavy, &inputs(&heavy, hold), settings);
            } else {
                let error = simulate(&heavy, &taken, settings).expect_err("an inertia that is needed").error;
                assert!(matches!(error, Error::Parameter { value: 0.0, .. }), "{kind}: {error:?}");
                assert_says(&error, &["the inertia of `", "is 0", "the scene is compiled with 0"]);
            }
        }
    }
}

/// The scene after it was written to a file and read again.
#[cfg(feature = "files")]
fn from_file(scene: &Scene) -> System {
    let file = scene.to_json().expect("a file");
    hamiltonian_adjoint::SceneFile::from_json(&file).expect("a scene").scene.compile().expect("a scene")
}

#[cfg(not(feature = "files"))]
fn from_file(scene: &Scene) -> System {
    scene.clone().compile().expect("a scene")
}

#[test]
fn files_and_other_solvers_know_the_same_motion() {
    let settings = Settings::default();
    for kind in KINDS {
        let (scene, held) = scene(kind, 0.0);
        let (plain, read) = (scene.clone().compile_without_programs().expect("a scene"), from_file(&scene));
        let system = scene.compile().expect("a scene");
        let inputs = inputs(&system, &held);
        let expected = gradient(&system, &inputs, settings).expect("a gradient");
        let assert_same = |what: &str, other: &Gradient| {
            for (ours, reference) in [
                (other.design.as_slice(), expected.design.as_slice()),
                (other.controls.as_slice(), expected.controls.as_slice()),
            ] {
                let error = relative_error(ours, reference);
                assert!(error < 1e-12, "{kind}, {what}: {error:e}");
            }
        };
        assert_same("without programs", &gradient(&plain, &inputs, settings).expect("a gradient"));
        assert_same("long", LongSolver::new(&system, settings, 30_000).gradient(&inputs).expect("a gradient"));
        check::gradient(&system, &inputs, settings).run().expect("a report").assert_passed();
        let free = Inputs { start: Start::assembled(&read), ..inputs.clone() };
        let [was, is] = [&system, &read].map(|system| simulate(system, &free, settings).expect("a motion").nodes.q);
        assert!((was - is).amax() < 1e-13, "{kind}");
    }
}
