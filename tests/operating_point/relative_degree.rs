//! The relative degree of coordinates behind springs and dampers.

use crate::common::assert_says;
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Control, Coordinate, Error, Mechanics, Scene};

/// Two carts with a spring, and perhaps a damper, between them, on rails, and the force on the first one.
fn carts(damping: f64) -> (Mechanics, [Coordinate; 4], Control) {
    let mut scene = Scene::new();
    let carts = [0, 1].map(|k| scene.body(&format!("cart {k}"), 2.0, 0.1, [k as f64, 0.0, 0.0]));
    let force = scene.control("force");
    for (k, cart) in carts.iter().enumerate() {
        scene.prismatic(&format!("rail {k}"), Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), 0.0);
    }
    scene.spring_damper("spring", carts[0].at(0.0, 0.0), carts[1].at(0.0, 0.0), 100.0, 1.0, damping);
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, carts[0].at(0.0, 0.0), force);
    let system = scene.compile().expect("a scene");
    let at = Mechanics::new(&system, system.initial_coordinates().as_slice(), &[0.0; 6]).expect("a state");
    (at, [carts[0].coordinates[0], carts[1].coordinates[0], carts[1].coordinates[1], carts[0].coordinates[2]], force)
}

#[test]
fn relative_degrees() {
    for (damping, degree) in [(0.0, 4), (2.0, 3)] {
        let (at, [own, behind, across, angle], force) = carts(damping);
        let of = |q: Coordinate| at.relative_degree(q, &[force]).expect("a linear model");
        assert_eq!([of(own), of(behind), of(across), of(angle)], [Some(2), Some(degree), None, None]);
        assert_eq!(at.relative_degree(own, &[]).expect("a linear model"), None);
        let error = at.inverse_dynamics(&[(behind, 1.0)], &[force]).expect_err("a spring");
        assert_says(&error, &[&format!("order {degree}"), &format!("index {}", degree + 1)]);
    }
    // A third cart behind a second spring: the derivatives of order 6.
    let mut scene = Scene::new();
    let carts = [0, 1, 2].map(|k| scene.particle(&format!("cart {k}"), 1.0 + k as f64, [k as f64, 0.0]));
    let force = scene.control("force");
    for k in 0..2 {
        scene.spring_damper(
            &format!("spring {k}"),
            carts[k].point(),
            carts[k + 1].point(),
            1e-3 * 1e6f64.powi(k as i32),
            1.0,
            0.0,
        );
    }
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, carts[0].point(), force);
    let system = scene.compile().expect("a scene");
    let at = Mechanics::new(&system, &[0.0, 0.0, 1.0, 0.0, 2.0, 0.0], &[0.0; 6]).expect("a state");
    assert_eq!(at.relative_degree(carts[2].coordinates[0], &[force]).expect("a linear model"), Some(6));
    let (_, [other, ..], foreign) = self::carts(0.0);
    assert!(matches!(at.relative_degree(other, &[force]), Err(Error::Foreign { kind: "coordinate", .. })));
    assert!(matches!(at.relative_degree(carts[0].coordinates[0], &[foreign]), Err(Error::Foreign { kind: "control", .. })));
}
