//! Controls for given accelerations.

use crate::cases::{all, driven};
use crate::common::{assert_order, assert_says};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Coordinate, Error, Force, ForcePoint, Grid, Held, Inputs, Mechanics, Scalar, Scene, Scheme, Settings, Solver, Start,
    System,
};
use nalgebra::{DVector, SVector};

#[test]
fn controls_are_recovered_from_the_accelerations_that_they_cause() {
    for (name, system, at) in all().into_iter().filter(|(name, _, _)| *name != "cart") {
        let (v_dot, _) = at.accelerations().expect(name);
        let linear = at.linear_model(&[]).expect(name);
        // The coordinate on which the control has the most influence.
        let d = linear.coordinates.len();
        let k =
            (0..d).max_by(|&i, &j| linear.b[(d + i, 0)].abs().total_cmp(&linear.b[(d + j, 0)].abs())).expect("a coordinate");
        let coordinate = linear.coordinates[k];
        let blank = at.with_controls(&[0.0]).expect(name);
        let found = blank.inverse_dynamics(&[(coordinate, v_dot[coordinate.index()])], &[system.control(0)]).expect(name);
        assert!((found.controls()[0] - 0.7).abs() < 1e-10, "{name}: {}", found.controls()[0]);
    }
}

/// An arm of two links with a motor in each joint.
fn arm() -> (System, [Coordinate; 2]) {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let links = [0, 1].map(|k| scene.body(&format!("link {k}"), 1.0, 0.05, [0.3 + 0.6 * k as f64, 0.0, 0.0]));
    scene.revolute("shoulder", Body::GROUND.at(0.0, 0.0), links[0].at(-0.3, 0.0));
    scene.revolute("elbow", links[0].at(0.3, 0.0), links[1].at(-0.3, 0.0));
    let torques = [scene.control("shoulder torque"), scene.control("elbow torque")];
    scene.torque_actuator("shoulder motor", Body::GROUND, links[0], torques[0]);
    scene.torque_actuator("elbow motor", links[0], links[1], torques[1]);
    (scene.compile().expect("a scene"), links.map(|link| link.coordinates[2]))
}

/// Values, rates and accelerations of the prescribed angles.
fn prescribed(t: f64) -> [[f64; 2]; 3] {
    let (sin, cos) = (2.0 * t).sin_cos();
    [[0.8 * sin, -0.5 + 0.5 * cos], [1.6 * cos, -sin], [-3.2 * sin, -2.0 * cos]]
}

#[test]
fn an_arm_under_the_controls_of_a_prescribed_motion_follows_it_with_the_order_of_the_scheme() {
    let (system, angles) = arm();
    let errors: Vec<f64> = [25, 50, 100]
        .map(|steps| {
            let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 1.0 / steps as f64));
            let mut start = inputs.start.clone();
            for (node, t) in inputs.grid.times().into_iter().enumerate() {
                let [value, rate, acceleration] = prescribed(t);
                let [mut q, mut v] = [start.q().clone(), DVector::zeros(system.n())];
                for (k, angle) in angles.iter().enumerate() {
                    (q[angle.index()], v[angle.index()]) = (value[k], rate[k]);
                }
                let held = Held { coordinates: angles.to_vec(), velocities: angles.to_vec() };
                let there = Inputs { start: Start::Assembled { q, v, held }, ..inputs.clone() };
                let at = Mechanics::at_start(&system, &there).expect("a state");
                let given: Vec<(Coordinate, f64)> = angles.into_iter().zip(acceleration).collect();
                let at = at.inverse_dynamics(&given, &[system.control(0), system.control(1)]).expect("controls");
                let (v_dot, _) = at.accelerations().expect("accelerations");
                assert!(given.iter().all(|(angle, a)| (v_dot[angle.index()] - a).abs() < 1e-12));
                inputs.controls.column_mut(node).copy_from_slice(at.controls());
                start = Start::Velocity { q: DVector::from_column_slice(at.q()), v: DVector::from_column_slice(at.v()) };
                if node == 0 {
                    inputs.start = start.clone();
                }
            }
            let mut solver = Solver::new(&system, Settings { scheme: Scheme::TRAPEZOIDAL, ..Settings::default() });
            let motion = solver.simulate(&inputs).expect("a motion");
            let [expected, ..] = prescribed(1.0);
            let last = motion.last();
            angles
                .iter()
                .zip(expected)
                .map(|(angle, value)| (motion.q[(angle.index(), last)] - value).abs())
                .fold(0.0, f64::max)
        })
        .to_vec();
    assert_order("the angles at the end", &errors, 2.0, 0.1);
}

/// u + u³.
struct Cubic;
impl Force<1, 1, 0> for Cubic {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([at.u[0] + at.u[0] * at.u[0] * at.u[0]])
    }
}

#[test]
fn forces_need_not_be_linear_in_the_controls_and_may_vanish() {
    let mut scene = Scene::new();
    let ball = scene.particle("ball", 2.0, [0.0, 0.0]);
    let (u, idle) = (scene.control("u"), scene.control("idle"));
    scene.force("drive", Cubic, [ball.coordinates[0]], [u], []);
    let system = scene.compile().expect("a scene");
    let [x, y] = ball.coordinates;
    let at = Mechanics::new(&system, &[0.0; 2], &[0.0; 2]).expect("a state").with_controls(&[1.0, 5.0]).expect("controls");
    let found = at.clone().inverse_dynamics(&[(x, 5.0)], &[u]).expect("a control");
    assert!((found.controls()[0] - 2.0).abs() < 1e-13 && found.controls()[1] == 5.0);
    let found = found.inverse_dynamics(&[(x, 0.0)], &[u]).expect("a control");
    assert!(found.controls()[0].abs() < 1e-13);
    assert_eq!(at.clone().inverse_dynamics(&[], &[]).expect("nothing to do").controls(), [1.0, 5.0]);
    let error = at.clone().inverse_dynamics(&[(y, 1.0)], &[u]).expect_err("no influence");
    assert_says(&error, &["`u`", "`ball.y`", "no influence"]);
    let error = at.clone().inverse_dynamics(&[(x, 1.0), (y, 1.0)], &[u, idle]).expect_err("no influence");
    assert_says(&error, &["`u`, `idle`", "`ball.x`, `ball.y`", "no influence"]);
    assert!(matches!(at.clone().inverse_dynamics(&[(x, 1.0)], &[]), Err(Error::Size { expected: 1, found: 0, .. })));
    let error = at.clone().inverse_dynamics(&[(x, f64::NAN)], &[u]).expect_err("NaN");
    assert_says(&error, &["the acceleration of `ball.x`", "NaN"]);
    let (other, angles) = arm();
    assert!(matches!(at.clone().inverse_dynamics(&[(angles[0], 1.0)], &[u]), Err(Error::Foreign { .. })));
    assert!(matches!(at.inverse_dynamics(&[(x, 1.0)], &[other.control(0)]), Err(Error::Foreign { .. })));
}

#[test]
fn a_motor_behind_a_spring_and_a_driven_coordinate_are_refused() {
    let mut scene = Scene::new();
    let masses = [0, 1].map(|k| scene.particle(&format!("mass {k}"), 1.0, [k as f64, 0.0]));
    let force = scene.control("force");
    scene.spring_damper("spring", masses[0].point(), masses[1].point(), 100.0, 1.0, 0.0);
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, masses[0].point(), force);
    let system = scene.compile().expect("a scene");
    let at = Mechanics::new(&system, &[0.0, 0.0, 1.0, 0.0], &[0.0; 4]).expect("a state");
    let error = at.inverse_dynamics(&[(masses[1].coordinates[0], 1.0)], &[force]).expect_err("a spring");
    assert_says(&error, &["`force`", "`mass 1.x`", "order 4", "index 5", "readings"]);
    let system = driven();
    let at = crate::cases::state(&system, &[0.0], &[]);
    let crank = system.coordinate(2);
    let error = at.inverse_dynamics(&[(crank, 1.0)], &[system.control(0)]).expect_err("a drive");
    assert_says(&error, &["`crank.φ`", "no influence"]);
}

#[test]
fn a_motor_behind_a_spring_is_named_beside_one_that_acts() {
    // The second motor acts on both masses at once, the first one on the rotor alone.
    let mut scene = Scene::new();
    let masses = [0, 1, 2].map(|k| scene.particle(&format!("mass {k}"), 1.0, [k as f64, 0.0]));
    let forces = ["far", "near"].map(|name| scene.control(name));
    scene.spring_damper("spring", masses[0].point(), masses[1].point(), 100.0, 1.0, 0.0);
    scene.spring_damper("other", masses[1].point(), masses[2].point(), 100.0, 1.0, 0.0);
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, masses[0].point(), forces[0]);
    scene.actuator("second motor", masses[1].point(), 0.0, masses[2].point(), forces[1]);
    let system = scene.compile().expect("a scene");
    let at = Mechanics::new(&system, &[0.0, 0.0, 1.0, 0.0, 2.0, 0.0], &[0.0; 6]).expect("a state");
    let asked = [1, 2].map(|k| (masses[k].coordinates[0], 1.0));
    let error = at.inverse_dynamics(&asked, &forces).expect_err("a spring");
    assert_says(&error, &["the control `far` does not", "`mass 1.x`, `mass 2.x`", "order 4"]);
}
