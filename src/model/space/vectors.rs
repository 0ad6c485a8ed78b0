//! Vectors and matrices of parameters, with constants folded, for frames that may depend on design variables.

use crate::model::Param;

pub(crate) type Vector = [Param; 3];
/// Rows of a matrix.
pub(crate) type Matrix = [[Param; 3]; 3];

/// Entries of rotations this close to 0, 1 and −1 are equal to them, so that formulas do not contain them.
const ROUNDING: f64 = 1e-14;

pub(crate) fn zero() -> Vector {
    [0.0.into(); 3]
}

pub(crate) fn identity() -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| f64::from(i == j).into()))
}

fn is(x: Param, value: f64) -> bool {
    x.constant() == Some(value)
}

pub(crate) fn times(a: Param, b: Param) -> Param {
    if is(a, 0.0) || is(b, 0.0) { 0.0.into() } else { a * b }
}

pub(crate) fn plus(a: Param, b: Param) -> Param {
    match (is(a, 0.0), is(b, 0.0)) {
        (true, _) => b,
        (_, true) => a,
        _ => a + b,
    }
}

pub(crate) fn sum(terms: impl IntoIterator<Item = Param>) -> Param {
    terms.into_iter().fold(0.0.into(), plus)
}

pub(crate) fn dot(a: Vector, b: Vector) -> Param {
    sum((0..3).map(|i| times(a[i], b[i])))
}

pub(crate) fn add(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| plus(a[i], b[i]))
}

pub(crate) fn scaled(a: Vector, factor: Param) -> Vector {
    a.map(|x| times(x, factor))
}

pub(crate) fn negated(a: Vector) -> Vector {
    a.map(|x| times(x, (-1.0).into()))
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        plus(times(a[j], b[k]), -times(a[k], b[j]))
    })
}

pub(crate) fn transposed(a: Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

/// A x.
pub(crate) fn apply(a: Matrix, x: Vector) -> Vector {
    a.map(|row| dot(row, x))
}

/// A B.
pub(crate) fn product(a: Matrix, b: Matrix) -> Matrix {
    let columns = transposed(b);
    a.map(|row| columns.map(|column| clean(dot(row, column))))
}

/// An entry of a rotation without rounding errors of 0, 1 and −1.
fn clean(x: Param) -> Param {
    let near = |value: f64| x.constant().is_some_and(|x| (x - value).abs() < ROUNDING);
    [0.0, 1.0, -1.0].into_iter().find(|value| near(*value)).map_or(x, Param::from)
}

/// The rotation with the columns x, y and z.
pub(crate) fn of_columns(x: Vector, y: Vector, z: Vector) -> Matrix {
    transposed([x, y, z]).map(|row| row.map(clean))
}

/// x/|x|.
pub(crate) fn unit(x: Vector) -> Vector {
    let length = dot(x, x).sqrt();
    x.map(|x| if is(x, 0.0) || is(length, 1.0) { x } else { x / length })
}
