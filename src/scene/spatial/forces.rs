//! Forces and torques at markers.

use super::elements::Arguments;
use super::formula::{dot, minus, scaled, zero};
use super::functions::{MarkerPoint, Markers};
use super::path::Load;
use super::{Components, Marker, Spatial};
use crate::model::space::ConnectionKind;
use crate::model::{Control, Drives, Param, Unit};
use crate::scene::ready::{Kind, Part};
use crate::{ListForce, ListForcePoint, ListPotentialEnergy, Scalar};

/// Forces and torques on markers, as functions of their positions and velocities. Their accelerations are zero in the arguments.
///
/// ```
/// use hamiltonian_adjoint::spatial::{Body, Inertia, Load, MarkerForce, MarkerPoint};
/// use hamiltonian_adjoint::{Scalar, Scene};
///
/// /// Drag −c |v| v at the first marker; b = [c].
/// struct Drag;
/// impl MarkerForce for Drag {
///     fn loads<S: Scalar>(&self, at: &MarkerPoint<S>, loads: &mut [Load<S>]) {
///         let v = at.markers[0].velocity;
///         let speed = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + 1e-6).sqrt();
///         loads[0].force = v.map(|v| -(at.b[0] * speed * v));
///     }
/// }
///
/// let mut scene = Scene::new();
/// let mut space = scene.spatial();
/// let ball = space.body("ball", Inertia::sphere(1.0, 0.1));
/// space.free("flight", Body::GROUND.origin(), ball.origin());
/// space.force("drag", Drag, &[ball.origin()], &[], &[0.02.into()]);
/// scene.compile()?;
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub trait MarkerForce: Send + Sync + 'static {
    /// Writes the loads on the markers, which are zero at first.
    fn loads<S: Scalar>(&self, at: &MarkerPoint<S>, loads: &mut [Load<S>]);
}

/// Forces on markers as generalized forces.
struct OnMarkers<F> {
    force: F,
    markers: Markers,
}

impl<F: MarkerForce> ListForce for OnMarkers<F> {
    fn force<S: Scalar>(&self, at: &ListForcePoint<S>, b: &[S], force: &mut [S]) {
        let still = vec![S::from(0.0); at.q.len()];
        let paths = &self.markers.paths;
        let states: Vec<_> = paths.iter().map(|path| path.state([at.q, at.v, &still, b])).collect();
        let mut loads = vec![Load { force: zero(), torque: zero() }; paths.len()];
        let own = &b[b.len() - self.markers.own..];
        self.force.loads(&MarkerPoint { markers: &states, u: at.u, t: at.t, b: own }, &mut loads);
        paths.iter().zip(&loads).for_each(|(path, load)| path.pull_back(load, [at.q, b], force));
    }
}

/// The force u along the z axis of the first marker on it.
struct Thrust;

impl MarkerForce for Thrust {
    fn loads<S: Scalar>(&self, at: &MarkerPoint<S>, loads: &mut [Load<S>]) {
        loads[0].force = scaled(at.markers[0].axes[2], at.u[0]);
    }
}

/// The torque u about the z axis of the first marker on its body, and the opposite one on the body of the second, if there is one.
struct Twist;

impl MarkerForce for Twist {
    fn loads<S: Scalar>(&self, at: &MarkerPoint<S>, loads: &mut [Load<S>]) {
        let torque = scaled(at.markers[0].axes[2], at.u[0]);
        for (load, sign) in loads.iter_mut().zip([1.0, -1.0]) {
            load.torque = scaled(torque, S::from(sign));
        }
    }
}

/// A force and a torque with constant components b; those in the inertial frame if `is_in_space`, otherwise along the axes of the marker.
struct Applied {
    is_in_space: bool,
}

impl MarkerForce for Applied {
    fn loads<S: Scalar>(&self, at: &MarkerPoint<S>, loads: &mut [Load<S>]) {
        let turned = |x: [S; 3]| match self.is_in_space {
            true => x,
            false => std::array::from_fn(|i| {
                let axes = &at.markers[0].axes;
                axes[0][i] * x[0] + axes[1][i] * x[1] + axes[2][i] * x[2]
            }),
        };
        let b = |k: usize| [at.b[k], at.b[k + 1], at.b[k + 2]];
        loads[0] = Load { force: turned(b(0)), torque: turned(b(3)) };
    }
}

/// The force −d dl/dt along the line between two markers; b = [d].
struct Damper;

impl MarkerForce for Damper {
    fn loads<S: Scalar>(&self, at: &MarkerPoint<S>, loads: &mut [Load<S>]) {
        let [first, second] = [&at.markers[0], &at.markers[1]];
        let between = minus(second.position, first.position);
        let direction = scaled(between, dot(between, between).sqrt().recip());
        let speed = dot(direction, minus(second.velocity, first.velocity));
        let pull = scaled(direction, at.b[0] * speed);
        (loads[0].force, loads[1].force) = (pull, pull.map(|x| -x));
    }
}

/// The force u along the line between two markers, which drives them apart.
struct Push;

impl MarkerForce for Push {
    fn loads<S: Scalar>(&self, at: &MarkerPoint<S>, loads: &mut [Load<S>]) {
        let between = minus(at.markers[1].position, at.markers[0].position);
        let push = scaled(between, at.u[0] / dot(between, between).sqrt());
        (loads[0].force, loads[1].force) = (push.map(|x| -x), push);
    }
}

/// V = ½ c (|d| − l)²; b = [c, l] behind the parameters of the paths. With `is_slack` l is 0, and V is smooth at d = 0.
struct Spring {
    markers: Markers,
    is_slack: bool,
}

impl ListPotentialEnergy for Spring {
    fn potential_energy<S: Scalar>(&self, q: &[S], b: &[S], _t: S) -> S {
        let [first, second] = [0, 1].map(|k| self.markers.paths[k].place(q, b).0);
        let (between, own) = (minus(second, first), &b[b.len() - self.markers.own..]);
        let square = dot(between, between);
        if self.is_slack {
            return own[0] * square * 0.5;
        }
        let stretch = square.sqrt() - own[1];
        own[0] * stretch * stretch * 0.5
    }
}

pub(super) static THRUST: Kind = Kind::of_markers("thrust", &[], |scene, name, part| {
    let (by, mut space) = (part.by(), scene.spatial());
    space.drives(by, Unit::Length);
    space.force(name, Thrust, &part.markers, &by, &[]);
})
.at(&["marker"])
.driven_by("force");

pub(super) static TORQUE: Kind = Kind::of_markers("torque in space", &[], |scene, name, part| {
    let (by, [a, b], mut space) = (part.by(), part.pair(), scene.spatial());
    space.drives(by, Unit::Angle);
    space.opposite(name, Twist, [b, a], &by, &[]);
})
.driven_by("torque");

const OF_LOAD: &[&str] = &["force", "force", "force", "torque", "torque", "torque"];

pub(super) static APPLIED_IN_SPACE: Kind = Kind::of_markers("applied in space", OF_LOAD, |scene, name, part| {
    scene.spatial().force(name, Applied { is_in_space: true }, &part.markers, &[], &part.numbers);
})
.at(&["marker"]);

pub(super) static APPLIED_ON_BODY: Kind = Kind::of_markers("applied on body", OF_LOAD, |scene, name, part| {
    scene.spatial().force(name, Applied { is_in_space: false }, &part.markers, &[], &part.numbers);
})
.at(&["marker"]);

pub(super) static TWO_POINT_ACTUATOR: Kind = Kind::of_markers("two-point actuator in space", &[], |scene, name, part| {
    let (by, mut space) = (part.by(), scene.spatial());
    space.drives(by, Unit::Length);
    space.connect(name, part.pair(), ConnectionKind::Line(1.5));
    space.opposite(name, Push, part.pair(), &by, &[]);
})
.driven_by("force");

const OF_SPRING: &[&str] = &["stiffness", "free_length", "damping"];

pub(super) static SPRING_DAMPER: Kind = Kind::of_markers("spring and damper in space", OF_SPRING, |scene, name, part| {
    let (both, [stiffness, free_length, damping]) = (part.pair(), part.numbers_from(0));
    let mut space = scene.spatial();
    space.connect(name, both, ConnectionKind::Line(0.6));
    if stiffness.constant() != Some(0.0) {
        let Some((markers, Arguments { q, b })) = space.pair(name, both, &[stiffness, free_length]) else { return };
        let spring = Spring { markers, is_slack: free_length.constant() == Some(0.0) };
        space.scene.list_potential_energy(&format!("{name} (spring)"), spring, &q, &b.0);
    }
    if damping.constant() != Some(0.0) {
        space.opposite(&format!("{name} (damper)"), Damper, both, &[], &[damping]);
    }
});

impl Spatial<'_> {
    /// Adds forces and torques on markers, which depend on their positions and velocities, controls, constants b and the time.
    pub fn force(&mut self, name: &str, force: impl MarkerForce, markers: &[Marker], u: &[Control], b: &[Param]) {
        let Some((markers, Arguments { q, b })) = self.markers(name, markers, b) else { return };
        self.scene.list_force(name, OnMarkers { force, markers }, &q, u, &b.0);
    }

    /// Adds the force u (N) on a marker along its z axis, which turns with its body.
    pub fn thrust(&mut self, name: &str, marker: Marker, u: Control) {
        self.scene.ready(name, Part { control: Some(u), ..Part::at_markers(&THRUST, &[marker], &[]) });
    }

    /// Adds the torque u (N m) on the body of marker b about the z axis of b, and the opposite one on the body of a.
    pub fn torque(&mut self, name: &str, a: Marker, b: Marker, u: Control) {
        self.scene.ready(name, Part { control: Some(u), ..Part::at_markers(&TORQUE, &[a, b], &[]) });
    }

    fn drives(&mut self, [control]: [Control; 1], along: Unit) {
        self.scene.parts.sketch.driven.push((control, Drives::Displacement(along)));
    }

    /// Adds opposite loads on two markers.
    fn opposite(&mut self, name: &str, force: impl MarkerForce, both: [Marker; 2], u: &[Control], b: &[Param]) {
        let Some((markers, Arguments { q, b })) = self.pair(name, both, b) else { return };
        self.scene.list_force(name, OnMarkers { force, markers }, &q, u, &b.0);
    }

    /// Adds a force (N) at a marker and a torque (N m) on its body, with constant components in the inertial frame.
    pub fn applied_in_space(&mut self, name: &str, marker: Marker, force: impl Components<3>, torque: impl Components<3>) {
        let numbers = [force.params(), torque.params()].concat();
        self.scene.ready(name, Part::at_markers(&APPLIED_IN_SPACE, &[marker], &numbers));
    }

    /// Adds a force (N) at a marker and a torque (N m) on its body, with constant components along the axes of the marker.
    pub fn applied_on_body(&mut self, name: &str, marker: Marker, force: impl Components<3>, torque: impl Components<3>) {
        let numbers = [force.params(), torque.params()].concat();
        self.scene.ready(name, Part::at_markers(&APPLIED_ON_BODY, &[marker], &numbers));
    }

    /// Adds a force u (N) between two markers that drives them apart.
    pub fn two_point_actuator(&mut self, name: &str, a: Marker, b: Marker, u: Control) {
        self.scene.ready(name, Part { control: Some(u), ..Part::at_markers(&TWO_POINT_ACTUATOR, &[a, b], &[]) });
    }

    /// Adds a spring and a damper between two markers; `numbers` are stiffness (N/m), free length (m) and damping (N s/m). The markers may coincide only if the free length
    /// and the damping are the constant 0.
    pub fn spring_damper(&mut self, name: &str, a: Marker, b: Marker, numbers: impl Components<3>) {
        self.scene.ready(name, Part::at_markers(&SPRING_DAMPER, &[a, b], &numbers.params()));
    }
}
