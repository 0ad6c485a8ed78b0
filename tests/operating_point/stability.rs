//! Which equilibria are stable.

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Coordinate, Force, ForcePoint, KineticEnergy, Mechanics, PotentialEnergy, Scalar, Scene, System};
use nalgebra::SVector;

/// Ziegler's double pendulum: links of length 1, masses 2 and 1 at their ends, springs of stiffness 1 in both hinges, angles from the axis.
struct Ziegler;
impl KineticEnergy<2> for Ziegler {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * 1.5 + v[1] * v[1] * 0.5 + v[0] * v[1] * (q[0] - q[1]).cos()
    }
}
impl PotentialEnergy<2> for Ziegler {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, _b: &SVector<S, 0>, _t: S) -> S {
        let bend = q[1] - q[0];
        (q[0] * q[0] + bend * bend) * 0.5
    }
}

/// A force u at the end against the direction of the second link, and viscous friction b.
struct Follower;
impl Force<2, 1, 1> for Follower {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 1>, b: &SVector<S, 1>) -> SVector<S, 2> {
        let bend = at.v[1] - at.v[0];
        SVector::from([at.u[0] * (at.q[0] - at.q[1]).sin() - b[0] * (at.v[0] - bend), -b[0] * bend])
    }
}

fn ziegler(damping: f64) -> System {
    let mut scene = Scene::new();
    let q: [Coordinate; 2] = scene.coordinates("angle", ["1", "2"]);
    let load = scene.control("load");
    scene.kinetic_energy("masses", Ziegler, q, []);
    scene.potential_energy("springs", Ziegler, q, []);
    scene.force("load", Follower, q, [load], [damping.into()]);
    scene.compile().expect("a scene")
}

/// H. Ziegler, Ing.-Archiv 20 (1952): without damping flutter begins at 7/2 − √2.
#[test]
fn a_follower_load_flutters_above_zieglers_load() {
    let system = ziegler(0.0);
    let critical = 3.5 - std::f64::consts::SQRT_2;
    for (load, is_stable) in [(0.0, true), (critical - 1e-4, true), (critical + 1e-4, false), (4.0, false)] {
        let at =
            Mechanics::new(&system, &[0.01, -0.02], &[0.0; 2]).expect("a state").with_controls(&[load]).expect("a load");
        let found = at.equilibrium(&[]).expect("an equilibrium");
        assert!(found.state.q().iter().all(|q| q.abs() < 1e-13), "{load}: {:?}", found.state.q());
        assert_eq!(found.is_stable(), is_stable, "{load}: {:?}", found.eigenvalues);
    }
    // A little friction destabilises it, down to 41/28 for small friction of this kind.
    let system = ziegler(1e-3);
    for (load, is_stable) in [(1.46, true), (1.47, false)] {
        let at = Mechanics::new(&system, &[0.0; 2], &[0.0; 2]).expect("a state").with_controls(&[load]).expect("a load");
        let found = at.equilibrium(&[]).expect("an equilibrium");
        assert_eq!(found.is_stable(), is_stable, "{load}: {:?}", found.eigenvalues);
    }
}

/// A column of rods with springs in its hinges, under gravity.
fn column(stiffness: f64) -> (System, Vec<f64>) {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let mut last = (Body::GROUND, Body::GROUND.at(0.0, 0.0));
    for k in 0..4 {
        let rod = scene.body(&format!("rod {k}"), 1.0, 0.02, [0.0, 0.25 + 0.5 * k as f64, std::f64::consts::FRAC_PI_2]);
        scene.revolute(&format!("hinge {k}"), last.1, rod.at(-0.25, 0.0));
        let free = if k == 0 { std::f64::consts::FRAC_PI_2 } else { 0.0 };
        scene.torsional_spring_damper(&format!("spring {k}"), last.0, rod, stiffness, free, 0.1);
        last = (rod.into(), rod.at(0.25, 0.0));
    }
    let system = scene.compile().expect("a scene");
    let q = system.initial_coordinates().as_slice().to_vec();
    (system, q)
}

#[test]
fn a_column_buckles_under_its_weight_and_comes_to_rest_bent() {
    let energy = |at: &Mechanics| at.potential_energy();
    for (stiffness, is_stable) in [(60.0, true), (5.0, false)] {
        let (system, q) = column(stiffness);
        let at = Mechanics::new(&system, &q, &vec![0.0; q.len()]).expect("a state");
        let upright = at.equilibrium(&[]).expect("an equilibrium");
        assert_eq!(upright.is_stable(), is_stable, "{:?}", upright.eigenvalues);
        let rest = at.stable_equilibrium(&[]).expect("an equilibrium");
        assert!(rest.is_stable());
        let fallen = energy(&upright.state) - energy(&rest.state);
        assert_eq!(fallen < 1e-9, is_stable, "{fallen}");
        // No small admissible motion lowers the energy.
        let (v_dot, _) = rest.state.accelerations().expect("accelerations");
        assert!(v_dot.amax() < 1e-10, "{v_dot}");
    }
}

/// An arm with a motor at its shoulder, horizontal, where its weight has no stiffness.
#[test]
fn a_guess_without_stiffness_leads_to_an_equilibrium() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -10.0);
    let arm = scene.body("arm", 2.0, 0.1, [0.5, 0.0, 0.0]);
    scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), arm.at(-0.5, 0.0));
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, arm, torque);
    let system = scene.compile().expect("a scene");
    let guess = Mechanics::new(&system, system.initial_coordinates().as_slice(), &[0.0; 3]).expect("a state");
    for (torque, cosine) in [(5.0, 0.5), (-5.0, -0.5), (9.99, 0.999), (0.0, 0.0)] {
        let found = guess.clone().with_controls(&[torque]).expect("a torque").equilibrium(&[]).expect("an equilibrium");
        let phi = found.state.q()[2];
        assert!((phi.cos() - cosine).abs() < 1e-12, "{torque}: {phi}");
        assert!(found.is_stable() && phi.sin() < 0.0);
    }
    let error = guess.with_controls(&[10.1]).expect("a torque").equilibrium(&[]).expect_err("a strong motor");
    assert!(matches!(error, hamiltonian_adjoint::Error::NoEquilibrium { .. }), "{error}");
}
