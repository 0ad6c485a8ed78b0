//! Physical constants of elements: numbers, or values bound to a design variable.

use num_traits::Zero;

use super::Design;

/// A physical constant of an element: a number, or a design variable of the scene.
///
/// `0.8.into()` is a number; a [`Design`] handle converts into a bound parameter. Binding is what makes
/// dJ/db available; an unbound parameter costs nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Param(Kind);

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Constant(f64),
    Design(Design),
    /// A component of the scene's gravity, which may be set after the bodies.
    Gravity(usize),
}

impl From<f64> for Param {
    fn from(value: f64) -> Self {
        Param(Kind::Constant(value))
    }
}

impl From<Design> for Param {
    fn from(design: Design) -> Self {
        Param(Kind::Design(design))
    }
}

impl Param {
    pub(crate) fn gravity(axis: usize) -> Self {
        Param(Kind::Gravity(axis))
    }

    pub(crate) fn resolve(self, gravity: &[Param; 2]) -> Self {
        match self.0 {
            Kind::Gravity(axis) => gravity[axis],
            _ => self,
        }
    }

    /// The number, unless it is bound to a design variable.
    pub(crate) fn constant(&self) -> Option<f64> {
        match self.0 {
            Kind::Constant(value) => Some(value),
            _ => None,
        }
    }

    /// The index of the design variable, if it is bound to one.
    pub(crate) fn design(&self) -> Option<usize> {
        self.handle().map(|design| design.index())
    }

    pub(crate) fn handle(&self) -> Option<Design> {
        match self.0 {
            Kind::Design(design) => Some(design),
            _ => None,
        }
    }

    /// The value for given design variables.
    pub(crate) fn value<R: From<f64> + Copy + Zero>(&self, design: &[R]) -> R {
        match self.0 {
            Kind::Constant(value) => R::from(value),
            Kind::Design(handle) => design[handle.index()],
            Kind::Gravity(_) => R::zero(),
        }
    }
}
