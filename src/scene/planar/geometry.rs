//! Points and vectors of two bodies a and b with the coordinates q = (x_a, y_a, φ_a, x_b, y_b, φ_b).

use nalgebra::SVector;

use crate::Scalar;

/// R(φ) s: a vector of the body's frame in the inertial frame.
pub(super) fn rotated<S: Scalar>(phi: S, s: [S; 2]) -> SVector<S, 2> {
    let (sin, cos) = phi.sin_cos();
    SVector::from([cos * s[0] - sin * s[1], sin * s[0] + cos * s[1]])
}

/// A vector turned by a right angle: the derivative of a rotated vector with respect to φ.
pub(super) fn turned<S: Scalar>(v: &SVector<S, 2>) -> SVector<S, 2> {
    SVector::from([-v[1], v[0]])
}

/// The arms R_a s_a, R_b s_b and the vector between the points, r_b + R_b s_b − r_a − R_a s_a.
pub(super) struct Link<S> {
    pub(super) arm_a: SVector<S, 2>,
    pub(super) arm_b: SVector<S, 2>,
    pub(super) between: SVector<S, 2>,
}

impl<S: Scalar> Link<S> {
    /// The link between the points s_a = (b₀, b₁) and s_b = (b₂, b₃).
    pub(super) fn new(q: &SVector<S, 6>, b: &[S]) -> Self {
        let arm_a = rotated(q[2], [b[0], b[1]]);
        let arm_b = rotated(q[5], [b[2], b[3]]);
        let between = SVector::from([q[3], q[4]]) + arm_b - SVector::from([q[0], q[1]]) - arm_a;
        Link { arm_a, arm_b, between }
    }

    /// The velocity of the vector between, in the plane: written with differences, so that equal differences are computed once.
    pub(super) fn velocity(&self, v: &SVector<S, 6>) -> SVector<S, 2> {
        SVector::from([v[3] - v[0], v[4] - v[1]]) + turned(&self.arm_b) * v[5] - turned(&self.arm_a) * v[2]
    }

    /// The gradient with respect to q of e · between for a direction e that does not change.
    pub(super) fn along(&self, e: &SVector<S, 2>) -> SVector<S, 6> {
        let turn_a = -e.dot(&turned(&self.arm_a));
        let turn_b = e.dot(&turned(&self.arm_b));
        SVector::from([-e[0], -e[1], turn_a, e[0], e[1], turn_b])
    }

    /// The gradient of e · between for a direction e that turns with body a.
    pub(super) fn along_axis(&self, e: &SVector<S, 2>) -> SVector<S, 6> {
        let mut gradient = self.along(e);
        gradient[2] += turned(e).dot(&self.between);
        gradient
    }

    /// The unit vector from one point to the other.
    pub(super) fn direction(&self) -> SVector<S, 2> {
        self.between / self.between.dot(&self.between).sqrt()
    }
}
