//! Points and vectors of two bodies a and b with the coordinates q = (x_a, y_a, φ_a, x_b, y_b, φ_b).

use nalgebra::SVector;

use crate::Scalar;

/// R(φ) s: a vector given in a body's frame, expressed in the inertial frame.
pub fn rotated<S: Scalar>(phi: S, s: [S; 2]) -> SVector<S, 2> {
    let (sin, cos) = phi.sin_cos();
    SVector::from([cos * s[0] - sin * s[1], sin * s[0] + cos * s[1]])
}

/// A vector rotated by a right angle: the derivative of a rotated vector with respect to φ.
pub fn turned<S: Scalar>(v: &SVector<S, 2>) -> SVector<S, 2> {
    SVector::from([-v[1], v[0]])
}

/// Geometry of a point of body a and a point of body b, for user-defined elements on their six coordinates.
///
/// ```
/// use hamiltonian_adjoint::planar::{Body, Link};
/// use hamiltonian_adjoint::{Force, ForcePoint, Scalar, Scene};
/// use nalgebra::SVector;
///
/// /// Two points attract each other by k/|d|²; b = [s_a, s_b, k].
/// struct Magnet;
/// impl Force<6, 0, 5> for Magnet {
///     fn force<S: Scalar>(&self, at: &ForcePoint<S, 6, 0>, b: &SVector<S, 5>) -> SVector<S, 6> {
///         let link = Link::new(&at.q, b.as_slice());
///         link.along(&link.direction()) * -(b[4] / link.between.dot(&link.between))
///     }
/// }
///
/// let mut scene = Scene::new();
/// let [a, b] = [("a", 0.0), ("b", 1.0)].map(|(name, x)| scene.body(name, 1.0, 0.1, [x, 0.0, 0.0]));
/// let q = [a.coordinates, b.coordinates].concat().try_into().expect("six");
/// let tips = [0.1, 0.2, -0.1, 0.2, 3.0].map(Into::into);
/// scene.force("magnet", Magnet, q, [], tips);
/// scene.draw_spring("magnet", a.at(0.1, 0.2), b.at(-0.1, 0.2));
/// scene.compile()?;
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Link<S> {
    /// R_a s_a, from the centre of a to its point, m.
    pub arm_a: SVector<S, 2>,
    /// R_b s_b, from the centre of b to its point, m.
    pub arm_b: SVector<S, 2>,
    /// d = r_b + R_b s_b − r_a − R_a s_a, m.
    pub between: SVector<S, 2>,
}

impl<S: Scalar> Link<S> {
    /// The geometry of the points s_a = (b₀, b₁) and s_b = (b₂, b₃), each in its body's frame, m.
    ///
    /// # Panics
    /// If `b` has fewer than four entries.
    pub fn new(q: &SVector<S, 6>, b: &[S]) -> Self {
        let arm_a = rotated(q[2], [b[0], b[1]]);
        let arm_b = rotated(q[5], [b[2], b[3]]);
        let between = SVector::from([q[3], q[4]]) + arm_b - SVector::from([q[0], q[1]]) - arm_a;
        Link { arm_a, arm_b, between }
    }

    /// The time derivative of `between`, m/s. It is written in terms of coordinate differences, so that a difference that occurs several
    /// times is computed once.
    pub fn velocity(&self, v: &SVector<S, 6>) -> SVector<S, 2> {
        SVector::from([v[3] - v[0], v[4] - v[1]]) + turned(&self.arm_b) * v[5] - turned(&self.arm_a) * v[2]
    }

    /// The gradient of e · `between` with respect to q for a constant direction e.
    pub fn along(&self, e: &SVector<S, 2>) -> SVector<S, 6> {
        let turn_a = -e.dot(&turned(&self.arm_a));
        let turn_b = e.dot(&turned(&self.arm_b));
        SVector::from([-e[0], -e[1], turn_a, e[0], e[1], turn_b])
    }

    /// The gradient of e · `between` with respect to q for a direction e that rotates with body a.
    pub fn along_axis(&self, e: &SVector<S, 2>) -> SVector<S, 6> {
        let mut gradient = self.along(e);
        gradient[2] += turned(e).dot(&self.between);
        gradient
    }

    /// The unit vector from the point of body a to the point of body b.
    pub fn direction(&self) -> SVector<S, 2> {
        self.between / self.between.dot(&self.between).sqrt()
    }
}
