//! One small scene for each kind of element: an upper arm hinged to the ground with a motor in the shoulder, and in the elbow, or
//! between the arms, the element in question.

use hamiltonian_adjoint::planar::{Body, Harmonic, Point};
use hamiltonian_adjoint::scenes::AngleError;
use hamiltonian_adjoint::{Constraint, Force, ForcePoint, KineticEnergy, Multiplier, PotentialEnergy, Scalar, Scene, Sum};
use nalgebra::{SVector, Vector1, Vector2};
use std::f64::consts::FRAC_PI_2;

pub const UPPER_ANGLE: f64 = -1.2;
/// φ_lower − φ_upper.
pub const ELBOW_ANGLE: f64 = 0.5;

/// A kind of element: its name, whether the elbow is a hinge besides, and what adds it.
pub type Kind = (&'static str, bool, fn(&mut Arms));

/// The kinds of elements between two arms.
pub fn kinds() -> Vec<Kind> {
    vec![
        ("revolute joint", true, |_| {}),
        ("prismatic joint between moving bodies", false, prismatic),
        ("weld", false, weld),
        ("distance", false, distance),
        ("driven angle", true, driven_angle),
        ("spring and damper", true, spring_and_damper),
        ("torsional spring and damper", true, torsional_spring),
        ("friction in a joint", true, joint_friction),
        ("friction of sliding on a moving body", true, sliding_friction),
        ("actuator on a moving body", true, actuator),
        ("torque actuator", true, torque_actuator),
        ("constraint of one's own", true, pin_on_curve),
        ("force of one's own", true, air_drag),
        ("potential energy of one's own", true, magnet),
    ]
}

/// A scene for each kind of element.
pub fn all() -> Vec<(&'static str, Scene)> {
    let between = kinds().into_iter().map(|kind| (kind.0, with(kind, |_| {})));
    let minimal =
        [("kinetic energy with constant M", minimal(ConstantMass)), ("kinetic energy with M(q)", minimal(CoupledArms))];
    between.chain(minimal).collect()
}

/// The scene of a kind, and something more.
pub fn with((_, is_hinged, add): Kind, more: impl FnOnce(&mut Arms)) -> Scene {
    let both = |arms: &mut Arms| {
        add(arms);
        more(arms);
    };
    if is_hinged { hinged(both) } else { jointed(both) }
}

/// Both arms and the scene around them.
pub struct Arms {
    pub scene: Scene,
    pub upper: Body,
    pub lower: Body,
    /// x, y and φ of the lower arm at the start.
    pub lower_place: [f64; 3],
    /// Those of the shoulder.
    #[allow(dead_code)]
    pub shoulder: [Multiplier; 2],
}

impl Arms {
    fn new() -> Self {
        let mut scene = Scene::new();
        scene.gravity(0.0, -9.81);
        let place = |[x, y]: [f64; 2], angle: f64| [x + 0.5 * angle.cos(), y + 0.5 * angle.sin(), angle];
        let upper = scene.body("upper arm", 1.2, 0.1, place([0.0; 2], UPPER_ANGLE));
        let elbow = [UPPER_ANGLE.cos(), UPPER_ANGLE.sin()];
        let lower_place = place(elbow, UPPER_ANGLE + ELBOW_ANGLE);
        let lower = scene.body("lower arm", 0.8, 0.07, lower_place);
        let shoulder = scene.revolute("shoulder", Body::GROUND.at(0.0, 0.0), upper.at(-0.5, 0.0));
        let torque = scene.control("shoulder torque");
        scene.torque_actuator("motor", Body::GROUND, upper, torque);
        scene.cost("aim", AngleError, Sum::Terminal, [lower.coordinates[2]], [], [], [FRAC_PI_2.into()]);
        Arms { scene, upper, lower, lower_place, shoulder }
    }

    /// The point of the upper and of the lower arm that meet in the elbow.
    pub fn elbow(&self) -> (Point, Point) {
        (self.upper.at(0.5, 0.0), self.lower.at(-0.5, 0.0))
    }
}

/// Arms joined by anything.
pub fn jointed(joint: impl FnOnce(&mut Arms)) -> Scene {
    let mut arms = Arms::new();
    joint(&mut arms);
    arms.scene
}

/// Arms with a hinge as elbow, and something more.
pub fn hinged(more: impl FnOnce(&mut Arms)) -> Scene {
    jointed(|arms| {
        let (a, b) = arms.elbow();
        arms.scene.revolute("elbow", a, b);
        more(arms);
    })
}

fn prismatic(arms: &mut Arms) {
    let (a, b) = arms.elbow();
    arms.scene.prismatic("elbow", a, 0.3, b, ELBOW_ANGLE);
}

fn weld(arms: &mut Arms) {
    let (a, b) = arms.elbow();
    arms.scene.weld("elbow", a, b, ELBOW_ANGLE);
}

fn distance(arms: &mut Arms) {
    arms.scene.distance("elbow", arms.upper.at(0.5, 0.0), arms.lower.at(0.5, 0.0), 1.0);
}

fn driven_angle(arms: &mut Arms) {
    let amplitude = 0.2;
    let parameters = [(ELBOW_ANGLE - amplitude).into(), amplitude.into(), 7.0.into(), FRAC_PI_2.into()];
    arms.scene.driven_angle("drive", arms.upper, arms.lower, Harmonic, parameters);
}

fn spring_and_damper(arms: &mut Arms) {
    arms.scene.spring_damper("spring", Body::GROUND.at(1.0, 0.0), arms.lower.at(0.5, 0.0), 20.0, 0.5, 1.5);
}

fn torsional_spring(arms: &mut Arms) {
    arms.scene.torsional_spring_damper("spring", arms.upper, arms.lower, 4.0, 0.1, 0.2);
}

fn joint_friction(arms: &mut Arms) {
    arms.scene.joint_friction("friction", arms.upper, arms.lower, 0.2);
}

fn sliding_friction(arms: &mut Arms) {
    arms.scene.sliding_friction("friction", arms.upper.at(0.0, 0.0), 0.3, arms.lower.at(0.5, 0.0), 0.4);
}

fn actuator(arms: &mut Arms) {
    let force = arms.scene.control("force");
    arms.scene.actuator("cylinder", arms.upper.at(0.0, 0.0), 0.3, arms.lower.at(0.5, 0.0), force);
}

fn torque_actuator(arms: &mut Arms) {
    let torque = arms.scene.control("elbow torque");
    arms.scene.torque_actuator("elbow motor", arms.upper, arms.lower, torque);
}

fn pin_on_curve(arms: &mut Arms) {
    let ([x, y, _], [x0, y0, _]) = (arms.lower.coordinates, arms.lower_place);
    let curvature = 0.4;
    let height = y0 - curvature * x0 * x0;
    arms.scene.constraint("curve", Parabola, [x, y], [curvature.into(), height.into()]);
}

fn air_drag(arms: &mut Arms) {
    let [x, y, _] = arms.lower.coordinates;
    arms.scene.force("drag", AirDrag, [x, y], [], [0.3.into()]);
}

fn magnet(arms: &mut Arms) {
    let [x, y, _] = arms.lower.coordinates;
    arms.scene.potential_energy("magnet", Magnet, [x, y], [2.0.into(), 1.5.into()]);
}

/// Both arms in their angles alone.
pub fn minimal(inertia: impl KineticEnergy<2>) -> Scene {
    let mut scene = Scene::new();
    let q = scene.coordinates("arms", ["upper", "lower"]);
    scene.place(q[0], UPPER_ANGLE);
    scene.place(q[1], UPPER_ANGLE + ELBOW_ANGLE);
    scene.kinetic_energy("motion", inertia, q, []);
    scene.potential_energy("weight", ArmsWeight, q, []);
    let torque = scene.control("shoulder torque");
    scene.force("motor", Shoulder, [q[0]], [torque], []);
    scene.cost("aim", AngleError, Sum::Terminal, [q[1]], [], [], [FRAC_PI_2.into()]);
    scene
}

/// Φ = y − a x² − b, the parameters [a, b].
pub struct Parabola;

impl Constraint<2, 1, 2> for Parabola {
    fn phi<S: Scalar>(&self, q: &Vector2<S>, b: &Vector2<S>, _t: S) -> Vector1<S> {
        Vector1::new(q[1] - b[0] * q[0] * q[0] - b[1])
    }
}

/// Q = −c |v| v, `b = [c]`.
pub struct AirDrag;

impl Force<2, 0, 1> for AirDrag {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, b: &Vector1<S>) -> Vector2<S> {
        // The small constant keeps the root differentiable at rest.
        let speed = (at.v.dot(&at.v) + 1e-6).sqrt();
        at.v * -(b[0] * speed)
    }
}

/// V = −c / (|r|² + l²), b = [c, l].
pub struct Magnet;

impl PotentialEnergy<2, 2> for Magnet {
    fn potential_energy<S: Scalar>(&self, q: &Vector2<S>, b: &Vector2<S>, _t: S) -> S {
        -(b[0] / (q.dot(q) + b[1] * b[1]))
    }
}

/// T of two arms without coupling.
pub struct ConstantMass;

impl KineticEnergy<2> for ConstantMass {
    fn kinetic_energy<S: Scalar>(&self, _q: &Vector2<S>, v: &Vector2<S>, _b: &SVector<S, 0>) -> S {
        (v[0] * v[0] * 1.3 + v[1] * v[1] * 0.3) * 0.5
    }
}

/// T of two arms that hang on each other.
pub struct CoupledArms;

impl KineticEnergy<2> for CoupledArms {
    fn kinetic_energy<S: Scalar>(&self, q: &Vector2<S>, v: &Vector2<S>, _b: &SVector<S, 0>) -> S {
        let coupling = v[0] * v[1] * (q[0] - q[1]).cos() * 0.8;
        (v[0] * v[0] * 1.3 + v[1] * v[1] * 0.3 + coupling) * 0.5
    }
}

/// V of the two arms; angles count from the horizontal.
pub struct ArmsWeight;

impl PotentialEnergy<2> for ArmsWeight {
    fn potential_energy<S: Scalar>(&self, q: &Vector2<S>, _b: &SVector<S, 0>, _t: S) -> S {
        (q[0].sin() * 1.4 + q[1].sin() * 0.4) * 9.81
    }
}

/// A torque u on the upper arm.
pub struct Shoulder;

impl Force<1, 1> for Shoulder {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> Vector1<S> {
        at.u
    }
}
