//! What holds at one state: against closed forms, against motions, and against the numbers of a published mechanism.

use crate::common::{assert_says, largest};
use crate::scenes::{seven_bodies, structures, varying};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{Error, Grid, Inputs, Mechanics, Scene, Scheme, Settings, Solver, Start, Sum, simulate};
use nalgebra::{DMatrix, DVector};

#[test]
fn a_pendulum_has_its_textbook_accelerations_and_reactions() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let (m, l, angle, rate) = (1.3, 0.7f64, -0.4f64, 2.1f64);
    let bob = scene.body("bob", m, 0.2, [l * angle.cos(), l * angle.sin(), 0.3]);
    scene.distance("rod", Body::GROUND.at(0.0, 0.0), bob.at(0.0, 0.0), l);
    let system = scene.compile().expect("a scene");
    let q = [l * angle.cos(), l * angle.sin(), 0.3];
    let v = [-l * rate * angle.sin(), l * rate * angle.cos(), 0.0];
    let at = Mechanics::new(&system, &q, &v).expect("a state");
    let (v_dot, lambda) = at.accelerations().expect("accelerations");
    let turn = -9.81 * angle.cos() / l;
    let expected =
        [-l * (turn * angle.sin() + rate * rate * angle.cos()), l * (turn * angle.cos() - rate * rate * angle.sin()), 0.0];
    assert!((0..3).all(|i| (v_dot[i] - expected[i]).abs() < 1e-13), "{v_dot}");
    // What keeps the bob on its circle, as a force along the rod.
    let pull = m * (l * rate * rate - 9.81 * angle.sin());
    let reaction = at.phi_q().transpose() * lambda;
    assert!((reaction.norm() - pull).abs() < 1e-12, "{reaction}");
    assert!((at.kinetic_energy() - 0.5 * m * (l * rate).powi(2)).abs() < 1e-14);
    assert!((at.potential_energy() - m * 9.81 * l * angle.sin()).abs() < 1e-14);
    assert_eq!(at.energy(), at.kinetic_energy() + at.potential_energy());
    assert_eq!(at.mass(), DMatrix::from_diagonal(&DVector::from_row_slice(&[m, m, 0.2])));
    assert!(largest((at.momenta() - at.mass() * DVector::from_row_slice(&v)).as_slice()) < 1e-15);
    assert!(largest(at.phi().as_slice()) < 1e-15 && largest(at.phi_dot().as_slice()) < 1e-15);
}

/// Hairer and Wanner (1996), section VII.7, give the accelerations and multipliers of the first moment.
#[test]
fn seven_bodies_start_as_published() {
    for scene in [seven_bodies::whole(), seven_bodies::by_parts()] {
        let system = scene.compile().expect("a scene");
        let q = system.initial_coordinates();
        let at = Mechanics::new(&system, q.as_slice(), &[0.0; 7]).expect("a state").with_controls(&[1.0]).expect("a torque");
        assert!(largest(at.phi().as_slice()) < 1e-15, "{}", at.phi());
        let (v_dot, lambda) = at.accelerations().expect("accelerations");
        assert!((v_dot[0] - 14222.443919954114).abs() < 1e-7, "{v_dot}");
        assert!((v_dot[1] + 10666.832939965585).abs() < 1e-7, "{v_dot}");
        assert!((lambda[0].abs() - 98.566_870_396_241_09).abs() < 1e-9, "{lambda}");
        assert!((lambda[1].abs() - 6.122_688_344_255_663).abs() < 1e-9, "{lambda}");
    }
}

#[test]
fn accelerations_and_reactions_are_the_rates_of_a_motion() {
    let system = CartPendulum::default().scene().compile().expect("a scene");
    let dt = 1e-4;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, dt));
    inputs.controls.fill(10.0);
    let settings = Settings { scheme: Scheme::ESDIRK5, ..Settings::default() };
    let motion = simulate(&system, &inputs, settings).expect("a motion");
    let at = Mechanics::at_node(&system, &inputs, &motion, 10).expect("a node");
    let (v_dot, lambda) = at.accelerations().expect("accelerations");
    let rate = |x: &DMatrix<f64>| (x.column(11) - x.column(9)) / (2.0 * dt);
    assert!(largest((v_dot - rate(&motion.v)).as_slice()) < 1e-4);
    assert!(largest((lambda - rate(&motion.sigma)).as_slice()) < 1e-4);
    let beyond =
        Mechanics::at_node(&system, &inputs, &motion, 21).map(drop).expect_err("a node that is not there").to_string();
    assert!(beyond.contains("21 nodes") && beyond.contains("counted from 0"), "{beyond}");
}

#[test]
fn energy_is_conserved_along_a_motion_without_friction() {
    let cart = CartPendulum { rail_friction: 0.0, hinge_friction: 0.0, ..CartPendulum::default() };
    let system = cart.scene().compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.001));
    let mut solver = Solver::new(&system, Settings { scheme: Scheme::ESDIRK5, ..Settings::default() });
    let motion = solver.simulate(&inputs).expect("a motion").clone();
    let energy = |node| Mechanics::at_node(&system, solver.inputs(), &motion, node).expect("a node").energy();
    assert!((energy(100) - energy(0)).abs() < 1e-6, "{} {}", energy(0), energy(100));
}

#[test]
fn dependent_constraints_share_a_reaction_that_is_determined() {
    let of = |hinges: usize| {
        let system = structures::string(3, hinges).compile().expect("a scene");
        let inputs = Inputs::at_rest(&system, Grid::uniform(1, 0.01));
        let at =
            Mechanics::at_start(&system, &inputs).expect("a start").with_controls(&vec![0.7; system.k()]).expect("controls");
        let (v_dot, lambda) = at.accelerations().expect("accelerations");
        (v_dot, at.phi_q().transpose() * lambda)
    };
    let ((plain, force), (doubled, same)) = (of(1), of(2));
    assert!(largest((plain - doubled).as_slice()) < 1e-9);
    assert!(largest((force - same).as_slice()) < 1e-9);
}

#[test]
fn points_follow_their_bodies() {
    let mut scene = Scene::new();
    let l = scene.design("length", 0.8);
    let arm = scene.body("arm", 1.0, 0.1, [0.0; 3]);
    let system = scene.compile().expect("a scene");
    let (q, v) = ([0.3, -0.2, 1.1f64], [0.5, 0.1, -2.0]);
    let tip = arm.at(l * 0.5, 0.1);
    let at = Mechanics::new(&system, &q, &v).expect("a state").with_design(&[1.2]).expect("a length");
    let dt = 1e-6;
    let later = |sign: f64| {
        let q: Vec<f64> = q.iter().zip(v).map(|(q, v)| q + sign * dt * v).collect();
        Mechanics::new(&system, &q, &v).expect("a state").with_design(&[1.2]).expect("a length").position(tip)
    };
    let (sin, cos) = q[2].sin_cos();
    assert_eq!(at.position(tip), [0.3 + cos * 0.6 - sin * 0.1, -0.2 + sin * 0.6 + cos * 0.1]);
    let (ahead, behind) = (later(1.0), later(-1.0));
    let velocity = at.velocity(tip);
    assert!((0..2).all(|k| (velocity[k] - (ahead[k] - behind[k]) / (2.0 * dt)).abs() < 1e-9));
    assert_eq!((at.position(Body::GROUND.at(1.0, l)), at.velocity(Body::GROUND.at(1.0, l))), ([1.0, 1.2], [0.0; 2]));
}

#[test]
fn points_that_the_system_does_not_know_are_refused() {
    let build = || {
        let mut scene = Scene::new();
        let l = scene.design("length", 0.8);
        let arm = scene.body("arm", 1.0, 0.1, [0.0; 3]);
        (scene.compile().expect("a scene"), l, arm)
    };
    let ((system, l, arm), (_, other_l, other_arm)) = (build(), build());
    let at = Mechanics::at_start(&system, &Inputs::at_rest(&system, Grid::uniform(1, 0.1))).expect("a start");
    // A multiple of a design variable is known whenever it is made, a sum only before the scene is compiled.
    assert_eq!(at.position(arm.at(l * 0.5, 0.0)), [0.4, 0.0]);
    let unknown = [(arm.at(l + 0.1, 0.0), "after"), (arm.at(other_l, 0.0), "another"), (other_arm.at(0.0, 0.0), "another")];
    for (point, word) in unknown {
        let message =
            std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| at.position(point))).expect_err("nothing to say");
        assert!(message.downcast_ref::<&str>().is_some_and(|message| message.contains(word)));
    }
}

#[test]
fn a_start_is_assembled_or_follows_from_momenta() {
    let system = CartPendulum::default().scene().compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(3, 0.01));
    let p_star = DVector::from_fn(system.n(), |i, _| 0.1 * (i as f64).sin());
    inputs.start = Start::Momentum { q: system.initial_coordinates(), p_star };
    let at = Mechanics::at_start(&system, &inputs).expect("a start");
    assert!(largest(at.phi_dot().as_slice()) < 1e-14 && at.kinetic_energy() > 1e-4);
    // Whatever counts at later nodes.
    let mut cart = CartPendulum::default().mechanism();
    cart.scene.cost("at a node", AngleError, Sum::Node(2), [cart.links[0].coordinates[2]], [], [], [0.3.into()]);
    let later = cart.scene.compile().expect("a scene");
    for start in [inputs.start.clone(), Start::assembled(&later)] {
        Mechanics::at_start(&later, &Inputs { start, ..inputs.clone() }).expect("a start");
    }
    // What no motion starts from is refused.
    let mut apart = Inputs::at_rest(&system, Grid::uniform(3, 0.01));
    apart.start.q_mut()[1] += 0.2;
    assert!(matches!(Mechanics::at_start(&system, &apart), Err(Error::InitialPosition { .. })));
    inputs.start = Start::assembled(&system);
    inputs.start.q_mut()[2] += 0.3;
    let at = Mechanics::at_start(&system, &inputs).expect("a start");
    assert!(largest(at.phi().as_slice()) < 1e-14);
}

#[test]
fn what_does_not_fit_is_named() {
    let system = CartPendulum::default().scene().compile().expect("a scene");
    let zeros = vec![0.0; system.n()];
    assert_says(
        &Mechanics::new(&system, &zeros[1..], &zeros).expect_err("a short vector"),
        &["q", "expected 12", "found 11"],
    );
    let at = Mechanics::new(&system, &zeros, &zeros).expect("a state");
    assert_says(&at.clone().at_time(f64::NAN).expect_err("no time"), &["t", "NaN"]);
    assert_says(&at.clone().with_controls(&[]).expect_err("no control"), &["controls", "expected 1"]);
    assert_says(&at.with_design(&[1.0]).expect_err("no design variables"), &["design variables", "expected 0"]);
}

#[test]
fn a_mass_matrix_that_varies_and_a_constraint_that_depends_on_time_are_no_exception() {
    let (scene, q) = varying::bead();
    let system = scene.compile().expect("a scene");
    let dt = 1e-4;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, dt));
    inputs.start = Start::assembled(&system);
    inputs.start.set_rate(q[0], 0.7);
    inputs.controls.fill(0.4);
    let mut solver = Solver::new(&system, Settings { scheme: Scheme::ESDIRK5, ..Settings::default() });
    let motion = solver.simulate(&inputs).expect("a motion").clone();
    let at = Mechanics::at_node(&system, solver.inputs(), &motion, 10).expect("a node");
    let (v_dot, lambda) = at.accelerations().expect("accelerations");
    let rate = |x: &DMatrix<f64>| (x.column(11) - x.column(9)) / (2.0 * dt);
    assert!(largest((v_dot - rate(&motion.v)).as_slice()) < 1e-5);
    assert!(largest((lambda - rate(&motion.sigma)).as_slice()) < 1e-5);
}
