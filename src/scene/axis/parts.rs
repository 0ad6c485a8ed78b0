//! The parts along an axis: their formulas, and the methods that add them.

use nalgebra::SVector;

use super::Axis;
use super::along::{Along, Push, combined};
use crate::model::element::{ForcePoint, ListCost, ListPoint};
use crate::model::{Control, Coordinate, Drives, Multiplier, Param};
use crate::planar::{AppliedTorque, Constant, Motion};
use crate::scene::planar::{dry_friction, stop_force, within};
use crate::{Constraint, Error, Force, KineticEnergy, PotentialEnergy, Scalar, Scene};

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

impl Scene {
    /// Adds the force u (N or N m) of a motor along an axis, driven by a control. For a joint it acts on its second body, and its reaction on the first.
    pub fn motor(&mut self, name: &str, axis: impl Into<Axis>, force: Control) {
        let axis = axis.into();
        let along = axis.q.first().map(|q| (force, Drives::Coordinate(*q)));
        self.parts.sketch.driven.extend(along);
        self.list_force(name, Push(Motor), &axis.q, &[force], &axis.factors);
    }

    /// Adds a force f(t; parameters), N or N m, along an axis; use [`Constant`] for a constant force.
    pub fn axis_force<F, const P: usize>(&mut self, name: &str, axis: impl Into<Axis>, motion: F, parameters: [Param; P])
    where
        F: Motion<P>,
    {
        let axis = axis.into();
        self.list_force(name, Push::<_, 0, P>(AppliedTorque(motion)), &axis.q, &[], &axis.and(&parameters));
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
        let (axis, stiffness, free_value, damping) = (axis.into(), stiffness.into(), free_value.into(), damping.into());
        self.part(name, &axis, &[("stiffness", stiffness), ("free value", free_value), ("damping", damping)]);
        if stiffness.constant() != Some(0.0) {
            self.list_potential_energy(
                &format!("{name} (spring)"),
                Along(Spring),
                &axis.q,
                &axis.and(&[stiffness, free_value]),
            );
        }
        if damping.constant() != Some(0.0) {
            self.list_force(&format!("{name} (damper)"), Push(Damper), &axis.q, &[], &axis.and(&[damping]));
        }
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
        let (axis, force, speed) = (axis.into(), force.into(), speed.into());
        let part = self.part(name, &axis, &[("force", force), ("speed", speed)]);
        self.require_positive(speed, format!("the speed of {part}"));
        self.list_force(name, Push(DryFriction), &axis.q, &[], &axis.and(&[force, speed]));
    }

    /// Adds end stops of an axis at the `limits` [lower, upper] of its coordinate (m or rad).
    ///
    /// `law` = [k in N/m or N m/rad, c in s/m or s/rad, w in m or rad]; force and event are those of [`end_stop`](Self::end_stop).
    pub fn axis_end_stop(&mut self, name: &str, axis: impl Into<Axis>, limits: [Param; 2], law: [Param; 3]) {
        let (axis, [lower, upper], [stiffness, damping, width]) = (axis.into(), limits, law);
        let numbers = [("lower", lower), ("upper", upper), ("stiffness", stiffness), ("damping", damping), ("width", width)];
        let part = self.part(name, &axis, &numbers);
        self.require_positive(upper - lower, format!("the upper limit minus the lower limit of {part}"));
        let is_smooth = self.is_smooth(name, width);
        self.list_force(name, Push(EndStop(is_smooth)), &axis.q, &[], &axis.and(&numbers.map(|(_, number)| number)));
        if !is_smooth {
            self.list_event(name, Range, &axis.q, &[], &[], &axis.and(&limits));
        }
    }

    /// Adds the inertia I (kg m², or kg) of a rotor that turns n times as fast as the coordinate of the axis, T = ½ I (n ds/dt)².
    ///
    /// This is the energy of a rotor behind a gear with the ratio n, without the (usually small) coupling of its spin with the motion of the body that
    /// carries it.
    pub fn rotor(&mut self, name: &str, axis: impl Into<Axis>, inertia: impl Into<Param>, ratio: impl Into<Param>) {
        let (axis, inertia, ratio) = (axis.into(), inertia.into(), ratio.into());
        let part = self.part(name, &axis, &[("inertia", inertia), ("ratio", ratio)]);
        self.require_nonnegative(inertia, format!("the inertia of {part}"));
        self.list_kinetic_energy(name, Along(Rotor), &axis.q, &axis.and(&[inertia, ratio]));
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
        let driven = Along::<_, P>(Driven(motion));
        self.multipliers_of(|scene| _ = scene.list_constraint(name, driven, 1, &axis.q, &axis.and(&parameters)))
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
        self.driven_axis(name, terms, Constant, [c.into()])
    }

    /// Reports numbers that are not finite. Returns the names of the part and of its coordinates, for messages.
    fn part(&mut self, name: &str, axis: &Axis, numbers: &[(&str, Param)]) -> String {
        let own = axis.q.iter().filter(|q| self.parts.scene.owns(&q.0));
        let coordinates: Vec<_> = own.map(|q| format!("`{}`", self.parts.coordinates[q.index()])).collect();
        let part = format!("`{name}` along {}", coordinates.join(", "));
        if let Some((number, param)) = numbers.iter().find(|(_, param)| !param.factor().is_finite()) {
            self.report(Error::NotFinite { what: format!("`{number}` of {part}"), value: param.factor() });
        }
        part
    }
}
