//! Equilibria with held coordinates, and the forces that hold them.

use crate::cases::{angle, differences, four_bar};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Mechanics, Scene, System};
use nalgebra::DVector;

fn guess(system: &System) -> Mechanics {
    Mechanics::new(system, system.initial_coordinates().as_slice(), &vec![0.0; system.n()]).expect("a guess")
}

#[test]
fn a_held_cart_lets_its_links_hang_and_is_held_by_its_drive_force() {
    let parts = CartPendulum { start_angle: -1.0, ..CartPendulum::default() }.mechanism();
    let (cart, links, rail) = (parts.cart.coordinates[0], parts.links, parts.rail);
    let system = parts.scene.compile().expect("a scene");
    let found = guess(&system).with_controls(&[3.0]).expect("a force").equilibrium(&[cart]).expect("an equilibrium");
    let angles = links.iter().map(|link| found.state.q()[link.coordinates[2].index()]);
    assert!(
        angles.clone().all(|phi| (phi + std::f64::consts::FRAC_PI_2).abs() < 1e-13),
        "{:?}",
        angles.collect::<Vec<f64>>()
    );
    assert_eq!(found.state.q()[cart.index()], 0.0);
    assert!((found.holding[cart.index()] + 3.0).abs() < 1e-12 && (found.holding.norm() - 3.0).abs() < 1e-12);
    assert!((found.by_controls.holding[(cart.index(), 0)] + 1.0).abs() < 1e-12 && found.by_controls.q.amax() < 1e-12);
    // The constraints carry the weight of the cart, and the rail that of all bodies.
    let on_cart = -found.state.phi_q().tr_mul(&found.lambda)[1];
    assert!((on_cart - 0.8 * 9.81).abs() < 1e-11, "{on_cart}");
    let on_rail = rail.map(|multiplier| found.lambda[multiplier.index()].abs()).into_iter().fold(0.0, f64::max);
    assert!((on_rail - (0.8 + 3.0 * 0.4) * 9.81).abs() < 1e-11, "{on_rail}");
    assert_eq!(found.eigenvalues.len(), 6);
    assert!(found.is_stable());
}

/// With all freedoms held, what remains is inverse statics.
#[test]
fn a_held_crank_needs_the_torque_that_another_computation_gives() {
    let (system, crank) = four_bar();
    let angle = angle(crank);
    let found = guess(&system).equilibrium(&[angle]).expect("an equilibrium");
    assert!(found.eigenvalues.is_empty() && found.is_stable());
    assert_eq!(found.state.q()[angle.index()], 1.2);
    // A motor with the torque of the holding force balances the linkage.
    let torque = found.holding[angle.index()];
    let balanced = guess(&system).with_controls(&[torque]).expect("a torque").equilibrium(&[]).expect("an equilibrium");
    let moved = DVector::from_column_slice(balanced.state.q()) - DVector::from_column_slice(found.state.q());
    assert!(torque.abs() > 0.5 && moved.amax() < 1e-12, "{torque} {moved}");
    assert!((&found.lambda - &balanced.lambda).amax() < 1e-10);
    // Of the torque and the reactions, by new ones.
    let design = system.design_values();
    for j in 0..design.len() {
        let expected = differences(|by| {
            let mut design = design.clone();
            design[j] += by;
            let again = guess(&system).with_design(design.as_slice()).expect("a design").equilibrium(&[angle]);
            let again = again.expect("an equilibrium");
            DVector::from_vec([again.state.q(), again.lambda.as_slice(), again.holding.as_slice()].concat())
        });
        let of = &found.by_design;
        let ours: Vec<f64> =
            [&of.q, &of.lambda, &of.holding].iter().flat_map(|x| x.column(j).iter().copied().collect::<Vec<_>>()).collect();
        let ours = DVector::from_vec(ours);
        assert!((&ours - &expected).amax() < 1e-8 * expected.amax(), "{ours}{expected}");
    }
}

#[test]
fn a_structure_without_degrees_of_freedom_has_the_reactions_of_statics() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -10.0);
    let beam = scene.body("beam", 2.0, 0.1, [0.5, 0.0, 0.0]);
    scene.revolute("pin", Body::GROUND.at(0.0, 0.0), beam.at(-0.5, 0.0));
    let strut = scene.distance("strut", Body::GROUND.at(0.0, -1.0), beam.at(0.5, 0.0), 2.0f64.sqrt());
    let system = scene.compile().expect("a scene");
    for search in [Mechanics::equilibrium, Mechanics::stable_equilibrium] {
        let found = search(&guess(&system), &[]).expect("an equilibrium");
        // Moments about the pin: the strut carries half of the weight at 45°.
        assert!((found.lambda[strut[0].index()] + 10.0 * 2.0f64.sqrt()).abs() < 1e-12, "{}", found.lambda);
        assert!(found.eigenvalues.is_empty() && found.is_stable());
    }
    let linear = guess(&system).linear_model(&[]).expect("a linear model");
    assert_eq!((linear.a.shape(), linear.q_z.shape(), linear.eigenvalues.len()), ((0, 0), (3, 0), 0));
}

#[test]
fn a_cart_that_is_not_held_is_neutral_or_out_of_balance() {
    let parts = CartPendulum { start_angle: -1.0, ..CartPendulum::default() }.mechanism();
    let system = parts.scene.compile().expect("a scene");
    for search in [Mechanics::equilibrium, Mechanics::stable_equilibrium] {
        let error = search(&guess(&system), &[]).expect_err("a cart on a rail");
        crate::common::assert_says(&error, &["not isolated", "`cart.x`", "hold one"]);
        let pushed = guess(&system).with_controls(&[3.0]).expect("a force");
        let error = search(&pushed, &[]).expect_err("a cart that is pushed");
        crate::common::assert_says(&error, &["no equilibrium", "3.000e0", ".x`"]);
    }
}
