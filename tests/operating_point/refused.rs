//! Input that does not fit, and states for which there is no answer.

use crate::cases::{driven, four_bar, parallelogram};
use crate::common::assert_says;
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Error, Force, ForcePoint, Mechanics, Scalar, Scene, System};
use nalgebra::SVector;

fn at_rest(system: &System) -> Mechanics {
    Mechanics::new(system, system.initial_coordinates().as_slice(), &vec![0.0; system.n()]).expect("a state")
}

#[test]
fn states_and_coordinates_that_do_not_fit_are_refused_by_name() {
    let (system, crank) = four_bar();
    let error = at_rest(&system).linear_model(&[]).expect_err("a guess");
    assert_says(&error, &["violates", "Mechanics::at_start"]);
    let (plane, [first, coupler]) = parallelogram(3, 1.0);
    let mut v = vec![0.0; plane.n()];
    v[first.coordinates[2].index()] = 1.0;
    let q = plane.initial_coordinates();
    let error = Mechanics::new(&plane, q.as_slice(), &v).expect("a state").linear_model(&[]).expect_err("a wrong velocity");
    assert_says(&error, &["violates the rate of"]);
    let two = [first.coordinates[2], coupler.coordinates[0]];
    let error = at_rest(&plane).linear_model(&two).expect_err("one degree of freedom");
    assert_says(&error, &["`coupler.x` is not independent"]);
    let error = at_rest(&plane).equilibrium(&two).expect_err("one degree of freedom");
    assert_says(&error, &["`coupler.x`", "held"]);
    for error in [
        at_rest(&plane).linear_model(&[crank.coordinates[2]]).expect_err("another scene"),
        at_rest(&plane).equilibrium(&[crank.coordinates[2]]).expect_err("another scene"),
    ] {
        assert!(matches!(error, Error::Foreign { .. }), "{error}");
    }
}

#[test]
fn a_constraint_that_moves_allows_no_equilibrium() {
    let system = driven();
    let error = at_rest(&system).at_time(0.4).expect("a time").equilibrium(&[]).expect_err("a drive");
    assert_says(&error, &["t = 0.4 s", "drive", "depends on time"]);
    // At its turning point the drive rests but accelerates.
    let error =
        at_rest(&system).at_time(std::f64::consts::FRAC_PI_2).expect("a time").equilibrium(&[]).expect_err("a drive");
    assert_says(&error, &["drive", "depends on time"]);
}

#[test]
fn a_flat_parallelogram_is_refused_as_singular() {
    let mut scene = Scene::new();
    let coupler = scene.body("coupler", 1.0, 0.1, [2.0, 0.0, 0.0]);
    for (k, along) in [0.0, 2.0].into_iter().enumerate() {
        let crank = scene.body(&format!("crank {k}"), 1.0, 0.1, [along + 0.5, 0.0, 0.0]);
        scene.revolute(&format!("foot {k}"), Body::GROUND.at(along, 0.0), crank.at(-0.5, 0.0));
        scene.revolute(&format!("head {k}"), crank.at(0.5, 0.0), coupler.at(along - 1.0, 0.0));
    }
    let system = scene.compile().expect("a scene");
    assert!(matches!(at_rest(&system).linear_model(&[]), Err(Error::SingularConfiguration { .. })));
    assert!(matches!(at_rest(&system).equilibrium(&[]), Err(Error::SingularConfiguration { .. })));
}

/// √q.
struct Root;
impl Force<1, 0, 0> for Root {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([-at.q[0].sqrt()])
    }
}

#[test]
fn formulas_without_a_derivative_are_named() {
    let mut scene = Scene::new();
    let ball = scene.particle("ball", 1.0, [0.0, 0.0]);
    scene.force("root", Root, [ball.coordinates[0]], [], []);
    let system = scene.compile().expect("a scene");
    for error in [
        at_rest(&system).linear_model(&[]).expect_err("no derivative"),
        at_rest(&system).equilibrium(&[]).expect_err("no derivative"),
    ] {
        assert_says(&error, &["root"]);
    }
}

#[test]
fn a_constant_force_that_nothing_balances_is_named() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let ball = scene.particle("ball", 2.0, [0.0, 0.0]);
    let system = scene.compile().expect("a scene");
    let error = at_rest(&system).equilibrium(&[]).expect_err("a fall");
    assert_says(&error, &["no equilibrium", "-1.962e1", "`ball.y`"]);
    let error = at_rest(&system).equilibrium(&[ball.coordinates[1]]).expect_err("a slide");
    assert_says(&error, &["not isolated", "`ball.x`"]);
    let held = at_rest(&system).equilibrium(&ball.coordinates).expect("an equilibrium");
    assert!((held.holding[1] - 19.62).abs() < 1e-13 && held.eigenvalues.is_empty());
}
