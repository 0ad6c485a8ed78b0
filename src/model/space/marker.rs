//! [`Body`]: a rigid body in space, and [`Marker`]: a point of a body with axes.

use super::components::Components;
use super::vectors::{self, Matrix, Vector};
use crate::Error;
use crate::model::{Handle, Param};

/// A rigid body in space, or the ground ([`Body::GROUND`]), whose axes are those of the inertial frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body(pub(crate) Option<Handle>);

/// A point of a body with axes x, y and z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marker {
    pub(crate) body: Body,
    pub(crate) at: Vector,
    pub(crate) axes: Axes,
}

/// A quantity of a marker with components along the axes of the inertial frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The position, m.
    Position,
    /// The velocity, m/s.
    Velocity,
    /// The acceleration, m/s².
    Acceleration,
    /// The direction of the x axis.
    XAxis,
    /// The direction of the y axis.
    YAxis,
    /// The direction of the z axis.
    ZAxis,
    /// The angular velocity, rad/s.
    AngularVelocity,
    /// The angular acceleration, rad/s².
    AngularAcceleration,
}

/// The axes of a marker in the frame of its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Axes {
    /// Those of the body.
    OfBody,
    /// Those of the body after a rotation by roll, pitch and yaw.
    Turned(Vector),
    /// The z axis has this direction; the others are those of the body after the shortest rotation, or near −z after a half turn about x and the
    /// shortest rotation from there.
    Along(Vector),
    /// The z axis has the first direction; the x axis has that of the second one perpendicular to it.
    Toward(Vector, Vector),
}

impl Body {
    /// The inertial frame.
    pub const GROUND: Body = Body(None);

    /// The marker at a point of the body's frame, m, with the axes of the body.
    pub fn at(self, point: impl Components<3>) -> Marker {
        Marker { body: self, at: point.params(), axes: Axes::OfBody }
    }

    /// The marker at the origin of the body's frame, with the axes of the body.
    pub fn origin(self) -> Marker {
        self.at([0.0; 3])
    }
}

impl Marker {
    /// The marker with its z axis in a direction of the body's frame; x and y are those of the body after the shortest rotation. For directions within
    /// 26° of −z they are those after a half turn about x and the shortest rotation from −z.
    #[must_use]
    pub fn along(self, z: impl Components<3>) -> Self {
        Marker { axes: Axes::Along(z.params()), ..self }
    }

    /// The marker with its z axis in a direction of the body's frame, and its x axis in the direction of the part of `x` that is perpendicular to it.
    #[must_use]
    pub fn along_and_toward(self, z: impl Components<3>, x: impl Components<3>) -> Self {
        Marker { axes: Axes::Toward(z.params(), x.params()), ..self }
    }

    /// The marker with the axes of the body turned by roll, pitch and yaw, rad: R = R_z(yaw) R_y(pitch) R_x(roll).
    #[must_use]
    pub fn turned(self, roll_pitch_yaw: impl Components<3>) -> Self {
        Marker { axes: Axes::Turned(roll_pitch_yaw.params()), ..self }
    }

    /// The body of the marker.
    pub fn body(self) -> Body {
        self.body
    }

    /// All parameters of the marker.
    pub(crate) fn params(&self) -> Vec<Param> {
        let axes = match self.axes {
            Axes::OfBody => Vec::new(),
            Axes::Turned(angles) => angles.to_vec(),
            Axes::Along(z) => z.to_vec(),
            Axes::Toward(z, x) => [z, x].concat(),
        };
        [self.at.to_vec(), axes].concat()
    }
}

impl Axes {
    /// The lengths that must not vanish: of the directions, and of the part of the x axis that is perpendicular to z, which is 0 if it is rounding.
    fn lengths(self, value: &dyn Fn(Param) -> f64) -> Vec<f64> {
        let length = |direction: Vector| direction.map(value).iter().map(|x| x * x).sum::<f64>().sqrt();
        match self {
            Axes::OfBody | Axes::Turned(_) => Vec::new(),
            Axes::Along(z) => vec![length(z)],
            Axes::Toward(z, x) => {
                let (both, across) = (length(z) * length(x), length(vectors::cross(z, x)));
                vec![length(z), if across > PARALLEL * both { across } else { 0.0 }]
            }
        }
    }

    /// The rotation whose columns are the axes, with the present values of parameters.
    ///
    /// # Errors
    /// An axis without a direction.
    pub(crate) fn checked_rotation(self, part: &str, value: &dyn Fn(Param) -> f64) -> Result<Matrix, Error> {
        let bad = self.lengths(value).into_iter().find(|length| !(*length > SHORTEST && length.is_finite()));
        let Some(length) = bad else { return Ok(self.rotation(value)) };
        let what = format!("the length of an axis of a marker of `{part}`");
        Err(Error::Parameter { what, value: length, must_be: "positive, and axes must not be parallel to each other" })
    }

    /// The rotation whose columns are the axes. `value` is the present value of a parameter.
    fn rotation(self, value: &dyn Fn(Param) -> f64) -> Matrix {
        match self {
            Axes::OfBody => vectors::identity(),
            Axes::Turned(angles) => turned(angles),
            Axes::Along(z) => shortest(vectors::unit(z), value),
            Axes::Toward(z, x) => {
                let z = vectors::unit(z);
                let y = vectors::unit(vectors::cross(z, x));
                vectors::of_columns(vectors::cross(y, z), y, z)
            }
        }
    }
}

/// R_z(yaw) R_y(pitch) R_x(roll).
fn turned(roll_pitch_yaw: Vector) -> Matrix {
    let [(sr, cr), (sp, cp), (sy, cy)] = roll_pitch_yaw.map(|angle| (angle.sin(), angle.cos()));
    let (one, nil) = (Param::from(1.0), Param::from(0.0));
    let x = [[one, nil, nil], [nil, cr, -sr], [nil, sr, cr]];
    let y = [[cp, nil, sp], [nil, one, nil], [-sp, nil, cp]];
    let z = [[cy, -sy, nil], [sy, cy, nil], [nil, nil, one]];
    vectors::product(vectors::product(z, y), x)
}

/// The sine of an angle between axes that is rounding.
const PARALLEL: f64 = 1e-12;
/// The squares of shorter axes lose digits.
const SHORTEST: f64 = 1e-150;

/// Where the shortest rotation from the z axis is replaced: far from horizontal directions, whose z may be 0 or a rounding error of either sign.
const BELOW: f64 = -0.9;

/// The shortest rotation from the z axis to a unit vector n, R = 1 + [a]ₓ + [a]ₓ²/(1 + n_z) with a = ẑ × n. Near −ẑ, where it becomes singular, it is
/// the shortest rotation from −ẑ after a half turn about x.
fn shortest(n: Vector, value: &dyn Fn(Param) -> f64) -> Matrix {
    let is_below = value(n[2]) < BELOW;
    let [x, y, z] = if is_below { [n[0], -n[1], -n[2]] } else { n };
    let share = (z + 1.0).recip();
    let (xx, xy, yy) = (vectors::times(x, x), vectors::times(x, y), vectors::times(y, y));
    let less = |k: Param| vectors::plus(1.0.into(), -vectors::times(k, share));
    let first = [less(xx), -vectors::times(xy, share), -x];
    let second = [-vectors::times(xy, share), less(yy), -y];
    let columns = [first, second, [x, y, z]];
    let [a, b, c] = columns.map(|[x, y, z]| if is_below { [x, -y, -z] } else { [x, y, z] });
    vectors::of_columns(a, b, c)
}
