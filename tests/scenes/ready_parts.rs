//! One small scene for each of the ready parts that are not everyday: the arms of `elements.rs` with the part in question.

use super::elements::{Arms, ELBOW_ANGLE, Kind, UPPER_ANGLE, with};
use hamiltonian_adjoint::planar::{Body, Constant, Curve, Harmonic};
use hamiltonian_adjoint::{Scalar, Scene};
use nalgebra::SVector;
use std::f64::consts::FRAC_PI_2;

/// The parts.
pub fn kinds() -> Vec<Kind> {
    vec![
        ("actuator between two points", true, cylinder),
        ("driven distance", true, driven_distance),
        ("driven slider", false, driven_slider),
        ("gear", false, gear),
        ("rack", true, rack),
        ("point on a curve", true, point_on_curve),
        ("bushing", false, bushing),
        ("dry friction", true, dry_friction),
        ("contact", true, contact),
        ("contact of a circle", true, circle_contact),
        ("contact of circles", true, circle_pair_contact),
        ("hinge with clearance", false, clearance),
        ("end stops", true, end_stops),
        ("force and torque given by time", true, given_by_time),
    ]
}

/// A scene for each part.
#[allow(dead_code)]
pub fn all() -> Vec<(&'static str, Scene)> {
    kinds().into_iter().map(|kind| (kind.0, with(kind, |_| {}))).collect()
}

fn cylinder(arms: &mut Arms) {
    let force = arms.scene.control("force");
    arms.scene.two_point_actuator("cylinder", arms.upper.at(-0.2, 0.1), arms.lower.at(0.2, 0.1), force);
}

fn driven_distance(arms: &mut Arms) {
    // From the middle of one arm to the middle of the other, by the law of cosines.
    let length = 0.5 * (2.0 + 2.0 * ELBOW_ANGLE.cos()).sqrt();
    let parameters = [(length - 0.05).into(), 0.05.into(), 6.0.into(), FRAC_PI_2.into()];
    arms.scene.driven_distance("cylinder", arms.upper.at(0.0, 0.0), arms.lower.at(0.0, 0.0), Harmonic, parameters);
}

fn driven_slider(arms: &mut Arms) {
    let (a, b) = arms.elbow();
    arms.scene.prismatic("elbow", a, 0.3, b, ELBOW_ANGLE);
    arms.scene.driven_slider("drive", (a, 0.3), b, Harmonic, [(-0.1).into(), 0.1.into(), 5.0.into(), FRAC_PI_2.into()]);
}

fn gear(arms: &mut Arms) {
    let [x, y, _] = arms.lower_place;
    let axle = Body::GROUND.at(x, y);
    arms.scene.revolute("second axle", axle, arms.lower.at(0.0, 0.0));
    arms.scene.gear("gear", arms.upper, 0.3, arms.lower, 0.2);
}

fn rack(arms: &mut Arms) {
    let rack = arms.scene.body("rack", 0.4, 0.01, [0.2, 0.1, 0.4]);
    arms.scene.prismatic("rail", Body::GROUND.at(0.2, 0.1), 0.4, rack.at(0.0, 0.0), 0.4);
    arms.scene.rack("teeth", rack, 0.4, arms.upper, 0.15);
}

/// y = c₀ + c₁ x².
struct Bowl;

impl Curve<2> for Bowl {
    fn value<S: Scalar>(&self, x: S, y: S, b: &SVector<S, 2>) -> S {
        y - b[0] - b[1] * x * x
    }
}

fn point_on_curve(arms: &mut Arms) {
    let (angle, curvature) = (UPPER_ANGLE + ELBOW_ANGLE, 0.4);
    let (x, y) = (UPPER_ANGLE.cos() + angle.cos(), UPPER_ANGLE.sin() + angle.sin());
    let parameters = [(y - curvature * x * x).into(), curvature.into()];
    arms.scene.point_on_curve("slot", Body::GROUND.at(0.0, 0.0), Bowl, arms.lower.at(0.5, 0.0), parameters);
}

fn bushing(arms: &mut Arms) {
    let (a, b) = arms.elbow();
    arms.scene.bushing("elbow", a, b, [900.0.into(), 700.0.into(), 20.0.into()], [3.0.into(), 2.0.into(), 0.1.into()]);
}

fn dry_friction(arms: &mut Arms) {
    arms.scene.coulomb_friction("friction", arms.upper, arms.lower, 0.4, 0.2);
    arms.scene.coulomb_sliding("rubbing", arms.upper.at(0.0, 0.0), 0.3, arms.lower.at(0.5, 0.0), 0.3, 0.1);
}

fn contact(arms: &mut Arms) {
    let law = [1e4.into(), 0.2.into(), 0.3.into(), 0.05.into()];
    arms.scene.contact("floor", Body::GROUND.at(0.0, -1.57), FRAC_PI_2, arms.lower.at(0.5, 0.0), law);
}

fn circle_contact(arms: &mut Arms) {
    for (name, x, width) in [("floor", 0.5, 0.01), ("hard floor", 0.48, 0.0)] {
        let law = [1e4, 0.2, 0.3, 0.05, width].map(Into::into);
        arms.scene.circle_contact(name, Body::GROUND.at(0.0, -1.62), FRAC_PI_2, arms.lower.at(x, 0.0), 0.05, law);
    }
}

fn circle_pair_contact(arms: &mut Arms) {
    for (name, radius, width) in [("stone", 0.25, 0.1), ("hard stone", 0.23, 0.0)] {
        let law = [1e3, 0.2, 0.3, 0.05, width].map(Into::into);
        arms.scene.circle_pair_contact(name, Body::GROUND.at(1.127, -1.87), radius, arms.lower.at(0.5, 0.0), 0.1, law);
    }
}

fn clearance(arms: &mut Arms) {
    let (bore, pin) = (arms.upper.at(0.5, 0.0), arms.lower.at(-0.2, 0.0));
    arms.scene.circle_pair_contact("elbow", bore, -0.5, pin, 0.25, [1e3, 0.2, 0.3, 0.05, 0.1].map(Into::into));
}

fn end_stops(arms: &mut Arms) {
    let limits = [ELBOW_ANGLE - 1.0, ELBOW_ANGLE - 0.02].map(Into::into);
    arms.scene.end_stop("stop", arms.upper, arms.lower, limits, [40.0, 0.3, 0.05].map(Into::into));
    let (a, b, reach) = (arms.upper.at(0.0, 0.0), arms.lower.at(0.5, 0.0), [-1.0, 1.4].map(Into::into));
    arms.scene.sliding_end_stop("reach", a, 0.1, b, reach, [300.0, 0.2, 0.0].map(Into::into));
}

fn given_by_time(arms: &mut Arms) {
    let parameters = [0.5.into(), 1.0.into(), 4.0.into(), 0.3.into()];
    arms.scene.applied_force("gust", arms.lower.at(0.3, 0.1), 0.7, Harmonic, parameters);
    arms.scene.applied_torque("moment", arms.upper, Constant, [0.2.into()]);
}
