//! Mechanisms of every kind, each at a state on its constraints, and differences as the reference for derivatives.

use hamiltonian_adjoint::planar::{Body, Motion};
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::spatial::{self, Inertia};
use hamiltonian_adjoint::{
    Constraint, Coordinate, Force, ForcePoint, Grid, Inputs, KineticEnergy, Mechanics, Multiplier, Param, Scalar, Scene,
    Start, System,
};
use nalgebra::{DMatrix, DVector, SVector, UnitQuaternion};

/// b₀ + b₁ sin t.
pub struct Swaying;
impl Motion<2> for Swaying {
    fn value<S: Scalar>(&self, t: S, b: &SVector<S, 2>) -> S {
        b[0] + b[1] * t.sin()
    }
}

/// A spring along one coordinate that is stiffer in compression, and a force u: a formula without a graph.
pub struct TwoSided;
impl Force<1, 1, 1> for TwoSided {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, b: &SVector<S, 1>) -> SVector<S, 1> {
        let q = at.q[0] - 0.1;
        let stiffness = if q.re() > 0.0 { b[0] } else { b[0] * 3.0 };
        SVector::from([at.u[0] - q * stiffness - at.v[0] * at.v[0] * at.v[0] * 0.2])
    }
}

/// ½ b v².
pub struct Mass;
impl KineticEnergy<1, 1> for Mass {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, b: &SVector<S, 1>) -> S {
        v[0] * v[0] * b[0] * 0.5
    }
}

/// A massless height x = r sin φ.
pub struct Height;
impl Constraint<2, 1, 1> for Height {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 1>, _t: S) -> SVector<S, 1> {
        SVector::from([q[0] - b[0] * q[1].sin()])
    }
}

/// A state on the constraints near the positions of the scene and these velocities, with all controls 0.7, at t = 0.4 s.
pub fn state(system: &System, v: &[f64], open: &[Multiplier]) -> Mechanics {
    let mut inputs = Inputs::at_rest(system, Grid::new(0.4, vec![1.0]));
    let v = DVector::from_fn(system.n(), |i, _| v[i % v.len()]);
    inputs.start = Start::Assembled { q: system.initial_coordinates(), v, held: Default::default() };
    inputs.controls.fill(0.7);
    inputs.open = open.to_vec();
    Mechanics::at_start(system, &inputs).expect("a state")
}

/// The inputs of a motion from a state, with other controls and design variables.
pub fn inputs(system: &System, at: &Mechanics, u: &[f64], design: &DVector<f64>) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::new(at.t(), vec![1.0]));
    inputs.controls.column_iter_mut().for_each(|mut column| column.copy_from_slice(u));
    inputs.design.copy_from(design);
    inputs.open = at.open();
    inputs
}

/// The derivative of a function at 0 by differences of fourth order.
pub fn differences(f: impl Fn(f64) -> DVector<f64>) -> DVector<f64> {
    let h = 5e-4;
    ((f(h) - f(-h)) * 8.0 - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
}

/// The largest difference of two matrices, relative to the largest entry.
pub fn apart(ours: &DMatrix<f64>, reference: &DMatrix<f64>) -> f64 {
    assert_eq!(ours.shape(), reference.shape());
    if ours.is_empty() { 0.0 } else { (ours - reference).amax() / reference.amax().max(1.0) }
}

/// Cranks of a parallelogram, the third one with this mass; with three of them, constraints depend on each other. A spring holds it.
pub fn parallelogram(cranks: usize, third: f64) -> (System, [Body; 2]) {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let (length, stiffness) = (scene.design("length", 1.0), scene.design("stiffness", 40.0));
    let (x, y) = (1.0f64.cos(), 1.0f64.sin());
    let coupler = scene.body("coupler", 1.0, 0.1, [x + 1.0, y, 0.0]);
    let mut first = coupler;
    for (k, along) in [0.0, 2.0, 1.0].into_iter().enumerate().take(cranks) {
        let mass = if k == 2 { third } else { 1.0 };
        let crank = scene.body(&format!("crank {k}"), mass, 0.1 * mass, [along + 0.5 * x, 0.5 * y, 1.0]);
        scene.revolute(&format!("foot {k}"), Body::GROUND.at(along, 0.0), crank.at(-0.5 * length, 0.0));
        scene.revolute(&format!("head {k}"), crank.at(0.5 * length, 0.0), coupler.at(along - 1.0, 0.0));
        first = if k == 0 { crank } else { first };
    }
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, first, torque);
    scene.torsional_spring_damper("spring", Body::GROUND, first, stiffness, 1.2, 0.3);
    (scene.compile().expect("a scene"), [first, coupler])
}

/// A four-bar linkage with an oblique spring.
pub fn four_bar() -> (System, Body) {
    let mut scene = Scene::new();
    scene.gravity(1.0, -9.81);
    let (rocker_length, stiffness) = (scene.design("rocker", 0.8), scene.design("stiffness", 60.0));
    let crank = scene.body("crank", 1.0, 0.02, [0.1, 0.2, 1.2]);
    let coupler = scene.body("coupler", 2.0, 0.1, [0.6, 0.6, 0.3]);
    let rocker = scene.body("rocker", 1.5, 0.08, [1.1, 0.4, 1.4]);
    scene.revolute("A", Body::GROUND.at(0.0, 0.0), crank.at(-0.2, 0.0));
    scene.revolute("B", crank.at(0.2, 0.0), coupler.at(-0.5, 0.0));
    scene.revolute("C", coupler.at(0.5, 0.0), rocker.at(0.5 * rocker_length, 0.0));
    scene.revolute("D", Body::GROUND.at(1.0, 0.0), rocker.at(-0.5 * rocker_length, 0.0));
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, crank, torque);
    scene.spring_damper("spring", Body::GROUND.at(0.2, 1.2), coupler.at(0.1, 0.1), stiffness, 0.5, 2.0);
    (scene.compile().expect("a scene"), crank)
}

/// An arm in space: a ball joint, a hinge, springs, and a tip on an oblique plane.
pub fn arm_in_space() -> System {
    let mut scene = Scene::new();
    let (mass, stiffness) = (scene.design("mass", 1.2), scene.design("stiffness", 80.0));
    let u = scene.control("ram");
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let upper = space.body("upper", Inertia::cuboid(mass, [0.6, 0.1, 0.2]));
    let lower = space.body("lower", Inertia::cuboid(0.8, [0.1, 0.5, 0.1]));
    let ground = spatial::Body::GROUND;
    let numbers: [Param; 3] = [stiffness.into(), 0.3.into(), 1.0.into()];
    let ball = space.ball("ball", ground.origin(), upper.at([-0.3, 0.0, 0.0]));
    let hinge = space.revolute("hinge", upper.at([0.3, 0.0, 0.0]).along([0.0, 1.0, 1.0]), lower.at([0.0, -0.25, 0.0]));
    space.spring_damper("spring", ground.at([0.4, 0.1, 0.9]), upper.at([0.2, 0.0, 0.1]), numbers);
    space.spring_damper("guy", ground.at([0.3, 1.0, 0.2]), lower.origin(), [30.0, 0.4, 0.5]);
    space.two_point_actuator("ram", ground.at([0.0, -1.0, 0.0]), lower.at([0.0, 0.25, 0.0]), u);
    space.point_on_plane("plane", ground.at([0.0, 0.0, -0.1]).along([0.2, 0.1, 1.0]), lower.at([0.0, 0.25, 0.0]));
    scene.place_rotation(ball.orientation, UnitQuaternion::from_euler_angles(0.1, 0.3, 0.2));
    scene.place(hinge.angle, 0.4);
    scene.compile().expect("a scene")
}

/// A crank whose angle is driven, a pendulum on it, and a bob on the pendulum by a rod.
pub fn driven() -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let (offset, sway) = (scene.design("offset", 0.5), scene.design("sway", 0.3));
    let crank = scene.body("crank", 1.0, 0.02, [0.2, 0.1, 0.6]);
    let pendulum = scene.body("pendulum", 1.5, 0.1, [0.4, -0.3, -1.2]);
    let bob = scene.particle("bob", 0.5, [0.7, -1.0]);
    scene.revolute("A", Body::GROUND.at(0.0, 0.0), crank.at(-0.25, 0.0));
    scene.revolute("B", crank.at(0.25, 0.0), pendulum.at(-0.5, 0.0));
    scene.distance("rod", pendulum.at(0.5, 0.0), bob.point(), 0.4);
    scene.driven_angle("drive", Body::GROUND, crank, Swaying, [offset.into(), sway.into()]);
    let torque = scene.control("torque");
    scene.torque_actuator("motor", crank, pendulum, torque);
    scene.compile().expect("a scene")
}

/// A mass on a branching spring, geared by a massless height to a crank.
pub fn branching() -> System {
    let mut scene = Scene::new();
    let (stiffness, radius, inertia) = (scene.design("stiffness", 20.0), scene.design("r", 0.6), scene.design("J", 0.2));
    let u = scene.control("u");
    let [height] = scene.coordinates("height", ["x"]);
    let [angle] = scene.coordinates("crank", ["φ"]);
    scene.place(angle, 0.3);
    scene.place(height, 0.6 * 0.3f64.sin());
    scene.kinetic_energy("inertia", Mass, [angle], [inertia.into()]);
    scene.constraint("height", Height, [height, angle], [radius.into()]);
    scene.force("spring", TwoSided, [height], [u], [stiffness.into()]);
    scene.compile().expect("a scene")
}

/// A double pendulum whose lower hinge is open, so that its lower link hangs by a spring.
pub fn opened() -> (System, Vec<Multiplier>) {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let stiffness = scene.design("stiffness", 50.0);
    let links = [0, 1].map(|k| scene.body(&format!("link {k}"), 1.0, 0.1, [0.5 + k as f64, -0.1, 0.1]));
    scene.revolute("upper", Body::GROUND.at(0.0, 0.0), links[0].at(-0.5, 0.0));
    let lower = scene.revolute("lower", links[0].at(0.5, 0.0), links[1].at(-0.5, 0.0));
    scene.spring_damper("spring", links[0].at(0.5, 0.1), links[1].at(-0.4, 0.0), stiffness, 0.2, 1.0);
    scene.torsional_spring_damper("twist", links[0], links[1], 10.0, 0.3, 0.5);
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, links[0], torque);
    let release = scene.event("release", AngleError, [links[0].coordinates[2]], [], [], [0.0.into()]);
    scene.open_at(release, &lower);
    (scene.compile().expect("a scene"), lower.to_vec())
}

/// All mechanisms, each in motion.
pub fn all() -> Vec<(&'static str, System, Mechanics)> {
    let cart =
        CartPendulum { friction_joint: 1, start_angle: -0.7, ..CartPendulum::default() }.scene().compile().expect("a scene");
    let ((open, lower), mut found) = (opened(), Vec::new());
    let scenes = [
        ("cart", cart),
        ("four-bar", four_bar().0),
        ("parallelogram", parallelogram(2, 1.0).0),
        ("three cranks", parallelogram(3, 1.0).0),
        ("arm in space", arm_in_space()),
        ("driven", driven()),
        ("branching", branching()),
        ("opened", open),
    ];
    for (name, system) in scenes {
        let open = if name == "opened" { &lower[..] } else { &[] };
        let at = state(&system, &[0.3, -0.5, 0.8, 0.2, 1.1], open);
        found.push((name, system, at));
    }
    found
}

/// The coordinates of a body.
pub fn angle(body: Body) -> Coordinate {
    body.coordinates[2]
}
