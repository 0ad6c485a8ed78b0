//! The parts along an axis: their formulas, and the methods that add them.

use nalgebra::SVector;

use super::Axis;
use super::along::{Along, Push, combined};
use crate::model::element::{ForcePoint, ListCost, ListPoint};
use crate::model::{Control, Coordinate, Drives, Multiplier, Param};
use crate::planar::{AppliedTorque, Constant, Motion};
use crate::scene::planar::{dry_friction, stop_force, with_motion, within};
use crate::scene::ready::{Kind, Part, Sort};
use crate::{Constraint, Force, KineticEnergy, PotentialEnergy, Scalar, Scene};

/// F = u.
struct Motor;

impl Force<1, 1> for Motor {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        at.u
    }
}

/// V = ½ c (s − s₀)²; b = [c, s₀].
struct Spring;

impl PotentialEnergy<1, 2> for Spring {
    fn potential_energy<S: Scalar>(&self, s: &SVector<S, 1>, b: &SVector<S, 2>, _t: S) -> S {
        let stretch = s[0] - b[1];
        b[0] * stretch * stretch * 0.5
    }
}

/// F = −d ds/dt; b = [d].
struct Damper;

impl Force<1, 0, 1> for Damper {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 1>) -> SVector<S, 1> {
        at.v * -b[0]
    }
}

/// F = −F_max tanh((ds/dt)/v_s); b = [F_max, v_s].
struct DryFriction;

impl Force<1, 0, 2> for DryFriction {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 2>) -> SVector<S, 1> {
        SVector::from([dry_friction(at.v[0], [b[0], b[1]])])
    }
}

/// T = ½ I (n ds/dt)²; b = [I, n].
struct Rotor;

impl KineticEnergy<1, 2> for Rotor {
    fn kinetic_energy<S: Scalar>(&self, _s: &SVector<S, 1>, v: &SVector<S, 1>, b: &SVector<S, 2>) -> S {
        let speed = b[1] * v[0];
        b[0] * speed * speed * 0.5
    }
}

/// Stops of both ends, smooth for a width w > 0 if true; b = [lower and upper limit, k, c, w].
struct EndStop(bool);

impl Force<1, 0, 5> for EndStop {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 5>) -> SVector<S, 1> {
        SVector::from([stop_force(self.0, at.q[0], at.v[0], b.as_slice())])
    }
}

/// The event of a stop: negative beyond the limits; b = [factors of the axis, lower, upper].
struct Range;

impl ListCost for Range {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        let n = at.q.len();
        within(combined(at.q, at.b)[0], [at.b[n], at.b[n + 1]])
    }
}

/// Φ = s − f(t); b = parameters of f.
struct Driven<F>(F);

impl<F: Motion<P>, const P: usize> Constraint<1, 1, P> for Driven<F> {
    fn phi<S: Scalar>(&self, s: &SVector<S, 1>, b: &SVector<S, P>, t: S) -> SVector<S, 1> {
        SVector::from([s[0] - self.0.value(t, b)])
    }
}

static MOTOR: Kind = Kind::of_axis("motor", &[], |scene, name, part| {
    let (axis, by) = (part.axis(), part.by());
    let along = axis.q.first().map(|q| (by[0], Drives::Coordinate(*q)));
    scene.parts.sketch.driven.extend(along);
    scene.list_force(name, Push(Motor), &axis.q, &by, &axis.factors);
})
.driven_by("force");

static AXIS_FORCE: Kind = Kind::of_axis("axis force", &[], |scene, name, part| {
    with_motion!(part, motion, parameters, scene.axis_force(name, part.axis().clone(), motion, parameters));
})
.moving();

static SPRING_DAMPER: Kind =
    Kind::of_axis("axis spring and damper", &["stiffness", "free_value", "damping"], |scene, name, part| {
        let (axis, [stiffness, free_value, damping]) = (part.axis(), part.numbers_from(0));
        if stiffness.constant() != Some(0.0) {
            let b = axis.and(&[stiffness, free_value]);
            scene.list_potential_energy(&format!("{name} (spring)"), Along(Spring), &axis.q, &b);
        }
        if damping.constant() != Some(0.0) {
            scene.list_force(&format!("{name} (damper)"), Push(Damper), &axis.q, &[], &axis.and(&[damping]));
        }
    });

static COULOMB_FRICTION: Kind = Kind::of_axis("axis Coulomb friction", &["force", "speed"], |scene, name, part| {
    let axis = part.axis();
    scene.require_positive(part.number(1), format!("the speed of {}", scene.along(name, axis)));
    scene.list_force(name, Push(DryFriction), &axis.q, &[], &axis.and(&part.numbers));
});

const OF_STOP: &[&str] = &["lower", "upper", "stiffness", "damping", "width"];

static END_STOP: Kind = Kind::of_axis("axis end stop", OF_STOP, |scene, name, part| {
    let (axis, [lower, upper, .., width]) = (part.axis(), part.numbers_from::<5>(0));
    let of = scene.along(name, axis);
    scene.require_positive(upper - lower, format!("the upper limit minus the lower limit of {of}"));
    let is_smooth = scene.is_smooth(name, width);
    scene.list_force(name, Push(EndStop(is_smooth)), &axis.q, &[], &axis.and(&part.numbers));
    if !is_smooth {
        scene.list_event(name, Range, &axis.q, &[], &[], &axis.and(&[lower, upper]));
    }
});

static ROTOR: Kind = Kind::of_axis("rotor", &["inertia", "ratio"], |scene, name, part| {
    let axis = part.axis();
    scene.require_nonnegative(part.number(0), format!("the inertia of {}", scene.along(name, axis)));
    scene.list_kinetic_energy(name, Along(Rotor), &axis.q, &axis.and(&part.numbers));
});

static DRIVEN_AXIS: Kind = Kind::of_axis("driven axis", &[], |scene, name, part| {
    with_motion!(part, motion, parameters, scene.driven_axis(name, part.axis().clone(), motion, parameters));
})
.moving();

static LINEAR_RELATION: Kind = Kind::new("linear relation", &["c"], |scene, name, part| {
    scene.driven_axis(name, part.axis().clone(), Constant, [part.number(0)]);
})
.with(&[("terms", Sort::Axis)]);

/// All kinds of parts along an axis.
#[cfg(feature = "files")]
pub(crate) static KINDS: [&Kind; 8] =
    [&MOTOR, &AXIS_FORCE, &SPRING_DAMPER, &COULOMB_FRICTION, &END_STOP, &ROTOR, &DRIVEN_AXIS, &LINEAR_RELATION];

impl Scene {
    /// Adds the force u (N or N m) of a motor along an axis, driven by a control. For a joint it acts on its second body, and its reaction on the first.
    pub fn motor(&mut self, name: &str, axis: impl Into<Axis>, force: Control) {
        self.ready(name, Part { control: Some(force), ..Part::along(&MOTOR, axis.into(), &[]) });
    }

    /// Adds a force f(t; parameters), N or N m, along an axis; use [`Constant`] for a constant force.
    pub fn axis_force<F, const P: usize>(&mut self, name: &str, axis: impl Into<Axis>, motion: F, parameters: [Param; P])
    where
        F: Motion<P>,
    {
        let axis = axis.into();
        self.driven(name, Part::along(&AXIS_FORCE, axis.clone(), &[]), motion, parameters, |scene, motion| {
            scene.list_force(name, Push::<_, 0, P>(AppliedTorque(motion)), &axis.q, &[], &axis.and(&parameters));
        });
    }

    /// Adds a spring and a damper along an axis: stiffness (N/m or N m/rad), free value s₀ of the coordinate (m or rad), damping (N s/m or N m s/rad).
    pub fn axis_spring_damper(
        &mut self,
        name: &str,
        axis: impl Into<Axis>,
        stiffness: impl Into<Param>,
        free_value: impl Into<Param>,
        damping: impl Into<Param>,
    ) {
        let numbers = [stiffness.into(), free_value.into(), damping.into()];
        self.ready(name, Part::along(&SPRING_DAMPER, axis.into(), &numbers));
    }

    /// Adds regularised dry friction along an axis: a force of at most `force` (N or N m), reached at a few times `speed` (m/s or rad/s).
    ///
    /// There is no sticking; see [`coulomb_friction`](Self::coulomb_friction).
    pub fn axis_coulomb_friction(
        &mut self,
        name: &str,
        axis: impl Into<Axis>,
        force: impl Into<Param>,
        speed: impl Into<Param>,
    ) {
        self.ready(name, Part::along(&COULOMB_FRICTION, axis.into(), &[force.into(), speed.into()]));
    }

    /// Adds end stops of an axis at the `limits` [lower, upper] of its coordinate (m or rad).
    ///
    /// `law` = [k in N/m or N m/rad, c in s/m or s/rad, w in m or rad]; force and event are those of [`end_stop`](Self::end_stop).
    pub fn axis_end_stop(&mut self, name: &str, axis: impl Into<Axis>, limits: [Param; 2], law: [Param; 3]) {
        self.ready(name, Part::along(&END_STOP, axis.into(), &[&limits[..], &law].concat()));
    }

    /// Adds the inertia I (kg m², or kg) of a rotor that turns n times as fast as the coordinate of the axis, T = ½ I (n ds/dt)².
    ///
    /// This is the energy of a rotor behind a gear with the ratio n, without the (usually small) coupling of its spin with the motion of the body that
    /// carries it.
    pub fn rotor(&mut self, name: &str, axis: impl Into<Axis>, inertia: impl Into<Param>, ratio: impl Into<Param>) {
        self.ready(name, Part::along(&ROTOR, axis.into(), &[inertia.into(), ratio.into()]));
    }

    /// Adds a drive: the prescribed value s = f(t; parameters), m or rad, of the coordinate of an axis.
    ///
    /// The drive acts with the force −λ (N or N m) along the axis, where λ is the reaction that belongs to the multiplier
    /// ([`CostPoint::lambda`](crate::CostPoint::lambda)).
    pub fn driven_axis<F, const P: usize>(
        &mut self,
        name: &str,
        axis: impl Into<Axis>,
        motion: F,
        parameters: [Param; P],
    ) -> [Multiplier; 1]
    where
        F: Motion<P>,
    {
        let axis = axis.into();
        self.multipliers_of(|scene| {
            scene.driven(name, Part::along(&DRIVEN_AXIS, axis.clone(), &[]), motion, parameters, |scene, motion| {
                let driven = Along::<_, P>(Driven(motion));
                scene.list_constraint(name, driven, 1, &axis.q, &axis.and(&parameters));
            });
        })
    }

    /// Adds the relation Σ a_k q_k = c of coordinates q_k with factors a_k, for example a gear between two joints.
    ///
    /// The relation acts with the force −a_k λ on q_k.
    pub fn linear_relation<P: Into<Param>, const N: usize>(
        &mut self,
        name: &str,
        terms: [(Coordinate, P); N],
        c: impl Into<Param>,
    ) -> [Multiplier; 1] {
        let part = Part::along(&LINEAR_RELATION, terms.into(), &[c.into()]);
        self.multipliers_of(|scene| scene.ready(name, part))
    }

    /// The names of a part and of the coordinates of its axis, for messages.
    pub(in crate::scene) fn along(&self, name: &str, axis: &Axis) -> String {
        let own = axis.q.iter().filter(|q| self.parts.scene.owns(&q.0));
        let coordinates: Vec<_> = own.map(|q| format!("`{}`", self.parts.coordinates[q.index()])).collect();
        format!("`{name}` along {}", coordinates.join(", "))
    }
}
