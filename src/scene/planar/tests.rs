//! Comparison of the programs of all planar elements with num-dual.

use super::*;
use crate::system::verify_tests::{hold_element, hold_element_with};
use crate::system::{Applied, Fixed, Holonomic, Kinetic, Potential};

/// y = b x².
#[derive(Clone, Copy)]
struct Parabola;

impl Curve<1> for Parabola {
    fn value<S: crate::Scalar>(&self, x: S, y: S, b: &nalgebra::SVector<S, 1>) -> S {
        y - b[0] * x * x
    }
}

macro_rules! between_bodies {
    ($($kind:ident, $element:expr, $m:literal, $k:literal, $p:literal $(, $positive:literal)*;)*) => {$(
        hold_element_with::<_, $p>(|| $kind::<Fixed<_, 6, $m, $k, $p>, 6>::fixed($element), &[], stringify!($element), &[$($positive),*]);
        hold_element_with::<_, $p>(|| $kind::<Fixed<_, 6, $m, $k, $p>, 6>::fixed($element), &[3, 4, 5], concat!(stringify!($element), " from ground"), &[$($positive),*]);
        hold_element_with::<_, $p>(|| $kind::<Fixed<_, 6, $m, $k, $p>, 6>::fixed($element), &[0, 1, 2], concat!(stringify!($element), " to ground"), &[$($positive),*]);
    )*};
}

#[test]
fn programs_of_planar_elements_are_what_num_dual_makes_of_them() {
    between_bodies! {
        Holonomic, Revolute, 2, 0, 4;
        Holonomic, Prismatic, 2, 0, 6;
        Holonomic, Weld, 3, 0, 5;
        Holonomic, Distance, 1, 0, 5;
        Holonomic, DrivenAngle(ConstantSpeed), 1, 0, 2;
        Holonomic, DrivenAngle(Harmonic), 1, 0, 4;
        Applied, Damper, 0, 0, 5;
        Applied, JointFriction, 0, 0, 1;
        Applied, SlidingFriction, 0, 0, 6;
        Applied, Actuator, 0, 1, 5;
        Applied, TorqueActuator, 0, 1, 0;
        Potential, LinearSpring, 0, 0, 6;
        Potential, ZeroLengthSpring, 0, 0, 5;
        Potential, TorsionalSpring, 0, 0, 2;
        Holonomic, DrivenDistance::<_, 4>(Harmonic), 1, 0, 12;
        Holonomic, DrivenSlider::<_, 2>(ConstantSpeed), 1, 0, 13;
        Holonomic, PointOnCurve::<_, 1>(Parabola), 1, 0, 12;
        Applied, TwoPointActuator, 0, 1, 4;
        Applied, BushingDamper, 0, 0, 7;
        Applied, CoulombFriction, 0, 0, 2;
        Applied, CoulombSliding, 0, 0, 7;
        Applied, CircleContact { is_pair: false, is_smooth: false }, 0, 0, 11, 9;
        Applied, CircleContact { is_pair: false, is_smooth: true }, 0, 0, 11, 9, 10;
        Applied, CircleContact { is_pair: true, is_smooth: false }, 0, 0, 11, 9;
        Applied, CircleContact { is_pair: true, is_smooth: true }, 0, 0, 11, 9, 10;
        Applied, EndStop(false), 0, 0, 5;
        Applied, EndStop(true), 0, 0, 5, 4;
        Applied, SlidingEndStop(false), 0, 0, 10;
        Applied, SlidingEndStop(true), 0, 0, 10, 9;
        Potential, Bushing, 0, 0, 7;
    }
    hold_element::<_, 2>(|| Kinetic::<Fixed<_, 3, 0, 0, 2>, 3>::fixed(RigidBody), &[], "RigidBody");
    hold_element::<_, 5>(
        || Holonomic::<Fixed<_, 6, 1, 0, 5>, 6>::fixed(Distance),
        &[0, 1, 2, 3, 4],
        "Distance to a particle",
    );
    hold_element::<_, 5>(|| Applied::<Fixed<_, 6, 0, 0, 5>, 6>::fixed(Damper), &[0, 1, 3, 4, 5], "Damper from a particle");
    hold_element::<_, 6>(
        || Potential::<Fixed<_, 6, 0, 0, 6>, 6>::fixed(LinearSpring),
        &[0, 1, 3, 4],
        "LinearSpring between particles",
    );
    hold_element::<_, 5>(|| Applied::<Fixed<_, 6, 0, 0, 5>, 6>::fixed(Damper), &[3, 4], "Damper from ground to a particle");
    hold_element::<_, 5>(
        || Holonomic::<Fixed<_, 6, 1, 0, 5>, 6>::fixed(Distance),
        &[0, 1],
        "Distance from a particle to ground",
    );
    let floor = CircleContact { is_pair: false, is_smooth: false };
    hold_element_with::<_, 11>(
        || Applied::<Fixed<_, 6, 0, 0, 11>, 6>::fixed(floor),
        &[0, 1, 3, 4],
        "contact between particles",
        &[9],
    );
    hold_element::<_, 12>(
        || Holonomic::<Fixed<_, 6, 1, 0, 12>, 6>::fixed(PointOnCurve::<_, 1>(Parabola)),
        &[3, 4],
        "PointOnCurve of a particle",
    );
    hold_element::<_, 1>(|| Kinetic::<Fixed<_, 2, 0, 0, 1>, 2>::fixed(PointMass), &[], "PointMass");
    hold_element::<_, 3>(|| Holonomic::<Fixed<_, 2, 1, 0, 3>, 2>::fixed(Gear), &[], "Gear");
    hold_element::<_, 3>(|| Holonomic::<Fixed<_, 3, 1, 0, 3>, 3>::fixed(Rack), &[], "Rack");
    hold_element::<_, 11>(
        || Applied::<Fixed<_, 3, 0, 0, 11>, 3>::fixed(AppliedForce::<_, 4>(Harmonic)),
        &[],
        "AppliedForce",
    );
    hold_element::<_, 4>(|| Applied::<Fixed<_, 1, 0, 0, 4>, 1>::fixed(AppliedTorque(Harmonic)), &[], "AppliedTorque");
    hold_element::<_, 3>(|| Potential::<Fixed<_, 2, 0, 0, 3>, 2>::fixed(Weight), &[], "Weight");
}
