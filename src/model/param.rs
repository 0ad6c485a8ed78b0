//! Physical constants of elements: numbers, or multiples of a design variable.

use num_traits::Zero;
use std::ops::{Mul, Neg};

use super::Design;
use crate::number::Arithmetic;

/// A physical constant of an element: a number, or a multiple of a design variable of the scene.
///
/// Numbers and [`Design`] handles convert into it; `length * 0.5` and `-length` bind half a length or its opposite. Binding is
/// what makes dJ/db available; an unbound parameter costs nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Param {
    of: Source,
    factor: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    One,
    Design(Design),
    /// A component of the scene's gravity, which may be set after the bodies.
    Gravity(usize),
}

impl From<f64> for Param {
    fn from(value: f64) -> Self {
        Param { of: Source::One, factor: value }
    }
}

impl From<Design> for Param {
    fn from(design: Design) -> Self {
        Param { of: Source::Design(design), factor: 1.0 }
    }
}

impl Mul<f64> for Param {
    type Output = Param;
    fn mul(self, factor: f64) -> Param {
        Param { factor: self.factor * factor, ..self }
    }
}

impl Neg for Param {
    type Output = Param;
    fn neg(self) -> Param {
        self * -1.0
    }
}

impl Mul<f64> for Design {
    type Output = Param;
    fn mul(self, factor: f64) -> Param {
        Param::from(self) * factor
    }
}

impl Neg for Design {
    type Output = Param;
    fn neg(self) -> Param {
        Param::from(self) * -1.0
    }
}

impl Param {
    pub(crate) fn gravity(axis: usize) -> Self {
        Param { of: Source::Gravity(axis), factor: 1.0 }
    }

    pub(crate) fn resolve(self, gravity: &[Param; 3]) -> Self {
        match self.of {
            Source::Gravity(axis) => gravity[axis] * self.factor,
            _ => self,
        }
    }

    /// The number, unless it is bound to a design variable.
    pub(crate) fn constant(&self) -> Option<f64> {
        match self.of {
            Source::One => Some(self.factor),
            _ => None,
        }
    }

    /// The index of the design variable and its factor, if it is bound to one.
    pub(crate) fn design(&self) -> Option<(usize, f64)> {
        self.handle().map(|design| (design.index(), self.factor))
    }

    pub(crate) fn handle(&self) -> Option<Design> {
        match self.of {
            Source::Design(design) => Some(design),
            _ => None,
        }
    }

    /// The value for given design variables.
    pub(crate) fn value<R: From<f64> + Copy + Zero + Arithmetic<f64>>(&self, design: &[R]) -> R {
        match self.of {
            Source::One => R::from(self.factor),
            Source::Design(handle) => design[handle.index()] * self.factor,
            Source::Gravity(_) => R::zero(),
        }
    }
}
