//! Clones of a scene: the same parts, whose handles are valid in both; those of later parts are valid in their own scene only.

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::AngleError;
use hamiltonian_adjoint::{
    Control, Cost, CostPoint, Design, Error, Grid, Inputs, Mechanics, Multiplier, Output, Scalar, Scene, Settings, Solver,
    Sum, System, gradient,
};
use nalgebra::SVector;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// σ².
struct Square;
impl Cost<0, 1, 0, 0> for Square {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 1, 0>, _b: &SVector<S, 0>) -> S {
        at.sigma[0] * at.sigma[0]
    }
}

/// Parts of a scene.
#[derive(Clone, Copy)]
struct Parts {
    body: Body,
    mass: Design,
    length: Design,
    torque: Control,
    output: Output,
    multiplier: Multiplier,
}

/// Adds a pendulum with a mass of so many kg.
fn add(scene: &mut Scene, name: &str, kg: f64) -> Parts {
    let (mass, length) = (scene.design(&format!("m {name}"), kg), scene.design(&format!("l {name}"), 0.5));
    let body = scene.body(name, mass, mass * length * length / 12.0, [0.25, 0.0, 0.0]);
    let [multiplier, _] = scene.revolute(&format!("hinge {name}"), Body::GROUND.at(0.0, 0.0), body.at(length * -0.5, 0.0));
    let (torque, output) = (scene.control(&format!("u {name}")), scene.output(&format!("output {name}")));
    scene.torque_actuator(&format!("motor {name}"), Body::GROUND, body, torque);
    scene.term(output, &format!("angle {name}"), AngleError, Sum::Terminal, [body.coordinates[2]], [], [], [0.1.into()]);
    Parts { body, mass, length, torque, output, multiplier }
}

/// A scene with a cost that is the mass times the duration.
fn scene() -> (Scene, Parts) {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let parts = add(&mut scene, "first", 2.0);
    scene.time("time", parts.mass);
    (scene, parts)
}

fn inputs(system: &System) -> Inputs {
    Inputs::at_rest(system, Grid::uniform(4, 0.25))
}

/// J of a motion of 1 s.
fn cost(scene: Scene) -> f64 {
    let system = scene.compile().expect("a scene");
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs(&system)).expect("a motion");
    solver.cost().expect("a cost")
}

#[test]
fn a_clone_is_the_same_scene() {
    let (scene, parts) = scene();
    let clone = scene.clone();
    #[cfg(feature = "files")]
    assert_eq!(clone.to_json().expect("a file"), scene.to_json().expect("a file"));
    assert_eq!(clone.coordinate_named("first.x"), Some(parts.body.coordinates[0]));
    let plain = clone.clone().compile_without_programs().expect("a scene");
    let [one, other] = [scene, clone].map(|scene| scene.compile().expect("a scene"));
    assert_eq!([&one, &other, &plain].map(|system| system.coordinate(2)), [parts.body.coordinates[2]; 3]);
    let of = |system: &System| gradient(system, &inputs(system), Settings::default()).expect("a gradient");
    assert_eq!(of(&one), of(&other));
    assert!((of(&one).design - of(&plain).design).amax() < 1e-12);
}

#[test]
fn handles_are_valid_in_the_scenes_that_have_the_part() {
    type Use = fn(&mut Scene, Parts, Parts);
    let uses: [(&str, Use); 10] = [
        ("coordinate", |scene, _, of| scene.place(of.body.coordinates[0], 0.25)),
        ("body", |scene, _, of| scene.torsional_spring_damper("x", of.body, Body::GROUND, 1.0, 0.0, 0.0)),
        ("control", |scene, first, of| scene.torque_actuator("x", Body::GROUND, first.body, of.torque)),
        ("design", |scene, _, of| scene.time("x", of.mass)),
        ("multiple", |scene, _, of| scene.time("x", -of.mass)),
        ("expression", |scene, _, of| scene.time("x", of.mass * of.length)),
        ("mixed", |scene, first, of| scene.time("x", (of.mass + first.mass * first.length).sqrt())),
        ("mixed the other way", |scene, first, of| scene.time("x", (first.mass * of.length - first.length).sin())),
        ("output", |scene, first, of| {
            scene.term(of.output, "x", AngleError, Sum::Terminal, [first.body.coordinates[1]], [], [], [0.0.into()]);
        }),
        ("multiplier", |scene, _, of| scene.cost("x", Square, Sum::Integral, [], [of.multiplier], [], [])),
    ];
    for (what, apply) in uses {
        for clone_first in [false, true] {
            let (mut own, first) = scene();
            let mut other = own.clone();
            if clone_first {
                std::mem::swap(&mut own, &mut other);
            }
            // Of the same numbers in both.
            let (of_own, of_other) = (add(&mut own, "later", 3.0), add(&mut other, "later", 5.0));
            let mut third = own.clone();
            let of_third = add(&mut third, "third", 7.0);
            let result = |scene: &Scene, of: Parts| {
                let mut scene = scene.clone();
                apply(&mut scene, first, of);
                scene.compile().map(drop)
            };
            for (scene, of) in [(&own, of_own), (&other, of_other), (&third, of_own), (&third, of_third)] {
                assert_eq!(result(scene, of), Ok(()), "{what}");
            }
            [&own, &other, &third].into_iter().for_each(|scene| assert_eq!(result(scene, first), Ok(()), "{what}"));
            for (scene, of) in [(&own, of_other), (&other, of_own), (&third, of_other), (&own, of_third), (&other, of_third)]
            {
                assert!(matches!(result(scene, of), Err(Error::Foreign { .. })), "{what}");
            }
        }
    }
}

#[test]
fn expressions_of_clones_are_their_own() {
    let (mut own, first) = scene();
    let mut other = own.clone();
    // Design variables of the same numbers, and one more.
    let (a, b) = (own.design("a", 3.0), other.design("b", 5.0));
    let c = other.design("c", 7.0);
    own.time("x", (a * first.mass).sqrt() * first.length);
    other.time("x", (b * first.mass).sqrt() + c * first.length);
    let both = a * b;
    for scene in [&own, &other] {
        let mut scene = scene.clone();
        scene.time("y", both);
        assert!(matches!(scene.compile(), Err(Error::Foreign { .. })));
    }
    let mut later = own.clone();
    assert!((cost(own) - (2.0 + 6.0f64.sqrt() * 0.5)).abs() < 1e-14);
    // The first scene is gone; what both had can still be used.
    other.time("y", first.mass * first.mass / first.length);
    assert!((cost(other) - (2.0 + 10.0f64.sqrt() + 3.5 + 8.0)).abs() < 1e-14);
    later.time("z", first.mass / a);
    assert!((cost(later) - (2.0 + 6.0f64.sqrt() * 0.5 + 2.0 / 3.0)).abs() < 1e-14);
    let mut late = Scene::new();
    late.time("w", first.mass * first.length);
    assert!(matches!(late.compile(), Err(Error::Foreign { .. })), "all of them are gone");
}

#[test]
fn a_compiled_scene_does_not_know_what_is_made_of_its_design_variables_later() {
    let (scene, parts) = scene();
    let clone = scene.clone();
    let system = scene.compile().expect("a scene");
    let mechanics = Mechanics::at_start(&system, &inputs(&system)).expect("a place");
    let at = |x: hamiltonian_adjoint::Param| catch_unwind(AssertUnwindSafe(|| mechanics.position(parts.body.at(x, 0.0))));
    assert!((at(parts.length * 0.5).expect("a place")[0] - 0.5).abs() < 1e-15);
    assert!(at((parts.length * parts.mass).exp()).is_err());
    drop(clone);
}
