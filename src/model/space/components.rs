//! [`Components`]: lists of parameters as arrays, or as tuples of numbers, design variables and expressions.

use crate::model::Param;

/// N parameters: an array such as `[0.0, 0.1, 0.2]`, or a tuple whose entries may differ in type, such as `(0.0, length, width * 0.5)`.
pub trait Components<const N: usize> {
    /// The parameters.
    fn params(self) -> [Param; N];
}

impl<T: Into<Param>, const N: usize> Components<N> for [T; N] {
    fn params(self) -> [Param; N] {
        self.map(Into::into)
    }
}

impl<A: Into<Param>, B: Into<Param>> Components<2> for (A, B) {
    fn params(self) -> [Param; 2] {
        [self.0.into(), self.1.into()]
    }
}

impl<A: Into<Param>, B: Into<Param>, C: Into<Param>> Components<3> for (A, B, C) {
    fn params(self) -> [Param; 3] {
        [self.0.into(), self.1.into(), self.2.into()]
    }
}
