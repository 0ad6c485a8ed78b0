//! [`Assembly`]: an assembled start as data, complete for the adjoint sweep.

use super::inputs::Held;
use crate::Coordinate;
use crate::system::{Given, NodeView, Pair};

/// An assembled start, with all values that its derivatives need.
pub(crate) struct Assembly {
    /// The guess.
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) held: Held,
    /// (w, ν) and (v₀, μ).
    pub(crate) moved: Pair,
    pub(crate) velocity: Pair,
}

/// Which of the two systems of equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Which {
    /// For w and ν.
    Coordinates,
    /// For v₀ and μ.
    Velocities,
}

impl Assembly {
    /// The points at which the equations for w or v₀ are linearised: (q₀, w, ν) and (q₀, 0, 0), or (q₀, v₀, μ) and (q₀, v̂, 0).
    pub(crate) fn points<'a>(
        &'a self,
        which: Which,
        (q, zeros): (&'a [f64], &'a Pair),
        given: Given<'a>,
    ) -> [NodeView<'a, f64>; 2] {
        let (moved, from) = match which {
            Which::Coordinates => (&self.moved, &zeros.v),
            Which::Velocities => (&self.velocity, &self.v),
        };
        [given.at(q, &moved.v, &moved.sigma), given.at(q, from, &zeros.sigma)]
    }

    /// Numbers of the held coordinates or velocities.
    pub(crate) fn held(&self, which: Which) -> Vec<usize> {
        match which {
            Which::Coordinates => indices(&self.held.coordinates),
            Which::Velocities => indices(&self.held.velocities),
        }
    }
}

/// The numbers of coordinates, each once.
pub(crate) fn indices(coordinates: &[Coordinate]) -> Vec<usize> {
    let all = coordinates.iter().enumerate();
    all.filter(|(k, q)| !coordinates[..*k].contains(q)).map(|(_, q)| q.index()).collect()
}
