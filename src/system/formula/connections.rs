//! [`Connections`]: the arguments of a formula in the numbering of the scene.

use super::shape::{Argument, Shape, Slot};
use super::view::NodeView;
use crate::Scalar;
use crate::model::Param;

/// The coordinates, equations, controls and constants that a formula is connected to.
#[derive(Clone, Debug, Default)]
pub struct Connections {
    pub q: Vec<usize>,
    pub sigma: Vec<usize>,
    pub u: Vec<usize>,
    pub b: Vec<Param>,
}

impl Connections {
    /// The lengths of the lists.
    pub fn shape(&self) -> Shape {
        Shape { n: self.q.len(), m: self.sigma.len(), k: self.u.len(), p: self.b.len() }
    }

    /// The value of an argument at a node; zero if the node lacks the list, which then no formula depends on.
    #[inline]
    pub fn read<R: Scalar>(&self, at: &NodeView<R>, slot: Slot) -> R {
        match slot {
            Slot::T => at.t,
            Slot::B(p) => self.b[p].value(at.design),
            _ => at.list(slot.place().0).get(self.index(slot)).copied().unwrap_or(R::zero()),
        }
    }

    /// The number in the scene of an argument that is no constant.
    #[inline]
    fn index(&self, slot: Slot) -> usize {
        match slot {
            Slot::Q(i) | Slot::V(i) | Slot::PStar(i) | Slot::PStarDot(i) | Slot::VDot(i) => self.q[i],
            Slot::Lambda(j) | Slot::Sigma(j) => self.sigma[j],
            Slot::U(k) | Slot::UDot(k) => self.u[k],
            Slot::B(_) | Slot::T => 0,
        }
    }

    /// The derivative of an argument along a direction.
    pub fn rate(&self, along: &NodeView<f64>, slot: Slot) -> f64 {
        let of_design = |(place, factor): (usize, f64)| along.design.get(place).map_or(0.0, |rate| factor * rate);
        match slot {
            Slot::B(p) => self.b[p].bound().map_or(0.0, of_design),
            _ => self.read(along, slot),
        }
    }

    /// The scene's argument for an argument of the formula, and the factor between the two: zero for a plain number.
    pub fn argument(&self, slot: Slot) -> (Argument, f64) {
        match slot {
            Slot::B(p) => self.b[p].bound().map_or((Slot::T, 0.0), |(place, factor)| (Slot::B(place), factor)),
            _ => (Slot::ALL[slot.place().0](self.index(slot)), 1.0),
        }
    }

    /// Whether each constant is bound to a design variable.
    pub fn bound(&self) -> Vec<bool> {
        Param::which_are_bound(&self.b)
    }

    /// The values of the constants, followed by the numbers in the formula.
    pub fn parameters(&self, design: &[f64], numbers: &[f64]) -> Vec<f64> {
        self.b.iter().map(|b| b.value(design)).chain(numbers.iter().copied()).collect()
    }

    /// [`parameters`](Self::parameters), followed by the factor of each constant (its ratio to the parameter it is bound to).
    pub fn with_factors(&self, design: &[f64], numbers: &[f64]) -> Vec<f64> {
        let factors = self.b.iter().map(|b| b.bound().map_or(0.0, |(_, factor)| factor));
        self.parameters(design, numbers).into_iter().chain(factors).collect()
    }
}
