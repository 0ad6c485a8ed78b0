//! Vectors in formulas, and the motion of one frame relative to another.

use crate::Scalar;
use crate::model::Param;
use crate::model::space::Motion;

pub(super) type Vector<S> = [S; 3];

/// A parameter of a formula: a number, which becomes part of the recorded program, or an entry of b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Number {
    Constant(f64),
    Entry(usize),
}

impl Number {
    pub(super) fn value<S: Scalar>(self, b: &[S]) -> S {
        match self {
            Number::Constant(value) => S::from(value),
            Number::Entry(which) => b[which],
        }
    }

    pub(super) fn is_zero(self) -> bool {
        self == Number::Constant(0.0)
    }
}

/// The parameters b of a formula.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbers(pub(super) Vec<Param>);

impl Numbers {
    pub(super) fn number(&mut self, param: Param) -> Number {
        if let Some(value) = param.constant() {
            return Number::Constant(value);
        }
        let known = self.0.iter().position(|other| *other == param);
        Number::Entry(known.unwrap_or_else(|| {
            self.0.push(param);
            self.0.len() - 1
        }))
    }

    pub(super) fn numbers<const N: usize>(&mut self, params: [Param; N]) -> [Number; N] {
        params.map(|param| self.number(param))
    }
}

pub(super) fn values<S: Scalar, const N: usize>(numbers: [Number; N], b: &[S]) -> [S; N] {
    numbers.map(|number| number.value(b))
}

pub(super) fn zero<S: Scalar>() -> Vector<S> {
    [S::from(0.0); 3]
}

pub(super) fn plus<S: Scalar>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    std::array::from_fn(|i| a[i] + b[i])
}

pub(super) fn minus<S: Scalar>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    std::array::from_fn(|i| a[i] - b[i])
}

pub(super) fn scaled<S: Scalar>(a: Vector<S>, factor: S) -> Vector<S> {
    a.map(|x| x * factor)
}

pub(super) fn dot<S: Scalar>(a: Vector<S>, b: Vector<S>) -> S {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross<S: Scalar>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

/// A rotation and an origin that do not change.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fixed {
    /// The columns are the axes of the inner frame in the outer one.
    pub(super) turn: [[Number; 3]; 3],
    pub(super) origin: [Number; 3],
}

impl Fixed {
    /// Rᵀ x: from the outer frame to the inner one.
    pub(super) fn inward<S: Scalar>(&self, x: Vector<S>, b: &[S]) -> Vector<S> {
        std::array::from_fn(|j| {
            let column = [self.turn[0][j], self.turn[1][j], self.turn[2][j]];
            dot(values(column, b), x)
        })
    }

    /// R x: from the inner frame to the outer one.
    pub(super) fn outward<S: Scalar>(&self, x: Vector<S>, b: &[S]) -> Vector<S> {
        self.turn.map(|row| dot(values(row, b), x))
    }

    pub(super) fn origin<S: Scalar>(&self, b: &[S]) -> Vector<S> {
        values(self.origin, b)
    }
}

/// A coordinate of a joint: a factor times a coordinate of the scene, plus an offset.
#[derive(Clone, Copy, Debug)]
pub(super) struct Follows {
    /// The number of the coordinate in the formula.
    pub(super) q: usize,
    pub(super) factor: Number,
    pub(super) offset: Number,
}

impl Follows {
    pub(super) fn place<S: Scalar>(&self, q: &[S], b: &[S]) -> S {
        q[self.q] * self.factor.value(b) + self.offset.value(b)
    }

    pub(super) fn rate<S: Scalar>(&self, v: &[S], b: &[S]) -> S {
        v[self.q] * self.factor.value(b)
    }
}

/// The motion at one point.
pub(super) enum Moved<S> {
    Turn {
        axis: usize,
        sin: S,
        cos: S,
    },
    Slide {
        axis: usize,
        offset: S,
    },
    /// The rotation, rows.
    Ball([[S; 3]; 3]),
}

impl Motion<Follows> {
    pub(super) fn at<S: Scalar>(&self, q: &[S], b: &[S]) -> Moved<S> {
        match self {
            Motion::Turn(axis, angle) => {
                let (sin, cos) = angle.place(q, b).sin_cos();
                Moved::Turn { axis: *axis, sin, cos }
            }
            Motion::Slide(axis, offset) => Moved::Slide { axis: *axis, offset: offset.place(q, b) },
            Motion::Ball(e) => Moved::Ball(rotation(e.each_ref().map(|e| e.place(q, b)))),
        }
    }

    /// The rotation rate and the velocity of the origin, in the inner frame.
    pub(super) fn rates<S: Scalar>(&self, q: &[S], v: &[S], b: &[S]) -> (Vector<S>, Vector<S>) {
        let along = |axis: usize, rate: S| std::array::from_fn(|i| if i == axis { rate } else { S::from(0.0) });
        match self {
            Motion::Turn(axis, angle) => (along(*axis, angle.rate(v, b)), zero()),
            Motion::Slide(axis, offset) => (zero(), along(*axis, offset.rate(v, b))),
            Motion::Ball(e) => {
                let ([e0, x @ ..], [rate, y @ ..]) =
                    (e.each_ref().map(|e| e.place(q, b)), e.each_ref().map(|e| e.rate(v, b)));
                let twice = (e0 * e0 + dot(x, x)).recip() * 2.0;
                (scaled(minus(minus(scaled(y, e0), scaled(x, rate)), cross(x, y)), twice), zero())
            }
        }
    }
}

impl Motion<Follows> {
    /// The rates of change of the motion's own rates, in the inner frame: with E the matrix for which ω = 2 E ė/|e|², ω̇ = 2 E ë/|e|² − 2 ω e·ė/|e|².
    pub(super) fn accelerations<S: Scalar>(&self, q: &[S], v: &[S], v_dot: &[S], b: &[S]) -> (Vector<S>, Vector<S>) {
        let (turns, slides) = self.rates(q, v_dot, b);
        let Motion::Ball(e) = self else { return (turns, slides) };
        let [place, rate] = [e.each_ref().map(|e| e.place(q, b)), e.each_ref().map(|e| e.rate(v, b))];
        let sum = |x: &[S; 4], y: &[S; 4]| x[0] * y[0] + x[1] * y[1] + x[2] * y[2] + x[3] * y[3];
        let longer = sum(&place, &rate) * 2.0 / sum(&place, &place);
        (minus(turns, scaled(self.rates(q, v, b).0, longer)), slides)
    }
}

impl<S: Scalar> Moved<S> {
    /// From the outer frame to the inner one.
    pub(super) fn inward(&self, x: Vector<S>) -> Vector<S> {
        match self {
            Moved::Turn { axis, sin, cos } => turned(x, *axis, (*sin, *cos)),
            Moved::Slide { .. } => x,
            Moved::Ball(rotation) => std::array::from_fn(|j| dot([rotation[0][j], rotation[1][j], rotation[2][j]], x)),
        }
    }

    /// From the inner frame to the outer one.
    pub(super) fn outward(&self, x: Vector<S>) -> Vector<S> {
        match self {
            Moved::Turn { axis, sin, cos } => turned(x, *axis, (-*sin, *cos)),
            Moved::Slide { .. } => x,
            Moved::Ball(rotation) => rotation.map(|row| dot(row, x)),
        }
    }

    /// The origin of the inner frame in the outer one.
    pub(super) fn origin(&self) -> Vector<S> {
        match self {
            Moved::Slide { axis, offset } => std::array::from_fn(|i| if i == *axis { *offset } else { S::from(0.0) }),
            _ => zero(),
        }
    }
}

/// x in a frame that is turned by an angle about an axis.
fn turned<S: Scalar>(x: Vector<S>, axis: usize, (sin, cos): (S, S)) -> Vector<S> {
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut y = x;
    (y[i], y[j]) = (cos * x[i] + sin * x[j], cos * x[j] - sin * x[i]);
    y
}

/// R = 1 + 2 (e₀ [x]ₓ + [x]ₓ²)/|e|² with e = (e₀, x).
fn rotation<S: Scalar>([e0, x @ ..]: [S; 4]) -> [[S; 3]; 3] {
    let twice = (e0 * e0 + dot(x, x)).recip() * 2.0;
    let square = dot(x, x);
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            if i == j {
                return (x[i] * x[i] - square) * twice + 1.0;
            }
            let third = 3 - i - j;
            let skew = if (i + 1) % 3 == j { -x[third] } else { x[third] };
            (x[i] * x[j] + e0 * skew) * twice
        })
    })
}
